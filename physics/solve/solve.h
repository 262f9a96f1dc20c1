/* Classical solutions of a scene: the face of tools/solve. SI units here; within, everything is
 * dimensionless, see rod_model.h and beam_model.h. */
#ifndef PHYSICS_SOLVE_SOLVE_H
#define PHYSICS_SOLVE_SOLVE_H

#include "physics/model.h"
#include "physics/verdict.h"

#ifdef __cplusplus
extern "C" {
#endif

/* Raised when solutions change by more than their estimated error: kept ones are solved anew. */
#define SOLUTION_VERSION 4

typedef struct solve_settings {
    double tolerance;    /* of the position over the length, or a beam's deflection over the
                          * largest, everywhere; of rods in motion also of a tenth of the rotation
                          * in rad; refined until estimated to be met */
    int nodes;           /* along the rod, exactly these and no refinement; 0: by the tolerance */
    double perturbation; /* static rod: a force per length of so many EI/L^3 across the rod while
                          * the load grows, removed again at full load: leaves a straight column for
                          * a buckled one; 0: none */
} solve_settings;

typedef struct solve_report {
    int nodes;              /* along the rod, of the result */
    long newton_steps;      /* all together */
    long load_steps;        /* static: from the unstressed rod to the loaded one */
    long time_steps;        /* dynamic */
    double estimate;        /* of the error, as the tolerance; NaN: not estimated */
    double size;            /* m: what both are relative to, the length or a beam's deflection */
    double load_fraction;   /* static: reached; 1: all of it */
    double time;            /* dynamic: reached, of the duration */
    double energy_mismatch; /* dynamic: the largest, over the largest energy */
    double energy;          /* dynamic: the largest, over EI/L */
    bool may_buckle;        /* static: pushed from both ends, so that other equilibria may exist */
} solve_report;

/* tolerance 1e-10; of rods in motion, which are the hardest, 1e-6, with locked strains 1e-4 */
solve_settings solve_settings_default(const scene *rod_scene);

/* Of the whole rod, J. At rest `work` is that of dead forces, at their full size all along the way
 * from the unstressed rod: minus their potential; NaN under moments and follower loads, which have
 * none. */
typedef struct solve_energy {
    double kinetic, strain;
    double work;       /* of loads, and of what moves ends and rest shape, since t = 0 */
    double dissipated; /* by damping and drag since t = 0, >= 0 */
    double mismatch;   /* kinetic + strain + dissipated - work, less its value at t = 0: errors of
                        * integration in t; NaN at rest */
} solve_energy;

typedef struct solution solution;

/* Solve a scene that passes scene_check and the check of its model. A dynamic one at times [count]
 * in s, within its duration and in any order, and at its end; a static one needs none. AD_OK also
 * where the load could not be reached or the tolerance not met, which the report says: the solution
 * is then that of the load reached, or less accurate. AD_BAD_ARGUMENT for a scene that no solver
 * takes, AD_NO_MEMORY. */
ad_status solution_create(const scene *rod_scene, const solve_settings *settings, size_t count,
                          const double *times, solution **result, solve_report *report,
                          ad_error *error);
void solution_free(solution *x);

/* Values [columns][points] of the scene's model (physics/model.h), its first `columns`, in SI, at s
 * [points] (m, taken to lie within the rod) and t [points] (s, of the times given; a static scene
 * takes NULL). Quicker where points of one time follow one another. */
ad_status solution_evaluate(const solution *x, int columns, size_t points, const double *s,
                            const double *t, double *values, ad_error *error);

/* Of a rod, not of a beam, at t (s, of the times given; a static scene does not look at it). */
ad_status solution_energy(const solution *x, double t, solve_energy *energy, ad_error *error);

/* What speaks against a solution: that it is not that of the whole load, that its estimated error
 * is above the tolerance (where nodes are not prescribed), that the energy of a motion is out of
 * balance, or that the shape at rest is not stable (physics/solve/stability.h). And the remark that
 * there may be other equilibria. */
void solution_verdict(const solution *x, const scene *rod_scene, const solve_settings *settings,
                      const solve_report *report, verdict *result);

/* Columns that its model has in this scene: those of motion only in motion. */
int solution_columns(const scene *rod_scene);

#ifdef __cplusplus
}
#endif

#endif
