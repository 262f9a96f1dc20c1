/* Radau's methods with their eigenvalues. */
#include "physics/chain/modes_step_internal.h"

#include <math.h>
#include <string.h>

enum { S = COLLOCATION_STAGES_MAX };

/* Eigenvalues of A: those of Pade's denominator, sum_k (N - k)! s! / (N! k! (s - k)!) (-z)^k with
 * N = 2 s - 1, at 1/z (Hairer, Wanner, IV.3), by the method of Durand and Kerner. */
static void find_eigenvalues(int s, double complex *all)
{
    const int most = 2 * s - 1;
    double coefficient[S + 1] = {1}; /* of lambda^(s - k) */
    for (int k = 1; k <= s; k++) {
        coefficient[k] = -coefficient[k - 1] * (s - k + 1) / (double)(k * (most - k + 1));
    }
    for (int i = 0; i < s; i++) {
        all[i] = 0.3 * cexp(I * (0.4 + 2 * 3.14159265358979 * i / s));
    }
    for (int round = 0; round < 200; round++) {
        for (int i = 0; i < s; i++) {
            double complex value = 0, others = 1;
            for (int k = 0; k <= s; k++) {
                value = value * all[i] + coefficient[k];
            }
            for (int j = 0; j < s; j++) {
                others *= j == i ? 1 : all[i] - all[j];
            }
            all[i] -= value / others;
        }
    }
}

/* x of A x = b, [s][s] with s + 1 columns in all, in place; small: without any care for speed. */
static void solve_small(int s, double complex (*a)[S + 1], double complex *x)
{
    for (int i = 0; i < s; i++) {
        int best = i;
        for (int r = i + 1; r < s; r++) {
            best = cabs(a[r][i]) > cabs(a[best][i]) ? r : best;
        }
        for (int c = 0; c <= s; c++) {
            const double complex other = a[i][c];
            a[i][c] = a[best][c];
            a[best][c] = other;
        }
        for (int r = i + 1; r < s; r++) {
            const double complex by = a[r][i] / a[i][i];
            for (int c = i; c <= s; c++) {
                a[r][c] -= by * a[i][c];
            }
        }
    }
    for (int i = s - 1; i >= 0; i--) {
        x[i] = a[i][s];
        for (int c = i + 1; c < s; c++) {
            x[i] -= a[i][c] * x[c];
        }
        x[i] /= a[i][i];
    }
}

/* Right (or of the transposed matrix) eigenvector by inverse iteration. */
static void find_vector(const collocation_method *by, double complex value, bool transposed,
                        double complex *x)
{
    const int s = by->rule.stages;
    for (int i = 0; i < s; i++) {
        x[i] = 1 + 0.3 * i;
    }
    for (int round = 0; round < 3; round++) {
        double complex a[S][S + 1];
        double size = 0;
        for (int i = 0; i < s; i++) {
            for (int j = 0; j < s; j++) {
                a[i][j] = transposed ? by->rule.matrix[j][i] : by->rule.matrix[i][j];
                a[i][j] -= i == j ? value * (1 + 1e-11) : 0;
            }
            a[i][s] = x[i];
        }
        solve_small(s, a, x);
        for (int i = 0; i < s; i++) {
            size = fmax(size, cabs(x[i]));
        }
        for (int i = 0; i < s; i++) {
            x[i] /= size;
        }
    }
}

static double legendre_at(int degree, double y)
{
    double before = 0, value = 1;
    for (int k = 0; k < degree; k++) {
        const double next = ((2 * k + 1) * y * value - k * before) / (k + 1);
        before = value;
        value = next;
    }
    return value;
}

void collocation_make_method(int stages, collocation_method *by)
{
    double complex all[S];
    *by = (collocation_method){.rule = gauss_radau_rule_of(stages)};
    for (int j = 0; j < stages; j++) {
        by->highest[j] = (2 * stages - 1) * by->rule.weights[j] *
                         legendre_at(stages - 1, 2 * by->rule.nodes[j] - 1);
        for (int i = 0; i < stages; i++) {
            for (int k = 0; k < stages; k++) {
                by->square[i][j] += by->rule.matrix[i][k] * by->rule.matrix[k][j];
            }
        }
    }
    find_eigenvalues(stages, all);
    by->pairs = 1;
    for (int i = 0; i < stages; i++) {
        const bool is_real = fabs(cimag(all[i])) < 1e-9;
        if (is_real || cimag(all[i]) > 0) {
            const int k = is_real ? 0 : by->pairs++;
            double complex left[S], right[S], product = 0;
            by->eigenvalue[k] = is_real ? creal(all[i]) : all[i];
            find_vector(by, by->eigenvalue[k], true, left);
            find_vector(by, by->eigenvalue[k], false, right);
            for (int j = 0; j < stages; j++) {
                product += left[j] * right[j];
            }
            for (int j = 0; j < stages; j++) {
                by->to[k][j] = left[j] / product;
                by->from[j][k] = right[j] * (is_real ? 1 : 2); /* and its conjugate */
            }
        }
    }
}
