/* What the files of the beam share; not for others. Everything dimensionless. */
#ifndef PHYSICS_BEAM_BEAM_INTERNAL_H
#define PHYSICS_BEAM_BEAM_INTERNAL_H

#include "physics/beam/beam.h"

/* Units in SI of what a scene gives and of what is observed. */
typedef struct beam_units {
    double length, time;
    double deflection, slope, force, moment;
} beam_units;

/* A scene at work on a tape, at a place. */
typedef struct beam_context {
    const scene *scene;
    ad_tape *tape;
    beam_units unit;
    double rotary_inertia;     /* rhoI/(rhoA L^2); 0: none, and then psi has no initial state */
    ad_value bending;          /* EI(s) over the EI of the units; 1 where it does not vary */
    ad_value softness;         /* one over that */
    ad_value shear_compliance; /* EI/(kGA(s) L^2); 0: does not shear */
    ad_value mass, inertia;    /* rhoA(s) over its mean, rhoI(s)/(rhoA L^2) */
    bool dynamic, mixed;
    domain domain;
    domain_place at;
    ad_value s, t;
} beam_context;

/* The state at t = 0, or where a window begins; psi only with rotary inertia. */
typedef struct beam_initial {
    ad_value deflection, velocity, slope, slope_rate;
} beam_initial;

/* What is prescribed at one end: the deflection or else the shear, the slope or else the moment. */
typedef struct beam_end {
    bool holds_deflection, holds_slope;
    ad_value deflection, slope, shear, moment;
} beam_end;

/* beam_points.c. What acts at single places, lists of scene.h in their order; `s` is dimensionless.
 * With F, T what the outside does to the beam there, V(s+) = V(s-) - F and M(s+) = M(s-) - T. Of
 * rigid bodies and springs those parts that a deflection along d2 and a turn about d1 move: a body
 * F = -mass w_tt, T = -inertia psi_tt, in motion; a spring F = -stiffness (w - anchor), T =
 * -turning psi. */
typedef struct beam_point_data {
    double s;
    ad_value force, moment;
} beam_point_data;

typedef struct beam_body_data {
    double s, mass, inertia; /* 0 if static */
} beam_body_data;

typedef struct beam_spring_data {
    double s, stiffness, turning, anchor;
} beam_spring_data;

beam_point_data beam_point_of(const beam_context *beam, int i, ad_value t);
beam_body_data beam_body_of(const beam_context *beam, int i);
beam_spring_data beam_spring_of(const beam_context *beam, int i);

/* F and T of all of these for fields w, psi of s and t; ends of the beam count as places. */
typedef struct beam_force_at {
    double s;
    ad_value force, moment;
} beam_force_at;

enum { BEAM_PLACES_MAX = SCENE_POINTS_MAX + SCENE_BODIES_MAX + SCENE_SPRINGS_MAX };

/* acting [BEAM_PLACES_MAX]; returns how many. */
int beam_forces_at(const beam_context *beam, ad_value w, ad_value psi, beam_force_at *acting);
/* A function of s at a place, 0 and 1 the ends. */
ad_value beam_there(const beam_context *beam, ad_value y, double s);

/* beam.c */
bool beam_turns(const scene *scene); /* whether sections have rotary inertia */
beam_context beam_context_of(const scene *scene, const domain_place *at);
/* 0 of what is not given */
ad_value beam_formula(const beam_context *beam, quantity q, double unit, ad_value s, ad_value t);
ad_value beam_line_moment(const beam_context *beam); /* mu */
ad_value beam_foundation(const beam_context *beam);  /* k */
ad_value beam_drag(const beam_context *beam);        /* c; nothing without time */
ad_value beam_space_derivative(const beam_context *beam, ad_value y, int order);
/* (EI w_ss) differentiated `order` times by s, from derivatives of w of one order each */
ad_value beam_bent(const beam_context *beam, ad_value w, int order);
ad_value beam_time_derivative(const beam_context *beam, ad_value y, int order);
beam_end beam_end_of(const beam_context *beam, int end);
beam_initial beam_initial_of(const beam_context *beam);

#endif
