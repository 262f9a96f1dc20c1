/* A scene in numbers, for classical solvers: one rod, its ends, its loads.
 *
 * Dimensionless by the scales of rod_scales_of: s in [0, 1], t in units of scales.time (a static
 * scene has t = 0), forces by EI/L^2, moments by EI/L; distributed ones by EI/L^3, EI/L^2. Frames
 * and signs are those of physics/rod/rod.h: r, N, f, l in the world, m, v, u, w in the body frame,
 * quaternions (w, x, y, z) body to world.
 *
 * Coefficients, formulas of the scene, ends and initial state are those that the residuals of
 * networks use (physics/rod/rod.h), recorded once and evaluated at points. The equations of the rod
 * are not: solvers write them in plain C, so that they check those that networks are trained on. */
#ifndef PHYSICS_LOCAL_ROD_MODEL_H
#define PHYSICS_LOCAL_ROD_MODEL_H

#include "autodiff/memory.h"
#include "physics/learn/model.h"
#include "physics/local/jump.h"
#include "physics/local/method.h"
#include "physics/local/quadrature.h"

/* What one end holds; what loads it acts there (physics/local/jump.h). */
typedef struct solve_end {
    scene_hold hold; /* of the position */
    bool holds_rotation;
    bool moves; /* false: the pose that it gives is the same at all times */
} solve_end;

/* Whether what it holds moves. */
static inline bool solve_end_is_driven(const solve_end *end)
{
    return end->moves && (end->hold.directions > 0 || end->holds_rotation);
}

/* The rod at one (s, t): the columns of its model, see physics/learn/model.h. */
typedef struct solve_state {
    double position[3];  /* r, world */
    double rotation[4];  /* q, unit */
    double strain[3];    /* v, body */
    double curvature[3]; /* u, body */
    double force[3];     /* n, body; with actuators */
    double moment[3];    /* m, body; the same */
    union {
        struct {
            double velocity[3]; /* r_t, world */
            double spin[3];     /* w, body */
        };
        double tubes[2 * SCENE_TUBES_MAX]; /* at rest: theta, m_i of each tube; 0 without */
    };
} solve_state;

/* The part of the rod, start .. end, in which an actuator pulls. */
typedef struct solve_extent {
    double start, end; /* within [0, 1] */
    law_name law;      /* of an actuator, or a tube */
    bool has_length;   /* a tendon whose tension is sought: its length is that in the unstressed rod
                        * less its displacement, */
    double compliance; /* more by this times its tension; 0: no more */
    bool rubs;         /* a tendon with friction, */
    double creep;      /* and the speed below which it creeps in motion */
} solve_extent;

enum { SOLVE_ACTUATORS_MAX = SCENE_ACTUATORS_MAX + SCENE_TUBES_MAX };

typedef struct solve_rod {
    scene scene;         /* its texts belong to whoever filled the scene; in space, */
    scene_motion motion; /* where it was given this */
    rod_scales scales;
    bool dynamic;
    double duration;   /* in scales.time */
    bool along_moves;  /* false: numbers of `along` are the same at all times */
    bool rest_moves;   /* false: the rest shape is the same at all times */
    acting along;      /* laws that act on it per length, gravity and loads among them */
    solve_end ends[2]; /* at s = 0 and 1 */
    int actuators;     /* those of the scene, then tubes */
    int tubes;         /* of them; at rest alone */
    int lengths;       /* of them, whose length is given */
    int frictions;     /* of them, with friction */
    solve_extent extents[SOLVE_ACTUATORS_MAX];
    solve_jumps jumps;               /* what acts at single places */
    solve_quadrature *quadrature;    /* at rest, of solve_rod_given; NULL in motion */
    struct solve_functions *formula; /* opaque */
} solve_rod;

/* What the rod is made of at one s. A locked strain has stiffness 0 and compliance 0. Damping,
 * mass and inertia are 0 if static. */
