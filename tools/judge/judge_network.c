/* A scene by a network, trained as cpinn-train does it. */
#include "tools/judge/judge.h"
#include "tools/judge/signals.h"

/* Of training, without its rows of history. */
static double seconds_spent(const session *s)
{
    return fit_seconds(trainer_fit(s->trainer)) - trainer_inspect(s->trainer)->row_seconds;
}

static ad_status train(session *s, const judge_task *task, verdict *found, ad_error *error)
{
    ad_status status = AD_OK;
    while (status == AD_OK && trainer_fit(s->trainer)->state == FIT_RUNNING) {
        if (signals_caught()) {
            found->signal = signals_caught();
            verdict_add(found, VERDICT_SIGNAL, "stopped");
            break;
        }
        if (seconds_spent(s) >= task->seconds) {
            verdict_add(found, VERDICT_TIME_LIMIT, "%g s in window %d of %d", task->seconds,
                        s->e->window + 1, s->e->scene->windows);
            break;
        }
        status = trainer_step(s->trainer, error);
        if (status == AD_OK && task->step) {
            status = task->step(task->context, s, false, error);
        }
    }
    return status;
}

/* A row of history for the last step. */
static ad_status last_row(const session *s, ad_error *error)
{
    const history *h = &trainer_fit(s->trainer)->rows;
    double step = (double)trainer_fit(s->trainer)->at.step;
    bool is_there = h->count > 0 && history_value(h, h->count - 1, "step") == step;
    return is_there || step == 0 ? AD_OK : trainer_add_row(s->trainer, error);
}

/* Errors of a motion count once its windows are all trained. */
static ad_status conclude(session *s, const judge_task *task, judge_row *row, ad_error *error)
{
    ad_status status = last_row(s, error);
    const fit *f = trainer_fit(s->trainer);
    const trainer_info *info = trainer_inspect(s->trainer);
    if (status == AD_OK && s->e->window + 1 == s->e->scene->windows) {
        judge_measures(&info->errors, row->errors);
    }
    if (status == AD_OK && task->step) {
        status = task->step(task->context, s, true, error);
    }
    if (status == AD_OK && f->state == FIT_OVER) {
        trainer_verdict(s->trainer, &row->verdict);
    }
    return status;
}

ad_status judge_by_network(const judge_task *task, judge_row *row, ad_error *error)
{
    config *settings;
    session s = {.e = NULL};
    double reading = 0;
    ad_status status = judge_read(task, &settings, &reading, error);
    if (status == AD_OK) {
        status = config_session_create(settings, task->threads, &s, error);
    }
    if (status != AD_OK) {
        verdict_add(&row->verdict, status == AD_NO_MEMORY ? VERDICT_FAILED : VERDICT_BAD_INPUT,
                    "%s", error->message);
    } else {
        judge_describe(&s, row);
        status = train(&s, task, &row->verdict, error);
        row->seconds = reading + seconds_spent(&s);
        row->steps = (double)trainer_fit(s.trainer)->at.step;
        status = status == AD_OK ? conclude(&s, task, row, error) : status;
        if (status != AD_OK) {
            verdict_add(&row->verdict,
                        status == AD_NOT_FINITE ? VERDICT_NOT_FINITE : VERDICT_FAILED, "%s",
                        error->message);
        }
    }
    session_free(&s);
    return status;
}
