/* The scene as its author wrote it: one rod, what holds it, what loads it, in SI units.
 *
 * Arc length s in [0, length] of the undeformed rod (m), time t in [0, duration] (s). Vectors are
 * in the world frame unless a field says body. Quaternions are scalar first (w, x, y, z), unit,
 * body to world; director d3 is the tangent of the undeformed rod.
 *
 * Every number is a quantity (physics/quantity/quantity.h): a number, or a formula of s and t in SI
 * units where the field says so. Scenes are copied by value; the names with which their formulas
 * were made belong to whoever fills the scene and must outlive it. */
#ifndef PHYSICS_SCENE_SCENE_H
#define PHYSICS_SCENE_SCENE_H

#include "physics/quantity/quantity.h"
#include "physics/scene/scene_law.h"

#include <math.h>
#include <stdint.h>

#ifdef __cplusplus
extern "C" {
#endif

/* Every enumeration is one list of rows (name in C, name in YAML); scene_*_names give the texts. */
#define SCENE_MODEL_LIST(X)                                                                        \
    X(SCENE_COSSERAT, "cosserat")               /* bends, twists, shears, stretches */             \
    X(SCENE_INEXTENSIBLE, "inextensible")       /* no stretch */                                   \
    X(SCENE_KIRCHHOFF, "kirchhoff")             /* no shear and no stretch */                      \
    X(SCENE_EULER_BERNOULLI, "euler_bernoulli") /* beam of small deflection: bends */              \
    X(SCENE_TIMOSHENKO, "timoshenko")           /* the same: bends and shears */
#define SCENE_SECTION_LIST(X)                                                                      \
    X(SCENE_SECTION_NONE, "none") /* stiffness and inertia are given instead */                    \
    X(SCENE_CIRCLE, "circle")                                                                      \
    X(SCENE_TUBE, "tube")                                                                          \
    X(SCENE_RECTANGLE, "rectangle")
#define SCENE_END_LIST(X)                                                                          \
    X(SCENE_CLAMPED, "clamped") /* position and rotation held */                                   \
    X(SCENE_PINNED, "pinned")   /* position held, no moment */                                     \
    X(SCENE_FREE, "free")       /* no force, no moment */                                          \
    X(SCENE_LOADED, "loaded")   /* the force and moment of loads.base or loads.tip */              \
    X(SCENE_DRIVEN, "driven")   /* position and rotation given functions of t */                   \
    X(SCENE_GUIDED, "guided")   /* rotation held, the position slides */                           \
    X(SCENE_ROLLER, "roller")   /* no moment, the position slides */
#define SCENE_FRAME_LIST(X)                                                                        \
    X(SCENE_DEAD, "dead")         /* fixed in the world frame */                                   \
    X(SCENE_FOLLOWER, "follower") /* fixed in the body frame */
#define SCENE_FORMULATION_LIST(X)                                                                  \
    X(SCENE_MIXED, "mixed")               /* unknowns r, q, N, m; first order in s */              \
    X(SCENE_DISPLACEMENT, "displacement") /* unknowns r, q; second order in s: the strong form */  \
    X(SCENE_STRAIN_FORM, "strain")        /* unknown u, of a family: physics/learn/family.h */     \
    X(SCENE_POSE_STRAIN, "pose_strain")   /* unknowns r, q, v, u; first order in s */
#define SCENE_ROTATION_LIST(X)                                                                     \
    X(SCENE_QUATERNION, "quaternion") /* 4 numbers, normalised: any number of turns */             \
    X(SCENE_VECTOR, "vector")         /* 3, a rotation vector: no length that is free */           \
    X(SCENE_SIX, "six")               /* 6, two columns of the matrix before they are orthonormal */
#define SCENE_ENFORCEMENT_LIST(X)                                                                  \
    X(SCENE_HARD, "hard") /* exact by construction */                                              \
    X(SCENE_SOFT, "soft") /* a weighted loss term */

#define SCENE_MOTION_LIST(X)                                                                       \
    X(SCENE_AUTOMATIC, "automatic") /* planar when the scene keeps the rod in a plane */           \
    X(SCENE_PLANAR, "planar")       /* planar, or an error */                                      \
    X(SCENE_SPATIAL, "spatial")     /* in space whatever the scene */

#define SCENE_STATE_LIST(X)                                                                        \
    X(SCENE_GIVEN, "given") /* as initial.* says; else at rest in the unstressed shape */          \
    X(SCENE_EQUILIBRIUM, "equilibrium") /* at rest under what acts at t = 0 */

#define SCENE_ENUM(name, text) name,
typedef enum scene_model { SCENE_MODEL_LIST(SCENE_ENUM) } scene_model;
typedef enum scene_section { SCENE_SECTION_LIST(SCENE_ENUM) } scene_section;
typedef enum scene_end_type { SCENE_END_LIST(SCENE_ENUM) } scene_end_type;
typedef enum scene_frame { SCENE_FRAME_LIST(SCENE_ENUM) } scene_frame;
typedef enum scene_formulation { SCENE_FORMULATION_LIST(SCENE_ENUM) } scene_formulation;
typedef enum scene_rotation { SCENE_ROTATION_LIST(SCENE_ENUM) } scene_rotation;
typedef enum scene_enforcement { SCENE_ENFORCEMENT_LIST(SCENE_ENUM) } scene_enforcement;
typedef enum scene_motion { SCENE_MOTION_LIST(SCENE_ENUM) } scene_motion;
typedef enum scene_state { SCENE_STATE_LIST(SCENE_ENUM) } scene_state;
#undef SCENE_ENUM

typedef struct scene_rod {
    scene_model model;
    quantity length;    /* m, > 0; a number */
    quantity inserted;  /* m, > 0, up to the length; not given: all of it. Only for scene_map. */
    quantity feed_time; /* s, > 0, a number; in motion, of an `inserted` that is a parameter. What
                         * has come out, I, follows this command u by feed_time^2 I_tt + 2 feed_time
                         * I_t + I = u, without overshoot */
    quantity growth;    /* m of the rod for each m of s, of s; not given: 1. Only of scene_map. */

    /* Sizes of the section; of s. */
    scene_section section;
    quantity radius;       /* m: circle, tube (outer) */
    quantity inner_radius; /* m: tube */
    quantity width;        /* m: rectangle, along d1 */
    quantity height;       /* m: rectangle, along d2 */

    /* Of s. */
    quantity youngs_modulus;   /* Pa */
    quantity poissons_ratio;   /* -1 < nu <= 0.5 */
    quantity density;          /* kg/m^3 */
    quantity shear_correction; /* kappa; not given: Cowper's for the section */

    /* Damping by the material, in place of strain_damping and curvature_damping; of s, one of the
     * two. A Kelvin-Voigt solid: the stress is E e + eta e_t in extension and, with the same ratio,
     * G g + eta/(2 (1 + nu)) g_t in shear. eta is three times the shear viscosity of a material
     * that does not change its volume. So with the integrals of the section
     *   Bse = eta (kappa A/(2 (1 + nu)), kappa A/(2 (1 + nu)), A)
     *   Bbt = eta (I1, I2, J/(2 (1 + nu)))
     * and by the relaxation time tau = eta/E, for stiffness that is given as well,
     *   Bse = tau Kse, Bbt = tau Kbt. */
    quantity viscosity;       /* eta; Pa s */
    quantity relaxation_time; /* tau; s */

    /* A Maxwell branch beside them, both or none, of s: a spring of `maxwell_ratio` times each
     * stiffness in series with a damper, which makes a standard linear solid (Zener). e is strain
     * beyond rest, z the damper's part of it, e at the start. n and m grow by ratio K (e - z), and
     * z_t = (e - z)/time. A strain that is held has 1 + ratio exp(-t/time) times its stress at
     * rest. */
    quantity maxwell_ratio, maxwell_time; /* a number; s */

    /* Given instead of section and material, or to override what follows from them; of s. Infinite
     * stiffness is allowed, as a number: that strain is then locked. */
    quantity shear_stiffness[2];   /* kappa G A along d1, d2; N */
    quantity axial_stiffness;      /* E A; N */
    quantity bending_stiffness[2]; /* E I about d1, d2; N m^2 */
    quantity torsional_stiffness;  /* G J; N m^2 */
    quantity mass_per_length;      /* rho A; kg/m */
    quantity rotary_inertia[3];    /* rho I about d1, d2, d3; kg m */

    quantity rest_strain[3];    /* v*, of s; default 0, 0, 1 */
    quantity rest_curvature[3]; /* u*, of s; 1/m; default 0 */
    quantity imperfection[3];   /* added to u* times 1 - load factor; as above */

    quantity strain_damping[3];    /* Bse, Kelvin-Voigt, of s; N s; not given: by the material */
    quantity curvature_damping[3]; /* Bbt, the same; N m^2 s */

    /* A nonlinear law of the whole rod, in which its stiffness at rest is the stiffness above:
     * scene_take_law. NULL: n = Kse (v - v*), m = Kbt (u - u*). Of whoever fills the scene. */
    const scene_law *law;
} scene_rod;

/* A concentrated load at one end; formulas of t. The force and moment that the outside exerts on
 * the rod. */
typedef struct scene_load {
    quantity force[3];  /* N */
    quantity moment[3]; /* N m */
    scene_frame frame;
} scene_load;

typedef struct scene_loads {
    quantity gravity[3]; /* m/s^2; default 0 */
    quantity buoyancy; /* mass of the fluid that the rod displaces, per length; of s; kg/m, >= 0 */
    quantity drag;     /* force per length against the velocity, f = -drag r_t; N s/m^2 */
    quantity quadratic_drag;  /* f = -quadratic_drag |r_t| r_t; of s; N s^2/m^3 */
    quantity fluid_along[3];  /* f = -(c_1 + c_2 |w|^(1/2) + c_3 |w|) w against the velocity w along
                                 d3; of s; N s/m^2, N s^1.5/m^2.5, N s^2/m^3; >= 0 */
    quantity fluid_across[3]; /* the same for the velocity across d3 */
    quantity added_mass;      /* of the fluid that moves with the rod across d3; of s; kg/m, >= 0 */
    /* A magnetised rod in the field B = magnetic_field + G r, without curl and divergence: the
     * energy per length is -(R m) . B, the moment R m x B, the force G R m. */
    quantity magnetic_moment[3];   /* m per length, along d1, d2, d3; of s; A m */
    quantity magnetic_field[3];    /* at the origin of the world; of t; T */
    quantity magnetic_gradient[5]; /* G as xx, yy, xy, xz, yz, with zz = -xx - yy; of t; T/m */
    quantity force[3];             /* distributed, formulas of s, t; N/m */
    quantity moment[3];            /* distributed, formulas of s, t; N m/m */
    quantity foundation[3]; /* f = -foundation (r - r0), along the world's axes, with r0 where the
                               unstressed rod is; of s; N/m^2, >= 0 */
    scene_frame frame;      /* of the distributed force and moment */
    scene_load base;        /* at s = 0 */
    scene_load tip;         /* at s = length */
} scene_loads;

/* ---- lists ----
 * What a rod may have several of. `at`, `start` and `end` are places along the whole rod, in m, and
 * numbers; formulas of s count from its beginning, too. */
enum {
    SCENE_SEGMENTS_MAX = 12,
    SCENE_POINTS_MAX = 16,
    SCENE_BODIES_MAX = 16,
    SCENE_SPRINGS_MAX = 16,
    SCENE_TENDONS_MAX = 16,
    SCENE_CHAMBERS_MAX = 12,
    SCENE_ACTUATORS_MAX = SCENE_TENDONS_MAX + SCENE_CHAMBERS_MAX,
    SCENE_TUBES_MAX = 4
};

/* A piece of the rod. What its `rod` does not give is that of the whole rod, where its section has
 * such a size; model and length there are not looked at. `turn`: how it is set against the end of
 * the piece before, a rotation vector in the axes of that end, so that an elbow is two segments;
 * the first has none. */
typedef struct scene_segment {
    quantity length; /* m, > 0 */
    scene_rod rod;
    quantity turn[3]; /* rad; default 0 */
} scene_segment;

/* A force and a moment at one place within the rod: N and M fall by them there; formulas of t. */
typedef struct scene_point {
    quantity at;
    scene_load load;
} scene_point;

/* A rigid body that is fixed to the section at `at`, an end or a place within. It weighs and, in
 * motion, has inertia. */
typedef struct scene_body {
    quantity at;
    quantity mass;               /* kg, >= 0 */
    quantity offset[3];          /* of its centre of mass, along d1, d2, d3; m; default 0 */
    quantity inertia[3];         /* about d1, d2, d3 through it; kg m^2, >= 0; default 0 */
    quantity magnetic_moment[3]; /* along d1, d2, d3, in the field of loads; A m^2; default 0 */
} scene_body;

/* A linear spring between the section at `at` and the world, of the energy 1/2 stiffness (r - r0)^2
 * + 1/2 turning phi^2. phi is the rotation vector from q0 to q in the directors' components, of
 * less than a whole turn. The force is -stiffness (r - r0). Where the rod turns about one director,
 * or all turnings are equal, the moment is -turning phi. r0: `anchor` where it is given, else, as
 * q0, where the unstressed rod is. */
typedef struct scene_spring {
    quantity at;
    quantity stiffness[3]; /* along the world's axes; N/m, >= 0; default 0 */
    quantity turning[3];   /* about the directors; N m/rad, >= 0; default 0 */
    quantity anchor[3];    /* m */
} scene_spring;

/* A tendon that is guided by the rod at the body position (offset[0], offset[1], 0), formulas of s,
 * from `start` on and fixed to it at `end` (default: the ends of the rod). tension: formula of t,
 * >= 0, at its beginning. friction: against the guides, of Coulomb, so that the tension falls as
 * exp(-friction times the angle that the tendon has turned); default 0. creep_speed: in motion,
 * below which it creeps. In place of the tension its displacement may be given: by how much it is
 * pulled out of the rod against its unstressed length; formula of t, m. Its stiffness is the
 * tension that lengthens it by 1 m; default: it keeps its length. */
typedef struct scene_tendon {
    quantity offset[2]; /* m */
    quantity start, end;
    quantity tension;      /* N */
    quantity displacement; /* m */
    quantity stiffness;    /* N/m, > 0 */
    quantity friction;
    quantity creep_speed; /* m/s, > 0 */
} scene_tendon;

/* A fluid chamber along the rod with its axis at (offset[0], offset[1], 0), formulas of s:
 * pressure, a formula of t, on `area`, a formula of s, pushes its ends apart. */
typedef struct scene_chamber {
    quantity offset[2]; /* m */
    quantity start, end;
    quantity pressure; /* Pa */
    quantity area;     /* m^2, > 0 */
} scene_chamber;

/* A tube around the rod, which is the innermost of a concentric tube robot and reaches its tip. It
 * begins where the rod does, with its director d1 turned by `turned` about d3 from that of the rod.
 * It ends freely at `end` and shares the rod's axis without friction. The two bend together and
 * twist each by itself, see physics/rod/rod.h. `rod`: of the section its radius and inner_radius,
 * E, nu and density, stiffness of bending and torsion, mass, and the curvature at rest, in the
 * frame of the tube. They are functions of s, the place along the rod. A tube that is turned from
 * behind, through a straight part of length `transmission`, twists there, too. */
typedef struct scene_tube {
    quantity end; /* m */
    scene_rod rod;
    quantity turned;       /* rad; default 0 */
    quantity transmission; /* m, >= 0; default 0 */
} scene_tube;

typedef struct scene_end {
    scene_end_type type;
    quantity position[3]; /* m; numbers, for a driven end formulas of t */
    quantity rotation[4]; /* quaternion, normalised when read; numbers, or formulas of t */
    quantity turn_time;   /* s, > 0, of the start in motion: how fast a drive follows the parameter
                           * by which the rotation is turned about d3 */
    /* Of the end s = length, in place of rotation: the rotation vector by which it is turned from
     * where the unstressed rod ends, in the world's axes, so that turns count; rad. */
    quantity rotation_vector[3];
    /* Of the same end: the angle by which it is turned on about its own d3, beyond what its
     * rotation or rotation vector says, so that turns count; rad. It grows with the loads, after
     * the bend. */
    quantity twist;
    /* How the position of a guided or roller end slides, one of the two: along a direction, or
     * across one; in the world, of any length, numbers. A guided end with neither slides freely. */
    quantity along[3], across[3];
} scene_end;

/* The state at t = 0; formulas of s. Nothing given: at rest in the undeformed shape that the
 * clamped end implies. */
typedef struct scene_initial {
    quantity position[3];         /* m */
    quantity rotation[4];         /* quaternion */
    quantity velocity[3];         /* m/s, world frame */
    quantity angular_velocity[3]; /* 1/s, body frame */

    /* Position and rotation may be those of the equilibrium under what acts at t = 0, so that
     * "where(t, 0, 2)" as a load lets go of a rod that 2 has bent. Whoever fills the scene calls
     * solve_settle (physics/solve/solve.h), which computes `settled`, formulas of s: position (m)
     * and rotation; of a beam deflection (m) and slope. */
    scene_state state;
    quantity settled[7];
} scene_initial;

/* A solution chosen by the author; loads, ends and initial state that make it exact are derived on
 * the tape. rotation: quaternion, or three angles (rad) of rotations about body axes 1, 2, 3 in
 * turn: q = q1(a) q2(b) q3(c). Nothing given: none. */
typedef struct scene_manufactured {
    quantity position[3]; /* m */
    quantity rotation[4];
    quantity angles[3];
} scene_manufactured;

/* What the outside does to a loaded end of a beam; formulas of t. */
typedef struct scene_beam_load {
    quantity force;  /* N */
    quantity moment; /* N m */
} scene_beam_load;

/* A load at one place within a beam. */
typedef struct scene_beam_point {
    quantity at; /* m, within the beam: V and M fall by the load there */
    scene_beam_load load;
} scene_beam_point;

/* A beam of small deflection: everything along its one deflection w and its one slope, signs as in
 * physics/beam/beam.h. What is not given is zero, and the slope the derivative of the deflection.
 */
typedef struct scene_beam {
    quantity force;       /* q, distributed; of s, t; N/m */
    quantity moment;      /* mu, distributed; of s, t; N m/m */
    quantity foundation;  /* k, force per length and deflection; of s; N/m^2 */
    scene_beam_load base; /* at s = 0 */
    scene_beam_load tip;  /* at s = length */
    int point_count;
    scene_beam_point points[SCENE_POINTS_MAX];
    quantity deflection; /* the state at t = 0, of s; m */
    quantity velocity;   /* m/s */
    quantity slope;      /* rad; of a timoshenko beam, whose slope has inertia */
    quantity slope_rate; /* rad/s */
} scene_beam;

enum { SCENE_WINDOWS_MAX = 1024 }; /* DOMAIN_WINDOWS_MAX */

enum { SCENE_PARAMETERS_MAX = QUANTITY_OPEN_MAX - 2 }; /* beside s and t */

#define SCENE_SCALE_LIST(X)                                                                        \
    X(SCENE_LINEAR, "linear") /* as it is */                                                       \
    X(SCENE_LOG, "log")       /* members and networks go by its logarithm */
#define SCENE_ENUM(name, text) name,
typedef enum scene_scale { SCENE_SCALE_LIST(SCENE_ENUM) } scene_scale;
#undef SCENE_ENUM

/* A number that differs from member to member of a family of scenes: an open name of its formulas
 * (quantities_coordinate). */
typedef struct scene_parameter {
    const char *name;
    double low, high; /* its range; finite, low < high, both > 0 of scale log */
    scene_scale scale;
} scene_parameter;

/* A rod that moves through its port, made by scene_map: s from 0 to `to` is what is out of it up to
 * the first place that anything is at, and grows and shrinks. */
enum { SCENE_FED_IN_TIME = -1 };
typedef struct scene_feed {
    double to; /* m; 0: it does not */
    int by;    /* the parameter that it follows, or SCENE_FED_IN_TIME */
} scene_feed;

/* How the state of an input with a memory goes on: physics/scene/scene_memory.h. */
typedef struct scene_memory {
    bool lags;      /* lag; else a play, whose */
    quantity next;  /* state is this formula of the one before */
    quantity input; /* of a lag, and its */
    quantity time;  /* s */
} scene_memory;

typedef struct scene {
    quantity place; /* where s is on the rod as it was written, m, of s; not given: at s */
    scene_feed feed;
    scene_rod rod; /* of segments its length may be left out: then it is their sum */
    scene_loads loads;
    int segment_count, point_count, body_count, spring_count, tendon_count, chamber_count,
        tube_count;
    scene_segment segments[SCENE_SEGMENTS_MAX]; /* in turn; none: one piece */
    quantities *names; /* where the formulas are made that join segments; NULL: none of these */
    scene_point points[SCENE_POINTS_MAX];
    scene_body bodies[SCENE_BODIES_MAX];
    scene_spring springs[SCENE_SPRINGS_MAX];
    scene_tendon tendons[SCENE_TENDONS_MAX];
    scene_chamber chambers[SCENE_CHAMBERS_MAX];
    scene_tube tubes[SCENE_TUBES_MAX];
    scene_beam
        beam; /* beams only; they have drag alone of the loads, and types alone of the ends */
    scene_end start;   /* s = 0 */
    scene_end end;     /* s = length */
    quantity duration; /* s, a number; not given or 0: static */
    int windows;       /* of time: equal parts of the duration, each with a network of its own */
    scene_initial initial;
    scene_manufactured manufactured;
    int parameter_count; /* of a family, and unknowns; 0: one scene of numbers */
    scene_parameter parameters[SCENE_PARAMETERS_MAX];
    int unknown_count; /* of the parameters the last: each one number for all members, to be found
                        * from measurements, */
    double guess[SCENE_PARAMETERS_MAX]; /* from this value of the parameter on, within its range */
    int memory_count; /* of those that are known the last: states of inputs with a memory */
    scene_memory memory[QUANTITY_PLAYS_MAX];
    uint64_t timed; /* parameters, by bits, on which formulas of time depend that plays became */
    scene_formulation formulation;
    scene_motion motion;
    scene_rotation rotation; /* what networks say of it in space; in a plane an angle */
    scene_enforcement boundary_enforcement;
    scene_enforcement initial_enforcement;
} scene;

/* What follows from section and material, every number filled in (kirchhoff: infinite stiffness).
 * A beam bends about d1 and so deflects along d2, the height of a rectangle; everything else is
 * locked, and has no inertia. */
typedef struct scene_properties {
    quantity strain_stiffness[3];    /* Kse; N */
    quantity curvature_stiffness[3]; /* Kbt; N m^2 */
    quantity mass_per_length;        /* rho A; kg/m */
    quantity rotary_inertia[3];      /* rho J; kg m */
    quantity strain_damping[3];      /* Bse; N s; 0 of locked strains, as the next */
    quantity curvature_damping[3];   /* Bbt; N m^2 s */
    quantity maxwell_ratio;          /* of the stiffness of a Maxwell branch; 0: there is none */
    quantity maxwell_rate;           /* one over its time; 1/s */
} scene_properties;

/* Defaults: a straight Cosserat rod, clamped at s = 0 at the origin along +z, free at the other
 * end, static, mixed form, hard enforcement. Numbers without a default are not given. */
void scene_defaults(scene *rod_scene);

/* AD_BAD_INPUT for a scene that contradicts itself or lacks something: `key` receives the dotted
 * YAML key that is to blame (static text), `error` the line without a place. */
ad_status scene_check(const scene *rod_scene, const char **key, ad_error *error);

/* Of an open scene: the key (static text) of what a network has as one number, such as lengths,
 * places and springs, but depends on a parameter. `which` of those with a range or to be found;
 * NULL: there is none. */
const char *scene_common_key(const scene *open, bool to_be_found, const scene_parameter **which);

/* A scene with numbers in place of open names of its formulas, as quantity_with; and whether any of
 * its formulas depends on such a name. */
void scene_with(const scene *open, int count, const char *const *names, const double *values,
                scene *result);
bool scene_uses(const scene *rod_scene, const char *name);
bool scene_memory_uses(const scene *rod_scene, const char *name); /* a play or a lag of it does */

/* The same rods along another s, in which lengths and places are those of the middle member for
 * all. Between two places s runs in proportion, and what has come out of a port begins at 0. A rod
 * with `growth` m for each m of s is one again, of strains, loads per length and masses times that
 * and stiffnesses over it; r, q, N, m and energies stay. `place` says where s is on the rod as it
 * is written, growth is its derivative. Needs a scene that passes scene_check; its formulas must
 * outlive the result. Where nothing is to be done the result is the scene. AD_BAD_INPUT with the
 * key to blame: places that change their order within the ranges. */
ad_status scene_map(const scene *given, scene *mapped, const char **key, ad_error *error);

/* Where s is at t on a member with these values, on the scene itself if that has no parameters; s
 * where it is not mapped. And growth there, else 1. Which s is at a place of a scene of numbers
 * whose lengths are those of the middle, or that is fed in time. */
double scene_place_at(const scene *rod_scene, const double *values, double s, double t);
double scene_growth_at(const scene *rod_scene, const double *values, double s, double t);
double scene_at_place(const scene *rod_scene, double place, double t);

/* The s of a place at t of the member with these values, m on the rod as it is written. NaN: that
 * depends on what is to be found, or it is not on the rod. */
double scene_s_of_place(const scene *open, const double *values, double place, double t);

/* The value of a parameter at a fraction of its range, 0 to 1, by its scale, and back. */
double scene_parameter_at(const scene_parameter *parameter, double fraction);
double scene_parameter_fraction(const scene_parameter *parameter, double value);
bool scene_parameter_holds(const scene_parameter *parameter, double value); /* but for rounding */

/* How the value changes with the fraction, where it is that. */
double scene_parameter_slope(const scene_parameter *parameter, double value);

/* The fraction of parameter i of member `number` of some that are spread over their ranges. */
double scene_spread_fraction(int number, int i);

/* Whether a parameter is what a robot is moved by: what pulls, a held end or the insertion, a field
 * of magnets or how a tube is turned depends on it. */
bool scene_parameter_actuates(const scene *family, int index);

/* The index of the parameter of that name; -1: none. */
int scene_parameter_find(const scene *family, const char *name);

/* Training finds a number y for an unknown: its fraction is 1/(1 + exp(-y - y0)), never an end of
 * the range, with this y0 where it begins, of a guess at an end close to it. */
double scene_unknown_scalar(const scene_parameter *parameter, double guess);
double scene_unknown_value(const scene_parameter *parameter, double guess, double scalar);

/* One member of a family, values [parameter_count] in SI units: a scene without parameters. The
 * middle one has every parameter at the fraction 1/2; of a scene that is no family it is this
 * scene. */
void scene_member(const scene *family, const double *values, scene *member);
void scene_middle(const scene *family, scene *member);

/* Its ends are where those of the middle are. Places of ends in motion are recorded, and corners of
 * their ranges are not among them: a rod need not reach those. */
void scene_place_ends(const scene *family, scene *member);

/* Writes the values [parameter_count] of the middle one, and returns them. */
const double *scene_middle_values(const scene *family, double *values);

/* Reads "a=1, b=2" as the values [count] of these parameters. AD_BAD_INPUT: a name that is none of
 * them or comes twice, a value outside its range unless any will do, a parameter without one. */
ad_status scene_member_read(int count, const scene_parameter *parameters, bool any_value,
                            const char *text, double *values, ad_error *error);

/* Needs a scene that passes scene_check. Of segments that differ it has formulas that switch from
 * one to the next at their joints, where(s - joint, behind, before): at a joint what is before. */
scene_properties scene_properties_of(const scene *rod_scene);

/* The unstressed rod: v*, u* and what is added to u* times 1 - load factor, every number filled in;
 * joined like the properties. Whoever needs the rest shape of a scene asks here. */
typedef struct scene_rest {
    quantity strain[3];
    quantity curvature[3];
    quantity imperfection[3];
} scene_rest;

scene_rest scene_rest_of(const scene *rod_scene);

/* Whether springs or a foundation are measured from the unstressed rod. */
bool scene_measures_from_rest(const scene *rod_scene);

/* Whether the unstressed rod is straight and as long as it is written, by numbers. */
bool scene_rests_straight(const scene *rod_scene);

/* Whether a material has a Maxwell branch. */
bool scene_has_branch(const scene *rod_scene);

/* The rod in pieces: its segments, or all of it as one. `rod` has all that holds for the piece,
 * `turn` is 0 for the first. */
typedef struct scene_piece {
    double from, to; /* m */
    scene_rod rod;
    double turn[3]; /* rad */
} scene_piece;

int scene_pieces(const scene *rod_scene);
double scene_joint(const scene *rod_scene, int index); /* where segment `index` ends; m */
scene_piece scene_piece_of(const scene *rod_scene, int index);

/* Gives the rod the law, and where the model does not lock a strain and no stiffness is given the
 * stiffness of the law. */
void scene_take_law(scene_rod *rod, const scene_law *law);

/* Of one piece. */
scene_properties scene_rod_properties(const scene_rod *rod);
scene_rest scene_rod_rest(const scene_rod *rod);

/* A tendon or a chamber, in a scene that it points into; index: tendons, then chambers. */
typedef struct scene_actuator {
    const char *name, *unit;     /* "tendon"; of what is given */
    const quantity *offset;      /* [2] */
    const quantity *start, *end; /* as they are given, or not, */
    double from, to;             /* and where it is; m */
    quantity given;              /* tension, displacement or pressure */
    const scene_tendon *tendon;
    const scene_chamber *chamber; /* one of the two */
} scene_actuator;

int scene_actuator_count(const scene *rod_scene);
scene_actuator scene_actuator_of(const scene *rod_scene, int index);

/* What the law is given as its pull: the tension, where that is given; minus pressure times area. A
 * new formula. */
quantity scene_actuator_pull(const scene_actuator *of);

/* The keys of those it has. */
const char *scene_actuator_lists(const scene *rod_scene);

/* Of one tube: bending and torsional stiffness, mass; and where it ends, m. */
scene_properties scene_tube_properties(const scene_tube *tube);
double scene_tube_end(const scene *rod_scene, int index);

/* Whether a tendon is given by its displacement, so that its tension is not known; and whether one
 * has friction, so that its tension falls along it. */
bool scene_has_displaced_tendons(const scene *rod_scene);
bool scene_has_rubbing_tendons(const scene *rod_scene);

/* Whether any stiffness is infinite: that strain has no constitutive law. Of the properties of one
 * piece, as those of several may be infinite in some of them; and of a scene, in any piece. */
bool scene_is_locked(const scene_properties *properties);
bool scene_locks_somewhere(const scene *rod_scene);

/* In m and s; 0 for a static scene. */
static inline double scene_length(const scene *rod_scene)
{
    double sum = 0;
    if (rod_scene->rod.length.is_given) {
        return rod_scene->rod.length.number;
    }
    for (int i = 0; i < rod_scene->segment_count; i++) {
        sum += rod_scene->segments[i].length.number;
    }
    return sum;
}

/* The same as a formula of parameters. */
quantity scene_whole_length(const scene *rod_scene);

static inline double scene_duration(const scene *rod_scene)
{
    return rod_scene->duration.number;
}

/* Parameters that are known of each member, the first. */
static inline int scene_known_count(const scene *rod_scene)
{
    return rod_scene->parameter_count - rod_scene->unknown_count;
}

/* Of these, parameters of which a member has to say values: no states of plays. */
static inline int scene_given_count(const scene *rod_scene)
{
    return scene_known_count(rod_scene) - rod_scene->memory_count;
}

static inline bool scene_is_family(const scene *rod_scene)
{
    return scene_known_count(rod_scene) > 0;
}

/* Whether formulas have open names, of a family or of unknowns: it has no solution of its own. */
static inline bool scene_is_open(const scene *rod_scene)
{
    return rod_scene->parameter_count > 0;
}

static inline bool scene_is_dynamic(const scene *rod_scene)
{
    return scene_duration(rod_scene) > 0;
}

/* Whether a stiffness is infinite, so that its strain is locked. */
static inline bool scene_locks(quantity stiffness)
{
    return quantity_is(stiffness, INFINITY);
}

/* Smallest and largest value over samples of s, in every piece, and t, as far as it depends on
 * them; NaN where a value is not a number. */
typedef struct scene_range {
    double low, high;
} scene_range;

scene_range scene_range_of(const scene *rod_scene, quantity q);

/* The same over s from .. to only (m). */
scene_range scene_range_within(const scene *rod_scene, quantity q, double from, double to);

/* One number for what varies along the rod, at t = 0, by a few samples. Of a stiffness, which may
 * vary by powers of ten, it is the geometric mean of where it is finite; of anything else, the
 * mean. */
double scene_mean_stiffness(const scene *rod_scene, quantity stiffness);
double scene_mean(const scene *rod_scene, quantity q);

bool scene_is_manufactured(const scene *rod_scene);

/* Whether a rod does not shear or does not stretch, by infinite stiffness; of a beam: false. */
bool scene_locks_strains(const scene *rod_scene);

/* Whether sections or bodies resist an acceleration by more than their mass: a fluid moves with the
 * rod, or a body lies beside the axis. */
bool scene_couples_inertia(const scene *rod_scene);
bool scene_is_imperfect(const scene *rod_scene); /* by a number that is not 0, or a formula */

/* Whether the model is a beam of small deflection. */
static inline bool scene_is_beam(const scene *rod_scene)
{
    return rod_scene->rod.model == SCENE_EULER_BERNOULLI ||
           rod_scene->rod.model == SCENE_TIMOSHENKO;
}

/* Whether the equations take four derivatives of the unknown, the strong form of Euler and
 * Bernoulli: of what is known to rounding only, little would be left. */
static inline bool scene_is_fourth_order(const scene *rod_scene)
{
    return rod_scene->rod.model == SCENE_EULER_BERNOULLI &&
           rod_scene->formulation == SCENE_DISPLACEMENT;
}

/* What an end holds; where it does not hold the position it gives the force, where it does not hold
 * the rotation it gives the moment. */
static inline bool scene_end_holds_rotation(scene_end_type type)
{
    return type == SCENE_CLAMPED || type == SCENE_DRIVEN || type == SCENE_GUIDED;
}

/* Whether it has a position, which it holds in some directions at least, or slides from. */
static inline bool scene_end_is_placed(scene_end_type type)
{
    return type != SCENE_FREE && type != SCENE_LOADED;
}

static inline bool scene_end_slides(scene_end_type type)
{
    return type == SCENE_GUIDED || type == SCENE_ROLLER;
}

/* Whether loads.base or loads.tip act on it: the support takes what they do where it is held. */
static inline bool scene_end_takes_force(scene_end_type type)
{
    return type == SCENE_LOADED || scene_end_slides(type);
}

/* The directions in which an end holds its position: none (0), that of `axis` (1), those across it
 * (2), all (3). axis: unit, in the world; 0 where it does not count. */
typedef struct scene_hold {
    int directions;
    double axis[3];
} scene_hold;

scene_hold scene_hold_of(const scene_end *end);

/* The part of x along the held directions. */
void scene_hold_part(const scene_hold *hold, const double x[3], double part[3]);

/* Entry `index` of all lists of a scene in turn, for people: "tendons[0]: offset 0, 0.02; tension
 * 3", with what is given and no default. False: there are not so many. */
bool scene_entry_text(const scene *rod_scene, int index, char *text, size_t size);

/* Texts of each enumeration in the order of its values, NULL at the end. */
const char *const *scene_model_names(void);
const char *const *scene_section_names(void);
const char *const *scene_end_names(void);
const char *const *scene_frame_names(void);
const char *const *scene_formulation_names(void);
const char *const *scene_rotation_names(void);
const char *const *scene_enforcement_names(void);
const char *const *scene_motion_names(void);
const char *const *scene_scale_names(void);
const char *const *scene_state_names(void);

#ifdef __cplusplus
}
#endif

#endif
