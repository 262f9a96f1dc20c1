/* Reduced rods for tests. */
#ifndef MODES_TESTING_H
#define MODES_TESTING_H

#include "everything.h"
#include "motion_testing.h"

#include "physics/chain/modes_internal.h"

static const char everything[] = EVERYTHING("p: {range: [100, 300]}, e: {range: [0.5, 2]}", "1");

typedef struct reduced_test {
    config *settings;
    solve_rod *rod;
    modes *m;
} reduced_test;

static inline reduced_test make(const char *path, const char *text, modes_counts counts, int finer)
{
    ad_error error = {.message = ""};
    reduced_test x = {0};
    if (prepare_read_member(path, text, 0, NULL, text == everything ? "p=170,e=1.3" : NULL,
                            &x.settings, &error) != AD_OK ||
        solve_rod_create(&x.settings->scene, &x.rod, &error) != AD_OK ||
        modes_create(x.rod, NULL, &counts, finer, &x.m, &error) != AD_OK) {
        fail_msg("%s", error.message);
    }
    return x;
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

#endif
