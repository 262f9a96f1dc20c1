/* What the files of the reduced rod share; not for others. */
#ifndef PHYSICS_CHAIN_MODES_INTERNAL_H
#define PHYSICS_CHAIN_MODES_INTERNAL_H

#include "autodiff/memory.h"
#include "physics/chain/kinematics.h"
#include "physics/chain/modes.h"
#include "physics/local/inertia.h"
#include "physics/local/rod_model.h"
#include "physics/numerics/gauss.h"
#include "physics/numerics/processor.h"
#include "physics/numerics/quaternion.h"

#include <stdint.h>

/* Of strains, stresses and their modes: v and then u, body frame. */
enum { MODES_V = 0, MODES_U = 3, MODES_STRAINS = 6 };

/* Columns of matrices in fours: rows of matrices are padded with zeros to them. */
enum { QUAD = 4 };
typedef double quad
    __attribute__((vector_size(QUAD * sizeof(double)), aligned(sizeof(double)), may_alias));

/* A point of the rod: a Gauss point of an element, or its end, where the weight is 0 and only what
 * acts at single places counts. All that is spread along the rod is times the weight, so that a
 * point has forces and masses, not densities. */
typedef struct modes_point {
    double s, weight;
    /* given; strains as MODES_STRAINS */
    double stiffness[MODES_STRAINS], damping[MODES_STRAINS];
    double branch[MODES_STRAINS], relaxing; /* of a Maxwell branch: its spring, one over its time */
    double origin[MODES_STRAINS];           /* strain of modes that are all 0 */
    double rest[MODES_STRAINS], rest_rate[MODES_STRAINS];
    inertia inertia;
    double dead[6]; /* force and moment of dead loads */

    /* found, by modes_shape; world but for strains and stress */
    double q[4], R[3][3], r[3];
    double spin[3], velocity[3], spin_rate[3], acceleration[3];
    double strain[MODES_STRAINS], rate[MODES_STRAINS], second[MODES_STRAINS];
    double stretch[MODES_STRAINS];                   /* of that spring */
    double along[3], along_rate[3], along_second[3]; /* R v, R v_t, R v_tt */
    double turned_rate[3], turned_second[3];         /* R u_t, R u_tt */
    double turning[3];                               /* w x R v */

    /* of a rod that is fed (modes_feed.c), where s moves along it */
    double carry, carry_rate; /* s_t of what is there, and its s_tt */
    double along_slope[3], curve_rate[3], curve[3], curve_slope[3]; /* R v_s, R u_t, R u, R u_s */
    double own_spin[3], own_velocity[3], own_spin_rate[3], own_acceleration[3];
    double own_rate[MODES_STRAINS]; /* of the strain of what is there */
    bool is_carried;                /* these hold for it; false: it stays at its s */

    /* found, by modes_forces */
    double force[3], moment[3];   /* that act here, inertia among them */
    double carried[2][3];         /* times what each changes of R v and R u here: their work */
    double pull[MODES_STRAINS];   /* of actuators, a part of the stress */
    double law[MODES_STRAINS];    /* the same of a law, beyond the stiffness; */
    double law_energy;            /* per length */
    double stress[MODES_STRAINS]; /* n, m, body; not times the weight */
} modes_point;

/* As laws of motion see it. */
static inline inertia_motion modes_section(const modes_point *at)
{
    if (at->is_carried) {
        return (inertia_motion){(const double(*)[3])at->R, at->own_velocity, at->own_spin,
                                at->own_acceleration, at->own_spin_rate};
    }
    return (inertia_motion){(const double(*)[3])at->R, at->velocity, at->spin, at->acceleration,
                            at->spin_rate};
}

/* Steps from point to point of an element, in whole vectors of lanes. */
enum { MODES_STEPS = 16 };
_Static_assert(GAUSS_STAGES_MAX + 1 <= MODES_STEPS && MODES_STEPS % LANES == 0, "whole vectors");

/* Rows [width] of work at each point, and of an element. */
enum { MODES_ROWS = 12, MODES_ROOM = 600 };

