#include "tools/programs/train_surrogate.h"

#include "physics/numerics/clock.h"
#include "tools/prepare/config_session.h"
#include "tools/prepare/config_surrogate.h"
#include "tools/programs/cli.h"
#include "tools/programs/conclude.h"
#include "tools/programs/eval_rollouts.h"
#include "tools/programs/progress.h"
#include "tools/programs/signals.h"
#include "tools/surrogate/training.h"
#include "tools/train/report.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

/* Rollouts of the verdict, whose inputs training has not seen. */

typedef struct training {
    const train_surrogate_options *asked;
    config *settings;
    ad_pool *pool;
    surrogate_training *own;
    run_folder folder;
    train_origin origin;
    session s;
    verdict verdict;
    rollouts_report report;
    bool judged;
    double seconds; /* of training, when it was over */
    progress progress;
} training;

/* Of several ranks the first keeps the folder; what has become of that is the same for all. */
static bool keeps_folder(const training *t)
{
    return ad_ranks_is_first(t->asked->ranks);
}

static ad_status agreed(const training *t, ad_status status, ad_error *error)
{
    return ad_ranks_status(t->asked->ranks, status, error);
}

/* ---- the session --------------------------------------------------------------------------- */

static ad_status begin(training *t, ad_error *error)
{
    t->origin = config_origin(t->settings);
    t->s.fit = surrogate_training_fit(t->own);
    t->s.fit->origin = &t->origin;
    return session_begin(&t->s, &t->folder, t->asked->resume, error);
}

/* ---- training ------------------------------------------------------------------------------ */

static void start_progress(training *t)
{
    t->progress = progress_start(stdout, t->asked->quiet, surrogate_training_fit(t->own));
}

static void announce(training *t)
{
    const surrogate_training_info info = *surrogate_training_inspect(t->own);
    const surrogate_settings *s = &t->settings->surrogate;
    const surrogate_step *m = surrogate_training_step_of(t->own);
    char ranks[32] = "";
    if (t->asked->ranks) {
        snprintf(ranks, sizeof ranks, "%d ranks of ", t->asked->ranks->count);
    }
    if (*info.modes) {
        progress_say(&t->progress, "%s", info.modes);
    }
    progress_say(&t->progress, "%s: one-step model of %.4g ms, kind %s, %d states, %d inputs",
                 t->settings->settings.name, 1e3 * s->step, surrogate_kind_names()[s->kind],
                 m ? m->states : 0, m ? m->inputs : 0);
    progress_say(&t->progress, "%s", info.frame);
    progress_say(&t->progress, "%zu parameters, %zu steps solved in %.2f s, %s%d thread%s -> %s",
                 info.parameters, info.solved, info.prepared, ranks, ad_pool_threads(t->pool),
                 ad_pool_threads(t->pool) == 1 ? "" : "s", t->folder.path);
    if (t->asked->resume) {
        progress_say(&t->progress, "resumed at step %lld, %.1f s into the run",
                     (long long)t->s.fit->at.step, fit_seconds(t->s.fit));
    }
}

/* ---- the verdict --------------------------------------------------------------------------- */

static ad_status judge(training *t, ad_error *error)
{
    surrogate *s = NULL;
    ad_status status = surrogate_load(t->folder.checkpoint, &s, error);
    if (status == AD_OK) {
        status = eval_rollouts_judge(s, EVAL_ROLLOUTS_JUDGED,
                                     t->settings->settings.seed + EVAL_ROLLOUTS_SEED, t->pool,
                                     &t->report, error);
    }
    if (status == AD_OK) {
        const fit *f = t->s.fit;
        t->judged = true;
        eval_rollouts_verdict(&t->report, &s->settings, f->loss, f->held_out, &t->verdict);
    }
    surrogate_free(s);
    return status;
}

static void finish(training *t)
{
    const fit *f = t->s.fit;
    if (!t->asked->quiet) {
        progress_say(
            &t->progress,
            "done: %lld steps in %.2f s%s%s, loss %.3e, held-out %.3e of that of the linear "
            "map",
            (long long)f->at.step, t->seconds, f->ended ? ": " : "", f->ended ? f->ended : "",
            f->loss, f->held_out);
        eval_rollouts_print(stdout, &t->report);
        verdict_print(stdout, "", &t->verdict);
        printf("\n  %s\n  %s\n  %s\n\n  cpinn-eval %s --rollouts %d\n", t->folder.checkpoint,
               t->folder.history, t->folder.config, t->folder.path, EVAL_ROLLOUTS_JUDGED);
    }
}

