/* The law at a point: what acts on a rod there, as formulas of the state of the section that are
 * recorded once. Equations on a tape call them (law_record); solvers call C that is written from
 * them when the project is built (law_functions.h), for numbers and for vectors of numbers; their
 * derivatives are made by the tape's transforms alone.
 *
 * A law within the rod is the energy of a section per length, a function of v and u and of an
 * actuator: the wrench is its gradient, the stiffness its second derivative. What dissipates there
 * has a dissipation function of v_t and u_t in its place: its gradient, the wrench, times these
 * rates is the power that it takes. The energy of a tube, which turns by itself, is a function of
 * u, its turn theta and its torsion m, in this order, less m times the twist theta' + u_3 - k_3:
 * its gradient is what the rod's moment gains, m' and -theta'.
 *
 * A law outside of the rod acts on a section at r in the world with the rotation q, unit, body to
 * world, and the velocity V; per length or at a place. It has numbers of its own and gives a force
 * and a moment, both in the world: those of an energy, or by themselves. A turn of the section is
 * phi, in the world: q changes by (0, phi) q/2.
 *
 * A law of motion is the kinetic energy T of a section with the velocity V and the spin w, body
 * frame, and gives what its momenta P = T_V and L = T_w take with the acceleration A and the rate
 * w_t of the spin: the force -P' and the moment -L' - V x P, where a prime is the rate in the
 * world, seen in the body frame, as A is: P' = P_t + w x P (Kirchhoff; Lamb, Hydrodynamics, ch. 6).
 */
#ifndef PHYSICS_LAW_LAW_H
#define PHYSICS_LAW_LAW_H

#include "autodiff/ad.h"

typedef enum law_name {
    LAW_TENDON,    /* energy: tension |p'|, p' = v + u x r + r', (Rucker, Webster 2011) */
    LAW_CHAMBER,   /* energy: minus pressure times area times p'_3, here `pull` p'_3 */
    LAW_ACTUATORS, /* before: of x, y, x', y', pull */
    LAW_UNIT = LAW_ACTUATORS, /* energy of a unit of a learned law: a log(1 + exp(b + w . f)), f =
                                 (v, u) */
    LAW_ROUND_UNIT, /* the same, f: v_3, v_1^2 + v_2^2, u_1^2 + u_2^2, u_3^2, the squares of
                       v - J u and v + J u across, J u = (u_2, -u_1), and u_3 v . u across */
    LAW_TUBE,       /* energy: 1/2 K (w - k)^2 + m (u_3 - k_3) - c m^2/2, w of u turned back by
                       theta (Rucker, Jones, Webster 2010); u, cos theta, sin theta, m */
    LAW_ELASTIC,    /* energy: 1/2 sum_i k_i x_i^2 of strains x = (v - v*, u - u*) */
    LAW_DAMPING,    /* Kelvin-Voigt: 1/2 sum_i b_i x_i^2 of their rates x = (v_t, u_t) */
    LAW_FRICTION,   /* of a tendon, per tension: mu |t_s| sqrt(w^2 + c^2), with t_s for v and its
                       speed w past the guides for u_1 (modes_friction.c) */
    LAW_SPRING,     /* energy: 1/2 sum_i k_i (r - place - shift)_i^2, along the world's axes */
    LAW_TURNING_SPRING,  /* energy: 1/2 sum_i k_i phi_i^2, phi from upright to q, about directors */
    LAW_RESISTANCE,      /* force against the velocity: -(c_1 + c_2 |V|) V */
    LAW_FORCE,           /* energy: -f . r, a dead force f */
    LAW_MOMENT,          /* dead moment l, which has no energy */
    LAW_FOLLOWER_FORCE,  /* force R f */
    LAW_FOLLOWER_MOMENT, /* moment R l */
    LAW_SLENDER_DRAG,    /* drag along d3 and across it, with numbers of each: -(c_1 + c_2 |w|^(1/2)
                            + c_3 |w|) w of the part w of V */
    LAW_MAGNET,          /* energy: -(R m) . B, a magnetic moment m of the section in a field B */
    LAW_MAGNET_GRADIENT, /* energy: -(R m) . G r, in the field G r, G symmetric without trace */
    LAW_ROTARY_INERTIA,  /* kinetic energy: 1/2 sum_i J_i w_i^2 */
    LAW_ECCENTRICITY, /* kinetic energy: V . (w x S) + J_23 w_2 w_3 + J_13 w_1 w_3 + J_12 w_1 w_2,
                         of a mass m at c from the axis beside its m V^2/2 and the J_i: S = m c,
                         J_ij = -m c_i c_j */
    LAW_ADDED_MASS,   /* kinetic energy: 1/2 c (V_1^2 + V_2^2), of the fluid that moves with a
                         slender rod across d3 */
    LAW_COUNT
} law_name;

