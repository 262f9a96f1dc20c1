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

#include "physics/learn/problem.h"
#include "tools/prepare/config_experiment.h"

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
    if (prepare_read(path, NULL, count, overrides, &settings, &error) != AD_OK ||
        config_experiment_create(settings, threads, &e, &error) != AD_OK) {
        fail_msg("%s", error.message);
    }
    return e;
}

/* From a file, or from `text`; override: "key=value" or NULL. */
static inline experiment *experiment_of(const char *path, const char *text, const char *override)
{
    ad_error error = {.message = ""};
    config *settings = NULL;
    experiment *e = NULL;
    if (prepare_read(path, text, override != NULL, &override, &settings, &error) != AD_OK ||
        config_experiment_create(settings, 1, &e, &error) != AD_OK) {
        fail_msg("%s", error.message);
    }
    return e;
}

static inline made make_problem(const char *path, const char *const *changes, int threads)
{
    made m = {make_experiment(path, changes, threads), NULL};
    ad_error error = {AD_OK, ""};
    if (experiment_problem(m.e, &m.p, &error) != AD_OK) {
        fail_msg("%s", error.message);
    }
    return m;
}

static inline void made_free(made *m)
{
    problem_free(m->p);
    experiment_free(m->e);
}

static inline double loss_at(const made *m, const double *x, double *gradient)
{
    ad_error error = {AD_OK, ""};
    double loss;
    if (problem_evaluate(m->p, x, &loss, gradient, &error) != AD_OK) {
        fail_msg("%s", error.message);
    }
    return loss;
}

/* FNV-1a of the bits. */
static inline uint64_t fingerprint(const double *x, size_t count)
{
    uint64_t hash = UINT64_C(14695981039346656037);
    for (size_t i = 0; i < count * sizeof *x; i++) {
        hash = (hash ^ ((const unsigned char *)x)[i]) * UINT64_C(1099511628211);
    }
    return hash;
}

#endif
