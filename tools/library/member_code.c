#include "tools/library/member_code.h"

#include "physics/numerics/distance.h"
#include "tools/emit/export_family.h"
#include "tools/train/trainer.h"

#include <math.h>
#include <stdlib.h>

struct member_code {
    ad_code *code;
    const void *table; /* an export_family_table, of a solver an export_solver_table */
    double *memory;    /* [the table's] */
    int columns;
    /* Of a solver: */
    const scene *open;
    double length, tolerance, mesh_error; /* over the length; of strain_mesh_unresolved */
    int nodes;
};

static ad_status load(member_code *code, const export_text *text, ad_error *error)
{
    char folder[4096];
    const void *table = NULL;
    const ad_code_settings how = {
        .options = "-O3 -fno-math-errno -ffp-contract=fast", .folder = folder, .compile = true};
    if (!trainer_fuse_folder(folder, true)) {
        return ad_fail(error, AD_IO, "no folder for compiled C: neither XDG_CACHE_HOME nor HOME");
    }
    ad_status status = ad_code_begin(text->bytes, text->size, &how, &code->code, error);
    status = status == AD_OK ? ad_code_finish(code->code, true, &table, error) : status;
    if (status == AD_OK) {
        code->table = table; /* both kinds begin with that size */
        code->memory = malloc(*(const size_t *)table * sizeof *code->memory);
    }
    return status != AD_OK || code->memory
               ? status
               : ad_fail(error, AD_NO_MEMORY, "out of memory for compiled C");
}

static ad_status create(export_family *f, member_code **result, ad_error *error)
{
    export_text text = {.bytes = NULL};
    member_code *code = calloc(1, sizeof *code);
    ad_status status = code ? export_text_write(&text, EXPORT_CODE, export_family_write, f, error)
                            : ad_fail(error, AD_NO_MEMORY, "out of memory for compiled C");
    status = status == AD_OK ? load(code, &text, error) : status;
    free(text.bytes);
    if (status != AD_OK) {
        member_code_free(code);
        return status;
    }
    code->columns = f->columns;
    *result = code;
    return AD_OK;
}

static int columns_of(const scene *open, bool forces)
{
    return forces ? strain_columns(open) : SOLVE_MEMBERS_COLUMNS;
}

static ad_status check_points(size_t points, ad_error *error)
{
    return points <= MEMBER_CODE_POINTS_MAX
               ? AD_OK
               : ad_fail(error, AD_BAD_ARGUMENT, "%zu points; allowed for compiled C: up to %d",
                         points, MEMBER_CODE_POINTS_MAX);
}

ad_status member_code_create(const experiment *e, bool forces, size_t points, const double *s,
                             member_code **result, ad_error *error)
{
    export_family f = {.name = "member", .shape_by = true};
    double *numbers = NULL;
    *result = NULL;
    ad_status status = check_points(points, error);
    if (status == AD_OK) {
        status =
            export_family_at(e, columns_of(e->scene, forces), (int)points, s, &f, &numbers, error);
    }
    status = status == AD_OK ? create(&f, result, error) : status;
    free(numbers);
    return status;
}

void member_code_free(member_code *code)
{
    if (code) {
        ad_code_free(code->code);
        free(code->memory);
        free(code);
    }
}

void member_code_answer(const member_code *code, int steps, const double *parameters,
                        double *values, double *jacobian, cpinn_answer *answer)
{
    double said[EXPORT_SAID];
    const export_family_table *table = code->table;
    table->answer(parameters, steps, values, jacobian, answer ? said : NULL, code->memory);
    if (answer) {
        const cpinn_reason reason = (cpinn_reason)said[EXPORT_WHY];
        *answer = (cpinn_answer){.error = said[EXPORT_LEFT],
                                 .network_error = said[EXPORT_PREDICTED],
                                 .source = CPINN_FROM_NETWORK,
                                 .reason = reason,
                                 .trusted = reason == CPINN_REASON_NONE};
    }
}

/* ---- members that are solved --------------------------------------------------------------- */

static ad_status check_kind(const scene *open, const ad_ranks *ranks, ad_error *error)
{
    return ranks ? ad_fail(error, AD_BAD_ARGUMENT, "compiled C: members are dealt among ranks")
           : open->parameter_count == 0
               ? ad_fail(error, AD_BAD_ARGUMENT, "compiled C: nothing is a parameter")
           : strain_forces(open, 1) + strain_held(open) > 0 || strain_is_placed(open)
               ? ad_fail(error, AD_BAD_ARGUMENT,
                         "compiled C: the library solves where forces depend on the place, an end "
                         "is held, tendons rub or have a given length, or there are tubes")
               : AD_OK;
}

/* What an answer lacks is at least this share of the tolerance, and more by what the mesh hardly
 * resolves: by that margin times the most of the first EXPORT_JUDGED members. Of 45,000 members of
 * ten families that were within the tolerance so none was beyond it; the worst was off by 2.3 times
 * what it said. Where fewer are within the tolerance most would be solved twice. */
static const double LEAST = 0.1, MARGIN = 1.5, WITHIN = 0.75;

