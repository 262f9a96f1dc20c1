#include "physics/local/lobatto.h"

#include "physics/numerics/gauss.h"

#include <math.h>

void solve_lobatto_points(int degree, double *x, double *weights)
{
    const double pi = 3.14159265358979323846;
    for (int i = 0; i <= degree; i++) {
        /* Zeros of (1 - x^2) P'_n = n (P_(n-1) - x P_n), by Newton from Chebyshev's points. */
        double at = -cos(pi * i / degree), p[LOBATTO_DEGREE_MAX + 1];
        gauss_legendre(degree, at, p);
        for (int round = 0; round < 100 && i > 0 && i < degree; round++) {
            double step = (p[degree - 1] - at * p[degree]) / ((degree + 1) * p[degree]);
            at += step;
            gauss_legendre(degree, at, p);
            if (fabs(step) < 1e-15) {
                break;
            }
        }
        x[i] = at;
        weights[i] = 2 / (degree * (degree + 1) * p[degree] * p[degree]);
    }
    for (int i = 0; i <= degree; i++) { /* symmetric to the last bit */
        x[i] = i < degree - i ? -x[degree - i] : i > degree - i ? x[i] : 0;
        weights[i] = weights[i < degree - i ? degree - i : i];
    }
}

void solve_lobatto_derivative(int degree, const double *x, double *derivative)
{
    int n = degree + 1;
    double at[LOBATTO_DEGREE_MAX + 1], p[LOBATTO_DEGREE_MAX + 1];
    for (int i = 0; i < n; i++) {
        gauss_legendre(degree, x[i], p);
        at[i] = p[degree];
    }
    for (int i = 0; i < n; i++) {
        double sum = 0; /* rows of a derivative sum to 0: constants have none */
        for (int j = 0; j < n; j++) {
            if (i != j) {
                derivative[i * n + j] = at[i] / (at[j] * (x[i] - x[j]));
                sum += derivative[i * n + j];
            }
        }
        derivative[i * n + i] = -sum;
    }
}

void solve_lobatto_interpolation(int degree, const double *x, const double *weights, double at,
                                 double *values)
{
    double sum = 0;
    int hit = -1;
    for (int j = 0; j <= degree; j++) {
        double distance = at - x[j];
        hit = distance == 0 ? j : hit;
        values[j] = (j % 2 ? -1 : 1) * sqrt(weights[j]) / distance;
        sum += values[j];
    }
    for (int j = 0; j <= degree; j++) {
        values[j] = hit < 0 ? values[j] / sum : j == hit;
    }
}
