/* The time of a family that cpinn-export wrote, compiled with it and -DHEADER='"NAME.h"'
 * -DNAME=NAME, and -DNUMBER=float for one of these: us per member, one at a time: the shape of the
 * network alone, with its error, with one step and its error; the tip with one step; the tip's
 * derivatives. Times of the processor, the least of several rounds. */
#include HEADER

#include <math.h>
#include <stdio.h>
#include <time.h>

#define PASTE(a, b) a##_##b
#define JOIN(a, b)  PASTE(a, b)
#define OF(what)    JOIN(NAME, what)

enum { MANY = 200, ROUNDS = 20, KINDS = 5 };

static NUMBER in[MANY][OF(PARAMETERS)], shape[OF(POINTS)][OF(COLUMNS)], memory[OF(MEMORY)];
static NUMBER jacobian[OF(COLUMNS)][OF(PARAMETERS)];

static void work(int kind)
{
    for (int i = 0; i < MANY; i++) {
        OF(answer) answer;
        switch (kind) {
        case 0:
            OF(shape)(in[i], 0, shape[0], NULL, memory);
            break;
        case 1:
            OF(shape)(in[i], 0, shape[0], &answer, memory);
            break;
        case 2:
            OF(shape)(in[i], 1, shape[0], &answer, memory);
            break;
        case 3:
            OF(tip)(in[i], 1, shape[0], &answer, memory);
            break;
        default:
            OF(tip_jacobian)(in[i], 1, shape[0], jacobian[0], NULL, memory);
        }
    }
}

static double time_of(int kind)
{
    double best = HUGE_VAL;
    for (int round = 0; round < ROUNDS; round++) {
        struct timespec begin, end;
        clock_gettime(CLOCK_THREAD_CPUTIME_ID, &begin);
        work(kind);
        clock_gettime(CLOCK_THREAD_CPUTIME_ID, &end);
        best = fmin(best, (double)(end.tv_sec - begin.tv_sec) +
                              1e-9 * (double)(end.tv_nsec - begin.tv_nsec));
    }
    return 1e6 * best / MANY;
}

int main(void)
{
    for (int i = 0; i < MANY; i++) {
        for (int c = 0; c < OF(PARAMETERS); c++) {
            const double share = fmod((i + 1) * (0.618034 + 0.1 * c), 1);
            in[i][c] =
                (NUMBER)((double)OF(lower)[c] + share * (double)(OF(upper)[c] - OF(lower)[c]));
        }
    }
    for (int kind = 0; kind < KINDS; kind++) {
        printf("%s%.3g", kind ? " " : "", time_of(kind));
    }
    printf("\n");
    return 0;
}
