/* Reduced rods for tests. */
#ifndef MODES_TESTING_H
#define MODES_TESTING_H

#include "everything.h"
#include "motion_testing.h"

#include "physics/chain/modes_internal.h"

#include <stdlib.h>
#include <string.h>

#define MEMBER "parameters: {p: {range: [100, 300]}, e: {range: [0.5, 2]}}\n"
static const char everything[] = EVERYTHING("p: {range: [100, 300]}, e: {range: [0.5, 2]}", "1");

typedef struct reduced_test {
    config *settings;
    solve_rod *rod;
    modes *m;
} reduced_test;

static inline reduced_test make_with(const char *path, const char *text, modes_counts counts,
                                     int finer, int set_count, const char *const *sets)
{
    ad_error error = {.message = ""};
    reduced_test x = {0};
    if (prepare_read_member(path, text, set_count, sets,
                            text && strncmp(text, MEMBER, strlen(MEMBER)) == 0 ? "p=170,e=1.3"
                                                                               : NULL,
                            &x.settings, &error) != AD_OK ||
        solve_rod_create(&x.settings->scene, &x.rod, &error) != AD_OK ||
        modes_create(x.rod, NULL, &counts, finer, &x.m, &error) != AD_OK) {
        fail_msg("%s", error.message);
    }
    return x;
}

static inline reduced_test make(const char *path, const char *text, modes_counts counts, int finer)
{
    return make_with(path, text, counts, finer, 0, NULL);
}

static inline void discard(reduced_test *x)
{
    modes_free(x->m);
    solve_rod_free(x->rod);
    config_free(x->settings);
}

static inline double noise(unsigned *state)
{
    *state = *state * 1664525u + 1013904223u;
    return (double)*state / 4294967296.0 - 0.5;
}

/* Mass, stiffness and damping matrices are derivatives of the residual. Turns between points are
 * Magnus' of order 6, their changes are integrals of changes of curvature: the difference falls as
 * points become more. */
static inline double worst_derivative_of(const char *text, int finer, const scene_law *law,
                                         int set_count, const char *const *sets)
{
    enum { MOST = 64 };
    const double h = 1e-5;
    ad_error error = {.message = ""};
    reduced_test x =
        make_with("everything.yaml", text, modes_counts_of(2, 2, 2, 2), finer, set_count, sets);
    x.rod->scene.rod.law = law;
    const int n = modes_size(x.m), width = x.m->width; /* reactions of a held end among them */
    double state[3][MOST], with[2][MOST], worst = 0, size = 0;
    double *by_q = calloc((size_t)(n * width), sizeof *by_q);
    double *by_v = calloc((size_t)(n * width), sizeof *by_v);
    unsigned seed = 7;
    assert_true(n <= MOST);
    assert_int_equal(modes_at(x.m, 0.3, NULL, &error), AD_OK);
    for (int k = 0; k < 3 * MOST; k++) {
        state[k / MOST][k % MOST] = 0.3 * noise(&seed);
    }
    for (int i = 0; i < 2; i++) { /* nothing is left over from another state */
        modes_linearise(x.m, i ? state[0] : state[1], state[1], state[2], with[0], by_q, by_v);
    }
    const double *matrices[3] = {by_q, by_v, x.m->mass};
    for (int which = 0; which < 3; which++) {
        for (int c = 0; c < n; c++) {
            for (int side = 0; side < 2; side++) {
                state[which][c] += side ? h : -h;
                modes_shape(x.m, state[0], state[1], state[2]);
                modes_forces(x.m, false, with[side]);
                state[which][c] -= side ? h : -h;
            }
            for (int r = 0; r < n; r++) {
                const double quotient = (with[1][r] - with[0][r]) / (2 * h);
                worst = fmax(worst, fabs(quotient - matrices[which][r * width + c]));
                size = fmax(size, fabs(quotient));
            }
        }
    }
    free(by_q);
    free(by_v);
    discard(&x);
    return worst / size;
}

static inline double worst_derivative(int finer, const scene_law *law, int set_count,
                                      const char *const *sets)
{
    return worst_derivative_of(everything, finer, law, set_count, sets);
}

#endif
