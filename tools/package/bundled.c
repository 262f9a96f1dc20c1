/* What a bundled build has beside the sources (bundled.cmake). */
#include <stdio.h>

/* The streams of the C library, for an archive that takes them for its own variables. */
extern FILE *cpinn_stderr, *cpinn_stdout;
FILE *cpinn_stderr, *cpinn_stdout;

__attribute__((constructor)) static void set_streams(void)
{
    cpinn_stderr = stderr;
    cpinn_stdout = stdout;
}

/* Of the functions that are called only these have a version later than glibc 2.34. The older one
 * is in every release; both are within a unit in the last place. */
double old_hypot(double, double);
float old_hypotf(float, float);
__asm__(".symver old_hypot, hypot@GLIBC_2.2.5");
__asm__(".symver old_hypotf, hypotf@GLIBC_2.2.5");

double __wrap_hypot(double, double);
double __wrap_hypot(double a, double b)
{
    return old_hypot(a, b);
}

float __wrap_hypotf(float, float);
float __wrap_hypotf(float a, float b)
{
    return old_hypotf(a, b);
}
