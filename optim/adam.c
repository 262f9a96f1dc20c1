/* Kingma & Ba, "Adam: a method for stochastic optimization", ICLR 2015, algorithm 1. */
#include "internal.h"

#include <math.h>
#include <string.h>

int optim_adam_parts(size_t count, const optim_settings *settings, optim_part *part)
{
    const optim_part own[] = {OPTIM_STATE(optim_adam, x, 1, count),
                              OPTIM_STATE(optim_adam, mean, 1, count),
                              OPTIM_ANY(optim_adam, square, 1, count, "square"),
                              OPTIM_STATE(optim_adam, best_x, 1, count),
                              OPTIM_WORK(optim_adam, gradient, 1, count),
                              OPTIM_WORK(optim_adam, next_x, 1, count),
                              OPTIM_ANY(optim_adam, scalar, 0, OPTIM_ADAM_SCALARS, "scalars")};
    (void)settings;
    return optim_parts_add(0, part, sizeof own / sizeof *own, own);
}

void optim_adam_begin(void *own, size_t count, const double *x, const optim_settings *settings)
{
    optim_adam *adam = own;
    adam->count = count;
    adam->settings = *settings;
    memcpy(adam->x, x, count * sizeof *x);
    memcpy(adam->best_x, x, count * sizeof *x);
    adam->scalar[OPTIM_ADAM_VALUE] = INFINITY;
    adam->scalar[OPTIM_ADAM_GRADIENT_NORM] = INFINITY;
    adam->scalar[OPTIM_ADAM_BEST_VALUE] = INFINITY;
}

static double next_mean(double beta1, double mean, double g)
{
    return beta1 * mean + (1 - beta1) * g;
}

static double next_square(double beta2, double square, double g)
{
    return beta2 * square + (1 - beta2) * g * g;
}

/* The new point comes first, and nothing is stored unless it is finite; only then are the moments
 * computed once more and kept. They are finite with the old ones and the squares of the gradient,
 * which optim_evaluate has seen to. */
static optim_status update(optim_adam *adam)
{
    const optim_settings *settings = &adam->settings;
    const double steps = adam->scalar[OPTIM_ADAM_STEPS] + 1;
    const double beta1 = settings->beta1;
    const double beta2 = settings->beta2;
    const double rate = optim_schedule_rate(settings, (int64_t)adam->scalar[OPTIM_ADAM_STEPS]);
    const double correction1 = 1 - pow(beta1, steps);
    const double correction2 = 1 - pow(beta2, steps);
    const double scale = optim_adam_clip(adam);
    const double *restrict gradient = adam->gradient;
    const double *restrict x = adam->x;
    double *restrict mean = adam->mean;
    double *restrict square = adam->square;
    double *restrict next_x = adam->next_x;
    for (size_t i = 0; i < adam->count; i++) {
        const double g = scale * gradient[i];
        const double m = next_mean(beta1, mean[i], g);
        const double v = next_square(beta2, square[i], g);
        next_x[i] = x[i] - rate * (m / correction1) / (sqrt(v / correction2) + settings->epsilon);
    }
    if (!optim_all_finite(adam->count, next_x)) {
        return OPTIM_NOT_FINITE;
    }
    for (size_t i = 0; i < adam->count; i++) {
        const double g = scale * gradient[i];
        mean[i] = next_mean(beta1, mean[i], g);
        square[i] = next_square(beta2, square[i], g);
    }
    memcpy(adam->x, next_x, adam->count * sizeof *next_x);
    adam->scalar[OPTIM_ADAM_STEPS] = steps;
    adam->scalar[OPTIM_ADAM_LEARNING_RATE] = rate;
    return OPTIM_RUNNING;
}

static const char *check_scalars(const optim_adam *adam)
{
    if (!optim_is_counter(adam->scalar[OPTIM_ADAM_STEPS], OPTIM_COUNTER_LIMIT) ||
        !optim_is_counter(adam->scalar[OPTIM_ADAM_EVALUATIONS], OPTIM_COUNTER_LIMIT)) {
        return "scalars: a counter is not an integer in [0, 2^53]";
    }
    if (isnan(adam->scalar[OPTIM_ADAM_BEST_VALUE])) {
        return "scalars: the best value is not a number";
    }
    return NULL;
}

