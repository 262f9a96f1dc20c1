/* Strong Wolfe line search: Nocedal & Wright, Numerical Optimization, 2nd ed. 2006, algorithms 3.5
 * and 3.6 in one loop. `low` is the lowest point of sufficient decrease so far (at first the
 * origin); once a bracket is known, `high` is its other end and the slope at `low` points to it.
 * The rule that forces the bracket to shrink follows More & Thuente, ACM TOMS 20 (1994). */
#include "internal.h"

#include <float.h>
#include <math.h>
#include <string.h>

typedef struct bracket {
    optim_line_point low;
    optim_line_point high;     /* value is +infinity in effect when not finite */
    optim_line_point previous; /* the low before this one, for extrapolation */
    int closed;                /* whether high is set */
    double width[2];           /* of the last and the last but one bracket */
} bracket;

static void move_to(const optim_line *line, double step)
{
    const size_t count = line->evaluator->count;
    const double *restrict origin = line->origin;
    const double *restrict direction = line->direction;
    double *restrict x = line->x;
    for (size_t i = 0; i < count; i++) {
        x[i] = origin[i] + step * direction[i];
    }
}

static optim_status try_step(const optim_line *line, double step, optim_line_point *point)
{
    move_to(line, step);
    point->step = step;
    const optim_status status =
        optim_evaluate(line->evaluator, line->x, &point->value, line->gradient);
    point->slope = NAN;
    if (status == OPTIM_RUNNING) {
        point->slope = optim_dot(line->evaluator->count, line->gradient, line->direction);
    }
    point->finite = isfinite(point->slope);
    return status;
}

/* Armijo's condition, (3.6a) there. */
static int decreases(const optim_line *line, const optim_line_point *point)
{
    return point->finite &&
           point->value <= line->value + line->sufficient_decrease * point->step * line->slope;
}

static void update_bracket(const optim_line *line, bracket *b, const optim_line_point *point)
{
    if (!decreases(line, point) || point->value >= b->low.value) {
        b->high = *point;
        b->closed = 1;
        return;
    }
    const double towards_high = b->closed ? b->high.step - b->low.step : 1;
    if (point->slope * towards_high >= 0) {
        b->high = b->low;
        b->closed = 1;
    }
    b->previous = b->low;
    b->low = *point;
    memcpy(line->low_gradient, line->gradient, line->evaluator->count * sizeof(double));
}

/* Minimiser of the cubic through values and slopes of a and b, (3.59) there; NaN if none. */
static double cubic_minimiser(const optim_line_point *a, const optim_line_point *b)
{
    const double width = b->step - a->step;
    const double d1 = a->slope + b->slope - 3 * (a->value - b->value) / (a->step - b->step);
    const double d2 = copysign(sqrt(d1 * d1 - a->slope * b->slope), width);
    return b->step - width * (b->slope + d2 - d1) / (b->slope - a->slope + 2 * d2);
}

/* Beyond low: where the cubic through the last two points has its minimum, kept between 2.1 and
 * 11 times their distance from `previous`, so that the search neither crawls nor leaps. */
static double extrapolate(const optim_line *line, const bracket *b)
{
    const double width = b->low.step - b->previous.step;
    const double nearest = b->low.step + 1.1 * width;
    const double farthest = b->low.step + 10 * width;
    double step = cubic_minimiser(&b->previous, &b->low);
    if (!(step > b->low.step && step < farthest)) {
        step = farthest; /* no minimum ahead, or a NaN */
    }
    return fmin(fmax(step, nearest), line->maximum_step);
}

static double interpolate(bracket *b)
{
    const double width = b->high.step - b->low.step;
    const int slow = fabs(width) >= 0.66 * b->width[1];
    b->width[1] = b->width[0];
    b->width[0] = fabs(width);
    if (!b->high.finite) {
        /* Only the order of magnitude of the finite region is in question at first. */
        return b->low.step + (b->low.step > 0 ? 0.5 : 0.1) * width;
    }
    const double fraction = (cubic_minimiser(&b->low, &b->high) - b->low.step) / width;
    if (slow || !(fraction > 0 && fraction < 1)) {
        return b->low.step + 0.5 * width;
    }
    return b->low.step + fmin(fmax(fraction, 0.01), 0.99) * width;
}

static int collapsed(const bracket *b)
{
    const double size = fmax(b->high.step, b->low.step);
    return b->closed && fabs(b->high.step - b->low.step) <= 2 * DBL_EPSILON * size;
}

/* Put the trial point back to low, whose gradient was kept. */
static void return_to_low(const optim_line *line, const bracket *b, optim_line_point *chosen)
{
    move_to(line, b->low.step);
    memcpy(line->gradient, line->low_gradient, line->evaluator->count * sizeof(double));
    *chosen = b->low;
}

optim_line_result optim_line_search(const optim_line *line, double step, optim_line_point *chosen)
{
    const optim_line_point origin = {0, line->value, line->slope, 1};
    bracket b = {origin, origin, origin, 0, {INFINITY, INFINITY}};
    int any_finite = 0;
    for (int i = 0; i < line->maximum_evaluations && !collapsed(&b); i++) {
        optim_line_point point;
        if (try_step(line, step, &point) == OPTIM_STOPPED_BY_OBJECTIVE) {
            return OPTIM_LINE_STOPPED;
        }
        any_finite |= point.finite;
        if (decreases(line, &point) && fabs(point.slope) <= -line->curvature * line->slope) {
            *chosen = point;
            return OPTIM_LINE_WOLFE;
        }
        update_bracket(line, &b, &point);
        if (!b.closed && step >= line->maximum_step) {
            return_to_low(line, &b, chosen);
            return OPTIM_LINE_UNBOUNDED;
        }
        step = b.closed ? interpolate(&b) : extrapolate(line, &b);
    }
    if (b.low.step > 0) {
        return_to_low(line, &b, chosen);
        return OPTIM_LINE_DECREASE;
    }
    return any_finite ? OPTIM_LINE_FAILED : OPTIM_LINE_NO_FINITE;
}
