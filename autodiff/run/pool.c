/* Threads that wait for numbered items of work. Which thread takes which item is left to chance;
 * results must not depend on it. A worker spins for a moment before it sleeps, because the next
 * training step usually follows at once. */
#include "autodiff/compile/program.h"
#include "autodiff/dense.h"
#include "autodiff/run/blas.h"
#include "autodiff/run/rank_exchange.h"

#include <pthread.h>
#include <stdatomic.h>
#include <stdio.h>
#include <stdlib.h>
#include <unistd.h>

enum { SPINS = 2000 };

struct ad_pool {
    int threads; /* including the caller */
    int started;
    pthread_t *handles;
    struct worker *workers;
    pthread_mutex_t mutex;
    pthread_cond_t wake, done;
    atomic_uint round; /* grows by one for every job */
    atomic_int next;   /* item */
    atomic_int busy;   /* workers not yet finished with this round */
    int count;
    ad_pool_work work;
    void *context;
    bool (*asked)(void *context);
    void *asked_context;
    atomic_bool stopped; /* items have been left out since `asked` was set */
    bool quit;
    share share;
};

struct worker {
    ad_pool *pool;
    int thread;
};

void ad_pool_stop(ad_pool *pool)
{
    atomic_store(&pool->stopped, true);
}

/* Of ad_pool_watch: whether an item is to be left out. */
static bool gives_up(ad_pool *pool)
{
    const bool result =
        pool->asked && (atomic_load(&pool->stopped) || pool->asked(pool->asked_context));
    if (result) {
        ad_pool_stop(pool);
    }
    return result;
}

static void take_items(ad_pool *pool, int thread)
{
    for (int item; (item = atomic_fetch_add(&pool->next, 1)) < pool->count;) {
        if (!gives_up(pool)) {
            pool->work(pool->context, item, thread);
        }
    }
}

void ad_pool_watch(ad_pool *pool, bool (*asked)(void *context), void *context)
{
    pool->asked = asked;
    pool->asked_context = context;
    atomic_store(&pool->stopped, false);
}

bool ad_pool_stopped(const ad_pool *pool)
{
    return atomic_load(&pool->stopped);
}

static void pause_briefly(void)
{
#if defined(__x86_64__)
    __builtin_ia32_pause();
#endif
}

static void *worker_main(void *argument)
{
    struct worker *self = argument;
    ad_pool *pool = self->pool;
    unsigned seen = 0;
    for (;;) {
        for (int i = 0; i < SPINS && atomic_load(&pool->round) == seen; i++) {
            pause_briefly();
        }
        pthread_mutex_lock(&pool->mutex);
        while (atomic_load(&pool->round) == seen) {
            pthread_cond_wait(&pool->wake, &pool->mutex);
        }
        seen = atomic_load(&pool->round);
        bool quit = pool->quit;
        pthread_mutex_unlock(&pool->mutex);
        if (quit) {
            return NULL;
        }
        take_items(pool, self->thread);
        if (atomic_fetch_sub(&pool->busy, 1) == 1) {
            pthread_mutex_lock(&pool->mutex);
            pthread_cond_signal(&pool->done);
            pthread_mutex_unlock(&pool->mutex);
        }
    }
}

static void start_round(ad_pool *pool)
{
    pthread_mutex_lock(&pool->mutex);
    atomic_fetch_add(&pool->round, 1);
    pthread_cond_broadcast(&pool->wake);
    pthread_mutex_unlock(&pool->mutex);
}

void ad_pool_run(ad_pool *pool, int count, ad_pool_work work, void *context)
{
    pool->work = work;
    pool->context = context;
    pool->count = count;
    atomic_store(&pool->next, 0);
    if (pool->started == 0 || count == 1) {
        take_items(pool, 0);
        return;
    }
    atomic_store(&pool->busy, pool->started);
    start_round(pool);
    take_items(pool, 0);
    for (int i = 0; i < SPINS && atomic_load(&pool->busy) > 0; i++) {
        pause_briefly();
    }
    pthread_mutex_lock(&pool->mutex);
    while (atomic_load(&pool->busy) > 0) {
        pthread_cond_wait(&pool->done, &pool->mutex);
    }
    pthread_mutex_unlock(&pool->mutex);
}

