/* What an exported loop (cpinn-control --c) answers where something is wrong: the flag that its
 * header states, inputs that are finite and within their limits, and all well again after. With one
 * position as sensor and a delay of one sample; -DTRAINED=1: by a trained model, which knows
 * what it was made for. */
#include HEADER

#include <math.h>
#include <stdio.h>
#include <string.h>

#define JOIN_(a, b) a##_##b
#define JOIN(a, b)  JOIN_(a, b)
#define OF(name)    JOIN(NAME, name)

/* FAR: a filter that is far outside of what a trained model was made for. */
typedef enum fault {
    NONE,
    MISSING,
    NAN_SEEN,
    OLD,
    WILD,
    NO_SENSOR,
    LATE,
    HELD,
    PATH_NAN,
    PATH_INFINITE,
    NO_PATH,
    APPLIED_NAN,
    APPLIED_OUTSIDE,
    FAR,
    FAULTS
} fault;

enum { BEGIN = 40, SAMPLES = 400, OUTSIDE = 0x20040, AGAIN = 0x4000000 };

/* Flags that have to come, and how long the fault lasts. */
static const struct {
    const char *name;
    int flag, lasts;
} faults[FAULTS] = {[NONE] = {"none", 0, 0},
                    [MISSING] = {"missing", 0x1, 5},
                    [NAN_SEEN] = {"no number", 0x2, 5},
                    [OLD] = {"too old", 0x4, 5},
                    [WILD] = {"wild", 0x8, 3},
                    [NO_SENSOR] = {"no such sensor", 0x400, 1},
                    [LATE] = {"late", 0x2000000, 5},
                    [HELD] = {"late and held", 0x2000000, 5},
                    [PATH_NAN] = {"no wish", 0, 5},
                    [PATH_INFINITE] = {"infinite wish", 0x1000000, 5},
                    [NO_PATH] = {"path as before", 0, 5},
                    [APPLIED_NAN] = {"applied no number", 0, 1},
                    [APPLIED_OUTSIDE] = {"applied outside of limits", 0, 3},
                    [FAR] = {"outside of training", OUTSIDE | AGAIN, 3}};

static _Alignas(64) unsigned char memory[OF(MEMORY)], robot_memory[OF(MEMORY)];
static int bad;

static void fail(fault which, int k, const char *what)
{
    printf("%s, sample %d: %s\n", faults[which].name, k, what);
    bad = 1;
}

static int measure(OF(loop) * loop, fault which, const double *place)
{
    double seen[3];
    memcpy(seen, place, sizeof seen);
    seen[1] += which == WILD ? 0.05 : 0;
    seen[2] = which == NAN_SEEN ? NAN : seen[2];
    return which == MISSING     ? 0
           : which == OLD       ? OF(measure)(loop, 0, 1000, seen)
           : which == NO_SENSOR ? OF(measure)(loop, OF(SENSORS), -1, seen)
                                : OF(measure)(loop, 0, -1, seen);
}

static int control(OF(loop) * loop, fault which, double path[][3], double *inputs)
{
    for (int i = 0; i < OF(HORIZON); i++) {
        path[i][0] = which == PATH_NAN ? NAN : which == PATH_INFINITE ? INFINITY : path[i][0];
    }
    return which == LATE || which == HELD
               ? OF(late)(loop, which == HELD, inputs)
               : OF(control)(loop, which == NO_PATH ? NULL : path[0], inputs);
}

static void apply(OF(loop) * loop, fault which)
{
    double other[OF(CONTROLLED)];
    for (int i = 0; i < OF(CONTROLLED); i++) {
        other[i] = which == APPLIED_NAN ? NAN : 1e3 * OF(upper)[OF(controlled)[i]];
    }
    if (which == APPLIED_NAN || which == APPLIED_OUTSIDE) {
        OF(applied)(loop, other);
    }
}

/* The flag that a loop may end with: the innovations'. */
enum { USUAL = 0x100 };

/* Returns the place's distance from where it has to be at the end, m. */
static double run(fault which)
{
    OF(loop) *loop = OF(init)(memory, sizeof memory), *robot;
    double state[OF(STATES)], next[OF(STATES)], inputs[OF(INPUTS)], answer[OF(CONTROLLED)];
    double before[OF(CONTROLLED)], rest[3], place[3], path[OF(HORIZON)][3];
    int all = 0;
    robot = OF(init)(robot_memory, sizeof robot_memory);
    memcpy(state, OF(state)(loop), sizeof state);
    memcpy(inputs, OF(inputs)(loop), sizeof inputs);
    OF(place)(loop, state, rest, NULL);
    for (int k = 0; k < SAMPLES; k++) {
        const int now = k >= BEGIN && k < BEGIN + faults[which].lasts;
        const fault here = now ? which : NONE;
        int flags;
        if (now && which == FAR && k == BEGIN) {
            for (int i = 0; i < OF(STATES); i++) {
                next[i] = state[i] + 1e2;
            }
            OF(start)(loop, next, NULL);
        }
        for (int i = 0; i < OF(HORIZON); i++) {
            path[i][0] = rest[0] + 0.003;
            path[i][1] = rest[1];
            path[i][2] = NAN;
        }
        OF(place)(robot, state, place, NULL);
        flags = measure(loop, here, place);
        flags |= control(loop, here, path, answer);
        apply(loop, here);
        OF(prepare)(loop);
        all |= flags;
        if (now && (flags & faults[which].flag) != faults[which].flag && which != FAR) {
            fail(which, k, "the flag is not raised");
        }
        for (int i = 0; i < OF(CONTROLLED); i++) {
            const int input = OF(controlled)[i];
            if (!(answer[i] >= OF(lower)[input] && answer[i] <= OF(upper)[input])) {
                fail(which, k, "an input is not within its limits");
            }
            if (here == HELD && answer[i] != before[i]) {
                fail(which, k, "inputs are not held");
            }
            before[i] = answer[i];
        }
        if (OF(step)(robot, state, inputs, next, NULL, NULL)) {
            fail(which, k, "the robot has no next state");
        }
        memcpy(state, next, sizeof state);
        for (int i = 0; i < OF(CONTROLLED); i++) {
            inputs[OF(controlled)[i]] = answer[i];
        }
        if (k == SAMPLES - 1 && (flags & ~USUAL) != 0) {
            fail(which, k, "flags are left");
        }
    }
    if (which == FAR && TRAINED && (all & faults[FAR].flag) != faults[FAR].flag) {
        fail(which, BEGIN, "nobody says that the state is outside, and begins again");
    }
    OF(place)(robot, state, place, NULL);
    return hypot(place[0] - rest[0] - 0.003, place[1] - rest[1]);
}

int main(void)
{
    const double good = run(NONE);
    for (int i = NONE; i < FAULTS; i++) {
        const double off = run((fault)i);
        printf("%-26s %.3g mm off at the end\n", faults[i].name, 1e3 * off);
        if (!(off <= good + 5e-4)) { /* m, of 3 mm: but for what a filter keeps of it */
            fail((fault)i, SAMPLES, "the path is not found again");
        }
    }
    return bad;
}
