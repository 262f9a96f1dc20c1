/* What was measured on a scene with unknown parameters, and by how much solutions at trial values
 * of these miss it.
 *
 * The scene has parameters (physics/scene/scene.h): some are unknown, the others known for each row
 * of the measurements. Rows with the same known values are one experiment: one member of the
 * family, solved once. Rods at rest that physics/chain/solve_members.h takes are solved by it, all
 * experiments at all trial values in one batch; others, and what needs forces and moments, by
 * solution_create, over threads. Rows with the same inputs over time are one motion, which
 * recording.h follows. Where inputs have a memory (physics/scene/scene_memory.h), rows count in
 * their order: those in turn with the same known values are one experiment. */
#ifndef PHYSICS_SOLVE_MEASURED_H
#define PHYSICS_SOLVE_MEASURED_H

#include "physics/learn/model.h"
#include "physics/scene/view.h"
#include "physics/solve/recording.h"
#include "physics/solve/solve.h"

/* Rows of measured numbers, in SI; borrowed. Of a rotation in space all four numbers are there or
 * none: its residual is the rotation vector between the two, with the noise of its first column, in
 * rad, about every axis. Other numbers may be missing. */
typedef struct solve_measured {
    size_t rows;
    const double *s;     /* [rows] m */
    const double *t;     /* [rows] s; at rest not looked at */
    const double *known; /* [rows][parameter_count of the scene]; of unknowns not looked at */
    int columns;
    int column[MODEL_COLUMNS_MAX];     /* [columns] of the scene's model, ascending */
    double noise[MODEL_COLUMNS_MAX];   /* [columns] standard deviation, > 0, in the column's unit */
    const double *values;              /* [columns][rows]; NaN: missing, and does not count */
    const solve_inputs *const *inputs; /* [rows] over time, NULL: none of a row; NULL: of none */
    const double *weight;              /* [rows] of their squares; NULL: 1 */
    int modes[4]; /* of motions by modes, the same of all sets; all 0: of recordings with inputs
                   * the usual ones, else as many as the noise asks for */
    const scene_view *view; /* of positions and rotations in space, of which all columns are there;
                             * its delay of any quantity. NULL: they are those of the axis */
    /* Of inputs with a memory: known values of all that was commanded from the beginning on, as
     * above, [commands]; and which of them each row has, ascending, [rows]. NULL: the rows are all.
     */
    size_t commands;
    const double *command;
    const size_t *at;
} solve_measured;

size_t solve_measured_missing(const solve_measured *set); /* numbers that are */

/* How many residuals a row of the scene has: those of its numbers, of a rotation in space three. */
size_t solve_measured_residuals(const scene *open, const solve_measured *set, size_t row);

typedef struct solve_trials solve_trials;

/* Measurements in `sets` lists, on places within the rod and the duration; the scene is copied, its
 * formulas must outlive the trials. tolerance: of the position over the length, as in
 * solve_settings; 0: 1e-8, in motion its default, and
 * never more than a tenth of the noise. AD_NO_MEMORY.
 */
ad_status solve_trials_create(const scene *open, int sets, const solve_measured *measured,
                              double tolerance, int threads, solve_trials **result,
                              ad_error *error);
void solve_trials_free(solve_trials *trials); /* NULL is allowed */

/* From now on each experiment has values of its own: where one trial is run or differentiated,
 * values are [experiments][unknowns]. What inputs with a memory depend on has to be the same for
 * all. AD_NO_MEMORY. */
ad_status solve_trials_apart(solve_trials *trials, ad_error *error);

/* The experiment of each residual [residuals]. */
void solve_trials_tell(const solve_trials *trials, size_t *experiment);

/* Their parameters [experiments][parameter_count] at the values of one trial, with what inputs with
 * a memory were before each; and, where slopes were wanted, the derivative of a number by an
 * unknown, of its derivatives by all parameters at fixed states, column [parameter_count].
 * AD_NO_MEMORY. */
ad_status solve_trials_remember(solve_trials *trials, const double *values, bool slopes,
                                double *parameters, ad_error *error);
double solve_trials_change(const solve_trials *trials, size_t experiment, int parameter,
                           const double *column);

size_t solve_trials_residuals(const solve_trials *trials); /* numbers that were measured */
size_t solve_trials_experiments(const solve_trials *trials);

/* From then on each `every`-th experiment alone counts, 1: all of them: residuals of others are 0.
 * Their number without these. */
size_t solve_trials_thin(solve_trials *trials, size_t every);

double solve_trials_tolerance(const solve_trials *trials); /* of the solutions */
bool solve_trials_by_members(const solve_trials *trials);
/* Why the last run left some that are not
 * numbers; "": it did not, or by members. */
const char *solve_trials_reason(const solve_trials *trials);

/* What later runs depend on of those before, [experiments]: nodes of motions, once they are chosen.
 * NULL: nothing. */
double *solve_trials_nodes(const solve_trials *trials);

/* residuals [count][residuals], computed less measured over its noise, at values [count][unknowns]
 * in SI; not numbers where there is no solution. Rough: not where it is hard to find either, and
 * with a fixed, small number of nodes. The same bits for any number of threads. AD_BAD_ARGUMENT: a
 * scene that no solver takes; AD_NO_MEMORY. */
ad_status solve_trials_run(solve_trials *trials, size_t count, const double *values, bool rough,
                           double *residuals, ad_error *error);

/* jacobian [unknowns][residuals], their derivatives by the unknowns in SI, at values [unknowns] of
 * which residuals [residuals] are those of a run. By members they are exact, to some 1e-8
 * (solve_members_jacobian). Of experiments that these do not solve they are differences between
 * ends [unknowns][2], values beside, for which `solved` solutions are found: to one side where
 * there is none on the other, not numbers where there is none; ends NULL: no numbers. room [2
 * unknowns][residuals] is written over. Bits and errors as above. */
ad_status solve_trials_differentiate(solve_trials *trials, const double *values, const double *ends,
                                     const double *residuals, double *room, double *jacobian,
                                     size_t *solved, ad_error *error);

/* Chooses nodes, modes and steps of time of motions anew at these values; what was chosen before
 * stays where it is as many. `more`: whether some are more now. room [residuals]. */
ad_status solve_trials_choose(solve_trials *trials, const double *values, double *room, bool *more,
                              ad_error *error);

/* Of motions by modes: by how much residuals change, rms, where there are two more of each that
 * there are any of, and twice as many steps between samples of inputs; 0: there are no such
 * motions. Later runs have them, too. NaN: no solution with them. */
ad_status solve_trials_reduction(solve_trials *trials, const double *values, double *rms,
                                 ad_error *error);

#endif
