/* The strain form of a rod at rest: what is sought is the curvature u alone, a polynomial in each
 * element, given by its values at Gauss points (modes of Legendre by another name: with as many
 * points as modes collocation is Galerkin's method). All else follows from it, in turn:
 *
 *   R' = R u^              Magnus' expansion of order 6 from one point to the next
 *   N' = -f                from the end s = 1 back
 *   v  = v* + Kse^-1 (R^T N - sum tau_i t_i(v, u))
 *   r' = R v
 *   M' = -r' x N - l       from the end back
 *
 * and the equation is   u = u* + Kbt^-1 (R^T M - sum tau_i r_i x t_i(v, u))   at each point. It has
 * no derivative in s, and the clamp and a loaded end are met exactly. Forces that the shape does
 * not give by itself are unknowns, too: at an end that is held, of laws that depend on the place,
 * tensions of tendons whose length is given, and angles by which those with friction have turned,
 * as these say how strongly they pull; the torsion of concentric tubes; and where s = 0 does not
 * hold the pose, that is.
 *
 * Magnus: Blanes, Casas, Oteo, Ros, Physics Reports 470 (2009), eq. 253, whose Y' = A Y is R^T here
 * with A = -u^: commutators change their sign.
 *
 * LANES rods side by side, of one mesh and one kind. Dimensionless, signs and frames as in
 * rod_model.h; forces and moments in the world. */
#ifndef PHYSICS_CHAIN_STRAIN_FORM_H
#define PHYSICS_CHAIN_STRAIN_FORM_H

#include "autodiff/memory.h"
#include "physics/law/law.h"
#include "physics/local/acting_lanes.h"
#include "physics/local/static_rod.h"
#include "physics/numerics/quaternion_lanes.h"

#include <stddef.h>

enum { STRAIN_SUBSTEPS_MAX = 4 };

/* What is given at one point of the mesh. */
typedef struct strain_point {
    lanes rest[ACTUATION_ROWS];       /* v*, u* */
    lanes compliance[ACTUATION_ROWS]; /* 0: locked */
} strain_point;

/* An actuator at one point, as the laws are given it: a solve_actuator, whose pull is 0
 * where it is not. */
enum { ACTUATOR_OFFSET = 0, ACTUATOR_SLOPE = 2, ACTUATOR_PULL = 4, ACTUATOR_NUMBERS };
typedef struct strain_actuator {
    lanes given[ACTUATOR_NUMBERS];
} strain_actuator;

/* A tendon whose tension is sought. It is as long as it may be, int |p'| ds = allowed + compliance
 * pull, or shorter, and slack, without a pull. */
typedef struct strain_tension {
    int actuator;
    lanes pull, allowed, compliance;
    bool is_taut[LANES]; /* as strain_form_say_taut said */
    double *share;       /* [nodes] of the integral over its part of the rod; 0 beyond */
    lanes (*along)[6];   /* [nodes] derivatives of |p'| by v, u there; 0 beyond */
    lanes *bent;         /* [unknowns] what it does, by the elimination that was last */
} strain_tension;

/* A tendon with friction, whose angles are sought (strain_friction.h); 0 where it is not. */
typedef struct strain_rub {
    int actuator;
    lanes friction;
    lanes *pull;       /* [nodes] without friction, */
    lanes *left;       /* [nodes] and the share of it that is left */
    lanes *angle;      /* [nodes] sought, */
    lanes *measured;   /* [nodes] and what the shape makes of it */
    lanes (*along)[6]; /* [nodes] derivatives of |p'| by v, u; of which the first are the */
    lanes (*bend)[LAW_STIFFNESS]; /* tangent in the body, and their derivatives */
    lanes (*tangent)[3];          /* [nodes] world */
    lanes (*across)[3];           /* [nodes] the direction in which it turns */
} strain_rub;

/* Numbers of the law of a tube: K, k, 1/G. */
enum { TUBE_REST = 2, TUBE_SOFTNESS = 5 };

