/* Inputs with a memory: plays of formulas (quantity_play), as backlash of drives, sums of them, as
 * hysteresis of chambers (Prandtl and Ishlinskii), and lags of first order.
 *
 * In motion the input of a play may be a formula of time. Between the instants where it turns back
 * the play is max(x - r, min(x + r, before)) with one value before, so that it becomes a formula
 * of time, and everything that takes one takes it. Of parameters, which are recorded or set, the
 * state is a parameter of the scene, the last of those that are known. It goes from sample to
 * sample with the inputs, linearly between: whoever steps in time says it by scene_memory_step.
 * A motion whose parameters stay began after they had been there for long.
 *
 * At rest rows of commands have an order, that of their file or path: what a play was before a row
 * is then such a parameter, and whoever has the rows fills it in here. Alone, a row is the first:
 * the state is 0. A lag is its input there. */
#ifndef PHYSICS_SCENE_SCENE_MEMORY_H
#define PHYSICS_SCENE_SCENE_MEMORY_H

#include "physics/scene/scene_values.h"

/* Gives the plays of a scene's formulas, and of `others` beside it, their place, once these
 * are read and its duration and parameters are known; `other` are changed as the scene's are.
 * AD_BAD_INPUT with the key to blame: a play or lag along the rod, a threshold or time that
 * changes, one that may be negative, an input whose turns are too many or depend on parameters, a
 * lag of a formula of time, too many parameters. AD_NO_MEMORY. */
ad_status scene_remember(scene *rod_scene, int others, quantity *other, const char **key,
                         ad_error *error);

/* The states before each row of a path: parameters [rows][parameter_count], of which all others are
 * given. slopes [rows][memory_count][parameter_count]: their derivatives along unknowns, which are
 * the same in all rows; of other parameters 0. NULL: not wanted. Exact; does not allocate. In
 * motion each row is a motion of its own, and the states are those it begins with. */
void scene_remember_path(const scene *open, size_t rows, double *parameters, double *slopes);

/* In motion the states after inputs had been at parameters [parameter_count] for long, from 0 on;
 * and those at the end of h s in which inputs went linearly from those of `now`, whose states are
 * known, to those of `after`, of which the states are filled in. A play is exact where its input
 * goes one way in between, a lag where its input goes linearly. by_now, by_after [directions]
 * [parameter_count]: derivatives of all these along directions, of which those of the filled states
 * are filled in, too; NULL: not wanted. Do not allocate. */
void scene_memory_start(const scene *open, const scene_values *names, double *parameters,
                        int directions, double *by);
void scene_memory_step(const scene *open, const scene_values *names, double h, const double *now,
                       double *after, int directions, const double *by_now, double *by_after);

#endif
