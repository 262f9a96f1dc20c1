/* Items of work for the threads of all ranks: every so many are those of a rank. What the items
 * have made is sent once, when all are done. */
#include "autodiff/run/rank_exchange.h"

#include <pthread.h>
#include <stdlib.h>
#include <string.h>

enum { ERROR_NUMBERS = (sizeof(ad_error) + sizeof(double) - 1) / sizeof(double) };

/* What a rank says when it has nothing left to do. */
enum { SAID_FAILED, SAID_STOPPED };

static const int WITHOUT_MEMORY = -1; /* as the item that has failed */

typedef struct deal {
    ad_pool *pool;
    ad_pool_item work;
    void *context;
    int count, made_count;
    const ad_dealt *made;
    share *share;
    int rank, ranks; /* items rank, rank + ranks, ... are those of this rank */
    pthread_mutex_t mutex;
    int failed; /* the first of its items that has; count: none */
    ad_error error;
} deal;

/* Threads have taken the items before it already, so that the first one is the same every time. */
static void fail(deal *d, int item, const ad_error *error)
{
    pthread_mutex_lock(&d->mutex);
    if (item < d->failed) {
        d->failed = item;
        d->error = *error;
    }
    pthread_mutex_unlock(&d->mutex);
}

static void do_item(deal *d, int item, int thread)
{
    ad_error error = {.message = ""};
    error.status = d->work(d->context, item, thread, &error);
    if (error.status != AD_OK) {
        fail(d, item, &error);
    }
}

static void do_next(void *context, int k, int thread)
{
    deal *d = context;
    const int item = d->rank + k * d->ranks;
    pthread_mutex_lock(&d->mutex);
    const bool is_wanted = item < d->failed;
    pthread_mutex_unlock(&d->mutex);
    if (is_wanted) {
        do_item(d, item, thread);
    }
}

static int items_of(const deal *d, int rank)
{
    return (d->count - rank + d->ranks - 1) / d->ranks;
}

/* ---- what has been made ---------------------------------------------------------------------- */

/* Numbers that are sent of an item. */
static size_t numbers_of(const deal *d)
{
    size_t bytes = 0;
    for (int i = 0; i < d->made_count; i++) {
        bytes += d->made[i].size;
    }
    return (bytes + sizeof(double) - 1) / sizeof(double);
}

/* What an item has made, into a place of numbers_of, or from there. */
static void copy_item(const deal *d, int item, double *place, bool into)
{
    char *at = (char *)place;
    for (int i = 0; i < d->made_count; i++) {
        const ad_dealt *made = &d->made[i];
        const size_t first = (size_t)item * made->size, left = made->all - first;
        const size_t bytes = left < made->size ? left : made->size;
        char *own = (char *)made->data + first;
        memcpy(into ? at : own, into ? own : at, bytes);
        at += bytes;
    }
}

static void hand_out(deal *d)
{
    share *s = d->share;
    const size_t numbers = numbers_of(d);
    s->bounds[0] = 0;
    for (int i = 0; i < d->ranks; i++) { /* one number at least, for which all wait */
        s->bounds[i + 1] = s->bounds[i] + 1 + (size_t)items_of(d, i) * numbers;
    }
    for (int own = 1; own >= 0; own--) {
        for (int item = 0; item < d->count; item++) {
            const int rank = item % d->ranks, k = item / d->ranks;
            if ((rank == d->rank) == own) {
                copy_item(d, item, s->room + s->bounds[rank] + 1 + (size_t)k * numbers, own);
            }
        }
        if (own) {
            s->room[s->bounds[d->rank]] = 0;
            s->ranks->gather(s->ranks->context, s->bounds, s->room);
        }
    }
}

/* The error of that rank, or of none. */
static void hand_out_error(deal *d, int of)
{
    share *s = d->share;
    s->bounds[0] = 0;
    for (int i = 0; i < d->ranks; i++) {
        s->bounds[i + 1] = s->bounds[i] + 1 + (i == of ? ERROR_NUMBERS : 0);
    }
    double *said = of < 0 ? s->said[0] : s->room; /* that there is in any case */
    if (of == s->ranks->rank) {
        memcpy(said + s->bounds[of] + 1, &d->error, sizeof d->error);
    }
    said[s->bounds[s->ranks->rank]] = 0;
    s->ranks->gather(s->ranks->context, s->bounds, said);
    if (of >= 0) {
        memcpy(&d->error, said + s->bounds[of] + 1, sizeof d->error);
    }
}

/* Everyone says how it has ended; returns the rank of the first item that has failed, or -1, and
 * leaves that item in d->failed. */
static int meet(deal *d, bool *stopped)
{
    share *s = d->share;
    const ad_ranks *ranks = s->ranks;
    const double own[RANK_EXCHANGE_SAID] = {
        [SAID_FAILED] = d->failed, [SAID_STOPPED] = ad_pool_stopped(d->pool)};
    int failed = -1;
    for (int i = 0; i <= ranks->count; i++) {
        s->bounds[i] = RANK_EXCHANGE_SAID * (size_t)i;
    }
    memcpy(s->said[ranks->rank], own, sizeof own);
    ranks->gather(ranks->context, s->bounds, s->said[0]);
    *stopped = false;
    d->failed = d->count;
    for (int i = 0; i < ranks->count; i++) {
        *stopped = *stopped || s->said[i][SAID_STOPPED] != 0;
        if (s->said[i][SAID_FAILED] < d->failed) {
            d->failed = (int)s->said[i][SAID_FAILED];
            failed = i;
        }
    }
    return failed;
}

static ad_status deal_to_ranks(deal *d, ad_error *error)
{
    bool stopped;
    const size_t room = (size_t)d->count * numbers_of(d) + ERROR_NUMBERS + (size_t)d->ranks;
    if (ad_share_make_room(d->share, room)) {
        ad_pool_run(d->pool, items_of(d, d->rank), do_next, d);
    } else {
        d->failed = WITHOUT_MEMORY;
    }
    const int failed = meet(d, &stopped);
    if (d->failed == WITHOUT_MEMORY) {
        hand_out_error(d, -1);
        return ad_fail(error, AD_NO_MEMORY, "out of memory for %d items of several processes",
                       d->count);
    }
    if (stopped) {
        hand_out_error(d, -1);
        ad_pool_stop(d->pool);
        return AD_OK;
    }
    if (failed >= 0) {
        hand_out_error(d, failed);
        return ad_fail(error, d->error.status, "%s", d->error.message);
    }
    hand_out(d);
    return AD_OK;
}

ad_status ad_pool_deal(ad_pool *pool, int count, ad_pool_item work, void *context, int made_count,
                       const ad_dealt *made, ad_error *error)
{
    deal d = {.pool = pool,
              .work = work,
              .context = context,
              .count = count,
              .made_count = made_count,
              .made = made,
              .share = ad_pool_get_share(pool),
              .ranks = 1,
              .failed = count};
    ad_status status = AD_OK;
    if (count < 1) {
        return AD_OK;
    }
    pthread_mutex_init(&d.mutex, NULL);
    if (d.share->ranks && count > 1) { /* one is done sooner than sent */
        d.rank = d.share->ranks->rank;
        d.ranks = d.share->ranks->count;
        status = deal_to_ranks(&d, error);
    } else {
        ad_pool_run(pool, count, do_next, &d);
        if (d.failed < count) {
            status = ad_fail(error, d.error.status, "%s", d.error.message);
        }
    }
    pthread_mutex_destroy(&d.mutex);
    return status;
}
