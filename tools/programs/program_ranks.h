/* The ranks of a program that mpirun or srun has started as several processes, by MPI. A program
 * that is started alone never touches MPI. */
#ifndef TOOLS_PROGRAMS_PROGRAM_RANKS_H
#define TOOLS_PROGRAMS_PROGRAM_RANKS_H

#include "autodiff/ranks.h"

#include <stdio.h>

/* At the very beginning of main, with its arguments [count]. *ranks: NULL for a process by itself.
 * All but rank 0 say nothing from here on: what they print goes nowhere, their errors to rank 0 by
 * ranks_end. AD_BAD_INPUT: there are several processes, but no MPI; ranks have other arguments,
 * files that these name, or another version. */
ad_status ranks_begin(int count, char **arguments, const ad_ranks **ranks, ad_error *error);

/* Whether ranks are about to do the same, before any of them begins; the lines of `text`, each with
 * its end, say what. `status`: of this rank so far; with an error, which is kept, text does not
 * count. The error of a rank that has one, on all ranks; AD_BAD_INPUT where some have other lines
 * than rank 0. Without ranks, NULL, `status`. */
ad_status ranks_compare(const ad_ranks *ranks, ad_status status, const char *text, ad_error *error);
ad_status ranks_compare_arguments(const ad_ranks *ranks, int count, char **arguments,
                                  ad_error *error);

/* Of such a line: a file's name, with a hash of what is in it. */
void ranks_name_file(FILE *to, const char *path);

/* Threads of this rank: `asked`, or where that is 0 its part of the processors that it may use. */
int ranks_threads(int asked);

/* Seconds in which this rank has waited for others and for their numbers. */
double ranks_waited(void);

/* At the very end. Returns the exit status of the program: that of rank 0, or of a rank that has
 * failed by itself, whose last words rank 0 repeats. When others do not come to an end as well, all
 * are ended. */
int ranks_end(const char *program, int exit_status);

#endif
