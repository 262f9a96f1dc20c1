/* A family of rods at rest by its curvature, the strain form: a network of the parameters alone
 * says the curvature at N places along the rod, from which rotations and positions follow exactly.
 *
 *   L u(p) = T(p) (affine(x(p)) + modes (scale * network(x(p))))
 *
 * x are the inputs that groups.h finds, T turns the member of a set of equal shapes to this one.
 * Modes are the principal components of what some solved members have beyond their best affine
 * function of x, in the metric of distances. The coefficients c of a change of curvature are scaled
 * so that |c|^2 is the mean square distance by which the rod moves, over L^2. It is a mean over the
 * rod and an average of members. Where there are concentric tubes u has the torsion of each, too,
 * over the stiffness of the rod: Newton's method starts from both.
 *
 * Learnt from targets, curvatures that a source (physics/learn/model.h) gives for each member:
 *
 *   loss = mean over members of  (|c - c_target|^2 + e^2)^(1/2) - e
 *
 * a distance far from the target, so that members next to a fold, where curvature jumps, do not
 * count by their squares; a square near it. For networks without hidden layers |c - c_target|^2. */
#ifndef PHYSICS_LEARN_FAMILY_H
#define PHYSICS_LEARN_FAMILY_H

#include "physics/learn/groups.h"
#include "physics/learn/model.h"

#ifdef __cplusplus
extern "C" {
#endif

enum { FAMILY_MODES_MAX = 24 };

typedef struct family family;

/* Of a scene with parameters, which outlives it, with curvature at places [nodes] (m, ascending)
 * along it. Modes are 0 until family_fit, or until a checkpoint has filled its arrays.
 * AD_NO_MEMORY, errors of groups_find. */
ad_status family_create(const scene *open, const groups_settings *settings, size_t nodes,
                        const double *places, family **result, ad_error *error);
void family_free(family *f); /* NULL is allowed */

/* From some members: coordinates x [parameters][members], dimensionless as the model has them, and
 * their curvature [members][nodes][width], 1/m, of solve_members. AD_NO_MEMORY; AD_BAD_INPUT: fewer
 * members than inputs.
 */
ad_status family_fit(family *f, ad_pool *pool, size_t members, const double *x,
                     const double *curvature, ad_error *error);

/* What was fitted, to be kept in a checkpoint and filled in place. */
typedef struct family_array {
    const char *name;
    double *data;
    size_t rows, columns;
} family_array;

enum { FAMILY_ARRAYS = 4 };
void family_arrays(family *f, family_array arrays[FAMILY_ARRAYS]);

size_t family_nodes(const family *f);
int family_width(const family *f); /* numbers at a node: curvature, and the torsion of each tube */
int family_modes(const family *f); /* outputs of the network */
const groups *family_groups(const family *f);

/* Distance over the length, root mean square over rod and members: of what modes are made of, and
 * of what all of them miss. NaN before family_fit. */
double family_spread(const family *f);
double family_missed(const family *f);

/* Parameters [members][parameters] in SI units at coordinates x [parameters][members]. */
void family_parameters(const family *f, size_t members, const double *x, double *parameters);

/* Fields of a member: coefficients of the modes, then the curvature times the length in the order
 * [width][nodes], which is that of the data of the term "members" too. */
enum { FAMILY_COEFFICIENTS, FAMILY_CURVATURE, FAMILY_FIELDS };

/* Its model: one coordinate for each parameter, from 0 to 1 over its range by its scale; one set of
 * points with that term, whose source [width nodes rows] is the caller's. squares: the loss for
 * networks without hidden layers. The family outlives it. AD_NO_MEMORY. */
ad_status family_model(const family *f, const model_source *source, bool squares,
                       physics_model **result, ad_error *error);

/* ---- answers ------------------------------------------------------------------------------- */

/* A trained network's curvature; for one thread at a time, on all of those of the pool, which has
 * to outlive it, as has the network while it is made. */
typedef struct family_network family_network;

ad_status family_network_create(const family *f, const nn_mlp *mlp, ad_pool *pool,
                                family_network **result, ad_error *error);
void family_network_free(family_network *network); /* NULL is allowed */

/* curvature [members][nodes][width], 1/m, for parameters [members][parameters] in SI units, by the
 * weights of the network. Allocates only where there are more members than ever before. */
ad_status family_network_run(family_network *network, const double *weights, size_t members,
                             const double *parameters, double *curvature, ad_error *error);

#ifdef __cplusplus
}
#endif

#endif
