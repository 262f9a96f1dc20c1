/* cpinn: physics-informed neural networks for beams and Cosserat rods, as a library.
 *
 *   train     a scene file, or a scene and settings that a program fills in, by the measured recipe
 *             (windows of time, load steps, Gauss-Newton); kept in a folder or in memory alone
 *   open      a model that was trained before, by this library or by cpinn-train
 *   evaluate  values and derivatives of a model at any points: evaluator_evaluate, in
 *             physics/learn/evaluator.h; a few microseconds for one point, without allocations
 *   solve     the same scene by a classical method; many members of a family at once
 *   identify  numbers of a scene that are not known, from measurements
 *   fit       equations of one's own, to a tolerance and within a time
 *
 * A scene is filled in from scene_defaults, physics/scene/scene.h, settings from
 * train_settings_default, tools/train/train_settings.h; what is left open there is chosen by what
 * was measured to be best. All numbers are in SI units.
 *
 * Every function that can fail returns an ad_status and writes one line to its ad_error; AD_OK
 * means that there is an answer, and its verdict (physics/scene/verdict.h) whether it can be
 * trusted. Nothing is printed, and nothing is global: objects are used by one thread at a time,
 * different ones by different threads at once. Functions that free take NULL as well. Where a host
 * has made exceptions of floating-point numbers signals, these functions and those of evaluators
 * mask them while they work, also while they call the host (progress). Those of the other headers,
 * like all of C, do not.
 *
 * Names begin with cpinn_ here and with the name of their part in the headers of the parts: ad_,
 * nn_, optim_, scene_, problem_, evaluator_, train_, verdict_ and so on. */
#ifndef CPINN_H
#define CPINN_H

#include "physics/chain/solve_members.h"
#include "physics/learn/equations.h"
#include "physics/learn/evaluator.h"
#include "physics/learn/patches.h"
#include "physics/scene/scene.h"
#include "physics/scene/verdict.h"
#include "tools/train/train_settings.h"

#include <stdint.h>

