/* How long an exported loop (cpinn-control --c) with one sensor of the place takes, on its own
 * model with noise; on a circle about where it rests.
 *
 *   cc -std=c11 -O3 -march=native -DHEADER='"arm.h"' -DNAME=arm loop_time.c arm.c -lm -o time
 *   ./time 100000 */
#define _GNU_SOURCE
#include HEADER
#include "loop_wire.h"

#include <math.h>

#define JOIN_(a, b) a##_##b
#define JOIN(a, b)  JOIN_(a, b)
#define OF(name)    JOIN(NAME, name)

enum { SAMPLES_MAX = 1000000, PARTS = 4 };
static const char *const names[PARTS] = {"measures", "controls", "prepares", "all of a sample"};
static _Alignas(64) unsigned char memory[OF(MEMORY)], robot_memory[OF(MEMORY)];
static double lengths[PARTS][SAMPLES_MAX];

static double noise(void)
{
    return 3.4 * (rand() / (RAND_MAX + 1.0) - 0.5);
}

int main(int argc, char **argv)
{
    const long asked = argc > 1 ? atol(argv[1]) : 100000;
    const long count = asked < SAMPLES_MAX ? asked : SAMPLES_MAX;
    OF(loop) *loop = OF(init)(memory, sizeof memory);
    OF(loop) *robot = OF(init)(robot_memory, sizeof robot_memory);
    double state[OF(STATES)], next[OF(STATES)], inputs[OF(INPUTS)], answer[OF(CONTROLLED)];
    double rest[3], place[3], path[OF(HORIZON)][3];
    long failed = 0;
    memcpy(state, OF(state)(loop), sizeof state);
    memcpy(inputs, OF(inputs)(loop), sizeof inputs);
    OF(place)(loop, state, rest, NULL);
    wire_be_urgent(80);
    for (long k = 0; k < count; k++) {
        wire_sleep_until(wire_seconds() + 5e-5); /* urgent processes get 95 % of a second */
        OF(place)(robot, state, place, NULL);
        for (int i = 0; i < 3; i++) {
            place[i] += 2e-4 * noise();
        }
        for (int i = 0; i < OF(HORIZON); i++) {
            const double turn = M_PI * (OF(SAMPLE) * (double)k + OF(LOOK_AHEAD) * i);
            path[i][0] = rest[0] + 0.03 * sin(turn);
            path[i][1] = rest[1] + 0.03 * (1 - cos(turn)) - 0.03;
            path[i][2] = NAN;
        }
        double t[4] = {wire_seconds()};
        OF(measure)(loop, 0, -1, place);
        t[1] = wire_seconds();
        OF(control)(loop, path[0], answer);
        t[2] = wire_seconds();
        OF(prepare)(loop);
        t[3] = wire_seconds();
        for (int i = 0; i < 3; i++) {
            lengths[i][k] = t[i + 1] - t[i];
        }
        lengths[3][k] = t[3] - t[0];
        failed += OF(step)(robot, state, inputs, next, NULL, NULL) != 0;
        memcpy(state, next, sizeof state);
        for (int i = 0; i < OF(CONTROLLED); i++) { /* one sample later */
            inputs[OF(controlled)[i]] = answer[i];
        }
    }
    printf("%ld samples, %ld without a step of the model\n", count, failed);
    for (int i = 0; i < PARTS; i++) {
        wire_say(names[i], count, lengths[i]);
    }
    return failed > 0;
}
