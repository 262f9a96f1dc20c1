/* Liu & Nocedal, "On the limited memory BFGS method for large scale optimization", Mathematical
 * Programming 45 (1989); Nocedal & Wright, Numerical Optimization, 2nd ed. 2006, algorithms 7.4
 * and 7.5. */
#include "internal.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

/* Scalars live in one array of doubles so that the state is nothing but arrays. */
enum {
    EVALUATED, /* 1 when value and gradient belong to x */
    VALUE,
    BEST_VALUE,
    STEP,
    GAMMA,     /* s.y / y.y of the newest pair */
    PAIRS,     /* pairs in the ring */
    NEXT_SLOT, /* slot of the ring to write next */
    ITERATIONS,
    EVALUATIONS,
    SKIPPED,
    RESETS,
    SCALAR_COUNT
};

struct optim_lbfgs {
    optim_lbfgs_settings settings;
    size_t count;
    double *x;              /* [count] */
    double *gradient;       /* [count], at x */
    double *best_x;         /* [count] */
    double *s;              /* [memory][count], steps */
    double *y;              /* [memory][count], gradient differences */
    double *sy;             /* [memory], s.y */
    double *direction;      /* [count], work */
    double *trial_x;        /* [count], work */
    double *trial_gradient; /* [count], work */
    double *low_gradient;   /* [count], work */
    double *weight;         /* [memory], work: alpha of algorithm 7.4 */
    double scalar[SCALAR_COUNT];
};

optim_lbfgs_settings optim_lbfgs_defaults(void)
{
    return (optim_lbfgs_settings){.memory = 50,
                                  .sufficient_decrease = 1e-4,
                                  .curvature = 0.9,
                                  .maximum_line_evaluations = 25,
                                  .maximum_step = 1e10,
                                  .gradient_tolerance = 1e-12,
                                  .function_tolerance = 0,
                                  .step_tolerance = 0,
                                  .curvature_threshold = 1e-12};
}

/* Conditions are written so that a NaN fails them. */
const char *optim_lbfgs_check(const optim_lbfgs_settings *settings)
{
    if (settings->memory < 1 || settings->memory > 1000) {
        return "memory must be in [1, 1000]";
    }
    if (!(settings->sufficient_decrease > 0 && settings->sufficient_decrease < 0.5)) {
        return "sufficient_decrease must be in (0, 0.5)";
    }
    if (!(settings->curvature > settings->sufficient_decrease && settings->curvature < 1)) {
        return "curvature must be in (sufficient_decrease, 1)";
    }
    if (settings->maximum_line_evaluations < 2 || settings->maximum_line_evaluations > 1000) {
        return "maximum_line_evaluations must be in [2, 1000]";
    }
    if (!(settings->maximum_step > 0 && isfinite(settings->maximum_step))) {
        return "maximum_step must be finite and > 0";
    }
    if (!(settings->curvature_threshold >= 0 && settings->curvature_threshold < 1)) {
        return "curvature_threshold must be in [0, 1)";
    }
    return optim_check_tolerances(settings->gradient_tolerance, settings->function_tolerance,
                                  settings->step_tolerance);
}

void optim_lbfgs_free(optim_lbfgs *lbfgs)
{
    if (lbfgs) {
        free(lbfgs->x);
        free(lbfgs->gradient);
        free(lbfgs->best_x);
        free(lbfgs->s);
        free(lbfgs->y);
        free(lbfgs->sy);
        free(lbfgs->direction);
        free(lbfgs->trial_x);
        free(lbfgs->trial_gradient);
        free(lbfgs->low_gradient);
        free(lbfgs->weight);
        free(lbfgs);
    }
}

