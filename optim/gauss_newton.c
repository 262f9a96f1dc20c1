/* Levenberg 1944, Marquardt 1963. Every step that lowers the value is taken, and the damping falls
 * after it: by the more, the closer the decrease comes to what the linear model predicts. It rises
 * by a small factor until a step lowers the value; that rising is slow and falling is fast is from
 * Transtrum & Sethna, "Improvements to the Levenberg-Marquardt algorithm for nonlinear
 * least-squares minimization", arXiv:1201.5885 (2012). For networks, rules that keep or raise the
 * damping after a step that was taken were measured to end far higher after equally many steps.
 *
 * Where the linear model has foretold nine tenths of what a step gained, the problem is nearly
 * linear, and the next step keeps J (the chord method: Kelley 1995, Iterative Methods for Linear
 * and Nonlinear Equations, ch. 5.4): only J^T r is computed, at a part of the cost. A point where
 * J^T r vanishes is the same by either. A step by an old J that gains less than that is not taken:
 * it was measured to spoil the next one. */
#include "internal.h"

#include <float.h>
#include <math.h>
#include <string.h>

/* Scalars live in one array of doubles so that the state is nothing but arrays. */
enum {
    EVALUATED, /* 1 when the value belongs to x */
    VALUE,
    DAMPING,      /* multiple of the scaling matrix; 0: not yet chosen */
    GRADIENT_MAX, /* at the start of the last step */
    STEP,         /* 2-norm of the last accepted step */
    ITERATIONS,
    EVALUATIONS,
    REJECTED,
    NOT_FINITE,
    UNSOLVED,
    SLOW,  /* steps in turn that gained no more than function_tolerance, and promised little */
    KEEPS, /* 1 when the next step keeps J as it is at the anchor */
    SCALAR_COUNT
};

enum { PATIENCE = 3 };

static const double GOOD_GAIN = 0.5, POOR_GAIN = 0.05;

/* Part of the promised decrease that a step brings at least for J to be kept. */
static const double NEARLY_LINEAR = 0.9;

/* Part of the value that the linear model promises to take away while the end is far: as a rule all
 * of it, and damped steps then gain little because the model does not hold, not because there is
 * nothing to gain. */
static const double PROMISING = 0.5;

/* Damping of which a step hardly takes notice, in its units. */
static const double HARDLY_DAMPED = 1e-12;

typedef struct optim_gauss_newton {
    optim_settings settings;
    size_t count;
    double *x;             /* [count] */
    double *jtr;           /* [count] */
    double *scale;         /* [count], diagonal of the scaling matrix */
    double *step;          /* [count], work */
    double *trial_x;       /* [count], work */
    double *anchor;        /* [count], where J was computed */
    double *anchor_before; /* [count], at the start of the step at hand */
    int has_model;        /* whether the model remembers that J: not after the state was restored */
    double unit;          /* of the damping at x: the largest diagonal entry, or 1 */
    double promised;      /* decrease that the model predicts for the step */
    double damped;        /* what the step was computed with */
    double gradient_norm; /* |2 J^T r| at the last model; not part of the state */
    double scalar[SCALAR_COUNT];
} optim_gauss_newton;

static int parts(size_t count, const optim_settings *settings, optim_part *part)
{
    const optim_part own[] = {OPTIM_STATE(optim_gauss_newton, x, 1, count),
                              OPTIM_WORK(optim_gauss_newton, jtr, 1, count),
                              OPTIM_WORK(optim_gauss_newton, scale, 1, count),
                              OPTIM_WORK(optim_gauss_newton, step, 1, count),
                              OPTIM_WORK(optim_gauss_newton, trial_x, 1, count),
                              OPTIM_STATE(optim_gauss_newton, anchor, 1, count),
                              OPTIM_WORK(optim_gauss_newton, anchor_before, 1, count),
                              OPTIM_ANY(optim_gauss_newton, scalar, 0, SCALAR_COUNT, "scalars")};
    (void)settings;
    return optim_parts_add(0, part, sizeof own / sizeof *own, own);
}

static const char *check(const optim_settings *settings)
{
    return settings->maximum_damping > settings->initial_damping
               ? NULL
               : "maximum_damping must be finite and > initial_damping";
}

static void objective_changed(void *own)
{
    optim_gauss_newton *gn = own;
    gn->scalar[EVALUATED] = gn->scalar[KEEPS] = 0;
    gn->scalar[VALUE] = INFINITY;
}

