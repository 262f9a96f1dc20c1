/* cpinn-control: the closed loop of a scene in simulation; see --help. */
#include "tools/environment/environment.h"
#include "tools/environment/surface_tree.h"
#include "tools/files/shapes_vtk.h"
#include "tools/files/table_file.h"
#include "tools/prepare/config_surrogate.h"
#include "tools/programs/cli.h"
#include "tools/programs/conclude.h"
#include "tools/programs/control_judge.h"
#include "tools/programs/control_replay.h"
#include "tools/programs/control_run.h"
#include "tools/programs/help.h"
#include "tools/programs/scene_line.h"
#include "tools/surrogate/surrogate.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>

static const char program[] = "cpinn-control";

typedef struct options {
    const char *config, *out, *shapes, *run, *inner, *json, *c;
    cli_list overrides;
    int seed;
    replay_settings settings; /* of a replay */
    bool compare, quiet, force, replay;
} options;

enum { ROWS_MAX = 6 };

typedef struct controlling {
    options asked;
    config *nominal, *plant;
    surrogate_settings model;
    double truth[SCENE_PARAMETERS_MAX];
    environment *environment; /* of a constrained clearance; NULL: there is none */
    surface_tree *tree;
    surroundings around;
    surrogate *trained, *inner; /* NULL: there is none */
    one_step step, inner_step;  /* of them */
    char model_text[400];
    int count;
    control_row rows[ROWS_MAX];
    replays replays;
    verdict verdict;
} controlling;

/* Values of the scene's parameters in the plant. */
static void find_truth(controlling *controlling)
{
    const scene *nominal = &controlling->nominal->scene;
    for (int k = 0; k < nominal->parameter_count; k++) {
        controlling->truth[k] = NAN;
        for (int i = 0; i < controlling->plant->parameter_count; i++) {
            const config_parameter *p = &controlling->plant->parameters[i];
            if (strcmp(p->name, nominal->parameters[k].name) == 0) {
                double value = NAN;
                quantity_is_number(p->value, &value);
                controlling->truth[k] =
                    isnan(p->range[0]) ? value : scene_parameter_at(&nominal->parameters[k], 0.5);
            }
        }
    }
}

/* Whether two scenes are the same but for what is trained and controlled. */
static bool same_physics(const config *a, const config *b)
{
    const config *const both[2] = {a, b};
    char *texts[2] = {NULL, NULL};
    size_t sizes[2];
    for (int i = 0; i < 2; i++) {
        FILE *file = open_memstream(&texts[i], &sizes[i]);
        if (file) {
            (void)config_write_physics(both[i], file);
            fclose(file);
        }
    }
    const bool same = texts[0] && texts[1] && strcmp(texts[0], texts[1]) == 0;
    free(texts[0]);
    free(texts[1]);
    return same;
}

/* The key of section surrogate by which a scene asks for another model than is trained, beside its
 * step; NULL: none. */
static const char *other_model(const config *of, const surrogate_settings *trained)
{
    const surrogate_settings *asked = &of->surrogate;
    const bool open = asked->modes[0] + asked->modes[1] + asked->modes[2] + asked->modes[3] == 0;
    bool same = true;
    for (int i = 0; i < of->scene.parameter_count; i++) {
        const char *name = of->scene.parameters[i].name;
        same = same &&
               surrogate_names_parameter(asked, name) == surrogate_names_parameter(trained, name);
    }
    return !same ? "surrogate.parameters"
           : open || memcmp(asked->modes, trained->modes, sizeof asked->modes) == 0
               ? NULL
               : "surrogate.modes";
}

