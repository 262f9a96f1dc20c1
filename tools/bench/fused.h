/* The yardstick: one training step of one fixed problem, fused by hand, against which the recorded
 * tape is measured. It is what a patient engineer would write for exactly this case and for nothing
 * else, so the tape's distance from it is the price of being general.
 *
 * Network 2-64-64-64-64-7 in double precision, tanh on the hidden layers, linear output, inputs
 * (s, t). The forward pass carries y, y_s, y_ss, y_t, y_tt (derivatives, not Taylor coefficients).
 *
 *     rho_o = y + y_s / 2 + y_ss / 4 + 3 y_t / 10 + y_tt / 5 - 1 / 10,   o = 1 .. 7
 *     loss  = 1/N sum over the N points of sum over o of rho_o^2
 *
 * All five coefficients of the seven outputs and their adjoints are formed one by one, as a
 * residual that is not linear in them would need: nothing is gained from rho being simple. */
#ifndef TOOLS_BENCH_FUSED_H
#define TOOLS_BENCH_FUSED_H

#include <stddef.h>

/* Parameters, layer after layer: weights row-major [out][in], then bias [out]. */
enum {
    FUSED_INPUTS = 2,
    FUSED_WIDTH = 64,
    FUSED_OUTPUTS = 7,
    FUSED_PARAMETERS =
        3 * FUSED_WIDTH + 3 * (FUSED_WIDTH + 1) * FUSED_WIDTH + (FUSED_WIDTH + 1) * FUSED_OUTPUTS,
    FUSED_DEFAULT_TILE = 16,
    FUSED_MAX_TILE = 1024,
    FUSED_MAX_THREADS = 256
};

/* cblas_dgemm with its enumerations as int, from the library that the tape uses too. The library
 * must run each call on the calling thread (OPENBLAS_NUM_THREADS=1). */
typedef struct fused_blas {
    void (*dgemm)(int order, int trans_a, int trans_b, int m, int n, int k, double alpha,
                  const double *a, int lda, const double *b, int ldb, double beta, double *c,
                  int ldc);
} fused_blas;

typedef struct fused_state fused_state;

/* All memory and threads of a step. `tile`: points per tile, a multiple of 8 in 8..FUSED_MAX_TILE,
 * 0 for the default; `threads`: 1..FUSED_MAX_THREADS, the caller's thread included. NULL: an
 * argument is out of range, or there is no memory or no thread left. */
fused_state *fused_create(const fused_blas *blas, int tile, int threads);

/* loss and grad[FUSED_PARAMETERS] at params[FUSED_PARAMETERS] over the points (s[i], t[i]), i < n,
 * n >= 1. Allocates nothing; the result does not depend on the number of threads. */
void fused_step(fused_state *state, const double *params, const double *s, const double *t,
                size_t n, double *loss, double *grad);

/* Instruction set of the elementwise kernels chosen for this processor, e.g. "avx512". */
const char *fused_kernels(const fused_state *state);

void fused_free(fused_state *state);

#endif
