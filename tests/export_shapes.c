/* A family written by cpinn-export as NAME.h, compiled with -DHEADER='"NAME.h"' -DNAME=NAME:
 * members all over the ranges and at their ends, with what each number of steps gives, as JSON:
 * [[steps, [parameters], predicted, left, why, [shape]], ...]. Fails where numbers on the way are
 * subnormal. */
#include HEADER

#include <math.h>
#include <stdio.h>

#define PASTE(a, b) a##_##b
#define JOIN(a, b)  PASTE(a, b)
#define OF(what)    JOIN(NAME, what)

enum { P = OF(PARAMETERS), SHAPE = OF(POINTS) * OF(COLUMNS), MEMBERS = 60 };

/* Numbers that are not finite become null. */
static void put(double value, const char *behind)
{
    if (isfinite(value)) {
        printf("%.17g%s", value, behind);
    } else {
        printf("null%s", behind);
    }
}

int main(void)
{
    static double memory[OF(MEMORY)], shape[SHAPE], p[P];
    int i, k, slow = 0;
    for (i = 0; i < 3 * MEMBERS; i++) {
        OF(answer) answer;
        const int steps = i % 3, member = i / 3;
        for (k = 0; k < P; k++) {
            const double part = member < 2 ? member : fmod(member * sqrt(2 * k + 3), 1);
            p[k] = OF(lower)[k] + part * (OF(upper)[k] - OF(lower)[k]);
        }
        OF(shape)(p, steps, shape, &answer, memory);
        for (k = 0; k < OF(MEMORY); k++) {
            slow += fpclassify(memory[k]) == FP_SUBNORMAL;
        }
        printf("%s[%d, [", i > 0 ? ",\n" : "[", steps);
        for (k = 0; k < P; k++) {
            put(p[k], k + 1 < P ? ", " : "], ");
        }
        put(answer.predicted, ", ");
        put(answer.left, ", ");
        printf("%d, [", answer.why);
        for (k = 0; k < SHAPE; k++) {
            put(shape[k], k + 1 < SHAPE ? ", " : "]]");
        }
    }
    printf("]\n");
    if (slow > 0) {
        fprintf(stderr, "%d subnormal numbers, with which processors are slow\n", slow);
    }
    return slow > 0;
}
