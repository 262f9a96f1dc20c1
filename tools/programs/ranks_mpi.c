/* Ranks by MPI. Only the thread that began calls it. While a rank waits for others, rank 0 looks
 * whether one of them has failed. */
#include "tools/programs/launcher.h"
#include "tools/programs/program_ranks.h"

#include <limits.h>
#include <mpi.h>
#include <sched.h>
#include <stdint.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>

enum { TAG_END = 1, WORDS = 512, SPINS = 1000 };

static const double patience = 20; /* s, for others to come to an end */

/* How a rank has ended. */
typedef struct last_words {
    int32_t exit_status;
    char text[WORDS];
} last_words;

/* MPI is one for the process, and so is this. */
static struct {
    ad_ranks ranks;
    MPI_Comm work, control; /* for numbers; for ends */
    int *numbers;           /* [4][ranks] counts and places */
    FILE *errors;           /* what a rank but 0 has said on stderr */
    double waited;          /* s */
    bool is_begun;
} mpi;

/* ---- waiting --------------------------------------------------------------------------------- */

static void say(const char *program, int rank, const last_words *last)
{
    fprintf(stderr, "%s: rank %d: %s\n", program ? program : "cpinn", rank,
            *last->text ? last->text : "has ended");
}

/* A rank that has ended while this one still waits for all: it has failed. */
static void look_for_ends(double *seen)
{
    MPI_Status status;
    last_words last;
    int found = 0;
    MPI_Iprobe(MPI_ANY_SOURCE, TAG_END, mpi.control, &found, &status);
    if (!found) {
        return;
    }
    if (*seen == 0) {
        *seen = MPI_Wtime();
    }
    if (MPI_Wtime() - *seen > 1) {
        MPI_Recv(&last, sizeof last, MPI_BYTE, status.MPI_SOURCE, TAG_END, mpi.control, &status);
        fflush(stdout);
        say(NULL, status.MPI_SOURCE, &last);
        MPI_Abort(MPI_COMM_WORLD, last.exit_status);
    }
}

static void wait_for(MPI_Request *request)
{
    int done = 0;
    double seen = 0;
    const double began = MPI_Wtime();
    for (unsigned i = 1; MPI_Test(request, &done, MPI_STATUS_IGNORE) == MPI_SUCCESS && !done; i++) {
        if (i % SPINS == 0) {
            if (mpi.ranks.rank == 0) {
                look_for_ends(&seen);
            }
            sched_yield(); /* there may be more ranks than processors */
        }
    }
    mpi.waited += MPI_Wtime() - began;
}

double ranks_waited(void)
{
    return mpi.waited;
}

/* ---- numbers --------------------------------------------------------------------------------- */

/* Counts and places as MPI has them. */
static void list(const size_t *bounds, int *counts, int *places)
{
    for (int i = 0; i < mpi.ranks.count; i++) {
        if (bounds[i + 1] > INT_MAX) {
            fprintf(stderr, "cpinn: more than 2^31 numbers are exchanged at once\n");
            MPI_Abort(MPI_COMM_WORLD, EXIT_FAILURE);
        }
        counts[i] = (int)(bounds[i + 1] - bounds[i]);
        places[i] = (int)bounds[i];
    }
}

static void gather(void *context, const size_t *bounds, double *data)
{
    MPI_Request request;
    int *counts = mpi.numbers, *places = counts + mpi.ranks.count;
    (void)context;
    list(bounds, counts, places);
    MPI_Iallgatherv(MPI_IN_PLACE, 0, MPI_DOUBLE, data, counts, places, MPI_DOUBLE, mpi.work,
                    &request);
    wait_for(&request);
}

static void exchange(void *context, const size_t *to, const double *send, const size_t *from,
                     double *receive)
{
    MPI_Request request;
    const int n = mpi.ranks.count;
    int *sent = mpi.numbers, *received = sent + 2 * n;
    (void)context;
    list(to, sent, sent + n);
    list(from, received, received + n);
    MPI_Ialltoallv(send, sent, sent + n, MPI_DOUBLE, receive, received, received + n, MPI_DOUBLE,
                   mpi.work, &request);
    wait_for(&request);
}

/* ---- beginning ------------------------------------------------------------------------------- */

/* All but rank 0 are not heard. */
static void fall_silent(void)
{
    mpi.errors = tmpfile();
    if (!freopen("/dev/null", "w", stdout) || !mpi.errors ||
        dup2(fileno(mpi.errors), STDERR_FILENO) < 0) {
        MPI_Abort(MPI_COMM_WORLD, EXIT_FAILURE);
    }
}

ad_status ranks_begin(int count, char **arguments, const ad_ranks **ranks, ad_error *error)
{
    int rank, provided, processes = launcher_processes(&rank);
    *ranks = NULL;
    launcher_share();
    if (processes == 1) {
        return AD_OK;
    }
    MPI_Init_thread(NULL, NULL, MPI_THREAD_FUNNELED, &provided);
    MPI_Comm_dup(MPI_COMM_WORLD, &mpi.work);
    MPI_Comm_dup(MPI_COMM_WORLD, &mpi.control);
    MPI_Comm_rank(mpi.work, &mpi.ranks.rank);
    MPI_Comm_size(mpi.work, &mpi.ranks.count);
    mpi.is_begun = true;
    if (mpi.ranks.count == 1) {
        return ad_fail(
            error, AD_BAD_INPUT,
            "mpirun or srun: started as %d processes that MPI does not connect; by srun: try "
            "--mpi=pmix or --mpi=pmi2, which srun --mpi=list may know",
            processes);
    }
    if (provided < MPI_THREAD_FUNNELED) {
        return ad_fail(error, AD_BAD_INPUT,
                       "mpirun or srun: this MPI allows no threads; needed: MPI_THREAD_FUNNELED");
    }
    mpi.ranks.gather = gather;
    mpi.ranks.exchange = exchange;
    mpi.numbers = calloc(4 * (size_t)mpi.ranks.count, sizeof *mpi.numbers);
    if (!mpi.numbers) {
        return ad_fail(error, AD_NO_MEMORY, "out of memory for %d ranks", mpi.ranks.count);
    }
    if (mpi.ranks.rank > 0) {
        fall_silent();
    }
    *ranks = &mpi.ranks;
    return ranks_compare_arguments(*ranks, count, arguments, error);
}

