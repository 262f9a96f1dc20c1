/* Ranges of formulas between samples. */
#include "physics/scene/scene_internal.h"

#include <math.h>

enum { BOXES_MAX = 4000, STACK_MAX = 512 };

/* Of the range: what samples may be short of, as those next to an extreme are. */
static const double SLACK = 0.05;

typedef struct box {
    quantity_interval s, t;
} box;

/* Halves across the side that is the longer of its whole; false: none can be halved. */
static bool halve(const box *of, const box *whole, box halves[2])
{
    double s = of->s.high - of->s.low, t = of->t.high - of->t.low;
    bool along = s * (whole->t.high - whole->t.low) >= t * (whole->s.high - whole->s.low) && s > 0;
    const quantity_interval *side = along ? &of->s : &of->t;
    double at = quantity_middle(*side);
    halves[0] = halves[1] = *of;
    *(along ? &halves[0].s.high : &halves[0].t.high) = at;
    *(along ? &halves[1].s.low : &halves[1].t.low) = at;
    return side->low < at && at < side->high;
}

scene_range scene_range_between(quantity q, quantity_interval s, quantity_interval t,
                                scene_range sampled)
{
    const box whole = {quantity_depends_on(q, "s") ? s : (quantity_interval){s.low, s.low},
                       quantity_depends_on(q, "t") ? t : (quantity_interval){t.low, t.low}};
    double size = fmax(fabs(sampled.low), fabs(sampled.high));
    double slack = fmax(SLACK * (sampled.high - sampled.low), 1e-9 * size);
    box stack[STACK_MAX] = {whole};
    int count = isfinite(slack) ? 1 : 0;
    for (int looked = 0; count > 0 && looked < BOXES_MAX; looked++) {
        box now = stack[--count], halves[2];
        quantity_interval all = quantity_range(q, now.s, now.t);
        double value = quantity_value(q, quantity_middle(now.s), quantity_middle(now.t));
        if (value < sampled.low - slack || value > sampled.high + slack) {
            sampled.low = fmin(sampled.low, value);
            sampled.high = fmax(sampled.high, value);
        }
        bool within = all.low >= sampled.low - slack && all.high <= sampled.high + slack;
        if (!within && count + 2 <= STACK_MAX && halve(&now, &whole, halves)) {
            stack[count++] = halves[0];
            stack[count++] = halves[1];
        }
    }
    return sampled;
}