static void begin(void *own, size_t count, const double *x, const optim_settings *settings)
{
    optim_gauss_newton *gn = own;
    gn->count = count;
    gn->settings = *settings;
    memcpy(gn->x, x, count * sizeof *x);
    gn->scalar[GRADIENT_MAX] = INFINITY;
    gn->gradient_norm = NAN;
    objective_changed(gn);
}

/* ---- one step ---- */

static optim_status status_of(int code, double value)
{
    if (code == OPTIM_OBJECTIVE_NOT_FINITE) {
        return OPTIM_NOT_FINITE;
    }
    if (code != OPTIM_OBJECTIVE_OK) {
        return OPTIM_STOPPED_BY_OBJECTIVE;
    }
    return isfinite(value) ? OPTIM_RUNNING : OPTIM_NOT_FINITE;
}

static optim_status evaluate(optim_gauss_newton *gn, const optim_linear_model *model,
                             const double *x, double *value)
{
    *value = NAN; /* a model that forgets to write it must not pass */
    gn->scalar[EVALUATIONS] += 1;
    const int code = model->evaluate(model->context, x, value);
    return status_of(code, *value);
}

/* The diagonal of J^T J becomes that of the scaling matrix. */
static void choose_scale(optim_gauss_newton *gn)
{
    double largest = 0;
    for (size_t i = 0; i < gn->count; i++) {
        largest = fmax(largest, gn->scale[i]);
    }
    for (size_t i = 0; i < gn->count; i++) {
        gn->scale[i] = gn->settings.scaling == OPTIM_SCALING_IDENTITY
                           ? 1
                           : fmax(gn->scale[i], DBL_EPSILON * largest);
    }
    gn->unit = gn->settings.scaling == OPTIM_SCALING_IDENTITY ? largest : 1;
}

/* J, and so the scaling matrix, at the anchor; J^T r there. */
static optim_status make_model(optim_gauss_newton *gn, const optim_linear_model *model)
{
    double value = NAN;
    const int code = model->linearize(model->context, gn->anchor, &value, gn->jtr, gn->scale);
    const optim_status status = status_of(code, value);
    gn->has_model = status == OPTIM_RUNNING;
    if (gn->has_model && !optim_all_finite(gn->count, gn->scale)) {
        return OPTIM_NOT_FINITE;
    }
    choose_scale(gn);
    return status;
}

/* J^T r at x, by a new J or beside the one that is kept. */
static optim_status model_at_x(optim_gauss_newton *gn, const optim_linear_model *model)
{
    double value = NAN;
    gn->scalar[EVALUATIONS] += 1;
    if (gn->scalar[KEEPS] == 0 || !model->refresh) {
        gn->scalar[KEEPS] = 0;
        memcpy(gn->anchor, gn->x, gn->count * sizeof *gn->x);
        return make_model(gn, model);
    }
    const optim_status status = gn->has_model ? OPTIM_RUNNING : make_model(gn, model);
    if (status != OPTIM_RUNNING) {
        return status;
    }
    const int code = model->refresh(model->context, gn->x, &value, gn->jtr);
    return status_of(code, value);
}

/* The model at x, and what follows from it. */
static optim_status linearize(optim_gauss_newton *gn, const optim_linear_model *model)
{
    optim_status status = OPTIM_RUNNING;
    if (gn->scalar[EVALUATED] == 0) {
        status = evaluate(gn, model, gn->x, &gn->scalar[VALUE]);
    }
    if (status == OPTIM_RUNNING) {
        gn->scalar[EVALUATED] = 1;
        status = model_at_x(gn, model);
    }
    if (status != OPTIM_RUNNING) {
        return status;
    }
    gn->gradient_norm = 2 * sqrt(optim_dot(gn->count, gn->jtr, gn->jtr));
    if (!optim_all_finite(gn->count, gn->jtr)) {
        return OPTIM_NOT_FINITE;
    }
    gn->scalar[GRADIENT_MAX] = 2 * optim_max_abs(gn->count, gn->jtr);
    return gn->scalar[GRADIENT_MAX] <= gn->settings.gradient_tolerance ? OPTIM_GRADIENT_TOLERANCE
                                                                       : OPTIM_RUNNING;
}

static int raise_damping(optim_gauss_newton *gn)
{
    gn->scalar[DAMPING] *= gn->settings.damping_increase;
    return gn->scalar[DAMPING] <= gn->settings.maximum_damping * gn->unit;
}

/* What |r + J step|^2 lacks to |r|^2, by the equation that the step solves. */
static double predicted_decrease(const optim_gauss_newton *gn)
{
    double sum = -optim_dot(gn->count, gn->step, gn->jtr);
    for (size_t i = 0; i < gn->count; i++) {
        sum += gn->scalar[DAMPING] * gn->scale[i] * gn->step[i] * gn->step[i];
    }
    return sum;
}