/* A concentric tube, whose torsion is sought (strain_tubes.h); 0 where it is not. */
typedef struct strain_tube {
    double end;
    lanes turned, yielding;           /* theta at s = 0, and by how much torsion there turns it */
    lanes base, base_measured;        /* torsion there, sought and what the shape makes of it; */
    lanes *torsion, *measured;        /* [nodes] the same there */
    lanes *theta;                     /* [nodes] as its end has it beyond that */
    lanes (*numbers)[LAW_TUBE_GIVEN]; /* [nodes] of the law */
    lanes (*turn)[3];                 /* [nodes] cos theta, sin theta, m */
    lanes (*gradient)[LAW_WRENCH];    /* [nodes] of its energy, */
    lanes (*second)[LAW_STIFFNESS];   /* [nodes] and second derivatives */
} strain_tube;

/* What acts at an edge, and the rod there, before it. */
typedef struct strain_edge {
    bool turns;     /* a joint */
    double turn[4]; /* of it */
    lanes q[4], R[3][3], r[3], N[3], M[3];
    lanes force[3], moment[3];         /* that act, laws among them */
    lanes by_turn[2][3][3];            /* their change by a turn of the section */
    lanes back[2][3][3], beyond[2][3]; /* of elimination (strain_sweep.c): P, p of N, M */
} strain_edge;

/* What laws that depend on the place make of it: a force, which is an unknown of its own, a moment,
 * and what both change by. */
typedef struct strain_push {
    lanes force[3], moment[3], by_position[2][3][3], by_turn[2][3][3];
} strain_push;

/* A place where laws act, at an edge. */
typedef struct strain_place {
    int edge, unknown; /* first of the force; -1: none that depends on the place */
    const acting *acting;
    lanes *numbers;
    lanes force[3]; /* sought */
    strain_push push;
} strain_place;

/* The rod at a point, and how what is there changes. */
typedef struct strain_node {
    lanes u[3], v[3], q[4], R[3][3], r[3], slope[3], N[3], M[3];
    lanes push[3]; /* force per length of laws along the rod, sought */
    /* By a turn phi, world, dN and the change of u: r' by P, Q, S, the rate of M by G, H, K; the
     * equation by Y, Z, L, and by dM by -T. */
    lanes P[3][3], Q[3][3], S[3][3], G[3][3], H[3][3], K[3][3];
    lanes Y[3][3], Z[3][3], L[3][3], T[3][3];
    /* Force and moment per length, world, of laws along the rod before positions are known
     * (acting_lanes_of), and their change by a turn. */
    lanes load[2][3], load_by_turn[2][3][3];
} strain_node;

/* What numbers that are given change by themselves, all that is sought as it is: at a point r',
 * world, the equation, force and moment per length, and the force that laws make of the place; */
typedef struct strain_source {
    lanes slope[3], row[3], load[2][3], push[3];
} strain_source;

/* and all together. */
typedef struct strain_sources {
    strain_source *points; /* [nodes] */
    lanes (*edges)[2][3];  /* [elements + 1] force and moment there */
    lanes (*places)[3];    /* [place_count] as push */
    lanes start[2][3],
        end[2][3];              /* position and turn of the beginning, and of what holds the end */
    lanes *lengths;             /* [tension_count] by how much tendons are shorter */
    lanes (*tangents)[3];       /* [rub_count][nodes] of those with friction, body */
    lanes (*tubes)[LAW_WRENCH]; /* [tubes][nodes] of the gradient of a tube's energy */
    lanes *bases;               /* [tubes] theta at s = 0 */
    lanes (*steps)[3][3][3];    /* of each step of Magnus (step_change) */
} strain_sources;

