/* What the files of training share; not for others. */
#ifndef SURROGATE_TRAINING_PARTS_H
#define SURROGATE_TRAINING_PARTS_H

#include "tools/surrogate/excitation.h"
#include "tools/surrogate/surrogate.h"
#include "tools/surrogate/training.h"

/* Solved steps, sample by sample. */
typedef struct surrogate_steps {
    size_t count;
    double *state, *input, *next;   /* [count][states], [count][inputs], [count][states] */
    double *inner[SURROGATE_INNER]; /* as next, at the other nodes of a curve; NULL: no curve */
} surrogate_steps;

/* Adds those of rollouts. */
ad_status surrogate_steps_add(const excitation_rollouts *motions, bool ramps,
                              surrogate_steps *steps, ad_error *error);
void surrogate_steps_free(surrogate_steps *steps);

/* Numbers of a step by name, for those who fill them in. */
typedef struct surrogate_numbers {
#define SURROGATE_FIELD(name, count) double *name;
    SURROGATE_STEP_NUMBERS(SURROGATE_FIELD)
#undef SURROGATE_FIELD
    double *network;
} surrogate_numbers;

/* Of numbers that belong to whoever asks. */
surrogate_numbers surrogate_numbers_of(const surrogate_step *m, double *numbers);

/* axis_symmetry.c: classes of states and inputs by the symmetry that solved steps show, scales and
 * centers; fills in the step but for its layers, and allocates its numbers, *numbers, which the
 * caller frees. rod: of the model, looked at in its tip. text: what was found, for people. */
ad_status surrogate_find_symmetry(reduced_rod *rod, const surrogate_settings *settings,
                                  const scene *open, const surrogate_steps *steps,
                                  surrogate_step *m, double **numbers, char text[256],
                                  ad_error *error);

/* Coordinates z [2 pairs + evens + odds] of a state and inputs, and back to (x, u) where wanted. */
void surrogate_coordinates(const surrogate_step *m, const double *state, const double *inputs,
                           double *z);

/* linear.c: the linear map by least squares within each class, into the numbers. */
ad_status surrogate_fit_linear(ad_pool *pool, surrogate_step *m, double *numbers,
                               const surrogate_steps *steps, ad_error *error);

/* The matrix Q [n][n], in coordinates of the state, of what an error of one step does to the tip
 * over many: sum_k (A^k)^T C^T C A^k, with C^T C the mean over solved steps, and a little of every
 * number's variance. */
ad_status surrogate_gramian(ad_pool *pool, const surrogate_step *m, reduced_rod *rod,
                            const surrogate_steps *steps, double *q, ad_error *error);

#endif
