#include "tools/programs/ranks_queue.h"

#include "tools/judge/signals.h"
#include "tools/programs/cli.h"
#include "tools/programs/program_ranks.h"
#include "tools/train/clock.h"

#include <pthread.h>
#include <stdlib.h>
#include <string.h>
#include <time.h>

/* What a rank asks for a job with, its last result behind it. It gets the index of the next. */
typedef struct answer {
    int64_t index; /* NO_JOB: none before the first */
    int signal;    /* that this rank has caught */
    ad_error error;
} answer;

static const int64_t NO_JOB = -1;
static const double LAST_RESULTS = 0.3; /* s after a signal, for what others have cut short */

/* What has become of a job. */
typedef struct slot {
    bool is_done;
    ad_error error;
    ranks_result result;
} slot;

/* What rank 0 does itself is done by a thread, as MPI is for the main one alone. */
typedef struct helper {
    const ranks_jobs *jobs;
    pthread_t thread;
    pthread_mutex_t mutex;
    pthread_cond_t changed;
    enum { IDLE, BUSY, DONE, OVER } state;
    size_t index;
    slot done; /* of index */
} helper;

typedef struct server {
    const ranks_jobs *jobs;
    const ad_ranks *ranks;
    slot *slots; /* [count] */
    size_t next; /* the job to hand out */
    size_t taken;
    size_t awaited;  /* handed out, not done */
    bool is_failed;  /* no job is begun any more */
    bool *is_served; /* [ranks] knows that nothing is left */
    int signal;      /* that a rank has caught, and */
    double stopped;  /* since when that is known, s */
} server;

ad_status ranks_result_copy(ranks_result *result, size_t size, const void *bytes, ad_error *error)
{
    result->bytes = malloc(size + 1);
    if (!result->bytes) {
        return ad_fail(error, AD_NO_MEMORY, "out of memory for a result of %zu bytes", size);
    }
    result->size = size;
    memcpy(result->bytes, bytes, size);
    return AD_OK;
}

static void doze(void)
{
    nanosleep(&(struct timespec){.tv_nsec = 1000000}, NULL);
}

static void do_job(const ranks_jobs *jobs, size_t index, slot *to)
{
    *to = (slot){.is_done = true};
    to->error.status = jobs->work(jobs->context, index, &to->result, &to->error);
    to->result.is_cut = signals_caught() != 0;
}

/* ---- a process by itself --------------------------------------------------------------------- */

static ad_status take(const ranks_jobs *jobs, size_t index, slot *done, ad_error *error)
{
    ad_status status = done->error.status;
    if (status != AD_OK) {
        *error = done->error;
    } else {
        status = jobs->take(jobs->context, index, &done->result, error);
    }
    free(done->result.bytes);
    *done = (slot){.is_done = false};
    return status;
}

static ad_status do_alone(const ranks_jobs *jobs, ad_error *error)
{
    ad_status status = AD_OK;
    for (size_t i = 0; i < jobs->count && status == AD_OK && !signals_caught(); i++) {
        slot done;
        do_job(jobs, i, &done);
        status = take(jobs, i, &done, error);
    }
    return status;
}

/* ---- the other ranks ------------------------------------------------------------------------- */

/* The error of a job goes to rank 0 as well, which reports it. */
static void ask(const slot *last, int64_t index)
{
    answer head = {index, signals_caught(), last->error};
    char *message = malloc(sizeof head + last->result.size);
    if (!message) {
        ad_fail(&head.error, AD_NO_MEMORY, "out of memory for a result");
        ranks_send(0, sizeof head, &head);
        return;
    }
    memcpy(message, &head, sizeof head);
    if (last->result.size > 0) {
        memcpy(message + sizeof head, last->result.bytes, last->result.size);
    }
    ranks_send(0, sizeof head + last->result.size, message);
    free(message);
}

