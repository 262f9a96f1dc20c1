/* An exported loop (cpinn-control --c), compiled with -DHEADER='"NAME.h"' -DNAME=NAME and the
 * sanitizers: every function with what it does not expect, between good samples. Inputs are finite
 * and within their limits all the time, what the filter knows is finite; after each burst the place
 * is found again, by good samples alone or after a start of their own. -DTRAINED as
 * export_loop_faults.c has it. */
#include "export_fuzz.h"

#include HEADER

#include <stdlib.h>

#define JOIN_(a, b) a##_##b
#define JOIN(a, b)  JOIN_(a, b)
#define OF(name)    JOIN(NAME, name)

enum {
    S = OF(STATES),
    U = OF(INPUTS),
    M = OF(CONTROLLED),
    H = OF(HORIZON),
    BURSTS = 6,
    BAD = 12,
    GOOD = 300
};

static _Alignas(64) unsigned char memory[OF(MEMORY)], robot_memory[OF(MEMORY)];
static OF(loop) * loop, *robot;
static double state[S], inputs[U], rest[3];

static void scatter(int count, double low, double high, double *to)
{
    for (int i = 0; i < count; i++) {
        to[i] = fuzz_number(low, high, 3);
    }
}

static void check_known(int round)
{
    fuzz_require(fuzz_finite(S, OF(state)(loop)) && fuzz_finite(U, OF(inputs)(loop)),
                 "what the filter knows is not finite", round);
    for (int i = 0; i < S; i++) {
        fuzz_require(isfinite(OF(state_deviation)(loop, i)), "a deviation is not finite", round);
    }
    for (int i = 0; i < OF(PARAMETERS); i++) {
        fuzz_require(isfinite(OF(parameter_deviation)(loop, i)), "a deviation is not finite",
                     round);
    }
}

static void check_answer(const double *answer, int round)
{
    for (int i = 0; i < M; i++) {
        const int at = OF(controlled)[i];
        fuzz_require(answer[i] >= OF(lower)[at] && answer[i] <= OF(upper)[at],
                     "an input is not within its limits", round);
    }
}

/* A call of one function, with anything; returns whether inputs were answered. */
static int call(int which, double *answer, int round)
{
    double any[U > S ? U : S], more[U], next[S], by_state[S * S], by_inputs[S * U], path[H][3];
    int most;
    scatter(U > S ? U : S, -10, 10, any);
    scatter(U, -10, 10, more);
    scatter(3 * H, -0.1, 0.1, path[0]);
    switch (which) {
    case 0: {
        const int sensor = random_below(&fuzz_random, OF(SENSORS) + 2) - 1;
        const int ages[] = {-1, 0, 1, 2, 1000, 2147483647, -2147483647 - 1};
        double seen[24];
        scatter(24, -0.2, 0.2, seen);
        OF(measure)(loop, sensor, ages[random_below(&fuzz_random, 7)], seen);
        return 0;
    }
    case 1:
        OF(control)(loop, random_below(&fuzz_random, 3) ? path[0] : NULL, answer);
        return 1;
    case 2:
        OF(late)(loop, random_below(&fuzz_random, 3) - 1, answer);
        return 1;
    case 3:
        OF(applied)(loop, any);
        return 0;
    case 4:
        OF(prepare)(loop);
        return 0;
    case 5: {
        const int flags = OF(start)(loop, random_below(&fuzz_random, 2) ? any : NULL,
                                    random_below(&fuzz_random, 2) ? more : NULL);
        fuzz_require(flags >= 0, "flags of a start", round);
        return 0;
    }
    case 6:
        if (OF(step)(loop, any, more, next, by_state, by_inputs) == 0) {
            fuzz_require(fuzz_finite(S, next), "a step is not finite, which nobody says", round);
        }
        return 0;
    case 7:
        OF(place)(loop, any, next, by_state);
        return 0;
    default:
        fuzz_require(OF(iterations)(loop, &most) <= most, "iterations", round);
        return 0;
    }
}

/* The robot is the model; its place is to be 3 mm beside where it rests. */
static double good_sample(double *answer, int round)
{
    double place[3], path[H][3], next[S];
    for (int i = 0; i < H; i++) {
        path[i][0] = rest[0] + 0.003;
        path[i][1] = rest[1];
        path[i][2] = NAN;
    }
    OF(place)(robot, state, place, NULL);
    OF(measure)(loop, 0, -1, place);
    OF(control)(loop, path[0], answer);
    OF(prepare)(loop);
    check_answer(answer, round);
    check_known(round);
    fuzz_require(OF(step)(robot, state, inputs, next, NULL, NULL) == 0, "the robot has no answer",
                 round);
    memcpy(state, next, sizeof state);
    for (int i = 0; i < M; i++) {
        inputs[OF(controlled)[i]] = answer[i];
    }
    return hypot(place[0] - rest[0] - 0.003, place[1] - rest[1]);
}

int main(void)
{
    double answer[M], off = 0;
    fuzz_fill(memory, sizeof memory);
    loop = OF(init)(memory, sizeof memory);
    robot = OF(init)(robot_memory, sizeof robot_memory);
    memcpy(state, OF(state)(loop), sizeof state);
    memcpy(inputs, OF(inputs)(loop), sizeof inputs);
    OF(place)(loop, state, rest, NULL);
    for (int k = 0; k < GOOD; k++) {
        off = good_sample(answer, -1);
    }
    const double good = off;
    for (int round = 0; round < BURSTS; round++) {
        for (int k = 0; k < BAD; k++) {
            if (call(random_below(&fuzz_random, 9), answer, round)) {
                check_answer(answer, round);
            }
            check_known(round);
        }
        if (round % 2) {
            fuzz_require(OF(start)(loop, NULL, NULL) == 0, "it does not start again", round);
        }
        for (int k = 0; k < GOOD; k++) {
            off = good_sample(answer, round);
        }
        /* m, of 3 mm: but for what a filter keeps of it */
        fuzz_require(off <= good + 5e-4, "the path is not found again", round);
    }
    return fuzz_failures > 0;
}
