#include "tools/solve/solve.h"

#include "tools/solve/static.h"

#include <stdlib.h>

struct solution {
    solve_rod *rod;
    static_solution *at_rest;
};

solve_settings solve_settings_default(void)
{
    return (solve_settings){.tolerance = 1e-10};
}

ad_status solution_create(const scene *rod_scene, const solve_settings *settings, solution **result,
                          solve_report *report, ad_error *error)
{
    *result = NULL;
    if (scene_is_dynamic(rod_scene)) {
        return ad_fail(error, AD_BAD_ARGUMENT,
                       "the scene is dynamic; only static ones are solved: --set time.duration=0");
    }
    solution *x = calloc(1, sizeof *x);
    ad_status status = x ? solve_rod_create(rod_scene, &x->rod, error)
                         : ad_fail(error, AD_NO_MEMORY, "out of memory for a solution");
    if (status == AD_OK) {
        status = static_solve(x->rod, settings, &x->at_rest, report, error);
    }
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
        solve_rod_free(x->rod);
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
    (void)t;
    return static_at(x->at_rest, n, s, out, error);
}
