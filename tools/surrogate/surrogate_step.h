/* A trained one-step model as numbers, and its evaluation with derivatives: plain C without
 * library but libm, nothing is allocated, equal arguments give equal bits. Exported C contains
 * this very text.
 *
 *   x+ = x1 + A (x - x0) + B (u - u0) + frame^-1 network(frame (x, u))
 *
 * with A, B polynomials of slow inputs, a stiffness. *
 * Coordinates: numbers of the state and inputs, scaled, in classes by how they take a turn of the
 * robot about its axis (pairs turn as a vector across it; the others stay) and the mirror (even
 * ones stay, odd ones change their sign). The frame turns pairs so that a leading one, the bending,
 * points along the first axis, shortened smoothly where there is no bending:
 * g = conj(w) / sqrt(|w|^2 + soft^2). The network knows the mirror: its units come in pairs that
 * the mirror exchanges, of which sums are even and differences odd. Without symmetry all
 * coordinates are even and the network is a plain one. */
#ifndef SURROGATE_STEP_H
#define SURROGATE_STEP_H

#include <stdbool.h>
#include <stddef.h>

enum {
    SURROGATE_LAYERS_MAX = 4,
    SURROGATE_STATES_MAX = 128,
    SURROGATE_INPUTS_MAX = 64,
    SURROGATE_SLOW_MAX = 4
};

/* Numbers of surrogate_step, in their order in memory: name, count. n states, m inputs of a step
 * (with ramps those of its begin, then those of its end), c coordinates of these, blocks = 1 + 2
 * slow_count: the linear map is a polynomial of each slow input k = (u - u0) / half its range, with
 * blocks for 1, k, k^2. */
#define SURROGATE_STEP_NUMBERS(X)                                                                  \
    X(state_center, n) /* x0; below x1 */                                                          \
    X(next_center, n)                                                                              \
    X(input_center, m)             /* u0 */                                                        \
    X(linear, blocks *(n + m) * n) /* [blocks][n + m][n]: A^T, then B^T */                         \
    X(state_scale, n)              /* coordinates are (x - x0) / scale, which may be negative */   \
    X(input_map, m *c)             /* [m][c]: coordinates of inputs are map^T (u - u0) */          \
    X(lead, n + c)                 /* by pairs: w = sum of lead_k pair_k; 0 behind them */         \
    X(state_range, n)              /* largest |x - x0| of training */                              \
    X(input_low, m)                                                                                \
    X(input_high, m)

typedef struct surrogate_step {
    int kind;           /* surrogate_kind_id */
    int states, inputs; /* inputs as one_step has them */
    int ramps;          /* 1: the network has inputs of both ends of the step */
    int drives;         /* coordinates of the inputs of all ends, as many as inputs or more */
    int slow_count, slow[SURROGATE_SLOW_MAX]; /* inputs */
    double step;                              /* s */
    double soft;                              /* of the frame */
    int turns, mirrors; /* whether the frame turns, whether the network knows a mirror */
    /* Classes: z has `pairs` first components, as many second ones, evens, odds. */
    int pairs, evens, odds;
    int out_pairs, out_evens, out_odds; /* of the network, those of states come first in a class */
    int layers;                         /* hidden ones */
    int width[SURROGATE_LAYERS_MAX];    /* units of each; with a mirror an even number */
    int state_slot[SURROGATE_STATES_MAX]; /* place in z of state k */
    int input_slot[SURROGATE_INPUTS_MAX]; /* and of coordinate k of the inputs */
    /* SURROGATE_STEP_NUMBERS, then layer by layer, with i inputs and o outputs of a class: weights
     * [i][o], of evens followed by biases [o]; evens first. */
    const double *numbers;
} surrogate_step;

/* How many numbers, doubles of work for one call, and parameters of the network among the numbers,
 * which are the last ones. */
size_t surrogate_step_numbers(const surrogate_step *m);
size_t surrogate_step_work(const surrogate_step *m);
size_t surrogate_step_parameters(const surrogate_step *m);

/* As one_step.advance and outside (physics/local/one_step.h); work [surrogate_step_work]. Not 0:
 * h is not the step, inputs of the end are given to a model that holds them, or a state is not
 * finite. */
int surrogate_step_advance(const surrogate_step *m, double *work, int count, double h,
                           const double *states, const double *inputs, const double *after,
                           double *next, double *by_state, double *by_inputs);
double surrogate_step_outside(const surrogate_step *m, const double *state, const double *inputs);

#endif
