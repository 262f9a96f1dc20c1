/* The scene of a beam of small deflection in numbers, for classical solvers; equations and signs as
 * in physics/beam/beam.h.
 *
 * Dimensionless: s in [0, 1], t in units of scales.time, the deflection w by `deflection`, W;
 * slopes by W/L, V by EI W/L^3, M by EI W/L^2, distributed force by EI W/L^4, distributed moment by
 * EI W/L^3. Coefficients, formulas, ends and initial state are those that the residuals of networks
 * use, recorded once and evaluated at points. The equations of the beam are not. */
#ifndef PHYSICS_SOLVE_BEAM_MODEL_H
#define PHYSICS_SOLVE_BEAM_MODEL_H

#include "physics/learn/model.h"
#include "physics/local/quadrature.h"

enum { BEAM_JUMPS_MAX = SCENE_POINTS_MAX + SCENE_BODIES_MAX + SCENE_SPRINGS_MAX };

/* All that acts at one s, 0 and 1 among them, sums of physics/beam/beam_internal.h; not the loads.
 */
typedef struct beam_jump {
    double s;
    double stiffness, turning;
    double mass, inertia; /* 0 if static */
} beam_jump;

typedef struct solve_beam {
    rod_scales scales;
    double deflection; /* W, m */
    bool dynamic;
    double duration; /* in scales.time; 0 if static */
    bool turns;      /* has rotary inertia, and moves */
    struct {
        bool holds_deflection, holds_slope;
    } ends[2];
    int jump_count;
    beam_jump jumps[BEAM_JUMPS_MAX]; /* s ascending, each once */
    scene_breaks instants;           /* in motion, between which steps of time are equal */
    solve_quadrature *quadrature;    /* of solve_beam_given; in motion of nothing, for its places */
    struct beam_functions *formula;  /* opaque */
} solve_beam;

/* What the beam is made of, and lies on, at one s. Mass, inertia and drag are 0 if static. */
typedef struct beam_section {
    double bending_compliance; /* 1/EI, by that of the scales: 1 where it does not vary */
    double shear_compliance;   /* EI/(kGA L^2); 0: does not shear */
    double mass;               /* rhoA, by that of the scales: 1 where it does not vary */
    double rotary_inertia;     /* rhoI/(rhoA L^2) */
    double drag;               /* c */
    double foundation;         /* k */
} beam_section;

/* Distributed force q and moment mu. */
typedef struct beam_load {
    double force, moment;
} beam_load;

typedef struct beam_initial_state {
    double deflection, slope, velocity, slope_rate;
} beam_initial_state;

/* The scene must pass scene_check and beam_check. AD_NO_MEMORY, or errors of formulas. */
ad_status solve_beam_create(const scene *beam_scene, solve_beam **result, ad_error *error);
void solve_beam_free(solve_beam *beam);

/* All that a beam at rest is given along it. The beam must outlive it. */
solve_given solve_beam_given(const solve_beam *beam);

/* At n points s [n], in any order; out [n]. One thread at a time for one beam. */
ad_status solve_beam_load(const solve_beam *beam, size_t n, const double *s, double t,
                          beam_load *out, ad_error *error);
ad_status solve_beam_sections(const solve_beam *beam, size_t n, const double *s, beam_section *out,
                              ad_error *error);
ad_status solve_beam_initial(const solve_beam *beam, size_t n, const double *s,
                             beam_initial_state *out, ad_error *error);

/* Force and moment of the outside at each of the jumps, pulls of springs at w = 0 among them: out
 * [jump_count]. */
ad_status solve_beam_jump_loads(const solve_beam *beam, double t, beam_load *out, ad_error *error);

/* What the ends prescribe: w or V, then psi or M, at s = 0 and then at s = 1; internal V, M. */
ad_status solve_beam_ends(const solve_beam *beam, double t, double values[4], ad_error *error);

/* What one unit of w, psi, V, M, w_t and psi_t is in SI; units [6]. */
void solve_beam_units(const solve_beam *beam, double *units);

#endif