typedef struct solve_section {
    double stiffness[6];      /* Kse, Kbt */
    double compliance[6];     /* Kse^-1, Kbt^-1 */
    double damping[6];        /* Bse, Bbt */
    double maxwell_ratio;     /* of a Maxwell branch: its stiffness over Kse, Kbt; */
    double maxwell_rate;      /* and one over its time */
    double mass;              /* rhoA, by that of the scales: 1 where it does not vary */
    double rotary_inertia[3]; /* rhoJ */
    double added_mass;        /* of the fluid that moves with it across d3 */
} solve_section;

/* Unstressed strain v* and curvature u*, and their rates by t. The imperfection is added to u* on
 * the way to the loads. */
typedef struct solve_rest {
    double strain[3], curvature[3], imperfection[3];
    double strain_rate[3], curvature_rate[3];
} solve_rest;

/* An actuator in one section: where it is, and how strongly it pulls, as if it had no
 * ends (solve_extent). */
typedef union solve_actuator {
    struct {
        double offset[2];    /* r, along d1 and d2 */
        double slope[2];     /* r_s */
        double pull;         /* tension, or what pushes with a minus */
        double displacement; /* by which a tendon of given length is pulled out; 0 of others */
        double friction;     /* Coulomb's, of a tendon against its guides; 0 of others */
        double compliance;   /* of a tendon of given length that is elastic; 0 of others */
    };
    struct {                 /* of a tube */
        double bending[2];   /* K */
        double softness;     /* 1/G; 0: it does not twist */
        double curvature[3]; /* k by itself */
        double turned;       /* of its base: theta there, rad, */
        double yielding;     /* and by how much its torsion there turns it more */
    };
} solve_actuator;

/* What is prescribed at an end: the pose counts where it is held, force and moment where not. Their
 * signs are those of the internal N and m, so those of the outside at s = 1 and against it at s =
 * 0; the force is in the world, or that of a follower in the body, the moment likewise. Rates are
 * by t: r_t, w = 2 vec(q* q_t), r_tt, w_t. */
typedef struct solve_end_state {
    double position[3], rotation[4];
    double velocity[3], spin[3];
    double acceleration[3], spin_rate[3];
    double force[3], moment[3];
} solve_end_state;

typedef struct solve_initial {
    double position[3], rotation[4]; /* the rotation is unit */
    double velocity[3], spin[3];     /* r_t world, w body */
} solve_initial;

/* The scene must pass scene_check and rod_check. AD_NO_MEMORY, or what the tape says of a formula.
 */
ad_status solve_rod_create(const scene *rod_scene, solve_rod **result, ad_error *error);
void solve_rod_free(solve_rod *rod);

/* Of a rod whose formulas have open names beside s and t (quantities_coordinate): values
 * [count], for which the scene passes its checks, say what its scales are and what it has at all.
 * AD_BAD_INPUT: a name stands where a scene has one number for all. */
typedef struct solve_parameters {
    int count;
    const char *const *names;
    const double *values;
} solve_parameters;

ad_status solve_rod_create_open(const scene *open, const solve_parameters *parameters,
                                solve_rod **result, ad_error *error);

/* The same, whose parts are derivatives of those by each of `count` > 0 parameters, one after the
 * other: by_parameters of those that depend on one, of which the others are 0. At rest. */
ad_status solve_rod_create_changes(const scene *open, const solve_parameters *parameters,
                                   solve_rod **result, ad_error *error);

/* What such a rod is given, in parts: the structs are those below, of actuators as many as it has,
 * of jumps the numbers of all. */
typedef enum solve_part {
    SOLVE_SECTIONS,  /* solve_section */
    SOLVE_REST,      /* solve_rest */
    SOLVE_START,     /* solve_end_state at s = 0 */
    SOLVE_END,       /* and at s = 1 */
    SOLVE_INITIAL,   /* solve_initial, without parameters */
    SOLVE_ACTUATORS, /* solve_actuator */
    SOLVE_JUMPS,     /* numbers of what acts at places */
    SOLVE_ALONG,     /* numbers of what acts along it */
    SOLVE_FEED,   /* growth less 1 and its two rates by t where a rod is fed in time; else none */
    SOLVE_GROWTH, /* one number, of what is mapped (scene_map); else no formula, of width 0 */
    SOLVE_PARTS
} solve_part;