static ad_status load(const controlling *controlling, const char *path, surrogate **model,
                      one_step *step, ad_error *error)
{
    ad_error why;
    ad_status status = surrogate_load(path, model, &why);
    if (status != AD_OK) {
        return ad_fail(error, status, "%.400s; cpinn-train trains one, --run DIR says where it is",
                       why.message);
    }
    if (!same_physics((*model)->owner, controlling->nominal)) {
        return ad_fail(error, AD_BAD_INPUT,
                       "%.200s: the one-step model in %.200s was trained for another scene; train "
                       "it again, or take control.model: reduced",
                       controlling->asked.config, path);
    }
    const char *other = other_model(controlling->nominal, &(*model)->settings);
    if (!other && model == &controlling->trained &&
        (*model)->settings.step != controlling->nominal->surrogate.step) {
        other = "surrogate.step";
    }
    if (other) {
        return ad_fail(error, AD_BAD_INPUT,
                       "%.200s: the one-step model in %.200s was trained with another %s; train "
                       "it again, or give what it was trained with",
                       controlling->asked.config, path, other);
    }
    return surrogate_one_step(*model, step, error);
}

/* The trained models, where one is wanted and there is one. */
static ad_status open_trained(controlling *controlling, ad_error *error)
{
    const control_settings *c = &controlling->nominal->control;
    char folder[200], checkpoint[220];
    snprintf(folder, sizeof folder, "runs/%.150s", controlling->nominal->settings.name);
    controlling->asked.run = controlling->asked.run ? controlling->asked.run : "";
    const char *path = *controlling->asked.run ? controlling->asked.run : folder;
    snprintf(checkpoint, sizeof checkpoint, "%s/checkpoint.h5", folder);
    const bool wanted = c->model == CONTROL_SURROGATE || *controlling->asked.run;
    if (!surrogate_is_given(&controlling->nominal->surrogate) ||
        !(wanted || (c->model == CONTROL_AUTOMATIC && access(checkpoint, R_OK) == 0))) {
        return AD_OK;
    }
    ad_status status = load(controlling, path, &controlling->trained, &controlling->step, error);
    if (status == AD_OK && controlling->asked.inner) {
        status = load(controlling, controlling->asked.inner, &controlling->inner,
                      &controlling->inner_step, error);
    }
    if (status == AD_OK && controlling->inner &&
        memcmp(controlling->inner->settings.modes, controlling->trained->settings.modes,
               sizeof controlling->inner->settings.modes) != 0) {
        status = ad_fail(error, AD_BAD_INPUT,
                         "%.200s: --inner %.200s: has other modes than the model of longer steps",
                         controlling->asked.config, controlling->asked.inner);
    }
    return status;
}

/* Of a model that is not trained by its tolerance, and of the plant one more of each. */
static ad_status choose_modes(controlling *controlling, ad_error *error)
{
    char text[256];
    int *of = controlling->nominal->control.plant_modes;
    ad_pool *pool = ad_pool_create(1);
    ad_status status = pool ? surrogate_choose_modes(&controlling->nominal->scene,
                                                     &controlling->model, pool, 0, text, error)
                            : ad_fail(error, AD_NO_MEMORY, "out of memory for modes");
    ad_pool_free(pool);
    const bool open = of[0] + of[1] + of[2] + of[3] == 0;
    for (int k = 0; k < 4 && open; k++) {
        of[k] = controlling->model.modes[k] + 1;
    }
    return status;
}

static ad_status find_model(controlling *controlling, ad_error *error)
{
    control_settings *c = &controlling->nominal->control;
    ad_status status = open_trained(controlling, error);
    if (status != AD_OK) {
        return status;
    }
    controlling->model = controlling->trained ? controlling->trained->settings
                                              : control_model_of(&controlling->nominal->surrogate);
    if (!surrogate_is_given(
            &controlling->nominal->surrogate)) { /* no inputs where nothing is estimated, either */
        controlling->model.parameter_count = c->estimate_count;
        memcpy(controlling->model.parameters, c->estimate, sizeof c->estimate);
    }
    if (c->model == CONTROL_AUTOMATIC) {
        c->model = controlling->trained ? CONTROL_SURROGATE : CONTROL_REDUCED;
    }
    if (c->model == CONTROL_SURROGATE && !controlling->trained) {
        return ad_fail(
            error, AD_BAD_INPUT,
            "control.model: is surrogate, and the scene has no one-step model; give it a section "
            "surrogate, and train it with cpinn-train");
    }
    if (c->model == CONTROL_SURROGATE && !controlling->asked.replay &&
        controlling->model.hold == SURROGATE_RAMP) {
        return config_refuse(controlling->nominal, "surrogate.hold",
                             "is linear, and the inputs of a loop jump from sample to sample and "
                             "stay; allowed: a model that is trained with constant",
                             error);
    }
    const char *unused = !controlling->trained && *controlling->asked.run            ? "--run"
                         : controlling->asked.inner && c->model != CONTROL_SURROGATE ? "--inner"
                                                                                     : NULL;
    if (unused) {
        return ad_fail(error, AD_BAD_INPUT,
                       "%s: is of a trained one-step model, and the loop has none; allowed: a "
                       "scene with surrogate, and control.model: surrogate",
                       unused);
    }
    status = choose_modes(controlling, error);
    const int *m = controlling->model.modes;
    static const char *const words[] = {"", "trained one-step model", "reduced rod", "linear"};
    snprintf(controlling->model_text, sizeof controlling->model_text,
             "%s%s, modes %d, %d, %d, %d, steps of %.4g ms, horizon %d", words[c->model],
             c->residual ? " and residual" : "", m[0], m[1], m[2], m[3],
             1e3 * controlling->model.step, c->horizon);
    return status;
}

