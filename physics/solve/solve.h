/* Classical solutions of a scene, without a network: the face of the library cpinn_solve.
 *
 * Rods at rest: collocation at Gauss points along the rod, of position, rotation, force and moment,
 * with Newton's method and continuation of the loads from 0. Many at once, with parameters that
 * differ, are solved by physics/chain/solve_members.h. Rods in motion: spectral elements between
 * places where something jumps. Steps of time are by Runge-Kutta: implicit where the motion is
 * slow, or composed of free motion and forces where every vibration has to be followed, as after a
 * sudden load. Or a few modes of the strains (SOLVE_MODES). Beams of small deflection: collocation
 * along the beam and in time, linear. Stiffness, inertia and damping may vary along the rod, loads,
 * gravity, prescribed ends and the rest shape with time.
 *
 *   solve_settings settings = solve_settings_default(&scene);    of a scene that scene_check and
 *   solution_create(&scene, &settings, count, times,             the check of its model passed
 *                   &solution, &report, &error);
 *   solution_verdict(solution, &scene, &settings, &report, &verdict);
 *   solution_evaluate(solution, solution_columns(&scene), points, s, t, values, &error);
 *   solution_free(solution);
 *
 * Everything is in SI units. Functions that can fail return AD_OK or a status, with a sentence in
 * `error`; a result is then NULL. Nothing is printed, and nothing is shared between solutions, so
 * that threads may make and use one each; one solution is for one thread at a time. */
#ifndef PHYSICS_SOLVE_SOLVE_H
#define PHYSICS_SOLVE_SOLVE_H

#include "physics/learn/model.h"
#include "physics/local/method.h"
#include "physics/scene/verdict.h"

