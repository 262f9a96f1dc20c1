#include "tools/optimize/optimize_parts.h"

#include "tools/files/table_file.h"

#include <ctype.h>
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

static ad_status add_column(optimize_cases_table *cases, const scene *family, const char *name,
                            ad_error *error)
{
    if (cases->columns == OPTIMIZE_NAMES_MAX) {
        return ad_fail(error, AD_BAD_INPUT, "has more than %d numbers; allowed: up to %d",
                       OPTIMIZE_NAMES_MAX, OPTIMIZE_NAMES_MAX);
    }
    snprintf(cases->name[cases->columns], sizeof cases->name[0], "%s", name);
    cases->parameter[cases->columns++] = scene_parameter_find(family, name);
    return AD_OK;
}

/* Names of "a=1, b=2". */
static ad_status add_names(optimize_cases_table *cases, const scene *family, const char *text,
                           ad_error *error)
{
    ad_status status = AD_OK;
    for (const char *p = text; status == AD_OK && *p; p += strcspn(p, ","), p += *p == ',') {
        char name[64];
        p += strspn(p, " \t");
        int length = 0;
        while (length < (int)sizeof name - 1 &&
               (isalnum((unsigned char)p[length]) || p[length] == '_')) {
            length++;
        }
        snprintf(name, sizeof name, "%.*s", length, p);
        status = length > 0 ? add_column(cases, family, name, error) : AD_OK;
    }
    return status;
}

static ad_status read_texts(const optimize_settings *settings, const scene *family,
                            optimize_cases_table *cases, char key[OPTIMIZE_KEY_MAX],
                            ad_error *error)
{
    snprintf(key, OPTIMIZE_KEY_MAX, "optimize.cases[0]");
    ad_status status = add_names(cases, family, settings->cases[0], error);
    scene_parameter open[OPTIMIZE_NAMES_MAX];
    for (int c = 0; c < cases->columns; c++) {
        open[c] = (scene_parameter){cases->name[c], -INFINITY, INFINITY, SCENE_LINEAR};
    }
    cases->count = (size_t)settings->case_count;
    for (int i = 0; i < settings->case_count && status == AD_OK; i++) {
        snprintf(key, OPTIMIZE_KEY_MAX, "optimize.cases[%d]", i);
        status = scene_member_read(cases->columns, open, true, settings->cases[i],
                                   cases->values + i * cases->columns, error);
    }
    return status;
}

static ad_status read_file(const optimize_settings *settings, const scene *family,
                           optimize_cases_table *cases, char key[OPTIMIZE_KEY_MAX], ad_error *error)
{
    table_file *table = NULL;
    snprintf(key, OPTIMIZE_KEY_MAX, "optimize.file");
    ad_status status = table_read(settings->file, TABLE_FINITE, &table, error);
    cases->count = status == AD_OK ? table_rows(table) : 0;
    if (status == AD_OK && (cases->count < 1 || cases->count > OPTIMIZE_CASES_MAX)) {
        status = ad_fail(error, AD_BAD_INPUT, "has %zu rows; allowed: 1 to %d", cases->count,
                         OPTIMIZE_CASES_MAX);
    }
    for (size_t c = 0; status == AD_OK && c < table_columns(table); c++) {
        status = add_column(cases, family, table_name(table, c), error);
    }
    for (size_t i = 0; status == AD_OK && i < cases->count; i++) {
        for (int c = 0; c < cases->columns; c++) {
            cases->values[i * (size_t)cases->columns + (size_t)c] =
                table_column(table, cases->name[c])[i];
        }
    }
    table_free(table);
    return status;
}

static ad_status check_ranges(const scene *family, const optimize_cases_table *cases,
                              ad_error *error)
{
    for (size_t i = 0; i < cases->count; i++) {
        for (int c = 0; c < cases->columns; c++) {
            const double value = cases->values[i * (size_t)cases->columns + (size_t)c];
            const scene_parameter *p =
                cases->parameter[c] < 0 ? NULL : &family->parameters[cases->parameter[c]];
            if (p && !scene_parameter_holds(p, value)) {
                return ad_fail(error, AD_BAD_INPUT,
                               "case %zu has %s = %g; allowed: its range, %g to %g", i + 1, p->name,
                               value, p->low, p->high);
            }
        }
    }
    return AD_OK;
}

ad_status optimize_read_cases(const optimize_settings *settings, const scene *family,
                              optimize_cases_table *cases, char key[OPTIMIZE_KEY_MAX],
                              ad_error *error)
{
    cases->count = 1;
    cases->columns = 0;
    cases->values = calloc((size_t)OPTIMIZE_CASES_MAX * OPTIMIZE_NAMES_MAX, sizeof(double));
    if (!cases->values) {
        return ad_fail(error, AD_NO_MEMORY, "out of memory for cases");
    }
    if (settings->file && settings->case_count > 0) {
        snprintf(key, OPTIMIZE_KEY_MAX, "optimize.file");
        return ad_fail(error, AD_BAD_INPUT, "stands beside optimize.cases; give one of them");
    }
    ad_status status = AD_OK;
    if (settings->file) {
        status = read_file(settings, family, cases, key, error);
    } else if (settings->case_count > 0) {
        status = read_texts(settings, family, cases, key, error);
    }
    return status == AD_OK ? check_ranges(family, cases, error) : status;
}
