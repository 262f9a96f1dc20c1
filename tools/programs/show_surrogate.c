/* cpinn-show: a one-step model, its rollouts beside the solver. */
#include "tools/prepare/config_surrogate.h"
#include "tools/programs/eval_rollouts.h"
#include "tools/programs/show_source.h"
#include "tools/train/history.h"
#include "tools/train/report.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

/* Shapes of the typical rollout: those of the model, with how far they are off, then places by the
 * solver. */
enum { POINTS = 31, OFF = 12, COLUMNS = 13, SOLVED = COLUMNS, ALL = COLUMNS + 3 };

static const char *const names[COLUMNS] = {
    "s", "t", "x", "y", "z", "qw", "qx", "qy", "qz", "vx", "vy", "vz", "off the solver"};
static const char *const units[COLUMNS] = {"m", "s", "m",   "m",   "m",   "", "",
                                           "",  "",  "m/s", "m/s", "m/s", "m"};

typedef struct rolled {
    showing *x;
    surrogate *of;
    rollouts_report report;
    reduced_rod *rod;
    size_t frames;   /* until the rollout ends */
    double *columns; /* [ALL][frames POINTS] */
    double *inputs;  /* [frames][inputs] */
} rolled;

/* ---- the rollout in space ------------------------------------------------------------------ */

static void put_point(const rolled *r, size_t row, const reduced_place *solved,
                      const reduced_place *stepped)
{
    const size_t rows = r->frames * POINTS;
    double numbers[ALL] = {r->report.length * (double)(row % POINTS) / (POINTS - 1),
                           (double)(row / POINTS) * r->report.step};
    memcpy(numbers + 2, stepped->position, sizeof stepped->position);
    memcpy(numbers + 5, stepped->rotation, sizeof stepped->rotation);
    memcpy(numbers + 9, stepped->velocity, sizeof stepped->velocity);
    memcpy(numbers + SOLVED, solved->position, sizeof solved->position);
    numbers[OFF] = hypot(hypot(numbers[2] - numbers[SOLVED], numbers[3] - numbers[SOLVED + 1]),
                         numbers[4] - numbers[SOLVED + 2]);
    for (size_t k = 0; k < ALL; k++) {
        r->columns[k * rows + row] = numbers[k];
    }
}

static ad_status fill_shapes(const rolled *r, ad_error *error)
{
    const size_t n = (size_t)reduced_states(r->rod), m = (size_t)reduced_inputs(r->rod);
    ad_status status = AD_OK;
    for (size_t frame = 0; frame < r->frames && status == AD_OK; frame++) {
        const double *states = r->report.states + frame * 2 * n;
        const double *inputs = r->report.inputs + frame * m;
        reduced_place places[2][POINTS];
        memcpy(r->inputs + frame * m, inputs, m * sizeof *inputs);
        for (size_t k = 0; k < 2 && status == AD_OK; k++) {
            status = reduced_output(r->rod, 0, states + k * n, inputs, places[k], NULL, error);
        }
        for (size_t i = 0; i < POINTS && status == AD_OK; i++) {
            put_point(r, frame * POINTS + i, &places[0][i], &places[1][i]);
        }
    }
    return status;
}

static ad_status make_shapes(rolled *r, ad_error *error)
{
    double s[POINTS];
    for (int i = 0; i < POINTS; i++) {
        s[i] = r->report.length * i / (POINTS - 1);
    }
    const ad_status status = surrogate_rod(r->of, POINTS, s, &r->rod, error);
    if (status != AD_OK) {
        return status;
    }
    const size_t n = (size_t)reduced_states(r->rod);
    const size_t most = (size_t)r->report.steps[ROLLOUTS_SHORT] + 1;
    while (r->frames < most && isfinite(r->report.states[r->frames * 2 * n])) {
        r->frames++;
    }
    r->columns = malloc(sizeof *r->columns * r->frames * ALL * POINTS + 1);
    r->inputs = malloc((size_t)reduced_inputs(r->rod) * r->frames * sizeof *r->inputs + 1);
    return r->columns && r->inputs ? fill_shapes(r, error)
                                   : ad_fail(error, AD_NO_MEMORY, "out of memory for a report");
}

static ad_status put_motion(const rolled *r, ad_error *error)
{
    const size_t rows = r->frames * POINTS;
    const double *columns[COLUMNS], *solved[5];
    for (size_t k = 0; k < COLUMNS; k++) {
        columns[k] = r->columns + k * rows;
    }
    for (size_t k = 0; k < 5; k++) {
        solved[k] = k < 2 ? columns[k] : r->columns + (SOLVED + k - 2) * rows;
    }
    const table_source table = {
        .names = names, .columns = columns, .ncols = COLUMNS, .nrows = rows, .units = units};
    const table_source ghost = {.names = names, .columns = solved, .ncols = 5, .nrows = rows};
    const ad_status status = show_put_motion(r->x, &table, NULL, &ghost, "solver", error);
    return status == AD_OK
               ? show_scene(&r->x->to, r->of->scene, r->inputs, &r->x->kept, NULL, error)
               : status;
}

/* ---- numbers ------------------------------------------------------------------------------- */

