/* One case by one method. */
#include "physics/solve/solve.h"
#include "tools/config/config_session.h"
#include "tools/judge/cases/cases.h"
#include "tools/judge/child.h"
#include "tools/judge/compare/compare.h"
#include "tools/train/clock.h"

#include <math.h>
#include <string.h>

static const double grace = 20; /* s beyond the limit, for recording and a last step */

const char *cases_method_name(cases_method method)
{
    static const char *const names[CASES_METHODS] = {"pinn", "solver"};
    return names[method];
}

const char *cases_outcome_name(cases_outcome outcome)
{
#define CASES_TEXT_OF(name, text) text,
    static const char *const names[] = {CASES_OUTCOME_LIST(CASES_TEXT_OF)};
#undef CASES_TEXT_OF
    return names[outcome];
}

/* ---- what is left out ---------------------------------------------------------------------- */

/* A word for the terms whose names begin so; told when all of these that there are, are absent. */
static const struct {
    const char *word, *terms[3];
} parts[] = {{"shear", {"shear"}},
             {"stretch", {"stretch"}},
             {"twist", {"twist"}},
             {"rotary inertia", {"rotary inertia"}},
             {"damping", {"strain damping", "curvature damping", "drag"}}};

static void add_word(char text[64], const char *word)
{
    size_t length = strlen(text);
    snprintf(text + length, 64 - length, "%s%s", length ? "; " : "", word);
}

/* Reasons that have been told otherwise: with the third dimension, with time. */
static bool is_told(const char *reason)
{
    return strcmp(reason, "planar motion") == 0 || strcmp(reason, "static scene") == 0;
}

/* Whether terms of a part are there, but none of them is present. */
static bool is_absent(const rod_term *terms, int count, int part)
{
    bool absent = false;
    for (int i = 0; i < count; i++) {
        for (int k = 0; k < 3 && parts[part].terms[k]; k++) {
            if (strncmp(terms[i].name, parts[part].terms[k], strlen(parts[part].terms[k])) != 0) {
                continue;
            }
            if (terms[i].present) {
                return false;
            }
            absent = absent || !is_told(terms[i].reason);
        }
    }
    return absent;
}

static void tell_left_out(const scene *scene, cases_row *row)
{
    rod_term terms[ROD_TERM_MAX];
    int count = scene_physics_of(scene)->terms(scene, terms);
    if (!scene_is_dynamic(scene)) {
        add_word(row->left_out, "time");
    }
    if (row->method == CASES_SOLVER) {
        return; /* takes all rods alike */
    }
    if (!scene_is_beam(scene) && rod_plane_of(scene).is_planar) {
        add_word(row->left_out, "out of plane");
    }
    for (int i = 0; i < (int)(sizeof parts / sizeof *parts); i++) {
        if (is_absent(terms, count, i)) {
            add_word(row->left_out, parts[i].word);
        }
    }
}

/* ---- by a network -------------------------------------------------------------------------- */

static void describe(const session *s, cases_row *row)
{
    const scene *scene = s->e->scene;
    static const rod_residual_kind inside[] = {ROD_STRAIN, ROD_CURVATURE, ROD_FORCE, ROD_MOMENT};
    row->unknowns = scene_physics_of(scene)->network_outputs(scene);
    row->equations = row->instructions = 0;
    for (int i = 0; i < 4; i++) {
        row->equations += scene_physics_of(scene)->residual_rows(scene, inside[i]);
    }
    for (int i = 0; i < problem_sets(s->problem); i++) {
        row->instructions += (double)problem_set_inspect(s->problem, i).program.instructions;
    }
    row->points = (double)problem_set_inspect(s->problem, 0).points;
    tell_left_out(scene, row);
}

/* Errors of a motion count once its windows are all trained. */
static void measure(const session *s, double reading, cases_row *row)
{
    trainer_info info = trainer_inspect(s->trainer);
    row->seconds = reading + info.seconds - info.row_seconds;
    row->steps = (double)info.step;
    if (s->e->window + 1 == s->e->scene->windows) {
        row->position = info.errors.position;
        row->rotation = info.errors.rotation;
    }
}

static ad_status train(const session *s, double seconds, cases_row *row, ad_error *error)
{
    double began = train_seconds();
    ad_status status = AD_OK;
    row->outcome = CASES_SOLVED;
    while (status == AD_OK && trainer_inspect(s->trainer).state == TRAINER_RUNNING) {
        if (train_seconds() - began > seconds) {
            row->outcome = CASES_OUT_OF_TIME;
            snprintf(row->text, CASES_TEXT, "%g s in window %d of %d", seconds, s->e->window + 1,
                     s->e->scene->windows);
            return trainer_add_row(s->trainer, error);
        }
        status = trainer_step(s->trainer, error);
    }
    verdict found;
    trainer_verdict(s->trainer, &found);
    if (status != AD_OK) {
        row->outcome = CASES_STOPPED;
    } else if (verdict_outcome_of(&found) == VERDICT_WARNING) {
        row->outcome = CASES_DOUBTED;
        snprintf(row->text, CASES_TEXT, "%s", verdict_text(&found));
    }
    return status;
}

static ad_status by_network(const cases_task *task, cases_row *row, ad_error *error)
{
    config *settings;
    session s = {.e = NULL};
    double began = train_seconds();
    ad_status status = config_read(task->path, NULL, 0, NULL, &settings, error);
    double reading = train_seconds() - began;
    if (status == AD_OK) {
        status = config_session_create(settings, task->threads, &s, error);
    }
    if (status == AD_OK) {
        describe(&s, row);
        status = train(&s, task->seconds, row, error);
    }
    if (status == AD_OK) {
        measure(&s, reading, row);
    }
    session_free(&s);
    return status;
}

