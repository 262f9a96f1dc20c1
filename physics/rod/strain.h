/* A rod at rest in the strain form on a tape: from its curvature at Gauss points to its shape, the
 * forces in it and the residual of the equation that the curvature obeys. Equations, mesh and
 * discretisation are those of physics/chain/strain_form.h:
 *
 *   R' = R u^,  N' = -f,  v = v* + Kse^-1 (R^T N - actuation),  r' = R v,  M' = -r' x N - l
 *   residual = u - u* - Kbt^-1 (R^T M - actuation)
 *
 * so that its residual at a curvature found by that solver is rounding. Numbers of the scene may be
 * formulas of open names, which are any values of the tape: parameters of a family, unknowns.
 *
 * Everything on the tape is dimensionless, as in physics/rod/rod.h, by the scales of the scene with
 * numbers in place of the names: curvature times length, places and positions over it.
 *
 *   strain_mesh_of(&open, 8, &mesh, &error);
 *   strain_rod_create(&settings, tape, s, parameters, &rod, &error);
 *   ad_value state = strain_rod_state(rod, network);
 *   ad_value residual = strain_rod_residual(rod, network, state);
 *
 * Errors while recording are sticky on the tape. */
#ifndef PHYSICS_ROD_STRAIN_H
#define PHYSICS_ROD_STRAIN_H

#include "physics/scene/scene.h"

enum { STRAIN_ELEMENTS_MAX = 100, STRAIN_STAGES_MIN = 3, STRAIN_STAGES_MAX = 12 };

/* Gauss points in each of the elements between edges, ascending from 0 to 1, of the length. */
typedef struct strain_mesh {
    int stages, elements;
    double edges[STRAIN_ELEMENTS_MAX + 1]; /* [elements + 1] */
} strain_mesh;

/* Elements between the places where something jumps, or between which it is narrow; of members of
 * which this is not at the same places, equal ones that are as short. AD_BAD_ARGUMENT: too many of
 * them. */
ad_status strain_mesh_of(const scene *open, int stages, strain_mesh *mesh, ad_error *error);

/* The one that has its points at s [nodes], of the length, as solve_members_places says over it: in
 * equal parts of these elements. AD_BAD_ARGUMENT: there is none. */
ad_status strain_mesh_at(const scene *open, int nodes, const double *s, strain_mesh *mesh,
                         ad_error *error);

/* Places [strain_mesh_nodes] of the points, of the length. */
int strain_mesh_nodes(const strain_mesh *mesh);
void strain_mesh_places(const strain_mesh *mesh, double *s);

/* Of the integral from 0 to a point, or to an edge, of what has values at the points: their weights
 * [strain_mesh_nodes], of the length. */
void strain_mesh_integral(const strain_mesh *mesh, bool to_edge, int i, double *weights);

/* By how much the two highest of Legendre's modes of a curvature, the first three numbers of
 * [nodes][width], of its values times `scale`, turn the rod, rad: what the mesh hardly resolves,
 * and STRAIN_RESOLVED. weights: of values at the points of an element, to the coefficients of these
 * modes. */
enum { STRAIN_MODES = 2 };
#define STRAIN_RESOLVED 1e-9
void strain_mesh_modes(const strain_mesh *mesh, double weights[STRAIN_MODES][STRAIN_STAGES_MAX]);
double strain_mesh_unresolved(const strain_mesh *mesh, double scale, int width,
                              const double *curvature);

/* AD_OK, or AD_BAD_ARGUMENT with what of the scene the strain form does not know, on a tape or for
 * solve_members. */
ad_status strain_check(const scene *one, bool on_tape, ad_error *error);

/* The same for solve_members and of its mesh, too: whether a family with such members can be one in
 * the strain form. Errors of either. */
ad_status strain_takes(const scene *one, ad_error *error);

typedef struct strain_settings {
    const scene *open;        /* which passes its checks with the numbers below; copied */
    int count;                /* of open names */
    const char *const *names; /* [count] */
    const double *values;     /* [count] */
    strain_mesh mesh;
    const ad_value *load; /* factor of all that loads and pulls, one row; NULL: 1 */
} strain_settings;

typedef struct strain_rod strain_rod;

/* s: an input of the tape of one row, at which formulas are recorded and which is in none of what
 * follows; parameters [count] of one row each. Formulas and names must outlive the rod. As
 * strain_check; AD_NO_MEMORY. */
ad_status strain_rod_create(const strain_settings *settings, ad_value s, const ad_value *parameters,
                            strain_rod **result, ad_error *error);
void strain_rod_free(strain_rod *rod); /* NULL is allowed; what was recorded stays */

/* Numbers that are sought before the curvature: forces of laws outside of the rod that depend on
 * the position (physics/law/law.h), per length [3][nodes] and [3] at each place, and angles [nodes]
 * by which each tendon with friction has turned; 0 without such. Their rows of the residual are
 * what is sought less what the shape makes of it. */
int strain_forces(const scene *open, int nodes);

/* Numbers that are sought between these and the curvature: of concentric tubes the torsion of each
 * at s = 0, then of each at all points, over the scale of moments; 0 beyond its end. Their rows are
 * what is sought less what the shape makes of it. */
