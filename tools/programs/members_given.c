#include "tools/programs/members_given.h"

#include "tools/config/config.h"

#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

enum { NAMES_BYTES = SCENE_PARAMETERS_MAX * CONFIG_PARAMETER_BYTES };

/* "a, b, c" */
static const char *list_names(const scene *family, char text[NAMES_BYTES])
{
    size_t at = 0;
    text[0] = '\0';
    for (int i = 0; i < family->parameter_count && at < NAMES_BYTES; i++) {
        at += (size_t)snprintf(text + at, NAMES_BYTES - at, "%s%s", i ? ", " : "",
                               family->parameters[i].name);
    }
    return text;
}

static int find(const scene *family, const char *name, size_t length)
{
    for (int i = 0; i < family->parameter_count; i++) {
        const char *known = family->parameters[i].name;
        if (strlen(known) == length && strncmp(known, name, length) == 0) {
            return i;
        }
    }
    return -1;
}

static ad_status check_family(const scene *family, ad_error *error)
{
    return scene_is_family(family)
               ? AD_OK
               : ad_fail(error, AD_BAD_ARGUMENT,
                         "the scene is no family: no parameter of it has a range");
}

/* One "name=value" of `length` characters. */
static ad_status take(const scene *family, const char *text, size_t length, double *values,
                      bool *given, ad_error *error)
{
    char names[NAMES_BYTES];
    const char *equals = memchr(text, '=', length);
    const int shown = length < 60 ? (int)length : 60;
    const size_t name = equals ? (size_t)(equals - text) : length;
    const int found = equals ? find(family, text, name) : -1;
    char *end = NULL;
    if (found < 0) {
        return ad_fail(error, AD_BAD_ARGUMENT,
                       "--at %.*s: allowed: NAME=VALUE, separated by commas, of the parameters %s",
                       shown, text, list_names(family, names));
    }
    if (given[found]) {
        return ad_fail(error, AD_BAD_ARGUMENT, "--at %.*s: %s is given twice", shown, text,
                       family->parameters[found].name);
    }
    values[found] = strtod(equals + 1, &end);
    if (end == equals + 1 || end != text + length || !isfinite(values[found])) {
        return ad_fail(error, AD_BAD_ARGUMENT, "--at %.*s: allowed: a finite number", shown, text);
    }
    given[found] = true;
    return AD_OK;
}

ad_status members_at(const scene *family, const char *text, double *values, ad_error *error)
{
    bool given[SCENE_PARAMETERS_MAX] = {false};
    ad_status status = check_family(family, error);
    for (const char *at = text; at && status == AD_OK;) {
        const char *comma = strchr(at, ',');
        status = take(family, at, comma ? (size_t)(comma - at) : strlen(at), values, given, error);
        at = comma ? comma + 1 : NULL;
    }
    for (int i = 0; i < family->parameter_count && status == AD_OK; i++) {
        const scene_parameter *p = &family->parameters[i];
        if (!given[i]) {
            status = ad_fail(error, AD_BAD_ARGUMENT, "--at: %s is missing; its range is %g to %g",
                             p->name, p->low, p->high);
        }
    }
    return status;
}

/* ---- files --------------------------------------------------------------------------------- */

static ad_status check_columns(const scene *family, const char *path, const table_file *table,
                               ad_error *error)
{
    char names[NAMES_BYTES];
    for (int i = 0; i < family->parameter_count; i++) {
        if (!table_column(table, family->parameters[i].name)) {
            return ad_fail(error, AD_BAD_INPUT,
                           "%s: column '%s' is missing; members have columns %s", path,
                           family->parameters[i].name, list_names(family, names));
        }
    }
    for (size_t i = 0; i < table_columns(table); i++) {
        const char *name = table_name(table, i);
        if (find(family, name, strlen(name)) < 0) {
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

ad_status members_read(const scene *family, const char *path, double **parameters,
                       table_file **table, ad_error *error)
{
    const size_t count = (size_t)family->parameter_count;
    *parameters = NULL;
    *table = NULL;
    ad_status status = check_family(family, error);
    status = status == AD_OK ? table_read(path, TABLE_FINITE, table, error) : status;
    status = status == AD_OK ? check_columns(family, path, *table, error) : status;
    if (status == AD_OK) {
        *parameters = malloc(table_rows(*table) * count * sizeof **parameters);
        status = *parameters ? AD_OK
                             : ad_fail(error, AD_NO_MEMORY, "out of memory for %zu members",
                                       table_rows(*table));
    }
    for (size_t k = 0; k < count && status == AD_OK; k++) {
        const double *column = table_column(*table, family->parameters[k].name);
        for (size_t i = 0; i < table_rows(*table); i++) {
            (*parameters)[i * count + k] = column[i];
        }
    }
    if (status != AD_OK) {
        table_free(*table);
        *table = NULL;
    }
    return status;
}
