/* What one window of time hands to the next: the state in which it ends, as polynomials of s
 * through its values at Chebyshev's points, the ends of the rod among them. They meet fields of up
 * to some ten waves along the rod to rounding.
 *
 * A state is [2][pieces][members][WINDOW_STATE_POINTS][rows of the model], coefficients of T_k(x),
 * x from -1 to 1 over each piece of s, and of a family those of its parameters' polynomials: all of
 * it, and the part of it that goes on through the window, polynomials of low degree
 * (physics/learn/rod_ansatz.c says why). */
#ifndef PHYSICS_LEARN_WINDOW_STATE_H
#define PHYSICS_LEARN_WINDOW_STATE_H

#include "nn/nn.h"
#include "physics/learn/model.h"

enum { WINDOW_STATE_DEGREE = 48, WINDOW_STATE_POINTS = WINDOW_STATE_DEGREE + 1 };

/* Parameters of a family of motions by windows at most: its states are polynomials of them, too,
 * through the members at their Chebyshev points. */
enum { WINDOW_STATE_PARAMETERS_MAX = 2, WINDOW_STATE_MEMBERS_MAX = 49 };

/* Numbers of a state; 0 for a model that hands on nothing. */
size_t window_state_numbers(const physics_model *m);

/* On the tape: the rows [state_rows] of the state that the place's window starts from, as functions
 * of s; all of it, or the part that goes on. */
ad_value window_state_state(const domain_place *at, int rows, bool going);

/* Carries states over windows: at most two programs are compiled, for the first window and for all
 * later ones, each when it is first needed. */
typedef struct window_state window_state;

/* Borrows all three, which must outlive it. AD_NO_MEMORY. */
ad_status window_state_create(const physics_model *m, const nn_mlp *mlp, ad_pool *pool,
                              window_state **result, ad_error *error);
void window_state_free(window_state *r);

/* end [window_state_numbers]: the state in which window `index` ends for the parameters x of its
 * network, when it starts from `start` (of the first window it is not read). */
ad_status window_state_run(window_state *r, int index, const double *start, const double *x,
                           double *end, ad_error *error);

/* Largest error, at those points, of polynomials of `degree` through every so many of the values
 * [WINDOW_STATE_POINTS][rows], over the rows first to first + count - 1. */
double window_state_misfit(const double *values, int rows, int first, int count, int degree);

#endif