optim_status optim_adam_evaluate(optim_adam *adam, const optim_target *target)
{
    if (check_scalars(adam)) {
        return OPTIM_BAD_STATE;
    }
    const optim_evaluator evaluator = {adam->count,
                                       target->objective,
                                       target->context,
                                       &adam->scalar[OPTIM_ADAM_EVALUATIONS],
                                       &adam->scalar[OPTIM_ADAM_BEST_VALUE],
                                       adam->best_x};
    double value = 0;
    const optim_status status = optim_evaluate(&evaluator, adam->x, &value, adam->gradient);
    if (status != OPTIM_RUNNING) {
        return status;
    }
    adam->scalar[OPTIM_ADAM_VALUE] = value;
    adam->scalar[OPTIM_ADAM_GRADIENT_NORM] =
        sqrt(optim_dot(adam->count, adam->gradient, adam->gradient));
    return optim_max_abs(adam->count, adam->gradient) <= adam->settings.gradient_tolerance
               ? OPTIM_GRADIENT_TOLERANCE
               : OPTIM_RUNNING;
}

double optim_adam_clip(const optim_adam *adam)
{
    const double most = adam->settings.clip_norm, norm = adam->scalar[OPTIM_ADAM_GRADIENT_NORM];
    return most > 0 && norm > most ? most / norm : 1;
}

/* ---- the method ---- */

static void defaults(optim_settings *settings)
{
    settings->gradient_tolerance = 0;
}

static optim_status step(void *own, const optim_target *target)
{
    const optim_status status = optim_adam_evaluate(own, target);
    return status == OPTIM_RUNNING ? update(own) : status;
}

void optim_adam_objective_changed(void *own)
{
    optim_adam *adam = own;
    adam->scalar[OPTIM_ADAM_BEST_VALUE] = INFINITY;
    memcpy(adam->best_x, adam->x, adam->count * sizeof *adam->x);
}

const double *optim_adam_x(const void *own)
{
    return ((const optim_adam *)own)->x;
}

const double *optim_adam_best_x(const void *own)
{
    return ((const optim_adam *)own)->best_x;
}

optim_info optim_adam_inspect(const void *own)
{
    const double *scalar = ((const optim_adam *)own)->scalar;
    return (optim_info){.steps = (int64_t)scalar[OPTIM_ADAM_STEPS],
                        .evaluations = (int64_t)scalar[OPTIM_ADAM_EVALUATIONS],
                        .value = scalar[OPTIM_ADAM_VALUE],
                        .gradient_norm = scalar[OPTIM_ADAM_GRADIENT_NORM],
                        .rate = scalar[OPTIM_ADAM_LEARNING_RATE],
                        .best_value = scalar[OPTIM_ADAM_BEST_VALUE]};
}

const char *optim_adam_state_check(const void *own)
{
    const optim_adam *adam = own;
    for (size_t i = 0; i < adam->count; i++) {
        if (!(adam->square[i] >= 0 && isfinite(adam->square[i]))) {
            return "square holds a number that is negative or not finite";
        }
    }
    return check_scalars(adam);
}

const optim_kind optim_adam_kind = {
    .about = "Adam",
    .needs = OPTIM_NEEDS_GRADIENTS,
    .reads = OPTIM_READS_RATE | OPTIM_READS_MEANS | OPTIM_READS_EPSILON,
    .defaults = defaults,
    .size = sizeof(optim_adam),
    .parts = optim_adam_parts,
    .begin = optim_adam_begin,
    .step = step,
    .objective_changed = optim_adam_objective_changed,
    .x = optim_adam_x,
    .best_x = optim_adam_best_x,
    .inspect = optim_adam_inspect,
    .state_check = optim_adam_state_check,
    .advice = "a smaller learning_rate, or clip_norm or warmup_steps"};
