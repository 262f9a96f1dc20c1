/* What family.c and family_fit.c share; not for others. */
#ifndef PHYSICS_LEARN_FAMILY_FIT_H
#define PHYSICS_LEARN_FAMILY_FIT_H

#include "autodiff/memory.h"
#include "physics/learn/family.h"

struct family {
    scene open;
    groups *groups;
    size_t nodes;
    double *places; /* [nodes], over the length */
    double length;
    int width, rows, inputs, modes; /* width: 3 and one a tube; rows: of all nodes */
    double *affine;                 /* [rows][1 + inputs] */
    double *shapes;                 /* [rows][modes] */
    double *project;                /* [modes][rows] */
    double *scale;                  /* [modes] */
    double spread, missed;
    ad_memory memory;
};

/* Inputs of the network at coordinates x [parameters]. */
ad_value family_inputs(const family *f, ad_tape *tape, const ad_value *x, groups_turn *turn);

/* What turns the curvature of the member that the inputs are of into the member's own: one row
 * each.
 */
void family_turn_matrix(const groups_turn *turn, ad_tape *tape, ad_value matrix[3][3]);

#endif
