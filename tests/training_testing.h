/* For tests of problems and training: a shipped scene made small, its network and its problem. */
#ifndef TESTS_TRAINING_TESTING_H
#define TESTS_TRAINING_TESTING_H

#include <math.h>
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include <cmocka.h>

#include "physics/problem.h"
#include "tools/config/config_experiment.h"

enum { OVERRIDES_MAX = 40 };

typedef struct made {
    experiment *e;
    problem *p;
} made;

/* `changes`: "key=value" texts, NULL at the end. The seconds that programs wait for are far away.
 */
static inline experiment *make_experiment(const char *path, const char *const *changes, int threads)
{
    const char *overrides[OVERRIDES_MAX] = {"network.hidden=[6, 5]", "network.fourier.features=0",
                                            "losses.held_out_points=16",
                                            "losses.interior.points=24"};
    int count = 4;
    for (int i = 0; changes && changes[i]; i++) {
        assert_true(count < OVERRIDES_MAX);
        overrides[count++] = changes[i];
    }
    ad_error error = {AD_OK, ""};
    config *settings = NULL;
    experiment *e = NULL;
    if (config_read(path, NULL, count, overrides, &settings, &error) != AD_OK ||
        config_experiment_create(settings, threads, &e, &error) != AD_OK) {
        fail_msg("%s", error.message);
    }
    return e;
}

static inline ad_status try_problem(const experiment *e, problem **p, ad_error *error)
{
    return experiment_problem(e, p, error);
}

static inline made make_problem(const char *path, const char *const *changes, int threads)
{
    made m = {make_experiment(path, changes, threads), NULL};
    ad_error error = {AD_OK, ""};
    if (try_problem(m.e, &m.p, &error) != AD_OK) {
        fail_msg("%s", error.message);
    }
    return m;
}

static inline void made_free(made *m)
{
    problem_free(m->p);
    experiment_free(m->e);
}

#endif