static void lower_damping(optim_gauss_newton *gn, double decrease)
{
    const double gain = decrease / gn->promised;
    const double power = gain > GOOD_GAIN ? 1 : gain > POOR_GAIN ? 2.0 / 3 : 1.0 / 3;
    gn->scalar[DAMPING] *= pow(gn->settings.damping_decrease, power);
    gn->scalar[DAMPING] = fmax(gn->scalar[DAMPING], DBL_EPSILON * gn->unit);
}

/* Is hardly anything left to gain, so that a step is the last, whether or not rounding lets it
 * lower the value? */
static int promises_nothing(const optim_gauss_newton *gn, double value)
{
    return gn->damped <= HARDLY_DAMPED * gn->unit &&
           gn->promised <= gn->settings.function_tolerance * value;
}

static optim_status accept(optim_gauss_newton *gn, double value)
{
    const double change = gn->scalar[VALUE] - value, before = gn->scalar[VALUE];
    memcpy(gn->x, gn->trial_x, gn->count * sizeof *gn->x);
    gn->scalar[VALUE] = value;
    gn->scalar[STEP] = sqrt(optim_dot(gn->count, gn->step, gn->step));
    gn->scalar[ITERATIONS] += 1;
    const int slow =
        change <= gn->settings.function_tolerance * before && gn->promised <= PROMISING * before;
    gn->scalar[SLOW] = slow ? gn->scalar[SLOW] + 1 : 0;
    gn->scalar[KEEPS] = change >= NEARLY_LINEAR * gn->promised;
    if (change <= 0 || gn->scalar[SLOW] >= PATIENCE || promises_nothing(gn, before)) {
        return OPTIM_FUNCTION_TOLERANCE;
    }
    if (optim_max_abs(gn->count, gn->step) <=
        gn->settings.step_tolerance * optim_max_abs(gn->count, gn->x)) {
        return OPTIM_STEP_TOLERANCE;
    }
    return OPTIM_RUNNING;
}

typedef enum trial {
    TRIAL_ACCEPTED,
    TRIAL_REJECTED,
    TRIAL_LAST,
    TRIAL_NO_MOVE,
    TRIAL_STOPPED
} trial;

/* One damping: its step is tried. */
static trial try_damping(optim_gauss_newton *gn, const optim_linear_model *model, double *value)
{
    const int code = model->solve(model->context, gn->scalar[DAMPING], gn->scale, gn->step);
    if (code == OPTIM_OBJECTIVE_STOP) {
        return TRIAL_STOPPED;
    }
    if (code != 0 || !optim_all_finite(gn->count, gn->step)) {
        gn->scalar[UNSOLVED] += 1;
        return TRIAL_REJECTED;
    }
    int moved = 0;
    for (size_t i = 0; i < gn->count; i++) {
        gn->trial_x[i] = gn->x[i] + gn->step[i];
        moved = moved || gn->trial_x[i] != gn->x[i];
    }
    if (!moved) {
        return TRIAL_NO_MOVE;
    }
    gn->damped = gn->scalar[DAMPING];
    gn->promised = predicted_decrease(gn);
    const optim_status status = evaluate(gn, model, gn->trial_x, value);
    if (status == OPTIM_STOPPED_BY_OBJECTIVE) {
        return TRIAL_STOPPED;
    }
    const int by_old = gn->scalar[KEEPS] == 1, last = promises_nothing(gn, gn->scalar[VALUE]);
    if (by_old && !last && !(gn->scalar[VALUE] - *value >= NEARLY_LINEAR * gn->promised)) {
        return TRIAL_REJECTED;
    }
    if (status == OPTIM_RUNNING && *value < gn->scalar[VALUE]) {
        lower_damping(gn, gn->scalar[VALUE] - *value);
        return TRIAL_ACCEPTED;
    }
    gn->scalar[status == OPTIM_RUNNING ? REJECTED : NOT_FINITE] += 1;
    return last ? TRIAL_LAST : TRIAL_REJECTED;
}

