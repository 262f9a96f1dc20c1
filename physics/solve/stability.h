/* Is a static equilibrium stable, or only a place where the forces balance? */
#ifndef PHYSICS_SOLVE_STABILITY_H
#define PHYSICS_SOLVE_STABILITY_H

#include "physics/scene/scene.h"
#include "physics/scene/verdict.h"

enum { STABILITY_POINTS = 512 };

/* Where the shape has to be known: s [STABILITY_POINTS], m, the middles of elements whose edges
 * hold every place where the scene jumps. AD_NO_MEMORY. */
ad_status stability_points(const scene *rod_scene, double *s, ad_error *error);

/* The number of independent ways in which the shape of a static scene gives way, of which values
 * [columns][STABILITY_POINTS] are the columns of the scene's model (physics/learn/model.h), in SI;
 * 0: it is stable, -1: not asked, as the scene moves or its loads have no energy: followers and, in
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
 * and the count is that beyond one negative direction for each nu. Laws outside of the rod add
 * minus the derivative of their force by x, or of their moment by eta; ends hold like springs that
 * are very stiff. The angle theta of a tube has variations phi of its own, which with those of u =
 * a are the second variation of the tube's energy (physics/rod/rod.h). By signs of pivots
 * (Sylvester). AD_NO_MEMORY, and what the tape says of formulas. */
ad_status stability_count(const scene *rod_scene, const double *values, int *count,
                          ad_error *error);

/* Why there is no margin of a rod, or of a family, at rest: its loads have no energy, and so on, in
 * words that follow "stability: "; NULL: there is one. */
const char *stability_without_margin(const scene *rod_scene);

enum { STABILITY_TEXT = 200 };

/* What is known of an equilibrium: the second variation, or where there is none the linearised
 * motion about it, of strain modes (physics/chain/modes.h), whose vibrations are e^(lambda t). */
typedef struct stability {
    int modes;        /* as stability_count; >= 0: the next four are not asked for */
    bool aside;       /* lost by what leaves the plane that the scene keeps the rod in */
    double share;     /* the largest real part of a lambda over its size: 1 where the rod gives way
                       * at once (divergence), in flutter as much damping as would end it; below
                       * what rounding leaves of 0, or < 0 with damping: nothing grows */
    double growth;    /* that real part, 1/s */
    double frequency; /* the imaginary one, rad/s; 0: divergence */
    bool damped;      /* the scene has a damping or a drag, which counts */
    bool massless;    /* a mass of 1 kg/m stands for that which the scene does not give */
    char unknown[STABILITY_TEXT]; /* "": known; else why not */
} stability;

/* Of a scene at rest and values as for stability_count. What leaves the plane of a planar scene
 * counts, too, unless `motion` says planar. Of other scenes, and of manufactured ones, nothing is
 * asked: modes is -1, share not a number, `unknown` empty. AD_NO_MEMORY, what the tape
 * says of formulas. */
ad_status stability_find(const scene *rod_scene, const double *values, stability *result,
                         ad_error *error);
bool stability_is_lost(const stability *stability);
bool stability_flutters(const stability *stability); /* where it is lost: by a vibration */

/* Adds to a verdict that it is lost, with an advice, or the remark that it is not known. */
void stability_judge(const stability *stability, const char *advice, verdict *result);

/* The part of stability_find that is not the second variation: fills in the rest of `result`. */
ad_status stability_of_motion(const scene *rod_scene, const double *values, stability *result,
                              ad_error *error);

/* stability_count on the way to the loads, where tubes are not yet what they are at rest, and where
 * sections have but a share of their stiffness against bending and twist `left`. */
ad_status stability_count_with(const scene *rod_scene, double load_factor, double left,
                               const double *values, int *count, ad_error *error);

#endif
