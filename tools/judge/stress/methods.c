/* What each method makes of a row. */
#include "tools/judge/stress/methods.h"

#include "physics/solve/solve.h"
#include "tools/config/config_session.h"
#include "tools/train/clock.h"

#include <errno.h>
#include <math.h>
#include <stdlib.h>
#include <string.h>
#include <time.h>

/* ---- the scene ----------------------------------------------------------------------------- */

/* The files beside it. */
static ad_status write_files(const stress_row *row, const char *folder, ad_error *error)
{
    char path[4096];
    if (!row->file && !row->write) {
        return AD_OK;
    }
    snprintf(path, sizeof path, "%s/reference.csv", folder);
    FILE *file = fopen(path, "w");
    if (!file) {
        return ad_fail(error, AD_IO, "%s: %s", path, strerror(errno));
    }
    if (row->file) {
        fputs(row->file, file);
    } else {
        row->write(file);
    }
    return fclose(file) == 0 ? AD_OK : ad_fail(error, AD_IO, "%s: %s", path, strerror(errno));
}

static ad_status read_scene(const stress_row *row, stress_method method, const char *folder,
                            config **settings, ad_error *error)
{
    char path[4096];
    const char *overrides[STRESS_OVERRIDES_MAX + 1];
    int count = 0;
    while (count < STRESS_OVERRIDES_MAX && row->overrides[count]) {
        overrides[count] = row->overrides[count];
        count++;
    }
    if (method == STRESS_SOLVER && row->solver_override) {
        overrides[count++] = row->solver_override;
    }
    snprintf(path, sizeof path, "%s/scene.yaml", folder);
    ad_status status = write_files(row, folder, error);
    return status == AD_OK ? config_read(path, row->scene, count, overrides, settings, error)
                           : status;
}

/* ---- what was found ------------------------------------------------------------------------ */

struct stress_answer {
    const scene *scene;
    field *trained; /* one of the two */
    const double *parameters;
    const solution *solved;
    reference_errors errors; /* NaN without a reference */
    double estimate;         /* of the solver; NaN of a network */
};

const scene *stress_scene(const stress_answer *a)
{
    return a->scene;
}

reference_errors stress_errors(const stress_answer *a)
{
    return a->errors;
}

ad_status stress_values(const stress_answer *a, size_t points, const double *s, const double *t,
                        double *values, ad_error *error)
{
    return a->trained ? field_evaluate(a->trained, a->parameters, points,
                                       (const double *const[]){s, t}, values, error)
                      : solution_evaluate(a->solved, solution_columns(a->scene), points, s, t,
                                          values, error);
}

/* The error that the row asks for; of a solution without a reference but itself, its own
 * estimate. */
static ad_status measure_of(const stress_row *row, const stress_answer *a, double *error,
                            ad_error *reason)
{
    if (row->measure) {
        return row->measure(a, error, reason);
    }
    *error = isnan(a->errors.position) ? a->estimate : a->errors.position;
    return AD_OK;
}

/* What the user is left with: a doubt, which `text` of the result then holds, or a solution. */
static void conclude(const stress_row *row, stress_method method, const stress_answer *a,
                     bool is_doubted, stress_result *result)
{
    ad_error error = {AD_OK, ""};
    const stress_expectation *expected = &row->expected[method];
    if (measure_of(row, a, &result->error, &error) != AD_OK) {
        result->outcome = STRESS_STOPPED;
        snprintf(result->text, sizeof result->text, "%s", error.message);
        return;
    }
    bool right = expected->outcome == STRESS_SOLVED && result->error <= expected->bound;
    result->outcome = is_doubted ? STRESS_DOUBTED : right ? STRESS_SOLVED : STRESS_WRONG;
}

/* ---- by a network -------------------------------------------------------------------------- */

/* Whether the time was enough; it is that of the processor, which others do not shorten. */
static ad_status train(session *s, double seconds, bool *ended, ad_error *error)
{
    clock_t until = clock() + (clock_t)(seconds * CLOCKS_PER_SEC);
    ad_status status = AD_OK;
    *ended = true;
    while (status == AD_OK && trainer_inspect(s->trainer).state == TRAINER_RUNNING) {
        if (clock() > until) {
            *ended = false;
            return AD_OK;
        }
        status = trainer_step(s->trainer, error);
    }
    return status;
}

static ad_status judge_training(const stress_row *row, session *s, stress_result *result,
                                ad_error *error)
{
    const experiment *e = s->e;
    trainer_info info = trainer_inspect(s->trainer);
    stress_answer answer = {.scene = e->scene,
                            .parameters = experiment_parameters(e),
                            .errors = {NAN, NAN, NAN, NAN, NAN},
                            .estimate = NAN};
    if (s->known) {
        answer.errors = info.errors;
    }
    ad_status status = field_create(e->model, e->mlp, false, e->pool, &answer.trained, error);
    if (status == AD_OK) {
        field_enter(answer.trained, e->window, e->parameters, e->starts);
        snprintf(result->text, sizeof result->text, "held-out loss %.1e", info.held_out);
        verdict found;
        trainer_verdict(s->trainer, &found);
        bool is_doubted = verdict_outcome_of(&found) == VERDICT_WARNING;
        if (is_doubted) {
            snprintf(result->text, sizeof result->text, "%s: %s",
                     verdict_reason_name(verdict_worst(&found)), verdict_text(&found));
        }
        conclude(row, STRESS_PINN, &answer, is_doubted, result);
    }
    field_free(answer.trained);
    return status;
}

