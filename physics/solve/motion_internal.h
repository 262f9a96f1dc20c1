/* What the files of the motion share; not for others. */
#ifndef PHYSICS_SOLVE_MOTION_INTERNAL_H
#define PHYSICS_SOLVE_MOTION_INTERNAL_H

#include "physics/local/actuation.h"
#include "physics/numerics/processor.h"
#include "physics/solve/motion.h"

/* What is differentiated at a node, padded for the processor: a vector, a quaternion, 0. */
enum { MOTION_LANE_Q = 3, MOTION_LANES = 7 };

/* Strains v and then u, and what goes with them. */
enum { MOTION_U = 3, MOTION_STRAINS = 6 };

/* Quadrature points of one element side by side, LANES of them; those beyond its last point repeat
 * it and count for nothing. Body frame. Locked strains have a finite stiffness here. */
typedef struct motion_block {
    lanes weight; /* of the quadrature over s */
    lanes stiffness[MOTION_STRAINS], damping[MOTION_STRAINS], rest[MOTION_STRAINS];
    lanes branch[MOTION_STRAINS], relaxing; /* Maxwell's: stiffness, one over the time */
    lanes memory[MOTION_STRAINS];           /* strain of its damper */
    lanes q[4], strain[MOTION_STRAINS];
    lanes rate[MOTION_STRAINS];   /* of strain, where it is damped */
    lanes stress[MOTION_STRAINS]; /* n, m */
    lanes pull[MOTION_STRAINS];   /* of actuators, a part of the stress */
    lanes law[MOTION_STRAINS];    /* the same of a law, beyond the stiffness; */
    lanes law_energy;             /* per length */
    lanes along;                  /* scalar part of q* q_s: q is unit at nodes only */
} motion_block;

/* A node where something acts: rod->jumps.at[] in their order. At a joint the node has a frame of
 * its own, from which those of the elements that meet there are turned. */
typedef struct motion_place {
    size_t node;
    int edge;
    bool turns;
    double before[4], after[4]; /* from the node's frame to those of the elements; unit */
} motion_place;

/* What moves with a node beside its own mass and inertia: its mass matrix, and by what it resists
 * without acceleration; positions and forces in the world, turns and moments in the body frame. */
typedef struct motion_added {
    bool any;     /* false: 0 */
    bool couples; /* false: only the 3 by 3 block of positions is not 0 */
    double mass[6][6], wrench[6];
} motion_added;

enum { MOTION_OWNED_MAX = 40 };

/* A point of quadrature is one of an element's nodes, seen from this element: number
 * element (degree + 1) + k, of `points` in all. Two elements share a node, and what the rod is made
 * of, its rest shape and its loads may jump there. */
struct motion {
    const solve_rod *rod;
    int elements, degree;
    int blocks; /* of an element */
    size_t nodes, points;
    bool is_damped; /* Bse or Bbt, or a branch */
    bool has_branch;
    double following; /* the time within which the memory follows strains; 0: it stays */
    bool has_added;   /* added mass of a fluid, or bodies beside the axis */
    bool is_pulled;   /* by actuators */
    bool has_time;    /* loads, ends and a rest shape that moves are those of `time` */
    double time;

    bool lacks_memory;
    int owned_count;
    void *owned[MOTION_OWNED_MAX]; /* what is pointed to below */
    double *edge;                  /* [elements + 1] s */
    double *abscissas;             /* [degree + 1] on [-1, 1] */
    double *weights;               /* [degree + 1] of the quadrature over [-1, 1] */
    double *derivative;        /* [degree + 1][blocks LANES]: (j, k) of the j-th polynomial at k */
    double *transposed;        /* [degree + 1][blocks LANES]: (j, k) of the k-th at j */
    double *s;                 /* [nodes] */
    double *point_s;           /* [points] s, within the element where two meet */
    double *point_weight;      /* [points] of the quadrature over s */
    double *node_weight;       /* [nodes] its sum over elements */
    solve_section *made;       /* [points] */
    solve_rest *rest;          /* [points] */
    solve_actuator *actuators; /* [points][those of the rod] */
    double *along;             /* [points][numbers of what acts along the rod] */
    double *relaxing;          /* [points][MOTION_STRAINS] one over the time of its branch */
    double *mass;              /* [nodes] rhoA likewise */
    double (*inertia)[3];      /* [nodes] rhoJ likewise */
    double *by_mass, (*by_inertia)[3];        /* [nodes] 1 over them */
    solve_end_state ends[2];                  /* at s = 0, 1 */
    double displacement[SOLVE_ACTUATORS_MAX]; /* of tendons whose length is given, by L */
    double tensions[SOLVE_ACTUATORS_MAX];     /* of them, by EI/L^2 */
    motion_place *places;                     /* [rod->jumps.count] */
    double *number;                           /* [rod->jumps.numbers] of what acts there, now */
    const double *(*frame)[2]; /* [elements] of the first and last point; NULL: the node's */