/* ---- surroundings -----------------------------------------------------------------------------
 */

static double of_line(const void *context, const double a[3], const double b[3])
{
    return environment_segment(context, a, b, INFINITY);
}

static ad_status open_surroundings(controlling *controlling, ad_error *error)
{
    const control_settings *c = &controlling->nominal->control;
    bool wanted = false;
    for (int i = 0; i < c->limit_count; i++) {
        wanted = wanted || c->limits[i].what == CONTROL_CLEARANCE;
    }
    if (!wanted) {
        return AD_OK;
    }
    ad_status status = environment_open(&c->environment, scene_length(&controlling->nominal->scene),
                                        &controlling->environment, error);
    if (status == AD_OK) {
        status = surface_tree_create(environment_surface(controlling->environment),
                                     c->environment.side, &controlling->tree, error);
    }
    if (status == AD_OK) {
        controlling->around =
            (surroundings){&controlling->tree->tree, of_line, controlling->environment};
    }
    return status;
}

/* ---- running ------------------------------------------------------------------------------- */

static void add(controlling *controlling, const char *name, const control_settings *control)
{
    controlling->rows[controlling->count++] = (control_row){.name = name, .control = *control};
}

static void choose_rows(controlling *controlling)
{
    static const char *const names[] = {"", "one-step model", "reduced rod", "linear model"};
    const control_settings *c = &controlling->nominal->control;
    control_settings other = *c;
    add(controlling, names[c->model], c);
    if (!controlling->asked.compare) {
        return;
    }
    if (c->residual) {
        other.residual = NULL;
        add(controlling, "without residual", &other);
        other = *c;
    }
    if (c->estimate_count > 0) {
        other.estimate_count = 0;
        add(controlling, "nothing estimated", &other);
        other = *c;
    }
    if (c->model != CONTROL_LINEAR && controlling->nominal->scene.memory_count == 0) {
        other.model = CONTROL_LINEAR;
        add(controlling, names[CONTROL_LINEAR], &other);
        other = *c;
    }
    if (c->model != CONTROL_REDUCED) {
        other.model = CONTROL_REDUCED;
        add(controlling, names[CONTROL_REDUCED], &other);
    }
}

static loop_setup setup_of(const controlling *controlling, const control_settings *control)
{
    return (loop_setup){.control = control,
                        .model = &controlling->model,
                        .nominal = &controlling->nominal->scene,
                        .plant = controlling->plant ? &controlling->plant->scene : NULL,
                        .truth = controlling->truth,
                        .around = controlling->tree ? &controlling->around : NULL,
                        .surrogate = controlling->trained ? &controlling->step : NULL,
                        .inner = controlling->inner ? &controlling->inner_step : NULL};
}

static ad_status run_row(controlling *controlling, control_row *row, ad_error *error)
{
    const loop_setup setup = setup_of(controlling, &row->control);
    ad_status status = loop_create(&setup, &row->loop, error);
    return status == AD_OK ? loop_run(row->loop, &row->report, error) : status;
}

