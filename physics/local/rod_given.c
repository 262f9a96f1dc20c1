/* What is given along a rod at rest, for quadrature: compliances, rest shape, laws outside,
 * actuators. */
#include "physics/local/rod_model.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

ad_status solve_rod_points_make(const solve_rod *rod, size_t n, const double *s,
                                solve_rod_points *points, ad_error *error)
{
    const size_t numbers = (size_t)rod->along.numbers, pulling = (size_t)rod->actuators;
    *points = (solve_rod_points){.sections = NULL};
    AD_TAKE(points, sections, n);
    AD_TAKE(points, rest, n);
    AD_TAKE(points, along, n * numbers);
    AD_TAKE(points, actuators, n * pulling);
    ad_status status = ad_memory_status(&points->memory, error, "out of memory for %zu points", n);
    status = status == AD_OK ? solve_rod_sections(rod, n, s, points->sections, error) : status;
    status = status == AD_OK ? solve_rod_rest(rod, n, s, 0, points->rest, error) : status;
    status = status == AD_OK ? solve_rod_along(rod, n, s, 0, points->along, error) : status;
    return status == AD_OK && pulling > 0
               ? solve_rod_actuators(rod, n, s, 0, points->actuators, error)
               : status;
}

void solve_rod_points_clear(solve_rod_points *points)
{
    ad_memory_free(&points->memory);
}

/* A path of equilibria that ends there would be the wrong answer. */
static ad_status check_finite(const solve_rod *rod, double s, const double *from, const double *to,
                              ad_error *error)
{
    for (; from < to; from++) {
        if (!isfinite(*from)) {
            return ad_fail(error, AD_NOT_FINITE,
                           "what loads, holds or shapes the rod is not finite at s = %g m",
                           s * rod->scales.length);
        }
    }
    return AD_OK;
}

static double *append(double *to, const double *from, size_t count)
{
    memcpy(to, from, count * sizeof *to);
    return to + count;
}

static ad_status given_at(const void *context, size_t n, const double *s, double *out,
                          ad_error *error)
{
    const solve_rod *rod = context;
    const size_t numbers = (size_t)rod->along.numbers, pulling = (size_t)rod->actuators;
    solve_rod_points at;
    ad_status status = solve_rod_points_make(rod, n, s, &at, error);
    for (size_t i = 0; i < n && status == AD_OK; i++) {
        const double *first = out;
        out = append(out, at.sections[i].compliance, 6);
        out = append(out, at.rest[i].strain, 3);
        out = append(out, at.rest[i].curvature, 3);
        out = append(out, at.rest[i].imperfection, 3);
        out = append(out, at.along + i * numbers, numbers);
        out = append(out, (const double *)&at.actuators[i * pulling],
                     pulling * sizeof *at.actuators / sizeof(double));
        status = check_finite(rod, s[i], first, out, error);
    }
    solve_rod_points_clear(&at);
    return status;
}

solve_given solve_rod_given(const solve_rod *rod)
{
    enum { ROWS = 15, EACH = sizeof(solve_actuator) / sizeof(double) };
    _Static_assert(ROWS + ACTING_ALONG_MAX + EACH * SOLVE_ACTUATORS_MAX <= QUADRATURE_ROWS_MAX,
                   "too many");
    return (solve_given){
        .rows = ROWS + rod->along.numbers + EACH * rod->actuators, .at = given_at, .context = rod};
}