/* What rods of one form have in common. */
typedef struct strain_kind {
    int stages, elements, actuators, tubes;
    const double *edges;         /* [elements + 1] */
    const solve_extent *extents; /* [actuators], of actuators, and [tubes] */
    const scene_law *law;        /* of the section; NULL: linear */
    double length, force;        /* its units, as of rod_scales */
    bool shears;                 /* a compliance of v is not 0 */
    const acting *along;         /* laws along it; NULL: none */
    bool seeks_tensions;      /* of tendons whose length is given, which have none then, and angles
                               * of those with friction */
    bool is_rigid;            /* of given strain: a form for positions alone, without equations */
    const solve_jumps *jumps; /* what acts at edges; NULL: nothing */
    int substeps;  /* of Magnus from one point to the next, at most STRAIN_SUBSTEPS_MAX */
    solve_end end; /* s = 1 */
} strain_kind;

typedef struct strain_form {
    strain_kind kind;
    gauss_rule rule;
    int nodes, unknowns, elastic, holding; /* unknowns: 3 nodes, of ends that are held, and more; */
    int tension_at, tension_count;         /* last, tensions: beside the matrix */
    bool turns, follows; /* a load along the rod depends on its turn; a force does */
    bool is_full;        /* what acts at a place depends on more than the turn there: no sweep */
    double tail[GAUSS_STAGES_MAX][GAUSS_STAGES_MAX]; /* integral from a point to the end */
    /* terms of each step, of u */
    double magnus[(GAUSS_STAGES_MAX + 1) * STRAIN_SUBSTEPS_MAX][3][GAUSS_STAGES_MAX];
    double *width;              /* [elements] */
    strain_point *points;       /* [nodes] */
    strain_actuator *actuators; /* [nodes][actuators] */
    strain_node *at;            /* [nodes] */
    strain_edge *edges;         /* [elements + 1] */
    lanes *along;               /* [nodes][numbers of what acts along the rod] */
    bool is_pushed;             /* one of it depends on the position */
    bool is_unloaded;           /* nothing acts but actuators: N and M stay 0, and each point is
                                 * by itself */
    strain_push *pushes;        /* [nodes] */
    lanes *numbers;             /* [kind.jumps->numbers] of what acts at places */
    strain_place *places;       /* [place_count] */
    int place_count;
    strain_tension *tensions; /* [tension_count] */
    lanes *tension_room;      /* theirs; */
    double *tension_shares;   /* theirs; */
    lanes *shorter;        /* [tension_count]^2 by how much each becomes shorter with each pull */
    double *taut;          /* [LANES][tension_count]^2 LU factors of that of those that are taut, */
    int *taut_pivots;      /* [LANES][tension_count]; the first < 0: there are none */
    lanes *border;         /* [2][unknowns] room */
    lanes (*pulled)[2][3]; /* [nodes] by a change of what pulls or is given: r', the equation */
    strain_rub *rubs;      /* [rub_count] */
    int rub_count;
    lanes *rub_room;                    /* theirs */
    strain_tube *tubes;                 /* [kind.tubes] */
    lanes *tube_room, *tube_turned;     /* theirs; [tubes][nodes] how they turn */
    lanes (*strained)[6], (*turned)[3]; /* [nodes] how points change, of a direction */
    double slope[GAUSS_STAGES_MAX][GAUSS_STAGES_MAX]; /* d/ds at points, times the width */
    lanes start_r[3], start_q[4];
    static_end last; /* what the end is held to, where that is not by lanes: */
    lanes held_r[3], held_q[4];
    lanes end_force[3], end_moment[3]; /* N and M at s = 1 beyond what acts there: sought, or 0 */
    /* First unknowns of three each; -1: there are none. */
    int force_at, moment_at, push_at;
    int angle_at;       /* of those of one node after the other, of each tendon */
    int tube_at;        /* of torsions, those at s = 0 and of one node after the other */
    lanes by_end[3][3]; /* change of M at s = 1 by a turn */
    lanes held[3][3];   /* of the conditions of turns at s = 1 by a turn */
    lanes *matrix;    /* [elements][3 stages][3 stages] blocks, or [unknowns][unknowns]; columns */
    lanes *coupled;   /* [elements][3][3 stages] what a turn of its beginning does; or room */
    lanes *right;     /* [unknowns], the residual, then the step */
    lanes *direction; /* [unknowns], 0 */
    void *columns;    /* room for what it changes */
    long long still[LANES]; /* -1: v stays as it is, of rods that have arrived; 0 */
    int negative[LANES];    /* pivots of the last elimination, rows that were swapped counted in */
    int (*swapped)[LANES];  /* [unknowns] with which row each was swapped in it */
    ad_memory memory;
} strain_form;

