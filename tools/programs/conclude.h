/* How programs that have a verdict end. */
#ifndef TOOLS_PROGRAMS_CONCLUDE_H
#define TOOLS_PROGRAMS_CONCLUDE_H

#include "physics/scene/verdict.h"
#include "tools/files/json.h"

typedef struct conclusion {
    const char *program;
    bool quiet;       /* so that a verdict is told on stderr if it is a warning, */
    bool anyhow;      /* or whatever it is */
    const char *json; /* a file, or NULL; begins with program, version, */
    const char *name; /* of the scene, NULL: not known, and the verdict, */
    void (*tell)(const void *of, json *to); /* and goes on with what the program has to tell */
    const void *of;
    verdict *verdict;
} conclusion;

/* After work that ended so: an error is told and becomes part of the verdict, the JSON is written.
 * The exit status. */
int conclude(const conclusion *c, ad_status status, ad_error *error);

#endif
