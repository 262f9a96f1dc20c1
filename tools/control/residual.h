/* What measured motions tell of a robot beyond its model: a network added to the model's steps and
 * trained through them, a knowledge-based neural ordinary differential equation (Jiahao et al.
 * 2024).
 *
 *   x+ = f(x, u, h) + h D W2 tanh(b + W1 (x/D, (u - c)/C))
 *
 * f is any one-step model: the reduced rod, that is the solver itself, or a surrogate. D are sizes
 * of the states, c and C middle and half of the ranges of inputs. With W2 = 0 it is f. Derivatives
 * are exact where those of f are. */
#ifndef CONTROL_RESIDUAL_H
#define CONTROL_RESIDUAL_H

#include "autodiff/error.h"
#include "physics/local/one_step.h"
#include "physics/scene/scene.h"
#include "tools/train/least_squares.h"

#include <stddef.h>
#include <stdint.h>

typedef struct residual residual;

/* D [states], c, C [inputs]; all numbers of the network are 0. AD_NO_MEMORY. */
ad_status residual_create(const one_step *of, int units, const double *size, const double *middle,
                          const double *half, residual **result, ad_error *error);
void residual_free(residual *residual); /* NULL is allowed */

/* The corrected model; borrows x and what `of` borrowed, for one thread at a time. */
one_step residual_one_step(residual *residual);

size_t residual_count(const residual *residual); /* of its numbers */

/* A measured motion: samples [count] one h after the other; inputs [count][inputs], held until the
 * next sample; seen [count][values], not a number where there was no measurement; start [states]:
 * the state at the first sample. All borrowed. */
typedef struct residual_run {
    size_t count;
    const double *inputs, *seen, *start;
} residual_run;

typedef struct residual_settings {
    int steps;     /* of Levenberg and Marquardt's method at most */
    double noise;  /* of each number that is seen, in its unit: misses of this size cost as much as
                    * numbers of the network of 1 */
    uint64_t seed; /* of the first W1 */
    const least_squares_runner *runner; /* NULL: none */
} residual_settings;

/* Root mean square of what is missed over runs, in the unit of what is seen; infinite where the
 * model has no answer. */
double residual_error(const one_step *model, double h, const one_observation *observation,
                      size_t runs, const residual_run *run);

/* Trains the network through the steps of whole runs: derivatives of all states by its numbers go
 * along. Of the runs, the last `held_out` are not trained on and choose among the networks on the
 * way (0: the last network). AD_BAD_INPUT: a model without an answer on a run. */
ad_status residual_fit(residual *residual, double h, const one_observation *observation,
                       size_t runs, const residual_run *run, size_t held_out,
                       const residual_settings *settings, ad_error *error);

/* A table (tools/files/table_file.h); read for a model of as many states and inputs, which have
 * these ranges [inputs]. AD_BAD_INPUT, errors of the table. */
ad_status residual_write(const residual *residual, const char *path, ad_error *error);
ad_status residual_read(const char *path, const one_step *of, const scene_parameter *ranges,
                        residual **result, ad_error *error);

#endif
