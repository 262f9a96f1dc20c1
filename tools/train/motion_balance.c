#include "tools/train/motion_balance.h"

#include <math.h>

typedef struct learnt {
    field *field;
    const double *x;
} learnt;

static ad_status learnt_motion(void *context, size_t points, const double *s, const double *t,
                               double *values, ad_error *error)
{
    const learnt *motion = context;
    return field_evaluate(motion->field, motion->x, points, (const double *const[]){s, t}, values,
                          error);
}

/* Terms of one's own may be forces, of which the scene does not know. */
static bool is_of_scene(const experiment *e)
{
    return e->model->has_scene && !e->is_lent && scene_is_dynamic(e->scene) &&
           !scene_is_beam(e->scene);
}

motion_balance experiment_motion_balance(const experiment *e)
{
    const domain *d = &e->model->domain;
    double times[DOMAIN_WINDOWS_MAX + 1];
    learnt motion = {.x = experiment_parameters(e)};
    motion_balance balance = {NAN, NAN};
    ad_error ignored;
    if (!is_of_scene(e) ||
        field_create(e->model, e->mlp, false, e->pool, &motion.field, &ignored) != AD_OK) {
        return balance;
    }
    field_enter(motion.field, e->window, e->parameters, e->starts);
    for (int i = 0; i <= e->window + 1; i++) {
        times[i] = domain_window_time(d, i) * d->coordinates[d->time].scale;
    }
    if (motion_balance_of(e->scene, e->window + 2, times, learnt_motion, &motion, &balance,
                          &ignored) != AD_OK) {
        balance = (motion_balance){NAN, NAN};
    }
    field_free(motion.field);
    return balance;
}
