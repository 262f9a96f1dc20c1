/* Descent along lines for the methods whose direction is -H gradient, with a model H of the inverse
 * Hessian: the strong Wolfe search and what follows when it fails, the pair (s, y) that a step
 * teaches, the criteria to stop. What differs between the methods is an optim_model. */
#include "internal.h"

#include <math.h>
#include <string.h>

const char *optim_descent_check(const optim_settings *settings)
{
    return settings->curvature > settings->sufficient_decrease
               ? NULL
               : "curvature must be in (sufficient_decrease, 1)";
}

/* ---- making ---- */

int optim_descent_parts(size_t count, int more, const optim_part *own, optim_part *part)
{
    const optim_part all[] = {OPTIM_STATE(optim_descent, x, 1, count),
                              OPTIM_ANY(optim_descent, gradient, 1, count, "gradient"),
                              OPTIM_STATE(optim_descent, best_x, 1, count),
                              OPTIM_WORK(optim_descent, direction, 1, count),
                              OPTIM_WORK(optim_descent, trial_x, 1, count),
                              OPTIM_WORK(optim_descent, trial_gradient, 1, count),
                              OPTIM_WORK(optim_descent, low_gradient, 1, count)};
    const optim_part scalars =
        OPTIM_ANY(optim_descent, scalar, 0, OPTIM_DESCENT_SCALARS, "scalars");
    int parts = optim_parts_add(0, part, sizeof all / sizeof *all, all);
    parts = optim_parts_add(parts, part, more, own);
    return optim_parts_add(parts, part, 1, &scalars);
}

void optim_descent_begin(optim_descent *d, size_t count, const double *x,
                         const optim_settings *settings, const optim_model *model)
{
    d->count = count;
    d->settings = *settings;
    d->model = model;
    memcpy(d->x, x, count * sizeof *x);
    optim_descent_objective_changed(d);
}

void optim_descent_objective_changed(void *own)
{
    optim_descent *d = own;
    d->scalar[OPTIM_PAIRS] = 0;
    d->scalar[OPTIM_EVALUATED] = 0;
    d->scalar[OPTIM_VALUE] = INFINITY;
    d->scalar[OPTIM_BEST_VALUE] = INFINITY;
    memcpy(d->best_x, d->x, d->count * sizeof *d->x);
}

/* ---- one step ---- */

static void find_direction(optim_descent *d)
{
    if (d->scalar[OPTIM_PAIRS] > 0) {
        d->model->apply(d, d->gradient, d->direction);
    } else {
        memcpy(d->direction, d->gradient, d->count * sizeof *d->direction);
    }
    for (size_t i = 0; i < d->count; i++) {
        d->direction[i] = -d->direction[i];
    }
}

/* A descent direction and its slope. Rounding can spoil the one from the model; then the model
 * goes, and what is left is steepest descent. */
static double find_descent(optim_descent *d)
{
    find_direction(d);
    double slope = optim_dot(d->count, d->gradient, d->direction);
    const int usable = slope < 0 && isfinite(optim_dot(d->count, d->direction, d->direction));
    if (d->scalar[OPTIM_PAIRS] > 0 && !(usable && isfinite(slope))) {
        d->scalar[OPTIM_PAIRS] = 0;
        d->scalar[OPTIM_RESETS] += 1;
        find_direction(d);
        slope = optim_dot(d->count, d->gradient, d->direction);
    }
    return slope;
}

static optim_line_result search(optim_descent *d, const optim_evaluator *evaluator,
                                optim_line_point *chosen)
{
    const double slope = find_descent(d);
    const double length = sqrt(optim_dot(d->count, d->direction, d->direction));
    const optim_line line = {.evaluator = evaluator,
                             .origin = d->x,
                             .direction = d->direction,
                             .value = d->scalar[OPTIM_VALUE],
                             .slope = slope,
                             .sufficient_decrease = d->settings.sufficient_decrease,
                             .curvature = d->settings.curvature,
                             .maximum_step = d->settings.maximum_step / length,
                             .maximum_evaluations = d->settings.maximum_line_evaluations,
                             .x = d->trial_x,
                             .gradient = d->trial_gradient,
                             .low_gradient = d->low_gradient};
    /* Without a model there is no scale: the first trial then has unit length. */
    const double first = d->scalar[OPTIM_PAIRS] > 0 ? 1 : 1 / length;
    return optim_line_search(&line, fmin(first, line.maximum_step), chosen);
}

