/* Items of work for the threads of all ranks. A rank takes neighbouring items, half of all that are
 * left among the ranks, so that it asks seldom, and its threads take them one by one. What the
 * items have made is sent once, when all are done. */
#include "autodiff/run/rank_exchange.h"

#include <pthread.h>
#include <stdlib.h>
#include <string.h>

enum { ERROR_NUMBERS = (sizeof(ad_error) + sizeof(double) - 1) / sizeof(double) };

/* What a rank says when it has nothing left to do. */
enum { SAID_DONE, SAID_ADDED, SAID_FAILED, SAID_STOPPED };

static const int WITHOUT_MEMORY = -1; /* as the item that has failed */

typedef struct deal {
    ad_pool *pool;
    ad_pool_item work;
    void *context;
    int count, made_count;
    const ad_dealt *made;
    share *share;
    pthread_mutex_t mutex;
    int next, end; /* of the items that this rank has taken last */
    bool is_over;  /* it takes no more */
    int done;      /* how many it has begun: share->items */
    int64_t added; /* to the number of all ranks */
    int failed;    /* the first of its items that has; count: none */
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

/* ---- a process by itself --------------------------------------------------------------------- */

static void do_next(void *context, int item, int thread)
{
    deal *d = context;
    pthread_mutex_lock(&d->mutex);
    const bool is_wanted = item < d->failed;
    pthread_mutex_unlock(&d->mutex);
    if (is_wanted) {
        do_item(d, item, thread);
    }
}

/* ---- ranks: taking items --------------------------------------------------------------------- */

/* The items of take k = 0, 1, ... of all: as many takes as there are ranks share half of what is
 * left before them. False: nothing is left. */
static bool find_take(int count, int ranks, int64_t k, int *first, int *end)
{
    for (int64_t at = 0; at < count; k -= ranks) {
        const int64_t left = (count - at) / ((int64_t)2 * ranks), size = left > 0 ? left : 1;
        if (k < ranks && at + k * size < count) {
            *first = (int)(at + k * size);
            *end = *first + (int)size < count ? *first + (int)size : count;
            return true;
        }
        at += ranks * size;
    }
    return false;
}

static int64_t add(deal *d, int64_t step)
{
    const ad_ranks *ranks = d->share->ranks;
    d->added += step;
    return ranks->add(ranks->context, step);
}

static bool take(deal *d, int *item)
{
    pthread_mutex_lock(&d->mutex);
    if (!d->is_over && (d->failed < d->count || ad_pool_gives_up(d->pool))) {
        add(d, d->count); /* nobody takes any more */
        d->is_over = true;
    }
    if (!d->is_over && d->next == d->end) {
        d->is_over = !find_take(d->count, d->share->ranks->count, add(d, 1), &d->next, &d->end);
    } else if (!d->is_over && d->share->ranks->rank == 0) {
        add(d, 0); /* where others reach the number of this rank only while it looks */
    }
    const bool taken = !d->is_over;
    if (taken) {
        *item = d->next++;
        d->share->items[d->done++] = *item;
    }
    pthread_mutex_unlock(&d->mutex);
    return taken;
}

static void take_all(void *context, int item, int thread)
{
    deal *d = context;
    (void)item; /* one for each thread */
    while (take(d, &item)) {
        do_item(d, item, thread);
    }
}

/* ---- ranks: what has been made --------------------------------------------------------------- */

/* Numbers that are sent of an item: which it is, and what it has made. */
static size_t numbers_of(const deal *d)
{
    size_t bytes = 0;
    for (int i = 0; i < d->made_count; i++) {
        bytes += d->made[i].size;
    }
    return 1 + (bytes + sizeof(double) - 1) / sizeof(double);
}

/* What an item has made, into a place of numbers_of, or from there. */
static void copy_item(const deal *d, int item, double *place, bool into)
{
    char *at = (char *)(place + 1);
    for (int i = 0; i < d->made_count; i++) {
        const ad_dealt *made = &d->made[i];
        const size_t first = (size_t)item * made->size, left = made->all - first;
        const size_t bytes = left < made->size ? left : made->size;
        char *own = (char *)made->data + first;
        memcpy(into ? at : own, into ? own : at, bytes);
        at += bytes;
    }
}

static bool make_room(deal *d)
{
    share *s = d->share;
    const size_t count = (size_t)d->count, numbers = count * numbers_of(d) + ERROR_NUMBERS;
    if (count > s->item_capacity) {
        int *larger = realloc(s->items, count * sizeof *larger);
        if (!larger) {
            return false;
        }
        s->items = larger;
        s->item_capacity = count;
    }
    return ad_share_make_room(s, numbers + (size_t)s->ranks->count);
}

static void hand_out(deal *d)
{
    share *s = d->share;
    const int ranks = s->ranks->count, rank = s->ranks->rank;
    const size_t numbers = numbers_of(d);
    s->bounds[0] = 0;
    for (int i = 0; i < ranks; i++) { /* one number at least, for which all wait */
        s->bounds[i + 1] = s->bounds[i] + 1 + (size_t)s->said[i][SAID_DONE] * numbers;
    }
    double *own = s->room + s->bounds[rank];
    *own++ = 0;
    for (int k = 0; k < d->done; k++, own += numbers) {
        *own = s->items[k];
        copy_item(d, s->items[k], own, true);
    }
    s->ranks->gather(s->ranks->context, s->bounds, s->room);
    for (int i = 0; i < ranks; i++) {
        const double *end = s->room + s->bounds[i + 1];
        for (double *at = s->room + s->bounds[i] + 1; i != rank && at < end; at += numbers) {
            copy_item(d, (int)*at, at, false);
        }
    }
}

/* The error of that rank, or of none. */
static void hand_out_error(deal *d, int of)
{
    share *s = d->share;
    const int ranks = s->ranks->count;
    s->bounds[0] = 0;
    for (int i = 0; i < ranks; i++) {
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
    const double own[RANK_EXCHANGE_SAID] = {[SAID_DONE] = d->done,
                                            [SAID_ADDED] = (double)d->added,
                                            [SAID_FAILED] = d->failed,
                                            [SAID_STOPPED] = ad_pool_stopped(d->pool)};
    int64_t added = 0;
    int failed = -1;
    for (int i = 0; i <= ranks->count; i++) {
        s->bounds[i] = RANK_EXCHANGE_SAID * (size_t)i;
    }
    memcpy(s->said[ranks->rank], own, sizeof own);
    ranks->gather(ranks->context, s->bounds, s->said[0]);
    *stopped = false;
    d->failed = d->count;
    for (int i = 0; i < ranks->count; i++) {
        added += (int64_t)s->said[i][SAID_ADDED];
        *stopped = *stopped || s->said[i][SAID_STOPPED] != 0;
        if (s->said[i][SAID_FAILED] < d->failed) {
            d->failed = (int)s->said[i][SAID_FAILED];
            failed = i;
        }
    }
    if (ranks->rank == 0) { /* nobody adds before the next gathering is over */
        ranks->add(ranks->context, -added);
    }
    return failed;
}

static ad_status deal_to_ranks(deal *d, ad_error *error)
{
    bool stopped;
    if (make_room(d)) {
        ad_pool_run(d->pool, ad_pool_threads(d->pool), take_all, d);
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
              .failed = count};
    ad_status status = AD_OK;
    if (count < 1) {
        return AD_OK;
    }
    pthread_mutex_init(&d.mutex, NULL);
    if (d.share->ranks && count > 1) { /* one is done sooner than sent */
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
