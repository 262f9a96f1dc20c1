/* For tests: doubles compared with a tolerance; cmocka itself rounds to float. */
#ifndef TESTS_NEAR_H
#define TESTS_NEAR_H

#include <math.h>
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>

#include <cmocka.h>

/* |value - expected| <= tolerance; not a number fails. */
#define assert_near(value, expected, tolerance)                                                    \
    check_near(value, expected, tolerance, __FILE__, __LINE__)

static inline void check_near(double value, double expected, double tolerance, const char *file,
                              int line)
{
    if (!(fabs(value - expected) <= tolerance)) {
        print_error("%.17g is not %.17g: off by %.3g, %.3g is allowed\n", value, expected,
                    fabs(value - expected), tolerance);
        _fail(file, line);
    }
}

#endif