static void put_head(const rolled *r)
{
    const rollouts_report *report = &r->report;
    json *to = &r->x->to;
    verdict judged = {.count = 0};
    eval_rollouts_verdict(report, &r->of->settings, history_last(r->x->file, "loss"),
                          history_last(r->x->file, "held_out"), &judged);
    report_verdict(to, &judged);
    json_open(to, "facts", '[');
    show_scene_facts(to, r->of->scene);
    show_fact(to, "step", "%g s", report->step);
    show_fact(to, "states", "%.0f", report->rows[ROLLOUTS_MODEL].states);
    show_fact(to, "rollouts", "%.0f", report->count);
    show_fact(to, "error of the tip, median", "%.2g mm",
              1e3 * report->length * report->rows[ROLLOUTS_MODEL].error[ROLLOUTS_SHORT][0]);
    show_fact(to, "worst", "%.2g mm",
              1e3 * report->length * report->rows[ROLLOUTS_MODEL].error[ROLLOUTS_SHORT][1]);
    json_close(to, ']');
}

static void put_table(const rolled *r)
{
    char cells[EVAL_ROLLOUTS_CELLS][EVAL_ROLLOUTS_CELL];
    json *to = &r->x->to;
    json_open(to, "tables", '[');
    json_open(to, NULL, '{');
    json_text(to, "title",
              "Errors of the tip in % of the length, median / worst; times of a step in \u00b5s");
    json_open(to, "rows", '[');
    for (int row = -1; row < ROLLOUTS_ROWS; row++) {
        if (row < 0) {
            eval_rollouts_heads(&r->report, cells);
        } else {
            eval_rollouts_cells(&r->report, row, cells);
        }
        json_open(to, NULL, '[');
        for (int k = 0; k < EVAL_ROLLOUTS_CELLS; k++) {
            json_text(to, NULL, cells[k]);
        }
        json_close(to, ']');
    }
    json_close(to, ']');
    json_close(to, '}');
    json_close(to, ']');
}

/* Errors over time, of all rollouts, and the inputs of the one in the picture. */
static ad_status put_curves(const rolled *r, ad_error *error)
{
    const size_t steps = (size_t)r->report.steps[ROLLOUTS_SHORT];
    const size_t count = (size_t)reduced_inputs(r->rod);
    json *to = &r->x->to;
    double *t = malloc(4 * (steps + 1) * sizeof *t), *values = t + steps + 1;
    if (!t) {
        return ad_fail(error, AD_NO_MEMORY, "out of memory for a report");
    }
    json_open(to, "curves", '[');
    show_open_curve(to, "Error of the tip, all rollouts", "t", "s", "m", true);
    for (int which = 0; which < 2; which++) {
        for (size_t k = 0; k < steps; k++) {
            t[k] = (double)(k + 1) * r->report.step;
            values[k] = r->report.length * r->report.over_time[k][which];
        }
        show_series(to, which == ROLLOUTS_WORST ? "worst" : "median", t, values, steps);
    }
    show_close_curve(to);
    show_open_curve(to, "Inputs of this rollout", "t", "s", "", false);
    for (size_t i = 0; i < count; i++) {
        for (size_t k = 0; k < r->frames; k++) {
            t[k] = (double)k * r->report.step;
            values[k] = r->inputs[k * count + i];
        }
        show_series(to, reduced_input(r->rod, (int)i)->name, t, values, r->frames);
    }
    show_close_curve(to);
    const ad_status status = show_history(to, r->x->file, error);
    json_close(to, ']');
    free(t);
    return status;
}

/* ---- all of it ----------------------------------------------------------------------------- */

static ad_status judge(rolled *r, ad_error *error)
{
    const config *settings = r->of->owner;
    ad_pool *pool = NULL;
    ad_status status = ad_pool_open(0, &pool, error);
    if (status == AD_OK) {
        status = eval_rollouts_judge(r->of, EVAL_ROLLOUTS_JUDGED,
                                     settings->settings.seed + EVAL_ROLLOUTS_SEED, pool, &r->report,
                                     error);
    }
    ad_pool_free(pool);
    return status;
}

ad_status show_surrogate(showing *showing, ad_error *error)
{
    rolled r = {.x = showing};
    ad_status status = surrogate_load(showing->source, &r.of, error);
    if (status == AD_OK && (showing->at || showing->overrides.count > 0 || showing->grid)) {
        status = ad_fail(error, AD_BAD_INPUT,
                         "%s: is of a one-step model, which is shown in rollouts of its own; "
                         "allowed: no --at, --set or --grid",
                         showing->source);
    }
    status = status == AD_OK ? judge(&r, error) : status;
    status = status == AD_OK ? make_shapes(&r, error) : status;
    if (status == AD_OK) {
        const config *settings = r.of->owner;
        snprintf(showing->title, sizeof showing->title, "%s", settings->settings.name);
        put_head(&r);
        put_table(&r);
        status = put_curves(&r, error);
        show_settings(&showing->to, settings);
    }
    status = status == AD_OK ? put_motion(&r, error) : status;
    reduced_free(r.rod);
    rollouts_free(&r.report);
    surrogate_free(r.of);
    free(r.columns);
    free(r.inputs);
    return status;
}