int strain_twisting(const scene *open, int nodes);

/* Tendons with friction. */
int strain_angles(const scene *open);

/* Numbers that are sought after the curvature: N [3], world, of an end s = 1 whose position is held
 * in any direction, and M [3], world, of one whose rotation is, beyond what acts there, and last
 * strain_tensions; 0 without such. Their rows of the residual are how far the end is from there,
 * and N in directions that are free; of a tension by how much the tendon is shorter than it may be,
 * which is 0 or it is slack, and the tension 0. `sought` is [forces + twisting + 3 nodes + held],
 * below called curvature where it is that alone. */
int strain_held(const scene *open);

/* Tendons whose length is given, in their order: their tensions, which are not negative. */
int strain_tensions(const scene *open);

/* How far these tendons are from the axis, over the length: arms [strain_tensions] by which a
 * tension bends the rod, at least 1e-3. */
void strain_arms(const scene *one, double *arms);

/* Whether more is sought than the curvature, or a law asks for the position: then no
 * strain_rod_blocks. */
bool strain_is_placed(const scene *open);

/* All that follows from what is sought, as one vector: rotations, forces, strains and moments, with
 * laws that depend on them positions, at points and at the ends of elements. The others record from
 * both. The vector may be an input of as many rows, which several programs share. */
ad_value strain_rod_state(const strain_rod *rod, ad_value sought);

/* Inputs that move, each along its direction: of parameters, the curvature. */
typedef struct strain_changes {
    int count; /* up to 2 */
    const ad_value *wrt, *along;
} strain_changes;

/* How the state changes, which is here an input; of the strain by what it obeys at the state. */
ad_value strain_rod_state_change(const strain_rod *rod, ad_value curvature, ad_value state,
                                 const strain_changes *changes);

/* [forces + twisting + 3 nodes + held] */
ad_value strain_rod_residual(const strain_rod *rod, ad_value sought, ad_value state);

/* [3][nodes + 1]: positions at the points and at the end. */
ad_value strain_rod_positions(const strain_rod *rod, ad_value sought, ad_value state);

/* u* [3][nodes] */
ad_value strain_rod_rest(const strain_rod *rod);

/* At places: components of one row for each of them; the columns of cpinn-eval. */
typedef struct strain_shape {
    ad_value position[3]; /* r, world */
    ad_value rotation[4]; /* q, unit, body to world */
    ad_value force[3];    /* n, body; of rod and actuators together, as in physics/rod/rod.h */
    ad_value moment[3];   /* m, body */
    ad_value strain[3];   /* v */
    ad_value curvature[3];
    ad_value twist[2 * SCENE_TUBES_MAX]; /* theta and torsion of each concentric tube */
} strain_shape;

/* At places s [places], ascending, of the length: Magnus' steps of rotation and position together
 * from one to the next, of at most a sixteenth of the length. */
strain_shape strain_rod_shape(const strain_rod *rod, ad_value curvature, ad_value state, int places,
                              const double *s);

/* The same in SI units: columns which [count] of cpinn-eval, of 0 r, 3 q, 7 v, 10 u, 13 n, 16 m, 19
 * theta and torsion of each tube; [count][places]. */
enum { STRAIN_COLUMNS = 19, STRAIN_COLUMNS_MAX = STRAIN_COLUMNS + 2 * SCENE_TUBES_MAX };
int strain_columns(const scene *open);
ad_value strain_rod_columns(const strain_rod *rod, ad_value curvature, ad_value state, int places,
                            const double *s, int count, const int *which);

/* What a change du of the curvature changes, as physics/chain/strain_matrix.c has it, which leaves
 * out what Magnus' steps of finite length add. At a point, with turn = the integral of R du from
 * s = 0, and the changes of N and M as integrals from s = 1 of `load` and `rate` and of what acts
 * at edges. Those from LOAD on matter where forces follow the rod. */
enum {
    STRAIN_ROTATION,      /* R */
    STRAIN_SLOPE_BY_TURN, /* of r' */
    STRAIN_SLOPE_BY_CURVATURE,
    STRAIN_RATE_BY_TURN, /* of -M' */
    STRAIN_RATE_BY_CURVATURE,
    STRAIN_MISSING_BY_TURN, /* of the residual */
    STRAIN_MISSING_BY_CURVATURE,
    STRAIN_MISSING_BY_MOMENT,
    STRAIN_LOAD_BY_TURN, /* of -N' */
    STRAIN_SLOPE_BY_FORCE,
    STRAIN_RATE_BY_FORCE,
    STRAIN_MISSING_BY_FORCE,
    STRAIN_BLOCKS
};

typedef struct strain_blocks {
    ad_value residual; /* [3][nodes], as strain_rod_residual */
    bool follows;      /* a change of the curvature changes N */
    ad_value blocks;   /* [STRAIN_BLOCKS, or LOAD_BY_TURN without `follows`][3][3][nodes] */
    ad_value edges; /* [elements][2][3][3]: of force and moment at an element's end, by its turn */
} strain_blocks;

/* Without laws that depend on the position. */
strain_blocks strain_rod_blocks(const strain_rod *rod, ad_value curvature, ad_value state);

#endif