/* A mode: Legendre's polynomial of this degree, of one strain, on one piece of the rod. */
typedef struct modes_mode {
    int strain, degree, first_element, last_element;
} modes_mode;

static inline const double *modes_strain_rate(const modes_point *at)
{
    return at->is_carried ? at->own_rate : at->rate;
}

static inline void strain_beyond_rest(const modes_point *at, double off[MODES_STRAINS])
{
    for (int c = 0; c < MODES_STRAINS; c++) {
        off[c] = at->strain[c] - at->rest[c];
    }
}

/* A tendon with friction at a point: |p'| by the strains, and what is integrated along it. At an
 * element's end `fall`, `by` and `speed` are of the kink there. */
typedef struct modes_rub {
    double along[MODES_STRAINS], bend[LAW_STIFFNESS];
    double rate, longer; /* of the length, per length, and from its beginning to here */
    double speed;        /* past its guide, towards its beginning */
    double fall, fallen; /* of log T, per length, and from its beginning to here */
    double by[4];        /* `fall` by the turning of the tangent, and by the speed */
} modes_rub;

/* The same on the way of Newton's method: the speed where it was, and the share of Coulomb's
 * friction that it takes there. */
typedef struct modes_dual {
    double speed, share;
} modes_dual;

typedef struct modes_element {
    int own, end; /* modes own .. end - 1 are its own; those from 0 on move its points */
    int width;    /* end, padded */
    double length;
    double matrix[GAUSS_STAGES_MAX + 1][GAUSS_STAGES_MAX]; /* integrals from its start to its
                                                            * points and to its end */
} modes_element;

struct modes {
    solve_rod *rod;
    modes_counts counts;
    int size, width; /* modes and reactions of a held end; padded to fours */
    int pieces;
    int hinges; /* the first so many elements: of no extent and no mass, each turns about an axis */
    double upright[4];            /* with hinges: rotation at s = 0 of modes that are all 0 */
    int elements, stages, points; /* points: elements (stages + 1) */
    int inputs;
    double time;
    double *input, *inputs_at; /* [inputs], [points][inputs] */
    double *input_step;        /* [inputs] for difference quotients */
    double *rate;              /* [2][inputs] by t, that ends follow; 0 but for modes_move */
    bool has_moved;            /* these, since ends were taken */
    bool rest_moves;           /* the rest shape, by t or by inputs that may move; */
    bool origin_moves;         /* of points, with inputs that do not */
    uint64_t unasked;          /* inputs by which derivatives are not wanted: 0 in their place */
    struct modes_affine {      /* values [count]: base + sum_k slope_k (input_k - center_k) */
        size_t count;
        double *base, *slope; /* [count], [inputs][count]; NULL: not known to be of this form */
        size_t *of, *changes; /* [inputs][count] which values an input changes; [inputs] how many */
    } affine[SOLVE_PARTS];
    double *center; /* [inputs] */
    bool has_given, is_pulled, is_locked;
    bool is_coupled;                                 /* the stress of a strain depends on others */
    bool inertia_couples;                            /* added mass, or a body beside the axis */
    double magnus[3][GAUSS_STAGES_MAX][MODES_STEPS]; /* of the steps from point to point, padded */
    gauss_rule rule;

