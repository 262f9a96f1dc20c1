/* A network of a rod's motion: by strain modes along s (modes.h) whose numbers are a network of
 * time. Rotation and position follow from them exactly, so that all there is to learn is the
 * equation of motion of the modes,
 *
 *   M(q) q_tt + c(q, q_t) + stress of the modes - loads = 0,
 *
 * of which the residual and its derivatives are computed and not recorded (model_motion). */
#ifndef PHYSICS_SOLVE_MODES_MODEL_H
#define PHYSICS_SOLVE_MODES_MODEL_H

#include "physics/learn/model.h"

typedef struct modes_model modes_model;

/* Of a scene that passes its checks and is copied; its texts must live on. counts: of bending,
 * twist, stretch and shear, for each direction and piece of the rod; a motion in a plane has only
 * those in it. AD_BAD_ARGUMENT: a scene that the form does
 * not take (physics/scene/support.h); AD_BAD_INPUT: all counts are 0; AD_NO_MEMORY, errors of
 * formulas.
 */
ad_status modes_model_create(const scene *rod_scene, const int counts[4], modes_model **result,
                             ad_error *error);
void modes_model_free(modes_model *model); /* NULL is fine */

/* Its coordinates s and t, a network of time alone, and the columns of the scene's model; lives as
 * long as this. */
physics_model *modes_model_physics(modes_model *model);

/* How many there are of v along d1, d2, d3 and of u about them. */
void modes_model_counts(const modes_model *model, int counts[6]);

#endif