/* ---- by the solver ------------------------------------------------------------------------- */

typedef struct classical {
    experiment *e;
    reference *known; /* NULL: the scene names none */
    solution *solved;
    solve_report report;
} classical;

/* The scene and what it is measured with, which does not count; *reading does, in s. */
static ad_status open_scene(const char *path, classical *x, double *reading, ad_error *error)
{
    config *settings;
    double began = train_seconds();
    ad_status status = config_read(path, NULL, 0, NULL, &settings, error);
    *reading = train_seconds() - began;
    if (status == AD_OK) {
        status = config_experiment_create(settings, 1, &x->e, error);
    }
    return status == AD_OK ? reference_create(x->e, &x->known, error) : status;
}

static ad_status solve(classical *x, const solve_settings *settings, cases_row *row,
                       ad_error *error)
{
    size_t points = x->known ? reference_points(x->known) : 0;
    const double *t = x->known ? reference_t(x->known) : NULL;
    double began = train_seconds();
    ad_status status =
        solution_create(x->e->scene, settings, points, t, &x->solved, &x->report, error);
    row->seconds = status == AD_OK ? train_seconds() - began : NAN;
    return status;
}

/* Where the reference is the solver's own, its estimate is what is known of the error. */
static ad_status compare(const classical *x, cases_row *row, ad_error *error)
{
    reference_errors errors;
    ad_status status = reference_compare_solution(x->known, x->solved, &errors, error);
    if (status != AD_OK) {
        return status;
    }
    bool is_own = !isnan(reference_estimates(x->known).position);
    row->position = is_own ? fmax(errors.position, x->report.estimate) : errors.position;
    row->rotation = is_own ? NAN : errors.rotation;
    return AD_OK;
}

static ad_status conclude(const classical *x, const solve_settings *settings, double reading,
                          cases_row *row, ad_error *error)
{
    const scene *scene = x->e->scene;
    const solve_report *r = &x->report;
    bool moving = scene_is_dynamic(scene);
    verdict found = {.count = 0};
    solution_verdict(x->solved, scene, settings, r, &found);
    bool is_doubted = verdict_outcome_of(&found) != VERDICT_SOLVED;
    row->seconds += reading;
    row->points = r->nodes;
    row->steps = (double)(moving ? r->time_steps : r->newton_steps);
    snprintf(row->text, CASES_TEXT, "%s", is_doubted ? verdict_text(&found) : "");
    if (!moving && r->load_fraction < 1) {
        row->outcome = CASES_STOPPED;
        return AD_OK;
    }
    row->outcome = is_doubted ? CASES_DOUBTED : CASES_SOLVED;
    return x->known ? compare(x, row, error) : AD_OK;
}

static ad_status by_solver(const cases_task *task, cases_row *row, ad_error *error)
{
    classical x = {.e = NULL};
    double reading = 0;
    ad_status status = open_scene(task->path, &x, &reading, error);
    if (status == AD_OK) {
        const scene *scene = x.e->scene;
        const solve_settings settings = solve_settings_default(scene);
        status = solve(&x, &settings, row, error);
        if (status == AD_OK) {
            tell_left_out(scene, row);
            status = conclude(&x, &settings, reading, row, error);
        } else if (status != AD_BAD_ARGUMENT) {
            row->outcome = CASES_STOPPED;
        }
    }
    solution_free(x.solved);
    reference_free(x.known);
    experiment_free(x.e);
    return status;
}

/* ---- in a process of its own --------------------------------------------------------------- */

void cases_name(const char *path, char name[CASES_NAME])
{
    const char *slash = strrchr(path, '/'), *base = slash ? slash + 1 : path;
    const char *dot = strrchr(base, '.');
    int length = dot && dot > base ? (int)(dot - base) : (int)strlen(base);
    char text[CASES_NAME];
    snprintf(text, sizeof text, "%.*s", length, base);
    compare_name(name, text);
}

static void work(const void *task, void *result)
{
    const cases_task *asked = task;
    cases_row *row = result;
    ad_error error = {AD_OK, ""};
    ad_status status = asked->method == CASES_PINN ? by_network(asked, row, &error)
                                                   : by_solver(asked, row, &error);
    if (status != AD_OK) {
        snprintf(row->text, CASES_TEXT, "%s", error.message);
    }
}

ad_status cases_run(const cases_task *task, cases_row *row, ad_error *error)
{
    child_end end;
    char why[CHILD_WHY];
    double began = train_seconds();
    *row = (cases_row){.method = task->method,
                       .outcome = CASES_REFUSED,
                       .position = NAN,
                       .rotation = NAN,
                       .seconds = NAN,
                       .unknowns = NAN,
                       .equations = NAN,
                       .instructions = NAN,
                       .points = NAN,
                       .steps = NAN};
    cases_name(task->path, row->name);
    ad_status status =
        child_run(work, task, row, sizeof *row, task->seconds + grace, &end, why, error);
    if (status != AD_OK || end == CHILD_TOLD) {
        return status;
    }
    row->seconds = train_seconds() - began;
    row->outcome = end == CHILD_LATE ? CASES_OUT_OF_TIME : CASES_CRASHED;
    snprintf(row->text, CASES_TEXT, "%s", end == CHILD_LATE ? "killed" : why);
    return AD_OK;
}
