#include "tools/train/session.h"

#include "autodiff/ranks.h"
#include "tools/train/clock.h"

#include <stdlib.h>
#include <string.h>

static ad_status prepare(session *s, double before, ad_status status, ad_error *error)
{
    status = status == AD_OK ? ad_pool_share(s->e->pool, s->e->settings->ranks, error) : status;
    if (status == AD_OK) {
        status = experiment_problem(s->e, &s->problem, error);
    }
    s->prepared = train_seconds() - before;
    return status == AD_OK ? reference_create(s->e, &s->known, error) : status;
}

ad_status session_prepare(const scene *rod_scene, train_settings *settings,
                          const train_origin *origin, int threads, session *s, ad_error *error)
{
    *s = (session){.e = NULL};
    double before = train_seconds();
    return prepare(s, before, experiment_create(rod_scene, settings, origin, threads, &s->e, error),
                   error);
}

ad_status session_prepare_model(physics_model *m, train_settings *settings,
                                const train_origin *origin, int threads, session *s,
                                ad_error *error)
{
    *s = (session){.e = NULL};
    double before = train_seconds();
    return prepare(s, before, experiment_of_model(m, settings, origin, threads, &s->e, error),
                   error);
}

/* ---- a trainer ----------------------------------------------------------------------------- */

static ad_status save_trainer(session *s, const file_place *place, ad_error *error)
{
    return trainer_save(s->trainer, place, error);
}

static ad_status restore_trainer(session *s, const checkpoint *file, ad_error *error)
{
    return trainer_restore(s->trainer, file, error);
}

ad_status session_start(session *s, ad_error *error)
{
    ad_status status = trainer_create(s->e, s->problem, s->known, s->prepared, &s->trainer, error);
    if (status == AD_OK) {
        s->of = (session_subject){.fit = trainer_fit(s->trainer),
                                  .origin = &s->e->origin,
                                  .text_item = experiment_text_item(s->e),
                                  .save = save_trainer,
                                  .restore = restore_trainer};
    }
    return status;
}

void session_free(session *s)
{
    trainer_free(s->trainer);
    reference_free(s->known);
    problem_free(s->problem);
    experiment_free(s->e);
}

/* ---- descents ------------------------------------------------------------------------------ */

static ad_status save_descents(session *s, const file_place *place, ad_error *error)
{
    checkpoint *file = checkpoint_create(CPINN_VERSION);
    char *text = train_origin_text(s->of.origin);
    ad_status status =
        file && text ? AD_OK : ad_fail(error, AD_NO_MEMORY, "out of memory for a checkpoint");
    if (status == AD_OK) {
        checkpoint_put_text(file, s->of.text_item, text);
        least_squares_put(s->of.context, file);
        status = place ? checkpoint_write(file, place, error) : AD_OK;
    }
    checkpoint_free(file);
    free(text);
    return status;
}

static ad_status restore_descents(session *s, const checkpoint *file, ad_error *error)
{
    return least_squares_get(s->of.context, file, error);
}

session_subject session_of_descents(least_squares *ls, const train_origin *origin)
{
    return (session_subject){.fit = &ls->fit,
                             .origin = origin,
                             .text_item = "fit/text",
                             .context = ls,
                             .save = save_descents,
                             .restore = restore_descents};
}

/* ---- ranks --------------------------------------------------------------------------------- */

/* Of several ranks the first keeps the folder. */
static bool keeps_folder(const session *s)
{
    return s->folder && ad_ranks_is_first(s->of.fit->ranks);
}

static ad_status agreed(const session *s, ad_status status, ad_error *error)
{
    return ad_ranks_status(s->of.fit->ranks, status, error);
}

/* ---- runs ---------------------------------------------------------------------------------- */

static ad_status save(session *s, ad_error *error)
{
    ad_status held = keeps_folder(s) ? run_check_held(s->folder, error) : AD_OK;
    const bool writes = keeps_folder(s) && held == AD_OK;
    const file_place place = {writes ? s->folder->checkpoint : NULL,
                              s->of.fit->settings->checkpoint_keep - 1,
                              writes ? s->folder->held : 0};
    ad_status status = s->of.save(s, writes ? &place : NULL, error); /* by all ranks */
    if (writes && status != AD_OK) {
        held = run_check_held(s->folder, error); /* removed meanwhile, perhaps */
    }
    s->last_save = train_seconds();
    s->saved_step = s->of.fit->at.step;
    return held == AD_OK ? status : held;
}

