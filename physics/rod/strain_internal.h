/* What the files of the strain form on the tape share; not for others. A field along the rod is its
 * components, each of one row for each point of the mesh, or of one row where all points have the
 * same. */
#ifndef PHYSICS_ROD_STRAIN_INTERNAL_H
#define PHYSICS_ROD_STRAIN_INTERNAL_H

#include "physics/law/law.h"
#include "physics/numerics/gauss.h"
#include "physics/rod/rod_internal.h"
#include "physics/rod/strain.h"

enum { STRAIN_NODES_MAX = STRAIN_ELEMENTS_MAX * STRAIN_STAGES_MAX, STRAIN_STEPS_MAX = 512 };

typedef struct along {
    ad_value x[3];
} along;

typedef struct along_turn {
    ad_value x[4]; /* a unit quaternion */
} along_turn;

typedef struct along_matrix {
    ad_value x[3][3];
} along_matrix;

typedef struct along_twist {
    along turn, shift; /* of the rotation and of the position, body */
} along_twist;

/* An actuator along the rod, whose pull is 0 where it is not. */
typedef struct strain_pull {
    ad_value offset[2], slope[2], pull, displacement;
    int first, count; /* of the points where it is */
    law_name law;
    bool is_sought; /* the tension of one whose length is given, */
    ad_value compliance;
    bool rubs; /* a tendon with friction: angles by which it has turned are sought */
    ad_value friction;
} strain_pull;

/* A concentric tube, with the numbers of its law at the points of its elements. */
typedef struct strain_torsion {
    int elements;
    ad_value turned, yielding; /* theta at s = 0, and by how much torsion there turns it */
    ad_value numbers[LAW_TUBE_GIVEN];
} strain_torsion;

/* A law that acts from outside, with its numbers at points or at its place. */
typedef struct strain_law {
    law_name law;
    double s; /* of a place */
    ad_value numbers[LAW_NUMBERS_MAX];
} strain_law;

struct strain_rod {
    scene one, open;
    ad_tape *tape;
    domain_place at;
    rod_context rod;
    strain_mesh mesh;
    gauss_rule rule;
    int nodes;
    double s[STRAIN_NODES_MAX];
    bool shears;
    along rest_strain, rest_curvature, strain_compliance, curvature_compliance;
    int actuators;
    strain_pull pulls[SCENE_ACTUATORS_MAX];
    int tubes, twisting; /* what is sought of tubes */
    strain_torsion torsions[SCENE_TUBES_MAX];
    int along_count, place_count; /* of laws along the rod and at places */
    bool turns, is_pushed; /* one along it depends on the rotation; its force on the position */
    bool is_placed; /* one along it or at a place depends on the position, or the end is held */
    strain_law along[ROD_ALONG_MAX], places[ROD_AT_PLACES_MAX + ROD_AT_ENDS_MAX];
    int forces, held; /* that are sought, before and after the curvature, tensions among them */
    bool holds_position, holds_rotation; /* at s = 1 */
    rod_end_data start, end;
};

/* strain.c. Rows of a value recorded at s, each of one row for each point, or one for all. */
void strain_spread(const strain_rod *rod, ad_value value, ad_value *rows);

/* strain_along.c */
along strain_add(along a, along b);
along strain_sub(along a, along b);
along strain_mul(along a, along b); /* component by component */
along strain_by(ad_value a, along b);
along strain_cross(along a, along b);
ad_value strain_dot(along a, along b);
along strain_to_world(const along_matrix *R, along a);
along strain_to_body(const along_matrix *R, along a);
along strain_zeros(ad_tape *tape);
along strain_rows(ad_value vector);         /* of 3 rows: one for each component */
ad_value strain_points(int nodes, along a); /* [3][nodes] */
along strain_of_points(int nodes, ad_value x);
along_turn strain_turn_product(along_turn p, along_turn q);
along_turn strain_turn_by(along rotation_vector);
along_matrix strain_turn_matrix(along_turn q);
along_turn strain_turn_rows(ad_value quaternion);

/* The twist of a step with terms a of Magnus' expansion (Blanes et al. 2009, eq. 253, whose Y' = A
 * Y is transposed here: commutators change their sign), and the position at its end by that. */
along_twist strain_magnus(const along_twist a[3]);
along strain_twist_shift(along_twist a);

