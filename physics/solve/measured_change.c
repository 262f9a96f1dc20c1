/* How residuals change with the unknowns. By members they do as the shapes at equilibrium do, by
 * the implicit function theorem; experiments that members do not solve are solved beside. */
#include "physics/solve/measured_trials.h"

#include "physics/numerics/quaternion.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

enum { CHANGE_BYTES = 64 << 20 /* of the derivatives of one batch */ };

/* Rows are compared in closed form, of which differences of fourth order are exact but for
 * rounding: so much of a range to both sides, and twice. */
static const double BESIDE = 1e-3;

typedef struct change {
    solve_trials *x;
    const double *values;
    const double *ends;      /* [unknowns][2] */
    const double *residuals; /* at the values */
    double *room;            /* [2 unknowns][residuals] */
    double *jacobian;        /* [unknowns][residuals] */
} change;

/* ---- by members ---------------------------------------------------------------------------- */

/* Of a row's residuals by the parameter `unknown`, by which the columns change as `by`, each
 * `stride` numbers after the one before, and what is seen of them by itself. */
static void compare_change(const change *c, const measured_row *row, const double *parameters,
                           int unknown, const double *columns, const double *by, size_t stride,
                           double *to)
{
    static const double WEIGHT[4] = {1.0 / 12, -8.0 / 12, 8.0 / 12, -1.0 / 12};
    static const int AT[4] = {-2, -1, 1, 2};
    double beside[MODEL_COLUMNS_MAX], residuals[MODEL_COLUMNS_MAX];
    double moved[SCENE_PARAMETERS_MAX];
    const size_t count = solve_trials_row_residuals(c->x, row);
    const double step =
        BESIDE * scene_parameter_slope(&c->x->open.parameters[unknown], parameters[unknown]);
    memset(to, 0, count * sizeof *to);
    memcpy(moved, parameters, (size_t)c->x->open.parameter_count * sizeof *moved);
    for (int k = 0; k < 4; k++) {
        for (int i = 0; i < c->x->columns; i++) {
            beside[i] = columns[i] + AT[k] * step * by[(size_t)i * stride];
        }
        moved[unknown] = parameters[unknown] + AT[k] * step;
        solve_trials_compare(c->x, row, moved, beside, 1, residuals);
        for (size_t i = 0; i < count; i++) {
            to[i] += WEIGHT[k] / step * residuals[i];
        }
    }
}

/* The parameter from which on derivatives are looked at: states of inputs with a memory, which are
 * among those that are known, change with the unknowns. */
static int first_of(const solve_trials *x)
{
    return x->inputs ? 0 : scene_known_count(&x->open);
}

static size_t width_of(const solve_trials *x)
{
    return (size_t)(x->open.parameter_count - first_of(x));
}

static void put_rows(const change *c, size_t experiment, const double *parameters,
                     const double *shapes, const double *by)
{
    const solve_trials *x = c->x;
    const size_t unknowns = (size_t)x->unknowns, width = width_of(x);
    const size_t known = (size_t)scene_known_count(&x->open);
    for (size_t r = x->first[experiment]; r < x->first[experiment + 1]; r++) {
        const measured_row *row = &x->row[r];
        const size_t first = row->place * SOLVE_MEMBERS_COLUMNS;
        for (size_t i = 0; i < unknowns; i++) {
            double all[SOLVE_MEMBERS_COLUMNS];
            for (size_t k = 0; k < SOLVE_MEMBERS_COLUMNS; k++) {
                const double *column = by + (first + k) * width;
                all[k] = x->inputs ? trial_memory_change(x->inputs, row->turn, known + i, column)
                                   : column[i];
            }
            compare_change(c, row, parameters, (int)(known + i), shapes + first, all, 1,
                           c->jacobian + i * x->residuals + row->residual);
        }
    }
}

static ad_status change_members(const change *c, size_t first, size_t count, double *room,
                                ad_error *error)
{
    const solve_trials *x = c->x;
    const size_t width = (size_t)x->open.parameter_count,
                 numbers = solve_members_numbers(x->members);
    const size_t shape = x->places * SOLVE_MEMBERS_COLUMNS;
    const double *curvature = x->curvature + first * numbers;
    double *shapes = room + count * width, *by = shapes + count * shape;
    for (size_t i = 0; i < count; i++) {
        solve_trials_fill(x, c->values, (first + i) * x->every, room + i * width);
    }
    ad_status status =
        solve_members_refine(x->members, count, room, curvature, 0, shapes, NULL, NULL, error);
    status = status == AD_OK ? solve_members_jacobian(x->members, count, room, curvature,
                                                      first_of(x), by, error)
                             : status;
    for (size_t i = 0; status == AD_OK && i < count; i++) {
        put_rows(c, (first + i) * x->every, room + i * width, shapes + i * shape,
                 by + i * shape * width_of(x));
    }
    return status;
}

