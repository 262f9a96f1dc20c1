#include "physics/local/radau.h"

#include "physics/numerics/gauss.h"

#include <math.h>

enum { STAGES = RADAU_STAGES };

/* Legendre's polynomial P_n at y, and its derivative for |y| < 1. */
static double legendre(int n, double y, double *derivative)
{
    double before = 1, now = y;
    for (int k = 1; k < n; k++) {
        double next = ((2 * k + 1) * y * now - k * before) / (k + 1);
        before = now;
        now = next;
    }
    *derivative = n * (y * now - before) / (y * y - 1);
    return now;
}

/* Roots of P_n - P_(n-1) at 2x - 1, by Newton's iteration from Chebyshev's points. */
static void find_nodes(radau_rule *rule)
{
    const double pi = 3.14159265358979323846;
    for (int i = 0; i < STAGES - 1; i++) {
        double y = -cos(pi * (2 * i + 1) / (2 * STAGES - 1));
        for (int k = 0; k < 8; k++) {
            double slope, slope_before;
            double value = legendre(STAGES, y, &slope) - legendre(STAGES - 1, y, &slope_before);
            y -= value / (slope - slope_before);
        }
        rule->nodes[i] = (1 + y) / 2;
    }
    rule->nodes[STAGES - 1] = 1;
}

radau_rule solve_radau_rule_of(void)
{
    gauss_rule quadrature = solve_gauss_rule_of(STAGES);
    radau_rule rule = {.matrix = {{0}}};
    find_nodes(&rule);
    for (int i = 0; i < STAGES; i++) {
        for (int k = 0; k < STAGES; k++) {
            double values[STAGES], derivatives[STAGES];
            solve_radau_lagrange(&rule, rule.nodes[i] * quadrature.nodes[k], values, derivatives);
            for (int j = 0; j < STAGES; j++) {
                rule.matrix[i][j] += rule.nodes[i] * quadrature.weights[k] * values[j];
            }
        }
    }
    return rule;
}

void solve_radau_lagrange(const radau_rule *rule, double x, double values[RADAU_STAGES],
                          double derivatives[RADAU_STAGES])
{
    for (int j = 0; j < STAGES; j++) {
        values[j] = 1;
        derivatives[j] = 0;
        for (int k = 0; k < STAGES; k++) {
            if (k != j) {
                double width = rule->nodes[j] - rule->nodes[k];
                double factor = (x - rule->nodes[k]) / width;
                derivatives[j] = derivatives[j] * factor + values[j] / width;
                values[j] *= factor;
            }
        }
    }
}
