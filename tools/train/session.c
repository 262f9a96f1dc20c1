#include "tools/train/session.h"

#include "tools/train/clock.h"

ad_status session_prepare(const scene *rod_scene, train_settings *settings,
                          const train_origin *origin, int threads, session *s, ad_error *error)
{
    *s = (session){.e = NULL};
    double before = wall_seconds();
    ad_status status = experiment_create(rod_scene, settings, origin, threads, &s->e, error);
    if (status == AD_OK) {
        status = experiment_problem(s->e, &s->problem, error);
    }
    s->prepared = wall_seconds() - before;
    return status == AD_OK ? reference_create(s->e, &s->known, error) : status;
}

ad_status session_start(session *s, ad_error *error)
{
    return trainer_create(s->e, s->problem, s->known, s->prepared, &s->trainer, error);
}

void session_free(session *s)
{
    trainer_free(s->trainer);
    reference_free(s->known);
    problem_free(s->problem);
    experiment_free(s->e);
}
