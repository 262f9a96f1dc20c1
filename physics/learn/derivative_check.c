#include "physics/learn/derivative_check.h"
#include "physics/learn/window_state.h"

#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

enum { STEPS = 8, SHIFTS = 7, ROWS_MAX = 4 };

/* Fractions of the range: long ones for slow functions, whose differences drown in rounding, short
 * ones for thousands of radians over the range. */
static const double step_sizes[STEPS] = {6e-3,   2e-3,   6.7e-4, 2.2e-4,
                                         7.4e-5, 2.5e-5, 8.2e-6, 2.7e-6};

/* Central difference of sixth order at shifts -3 .. 3. */
static const double difference_weights[SHIFTS] = {-1, 9, -45, 0, 45, -9, 1};

/* What is checked where. */
typedef struct derivative_task {
    const physics_model *model;
    int window;
    const double *start;
    const nn_mlp *mlp;
    const double *x;
    ad_pool *pool;
} derivative_task;

typedef struct derivative_program {
    ad_program *program;
    int rows;
    int by; /* the coordinate of the last differentiation */
} derivative_program;

/* The numbers of one check; `at[0]` owns everything. */
typedef struct derivative_batch {
    size_t points;
    double range;                       /* of the coordinate that is shifted */
    double *at[DOMAIN_COORDINATES_MAX]; /* [STEPS][SHIFTS][points] */
    double *lower, *derivative;         /* [ROWS_MAX][STEPS * SHIFTS * points] each */
} derivative_batch;

/* "r_sst", taken apart. */
typedef struct derivative_name {
    int field; /* of the model; -1: not such a name */
    int orders[DOMAIN_COORDINATES_MAX];
} derivative_name;

static derivative_name name_of(const physics_model *m, const char *text)
{
    size_t symbol = strcspn(text, "_");
    derivative_name name = {-1, {0}};
    if (strlen(text) >= DERIVATIVE_NAME_MAX || strlen(text) < symbol + 2) {
        return name;
    }
    const char *orders = text + symbol + 1;
    for (int i = 0; i < m->domain.count; i++) {
        const char *letter = m->domain.coordinates[i].name;
        for (; letter[1] == '\0' && *orders == letter[0]; orders++) {
            name.orders[i]++;
        }
    }
    for (int i = 0; i < m->field_count && *orders == '\0'; i++) {
        if (strlen(m->symbols[i]) == symbol && strncmp(m->symbols[i], text, symbol) == 0) {
            name.field = i;
        }
    }
    return name;
}

static ad_value differentiate(const physics_model *m, const domain_place *at, ad_value y,
                              const int *orders)
{
    for (int i = 0; i < m->domain.count; i++) {
        y = orders[i] ? ad_derivative(y, at->x[i], orders[i]) : y;
    }
    return y;
}

/* Outputs: the derivative, and the one that it is the derivative of. */
static ad_status record(const derivative_task *task, derivative_name name, derivative_program *made,
                        ad_error *error)
{
    const physics_model *m = task->model;
    ad_tape *tape = ad_tape_create();
    ad_value fields[MODEL_FIELDS_MAX], values[2];
    domain_place at = model_record(m, task->window, task->mlp, tape, fields);
    ad_value y = fields[name.field];
    values[0] = differentiate(m, &at, y, name.orders);
    for (int i = 0; i < m->domain.count; i++) {
        made->by = name.orders[i] ? i : made->by;
    }
    name.orders[made->by]--;
    values[1] = differentiate(m, &at, y, name.orders);
    made->rows = ad_rows(y);
    ad_status status = ad_compile(2, values, NULL, task->pool, &made->program, error);
    for (int i = 0; status == AD_OK && i < 2; i++) {
        if (ad_extent_of(values[i]) != AD_BATCH) {
            made->rows = 0; /* the same everywhere, whatever the network is: nothing to compare */
        }
    }
    ad_tape_free(tape);
    return status;
}

/* From where a coordinate goes how far; time over the window. */
static double range_of(const derivative_task *task, int coordinate, double *low)
{
    const domain *d = &task->model->domain;
    *low = d->coordinates[coordinate].low;
    if (coordinate != d->time) {
        return d->coordinates[coordinate].high - *low;
    }
    *low = domain_window_time(d, task->window);
    return domain_window_time(d, task->window + 1) - *low;
}

static ad_status make_batch(const derivative_task *task, size_t points, nn_rng *rng, int by,
                            derivative_batch *batch, ad_error *error)
{
    size_t shifted = (size_t)STEPS * SHIFTS * points;
    int count = task->model->domain.count;
    double *memory = calloc(((size_t)count + ROWS_MAX + ROWS_MAX) * shifted, sizeof *memory), low;
    if (!memory) {
        return ad_fail(error, AD_NO_MEMORY, "out of memory for %zu points", shifted);
    }
    batch->points = points;
    for (int c = 0; c < count; c++) {
        batch->at[c] = memory + (size_t)c * shifted;
    }
    batch->lower = memory + (size_t)count * shifted;
    batch->derivative = batch->lower + ROWS_MAX * shifted;
    for (size_t i = 0; i < points; i++) { /* no shift leaves the window */
        for (int c = 0; c < count; c++) {
            double range = range_of(task, c, &low), unit = nn_rng_between(rng, 0.02, 0.98);
            for (size_t k = i; k < shifted; k += points) {
                double shift =
                    step_sizes[k / points / SHIFTS] * ((double)(k / points % SHIFTS) - 3);
                batch->at[c][k] = low + range * (unit + (c == by ? shift : 0));
            }
        }
    }
    batch->range = range_of(task, by, &low);
    return AD_OK;
}

