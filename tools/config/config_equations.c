/* Own equations from YAML: a walk through the two sections, with overrides put in where they
 * belong. */
#include "tools/config/config_equations.h"

#include "physics/quantity/spelling.h"
#include "tools/config/config_parts.h"
#include "tools/files/table_file.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

enum { OVERRIDES_MAX = 128, ENTRIES_MAX = 64 };

/* A node of the file or of an override. */
typedef struct view {
    yaml_document_t *document;
    yaml_node_t *node;
    const config_origin *origin;
} view;

typedef struct override {
    char path[CONFIG_PATH_MAX];
    yaml_document_t document;
    config_origin origin;
    bool used;
} override;

typedef struct reading {
    config_equations *into;
    config_source *source;
    yaml_document_t document;
    config_origin origin;
    int override_count;
    override overrides[OVERRIDES_MAX];
    ad_error *error;
} reading;

/* An entry of a section. */
typedef struct entry {
    char path[CONFIG_PATH_MAX];
    const char *key;
    view value;
} entry;

typedef struct section {
    const char *path;
    int count;
    entry entries[ENTRIES_MAX];
} section;

void config_equations_free(config_equations *c)
{
    if (c) {
        equations_free(c->equations);
    }
    free(c);
}

/* ---- nodes ----------------------------------------------------------------------------------- */

static ad_status no_memory(reading *r)
{
    return ad_fail(r->error, AD_NO_MEMORY, "%s: out of memory", r->origin.file);
}

static const char *scalar(const view *v)
{
    return (const char *)v->node->data.scalar.value;
}

static bool is_scalar(const view *v)
{
    return v->node->type == YAML_SCALAR_NODE && strlen(scalar(v)) == v->node->data.scalar.length;
}

/* Whether `error` says what is wrong at a path; else AD_OK. */
static ad_status blame(reading *r, const char *path, ad_status status, const ad_error *why)
{
    if (status == AD_OK || status == AD_NO_MEMORY) {
        return status == AD_OK ? AD_OK : no_memory(r);
    }
    return config_blame(r->source, r->error, path, "%s", why->message);
}

static override *override_of(reading *r, const char *path)
{
    override *found = NULL;
    for (int i = 0; i < r->override_count; i++) {
        if (strcmp(r->overrides[i].path, path) == 0) {
            found = &r->overrides[i];
            found->used = true;
        }
    }
    return found;
}

/* What stands at `path`: the override, or what the file has. */
static ad_status place_view(reading *r, const char *path, view *v, const yaml_mark_t *key)
{
    override *o = override_of(r, path);
    if (o) {
        *v = (view){&o->document, yaml_document_get_root_node(&o->document), &o->origin};
    }
    return config_place(r->source, v->origin, path, o || !key ? v->node->start_mark : *key)
               ? AD_OK
               : no_memory(r);
}

static view child(const view *of, int index)
{
    return (view){of->document, yaml_document_get_node(of->document, index), of->origin};
}

/* Takes an entry in, unless it is null. */
static ad_status take(reading *r, section *s, const char *key, view value, const yaml_mark_t *mark)
{
    entry *e = &s->entries[s->count];
    *e = (entry){.key = key, .value = value};
    const int length =
        snprintf(e->path, sizeof e->path, "%s%s%s", s->path, *s->path ? "." : "", key);
    if (s->count + 1 == ENTRIES_MAX || length >= (int)sizeof e->path) {
        return config_blame(r->source, r->error, s->path,
                            "has too many keys or too long ones; allowed: %d", ENTRIES_MAX - 1);
    }
    ad_status status = place_view(r, e->path, &e->value, mark);
    s->count += status == AD_OK && !config_is_null(e->value.node);
    return status;
}

static bool has_entry(const section *s, const char *key)
{
    bool has = false;
    for (int i = 0; i < s->count; i++) {
        has = has || strcmp(s->entries[i].key, key) == 0;
    }
    return has;
}

