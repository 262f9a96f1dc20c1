/* What every side of the benchmark computes: loss and parameter gradient of one Cosserat rod in
 * motion, displacement form, clamped at both ends, under its weight, a network of tanh with linear
 * output, double precision. Everything is dimensionless (length, bending stiffness and mass per
 * length are 1), so that physics/rod/rod.h reads
 *
 *     x = (0, 0, s) + f y_1..3,   p = (1, 0, 0, 0) + f y_4..7,   f = s (1 - s) (t / duration)^2
 *     q = p/|p|,  v = R(q)^T x_s,  u = 2 vec(q* q_s),  w = 2 vec(q* q_t),
 *     n = K (v - e3),  m = C u,  N = R(q) n
 *     force = N_s + weight - x_tt,   moment = m_s + u x m + v x n - J w_t - w x (J w)
 *     loss = mean over the points of force_weight |force|^2 + moment_weight |moment|^2
 *
 * where y is the network of (2 s - 1, 2 t / duration - 1). */
#ifndef TOOLS_BENCH_ROD_CASE_H
#define TOOLS_BENCH_ROD_CASE_H

#include "physics/learn/problem.h"

typedef struct rod_case_constants {
    double strain_stiffness[3], curvature_stiffness[3]; /* K, C */
    double rotary_inertia[3];                           /* J */
    double weight[3];
    double duration;
    double force_weight, moment_weight;
} rod_case_constants;

extern const rod_case_constants rod_case_numbers;

typedef struct rod_case {
    int hidden_count, width;
    size_t points, parameters;
    const double *s, *t; /* [points], the problem's own */
    double *x;           /* [parameters]: layer after layer weights [out][in], bias [out] */
    struct experiment *e;
    ad_pool *pool; /* its own, as x is */
    problem *problem;
} rod_case;

/* AD_OK, or `error`. */
ad_status rod_case_create(rod_case *c, int hidden_count, int width, int points, int threads,
                          ad_error *error);
void rod_case_free(rod_case *c);

#endif
