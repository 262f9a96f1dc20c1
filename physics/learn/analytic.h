/* Closed-form shapes of statically loaded rods, to check trained networks against.
 *
 * All rods are uniform, straight when unloaded, inextensible and unshearable, clamped at s = 0 and
 * loaded at s = L only. SI (or any consistent) units in and out. r and the internal force in the
 * world frame, the internal moment in the body frame; quaternions (w, x, y, z), unit, body to
 * world; d3 is the tangent. */
#ifndef PHYSICS_LEARN_ANALYTIC_H
#define PHYSICS_LEARN_ANALYTIC_H

#include "autodiff/error.h"

/* Position and orientation of the clamped end. */
typedef struct analytic_clamp {
    double position[3];
    double quaternion[4]; /* unit to 1e-12 */
} analytic_clamp;

/* State of the rod at one s. */
typedef struct analytic_state {
    double position[3];
    double quaternion[4];
    double force[3];  /* internal force, world frame */
    double moment[3]; /* internal moment, body frame */
} analytic_state;

/* ---- Elastica: dead transverse force F at the tip ----
 *
 * theta, the angle from the clamped tangent towards F, obeys EI theta'' + F cos theta = 0,
 * theta(0) = theta'(L) = 0 (Bisshopp and Drucker 1945). With alpha = F L^2/EI, w = sqrt(alpha)
 * (1 - s/L) and psi = pi/2 - theta the angle between tangent and force,
 *
 *     tan(psi/2) = (k'/k) nc(w, k),     k' = k cn(sqrt(alpha), k)  fixes the modulus k,
 *     kappa L = 2 sqrt(alpha) k k' sd(w, k),     x = (kappa(0) - kappa(s)) EI/F,
 *
 * Jacobi's functions as in DLMF 22.2; y is the integral of sin theta, by Gauss quadrature of that
 * analytic function (its closed form by E(w) loses digits when alpha is small). Relative error of
 * theta, x, y and kappa at any s: below 1e-14 for alpha <= 10, below 3e-14 for alpha <= 1e4. */
typedef struct analytic_elastica {
    analytic_clamp clamp;
    double length;            /* L, m */
    double bending_stiffness; /* EI, N m^2 */
    double force[3];          /* world, N; perpendicular to the clamped tangent */
    double axis[3];           /* unit, world: d3(0) x F/|F|; the rod rotates about it */
    double body_axis[3];      /* the same in the body frame, where it stays */
    double alpha;             /* F L^2/EI >= 0 */
    double modulus;           /* k */
    double complement;        /* k' = sqrt(1 - k^2) */
} analytic_elastica;

/* The planar shape at one s: angle (rad), coordinates along the clamped tangent and along the force
 * (m), curvature (1/m). */
typedef struct analytic_planar {
    double angle, along, across, curvature;
} analytic_planar;

/* Solve for the modulus and store everything in *elastica (plain data, nothing to free).
 * AD_BAD_ARGUMENT: length or stiffness not positive, alpha above 1e4, quaternion not unit, force
 * not perpendicular to the clamped tangent (1e-12 |F|). A zero force gives the straight rod. */
ad_status analytic_elastica_create(const analytic_clamp *clamp, double length,
                                   double bending_stiffness, const double force[3],
                                   analytic_elastica *elastica, ad_error *error);

/* Shape at 0 <= s <= L (s is clipped to that). */
analytic_planar analytic_elastica_shape(const analytic_elastica *elastica, double s);

/* The same as a state in space. */
void analytic_elastica_at(const analytic_elastica *elastica, double s, analytic_state *state);

/* ---- Helix: dead couple M (world frame) at the tip of an isotropic rod ----
 *
 * With B = EI, C = GJ and m3 = M . d3(0),
 *
 *     q(s) = exp(M s/(2B)) (x) q(0) (x) exp(m3 s (1/C - 1/B) e3 / 2),
 *
 * so the tangent turns about M at the rate w = |M|/B, and with a = M/|M|, d = d3(0), phi = w s
 *
 *     r(s) = r(0) + s [ (a.d) a + (sin phi/phi) (d - (a.d) a) + ((1 - cos phi)/phi) a x d ].
 *
 * The internal force is zero, the internal moment is M throughout (in the body frame, R^T M).
 * AD_BAD_ARGUMENT: a stiffness not positive, s or M not finite, quaternion not unit. */
ad_status analytic_helix_at(const analytic_clamp *clamp, double bending_stiffness,
                            double torsional_stiffness, const double couple[3], double s,
                            analytic_state *state, ad_error *error);

/* ---- Roll-up: the helix whose couple is perpendicular to the clamped tangent ----
 *
 * A circular arc of radius EI/|M|, however many turns; no twist, so no torsional stiffness.
 * AD_BAD_ARGUMENT as above, and M not perpendicular to d3(0) (1e-12 |M|). */
ad_status analytic_rollup_at(const analytic_clamp *clamp, double bending_stiffness,
                             const double couple[3], double s, analytic_state *state,
                             ad_error *error);

#endif