static const char *check_scalars(const optim_gauss_newton *gn)
{
    static const int counters[] = {ITERATIONS, EVALUATIONS, REJECTED, NOT_FINITE, UNSOLVED, SLOW};
    const double *scalar = gn->scalar;
    for (size_t i = 0; i < sizeof counters / sizeof counters[0]; i++) {
        if (!optim_is_counter(scalar[counters[i]], OPTIM_COUNTER_LIMIT)) {
            return "scalars: a counter is not an integer in [0, 2^53]";
        }
    }
    if (!optim_is_counter(scalar[EVALUATED], 1) || !optim_is_counter(scalar[KEEPS], 1) ||
        (scalar[EVALUATED] > 0 && !isfinite(scalar[VALUE]))) {
        return "scalars: the value is not a number";
    }
    if (!(scalar[DAMPING] >= 0 && isfinite(scalar[DAMPING]))) {
        return "scalars: the damping is not a number";
    }
    return NULL;
}

static optim_status try_step(optim_gauss_newton *gn, const optim_linear_model *model)
{
    optim_status status = linearize(gn, model);
    if (status != OPTIM_RUNNING) {
        return status;
    }
    if (gn->scalar[DAMPING] == 0) {
        gn->scalar[DAMPING] = gn->settings.initial_damping * gn->unit;
    }
    const double start = gn->scalar[DAMPING], finite_before = gn->scalar[REJECTED];
    const double bad_before = gn->scalar[NOT_FINITE];
    double value = 0;
    trial result = try_damping(gn, model, &value);
    if (result == TRIAL_REJECTED && gn->scalar[KEEPS] == 1) { /* the old J is to blame */
        gn->scalar[KEEPS] = 0;
        status = linearize(gn, model);
        if (status != OPTIM_RUNNING) {
            return status;
        }
        result = try_damping(gn, model, &value);
    }
    while (result == TRIAL_REJECTED && raise_damping(gn)) {
        result = try_damping(gn, model, &value);
    }
    if (result == TRIAL_ACCEPTED) {
        return accept(gn, value);
    }
    gn->scalar[DAMPING] = start; /* a step may be called again */
    if (result == TRIAL_STOPPED) {
        return OPTIM_STOPPED_BY_OBJECTIVE;
    }
    if (result == TRIAL_LAST) {
        return OPTIM_FUNCTION_TOLERANCE;
    }
    const int none_finite =
        gn->scalar[REJECTED] == finite_before && gn->scalar[NOT_FINITE] > bad_before;
    return none_finite ? OPTIM_NO_FINITE_STEP : OPTIM_DAMPING_OVERFLOW;
}

/* A step that was stopped leaves the state as it was before. */
static optim_status step(void *own, const optim_target *target)
{
    optim_gauss_newton *gn = own;
    if (check_scalars(gn)) {
        return OPTIM_BAD_STATE;
    }
    double before[SCALAR_COUNT];
    memcpy(before, gn->scalar, sizeof before);
    memcpy(gn->anchor_before, gn->anchor, gn->count * sizeof *gn->anchor);
    const optim_status status = try_step(gn, target->model);
    if (status == OPTIM_STOPPED_BY_OBJECTIVE) {
        memcpy(gn->scalar, before, sizeof before);
        memcpy(gn->anchor, gn->anchor_before, gn->count * sizeof *gn->anchor);
        gn->has_model = 0;
    }
    return status;
}

/* ---- looking ---- */

static const double *current_x(const void *own)
{
    return ((const optim_gauss_newton *)own)->x;
}

static optim_info inspect(const void *own)
{
    const optim_gauss_newton *gn = own;
    const double *scalar = gn->scalar;
    return (optim_info){.steps = (int64_t)scalar[ITERATIONS],
                        .evaluations = (int64_t)scalar[EVALUATIONS],
                        .refused =
                            (int64_t)(scalar[REJECTED] + scalar[NOT_FINITE] + scalar[UNSOLVED]),
                        .rejected = (int64_t)scalar[REJECTED],
                        .not_finite = (int64_t)scalar[NOT_FINITE],
                        .unsolved = (int64_t)scalar[UNSOLVED],
                        .value = scalar[VALUE],
                        .best_value = scalar[VALUE],
                        .gradient_max = scalar[GRADIENT_MAX],
                        .gradient_norm = gn->gradient_norm,
                        .rate = scalar[DAMPING],
                        .step = scalar[STEP]};
}

static const char *state_check(const void *own)
{
    return check_scalars(own);
}

const optim_kind optim_gauss_newton_kind = {
    .about = "Levenberg-Marquardt",
    .needs = OPTIM_NEEDS_SQUARES,
    .reads = OPTIM_READS_TOLERANCES | OPTIM_READS_DAMPING,
    .size = sizeof(optim_gauss_newton),
    .parts = parts,
    .begin = begin,
    .step = step,
    .objective_changed = objective_changed,
    .x = current_x,
    .inspect = inspect,
    .state_check = state_check,
    .check = check,
    .advice = "more steps of adam before, or a larger initial_damping"};
