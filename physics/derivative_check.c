#include "physics/derivative_check.h"

#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

enum { STEPS = 8, SHIFTS = 7, ROWS_MAX = 4 };

/* Fractions of the length or the window: long ones for slow functions, whose differences drown in
 * rounding, short ones for thousands of radians over the range. */
static const double step_sizes[STEPS] = {6e-3,   2e-3,   6.7e-4, 2.2e-4,
                                         7.4e-5, 2.5e-5, 8.2e-6, 2.7e-6};

/* Central difference of sixth order at shifts -3 .. 3. */
static const double difference_weights[SHIFTS] = {-1, 9, -45, 0, 45, -9, 1};

typedef struct derivative_program {
    ad_program *program;
    int rows;
    bool by_time; /* the last differentiation */
} derivative_program;

/* The numbers of one check; `s` owns everything. */
typedef struct derivative_batch {
    size_t points;
    double span;                /* of the window */
    double *s, *t;              /* [points] unshifted */
    double *at_s, *at_t;        /* [STEPS][SHIFTS][points] */
    double *lower, *derivative; /* [ROWS_MAX][STEPS * SHIFTS * points] each */
} derivative_batch;

/* "r_sst", taken apart. */
typedef struct derivative_name {
    int field; /* of the model; -1: not such a name */
    int s_count, t_count;
} derivative_name;

static derivative_name name_of(const scene *scene, const char *text)
{
    const char *const *fields = model_of(scene)->fields;
    size_t symbol = strcspn(text, "_");
    derivative_name name = {-1, 0, 0};
    if (strlen(text) >= DERIVATIVE_NAME_MAX || strlen(text) < symbol + 2) {
        return name;
    }
    const char *orders = text + symbol + 1;
    name.s_count = (int)strspn(orders, "s");
    name.t_count = (int)strspn(orders + name.s_count, "t");
    bool whole = orders[name.s_count + name.t_count] == '\0';
    for (int i = 0; i < MODEL_FIELDS && whole; i++) {
        if (strlen(fields[i]) == symbol && strncmp(fields[i], text, symbol) == 0) {
            name.field = scene_is_dynamic(scene) || name.t_count == 0 ? i : -1;
        }
    }
    return name;
}

static ad_value differentiate(ad_value y, ad_value s, ad_value t, int s_count, int t_count)
{
    y = s_count ? ad_derivative(y, s, s_count) : y;
    return t_count ? ad_derivative(y, t, t_count) : y;
}

/* Outputs: the derivative, and the one that it is the derivative of. */
static ad_status record(const scene *scene, const rod_window *window, const nn_mlp *mlp,
                        derivative_name name, ad_pool *pool, derivative_program *made,
                        ad_error *error)
{
    ad_tape *tape = ad_tape_create();
    if (!tape) {
        return ad_fail(error, AD_NO_MEMORY, "out of memory for a tape");
    }
    ad_value s = ad_input(tape, "s", 1), t = ad_input(tape, "t", 1);
    t = scene_is_dynamic(scene) ? t : ad_scalar(tape, 0);
    ad_value outputs = nn_mlp_record(mlp, rod_network_input(scene, window, s, t), 0);
    rod_state state = model_of(scene)->ansatz(scene, window, outputs, s, t);
    ad_value y =
        (ad_value[]){state.position, state.rotation, state.force, state.moment}[name.field];
    int s_count = name.s_count, t_count = name.t_count;
    made->by_time = t_count > 0;
    made->rows = ad_rows(y);
    ad_value values[2] = {differentiate(y, s, t, s_count, t_count),
                          differentiate(y, s, t, s_count - !t_count, t_count - (t_count > 0))};
    ad_status status = ad_compile(2, values, NULL, pool, &made->program, error);
    for (int i = 0; status == AD_OK && i < 2; i++) {
        if (ad_extent_of(values[i]) != AD_BATCH) {
            made->rows = 0; /* the same everywhere, whatever the network is: nothing to compare */
        }
    }
    ad_tape_free(tape);
    return status;
}

static ad_status make_batch(const scene *scene, const rod_window *window, size_t points,
                            nn_rng *rng, bool by_time, derivative_batch *batch, ad_error *error)
{
    size_t shifted = STEPS * SHIFTS * points;
    double start = rod_window_time(scene, window->index);
    double span = rod_window_time(scene, window->index + 1) - start;
    batch->points = points;
    batch->span = span;
    batch->s = calloc(2 * points + (2 + 2 * ROWS_MAX) * shifted, sizeof *batch->s);
    if (!batch->s) {
        return ad_fail(error, AD_NO_MEMORY, "out of memory for %zu points", shifted);
    }
    batch->t = batch->s + points;
    batch->at_s = batch->t + points;
    batch->at_t = batch->at_s + shifted;
    batch->lower = batch->at_t + shifted;
    batch->derivative = batch->lower + ROWS_MAX * shifted;
    for (size_t i = 0; i < points; i++) { /* no shift leaves the window */
        batch->s[i] = nn_rng_between(rng, 0.02, 0.98);
        batch->t[i] = span > 0 ? start + span * nn_rng_between(rng, 0.02, 0.98) : 0;
    }
    for (size_t k = 0; k < shifted; k++) {
        size_t i = k % points;
        double shift = step_sizes[k / points / SHIFTS] * ((double)(k / points % SHIFTS) - 3);
        batch->at_s[k] = batch->s[i] + (by_time ? 0 : shift);
        batch->at_t[k] = batch->t[i] + (by_time ? shift * span : 0);
    }
    return AD_OK;
}

