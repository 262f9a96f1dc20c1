/* cpinn-residual: learns what measured motions tell of a robot beyond its model; see --help. */
#include "physics/check/plausible.h"
#include "physics/numerics/clock.h"
#include "tools/control/observation.h"
#include "tools/control/reduced_model.h"
#include "tools/control/residual.h"
#include "tools/files/json.h"
#include "tools/files/table_file.h"
#include "tools/prepare/prepare.h"
#include "tools/programs/fit_run.h"
#include "tools/programs/help.h"
#include "tools/programs/residual_rest.h"
#include "tools/surrogate/surrogate.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

static const char program[] = "cpinn-residual";

typedef struct options {
    const char *config, *measured, *out, *json;
    cli_list overrides;
    int units, steps, held_out, seed;
    int folds, left_out, choices, threads; /* at rest */
    double noise;
    fit_run run;
} options;

enum { RUNS_MAX = 10000 };

typedef struct learning {
    options asked;
    config *settings;
    surrogate_settings model;
    reduced_rod *rod;
    observation *eye;
    one_step step;
    one_observation observation;
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
static ad_status check_table(const learning *learning, const table_file *file, ad_error *error)
{
    const double *found;
    ad_status status = table_find(file, "t", TABLE_FINITE, &found, error);
    for (int i = 0; i < 2 * learning->step.inputs && status == AD_OK; i++) {
        const scene_parameter *p = reduced_input(learning->rod, i / 2);
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
static ad_status fill_seen(learning *learning, const table_file *file, ad_error *error)
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
    for (size_t r = 0; r < learning->rows; r++) {
        bool lost = false;
        for (int k = 0; k < 3; k++) {
            learning->seen[3 * r + (size_t)k] = from[k][r];
            lost = lost || isnan(from[k][r]);
        }
        learning->lost += lost;
    }
    if (scene_positions_implausible(&learning->settings->scene, learning->rows, from, &implausible,
                                    text) != AD_OK) {
        return ad_fail(error, AD_NO_MEMORY, "out of memory");
    }
    return implausible ? ad_fail(error, AD_BAD_INPUT, "%s", text) : AD_OK;
}

static ad_status fill(learning *learning, const table_file *file, ad_error *error)
{
    const size_t inputs = (size_t)learning->step.inputs;
    for (size_t i = 0; i < inputs; i++) {
        const scene_parameter *p = reduced_input(learning->rod, (int)i);
        char other[128];
        name_input(p, other);
        const double *from = column(file, p->name, other);
        for (size_t r = 0; r < learning->rows; r++) {
            learning->inputs[r * inputs + i] = from ? from[r] : scene_parameter_at(p, 0.5);
        }
    }
    return fill_seen(learning, file, error);
}

/* Motions begin where t falls. */
static ad_status split(learning *learning, const double *t, ad_error *error)
{
    learning->h = t && learning->rows > 1 ? t[1] - t[0] : 0;
    if (!(learning->h > 0)) {
        return ad_fail(error, AD_BAD_INPUT,
                       "has no column t that grows; allowed: two rows or more");
    }
    for (size_t r = 0; r < learning->rows; r++) {
        const double step = r > 0 ? t[r] - t[r - 1] : -1;
        if (step <= 0) {
            if (learning->run_count == RUNS_MAX) {
                return ad_fail(error, AD_BAD_INPUT, "has more than %d motions", RUNS_MAX);
            }
            learning->runs[learning->run_count++] =
                (residual_run){.inputs = learning->inputs + r * (size_t)learning->step.inputs,
                               .seen = learning->seen + 3 * r};
        } else if (!(fabs(step - learning->h) < 1e-6 * learning->h)) {
            return ad_fail(error, AD_BAD_INPUT,
                           "row %zu is %g s after the one before, and the second %g; allowed: "
                           "steps of one length",
                           r + 1, step, learning->h);
        }
        learning->runs[learning->run_count - 1].count++;
    }
    return AD_OK;
}

static ad_status read_table(learning *learning, ad_error *error)
{
    const char *path = learning->asked.measured;
    ad_error reason;
    table_file *file = NULL;
    ad_status status = table_read(path, TABLE_MEASURED, &file, error);
    status = status == AD_OK ? check_table(learning, file, error) : status;
    if (status != AD_OK) {
        table_free(file);
        return status;
    }
    learning->rows = table_rows(file);
    learning->inputs =
        malloc((learning->rows * (size_t)learning->step.inputs + 1) * sizeof *learning->inputs);
    learning->seen = malloc((learning->rows * 3 + 1) * sizeof *learning->seen);
    status = learning->inputs && learning->seen ? fill(learning, file, &reason)
                                                : ad_fail(&reason, AD_NO_MEMORY, "out of memory");
    status = status == AD_OK ? split(learning, table_column(file, "t"), &reason) : status;
    table_free(file);
    return status == AD_OK ? AD_OK : ad_fail(error, status, "%s: %s", path, reason.message);
}

/* ---- the model ----------------------------------------------------------------------------- */

static ad_status make_model(learning *learning, ad_error *error)
{
    const options *o = &learning->asked;
    ad_status status = prepare_read(o->config, NULL, o->overrides.count, o->overrides.texts,
                                    &learning->settings, error);
    if (status != AD_OK) {
        return status;
    }
    const scene *robot = &learning->settings->scene;
    const double track = learning->settings->control.track_at;
    learning->model = control_model_of(&learning->settings->surrogate);
    char text[256]; /* what cpinn-control chooses, too */
    ad_pool *pool = ad_pool_create(1);
    status = pool ? surrogate_choose_modes(robot, &learning->model, pool, 0, text, error)
                  : ad_fail(error, AD_NO_MEMORY, "out of memory");
    ad_pool_free(pool);
    if (status != AD_OK) {
        return status;
    }
    if (robot->memory_count > 0) {
        return ad_fail(error, AD_BAD_INPUT,
                       "a residual in motion is not built beside plays and lags; allowed: a scene "
                       "without them");
    }
    learning->place = isfinite(track) ? track : scene_length(robot);
    const int *m = learning->model.modes;
    const reduced_settings settings = {.modes = {m[0], m[1], m[2], m[3]}};
    const observation_sensor sensor = {
        .what = OBSERVATION_POSITION, .count = 1, .s = &learning->place};
    status = reduced_create(robot, &settings, &learning->rod, error);
    status =
        status == AD_OK ? observation_create(robot, m, &sensor, &learning->eye, error) : status;
    if (status == AD_OK) {
        learning->step = reduced_one_step(learning->rod, INFINITY);
        learning->observation = observation_of(learning->eye);
    }
    return status;
}

/* Where motions start, and how large states are along them, rms. */
static ad_status start_runs(learning *learning, double *size, ad_error *error)
{
    const size_t n = (size_t)learning->step.states, m = (size_t)learning->step.inputs;
    double *state = calloc(2 * n, sizeof *state), *next = state + n, most[2] = {0};
    learning->starts = calloc(learning->run_count * n, sizeof *learning->starts);
    ad_status status =
        state && learning->starts ? AD_OK : ad_fail(error, AD_NO_MEMORY, "out of memory");
    for (size_t i = 0; i < learning->run_count && status == AD_OK; i++) {
        residual_run *run = &learning->runs[i];
        double *start = learning->starts + i * n;
        run->start = start;
        status = reduced_settle(learning->rod, 0, run->inputs, start, error);
        memcpy(state, start, n * sizeof *state);
        for (size_t k = 0; k + 1 < run->count && status == AD_OK; k++) {
            status = reduced_step(learning->rod, 0, learning->h, state, run->inputs + k * m, next,
                                  NULL, NULL, error);
            for (size_t r = 0; r < n; r++) {
                size[r] += next[r] * next[r] / (double)learning->rows;
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

static ad_status make_network(learning *learning, ad_error *error)
{
    double middle[SCENE_PARAMETERS_MAX], half[SCENE_PARAMETERS_MAX];
    double *size = calloc((size_t)learning->step.states, sizeof *size);
    ad_status status =
        size ? start_runs(learning, size, error) : ad_fail(error, AD_NO_MEMORY, "out of memory");
    for (int i = 0; i < learning->step.inputs; i++) {
        const scene_parameter *p = reduced_input(learning->rod, i);
        const double *all = learning->inputs + i;
        bool varies = false;
        for (size_t r = 1; r < learning->rows; r++) {
            varies = varies || all[r * (size_t)learning->step.inputs] != all[0];
        }
        middle[i] = (p->low + p->high) / 2;
        half[i] = (p->high - p->low) / 2;
        if (!varies) {
            printf("%s is %g in all rows: what it changes is not learned\n", p->name, all[0]);
        }
    }
    if (status == AD_OK) {
        status = residual_create(&learning->step, learning->asked.units, size, middle, half,
                                 &learning->net, error);
    }
    free(size);
    return status;
}

/* ---- learning ------------------------------------------------------------------------------ */

/* Errors of a model on the motions; of what is learned with its deviations. */
static ad_status print_row(const learning *learning, const char *name, residual *net, size_t held,
                           ad_error *error)
{
    const size_t trained = learning->run_count - held;
    const one_step model = net ? residual_one_step(net) : learning->step;
    const double start = clock_seconds(CLOCK_MONOTONIC);
    const double off =
        residual_error(&model, learning->h, &learning->observation, trained, learning->runs);
    const double each = (clock_seconds(CLOCK_MONOTONIC) - start) / (double)learning->rows;
    const residual_run *last = learning->runs + trained;
    residual_score score = {0};
    ad_status status = AD_OK;
    printf("%-14s  %-10.2e  ", name, off);
    if (held > 0) {
        printf("%-10.2e  ",
               residual_error(&model, learning->h, &learning->observation, held, last));
    } else {
        printf("%-10s  ", "-");
    }
    if (net) {
        status = residual_judge(net, learning->h, &learning->observation, held > 0 ? held : trained,
                                held > 0 ? last : learning->runs, &score, error);
        printf("%-10.2e  %3.0f %%  %3.0f %%  ", score.deviation, 100 * score.covered[0],
               100 * score.covered[1]);
    } else {
        printf("%-10s  %5s  %5s  ", "-", "-", "-");
    }
    printf("%.1f\n", 1e6 * each);
    return status;
}

static ad_status learn(learning *learning, ad_error *error)
{
    options *o = &learning->asked;
    const size_t held = (size_t)o->held_out;
    const least_squares_runner runner = fit_run_by(&o->run);
    const residual_settings settings = {
        .steps = o->steps, .noise = o->noise, .seed = (uint64_t)o->seed, .runner = &runner};
    if (held >= learning->run_count) {
        return ad_fail(error, AD_BAD_INPUT,
                       "%s: has %zu motion%s, %zu held out; allowed: fewer held out", o->measured,
                       learning->run_count, learning->run_count == 1 ? "" : "s", held);
    }
    ad_status status = fit_run_ask(&o->run, learning->settings, error,
                                   "# units %d, steps %d, held out %d, noise %.17g, seed %d\n",
                                   o->units, o->steps, o->held_out, o->noise, o->seed);
    status = status == AD_OK ? make_network(learning, error) : status;
    const double start = clock_seconds(CLOCK_MONOTONIC);
    status = status == AD_OK
                 ? residual_fit(learning->net, learning->h, &learning->observation,
                                learning->run_count, learning->runs, held, &settings, error)
                 : status;
    if (status == AD_OK && !o->run.signal) {
        printf("%zu motions, %zu held out, %zu samples of %g s; %d states, %zu numbers; %.1f s\n",
               learning->run_count, held, learning->rows, learning->h, learning->step.states,
               residual_count(learning->net), clock_seconds(CLOCK_MONOTONIC) - start);
        if (learning->lost > 0) {
            printf("%zu samples have no place, and do not count\n", learning->lost);
        }
        printf("place, rms, m  trained on  held out    deviation   1 of it  2 of it  us a step\n");
        status = print_row(learning, "model", NULL, held, error);
        status = status == AD_OK ? print_row(learning, "with network", learning->net, held, error)
                                 : status;
        status = status == AD_OK ? residual_write(learning->net, o->out, error) : status;
    }
    return status;
}

static ad_status learn_motions(learning *x, ad_error *error)
{
    options *o = &x->asked;
    if (o->json || o->folds > 0 || o->left_out > 0 || o->choices > 0 || o->threads > 0) {
        return ad_fail(error, AD_BAD_INPUT,
                       "--json, --folds, --leave-out, --choices, --threads: of motions there are "
                       "none; allowed: scenes at rest that have residual.outputs");
    }
    o->units = o->units > 0 ? o->units : 8;
    o->noise = o->noise > 0 ? o->noise : 1e-3;
    if (!o->measured) {
        return ad_fail(error, AD_BAD_INPUT,
                       "--measured is missing; give a table of measured motions, or to the scene "
                       "of a rod at rest residual.outputs");
    }
    ad_status status = make_model(x, error);
    status = status == AD_OK ? read_table(x, error) : status;
    return status == AD_OK ? learn(x, error) : status;
}

static ad_status learn_rest(options *o, ad_error *error)
{
    const residual_rest_asked asked = {.scene = o->config,
                                       .out = o->out,
                                       .overrides = &o->overrides,
                                       .steps = o->steps,
                                       .folds = o->folds > 0 ? o->folds : 5,
                                       .left_out = o->left_out,
                                       .choices = o->choices > 0 ? o->choices : 1000,
                                       .threads = o->threads,
                                       .seed = (uint64_t)o->seed,
                                       .json = o->json,
                                       .run = &o->run};
    if (o->measured || o->held_out > 0 || o->units > 0 || o->noise > 0) {
        return ad_fail(error, AD_BAD_INPUT,
                       "--measured, --held-out, --units, --noise: the scene has residual.outputs; "
                       "its measurements are its data, some with held_out: true, and its network "
                       "has residual.hidden");
    }
    const ad_status status = json_check_path(o->json, error);
    return status == AD_OK ? residual_rest(&asked, error) : status;
}

/* Of a scene with residual.outputs what is learned is at rest, else in motion. */
static ad_status run(learning *x, ad_error *error)
{
    options *o = &x->asked;
    config *settings = NULL;
    o->out = o->out ? o->out : "residual.h5";
    const size_t length = strlen(o->out);
    if (length < 3 || strcmp(o->out + length - 3, ".h5") != 0) {
        return ad_fail(error, AD_BAD_INPUT, "--out %s: allowed: a name that ends in .h5", o->out);
    }
    ad_status status = table_check_path(o->out, error);
    if (status != AD_OK) {
        return status;
    }
    status = config_read(x->asked.config, NULL, x->asked.overrides.count, x->asked.overrides.texts,
                         &settings, error);
    const bool rests = status == AD_OK && residual_rest_is_meant(settings);
    config_free(settings);
    return status != AD_OK ? status
           : rests         ? learn_rest(&x->asked, error)
                           : learn_motions(x, error);
}

int main(int argc, char **argv)
{
    static learning x;
    options *o = &x.asked;
    *o = (options){.run.program = program, .steps = 40}; /* 0: not given */
    const cli_option rows[] = {{"--measured", "TABLE", CLI_TEXT, &o->measured, 0, 0},
                               {"--out", "FILE", CLI_TEXT, &o->out, 0, 0},
                               CLI_SET(&o->overrides),
                               CLI_DATA(&o->overrides),
                               {"--folds", "N", CLI_INTEGER, &o->folds, 2, 1000},
                               {"--leave-out", "N", CLI_INTEGER, &o->left_out, 1, 60},
                               {"--choices", "N", CLI_INTEGER, &o->choices, 1, 1000000},
                               CLI_THREADS(&o->threads),
                               {"--units", "N", CLI_INTEGER, &o->units, 1, 64},
                               {"--steps", "N", CLI_INTEGER, &o->steps, 0, 100000},
                               {"--held-out", "N", CLI_INTEGER, &o->held_out, 0, RUNS_MAX},
                               {"--noise", "M", CLI_NUMBER, &o->noise, 1e-12, 1e3},
                               CLI_SEED(&o->seed),
                               CLI_JSON(&o->json),
                               {"--run", "DIR", CLI_TEXT, &o->run.folder, 0, 0},
                               {"--resume", NULL, CLI_FLAG, &o->run.resume, 0, 0}};
    const cli_program face = {.name = program, .operand = "CONFIG.yaml", .help = help_residual};
    int status = cli_parse(&face, rows, sizeof rows / sizeof *rows, argc, argv, &o->config);
    ad_error error;
    if (status != CLI_RUN) {
        return status;
    }
    status = run(&x, &error) == AD_OK ? 0 : cli_fail_error(program, &error);
    residual_free(x.net);
    observation_free(x.eye);
    reduced_free(x.rod);
    config_free(x.settings);
    free(x.inputs);
    free(x.seen);
    free(x.starts);
    const int left = fit_run_end(&o->run);
    return left ? left : status;
}
