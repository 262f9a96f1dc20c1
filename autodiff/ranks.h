/* Ranks: processes that compute together what one could compute alone, to the same bits.
 *
 * All of them run the same program on the same numbers. Where a program of the tape goes over
 * points (ad_execute, ad_normal_add) each rank takes the points of some of the chunks. Values of
 * points and sums over them then become everyone's, in the order in which one process adds them up.
 * Items of other work are dealt in turn (ad_pool_deal). So the ranks make the same
 * decisions without asking each other, as long as these follow from the numbers; what comes from
 * elsewhere (a clock, a signal, a file) has to be agreed on.
 *
 * How numbers get from one rank to another is the caller's: MPI in the programs
 * (tools/programs/program_ranks.h). Every rank calls the same functions in the same order. */
#ifndef AD_RANKS_H
#define AD_RANKS_H

#include "autodiff/ad.h"

#include <stdint.h>

#ifdef __cplusplus
extern "C" {
#endif

enum { AD_RANKS_MAX = 4096 };

typedef struct ad_ranks {
    int rank, count;
    void *context;
    /* data[bounds[i]] to data[bounds[i + 1] - 1] are those of rank i, and become everyone's. */
    void (*gather)(void *context, const size_t *bounds, double *data);
    /* send[to[i]] to send[to[i + 1] - 1] go to rank i, and receive[from[i]] to
     * receive[from[i + 1] - 1] come from it. */
    void (*exchange)(void *context, const size_t *to, const double *send, const size_t *from,
                     double *receive);
} ad_ranks;

/* Programs of this pool share their points among these ranks from now on; ranks, borrowed, has to
 * outlive the pool; NULL, or a count of 1: every process is by itself. AD_NO_MEMORY;
 * AD_BAD_ARGUMENT: too many, or on processors of different kinds. Programs with
 * values of members are not shared: each rank runs all of them. */
ad_status ad_pool_share(ad_pool *pool, const ad_ranks *ranks, ad_error *error);
const ad_ranks *ad_pool_ranks(const ad_pool *pool); /* NULL: there are no others */

/* ---- items of work --------------------------------------------------------------------------- */

/* What items make: item i has data[i * size] to data[(i + 1) * size - 1], of `all` bytes; the last
 * may have fewer. */
typedef struct ad_dealt {
    void *data;
    size_t size, all;
} ad_dealt;

typedef ad_status (*ad_pool_item)(void *context, int item, int thread, ad_error *error);

/* Items 0 .. count-1, which do not need each other, each rank every so many, by
 * whatever thread is free next; then made [made_count] is everyone's. Where items fail, the error
 * of the first of them, on all ranks; what is made is not defined then. When one is asked to stop
 * (ad_pool_watch), all are stopped. A single item is done by every rank. Does not allocate, or
 * among ranks not twice for the same sizes; AD_NO_MEMORY. */
ad_status ad_pool_deal(ad_pool *pool, int count, ad_pool_item work, void *context, int made_count,
                       const ad_dealt *made, ad_error *error);

/* Whether this is the only process, or rank 0, which prints and writes for all. */
static inline bool ad_ranks_is_first(const ad_ranks *ranks)
{
    return !ranks || ranks->rank == 0;
}

/* ---- agreement ------------------------------------------------------------------------------- */

/* Of all ranks the largest x; the numbers [count] of rank 0; whether x is the same everywhere.
 * Without ranks, NULL, nothing is changed and everything is the same. */
double ad_ranks_largest(const ad_ranks *ranks, double x);
void ad_ranks_first(const ad_ranks *ranks, size_t count, double *numbers);
bool ad_ranks_agree(const ad_ranks *ranks, uint64_t x);

/* What has become of something that rank 0 does alone, files mostly, is the same for all: its
 * status. A rank that has an error where rank 0 has none keeps it. */
ad_status ad_ranks_status(const ad_ranks *ranks, ad_status status, ad_error *error);

/* ---- what is shared -------------------------------------------------------------------------- */

/* What a rank takes of so many points. */
typedef struct ad_share {
    size_t first;  /* the first point that it takes */
    size_t points; /* how many; 0: there is nothing for it */
    size_t bytes;  /* that it keeps for sums of its own */
} ad_share;

ad_share ad_program_share(const ad_program *program, size_t points, int ranks, int rank);
ad_share ad_normal_share(const ad_normal *normal, size_t points, int ranks, int rank);

#ifdef __cplusplus
}
#endif

#endif