/* The entries of a section, and those that overrides add. */
static ad_status read_section(reading *r, const char *path, const view *v, section *s)
{
    ad_status status = AD_OK;
    *s = (section){.path = path};
    if (v->node->type != YAML_MAPPING_NODE && !config_is_empty(v->node)) {
        return config_blame(r->source, r->error, path, "is no section; allowed: key: value");
    }
    const bool some = v->node->type == YAML_MAPPING_NODE;
    const yaml_node_pair_t *pair = some ? v->node->data.mapping.pairs.start : NULL;
    for (; some && pair < v->node->data.mapping.pairs.top && status == AD_OK; pair++) {
        const view key = child(v, pair->key);
        if (!is_scalar(&key) || !*scalar(&key) || strpbrk(scalar(&key), ".[]")) {
            return config_blame(r->source, r->error, path,
                                "a key here is not a word; allowed: key: value");
        }
        status = has_entry(s, scalar(&key))
                     ? config_blame(r->source, r->error, path, "%s is given twice; allowed: once",
                                    scalar(&key))
                     : take(r, s, scalar(&key), child(v, pair->value), &key.node->start_mark);
    }
    const size_t length = strlen(path);
    for (int i = 0; i < r->override_count && status == AD_OK; i++) {
        override *o = &r->overrides[i];
        const char *key = o->path + length + (length > 0);
        const bool here = strncmp(o->path, path, length) == 0 &&
                          (length == 0 || o->path[length] == '.') && *key && !strpbrk(key, ".[]");
        if (here && !has_entry(s, key)) {
            const view value = {&o->document, yaml_document_get_root_node(&o->document),
                                &o->origin};
            status = take(r, s, key, value, NULL);
        }
    }
    return status;
}

/* Blames a key that is none of `allowed`, "range, time". */
static ad_status unknown_key(reading *r, const entry *e, const char *allowed)
{
    const char *nearest = NULL;
    size_t near_length = 0;
    int best = 3;
    for (const char *word = allowed; *word;) {
        const size_t length = strcspn(word, ", ");
        const int far = spelling_distance(e->key, strlen(e->key), word, length);
        if (length > 0 && far < best) {
            best = far;
            nearest = word;
            near_length = length;
        }
        word += length + strspn(word + length, ", ");
    }
    return config_blame(r->source, r->error, e->path, "unknown key; %s%.*s%sallowed: %s",
                        nearest ? "did you mean " : "", (int)near_length, nearest ? nearest : "",
                        nearest ? "? " : "", allowed);
}

/* The entries [length] of a list; a scalar is a list of one. */
static ad_status read_list(reading *r, const char *path, const view *v, section *s)
{
    *s = (section){.path = path};
    const bool is_list = v->node->type == YAML_SEQUENCE_NODE;
    const long count =
        is_list ? v->node->data.sequence.items.top - v->node->data.sequence.items.start : 1;
    ad_status status = AD_OK;
    if (count >= ENTRIES_MAX) {
        return config_blame(r->source, r->error, path, "is too long; allowed: %d", ENTRIES_MAX - 1);
    }
    for (int i = 0; i < (int)count && status == AD_OK; i++) {
        entry *e = &s->entries[s->count++];
        *e = (entry){.key = "", .value = *v};
        snprintf(e->path, sizeof e->path, "%.140s%s%.*d%s", path, is_list ? "[" : "",
                 is_list ? 1 : 0, is_list ? i : 0, is_list ? "]" : "");
        if (is_list) {
            e->value = child(v, v->node->data.sequence.items.start[i]);
            status = place_view(r, e->path, &e->value, NULL);
        }
    }
    return status;
}

/* ---- values ---------------------------------------------------------------------------------- */

static ad_status read_text(reading *r, const entry *e, const char *what, const char **text)
{
    if (!is_scalar(&e->value) || !*scalar(&e->value)) {
        return config_blame(r->source, r->error, e->path, "is no %s; allowed: one %s", what, what);
    }
    *text = scalar(&e->value);
    return AD_OK;
}

static ad_status read_number(reading *r, const entry *e, double *number)
{
    const char *text = "";
    ad_error why;
    ad_status status = read_text(r, e, "number", &text);
    return status == AD_OK
               ? blame(r, e->path, equations_number(r->into->equations, text, number, &why), &why)
               : status;
}

static ad_status read_above_zero(reading *r, const entry *e, double *number)
{
    ad_status status = read_number(r, e, number);
    return status != AD_OK || (*number > 0 && isfinite(*number))
               ? status
               : config_blame(r->source, r->error, e->path, "is %g; allowed: above 0", *number);
}

static ad_status read_truth(reading *r, const entry *e, bool *truth)
{
    const char *text = "";
    ad_status status = read_text(r, e, "truth", &text);
    if (status != AD_OK) {
        return status;
    }
    *truth = strcmp(text, "true") == 0;
    return *truth || strcmp(text, "false") == 0
               ? AD_OK
               : config_blame(r->source, r->error, e->path, "is '%.40s'; allowed: true, false",
                              text);
}

