/* Cholesky's factors, by LAPACK. A row-major upper triangle is LAPACK's lower one. */
#include "autodiff/blas.h"

static int factor(size_t n, double *matrix)
{
    int size = (int)n, info = 0;
    blas_load(NULL)->potrf("L", &size, matrix, &size, &info);
    return info;
}

static void solve(size_t n, const double *factored, double *x)
{
    int size = (int)n, one = 1, info = 0;
    blas_load(NULL)->potrs("L", &size, &one, factored, &size, x, &size, &info);
}

ad_status ad_cholesky_load(ad_cholesky *cholesky, ad_error *error)
{
    *cholesky = (ad_cholesky){factor, solve};
    return blas_load(error) ? AD_OK : AD_NO_BLAS;
}
