/* cpinn-residual: learns what measured motions tell of a robot beyond its model; see --help. */
#include "physics/plausible.h"
#include "tools/control/look.h"
#include "tools/control/reduced_model.h"
#include "tools/control/residual.h"
#include "tools/files/table_file.h"
#include "tools/prepare/prepare.h"
#include "tools/programs/cli.h"
#include "tools/programs/help.h"
#include "tools/surrogate/surrogate.h"
#include "tools/train/clock.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

static const char program[] = "cpinn-residual";

typedef struct options {
    const char *config, *measured, *out;
    cli_list overrides;
    int units, steps, held_out, seed;
    double noise;
} options;

enum { RUNS_MAX = 10000 };

typedef struct learning {
    options asked;
    config *settings;
    surrogate_settings model;
    reduced_rod *rod;
    look *eye;
    one_step step;
    one_look look;
    residual *net;
    double h, place;
    size_t rows, run_count, lost;   /* rows without a place */
    double *inputs, *seen, *starts; /* [rows][inputs], [rows][3], [runs][states] */
    residual_run runs[RUNS_MAX];
} learning;

/* ---- the table ----------------------------------------------------------------------------- */

static const char *const place_names[3][2] = {
    {"x", "measured0_0"}, {"y", "measured0_1"}, {"z", "measured0_2"}};

static const double *column(const table_file *file, const char *first, const char *other)
{
    const double *found = table_column(file, first);
    return found ? found : table_column(file, other);
}

/* Of a parameter in a loop's table. */
static void name_input(const scene_parameter *p, char name[128])
{
    snprintf(name, 128, "input_%.100s", p->name);
}

/* Whether columns that will be used have what is no number. */
static ad_status check_table(const learning *x, const table_file *file, ad_error *error)
{
    const double *found;
    ad_status status = table_find(file, "t", TABLE_FINITE, &found, error);
    for (int i = 0; i < 2 * x->step.inputs && status == AD_OK; i++) {
        const scene_parameter *p = reduced_input(x->rod, i / 2);
        char other[128];
        name_input(p, other);
        status = table_find(file, i % 2 ? other : p->name, TABLE_FINITE, &found, error);
    }
    for (int k = 0; k < 6 && status == AD_OK; k++) {
        status = table_find(file, place_names[k / 2][k % 2], TABLE_MEASURED, &found, error);
    }
    return status;
}

/* What the camera saw, and how much of it is missing. */
static ad_status fill_seen(learning *x, const table_file *file, ad_error *error)
{
    const double *from[3];
    char text[SCENE_WARNING_TEXT];
    bool implausible;
    for (int k = 0; k < 3; k++) {
        from[k] = column(file, place_names[k][0], place_names[k][1]);
        if (!from[k]) {
            return ad_fail(error, AD_BAD_INPUT,
                           "has no column %s; allowed: t, inputs, and x, y, z "
                           "or measured0_0, measured0_1, measured0_2",
                           place_names[k][0]);
        }
    }
    for (size_t r = 0; r < x->rows; r++) {
        bool lost = false;
        for (int k = 0; k < 3; k++) {
            x->seen[3 * r + (size_t)k] = from[k][r];
            lost = lost || isnan(from[k][r]);
        }
        x->lost += lost;
    }
    if (scene_positions_implausible(&x->settings->scene, x->rows, from, &implausible, text) !=
        AD_OK) {
        return ad_fail(error, AD_NO_MEMORY, "out of memory");
    }
    return implausible ? ad_fail(error, AD_BAD_INPUT, "%s", text) : AD_OK;
}

static ad_status fill(learning *x, const table_file *file, ad_error *error)
{
    const size_t inputs = (size_t)x->step.inputs;
    for (size_t i = 0; i < inputs; i++) {
        const scene_parameter *p = reduced_input(x->rod, (int)i);
        char other[128];
        name_input(p, other);
        const double *from = column(file, p->name, other);
        for (size_t r = 0; r < x->rows; r++) {
            x->inputs[r * inputs + i] = from ? from[r] : scene_parameter_at(p, 0.5);
        }
    }
    return fill_seen(x, file, error);
}