static optim_lbfgs *allocate(size_t count, size_t memory)
{
    optim_lbfgs *lbfgs = calloc(1, sizeof *lbfgs);
    if (!lbfgs) {
        return NULL;
    }
    lbfgs->count = count;
    lbfgs->x = optim_vector_create(1, count);
    lbfgs->gradient = optim_vector_create(1, count);
    lbfgs->best_x = optim_vector_create(1, count);
    lbfgs->s = optim_vector_create(memory, count);
    lbfgs->y = optim_vector_create(memory, count);
    lbfgs->sy = optim_vector_create(1, memory);
    lbfgs->direction = optim_vector_create(1, count);
    lbfgs->trial_x = optim_vector_create(1, count);
    lbfgs->trial_gradient = optim_vector_create(1, count);
    lbfgs->low_gradient = optim_vector_create(1, count);
    lbfgs->weight = optim_vector_create(1, memory);
    if (!lbfgs->x || !lbfgs->gradient || !lbfgs->best_x || !lbfgs->s || !lbfgs->y || !lbfgs->sy ||
        !lbfgs->direction || !lbfgs->trial_x || !lbfgs->trial_gradient || !lbfgs->low_gradient ||
        !lbfgs->weight) {
        optim_lbfgs_free(lbfgs);
        return NULL;
    }
    return lbfgs;
}

optim_lbfgs *optim_lbfgs_create(size_t count, const double *x, const optim_lbfgs_settings *settings,
                                const char **why)
{
    const char *problem = optim_lbfgs_check(settings);
    optim_lbfgs *lbfgs = NULL;
    if (!problem && count == 0) {
        problem = "count must be >= 1";
    }
    if (!problem && !optim_all_finite(count, x)) {
        problem = "the starting point x must be finite";
    }
    if (!problem) {
        lbfgs = allocate(count, (size_t)settings->memory);
        problem = lbfgs ? NULL : "out of memory";
    }
    if (lbfgs) {
        lbfgs->settings = *settings;
        memcpy(lbfgs->x, x, count * sizeof *x);
        optim_lbfgs_objective_changed(lbfgs);
    }
    if (why) {
        *why = problem;
    }
    return lbfgs;
}

static void drop_history(optim_lbfgs *lbfgs)
{
    lbfgs->scalar[PAIRS] = 0;
    lbfgs->scalar[NEXT_SLOT] = 0;
}

void optim_lbfgs_objective_changed(optim_lbfgs *lbfgs)
{
    drop_history(lbfgs);
    lbfgs->scalar[EVALUATED] = 0;
    lbfgs->scalar[VALUE] = INFINITY;
    lbfgs->scalar[BEST_VALUE] = INFINITY;
    memcpy(lbfgs->best_x, lbfgs->x, lbfgs->count * sizeof *lbfgs->x);
}

/* a[count] += factor * b[count] */
static void add(size_t count, double *restrict a, double factor, const double *restrict b)
{
    for (size_t i = 0; i < count; i++) {
        a[i] += factor * b[i];
    }
}

/* direction = -H gradient by the two-loop recursion, algorithm 7.4. */
static void find_direction(optim_lbfgs *lbfgs)
{
    const size_t count = lbfgs->count;
    const size_t memory = (size_t)lbfgs->settings.memory;
    const size_t pairs = (size_t)lbfgs->scalar[PAIRS];
    const size_t next = (size_t)lbfgs->scalar[NEXT_SLOT];
    double *direction = lbfgs->direction;
    memcpy(direction, lbfgs->gradient, count * sizeof *direction);
    for (size_t age = 1; age <= pairs; age++) {
        const size_t slot = (next + memory - age) % memory;
        const double weight =
            optim_dot(count, lbfgs->s + slot * count, direction) / lbfgs->sy[slot];
        lbfgs->weight[slot] = weight;
        add(count, direction, -weight, lbfgs->y + slot * count);
    }
    const double gamma = pairs ? lbfgs->scalar[GAMMA] : 1;
    for (size_t i = 0; i < count; i++) {
        direction[i] *= gamma;
    }
    for (size_t age = pairs; age >= 1; age--) {
        const size_t slot = (next + memory - age) % memory;
        const double weight =
            optim_dot(count, lbfgs->y + slot * count, direction) / lbfgs->sy[slot];
        add(count, direction, lbfgs->weight[slot] - weight, lbfgs->s + slot * count);
    }
    for (size_t i = 0; i < count; i++) {
        direction[i] = -direction[i];
    }
}

/* A descent direction and its slope. Rounding can spoil the one from the history; then the history
 * goes, and what is left is steepest descent. */
