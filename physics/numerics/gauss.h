/* Collocation at Gauss-Legendre points on [0, 1], as an implicit Runge-Kutta method (Hairer,
 * Lubich, Wanner, Geometric Numerical Integration, II.1.3, IV.2.1): order 2 stages at the ends of
 * an element, and quadratic invariants, such as |q|^2, are kept exactly there. Or at Radau's
 * points. */
#ifndef PHYSICS_NUMERICS_GAUSS_H
#define PHYSICS_NUMERICS_GAUSS_H

enum { GAUSS_STAGES_MAX = 12 };

typedef struct gauss_rule {
    int stages;
    double nodes[GAUSS_STAGES_MAX];                    /* c, ascending */
    double weights[GAUSS_STAGES_MAX];                  /* b */
    double matrix[GAUSS_STAGES_MAX][GAUSS_STAGES_MAX]; /* a */
    double barycentric[GAUSS_STAGES_MAX + 2];          /* for interpolation at 0, c, 1 */
} gauss_rule;

/* p [n + 1]: Legendre's polynomials P_0 .. P_n at y. */
void gauss_legendre(int n, double y, double *p);

/* Gauss-Legendre points on [0, 1], ascending, and their weights [n], n <= GAUSS_POINTS_MAX. */
enum { GAUSS_POINTS_MAX = 64 };
void gauss_points(int n, double *nodes, double *weights);

/* 1 <= stages <= GAUSS_STAGES_MAX */
gauss_rule solve_gauss_rule_of(int stages);

/* Radau IIA, whose last point is 1: order 2 stages - 1, damps what is too fast for its steps
 * (Hairer, Wanner, Solving Ordinary Differential Equations II, IV.5). Without what is barycentric:
 * neither for solve_gauss_lagrange nor for gauss_slope. */
gauss_rule gauss_radau_rule_of(int stages);

/* values[stages + 2]: Lagrange's polynomials of the points 0, c, 1 at x in [0, 1] (Berrut,
 * Trefethen, SIAM Review 46, 2004). */
void solve_gauss_lagrange(const gauss_rule *rule, double x, double *values);

/* By values at the points c alone: the polynomial through them at x, and its integral from 0;
 * values [stages]. */
void gauss_lagrange(const gauss_rule *rule, double x, double *values);
void gauss_integral(const gauss_rule *rule, double x, double *values);

/* And its slope there; [stages] each. */
void gauss_lagrange_slope(const gauss_rule *rule, double x, double *values, double *slopes);

/* The slope of that polynomial at the points c, on [0, 1]: (i, j) of the j-th at c_i. */
void gauss_slope(const gauss_rule *rule, double slope[GAUSS_STAGES_MAX][GAUSS_STAGES_MAX]);

/* The terms alpha_1 .. alpha_3 of Magnus' expansion of order 6 for a step from one x to another
 * (Blanes, Casas, Oteo, Ros, Physics Reports 470, 2009, eq. 253), by values at the points c. */
void gauss_magnus(const gauss_rule *rule, double from, double to,
                  double terms[3][GAUSS_STAGES_MAX]);

#endif
