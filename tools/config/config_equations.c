/* Own equations from YAML: a walk through the two sections. */
#include "tools/config/config_equations.h"

#include "tools/config/config_tree.h"
#include "tools/files/file_bytes.h"
#include "tools/files/table_file.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

typedef struct reading {
    config_tree tree;
    config_equations *into;
} reading;

void config_equations_free(config_equations *c)
{
    if (c) {
        equations_free(c->equations);
    }
    free(c);
}

/* ---- values ---------------------------------------------------------------------------------- */

static ad_status read_number(reading *r, const config_entry *e, double *number)
{
    const char *text = "";
    ad_error why;
    ad_status status = config_tree_text(&r->tree, e, "number", &text);
    return status == AD_OK
               ? config_tree_blame(&r->tree, e->path,
                                   equations_number(r->into->equations, text, number, &why), &why)
               : status;
}

static ad_status read_above_zero(reading *r, const config_entry *e, double *number)
{
    ad_status status = read_number(r, e, number);
    return status != AD_OK || (*number > 0 && isfinite(*number))
               ? status
               : config_blame(r->tree.source, r->tree.error, e->path, "is %g; allowed: above 0",
                              *number);
}

static ad_status read_range(reading *r, const config_entry *e, double range[2])
{
    config_section s;
    ad_status status = config_tree_list(&r->tree, e->path, &e->value, &s);
    if (status == AD_OK && s.count != 2) {
        status = config_blame(r->tree.source, r->tree.error, e->path,
                              "has %d numbers; allowed: 2, the smaller one first", s.count);
    }
    for (int i = 0; i < 2 && status == AD_OK; i++) {
        status = read_number(r, &s.entries[i], &range[i]);
    }
    return status;
}

/* ---- coordinates, parameters, fields --------------------------------------------------------- */

static ad_status read_coordinate(reading *r, const config_entry *of)
{
    config_section s;
    double range[2] = {NAN, NAN};
    ad_error why;
    equations_coordinate c = {.name = of->key};
    ad_status status = config_tree_section(&r->tree, of->path, &of->value, &s);
    for (int i = 0; i < s.count && status == AD_OK; i++) {
        const config_entry *e = &s.entries[i];
        if (strcmp(e->key, "range") == 0) {
            status = read_range(r, e, range);
        } else if (strcmp(e->key, "periodic") == 0 || strcmp(e->key, "time") == 0) {
            status = config_tree_truth(&r->tree, e, e->key[0] == 't' ? &c.time : &c.periodic);
        } else if (strcmp(e->key, "unit") == 0) {
            status = config_tree_text(&r->tree, e, "unit", &c.unit);
        } else {
            status = config_tree_unknown(&r->tree, e, "range, periodic, time, unit");
        }
    }
    if (status == AD_OK && isnan(range[0])) {
        status = config_blame(r->tree.source, r->tree.error, of->path,
                              "has no range; allowed: {range: [0, 1]}");
    }
    c.low = range[0];
    c.high = range[1];
    return status == AD_OK
               ? config_tree_blame(&r->tree, of->path,
                                   equations_add_coordinate(r->into->equations, &c, &why), &why)
               : status;
}

/* {guess: 0.02} or {range: [0.01, 0.1]} in place of a number. */
static ad_status read_open_parameter(reading *r, const config_entry *of)
{
    config_section s;
    double range[2] = {NAN, NAN}, guess = NAN;
    ad_error why;
    ad_status status = config_tree_section(&r->tree, of->path, &of->value, &s);
    for (int i = 0; i < s.count && status == AD_OK; i++) {
        const config_entry *e = &s.entries[i];
        if (strcmp(e->key, "guess") == 0) {
            status = read_number(r, e, &guess);
        } else if (strcmp(e->key, "range") == 0) {
            status = read_range(r, e, range);
        } else {
            status = config_tree_unknown(&r->tree, e, "guess, range");
        }
    }
    if (status == AD_OK && isnan(guess) == isnan(range[0])) {
        status = config_blame(r->tree.source, r->tree.error, of->path,
                              "allowed: a number, a formula, {guess: 0.1} of what data "
                              "determine, or {range: [0.1, 0.2]} of what it is solved for");
    }
    if (status != AD_OK) {
        return status;
    }
    equations *e = r->into->equations;
    status = isnan(guess) ? equations_add_range(e, of->key, range[0], range[1], &why)
                          : equations_add_unknown(e, of->key, guess, &why);
    return config_tree_blame(&r->tree, of->path, status, &why);
}

