/* What is given along a rod at rest, for quadrature: compliances, rest shape, laws outside,
 * actuators. */
#include "physics/local/rod_model.h"

#include <math.h>
#include <string.h>

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
    size_t pulling = (size_t)rod->actuators;
    solve_section sections[QUADRATURE_BATCH];
    solve_rest rest[QUADRATURE_BATCH];
    double along[QUADRATURE_BATCH * ACTING_ALONG_MAX];
    const size_t numbers = (size_t)rod->along.numbers;
    solve_actuator actuators[QUADRATURE_BATCH * SOLVE_ACTUATORS_MAX];
    ad_status status = solve_rod_sections(rod, n, s, sections, error);
    status = status == AD_OK ? solve_rod_rest(rod, n, s, 0, rest, error) : status;
    status = status == AD_OK ? solve_rod_along(rod, n, s, 0, along, error) : status;
    if (status == AD_OK && pulling > 0) {
        status = solve_rod_actuators(rod, n, s, 0, actuators, error);
    }
    for (size_t i = 0; i < n && status == AD_OK; i++) {
        const double *first = out;
        out = append(out, sections[i].compliance, 6);
        out = append(out, rest[i].strain, 3);
        out = append(out, rest[i].curvature, 3);
        out = append(out, rest[i].imperfection, 3);
        out = append(out, along + i * numbers, numbers);
        out = append(out, (const double *)&actuators[i * pulling],
                     pulling * sizeof *actuators / sizeof(double));
        status = check_finite(rod, s[i], first, out, error);
    }
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