static void interrupted(training *t)
{
    t->verdict.signal = (int)ad_ranks_largest(t->asked->ranks, signals_caught());
    verdict_add(&t->verdict, VERDICT_SIGNAL, "stopped at step %lld and saved; --resume goes on",
                (long long)t->s.saved_step);
    progress_say(&t->progress, "stopped at step %lld and saved; --resume with --out %s goes on",
                 (long long)t->s.saved_step, t->folder.path);
}

/* ---- the whole ----------------------------------------------------------------------------- */

static void explain_network(const surrogate_settings *s, const train_settings *settings)
{
    const nn_mlp_settings *network = &settings->network;
    printf("A linear map by least squares, and a network (");
    for (int i = 0; i < network->hidden_count; i++) {
        printf("%s%d", i ? " x " : "", network->hidden[i]);
    }
    printf(
        ") for what it leaves over, in\nthe frame of the robot's symmetry, if there is one; errors "
        "count by what they do to the tip\nover all that follow; output layer by least squares "
        "in every evaluation.\n\n");
    if (s->kind == SURROGATE_POLYNOMIAL) {
        printf("Both are of the three nodes of Radau's method, whose values have no defect of the "
               "rod's\nequations.\n\n");
    }
    for (int i = 0; i < settings->stage_count; i++) {
        printf("  stage %d: %s, up to %d steps\n", i + 1,
               optim_method_name(settings->stages[i].optim.method), settings->stages[i].steps);
    }
}

#define SEEN_TEXT(value, text) text,
/* What cpinn-control would do with it. */
static void explain_control(const control_settings *c)
{
    static const char *const tasks[] = {"a circle", "a figure eight", "set points", "a file"};
    static const char *const seen[] = {CONTROL_SEEN_LIST(SEEN_TEXT)};
    printf("\nClosed loop (cpinn-control): the place at %.4g m follows %s, in periods of %.4g ms; "
           "measured:",
           c->track_at, tasks[c->task.path], 1e3 * c->period);
    for (int i = 0; i < c->measurement_count; i++) {
        const control_measurement *m = &c->measurements[i];
        printf("%s %s at %.4g m", i ? "," : "", seen[m->what], m->at);
    }
    printf("; estimated:");
    for (int i = 0; i < c->estimate_count; i++) {
        printf("%s %s", i ? "," : "", c->estimate[i]);
    }
    printf("%s.\n", c->estimate_count > 0 ? "" : " nothing");
}

static void explain(training *t)
{
    const surrogate_settings *s = &t->settings->surrogate;
    const train_settings *settings = &t->settings->settings;
    const scene *open = &t->settings->scene;
    printf("%s: a one-step model of %.4g ms, kind %s; inputs %s within a step\n\n", settings->name,
           1e3 * s->step, surrogate_kind_names()[s->kind],
           s->hold == SURROGATE_RAMP ? "go linearly" : "are held");
    for (int i = 0; i < open->parameter_count; i++) {
        const scene_parameter *p = &open->parameters[i];
        printf("  %-12s %-18s %g to %g\n", p->name,
               surrogate_names_parameter(s, p->name) ? "parameter, slow" : "input", p->low,
               p->high);
    }
    if (s->modes[0] + s->modes[1] + s->modes[2] + s->modes[3] > 0) {
        printf("\nreduced rod of %d bending, %d twist, %d stretch, %d shear modes, as given\n",
               s->modes[0], s->modes[1], s->modes[2], s->modes[3]);
    } else {
        printf("\nmodes of the reduced rod: the fewest within %.2g %% of the length (median of the "
               "tip)\n",
               100 * s->tolerance);
    }
    printf(
        "\n%d steps are solved in rollouts under steps, ramps, bang-bang and chirps, and a tenth "
        "as\nmany held out. ",
        s->solved);
    if (s->kind == SURROGATE_LINEAR) {
        printf("A linear map by least squares is all.\n");
    } else {
        explain_network(s, settings);
    }
    printf("\nA verdict at the end: %d fresh rollouts of 5 s and of 1,000 steps beside the "
           "solver.\n",
           EVAL_ROLLOUTS_JUDGED);
    if (config_controls(t->settings)) {
        explain_control(&t->settings->control);
    }
}

