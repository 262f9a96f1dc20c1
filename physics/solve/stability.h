/* Is a static equilibrium a minimum of the energy, or only a place where the forces balance? */
#ifndef PHYSICS_SOLVE_STABILITY_H
#define PHYSICS_SOLVE_STABILITY_H

#include "physics/scene.h"

#ifdef __cplusplus
extern "C" {
#endif

enum { STABILITY_POINTS = 512 };

/* Where the shape has to be known: s [STABILITY_POINTS], m, the middles of elements whose edges
 * hold every place where the scene jumps. AD_NO_MEMORY. */
ad_status stability_points(const scene *rod_scene, double *s, ad_error *error);

/* The number of independent ways in which the shape of a static scene gives way, of which values
 * [columns][STABILITY_POINTS] are the columns of the scene's model (physics/model.h), in SI; 0: it
 * is stable, -1: not asked, as the scene moves or its loads have no energy: followers and, in
 * space, moments; or a tendon has a length in place of a tension, or friction; or a section gives
 * way by itself. Counted among motions in the plane where the scene is planar.
 *
 * The second variation of the energy over rotations R exp(eta^), the strains at their best
 * (Antman, Nonlinear Problems of Elasticity, ch. 9; with a = eta_s + u x eta, C = Kse^-1),
 *
 *   2 E = int a.K a + m.(a x eta) - n.(eta x (eta x v)) - (eta x n).C (eta x n) ds,
 *
 * (where tendons pull, K and C with the second derivatives of their energy by strains, too,)
 * on piecewise linear eta. The displacement x is a field of its own, and nu, constant in each
 * element, the force that changes N for int R v to follow it:
 *
 *   2 E -> 2 E - int 2 R^T nu.(eta x v - C (eta x n)) + R^T nu.C R^T nu ds + 2 nu.(x2 - x1),
 *
 * and the count is that beyond one negative direction for each nu. Springs and the foundation, K,
 * add x.K x, one that turns minus the derivative of its moment; ends hold like springs that are
 * very stiff. The angle theta of a tube has variations phi of its own, which with those of u = a
 * are the second variation of the tube's energy (physics/rod.h). By signs of pivots (Sylvester).
 * AD_NO_MEMORY, and what the tape says of formulas. */
ad_status stability_count(const scene *rod_scene, const double *values, int *count,
                          ad_error *error);

/* The same on the way to the loads, where tubes are not yet what they are at rest. */
ad_status stability_count_at(const scene *rod_scene, double load_factor, const double *values,
                             int *count, ad_error *error);

#ifdef __cplusplus
}
#endif

#endif
