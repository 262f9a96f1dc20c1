/* Runs an exported loop (cpinn-control --c) in real time against a robot in another process,
 * loop_plant.c, and measures how late it wakes and how long it computes; tools/bench/loop.sh.
 *
 *   cc -std=c11 -O2 -DHEADER='"arm.h"' -DNAME=arm loop_host.c arm.c -lm -o host
 *   ./host SECONDS X Y Z RADIUS HZ FILE.csv     a circle about (X, Y, Z) m across z */
#define _GNU_SOURCE
#include HEADER
#include "loop_wire.h"

#include <math.h>

#define JOIN_(a, b) a##_##b
#define JOIN(a, b)  JOIN_(a, b)
#define OF(name)    JOIN(NAME, name)

static _Alignas(64) unsigned char memory[OF(MEMORY)];

enum { WAKE, ANSWER, PREPARE, ALL, TIMES, BINS = 40 };
static const char *const names[TIMES] = {"wakes late by", "measures and controls", "prepares",
                                         "all of a period"};

/* Samples are taken so much of a period after the robot has sent its own. */
static const double PHASE = 0.2;

static double lengths[TIMES][4000000];

static double approach = 1;

/* Where the place has to be at t: from `start` onto the circle in a second. */
static void path_at(const double *circle, const double *start, double t, double wish[3])
{
    const double turn = 2 * M_PI * circle[4] * t, x = fmin(1, t / approach);
    const double part = x * x * x * (10 + x * (6 * x - 15));
    const double on[3] = {circle[0] + circle[3] * cos(turn), circle[1] + circle[3] * sin(turn),
                          circle[2]};
    for (int k = 0; k < 3; k++) {
        wish[k] = start[k] + part * (on[k] - start[k]);
    }
}

static void report(long count, const char *path)
{
    long bins[TIMES][BINS] = {{0}};
    FILE *file = fopen(path, "w");
    for (int i = 0; i < TIMES; i++) {
        double *t = lengths[i];
        for (long k = 0; k < count; k++) { /* fourths of a factor of ten, from 0.1 us on */
            const int bin = t[k] > 1e-7 ? (int)(4 * log10(t[k] / 1e-7)) : 0;
            bins[i][bin < BINS ? bin : BINS - 1]++;
        }
        wire_say(names[i], count, t);
    }
    if (file) {
        fputs("from_us,wake,answer,prepare,all\n", file);
        for (int b = 0; b < BINS; b++) {
            fprintf(file, "%.4g,%ld,%ld,%ld,%ld\n", 0.1 * pow(10, b / 4.0), bins[WAKE][b],
                    bins[ANSWER][b], bins[PREPARE][b], bins[ALL][b]);
        }
        fclose(file);
    }
}

int main(int argc, char **argv)
{
    const double period = OF(SAMPLE);
    double circle[5], start[3], path[OF(HORIZON)][3];
    if (argc != 8) {
        fprintf(stderr, "usage: %s SECONDS X Y Z RADIUS HZ FILE.csv\n", argv[0]);
        return 2;
    }
    for (int i = 0; i < 5; i++) {
        circle[i] = atof(argv[2 + i]);
    }
    const long wanted = (long)(atof(argv[1]) / period);
    const long count = wanted < 4000000 ? wanted : 4000000;
    OF(loop) *loop = OF(init)(memory, sizeof memory);
    const int s = wire_open(WIRE_PORT + 1, WIRE_PORT);
    long missing = 0, flagged = 0, late = 0, passed = 0;
    wire_told told = {0};
    OF(place)(loop, OF(state)(loop), start, NULL);
    wire_be_urgent(80);
    wire_seen seen;
    told.sample = -1; /* the robot rests under these inputs, and then goes by its clock */
    for (int i = 0; i < OF(CONTROLLED); i++) {
        told.inputs[i] = OF(inputs)(loop)[OF(controlled)[i]];
    }
    while (wire_newest(s, &seen, sizeof seen) == 0) {
        send(s, &told, sizeof told, 0);
        wire_sleep_until(wire_seconds() + 0.01);
    }
    while (recv(s, &seen, sizeof seen, 0) != (ssize_t)sizeof seen) {
    }
    double next = wire_seconds() + (1 + PHASE) * period;
    wire_sleep_until(next - 0.5 * period);
    wire_newest(s, &seen, sizeof seen);
    const double begin = next;
    for (long k = 0; k < count; k++, next += period) {
        wire_sleep_until(next);
        const double woken = wire_seconds();
        for (; woken > next + period; passed++, next += period) {
            (void)OF(late)(loop, 1, told.inputs); /* the robot holds what it has */
        }
        if (wire_newest(s, &seen, sizeof seen) == 0) {
            missing++;
        } else {
            for (int i = 0; i < OF(SENSORS); i++) {
                if (!isnan(seen.values[i][0])) {
                    OF(measure)(loop, i, -1, seen.values[i]);
                }
            }
        }
        for (int i = 0; i < OF(HORIZON); i++) {
            path_at(circle, start, next - begin + OF(DELAY) * period + (i + 1) * OF(LOOK_AHEAD),
                    path[i]);
        }
        const int flags = OF(control)(loop, path[0], told.inputs);
        flagged += flags != 0;
        path_at(circle, start, next - begin + period, told.wish); /* when the robot reads it */
        told.sample = k + passed;
        told.wished = next - begin > 2 * approach;
        told.ends = k + 1 == count;
        send(s, &told, sizeof told, 0);
        const double answered = wire_seconds();
        OF(prepare)(loop);
        const double ready = wire_seconds();
        lengths[WAKE][k] = woken - next;
        lengths[ANSWER][k] = answered - woken;
        lengths[PREPARE][k] = ready - answered;
        lengths[ALL][k] = ready - next;
        late += ready > next + period;
    }
    printf("%ld periods of %g ms: %ld without a measurement, %ld with flags, ", count, 1e3 * period,
           missing, flagged);
    printf("%ld not done in time, %ld slept through\n", late, passed);
    for (int i = 0; i < OF(PARAMETERS); i++) {
        printf("found: parameter %d +- %.3g\n", i, OF(parameter_deviation)(loop, i));
    }
    for (int i = 0; i < OF(INPUTS); i++) {
        printf("%s %.4g\n", OF(input_names)[i], OF(inputs)(loop)[i]);
    }
    report(count, argv[7]);
    return 0;
}
