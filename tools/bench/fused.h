/* The yardstick: one training step of one fixed problem, fused by hand, against which the recorded
 * tape is measured. It is what a patient engineer would write for exactly this case and for nothing
 * else, so the tape's distance from it is the price of being general.
 *
 * The rod of rod_case.h with a network 2-64-64-64-64-7. The forward pass carries y, y_s, y_ss, y_t,
 * y_tt (derivatives, not Taylor coefficients); residual and adjoint are derived by hand.
 */
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

void fused_free(fused_state *state);

#endif
