/* A reduced rod for filters and controllers: the right-hand side of its motion, steps of time and
 * what is seen of it, each with its derivatives, in SI units, a few microseconds each.
 *
 *   reduced_settings settings = {.modes = {3, 2, 2, 1}, .count = 1, .s = &tip};
 *   reduced_create(&scene, &settings, &rod, &error);
 *   reduced_initial(rod, inputs, state, &error);
 *   reduced_step(rod, t, 0.02, state, inputs, state, NULL, NULL, &error);
 *   reduced_output(rod, t, state, inputs, outputs, NULL, &error);
 *   reduced_free(rod);
 *
 * The scene is one in motion whose `parameters` with ranges are the inputs: pressures, tensions,
 * loads, a stiffness; they are held while a step lasts. The state is first the modes, of a
 * pinned start three angles (rad), of curvature (1/m) and strain, then their rates (by s):
 * physics/chain/modes.h. Where the material has a Maxwell branch, by how much its springs are
 * stretched comes behind them, one number for each mode of a strain there. Nothing is allocated
 * after reduced_create. One rod is for one thread at a time. */
#ifndef PHYSICS_CHAIN_REDUCED_H
#define PHYSICS_CHAIN_REDUCED_H

#include "physics/chain/kinematics.h"
#include "physics/scene/scene.h"

#include <stdint.h>

