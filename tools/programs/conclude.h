/* How programs that have a verdict end. */
#ifndef TOOLS_PROGRAMS_CONCLUDE_H
#define TOOLS_PROGRAMS_CONCLUDE_H

#include "physics/scene/verdict.h"

typedef struct conclusion {
    const char *program;
    bool quiet;       /* so that a verdict is told on stderr if it is a warning, */
    bool anyhow;      /* or whatever it is */
    const char *json; /* a file, or NULL */
    ad_status (*write_json)(const void *of, ad_error *error);
    const void *of;
    verdict *verdict;
} conclusion;

/* After work that ended so: an error is told and becomes part of the verdict, the JSON is written.
 * The exit status. */
int conclude(const conclusion *c, ad_status status, ad_error *error);

#endif
