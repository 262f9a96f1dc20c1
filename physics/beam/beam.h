/* Beams of small deflection: Euler and Bernoulli's, and Timoshenko's, which also shears.
 *
 *        w                                          a piece of it, ds long:
 *        ^       ^ ^ ^ ^ ^ q        ^ F
 *        |       | | | | |          |                     +------^ V + V_s ds
 *    ////|==========================O ) T               M (|      |) M + M_s ds
 *    ////+----------------------------> s               V v------+
 *
 *   w    deflection along d2          q, F   force, distributed and on an end
 *   psi  rotation of the section      mu, T  moment, distributed and on an end, from s towards w
 *
 * Internal shear V and moment M are what the part beyond s does to the part before it, so that
 * V = F, M = T at s = L and V = -F, M = -T at s = 0. (Many textbooks count V the other way.)
 *
 *   Timoshenko   rhoA w_tt = V_s + q - k w - c w_t           V = kGA (w_s - psi)
 *                rhoI psi_tt = M_s + V + mu                  M = EI psi_s
 *   Euler-Bernoulli: kGA infinite, rhoI = 0, so that psi = w_s, V = -(M_s + mu) and
 *                rhoA w_tt + (EI w_ss)_ss + mu_s + k w + c w_t = q
 *
 * EI, kGA, rhoA, rhoI, k and c may vary with s; the strong form then has the derivatives of EI as
 * well, and its ends take w_sss from shear, moment and the slope of EI.
 * (Timoshenko, Young, Weaver 1974, Vibration Problems in Engineering, 4th ed., ch. 5; Hetenyi 1946,
 * Beams on Elastic Foundation.) Ends: clamped w = psi = 0, pinned w = M = 0, free V = M = 0, loaded
 * V and M given.
 *
 *   mixed         unknowns w, psi, V, M, first order in s
 *                   strain      w_s - psi - V / kGA
 *                   curvature   psi_s - M / EI
 *                   force, moment: the balances above
 *   displacement  the strong form: w alone, fourth order in s; Timoshenko: w and psi, second order
 *
 * One copy of each equation serves both theories and both forms: what is absent is a constant 0.
 * The problem is linear, so w is counted in a deflection W that its loads could cause, psi by W/L,
 * V by EI W/L^3, M by EI W/L^2, s by L and t by the scene's time (rod_scales_of, whose EI and rhoA
 * are one number each).
 *
 * Errors are sticky on the tape. Scenes must pass scene_check and be beams. */
#ifndef PHYSICS_BEAM_BEAM_H
#define PHYSICS_BEAM_BEAM_H

#include "physics/rod/rod.h"

/* W in m: the largest of initial deflection, initial velocity times time, and what each of the
 * loads at its largest would do to a cantilever that bends; the length when nothing is given. */
double beam_deflection_scale(const scene *scene);

/* Dimensionless numbers that decide how hard a scene is. */
typedef struct beam_numbers {
    double deflection;     /* W/L; small if the theory is to hold */
    double shear_ratio;    /* kGA L^2/EI; infinite: does not shear */
    double rotary_inertia; /* rhoI/(rhoA L^2) */
    double foundation;     /* k L^4/EI, largest over s */
} beam_numbers;

beam_numbers beam_numbers_of(const scene *scene);

/* mixed 4: w, psi, V, M; displacement 1: w, timoshenko 2: w, psi. */
int beam_network_outputs(const scene *scene);

/* One row each. */
typedef struct beam_state {
    ad_value deflection, slope, shear, moment; /* w, psi, V, M */
} beam_state;

/* From the raw outputs of the network of the place's window to a state: field = lift + blend
 * network, the lift being the initial state and its velocity where that is hard and the blend then
 * having (t/duration)^2. Where ends are hard, the blend vanishes at those that give the field, or
 * with its slope, and what conditions are left open is corrected: the polynomial of lowest degree
 * in s is added with which every one holds exactly, moment and shear of the displacement form
 * included (a Hermite-Birkhoff interpolant; Lorentz, Jetter, Riemenschneider 1983, Birkhoff
 * Interpolation). Later windows of time begin as those of rods do. In the displacement form psi, V
 * and M follow from w. */
beam_state beam_ansatz(const scene *scene, const domain_place *at, ad_value outputs);

/* Rows of a residual, one each: as in rod.h, with 2 rows for an end that is soft, the deflection or
 * shear and the slope or moment, and for a soft initial state w and w_t, with rotary inertia also
 * psi and psi_t. Dimensionless. */
int beam_residual_rows(const scene *scene, rod_residual_kind kind);
ad_value beam_residual(const scene *scene, rod_residual_kind kind, beam_state state,
                       const domain_place *at);

/* w (m), psi (rad), V (N), M (N m), w_t (m/s), psi_t (rad/s), one row each. */
enum { BEAM_COLUMNS = 6 };
void beam_observe(const scene *scene, beam_state state, const domain_place *at,
                  ad_value values[BEAM_COLUMNS]);

/* The state in motion, as rod_moving_state: w and w_t, with rotary inertia also psi and psi_t. */
enum { BEAM_GOING_DEGREE = 6 }; /* of the polynomials in which it goes on; see rod_ansatz.c */
int beam_state_rows(const scene *scene); /* 2 or 4, 0 at rest */
void beam_moving_state(const scene *scene, const domain_place *at, beam_state state,
                       ad_value *rows);

/* As rod_check: an initial state that the ends would shift is refused. */
ad_status beam_check(const scene *scene, const char **key, ad_error *error);

/* As rod_terms. */
int beam_terms(const scene *scene, rod_term *terms);

#endif
