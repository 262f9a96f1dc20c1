/* Functions that are compiled for each processor copy arrays of constants as they are: GCC 12 wrote
 * ones in place of the zeros behind them, where it might store 32 or 64 bytes at once. */
#include "physics/numerics/processor.h"

#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>
#include <string.h>
/* cmocka needs those above */
#include <cmocka.h>

enum { ONES = 10, ALL = 40 };

FOR_EACH_PROCESSOR static void copy_constants(double *to)
{
    static const double ones[ALL] = {1, 1, 1, 1, 1, 1, 1, 1, 1, 1};
    for (int i = 0; i < ALL; i++) {
        to[i] = ones[i];
    }
}

static void test_constants(void **state)
{
    (void)state;
    double copied[ALL];
    copy_constants(copied);
    for (int i = 0; i < ALL; i++) {
        assert_true(copied[i] == (i < ONES));
    }
}

/* COPY(n, ones): an array [n] that begins with ones. */
#define COPY(n, ...)                                                                               \
    FOR_EACH_PROCESSOR static __attribute__((noinline)) void copy_##n(double *to)                  \
    {                                                                                              \
        const double ones[n] = {__VA_ARGS__};                                                      \
        memcpy(to, ones, sizeof ones);                                                             \
    }
COPY(4, 1, 1)
COPY(5, 1, 1, 1)
COPY(8, 1, 1, 1, 1, 1, 1)
COPY(9, 1, 1, 1, 1, 1, 1, 1)
COPY(16, 1, 1, 1, 1, 1, 1, 1, 1, 1, 1)

static void test_local(void **state)
{
    (void)state;
    static const struct {
        int count, ones;
        void (*copy)(double *to);
    } tried[] = {{4, 2, copy_4}, {5, 3, copy_5}, {8, 6, copy_8}, {9, 7, copy_9}, {16, 10, copy_16}};
    for (size_t k = 0; k < sizeof tried / sizeof *tried; k++) {
        double copied[ALL];
        tried[k].copy(copied);
        for (int i = 0; i < tried[k].count; i++) {
            assert_true(copied[i] == (i < tried[k].ones));
        }
    }
}

int main(void)
{
    const struct CMUnitTest tests[] = {cmocka_unit_test(test_constants),
                                       cmocka_unit_test(test_local)};
    return cmocka_run_group_tests(tests, NULL, NULL);
}
