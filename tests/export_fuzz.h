/* For programs that fuzz exported C, compiled with the sanitizers: numbers that nobody expects. */
#ifndef TESTS_EXPORT_FUZZ_H
#define TESTS_EXPORT_FUZZ_H

#include "helpers/random_numbers.h"

#include <fenv.h>
#include <float.h>
#include <math.h>
#include <stdio.h>
#include <string.h>

static uint64_t fuzz_random = 1;
static int fuzz_failures;

/* One line for the first of them. */
static inline void fuzz_require(int so, const char *what, int round)
{
    if (!so && fuzz_failures++ == 0) {
        printf("round %d: %s\n", round, what);
    }
}

/* One in `rare` is no good number; else between low and high. */
static inline double fuzz_number(double low, double high, int rare)
{
    const double wild[] = {NAN,   INFINITY, -INFINITY, 1e308,        -1e308,        DBL_MAX,
                           1e300, -1e300,   1e155,     -1e100,       1e40,          -1e39,
                           1e20,  -1e16,    1e10,      -1e6,         1e3,           0.0,
                           -0.0,  DBL_MIN,  5e-324,    -5e-324,      1e-160,        low,
                           high,  low - 1,  high + 1,  2147483648.0, -2147483649.0, 9.3e18};
    return random_below(&fuzz_random, rare) == 0
               ? wild[random_below(&fuzz_random, (int)(sizeof wild / sizeof *wild))]
               : random_in(&fuzz_random, low, high);
}

/* In a host that has made exceptions of floating-point numbers signals: one ends the test. For
 * glibc, with _GNU_SOURCE. */
static inline void fuzz_trap(int traps)
{
#ifdef FE_NOMASK_ENV
    const int exceptions = FE_INVALID | FE_DIVBYZERO | FE_OVERFLOW;
    feclearexcept(FE_ALL_EXCEPT);
    if (traps) {
        feenableexcept(exceptions);
    } else {
        fedisableexcept(exceptions);
    }
#else
    (void)traps;
#endif
}

/* What the caller's memory has before a call makes no difference. */
static inline void fuzz_fill(void *memory, size_t size)
{
    static const unsigned char bytes[] = {0x00, 0xff, 0x7f, 0xfe};
    memset(memory, bytes[random_below(&fuzz_random, 4)], size);
}

static inline int fuzz_finite(int count, const double *list)
{
    for (int i = 0; i < count; i++) {
        if (!isfinite(list[i])) {
            return 0;
        }
    }
    return 1;
}

#endif