static double find_descent(optim_lbfgs *lbfgs)
{
    find_direction(lbfgs);
    double slope = optim_dot(lbfgs->count, lbfgs->gradient, lbfgs->direction);
    const int usable =
        slope < 0 && isfinite(optim_dot(lbfgs->count, lbfgs->direction, lbfgs->direction));
    if (lbfgs->scalar[PAIRS] > 0 && !(usable && isfinite(slope))) {
        drop_history(lbfgs);
        lbfgs->scalar[RESETS] += 1;
        find_direction(lbfgs);
        slope = optim_dot(lbfgs->count, lbfgs->gradient, lbfgs->direction);
    }
    return slope;
}

static optim_line_result search(optim_lbfgs *lbfgs, const optim_evaluator *evaluator,
                                optim_line_point *chosen)
{
    const double slope = find_descent(lbfgs);
    const double length = sqrt(optim_dot(lbfgs->count, lbfgs->direction, lbfgs->direction));
    const optim_line line = {.evaluator = evaluator,
                             .origin = lbfgs->x,
                             .direction = lbfgs->direction,
                             .value = lbfgs->scalar[VALUE],
                             .slope = slope,
                             .sufficient_decrease = lbfgs->settings.sufficient_decrease,
                             .curvature = lbfgs->settings.curvature,
                             .maximum_step = lbfgs->settings.maximum_step / length,
                             .maximum_evaluations = lbfgs->settings.maximum_line_evaluations,
                             .x = lbfgs->trial_x,
                             .gradient = lbfgs->trial_gradient,
                             .low_gradient = lbfgs->low_gradient};
    /* Without a history there is no scale: the first trial then has unit length. */
    const double first = lbfgs->scalar[PAIRS] > 0 ? 1 : 1 / length;
    return optim_line_search(&line, fmin(first, line.maximum_step), chosen);
}

/* Make the chosen point current. Leaves the step in direction. */
static void move(optim_lbfgs *lbfgs, const optim_line_point *chosen)
{
    const size_t size = lbfgs->count * sizeof(double);
    for (size_t i = 0; i < lbfgs->count; i++) {
        lbfgs->direction[i] = lbfgs->trial_x[i] - lbfgs->x[i];
    }
    memcpy(lbfgs->x, lbfgs->trial_x, size);
    memcpy(lbfgs->gradient, lbfgs->trial_gradient, size);
    lbfgs->scalar[VALUE] = chosen->value;
    lbfgs->scalar[STEP] = chosen->step;
}

/* Store the pair of the coming move from x to trial_x, unless its curvature is too weak to keep
 * the matrix well positive definite. It is formed in work vectors, so that a dropped pair does not
 * cost the oldest slot of the ring. */
static void remember(optim_lbfgs *lbfgs)
{
    const size_t count = lbfgs->count;
    const size_t slot = (size_t)lbfgs->scalar[NEXT_SLOT];
    double *s = lbfgs->direction;
    double *y = lbfgs->low_gradient;
    for (size_t i = 0; i < count; i++) {
        s[i] = lbfgs->trial_x[i] - lbfgs->x[i];
        y[i] = lbfgs->trial_gradient[i] - lbfgs->gradient[i];
    }
    const double sy = optim_dot(count, s, y);
    const double ss = optim_dot(count, s, s);
    const double yy = optim_dot(count, y, y);
    const double gamma = sy / yy;
    const double threshold = lbfgs->settings.curvature_threshold * sqrt(ss) * sqrt(yy);
    if (!(sy > threshold && sy > 0 && isfinite(sy) && isfinite(gamma) && gamma > 0)) {
        lbfgs->scalar[SKIPPED] += 1;
        return;
    }
    memcpy(lbfgs->s + slot * count, s, count * sizeof *s);
    memcpy(lbfgs->y + slot * count, y, count * sizeof *y);
    lbfgs->sy[slot] = sy;
    lbfgs->scalar[GAMMA] = gamma;
    lbfgs->scalar[NEXT_SLOT] = (double)((slot + 1) % (size_t)lbfgs->settings.memory);
    lbfgs->scalar[PAIRS] = fmin(lbfgs->scalar[PAIRS] + 1, lbfgs->settings.memory);
}

