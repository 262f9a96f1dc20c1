/* Actuators and tubes in a section of the rod, in plain C: the sums of physics/rod/rod.h; and
 * what a nonlinear law is beyond the stiffness of the rod, which depends on the strains like them.
 * Strains are (v, u), wrenches (n, m), six numbers each. */
#ifndef PHYSICS_LOCAL_ACTUATION_H
#define PHYSICS_LOCAL_ACTUATION_H

#include "physics/local/rod_model.h"

enum { ACTUATION_ROWS = 6 };

/* All that pulls in one section; count 0 and no law: nothing does. */
typedef struct solve_actuation {
    int count;
    const solve_extent *extents;     /* [count] */
    const solve_actuator *actuators; /* [count] in this section */
    double s;
    double factor;          /* of the load */
    const double *tensions; /* [count] of tendons whose length is given, 0 of others; NULL: none */
    const scene_law *law;   /* NULL: linear; length and force are its units, as of rod_scales */
    double length, unit_force;
    const double *rest;  /* v*, u* of the rod, for a law and for tubes, which set out from them; */
    const double *tubes; /* theta, m_i of each, the last of the actuators; NULL: not looked at */
    double rubbed[SOLVE_ACTUATORS_MAX]; /* [count] friction times the angle turned up to here */
} solve_actuation;

/* Those of a point at s, the `point`th of `all` [..][rod->actuators]. */
static inline solve_actuation solve_actuation_at(const solve_rod *rod, const solve_actuator *all,
                                                 size_t point, double s, double factor)
{
    return (solve_actuation){.count = rod->actuators,
                             .extents = rod->extents,
                             .actuators = all + point * (size_t)rod->actuators,
                             .s = s,
                             .factor = factor,
                             .law = rod->scene.rod.law,
                             .length = rod->scales.length,
                             .unit_force = rod->scales.force};
}

/* How strongly actuator i pulls here, by Euler's and Eytelwein's law of a rope. */
double solve_actuation_pull(const solve_actuation *a, int i);

/* Whether anything does. */
static inline bool solve_actuation_pulls(const solve_actuation *a)
{
    return a->count > 0 || a->law;
}

/* What they and the law add to n and m at these strains, and its derivatives by them, a symmetric
 * matrix, where that is not NULL. */
void solve_actuation_wrench(const solve_actuation *a, const double *strains, double *wrench,
                            double (*by_strains)[ACTUATION_ROWS]);

/* Index of the first tube. */
static inline int solve_actuation_first_tube(const solve_actuation *a)
{
    int first = a->count;
    while (first > 0 && a->extents[first - 1].law == LAW_TUBE) {
        first--;
    }
    return first;
}

/* The equations of tube i (an actuator) where u is: theta' and m_i', and where that is not NULL
 * their derivatives by u, by theta and by m_i [2][5]; beyond its end 0. Those of m_i' by u are also
 * those of what it adds to m by theta. */
void solve_tube_rate(const solve_actuation *a, int i, const double *curvature, double rate[2],
                     double (*by)[5]);

/* Whether a tube is here, for which s is not beyond its end. */
bool solve_tube_is_here(const solve_actuation *a, int i);

/* The energy of all tubes per length. */
double solve_tube_energy(const solve_actuation *a, const double *curvature);

/* The same of the law, beyond that of the linear one; and n, m [ACTUATION_ROWS] and derivatives by
 * the strains, which may be NULL. */
double solve_law_energy(const solve_actuation *a, const double *strains, double *wrench,
                        double (*by_strains)[ACTUATION_ROWS]);

/* The second variation of the energy of tube i by changes p, q of u (the first three), theta and
 * theta'. */
double solve_tube_variation(const solve_actuation *a, int i, const double *curvature,
                            const double p[5], const double q[5]);

/* The potential energy per length of actuators, of which their wrench is the gradient. */
double solve_actuation_energy(const solve_actuation *a, const double *strains);

/* tangent [3] = p'/|p'| of tendon i, body, and |p'|; also beyond its ends. */
double solve_actuation_tangent(const solve_actuation *a, int i, const double *strains,
                               double tangent[3]);

/* |p'| of tendon i, 0 beyond its ends and of tubes. */
double solve_actuation_length(const solve_actuation *a, int i, const double *strains);

/* The strains x with x = rest + compliance (wrench - actuation(x)), which are those of a minimum of
 * a convex energy, and their derivatives by the wrench. Not a number where Newton's method finds
 * none, as where tendons shorten the section to nothing, and where the derivatives that are asked
 * for do not exist. */
void solve_actuation_strains(const solve_actuation *a, const double *rest, const double *compliance,
                             const double *wrench, double *strains,
                             double (*by_wrench)[ACTUATION_ROWS]);

/* With T, the second derivatives of their energy by v and u: stiffness K + T_uu, softness
 * (1 + C T_vv)^-1 C, coupling T_vu. K and C are given in their diagonals. The softness is not
 * a number where the section gives way by itself. */
void solve_actuation_stiffen(const solve_actuation *a, const double *strains,
                             double stiffness[3][3], double softness[3][3], double coupling[3][3]);

/* Of a scene with actuators: its rod and, at rest and in SI units, its actuators at n
 * points s [n], m: [n][(*rod)->actuators]. The caller frees both, also after an error. */
ad_status solve_actuation_in_si(const scene *rod_scene, size_t n, const double *s, solve_rod **rod,
                                solve_actuator **actuators, ad_error *error);

/* The largest, over n points s [n] at time t, of the moment and the winding of actuators
 * along the rod, by EI/L and 1/L; 0 without any. */
typedef struct solve_actuation_size {
    double moment;  /* sum of |pull| |r|; of tendons whose length is given by how much they turn
                     * the rod */
    double winding; /* |r_s| by |r| */
} solve_actuation_size;

ad_status solve_actuation_measure(const solve_rod *rod, size_t n, const double *s, double t,
                                  solve_actuation_size *size, ad_error *error);

#endif
