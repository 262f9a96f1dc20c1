#include "tools/train/witness.h"

#include "physics/field.h"
#include "physics/solve/solve.h"
#include "physics/sort.h"

#include <math.h>

enum { POINTS = 21 };

/* Far below what networks of families reach. */
static const double TOLERANCE = 1e-8;

/* Positions [3][POINTS] of one member. False: there is no solution, or one with a warning. */
static bool solve_one(const scene *member, const double *s, double *positions)
{
    const solve_settings asked = {.tolerance = TOLERANCE};
    solution *solved = NULL;
    solve_report report;
    verdict said = {.count = 0};
    ad_error ignored;
    bool found = solution_create(member, &asked, 0, NULL, &solved, &report, &ignored) == AD_OK &&
                 report.load_fraction == 1 &&
                 solution_evaluate(solved, 3, POINTS, s, NULL, positions, &ignored) == AD_OK;
    if (found) {
        solution_verdict(solved, member, &asked, &report, &said);
    }
    solution_free(solved);
    return found && verdict_outcome_of(&said) == VERDICT_SOLVED;
}

static double distance(const double *a, const double *b)
{
    double largest = 0;
    for (int i = 0; i < POINTS; i++) {
        const double off = hypot(hypot(a[i] - b[i], a[POINTS + i] - b[POINTS + i]),
                                 a[2 * POINTS + i] - b[2 * POINTS + i]);
        largest = off <= largest ? largest : isnan(off) ? INFINITY : off;
    }
    return largest;
}

static ad_status compare(const experiment *e, field *network, nn_rng *rng, double *off, bool *found,
                         ad_error *error)
{
    const scene *family = e->scene;
    double s[POINTS], exact[3 * POINTS], values[MODEL_COLUMNS_MAX * POINTS];
    double more[SCENE_PARAMETERS_MAX][POINTS], member_values[SCENE_PARAMETERS_MAX];
    const double *at[DOMAIN_COORDINATES_MAX] = {s};
    scene member;
    for (int i = 0; i < POINTS; i++) {
        s[i] = scene_length(family) * i / (POINTS - 1);
    }
    for (int k = 0; k < family->parameter_count; k++) {
        member_values[k] = scene_parameter_at(&family->parameters[k], nn_rng_uniform(rng));
        for (int i = 0; i < POINTS; i++) {
            more[k][i] = member_values[k];
        }
        at[1 + k] = more[k];
    }
    scene_member(family, member_values, &member);
    *found = solve_one(&member, s, exact);
    ad_status status =
        *found ? field_evaluate(network, experiment_parameters(e), POINTS, at, values, error)
               : AD_OK;
    *off = *found && status == AD_OK ? distance(values, exact) / scene_length(family) : 0;
    return status;
}

ad_status witness_members(const experiment *e, witness_errors *result, ad_error *error)
{
    double off[WITNESS_MEMBERS];
    nn_rng rng = nn_rng_split(e->settings->seed, "witness");
    field *network = NULL;
    int n = 0;
    *result = (witness_errors){NAN, NAN, NAN, 0};
    ad_status status = field_create(e->model, e->mlp, false, e->pool, &network, error);
    for (int m = 0; status == AD_OK && m < WITNESS_MEMBERS; m++) {
        bool found;
        status = compare(e, network, &rng, &off[n], &found, error);
        n += found;
    }
    field_free(network);
    if (status == AD_OK && n > 0) {
        sort_ascending((size_t)n, off);
        *result = (witness_errors){off[n / 2], off[(n * 95 - 1) / 100], off[n - 1], n};
    }
    return status;
}
