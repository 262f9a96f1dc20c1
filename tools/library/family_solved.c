/* Answers for members of a family by solution_create, and derivatives of those in motion. */
#include "tools/library/trained_family.h"

#include "physics/solve/motion_change.h"
#include "physics/solve/solve.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

void cpinn_put_nothing(size_t numbers, double *values)
{
    for (size_t i = 0; i < numbers; i++) {
        values[i] = NAN;
    }
}

void cpinn_family_say_nothing(const cpinn_family *family, cpinn_reason reason, double *values,
                              cpinn_answer *answer)
{
    cpinn_put_nothing(family->points * (size_t)family->columns, values);
    answer->source = CPINN_FROM_NOTHING;
    answer->reason = reason;
    answer->trusted = false;
    answer->error = NAN;
}

/* ---- answers ------------------------------------------------------------------------------- */

/* The shape in `values` [points][columns], by the solver's columns. */
static ad_status put_solution(const cpinn_family *family, const solution *found, double *values,
                              ad_error *error)
{
    double *room = malloc((family->points * (size_t)family->columns + 1) * sizeof *room);
    ad_status status =
        room ? solution_evaluate(found, family->columns, family->points, family->s, family->t, room,
                                 error)
             : ad_fail(error, AD_NO_MEMORY, "out of memory for %zu points", family->points);
    for (size_t i = 0; i < family->points && status == AD_OK; i++) {
        for (int c = 0; c < family->columns; c++) {
            values[i * (size_t)family->columns + (size_t)c] = room[(size_t)c * family->points + i];
        }
    }
    free(room);
    return status;
}

/* Its curvature [numbers] as the solver of members is given it. */
static ad_status put_curvature(const cpinn_family *family, const solution *found, const scene *one,
                               double *curvature, ad_error *error)
{
    enum {
        FIRST = 10,
        TORSION = 20
    }; /* of the columns of a solution: u, and m of the first tube */
    const size_t nodes = family->nodes, width = family->numbers / (nodes + (nodes == 0));
    const int columns = solution_columns(one);
    const double unit = solve_members_torsion(family->solver);
    double *s = malloc((1 + (size_t)columns) * (nodes + 1) * sizeof *s), *values = s + nodes;
    ad_status status = s ? AD_OK : ad_fail(error, AD_NO_MEMORY, "out of memory for derivatives");
    if (status == AD_OK) {
        solve_members_places(family->solver, s);
        status = solution_evaluate(found, columns, nodes, s, NULL, values, error);
    }
    for (size_t i = 0; i < family->numbers && status == AD_OK; i++) {
        const size_t node = i / width, k = i % width;
        const double growth = scene_growth_at(one, NULL, s[node], 0);
        curvature[i] = k < 3 ? growth * values[(FIRST + k) * nodes + node]
                             : values[(TORSION + 2 * (k - 3)) * nodes + node] / unit;
    }
    free(s);
    return status;
}

static solve_settings settings_of(const cpinn_family *family, const scene *one)
{
    solve_settings settings = solve_settings_default(one);
    const double asked = family->tolerance;
    settings.tolerance = !family->solves_all ? fmin(settings.tolerance, asked)
                         : asked > 0         ? asked
                                             : settings.tolerance;
    return settings;
}

static ad_status solve_one(const cpinn_family *family, const double *parameters, double *values,
                           double *curvature, cpinn_answer *answer, ad_error *error)
{
    scene one;
    solution *found = NULL;
    solve_report report;
    scene_member(&family->open, parameters, &one);
    const solve_settings settings = settings_of(family, &one);
    const bool moves = scene_is_dynamic(&one);
    ad_status status = moves ? solve_settle(&one, one.names, error) : AD_OK;
    status = status == AD_OK ? solution_create(&one, &settings, moves ? family->points : 0,
                                               family->t, &found, &report, error)
                             : status;
    if (status == AD_NO_MEMORY || status == AD_NO_BLAS) {
        return status;
    }
    if (status != AD_OK || (!moves && report.load_fraction != 1)) {
        cpinn_family_say_nothing(family, CPINN_REASON_NO_EQUILIBRIUM, values, answer);
        status = AD_OK;
    } else {
        verdict said = {.count = 0};
        solution_verdict(found, &one, &settings, &report, &said);
        answer->source = CPINN_FROM_SOLVER;
        answer->trusted = verdict_outcome_of(&said) == VERDICT_SOLVED;
        answer->reason = answer->trusted ? answer->reason : CPINN_REASON_WARNING;
        answer->error = report.estimate * (scene_is_beam(&one) ? report.size : family->length);
        status = put_solution(family, found, values, error);
        if (status == AD_OK && curvature) {
            status = put_curvature(family, found, &one, curvature, error);
        }
    }
    solution_free(found);
    return status;
}