/* Make the chosen point current. Leaves the step in direction. */
static void move(optim_descent *d, const optim_line_point *chosen)
{
    const size_t size = d->count * sizeof(double);
    for (size_t i = 0; i < d->count; i++) {
        d->direction[i] = d->trial_x[i] - d->x[i];
    }
    memcpy(d->x, d->trial_x, size);
    memcpy(d->gradient, d->trial_gradient, size);
    d->scalar[OPTIM_VALUE] = chosen->value;
    d->scalar[OPTIM_STEP] = chosen->step;
}

/* Hand the pair of the coming move from x to trial_x to the model, unless its curvature is too weak
 * to keep the matrix well positive definite. It is formed in work vectors. */
static void learn(optim_descent *d, const optim_line_point *chosen)
{
    const size_t count = d->count;
    double *s = d->direction;
    double *y = d->low_gradient;
    for (size_t i = 0; i < count; i++) {
        s[i] = d->trial_x[i] - d->x[i];
        y[i] = d->trial_gradient[i] - d->gradient[i];
    }
    const optim_pair pair = {.s = s,
                             .y = y,
                             .sy = optim_dot(count, s, y),
                             .ss = optim_dot(count, s, s),
                             .yy = optim_dot(count, y, y),
                             .sbs = -chosen->step * optim_dot(count, d->gradient, s),
                             .gradient = d->trial_gradient};
    const double gamma = pair.sy / pair.yy;
    const double threshold = d->settings.curvature_threshold * sqrt(pair.ss) * sqrt(pair.yy);
    if (!(pair.sy > threshold && pair.sy > 0 && isfinite(pair.sy) && isfinite(gamma) &&
          gamma > 0)) {
        d->scalar[OPTIM_SKIPPED] += 1;
        return;
    }
    d->model->learn(d, &pair);
}

static int is_stationary(const optim_descent *d)
{
    /* A squared norm that underflows to zero would leave the search without a slope. */
    return optim_max_abs(d->count, d->gradient) <= d->settings.gradient_tolerance ||
           optim_dot(d->count, d->gradient, d->gradient) == 0;
}

static optim_status accept(optim_descent *d, const optim_line_point *chosen)
{
    const double before = d->scalar[OPTIM_VALUE];
    const double change = fabs(before - chosen->value);
    learn(d, chosen);
    move(d, chosen);
    d->scalar[OPTIM_ITERATIONS] += 1;
    if (is_stationary(d)) {
        return OPTIM_GRADIENT_TOLERANCE;
    }
    if (change <= d->settings.function_tolerance * fmax(fabs(before), fabs(chosen->value))) {
        return OPTIM_FUNCTION_TOLERANCE;
    }
    if (optim_max_abs(d->count, d->direction) <=
        d->settings.step_tolerance * optim_max_abs(d->count, d->x)) {
        return OPTIM_STEP_TOLERANCE;
    }
    return OPTIM_RUNNING;
}

