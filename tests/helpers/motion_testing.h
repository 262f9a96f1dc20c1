/* Motions of rods by the classical solver, from YAML, in the solver's own numbers. */
#ifndef TESTS_MOTION_TESTING_H
#define TESTS_MOTION_TESTING_H

#include "rod_testing.h"

#include "physics/solve/dynamic.h"
#include "tools/prepare/prepare.h"

#include <math.h>

typedef struct solved {
    config *settings;
    solve_rod *rod;
    dynamic_solution *motion;
    solve_report report;
} solved;

static inline void make_rod(solved *x, const char *path, const char *text)
{
    ad_error error = {.message = ""};
    *x = (solved){0};
    if (prepare_read(path, text, 0, NULL, &x->settings, &error) != AD_OK ||
        solve_rod_create(&x->settings->scene, &x->rod, &error) != AD_OK) {
        fail_msg("%s", error.message);
    }
}

static inline void solve(solved *x, int nodes, double tolerance, size_t count, const double *times)
{
    ad_error error = {.message = ""};
    solve_settings settings = {.nodes = nodes, .tolerance = tolerance};
    if (dynamic_solve(x->rod, &settings, count, times, &x->motion, &x->report, &error) != AD_OK) {
        fail_msg("%s", error.message);
    }
}

static inline solve_state state_at(const solved *x, size_t which, double s)
{
    ad_error error = {.message = ""};
    solve_state state;
    if (dynamic_at(x->motion, which, 1, &s, &state, &error) != AD_OK) {
        fail_msg("%s", error.message);
    }
    return state;
}

static inline void free_solved(solved *x)
{
    dynamic_free(x->motion);
    solve_rod_free(x->rod);
    config_free(x->settings);
}

static inline double distance(const double *a, const double *b)
{
    return hypot(hypot(a[0] - b[0], a[1] - b[1]), a[2] - b[2]);
}

#endif