static int is_stationary(const optim_lbfgs *lbfgs)
{
    /* A squared norm that underflows to zero would leave the search without a slope. */
    return optim_max_abs(lbfgs->count, lbfgs->gradient) <= lbfgs->settings.gradient_tolerance ||
           optim_dot(lbfgs->count, lbfgs->gradient, lbfgs->gradient) == 0;
}

static optim_status accept(optim_lbfgs *lbfgs, const optim_line_point *chosen)
{
    const optim_lbfgs_settings *settings = &lbfgs->settings;
    const double before = lbfgs->scalar[VALUE];
    const double change = fabs(before - chosen->value);
    remember(lbfgs);
    move(lbfgs, chosen);
    lbfgs->scalar[ITERATIONS] += 1;
    if (is_stationary(lbfgs)) {
        return OPTIM_GRADIENT_TOLERANCE;
    }
    if (change <= settings->function_tolerance * fmax(fabs(before), fabs(chosen->value))) {
        return OPTIM_FUNCTION_TOLERANCE;
    }
    if (optim_max_abs(lbfgs->count, lbfgs->direction) <=
        settings->step_tolerance * optim_max_abs(lbfgs->count, lbfgs->x)) {
        return OPTIM_STEP_TOLERANCE;
    }
    return OPTIM_RUNNING;
}

static optim_status iterate(optim_lbfgs *lbfgs, const optim_evaluator *evaluator)
{
    optim_line_point chosen = {0};
    optim_line_result result = OPTIM_LINE_FAILED;
    for (int attempt = 0; attempt < 2; attempt++) {
        result = search(lbfgs, evaluator, &chosen);
        if (result == OPTIM_LINE_WOLFE) {
            return accept(lbfgs, &chosen);
        }
        if (result == OPTIM_LINE_STOPPED) {
            return OPTIM_STOPPED_BY_OBJECTIVE;
        }
        const int had_history = lbfgs->scalar[PAIRS] > 0;
        const int moved = result == OPTIM_LINE_DECREASE || result == OPTIM_LINE_UNBOUNDED;
        if (moved) {
            move(lbfgs, &chosen);
        }
        drop_history(lbfgs);
        lbfgs->scalar[RESETS] += had_history;
        if (result == OPTIM_LINE_UNBOUNDED) {
            return OPTIM_UNBOUNDED;
        }
        if (moved && is_stationary(lbfgs)) {
            return OPTIM_GRADIENT_TOLERANCE;
        }
        if (!had_history && !moved) {
            break; /* the same search again would fail the same way */
        }
    }
    return result == OPTIM_LINE_NO_FINITE ? OPTIM_NO_FINITE_STEP : OPTIM_LINE_SEARCH_FAILED;
}

static const char *check_scalars(const optim_lbfgs *lbfgs)
{
    static const int counters[] = {ITERATIONS, EVALUATIONS, SKIPPED, RESETS};
    const double *scalar = lbfgs->scalar;
    for (size_t i = 0; i < sizeof counters / sizeof counters[0]; i++) {
        if (!optim_is_counter(scalar[counters[i]], OPTIM_COUNTER_LIMIT)) {
            return "scalars: a counter is not an integer in [0, 2^53]";
        }
    }
    if (!optim_is_counter(scalar[EVALUATED], 1) ||
        (scalar[EVALUATED] > 0 && !isfinite(scalar[VALUE])) || isnan(scalar[BEST_VALUE])) {
        return "scalars: the value is not a number";
    }
    if (!optim_is_counter(scalar[PAIRS], lbfgs->settings.memory) ||
        !optim_is_counter(scalar[NEXT_SLOT], lbfgs->settings.memory - 1)) {
        return "scalars: the number of pairs does not fit in memory";
    }
    if (scalar[PAIRS] > 0 && !(scalar[GAMMA] > 0 && isfinite(scalar[GAMMA]))) {
        return "scalars: the scale of the history is not positive";
    }
    return NULL;
}

