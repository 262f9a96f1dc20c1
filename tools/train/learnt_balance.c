#include "tools/train/learnt_balance.h"

#include "physics/solve/error_estimate.h"
#include "physics/solve/motion_balance.h"

#include <math.h>

typedef struct learnt {
    scene one; /* the member, of a family */
    field *field;
    const double *x;
} learnt;

/* Of a shape at rest t is not read. */
static ad_status learnt_field(void *context, size_t points, const double *s, const double *t,
                              double *values, ad_error *error)
{
    const learnt *all = context;
    return field_evaluate(all->field, all->x, points, (const double *const[]){s, t}, values, error);
}

static ad_status learnt_shape(const void *context, size_t points, const double *s, double *values,
                              ad_error *error)
{
    return learnt_field((void *)context, points, s, NULL, values, error);
}

/* To the end of the window at work. */
static ad_status learnt_open(const experiment *e, const double *member, learnt *all,
                             ad_error *error)
{
    double middle[SCENE_PARAMETERS_MAX];
    member = member ? member : experiment_member_values(e, middle);
    scene_member(e->scene, member, &all->one);
    all->x = experiment_parameters(e);
    return experiment_field(e, member, &all->field, error);
}

/* When a window begins, s; the end of one is the beginning of the next. */
static double window_time(const experiment *e, int window)
{
    const domain *d = &e->model->domain;
    return domain_window_time(d, window) * d->coordinates[d->time].scale;
}

static void balance_motion(const experiment *e, learnt *all, learnt_balance *result)
{
    double times[DOMAIN_WINDOWS_MAX + 1];
    motion_balance found;
    ad_error ignored;
    for (int i = 0; i <= e->window + 1; i++) {
        times[i] = window_time(e, i);
    }
    if (motion_balance_of(&all->one, e->window + 2, times, learnt_field, all, &found, &ignored) ==
        AD_OK) {
        result->energy = found.energy;
        result->momentum = found.momentum;
    }
}

static void balance_loads(const learnt *all, learnt_balance *result)
{
    double found;
    ad_error ignored;
    if (solve_balance(&all->one, learnt_shape, all, &found, &ignored) == AD_OK) {
        result->loads = found;
    }
}

learnt_balance experiment_balance(const experiment *e, const double *member)
{
    learnt all;
    learnt_balance result = {NAN, NAN, NAN};
    ad_error ignored;
    bool moves = scene_is_dynamic(e->scene);
    /* In motion terms of one's own may be forces, of which the scene does not know. */
    bool is_known = e->model->has_scene && !(moves && (e->is_lent || scene_is_beam(e->scene)));
    if (is_known && learnt_open(e, member, &all, &ignored) == AD_OK) {
        if (moves) {
            balance_motion(e, &all, &result);
        } else {
            balance_loads(&all, &result);
        }
        field_free(all.field);
    }
    return result;
}

/* Why the solver's equations are not those that the network was trained on; NULL: they are. */
static const char *differs(const experiment *e)
{
    const rod_weights *w = &e->settings->weights;
    const bool all = w->strain > 0 && w->curvature > 0 && w->force > 0 && w->moment > 0;
    return !e->model->has_scene ? "equations of one's own have no classical solver"
           : e->is_lent         ? "of the scene's terms some are one's own, which no solver knows"
           : !all               ? "data stand for an equation whose weight is 0"
                                : NULL;
}

ad_status experiment_error(const experiment *e, const double *member, double *estimate,
                           ad_error *why)
{
    learnt all;
    const char *unknown = differs(e);
    *estimate = NAN;
    if (unknown) {
        ad_fail(why, AD_BAD_ARGUMENT, "%s", unknown);
        return AD_OK;
    }
    ad_status status = learnt_open(e, member, &all, why);
    if (status == AD_OK) {
        status =
            solve_error_estimate(&all.one, experiment_until(e), learnt_field, &all, estimate, why);
        field_free(all.field);
    }
    return status;
}

ad_status experiment_kept_error(const experiment *e, const checkpoint *file, double *estimate,
                                ad_error *why)
{
    *estimate = NAN;
    checkpoint_get_doubles(file, "estimate", estimate, 1, NULL);
    return isnan(*estimate) && !e->targets ? experiment_error(e, NULL, estimate, why) : AD_OK;
}