    modes_mode *mode;       /* [size] */
    modes_element *element; /* [elements] */
    modes_point *point;     /* [points] */
    double *value;          /* [points][width] of each mode, 0 at ends of elements */
    double *s;              /* [points] */
    int *jump_at;           /* [jumps.count] point, -1: at s = 0 */
    int *turn_at;           /* [elements] jump of a joint at its end; -1: none */
    double *along;          /* [points][numbers of what acts along the rod] */
    solve_end_state start;
    solve_actuator *actuators;        /* [points][actuators] */
    double (*pull_by)[LAW_STIFFNESS]; /* [points] derivatives of pull and law by the strain
                                       * (law_entry), where they were asked for */
    double (*guides)[4]; /* [points][actuators] offset and slope for which lengths were taken */
    double unstressed[SOLVE_ACTUATORS_MAX]; /* lengths of tendons that are given theirs, at rest */
    double tension[SOLVE_ACTUATORS_MAX];    /* of tendons whose length is given, 0 of others; */
    double tight[SOLVE_ACTUATORS_MAX];      /* what that grows by with the length, 0 where slack, */
    double *longer;                         /* [actuators][width] and the length with each mode, */
                                            /* where derivatives were asked for */
    struct modes_friction {                 /* of tendons (modes_friction.c) */
        modes_rub *rub;                     /* [frictions][points] */
        modes_dual *dual;                   /* [frictions][points]; NULL: none is asked for */
        double *left;                       /* [points][actuators] of a pull; NULL: no friction */
        double slope[GAUSS_STAGES_MAX][GAUSS_STAGES_MAX], edge[2][GAUSS_STAGES_MAX]; /* of rule */
    } friction;
    double base[2][3]; /* force and moment by which the rod is held at s = 0, world */

    /* rows [width] of matrices, of a change of each mode */
    double *theta, *rho; /* [points][3]: turn, displacement */
    struct modes_feed {
        int mode;    /* of the state: growth of what is out of the port, less 1; -1: none is fed */
        int input;   /* that it follows; -1: a given function of t */
        double to;   /* s up to which the rod grows */
        double lag;  /* feed_time */
        double from; /* the input where the growth is 1; and by how much that is more where the */
        double unit; /* mode is 1 */
        double command, out; /* the input as it is given, and what formulas are given */
        double now[3];       /* the mode and its rates by t as they are; of the last */
        double second;       /* what the state has of it */
        double wanted[3];    /* the same of a given function of t */
        double *slope;       /* [points][width] of `value` along s */
        double *trial;       /* [4][size] */
        double *q;           /* [size] as they are */
    } feed;
    struct modes_turn {
        int mode, input; /* a hinge about d3, and what it follows; -1: the base is not turned */
        double lag;      /* turn_time */
        double command;  /* the input as it is given */
        double now[3];   /* the angle and its rates */
        double moment;   /* by which the drive turns */
    } turn;
    struct modes_branch {         /* of Maxwell (modes_branch.c) */
        int count, *mode;         /* [count] modes that stretch a spring; 0: there is none */
        double *stretch;          /* [size] of the springs, as modes_stretch took it, */
        double *rate, *rest_rate; /* [size] one over its time, and what the rest shape adds */
        double *by;               /* [width] rows: the residual by the stretch */
    } branch;
    struct modes_end {     /* held at s = 1 (modes_end.c) */
        int directions;    /* that the end holds; 0: none */
        int first, count;  /* reactions stand behind so many modes; how many of them */
        double hold[6][6]; /* [count] their directions, unit: force and moment, world */
        solve_end_state given;
        double spin[3], spin_rate[3]; /* of that, world */
        double reaction[6];           /* force and moment on the rod, world */
        double freedom; /* of modes_end_hold: one over the mass that resists a force in the worst
                         * direction; 0: nothing gives way there */
        double *faster; /* [6][width] velocity and spin of the tip by the modes */
        double *room;   /* [12][size] */
        int *free;      /* [size] */
    } end;
    double *mass; /* [width]; by modes_linearise with what reactions do to the modes */
    double *room; /* work of modes_matrix.c */
    ad_memory memory;
};

/* Where the rod is and how it moves with modes q, rates v and accelerations a [size] (NULL: 0).
 * Reactions of a held end are entries of a alone: those of q and v are never read. */
void modes_shape(modes *m, const double *q, const double *v, const double *a);

/* Of that shape: forces, and the residual [size] of the equations of motion,
 * M a + ... - loads. derive: pull_by, too. */
void modes_forces(modes *m, bool derive, double *residual);

/* Takes the lengths of tendons that are given theirs in the unstressed rod. */
void modes_unstressed_lengths(modes *m);

/* Of that shape: theta, rho and the mass matrix [size rows of width], which is symmetric. */
void modes_mass(modes *m);