/* Those that are numbers come before the coordinates, whose ranges may have them; formulas of
 * coordinates and fields after those. */
static ad_status read_parameters(reading *r, const config_section *s, bool done[CONFIG_ENTRIES_MAX],
                                 int round)
{
    ad_status status = AD_OK;
    for (int i = 0; i < s->count && status == AD_OK; i++) {
        const config_entry *e = &s->entries[i];
        const bool open = e->value.node->type == YAML_MAPPING_NODE;
        const char *text = "";
        ad_error why;
        if (done[i] || open != (round == 1)) {
            continue;
        }
        if (open) {
            status = read_open_parameter(r, e);
        } else {
            status = config_tree_text(&r->tree, e, "number or formula", &text);
        }
        done[i] = status == AD_OK;
        if (!open && status == AD_OK) {
            status = equations_add_parameter(r->into->equations, e->key, text, &why);
            done[i] = status == AD_OK;
            status = round == 0 && status == AD_BAD_INPUT
                         ? AD_OK
                         : config_tree_blame(&r->tree, e->path, status, &why);
        }
    }
    return status;
}

static ad_status read_fields(reading *r, const config_entry *of, bool inside)
{
    config_section s;
    const char *text = "";
    ad_error why;
    equations *e = r->into->equations;
    ad_status status = config_tree_list(&r->tree, of->path, &of->value, &s);
    for (int i = 0; i < s.count && status == AD_OK; i++) {
        status = config_tree_text(&r->tree, &s.entries[i], inside ? "formula" : "name", &text);
        if (status == AD_OK) {
            status =
                inside ? equations_add_inside(e, text, &why) : equations_add_field(e, text, &why);
            status = config_tree_blame(&r->tree, s.entries[i].path, status, &why);
        }
    }
    return status;
}

/* ---- conditions and data --------------------------------------------------------------------- */

/* {at: {t: 0}, u: 0, u_t: 1} */
static ad_status read_condition(reading *r, const config_entry *of)
{
    config_section s, at = {0};
    double where = 0;
    const char *text = "";
    ad_error why;
    ad_status status = config_tree_section(&r->tree, of->path, &of->value, &s);
    for (int i = 0; i < s.count && status == AD_OK; i++) {
        if (strcmp(s.entries[i].key, "at") == 0) {
            status = config_tree_section(&r->tree, s.entries[i].path, &s.entries[i].value, &at);
        }
    }
    if (status == AD_OK && (at.count != 1 || s.count < 2)) {
        return config_blame(r->tree.source, r->tree.error, of->path,
                            "%s; allowed: as in {at: {x: 0}, u: 1}",
                            at.count == 0   ? "has no face"
                            : at.count == 1 ? "says nothing of what is there"
                                            : "has a face of several coordinates");
    }
    status = status == AD_OK ? read_number(r, &at.entries[0], &where) : status;
    for (int i = 0; i < s.count && status == AD_OK; i++) {
        const config_entry *e = &s.entries[i];
        if (strcmp(e->key, "at") != 0) {
            status = config_tree_text(&r->tree, e, "formula", &text);
            status = status == AD_OK
                         ? config_tree_blame(&r->tree, e->path,
                                             equations_add_condition(r->into->equations,
                                                                     at.entries[0].key, where,
                                                                     e->key, text, &why),
                                             &why)
                         : status;
        }
    }
    return status;
}