static ad_status read_range(reading *r, const entry *e, double range[2])
{
    section s;
    ad_status status = read_list(r, e->path, &e->value, &s);
    if (status == AD_OK && s.count != 2) {
        status = config_blame(r->source, r->error, e->path,
                              "has %d numbers; allowed: 2, the smaller one first", s.count);
    }
    for (int i = 0; i < 2 && status == AD_OK; i++) {
        status = read_number(r, &s.entries[i], &range[i]);
    }
    return status;
}

/* ---- coordinates, parameters, fields --------------------------------------------------------- */

static ad_status read_coordinate(reading *r, const entry *of)
{
    section s;
    double range[2] = {NAN, NAN};
    ad_error why;
    equations_coordinate c = {.name = of->key};
    ad_status status = read_section(r, of->path, &of->value, &s);
    for (int i = 0; i < s.count && status == AD_OK; i++) {
        const entry *e = &s.entries[i];
        if (strcmp(e->key, "range") == 0) {
            status = read_range(r, e, range);
        } else if (strcmp(e->key, "periodic") == 0 || strcmp(e->key, "time") == 0) {
            status = read_truth(r, e, e->key[0] == 't' ? &c.time : &c.periodic);
        } else if (strcmp(e->key, "unit") == 0) {
            status = read_text(r, e, "unit", &c.unit);
        } else {
            status = unknown_key(r, e, "range, periodic, time, unit");
        }
    }
    if (status == AD_OK && isnan(range[0])) {
        status =
            config_blame(r->source, r->error, of->path, "has no range; allowed: {range: [0, 1]}");
    }
    c.low = range[0];
    c.high = range[1];
    return status == AD_OK
               ? blame(r, of->path, equations_add_coordinate(r->into->equations, &c, &why), &why)
               : status;
}

/* {guess: 0.02} or {range: [0.01, 0.1]} in place of a number. */
static ad_status read_open_parameter(reading *r, const entry *of)
{
    section s;
    double range[2] = {NAN, NAN}, guess = NAN;
    ad_error why;
    ad_status status = read_section(r, of->path, &of->value, &s);
    for (int i = 0; i < s.count && status == AD_OK; i++) {
        const entry *e = &s.entries[i];
        if (strcmp(e->key, "guess") == 0) {
            status = read_number(r, e, &guess);
        } else if (strcmp(e->key, "range") == 0) {
            status = read_range(r, e, range);
        } else {
            status = unknown_key(r, e, "guess, range");
        }
    }
    if (status == AD_OK && isnan(guess) == isnan(range[0])) {
        status = config_blame(r->source, r->error, of->path,
                              "allowed: a number, a formula, {guess: 0.1} of what data "
                              "determine, or {range: [0.1, 0.2]} of what it is solved for");
    }
    if (status != AD_OK) {
        return status;
    }
    equations *e = r->into->equations;
    status = isnan(guess) ? equations_add_range(e, of->key, range[0], range[1], &why)
                          : equations_add_unknown(e, of->key, guess, &why);
    return blame(r, of->path, status, &why);
}

/* Those that are numbers come before the coordinates, whose ranges may have them; formulas of
 * coordinates and fields after those. */
static ad_status read_parameters(reading *r, const section *s, bool done[ENTRIES_MAX], int round)
{
    ad_status status = AD_OK;
    for (int i = 0; i < s->count && status == AD_OK; i++) {
        const entry *e = &s->entries[i];
        const bool open = e->value.node->type == YAML_MAPPING_NODE;
        const char *text = "";
        ad_error why;
        if (done[i] || open != (round == 1)) {
            continue;
        }
        if (open) {
            status = read_open_parameter(r, e);
        } else {
            status = read_text(r, e, "number or formula", &text);
        }
        done[i] = status == AD_OK;
        if (!open && status == AD_OK) {
            status = equations_add_parameter(r->into->equations, e->key, text, &why);
            done[i] = status == AD_OK;
            status = round == 0 && status == AD_BAD_INPUT ? AD_OK : blame(r, e->path, status, &why);
        }
    }
    return status;
}

static ad_status read_fields(reading *r, const entry *of, bool inside)
{
    section s;
    const char *text = "";
    ad_error why;
    equations *e = r->into->equations;
    ad_status status = read_list(r, of->path, &of->value, &s);
    for (int i = 0; i < s.count && status == AD_OK; i++) {
        status = read_text(r, &s.entries[i], inside ? "formula" : "name", &text);
        if (status == AD_OK) {
            status =
                inside ? equations_add_inside(e, text, &why) : equations_add_field(e, text, &why);
            status = blame(r, s.entries[i].path, status, &why);
        }
    }
    return status;
}

/* ---- conditions and data --------------------------------------------------------------------- */

