/* How a motion changes with the parameters of its family: derivatives of all that is seen of a rod,
 * by strain modes.
 *
 *   motion_change_create(&family, parameters, &settings, count, times, &change, &report, &error);
 *   motion_change_evaluate(change, columns, points, s, t, by, &error);
 *   motion_change_free(change);
 *
 * Derivatives of the state go on with it: those of each step are exact ones of the step, by its own
 * matrix. What a state looks like is differentiated along them, as the start is, by differences to
 * both sides. */
#ifndef PHYSICS_SOLVE_MOTION_CHANGE_H
#define PHYSICS_SOLVE_MOTION_CHANGE_H

#include "physics/solve/solve.h"

#ifdef __cplusplus
extern "C" {
#endif

typedef struct motion_change motion_change;

/* Derivatives may be off by so many tolerances of the motion. */
static const double MOTION_CHANGE_OF_TOLERANCE = 100;

typedef struct motion_change_report {
    double estimate; /* of the error of the derivatives of positions by the parameter of which they
                      * are the least exact, relative L2 over s and t; NaN: not estimated */
    int worst;       /* that parameter */
    long time_steps; /* all together */
} motion_change_report;

/* Of a family in motion that passes scene_check, at parameters [parameter_count] for which the
 * member does, too (states of memory follow from the others); times [count] s, within the duration
 * and in any order. settings->modes: those numbers, without an estimate; else more of them until
 * derivatives are estimated to be within MOTION_CHANGE_OF_TOLERANCE, as well as it goes.
 * AD_BAD_ARGUMENT: what modes do not take (physics/scene/support.h), memory beside unknowns,
 * settings->from with lengths that have ranges or a Maxwell branch, and an instant at which
 * something jumps or has a kink that a parameter moves. AD_NOT_FINITE, AD_NO_MEMORY, errors of
 * formulas. */
ad_status motion_change_create(const scene *family, const double *parameters,
                               const solve_settings *settings, size_t count, const double *times,
                               motion_change **result, motion_change_report *report,
                               ad_error *error);
void motion_change_free(motion_change *change); /* NULL is allowed */

/* by [columns][parameter_count][points]: of the first columns of the scene's model, in SI units by
 * that of the parameter, at s [points] (m, of the family: scene_map) and t [points] (s), the
 * nearest of the times. Quicker where points of one time follow one another. AD_NO_MEMORY. */
ad_status motion_change_evaluate(const motion_change *change, int columns, size_t points,
                                 const double *s, const double *t, double *by, ad_error *error);

#ifdef __cplusplus
}
#endif

#endif