/* Motions begin where t falls. */
static ad_status split(learning *x, const double *t, ad_error *error)
{
    x->h = t && x->rows > 1 ? t[1] - t[0] : 0;
    if (!(x->h > 0)) {
        return ad_fail(error, AD_BAD_INPUT,
                       "has no column t that grows; allowed: two rows or more");
    }
    for (size_t r = 0; r < x->rows; r++) {
        const double step = r > 0 ? t[r] - t[r - 1] : -1;
        if (step <= 0) {
            if (x->run_count == RUNS_MAX) {
                return ad_fail(error, AD_BAD_INPUT, "has more than %d motions", RUNS_MAX);
            }
            x->runs[x->run_count++] = (residual_run){
                .inputs = x->inputs + r * (size_t)x->step.inputs, .seen = x->seen + 3 * r};
        } else if (!(fabs(step - x->h) < 1e-6 * x->h)) {
            return ad_fail(error, AD_BAD_INPUT,
                           "row %zu is %g s after the one before, and the second %g; allowed: "
                           "steps of one length",
                           r + 1, step, x->h);
        }
        x->runs[x->run_count - 1].count++;
    }
    return AD_OK;
}

static ad_status read_table(learning *x, ad_error *error)
{
    const char *path = x->asked.measured;
    ad_error reason;
    table_file *file = NULL;
    ad_status status = table_read(path, TABLE_MEASURED, &file, error);
    status = status == AD_OK ? check_table(x, file, error) : status;
    if (status != AD_OK) {
        table_free(file);
        return status;
    }
    x->rows = table_rows(file);
    x->inputs = malloc((x->rows * (size_t)x->step.inputs + 1) * sizeof *x->inputs);
    x->seen = malloc((x->rows * 3 + 1) * sizeof *x->seen);
    status = x->inputs && x->seen ? fill(x, file, &reason)
                                  : ad_fail(&reason, AD_NO_MEMORY, "out of memory");
    status = status == AD_OK ? split(x, table_column(file, "t"), &reason) : status;
    table_free(file);
    return status == AD_OK ? AD_OK : ad_fail(error, status, "%s: %s", path, reason.message);
}

/* ---- the model ----------------------------------------------------------------------------- */

static ad_status make_model(learning *x, ad_error *error)
{
    const options *o = &x->asked;
    ad_status status =
        prepare_read(o->config, NULL, o->overrides.count, o->overrides.texts, &x->settings, error);
    if (status != AD_OK) {
        return status;
    }
    const scene *robot = &x->settings->scene;
    const double track = x->settings->control.track_at;
    x->model = control_model_of(&x->settings->surrogate);
    char text[256]; /* what cpinn-control chooses, too */
    ad_pool *pool = ad_pool_create(1);
    status = pool ? surrogate_choose_modes(robot, &x->model, pool, 0, text, error)
                  : ad_fail(error, AD_NO_MEMORY, "out of memory");
    ad_pool_free(pool);
    if (status != AD_OK) {
        return status;
    }
    x->place = isfinite(track) ? track : scene_length(robot);
    const int *m = x->model.modes;
    const reduced_settings settings = {.modes = {m[0], m[1], m[2], m[3]}};
    const look_sensor sensor = {.what = LOOK_POSITION, .count = 1, .s = &x->place};
    status = reduced_create(robot, &settings, &x->rod, error);
    status = status == AD_OK ? look_create(robot, m, &sensor, &x->eye, error) : status;
    if (status == AD_OK) {
        x->step = reduced_one_step(x->rod, INFINITY);
        x->look = look_of(x->eye);
    }
    return status;
}

/* Where motions start, and how large states are along them, rms. */
static ad_status start_runs(learning *x, double *size, ad_error *error)
{
    const size_t n = (size_t)x->step.states, m = (size_t)x->step.inputs;
    double *state = calloc(2 * n, sizeof *state), *next = state + n, most[2] = {0};
    x->starts = calloc(x->run_count * n, sizeof *x->starts);
    ad_status status = state && x->starts ? AD_OK : ad_fail(error, AD_NO_MEMORY, "out of memory");
    for (size_t i = 0; i < x->run_count && status == AD_OK; i++) {
        residual_run *run = &x->runs[i];
        double *start = x->starts + i * n;
        run->start = start;
        status = reduced_settle(x->rod, 0, run->inputs, start, error);
        memcpy(state, start, n * sizeof *state);
        for (size_t k = 0; k + 1 < run->count && status == AD_OK; k++) {
            status =
                reduced_step(x->rod, 0, x->h, state, run->inputs + k * m, next, NULL, NULL, error);
            for (size_t r = 0; r < n; r++) {
                size[r] += next[r] * next[r] / (double)x->rows;
            }
            memcpy(state, next, n * sizeof *state);
        }
    }
    for (size_t r = 0; r < n; r++) {
        size[r] = sqrt(size[r]);
        most[2 * r / n] = fmax(most[2 * r / n], size[r]);
    }
    for (size_t r = 0; r < n; r++) { /* one that hardly moves counts for little */
        size[r] = fmax(size[r], 1e-3 * most[2 * r / n]);
    }
    free(state);
    return status;
}

