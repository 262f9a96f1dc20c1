/* Formulas of a scene's parameters, in numbers: which open name each is of, looked up once. */
#ifndef PHYSICS_SCENE_SCENE_VALUES_H
#define PHYSICS_SCENE_SCENE_VALUES_H

#include "physics/scene/scene.h"

typedef struct scene_values {
    int count;
    int index[SCENE_PARAMETERS_MAX]; /* of each parameter, of open names */
} scene_values;

/* Of a scene that has its names. */
scene_values scene_values_of(const scene *open);

/* A formula at parameters [count], and how it changes along a direction [count] of them. */
double scene_value_at(const scene_values *names, quantity q, const double *parameters);
double scene_slope_at(const scene_values *names, quantity q, const double *parameters,
                      const double *direction);

#endif