enum { LAW_TUBE_GIVEN = 6 }; /* numbers of a tube */
enum { LAW_NUMBERS_MAX = 9, LAW_STATE = 3 + 4 + 3, LAW_MOVING = 4 * 3 };
enum { LAW_GIVEN_MAX = LAW_MOVING + LAW_NUMBERS_MAX };
enum { LAW_WRENCH = 6, LAW_STIFFNESS = LAW_WRENCH * (LAW_WRENCH + 1) / 2 };
enum { LAW_BY = 3 * 3 * LAW_WRENCH };        /* outside */
enum { LAW_BY_MOTION = 4 * 3 * LAW_WRENCH }; /* of motion; the most */

/* What is done with its power: energy of the rod, work of the outside, dissipation, kinetic energy.
 */
typedef enum law_kind { LAW_STORES, LAW_LOADS, LAW_DISSIPATES, LAW_MOVES } law_kind;

/* Of which state it is a law: position, rotation and velocity, of what acts from outside; strains
 * of the section; curvature and the turn of a tube; velocities and accelerations, body. */
typedef enum law_state { LAW_OUTSIDE, LAW_WITHIN, LAW_TURNED, LAW_OF_MOTION } law_state;

/* A name and how many scalars. */
typedef struct law_group {
    const char *name;
    int count;
} law_group;

enum { LAW_GROUPS_MAX = 5 };

typedef struct law {
    const char *name, *about;
    law_state state;
    law_kind kind;
    int numbers; /* how many it has */
    int shares;  /* the first so many are those of the full load, and 0 without */
    bool has_energy;
    bool along_axes; /* of the world: else the same in any frame */
    bool couples;    /* within the rod: the wrench of one strain depends on others */
    /* Outside: what it depends on, and what it gives. */
    bool by_position, by_rotation, by_velocity, has_force, has_moment;
    bool steady_force; /* by_position is of the moment alone */
    /* The energy, or what it gives of force and moment, which are 0 before. */
    void (*record)(const ad_value *given, ad_value *value);
} law;

extern const law law_table[LAW_COUNT];

/* Whether it depends on the shape of the rod. */
static inline bool law_depends_on_shape(const law *of)
{
    return of->by_position || of->by_rotation;
}

/* Whether its force depends on the position. */
static inline bool law_force_by_position(const law *of)
{
    return of->by_position && of->has_force && !of->steady_force;
}

/* Scalars of the state and its numbers: v, u, numbers; u, cos theta, sin theta, m, numbers; or r,
 * q, V, numbers; or V, w, A, w_t, numbers. */
int law_given(law_name name);
int law_groups(law_name name, law_group groups[LAW_GROUPS_MAX]); /* how many, the numbers last */

/* How many derivatives: within the rod the upper triangle of second derivatives by v and u, or by
 * u, theta, m and nothing, row by row; outside those of force and moment, [6][3] by r, by a turn,
 * and by V; of motion by V, w, A and w_t. */
int law_derivatives(law_name name);

/* Entry (i, j) of the upper triangle of a symmetric 6 x 6. */
static inline int law_entry(int i, int j)
{
    return i <= j ? i * (2 * LAW_WRENCH - 1 - i) / 2 + j : j * (2 * LAW_WRENCH - 1 - j) / 2 + i;
}

/* A law on a tape of its own, with its derivatives. Within the rod: wrench n, m. */
typedef struct law_formula {
    ad_tape *tape;
    ad_value given[LAW_GIVEN_MAX], energy, wrench[LAW_WRENCH], by[LAW_BY_MOTION];
} law_formula;

/* Errors are on the tape. */
law_formula law_formula_create(law_name name);
void law_formula_free(law_formula *formula);

/* A law of values [law_given] of a tape, each of one row or of one row a point; energy, wrench [6]
 * and by [law_derivatives] may be NULL. Errors are noted on the tape. */
void law_record(law_name name, ad_tape *tape, const ad_value *given, ad_value *energy,
                ad_value *wrench, ad_value *by);

#endif