/* After a signal rank 0 is told of it, and not waited for. */
static int64_t hear(void)
{
    int64_t index;
    void *message;
    size_t size;
    int from;
    while (!ranks_receive(&from, &size, &message)) {
        if (signals_caught()) {
            ask(&(slot){.is_done = false}, NO_JOB);
            return NO_JOB;
        }
        doze();
    }
    memcpy(&index, message, sizeof index);
    free(message);
    return index;
}

static void serve_others(const ranks_jobs *jobs)
{
    slot last = {.is_done = false};
    int64_t index = NO_JOB;
    do {
        ask(&last, index);
        free(last.result.bytes);
        last = (slot){.is_done = false};
        index = hear();
        if (index != NO_JOB) {
            do_job(jobs, (size_t)index, &last);
        }
    } while (index != NO_JOB);
}

/* ---- rank 0: the thread that works ----------------------------------------------------------- */

static void *help(void *context)
{
    helper *h = context;
    pthread_mutex_lock(&h->mutex);
    while (h->state != OVER) {
        if (h->state == BUSY) {
            pthread_mutex_unlock(&h->mutex);
            do_job(h->jobs, h->index, &h->done);
            pthread_mutex_lock(&h->mutex);
            h->state = DONE;
        }
        pthread_cond_wait(&h->changed, &h->mutex);
    }
    pthread_mutex_unlock(&h->mutex);
    return NULL;
}

static ad_status helper_start(helper *h, const ranks_jobs *jobs, ad_error *error)
{
    *h = (helper){.jobs = jobs, .state = IDLE};
    pthread_mutex_init(&h->mutex, NULL);
    pthread_cond_init(&h->changed, NULL);
    if (pthread_create(&h->thread, NULL, help, h) != 0) {
        return ad_fail(error, AD_NO_MEMORY, "a thread could not be started");
    }
    return AD_OK;
}

/* Whether it leaves a result, of a job that a signal has cut short. */
static bool helper_end(helper *h)
{
    pthread_mutex_lock(&h->mutex);
    while (h->state == BUSY) {
        pthread_mutex_unlock(&h->mutex);
        doze();
        pthread_mutex_lock(&h->mutex);
    }
    const bool is_done = h->state == DONE;
    h->state = OVER;
    pthread_cond_signal(&h->changed);
    pthread_mutex_unlock(&h->mutex);
    pthread_join(h->thread, NULL);
    pthread_mutex_destroy(&h->mutex);
    pthread_cond_destroy(&h->changed);
    return is_done;
}

/* ---- rank 0: who hands out ------------------------------------------------------------------- */

static bool begins_jobs(const server *s)
{
    return !s->is_failed && s->signal == 0 && s->next < s->jobs->count;
}

static int64_t hand_out(server *s)
{
    if (!begins_jobs(s)) {
        return NO_JOB;
    }
    s->awaited++;
    return (int64_t)s->next++;
}

static void put(server *s, size_t index, const slot *done)
{
    s->slots[index] = *done;
    s->awaited--;
    s->is_failed = s->is_failed || done->error.status != AD_OK;
}

static void stop(server *s, int signal)
{
    if (signal && !s->signal) {
        s->signal = signal;
        s->stopped = train_seconds();
    }
}

/* One message of another rank; whether there was one. */
static bool serve_one(server *s)
{
    void *message;
    size_t size;
    int from;
    if (!ranks_receive(&from, &size, &message)) {
        return false;
    }
    answer head;
    memcpy(&head, message, sizeof head);
    stop(s, head.signal);
    if (head.index != NO_JOB) {
        slot done = {.is_done = true, .error = head.error, .result.is_cut = head.signal != 0};
        if (done.error.status == AD_OK) {
            done.error.status = ranks_result_copy(&done.result, size - sizeof head,
                                                  (char *)message + sizeof head, &done.error);
        }
        put(s, (size_t)head.index, &done);
    }
    free(message);
    const int64_t index = hand_out(s);
    s->is_served[from] = index == NO_JOB;
    ranks_send(from, sizeof index, &index);
    return true;
}

