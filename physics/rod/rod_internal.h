/* What the files of the rod physics share; not for others. Everything dimensionless. */
#ifndef PHYSICS_ROD_ROD_INTERNAL_H
#define PHYSICS_ROD_ROD_INTERNAL_H

#include "physics/law/law.h"
#include "physics/rod/rod.h"

/* Dimensionless: how far a held end may be from the initial state, and so what the unstressed shape
 * has to be resolved to. Well above rounding, well below what training resolves. */
static const double ROD_MISMATCH = 1e-8;

/* Position, rotation and their rates at t = 0, or where a window begins. */
typedef struct rod_initial_data {
    ad_value position, rotation, velocity, spin;
} rod_initial_data;

/* A scene at work on a tape, at a place. */
typedef struct rod_context {
    const scene *scene;
    ad_tape *tape;
    bool dynamic;
    rod_scales scales;
    scene_properties properties; /* SI */
    domain domain;
    domain_place at; /* its window and load factor; its state where it goes on from one */
    rod_plane plane;
    ad_value s, t;       /* the coordinates; in a static scene t is the constant 0 */
    int parameter_count; /* open names beside these, and what they are on the tape */
    quantity_binding parameters[SCENE_PARAMETERS_MAX];
} rod_context;

/* Coefficients of the equations, of s and t; a term that the scene lacks has a constant 0. */
typedef struct rod_coefficients {
    ad_value strain_compliance;    /* [3] Kse^-1, 0: locked */
    ad_value curvature_compliance; /* [3] Kbt^-1, 0: locked */
    ad_value strain_stiffness;     /* [3] Kse, 0 where locked */
    ad_value curvature_stiffness;  /* [3] Kbt, 0 where locked */
    ad_value strain_damping;       /* [3] Bse */
    ad_value curvature_damping;    /* [3] Bbt */
    ad_value maxwell;              /* [2] ratio, and one over the time of a Maxwell branch */
    ad_value mass;                 /* rhoA over its mean, static: 0 */
    ad_value rotary_inertia;       /* [3] rhoJ */
    ad_value added_mass;           /* of the fluid across d3 */
    ad_value rest_strain;          /* [3] v* */
    ad_value rest_curvature;       /* [3] u* */
} rod_coefficients;

/* Strains and rates of a pose field. Rates are constant zeros in a static scene. */
typedef struct rod_kinematics {
    ad_value strain, curvature;           /* v, u, body */
    ad_value strain_rate, curvature_rate; /* v_t, u_t */
    ad_value velocity, acceleration;      /* r_t, r_tt, world */
    ad_value spin, spin_rate;             /* w, w_t, body */
} rod_kinematics;

typedef struct rod_wrench {
    ad_value force;  /* n [3], body */
    ad_value moment; /* m [3], body */
} rod_wrench;

static inline rod_wrench rod_wrench_add(rod_wrench a, rod_wrench b)
{
    return (rod_wrench){ad_add(a.force, b.force), ad_add(a.moment, b.moment)};
}

/* An actuator in the section at s: its axis is at the body position r = (offset, 0). */
typedef struct rod_actuator {
    ad_value offset, slope; /* [2] r and r_s */
    ad_value pull;          /* its tension; minus pressure times area; also beyond its ends */
    ad_value displacement;  /* by which a tendon of given length is pulled out; 0 of others */
    ad_value friction;      /* Coulomb's, of a tendon against its guides; 0 of others */
    ad_value compliance;    /* of a tendon of given length that is elastic; 0 of others */
    double start, end;      /* within [0, 1] */
    law_name law;
} rod_actuator;

/* The directions in which a vector is given: scene_hold in the frame of the equations. */
typedef struct rod_hold {
    int directions;
    ad_value axis; /* [3]; not of 0 and 3 directions */
} rod_hold;

/* What is prescribed at one end. N(end) = force (world) if force_is_body is false, else R(q)
 * force; m(end) = R(q)^T moment if moment_is_world, else moment. Signs are those of the internal
 * force and moment. */
typedef struct rod_end_data {
    rod_hold hold;       /* of the position; in other directions it has a force */
    bool holds_rotation; /* else it has a moment */
    ad_value position, rotation;
    ad_value force, moment;
    bool force_is_body, moment_is_world;
    bool turns; /* rotation = exp(turn) times that of the unstressed rod; turn [3], world */
    ad_value turn;
} rod_end_data;

typedef struct rod_pose {
    ad_value position, rotation;
} rod_pose;

/* rod_context.c */
rod_context rod_context_of(const scene *scene, const domain_place *at);

/* Of a scene with open names, which are any values of the tape; `one` has numbers in their place,
 * and its scales. Both must outlive it. */
rod_context rod_context_open(const scene *open, const scene *one, const domain_place *at, int count,
                             const char *const *names, const ad_value *parameters);

