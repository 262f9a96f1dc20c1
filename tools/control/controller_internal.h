/* What controller.c and controller_plan.c, which finds plans, share; for them alone. */
#ifndef CONTROL_CONTROLLER_INTERNAL_H
#define CONTROL_CONTROLLER_INTERNAL_H

#include "tools/control/controller.h"
#include "tools/control/small_matrix.h"

#include <stdbool.h>

struct controller {
    controller_settings settings; /* with what NULL and 0 stand for */
    int n, m, v, horizon, moves, delay;
    void *work;         /* of controller_plan.c */
    double *span;       /* [m] upper - lower */
    double *rest;       /* [m] */
    double *others;     /* [model.inputs] */
    double *reference;  /* [horizon][v]; NaN: no wish */
    double *plan;       /* [horizon][m] from the next answer on */
    double *pending;    /* [delay][m] decided, not applied yet at the time of the last state */
    double *last;       /* [m] last answer, before the plan */
    double *state;      /* [n] of now, seen or predicted */
    double *start;      /* [n] where the plan begins */
    double *expected;   /* [n] state of the next sample by the model alone, without drift */
    double *drift;      /* [n] */
    double *bias;       /* [v] */
    double *margin;     /* [v] */
    double *row, *next; /* [model.inputs], [max(n, v)] */
    double cost;
    int iterations; /* of the last quadratic program */
    int most;       /* of them, set by controller_plan_init */
    int coasted;    /* samples without a state */
    bool known;     /* state and start are defined */
    bool foreseen;  /* expected is defined */
    bool prepared;  /* controller_plan_prepare was called for `plan` */
    bool restart;   /* states along the plan that controller_plan.c keeps do not belong to it */
};

/* How a plan is found. `prepare` may use the plan, not the state; `solve` changes the plan for the
 * state `start`, and says what it costs; both return flags, and the plan stays where it is if these
 * are CONTROLLER_MODEL or CONTROLLER_QP. `shift`: the plan went on by one sample. */
size_t controller_plan_size(const controller_settings *settings);
void controller_plan_init(controller *c, void *memory);
int controller_plan_prepare(controller *c);
int controller_plan_solve(controller *c);
void controller_plan_shift(controller *c);

/* inputs [model.inputs] with row `move` of the plan [m]. */
void controller_inputs(const controller *c, const double *move, double *inputs);
/* Where input j may be in the next sample. */
void controller_range(const controller *c, int j, double before, double *lower, double *upper);
/* moves [moves][m] cut to what is allowed after the last answer. */
void controller_allow(const controller *c, double *moves);
bool controller_finite(const double *x, int count);

#endif