/* A job for the thread, or its result; whether there was either. */
static bool use_helper(server *s, helper *h)
{
    pthread_mutex_lock(&h->mutex);
    const bool is_done = h->state == DONE;
    if (is_done) {
        put(s, h->index, &h->done);
        h->state = IDLE;
    }
    const bool begins = h->state == IDLE && begins_jobs(s);
    if (begins) {
        h->index = (size_t)hand_out(s);
        h->state = BUSY;
        pthread_cond_signal(&h->changed);
    }
    pthread_mutex_unlock(&h->mutex);
    return is_done || begins;
}

/* Those that are next, in order; at the end also those behind jobs that are not done. */
static ad_status take_ready(server *s, bool is_end, ad_error *error)
{
    ad_status status = AD_OK;
    while (s->taken < s->next && (s->slots[s->taken].is_done || is_end) && status == AD_OK) {
        const size_t index = s->taken++;
        if (s->slots[index].is_done) {
            status = take(s->jobs, index, &s->slots[index], error);
        }
    }
    s->is_failed = s->is_failed || status != AD_OK;
    return status;
}

/* All the others know that nothing is left, or have come to their end by themselves. */
static bool all_served(const server *s)
{
    for (int i = 1; i < s->ranks->count; i++) {
        if (!s->is_served[i] && !ranks_has_ended(i)) {
            return false;
        }
    }
    return true;
}

/* After a signal the others may be gone, and are not waited for. */
static bool is_over(server *s)
{
    stop(s, signals_caught());
    return (s->signal && train_seconds() - s->stopped > LAST_RESULTS) ||
           (!begins_jobs(s) && s->awaited == 0 && all_served(s));
}

static ad_status serve(server *s, ad_error *error)
{
    helper h;
    ad_status status = helper_start(&h, s->jobs, error);
    if (status != AD_OK) {
        return status;
    }
    while (!is_over(s)) {
        const bool is_idle = !serve_one(s) && !use_helper(s, &h);
        status = status == AD_OK ? take_ready(s, false, error) : status;
        if (is_idle) {
            doze();
        }
    }
    if (helper_end(&h)) {
        put(s, h.index, &h.done);
    }
    return status == AD_OK ? take_ready(s, true, error) : status;
}

static ad_status hand_out_all(const ad_ranks *ranks, const ranks_jobs *jobs, int *signal,
                              ad_error *error)
{
    server s = {.jobs = jobs,
                .ranks = ranks,
                .slots = calloc(jobs->count + 1, sizeof *s.slots),
                .is_served = calloc((size_t)ranks->count, sizeof *s.is_served)};
    ad_status status = s.slots && s.is_served ? serve(&s, error)
                                              : ad_fail(error, AD_NO_MEMORY,
                                                        "out of memory for %zu jobs", jobs->count);
    for (size_t i = 0; s.slots && i < jobs->count; i++) {
        free(s.slots[i].result.bytes); /* behind an error */
    }
    free(s.slots);
    free(s.is_served);
    *signal = s.signal;
    return status;
}

ad_status ranks_queue(const ad_ranks *ranks, const ranks_jobs *jobs, int *signal, ad_error *error)
{
    ad_status status = AD_OK;
    if (ranks && ranks->rank == 0) {
        return hand_out_all(ranks, jobs, signal, error);
    }
    if (ranks) {
        serve_others(jobs);
    } else {
        status = do_alone(jobs, error);
    }
    *signal = signals_caught();
    return status;
}

void ranks_queue_none(const ad_ranks *ranks)
{
    ad_error error;
    int signal;
    if (ranks && ranks->rank == 0) {
        hand_out_all(ranks, &(ranks_jobs){.count = 0}, &signal, &error);
    }
}

int ranks_queue_stopped(const char *program, const ad_ranks *ranks, int signal, size_t done,
                        size_t count)
{
    if (ranks) {
        cli_warn(program,
                 "stopped by signal %d, or since a rank has ended: %zu of %zu rows are done",
                 signal, done, count);
    }
    return 128 + signal;
}
