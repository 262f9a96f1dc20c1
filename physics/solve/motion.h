/* The equations of motion of a rod at the nodes of spectral elements: space made discrete, time
 * not.
 *
 * Elements of one degree, with Legendre-Gauss-Lobatto points for nodes and quadrature. What the rod
 * is made of, its rest shape and its loads may jump where two elements meet.
 * Unknown at each node: position r (world), rotation q, velocity V = r_t (world), spin w = 2 vec(q*
 * q_t) (body). Strains follow from nodal values by differentiation, in each element: v = R^T r_s, u
 * = 2 vec(q* q_s). With potential energy W(r, q), the sum over the quadrature points of
 * 1/2 (v - v*) Kse (v - v*) + 1/2 (u - u*) Kbt (u - u*), the equations of motion at node j are
 * those of Lagrange, whose mass is diagonal:
 *
 *   weight_j rhoA V_t                    = -dW/dr_j + loads
 *   weight_j (rhoJ w_t + w x rhoJ w)     = -(derivative of W by a turn of node j, body) + loads
 *
 * Without damping and loads the discrete rod conserves energy, momentum and angular momentum
 * exactly, and ends that give force and moment are natural. Damping acts on v_t and u_t, which are
 * linear in V and w, through the same derivatives, so that it can only dissipate; actuators,
 * whose wrench is one of the strains, act through them, too, and do exact work. q and r are
 * polynomials in an element, so that strains do not change when the rod moves rigidly.
 *
 * A Maxwell branch adds ratio K (e - z) to n and m, e the strain beyond rest: what its damper has
 * of it, z at each quadrature point, is a state, too, with the rate (e - z)/time.
 *
 * At an end that holds position or rotation, these and their rates are what the model prescribes,
 * whatever stands in the state. Quaternions of the state need not be unit. Numbers are
 * dimensionless as in rod_model.h. */
#ifndef PHYSICS_SOLVE_MOTION_H
#define PHYSICS_SOLVE_MOTION_H

#include "physics/local/rod_model.h"
#include "physics/solve/solve.h"

#include <math.h>

/* Rows of the state of a node: [nodes][MOTION_ROWS]. Behind them, with a Maxwell branch, are z
 * [points][6] of quadrature points, motion_size in all. */
enum { MOTION_R = 0, MOTION_Q = 3, MOTION_V = 7, MOTION_W = 10, MOTION_ROWS = 13 };

typedef struct motion motion;

/* Borrows `rod`. lock: the stiffness, by EI/L^2 or EI, of strains that the model locks; what they
 * still give way is n/lock. edges [elements + 1]: s where they begin and end, from 0 to 1; NULL:
 * equal elements. AD_BAD_INPUT for what this form cannot do: no rotary inertia. */
ad_status motion_create(const solve_rod *rod, double lock, int elements, const double *edges,
                        int degree, motion **result, ad_error *error);
void motion_free(motion *m);

const solve_rod *motion_rod(const motion *m);
size_t motion_nodes(const motion *m);
int motion_degree(const motion *m);
const double *motion_points(const motion *m);  /* s [nodes] */
const double *motion_weights(const motion *m); /* of the quadrature over s [nodes] */

size_t motion_size(const motion *m); /* of a state */

/* The state [motion_size] at t = 0, where it then is. */
ad_status motion_initial(motion *m, double *state, ad_error *error);

/* Go to time t: loads, prescribed ends and rest shape, for all that follows. Cheap when already
 * there. */
ad_status motion_at(motion *m, double t, ad_error *error);

/* rate = d state/dt, both [motion_size]; 0 where an end prescribes. */
void motion_rate(motion *m, const double *state, double *rate);

/* The same with z as it follows strains within a time gamma implicitly, z + gamma z_t in place of
 * z, which is the stress of a branch that is softer: z of `state` is less by gamma z_t. */
void motion_rate_following(motion *m, double gamma, const double *state, double *rate);
const double *motion_relaxing(const motion *m, size_t *count); /* 1/time of each z [count] */

/* Put what the ends prescribe into the state, and make quaternions unit. */
void motion_prescribe(const motion *m, double *state);

/* The larger of two; not a number if one is none, which fmax would forget. */
static inline double motion_larger(double a, double b)
{
    return a > b || isnan(a) ? a : b;
}

typedef struct motion_energy {
    double kinetic, strain;
} motion_energy;

motion_energy motion_energy_of(motion *m, const double *state);

/* load - dissipation is exactly the rate of kinetic + strain. */
typedef struct motion_power {
    double load;        /* of loads and actuators, of what moves the ends, and of what
                         * changes the rest shape */
    double dissipation; /* of damping and drag, >= 0 */
} motion_power;

motion_power motion_power_of(motion *m, const double *state);

/* The same of the nodes as motion_start or the flows below left them. */
motion_energy motion_energy_now(motion *m);
motion_power motion_power_now(motion *m);

/* At n points s [n], by the elements' polynomials through nodal values. */
void motion_samples(motion *m, const double *state, size_t n, const double *s, solve_state *out);

/* ---- flows, for steps of time that are composed of them ------------------------------------ */

/* Whether no force but drag depends on velocities, and no mass on the shape, so that these are the
 * whole motion. */
bool motion_is_separable(const motion *m);

/* Take a state, at the time gone to; give it. In between the nodes are the motion's own, and
 * nothing else may be asked of it that takes a state. */
void motion_start(motion *m, const double *state);
void motion_finish(const motion *m, double *state);

/* Nodes to the last bit, so that steps to somewhere else can be taken back. */
size_t motion_kept_size(const motion *m); /* of `kept`, doubles */
void motion_keep(const motion *m, double *kept);
ad_status motion_take_back(motion *m, const double *kept, double t, ad_error *error);

/* Nodes move freely by h, which may be negative, to the time t: r_t = V, bodies turn as free ones
 * do. */
ad_status motion_drift(motion *m, double h, double t, ad_error *error);

/* Forces change velocities as they would in a time h. Returns the work of outside forces while
 * nodes move by `before` with the velocities up to now, and by `after` with the new ones, at half
 * the forces of now: the other half is that of the kicks before and after. */
double motion_kick(motion *m, double h, double before, double after);

/* Drag alone slows the nodes for a time h. Returns the energy that it takes, from the nodes and
 * from what moves an end. */
double motion_resist(motion *m, double h);

#endif
