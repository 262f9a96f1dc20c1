/* Orthonormal functions made of the fixed ones that enter a linear network; not for callers. */
#ifndef NN_BASIS_H
#define NN_BASIS_H

#include "nn/nn.h"

/* The functions to begin with: 1, the inputs, sin and cos of the projections by
 * fourier[features][inputs]. */
int nn_basis_functions(const nn_mlp_settings *settings);

/* Combinations of them, each orthogonal to 1 and to the others and of mean square 1, in the mean
 * over points of [-1, 1]^inputs that are denser at the edges, as Chebyshev's. As many as the
 * functions span to rounding: random waves nearly depend on one another, and what they span to
 * 1e-12 has far fewer dimensions than there are waves, or needs coefficients of 1e12. As
 * parameters those would spoil the normal equations, whose condition is the square.
 *
 * At edges of pieces: of what is left of the functions where the first input is 0.
 *
 * basis [rows][functions], owned by the caller. */
ad_status nn_basis_create(const nn_mlp_settings *settings, const double *fourier, bool at_edges,
                          nn_rng *rng, double **basis, int *rows, ad_error *error);

#endif