static bool find(const member_code *code, const double *parameters, double *values,
                 double *jacobian, double said[EXPORT_SOLVED])
{
    const export_solver_table *table = code->table;
    bool result = true;
    for (int i = 0; i < code->open->parameter_count && result; i++) {
        result = scene_parameter_holds(&code->open->parameters[i], parameters[i]);
    }
    return result && table->solve(parameters, values, jacobian, said, code->memory) == 0 &&
           isfinite(said[EXPORT_MOVED]);
}

/* Of a solution that is found, over the length. */
static double estimate_of(const member_code *code, const double said[EXPORT_SOLVED])
{
    return LEAST * code->tolerance + said[EXPORT_MOVED] / code->length +
           code->mesh_error * said[EXPORT_UNRESOLVED];
}

/* By how much members over the ranges are off, of what their mesh hardly resolves: from such that
 * the solver has a hundred times as exactly. */
static ad_status judge(member_code *code, solve_members *exact, size_t points, ad_error *error)
{
    const size_t count = (size_t)code->open->parameter_count;
    const size_t width = points * SOLVE_MEMBERS_COLUMNS, columns = (size_t)code->columns;
    solve_member results[EXPORT_JUDGED];
    double said[EXPORT_JUDGED][EXPORT_SOLVED];
    bool found[EXPORT_JUDGED];
    int solved = 0, within = 0;
    double *parameters = malloc(EXPORT_JUDGED * (count + width) * sizeof *parameters);
    double *values = malloc((points * columns + 1) * sizeof *values);
    ad_status status =
        parameters && values ? AD_OK : ad_fail(error, AD_NO_MEMORY, "out of memory for compiled C");
    if (status == AD_OK) {
        export_family_judged(code->open, parameters);
        status = solve_members_solve(exact, EXPORT_JUDGED, parameters,
                                     parameters + EXPORT_JUDGED * count, results, error);
    }
    for (size_t i = 0; i < EXPORT_JUDGED && status == AD_OK; i++) {
        found[i] = find(code, parameters + i * count, values, NULL, said[i]) &&
                   isfinite(results[i].estimate);
        if (found[i]) {
            const double *other = parameters + EXPORT_JUDGED * count + i * width;
            double off = 0;
            for (size_t k = 0; k < points; k++) {
                off = fmax(off, largest_distance(1, 3, 1, 1, other + k * SOLVE_MEMBERS_COLUMNS,
                                                 values + k * columns) /
                                    code->length);
            }
            code->mesh_error = fmax(code->mesh_error, MARGIN * (off - LEAST * code->tolerance) /
                                                          said[i][EXPORT_UNRESOLVED]);
        }
    }
    for (size_t i = 0; i < EXPORT_JUDGED && status == AD_OK; i++) {
        solved += isfinite(results[i].estimate);
        within += found[i] && estimate_of(code, said[i]) <= code->tolerance;
    }
    if (status == AD_OK && within < WITHIN * solved) {
        status = ad_fail(error, AD_BAD_ARGUMENT,
                         "compiled C has %d of %d members to %g, too few: the solver is left alone",
                         within, solved, code->tolerance);
    }
    free(parameters);
    free(values);
    return status;
}

ad_status member_code_create_solver(const scene *open, bool forces, solve_members *solver,
                                    const solve_members_settings *settings, member_code **result,
                                    ad_error *error)
{
    export_family f = {.name = "member", .shape_by = true};
    solve_members_settings more = *settings;
    solve_members *exact = NULL;
    double *numbers = NULL;
    *result = NULL;
    ad_status status = check_points(settings->points, error);
    status = status == AD_OK ? check_kind(open, settings->ranks, error) : status;
    if (status == AD_OK) {
        status = export_family_solved(open, solver, settings->tolerance, columns_of(open, forces),
                                      (int)settings->points, settings->s, &f, &numbers, error);
    }
    status = status == AD_OK ? create(&f, result, error) : status;
    if (status == AD_OK) {
        (*result)->open = open;
        (*result)->length = scene_length(open);
        (*result)->tolerance = settings->tolerance;
        (*result)->nodes = strain_mesh_nodes(&f.mesh);
        more.tolerance /= 100;
        more.ranks = NULL;
        status = solve_members_create(open, &more, &exact, error);
    }
    status = status == AD_OK ? judge(*result, exact, settings->points, error) : status;
    solve_members_free(exact);
    free(numbers);
    if (status != AD_OK) {
        member_code_free(*result);
        *result = NULL;
    }
    return status;
}

bool member_code_solve(const member_code *code, const double *parameters, double *values,
                       double *jacobian, solve_member *result)
{
    double said[EXPORT_SOLVED];
    if (!find(code, parameters, values, jacobian, said)) {
        return false;
    }
    *result = (solve_member){.estimate = estimate_of(code, said),
                             .load = 1,
                             .nodes = code->nodes,
                             .steps = (int)said[EXPORT_STEPS],
                             .solved = true,
                             .end = SOLVE_MEMBER_SOLVED};
    return result->estimate <= code->tolerance;
}
