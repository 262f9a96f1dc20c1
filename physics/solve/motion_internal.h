/* What the files of the motion share; not for others. */
#ifndef PHYSICS_SOLVE_MOTION_INTERNAL_H
#define PHYSICS_SOLVE_MOTION_INTERNAL_H

#include "physics/solve/motion.h"
#include "physics/solve/processor.h"

/* What is differentiated at a node, padded for the processor: a vector, a quaternion, 0. */
enum { MOTION_LANE_Q = 3 };

/* Strains and forces at a quadrature point, body frame. */
typedef struct motion_strained {
    double v[3], u[3], n[3], m[3];
} motion_strained;

/* What the rod is made of at a node, stiffness finite also where it is locked. */
typedef struct motion_material {
    solve_section section;
    double by_mass, by_inertia[3]; /* 1 over them */
} motion_material;

struct motion {
    const solve_rod *rod;
    int elements, degree;
    size_t nodes;
    bool is_damped; /* Bse or Bbt */
    bool has_time;  /* loads, ends and a rest shape that moves are those of `time` */
    double time;

    double *points;             /* [degree + 1] on [-1, 1] */
    double *point_weights;      /* [degree + 1] */
    double *derivative;         /* [degree + 1][degree + 1] d/ds */
    double *transposed;         /* of the derivative */
    double *s;                  /* [nodes] */
    double *weight;             /* [nodes] of the quadrature over the rod */
    double *element_weight;     /* [degree + 1] of the quadrature over an element */
    motion_material *materials; /* [nodes] */
    solve_rest *rest;           /* [nodes] */
    solve_load *load;           /* [nodes] */
    solve_end_state ends[2];    /* at s = 0, 1 */

    double (*pose)[LANES];                                          /* [nodes] r, q; unit */
    double (*flow)[LANES];                                          /* [nodes] V, q_t */
    double (*spin)[3];                                              /* [nodes] w */
    double (*R)[3][3];                                              /* [nodes] */
    double (*slope)[LANES], (*slope_rate)[LANES], (*wrench)[LANES]; /* [degree + 1] */
    motion_strained *sections;                                      /* [elements][degree + 1] */
    double (*force)[LANES];  /* [nodes] internal, as an impulse on r and q */
    double (*torque)[3];     /* [nodes] internal, body */
    double (*push)[3];       /* [nodes] outside force, world */
    double (*turn)[3];       /* [nodes] outside moment, body */
    double (*velocity)[3];   /* [nodes] V */
    double (*resistance)[3]; /* [nodes] per length, part of the push; 0 without any */
};

/* The node at an end, 0 or 1. */
static inline size_t motion_end_node(const motion *m, int end)
{
    return end ? m->nodes - 1 : 0;
}

/* Take a state, with what the ends prescribe at the time. */
void motion_set_nodes(motion *m, const double *state);

/* From nodes that are set: strains, internal forces; outside forces. */
void motion_internal_forces(motion *m);
void motion_outside_forces(motion *m);

#endif
