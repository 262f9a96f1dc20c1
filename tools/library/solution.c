/* Classical solutions of what a file or a program describes. */
#include "tools/library/cpinn.h"

#include "autodiff/host.h"
#include "physics/solve/solve.h"
#include "tools/prepare/prepare.h"

#include <stdlib.h>

struct cpinn_solution {
    config *settings; /* holds the scene */
    solution *solved;
    solve_report report;
    verdict verdict;
};

void cpinn_solution_free(cpinn_solution *x)
{
    if (x) {
        solution_free(x->solved);
        config_free(x->settings);
        free(x);
    }
}

/* Takes over `settings`, also when it fails. */
static ad_status solve(config *settings, const cpinn_solve_options *options, size_t time_count,
                       const double *times, cpinn_solution **result, ad_error *error)
{
    cpinn_solution *x = calloc(1, sizeof *x);
    if (!x) {
        config_free(settings);
        return ad_fail(error, AD_NO_MEMORY, "out of memory for a solution");
    }
    x->settings = settings;
    solve_settings asked = solve_settings_default(&settings->scene);
    if (options && options->tolerance > 0) {
        asked.tolerance = options->tolerance;
    }
    if (options) {
        asked.perturbation = options->perturbation;
        asked.branch = options->branch;
    }
    ad_status status =
        solution_create(&settings->scene, &asked, time_count, times, &x->solved, &x->report, error);
    if (status != AD_OK) {
        cpinn_solution_free(x);
        return status;
    }
    solution_verdict(x->solved, &settings->scene, &asked, &x->report, &x->verdict);
    *result = x;
    return AD_OK;
}

ad_status cpinn_solve_file(const char *path, int count, const char *const *overrides,
                           const cpinn_solve_options *options, size_t time_count,
                           const double *times, cpinn_solution **result, ad_error *error)
{
    AD_LEAVE_HOST;
    config *settings;
    *result = NULL;
    ad_status status = prepare_read_member(path, NULL, count, overrides, NULL, &settings, error);
    return status == AD_OK ? solve(settings, options, time_count, times, result, error) : status;
}

ad_status cpinn_solve_scene(const scene *rod_scene, double tolerance, size_t time_count,
                            const double *times, cpinn_solution **result, ad_error *error)
{
    AD_LEAVE_HOST;
    const train_settings usual = train_settings_default();
    const cpinn_solve_options options = {.tolerance = tolerance};
    config *made;
    *result = NULL;
    ad_status status = prepare_create(rod_scene, &usual, &made, error);
    return status == AD_OK ? solve(made, &options, time_count, times, result, error) : status;
}

const verdict *cpinn_solution_verdict(const cpinn_solution *x)
{
    return &x->verdict;
}

double cpinn_solution_estimate(const cpinn_solution *x)
{
    return x->report.estimate + solve_misfit(&x->report);
}

int cpinn_solution_columns(const cpinn_solution *x)
{
    return solution_columns(&x->settings->scene);
}

const char *cpinn_solution_column_name(const cpinn_solution *x, int column)
{
    return column >= 0 && column < cpinn_solution_columns(x)
               ? scene_physics_of(&x->settings->scene)->columns[column].name
               : "";
}

ad_status cpinn_solution_evaluate(const cpinn_solution *x, size_t points, const double *s,
                                  const double *t, double *values, ad_error *error)
{
    AD_LEAVE_HOST;
    const scene *of = &x->settings->scene;
    const double length = scene_length(of), slack = EVALUATOR_BEYOND * length;
    for (size_t i = 0; i < points; i++) {
        if (s[i] < -slack || s[i] > length + slack) {
            return ad_fail(error, AD_BAD_ARGUMENT, "s is %g m; allowed: 0 to %g m", s[i], length);
        }
    }
    return solution_evaluate(x->solved, cpinn_solution_columns(x), points, s, t, values, error);
}

/* ---- members ------------------------------------------------------------------------------- */

struct cpinn_members {
    config *settings; /* holds the formulas */
    solve_members *members;
};

ad_status cpinn_members_file(const char *path, int count, const char *const *overrides,
                             const solve_members_settings *settings, cpinn_members **result,
                             ad_error *error)
{
    AD_LEAVE_HOST;
    solve_members_settings asked = *settings;
    cpinn_members *x = calloc(1, sizeof *x);
    *result = NULL;
    if (!x) {
        return ad_fail(error, AD_NO_MEMORY, "out of memory for members");
    }
    ad_status status = prepare_read(path, NULL, count, overrides, &x->settings, error);
    if (status == AD_OK) {
        status = solve_members_create(&x->settings->scene, &asked, &x->members, error);
    }
    if (status != AD_OK) {
        cpinn_members_free(x);
        return status;
    }
    *result = x;
    return AD_OK;
}

void cpinn_members_free(cpinn_members *x)
{
    if (x) {
        solve_members_free(x->members);
        config_free(x->settings);
        free(x);
    }
}

const char *cpinn_members_name(const cpinn_members *x, int parameter)
{
    const scene *family = &x->settings->scene;
    return parameter >= 0 && parameter < family->parameter_count
               ? family->parameters[parameter].name
               : NULL;
}

ad_status cpinn_members_solve(cpinn_members *x, size_t members, const double *parameters,
                              double *values, solve_member *results, ad_error *error)
{
    AD_LEAVE_HOST;
    return solve_members_solve(x->members, members, parameters, values, results, error);
}

ad_status cpinn_members_jacobian(cpinn_members *x, size_t members, const double *parameters,
                                 double *values, double *jacobian, solve_member *results,
                                 ad_error *error)
{
    AD_LEAVE_HOST;
    const size_t unknowns = 3 * solve_members_nodes(x->members);
    double *curvature = malloc((members * unknowns + 1) * sizeof *curvature);
    ad_status status = curvature
                           ? solve_members_curvature(x->members, members, parameters, values,
                                                     curvature, results, error)
                           : ad_fail(error, AD_NO_MEMORY, "out of memory for %zu members", members);
    if (status == AD_OK) {
        status =
            solve_members_jacobian(x->members, members, parameters, curvature, jacobian, error);
    }
    free(curvature);
    return status;
}
