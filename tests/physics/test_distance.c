/* How far shapes are apart: known distances, and numbers that are none, wherever they stand. */
#include "physics/numerics/distance.h"

#include <setjmp.h>
#include <stdarg.h>
#include <stdint.h>
/* cmocka needs those above */
#include <cmocka.h>

enum { POINTS = 3, COORDINATES = 3 };

/* The second point is off by (3, 4, 12), 13 exactly. */
static void test_both_layouts(void **state)
{
    (void)state;
    const double zero[POINTS * COORDINATES] = {0};
    const double by_point[POINTS * COORDINATES] = {1, 0, 0, 3, 4, 12, 0, 2, 0};
    const double by_coordinate[POINTS * COORDINATES] = {1, 3, 0, 0, 4, 2, 0, 12, 0};
    assert_true(largest_distance(POINTS, COORDINATES, COORDINATES, 1, by_point, zero) == 13);
    assert_true(largest_distance(POINTS, COORDINATES, 1, POINTS, by_coordinate, zero) == 13);
}

static void test_no_number(void **state)
{
    (void)state;
    const double zero[POINTS * COORDINATES] = {0};
    for (int i = 0; i < POINTS * COORDINATES; i++) {
        double off[POINTS * COORDINATES] = {1, 2, 3, 4, 5, 6, 7, 8, 9};
        off[i] = NAN;
        assert_true(isinf(largest_distance(POINTS, COORDINATES, COORDINATES, 1, off, zero)));
        assert_true(isinf(largest_distance(POINTS, COORDINATES, COORDINATES, 1, zero, off)));
    }
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_both_layouts),
        cmocka_unit_test(test_no_number),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