static ad_status take_data(reading *r, const config_entry *of, const char *file, double noise)
{
    const char *slash = strrchr(r->tree.origin.file, '/');
    char path[4096];
    const char *names[CONFIG_ENTRIES_MAX];
    const double *columns[CONFIG_ENTRIES_MAX];
    ad_error why;
    table_file *table = NULL;
    const int folder = slash && file[0] != '/' ? (int)(slash - r->tree.origin.file + 1) : 0;
    snprintf(path, sizeof path, "%.*s%s", folder, r->tree.origin.file, file);
    ad_status status = table_read(path, TABLE_MEASURED, &table, &why);
    if (status == AD_OK && table_columns(table) > CONFIG_ENTRIES_MAX) {
        status = ad_fail(&why, AD_BAD_INPUT, "%.200s: too many columns; allowed: %d", file,
                         CONFIG_ENTRIES_MAX);
    }
    for (size_t i = 0; status == AD_OK && i < table_columns(table); i++) {
        names[i] = table_name(table, i);
        status = table_find(table, names[i], TABLE_MEASURED, &columns[i], &why);
    }
    if (status == AD_OK) {
        ad_error reason;
        status = equations_add_data(r->into->equations, table_rows(table),
                                    (int)table_columns(table), names, columns, noise, &reason);
        if (status != AD_OK) {
            ad_fail(&why, status, "%.200s: %s", file, reason.message);
        }
    }
    table_free(table);
    return config_tree_blame(&r->tree, of->path, status, &why);
}

static ad_status read_data(reading *r, const config_entry *of)
{
    config_section s;
    const char *file = NULL;
    double noise = 0;
    ad_status status = config_tree_section(&r->tree, of->path, &of->value, &s);
    for (int i = 0; i < s.count && status == AD_OK; i++) {
        const config_entry *e = &s.entries[i];
        if (strcmp(e->key, "file") == 0) {
            status = config_tree_text(&r->tree, e, "name of a file", &file);
        } else if (strcmp(e->key, "noise") == 0) {
            status = read_above_zero(r, e, &noise);
        } else {
            status = config_tree_unknown(&r->tree, e, "file, noise");
        }
    }
    if (status == AD_OK && !file) {
        status = config_blame(r->tree.source, r->tree.error, of->path,
                              "has no file; allowed: {file: measured.csv}");
    }
    return status == AD_OK ? take_data(r, of, file, noise) : status;
}

/* ---- sections -------------------------------------------------------------------------------- */

/* In the order in which they need each other, whatever that of the file is. */
static ad_status read_equations(reading *r, const config_entry *of)
{
    static const char *const keys[] = {"coordinates", "parameters", "fields",
                                       "inside",      "conditions", "data"};
    enum { COORDINATES, PARAMETERS, FIELDS, INSIDE, CONDITIONS, DATA, KEYS };
    config_section s, list[KEYS] = {{0}};
    const config_entry *given[KEYS] = {NULL};
    bool done[CONFIG_ENTRIES_MAX] = {false};
    ad_error why;
    ad_status status = config_tree_section(&r->tree, of->path, &of->value, &s);
    for (int i = 0; i < s.count && status == AD_OK; i++) {
        int k = 0;
        while (k < KEYS && strcmp(s.entries[i].key, keys[k]) != 0) {
            k++;
        }
        if (k == KEYS) {
            return config_tree_unknown(&r->tree, &s.entries[i],
                                       "coordinates, parameters, fields, inside, conditions, data");
        }
        given[k] = &s.entries[i];
        if (k == COORDINATES || k == PARAMETERS) {
            status = config_tree_section(&r->tree, given[k]->path, &given[k]->value, &list[k]);
        } else if (k == CONDITIONS) {
            status = config_tree_list(&r->tree, given[k]->path, &given[k]->value, &list[k]);
        }
    }
    status = status == AD_OK ? read_parameters(r, &list[PARAMETERS], done, 0) : status;
    for (int i = 0; i < list[COORDINATES].count && status == AD_OK; i++) {
        status = read_coordinate(r, &list[COORDINATES].entries[i]);
    }
    status = status == AD_OK ? read_parameters(r, &list[PARAMETERS], done, 1) : status;
    status = status == AD_OK && given[FIELDS] ? read_fields(r, given[FIELDS], false) : status;
    status = status == AD_OK ? read_parameters(r, &list[PARAMETERS], done, 2) : status;
    status = status == AD_OK && given[INSIDE] ? read_fields(r, given[INSIDE], true) : status;
    for (int i = 0; i < list[CONDITIONS].count && status == AD_OK; i++) {
        status = read_condition(r, &list[CONDITIONS].entries[i]);
    }
    status = status == AD_OK && given[DATA] ? read_data(r, given[DATA]) : status;
    return status == AD_OK
               ? config_tree_blame(&r->tree, of->path,
                                   equations_model(r->into->equations, &r->into->model, &why), &why)
               : status;
}

