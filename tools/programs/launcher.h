/* Whether mpirun or srun has started this process together with others, as their environment says
 * it: known without MPI. */
#ifndef TOOLS_PROGRAMS_LAUNCHER_H
#define TOOLS_PROGRAMS_LAUNCHER_H

#include <stdbool.h>

/* How many processes have been started, 1 when this one is by itself; *rank is its number. */
int launcher_processes(int *rank);

/* This program shares its work among the processes; others are refused by cli_parse. */
void launcher_share(void);
bool launcher_is_shared(void);

/* The one line of a program that does not share its work is said by process 0 alone. Returns
 * CLI_BAD. */
int launcher_refuse(const char *program, const char *what);

#endif
