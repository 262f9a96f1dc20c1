/* cpinn-solve --members: equilibria of many members of a family at once, without a network. */
#ifndef TOOLS_PROGRAMS_SOLVE_FAMILY_H
#define TOOLS_PROGRAMS_SOLVE_FAMILY_H

#include "tools/programs/cli.h"
#include "tools/programs/samples.h"

typedef struct solve_family_options {
    const char *config, *members, *out, *json; /* members: a table with a column per parameter */
    const cli_list *overrides;
    samples_asked where;
    double tolerance; /* of the position over the length; 0: CPINN_TOLERANCE */
    int threads;
    bool derivatives, quiet;
} solve_family_options;

/* Solves, writes and prints. The exit status: 3 where a member is not trusted. */
int solve_family_run(const char *program, const solve_family_options *asked);

#endif