static ad_status read_fit(reading *r, const config_entry *of)
{
    config_section s;
    ad_status status = config_tree_section(&r->tree, of->path, &of->value, &s);
    for (int i = 0; i < s.count && status == AD_OK; i++) {
        const config_entry *e = &s.entries[i];
        if (strcmp(e->key, "tolerance") == 0) {
            status = read_above_zero(r, e, &r->into->tolerance);
        } else if (strcmp(e->key, "seconds") == 0) {
            status = read_above_zero(r, e, &r->into->seconds);
        } else {
            status = config_tree_unknown(&r->tree, e, "tolerance, seconds");
        }
    }
    return status;
}

static void name_after(config_equations *into, const char *file)
{
    const char *base = file_bytes_name(file), *dot = strrchr(base, '.');
    snprintf(into->name, sizeof into->name, "%.*s",
             dot && dot > base ? (int)(dot - base) : (int)strlen(base), base);
}

static ad_status read_root(reading *r)
{
    const config_view root = config_tree_root(&r->tree);
    config_section s;
    const char *name = NULL;
    ad_status status = config_tree_section(&r->tree, "", &root, &s);
    if (status == AD_OK && !config_tree_has(&s, "equations")) {
        return config_blame(r->tree.source, r->tree.error, "",
                            "has no equations; needed: a section equations. Scenes of rods and "
                            "beams are for cpinn-train and cpinn-solve");
    }
    for (int i = 0; i < s.count && status == AD_OK; i++) {
        const config_entry *e = &s.entries[i];
        if (strcmp(e->key, "name") == 0) {
            status = config_tree_text(&r->tree, e, "name", &name);
            snprintf(r->into->name, sizeof r->into->name, "%.60s", name ? name : "");
        } else if (strcmp(e->key, "equations") == 0) {
            status = read_equations(r, e);
        } else if (strcmp(e->key, "fit") == 0) {
            status = read_fit(r, e);
        } else {
            status = config_tree_unknown(&r->tree, e, "name, equations, fit");
        }
    }
    return status == AD_OK ? config_tree_all_used(&r->tree) : status;
}

ad_status config_equations_read(const char *path, const char *text, int count,
                                const char *const *overrides, config_equations **result,
                                ad_error *error)
{
    reading *r = calloc(1, sizeof *r);
    config_equations *into = calloc(1, sizeof *into);
    ad_status status = AD_OK;
    *result = NULL;
    if (into) {
        into->equations = equations_create();
        into->tolerance = CONFIG_FIT_TOLERANCE;
        into->seconds = CONFIG_FIT_SECONDS;
        name_after(into, path);
    }
    if (!r || !into || !into->equations) {
        status = ad_fail(error, AD_NO_MEMORY, "%s: out of memory", path);
    } else {
        r->into = into;
        status = config_tree_open(&r->tree, path, text, count, overrides, error);
        status = status == AD_OK ? read_root(r) : status;
        config_tree_close(&r->tree);
    }
    free(r);
    if (status != AD_OK) {
        config_equations_free(into);
        into = NULL;
    }
    *result = into;
    return status;
}
