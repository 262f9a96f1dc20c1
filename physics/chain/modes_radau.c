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
    const int s = by->stages;
    for (int i = 0; i < s; i++) {
        x[i] = 1 + 0.3 * i;
    }
    for (int round = 0; round < 3; round++) {
        double complex a[S][S + 1];
        double size = 0;
        for (int i = 0; i < s; i++) {
            for (int j = 0; j < s; j++) {
                a[i][j] = transposed ? by->matrix[j][i] : by->matrix[i][j];
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

/* By Gauss' rule. */
void collocation_integrals(const collocation_method *by, double x, double *to)
{
    const gauss_rule rule = solve_gauss_rule_of(S);
    for (int j = 0; j < by->stages; j++) {
        to[j] = 0;
        for (int k = 0; k < rule.stages; k++) {
            double value = 1;
            for (int i = 0; i < by->stages; i++) {
                value *=
                    i == j ? 1 : (x * rule.nodes[k] - by->nodes[i]) / (by->nodes[j] - by->nodes[i]);
            }
            to[j] += x * rule.weights[k] * value;
        }
    }
}

/* Radau's points: zeros of P_s - P_(s-1), those between the zeros of P_s apart from 1. */
static void radau_nodes(int s, const gauss_rule *rule, double *nodes)
{
    for (int i = 0; i + 1 < s; i++) {
        double low = rule->nodes[i], high = rule->nodes[i + 1];
        for (int k = 0; k < 100; k++) {
            const double middle = 0.5 * (low + high);
            const double at_low = legendre_at(s, 2 * low - 1) - legendre_at(s - 1, 2 * low - 1);
            const double here = legendre_at(s, 2 * middle - 1) - legendre_at(s - 1, 2 * middle - 1);
            if ((here > 0) == (at_low > 0)) {
                low = middle;
            } else {
                high = middle;
            }
        }
        nodes[i] = 0.5 * (low + high);
    }
    nodes[s - 1] = 1;
}

/* The highest coefficient in Legendre's polynomials of the one through values at the nodes. */
static void find_highest(collocation_method *by)
{
    const int s = by->stages;
    for (int j = 0; j < s; j++) {
        double complex a[S][S + 1], x[S];
        for (int i = 0; i < s; i++) {
            for (int k = 0; k < s; k++) {
                a[i][k] = legendre_at(k, 2 * by->nodes[i] - 1);
            }
            a[i][s] = i == j;
        }
        solve_small(s, a, x);
        by->highest[j] = creal(x[s - 1]);
    }
}

void collocation_make_method(int stages, collocation_method *by)
{
    const gauss_rule rule = solve_gauss_rule_of(stages);
    double complex all[S];
    *by = (collocation_method){.stages = stages};
    radau_nodes(stages, &rule, by->nodes);
    for (int i = 0; i < stages; i++) {
        collocation_integrals(by, by->nodes[i], by->matrix[i]);
    }
    for (int j = 0; j < stages; j++) {
        for (int i = 0; i < stages; i++) {
            by->end[j] += by->matrix[stages - 1][i] * by->matrix[i][j];
            for (int k = 0; k < stages; k++) {
                by->square[i][j] += by->matrix[i][k] * by->matrix[k][j];
            }
        }
    }
    find_highest(by);
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