static void tell(const void *of, json *to)
{
    const training *t = of;
    if (t->own) {
        const surrogate_training_info info = *surrogate_training_inspect(t->own);
        const fit *f = surrogate_training_fit(t->own);
        json_integer(to, "step", f->at.step);
        json_integer(to, "stage", f->at.stage);
        json_integer(to, "stages", t->settings->settings.stage_count);
        json_number(to, "training_seconds", t->seconds);
        json_number(to, "prepared_seconds", info.prepared);
        json_integer(to, "parameters", (int64_t)info.parameters);
        json_integer(to, "solved", (int64_t)info.solved);
        json_text(to, "frame", info.frame);
        json_number(to, "loss", f->loss);
        json_number(to, "held_out", f->held_out);
        json_text(to, "checkpoint", t->folder.checkpoint);
        json_text(to, "history", t->folder.history);
        json_text(to, "config", t->folder.config);
    }
    if (t->judged) {
        const rollouts_row *row = &t->report.rows[ROLLOUTS_MODEL];
        json_number(to, "one_step_median", row->error[ROLLOUTS_ONE][ROLLOUTS_MEDIAN]);
        json_number(to, "one_step_worst", row->error[ROLLOUTS_ONE][ROLLOUTS_WORST]);
        json_number(to, "rollout_median", row->error[ROLLOUTS_SHORT][ROLLOUTS_MEDIAN]);
        json_number(to, "rollout_worst", row->error[ROLLOUTS_SHORT][ROLLOUTS_WORST]);
        row = &t->report.rows[ROLLOUTS_FINER];
        json_number(to, "modes_median", row->error[ROLLOUTS_SHORT][ROLLOUTS_MEDIAN]);
        json_number(to, "modes_worst", row->error[ROLLOUTS_SHORT][ROLLOUTS_WORST]);
        json_integer(to, "diverged", t->report.rows[ROLLOUTS_MODEL].diverged);
        json_integer(to, "lost", t->report.lost);
    }
}

static ad_status go(training *t, bool *began, ad_error *error)
{
    char path[3900];
    snprintf(path, sizeof path, "runs/%s", t->settings->settings.name);
    ad_status status = run_name(&t->folder, t->asked->out ? t->asked->out : path, error);
    if (status == AD_OK && !t->asked->resume && keeps_folder(t)) {
        status = run_check_new(&t->folder, error);
    }
    status = agreed(t, status, error);
    status = status == AD_OK ? ad_pool_open(t->asked->threads, &t->pool, error) : status;
    status = status == AD_OK ? ad_pool_share(t->pool, t->asked->ranks, error) : status;
    if (status == AD_OK) {
        status = surrogate_training_create(&t->settings->scene, &t->settings->surrogate,
                                           &t->settings->settings, t->pool, &t->own, error);
    }
    status = status == AD_OK ? begin(t, error) : status;
    *began = status == AD_OK;
    if (status == AD_OK) {
        start_progress(t);
        announce(t);
        signals_catch();
        status = progress_train(&t->progress, &t->s, error);
        t->seconds = fit_seconds(t->s.fit);
    }
    if (status == AD_OK && t->s.fit->state == FIT_RUNNING) {
        interrupted(t);
        return AD_OK;
    }
    status = status == AD_OK ? judge(t, error) : status;
    if (status == AD_OK) {
        finish(t);
    } else if (*began) {
        progress_say(&t->progress, "stopped; the checkpoint of step %lld is kept: %s",
                     (long long)t->s.saved_step, t->folder.checkpoint);
    }
    return status;
}

int train_surrogate(const train_surrogate_options *asked, config *settings)
{
    training t = {.asked = asked, .settings = settings};
    ad_error error = {AD_OK, ""};
    bool began = false;
    if (asked->explain) {
        explain(&t);
        config_free(settings);
        return 0;
    }
    const ad_status status = go(&t, &began, &error);
    const conclusion end = {.program = asked->program,
                            .quiet = asked->quiet,
                            .json = asked->json,
                            .name = settings->settings.name,
                            .tell = tell,
                            .of = &t,
                            .verdict = &t.verdict};
    const int ended = conclude(&end, status, &error);
    run_end(&t.folder);
    rollouts_free(&t.report);
    surrogate_training_free(t.own);
    ad_pool_free(t.pool);
    config_free(settings);
    return ended;
}