#ifdef __cplusplus
extern "C" {
#endif

/* The version of the project, "MAJOR.MINOR.PATCH". */
const char *cpinn_version(void);

/* ---- training ------------------------------------------------------------------------------- */

/* A trained model: its scene, networks, history and verdict. */
typedef struct cpinn_model cpinn_model;

/* Where training stands after a step; numbers that are not known are NaN. */
typedef struct cpinn_progress {
    int64_t step;                       /* over all windows and stages, from 1 */
    int window, windows, stage, stages; /* counted from 1 */
    double load_factor;                 /* part of the loads at work; 1: all of them */
    double loss, held_out;              /* weighted; held out: of points never trained on */
    double error;                       /* against the scene's reference, relative */
    double seconds;
} cpinn_progress;

/* How training runs; all 0 is fine. */
typedef struct cpinn_options {
    int threads;        /* 0: one per processor; results do not depend on it */
    const char *folder; /* for checkpoint.h5, history.csv and config.yaml; NULL: memory alone */
    bool resume;        /* go on from the checkpoint in the folder */
    bool (*progress)(void *context, const cpinn_progress *now); /* after each step; false: stop */
    void *context;
} cpinn_options;

/* Train what the file at `path` describes, with `count` overrides "key=value" as --set takes them.
 * options may be NULL. AD_BAD_INPUT: "file:line:column: key: what is wrong; what is allowed";
 * AD_IO, AD_NO_MEMORY; AD_NOT_FINITE: the folder has the last good checkpoint. A stopped training
 * is AD_OK, with the verdict `unfinished`. */
ad_status cpinn_train_file(const char *path, int count, const char *const *overrides,
                           const cpinn_options *options, cpinn_model **model, ad_error *error);

/* The same of a scene and settings (NULL: the defaults), both of which are copied. */
ad_status cpinn_train_scene(const scene *rod_scene, const train_settings *settings,
                            const cpinn_options *options, cpinn_model **model, ad_error *error);

/* The same of physics of one's own: a model that the functions of physics/learn/model.h put
 * together, with coordinates, fields and residuals. Or the model of a scene with further terms,
 * where train_settings_resolve has been called before model_of_scene. It is borrowed, and must
 * outlive what is made of it; so must what its residuals point to. A folder keeps the network, not
 * the equations, which are the program's: to be opened and resumed by it. */
ad_status cpinn_train_physics(physics_model *physics, const train_settings *settings,
                              const cpinn_options *options, cpinn_model **model, ad_error *error);

/* A model from a folder of a run, its checkpoint.h5 or any such file. */
ad_status cpinn_open(const char *path, cpinn_model **model, ad_error *error);

/* The same of physics of one's own, with the physics and settings that it was trained with.
 * AD_BAD_INPUT: other coordinates, fields, terms or another network; whether residuals are still
 * the same functions is not known. */
ad_status cpinn_open_physics(const char *path, physics_model *physics,
                             const train_settings *settings, cpinn_model **model, ad_error *error);
void cpinn_free(cpinn_model *model);

/* Write a checkpoint that cpinn_open and cpinn-eval read. AD_BAD_ARGUMENT: of an opened model,
 * which is in a file already. */
ad_status cpinn_save(cpinn_model *model, const char *path, ad_error *error);

/* Of a model; these live as long as it. */
const verdict *cpinn_verdict(const cpinn_model *model);
const scene *cpinn_scene(const cpinn_model *model);
const train_settings *cpinn_settings(const cpinn_model *model); /* resolved */

/* The estimated error of the position, the largest over the length, or of a beam's deflection over
 * its largest; NaN: not known, or training is not over. */
double cpinn_estimate(const cpinn_model *model);

/* Rows of history.csv. Columns are "step", "seconds", "loss", "held_out", "error", ...; NaN where a
 * value is not known, and where there is no such column. */
size_t cpinn_history_rows(const cpinn_model *model);
int cpinn_history_columns(const cpinn_model *model);
const char *cpinn_history_name(const cpinn_model *model, int column);
double cpinn_history_value(const cpinn_model *model, size_t row, const char *column);

/* Values and derivatives by name, as evaluator_create takes them ("r q x_s r_tt"; NULL: all
 * columns). To be freed by evaluator_free; it does not need the model any more. */
ad_status cpinn_evaluator(const cpinn_model *model, const char *names, evaluator **result,
                          ad_error *error);

/* ---- equations of one's own -----------------------------------------------------------------
 *
 * What physics/learn/equations.h puts together from texts and data, or a YAML file with a section
 * `equations`, is solved by patches (physics/learn/patches.h) until the estimated error is within
 * the tolerance or the time is over. */

/* A solution, with its error and verdict. */
typedef struct cpinn_fit cpinn_fit;

/* All 0 is fine. */
typedef struct cpinn_fit_options {
    double
        tolerance;  /* of the fields relative to their root mean square; 0: of the file, or 1e-6 */
    double seconds; /* 0: of the file, or 60 */
    int threads;    /* 0: one per processor */
    bool (*progress)(void *context, const patches_progress *now); /* NULL; false: stop */
    void *context;
} cpinn_fit_options;

/* AD_OK, also where the tolerance is not met: the verdict says so. options may be NULL. The
 * equations are borrowed, and must outlive the fit. AD_BAD_INPUT, of a file with its line; else as
 * patches_fit. */
ad_status cpinn_fit_equations(equations *e, const cpinn_fit_options *options, cpinn_fit **fit,
                              ad_error *error);
ad_status cpinn_fit_file(const char *path, int count, const char *const *overrides,
                         const cpinn_fit_options *options, cpinn_fit **fit, ad_error *error);

/* Keep what evaluation needs in a file of HDF5, and read it again. AD_IO, AD_BAD_INPUT. */
ad_status cpinn_fit_save(const cpinn_fit *fit, const char *path, ad_error *error);
ad_status cpinn_fit_open(const char *path, cpinn_fit **fit, ad_error *error);
void cpinn_fit_free(cpinn_fit *fit);

/* Of a fit; these live as long as it. The model has the names and ranges of coordinates, which
 * include parameters with a range, the fields, and the unknowns. */
const verdict *cpinn_fit_verdict(const cpinn_fit *fit);
const physics_model *cpinn_fit_model(const cpinn_fit *fit);
const char *cpinn_fit_coordinate(const cpinn_fit *fit, int index); /* names; NULL behind the last */
const char *cpinn_fit_field(const cpinn_fit *fit, int index);
const char *cpinn_fit_unknown(const cpinn_fit *fit, int index);
double cpinn_fit_tolerance(const cpinn_fit *fit);        /* that was asked for */
patches_summary cpinn_fit_summary(const cpinn_fit *fit); /* error, size, time, unknowns */

/* A field or a derivative of one, "u", "u_xt", at places x [coordinates][count], in SI units:
 * values [count], and their estimated errors [count] (NULL: not wanted). All are NaN beyond the
 * time that was reached. AD_BAD_INPUT: no such name; a place outside of the ranges. */
ad_status cpinn_fit_evaluate(const cpinn_fit *fit, const char *name, size_t count,
                             const double *const *x, double *values, double *errors,
                             ad_error *error);

/* ---- families -------------------------------------------------------------------------------
 *
 * All members of a family, values of the scene's parameters within their ranges: by a network that
 * stands for them, or without one by the solver of members (physics/chain/solve_members.h). Where
 * that takes the scene, each shape comes with its error. Newton's method predicts it from the
 * network's curvature, independently of how the network was trained. Members that are not trusted
 * are solved. */

typedef struct cpinn_family cpinn_family;

/* Of members that are solved: the estimated error of the position, over the length. */
#define CPINN_TOLERANCE 1e-6

/* Of members after two steps: those of which more is predicted are solved, though it is trusted. */
#define CPINN_ENOUGH 1e-5

/* Members of a call that compiled C answers one after the other; more are quicker side by side. */
#define CPINN_FEW 4

/* One row per reason: name, word, meaning. The first are those of solve_doubt. */
#define CPINN_REASON_LIST(X)                                                                       \
    X(CPINN_REASON_NONE, "none", "nothing speaks against the network's answer")                    \
    X(CPINN_REASON_NOT_FINITE, "not_finite", "numbers of the network's answer are not finite")     \
    X(CPINN_REASON_UNSTABLE, "unstable", "the network's answer is close to no stable equilibrium") \
    X(CPINN_REASON_TOO_FAR, "too_far", "the network's error is predicted to be too large")         \
    X(CPINN_REASON_NOT_SETTLING, "not_settling", "steps of Newton's method hardly become shorter") \
    X(CPINN_REASON_NOT_REACHED, "not_reached", "two steps leave an error above CPINN_ENOUGH")      \
    X(CPINN_REASON_NO_ESTIMATE, "no_estimate", "the solver of members does not take this scene")   \
    X(CPINN_REASON_REFUSED, "refused", "with these values the scene does not pass its checks")     \
    X(CPINN_REASON_NO_EQUILIBRIUM, "no_equilibrium", "none was found under the whole load")        \
    X(CPINN_REASON_WARNING, "warning",                                                             \
      "the solver is beyond its tolerance, or its verdict a warning")

typedef enum cpinn_reason {
#define CPINN_REASON_ENUM(name, word, help) name,
    CPINN_REASON_LIST(CPINN_REASON_ENUM)
#undef CPINN_REASON_ENUM
        CPINN_REASON_COUNT
} cpinn_reason;

const char *cpinn_reason_word(cpinn_reason reason);
const char *cpinn_reason_text(cpinn_reason reason);

/* Where an answer is from, the words: "network", "members" (the solver of members), "solver"
 * (solution_create), "nothing" (there is none: values are NaN). */
typedef enum cpinn_source {
    CPINN_FROM_NETWORK,
    CPINN_FROM_MEMBERS,
    CPINN_FROM_SOLVER,
    CPINN_FROM_NOTHING
} cpinn_source;

const char *cpinn_source_word(cpinn_source source);

typedef struct cpinn_answer {
    double error;         /* m, predicted: largest distance of the shape from the member's, at the
                           * points of the solver's mesh; NaN: not known. Of a network's answer that
                           * is trusted the true one is within twice as much and CPINN_TOLERANCE. */
    double network_error; /* m, the same of the network before any step */
    cpinn_source source;
    cpinn_reason reason; /* why it is not trusted; of a solver's answer that is trusted, why that
                          * of the network is not */
    bool trusted;
    bool outside; /* of the range of a parameter */
} cpinn_answer;

typedef struct cpinn_family_settings {
    bool extrapolate; /* members outside the range are answered, too, and said to be so */
    int threads;      /* 0: one per processor; results do not depend on it */
    size_t points;
    const double *s; /* [points] where shapes are wanted, m; ascending */
    const double *t; /* [points] s, of a family in motion; else it may be NULL */
    bool compile;    /* of a network in the strain form, and without a network: C answers members
                      * within the ranges, in calls of up to CPINN_FEW. The command cc compiles it
                      * once, in 5 s for 21 points and 40 for 101. It is kept below $XDG_CACHE_HOME
                      * or $HOME/.cache. Answers are three to five times as quick, solved ones more
                      * than twice; values differ by less than the error that is told */
    const ad_ranks *ranks; /* borrowed; among which members are dealt: all of them call the same
                            * functions; NULL: this process is by itself */
    bool forces;           /* where the solver of members takes the scene, n1 to m3 are columns,
                            * too: force and moment in the rod, of rod and actuators together
                            * (solve_members_forces), and theta1, mt1 and so on of tubes. They are
                            * at the equilibrium of the answer, whatever the polish, and not numbers
                            * where its derivatives are none */
} cpinn_family_settings;

/* A family from a folder of a run, its checkpoint.h5 or any such file. AD_BAD_ARGUMENT: the scene
 * has no parameters with ranges, or points are not within the rod; errors as of cpinn_open. */
ad_status cpinn_family_open(const char *path, const cpinn_family_settings *settings,
                            cpinn_family **result, ad_error *error);
void cpinn_family_free(cpinn_family *family);

/* A family of the file's scene without a network. The solver of members answers, to a tolerance of
 * the position over the length (0: CPINN_TOLERANCE). What it does not solve is left to the other
 * one, unless that is to be left alone. Rods in motion are left to solution_create (0: the
 * tolerance of solve_settings_default). AD_BAD_ARGUMENT as above, and a scene at rest, or of a
 * beam, that the solver of members does not take, and plays and lags of parameters in motion;
 * AD_BAD_INPUT, AD_IO, AD_NO_MEMORY. */
ad_status cpinn_family_file(const char *path, int count, const char *const *overrides,
                            double tolerance, const cpinn_family_settings *settings,
                            cpinn_family **result, ad_error *error);

/* Parameters in the order of the scene, with their ranges in units of the SI; live as long as it.
 */
int cpinn_family_parameters(const cpinn_family *family);
const scene_parameter *cpinn_family_parameter(const cpinn_family *family, int index);

/* Columns of a shape: those of solve_members, with settings.forces the next of the model, too; of
 * other scenes all of the model. */
int cpinn_family_columns(const cpinn_family *family);
const char *cpinn_family_column_name(const cpinn_family *family, int column);

/* "", or why answers of this family have no predicted error. */
const char *cpinn_family_without_error(const cpinn_family *family);

/* "", or why nothing is compiled, where settings.compile asks for it. There is no compiler, or no
 * folder for what it makes. Or the network is another, there are more than 101 points, or the scene
 * is left to the solver. Answers are those without it. */
const char *cpinn_family_not_compiled(const cpinn_family *family);

/* What is to be made of the network's answer. */
typedef struct cpinn_polish {
    int steps;  /* of Newton's method: 0, 1, 2, by default 2 */
    bool alone; /* what is not trusted then, or not reached, is left as it is, not solved */
    bool quick; /* what the solver of members does not find is left as it is */
} cpinn_polish;

/* values [members][points][columns] and answers [members] for parameters [members][parameters], in
 * units of the SI. polish NULL: its defaults. answers NULL: the network alone, without its error,
 * and not polished. The same bits for any number of threads. Allocates only for members that need
 * solution_create. AD_BAD_ARGUMENT: a parameter that is not finite, or outside its range without
 * `extrapolate`. */
ad_status cpinn_family_evaluate(cpinn_family *family, const cpinn_polish *polish, size_t members,
                                const double *parameters, double *values, cpinn_answer *answers,
                                ad_error *error);

/* The same answers with their derivatives by the parameters, jacobian [members][points][columns]
 * [parameters] in SI units. At rest, where the solver of members takes the scene, they are those of
 * the equilibrium of the answer (solve_members_forces), also of one that is solved. They are not
 * numbers where only solution_create finds the equilibrium, and a step on the mesh of members leads
 * away from it. Of motions without a network they are those of physics/solve/motion_change.h; an
 * answer is not trusted where they are not as exact as that allows. Of other scenes they are those
 * of the network. AD_BAD_ARGUMENT: as above, and motions that have no derivatives. */
ad_status cpinn_family_jacobian(cpinn_family *family, size_t members, const double *parameters,
                                double *values, double *jacobian, cpinn_answer *answers,
                                ad_error *error);

/* Parameters that bring the tip, the last of the family's points, to places: of several random
 * starts the nearest, then Levenberg and Marquardt's method with derivatives of the answers. */
typedef struct cpinn_reach_settings {
    const double *fixed; /* [parameters] values that are given; NaN: chosen. NULL: all are chosen */
    double tolerance;    /* m; 0: CPINN_REACHED */
    uint64_t seed;       /* of the starts */
} cpinn_reach_settings;

#define CPINN_REACHED 1e-5

typedef struct cpinn_reached {
    double distance; /* m, of the nearest tip that was found from the place */
    double bound;    /* m, by how much that may be off: cpinn_family_bound; infinite: no answer */
    bool reached;    /* both together are within the tolerance */
} cpinn_reached;

/* For places [tips][3], m: parameters [tips][parameters] within their ranges, and results [tips]. A
 * place that is not reached may be beyond what the robot reaches, or beyond what the starts have
 * found. The same bits for any number of threads. AD_BAD_ARGUMENT: a family in motion or of beams,
 * or without predicted errors, no points; fixed values outside their range; AD_NO_MEMORY. */
ad_status cpinn_reach(cpinn_family *family, const cpinn_reach_settings *settings, size_t tips,
                      const double *places, double *parameters, cpinn_reached *results,
                      ad_error *error);

/* Which row of parameters [members][parameters] cpinn_family_evaluate would refuse, and which of
 * them is to blame: false, none. */
bool cpinn_family_refuses(const cpinn_family *family, size_t members, const double *parameters,
                          size_t *member, int *parameter);

/* Which row of a check: the network alone, after one and two steps, and the last of these with what
 * is not trusted solved instead. */
typedef enum cpinn_way {
    CPINN_WAY_NETWORK,
    CPINN_WAY_ONE_STEP,
    CPINN_WAY_TWO_STEPS,
    CPINN_WAY_PRODUCT,
    CPINN_WAY_COUNT
} cpinn_way;

const char *cpinn_way_word(cpinn_way way); /* "network", "one step", "two steps", "product" */

/* Errors of answers to fresh members, m: the largest distance of a shape's points from those of the
 * member, solved to a hundredth of CPINN_TOLERANCE. Members that nobody solves are left out. */
typedef struct cpinn_family_row {
    double median, p95, p999, worst;
    size_t not_trusted, reasons[CPINN_REASON_COUNT];
    size_t solved;   /* whose answer is from a solver, not from the network */
    size_t wrong;    /* trusted, and off by more than cpinn_family_bound */
    size_t unknown;  /* trusted, of members that nobody solves */
    double ratio[3]; /* predicted over actual error, quantiles 1, 50 and 99 %. Counted are members
                      * off by less than a fortieth of the length and by more than is known of
                      * them; NaN: none */
    double within;   /* the share of these within 5 % */
    double alone, batch; /* s a shape, one member at a time and many */
} cpinn_family_row;

typedef struct cpinn_family_check {
    size_t members;
    size_t by_members, by_solver; /* solved by solve_members, else by solution_create */
    size_t unsolved;              /* by neither, or with a warning */
    cpinn_family_row rows[CPINN_WAY_COUNT];
    double bare_alone, bare_batch;     /* s a shape, of the network without its errors */
    double solver_alone, solver_batch; /* the same of solve_members; NaN: it does not take these */
    size_t compared;                   /* members solved by both, */
    double apart;                      /* and how far they are apart at most, m */
} cpinn_family_check;

/* What an answer that is trusted may be off by, m: twice the predicted error, which is what a ratio
 * of successive steps below 1/4 allows, and CPINN_TOLERANCE of the length. */
double cpinn_family_bound(const cpinn_family *family, const cpinn_answer *answer);

/* Solve fresh members, drawn at random from the ranges, and compare; times are those of all ranks
 * together. AD_BAD_ARGUMENT: no members. */
ad_status cpinn_family_verify(cpinn_family *family, size_t members, uint64_t seed,
                              cpinn_family_check *result, ad_error *error);

/* ---- classical solutions ----------------------------------------------------------------------
 */

typedef struct cpinn_solution cpinn_solution;

/* How a scene is solved; all 0 is fine, and perturbation and branch are of rods at rest. */
typedef struct cpinn_solve_options {
    double tolerance;    /* of the position, over the length; 0: the solver's default */
    double perturbation; /* a force of so many EI/L^3 pushes across while the loads grow */
    int branch;          /* leave the path of the unstressed rod at the so many-th bifurcation */
} cpinn_solve_options;

/* Solve what the file describes; a motion at `times` [count] in s. options may be NULL.
 * AD_BAD_INPUT, AD_BAD_ARGUMENT: a scene that no solver takes, AD_NO_MEMORY. */
ad_status cpinn_solve_file(const char *path, int count, const char *const *overrides,
                           const cpinn_solve_options *options, size_t time_count,
                           const double *times, cpinn_solution **result, ad_error *error);
ad_status cpinn_solve_scene(const scene *rod_scene, double tolerance, size_t time_count,
                            const double *times, cpinn_solution **result, ad_error *error);
void cpinn_solution_free(cpinn_solution *solution);

const verdict *cpinn_solution_verdict(const cpinn_solution *solution);
double
cpinn_solution_estimate(const cpinn_solution *solution); /* of the largest error; NaN: none */

/* Columns of the scene's model, as evaluators have them without names. */
int cpinn_solution_columns(const cpinn_solution *solution);
const char *cpinn_solution_column_name(const cpinn_solution *solution, int column);

/* values [columns][points] at s [points] (m) and t [points] (s, each one of the times solved for;
 * ignored in a static scene, may then be NULL). AD_BAD_ARGUMENT: a point beyond the rod. */
ad_status cpinn_solution_evaluate(const cpinn_solution *solution, size_t points, const double *s,
                                  const double *t, double *values, ad_error *error);

/* ---- unknowns ----------------------------------------------------------------------------------
 */

/* Unknown numbers of the file's scene (parameters with `identify`) from its data, as cpinn-solve
 * finds them. threads: 0, one per processor. AD_BAD_INPUT: no unknowns, no data; AD_IO,
 * AD_NO_MEMORY. */
typedef struct cpinn_unknowns cpinn_unknowns;

ad_status cpinn_identify_file(const char *path, int count, const char *const *overrides,
                              int threads, cpinn_unknowns **result, ad_error *error);
void cpinn_unknowns_free(cpinn_unknowns *unknowns);

int cpinn_unknowns_count(const cpinn_unknowns *unknowns);
const char *cpinn_unknowns_name(const cpinn_unknowns *unknowns, int unknown);
double cpinn_unknowns_value(const cpinn_unknowns *unknowns, int unknown);
double cpinn_unknowns_deviation(const cpinn_unknowns *unknowns,
                                int unknown); /* standard; NaN: at the end
                                               * of its range */
double cpinn_unknowns_correlation(const cpinn_unknowns *unknowns, int one, int other);
double cpinn_unknowns_chi_squared(
    const cpinn_unknowns *unknowns); /* residuals over their noise, squared */
double
cpinn_unknowns_freedom(const cpinn_unknowns *unknowns); /* degrees of it: numbers less unknowns */
const verdict *cpinn_unknowns_verdict(const cpinn_unknowns *unknowns);

/* ---- robots in steps ---------------------------------------------------------------------------
 */

/* A robot whose state is stepped, many states at once, on several threads: a one-step model that
 * was trained, or the reduced rod itself (physics/chain/reduced.h). Results do not depend on the
 * number of threads nor on how many states there are. One call at a time. */
typedef struct cpinn_stepper cpinn_stepper;

/* The one-step model of a run: its folder, checkpoint.h5 or any such file. threads: 0, one per
 * processor. AD_BAD_INPUT: the run is of another kind; AD_IO, AD_NO_MEMORY. */
ad_status cpinn_stepper_open(const char *path, int threads, cpinn_stepper **result,
                             ad_error *error);

/* The reduced rod of a scene in motion, one step of Radau's method of `step` (s; 0: that of the
 * scene's section surrogate). AD_BAD_INPUT: a scene that reduced_create refuses, without inputs, or
 * with formulas of t. */
ad_status cpinn_stepper_file(const char *path, int count, const char *const *overrides, double step,
                             int threads, cpinn_stepper **result, ad_error *error);
void cpinn_stepper_free(cpinn_stepper *stepper);

int cpinn_stepper_states(const cpinn_stepper *stepper);
int cpinn_stepper_inputs(const cpinn_stepper *stepper);
const scene_parameter *cpinn_stepper_input(const cpinn_stepper *stepper,
                                           int i);               /* name and range */
bool cpinn_stepper_is_slow(const cpinn_stepper *stepper, int i); /* stays while the robot moves */
bool cpinn_stepper_ramps(const cpinn_stepper *stepper);    /* inputs go linearly within a step */
double cpinn_stepper_step(const cpinn_stepper *stepper);   /* s */
double cpinn_stepper_length(const cpinn_stepper *stepper); /* m, of the robot */

/* next [members][states] a step after states [members][states], under inputs [members][inputs] that
 * stay, or go linearly to `after` (NULL: they stay). by_state [members][states][states], by_inputs
 * [members][states][inputs]: derivatives, or NULL. Not numbers where there is no answer.
 * AD_BAD_ARGUMENT: an input outside its range, or a trained model for inputs that move otherwise.
 */
ad_status cpinn_stepper_advance(cpinn_stepper *stepper, size_t members, const double *states,
                                const double *inputs, const double *after, double *next,
                                double *by_state, double *by_inputs, ad_error *error);

/* tip [members][CPINN_TIP_NUMBERS]: position (m), rotation (w, x, y, z; unit, body to world) and
 * velocity (m/s, world) of the end of the robot. */
enum { CPINN_TIP_NUMBERS = 10 };
void cpinn_stepper_tip(cpinn_stepper *stepper, size_t members, const double *states, double *tip);

/* states [members][states] at rest under inputs [members][inputs], of the reduced rod; not numbers
 * where Newton's method finds none, or an input is outside its range. */
void cpinn_stepper_rest(cpinn_stepper *stepper, size_t members, const double *inputs,
                        double *states);

#ifdef __cplusplus
}
#endif

#endif
