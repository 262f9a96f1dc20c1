/* Sums, values and items of several ranks (rank_exchange.c, rank_items.c). Private to autodiff. */
#ifndef AD_RANK_EXCHANGE_H
#define AD_RANK_EXCHANGE_H

#include "autodiff/ranks.h"

enum { RANK_EXCHANGE_SAID = 2 };

/* Of a pool: its ranks, and memory for what they exchange. */
typedef struct share {
    const ad_ranks *ranks;              /* of more than one, else NULL */
    size_t *bounds;                     /* [2][ranks + 1] */
    double (*said)[RANK_EXCHANGE_SAID]; /* [ranks] of one who has done its items */
    double *room;
    size_t capacity; /* numbers */
} share;

share *ad_pool_get_share(ad_pool *pool);

/* Of ad_pool_watch: other ranks have left items out. */
void ad_pool_stop(ad_pool *pool);

/* The first of `items` that rank `rank` takes; the next rank's is where its own end. */
static inline size_t share_first(size_t items, int ranks, int rank)
{
    return items * (size_t)rank / (size_t)ranks;
}

/* Puts together pieces [pieces][width], of all ranks in their order, into to [width]. */
typedef void (*share_combine)(void *context, size_t width, double *pieces, double *to);

/* Of each rank pieces[rank] pieces of `count` numbers each; own: those of this rank. Every rank
 * puts together some of the numbers, then total [count] is everyone's. ad_share_room is how many
 * numbers of memory that needs. */
void ad_share_sum(share *s, const int *pieces, const double *const *own, size_t count,
                  share_combine combine, void *context, double *total);
size_t ad_share_room(int ranks, const int *pieces, int rank, size_t count);
bool ad_share_make_room(share *s, size_t numbers);

#endif
