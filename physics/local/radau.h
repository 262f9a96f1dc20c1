/* Radau IIA: collocation at Radau's points on [0, 1], the last of which is 1, as an implicit
 * Runge-Kutta method of order 2 stages - 1 that damps what is too fast for its steps (Hairer,
 * Wanner, Solving Ordinary Differential Equations II, IV.5). */
#ifndef PHYSICS_LOCAL_RADAU_H
#define PHYSICS_LOCAL_RADAU_H

enum { RADAU_STAGES = 8 };

typedef struct radau_rule {
    double nodes[RADAU_STAGES];                /* c, ascending */
    double matrix[RADAU_STAGES][RADAU_STAGES]; /* a; its last row are the weights */
} radau_rule;

radau_rule solve_radau_rule_of(void);

/* Lagrange's polynomials of the points c at x, and their derivatives. */
void solve_radau_lagrange(const radau_rule *rule, double x, double values[RADAU_STAGES],
                          double derivatives[RADAU_STAGES]);

#endif