/* After modes_forces (derive) and modes_mass: derivatives of the residual by q and v [size rows of
 * width]. */
void modes_derivatives(modes *m, double *by_q, double *by_v);

/* All of that of a state: the residual [size], its derivatives, and the mass. a [size] or NULL. */
void modes_linearise(modes *m, const double *q, const double *v, const double *a, double *residual,
                     double *by_q, double *by_v);

/* A rod and its modes (modes.h), with the parameters of a family as inputs and their ranges; it is
 * measured by the member in their middle. follows: a held end may depend on them, as whoever steps
 * says how fast they are, or they stay as they are. staying: a bit for each parameter that does so
 * while anything moves. Both results are to be freed, also after errors; AD_BAD_ARGUMENT: a
 * parameter that modes do not take as an input. */
ad_status modes_create_open(const scene *family, bool follows, uint64_t staying,
                            const modes_counts *counts, int finer, solve_rod **rod, modes **result,
                            ad_error *error);

/* Ranges of the inputs: parts that are affine in them everywhere, as far as samples tell, and do
 * not depend on t are taken as sums from now on. AD_NO_MEMORY, errors of formulas. */
ad_status modes_set_ranges(modes *m, const double *low, const double *high, ad_error *error);

/* Derivatives [size][inputs] of the residual of a state by the inputs, which stay as they are. */
ad_status modes_by_inputs(modes *m, double t, const double *q, const double *v, const double *a,
                          double *by_inputs, ad_error *error);

/* L of a positive definite matrix [n rows of width], of which the lower triangle counts, in place;
 * false: it is not. x [n]: the right side, then the solution, of a matrix that is factored. */
bool modes_factor(int n, int width, double *A);
void modes_back(int n, int width, const double *L, double *x);

/* The same x [size] of a matrix [size rows of width]. */
void modes_solve_factored(const modes *m, const double *matrix, double *x);

/* What a turn of 1 rad counts for in least squares beside a displacement of the length. */
static const double MODES_TURN = 0.09;

/* The accelerations a [size] of a state at the present time, with reactions; false: the mass is not
 * positive, or modes do not move the end where it is held. */
bool modes_accelerations(modes *m, const double *q, const double *v, double *a);
ad_status modes_accelerations_fail(const modes *m, ad_error *error); /* AD_NOT_FINITE */

/* A state and the motion near it: [size] and [size][width] each; a: 0 but for reactions. */
typedef struct modes_linear {
    double *q, *v, *a, *residual, *by_q, *by_v, *factor;
    int *pivots; /* [size] */
} modes_linear;

/* factor [size][size], column-major: of by_q and what reactions do. */
void modes_stiffness(const modes *m, const double *by_q, double *factor);

/* The equilibrium at the present time and inputs, by Newton's method from q; v becomes 0, the rest
 * is what its last step came from. AD_NOT_FINITE: none is found. */
ad_status modes_settle(modes *m, const modes_linear *linear, ad_error *error);

/* The start from the equilibrium of the inputs [inputs], with the velocities of the scene and of
 * ends that follow inputs with `rates` as modes_move has them, where its initial.settled is that of
 * other inputs: followed from there. AD_NOT_FINITE: there is none, or it is not stable on the way;
 * AD_NO_MEMORY, errors of formulas. */
ad_status modes_initial_settled(modes *m, const double *settled_at, const double *inputs,
                                const double *rates, const modes_linear *linear, ad_error *error);

/* Of modes_create_open the start of a member, linear->q and linear->v, with rates as modes_move has
 * them. An equilibrium is followed from that of the middle. Errors of modes_initial and of these.
 */
ad_status modes_begin_open(modes *m, const scene *family, const double *inputs, const double *rates,
                           const modes_linear *linear, ad_error *error);

/* q [size] nearest to strains [points][MODES_STRAINS]; hinges stay upright. */
void modes_project(const modes *m, const double (*strains)[MODES_STRAINS], double *q);