/* The difference at point i by one of the steps. */
static double difference(const derivative_batch *batch, int row, int step, size_t i, double range)
{
    size_t shifted = STEPS * SHIFTS * batch->points;
    double sum = 0;
    for (int k = 0; k < SHIFTS; k++) {
        size_t at = (size_t)(step * SHIFTS + k) * batch->points + i;
        sum += difference_weights[k] * batch->lower[(size_t)row * shifted + at];
    }
    return sum / (60 * step_sizes[step] * range);
}

/* Where the shift is 0. */
static double at_center(const derivative_batch *batch, const double *values, int row, size_t i)
{
    size_t shifted = STEPS * SHIFTS * batch->points;
    return values[(size_t)row * shifted + (SHIFTS / 2) * batch->points + i];
}

static void compare_point(const derivative_batch *batch, int row, size_t i, double range,
                          double scale, const rod_scales *scales, derivative_check *check)
{
    double derivative = at_center(batch, batch->derivative, row, i), best = INFINITY, closest = NAN;
    for (int step = 0; step < STEPS; step++) {
        double found = difference(batch, row, step, i, range);
        double off = fabs(found - derivative) / scale;
        if (off < best) {
            best = off;
            closest = found;
        }
    }
    if (best >= check->worst_error) {
        check->worst_error = best;
        check->worst_row = row;
        check->worst_s = batch->s[i] * scales->length;
        check->worst_t = batch->t[i] * scales->time;
        check->worst_derivative = derivative;
        check->worst_difference = closest;
    }
}

static ad_status compare(const scene *scene, const derivative_program *made,
                         const derivative_batch *batch, derivative_check *check, ad_error *error)
{
    rod_scales scales = rod_scales_of(scene);
    double range = made->by_time ? batch->span : 1, scale = 1e-300;
    for (int row = 0; row < made->rows; row++) {
        for (size_t i = 0; i < batch->points; i++) {
            double derivative = at_center(batch, batch->derivative, row, i);
            if (!isfinite(derivative)) {
                return ad_fail(error, AD_NOT_FINITE, "%s is not finite at s = %g m, t = %g s",
                               check->name, batch->s[i] * scales.length, batch->t[i] * scales.time);
            }
            scale = fmax(scale, fabs(derivative));
            scale = fmax(scale,
                         1e-6 * fabs(at_center(batch, batch->lower, row, i))); /* of its rounding */
        }
    }
    for (int row = 0; row < made->rows; row++) {
        for (size_t i = 0; i < batch->points; i++) {
            compare_point(batch, row, i, range, scale, &scales, check);
        }
    }
    return AD_OK;
}

static ad_status run(const scene *scene, const double *x, const derivative_program *made,
                     derivative_batch *batch, derivative_check *check, ad_error *error)
{
    const double *inputs[2] = {batch->at_s, batch->at_t};
    double *outputs[2] = {batch->derivative, batch->lower};
    ad_run at = {.points = STEPS * SHIFTS * batch->points,
                 .inputs = inputs,
                 .parameters = x,
                 .outputs = outputs};
    ad_status status = ad_execute(made->program, &at, error);
    return status == AD_OK ? compare(scene, made, batch, check, error) : status;
}

ad_status derivative_check_run(const scene *scene, const rod_window *window, const nn_mlp *mlp,
                               const double *x, const char *name, size_t points, nn_rng *rng,
                               ad_pool *pool, derivative_check *check, ad_error *error)
{
    derivative_program made = {NULL, 0, false};
    derivative_batch batch = {.s = NULL};
    *check = (derivative_check){.name = ""};
    derivative_name parts = name_of(scene, name);
    if (parts.field < 0 || points == 0) {
        const char *const *fields = model_of(scene)->fields;
        return ad_fail(error, AD_BAD_ARGUMENT,
                       "derivative %s of %zu points: allowed: %s, %s, %s or %s, then _s, _ss, _t, "
                       "..., at one point at least",
                       name, points, fields[0], fields[1], fields[2], fields[3]);
    }
    snprintf(check->name, sizeof check->name, "%s", name);
    ad_status status = record(scene, window, mlp, parts, pool, &made, error);
    if (status == AD_OK && made.rows > 0) {
        status = make_batch(scene, window, points, rng, made.by_time, &batch, error);
    }
    if (status == AD_OK && made.rows > 0) {
        status = run(scene, x, &made, &batch, check, error);
    }
    ad_program_free(made.program);
    free(batch.s);
    return status;
}
