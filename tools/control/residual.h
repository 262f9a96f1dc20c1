/* What measured motions tell of a robot beyond its model: a network added to the model's steps and
 * trained through them, a knowledge-based neural ordinary differential equation (Jiahao et al.
 * 2024).
 *
 *   x+ = f(x, u, h) + h N(x, u)
 *
 * f is any one-step model: the reduced rod, that is the solver itself, or a surrogate. N is a
 * network on the tape (tools/train/learned_net.h), which sees states over their sizes and inputs
 * in their ranges. With N = 0 it is f. Derivatives are exact where those of f are.
 *
 * What the runs leave open of its numbers is their linearised posterior (MacKay, Neural Computation
 * 4 (1992) 448) with a prior of size 1: near what it was trained on the network is known, and far
 * from it not. one_step.doubt says so of a step. */
#ifndef CONTROL_RESIDUAL_H
#define CONTROL_RESIDUAL_H

#include "autodiff/error.h"
#include "physics/local/one_step.h"
#include "physics/scene/scene.h"
#include "tools/train/least_squares.h"

#include <stddef.h>
#include <stdint.h>

typedef struct residual residual;

/* size [states]; middle and half of the ranges [inputs]; all numbers of the network are 0, and not
 * known. AD_BAD_INPUT: too many states and inputs; AD_NO_MEMORY. */
ad_status residual_create(const one_step *of, int units, const double *size, const double *middle,
                          const double *half, residual **result, ad_error *error);
void residual_free(residual *residual); /* NULL is allowed */

/* The corrected model; borrows x and what `of` borrowed, for one thread at a time. */
one_step residual_one_step(residual *residual);

/* The equilibrium of the corrected model for held inputs, from a state near it, and its derivatives
 * [states][inputs]. Whether it is found; else state is as it was. */
bool residual_settle(residual *residual, double h, const double *inputs, double *state, double *by);

/* Largest deviations, in the unit of what is seen, that the network's numbers leave to a motion
 * that nothing corrects: of those that it was trained on, and of all that one_step.doubt has
 * followed. NULL: NaN. */
typedef struct residual_reach {
    double trained, most;
} residual_reach;

residual_reach residual_reached(const residual *residual);

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
    uint64_t seed; /* of the network's first numbers */
    const least_squares_runner *runner; /* NULL: none */
} residual_settings;

/* Root mean square of what is missed over runs, in the unit of what is seen; infinite where the
 * model has no answer. */
double residual_error(const one_step *model, double h, const one_observation *observation,
                      size_t runs, const residual_run *run);

/* Trains the network through the steps of whole runs: derivatives of all states by its numbers go
 * along. Of the runs, the last `held_out` are not trained on and choose among the networks on the
 * way (0: the last network), and say what is left. AD_BAD_INPUT: a model without an answer on a
 * run. */
ad_status residual_fit(residual *residual, double h, const one_observation *observation,
                       size_t runs, const residual_run *run, size_t held_out,
                       const residual_settings *settings, ad_error *error);

/* Of each number that is seen over runs: root mean squares of what is missed and of the deviation
 * that is said of it, by what is open of the network and what was left on runs held out; and the
 * part of the numbers within one and two deviations. */
typedef struct residual_score {
    double rms, deviation, covered[2];
} residual_score;

ad_status residual_judge(residual *residual, double h, const one_observation *observation,
                         size_t runs, const residual_run *run, residual_score *score,
                         ad_error *error);

/* As tools/train/learned_file.h; read for a model of as many states and inputs, which have these
 * ranges [inputs]. AD_BAD_INPUT, errors of the file. */
ad_status residual_write(const residual *residual, const char *path, ad_error *error);
ad_status residual_read(const char *path, const one_step *of, const scene_parameter *ranges,
                        residual **result, ad_error *error);

#endif
