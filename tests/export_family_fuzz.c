/* A family written by export_family.h, compiled with -DHEADER='"NAME.h"' -DNAME=NAME,
 * -DNUMBER=double (or float), -DROUNDS=300 and the sanitizers: every function with what it does not
 * expect. It says what is wrong, answers what it can with finite numbers, and the same whatever was
 * in its memory. */
#include "export_fuzz.h"

#include HEADER

#include <limits.h>

#define PASTE(a, b) a##_##b
#define JOIN(a, b)  PASTE(a, b)
#define OF(what)    JOIN(NAME, what)

enum {
    P = OF(PARAMETERS),
    N = OF(WIDTH) * OF(NODES),
    COLUMNS = OF(COLUMNS),
    SHAPE = OF(POINTS) * OF(COLUMNS),
    SINGLE = sizeof(NUMBER) < sizeof(double)
};

/* Of one call of each function. */
typedef struct results {
    int status[6];
    NUMBER network[N], polished[N], shape[SHAPE], shape_of[SHAPE], tip[COLUMNS],
        jacobian[COLUMNS * P];
    NUMBER tip_again[COLUMNS], answers[4][6];
} results;

static NUMBER memory[OF(MEMORY)];

static int all_finite(int count, const NUMBER *list)
{
    for (int i = 0; i < count; i++) {
        if (!isfinite(list[i])) {
            return 0;
        }
    }
    return 1;
}

static void keep(const OF(answer) * from, NUMBER to[6])
{
    to[0] = from->predicted;
    to[1] = from->left;
    to[2] = from->ratio;
    to[3] = from->stable;
    to[4] = from->trusted;
    to[5] = from->why;
}

static void call(const NUMBER *p, const NUMBER *curvature, int steps, results *to)
{
    OF(answer) answer;
    memset(to, 0, sizeof *to);
    memcpy(to->polished, curvature, sizeof to->polished);
    fuzz_fill(memory, sizeof memory);
    to->status[0] = OF(network)(p, to->network, memory);
    fuzz_fill(memory, sizeof memory);
    to->status[1] = OF(polish)(p, steps, to->polished, &answer, memory);
    keep(&answer, to->answers[0]);
    fuzz_fill(memory, sizeof memory);
    to->status[2] = OF(shape_of)(p, curvature, to->shape_of, memory);
    fuzz_fill(memory, sizeof memory);
    to->status[3] = OF(shape)(p, steps, to->shape, &answer, memory);
    keep(&answer, to->answers[1]);
    fuzz_fill(memory, sizeof memory);
    to->status[4] = OF(tip)(p, steps, to->tip, NULL, memory);
    fuzz_fill(memory, sizeof memory);
    to->status[5] = OF(tip_jacobian)(p, steps, to->tip_again, to->jacobian, &answer, memory);
    keep(&answer, to->answers[2]);
}

static int is_beyond(const NUMBER *p)
{
    for (int i = 0; i < P; i++) {
        const NUMBER rounding = (OF(upper)[i] - OF(lower)[i]) * (NUMBER)(SINGLE ? 1e-6 : 1e-9);
        if (!(p[i] >= OF(lower)[i] - rounding && p[i] <= OF(upper)[i] + rounding)) {
            return 1;
        }
    }
    return 0;
}

static void check_answer(int status, const NUMBER *answer, int round)
{
    if (status & OF(SINGULAR)) {
        fuzz_require(answer[0] == HUGE_VAL && answer[1] == HUGE_VAL && answer[2] == -1 &&
                         answer[3] == 0 && answer[4] == 0 && answer[5] == OF(NOT_FINITE),
                     "an answer without a step is known", round);
    } else {
        fuzz_require(all_finite(5, answer) && answer[0] >= 0 && answer[1] >= 0,
                     "an answer is not finite, which nobody says", round);
    }
    fuzz_require((answer[4] == 1) == (answer[5] == 0), "trusted, and why not", round);
}

static void check(const NUMBER *p, const NUMBER *curvature, const results *x, int round)
{
    const int beyond = is_beyond(p) ? OF(OUT_OF_RANGE) : 0, given = all_finite(N, curvature);
    for (int i = 0; i < 6; i++) {
        const int may = i == 1 || i >= 3 ? OF(SINGULAR) : 0;
        fuzz_require((x->status[i] & ~may) == beyond, "a status is wrong", round);
    }
    fuzz_require(given || (x->status[1] & OF(SINGULAR)), "a curvature that is none is polished",
                 round);
    fuzz_require(!given || all_finite(N, x->polished), "a polished curvature is not finite", round);
    fuzz_require(all_finite(N, x->network), "the network is not finite", round);
    fuzz_require(all_finite(SHAPE, x->shape), "a shape is not finite", round);
    fuzz_require(all_finite(COLUMNS, x->tip), "a tip is not finite", round);
    fuzz_require(all_finite(COLUMNS, x->tip_again), "a tip is not finite", round);
    fuzz_require((x->status[5] & OF(SINGULAR)) || all_finite(COLUMNS * P, x->jacobian),
                 "derivatives are not finite, which nobody says", round);
    check_answer(x->status[1], x->answers[0], round);
    check_answer(x->status[3], x->answers[1], round);
}

int main(void)
{
    static const int steps[] = {0, 1, 2, 5, -1, INT_MIN};
    static results one, other;
    for (int round = 0; round < ROUNDS; round++) {
        NUMBER p[P], curvature[N];
        const int rare = round % 3 == 0 ? 1000000 : 3, k = steps[random_below(&fuzz_random, 6)];
        for (int i = 0; i < P; i++) {
            p[i] = (NUMBER)fuzz_number(OF(lower)[i], OF(upper)[i], rare);
        }
        for (int i = 0; i < N; i++) {
            curvature[i] = (NUMBER)fuzz_number(-3, 3, round % 2 ? 4 : 1000);
        }
        call(p, curvature, k, &one);
        call(p, curvature, k, &other);
        fuzz_require(memcmp(&one, &other, sizeof one) == 0,
                     "what was in the memory makes a difference", round);
        check(p, curvature, &one, round);
    }
    return fuzz_failures > 0;
}
