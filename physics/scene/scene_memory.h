/* Inputs with a memory: plays of formulas (quantity_play), as backlash of drives, and sums of them,
 * as hysteresis of chambers (Prandtl and Ishlinskii).
 *
 * In motion an input is known at all times. Between the instants where it turns back a play is
 * max(x - r, min(x + r, before)) with one value before, so that it becomes a formula of time, and
 * everything that takes one takes it. At rest rows of commands have an order, that of their file or
 * path: what a play was before a row is then a parameter of the scene, the last of those that are
 * known, and whoever has the rows fills it in here. Alone, a row is the first: the state is 0. */
#ifndef PHYSICS_SCENE_SCENE_MEMORY_H
#define PHYSICS_SCENE_SCENE_MEMORY_H

#include "physics/scene/scene.h"

/* Gives the plays of a scene's formulas, and of `count` others beside it, their place, once these
 * are read and its duration and parameters are known. AD_BAD_INPUT with the key to blame: a play
 * along the rod, a threshold that changes in time, one that may be negative, an input whose turns
 * are too many or depend on parameters, too many parameters. AD_NO_MEMORY. */
ad_status scene_remember(scene *rod_scene, int count, const quantity *others, const char **key,
                         ad_error *error);

/* The states before each row of a path: parameters [rows][parameter_count], of which all others are
 * given. slopes [rows][memory_count][parameter_count]: their derivatives along unknowns, which are
 * the same in all rows; of other parameters 0. NULL: not wanted. Exact; does not allocate. */
void scene_remember_path(const scene *open, size_t rows, double *parameters, double *slopes);

#endif
