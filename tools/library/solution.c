/* Classical solutions of what a file or a program describes. */
#include "tools/library/cpinn.h"

#include "autodiff/host.h"
#include "physics/solve/solve.h"
#include "tools/library/member_code.h"
#include "tools/prepare/prepare.h"

#include <stdlib.h>
#include <string.h>

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

/* ---- members ------------------------------------------------------------------------------- */

struct cpinn_members {
    config *settings; /* holds the formulas */
    solve_members *members;
    solve_members_settings asked;
    double *s;         /* [asked.points] */
    member_code *code; /* of few members; NULL: */
};

ad_status cpinn_members_file(const char *path, int count, const char *const *overrides,
                             const solve_members_settings *settings, cpinn_members **result,
                             ad_error *error)
{
    AD_LEAVE_HOST;
    solve_members_settings asked = *settings;
    cpinn_members *members = calloc(1, sizeof *members);
    *result = NULL;
    if (!members) {
        return ad_fail(error, AD_NO_MEMORY, "out of memory for members");
    }
    ad_status status = prepare_read(path, NULL, count, overrides, &members->settings, error);
    if (status == AD_OK) {
        status = solve_members_create(&members->settings->scene, &asked, &members->members, error);
    }
    if (status == AD_OK) {
        members->s = malloc((asked.points + 1) * sizeof *members->s);
        status = members->s ? AD_OK : ad_fail(error, AD_NO_MEMORY, "out of memory for members");
    }
    if (status != AD_OK) {
        cpinn_members_free(members);
        return status;
    }
    memcpy(members->s, asked.s, asked.points * sizeof *members->s);
    members->asked = asked;
    members->asked.s = members->s;
    *result = members;
    return AD_OK;
}

void cpinn_members_free(cpinn_members *members)
{
    if (members) {
        member_code_free(members->code);
        solve_members_free(members->members);
        config_free(members->settings);
        free(members->s);
        free(members);
    }
}

const char *cpinn_members_name(const cpinn_members *members, int parameter)
{
    const scene *family = &members->settings->scene;
    return parameter >= 0 && parameter < family->parameter_count
               ? family->parameters[parameter].name
               : NULL;
}

ad_status cpinn_members_compile(cpinn_members *members, ad_error *error)
{
    AD_LEAVE_HOST;
    return members->code ? AD_OK
                         : member_code_create_solver(&members->settings->scene, members->members,
                                                     &members->asked, &members->code, error);
}

/* Whether compiled C has found all members of a call. */
static bool is_by_code(const cpinn_members *solver, size_t members, const double *parameters,
                       double *values, double *jacobian, solve_member *results)
{
    const size_t count = (size_t)solver->settings->scene.parameter_count;
    const size_t width = solver->asked.points * SOLVE_MEMBERS_COLUMNS;
    bool result = solver->code && members <= CPINN_FEW;
    for (size_t i = 0; i < members && result; i++) {
        result = member_code_solve(solver->code, parameters + i * count, values + i * width,
                                   jacobian ? jacobian + i * width * count : NULL, results + i);
    }
    return result;
}

ad_status cpinn_members_solve(cpinn_members *solver, size_t members, const double *parameters,
                              double *values, solve_member *results, ad_error *error)
{
    AD_LEAVE_HOST;
    return is_by_code(solver, members, parameters, values, NULL, results)
               ? AD_OK
               : solve_members_solve(solver->members, members, parameters, values, results, error);
}

ad_status cpinn_members_jacobian(cpinn_members *solver, size_t members, const double *parameters,
                                 double *values, double *jacobian, solve_member *results,
                                 ad_error *error)
{
    AD_LEAVE_HOST;
    if (is_by_code(solver, members, parameters, values, jacobian, results)) {
        return AD_OK;
    }
    const size_t unknowns = 3 * solve_members_nodes(solver->members);
    double *curvature = malloc((members * unknowns + 1) * sizeof *curvature);
    ad_status status = curvature
                           ? solve_members_curvature(solver->members, members, parameters, values,
                                                     curvature, results, error)
                           : ad_fail(error, AD_NO_MEMORY, "out of memory for %zu members", members);
    if (status == AD_OK) {
        status = solve_members_jacobian(solver->members, members, parameters, curvature, jacobian,
                                        error);
    }
    free(curvature);
    return status;
}