static ad_status run_pinn(const stress_row *row, const char *folder, stress_result *result,
                          ad_error *error)
{
    config *settings;
    session s = {.e = NULL};
    bool ended = true;
    ad_status status = read_scene(row, STRESS_PINN, folder, &settings, error);
    if (status == AD_OK) {
        status = config_session_create(settings, 1, &s, error);
    }
    if (status == AD_OK) {
        result->outcome = STRESS_STOPPED;
        status = train(&s, stress_limit(row), &ended, error);
    }
    if (status == AD_OK && ended) {
        result->seconds = trainer_inspect(s.trainer).seconds;
        status = judge_training(row, &s, result, error);
    } else if (status == AD_OK) {
        result->outcome = STRESS_OUT_OF_TIME;
    }
    session_free(&s);
    return status;
}

/* ---- by the solver ------------------------------------------------------------------------- */

typedef struct classical {
    experiment *e;
    reference *known; /* NULL: the scene names none */
    double *times;    /* those of the reference, then STRESS_INSTANTS */
    solution *solved;
    solve_report report;
} classical;

static ad_status solve(classical *x, const solve_settings *settings, ad_error *error)
{
    const scene *rod_scene = x->e->scene;
    size_t points = x->known ? reference_points(x->known) : 0, count = points + STRESS_INSTANTS;
    x->times = calloc(count, sizeof *x->times);
    if (!x->times) {
        return ad_fail(error, AD_NO_MEMORY, "out of memory for %zu times", count);
    }
    if (x->known) {
        memcpy(x->times, reference_t(x->known), points * sizeof *x->times);
    }
    stress_instants(rod_scene, x->times + points);
    return solution_create(rod_scene, settings, count, x->times, &x->solved, &x->report, error);
}

static ad_status judge_solution(const stress_row *row, const classical *x,
                                const solve_settings *settings, stress_result *result,
                                ad_error *error)
{
    const scene *rod_scene = x->e->scene;
    stress_answer answer = {.scene = rod_scene,
                            .solved = x->solved,
                            .errors = {NAN, NAN, NAN, NAN, NAN},
                            .estimate = x->report.estimate};
    verdict found = {.count = 0};
    solution_verdict(x->solved, rod_scene, settings, &x->report, &found);
    bool is_doubted = verdict_outcome_of(&found) != VERDICT_SOLVED;
    snprintf(result->text, sizeof result->text, "%s: %s",
             verdict_reason_name(verdict_worst(&found)), verdict_text(&found));
    if (!scene_is_dynamic(rod_scene) && x->report.load_fraction < 1) {
        return AD_OK; /* stopped */
    }
    ad_status status =
        x->known ? reference_compare_solution(x->known, x->solved, &answer.errors, error) : AD_OK;
    if (status == AD_OK) {
        conclude(row, STRESS_SOLVER, &answer, is_doubted, result);
    }
    return status;
}

static ad_status run_solver(const stress_row *row, const char *folder, stress_result *result,
                            ad_error *error)
{
    config *settings;
    classical x = {.e = NULL};
    ad_status status = read_scene(row, STRESS_SOLVER, folder, &settings, error);
    if (status == AD_OK) {
        status = config_experiment_create(settings, 1, &x.e, error);
    }
    if (status == AD_OK && isnan(x.e->settings->reference_tolerance)) {
        status = reference_create(x.e, &x.known, error);
    }
    if (status == AD_OK) {
        solve_settings asked = solve_settings_default(x.e->scene);
        asked.tolerance = row->tolerance > 0 ? row->tolerance : asked.tolerance;
        double began = train_seconds();
        status = solve(&x, &asked, error);
        result->seconds = train_seconds() - began;
        if (status != AD_BAD_ARGUMENT) {
            result->outcome = STRESS_STOPPED;
        }
        if (status == AD_OK) {
            status = judge_solution(row, &x, &asked, result, error);
        }
    }
    solution_free(x.solved);
    free(x.times);
    reference_free(x.known);
    experiment_free(x.e);
    return status;
}

void stress_answer_by(stress_method method, const stress_row *row, const char *folder,
                      stress_result *result)
{
    ad_error error = {AD_OK, ""};
    result->outcome = STRESS_REFUSED;
    ad_status status = method == STRESS_PINN ? run_pinn(row, folder, result, &error)
                                             : run_solver(row, folder, result, &error);
    if (status != AD_OK) {
        snprintf(result->text, sizeof result->text, "%s", error.message);
    }
}
