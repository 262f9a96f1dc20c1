#include "tools/train/session.h"

#include "tools/train/clock.h"

ad_status session_create(config *settings, int threads, session *s, ad_error *error)
{
    *s = (session){.e = NULL};
    double before = wall_seconds();
    ad_status status = experiment_create(settings, threads, &s->e, error);
    if (status == AD_OK) {
        status = problem_create(&settings->scene, s->e->mlp, &settings->losses, settings->seed,
                                s->e->pool, &s->problem, error);
    }
    double spent = wall_seconds() - before;
    if (status == AD_OK) {
        status = reference_create(s->e, &s->known, error);
    }
    if (status == AD_OK) {
        status = trainer_create(s->e, s->problem, s->known, spent, &s->trainer, error);
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
