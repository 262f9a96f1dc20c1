/* Sums over ranks. Every rank owns some of the numbers: it gets the pieces of these from all
 * others, puts them together in the order of one process, and hands the sums out. So each rank
 * sends its pieces once and the sums of its own numbers, however many ranks there are. */
#include "autodiff/run/rank_exchange.h"

#include <stdlib.h>
#include <string.h>

bool ad_share_make_room(share *s, size_t numbers)
{
    if (numbers > s->capacity) {
        double *larger = realloc(s->room, numbers * sizeof *larger);
        if (!larger) {
            return false;
        }
        s->room = larger;
        s->capacity = numbers;
    }
    return true;
}

static size_t pieces_of_all(int ranks, const int *pieces)
{
    size_t all = 0;
    for (int i = 0; i < ranks; i++) {
        all += (size_t)pieces[i];
    }
    return all;
}

/* Several pieces are sent from a copy in which those for a rank follow each other. */
static size_t copied(size_t pieces, size_t count)
{
    return pieces > 1 ? pieces * count : 0;
}

size_t ad_share_room(int ranks, const int *pieces, int rank, size_t count)
{
    const size_t width = count / (size_t)ranks + 1;
    return copied((size_t)pieces[rank], count) + 1 + pieces_of_all(ranks, pieces) * width;
}

void ad_share_sum(share *s, const int *pieces, const double *const *own, size_t count,
                  share_combine combine, void *context, double *total)
{
    const ad_ranks *r = s->ranks;
    const int ranks = r->count;
    const size_t mine = (size_t)pieces[r->rank], first = share_first(count, ranks, r->rank),
                 width = share_first(count, ranks, r->rank + 1) - first;
    size_t *to = s->bounds, *from = s->bounds + ranks + 1;
    double *send = s->room,
           *receive = send + copied(mine, count) + 1; /* apart, also where nothing is sent */
    to[0] = from[0] = 0;
    for (int i = 0; i < ranks; i++) {
        const size_t start = share_first(count, ranks, i),
                     numbers = share_first(count, ranks, i + 1) - start;
        for (size_t k = 0; k < mine && mine > 1; k++) {
            memcpy(send + to[i] + k * numbers, own[k] + start, numbers * sizeof *send);
        }
        to[i + 1] = to[i] + mine * numbers;
        from[i + 1] = from[i] + (size_t)pieces[i] * width;
    }
    r->exchange(r->context, to, mine == 1 ? own[0] : send, from, receive);
    combine(context, width, receive, total + first);
    for (int i = 0; i <= ranks; i++) {
        to[i] = share_first(count, ranks, i);
    }
    r->gather(r->context, to, total);
}

/* One number of each rank. */
static void list_ranks(size_t *bounds, int ranks)
{
    for (int i = 0; i <= ranks; i++) {
        bounds[i] = (size_t)i;
    }
}

double ad_ranks_largest(const ad_ranks *ranks, double x)
{
    double all[AD_RANKS_MAX];
    size_t bounds[AD_RANKS_MAX + 1];
    if (!ranks) {
        return x;
    }
    list_ranks(bounds, ranks->count);
    all[ranks->rank] = x;
    ranks->gather(ranks->context, bounds, all);
    for (int i = 0; i < ranks->count; i++) {
        x = all[i] > x ? all[i] : x;
    }
    return x;
}

void ad_ranks_first(const ad_ranks *ranks, size_t count, double *numbers)
{
    size_t bounds[AD_RANKS_MAX + 1];
    if (ranks) {
        for (int i = 0; i <= ranks->count; i++) {
            bounds[i] = i > 0 ? count : 0;
        }
        ranks->gather(ranks->context, bounds, numbers);
    }
}

ad_status ad_ranks_status(const ad_ranks *ranks, ad_status status, ad_error *error)
{
    double first = (double)status;
    ad_ranks_first(ranks, 1, &first);
    return first == AD_OK || (ad_status)first == status
               ? status
               : ad_fail(error, (ad_status)first, "rank 0 has failed");
}

bool ad_ranks_agree(const ad_ranks *ranks, uint64_t x)
{
    const double half = 4294967296.0;
    double first[2] = {(double)(x >> 32), (double)(x & 0xffffffff)};
    ad_ranks_first(ranks, 2, first);
    const uint64_t of_first = (uint64_t)first[0] * (uint64_t)half + (uint64_t)first[1];
    return ad_ranks_largest(ranks, of_first != x) == 0;
}
