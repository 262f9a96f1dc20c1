/* Classical solutions of a scene: the face of tools/solve, and what its solvers share.
 *
 * A solver takes a solve_rod and solve_settings, fills a solve_report and makes a solution that can
 * be evaluated at any s and t. Everything is dimensionless, see rod_model.h. */
#ifndef TOOLS_SOLVE_SOLVE_H
#define TOOLS_SOLVE_SOLVE_H

#include "tools/solve/rod_model.h"

/* The rod at one (s, t). */
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
    double perturbation; /* static: a force per length of so many EI/L^3 along d1 while the load
                          * grows, removed again at full load: leaves a straight column for a
                          * buckled one; 0: none */
} solve_settings;

typedef struct solve_report {
    int nodes;            /* along the rod, of the result */
    long newton_steps;    /* all together */
    long load_steps;      /* static: continuation in the load */
    long time_steps;      /* dynamic */
    double estimate;      /* of the error of the position over the length; NaN: not estimated */
    double load_fraction; /* reached; 1: solved */
    double time;          /* reached, of the duration; dynamic */
} solve_report;

solve_settings solve_settings_default(void);

#endif