static optim_status iterate(optim_descent *d, const optim_evaluator *evaluator)
{
    optim_line_point chosen = {0};
    optim_line_result result = OPTIM_LINE_FAILED;
    for (int attempt = 0; attempt < 2; attempt++) {
        result = search(d, evaluator, &chosen);
        if (result == OPTIM_LINE_WOLFE) {
            return accept(d, &chosen);
        }
        if (result == OPTIM_LINE_STOPPED) {
            return OPTIM_STOPPED_BY_OBJECTIVE;
        }
        const int had_model = d->scalar[OPTIM_PAIRS] > 0;
        const int moved = result == OPTIM_LINE_DECREASE || result == OPTIM_LINE_UNBOUNDED;
        if (moved) {
            move(d, &chosen);
        }
        d->scalar[OPTIM_PAIRS] = 0;
        d->scalar[OPTIM_RESETS] += had_model;
        if (result == OPTIM_LINE_UNBOUNDED) {
            return OPTIM_UNBOUNDED;
        }
        if (moved && is_stationary(d)) {
            return OPTIM_GRADIENT_TOLERANCE;
        }
        if (!had_model && !moved) {
            break; /* the same search again would fail the same way */
        }
    }
    return result == OPTIM_LINE_NO_FINITE ? OPTIM_NO_FINITE_STEP : OPTIM_LINE_SEARCH_FAILED;
}

optim_status optim_descent_step(optim_descent *d, const optim_target *target)
{
    const optim_evaluator evaluator = {d->count,
                                       target->objective,
                                       target->context,
                                       &d->scalar[OPTIM_EVALUATIONS],
                                       &d->scalar[OPTIM_BEST_VALUE],
                                       d->best_x};
    if (d->scalar[OPTIM_EVALUATED] == 0) {
        double value = 0;
        const optim_status status = optim_evaluate(&evaluator, d->x, &value, d->gradient);
        if (status != OPTIM_RUNNING) {
            return status;
        }
        d->scalar[OPTIM_VALUE] = value;
        d->scalar[OPTIM_EVALUATED] = 1;
    }
    if (is_stationary(d)) {
        return OPTIM_GRADIENT_TOLERANCE;
    }
    return iterate(d, &evaluator);
}

/* ---- looking ---- */

const double *optim_descent_x(const void *own)
{
    return ((const optim_descent *)own)->x;
}

optim_info optim_descent_inspect(const void *own)
{
    const optim_descent *d = own;
    const double *scalar = d->scalar;
    const int evaluated = scalar[OPTIM_EVALUATED] > 0;
    return (optim_info){
        .steps = (int64_t)scalar[OPTIM_ITERATIONS],
        .evaluations = (int64_t)scalar[OPTIM_EVALUATIONS],
        .pairs = (int64_t)scalar[OPTIM_PAIRS],
        .skipped = (int64_t)scalar[OPTIM_SKIPPED],
        .resets = (int64_t)scalar[OPTIM_RESETS],
        .value = scalar[OPTIM_VALUE],
        .gradient_max = evaluated ? optim_max_abs(d->count, d->gradient) : INFINITY,
        .gradient_norm = evaluated ? sqrt(optim_dot(d->count, d->gradient, d->gradient)) : INFINITY,
        .rate = scalar[OPTIM_STEP],
        .best_value = scalar[OPTIM_BEST_VALUE]};
}

const char *optim_descent_check_scalars(const optim_descent *d, double pairs_max)
{
    static const int counters[] = {OPTIM_ITERATIONS, OPTIM_EVALUATIONS, OPTIM_SKIPPED,
                                   OPTIM_RESETS};
    const double *scalar = d->scalar;
    for (size_t i = 0; i < sizeof counters / sizeof counters[0]; i++) {
        if (!optim_is_counter(scalar[counters[i]], OPTIM_COUNTER_LIMIT)) {
            return "scalars: a counter is not an integer in [0, 2^53]";
        }
    }
    if (!optim_is_counter(scalar[OPTIM_EVALUATED], 1) ||
        (scalar[OPTIM_EVALUATED] > 0 && !isfinite(scalar[OPTIM_VALUE])) ||
        isnan(scalar[OPTIM_BEST_VALUE])) {
        return "scalars: the value is not a number";
    }
    if (scalar[OPTIM_EVALUATED] > 0 && !optim_all_finite(d->count, d->gradient)) {
        return "gradient holds a number that is not finite";
    }
    if (!optim_is_counter(scalar[OPTIM_PAIRS], pairs_max)) {
        return "scalars: the number of pairs is impossible";
    }
    return NULL;
}
