/* Motions of a reduced rod under inputs that move within their ranges: what one-step models are
 * trained with and judged by.
 *
 *   excitation_settings settings = excitation_settings_default();
 *   settings.step = 0.02, settings.steps = 250, settings.count = 80;
 *   excitation_run(&scene, &settings, pool, &motions, &error);
 *   ... motions.state, motions.input ...
 *   excitation_free(&motions);
 *
 * Rollout i of a seed is the same whatever the number of rollouts and threads. They are dealt to
 * the ranks of the pool (autodiff/ranks.h). */
#ifndef SURROGATE_EXCITATION_H
#define SURROGATE_EXCITATION_H

#include "autodiff/ad.h"
#include "autodiff/memory.h"
#include "physics/scene/scene.h"

#include <stdint.h>

typedef enum excitation_kind {
    EXCITATION_STEPS,  /* levels anywhere in the range, at times of its own for each input */
    EXCITATION_RAMPS,  /* straight from one such level to the next */
    EXCITATION_BANG,   /* bang-bang: one end of the range or the other */
    EXCITATION_CHIRPS, /* sines whose frequency sweeps */
    EXCITATION_MIXED,  /* each input by a kind of its own */
    EXCITATION_KIND_COUNT
} excitation_kind;

typedef struct excitation_settings {
    int modes[4];     /* of the reduced rod, as reduced_settings */
    double step;      /* s */
    int steps;        /* of each rollout */
    int count, first; /* rollouts first .. first + count - 1; kinds by turns, or `only` */
    int only;         /* an excitation_kind; -1: all by turns */
    uint64_t seed;
    bool linear;       /* inputs go linearly from instant to instant; false: held */
    uint32_t constant; /* bit i: input i is drawn once for a rollout, as a stiffness */
    /* Levels last and ramps take from `shortest` to `longest` (s), log-uniformly, chirps have
     * periods of two to four times as long; 0: 1 and 50 steps. */
    double shortest, longest;
} excitation_settings;

/* step and steps are left to be given. */
excitation_settings excitation_settings_default(void);

/* Of the largest number of the states: those that move less are rounding, in a robot that stays in
 * a plane. Who scales states takes them as 1, since a filter that looks beside the plane would else
 * be far outside of all motions. */
#define EXCITATION_STAYS 1e-10

typedef struct excitation_rollouts {
    int states, inputs, steps, count;
    double *state; /* [count][steps + 1][states] at the instants; SI units, of reduced.h */
    double *input; /* [count][steps + 1][inputs]: step k is taken with k, or linearly to k + 1 */
    int *done;     /* [count]: steps that were solved; what is behind them is not defined */
    long substepped, lost; /* steps in more parts than usual; not solved so either */
    double seconds;        /* of processor time for all steps */
    ad_memory memory;
} excitation_rollouts;

/* Inputs [steps + 1][count] of rollout `index`, as many as parameters [count]. */
void excitation_draw(int count, const scene_parameter *parameters,
                     const excitation_settings *settings, int index, double *inputs);

/* A rollout begins at the equilibrium of its first inputs where one is found, and every fourth as
 * the scene does. A step is taken in 4 parts, for an error far below that of models, or where
 * these cannot be solved in 8, ... 256; failing that its rollout ends. AD_BAD_INPUT: a scene that
 * reduced_create refuses; AD_BAD_ARGUMENT: bad settings. */
ad_status excitation_run(const scene *open, const excitation_settings *settings, ad_pool *pool,
                         excitation_rollouts *result, ad_error *error);
void excitation_free(excitation_rollouts *rollouts); /* of zeros is allowed */

#endif
