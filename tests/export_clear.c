/* A family written by cpinn-export --wall as NAME.h, and with more places as FINE.h, compiled with
 * -DHEADER='"NAME.h"' -DNAME=NAME -DFINE_HEADER='"FINE.h"' -DFINE=FINE: what it says that members
 * keep from a box around them, beside the distances of all places of the fine shape.
 *   clear HALF_X HALF_Y LOW_Z HIGH_Z RADIUS FROM SLACK: never more, and no more than SLACK less */
#include HEADER
#include FINE_HEADER

#include <math.h>
#include <stdio.h>
#include <stdlib.h>

#define PASTE(a, b)  a##_##b
#define JOIN(a, b)   PASTE(a, b)
#define OF(what)     JOIN(NAME, what)
#define FINELY(what) JOIN(FINE, what)

enum { P = OF(PARAMETERS), MEMBERS = 500 };

/* Of a place from the box, negative outside of it. */
static double distance(const double *p, const double *box)
{
    const double low[3] = {-box[0], -box[1], box[2]}, high[3] = {box[0], box[1], box[3]};
    double inside = INFINITY, outside = 0;
    for (int i = 0; i < 3; i++) {
        const double off = fmax(fmax(low[i] - p[i], p[i] - high[i]), 0);
        outside += off * off;
        inside = fmin(inside, fmin(p[i] - low[i], high[i] - p[i]));
    }
    return outside > 0 ? -sqrt(outside) : inside;
}

int main(int argc, char **argv)
{
    static NUMBER memory[OF(MEMORY)], shape[OF(POINTS) * OF(COLUMNS)], coarse_p[P];
    static double fine_memory[FINELY(MEMORY)], fine[FINELY(POINTS) * FINELY(COLUMNS)], p[P];
    double box[7], least_slack = INFINITY, most_slack = 0;
    int touching = 0;
    for (int i = 0; i < 7; i++) {
        box[i] = argc == 8 ? atof(argv[1 + i]) : NAN;
    }
    for (int member = 0; member < MEMBERS; member++) {
        OF(answer) answer;
        double exact = INFINITY;
        for (int k = 0; k < P; k++) {
            const double part = member < 2 ? member : fmod(member * sqrt(2 * k + 3), 1);
            p[k] = OF(lower)[k] + part * (OF(upper)[k] - OF(lower)[k]);
            coarse_p[k] = (NUMBER)p[k];
        }
        OF(shape)(coarse_p, 2, shape, &answer, memory);
        FINELY(shape)(p, 2, fine, NULL, fine_memory);
        for (int k = 0; k < FINELY(POINTS); k++) {
            if (FINELY(places)[k] >= box[5]) {
                exact = fmin(exact, distance(fine + k * FINELY(COLUMNS), box) - box[4]);
            }
        }
        const double said = OF(clear)(shape, answer.left, HUGE_VAL);
        const double quick = OF(clear)(shape, answer.left, 0.003);
        if (said >= 0 && !(fabs(quick - fmin(said, 0.003)) <= 1e-15)) {
            printf("%.17g, where enough is known %.17g\n", said, quick);
            return 3;
        }
        touching += exact < 0;
        if (exact >= 0 || said >= 0) { /* it does not say how deep */
            least_slack = fmin(least_slack, exact - said);
            most_slack = fmax(most_slack, exact - said);
        }
    }
    printf("%d touch; %.3g to %.3g m less than there is\n", touching, least_slack, most_slack);
    if (!(least_slack >= -1e-7 && most_slack <= box[6]) || touching == 0 || touching == MEMBERS) {
        return 1;
    }
    shape[(OF(POINTS) - 1) * OF(COLUMNS)] = NAN;
    return OF(clear)(shape, 0, HUGE_VAL) == -HUGE_VAL ? 0 : 2;
}
