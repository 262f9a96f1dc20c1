/* The physics of one Cosserat rod on the tape: what the network's outputs mean, and the residuals
 * that vanish for the true solution.
 *
 * Equations: the special Cosserat rod (Antman, Nonlinear Problems of Elasticity, ch. 8), in the
 * notation
 *
 *   r(s,t) position, world        q(s,t) rotation, unit quaternion, body to world
 *   N = R(q) n  force, world      m  moment, body
 *   v = R^T r_s                   u = 2 vec(q* q_s)         w = 2 vec(q* q_t)
 *   n = Kse (v - v*) + Bse v_t                               internal force, body
 *   m = Kbt (u - u*) + Bbt u_t                               internal moment, body
 *   N_s + f = rhoA r_tt                                      balance of force, world
 *   m_s + u x m + v x R^T N + R^T l
 *     = rhoJ w_t + w x (rhoJ w)                              balance of moment, body
 *
 * with f and l the distributed force and moment, world. A fluid whose mass c per length moves with
 * the rod across d3 has the momentum P = c (V_1, V_2, 0) of V = R^T r_t, and is among them with
 *
 *   f = -(R P)_t             l = -r_t x R P                  (Lamb, Hydrodynamics, ch. 6)
 *
 * Tendons of tension tau_i along body positions r_i(s) and chambers of pressure p_j, area A_j and
 * axis r_j add to n and m
 *
 *   n += sum tau_i t_i       - sum p_j A_j d3
 *   m += sum r_i x tau_i t_i - sum r_j x p_j A_j d3        t_i = p_i'/|p_i'|,
 *                                                        p_i' = v + u x r_i + r_i'
 *
 * (Rucker and Webster, IEEE Trans. Robotics 27, 2011, who write the same by second derivatives; a
 * chamber by the work of its volume, whose change along the rod is A (v + u x r).d3). n, m and N
 * are everywhere those of rod and actuators together, also in what is observed. They meet
 * the balances and the conditions at ends. Where a tendon ends, strains jump and n and m do not.
 *
 * A tube i around the rod (scene.h), at rest alone, shares its axis; its frame is that of the rod
 * turned by theta_i about d3. With R_i that turn, w = R_i^T (u_1, u_2) and its own bending K_i,
 * torsion G_i and rest shape (k_1, k_2, k_3), it adds to m
 *
 *   about d1, d2: R_i K_i (w - k)      about d3: m_i = G_i (u_3 + theta_i' - k_3)
 *   m_i' = K_i1 (w_1 - k_1) w_2 - K_i2 (w_2 - k_2) w_1          m_i = 0 at its end and beyond
 *   theta_i(0) = turned + transmission m_i(0)/G_i(0)
 *
 * (Dupont et al., IEEE Trans. Robotics 26, 2010; Rucker, Jones and Webster, the same; m_i' is the
 * derivative of its energy by theta_i). On the way to the full load, at a load factor x below 1,
 * its rest shape is a share 1 - (1 - x)^4 of the way from that of the rod. It is turned by x^2 of
 * its angle, nearly as in a robot whose tubes are in one another before they are turned. With
 * friction mu the tension falls along a tendon that is pulled, by Coulomb's law:
 *
 *   tau = tau_0 exp(-mu phi),   phi_s = |dt/ds|, t in the world, phi = 0 at its beginning.
 *
 * One that is pulled by a displacement d, of stiffness k, has an unknown tau_0, the same all along.
 * Its field l is by how much it is longer up to s than in the unstressed rod:
 *
 *   l_s = |p'| - |p'| of v*, u*,   l = 0 at its beginning, l = tau_0/k - d at its end,
 *
 * or there l is less and tau_0 = 0: then it is slack. Kse, Kbt, Bse, Bbt, rhoA, rhoJ and drag may
 * vary with s, the rest shape v*, u* with s and t, gravity with t. Damping follows the rate of the
 * strain itself, v_t and u_t, also where the rest shape moves (Kelvin and Voigt). A rod that takes
 * on a new rest shape is damped against the space that it moves in. Its material is like a spring
 * with a changing rest length beside a dashpot.
 *
 * Everything on the tape is dimensionless: sigma = s/length in [0, 1], tau = t/time, forces by
 * EI/length^2, moments by EI/length, with time = length^2 sqrt(rhoA/EI), 1 s in a static scene. EI
 * and rhoA that vary have one number each (rod_scales), and the equations have their ratio to it.
 * `s` and `t` below are sigma and tau, the coordinates of the scene's domain. In a static scene
 * there is no t, and every derivative by it is an exact 0. Absent physics (no damping, locked
 * strain, no gravity) enters as a constant 0 and is folded away by the tape; there is one copy of
 * each equation.
 *
 * Errors are sticky on the tape. Scenes must pass scene_check. */