static ad_status run_replays(controlling *controlling, ad_error *error)
{
    const options *o = &controlling->asked;
    const loop_setup setup = setup_of(controlling, &controlling->nominal->control);
    const control_model model = setup.control->model;
    if (model == CONTROL_LINEAR ||
        (model == CONTROL_SURROGATE && setup.model->hold != SURROGATE_RAMP)) {
        return config_refuse(controlling->nominal, "control.model",
                             "holds inputs while a step lasts, and those of a recording go "
                             "linearly; allowed: reduced, or a model of surrogate.hold: linear",
                             error);
    }
    ad_status status =
        replays_run(controlling->nominal, &setup, &o->settings, &controlling->replays, error);
    if (status == AD_OK) {
        replays_judge(controlling->nominal, &controlling->replays, &controlling->verdict);
    }
    if (status == AD_OK && !o->quiet) {
        replays_print(controlling->nominal, &controlling->replays, controlling->model_text);
        verdict_print(stdout, "", &controlling->verdict);
    }
    return status;
}

/* "control.period: ..." with its place in the file. */
static ad_status blame_key(const config *of, ad_error *error)
{
    const char *colon = strstr(error->message, ": ");
    char key[64], problem[sizeof error->message];
    if (error->status != AD_BAD_INPUT || strncmp(error->message, "control", 7) != 0 || !colon) {
        return error->status;
    }
    snprintf(key, sizeof key, "%.*s", (int)(colon - error->message), error->message);
    snprintf(problem, sizeof problem, "%s", colon + 2);
    return config_refuse(of, key, problem, error);
}

/* An option that would do nothing is refused. */
static ad_status check_options(const options *o, ad_error *error)
{
    const char *of_loop = o->compare  ? "--compare"
                          : o->out    ? "--out"
                          : o->shapes ? "--shapes"
                          : o->c      ? "--c"
                                      : NULL;
    const char *of_replay = o->settings.drift > 0       ? "--drift"
                            : o->settings.fade > 0      ? "--fade"
                            : !isnan(o->settings.ahead) ? "--ahead"
                                                        : NULL;
    const char *wrong = o->replay ? of_loop : of_replay;
    return wrong ? ad_fail(error, AD_BAD_INPUT, "%s: is of a %s; allowed: %s --replay", wrong,
                           o->replay ? "simulated loop" : "replay", o->replay ? "without" : "with")
                 : AD_OK;
}

static ad_status run(controlling *controlling, ad_error *error)
{
    options *o = &controlling->asked;
    ad_status status = check_options(o, error);
    o->settings.ahead = isnan(o->settings.ahead) ? 1 : o->settings.ahead;
    status = status == AD_OK && o->out ? table_check_path(o->out, error) : status;
    status = status == AD_OK ? json_check_path(o->json, error) : status;
    status = status == AD_OK && o->shapes ? shapes_check_path(o->shapes, error) : status;
    if (status == AD_OK) {
        status = prepare_read_robot(o->config, o->overrides.count, o->overrides.texts,
                                    &controlling->nominal, o->replay ? NULL : &controlling->plant,
                                    error);
    }
    if (status == AD_OK && o->seed >= 0) {
        controlling->nominal->control.seed = o->seed;
    }
    if (status == AD_OK && !o->quiet) {
        scene_line_implausible(&controlling->nominal->scene);
    }
    status = status == AD_OK ? open_surroundings(controlling, error) : status;
    status = status == AD_OK ? find_model(controlling, error) : status;
    if (status != AD_OK) {
        return controlling->nominal ? blame_key(controlling->nominal, error) : status;
    }
    if (o->replay) {
        return run_replays(controlling, error);
    }
    find_truth(controlling);
    choose_rows(controlling);
    for (int i = 0; i < controlling->count; i++) {
        control_row *row = &controlling->rows[i];
        status = run_row(controlling, row, &row->why);
        if (status != AD_OK && i == 0) {
            *error = row->why;
            return blame_key(controlling->nominal, error);
        }
        if (status != AD_OK) {
            loop_free(row->loop);
            row->loop = NULL;
        }
        if (i == 0 && !o->quiet) {
            control_print_head(controlling->nominal, row, controlling->model_text);
        }
    }
    control_judge(&controlling->rows[0].control, &controlling->rows[0].report,
                  &controlling->verdict);
    if (!o->quiet) {
        control_print(controlling->count, controlling->rows);
        control_print_details(&controlling->rows[0]);
    }
    const scene *plant = &controlling->plant->scene;
    status = o->out ? control_write(&controlling->rows[0], plant, o->out, error) : AD_OK;
    if (status == AD_OK && o->shapes) {
        status = control_write_shapes(&controlling->rows[0], plant, o->shapes, error);
    }
    char said[256];
    if (status == AD_OK && o->c) {
        const surrogate *plans =
            controlling->rows[0].control.model == CONTROL_SURROGATE ? controlling->trained : NULL;
        const surrogate *filters = plans && controlling->inner ? controlling->inner : plans;
        status =
            control_export(controlling->nominal, &controlling->rows[0], controlling->model_text,
                           filters, plans, o->c, o->force, said, &controlling->verdict, error);
        if (status == AD_OK && !o->quiet) {
            printf("wrote %s as C: %s\n", o->c, said);
        }
    }
    if (status == AD_OK && !o->quiet) {
        verdict_print(stdout, "", &controlling->verdict);
    }
    return status;
}