ad_pool *ad_pool_create(int threads)
{
    if (threads < 1 || threads > AD_THREADS_MAX || !ad_blas_fits(threads)) {
        return NULL;
    }
    ad_pool *pool = calloc(1, sizeof *pool);
    if (!pool) {
        return NULL;
    }
    pool->threads = threads;
    pthread_mutex_init(&pool->mutex, NULL);
    pthread_cond_init(&pool->wake, NULL);
    pthread_cond_init(&pool->done, NULL);
    pool->handles = calloc((size_t)threads, sizeof *pool->handles);
    pool->workers = calloc((size_t)threads, sizeof *pool->workers);
    if (!pool->handles || !pool->workers) {
        ad_pool_free(pool);
        return NULL;
    }
    for (int i = 0; i < threads - 1; i++) {
        pool->workers[i] = (struct worker){pool, i + 1};
        if (pthread_create(&pool->handles[i], NULL, worker_main, &pool->workers[i]) != 0) {
            ad_pool_free(pool);
            return NULL;
        }
        pool->started++;
    }
    return pool;
}

ad_status ad_pool_open(int threads, ad_pool **pool, ad_error *error)
{
    *pool = NULL;
    if (threads < 0 || threads > AD_THREADS_MAX) {
        return ad_fail(error, AD_BAD_ARGUMENT,
                       "threads: is %d; allowed: 1 to %d, or 0, one per processor", threads,
                       AD_THREADS_MAX);
    }
    const long processors = sysconf(_SC_NPROCESSORS_ONLN);
    const int most = processors < AD_THREADS_MAX ? (int)processors : AD_THREADS_MAX;
    const int count = threads > 0 ? threads : most > 1 ? most : 1;
    *pool = ad_pool_create(count);
    return *pool ? AD_OK
                 : ad_fail(error, AD_NO_MEMORY,
                           "out of memory: %d thread%s, with 128 MiB of address space each, could "
                           "not be started; try fewer",
                           count, count == 1 ? "" : "s");
}

void ad_pool_free(ad_pool *pool)
{
    if (!pool) {
        return;
    }
    pool->quit = true;
    if (pool->started > 0) {
        start_round(pool);
    }
    for (int i = 0; i < pool->started; i++) {
        pthread_join(pool->handles[i], NULL);
    }
    pthread_mutex_destroy(&pool->mutex);
    pthread_cond_destroy(&pool->wake);
    pthread_cond_destroy(&pool->done);
    free(pool->share.bounds);
    free(pool->share.said);
    free(pool->share.room);
    free(pool->handles);
    free(pool->workers);
    free(pool);
}

int ad_pool_threads(const ad_pool *pool)
{
    return pool->threads;
}

/* What results depend on beside their inputs: kernels, and the size of tiles (FNV-1a). */
static uint64_t kind_of_machine(void)
{
    char text[128];
    uint64_t hash = 0xcbf29ce484222325u;
    snprintf(text, sizeof text, "%s %s %ld", ad_kernels_select()->name, ad_dense_kernels(),
             sysconf(_SC_LEVEL2_CACHE_SIZE));
    for (const char *at = text; *at; at++) {
        hash = (hash ^ (unsigned char)*at) * 0x100000001b3u;
    }
    return hash;
}

ad_status ad_pool_share(ad_pool *pool, const ad_ranks *ranks, ad_error *error)
{
    share *s = &pool->share;
    s->ranks = NULL;
    if (!ranks || ranks->count < 2) {
        return AD_OK;
    }
    if (ranks->count > AD_RANKS_MAX) {
        return ad_fail(error, AD_BAD_ARGUMENT, "%d ranks; allowed: at most %d", ranks->count,
                       AD_RANKS_MAX);
    }
    free(s->bounds);
    free(s->said);
    s->bounds = calloc(2 * ((size_t)ranks->count + 1), sizeof *s->bounds);
    s->said = calloc((size_t)ranks->count, sizeof *s->said);
    if (!s->bounds || !s->said) {
        return ad_fail(error, AD_NO_MEMORY, "out of memory for %d ranks", ranks->count);
    }
    if (!ad_ranks_agree(ranks, kind_of_machine())) {
        return ad_fail(error, AD_BAD_ARGUMENT,
                       "the ranks run on processors of different kinds, with kernels or tiles of "
                       "their own, so that their numbers would differ; take machines of one kind");
    }
    s->ranks = ranks;
    return AD_OK;
}

const ad_ranks *ad_pool_ranks(const ad_pool *pool)
{
    return pool->share.ranks;
}

share *ad_pool_get_share(ad_pool *pool)
{
    return &pool->share;
}