/* Where to look at a rod: s [n] within [0, 1]. AD_NO_MEMORY. */
typedef struct modes_place {
    int element, before; /* the last of its points before the place; -1: none */
    double length, values[GAUSS_STAGES_MAX], integrals[GAUSS_STAGES_MAX]; /* by points */
    double magnus[3][GAUSS_STAGES_MAX];
} modes_place;

typedef struct modes_places {
    size_t count;
    modes_place at[];
} modes_places;

ad_status modes_places_create(const modes *m, size_t n, const double *s, modes_places **result,
                              ad_error *error);
void modes_places_free(modes_places *places);

/* out [n]: of the shape and the forces as they are. Force and moment are those that balance what
 * lies beyond. */
void modes_samples(const modes *m, const modes_places *places, solve_state *out);

/* The same of a state: q, q_t, stretches of Maxwell branches [3][size], with the accelerations that
 * it has; room [2][size]. AD_NOT_FINITE: it has none. */
ad_status modes_see(modes *m, const double *state, double *room, const modes_places *places,
                    solve_state *out, ad_error *error);

/* Kinematics of places with the wanted rows [rows] of derivatives; the start, and strains of modes
 * that are all 0, are those of the present time and inputs, and by modes_kinematics_start of those
 * it is called with. AD_NO_MEMORY: x is all 0. */
ad_status modes_kinematics_create(const modes *m, modes_places *places, int rows, const int *row,
                                  kinematics *kinematics, ad_error *error);
void modes_kinematics_free(kinematics *kinematics);
void modes_kinematics_start(const modes *m, const modes_places *places, kinematics *kinematics);

/* The modes and rates [size] that come nearest to what is seen along the rod [count], in SI units.
 */
ad_status modes_fit_seen(modes *m, size_t count, const solve_seen *seen, double *q, double *v,
                         ad_error *error);

/* Time and inputs (NULL: as they are), for all that follows; AD_NOT_FINITE. Inputs are those of
 * formulas in the second, where modes_at gives the command of what is fed. */
ad_status modes_at(modes *m, double t, const double *inputs, ad_error *error);
ad_status modes_give(modes *m, double t, const double *inputs, ad_error *error);

/* First and second derivatives [2][inputs] of the inputs by t (NULL: they stay), for all calls of
 * these that follow: by them ends move that depend on inputs. */
void modes_move(modes *m, const double *rates);

/* inputs [inputs] as modes_at was given them. */
void modes_commands(const modes *m, double *inputs);

/* ---- drives ---- */

/* How far a, with its rates now [3], is from following a command: T^2 a_tt + 2 T a_t + a = u, over
 * T^2. */
static inline double modes_drive_residual(double lag, const double now[3], double command)
{
    return now[2] + 2 / lag * now[1] + (now[0] - command) / (lag * lag);
}

/* ---- a base that is turned (modes_turn.c) ---- */

/* Which input turns it, of a scene that says so. AD_BAD_ARGUMENT: none, or what is not taken. */
ad_status modes_turn_find(modes *m, const solve_parameters *open, ad_error *error);

/* The angle as it is; the residual of the mode; its rows of the derivatives and the mass. */
void modes_turn_take(modes *m, const double *q, const double *v, const double *a);
double modes_turn_residual(const modes *m);
void modes_turn_derivatives(modes *m, double *by_q, double *by_v);

/* ---- an end that is held (modes_end.c) ---- */

/* In how many directions, of 6, the end of a rod is held. */
int modes_end_directions(const solve_rod *rod);

/* Which of them modes move: their reactions. AD_BAD_INPUT: more than there are modes. */
ad_status modes_end_find(modes *m, ad_error *error);

/* What follows from the prescribed state as it was given. */
void modes_end_given(modes *m);

/* The reactions of a [size] (NULL: 0); adds them to what acts at the tip. */
void modes_end_react(modes *m, const double *a);
void modes_end_push(modes *m);

/* Of the shape as it is: by how much it is off what is held, the largest, over the length or in
 * rad; the residual of the reactions, and what they are in derivatives and the mass; the power of
 * what moves the end. modes_end_keep before: what modes change spin and velocity of the tip by,
 * rates held, rows [3] each. */
