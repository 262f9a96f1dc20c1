#include "physics/numerics/gauss.h"

#include <math.h>
#include <string.h>

void gauss_legendre(int n, double y, double *p)
{
    p[0] = 1;
    for (int k = 0; k < n; k++) {
        p[k + 1] = ((2 * k + 1) * y * p[k] - (k > 0 ? k * p[k - 1] : 0)) / (k + 1);
    }
}

/* Newton's iteration for the roots of P_n from their asymptotic places. */
void gauss_points(int n, double *nodes, double *weights)
{
    const double pi = 3.14159265358979323846;
    for (int i = 0; i < n; i++) {
        double x = 0.5 - 0.5 * cos(pi * (i + 0.75) / (n + 0.5)), p[GAUSS_POINTS_MAX + 1], slope = 1;
        for (int k = 0; k < 8; k++) {
            const double y = 2 * x - 1;
            gauss_legendre(n, y, p);
            slope = 2 * n * (y * p[n] - p[n - 1]) / (y * y - 1); /* by x */
            x -= p[n] / slope;
        }
        nodes[i] = x;
        weights[i] = 4 / (4 * x * (1 - x) * slope * slope);
    }
}

/* Those of P_n - P_(n-1), from Chebyshev's points, and 1. */
static void find_radau_nodes(gauss_rule *rule)
{
    const double pi = 3.14159265358979323846;
    const int n = rule->stages;
    double p[GAUSS_STAGES_MAX + 1];
    for (int i = 0; i < n; i++) {
        double y = i == n - 1 ? 1 : -cos(pi * (2 * i + 1) / (2 * n - 1));
        for (int k = 0; i < n - 1 && k < 8; k++) {
            gauss_legendre(n, y, p);
            const double slope =
                (n * (y * p[n] - p[n - 1]) - (n - 1) * (y * p[n - 1] - p[n - 2])) / (y * y - 1);
            y -= (p[n] - p[n - 1]) / slope;
        }
        rule->nodes[i] = (1 + y) / 2;
        gauss_legendre(n, 2 * rule->nodes[i] - 1, p);
        rule->weights[i] = rule->nodes[i] / (n * p[n - 1] * n * p[n - 1]);
    }
}

static double point(const gauss_rule *rule, int i)
{
    return i == 0 ? 0 : i > rule->stages ? 1 : rule->nodes[i - 1];
}

/* a_ij, the integral of the j-th polynomial of Lagrange from 0 to c_i, by its Legendre series. */
static double integral(const gauss_rule *rule, int i, int j)
{
    double at[GAUSS_STAGES_MAX + 2], to[GAUSS_STAGES_MAX + 2], sum = rule->nodes[i];
    gauss_legendre(rule->stages, 2 * rule->nodes[j] - 1, at);
    gauss_legendre(rule->stages, 2 * rule->nodes[i] - 1, to);
    for (int k = 1; k < rule->stages; k++) {
        sum += at[k] * (to[k + 1] - to[k - 1]) / 2;
    }
    return rule->weights[j] * sum;
}

static void fill_matrix(gauss_rule *rule)
{
    for (int i = 0; i < rule->stages; i++) {
        for (int j = 0; j < rule->stages; j++) {
            rule->matrix[i][j] = integral(rule, i, j);
        }
    }
}

gauss_rule gauss_radau_rule_of(int stages)
{
    gauss_rule rule = {.stages = stages};
    find_radau_nodes(&rule);
    fill_matrix(&rule);
    return rule;
}

gauss_rule solve_gauss_rule_of(int stages)
{
    gauss_rule rule = {.stages = stages};
    gauss_points(stages, rule.nodes, rule.weights);
    fill_matrix(&rule);
    for (int i = 0; i < stages + 2; i++) {
        double product = 1;
        for (int j = 0; j < stages + 2; j++) {
            product *= i == j ? 1 : 2 * (point(&rule, i) - point(&rule, j));
        }
        rule.barycentric[i] = 1 / product;
    }
    return rule;
}

void solve_gauss_lagrange(const gauss_rule *rule, double x, double *values)
{
    double sum = 0;
    int count = rule->stages + 2;
    for (int i = 0; i < count; i++) {
        double distance = x - point(rule, i);
        if (distance == 0) {
            for (int j = 0; j < count; j++) {
                values[j] = i == j;
            }
            return;
        }
        values[i] = rule->barycentric[i] / distance;
        sum += values[i];
    }
    for (int i = 0; i < count; i++) {
        values[i] /= sum;
    }
}

void gauss_lagrange_slope(const gauss_rule *rule, double x, double *values, double *slopes)
{
    for (int j = 0; j < rule->stages; j++) {
        values[j] = 1;
        slopes[j] = 0;
        for (int k = 0; k < rule->stages; k++) {
            if (k != j) {
                const double width = rule->nodes[j] - rule->nodes[k];
                const double factor = (x - rule->nodes[k]) / width;
                slopes[j] = slopes[j] * factor + values[j] / width;
                values[j] *= factor;
            }
        }
    }
}

void gauss_lagrange(const gauss_rule *rule, double x, double *values)
{
    double slopes[GAUSS_STAGES_MAX];
    gauss_lagrange_slope(rule, x, values, slopes);
}

void gauss_integral(const gauss_rule *rule, double x, double *values)
{
    memset(values, 0, (size_t)rule->stages * sizeof *values);
    for (int k = 0; k < rule->stages; k++) {
        double at[GAUSS_STAGES_MAX];
        gauss_lagrange(rule, x * rule->nodes[k], at);
        for (int j = 0; j < rule->stages; j++) {
            values[j] += x * rule->weights[k] * at[j];
        }
    }
}

void gauss_slope(const gauss_rule *rule, double slope[GAUSS_STAGES_MAX][GAUSS_STAGES_MAX])
{
    const double *c = rule->nodes;
    double w[GAUSS_STAGES_MAX]; /* barycentric, without 0 and 1 */
    for (int j = 0; j < rule->stages; j++) {
        w[j] = rule->barycentric[j + 1] * c[j] * (c[j] - 1);
    }
    for (int i = 0; i < rule->stages; i++) {
        slope[i][i] = 0;
        for (int j = 0; j < rule->stages; j++) {
            if (i != j) {
                slope[i][j] = w[j] / w[i] / (c[i] - c[j]);
                slope[i][i] -= slope[i][j];
            }
        }
    }
}

/* Blanes' alpha_1 .. alpha_3 from u at three points of Gauss. */
void gauss_magnus(const gauss_rule *rule, double from, double to, double terms[3][GAUSS_STAGES_MAX])
{
    const double h = to - from, middle = (from + to) / 2, off = h * sqrt(15) / 10;
    double at[3][GAUSS_STAGES_MAX];
    for (int k = 0; k < 3; k++) {
        gauss_lagrange(rule, middle + (k - 1) * off, at[k]);
    }
    for (int j = 0; j < rule->stages; j++) {
        terms[0][j] = h * at[1][j];
        terms[1][j] = h * sqrt(15) / 3 * (at[2][j] - at[0][j]);
        terms[2][j] = h * 10 / 3 * (at[2][j] - 2 * at[1][j] + at[0][j]);
    }
}
