/* A trained network, or one for each window of time, at given points and fast: any observable of
 * the scene's model and any derivative of it by s and t, in SI units. Made for one point at a time
 * as much as for many: it works on the caller's thread alone and allocates nothing while it
 * evaluates. An evaluator is for one thread at a time; several threads take one each. */
#ifndef PHYSICS_LEARN_EVALUATOR_H
#define PHYSICS_LEARN_EVALUATOR_H

#include "nn/nn.h"
#include "physics/learn/model.h"

#include <stdio.h>

#ifdef __cplusplus
extern "C" {
#endif

typedef struct evaluator evaluator;

enum { EVALUATOR_COLUMNS_MAX = 128, EVALUATOR_ORDER_MAX = 4, EVALUATOR_NAME_MAX = 96 };

/* A network that was trained on a model. */
typedef struct evaluator_model {
    const physics_model *physics;
    const nn_mlp *mlp;
    int windows;              /* how many have been trained, from t = 0 on */
    const double *parameters; /* [windows][nn_mlp_parameters] */
    const double *starts;     /* [windows][window_state_numbers], of all but the first */
} evaluator_model;

/* `names`: what to evaluate, separated by spaces or commas; NULL: every column of the scene's
 * model. A name is that of a column ("x", "qw", "m2", of beams "w"), or r or q for all columns of a
 * rod's position or rotation. Behind an underscore stand s and t (of a model of one's own its
 * coordinates) as often as it is differentiated, four times at most: "x_s", "r_tt", "m2_st". By a
 * parameter of a family it is the parameter's name, "x_load", "x_s_load". Everything is compiled
 * here, and nothing of the model is needed afterwards. AD_BAD_ARGUMENT: no such name, or too many;
 * AD_NO_MEMORY. */
ad_status evaluator_create(const evaluator_model *model, const char *names, evaluator **result,
                           ad_error *error);
/* The same, and after these columns the derivatives of each by every coordinate of the domain. */
ad_status evaluator_create_jacobian(const evaluator_model *model, const char *names,
                                    evaluator **result, ad_error *error);
void evaluator_free(evaluator *e); /* NULL is fine */

int evaluator_columns(const evaluator *e);
const char *evaluator_column_name(const evaluator *e, int column); /* "x_s" */
const char *evaluator_column_unit(const evaluator *e, int column); /* "m", "N m s^-1"; "" for 1 */

/* Of the range of a coordinate: grids end with rounding, those of float numbers with 6e-8. */
#define EVALUATOR_BEYOND 1e-6

/* values [columns][points] at s [points] (m) and t [points] (s; ignored in a static scene, may then
 * be NULL). An instant between two windows belongs to the one that it ends; a time beyond the last
 * window that is trained is taken as that window's. NaN gives NaN. AD_BAD_ARGUMENT: of a model with
 * other coordinates, as a family; a point beyond the rod or a time beyond the motion, where
 * networks mean nothing. */
ad_status evaluator_evaluate(evaluator *e, size_t points, const double *s, const double *t,
                             double *values, ad_error *error);

/* The same of any model: at[coordinates of its domain][points], in their units of the SI.
 * Parameters of a family may lie outside their ranges. */
ad_status evaluator_evaluate_at(evaluator *e, size_t points, const double *const *at,
                                double *values, ad_error *error);

/* How much rounding can change the values at these points: change [columns], the largest difference
 * when every number of the networks is changed by up to 2^-53 of it, in several ways. */
ad_status evaluator_rounding(evaluator *e, size_t points, const double *const *at, double *change,
                             ad_error *error);

/* Evaluators of one model as static C functions, of type double or, where `single`, float:
 *     void NAMES[i]_first(const double *x, double *y, double *w)
 *     void NAMES[i]_later(int window, const double *x, double *y, double *w)
 * of the first window and of those after it, counted from 0 there. `window` is left out where it is
 * only one. Of a model without windows there is the first function alone. x: the coordinates in
 * units of their scales, y: the columns in units of the SI, w: workspace of *memory numbers. What
 * they include is written, too. */
ad_status evaluator_write_c(int count, evaluator *const *list, const char *const *names,
                            bool single, FILE *file, size_t *memory, ad_error *error);

#ifdef __cplusplus
}
#endif

#endif