/* AD_NO_MEMORY, AD_BAD_ARGUMENT: a law that depends on the velocity. Extents, laws and jumps must
 * outlive it. */
ad_status strain_form_create(const strain_kind *kind, strain_form **result, ad_error *error);
void strain_form_free(strain_form *form);

/* Joints and laws at edges, from s = 0 on: the latter with their unknowns. */
void strain_form_set_jumps(strain_form *form);

/* The i-th number that is sought. */
lanes *strain_form_unknown(strain_form *form, int i);

/* Everything that follows from u (at[].u), what is sought besides, and what is given: `right`
 * becomes the residual. v is warm: what it was before is where it is sought. */
void strain_form_shape(strain_form *form);

/* The same without the balance: no moments, and `right` stays. */
void strain_form_strain(strain_form *form);

/* What the law of the section is beyond its stiffness at a node: force and moment, and the upper
 * triangle of the second derivatives of its energy by v and u, or by v alone, of 6 or 3 rows. */
void strain_form_law(const strain_form *form, int node, int rows, lanes wrench[6],
                     lanes *stiffness);

/* Rotations and positions alone, for given u and v; and what laws make of these positions. */
void strain_form_place(strain_form *form);
void strain_form_push(strain_form *form);

/* Rotations, and angles of tendons with friction, become what the curvature makes of them. */
void strain_form_rub(strain_form *form);

/* Loads along the rod, by rotations as they are: after numbers of laws have changed. */
void strain_form_load(strain_form *form);

/* The derivatives there, and the matrix times a direction [unknowns] by them. */
void strain_form_linearise(strain_form *form);
void strain_form_apply(strain_form *form, const lanes *direction, lanes *result);

/* The same by a direction of torsions of one tube alone, without the rows of tensions. */
void strain_form_apply_torsion(strain_form *form, int tube, const lanes *direction, lanes *result);

/* The rows of tensions alone, by a direction without tensions. */
void strain_form_apply_lengths(strain_form *form, const lanes *direction, lanes *result);

/* The change of the residual by a direction and by sources, as strain_form_apply but with the turns
 * of Magnus' steps as they are, of one substep: the matrix leaves out what finite steps add. Then
 * strains [nodes] (v, u) are what these change by, and carried [nodes] what N and M do, or NULL. */
void strain_form_steps(strain_form *form, lanes (*steps)[3][3][3]);
void strain_form_change(strain_form *form, const strain_sources *sources, const lanes *direction,
                        lanes *result, lanes (*strains)[6], lanes (*carried)[6]);

/* right becomes the step to subtract, by elimination in all lanes: element by element where
 * curvatures alone are sought, else of the full matrix. A singular one gives numbers that are none.
 * Tensions are beside the matrix: the step is to those of the linear model of which no tendon with
 * tension is slack and none without is too long. */
void strain_form_solve(strain_form *form);

/* The same of another right side, by the elimination that was last; or of a change, in which of
 * tensions those move that are taut, with more than `least` when that was said, and no others. */
void strain_form_solve_again(strain_form *form);
void strain_form_say_taut(strain_form *form, double least);
void strain_form_solve_change(strain_form *form);

/* For strain_tensions.c: that of the matrix alone, without tensions; again: by the one before. */
void strain_form_eliminate(strain_form *form, bool again);

/* Subtracts `share` of a step. */
void strain_form_move(strain_form *form, const lanes *step, const lanes *share);

#endif