/* [rows] sums of weights [rows][points] times what is at points, also if it is the same at all. */
ad_value strain_weigh(int rows, int points, const double *weights, ad_value x);

/* What is at an element's points; and of all elements one after the other what `parts` says, of
 * counts[e] rows each or of one that is the same for all. */
along strain_element(const strain_rod *rod, along a, int element);
along strain_join(int elements, const int *counts, const along *parts);

/* strain_record.c: all that follows from the curvature, at points and at edges before what acts
 * there, or the joint turns. */
typedef struct strain_state {
    along curvature, strain, slope, force, moment;
    along push, position; /* sought force per length of laws along the rod; where it is */
    along pushes[ROD_AT_PLACES_MAX], edge_position[STRAIN_ELEMENTS_MAX + 1];
    along held[2];                       /* N, M at s = 1, sought where the end is held, else 0 */
    ad_value tension[SCENE_TENDONS_MAX]; /* sought where the length is given */
    ad_value angle[SCENE_TENDONS_MAX];   /* [nodes] sought with friction */
    ad_value pull[SCENE_ACTUATORS_MAX];
    ad_value base[SCENE_TUBES_MAX], torsion[SCENE_TUBES_MAX]; /* [nodes], both sought */
    ad_value theta[SCENE_TUBES_MAX];                          /* [nodes] */
    ad_value tube[SCENE_TUBES_MAX][LAW_WRENCH]; /* gradients of their energies, within it */
    along_turn turn;
    along_matrix R;
    along load_rate[2]; /* f, l, world */
    along_turn edge_turn[STRAIN_ELEMENTS_MAX + 1];
    along edge_force[STRAIN_ELEMENTS_MAX + 1], edge_moment[STRAIN_ELEMENTS_MAX + 1];
} strain_state;

/* From what is sought and the vector that strain_rod_state made of it. */
void strain_state_of(const strain_rod *rod, ad_value sought, ad_value vector, strain_state *state);

/* q after a joint at an edge. */
along_turn strain_turn_over(const strain_rod *rod, int edge, along_turn q);

/* Parts of it: f, l at points, without moments that depend on the position; all of l; what acts at
 * an edge; the rate of M, negative. */
void strain_loads(const strain_rod *rod, along_turn turn, along load_rate[2]);
along strain_moment_load(const strain_rod *rod, const strain_state *state);
void strain_acting(const strain_rod *rod, int edge, along_turn turn, along *force, along *moment);
along strain_moment_rate(along slope, along force, along load);

/* strain_pull.c. A pull at the points where the actuator is, elsewhere 0; the length of a tendon
 * per length of the rod; and the angle by which it has turned, 0 beyond its part of the rod. */
ad_value strain_pull_within(const strain_rod *rod, const strain_pull *of, ad_value pull);
ad_value strain_pull_length(const strain_rod *rod, const strain_pull *of, along strain,
                            along curvature);
ad_value strain_pull_angle(const strain_rod *rod, const strain_pull *of, const strain_state *state);

/* Also there, with the pulls of a state: v* + C (n - what pulls at v, u), and whether that depends
 * on v; the v that obeys it, from some v on; v after one step of Newton's method, with the matrix
 * of v and of another u; (1 + C T_vv)^-1 times a; the residual. */
along strain_balance(const strain_rod *rod, const ad_value *pull, along n, along u, along v);
bool strain_is_implicit(const strain_rod *rod);
along strain_yield(const strain_rod *rod, const ad_value *pull, along n, along u, along v);
along strain_yield_on(const strain_rod *rod, const ad_value *pull, along n, along u, along v,
                      along matrix_u);
along strain_softened(const strain_rod *rod, const ad_value *pull, along v, along u, along a);
along strain_missing(const strain_rod *rod, const ad_value *pull, const along_matrix *R,
                     along strain, along curvature, along moment);

/* strain_torsion.c. What is given of tubes; what is sought of them, from `first` on, and their laws
 * at the points, after the curvature; what they add to the moment of the rod; and the rows of what
 * is sought, of which it returns how many. */
void strain_torsion_give(strain_rod *rod);
void strain_torsion_turn(const strain_rod *rod, ad_value sought, int first, strain_state *state);
along strain_torsion_moment(const strain_rod *rod, const strain_state *state);
int strain_torsion_missing(const strain_rod *rod, const strain_state *state, ad_value *rows);

#endif
