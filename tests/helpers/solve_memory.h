/* For tests: the classical solver where memory runs out. */
#ifndef TESTS_SOLVE_MEMORY_H
#define TESTS_SOLVE_MEMORY_H

#include "allocations.h"
#include "near.h"

#include "physics/solve/solve.h"

/* Whichever allocation fails, it is told (or, of a formula's value, survived) and nothing is left:
 * each of the first `all`, then one of `stride`. */
static inline void check_no_memory(const scene *given, const solve_settings *settings, size_t count,
                                   const double *times, long all, long stride)
{
    long needed = 0;
    int told = 0;
    for (long n = 0; n <= needed; n += n < all ? 1 : stride) {
        solution *x = NULL;
        solve_report report;
        allocations = 0;
        failing_allocation = n;
        ad_status status = solution_create(given, settings, count, times, &x, &report, NULL);
        failing_allocation = 0;
        needed = n == 0 ? allocations : needed;
        assert_true(status == AD_OK || (status == AD_NO_MEMORY && x == NULL));
        told += status == AD_NO_MEMORY;
        solution_free(x);
    }
    assert_true(needed > 50 && told > 30);
}

#endif
