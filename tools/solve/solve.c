#include "tools/solve/solve.h"

#include "tools/solve/dynamic.h"
#include "tools/solve/static.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

struct solution {
    solve_rod *rod;
    static_solution *at_rest; /* one of the two */
    dynamic_solution *moving;
    size_t count;
    double *times; /* [count] */
};

solve_settings solve_settings_default(void)
{
    return (solve_settings){.tolerance = 1e-10};
}

static ad_status solve_motion(solution *x, const solve_settings *settings, solve_report *report,
                              ad_error *error)
{
    ad_status status =
        dynamic_solve(x->rod, settings, x->count, x->times, &x->moving, report, error);
    if (status != AD_BAD_INPUT) {
        return status;
    }
    if (error) {
        error->status = AD_BAD_ARGUMENT; /* no place in a file is known here */
    }
    return AD_BAD_ARGUMENT;
}

static ad_status solve(solution *x, const scene *rod_scene, const solve_settings *settings,
                       const double *times, solve_report *report, ad_error *error)
{
    if (scene_is_beam(rod_scene)) {
        return ad_fail(
            error, AD_BAD_ARGUMENT,
            "rod.model: beams of small deflection are not solved here; allowed: kirchhoff, "
            "cosserat");
    }
    x->times = malloc((x->count + 1) * sizeof *x->times);
    ad_status status = x->times ? solve_rod_create(rod_scene, &x->rod, error)
                                : ad_fail(error, AD_NO_MEMORY, "out of memory for a solution");
    if (status != AD_OK) {
        return status;
    }
    if (!x->rod->dynamic) {
        return static_solve(x->rod, settings, &x->at_rest, report, error);
    }
    memcpy(x->times, times, x->count * sizeof *times);
    return solve_motion(x, settings, report, error);
}

ad_status solution_create(const scene *rod_scene, const solve_settings *settings, size_t count,
                          const double *times, solution **result, solve_report *report,
                          ad_error *error)
{
    *result = NULL;
    solution *x = calloc(1, sizeof *x);
    if (!x) {
        return ad_fail(error, AD_NO_MEMORY, "out of memory for a solution");
    }
    x->count = count;
    ad_status status = solve(x, rod_scene, settings, times, report, error);
    if (status != AD_OK) {
        solution_free(x);
        return status;
    }
    *result = x;
    return AD_OK;
}

void solution_free(solution *x)
{
    if (x) {
        static_free(x->at_rest);
        dynamic_free(x->moving);
        solve_rod_free(x->rod);
        free(x->times);
        free(x);
    }
}

const solve_rod *solution_rod(const solution *x)
{
    return x->rod;
}

ad_status solution_at(const solution *x, size_t n, const double *s, double t, solve_state *out,
                      ad_error *error)
{
    if (x->at_rest) {
        return static_at(x->at_rest, n, s, out, error);
    }
    size_t nearest = 0;
    for (size_t i = 1; i < x->count; i++) {
        nearest = fabs(x->times[i] - t) < fabs(x->times[nearest] - t) ? i : nearest;
    }
    return dynamic_at(x->moving, nearest, n, s, out, error);
}
