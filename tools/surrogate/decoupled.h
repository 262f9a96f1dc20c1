/* One-step models whose network knows nothing of time: from a state and inputs it says the numbers
 * of a curve in time, which begins at the state exactly and has its derivative in closed form
 * (DD-PINN: Krauss et al., ICINCO 2024; of a rod Licher et al., arXiv:2508.12681). Any h in
 * (0, step] has an answer. Plain C without library but libm, as surrogate_step.h.
 *
 * With z = (x - x_c)/x_s, v = (u - u_c)/u_s (hold linear: and those of the end), t in units of the
 * step:
 *
 *   z(t) = z(0) + y(t),  y(0) = 0,  a = network(z(0), v)
 *   y_j  = sum_i alpha (exp(-delta t) sin(beta t + gamma) - sin gamma) */
#ifndef SURROGATE_DECOUPLED_H
#define SURROGATE_DECOUPLED_H

#include <stdbool.h>
#include <stddef.h>

enum { DECOUPLED_LAYERS_MAX = 4, DECOUPLED_NODES = 3 };

/* Numbers in their order in memory: name, count; n states, v numbers of inputs. */
#define DECOUPLED_NUMBERS(X)                                                                       \
    X(state_center, n)                                                                             \
    X(state_scale, n)                                                                              \
    X(input_center, inputs)                                                                        \
    X(input_scale, inputs)                                                                         \
    X(state_range, n) /* largest |z| of training */

typedef struct decoupled {
    int states, inputs; /* of one_step */
    bool ramps;         /* inputs go linearly: those of the end are inputs of the network, too */
    int terms;          /* damped sines for each state */
    double step;        /* s */
    int layers, width[DECOUPLED_LAYERS_MAX];
    const double *numbers; /* DECOUPLED_NUMBERS, then weights [out][in] and biases of each layer */
} decoupled;

extern const double decoupled_nodes[DECOUPLED_NODES]; /* Radau's, the last is 1 */

int decoupled_given(const decoupled *m);   /* numbers v of inputs: inputs, or twice as many */
int decoupled_outputs(const decoupled *m); /* of the network */
size_t decoupled_numbers(const decoupled *m);
size_t decoupled_parameters(const decoupled *m); /* weights and biases, the last of the numbers */
size_t decoupled_work(const decoupled *m);       /* doubles */

/* Hidden values [sum of widths] and a [outputs] of the network with parameters of m. */
void decoupled_network(const decoupled *m, const double *parameters, const double *z,
                       const double *v, double *hidden, double *a);

/* y, dy/dt [states] of a at t, and adds their adjoints to those of a: to_a += (dy/da)^T by_y +
 * (dy'/da)^T by_rate. What is NULL is not wanted. */
void decoupled_curve(const decoupled *m, const double *a, double t, double *y, double *rate);
void decoupled_curve_adjoint(const decoupled *m, const double *a, double t, const double *by_y,
                             const double *by_rate, double *to_a);

/* As one_step.advance and outside (physics/local/one_step.h). Not 0: h is outside of (0, step],
 * inputs of the end are given to a model that holds them (or not, to one that does not: they are
 * held), or the result is not finite. */
int decoupled_advance(const decoupled *m, double *work, int count, double h, const double *states,
                      const double *inputs, const double *after, double *next, double *by_state,
                      double *by_inputs);
double decoupled_outside(const decoupled *m, const double *state, const double *inputs);

#endif
