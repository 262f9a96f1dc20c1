/* Rows as text and as files. */
#include "tools/judge/cases.h"
#include "tools/judge/result_table.h"

#include <math.h>
#include <string.h>

/* ---- for people ---------------------------------------------------------------------------- */

void cases_print_heading(FILE *file, int width)
{
    fprintf(file, "%-*s  %-27s  %8s  %8s  %7s  %-27s  %s\n", width, "case", "method", "position",
            "rotation", "seconds", "size", "left out");
}

/* "1 equation", "2 equations" */
static void count_text(double count, const char *what, char text[32])
{
    snprintf(text, 32, "%.0f %s%s", count, what, count == 1 ? "" : "s");
}

static void size_text(const cases_row *row, char text[72])
{
    const judge_row *r = &row->result;
    bool trained = row->method == JUDGE_NETWORK;
    char first[32], second[32];
    count_text(trained ? r->unknowns : r->points, trained ? "unknown" : "node", first);
    count_text(trained ? r->equations : r->steps, trained ? "equation" : "step", second);
    bool direct = !trained && r->steps == 0; /* a linear scene */
    snprintf(text, 72, isnan(r->points) ? "-" : direct ? "%s" : "%s, %s", first, second);
}

/* "time, shear" for "time; shear". */
static void print_left_out(FILE *file, const char *text)
{
    for (; *text; text++) {
        fputc(*text == ';' ? ',' : *text, file);
    }
}

void cases_print_row(FILE *file, const cases_row *row, const cases_row *before, int width)
{
    const bool is_named =
        row->method == JUDGE_NETWORK || !before || strcmp(before->name, row->name) != 0;
    char position[RESULT_TABLE_TEXT], rotation[RESULT_TABLE_TEXT], seconds[RESULT_TABLE_TEXT],
        size[72];
    const judge_row *r = &row->result;
    size_text(row, size);
    fprintf(file, "%-*s  %-27s  %8s  %8s  %7s  %-27s  ", width, is_named ? row->name : "",
            judge_form_of(r, row->method), result_table_error(r->errors[JUDGE_POSITION], position),
            result_table_error(r->errors[JUDGE_ROTATION], rotation),
            result_table_seconds(r->seconds, seconds), size);
    print_left_out(file, *r->left_out ? r->left_out : "-");
    fputc('\n', file);
    char indent[JUDGE_NAME + 2];
    snprintf(indent, sizeof indent, "%*s  ", width, "");
    if (verdict_outcome_of(&r->verdict) != VERDICT_SOLVED) {
        verdict_print(file, indent, &r->verdict);
    }
}

/* ---- files --------------------------------------------------------------------------------- */

enum { WORDS = 6, NUMBERS = 8 };

ad_status cases_write(const cases_row *rows, size_t count, const char *folder, ad_error *error)
{
    static const char *const names[WORDS + NUMBERS] = {
        "case",      "method",         "form",           "outcome", "reason",
        "left_out",  "position_error", "rotation_error", "seconds", "unknowns",
        "equations", "instructions",   "points",         "steps"};
    result_table s = result_table_create(names, WORDS, NUMBERS, count);
    for (size_t i = 0; i < count; i++) {
        const judge_row *r = &rows[i].result;
        const char *words[WORDS] = {rows[i].name,
                                    judge_method_name(rows[i].method),
                                    judge_form_of(r, rows[i].method),
                                    verdict_outcome_name(verdict_outcome_of(&r->verdict)),
                                    verdict_reason_name(verdict_worst(&r->verdict)),
                                    *r->left_out ? r->left_out : "nothing"};
        result_table_add(&s, words,
                         (const double[NUMBERS]){
                             r->errors[JUDGE_POSITION], r->errors[JUDGE_ROTATION], r->seconds,
                             r->unknowns, r->equations, r->instructions, r->points, r->steps});
    }
    ad_status status = result_table_write_both(&s, folder, "cases", error);
    result_table_free(&s);
    return status;
}
