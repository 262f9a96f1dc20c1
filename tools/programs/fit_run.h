/* Fits by least squares in programs: a line of progress on stderr, or a picture; and a folder in
 * which the run is kept, so that one that was stopped or killed goes on to the same bits. */
#ifndef TOOLS_PROGRAMS_FIT_RUN_H
#define TOOLS_PROGRAMS_FIT_RUN_H

#include "tools/config/config.h"
#include "tools/programs/cli.h"
#include "tools/train/least_squares.h"

typedef struct fit_run {
    const char *program, *folder; /* --run; NULL: it is kept nowhere */
    bool resume, quiet;           /* options of these names; help/shared.txt explains them */
    char *text; /* all that is asked for, and what a resumed run has to ask for again; owned */
    int signal; /* that has stopped it, or 0 */
} fit_run;

/* What is asked for: a line of one's own, and a scene (NULL: none). */
ad_status fit_run_ask(fit_run *o, const config *settings, ad_error *error, const char *format, ...)
    __attribute__((format(printf, 4, 5)));

/* Borrows `o`. */
least_squares_runner fit_run_by(fit_run *o);

/* The exit status of a run that was stopped; 0: it was not. */
int fit_run_end(fit_run *o);

#endif
