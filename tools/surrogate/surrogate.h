/* One-step models of moving robots: x+ = f(x, u), the state of the reduced rod
 * (physics/chain/reduced.h) one sampling step later.
 *
 *   surrogate *s;
 *   surrogate_load("runs/arm", 0, &s, &error);          tools/prepare/config_surrogate.h
 *   one_step model;
 *   surrogate_one_step(s, &model, &error);              physics/local/one_step.h
 *   model.advance(model.context, 1, model.step, state, inputs, NULL, next, NULL, NULL);
 *   surrogate_one_step_free(&model);
 *   surrogate_free(s); */
#ifndef SURROGATE_H
#define SURROGATE_H

#include "physics/chain/reduced.h"
#include "physics/local/one_step.h"
#include "tools/files/checkpoint.h"
#include "tools/surrogate/surrogate_curve.h"
#include "tools/surrogate/surrogate_settings.h"

typedef struct surrogate {
    const struct scene *scene;   /* borrowed, with what it needs, from `owner` */
    surrogate_settings settings; /* resolved: modes, inputs, parameters */
    surrogate_step step;
    double *numbers; /* of the step; owned. Those of the other nodes of a polynomial follow */
    void *owner;     /* freed by free_owner, which may be NULL */
    void (*free_owner)(void *owner);
} surrogate;

void surrogate_free(surrogate *s); /* NULL is fine */

/* All names are those of s->scene->parameters, in that order, with their ranges. Whether input i is
 * a slow parameter. */
bool surrogate_is_parameter(const surrogate *s, int i);

/* A model for one thread, borrowing from s, which outlives it. AD_NO_MEMORY. */
ad_status surrogate_one_step(const surrogate *s, one_step *result, ad_error *error);
void surrogate_one_step_free(one_step *step);

/* The reduced rod whose state the model steps, looked at in `count` places s (m). */
ad_status surrogate_rod(const surrogate *s, int count, const double *places, reduced_rod **result,
                        ad_error *error);

/* Modes that settings leave open, by their tolerance against the rod by finer ones; text [256] for
 * people. AD_NO_MEMORY, errors of reduced_create. */
ad_status surrogate_choose_modes(const struct scene *open, surrogate_settings *settings,
                                 ad_pool *pool, uint64_t seed, char text[256], ad_error *error);

/* A step in a checkpoint: surrogate/shape, step, soft, numbers; the step and shape are borrowed
 * until it is written. get: the caller frees *numbers, also after a failure. */
enum {
    SURROGATE_SHAPE =
        15 + SURROGATE_SLOW_MAX + SURROGATE_LAYERS_MAX + SURROGATE_STATES_MAX + SURROGATE_INPUTS_MAX
};
void surrogate_put(surrogate_step *m, int64_t shape[SURROGATE_SHAPE], checkpoint *file);
ad_status surrogate_get(const checkpoint *file, surrogate_step *m, double **numbers,
                        ad_error *error);

/* The other nodes of polynomials beside their step: surrogate/inner. get reads the step as well. */
void surrogate_put_nodes(const surrogate_step *m, const double *inner, checkpoint *file);
ad_status surrogate_get_nodes(const checkpoint *file, surrogate_step *m, double **numbers,
                              ad_error *error);

#endif