/* {at: {t: 0}, u: 0, u_t: 1} */
static ad_status read_condition(reading *r, const entry *of)
{
    section s, at = {0};
    double where = 0;
    const char *text = "";
    ad_error why;
    ad_status status = read_section(r, of->path, &of->value, &s);
    for (int i = 0; i < s.count && status == AD_OK; i++) {
        if (strcmp(s.entries[i].key, "at") == 0) {
            status = read_section(r, s.entries[i].path, &s.entries[i].value, &at);
        }
    }
    if (status == AD_OK && (at.count != 1 || s.count < 2)) {
        return config_blame(r->source, r->error, of->path, "%s; allowed: as in {at: {x: 0}, u: 1}",
                            at.count == 0   ? "has no face"
                            : at.count == 1 ? "says nothing of what is there"
                                            : "has a face of several coordinates");
    }
    status = status == AD_OK ? read_number(r, &at.entries[0], &where) : status;
    for (int i = 0; i < s.count && status == AD_OK; i++) {
        const entry *e = &s.entries[i];
        if (strcmp(e->key, "at") != 0) {
            status = read_text(r, e, "formula", &text);
            status = status == AD_OK
                         ? blame(r, e->path,
                                 equations_add_condition(r->into->equations, at.entries[0].key,
                                                         where, e->key, text, &why),
                                 &why)
                         : status;
        }
    }
    return status;
}

