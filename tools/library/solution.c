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

void cpinn_solution_free(cpinn_solution *solution)
{
    if (solution) {
        solution_free(solution->solved);
        config_free(solution->settings);
        free(solution);
    }
}

/* Takes over `settings`, also when it fails. */
static ad_status solve(config *settings, const cpinn_solve_options *options, size_t time_count,
                       const double *times, cpinn_solution **result, ad_error *error)
{
    cpinn_solution *solution = calloc(1, sizeof *solution);
    if (!solution) {
        config_free(settings);
        return ad_fail(error, AD_NO_MEMORY, "out of memory for a solution");
    }
    solution->settings = settings;
    solve_settings asked = solve_settings_default(&settings->scene);
    if (options && options->tolerance > 0) {
        asked.tolerance = options->tolerance;
    }
    if (options) {
        asked.perturbation = options->perturbation;
        asked.branch = options->branch;
    }
    ad_status status = solution_create(&settings->scene, &asked, time_count, times,
                                       &solution->solved, &solution->report, error);
    if (status != AD_OK) {
        cpinn_solution_free(solution);
        return status;
    }
    solution_verdict(solution->solved, &settings->scene, &asked, &solution->report,
                     &solution->verdict);
    *result = solution;
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

const verdict *cpinn_solution_verdict(const cpinn_solution *solution)
{
    return &solution->verdict;
}

double cpinn_solution_estimate(const cpinn_solution *solution)
{
    return solution->report.estimate + solve_misfit(&solution->report);
}

int cpinn_solution_columns(const cpinn_solution *solution)
{
    return solution_columns(&solution->settings->scene);
}

const char *cpinn_solution_column_name(const cpinn_solution *solution, int column)
{
    return column >= 0 && column < cpinn_solution_columns(solution)
               ? scene_physics_of(&solution->settings->scene)->columns[column].name
               : "";
}

ad_status cpinn_solution_evaluate(const cpinn_solution *solution, size_t points, const double *s,
                                  const double *t, double *values, ad_error *error)
{
    AD_LEAVE_HOST;
    const scene *of = &solution->settings->scene;
    const double length = scene_length(of), slack = EVALUATOR_BEYOND * length;
    for (size_t i = 0; i < points; i++) {
        if (s[i] < -slack || s[i] > length + slack) {
            return ad_fail(error, AD_BAD_ARGUMENT, "s is %g m; allowed: 0 to %g m", s[i], length);
        }
    }
    return solution_evaluate(solution->solved, cpinn_solution_columns(solution), points, s, t,
                             values, error);
}
