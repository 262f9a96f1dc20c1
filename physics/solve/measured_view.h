/* What is seen of a computed row. */
#ifndef PHYSICS_SOLVE_MEASURED_VIEW_H
#define PHYSICS_SOLVE_MEASURED_VIEW_H

#include "physics/scene/scene.h"
#include "physics/solve/view.h"

/* A view, and the parameters that its formulas have. */
typedef struct measured_view {
    const solve_view *of;
    bool sees_marker, sees_frame, moves; /* moves: one of the two */
    int count;
    int index[SCENE_PARAMETERS_MAX]; /* [count] of the scene's parameters */
    const char *names[SCENE_PARAMETERS_MAX];
} measured_view;

/* The view and the scene's names stay where they are. */
void measured_view_prepare(const solve_view *view, const scene *open, measured_view *result);

/* The time of the rod, of a row of time t. parameters: as of scene_member. */
double measured_view_time(const measured_view *view, double s, double t, const double *parameters);

/* r [3] of the axis and a unit quaternion q [4] of a section become those that are seen. */
void measured_view_take(const measured_view *view, double s, double t, const double *parameters,
                        double r[3], double q[4]);

#endif