static ad_status make_network(learning *x, ad_error *error)
{
    double middle[SCENE_PARAMETERS_MAX], half[SCENE_PARAMETERS_MAX];
    double *size = calloc((size_t)x->step.states, sizeof *size);
    ad_status status =
        size ? start_runs(x, size, error) : ad_fail(error, AD_NO_MEMORY, "out of memory");
    for (int i = 0; i < x->step.inputs; i++) {
        const scene_parameter *p = reduced_input(x->rod, i);
        middle[i] = (p->low + p->high) / 2;
        half[i] = (p->high - p->low) / 2;
    }
    if (status == AD_OK) {
        status = residual_create(&x->step, x->asked.units, size, middle, half, &x->net, error);
    }
    free(size);
    return status;
}

/* ---- learning ------------------------------------------------------------------------------ */

/* Errors of a model on the motions. */
static void print_row(const learning *x, const char *name, const one_step *model, size_t held)
{
    const size_t trained = x->run_count - held;
    const double start = train_seconds();
    const double off = residual_error(model, x->h, &x->look, trained, x->runs);
    const double each = (train_seconds() - start) / (double)x->rows;
    printf("%-14s  %-10.2e  ", name, off);
    if (held > 0) {
        printf("%-10.2e  ", residual_error(model, x->h, &x->look, held, x->runs + trained));
    } else {
        printf("%-10s  ", "-");
    }
    printf("%.1f\n", 1e6 * each);
}

static ad_status learn(learning *x, ad_error *error)
{
    const options *o = &x->asked;
    const size_t held = (size_t)o->held_out;
    const residual_settings settings = {o->steps, o->noise, (uint64_t)o->seed};
    if (held >= x->run_count) {
        return ad_fail(error, AD_BAD_INPUT,
                       "%s: has %zu motion%s, %zu held out; allowed: fewer held out", o->measured,
                       x->run_count, x->run_count == 1 ? "" : "s", held);
    }
    ad_status status = make_network(x, error);
    const double start = train_seconds();
    status = status == AD_OK ? residual_fit(x->net, x->h, &x->look, x->run_count, x->runs, held,
                                            &settings, error)
                             : status;
    if (status == AD_OK) {
        const one_step corrected = residual_one_step(x->net);
        printf("%zu motions, %zu held out, %zu samples of %g s; %d states, %zu numbers; %.1f s\n",
               x->run_count, held, x->rows, x->h, x->step.states, residual_count(x->net),
               train_seconds() - start);
        if (x->lost > 0) {
            printf("%zu samples have no place, and do not count\n", x->lost);
        }
        printf("place, rms, m  trained on  held out    us a step\n");
        print_row(x, "model", &x->step, held);
        print_row(x, "with network", &corrected, held);
        status = residual_write(x->net, o->out, error);
    }
    return status;
}

int main(int argc, char **argv)
{
    static learning x;
    options *o = &x.asked;
    *o = (options){.out = "residual.csv", .units = 8, .steps = 40, .noise = 1e-3};
    const cli_option rows[] = {{"--measured", "TABLE", CLI_TEXT, &o->measured, 0, 0},
                               {"--out", "FILE", CLI_TEXT, &o->out, 0, 0},
                               CLI_SET(&o->overrides),
                               {"--units", "N", CLI_INTEGER, &o->units, 1, 64},
                               {"--steps", "N", CLI_INTEGER, &o->steps, 0, 100000},
                               {"--held-out", "N", CLI_INTEGER, &o->held_out, 0, RUNS_MAX},
                               {"--noise", "M", CLI_NUMBER, &o->noise, 1e-12, 1e3},
                               CLI_SEED(&o->seed)};
    const cli_program face = {.name = program, .operand = "CONFIG.yaml", .help = help_residual};
    int status = cli_parse(&face, rows, sizeof rows / sizeof *rows, argc, argv, &o->config);
    ad_error error;
    if (status != CLI_RUN) {
        return status;
    }
    if (!o->measured) {
        return cli_fail(program, "--measured is missing; give a table of measured motions");
    }
    bool good = table_check_path(o->out, &error) == AD_OK && make_model(&x, &error) == AD_OK &&
                read_table(&x, &error) == AD_OK && learn(&x, &error) == AD_OK;
    status = good ? 0 : cli_fail_error(program, &error);
    residual_free(x.net);
    look_free(x.eye);
    reduced_free(x.rod);
    config_free(x.settings);
    free(x.inputs);
    free(x.seen);
    free(x.starts);
    return status;
}