optim_status optim_lbfgs_step(optim_lbfgs *lbfgs, optim_objective objective, void *context)
{
    if (check_scalars(lbfgs)) {
        return OPTIM_BAD_STATE;
    }
    const optim_evaluator evaluator = {
        lbfgs->count, objective, context, &lbfgs->scalar[EVALUATIONS], &lbfgs->scalar[BEST_VALUE],
        lbfgs->best_x};
    if (lbfgs->scalar[EVALUATED] == 0) {
        double value = 0;
        const optim_status status = optim_evaluate(&evaluator, lbfgs->x, &value, lbfgs->gradient);
        if (status != OPTIM_RUNNING) {
            return status;
        }
        lbfgs->scalar[VALUE] = value;
        lbfgs->scalar[EVALUATED] = 1;
    }
    if (is_stationary(lbfgs)) {
        return OPTIM_GRADIENT_TOLERANCE;
    }
    return iterate(lbfgs, &evaluator);
}

const double *optim_lbfgs_x(const optim_lbfgs *lbfgs)
{
    return lbfgs->x;
}

const double *optim_lbfgs_best_x(const optim_lbfgs *lbfgs)
{
    return lbfgs->best_x;
}

optim_lbfgs_info optim_lbfgs_get_info(const optim_lbfgs *lbfgs)
{
    const double *scalar = lbfgs->scalar;
    const double *gradient = lbfgs->gradient;
    const int evaluated = scalar[EVALUATED] > 0;
    return (optim_lbfgs_info){
        .iterations = (int64_t)scalar[ITERATIONS],
        .evaluations = (int64_t)scalar[EVALUATIONS],
        .pairs = (int64_t)scalar[PAIRS],
        .skipped = (int64_t)scalar[SKIPPED],
        .resets = (int64_t)scalar[RESETS],
        .value = scalar[VALUE],
        .gradient_max = evaluated ? optim_max_abs(lbfgs->count, gradient) : INFINITY,
        .gradient_norm = evaluated ? sqrt(optim_dot(lbfgs->count, gradient, gradient)) : INFINITY,
        .step = scalar[STEP],
        .best_value = scalar[BEST_VALUE]};
}

int optim_lbfgs_state(optim_lbfgs *lbfgs, optim_array *arrays, int capacity)
{
    const size_t memory = (size_t)lbfgs->settings.memory;
    const optim_array rows[] = {
        {"x", lbfgs->x, lbfgs->count},
        {"gradient", lbfgs->gradient, lbfgs->count},
        {"best_x", lbfgs->best_x, lbfgs->count},
        {"s", lbfgs->s, memory * lbfgs->count},
        {"y", lbfgs->y, memory * lbfgs->count},
        {"sy", lbfgs->sy, memory},
        {"scalars", lbfgs->scalar, SCALAR_COUNT},
    };
    return optim_copy_rows(arrays, capacity, rows, (int)(sizeof rows / sizeof rows[0]));
}

const char *optim_lbfgs_state_check(const optim_lbfgs *lbfgs)
{
    const size_t memory = (size_t)lbfgs->settings.memory;
    const char *problem = check_scalars(lbfgs);
    if (problem) {
        return problem;
    }
    if (!optim_all_finite(lbfgs->count, lbfgs->x)) {
        return "x holds a number that is not finite";
    }
    if (!optim_all_finite(lbfgs->count, lbfgs->gradient) && lbfgs->scalar[EVALUATED] > 0) {
        return "gradient holds a number that is not finite";
    }
    if (!optim_all_finite(lbfgs->count, lbfgs->best_x)) {
        return "best_x holds a number that is not finite";
    }
    if (!optim_all_finite(memory * lbfgs->count, lbfgs->s)) {
        return "s holds a number that is not finite";
    }
    if (!optim_all_finite(memory * lbfgs->count, lbfgs->y)) {
        return "y holds a number that is not finite";
    }
    for (size_t age = 1; age <= (size_t)lbfgs->scalar[PAIRS]; age++) {
        const double sy = lbfgs->sy[((size_t)lbfgs->scalar[NEXT_SLOT] + memory - age) % memory];
        if (!(sy > 0 && isfinite(sy))) {
            return "sy holds a number that is not finite and positive";
        }
    }
    return NULL;
}