static ad_status check_same(const session *s, const checkpoint *file, ad_error *error)
{
    const train_origin *origin = s->of.origin;
    const char *text;
    int64_t stage;
    ad_status status = checkpoint_get_text(file, s->of.text_item, &text, error);
    if (status == AD_OK) {
        status = checkpoint_get_int64(file, "training/stage", &stage, 1, error);
    }
    if (status != AD_OK || origin->continues) {
        return status == AD_OK
                   ? origin->continues(origin->context, s->folder->checkpoint, text, stage, error)
                   : status;
    }
    char *now = train_origin_text(origin); /* NULL: nobody can tell */
    const bool same = !now || strcmp(now, text) == 0;
    free(now);
    return same ? AD_OK
                : ad_fail(error, AD_BAD_INPUT,
                          "%s: something else is asked for now; ask as before, or choose another "
                          "folder",
                          s->folder->checkpoint);
}

static ad_status resume_run(session *s, ad_error *error)
{
    checkpoint *file;
    ad_status status = checkpoint_open(s->folder->checkpoint, &file, error);
    if (status != AD_OK) {
        return status;
    }
    status = check_same(s, file, error);
    if (status == AD_OK) {
        status = s->of.restore(s, file, error);
    }
    checkpoint_free(file);
    return status;
}

static ad_status enter_folder(run_folder *folder, bool resume, ad_error *error)
{
    ad_status status = resume ? AD_OK : run_check_new(folder, error);
    if (status == AD_OK && !resume) {
        status = run_make_folder(folder->path, error);
    }
    if (status == AD_OK) {
        status = run_lock(folder, resume, error);
    }
    if (status == AD_OK && !resume) { /* what another process has left by now */
        status = run_check_new(folder, error);
    }
    return status;
}

static ad_status begin_files(session *s, ad_error *error)
{
    char *text = train_origin_text(s->of.origin);
    ad_status status =
        text ? run_begin(s->folder, text, &s->of.fit->rows, s->of.fit->settings->output_tensorboard,
                         error)
             : ad_fail(error, AD_NO_MEMORY, "out of memory for %s", s->folder->config);
    free(text);
    return status;
}

ad_status session_begin(session *s, run_folder *folder, bool resume, ad_error *error)
{
    s->folder = folder;
    ad_status status = keeps_folder(s) ? enter_folder(folder, resume, error) : AD_OK;
    status = agreed(s, status, error);
    if (status == AD_OK && resume) {
        status = resume_run(s, error);
    }
    if (status == AD_OK && !resume) {
        status = save(s, error);
    }
    if (status == AD_OK && keeps_folder(s)) {
        status = begin_files(s, error);
    }
    return agreed(s, status, error);
}

static bool save_is_due(const session *s)
{
    return s->of.fit->at.step % s->of.fit->settings->checkpoint_every == 0 ||
           train_seconds() - s->last_save > s->of.fit->settings->checkpoint_seconds;
}

/* After a step: whether to save now, by the clock of the first rank, and to stop, when any rank
 * wants to; `status`: of what the first has appended to its files. */
static ad_status decide(const session *s, ad_status status, bool *due, bool *stopped,
                        ad_error *error)
{
    enum { GO_ON, SAVE, STOP, FAILED };
    const int wanted = status != AD_OK                     ? FAILED + (int)status
                       : *stopped                          ? STOP
                       : keeps_folder(s) && save_is_due(s) ? SAVE
                                                           : GO_ON;
    const int now = (int)ad_ranks_largest(s->of.fit->ranks, wanted);
    *stopped = now == STOP;
    *due = now != GO_ON || s->of.fit->state != FIT_RUNNING;
    return status != AD_OK || now < FAILED
               ? status
               : ad_fail(error, (ad_status)(now - FAILED), "rank 0 could not keep the run");
}

ad_status session_train(session *s, session_stepped stepped, void *context, ad_error *error)
{
    fit *fit = s->of.fit;
    bool stopped = false, due;
    s->last_save = train_seconds();
    s->saved_step = s->of.fit->at.step;
    while (fit->state == FIT_RUNNING && !stopped) {
        ad_status status = fit_step(fit, error);
        if (status != AD_OK) {
            return status;
        }
        stopped = stepped && !stepped(context);
        if (keeps_folder(s)) {
            status = run_append(s->folder, &fit->rows, error);
        }
        status = decide(s, status, &due, &stopped, error);
        if (status == AD_OK && s->folder && due) {
            status = agreed(s, save(s, error), error);
        }
        if (status != AD_OK) {
            return status;
        }
    }
    return AD_OK;
}
