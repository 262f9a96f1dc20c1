/* For tests: the numbers of recorded values at some points. */
#ifndef TESTS_EVALUATE_H
#define TESTS_EVALUATE_H

#include "autodiff/ad.h"
#include "near.h"

#include <math.h>
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>
#include <stdlib.h>
#include <string.h>

#include <cmocka.h>

/* results[i] is [rows][points] also for uniform values. Fails the test on any error. */
static inline void evaluate(int count, const ad_value *values, size_t points,
                            const double *const *inputs, const double *parameters,
                            double *const *results)
{
    ad_error error = {.message = ""};
    ad_pool *pool = ad_pool_create(1);
    assert_non_null(pool);
    ad_settings settings = ad_settings_default();
    ad_program *program = NULL;
    if (ad_compile(count, values, &settings, pool, &program, &error) != AD_OK)
        fail_msg("compile: %s", error.message);
    ad_run run = {.points = points, .inputs = inputs, .parameters = parameters, .outputs = results};
    if (ad_execute(program, &run, &error) != AD_OK)
        fail_msg("execute: %s", error.message);
    for (int i = 0; i < count; i++) {
        int rows = ad_rows(values[i]);
        for (int row = rows - 1; row >= 0 && ad_extent_of(values[i]) == AD_UNIFORM; row--) {
            double number = results[i][row];
            for (size_t k = points; k-- > 0;)
                results[i][(size_t)row * points + k] = number;
        }
    }
    ad_program_free(program);
    ad_pool_free(pool);
}

/* One value of two one-row inputs s, t; the caller frees [rows][points]. */
static inline double *evaluate_at(ad_value value, size_t points, const double *s, const double *t,
                                  const double *parameters)
{
    size_t numbers = (size_t)ad_rows(value) * points;
    double *result = malloc((numbers > 0 ? numbers : 1) * sizeof *result);
    assert_non_null(result);
    evaluate(1, &value, points, (const double *const[]){s, t}, parameters, (double *[]){result});
    return result;
}

#endif
