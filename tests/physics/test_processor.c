/* Functions that are compiled for each processor copy arrays of constants as they are: GCC 12 wrote
 * ones in place of the zeros behind them, where it might store 64 bytes at once. */
#include "physics/numerics/processor.h"

#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>
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

int main(void)
{
    const struct CMUnitTest tests[] = {cmocka_unit_test(test_constants)};
    return cmocka_run_group_tests(tests, NULL, NULL);
}
