#include "tools/train/members_given.h"

#include "physics/scene/scene_memory.h"

#include <stdio.h>
#include <stdlib.h>
#include <string.h>

enum { NAMES_BYTES = 1024 };

/* Whether members say its value; what plays were before follows from the rows before. */
static bool is_said(const scene *family, int parameter)
{
    return parameter < scene_given_count(family) || parameter >= scene_known_count(family);
}

/* "a, b, c" */
static const char *list_names(const scene *family, char text[NAMES_BYTES])
{
    size_t at = 0;
    text[0] = '\0';
    for (int i = 0; i < family->parameter_count && at < NAMES_BYTES; i++) {
        if (is_said(family, i)) {
            at += (size_t)snprintf(text + at, NAMES_BYTES - at, "%s%s", at ? ", " : "",
                                   family->parameters[i].name);
        }
    }
    return text;
}

static ad_status check_columns(const scene *family, const char *path, const table_file *table,
                               ad_error *error)
{
    char names[NAMES_BYTES];
    for (int i = 0; i < family->parameter_count; i++) {
        if (is_said(family, i) && !table_column(table, family->parameters[i].name)) {
            return ad_fail(error, AD_BAD_INPUT,
                           "%s: column '%s' is missing; members have columns %s", path,
                           family->parameters[i].name, list_names(family, names));
        }
    }
    for (size_t i = 0; i < table_columns(table); i++) {
        const char *name = table_name(table, i);
        const int found = scene_parameter_find(family, name);
        if (found < 0 || !is_said(family, found)) {
            return ad_fail(error, AD_BAD_INPUT,
                           "%s: column '%s' is no parameter; members have columns %s", path, name,
                           list_names(family, names));
        }
    }
    if (table_rows(table) == 0) {
        return ad_fail(error, AD_BAD_INPUT, "%s: there are no rows; at least one is needed", path);
    }
    return AD_OK;
}

ad_status train_members_read(const scene *family, const char *path, double **parameters,
                             table_file **table, ad_error *error)
{
    const size_t count = (size_t)family->parameter_count;
    *parameters = NULL;
    *table = NULL;
    ad_status status = table_read(path, TABLE_FINITE, table, error);
    status = status == AD_OK ? check_columns(family, path, *table, error) : status;
    if (status == AD_OK) {
        *parameters = malloc(table_rows(*table) * count * sizeof **parameters);
        status = *parameters ? AD_OK
                             : ad_fail(error, AD_NO_MEMORY, "out of memory for %zu members",
                                       table_rows(*table));
    }
    for (size_t k = 0; k < count && status == AD_OK; k++) {
        const double *column = table_column(*table, family->parameters[k].name);
        for (size_t i = 0; i < table_rows(*table) && column; i++) {
            (*parameters)[i * count + k] = column[i];
        }
    }
    if (status == AD_OK) {
        scene_remember_path(family, table_rows(*table), *parameters, NULL);
    }
    if (status != AD_OK) {
        table_free(*table);
        *table = NULL;
    }
    return status;
}

ad_status train_members_check(const scene *family, const char *path, const table_file *table,
                              const double *parameters, const char *or_else, ad_error *error)
{
    const size_t count = (size_t)family->parameter_count;
    for (size_t i = 0; i < table_rows(table) * count; i++) {
        const scene_parameter *p = &family->parameters[i % count];
        const size_t line = table_line(table, i / count);
        if (!scene_parameter_holds(p, parameters[i])) {
            return ad_fail(error, AD_BAD_INPUT,
                           "%s:%s%zu: %s = %.10g is outside its range; allowed: %g to %g%s", path,
                           line ? "" : " row ", line ? line : i / count + 1, p->name, parameters[i],
                           p->low, p->high, or_else);
        }
    }
    return AD_OK;
}
