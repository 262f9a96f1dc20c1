/* How far a one-step model is from the solver of the reduced rod, under inputs that it has not
 * seen: after one step, 5 s and 1000 steps, and what a step costs.
 *
 *   rollouts_subject subject = {&scene, {2, 1, 2, 1}, &model, "flow", false, 1 << 3};
 *   rollouts_judge(&subject, 16, 1, pool, &report, &error);
 *   rollouts_free(&report); */
#ifndef SURROGATE_ROLLOUTS_H
#define SURROGATE_ROLLOUTS_H

#include "autodiff/ad.h"
#include "autodiff/memory.h"
#include "physics/local/one_step.h"
#include "physics/scene/scene.h"

#include <stdint.h>

typedef struct rollouts_subject {
    const struct scene *scene;
    int modes[4]; /* of the reduced rod whose state the model has, as reduced_settings */
    const one_step *model;
    const char *name;  /* static text */
    bool linear;       /* inputs go linearly within a step; false: they are held */
    uint32_t constant; /* bit i: input i stays during a rollout, as a stiffness */
} rollouts_subject;

/* Errors are those of the tip's position over the length, at the end of each step: the median and
 * the worst of all steps of all rollouts that do not diverge. A rollout diverges when a number is
 * not finite or the tip is off by more than a quarter of the length. NaN: not measured. */
enum { ROLLOUTS_MEDIAN, ROLLOUTS_WORST };
enum { ROLLOUTS_ONE, ROLLOUTS_SHORT, ROLLOUTS_LONG, ROLLOUTS_SPANS };
enum { ROLLOUTS_TOGETHER = 147 }; /* sigma points of a filter, samples of a controller */

typedef struct rollouts_row {
    const char *name; /* static */
    int states;
    double error[ROLLOUTS_SPANS][2];
    int diverged;                     /* of the rollouts */
    double alone, together, jacobian; /* s of processor time: a step, ROLLOUTS_TOGETHER of them,
                                       * one with derivatives */
} rollouts_row;

/* The model; the reduced rod by one and by two steps of Radau's method for each, without what the
 * solver takes more; and a rod with one mode more for each strain, solved: the error of the modes.
 */
enum { ROLLOUTS_MODEL, ROLLOUTS_ROD, ROLLOUTS_ROD_TWICE, ROLLOUTS_FINER, ROLLOUTS_ROWS };

typedef struct rollouts_report {
    int count, steps[ROLLOUTS_SPANS]; /* of rollouts; of each span */
    double step, length;              /* s, m */
    double solver;                    /* s of processor time, a step of the solver */
    long lost;                        /* steps that the solver could not take, left out */
    double outside;                   /* part of the steps outside of the range of training */
    double growth;                    /* of the robot at rest: tools/surrogate/growth.h */
    rollouts_row rows[ROLLOUTS_ROWS];
    double (*over_time)[2];  /* [steps of the short span]: errors of the model after each step */
    double (*path)[2][3];    /* [steps of the short span]: m, the tip of a typical rollout by the
                              * solver and by the model */
    double *states, *inputs; /* of that rollout [steps of the short span + 1]: [2][states of the
                              * model], and the inputs [of the model] that follow */
    ad_memory memory;
} rollouts_report;

/* `count` rollouts that follow from the seed. AD_BAD_INPUT: a scene that reduced_create refuses. */
ad_status rollouts_judge(const rollouts_subject *subject, int count, uint64_t seed, ad_pool *pool,
                         rollouts_report *report, ad_error *error);
void rollouts_free(rollouts_report *report); /* of zeros is allowed */

/* Whether the model diverges, or its worst error over 5 s and that of its modes are above a
 * tolerance (NaN: none) together. */
bool rollouts_fail(const rollouts_report *report, double tolerance);

#endif