static ad_status change_all_members(const change *c, ad_error *error)
{
    const solve_trials *x = c->x;
    const size_t width = (size_t)x->open.parameter_count, count = solve_trials_counted(x);
    const size_t each = width + x->places * SOLVE_MEMBERS_COLUMNS * (1 + width_of(x));
    size_t most = CHANGE_BYTES / (each * sizeof(double));
    most = most < 1 ? 1 : most > count ? count : most;
    double *room = malloc(most * each * sizeof *room);
    ad_status status =
        room ? AD_OK
             : ad_fail(error, AD_NO_MEMORY, "out of memory for derivatives of %zu members", most);
    for (size_t first = 0; status == AD_OK && first < count; first += most) {
        const size_t left = count - first;
        status = change_members(c, first, left < most ? left : most, room, error);
    }
    free(room);
    return status;
}

/* ---- by recordings ------------------------------------------------------------------------- */

typedef struct change_jobs {
    const change *c;
    ad_status *status; /* [experiments] */
    ad_error *error;
} change_jobs;

typedef struct change_rows {
    const change *c;
    const double *parameters; /* of an experiment */
} change_rows;

/* By how much later the rod is looked at, by a parameter; 0 before its motion begins. */
static double time_change(const change_rows *rows, const measured_row *row, int parameter)
{
    const scene *open = &rows->c->x->open;
    double moved[SCENE_PARAMETERS_MAX], t[2];
    if (!row->view ||
        !quantity_depends_on(row->view->of->delay, open->parameters[parameter].name)) {
        return 0;
    }
    const double step =
        BESIDE * scene_parameter_slope(&open->parameters[parameter], rows->parameters[parameter]);
    memcpy(moved, rows->parameters, (size_t)open->parameter_count * sizeof *moved);
    for (int k = 0; k < 2; k++) {
        moved[parameter] = rows->parameters[parameter] + (k ? step : -step);
        t[k] = solve_trials_time(rows->c->x, row, moved);
    }
    return (t[1] - t[0]) / (2 * step);
}

/* The change of position and rotation with time is added, `by` so much of it. */
static void add_motion(const scene *open, const double *columns, size_t stride, double by,
                       double *change_of)
{
    const size_t velocity = solve_velocity_column(open);
    double q[4], turn[3], rate[4];
    for (size_t i = 0; i < 3; i++) {
        change_of[i] += by * columns[(velocity + i) * stride];
        turn[i] = columns[(velocity + 3 + i) * stride] / 2;
    }
    for (size_t i = 0; i < 4; i++) {
        q[i] = columns[(3 + i) * stride];
    }
    quaternion_times_vector(q, turn, rate); /* angular velocities are those of the section */
    for (size_t i = 0; i < 4; i++) {
        change_of[3 + i] += by * rate[i];
    }
}

static void take_change(void *context, const measured_row *row, const double *columns,
                        const double *change_of, size_t width, size_t stride)
{
    const change_rows *rows = context;
    const solve_trials *x = rows->c->x;
    const int known = scene_known_count(&x->open);
    double now[MODEL_COLUMNS_MAX], by[MODEL_COLUMNS_MAX] = {0};
    for (int k = 0; k < x->columns; k++) {
        now[k] = columns[(size_t)k * stride];
    }
    for (size_t i = 0; i < (size_t)x->unknowns; i++) {
        const double later = time_change(rows, row, known + (int)i);
        for (int k = 0; k < x->columns; k++) {
            by[k] = change_of[i * width + (size_t)k * stride];
        }
        if (later != 0) {
            add_motion(&x->open, columns, stride, later, by);
        }
        compare_change(rows->c, row, rows->parameters, known + (int)i, now, by, 1,
                       rows->c->jacobian + i * x->residuals + row->residual);
    }
}

static void change_recording(void *context, int item, int thread)
{
    const change_jobs *jobs = context;
    solve_trials *x = jobs->c->x;
    double parameters[SCENE_PARAMETERS_MAX];
    if (x->row[x->first[item]].inputs && (size_t)item % x->every == 0) {
        solve_trials_fill(x, jobs->c->values, (size_t)item, parameters);
        change_rows rows = {jobs->c, parameters};
        jobs->status[item] = solve_trials_follow_change(x, (size_t)item, thread, parameters,
                                                        take_change, &rows, &jobs->error[item]);
    }
}

/* Where there is no answer nothing is changed, and differences are tried. */
static ad_status change_recordings(const change *c, ad_error *error)
{
    const size_t count = c->x->experiments;
    change_jobs jobs = {c, calloc(count, sizeof(ad_status)), calloc(count, sizeof(ad_error))};
    ad_status status = jobs.status && jobs.error
                           ? AD_OK
                           : ad_fail(error, AD_NO_MEMORY, "out of memory for %zu motions", count);
    if (status == AD_OK) {
        ad_pool_run(c->x->pool, (int)count, change_recording, &jobs);
    }
    for (size_t i = 0; i < count && status == AD_OK; i++) {
        status = jobs.status[i] == AD_NO_MEMORY
                     ? ad_fail(error, AD_NO_MEMORY, "%s", jobs.error[i].message)
                     : AD_OK;
    }
    free(jobs.status);
    free(jobs.error);
    return status;
}

