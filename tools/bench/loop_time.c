/* How long an exported loop (cpinn-control --c) with one sensor of the place takes, on its own
 * model with noise, on a circle about where it rests; and whether what is slow is the loop or the
 * machine. All samples are computed three times, to the same bits: the quickest of three is what
 * a sample takes, and beside each an empty loop of about its length is timed, too.
 *
 *   cc -std=c11 -O2 -DHEADER='"arm.h"' -DNAME=arm loop_time.c arm.c -lm -o time
 *   ./time 100000 0.5     samples, and rounds a second: more than the robot can follow keep inputs
 *                         at their limits, which is what takes longest */
#define _GNU_SOURCE
#include HEADER
#include "loop_wire.h"

#include <math.h>
#include <sys/resource.h>

#define JOIN_(a, b) a##_##b
#define JOIN(a, b)  JOIN_(a, b)
#define OF(name)    JOIN(NAME, name)

enum { SAMPLES_MAX = 1000000, RUNS = 3, SHOWN = 5 };
enum { MEASURE, CONTROL, PREPARE, WALL, OWN, BEST, EMPTY, EMPTY_OWN, ROWS };
static const char *const names[ROWS] = {
    "measures",        "controls",   "prepares",           "all of a sample", "  time of processor",
    "  quickest of 3", "empty loop", "  time of processor"};
static _Alignas(64) unsigned char memory[OF(MEMORY)], robot_memory[OF(MEMORY)];
static double lengths[ROWS][SAMPLES_MAX]; /* of the first run; BEST: of all */
static double answers[SAMPLES_MAX];       /* sums, to see that all runs are the same */
static int iterations[SAMPLES_MAX], slowest[SAMPLES_MAX];
static unsigned char switches[SAMPLES_MAX]; /* involuntary, of the first run */
static unsigned seed;

static double noise(void)
{
    seed = seed * 1664525u + 1013904223u;
    return 3.4 * (seed / 4294967296.0 - 0.5);
}

static double own_seconds(void)
{
    struct timespec now;
    clock_gettime(CLOCK_THREAD_CPUTIME_ID, &now);
    return (double)now.tv_sec + 1e-9 * (double)now.tv_nsec;
}

static long switched(void)
{
    struct rusage use;
    getrusage(RUSAGE_THREAD, &use);
    return use.ru_nivcsw;
}

static void spin(long turns)
{
    for (volatile long i = 0; i < turns; i++) {
    }
}

/* Turns of the empty loop in so many seconds. */
static long turns_of(double seconds)
{
    double best = 1;
    for (int i = 0; i < 100; i++) {
        const double begin = wire_seconds();
        spin(100000);
        best = fmin(best, wire_seconds() - begin);
    }
    return (long)(1e5 * seconds / best);
}

static void time_empty(long k, long turns)
{
    const double own = own_seconds(), begin = wire_seconds();
    spin(turns);
    lengths[EMPTY][k] = wire_seconds() - begin;
    lengths[EMPTY_OWN][k] = own_seconds() - own;
}

/* One sample; t are the times of its parts. */
static int sample(OF(loop) * loop, long k, const double *place, const double *path, double *answer,
                  double t[4])
{
    int most;
    t[0] = wire_seconds();
    OF(measure)(loop, 0, -1, place);
    t[1] = wire_seconds();
    OF(control)(loop, path, answer);
    t[2] = wire_seconds();
    iterations[k] = OF(iterations)(loop, &most);
    OF(prepare)(loop);
    t[3] = wire_seconds();
    return most;
}

