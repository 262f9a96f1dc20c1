/* Jobs of very different duration over ranks (tools/programs/program_ranks.h): whoever is free
 * takes the next one, and results come in the order of the jobs, as those of one process. */
#ifndef TOOLS_PROGRAMS_RANKS_QUEUE_H
#define TOOLS_PROGRAMS_RANKS_QUEUE_H

#include "autodiff/ranks.h"

/* What a job leaves: bytes without pointers, as another process may have made them. */
typedef struct ranks_result {
    void *bytes; /* of malloc; the queue frees it */
    size_t size;
    bool is_cut; /* there was a signal before the job was done; the queue sets it */
} ranks_result;

typedef struct ranks_jobs {
    size_t count; /* that of rank 0 counts */
    void *context;
    /* Does one job, on whichever rank: beside other ranks in a thread of its own, which may fork,
     * one job after another. */
    ad_status (*work)(void *context, size_t index, ranks_result *result, ad_error *error);
    /* Takes results over, on rank 0 and in the thread that has called ranks_queue. */
    ad_status (*take)(void *context, size_t index, const ranks_result *result, ad_error *error);
} ranks_jobs;

/* Does all jobs; ranks is NULL for a process by itself. The first error in the order of the jobs
 * ends it: results before it have been taken. After a signal to one of the ranks
 * (tools/judge/signals.h), which *signal receives, else 0, no job begins, those at work end by
 * themselves, and what there is is taken. Every rank calls it, once in a program; one that comes to
 * its end without a call is not waited for. */
ad_status ranks_queue(const ad_ranks *ranks, const ranks_jobs *jobs, int *signal, ad_error *error);

/* In place of ranks_queue where rank 0 has found that there is nothing to do: the others hear it.
 */
void ranks_queue_none(const ad_ranks *ranks);

/* The exit status after that signal. Among ranks one line says how far it came: mpirun ends all of
 * them by SIGTERM when one of them dies. */
int ranks_queue_stopped(const char *program, const ad_ranks *ranks, int signal, size_t done,
                        size_t count);

/* A copy of so many bytes as a result. AD_NO_MEMORY. */
ad_status ranks_result_copy(ranks_result *result, size_t size, const void *bytes, ad_error *error);

#endif