/* rod_scale.c: the largest internal force and moment to expect, in units of the scales, at least 1.
 */
double rod_force_scale(const scene *scene);
double rod_moment_scale(const scene *scene);

/* A quantity at dimensionless s, t, in SI. */
ad_value rod_quantity(const rod_context *rod, quantity q, ad_value s, ad_value t);

/* Metres of the rod as it is written for each of s, at the context's s; 1 where it is not mapped.
 */
ad_value rod_growth(const rod_context *rod);

/* `count` quantities at dimensionless s, t as one value, times factor; `fallback` [count] are the
 * numbers, already dimensionless, of those that are not given. */
ad_value rod_quantities(const rod_context *rod, int count, const quantity *given,
                        const double *fallback, double factor, ad_value s, ad_value t);

/* rod_undeformed.c: the unloaded rod, held at one end where the scene holds it at t = 0; between
 * two pinned ends it is turned along the line through them. Of a scene with open names it is that
 * of the member; places at which rest strains jump have to be those of all, else the tape fails. */
rod_pose rod_undeformed(const rod_context *rod, ad_value s);

/* rod_shape.c, in numbers. The end, 0 or 1, whose pose places it, and its rotation when that end
 * gives none: of two ends that are held and turn freely the smallest rotation that turns the line
 * between the ends of the unloaded rod to the line between the two points; else none. */
int rod_shape_anchor(const scene *scene);
bool rod_shape_is_between(const scene *scene);
void rod_shape_upright(const scene *scene, double q[4]);

/* Whether its polynomials, where the rest strains vary with s, have converged. */
bool rod_shape_is_resolved(const scene *scene);

/* rod_frame.c. What the scene gives in the world enters the equations through the first three, what
 * they answer leaves through the next three; in a spatial scene all of them do nothing. What leaves
 * the plane is made the constant 0. */
ad_value rod_from_world(const rod_context *rod, ad_value vector);
ad_value rod_axial_from_world(const rod_context *rod, ad_value vector); /* a moment */
ad_value rod_rotation_from_world(const rod_context *rod, ad_value rotation);
ad_value rod_to_world(const rod_context *rod, ad_value vector);
ad_value rod_position_to_world(const rod_context *rod, ad_value position);
ad_value rod_rotation_to_world(const rod_context *rod, ad_value rotation);
/* What already is in the plane's frame, with the constant 0 where it numerically is 0. */
rod_pose rod_pose_in_plane(const rod_context *rod, rod_pose pose);
ad_value rod_keep_in_plane(const rod_context *rod, ad_value vector, bool axial);
/* A vector in the plane from its 2 rows, an axial vector from its 1, with zeros; in space from the
 * 3 that they are. */
ad_value rod_vector_of(const rod_context *rod, ad_value rows);
ad_value rod_axial_of(const rod_context *rod, ad_value rows);
/* The rotation by a rotation vector [3]; in a plane by an angle [1]. */
ad_value rod_rotation_by(const rod_context *rod, ad_value turn);
/* The rotation whose matrix has as first columns (1, 0, 0) + a, (0, 1, 0) + b, made orthonormal in
 * this order; columns [6] a, b. The quaternion has a scalar part >= 0. */
ad_value rod_rotation_by_six(ad_value columns);
/* In a plane: that angle, within (-2 pi, 2 pi]. */
ad_value rod_angle_of(const rod_context *rod, ad_value rotation);
/* The rows of a residual that do not vanish by symmetry, and how many they are: of vectors, and of
 * axial vectors like moments and curvatures. */
ad_value rod_vector_in_plane(const rod_context *rod, ad_value residual);
ad_value rod_axial_in_plane(const rod_context *rod, ad_value residual);
int rod_vector_rows(const rod_plane *plane);
int rod_axial_rows(const rod_plane *plane);

/* rod_ends.c. `end`: 0 or 1. */
rod_end_data rod_end_of(const rod_context *rod, int end, ad_value t);
/* q turned on about d3 by a share of the twist of the end s = 1. */
ad_value rod_twisted(const rod_context *rod, ad_value rotation, ad_value share, ad_value t);
rod_initial_data rod_initial_of(const rod_context *rod, ad_value s);
/* The part of a vector in these directions, and the other directions. */
ad_value rod_hold_part(const rod_context *rod, const rod_hold *hold, ad_value vector);
rod_hold rod_hold_other(const rod_hold *hold);
ad_value rod_end_force(const rod_end_data *end, ad_value rotation);  /* N, world */
ad_value rod_end_moment(const rod_end_data *end, ad_value rotation); /* m, body */

/* rod_points.c. What acts at single places, lists of scene.h in their order. The places `s` are
 * dimensionless, forces and moments those of the outside on the rod, in the frame of the equations
 * and under the load factor of the place:
 *   N(s+) = N(s-) - force,   m(s+) = turn* (m(s-) - moment) turn,   q(s+) = q(s-) turn
 * with the rotation before the joint in what follows it, all moments in body components. */
