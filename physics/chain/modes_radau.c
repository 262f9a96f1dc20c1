/* Radau's methods with their eigenvalues. */
#include "autodiff/dense.h"
#include "physics/chain/modes_step_internal.h"

enum { S = COLLOCATION_STAGES_MAX };

/* The eigenvector u of A: values at the nodes c of the derivative of a polynomial P that is
 * value P' there, P = value P' + M with M = prod_i (x - c_i), so that P = sum_k value^k M^(k). */
static void find_vector(const gauss_rule *rule, double complex value, double complex *u)
{
    const int s = rule->stages;
    double M[S + 1] = {1}; /* ascending powers */
    double complex power = 1;
    for (int i = 0; i < s; i++) {
        for (int k = i + 1; k > 0; k--) {
            M[k] = M[k - 1] - rule->nodes[i] * M[k];
        }
        M[0] *= -rule->nodes[i];
        u[i] = 0;
    }
    for (int order = 0; order <= s; order++, power *= value) {
        for (int j = 0; j < s; j++) {
            double at = 0;
            for (int k = s - order; k >= 0; k--) {
                at = at * rule->nodes[j] + M[k];
            }
            u[j] += power * at;
        }
        for (int k = 0; k < s - order; k++) {
            M[k] = (k + 1) * M[k + 1];
        }
    }
}

/* Rows of T^-1 and columns of T, of eigenvalues that are real or have an imaginary part > 0. */
static void find_eigenvectors(collocation_method *by)
{
    const int s = by->rule.stages;
    double A[S * S], real[S], imaginary[S], work[AD_DENSE_EIGEN_WORK(S)];
    double T[S * S], inverse[S * S] = {0}; /* by columns: real parts and imaginary ones in turn */
    int pivots[S], column[COLLOCATION_PAIRS];
    by->pairs = 1;
    for (int i = 0; i < s * s; i++) {
        A[i] = by->rule.matrix[i % s][i / s];
        inverse[i] = i % (s + 1) == 0;
    }
    ad_dense_eigenvalues((size_t)s, A, real, imaginary, work);
    for (int i = 0; i < s; i++) {
        double complex u[S];
        if (imaginary[i] >= 0) {
            const int k = imaginary[i] > 0 ? by->pairs++ : 0;
            column[k] = k > 0 ? 2 * k - 1 : 0;
            by->eigenvalue[k] = real[i] + I * imaginary[i];
            find_vector(&by->rule, by->eigenvalue[k], u);
            for (int j = 0; j < s; j++) {
                T[column[k] * s + j] = creal(u[j]);
                if (k > 0) {
                    T[(column[k] + 1) * s + j] = cimag(u[j]);
                }
                by->from[j][k] = k > 0 ? 2 * u[j] : u[j]; /* and its conjugate */
            }
        }
    }
    ad_dense_lu((size_t)s, T, pivots);
    ad_dense_lu_solve((size_t)s, (size_t)s, T, pivots, inverse);
    for (int k = 0; k < by->pairs; k++) {
        for (int j = 0; j < s; j++) {
            const double *row = inverse + j * s + column[k];
            by->to[k][j] = k > 0 ? (row[0] - I * row[1]) / 2 : row[0];
        }
    }
}

void collocation_make_method(int stages, collocation_method *by)
{
    *by = (collocation_method){.rule = gauss_radau_rule_of(stages)};
    for (int j = 0; j < stages; j++) {
        double p[S];
        gauss_legendre(stages - 1, 2 * by->rule.nodes[j] - 1, p);
        by->highest[j] = (2 * stages - 1) * by->rule.weights[j] * p[stages - 1];
        for (int i = 0; i < stages; i++) {
            for (int k = 0; k < stages; k++) {
                by->square[i][j] += by->rule.matrix[i][k] * by->rule.matrix[k][j];
            }
        }
    }
    find_eigenvectors(by);
}
