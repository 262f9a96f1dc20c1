/* nn: dense networks recorded on a tape, their parameters one flat vector with named views.
 *
 * Without hidden layers the network is linear in its parameters: one trained layer on the inputs
 * and fixed random Fourier features of them. Random features: Rahimi & Recht 2007; for differential
 * equations: Dwivedi & Srinivasan 2020, Dong & Li 2021, Chen, Chi, E & Yang 2022. Or it is linear
 * in polynomials of the inputs up to a weighted degree (polynomial chaos, nn/polynomial.h).
 * Features that nearly depend on one another leave least squares ill-conditioned. The trained layer
 * therefore sees an orthonormal basis of what they span, unless settings say otherwise. The basis
 * cancels twelve digits, and four derivatives of what is left are too noisy. */
#ifndef NN_H
#define NN_H

#include "autodiff/ad.h"
#include "nn/rng.h"

#ifdef __cplusplus
extern "C" {
#endif

enum {
    NN_HIDDEN_MAX = 16,
    NN_INPUTS_MAX = 64,
    NN_NAME_MAX = 48,
    NN_PIECES_MAX = 64,
    NN_DEGREE_MAX = 32
};

#define NN_ACTIVATION_LIST(X)                                                                      \
    X(NN_TANH, "tanh")                                                                             \
    X(NN_SIN, "sin")                                                                               \
    X(NN_SILU, "silu")                                                                             \
    X(NN_GELU, "gelu")
#define NN_INITIALIZATION_LIST(X)                                                                  \
    X(NN_GLOROT, "glorot")   /* Glorot & Bengio 2010: normal, variance 2/(inputs+outputs) */       \
    X(NN_UNIFORM, "uniform") /* uniform within 1/sqrt(inputs) */

#define NN_ENUM(name, text) name,
typedef enum nn_activation { NN_ACTIVATION_LIST(NN_ENUM) } nn_activation;
typedef enum nn_initialization { NN_INITIALIZATION_LIST(NN_ENUM) } nn_initialization;
#undef NN_ENUM

/* In pieces along its first input a network is smooth within each and continuous. Each piece has a
 * trained layer of its own over the same features, which the coordinate within the piece enters in
 * place of the first input, and between edges of pieces it is joined exactly:
 *
 *   y = e_0 + sum_k ramp_k e_k+1 + bubble sum_k mask_k (W_k features + b_k)
 *
 * with e_k of the other inputs alone, which at rest are none. Mask, ramp and bubble come with the
 * inputs: in rows after them bubble, mask [pieces], ramp [pieces]. */
typedef struct nn_mlp_settings {
    int inputs;
    int outputs;
    int pieces; /* 1 */
    int hidden_count;
    int hidden[NN_HIDDEN_MAX]; /* widths */
    nn_activation activation;
    nn_initialization initialization;
    bool orthonormal; /* the trained layer of a linear network with features sees a basis */
    int scalars;      /* numbers trained beside the weights, which the network does not use; 0 */
    int fourier_features; /* pairs sin, cos of random projections of the inputs; 0: none */
    double fourier_bandwidth[NN_INPUTS_MAX]; /* largest frequency by input, radians per unit of the
                                              * input; they are drawn uniformly within */
    int degree;                  /* of polynomials in place of Fourier features; 0: none */
    double range[NN_INPUTS_MAX]; /* of polynomials: inputs lie within -range .. range; in (0, 1] */
} nn_mlp_settings;

/* One piece, hidden 3 x 32, tanh, glorot, no Fourier features; their bandwidth 2 pi, orthonormal;
 * no polynomials, ranges 1. */
nn_mlp_settings nn_mlp_settings_default(void);

/* NULL, or the name of the field that is out of range with what is allowed (static text). */
const char *nn_mlp_settings_check(const nn_mlp_settings *settings);

/* The largest degree of polynomials of these inputs and ranges that has at most so many of them;
 * 1 where none has. */
int nn_polynomial_degree(nn_mlp_settings settings, double most);

/* A named part of the flat parameter vector. */
typedef struct nn_view {
    char name[NN_NAME_MAX]; /* "layer0/weight" */
    size_t offset;
    int rows;
    int columns; /* 1 for a bias */
} nn_view;

typedef struct nn_mlp nn_mlp;

/* Owned by the caller. The Fourier frequencies come from `rng` and are fixed numbers. */
ad_status nn_mlp_create(const nn_mlp_settings *settings, nn_rng *rng, nn_mlp **mlp,
                        ad_error *error);
void nn_mlp_free(nn_mlp *mlp);

size_t nn_mlp_parameters(const nn_mlp *mlp); /* length of the flat vector */
int nn_mlp_views(const nn_mlp *mlp, const nn_view **views);

/* Fill parameters [nn_mlp_parameters]; all 0 without hidden layers. */
void nn_mlp_initialize(const nn_mlp *mlp, nn_rng *rng, double *parameters);

/* The [features][inputs] Fourier frequencies in radians, for a checkpoint; NULL when there are
 * none. */
double *nn_mlp_fourier(nn_mlp *mlp, size_t *count);

/* That basis, of a network without hidden layers that has features and is orthonormal, for a
 * checkpoint:
 * [rows][columns], coefficients of 1, the inputs, sin and cos of their projections; NULL for other
 * networks. */
double *nn_mlp_basis(nn_mlp *mlp, int *rows, int *columns);

/* The basis of what is joined at the edges of pieces, functions of all inputs but the first: the
 * same for them; NULL for other networks. */
double *nn_mlp_edge_basis(nn_mlp *mlp, int *rows, int *columns);

/* Record the network on the tape of `input` (rows of the inputs, scaled to about [-1, 1], and what
 * comes with them where there are pieces): [outputs] rows. `offset`: of its first parameter in the
 * flat vector. */
ad_value nn_mlp_record(const nn_mlp *mlp, ad_value input, size_t offset);

/* Of a network without hidden layers, in one piece: another one of one output with the same
 * features, which the parameters [features + 1] of this one, weights and bias, are multiplied with,
 * from offset 0 on. */
ad_value nn_mlp_record_single(const nn_mlp *mlp, ad_value input, ad_value wrt[2]);
int nn_mlp_features(const nn_mlp *mlp); /* what enters the first layer */

/* Its scalars [settings.scalars], which come after all other parameters; of parameters as
 * nn_mlp_combine leaves them, or as they are. At least one. */
ad_value nn_mlp_record_scalars(const nn_mlp *mlp, ad_tape *tape, bool combined, size_t offset);

/* The same network for evaluation alone. Where it has a basis, the weights times the coefficients
 * of the basis are one matrix [outputs][functions], then the biases: one product in place of two in
 * training. Else they are the parameters as they are. nn_mlp_combine computes these numbers
 * from parameters. Results are equal to rounding. */
size_t nn_mlp_combined_parameters(const nn_mlp *mlp);
void nn_mlp_combine(const nn_mlp *mlp, const double *parameters, double *combined);
ad_value nn_mlp_record_combined(const nn_mlp *mlp, ad_value input, size_t offset);

#ifdef __cplusplus
}
#endif

#endif