/* ---- threads --------------------------------------------------------------------------------- */

/* The processors that this process may use, and which they are. */
static int processors(uint64_t *which)
{
    cpu_set_t allowed;
    CPU_ZERO(&allowed);
    *which = 0;
    if (sched_getaffinity(0, sizeof allowed, &allowed) != 0) {
        return 1;
    }
    for (int i = 0; i < CPU_SETSIZE; i++) {
        *which = *which * 31 + (uint64_t)(CPU_ISSET(i, &allowed) != 0);
    }
    return CPU_COUNT(&allowed);
}

/* The processors that this rank may use, how many ranks there are on its machine, and how many of
 * them may use the same. */
static int look_around(int *here, int *sharing)
{
    uint64_t own, *all;
    const int count = processors(&own);
    MPI_Comm machine;
    *here = *sharing = 1;
    if (mpi.ranks.count < 2) {
        return count;
    }
    MPI_Comm_split_type(mpi.work, MPI_COMM_TYPE_SHARED, 0, MPI_INFO_NULL, &machine);
    MPI_Comm_size(machine, here);
    all = calloc((size_t)*here, sizeof *all);
    if (!all) {
        MPI_Abort(MPI_COMM_WORLD, EXIT_FAILURE);
        return 1;
    }
    MPI_Allgather(&own, 1, MPI_UINT64_T, all, 1, MPI_UINT64_T, machine);
    *sharing = 0;
    for (int i = 0; i < *here; i++) {
        *sharing += all[i] == own;
    }
    free(all);
    MPI_Comm_free(&machine);
    return count;
}

int ranks_threads(int asked)
{
    int here, sharing, count;
    if (asked > 0 || mpi.ranks.count < 2) {
        return asked;
    }
    count = look_around(&here, &sharing);
    return count > sharing ? count / sharing : 1;
}

/* ---- the end --------------------------------------------------------------------------------- */

/* What this rank has said last. */
static void remember(int exit_status, last_words *last)
{
    memset(last, 0, sizeof *last);
    last->exit_status = exit_status;
    fflush(stderr);
    if (mpi.errors) {
        long size = fseek(mpi.errors, 0, SEEK_END) == 0 ? ftell(mpi.errors) : 0;
        fseek(mpi.errors, size > WORDS - 1 ? size - WORDS + 1 : 0, SEEK_SET);
        last->text[fread(last->text, 1, WORDS - 1, mpi.errors)] = '\0';
        last->text[strcspn(last->text, "\n")] = '\0';
    }
}

static bool all_done(MPI_Request *requests, int count, double limit)
{
    int done = 0;
    const double until = MPI_Wtime() + limit;
    while (!done && (limit == 0 || MPI_Wtime() < until)) {
        done = 1;
        for (int i = 0, is = 0; i < count; i++) {
            MPI_Test(&requests[i], &is, MPI_STATUS_IGNORE);
            done = done && is;
        }
        sched_yield();
    }
    return done;
}

/* Rank 0 hears how all have ended, and tells them how the program ends. */
static int hear_all(const char *program, int exit_status)
{
    const int others = mpi.ranks.count - 1;
    last_words *last = calloc((size_t)others, sizeof *last);
    MPI_Request *requests = calloc((size_t)others, sizeof(MPI_Request));
    if (!last || !requests) {
        MPI_Abort(MPI_COMM_WORLD, exit_status ? exit_status : EXIT_FAILURE);
        return exit_status;
    }
    for (int i = 0; i < others; i++) {
        MPI_Irecv(&last[i], sizeof *last, MPI_BYTE, i + 1, TAG_END, mpi.control, &requests[i]);
    }
    if (!all_done(requests, others, exit_status ? patience : 0)) {
        fflush(NULL);
        MPI_Abort(MPI_COMM_WORLD, exit_status); /* they wait for numbers of this one */
    }
    for (int i = 0; i < others && exit_status == 0; i++) {
        if (last[i].exit_status != 0) {
            exit_status = last[i].exit_status;
            say(program, i + 1, &last[i]);
        }
    }
    free(last);
    free(requests);
    return exit_status;
}

int ranks_end(const char *program, int exit_status)
{
    if (mpi.is_begun && mpi.ranks.count > 1) {
        if (mpi.ranks.rank == 0) {
            exit_status = hear_all(program, exit_status);
        } else {
            last_words last;
            MPI_Request request;
            remember(exit_status, &last);
            MPI_Isend(&last, sizeof last, MPI_BYTE, 0, TAG_END, mpi.control, &request);
            all_done(&request, 1, 0);
        }
        MPI_Request request;
        MPI_Ibcast(&exit_status, 1, MPI_INT, 0, mpi.control, &request);
        all_done(&request, 1, 0);
    }
    if (mpi.is_begun) {
        MPI_Comm_free(&mpi.work);
        MPI_Comm_free(&mpi.control);
        MPI_Finalize();
        free(mpi.numbers);
    }
    return exit_status;
}