/* The difference at point i by one of the steps. */
static double difference(const derivative_batch *batch, int row, int step, size_t i)
{
    size_t shifted = (size_t)STEPS * SHIFTS * batch->points;
    double sum = 0;
    for (int k = 0; k < SHIFTS; k++) {
        size_t at = (size_t)(step * SHIFTS + k) * batch->points + i;
        sum += difference_weights[k] * batch->lower[(size_t)row * shifted + at];
    }
    return sum / (60 * step_sizes[step] * batch->range);
}

/* Where the shift is 0. */
static size_t center(const derivative_batch *batch, size_t i)
{
    return (SHIFTS / 2) * batch->points + i;
}

static double at_center(const derivative_batch *batch, const double *values, int row, size_t i)
{
    size_t shifted = (size_t)STEPS * SHIFTS * batch->points;
    return values[(size_t)row * shifted + center(batch, i)];
}

static void compare_point(const derivative_task *task, const derivative_batch *batch, int row,
                          size_t i, double scale, derivative_check *check)
{
    const domain *d = &task->model->domain;
    double derivative = at_center(batch, batch->derivative, row, i), best = INFINITY, closest = NAN;
    for (int step = 0; step < STEPS; step++) {
        double found = difference(batch, row, step, i);
        double off = fabs(found - derivative) / scale;
        if (off < best) {
            best = off;
            closest = found;
        }
    }
    if (best >= check->worst_error) {
        check->worst_error = best;
        check->worst_row = row;
        for (int c = 0; c < d->count; c++) {
            check->worst_at[c] = batch->at[c][center(batch, i)] * d->coordinates[c].scale;
        }
        check->worst_derivative = derivative;
        check->worst_difference = closest;
    }
}

static ad_status compare(const derivative_task *task, const derivative_program *made,
                         const derivative_batch *batch, derivative_check *check, ad_error *error)
{
    double scale = 1e-300;
    for (int row = 0; row < made->rows; row++) {
        for (size_t i = 0; i < batch->points; i++) {
            double derivative = at_center(batch, batch->derivative, row, i);
            if (!isfinite(derivative)) {
                const domain_coordinate *first = &task->model->domain.coordinates[0];
                return ad_fail(error, AD_NOT_FINITE, "%s is not finite at %s = %g %s", check->name,
                               first->name, batch->at[0][center(batch, i)] * first->scale,
                               first->unit);
            }
            scale = fmax(scale, fabs(derivative));
            scale = fmax(scale,
                         1e-6 * fabs(at_center(batch, batch->lower, row, i))); /* of its rounding */
        }
    }
    for (int row = 0; row < made->rows; row++) {
        for (size_t i = 0; i < batch->points; i++) {
            compare_point(task, batch, row, i, scale, check);
        }
    }
    return AD_OK;
}

static ad_status run(const derivative_task *task, const derivative_program *made,
                     derivative_batch *batch, derivative_check *check, ad_error *error)
{
    double *outputs[2] = {batch->derivative, batch->lower};
    const double *uniforms[DOMAIN_UNIFORMS_MAX];
    domain_uniforms kinds = model_uniforms(task->model, task->window);
    const domain_setting setting =
        domain_setting_of(&task->model->domain, task->window, task->start, 1);
    domain_list_uniforms(&kinds, &setting, uniforms);
    ad_run at = {.points = (size_t)STEPS * SHIFTS * batch->points,
                 .inputs = (const double *const *)batch->at,
                 .uniforms = uniforms,
                 .parameters = task->x,
                 .outputs = outputs};
    ad_status status = ad_execute(made->program, &at, error);
    return status == AD_OK ? compare(task, made, batch, check, error) : status;
}

static ad_status refuse(const physics_model *m, const char *name, size_t points, ad_error *error)
{
    char allowed[16 * MODEL_FIELDS_MAX] = "";
    size_t used = 0;
    for (int i = 0; i < m->field_count; i++) {
        used += (size_t)snprintf(allowed + used, sizeof allowed - used, "%s%s",
                                 i == 0                    ? ""
                                 : i + 1 == m->field_count ? " or "
                                                           : ", ",
                                 m->symbols[i]);
    }
    return ad_fail(error, AD_BAD_ARGUMENT,
                   "derivative %s of %zu points: allowed: %s, then _s, _ss, _t, ..., at one point "
                   "at least",
                   name, points, allowed);
}

ad_status derivative_check_run(const physics_model *m, int window, const double *start,
                               const nn_mlp *mlp, const double *x, const char *name, size_t points,
                               nn_rng *rng, ad_pool *pool, derivative_check *check, ad_error *error)
{
    const derivative_task task = {m, window, start, mlp, x, pool};
    derivative_program made = {NULL, 0, 0};
    derivative_batch batch = {.points = 0};
    *check = (derivative_check){.name = ""};
    derivative_name parts = name_of(m, name);
    if (parts.field < 0 || points == 0) {
        return refuse(m, name, points, error);
    }
    snprintf(check->name, sizeof check->name, "%s", name);
    ad_status status = record(&task, parts, &made, error);
    if (status == AD_OK && made.rows > 0) {
        status = make_batch(&task, points, rng, made.by, &batch, error);
    }
    if (status == AD_OK && made.rows > 0) {
        status = run(&task, &made, &batch, check, error);
    }
    ad_program_free(made.program);
    free(batch.at[0]);
    return status;
}
