#include "tools/train/session.h"

#include "autodiff/ranks.h"
#include "physics/numerics/clock.h"

#include <stdlib.h>
#include <string.h>

static ad_status prepare(session *s, double before, ad_status status, ad_error *error)
{
    status = status == AD_OK ? ad_pool_share(s->e->pool, s->e->settings->ranks, error) : status;
    if (status == AD_OK) {
        status = experiment_problem(s->e, &s->problem, error);
    }
    s->prepared = clock_seconds(CLOCK_MONOTONIC) - before;
    return status == AD_OK ? reference_create(s->e, &s->known, error) : status;
}

ad_status session_prepare(const scene *rod_scene, train_settings *settings,
                          const train_origin *origin, int threads, session *s, ad_error *error)
{
    *s = (session){.e = NULL};
    double before = clock_seconds(CLOCK_MONOTONIC);
    return prepare(s, before, experiment_create(rod_scene, settings, origin, threads, &s->e, error),
                   error);
}

ad_status session_prepare_model(physics_model *m, train_settings *settings,
                                const train_origin *origin, int threads, session *s,
                                ad_error *error)
{
    *s = (session){.e = NULL};
    double before = clock_seconds(CLOCK_MONOTONIC);
    return prepare(s, before, experiment_of_model(m, settings, origin, threads, &s->e, error),
                   error);
}

/* ---- a trainer ----------------------------------------------------------------------------- */

ad_status session_start(session *s, ad_error *error)
{
    ad_status status = trainer_create(s->e, s->problem, s->known, s->prepared, &s->trainer, error);
    s->fit = status == AD_OK ? trainer_fit(s->trainer) : NULL;
    return status;
}

void session_free(session *s)
{
    trainer_free(s->trainer);
    reference_free(s->known);
    problem_free(s->problem);
    experiment_free(s->e);
}

/* ---- ranks --------------------------------------------------------------------------------- */

/* Of several ranks the first keeps the folder. */
static bool keeps_folder(const session *s)
{
    return s->folder && ad_ranks_is_first(s->fit->ranks);
}

static ad_status agreed(const session *s, ad_status status, ad_error *error)
{
    return ad_ranks_status(s->fit->ranks, status, error);
}

/* ---- runs ---------------------------------------------------------------------------------- */

static ad_status save(session *s, ad_error *error)
{
    ad_status held = keeps_folder(s) ? run_check_held(s->folder, error) : AD_OK;
    const bool writes = keeps_folder(s) && held == AD_OK;
    const file_place place = {writes ? s->folder->checkpoint : NULL,
                              s->fit->settings->checkpoint_keep - 1, writes ? s->folder->held : 0};
    ad_status status = fit_save(s->fit, writes ? &place : NULL, error); /* by all ranks */
    if (writes && status != AD_OK) {
        held = run_check_held(s->folder, error); /* removed meanwhile, perhaps */
    }
    s->last_save = clock_seconds(CLOCK_MONOTONIC);
    s->saved_step = s->fit->at.step;
    return held == AD_OK ? status : held;
}

static ad_status check_same(const session *s, const checkpoint *file, ad_error *error)
{
    const train_origin *origin = s->fit->origin;
    const char *text;
    int64_t stage;
    ad_status status = checkpoint_get_text(file, s->fit->text_item, &text, error);
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
        status = fit_restore(s->fit, file, error);
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
    char *text = train_origin_text(s->fit->origin);
    ad_status status =
        text ? run_begin(s->folder, text, &s->fit->rows, error)
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
    return s->fit->at.step % s->fit->settings->checkpoint_every == 0 ||
           clock_seconds(CLOCK_MONOTONIC) - s->last_save > s->fit->settings->checkpoint_seconds;
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
    const int now = (int)ad_ranks_largest(s->fit->ranks, wanted);
    *stopped = now == STOP;
    *due = now != GO_ON || s->fit->state != FIT_RUNNING;
    return status != AD_OK || now < FAILED
               ? status
               : ad_fail(error, (ad_status)(now - FAILED), "rank 0 could not keep the run");
}

ad_status session_train(session *s, session_stepped stepped, void *context, ad_error *error)
{
    fit *fit = s->fit;
    bool stopped = false, due;
    s->last_save = clock_seconds(CLOCK_MONOTONIC);
    s->saved_step = s->fit->at.step;
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
