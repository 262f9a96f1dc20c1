/* A robot as something that moves among surfaces: its variables, which are parameters of the scene
 * and how far its base is slid and turned, and its shapes; exact ones with
 * how far each point moves with each variable. */
#ifndef PLAN_PLAN_ROBOT_H
#define PLAN_PLAN_ROBOT_H

#include "autodiff/memory.h"
#include "physics/chain/solve_members.h"
#include "tools/plan/plan_settings.h"

enum { PLAN_KEY = 64 };

typedef struct plan_robot {
    int count; /* of variables */
    char names[PLAN_VARIABLES_MAX][64];
    double low[PLAN_VARIABLES_MAX], high[PLAN_VARIABLES_MAX]; /* their ranges */
    int parameter[PLAN_VARIABLES_MAX];                        /* of the scene; -1: of the base */
    int slide, turn;                                          /* which variables; -1: none */
    int parameters;                                           /* of the scene */
    double fixed[SCENE_PARAMETERS_MAX];                       /* NaN: one that moves */
    int unknowns,
        unknown[PLAN_UNKNOWN_MAX]; /* of the scene; fixed in the middle of their ranges, */
    double half[PLAN_UNKNOWN_MAX]; /* that go so far to both sides */
    double base[3], axis[3];       /* of the rod */
} plan_robot;

/* AD_BAD_INPUT: `key` receives what is to blame. */
ad_status plan_robot_create(const plan_settings *settings, const scene *of, plan_robot *result,
                            char key[PLAN_KEY], ad_error *error);

/* Parameters of the scene of configurations [count]. */
void plan_robot_parameters(const plan_robot *of, const double *configuration, double *parameters);

/* Places r [points][3] of a shape whose base has been moved; values [points][columns] begin with
 * its position before. */
void plan_robot_place(const plan_robot *of, const double *configuration, size_t points,
                      size_t columns, const double *values, double *r);

/* ---- exact shapes ---------------------------------------------------------------------------- */

/* The tolerance of the solver, of the length. */
#define PLAN_TOLERANCE 1e-9

typedef struct plan_exact {
    const plan_robot *robot;
    solve_members *solver;
    const scene *of;
    double length;
    size_t points;
    double *s; /* [points] m */
    /* of the last shapes [members][points]...: */
    double *r;       /* [3] */
    double *speed;   /* |dr/ds| */
    double *moves;   /* [3][count]: dr/d(variable) */
    double *error;   /* [members], m, by the tolerance, or what is estimated on the finest mesh
                      * where that is more; infinite: there is no such equilibrium */
    double *spread;  /* [members][points], m: what unknown parameters move a point at most */
    double *tangent; /* [members][3], of length 1: where the rod points at its tip */
    double *turns;   /* [members][3][count]: dtangent/d(variable) */
    double *first, *parameters, *values, *curvature, *jacobian;
    solve_member *solved;
    ad_memory memory;
} plan_exact;

/* So many points from 0 to the length, and one at `from`. The robot and the scene must outlive
 * it. Errors of solve_members_create. */
ad_status plan_exact_create(const plan_robot *robot, const scene *of, size_t points, double from,
                            int threads, plan_exact **result, ad_error *error);
void plan_exact_free(plan_exact *of); /* NULL is allowed */

enum { PLAN_BATCH = 64 };

/* Shapes of members <= PLAN_BATCH configurations [members][count], with unknown parameters in the
 * middle of their ranges. What these move is seen at all ends and middles of the ranges; what that
 * differs from the derivative is added once, for values between. */
ad_status plan_exact_shapes(plan_exact *of, size_t members, const double *configurations,
                            ad_error *error);

#endif
