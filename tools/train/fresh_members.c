#include "tools/train/fresh_members.h"

#include "autodiff/ranks.h"
#include "physics/learn/field.h"
#include "physics/numerics/distance.h"
#include "physics/numerics/sort.h"
#include "physics/solve/solve.h"

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

/* A fresh member. */
typedef struct fresh_member {
    double parameters[SCENE_PARAMETERS_MAX];
    double exact[3 * POINTS]; /* positions of its solution */
    int found;                /* it has one */
} fresh_member;

typedef struct fresh_members {
    const scene *family;
    double s[POINTS];
    fresh_member all[FRESH_MEMBERS];
} fresh_members;

static void draw(const experiment *e, fresh_members *members)
{
    nn_rng rng = nn_rng_split(e->settings->seed, "witness");
    *members = (fresh_members){.family = e->scene};
    for (int i = 0; i < POINTS; i++) {
        members->s[i] = scene_length(e->scene) * i / (POINTS - 1);
    }
    for (int m = 0; m < FRESH_MEMBERS; m++) {
        for (int k = 0; k < e->scene->parameter_count; k++) {
            members->all[m].parameters[k] =
                scene_parameter_at(&e->scene->parameters[k], nn_rng_uniform(&rng));
        }
    }
}

static ad_status solve_item(void *context, int item, int thread, ad_error *error)
{
    fresh_members *members = context;
    fresh_member *one = &members->all[item];
    scene member;
    (void)thread;
    (void)error;
    scene_member(members->family, one->parameters, &member);
    one->found = solve_one(&member, members->s, one->exact);
    return AD_OK;
}

static ad_status compare(const experiment *e, field *network, const fresh_members *members, int m,
                         double *off, ad_error *error)
{
    const fresh_member *one = &members->all[m];
    double values[MODEL_COLUMNS_MAX * POINTS];
    field_member(network, one->parameters);
    ad_status status = field_evaluate(network, experiment_parameters(e), POINTS,
                                      (const double *const[]){members->s}, values, error);
    *off = status == AD_OK ? largest_distance(POINTS, 3, 1, POINTS, values, one->exact) /
                                 scene_length(members->family)
                           : 0;
    return status;
}

ad_status fresh_members_compare(const experiment *e, fresh_errors *result, ad_error *error)
{
    double off[FRESH_MEMBERS];
    fresh_members x;
    field *network = NULL;
    int n = 0;
    const ad_dealt made = {x.all, sizeof *x.all, sizeof x.all};
    *result = (fresh_errors){NAN, NAN, NAN, 0};
    draw(e, &x);
    ad_status status = field_create(e->model, e->mlp, false, e->pool, &network, error);
    if (status == AD_OK) {
        status = ad_pool_deal(e->pool, FRESH_MEMBERS, solve_item, &x, 1, &made, error);
    }
    for (int m = 0; status == AD_OK && m < FRESH_MEMBERS; m++) {
        status = x.all[m].found ? compare(e, network, &x, m, &off[n], error) : AD_OK;
        n += x.all[m].found;
    }
    field_free(network);
    if (status == AD_OK && n > 0) {
        sort_ascending((size_t)n, off);
        *result = (fresh_errors){off[n / 2], off[(n * 95 - 1) / 100], off[n - 1], n};
    }
    return status;
}