/* ---- by solutions beside ------------------------------------------------------------------- */

static bool is_finite(const change *c, size_t experiment, const double *numbers)
{
    const solve_trials *x = c->x;
    for (size_t r = x->first[experiment]; r < x->first[experiment + 1]; r++) {
        const size_t count = solve_trials_row_residuals(x, &x->row[r]);
        for (size_t k = 0; k < count; k++) {
            if (!isfinite(numbers[x->row[r].residual + k])) {
                return false;
            }
        }
    }
    return true;
}

static bool is_changed(const change *c, size_t experiment)
{
    bool changed = true;
    for (size_t i = 0; i < (size_t)c->x->unknowns && changed; i++) {
        changed = is_finite(c, experiment, c->jacobian + i * c->x->residuals);
    }
    return changed;
}

/* To one side where there is no solution on the other. */
static void put_difference(const change *c, size_t experiment, size_t unknown)
{
    const solve_trials *x = c->x;
    const double *low = c->room + 2 * unknown * x->residuals, *high = low + x->residuals;
    double from = c->ends[2 * unknown], to = c->ends[2 * unknown + 1];
    if (!is_finite(c, experiment, low)) {
        low = c->residuals;
        from = c->values[unknown];
    } else if (!is_finite(c, experiment, high)) {
        high = c->residuals;
        to = c->values[unknown];
    }
    for (size_t r = x->first[experiment]; r < x->first[experiment + 1]; r++) {
        const size_t count = solve_trials_row_residuals(x, &x->row[r]);
        for (size_t k = x->row[r].residual; k < x->row[r].residual + count; k++) {
            c->jacobian[unknown * x->residuals + k] = (high[k] - low[k]) / (to - from);
        }
    }
}

/* Of the experiments of which derivatives are no numbers yet. */
static ad_status take_differences(const change *c, size_t *solved, ad_error *error)
{
    solve_trials *x = c->x;
    const size_t unknowns = (size_t)x->unknowns, trials = 2 * unknowns;
    size_t *open = malloc((x->experiments + 1) * sizeof *open), count = 0;
    trial_batch batch = {.x = x, .residuals = c->room};
    batch.job = malloc((trials * x->experiments + 1) * sizeof *batch.job);
    double *values = malloc(trials * unknowns * sizeof *values);
    ad_status status = open && batch.job && values
                           ? AD_OK
                           : ad_fail(error, AD_NO_MEMORY, "out of memory for %zu trials", trials);
    for (size_t i = 0; status == AD_OK && i < x->experiments; i += x->every) {
        if (!is_changed(c, i)) {
            open[count++] = i;
        }
    }
    for (size_t k = 0; status == AD_OK && k < trials; k++) {
        memcpy(values + k * unknowns, c->values, unknowns * sizeof *values);
        values[k * unknowns + k / 2] = c->ends[k];
        for (size_t i = 0; i < count; i++) {
            batch.job[batch.count++] = k * x->experiments + open[i];
        }
    }
    for (size_t i = 0; i < trials * x->experiments; i++) {
        solve_trials_clear(x, i / trials, c->room + i % trials * x->residuals);
    }
    batch.values = values;
    *solved = batch.count;
    if (status == AD_OK && count > 0) {
        status = trial_memory_follow(x->inputs, trials, values, false, error);
    }
    status = status == AD_OK && count > 0 ? solve_trials_jobs(&batch, error) : status;
    for (size_t i = 0; status == AD_OK && i < count * unknowns; i++) {
        put_difference(c, open[i / unknowns], i % unknowns);
    }
    free(open);
    free(batch.job);
    free(values);
    return status;
}

/* ---- all of them --------------------------------------------------------------------------- */

ad_status solve_trials_differentiate(solve_trials *trials, const double *values, const double *ends,
                                     const double *residuals, double *room, double *jacobian,
                                     size_t *solved, ad_error *error)
{
    const size_t unknowns = (size_t)trials->unknowns;
    const change c = {trials, values, ends, residuals, room, jacobian};
    ad_status status = AD_OK;
    for (size_t i = 0; i < unknowns * trials->experiments; i++) {
        solve_trials_clear(trials, i / unknowns, jacobian + i % unknowns * trials->residuals);
    }
    const size_t count = unknowns * (trials->apart ? trials->experiments : 1);
    if (trials->members && memcmp(trials->at, values, count * sizeof *values) != 0) {
        status = solve_trials_run(trials, 1, values, false, room, error);
    }
    trials->chooses = trials->rough = false;
    status = status == AD_OK ? trial_memory_follow(trials->inputs, 1, values, true, error) : status;
    status = status == AD_OK && trials->members ? change_all_members(&c, error) : status;
    if (status == AD_OK && trials->recordings && trials->columns <= SOLVE_MEMBERS_COLUMNS) {
        status = change_recordings(&c, error);
    }
    return status == AD_OK && ends ? take_differences(&c, solved, error) : status;
}
