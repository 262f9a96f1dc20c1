/* What the files of reduced rods share; not for others. */
#ifndef PHYSICS_CHAIN_REDUCED_INTERNAL_H
#define PHYSICS_CHAIN_REDUCED_INTERNAL_H

#include "autodiff/memory.h"
#include "physics/chain/modes_internal.h"
#include "physics/chain/modes_step.h"
#include "physics/chain/reduced.h"
#include "physics/scene/scene_values.h"

struct reduced_rod {
    scene open;
    scene_values values; /* its names, where inputs have a memory */
    solve_rod *rod;
    modes *m;
    collocation *step;
    kinematics look; /* of places, all rows but those of curvature */
    modes_places *places;
    int count;
    double newton;
    double *unit;        /* [states] of the state: SI by the model's */
    double *q, *v, *a;   /* [size] each */
    double *d;           /* [size] stretches of Maxwell branches */
    double *residual;    /* [size] */
    double *start;       /* [states] */
    double *by_q, *by_v; /* [size][width] */
    double *by;          /* of accelerations, [size][states + inputs]; of a step, along all */
    double *branch_by;   /* [2][inputs][size] of modes_branch_by_inputs */
    double *mass;        /* [width][width] */
    double *room;        /* of the derivatives of a step */
    double *seen;        /* [count][KINEMATICS_SEEN] */
    double *look_room;
    double *along;     /* [all states + inputs][the same] */
    double *change[2]; /* [all states + inputs][inputs] of inputs before and after a step */
    ad_memory memory;
    int *pivots;           /* [size] */
    double *rates;         /* [4][inputs] of inputs that ends follow, in the model's time: of one
                            * instant, first and second; before and after a step */
    collocation_path path; /* which: of inputs that ends depend on */
};

/* rod->q, rod->v, rod->d from a state in SI units, and back. */
void reduced_take_state(reduced_rod *rod, const double *state);
void reduced_give_state(const reduced_rod *rod, double *state);

#endif
