#include "tools/train/balance.h"

#include "physics/solve/motion_balance.h"

#include <math.h>

typedef struct learnt {
    const scene *scene; /* the member, of a family */
    field *field;
    const double *x;
} learnt;

static ad_status learnt_motion(void *context, size_t points, const double *s, const double *t,
                               double *values, ad_error *error)
{
    const learnt *all = context;
    return field_evaluate(all->field, all->x, points, (const double *const[]){s, t}, values, error);
}

static ad_status learnt_shape(const void *context, size_t points, const double *s, double *values,
                              ad_error *error)
{
    const learnt *all = context;
    return field_evaluate(all->field, all->x, points, (const double *const[]){s}, values, error);
}

static void balance_motion(const experiment *e, learnt *all, learnt_balance *result)
{
    const domain *d = &e->model->domain;
    double times[DOMAIN_WINDOWS_MAX + 1];
    motion_balance found;
    ad_error ignored;
    field_enter(all->field, e->window, e->parameters, e->starts);
    for (int i = 0; i <= e->window + 1; i++) {
        times[i] = domain_window_time(d, i) * d->coordinates[d->time].scale;
    }
    if (motion_balance_of(all->scene, e->window + 2, times, learnt_motion, all, &found, &ignored) ==
        AD_OK) {
        result->energy = found.energy;
        result->momentum = found.momentum;
    }
}

static void balance_loads(const learnt *all, learnt_balance *result)
{
    double found;
    ad_error ignored;
    if (solve_balance(all->scene, learnt_shape, all, &found, &ignored) == AD_OK) {
        result->loads = found;
    }
}

learnt_balance experiment_balance(const experiment *e, const double *member)
{
    scene one;
    double middle[SCENE_PARAMETERS_MAX];
    member = member ? member : experiment_member_values(e, middle);
    scene_member(e->scene, member, &one);
    learnt all = {.scene = &one, .x = experiment_parameters(e)};
    learnt_balance result = {NAN, NAN, NAN};
    ad_error ignored;
    bool moves = scene_is_dynamic(e->scene);
    /* In motion terms of one's own may be forces, of which the scene does not know. */
    bool is_known = e->model->has_scene && !(moves && (e->is_lent || scene_is_beam(e->scene)));
    if (is_known && field_create(e->model, e->mlp, false, e->pool, &all.field, &ignored) == AD_OK) {
        field_member(all.field, member);
        if (moves) {
            balance_motion(e, &all, &result);
        } else {
            balance_loads(&all, &result);
        }
        field_free(all.field);
    }
    return result;
}
