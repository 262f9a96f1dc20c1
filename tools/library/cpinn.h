/* cpinn: physics-informed neural networks for beams and Cosserat rods, as a library.
 *
 *   train     a scene file, or a scene and settings that a program fills in, by the measured recipe
 *             (windows of time, load steps, Gauss-Newton); kept in a folder or in memory alone
 *   open      a model that was trained before, by this library or by cpinn-train
 *   evaluate  values and derivatives of a model at any points: evaluator_evaluate, in
 *             physics/evaluator.h; a few microseconds for one point, without allocations
 *   solve     the same scene by a classical method
 *
 * A scene is filled in from scene_defaults, physics/scene.h, settings from train_settings_default,
 * tools/train/settings.h; what is left open there is chosen by what was measured to be best. All
 * numbers are in SI units.
 *
 * Every function that can fail returns an ad_status and writes one line to its ad_error; AD_OK
 * means that there is an answer, and its verdict (physics/verdict.h) whether it can be trusted.
 * Nothing is printed, and nothing is global: objects are used by one thread at a time, different
 * ones by different threads at once. Functions that free take NULL as well.
 *
 * Names begin with cpinn_ here and with the name of their part in the headers of the parts: ad_,
 * nn_, optim_, scene_, problem_, evaluator_, train_, verdict_ and so on. */
#ifndef CPINN_H
#define CPINN_H

#include "physics/evaluator.h"
#include "physics/scene.h"
#include "physics/solve/members.h"
#include "physics/verdict.h"
#include "tools/train/settings.h"

#include <stdint.h>

#ifdef __cplusplus
extern "C" {
#endif

/* "0.1.0" */
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

/* The same of physics of one's own: a model that the functions of physics/model.h put together,
 * with coordinates, fields and residuals; or that of a scene with further terms, where
 * train_settings_resolve, scene and settings have been through before model_of_scene. It is
 * borrowed, and must outlive what is made of it; so must what its residuals point to. Runs are in
 * memory alone: options->folder has to be NULL. */
ad_status cpinn_train_physics(physics_model *physics, const train_settings *settings,
                              const cpinn_options *options, cpinn_model **model, ad_error *error);

/* A model from a folder of a run, its checkpoint.h5 or any such file. */
ad_status cpinn_open(const char *path, cpinn_model **model, ad_error *error);
void cpinn_free(cpinn_model *model);

/* Write a checkpoint that cpinn_open and cpinn-eval read. AD_BAD_ARGUMENT: of an opened model,
 * which is in a file already. */
ad_status cpinn_save(cpinn_model *model, const char *path, ad_error *error);

/* Of a model; these live as long as it. */
const verdict *cpinn_verdict(const cpinn_model *model);
const scene *cpinn_scene(const cpinn_model *model);
const train_settings *cpinn_settings(const cpinn_model *model); /* resolved */

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

/* ---- classical solutions ----------------------------------------------------------------------
 */

typedef struct cpinn_solution cpinn_solution;

/* Solve what the file describes, to the estimated error `tolerance` of the position as cpinn-solve
 * --tol has it (0: its default); a motion at `times` [count] in s. AD_BAD_INPUT, AD_BAD_ARGUMENT:
 * a scene that no solver takes, AD_NO_MEMORY. */
ad_status cpinn_solve_file(const char *path, int count, const char *const *overrides,
                           double tolerance, size_t time_count, const double *times,
                           cpinn_solution **result, ad_error *error);
ad_status cpinn_solve_scene(const scene *rod_scene, double tolerance, size_t time_count,
                            const double *times, cpinn_solution **result, ad_error *error);
void cpinn_solution_free(cpinn_solution *x);

const verdict *cpinn_solution_verdict(const cpinn_solution *x);
const scene *cpinn_solution_scene(const cpinn_solution *x);
double cpinn_solution_estimate(const cpinn_solution *x); /* of the largest error; NaN: none */

/* Many equilibria of the rod at rest that the file describes, for values of its parameters that
 * have ranges (physics/solve/members.h). AD_BAD_INPUT, AD_BAD_ARGUMENT as there, AD_NO_MEMORY. */
typedef struct cpinn_members cpinn_members;

ad_status cpinn_members_file(const char *path, int count, const char *const *overrides,
                             const solve_members_settings *settings, cpinn_members **result,
                             ad_error *error);
void cpinn_members_free(cpinn_members *x);

/* The name of a parameter, in the order of the file; NULL beyond the last. */
const char *cpinn_members_name(const cpinn_members *x, int parameter);

/* As solve_members_solve. */
ad_status cpinn_members_solve(cpinn_members *x, size_t members, const double *parameters,
                              double *values, solve_member *results, ad_error *error);

/* Columns of the scene's model, as evaluators have them without names. */
int cpinn_solution_columns(const cpinn_solution *x);
const char *cpinn_solution_column_name(const cpinn_solution *x, int column);

/* values [columns][points] at s [points] (m) and t [points] (s, each one of the times solved for;
 * ignored in a static scene, may then be NULL). */
ad_status cpinn_solution_evaluate(const cpinn_solution *x, size_t points, const double *s,
                                  const double *t, double *values, ad_error *error);

#ifdef __cplusplus
}
#endif

#endif
