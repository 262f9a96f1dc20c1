#include "tools/programs/motion_derivatives.h"

#include "tools/prepare/prepare.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

ad_status motion_derivatives_open(const char *path, const cli_list *overrides, const char *at,
                                  samples *grid, motion_derivatives *result, ad_error *error)
{
    ad_status status =
        prepare_read(path, NULL, overrides->count, overrides->texts, &result->family, error);
    if (status != AD_OK) {
        return status;
    }
    const scene *family = &result->family->scene;
    grid->derives = true;
    grid->parameters = calloc((size_t)family->parameter_count + 1, sizeof(double));
    const int states = family->memory_count, asked = family->parameter_count - states;
    return grid->parameters
               ? scene_member_read(asked, family->parameters, false, at, grid->parameters, error)
               : ad_fail(error, AD_NO_MEMORY, "out of memory for parameters");
}

void motion_derivatives_free(motion_derivatives *of)
{
    motion_change_free(of->change);
    free(of->at);
    config_free(of->family);
}

ad_status motion_derivatives_find(motion_derivatives *of, const scene *member, samples *grid,
                                  const solve_settings *settings, ad_error *error)
{
    const int *modes = settings->modes;
    of->allowed = modes[0] + modes[1] + modes[2] + modes[3] > 0
                      ? INFINITY
                      : MOTION_CHANGE_OF_TOLERANCE * settings->tolerance;
    if (!of->family) {
        return AD_OK;
    }
    of->at = malloc((grid->count + 1) * sizeof *of->at);
    if (!of->at) {
        return ad_fail(error, AD_NO_MEMORY, "out of memory for %zu points", grid->count);
    }
    memcpy(of->at, grid->s, grid->count * sizeof *of->at);
    for (size_t i = 0; i < grid->count; i++) {
        const double place = scene_place_at(member, NULL, grid->s[i], grid->t[i]);
        grid->s[i] = scene_s_of_place(&of->family->scene, grid->parameters, place, grid->t[i]);
    }
    return motion_change_create(&of->family->scene, grid->parameters, settings, grid->count,
                                grid->t, &of->change, &of->report, error);
}

static ad_status ask_member(const answer *a, size_t points, const double *s, const double *t,
                            double *values, ad_error *error)
{
    const motion_derivatives *of = a->of;
    (void)s;
    return solution_evaluate(a->with, a->columns, points, of->at, t, values, error);
}

static ad_status ask_change(const answer *a, size_t points, const double *s, const double *t,
                            double *by, ad_error *error)
{
    const motion_derivatives *of = a->of;
    return motion_change_evaluate(of->change, a->columns, points, s, t, by, error);
}

answer motion_derivatives_answer(motion_derivatives *of, const solution *solved)
{
    static const answer_kind kind = {.at_points = ask_member, .change_at_points = ask_change};
    const scene *family = &of->family->scene;
    return (answer){&kind, of, solved, family, solution_columns(family)};
}

static const char *worst_parameter(const motion_derivatives *of)
{
    return of->family->scene.parameters[of->report.worst].name;
}

void motion_derivatives_judge(const motion_derivatives *of, verdict *to)
{
    if (of->change && of->allowed < INFINITY && !(of->report.estimate <= of->allowed)) {
        verdict_add(to, VERDICT_ESTIMATE_ABOVE_TOLERANCE, "of derivatives by %s: %.2g, above %.2g",
                    worst_parameter(of), of->report.estimate, of->allowed);
    }
}

void motion_derivatives_print(const motion_derivatives *of)
{
    if (of->change) {
        printf("  derivatives              by %d parameters; estimated error %.2g of those of the "
               "position by %s, relative L2\n",
               of->family->scene.parameter_count, of->report.estimate, worst_parameter(of));
    }
}

void motion_derivatives_json(const motion_derivatives *of, json *to)
{
    if (of->change) {
        json_number(to, "derivatives_estimated_error", of->report.estimate);
        json_text(to, "derivatives_least_exact_by", worst_parameter(of));
    }
}