static void tell(const void *of, json *to)
{
    const controlling *controlling = of;
    json_text(to, "model", controlling->model_text);
    if (controlling->asked.replay) {
        replays_json(controlling->nominal, &controlling->replays, to);
    } else {
        control_json(controlling->count, controlling->rows, to);
    }
}

int main(int argc, char **argv)
{
    static controlling x = {.asked = {.seed = -1, .settings.ahead = NAN}};
    options *o = &x.asked;
    const cli_option list[] = {
        {"--compare", NULL, CLI_FLAG, &o->compare, 0, 0},
        {"--replay", NULL, CLI_FLAG, &o->replay, 0, 0},
        {"--ahead", "S", CLI_NUMBER, &o->settings.ahead, 1e-6, 1e6},
        {"--drift", "X", CLI_NUMBER, &o->settings.drift, 0, 1},
        {"--fade", "S", CLI_NUMBER, &o->settings.fade, 1e-3, 1e6},
        {"--out", "FILE", CLI_TEXT, &o->out, 0, 0},
        {"--shapes", "FILE", CLI_TEXT, &o->shapes, 0, 0},
        {"--c", "OUT", CLI_TEXT, &o->c, 0, 0},
        CLI_FORCE(&o->force),
        {"--run", "DIR", CLI_TEXT, &o->run, 0, 0},
        {"--inner", "DIR", CLI_TEXT, &o->inner, 0, 0},
        CLI_SEED(&o->seed),
        CLI_DATA(&o->overrides),
        CLI_SET(&o->overrides),
        CLI_JSON(&o->json),
        CLI_QUIET(&o->quiet),
    };
    const cli_program about = {program, "CONFIG.yaml", help_control, verdict_help, NULL};
    int status = cli_parse(&about, list, sizeof list / sizeof *list, argc, argv, &o->config);
    if (status != CLI_RUN) {
        return status;
    }
    o->quiet = o->quiet || json_is_printed(o->json);
    ad_error error = {.message = ""};
    const ad_status ran = run(&x, &error);
    const conclusion end = {.program = program,
                            .quiet = o->quiet,
                            .json = o->json,
                            .name = x.nominal ? x.nominal->settings.name : NULL,
                            .tell = tell,
                            .of = &x,
                            .verdict = &x.verdict};
    status = conclude(&end, ran, &error);
    for (int i = 0; i < x.count; i++) {
        loop_free(x.rows[i].loop);
    }
    surface_tree_free(x.tree);
    environment_free(x.environment);
    surrogate_one_step_free(&x.step);
    surrogate_one_step_free(&x.inner_step);
    surrogate_free(x.trained);
    surrogate_free(x.inner);
    config_free(x.nominal);
    config_free(x.plant);
    return status;
}