    motion_block *block;      /* [elements][blocks] */
    double (*pose)[LANES];    /* [nodes] r, q; unit */
    double (*flow)[LANES];    /* [nodes] V, q_t */
    double (*spin)[3];        /* [nodes] w */
    double *wrench;           /* [MOTION_LANES][blocks LANES] of one element */
    double (*force)[3];       /* [nodes] internal, world */
    double (*torque)[3];      /* [nodes] internal, body */
    double (*push)[3];        /* [nodes] outside force, world */
    double (*turn)[3];        /* [nodes] outside moment, body */
    double (*pull_force)[3];  /* [nodes] the share of actuators in force */
    double (*pull_torque)[3]; /* [nodes] and in torque */
    motion_added *added;      /* [nodes], if any */
    double (*velocity)[3];    /* [points] V */
    double (*resistance)[3];  /* [points] per length, against V; part of the push */
};

/* The node at an end, 0 or 1. */
static inline size_t motion_end_node(const motion *m, int end)
{
    return end ? m->nodes - 1 : 0;
}

/* Where point k of an element is found: block and lane. */
static inline motion_block *motion_block_of(const motion *m, int element, int k)
{
    return &m->block[element * m->blocks + k / LANES];
}

/* Take a state, with what the ends prescribe at the time. */
void motion_set_nodes(motion *m, const double *state);

/* Put there what the ends prescribe at the time. */
void motion_hold_ends(motion *m);

/* Into r and v at an end, as far as it holds them. */
void motion_hold_part(const motion *m, int end, const double *position, const double *velocity,
                      double *r, double *v);

/* Energy that what acts along the rod and at places stores, of nodes that are set. */
double motion_along_energy(const motion *m);
double motion_places_energy(const motion *m);

/* The part of a Maxwell branch in the stress of a block. */
void motion_branch_stress(const motion *m, const motion_block *at, lanes stress[MOTION_STRAINS]);

/* From nodes that are set: strains, internal forces; loads; these and drag. */
void motion_internal_forces(motion *m);
void motion_loads(motion *m);
void motion_outside_forces(motion *m);

/* Point i of the quadrature: its node, and the section as the element has it; q: room. */
size_t motion_section_at(const motion *m, size_t i, double q[4], acting_on *at);

/* ---- what moves with the nodes (motion_added.c) --------------------------------------------- */

/* m->added, of nodes that are set; its kinetic energy. */
void motion_find_added(motion *m);
double motion_added_energy(const motion *m);

/* r_tt, world, and w_t, body, of node i, on which a wrench acts, force in the world and moment in
 * the body frame: 0 along what an end holds, whose acceleration the others feel. */
void motion_accelerate(const motion *m, size_t i, const double wrench[6], double acceleration[6]);

/* By what m->added of node i resists its acceleration. */
void motion_added_wrench(const motion *m, size_t i, const double acceleration[6], double wrench[6]);

/* m->resistance, of the velocities as they are. */
void motion_find_resistance(motion *m);

/* ---- what acts at single places (motion_jumps.c) ------------------------------------------- */

/* Needs the edges; each place has to be one. */
ad_status motion_place_jumps(motion *m, ad_error *error);

/* Mass and inertia of bodies; those of the elements are in m->mass and m->inertia. At joints, the
 * frames. */
void motion_add_bodies(motion *m);

/* The rotation before place k, of nodes that are set. */
void motion_rotation_before(const motion *m, int k, double q[4]);

/* The node of place k in the frame of its joint, from rotation and spin before the joint. */
void motion_turn_node(const motion *m, int k, const double rotation[4], const double spin[3],
                      double *state);

/* The frames of joints in an initial state. */
ad_status motion_turn_initial(const motion *m, double *state, ad_error *error);

/* Poses or flows [degree + 1] of an element's nodes, in its frames; room: for them, where these are
 * not all the nodes'. */
const double (*motion_rows_of(const motion *m, int element, double (*nodes)[LANES],
                              double (*room)[LANES]))[LANES];

/* From the frame of the node of point k to that of the element, a unit quaternion; NULL: the same.
 */
const double *motion_frame_of(const motion *m, int element, int k);

/* From nodes that are set: what acts at places of these kinds (acting.h), added to force and
 * torque.
 */
void motion_act_at_places(motion *m, int kinds, double (*force)[3], double (*torque)[3]);

/* The force of what acts at place k, world, of nodes that are set. */
void motion_place_force(const motion *m, int k, double force[3]);

/* What actuators put in, of nodes whose internal forces are known. */
double motion_pull_power(const motion *m);

#endif
