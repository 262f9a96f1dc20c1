/* How a rod is seen by what measures it. */
#ifndef PHYSICS_SOLVE_VIEW_H
#define PHYSICS_SOLVE_VIEW_H

#include "physics/quantity/quantity.h"

#ifdef __cplusplus
extern "C" {
#endif

/* Formulas of s, t and the scene's parameters; those that are not given are 0. */
typedef struct solve_view {
    quantity marker[3]; /* m, along d1, d2, d3: the point that is measured is r + R marker */
    /* of what measures in the scene: r = position + R_view r_measured. One rotation of the two */
    quantity position[3], rotation[4], rotation_vector[3];
    quantity delay; /* s; a row of the time t is of the rod at t - delay */
} solve_view;

/* Whether anything is given; whether a formula has this name. */
bool solve_view_is_given(const solve_view *view);
bool solve_view_depends_on(const solve_view *view, const char *name);

#ifdef __cplusplus
}
#endif

#endif