/* Returns how many samples are other than those of the first run, or a step has failed. */
static long run(int which, long count, double hz, long turns, int *most)
{
    OF(loop) *loop = OF(init)(memory, sizeof memory);
    OF(loop) *robot = OF(init)(robot_memory, sizeof robot_memory);
    double state[OF(STATES)], next[OF(STATES)], inputs[OF(INPUTS)], answer[OF(CONTROLLED)];
    double rest[3], place[3], path[OF(HORIZON)][3];
    long failed = 0;
    seed = 1;
    memcpy(state, OF(state)(loop), sizeof state);
    memcpy(inputs, OF(inputs)(loop), sizeof inputs);
    OF(place)(loop, state, rest, NULL);
    for (long k = 0; k < count; k++) {
        double t[4], sum = 0;
        wire_sleep_until(wire_seconds() + 5e-5); /* urgent processes get 95 % of a second */
        OF(place)(robot, state, place, NULL);
        for (int i = 0; i < 3; i++) {
            place[i] += 2e-4 * noise();
        }
        for (int i = 0; i < OF(HORIZON); i++) {
            const double now = OF(SAMPLE) * (double)k + OF(LOOK_AHEAD) * i;
            path[i][0] = rest[0] + 0.03 * sin(2 * M_PI * hz * now);
            path[i][1] = rest[1] - 0.03 * cos(2 * M_PI * hz * now);
            path[i][2] = NAN;
        }
        const long before = switched();
        const double own = own_seconds();
        *most = sample(loop, k, place, path[0], answer, t);
        const double all = t[3] - t[0], own_all = own_seconds() - own;
        lengths[BEST][k] = which ? fmin(lengths[BEST][k], all) : all;
        for (int i = 0; i < OF(CONTROLLED); i++) { /* one sample later */
            inputs[OF(controlled)[i]] = answer[i];
            sum += answer[i] * (i + 1);
        }
        if (which == 0) {
            for (int i = 0; i < 3; i++) {
                lengths[i][k] = t[i + 1] - t[i];
            }
            lengths[WALL][k] = all;
            lengths[OWN][k] = own_all;
            switches[k] = switched() != before;
            answers[k] = sum;
            time_empty(k, turns);
        }
        failed += answers[k] != sum;
        failed += OF(step)(robot, state, inputs, next, NULL, NULL) != 0;
        memcpy(state, next, sizeof state);
    }
    return failed;
}

static int by_wall(const void *a, const void *b)
{
    const double x = lengths[WALL][*(const int *)a], y = lengths[WALL][*(const int *)b];
    return (x < y) - (x > y);
}

/* The slowest samples of the first run, before the times are sorted. */
static void show_slowest(long count)
{
    for (int k = 0; k < count; k++) {
        slowest[k] = k;
    }
    qsort(slowest, (size_t)count, sizeof *slowest, by_wall);
    for (int i = 0; i < SHOWN; i++) {
        const int k = slowest[i];
        printf(
            "sample %6d: %7.1f us, of the processor %7.1f, quickest of 3 %7.1f, program %3d, %s\n",
            k, 1e6 * lengths[WALL][k], 1e6 * lengths[OWN][k], 1e6 * lengths[BEST][k], iterations[k],
            switches[k] ? "taken off the processor" : "not switched");
    }
}

static void show_iterations(long count, int most)
{
    int worst = 0;
    long none = 0;
    for (long k = 0; k < count; k++) {
        worst = iterations[k] > worst ? iterations[k] : worst;
        none += iterations[k] == 0;
    }
    printf("quadratic program: at most %d rows added or dropped, of %d allowed; none in %.3g %%\n",
           worst, most, 100.0 * (double)none / (double)count);
}

int main(int argc, char **argv)
{
    const long asked = argc > 1 ? atol(argv[1]) : 100000;
    const long count = asked < SAMPLES_MAX ? asked : SAMPLES_MAX;
    const double hz = argc > 2 ? atof(argv[2]) : 0.5;
    int most = 0;
    long failed = 0;
    wire_be_urgent(80);
    const long turns = turns_of(1.5e-4);
    for (int i = 0; i < RUNS; i++) {
        failed += run(i, count, hz, turns, &most);
    }
    printf("%ld samples at %g Hz, 3 times: %ld without a step of the model or other than before\n",
           count, hz, failed);
    show_slowest(count);
    show_iterations(count, most);
    for (int i = 0; i < ROWS; i++) {
        wire_say(names[i], count, lengths[i]);
    }
    return failed > 0;
}
