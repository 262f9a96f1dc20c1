/* How a rod is seen by what measures it. */
#ifndef PHYSICS_SCENE_VIEW_H
#define PHYSICS_SCENE_VIEW_H

#include "physics/scene/scene.h"

#ifdef __cplusplus
extern "C" {
#endif

/* Formulas of s, t and the scene's parameters; those that are not given are 0. */
typedef struct scene_view {
    quantity marker[3]; /* m, along d1, d2, d3: the point that is measured is r + R marker */
    /* of what measures in the scene: r = position + R_view r_measured. One rotation of the two */
    quantity position[3], rotation[4], rotation_vector[3];
    quantity delay; /* s; a row of the time t is of the rod at t - delay */
} scene_view;

/* Whether anything is given; whether a formula has this name. */
bool scene_view_is_given(const scene_view *view);
bool scene_view_depends_on(const scene_view *view, const char *name);

/* ---- what is seen of a computed row -------------------------------------------------------- */

/* A view, and the parameters that its formulas have. */
typedef struct scene_seen {
    const scene_view *of;
    const scene *open;
    bool sees_marker, sees_frame, moves; /* moves: one of the two */
    int count;
    int index[SCENE_PARAMETERS_MAX]; /* [count] of the scene's parameters */
    const char *names[SCENE_PARAMETERS_MAX];
} scene_seen;

/* The view and the scene stay where they are. */
void scene_seen_prepare(const scene_view *view, const scene *open, scene_seen *result);

/* The time of the rod, of a row of time t. s: of the scene, whose formulas see the place on the rod
 * as it is written. parameters: as of scene_member. */
double scene_seen_time(const scene_seen *view, double s, double t, const double *parameters);

/* r [3] of the axis and a unit quaternion q [4] of a section become those that are seen. */
void scene_seen_take(const scene_seen *view, double s, double t, const double *parameters,
                     double r[3], double q[4]);

/* The marker of that row, m along d1, d2, d3. */
void scene_seen_marker(const scene_seen *view, double s, double t, const double *parameters,
                       double offset[3]);

/* A place r [3] as it is measured becomes that in the scene. */
void scene_seen_place(const scene_seen *view, double s, double t, const double *parameters,
                      double r[3]);

#ifdef __cplusplus
}
#endif

#endif