/* Between segments i and i + 1. */
typedef struct rod_joint {
    double s;
    bool turns;
    double turn[4]; /* unit quaternion, from the frame before to the frame after */
} rod_joint;

int rod_joint_count(const scene *rod_scene);
rod_joint rod_joint_of(const scene *rod_scene, int i);

/* A body moves by mass, inertia about d1, d2, d3 at the axis, and LAW_ECCENTRICITY with the numbers
 * `beside`, all 0 in a static scene. Its weight acts at `offset`. */
typedef struct rod_body_data {
    double s;
    bool is_beside;                        /* false: beside, offset are 0 */
    ad_value mass, inertia, beside;        /* [1], [3], [6] */
    ad_value weight, world_weight, offset; /* [3]; in the frame of the equations, the world, body */
} rod_body_data;

rod_body_data rod_body_of(const rod_context *rod, int i, ad_value t);

/* rod_jumps.c. Whether points, bodies or springs act at single places. */
bool rod_has_places(const scene *rod_scene);

/* A rotation field as if no joint before s had turned it, and back; the same of vectors in body
 * components, and of the moment the way back. */
ad_value rod_straightened(const rod_context *rod, ad_value rotation, ad_value s);
ad_value rod_turned_at_joints(const rod_context *rod, ad_value rotation, ad_value s);
ad_value rod_vector_straightened(const rod_context *rod, ad_value vector, bool axial, ad_value s);
ad_value rod_moment_at_joints(const rod_context *rod, ad_value moment, ad_value s);

/* What acts at a place, for fields r, q of s and t: force in the frame of the equations, moment in
 * body components. Ends of the rod count as places. */
typedef struct rod_force_at {
    double s;
    ad_value force, moment;
} rod_force_at;

/* acting [ROD_AT_PLACES_MAX + SCENE_BODIES_MAX]; returns how many. */
int rod_forces_at(const rod_context *rod, const rod_pose *field, rod_force_at *acting);

/* By how much N and m, the latter as if there were no joints, have jumped up to s: minus the sums
 * of what acts before; and at s = 1 with what acts there. */
typedef struct rod_jumps {
    ad_value force, moment, all_force, all_moment;
} rod_jumps;

rod_jumps rod_jumps_of(const rod_context *rod, const rod_pose *field);

/* rod_residual.c. Whether strains are unknowns of their own or follow from N and m: there are
 * residuals of them, and as many outputs. */
bool rod_has_strains(const scene *rod_scene);

/* rod_balance.c */
rod_coefficients rod_coefficients_of(const rod_context *rod);
ad_value rod_space_derivative(const rod_context *rod, ad_value y);
ad_value rod_time_derivative(const rod_context *rod, ad_value y, int order);
ad_value rod_rate(ad_value rotation, ad_value derivative); /* 2 vec(q* dq) */
rod_kinematics rod_kinematics_of(const rod_context *rod, ad_value position, ad_value rotation);

/* By what a law of motion with these numbers resists velocities and accelerations: the force in the
 * frame of the equations, the moment in the body's. */
rod_wrench rod_resistance(const rod_context *rod, law_name law, ad_value rotation,
                          const rod_kinematics *k, ad_value numbers);

/* rod_tendons.c. The rows of rod_state.tendons, 0 in displacement form; their residuals; what is
 * left here of the tension of a tendon, `given` where the scene gives it. */
int rod_tendon_rows(const scene *scene);
ad_value rod_tendon_residual(const rod_context *rod, rod_state state);
ad_value rod_tendon_pull(const rod_context *rod, ad_value tendons, int index, ad_value given);

/* What friction leaves of a pull, by the angle by which the tendon has turned: the capstan's law.
 */
ad_value rod_tendon_rubbed(ad_value pull, ad_value friction, ad_value angle);

/* rod_scale.c: the largest distance of a tendon from the axis over the length, which is a scale
 * also of one on the axis: at least 1e-3. */
double rod_tendon_arm(const scene *scene, int index);

static inline law_name rod_actuator_law(const scene_actuator *given)
{
    return given->tendon ? LAW_TENDON : LAW_CHAMBER;
}

/* rod_actuation.c: in the order of scene_actuator_of. */
rod_actuator rod_actuator_of(const rod_context *rod, int index);
/* `inside` from start to end, else `outside`. */
ad_value rod_within(const rod_context *rod, double start, double end, ad_value inside,
                    ad_value outside);
/* Of one by its law, as if it had no ends; energy: NULL, if nobody asks. Of a tendon that pulls by
 * 1 the force is its tangent, the energy |p'|. */