typedef struct solving {
    const cpinn_family *x;
    const size_t *which;
    const double *parameters; /* of all members */
    double *values;           /* of those that are solved, one after the other, as `answers`, */
    double *curvature;        /* and this, NULL: nobody asks */
    cpinn_answer *answers;
} solving;

static ad_status solve_item(void *context, int item, int thread, ad_error *error)
{
    const solving *of = context;
    const size_t k = (size_t)item, width = of->x->points * (size_t)of->x->columns;
    (void)thread;
    return solve_one(
        of->x, of->parameters + of->which[k] * (size_t)of->x->count, of->values + k * width,
        of->curvature ? of->curvature + k * of->x->numbers : NULL, of->answers + k, error);
}

ad_status cpinn_family_solve(const cpinn_family *family, size_t count, const size_t *which,
                             const double *parameters, double *values, double *curvature,
                             cpinn_answer *answers, ad_error *error)
{
    if (count == 0) {
        return AD_OK;
    }
    const size_t width = family->points * (size_t)family->columns, bytes = width * sizeof *values;
    const size_t bent = family->numbers * sizeof *curvature;
    solving of = {.x = family,
                  .which = which,
                  .parameters = parameters,
                  .values = malloc(count * bytes + 1),
                  .curvature = curvature ? malloc(count * bent + 1) : NULL,
                  .answers = malloc((count + 1) * sizeof *answers)};
    const ad_dealt made[] = {{of.values, bytes, count * bytes},
                             {of.answers, sizeof *answers, count * sizeof *answers},
                             {of.curvature, bent, count * bent}};
    ad_status status = of.values && of.answers && (of.curvature || !curvature)
                           ? AD_OK
                           : ad_fail(error, AD_NO_MEMORY, "out of memory for %zu members", count);
    for (size_t k = 0; k < count && status == AD_OK; k++) {
        of.answers[k] = answers[which[k]];
    }
    if (status == AD_OK) {
        status =
            ad_pool_deal(family->pool, (int)count, solve_item, &of, curvature ? 3 : 2, made, error);
    }
    for (size_t k = 0; k < count && status == AD_OK; k++) {
        answers[which[k]] = of.answers[k];
        memcpy(values + which[k] * width, of.values + k * width, bytes);
        if (curvature) {
            memcpy((char *)curvature + which[k] * bent, (char *)of.curvature + k * bent, bent);
        }
    }
    free(of.values);
    free(of.curvature);
    free(of.answers);
    return status;
}

/* ---- derivatives of motions ---------------------------------------------------------------- */

typedef struct changing {
    const cpinn_family *x;
    const double *parameters;
    double *jacobian;
    cpinn_answer *answers;
} changing;

static ad_status change_item(void *context, int item, int thread, ad_error *error)
{
    const changing *of = context;
    const cpinn_family *x = of->x;
    const size_t p = (size_t)x->count, columns = (size_t)x->columns, points = x->points;
    const size_t width = points * columns * p, i = (size_t)item;
    double *to = of->jacobian + i * width, *by = NULL;
    cpinn_answer *answer = &of->answers[i];
    const double *parameters = of->parameters + i * p;
    motion_change *change = NULL;
    motion_change_report report;
    ad_status status = AD_OK;
    (void)thread;
    cpinn_put_nothing(width, to);
    if (answer->source == CPINN_FROM_NOTHING) {
        return AD_OK;
    }
    scene one;
    scene_member(&x->open, parameters, &one);
    const solve_settings settings = settings_of(x, &one);
    by = malloc((width + 1) * sizeof *by);
    status = by ? motion_change_create(&x->open, parameters, &settings, points, x->t, &change,
                                       &report, error)
                : ad_fail(error, AD_NO_MEMORY, "out of memory for derivatives");
    status = status == AD_OK
                 ? motion_change_evaluate(change, x->columns, points, x->s, x->t, by, error)
                 : status;
    for (size_t k = 0; k < width && status == AD_OK; k++) {
        to[k] = by[k % (columns * p) * points + k / (columns * p)];
    }
    if (status == AD_NOT_FINITE ||
        (status == AD_OK &&
         !(report.estimate <= MOTION_CHANGE_OF_TOLERANCE * settings.tolerance))) {
        answer->trusted = false;
        answer->reason = CPINN_REASON_WARNING;
        status = AD_OK;
    }
    motion_change_free(change);
    free(by);
    return status;
}

ad_status cpinn_family_change(const cpinn_family *family, size_t members, const double *parameters,
                              double *jacobian, cpinn_answer *answers, ad_error *error)
{
    const size_t bytes =
        family->points * (size_t)family->columns * (size_t)family->count * sizeof *jacobian;
    changing of = {family, parameters, jacobian, answers};
    const ad_dealt made[] = {{jacobian, bytes, members * bytes},
                             {answers, sizeof *answers, members * sizeof *answers}};
    return ad_pool_deal(family->pool, (int)members, change_item, &of, 2, made, error);
}
