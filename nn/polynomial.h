/* Polynomials of the inputs as features of a linear network; not for callers. */
#ifndef NN_POLYNOMIAL_H
#define NN_POLYNOMIAL_H

#include "nn/nn.h"

/* Products of Legendre polynomials of the inputs, each of mean square 1 over the inputs' ranges:
 *
 *   prod_i (2 k_i + 1)^(1/2) P_k_i(x_i / range_i),   0 < sum_i weight_i k_i <= degree
 *
 * (polynomial chaos: Wiener 1938; Xiu & Karniadakis 2002). Their number, which is infinite when it
 * is beyond all use. */
double nn_polynomial_count(const nn_mlp_settings *settings);

/* [count] rows of them, of the inputs x. */
ad_value nn_polynomial_record(const nn_mlp_settings *settings, ad_value x);

#endif
