/* Classical solutions of a scene: the face of tools/solve. Everything is dimensionless, see
 * rod_model.h. */
#ifndef TOOLS_SOLVE_SOLVE_H
#define TOOLS_SOLVE_SOLVE_H

#include "tools/solve/rod_model.h"

/* The rod at one (s, t): the columns of its model, see physics/model.h, of which those of the pose
 * come first. */
enum { SOLVE_COLUMNS = 25, SOLVE_POSE = 7 };

typedef struct solve_state {
    double position[3];  /* r, world */
    double rotation[4];  /* q, unit */
    double strain[3];    /* v, body */
    double curvature[3]; /* u, body */
    double force[3];     /* n, body */
    double moment[3];    /* m, body */
    double velocity[3];  /* r_t, world; 0 if static */
    double spin[3];      /* w, body; 0 if static */
} solve_state;

typedef struct solve_settings {
    double tolerance;    /* of the position over the length, everywhere; refined until estimated
                          * to be met */
    int nodes;           /* along the rod, exactly these and no refinement; 0: by the tolerance */
    double perturbation; /* static: a force per length of so many EI/L^3 across the rod while the
                          * load grows, removed again at full load: leaves a straight column for a
                          * buckled one; 0: none */
} solve_settings;

typedef struct solve_report {
    int nodes;            /* along the rod, of the result */
    long newton_steps;    /* all together */
    long load_steps;      /* static: from the unstressed rod to the loaded one */
    long time_steps;      /* dynamic */
    double estimate;      /* of the error of the position over the length; NaN: not estimated */
    double load_fraction; /* static: reached; 1: all of it */
    double time;          /* dynamic: reached, of the duration */
    bool may_buckle;      /* static: pushed from both ends, so that other equilibria may exist */
} solve_report;

solve_settings solve_settings_default(void); /* tolerance 1e-10 */

typedef struct solution solution;

/* Solve a scene that passes scene_check and rod_check. A dynamic one at times [count], ascending,
 * in [0, duration]; a static one needs none. AD_OK also where the load could not be reached or the
 * tolerance not met, which the report says: the solution is then that of the load reached, or less
 * accurate. AD_BAD_ARGUMENT for a scene that no solver takes, AD_NO_MEMORY. */
ad_status solution_create(const scene *rod_scene, const solve_settings *settings, size_t count,
                          const double *times, solution **result, solve_report *report,
                          ad_error *error);
void solution_free(solution *x);

const solve_rod *solution_rod(const solution *x);

/* At n points s [n] within [0, 1], at t, one of the times given; out [n]. */
ad_status solution_at(const solution *x, size_t n, const double *s, double t, solve_state *out,
                      ad_error *error);

#endif
