/* The time of a model that cpinn-export wrote, compiled with it and -DHEADER='"NAME.h"'
 * -DNAME=NAME, and -DNUMBER=float for one of these: us per point, one point at a time and in
 * batches, value and value with Jacobian; times of the processor, the least of several rounds. */
#include HEADER

#include <math.h>
#include <stdio.h>
#include <time.h>

#define PASTE(a, b) a##_##b
#define JOIN(a, b)  PASTE(a, b)
#define OF(what)    JOIN(NAME, what)

enum { MANY = 1000, ROUNDS = 30 };

static NUMBER in[MANY][OF(INPUTS)], out[MANY][OF(OUTPUTS)], memory[OF(MEMORY)];
static NUMBER jacobian[MANY][OF(OUTPUTS) * OF(INPUTS)];

static void value(void)
{
    for (int i = 0; i < MANY; i++) {
        OF(eval)(in[i], out[i], memory);
    }
}

static void value_batch(void)
{
    OF(eval_batch)(MANY, in[0], out[0], memory);
}

static void with_jacobian(void)
{
    for (int i = 0; i < MANY; i++) {
        OF(jacobian)(in[i], out[i], jacobian[i], memory);
    }
}

static void with_jacobian_batch(void)
{
    OF(jacobian_batch)(MANY, in[0], out[0], jacobian[0], memory);
}

static double time_of(void (*work)(void))
{
    double best = HUGE_VAL;
    for (int round = 0; round < ROUNDS; round++) {
        struct timespec begin, end;
        clock_gettime(CLOCK_THREAD_CPUTIME_ID, &begin);
        work();
        clock_gettime(CLOCK_THREAD_CPUTIME_ID, &end);
        best = fmin(best, (double)(end.tv_sec - begin.tv_sec) +
                              1e-9 * (double)(end.tv_nsec - begin.tv_nsec));
    }
    return 1e6 * best / MANY;
}

int main(void)
{
    for (int i = 0; i < MANY; i++) { /* a fixed walk over rod and duration */
        in[i][0] = (NUMBER)(OF(upper)[0] * fmod(0.618034 * i, 1));
        for (int c = 1; c < OF(INPUTS); c++) {
            in[i][c] = (NUMBER)(OF(upper)[c] * i / MANY);
        }
    }
    printf("%.3g %.3g %.3g %.3g\n", time_of(value), time_of(value_batch), time_of(with_jacobian),
           time_of(with_jacobian_batch));
    return 0;
}