double modes_end_off(const modes *m);
double modes_end_off_at(const modes *m, const double r[3], const double q[4]);
void modes_end_keep(modes *m, const double *spin, const double *velocity);
void modes_end_residual(const modes *m, double *residual);
void modes_end_derivatives(modes *m, double *by_q, double *by_v);
double modes_end_power(const modes *m);

/* AD_NOT_FINITE, where modes_end_hold is false. */
ad_status modes_end_fail(ad_error *error);

/* What is missing of the prescribed pose (derivative 0), velocity (1) or acceleration (2). */
void modes_end_missing(const modes *m, int derivative, double missing[6]);

/* Adds to x [size] M^-1 G^T reaction [count] (NULL: not wanted), so that G x is what is missing:
 * M by its factor [size rows of width], G of theta and rho. false: G has not full rank. */
bool modes_end_hold(modes *m, const double *factor, const double missing[6], double *x,
                    double *reaction);

/* Of the shape as it is, with G of full rank: matrices [size rows of width], `count` of them,
 * become those of motions that leave the end where it is, in their first rows and columns. How many
 * these motions are: all modes where nothing is held. */
int modes_end_free(modes *m, int count, double *const *matrices);

/* ---- friction of tendons (modes_friction.c) ---- */

/* Of the shape and the tensions as they are: what is left of pulls; derive: and what follows needs.
 */
void modes_friction_find(modes *m, bool derive);

/* Adds what derivatives of the residual have by it, also of tensions by lengths. */
void modes_friction_derivatives(modes *m, double *by_q, double *by_v);

/* The power of drives beyond what tendons do to the rod, and what friction takes of it. */
void modes_friction_power(const modes *m, double *load, double *dissipation);

/* ---- a Maxwell branch (modes_branch.c) ---- */

bool modes_branch_any(const solve_section *section);

/* Whether the i-th mode with a branch is of the piece of the one before, where all relax alike. */
bool modes_branch_as_before(const modes *m, int i);

/* Takes what the sections [points] say. AD_BAD_INPUT: a time that varies along a piece. */
ad_status modes_branch_give(modes *m, const solve_section *made, ad_error *error);
void modes_branch_rest(modes *m);

/* The stretch d [size] of springs for all that follows; NULL: 0. Of other modes it is not read. */
void modes_stretch(modes *m, const double *d);

/* Of the shape as it is: branch.by. */
void modes_branch_derivatives(modes *m);

/* [inputs][size] derivatives of branch.rate and branch.rest_rate by the inputs as they are. */
ad_status modes_branch_by_inputs(modes *m, double t, double *rate_by, double *rest_by,
                                 ad_error *error);

/* ---- what is fed through a port (modes_feed.c) ---- */

/* Modes that drives move, which no other mode does: -1 where there is none. */
enum { MODES_DRIVES = 2 };
static inline int modes_driven(const modes *m, int drive)
{
    return drive == 0 ? m->feed.mode : m->turn.mode;
}

/* Which mode it is, and where, of a scene that says so; AD_BAD_ARGUMENT: what is not taken beside.
 */
ad_status modes_feed_create(modes *m, ad_error *error);

/* The formulas where so much is out as the mode says; not numbers where that is nothing. */
void modes_feed_give(modes *m, const double *q, const double *v, const double *a);

/* Motion of what is at the points of an element; the residual of the mode; what the mode changes of
 * residual, derivatives and mass. */
void modes_feed_carry(modes *m, int e, const double *q);
double modes_feed_residual(const modes *m);
void modes_feed_derivatives(modes *m, const double *q, const double *v, const double *a,
                            double *by_q, double *by_v);

/* The power by which the port feeds, beyond what holds the rod there. */
double modes_feed_power(const modes *m);

/* Of the shape and forces as they are. */
solve_energy modes_energy_now(const modes *m); /* kinetic and strain alone */
void modes_power_now(const modes *m, double *load, double *dissipation);

#endif
