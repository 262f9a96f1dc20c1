/* Jobs over ranks, for test_ranks_queue.sh: queue_jobs COUNT [fails JOB | leaves RANK | dies RANK].
 * Job i takes a time that has nothing to do with i, and leaves i % 7 numbers. A rank dies once ten
 * rows are printed, however slow the others are: a file says so. */
#include "tools/judge/signals.h"
#include "tools/programs/cli.h"
#include "tools/programs/program_ranks.h"
#include "tools/programs/ranks_queue.h"

#include <signal.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <time.h>
#include <unistd.h>

static const char program[] = "queue_jobs";

enum { ROWS = 10 };

typedef struct plan {
    const char *what;
    size_t which, rank, taken;
} plan;

static bool is(const plan *p, const char *what, size_t which)
{
    return strcmp(p->what, what) == 0 && p->which == which;
}

static ad_status work(void *context, size_t index, ranks_result *result, ad_error *error)
{
    const plan *p = context;
    size_t numbers[7];
    nanosleep(&(struct timespec){.tv_nsec = (long)(index * 7919 % 13) * 2000000}, NULL);
    if (is(p, "fails", index)) {
        return ad_fail(error, AD_BAD_ARGUMENT, "job %zu: is one that fails", index);
    }
    if (is(p, "dies", p->rank) && index >= ROWS) {
        while (access("ten_rows", F_OK) != 0) {
            nanosleep(&(struct timespec){.tv_nsec = 1000000}, NULL);
        }
        raise(SIGKILL);
    }
    for (size_t i = 0; i < 7; i++) {
        numbers[i] = index * index + i;
    }
    return ranks_result_copy(result, index % 7 * sizeof *numbers, numbers, error);
}

static ad_status take(void *context, size_t index, const ranks_result *result, ad_error *error)
{
    plan *p = context;
    const size_t *numbers = result->bytes;
    (void)error;
    printf("%zu:", index);
    for (size_t i = 0; i < result->size / sizeof *numbers; i++) {
        printf(" %zu", numbers[i]);
    }
    puts(result->is_cut ? " cut" : "");
    fflush(stdout);
    p->taken++;
    if (strcmp(p->what, "dies") == 0 && p->taken == ROWS) {
        fclose(fopen("ten_rows", "w"));
    }
    return AD_OK;
}

static int run(const ad_ranks *ranks, const plan *asked, size_t count)
{
    plan p = *asked;
    const ranks_jobs jobs = {count, &p, work, take};
    ad_error error;
    int signal;
    if (ranks && is(&p, "leaves", p.rank)) {
        ranks_queue_none(ranks);
        return cli_fail(program, "rank %d leaves", ranks->rank);
    }
    signals_catch();
    ad_status status = ranks_queue(ranks, &jobs, &signal, &error);
    return status != AD_OK ? cli_fail_error(program, &error)
           : signal        ? ranks_queue_stopped(program, ranks, signal, p.taken, count)
                           : 0;
}

int main(int count, char **arguments)
{
    const ad_ranks *ranks;
    ad_error error;
    const bool whole = count == 4;
    plan p = {whole ? arguments[2] : "", whole ? strtoul(arguments[3], NULL, 10) : 0, 0, 0};
    if (ranks_begin(count, arguments, &ranks, &error) != AD_OK) {
        return ranks_end(program, cli_fail_error(program, &error));
    }
    p.rank = ranks ? (size_t)ranks->rank : 0;
    return ranks_end(program, run(ranks, &p, count > 1 ? strtoul(arguments[1], NULL, 10) : 0));
}