#ifdef __cplusplus
extern "C" {
#endif

/* Raised when solutions change by more than their estimated error, or when what is kept of them
 * does: those in files are then solved anew. */
#define SOLUTION_VERSION 9

/* Errors of motions with kinks are this much larger at some places than they are in L2. */
static const double SOLVE_PEAK = 10;

/* What energy may be out of balance by at most, of the largest: of a motion with more nothing is
 * known. And by EI/L what rounding leaves of the energy of a rod at rest. */
static const double SOLVE_ENERGY_ALLOWED = 0.1, SOLVE_ENERGY_ROUNDING = 1e-20;

/* values [columns][n] of the scene's model at s [n] (m), in SI units, all but those of motion. */
typedef ad_status solve_shape(const void *context, size_t n, const double *s, double *values,
                              ad_error *error);

/* Of a motion: values [solution_columns][points] in SI units at s [points] (m) and t [points] (s).
 */
typedef ad_status solve_known_motion(void *context, size_t points, const double *s, const double *t,
                                     double *values, ad_error *error);

typedef struct solve_settings {
    double tolerance;    /* > 0; of the position over the length, or of a beam's deflection over its
                          * largest, everywhere. Of rods in motion: of the position, or of a tenth
                          * of the rotation in rad times the length, relative L2 over s and t, and
                          * SOLVE_PEAK times as much anywhere. The solution is refined until its
                          * error is estimated to be below. */
    int nodes;           /* along the rod: so many or a few more, without refinement; 0: as
                          * many as the tolerance asks for. Of a rod in motion the tolerance is then
                          * that of steps of time. */
    double perturbation; /* rods at rest: a force per length of so many EI/L^3 pushes across the rod
                          * while the load grows and is gone at full load. A straight column so
                          * finds its buckled shape. 0: none. */
    int branch; /* rods at rest: at the so many-th bifurcation, leave the path that continues
                 * the unstressed rod for the one that crosses it; 0: never */
    solve_method method; /* rods at rest, modes in motion; of other scenes collocation alone. By
                          * default modes where tendons rub in motion, and where strains are
                          * locked and modes take the scene: forces of locked strains of a rod in
                          * motion are NaN by collocation */
    int modes[4];        /* of SOLVE_MODES: of bending, twist, stretch, shear, each direction and
                          * piece, without refinement; all 0: as many as the tolerance asks for */
    solve_shape *guess;  /* rods at rest: a shape next to which an equilibrium is sought, by */
    const void *guess_context;     /* Newton's method from there. NULL, or where that does not lead
                                    * to one: on the path from the unstressed rod */
    const struct solution *before; /* rods at rest: an equilibrium of the same robot, from whose
                                    * tensions tendons with friction go on; NULL: from none on */
    const solve_seen *from; /* of SOLVE_MODES: the state at t = 0 in place of the scene's, by */
    size_t from_count;      /* ascending s from 0 to the length, 6 at least; 0: the scene's */
} solve_settings;

/* What a place on a path of equilibria is. */
typedef enum solution_mark { SOLUTION_PLAIN, SOLUTION_LIMIT, SOLUTION_BIFURCATION } solution_mark;

typedef struct solve_report {
    int nodes;               /* along the rod, of the result */
    long newton_steps;       /* all together */
    long load_steps;         /* static: from the unstressed rod to the loaded one */
    long time_steps;         /* dynamic */
    double estimate;         /* of the largest error, relative to `size`; NaN: not estimated */
    double estimate_l2;      /* of rods in motion: of the relative L2 error; of others `estimate` */
    double size;             /* m: the length, or a beam's deflection */
    double misfit;           /* how far a law stiffer by its misfit moves the rod, over the
                              * length; 0 without a law, NaN where the law does not say */
    double balance;          /* static: as solve_balance; NaN: not under the whole load */
    double load_fraction;    /* static: reached; 1: all of it */
    double time;             /* dynamic: reached, of the duration */
    double energy_mismatch;  /* dynamic: the largest, over the largest energy */
    double energy;           /* dynamic: the largest, over EI/L */
    double limit_load;       /* static, where it was looked for: the first limit point, at which the
                              * load turns back, as a load factor; NaN: none */
    double bifurcation_load; /* the same of the first place where another path crosses */
    double path_estimate;    /* of the error of both; NaN: not estimated */
    bool snapped;            /* static: the solution lies beyond a limit point */
    const char *unresolved;  /* a key whose formula jumps in places that are not found, or varies on
                              * lengths that meshes do not reach; static text, NULL: none */
    int mode_count, modes[6]; /* SOLVE_MODES: all, and of each strain and piece: v, u */
    bool may_buckle; /* static: pushed from both ends, so that other equilibria may exist */
} solve_report;

/* A report of which nothing is known yet, and the whole load: numbers that may be missing are NaN.
 */
solve_report solve_report_blank(void);

/* What the misfit adds to both estimates; 0 where it is not known. */
double solve_misfit(const solve_report *report);

/* tolerance 1e-10; of rods in motion, which are the hardest, 1e-6, with locked strains 1e-4 */
solve_settings solve_settings_default(const scene *rod_scene);

typedef struct solution solution;

/* Whether the method takes the scene, also for its branch and, where asked, for its path: the table
 * of physics/scene/support.h. AD_BAD_ARGUMENT with its sentence; *key receives the key to blame
 * (NULL: not wanted). */
ad_status solve_check(const scene *rod_scene, const solve_settings *settings, bool path,
                      const char **key, ad_error *error);

/* Solve a scene that passes scene_check and the check of its model; the scene is copied, and what
 * its formulas belong to must outlive the solution. A scene in motion is solved at times [count] in
 * s, within its duration and in any order, and at its end; a scene at rest needs none (NULL).
 *
 * AD_OK also where the load could not be reached or the tolerance not met: the solution is then
 * that of the load reached, or less accurate, and the report and the verdict say so.
 * AD_BAD_ARGUMENT for a scene that no solver takes (a rod in motion without rotary inertia, a beam
 * that is free to move at rest). AD_NOT_FINITE when time steps fail or a formula is not finite,
 * AD_NO_BLAS without LAPACK, AD_NO_MEMORY. */
ad_status solution_create(const scene *rod_scene, const solve_settings *settings, size_t count,
                          const double *times, solution **result, solve_report *report,
                          ad_error *error);
void solution_free(solution *solution); /* NULL is allowed */

/* Values [columns][points] of the first `columns` observables of the scene's model
 * (physics/learn/model.h), in SI units, at s [points] (m) and t [points] (s; NULL at rest). What
 * lies beyond an end is taken at the end; of times, the nearest that was solved is taken. Where
 * something jumps they are all those just before, not the moment of one piece with the stiffness of
 * the next. Quicker where points of one time follow one another. AD_NO_MEMORY. */
ad_status solution_evaluate(const solution *solution, int columns, size_t points, const double *s,
                            const double *t, double *values, ad_error *error);

/* Of a rod at rest, in N: what was found of a tendon whose displacement is given, counted from 0;
 * of other tendons, and in motion, 0. */
double solution_tension(const solution *solution, int tendon);

/* Of a rod, not of a beam, at t (s; the nearest of the times that were solved; a scene at rest does
 * not look at it). AD_NO_MEMORY. */
ad_status solution_energy(const solution *solution, double t, solve_energy *energy,
                          ad_error *error);

/* Whether loads and supports of a whole rod or beam at rest balance: the sum of all forces and
 * moments, over 1 and the sum of their absolute values. The units are EI/L^2 and EI/L, of a beam as
 * much smaller as it deflects. The loads are those of the scene, followers and springs where the
 * shape has brought them. They are integrated on panels of their own between all places where they
 * jump. The force and the moment of a support are those of the shape at that end. Infinite where
 * the shape is not a number. Of a scene at rest that passes scene_check and the check of its model.
 * AD_NO_MEMORY, what the tape says of a formula, what the shape returns. */
ad_status solve_balance(const scene *rod_scene, solve_shape *shape, const void *context,
                        double *balance, ad_error *error);

/* Adds a warning to a verdict where that is more than an error of so much of the position, over the
 * length, or of a beam's deflection allows. */
void solve_judge_balance(double balance, double allowed_error, verdict *result);

/* Adds a warning where strains leave the data that a rod's law has learned from. Without such a law
 * it warns where they crush or stretch the rod beyond what a linear law holds for. values
 * [columns][n] are those of the first 13 columns of a rod's model at s [n] (m) and t [n] (s; NULL
 * at rest). */
void solve_judge_strains(const scene *rod_scene, size_t n, const double *s, const double *t,
                         const double *values, verdict *result);

/* Whether the energy of a motion balances to a tenth: else nothing is known of it. */
bool solve_energy_is_met(const solve_report *report);

/* What speaks against a solution: that it is not that of the whole load, or that its estimated
 * error is above the tolerance (where nodes are not prescribed). Jumps that were not resolved may
 * make the estimate too small. Further, that loads at rest or the energy of a motion are out of
 * balance, or that the shape at rest is not stable (physics/solve/stability.h). And remarks: that
 * there may be other equilibria, that sizes are hardly meant (physics/check/plausible.h). */
void solution_verdict(const solution *solution, const scene *rod_scene,
                      const solve_settings *settings, const solve_report *report, verdict *result);

/* The ends of a rod, s = 0 and s = length, before anything moves it: of a motion at t = 0, at rest
 * where the unstressed rod lies. Position in m and director d3, the tangent of a rod that does not
 * shear, both in the world. Of a rod that passes scene_check and the check of its model.
 * AD_NO_MEMORY, or what the tape says of a formula. */
typedef struct solve_place {
    double position[3], tangent[3];
} solve_place;

ad_status solve_start(const scene *rod_scene, solve_place ends[2], ad_error *error);

/* Of a scene whose initial.state is equilibrium: solves it at rest under what acts at t = 0 and
 * puts that shape into initial.settled, formulas that belong to `names`; of other scenes nothing.
 * Tendons do not rub then. The scene must pass scene_check. AD_BAD_INPUT: there is no such
 * equilibrium, or its verdict is a warning (unstable, or not as exact as a motion needs);
 * AD_BAD_ARGUMENT: names is NULL; AD_NO_MEMORY, and the errors of solution_create. */
ad_status solve_settle(scene *rod_scene, quantities *names, ad_error *error);

/* ---- paths --------------------------------------------------------------------------------- */

/* An equilibrium on the way from the unstressed rod to the loaded one. */
typedef struct solution_path_point {
    double load;        /* factor of all loads, and of the way of held ends */
    double arclength;   /* of the path: of positions over the length, rotations and load */
    double position[3]; /* m, of the place of the path */
    double deflection;  /* m, of that place along the direction of the path */
    int unstable_modes; /* as physics/solve/stability.h counts them, and in space unless `motion`
                         * says planar; of a mark those before it; -1: not asked */
    solution_mark mark; /* bifurcations are found where the modes are asked for */
} solution_path_point;

typedef struct solution_path {
    size_t count;
    solution_path_point *points; /* [count] in the order in which the path meets them */
    double place;                /* s, m: what moves the furthest, of 101 equally spaced places */
    double direction[3];         /* where to, then; unit, in the world */
    double estimate;             /* of the error of the loads of marks; NaN: not estimated */
    bool arrived;                /* at an equilibrium under the full load */
} solution_path;

/* Follow the equilibria of a rod at rest by the arc length of their path, through limit points and
 * past bifurcations, to the first stable one under the full load; settings as for solution_create.
 * Of a scene that passes scene_check and the check of its model. AD_BAD_ARGUMENT: a motion, a beam,
 * a perturbation, a rod that nothing holds without its loads, fewer bifurcations than the branch;
 * AD_NO_MEMORY, or what the tape says of a formula. */
ad_status solution_path_create(const scene *rod_scene, const solve_settings *settings,
                               solution_path **result, ad_error *error);
void solution_path_free(solution_path *path); /* NULL is allowed */

/* Columns that its model has in this scene: those of motion only in motion. */
int solution_columns(const scene *rod_scene);

#ifdef __cplusplus
}
#endif

#endif