#ifdef __cplusplus
extern "C" {
#endif

typedef struct reduced_rod reduced_rod;

typedef struct reduced_settings {
    int modes[4];    /* of bending, twist, stretch, shear, each direction and piece of the rod;
                      * all 0: 3, 1, 2, 1 */
    int count;       /* of places that are looked at */
    const double *s; /* [count] m */
    double newton;   /* where Newton's method stops in a step, of modes and rates that have no unit;
                      * 0: 1e-5, the fastest */
    bool follows;    /* an end may depend on inputs: steps are told how fast these are, where they
                      * move (reduced_follow) */
    uint64_t staying; /* inputs that never move, a bit each: a length may depend on them */
} reduced_settings;

/* At one place. The order is that of the rows of derivatives. Of a rod that moves through its port
 * (scene_feed) velocities are those of s, which is the material's from feed.to on, as at the tip.
 */
typedef struct reduced_place {
    double position[3]; /* m, world */
    double rotation[4]; /* unit, body to world; a turn that goes on changes it continuously */
    double velocity[3]; /* m/s, world */
    double angular_velocity[3]; /* 1/s, body */
} reduced_place;

/* The scene passes scene_check and the check of its model. AD_BAD_ARGUMENT: one that modes do not
 * take (physics/scene/support.h); AD_BAD_INPUT: with an input where one number has to stand;
 * AD_NO_MEMORY, errors of formulas. */
ad_status reduced_create(const scene *rod_scene, const reduced_settings *settings,
                         reduced_rod **result, ad_error *error);
void reduced_free(reduced_rod *rod); /* NULL is allowed */

int reduced_modes(const reduced_rod *rod);
int reduced_states(const reduced_rod *rod); /* two for each mode, and those of branches */
int reduced_inputs(const reduced_rod *rod);
const scene_parameter *reduced_input(const reduced_rod *rod, int i); /* name and range */

/* What number k of the state belongs to: Legendre's polynomial of that degree of a strain
 * on one piece of the rod. Strains 0 to 2 are v along d1, d2, d3 and 3 to 5 u about them; -1: a
 * hinge. */
typedef struct reduced_mode {
    int strain, degree, piece;
} reduced_mode;
reduced_mode reduced_mode_of(const reduced_rod *rod, int k);

/* Inputs that ends of the rod depend on, a bit each: they have to be twice differentiable. `before`
 * and `after` [inputs], borrowed until the next call, are their rates, by s, at both ends of the
 * steps that follow; between they go by Hermite's cubics, the others linearly. Functions of one
 * instant take `before`. Derivatives by these inputs are 0 then. NULL: inputs stay, as far as ends
 * are concerned. */
uint64_t reduced_followed(const reduced_rod *rod);
void reduced_follow(reduced_rod *rod, const double *before, const double *after);

/* state [states] with which the scene begins. Where that is an equilibrium, it is followed from the
 * one in the middle of the ranges, scene.initial.settled. And an equilibrium for held inputs, by
 * Newton's method from the state that is given. AD_NOT_FINITE: none is found from there, or the
 * first is not stable. */
ad_status reduced_initial(reduced_rod *rod, const double *inputs, double *state, ad_error *error);
ad_status reduced_settle(reduced_rod *rod, double t, const double *inputs, double *state,
                         ad_error *error);

/* rate [states] = d state/dt; by_state [states][states], by_inputs [states][inputs], row by row:
 * its derivatives, or NULL. AD_BAD_ARGUMENT: the end of the rod is held. */
ad_status reduced_rate(reduced_rod *rod, double t, const double *state, const double *inputs,
                       double *rate, double *by_state, double *by_inputs, ad_error *error);

/* next [states], which may be `state`, a time h later: one step of Radau's method of order 5. The
 * same for the same arguments, whatever came before. by_state, by_inputs (or NULL): derivatives of
 * next, exact ones of the step. AD_NOT_FINITE: Newton's method fails, of steps that are too long.
 */
ad_status reduced_step(reduced_rod *rod, double t, double h, const double *state,
                       const double *inputs, double *next, double *by_state, double *by_inputs,
                       ad_error *error);

/* The same, but the inputs go linearly to those `after` the step (NULL: they are held); by_inputs
 * is of both ends moved together. */
ad_status reduced_step_linear(reduced_rod *rod, double t, double h, const double *state,
                              const double *inputs, const double *after, double *next,
                              double *by_state, double *by_inputs, ad_error *error);

/* Inputs with a memory (physics/scene/scene_memory.h) have states, too: scene.memory_count of them,
 * which a whole state has behind the others. They are inputs of all functions above.
 * reduced_remember writes them from a whole state among inputs, and reduced_begin both among
 * inputs and into the state as they are after inputs had been there for long. */
int reduced_all_states(const reduced_rod *rod);
void reduced_remember(const reduced_rod *rod, const double *state, double *inputs);
void reduced_begin(const reduced_rod *rod, double *inputs, double *state);

/* The same step of whole states, with derivatives by them; of inputs, the places of these states
 * are not read, and by_inputs is 0 there. A play takes inputs that are held for a jump at the
 * beginning. */
ad_status reduced_step_whole(reduced_rod *rod, double t, double h, const double *state,
                             const double *inputs, const double *after, double *next,
                             double *by_state, double *by_inputs, ad_error *error);

/* The same along `count` directions, all states and inputs together at most. change [all states +
 * inputs][count] is how the whole state before the step changes, and inputs at both of its ends;
 * rows of inputs with a memory are not read. Rows of the state become those after it. */
ad_status reduced_step_along(reduced_rod *rod, double t, double h, const double *state,
                             const double *inputs, const double *after, double *next, int count,
                             double *change, ad_error *error);

/* places [count]; by_state (or NULL) [count][12][2 modes]: derivatives by modes and their rates of
 * position, turn (the rotation vector in the world by which the place turns), velocity, and angular
 * velocity in the body frame. */
ad_status reduced_output(reduced_rod *rod, double t, const double *state, const double *inputs,
                         reduced_place *places, double *by_state, ad_error *error);

/* By which places are found, of many states at once, with the start as it was at the last call of
 * reduced_output. Where the start is placed at all times and inputs alike, it is as it always
 * is. */
const kinematics *reduced_kinematics(const reduced_rod *rod);
bool reduced_is_placed(const reduced_rod *rod);

#ifdef __cplusplus
}
#endif

#endif