typedef struct solve_part_kind {
    size_t width; /* doubles; 0: the rod has none */
    bool by_s, by_t, by_parameters;
} solve_part_kind;

solve_part_kind solve_rod_part_kind(const solve_rod *rod, solve_part part);

/* out [n][width] at s [n] and t, with parameters [n][count]. Allocates only when n grows; one
 * thread at a time. */
ad_status solve_rod_part(const solve_rod *rod, solve_part part, size_t n, const double *s, double t,
                         const double *parameters, double *out, ad_error *error);

/* An end of a rod in motion with open names at t, whose parameters [count] have `rates`, first
 * [count] and then second derivatives by t: velocities and accelerations are along all of them.
 * NULL: they stay, as in solve_rod_part. */
ad_status solve_rod_end_moving(const solve_rod *rod, int end, double t, const double *parameters,
                               const double *rates, solve_end_state *out, ad_error *error);

/* What one unit of each double of a solve_state is in SI. */
void solve_rod_units(const solve_rod *rod, double *units);

/* At n points s [n], in any order; out [n]. They allocate only when n grows. One thread at a time
 * for one rod. */
ad_status solve_rod_sections(const solve_rod *rod, size_t n, const double *s, solve_section *out,
                             ad_error *error);
ad_status solve_rod_rest(const solve_rod *rod, size_t n, const double *s, double t, solve_rest *out,
                         ad_error *error);

/* Numbers of what acts along the rod, if anything does: out [n][along.numbers]. */
ad_status solve_rod_along(const solve_rod *rod, size_t n, const double *s, double t, double *out,
                          ad_error *error);

/* Of rods with actuators: out [n][actuators]. */
ad_status solve_rod_actuators(const solve_rod *rod, size_t n, const double *s, double t,
                              solve_actuator *out, ad_error *error);

/* What a rod at rest has at some points, at t = 0. From zeros; to be cleared also after errors. */
typedef struct solve_rod_points {
    solve_section *sections;
    solve_rest *rest;
    double *along;             /* [points][numbers of what acts along the rod] */
    solve_actuator *actuators; /* [points][those of the rod], at full load */
    ad_memory memory;
} solve_rod_points;

ad_status solve_rod_points_make(const solve_rod *rod, size_t n, const double *s,
                                solve_rod_points *points, ad_error *error);
void solve_rod_points_clear(solve_rod_points *points);

/* By how much actuator i, a tendon whose length is given, is pulled out; 0 of others. */
double solve_rod_displacement(const solve_rod *rod, int i, double t);

/* All that a rod at rest is given along it, at t = 0. The rod must outlive it. */
solve_given solve_rod_given(const solve_rod *rod);

/* What is given along the rod at some times, at most QUADRATURE_ROWS_MAX numbers; the rod must
 * outlive it. */
solve_given motion_given(const solve_rod *rod);

/* Where elements have to end, and what their quadrature is measured by. AD_NO_MEMORY, errors of
 * formulas; the result is freed by solve_quadrature_free. */
ad_status motion_places_of(const solve_rod *rod, solve_quadrature **places, ad_error *error);

/* Numbers of what acts at single places, if anything does: out [jumps.numbers]. */
ad_status solve_rod_jump_numbers(const solve_rod *rod, double t, double *out, ad_error *error);

/* end: 0 or 1. */
ad_status solve_rod_end(const solve_rod *rod, int end, double t, solve_end_state *out,
                        ad_error *error);

/* The solution that the author of a manufactured scene chose: all of solve_end_state, anywhere. */
ad_status solve_rod_manufactured(const solve_rod *rod, size_t n, const double *s, double t,
                                 solve_end_state *out, ad_error *error);

/* The state at t = 0; in a static scene, and where the scene does not give it, the unstressed shape
 * that the held end implies, at rest. */
ad_status solve_rod_initial(const solve_rod *rod, size_t n, const double *s, solve_initial *out,
                            ad_error *error);

#endif
