#include "tools/programs/solve_rows.h"

#include "tools/train/members_given.h"

#include <math.h>
#include <stdlib.h>

typedef struct taking {
    const solve_settings *settings;
    samples *to;
    rows_solved *solved;
    verdict *verdict;
    double *values; /* [columns][points] */
    cpinn_answer *said;
} taking;

/* A verdict of one row, which becomes part of that of all. */
static bool judge(const taking *taking, size_t row, const scene *member, const solution *solved,
                  const solve_report *report)
{
    verdict one = {.count = 0};
    solution_verdict(solved, member, taking->settings, report, &one);
    for (int i = 0; i < one.count; i++) {
        verdict_add(taking->verdict, one.findings[i].reason, "row %zu: %s", row + 1,
                    one.findings[i].text);
    }
    return verdict_outcome_of(&one) == VERDICT_SOLVED;
}

static ad_status take(void *context, size_t row, const scene *member, const solution *solved,
                      const solve_report *report, ad_error *error)
{
    taking *taking = context;
    const samples *to = taking->to;
    const size_t columns = (size_t)to->columns, all = samples_rows(to);
    const bool reached = report->load_fraction == 1;
    const bool good = judge(taking, row, member, solved, report);
    ad_status status = reached ? solution_evaluate(solved, to->columns, to->count, to->s, NULL,
                                                   taking->values, error)
                               : AD_OK;
    for (size_t k = 0; k < columns * to->count; k++) {
        to->values[k / to->count * all + row * to->count + k % to->count] =
            reached ? taking->values[k] : NAN;
    }
    taking->said[row] = (cpinn_answer){
        .error = report->estimate * report->size,
        .source = reached ? CPINN_FROM_SOLVER : CPINN_FROM_NOTHING,
        .reason = good      ? CPINN_REASON_NONE
                  : reached ? CPINN_REASON_WARNING
                            : CPINN_REASON_NO_EQUILIBRIUM,
        .trusted = good,
    };
    taking->solved->reached += reached;
    taking->solved->estimate = fmax(taking->solved->estimate, report->estimate);
    return status;
}

/* Rows of a table, within the ranges. */
static ad_status read_rows(const scene *open, const char *path, samples *shapes, ad_error *error)
{
    table_file *table = NULL;
    ad_status status = train_members_read(open, path, &shapes->parameters, &table, error);
    if (status == AD_OK) {
        shapes->members = table_rows(table);
        status = train_members_check(open, path, table, shapes->parameters, "", error);
    }
    table_free(table);
    return status;
}

ad_status solve_rows_run(const scene *open, const char *path, const solve_settings *settings,
                         samples *shapes, rows_solved *solved, verdict *verdict, ad_error *error)
{
    ad_status status = read_rows(open, path, shapes, error);
    if (status != AD_OK) {
        return status;
    }
    const size_t columns = (size_t)solution_columns(open);
    taking x = {.settings = settings, .to = shapes, .solved = solved, .verdict = verdict};
    shapes->of = open;
    shapes->columns = (int)columns;
    shapes->values = malloc((columns * samples_rows(shapes) + 1) * sizeof *shapes->values);
    shapes->said = x.said = calloc(shapes->members + 1, sizeof *shapes->said);
    x.values = malloc((columns * shapes->count + 1) * sizeof *x.values);
    *solved = (rows_solved){.rows = shapes->members};
    status = shapes->values && shapes->said && x.values
                 ? solve_rows(open, settings, shapes->members, shapes->parameters, take, &x, error)
                 : ad_fail(error, AD_NO_MEMORY, "out of memory for %zu rows", shapes->members);
    free(x.values);
    return status;
}
