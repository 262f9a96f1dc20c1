#include "tools/library/answer.h"

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
                            double *values, double *jacobian, cpinn_answer *said, ad_error *error)
{
    return cpinn_family_answer(a->of, a->with, members, parameters, values, jacobian, said, error);
}

answer answer_of_family(cpinn_family *family, const cpinn_polish *polish)
{
    static const answer_kind kind = {.of_members = ask_family};
    return (answer){&kind, family, polish, &family->open, cpinn_family_columns(family)};
}