static ad_status take_data(reading *r, const entry *of, const char *file, double noise)
{
    const char *slash = strrchr(r->origin.file, '/');
    char path[4096];
    const char *names[ENTRIES_MAX];
    const double *columns[ENTRIES_MAX];
    ad_error why;
    table_file *table = NULL;
    const int folder = slash && file[0] != '/' ? (int)(slash - r->origin.file + 1) : 0;
    snprintf(path, sizeof path, "%.*s%s", folder, r->origin.file, file);
    ad_status status = table_read(path, TABLE_MEASURED, &table, &why);
    if (status == AD_OK && table_columns(table) > ENTRIES_MAX) {
        status =
            ad_fail(&why, AD_BAD_INPUT, "%.200s: too many columns; allowed: %d", file, ENTRIES_MAX);
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
    return blame(r, of->path, status, &why);
}

static ad_status read_data(reading *r, const entry *of)
{
    section s;
    const char *file = NULL;
    double noise = 0;
    ad_status status = read_section(r, of->path, &of->value, &s);
    for (int i = 0; i < s.count && status == AD_OK; i++) {
        const entry *e = &s.entries[i];
        if (strcmp(e->key, "file") == 0) {
            status = read_text(r, e, "name of a file", &file);
        } else if (strcmp(e->key, "noise") == 0) {
            status = read_above_zero(r, e, &noise);
        } else {
            status = unknown_key(r, e, "file, noise");
        }
    }
    if (status == AD_OK && !file) {
        status = config_blame(r->source, r->error, of->path,
                              "has no file; allowed: {file: measured.csv}");
    }
    return status == AD_OK ? take_data(r, of, file, noise) : status;
}

/* ---- sections -------------------------------------------------------------------------------- */

/* In the order in which they need each other, whatever that of the file is. */
static ad_status read_equations(reading *r, const entry *of)
{
    static const char *const keys[] = {"coordinates", "parameters", "fields",
                                       "inside",      "conditions", "data"};
    enum { COORDINATES, PARAMETERS, FIELDS, INSIDE, CONDITIONS, DATA, KEYS };
    section s, list[KEYS] = {{0}};
    const entry *given[KEYS] = {NULL};
    bool done[ENTRIES_MAX] = {false};
    ad_error why;
    ad_status status = read_section(r, of->path, &of->value, &s);
    for (int i = 0; i < s.count && status == AD_OK; i++) {
        int k = 0;
        while (k < KEYS && strcmp(s.entries[i].key, keys[k]) != 0) {
            k++;
        }
        if (k == KEYS) {
            return unknown_key(r, &s.entries[i],
                               "coordinates, parameters, fields, inside, conditions, data");
        }
        given[k] = &s.entries[i];
        if (k == COORDINATES || k == PARAMETERS) {
            status = read_section(r, given[k]->path, &given[k]->value, &list[k]);
        } else if (k == CONDITIONS) {
            status = read_list(r, given[k]->path, &given[k]->value, &list[k]);
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
    return status == AD_OK ? blame(r, of->path,
                                   equations_model(r->into->equations, &r->into->model, &why), &why)
                           : status;
}

static ad_status read_fit(reading *r, const entry *of)
{
    section s;
    ad_status status = read_section(r, of->path, &of->value, &s);
    for (int i = 0; i < s.count && status == AD_OK; i++) {
        const entry *e = &s.entries[i];
        if (strcmp(e->key, "tolerance") == 0) {
            status = read_above_zero(r, e, &r->into->tolerance);
        } else if (strcmp(e->key, "seconds") == 0) {
            status = read_above_zero(r, e, &r->into->seconds);
        } else {
            status = unknown_key(r, e, "tolerance, seconds");
        }
    }
    return status;
}

static void name_after(config_equations *into, const char *file)
{
    const char *slash = strrchr(file, '/'), *base = slash ? slash + 1 : file;
    const char *dot = strrchr(base, '.');
    snprintf(into->name, sizeof into->name, "%.*s",
             dot && dot > base ? (int)(dot - base) : (int)strlen(base), base);
}

static ad_status read_root(reading *r)
{
    const view root = {&r->document, yaml_document_get_root_node(&r->document), &r->origin};
    section s;
    const char *name = NULL;
    ad_status status = read_section(r, "", &root, &s);
    if (status == AD_OK && !has_entry(&s, "equations")) {
        return config_blame(r->source, r->error, "",
                            "has no equations; needed: a section equations. Scenes of rods and "
                            "beams are for cpinn-train and cpinn-solve");
    }
    for (int i = 0; i < s.count && status == AD_OK; i++) {
        const entry *e = &s.entries[i];
        if (strcmp(e->key, "name") == 0) {
            status = read_text(r, e, "name", &name);
            snprintf(r->into->name, sizeof r->into->name, "%.60s", name ? name : "");
        } else if (strcmp(e->key, "equations") == 0) {
            status = read_equations(r, e);
        } else if (strcmp(e->key, "fit") == 0) {
            status = read_fit(r, e);
        } else {
            status = unknown_key(r, e, "name, equations, fit");
        }
    }
    for (int i = 0; i < r->override_count && status == AD_OK; i++) {
        if (!r->overrides[i].used) {
            status = ad_fail(r->error, AD_BAD_INPUT,
                             "override %.200s: there is nothing at %.100s that it could change; "
                             "allowed: keys of the file, and new ones in its sections",
                             r->overrides[i].origin.override, r->overrides[i].path);
        }
    }
    return status;
}

static ad_status read_override(reading *r, const char *text)
{
    const char *equals = strchr(text, '=');
    const size_t length = equals ? (size_t)(equals - text) : 0;
    override *o = &r->overrides[r->override_count];
    *o = (override){.origin = {r->origin.file, text}};
    if (length == 0 || length >= sizeof o->path || r->override_count == OVERRIDES_MAX - 1) {
        return ad_fail(r->error, AD_BAD_INPUT,
                       "override %.200s: allowed: key=value, as equations.parameters.nu=0.02",
                       text);
    }
    memcpy(o->path, text, length);
    ad_status status =
        config_document(&o->origin, equals + 1, strlen(equals + 1), &o->document, r->error);
    r->override_count += status == AD_OK;
    return status;
}

ad_status config_equations_read(const char *path, const char *text, int count,
                                const char *const *overrides, config_equations **result,
                                ad_error *error)
{
    size_t size = text ? strlen(text) : 0;
    char *read = NULL;
    *result = NULL;
    ad_status status = text ? AD_OK : config_file_text(path, &read, &size, error);
    if (status != AD_OK) {
        return status;
    }
    reading *r = calloc(1, sizeof *r);
    config_equations *into = calloc(1, sizeof *into);
    if (r && into) {
        *r = (reading){.into = into, .origin = {path, NULL}, .error = error};
        r->source = config_source_create(path);
        into->equations = equations_create();
        into->tolerance = CONFIG_FIT_TOLERANCE;
        into->seconds = CONFIG_FIT_SECONDS;
        name_after(into, path);
    }
    if (!r || !into || !r->source || !into->equations) {
        status = ad_fail(error, AD_NO_MEMORY, "%s: out of memory", path);
    } else {
        status = config_document(&r->origin, text ? text : read, size, &r->document, error);
    }
    if (status == AD_OK) {
        for (int i = 0; i < count && status == AD_OK; i++) {
            status = read_override(r, overrides[i]);
        }
        status = status == AD_OK ? read_root(r) : status;
        for (int i = 0; i < r->override_count; i++) {
            yaml_document_delete(&r->overrides[i].document);
        }
        yaml_document_delete(&r->document);
    }
    if (r) {
        config_source_free(r->source);
    }
    free(r);
    free(read);
    if (status != AD_OK) {
        config_equations_free(into);
        into = NULL;
    }
    *result = into;
    return status;
}