#ifndef PHYSICS_ROD_ROD_H
#define PHYSICS_ROD_ROD_H

#include "physics/scene/domain.h"
#include "physics/scene/scene.h"

#ifdef __cplusplus
extern "C" {
#endif

/* ---- scales and numbers -------------------------------------------------------------------- */

typedef struct rod_scales {
    double length; /* m */
    double time;   /* s: length^2 sqrt(rhoA/EI), 1 if static */
    double force;  /* N: EI/length^2 */
    double moment; /* N m: EI/length */
} rod_scales;      /* EI: the smaller of the two bending stiffnesses, where they vary their
                    * scene_mean_stiffness; rhoA: the scene_mean */

rod_scales rod_scales_of(const scene *scene);

/* Dimensionless numbers that decide how hard a scene is. Infinite ratios: that strain is locked.
 * Of what varies along the rod the means of scene.h, unless the largest value is said. */
typedef struct rod_numbers {
    double shear_ratio;    /* kGA L^2/EI, the smaller */
    double axial_ratio;    /* EA L^2/EI */
    double torsion_ratio;  /* GJ/EI */
    double rotary_inertia; /* rho I/(rhoA L^2), the larger of the two bending axes */
    double tip_force;      /* |F| L^2/EI, largest over time */
    double tip_moment;     /* |T| L/EI, largest over time */
    double compression;    /* F L^2/EI of a dead load at one end against the tangent of the other,
                              clamped one, largest over time; Euler's load is pi^2/4 */
    double distributed_force;  /* |f| L^3/EI, largest over s and t */
    double distributed_moment; /* |l| L^2/EI, largest over s and t */
    double foundation;         /* k L^4/EI, largest over s */
    double weight;             /* rhoA |g| L^3/EI, less buoyancy */
    double point_force; /* of point loads and the weight of bodies, |F| L^2/EI, largest over time */
    double point_moment; /* of point loads, |T| L/EI, all of them and largest over time */
    double actuation;    /* of actuators, tension times offset: as of a moment, T L/EI */
    double tubes;        /* rest curvature times length, their sum: what they may turn the rod by */
    double strain_damping;    /* largest Bse L^2/(EI time) */
    double curvature_damping; /* damping ratio of the first bending mode by Bbt: B w1/(2 EI) */
    double duration;          /* in scales.time; 0: static */
    double periods;           /* duration over 2 pi/3.516 time units: first bending periods */
} rod_numbers;

rod_numbers rod_numbers_of(const scene *scene);

/* The physical terms of the equations and whether this scene has them. */
typedef struct rod_term {
    const char *name;
    bool present;
    const char *reason; /* why it is left out, a few words; NULL when present */
    /* Of a term that resists the motion, else NULL and 0. */
    const char *key;     /* dotted YAML key */
    const char *formula; /* of the damping, with w1 the frequency of the first bending mode */
    double damping;      /* damping ratio of that mode; 0 when the term is left out */
} rod_term;

enum { ROD_TERM_MAX = 64 };

/* The angular frequency of the first bending mode of the cantilever, 1/s, in motion. */
double rod_first_frequency(const scene *scene);

/* The row of linear drag, of rods and beams. */
rod_term rod_drag_term(const scene *scene);

/* Fill terms [ROD_TERM_MAX], return how many; static texts. */
int rod_terms(const scene *scene, rod_term *terms);

/* Motion in a plane. Where the scene is its own mirror image in a plane to which a director d1 or
 * d2 is normal, only what lies in that plane is unknown and only its equations are solved. Vectors
 * have 2 rows, axial vectors (moment, curvature, spin) 1, and the rotation is about the normal. The
 * decision looks at what the scene says, not at solutions: a formula across the plane that happens
 * to be 0 leaves it. A planar solution need not be the stable one: a column may buckle sideways. */
typedef struct rod_plane {
    bool is_planar;
    const char *leaves; /* spatial: the YAML key that leaves the plane, or decides; static text */
    int director;       /* 0 or 1: d1 or d2 stays along the normal */
    double normal[3];   /* world, unit */
    double height;      /* of the plane along the normal, m */
    double axes[3][3];  /* columns: axes of the plane's frame in the world; axis `director` is the
                           normal */
} rod_plane;

rod_plane rod_plane_of(const scene *scene);

/* Whether loads and ends of a rod at rest have an energy that its shape tells, in a plane or in
 * space. What follows the rod has none, nor have moments in space. A shape does not tell the
 * tension of a tendon whose displacement is given, or that rubs. */
bool rod_has_energy(const scene *rod_scene, bool planar);

/* Whether the quaternion of the end s = length may as well mean another turn than the shorter one
 * that it is taken for. It is then half a turn or so, or a quaternion written for the longer way.
 * turn: that shorter one from where the unstressed rod ends, a rotation vector in the world's axes.
 * Of rods at rest with both rotations held; of others false. */
bool rod_turn_is_doubtful(const scene *scene, double turn[3]);

/* Whether the numbers of the scene are within reach, and the motion that it asks for is possible.
 * Held ends also have to agree with the initial state in value and velocity where both are hard;
 * else the ansatz would shift the whole initial state. AD_BAD_INPUT: `key` (may be NULL) receives
 * the dotted YAML key, static text. Also finds what only shows when a scene is recorded. */
ad_status rod_check(const scene *scene, const char **key, ad_error *error);

/* ---- network and state --------------------------------------------------------------------- */

/* r[3], rotation, N[3], m[3], tendons, tubes; displacement form: r, rotation; pose_strain: r,
 * rotation, v[3], u[3]. Planar, in the
 * plane's frame without the rows that vanish: r[2], rotation, N[2], m[1]. */
int rod_network_outputs(const scene *scene);

/* How the network's numbers for the rotation become one. */
typedef struct rod_head {
    const char *name; /* "q[4] quaternion" */
    int outputs;
    bool counts_on; /* they turn the rod on from the lift, by so much; else they are added to it */
} rod_head;

/* A quaternion or a rotation vector as the scene says; planar an angle. */
const rod_head *rod_head_of(const scene *scene);

/* The coordinates of a scene: s, and t in motion, with the scene's windows; of a family its
 * parameters follow. */
domain rod_domain_of(const scene *scene);

/* A place at s and t (in a static scene not read) in the first window, under all of the loads. */
domain_place rod_place(const scene *scene, ad_value s, ad_value t);

/* Binds the parameters of a family to their coordinates, in SI, and unknowns to those of the place;
 * returns how many they are. */
int rod_bind(const scene *rod_scene, const domain *d, const domain_place *at,
             quantity_binding *bindings);

/* ---- windows of time ----
 * scene->windows equal parts of the duration, each with a network of its own. A window starts from
 * the state in which the one before ends: position, rotation, velocity and spin along the rod
 * (physics/learn/window_state.h). N and m are not state, and meet as far as both windows are
 * solved. Time is that of the scene throughout. */
enum { ROD_STATE_ROWS = 13 };

int rod_state_rows(const scene *scene); /* ROD_STATE_ROWS in motion, else 0 */

/* Of a planar scene: in the plane's frame in place of the world, with constant zeros. */
typedef struct rod_state {
    ad_value position; /* r [3], world */
    ad_value rotation; /* q [4], unit */
    ad_value force;    /* N [3], world */
    ad_value moment;   /* m [3], body */
    ad_value tendons;  /* of each tendon in turn what tau_0 and l are made of where its length is
                        * given, and phi with friction; only where the scene has such */
    ad_value tubes;    /* [2 tube_count] theta, m_i of each; without tubes nothing */
    ad_value strains;  /* [6] v, u as unknowns of their own, form pose_strain alone */
} rod_state;

/* From the raw outputs of the network of the place's window to a state: field = lift + blend
 * network, q normalised.
 *
 * Hard boundary conditions: the lift meets the data of the ends, the blend vanishes there: s,
 * 1-s, s(1-s) or 1, per field by what the ends give. Hard initial conditions: the lift of r and q
 * starts as the initial state with its velocity, and the blend carries (t/duration)^2.
 * In later windows t counts from the start of the window, over its length, and r_i, v_i, q_i, w_i
 * are the state there; what polynomials of low degree in s miss of it fades away. The prescribed
 * motion of an end must agree with the initial state in value and velocity; where it does not, the
 * end wins. Of q and -q that an end may be given, the nearer one at t = 0 counts.
 *   r = r_i + t v_i + sum over held ends of weight (r_end(t) - r_i(end) - t v_i(end)) + blend net
 *   q = normalise(the same with q_i exp(t w_i)); by rotation vectors normalise(the same without
 *       net) exp(blend net); in a plane angles a about the normal n are added up in place of
 *       quaternions: q = q_i exp(t w_i) exp(a n), a = sum of weight a_end(t) + blend net,
 *       a_end within (-2 pi, 2 pi], at t = 0 within (-pi, pi]; exp(x) the rotation by |x| about x
 *   N = F or R(q) F_body, m = R(q)^T T or T_body, + blend load_scale net; at s = 0 the outside
 *       pulls the other way: N = -F, m = -T.
 * Soft: undeformed shape (or initial state) + network, the conditions are residuals.
 * Static scenes use the undeformed shape, from the held end on, in place of the initial state.
 *
 * Form pose_strain (as Bensch et al., ICRA 2024, have it): v and u are outputs, too,
 * v = v* + Kse^-1 load_scale net, and so u. N and m follow from them by the constitutive law. That
 * they are the strains of r and q, R^T r_s = v and 2 vec(q* q_s) = u, are the residuals ROD_STRAIN
 * and ROD_CURVATURE. Displacement form: N and m follow from r and q by that law. In both, ends that
 * give force or moment stay residuals (ROD_START, ROD_END) whatever the enforcement. */
rod_state rod_ansatz(const scene *scene, const domain_place *at, ad_value outputs);

/* The state in motion at the time of the place, functions of s: r, q, r_t, w, one row each
 * [ROD_STATE_ROWS]. */
void rod_moving_state(const scene *scene, const domain_place *at, rod_state state, ad_value *rows);

/* Degree of the polynomials of s in which a state [WINDOW_STATE_POINTS][ROD_STATE_ROWS] goes on. */
int rod_going_degree(const scene *scene, const double *state);

/* ---- residuals ----------------------------------------------------------------------------- */

/* Rows of a spatial scene. */
#define ROD_RESIDUAL_LIST(X)                                                                       \
    X(ROD_STRAIN, "strain")       /* v - v* - Kse^-1 (R^T N - Bse v_t - actuation), 3 rows,        \
                                     mixed */                                                      \
    X(ROD_CURVATURE, "curvature") /* u - u* - Kbt^-1 (m - Bbt u_t - actuation), 3 rows, mixed */   \
    X(ROD_FORCE, "force")         /* balance of force, world, 3 rows */                            \
    X(ROD_MOMENT, "moment")       /* balance of moment, body, 3 rows; mixed: about d3              \
                                     times EI/GJ, where that is > 1 */                             \
    X(ROD_TENDON, "tendons")      /* tau_0s, l_s - |p'| + |p'| unstressed where a length is given, \
                                     phi_s - |t_s| with friction; mixed */                         \
    X(ROD_TWIST, "twist")         /* theta_i' + u_3 - k_3 - m_i/G_i of tubes; theta_i' beyond */   \
    X(ROD_TORSION, "torsion")     /* balance of m_i of tubes, 1 row each as above */               \
    X(ROD_START, "start")         /* conditions at s = 0 that the ansatz does not enforce */       \
    X(ROD_END, "end")             /* the same at s = 1 */                                          \
    X(ROD_INITIAL, "initial")     /* r, 2 vec(q_i* q), r_t, w at t = 0, 12 rows, soft */

#define ROD_ENUM(name, text) name,
typedef enum rod_residual_kind { ROD_RESIDUAL_LIST(ROD_ENUM) ROD_RESIDUAL_COUNT } rod_residual_kind;
#undef ROD_ENUM

/* "strain", ...; static. */
const char *rod_residual_name(rod_residual_kind kind);

/* Rows of a residual in this scene; 0: the scene has none of this kind. Planar: of 3 rows the 2 in
 * the plane, of strain, force, position and velocity; the 1 along the normal, of the others. */
int rod_residual_rows(const scene *scene, rod_residual_kind kind);

/* Dimensionless, of order one, unweighted: [rod_residual_rows] rows. The points of the place are
 * the caller's: s = 0 for ROD_START, s = 1 for ROD_END, t = 0 for ROD_INITIAL. Asking for a kind
 * that the scene does not have is an error on the tape. */
ad_value rod_residual(const scene *scene, rod_residual_kind kind, rod_state state,
                      const domain_place *at);

/* What the squared norm of each residual counts for in a loss. */
typedef struct rod_weights {
    double strain, curvature; /* of the mixed form */
    double force, moment;     /* of the balances */
    double boundary, initial; /* of conditions at ends and at t = 0, where they are residuals */
} rod_weights;

rod_weights rod_weights_default(void);
double rod_weight_of(const rod_weights *weights, rod_residual_kind kind);

/* ---- manufactured solutions ---------------------------------------------------------------- */

/* The exact state; N and m from the constitutive law (finite stiffness). The residuals of a
 * manufactured scene take ends and initial state from it, and rod_manufactured_load as the
 * distributed load. */
rod_state rod_manufactured(const scene *scene, ad_value s, ad_value t);

typedef struct rod_load {
    ad_value force;  /* f [3], world, by EI/length^3 */
    ad_value moment; /* l [3], world, by EI/length^2 */
} rod_load;

/* What must be added to gravity, drag and the scene's own distributed loads. */
rod_load rod_manufactured_load(const scene *scene, ad_value s, ad_value t);

/* ---- observables --------------------------------------------------------------------------- */

/* In SI units. */
typedef struct rod_observables {
    ad_value position;         /* [3] m, world */
    ad_value rotation;         /* [4] */
    ad_value strain;           /* v [3] */
    ad_value curvature;        /* u [3] 1/m */
    ad_value force;            /* n [3] N, body; with actuators */
    ad_value moment;           /* m [3] N m, body; the same */
    ad_value velocity;         /* r_t [3] m/s, world; zeros in a static scene */
    ad_value angular_velocity; /* w [3] 1/s, body; zeros in a static scene */
    ad_value tubes;            /* [2 tube_count] theta, m_i, dimensionless */
} rod_observables;

rod_observables rod_observe(const scene *scene, rod_state state, const domain_place *at);

#ifdef __cplusplus
}
#endif

#endif