rod_wrench rod_actuator_wrench(const rod_context *rod, const rod_actuator *actuator, ad_value pull,
                               ad_value strain, ad_value curvature, ad_value *energy);
/* What n and m are beyond Kse (v - v*), Kbt (u - u*): damping of the material, what a nonlinear law
 * is beyond the stiffness, and actuators; constant zeros where there is none; see
 * physics/rod/rod.h. `tendons`: those of the state. And n, m in all. */
rod_wrench rod_beyond_elastic(const rod_context *rod, const rod_kinematics *kinematics,
                              ad_value tendons);
rod_wrench rod_constitutive(const rod_context *rod, const rod_kinematics *kinematics);

/* rod_tubes.c. A tube at the s of the rod; stiffness and rest shape also beyond its end. */
typedef struct rod_tube {
    ad_value bending;      /* [2] K */
    ad_value softness;     /* 1/G, 0: it does not twist */
    ad_value rest;         /* [3] k by itself */
    double end;            /* within [0, 1] */
    ad_value turned;       /* rad */
    ad_value transmission; /* of the length */
} rod_tube;

rod_tube rod_tube_of(const rod_context *rod, int index);
/* Numbers of its law [LAW_TUBE_GIVEN], under the load factor of the rod. */
void rod_tube_numbers(const rod_context *rod, int index, ad_value *numbers);
/* Shares of rest shapes and of angles at a load factor; see physics/rod/rod.h. */
double rod_tube_shape_share(double load_factor);
double rod_tube_turn_share(double load_factor);
/* theta, m_i of each from the outputs of the network, ends met; nothing without tubes. */
ad_value rod_tube_ansatz(const rod_context *rod, ad_value outputs);
/* What they add to m [3]; curvature: u. */
ad_value rod_tube_moment(const rod_context *rod, ad_value tubes, ad_value curvature);
/* [3] How much softer the rod is by itself than with them, about each director: 1/(1 + C sum K). */
ad_value rod_tube_stiffening(const rod_context *rod, ad_value compliance);
/* Rows of ROD_TWIST (torsion: false) or ROD_TORSION. */
ad_value rod_tube_residual(const rod_context *rod, rod_state state, bool torsion);

/* rod_acting.c. A law that acts from outside, per length or at a place, with its numbers [rows] by
 * physics/law/law.h, under the load factor of the rod: in the frame of the equations, or in the
 * world where the law is along its axes. Springs do not grow with the loads; an anchor that is
 * given sets out from where the unstressed rod is. */
typedef struct rod_acting {
    law_name law;
    double s; /* of a place, dimensionless */
    ad_value numbers;
} rod_acting;

enum {
    ROD_ALONG_MAX = 16,
    ROD_AT_PLACES_MAX = 2 * SCENE_SPRINGS_MAX + 2 * SCENE_POINTS_MAX + 4 * SCENE_BODIES_MAX,
    ROD_AT_ENDS_MAX = 4
};

/* What a law along the rod is given: a row of quantities of the scene. Where a law has several,
 * they stand together, in the order of its numbers. Its numbers are these times length^a
 * time^b/force; those of a factor are by themselves, and the law is 0 where it is not given. */
typedef struct rod_given {
    law_name law;
    const char *term; /* for people; NULL: it stands with another law */
    size_t offset;    /* into scene */
    int count;
    bool is_factor;
    struct {
        double length, time;
    } unit[5];
    const char *formula; /* where it resists the motion: of the damping of the first bending mode,
                            c at the velocity w1 L */
} rod_given;

int rod_givens(const rod_given **given);                               /* all of them */
const quantity *rod_given_of(const rod_given *given, const scene *of); /* [count] */
double rod_given_scale(const rod_given *given, int i, const rod_scales *by);

/* All of a scene; they return how many. */
int rod_acting_along(const rod_context *rod, rod_acting *acting);     /* [ROD_ALONG_MAX] */
int rod_acting_at_places(const rod_context *rod, rod_acting *acting); /* [ROD_AT_PLACES_MAX] */
int rod_acting_at_ends(const rod_context *rod, rod_acting *acting);   /* [ROD_AT_ENDS_MAX] */
ad_value rod_weight(const rod_context *rod); /* [3] per length, with that of tubes */
bool rod_has_law_along(const scene *given, bool (*which)(const law *of));
bool rod_has_law_at_places(const scene *given, bool (*which)(const law *of)); /* springs, magnets */

/* The force in the frame of the equations, the moment in body components. */
rod_wrench rod_acting_wrench(const rod_context *rod, const rod_acting *at, rod_pose pose,
                             ad_value velocity);

/* Left sides minus right sides of the two balance laws, without a manufactured load. */
ad_value rod_force_balance(const rod_context *rod, rod_state state);
ad_value rod_moment_balance(const rod_context *rod, rod_state state);

#endif
