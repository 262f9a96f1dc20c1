/* Large matrices: OpenBLAS, loaded so that it picks kernels that fit the processor; the products of
 * tiles are those of products.c. Private. */
#ifndef AD_BLAS_H
#define AD_BLAS_H

#include "autodiff/ad.h"

/* c[m][n] (row stride ldc) = a b + beta c, row-major; `a` is stored [k][m] when transpose_a, `b`
 * [n][k] when transpose_b. Single-threaded: several threads may call it at once. */
typedef void (*blas_gemm)(int order, int transpose_a, int transpose_b, int m, int n, int k,
                          double alpha, const double *a, int lda, const double *b, int ldb,
                          double beta, double *c, int ldc);

/* The upper or lower triangle of c[n][n] = a a^T + beta c, row-major, a [n][k]. */
typedef void (*blas_syrk)(int order, int triangle, int transpose, int n, int k, double alpha,
                          const double *a, int lda, double beta, double *c, int ldc);

enum { BLAS_ROW_MAJOR = 101, BLAS_NORMAL = 111, BLAS_TRANSPOSED = 112, BLAS_UPPER = 121 };

typedef struct blas {
    blas_gemm gemm;
    blas_syrk syrk;
    void (*getrf)(const int *, const int *, double *, const int *, int *, int *);
    void (*getrs)(const char *, const int *, const int *, const double *, const int *, const int *,
                  double *, const int *, int *);
    void (*geqp3)(const int *, const int *, double *, const int *, int *, double *, double *,
                  const int *, int *);
    void (*geqrf)(const int *, const int *, double *, const int *, double *, double *, const int *,
                  int *);
    void (*tpqrt)(const int *, const int *, const int *, const int *, double *, const int *,
                  double *, const int *, double *, const int *, double *, int *);
    void (*tpmqrt)(const char *, const char *, const int *, const int *, const int *, const int *,
                   const int *, const double *, const int *, const double *, const int *, double *,
                   const int *, double *, const int *, double *, int *);
    void (*trtri)(const char *, const char *, const int *, double *, const int *, int *);
    void (*sytf2)(const char *, const int *, double *, const int *, int *, int *);
    void (*geev)(const char *, const char *, const int *, double *, const int *, double *, double *,
                 double *, const int *, double *, const int *, double *, const int *, int *);
    const char *core; /* the kernels OpenBLAS chose, as it names them */
} blas;

/* OpenBLAS gets a buffer for every thread that multiplies, and asks for it again and again for ever
 * where there is no address space; so it is asked for here first. False: there is none. */
bool ad_blas_fits(int threads);

/* Loaded once per process, on first use; NULL with an error when it cannot be. */
const blas *ad_blas_load(ad_error *error);
ad_status ad_blas_status(void); /* how that went: AD_OK, AD_NO_MEMORY, AD_NO_BLAS */

#endif
