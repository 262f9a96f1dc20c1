#include "tools/library/answer.h"

#include <math.h>
#include <stdlib.h>

static ad_status ask_network(const answer *a, size_t points, const double *s, const double *t,
                             double *values, ad_error *error)
{
    return field_evaluate(a->of, a->with, points, (const double *const[]){s, t}, values, error);
}

answer answer_of_network(field *trained, const double *weights, const scene *of)
{
    static const answer_kind kind = {.at_points = ask_network};
    return (answer){&kind, trained, weights, of, field_columns(trained)};
}

static ad_status ask_solution(const answer *a, size_t points, const double *s, const double *t,
                              double *values, ad_error *error)
{
    return solution_evaluate(a->with, a->columns, points, s, t, values, error);
}

answer answer_of_solution(const solution *solved, const scene *of)
{
    static const answer_kind kind = {.at_points = ask_solution};
    return (answer){&kind, NULL, solved, of, solution_columns(of)};
}

static ad_status ask_family(const answer *a, size_t members, const double *parameters,
                            double *values, cpinn_answer *said, ad_error *error)
{
    return cpinn_family_evaluate(a->of, a->with, members, parameters, values, said, error);
}

answer answer_of_family(cpinn_family *family, const cpinn_polish *polish)
{
    static const answer_kind kind = {.of_members = ask_family};
    return (answer){&kind, family, polish, &family->open, cpinn_family_columns(family)};
}

static ad_status ask_members(const answer *a, size_t members, const double *parameters,
                             double *values, cpinn_answer *said, ad_error *error)
{
    solve_member *results = malloc((members + 1) * sizeof *results);
    ad_status status = results
                           ? solve_members_solve(a->of, members, parameters, values, results, error)
                           : ad_fail(error, AD_NO_MEMORY, "out of memory for %zu members", members);
    for (size_t i = 0; i < members && status == AD_OK; i++) {
        said[i] =
            (cpinn_answer){.error = results[i].estimate * scene_length(a->scene),
                           .network_error = NAN,
                           .source = results[i].solved ? CPINN_FROM_MEMBERS : CPINN_FROM_NOTHING,
                           .trusted = results[i].solved};
    }
    free(results);
    return status;
}

answer answer_of_members(solve_members *solver, const scene *of)
{
    static const answer_kind kind = {.of_members = ask_members};
    return (answer){&kind, solver, NULL, of, SOLVE_MEMBERS_COLUMNS};
}
