/* A YAML file as a tree, with overrides put in where they belong. */
#include "tools/config/config_tree.h"

#include "physics/quantity/spelling.h"

#include <stdlib.h>
#include <string.h>

/* ---- nodes ----------------------------------------------------------------------------------- */

static ad_status no_memory(config_tree *r)
{
    return ad_fail(r->error, AD_NO_MEMORY, "%s: out of memory", r->origin.file);
}

static const char *scalar(const config_view *v)
{
    return (const char *)v->node->data.scalar.value;
}

static bool is_scalar(const config_view *v)
{
    return v->node->type == YAML_SCALAR_NODE && strlen(scalar(v)) == v->node->data.scalar.length;
}

/* Whether `error` says what is wrong at a path; else AD_OK. */
ad_status config_tree_blame(config_tree *r, const char *path, ad_status status, const ad_error *why)
{
    if (status == AD_OK || status == AD_NO_MEMORY) {
        return status == AD_OK ? AD_OK : no_memory(r);
    }
    return config_blame(r->source, r->error, path, "%s", why->message);
}

static config_override *override_of(config_tree *r, const char *path)
{
    config_override *found = NULL;
    for (int i = 0; i < r->override_count; i++) {
        if (strcmp(r->overrides[i].path, path) == 0) {
            found = &r->overrides[i];
            found->used = true;
        }
    }
    return found;
}

/* What stands at `path`: the override, or what the file has. */
static ad_status place_view(config_tree *r, const char *path, config_view *v,
                            const yaml_mark_t *key)
{
    config_override *o = override_of(r, path);
    if (o) {
        *v = (config_view){&o->document, yaml_document_get_root_node(&o->document), &o->origin};
    }
    return config_place(r->source, v->origin, path, o || !key ? v->node->start_mark : *key)
               ? AD_OK
               : no_memory(r);
}

static config_view child(const config_view *of, int index)
{
    return (config_view){of->document, yaml_document_get_node(of->document, index), of->origin};
}

/* Takes an entry in, unless it is null. */
static ad_status take(config_tree *r, config_section *s, const char *key, config_view value,
                      const yaml_mark_t *mark)
{
    config_entry *e = &s->entries[s->count];
    *e = (config_entry){.key = key, .value = value};
    const int length =
        snprintf(e->path, sizeof e->path, "%s%s%s", s->path, *s->path ? "." : "", key);
    if (s->count + 1 == CONFIG_ENTRIES_MAX || length >= (int)sizeof e->path) {
        return config_blame(r->source, r->error, s->path,
                            "has too many keys or too long ones; allowed: %d",
                            CONFIG_ENTRIES_MAX - 1);
    }
    ad_status status = place_view(r, e->path, &e->value, mark);
    s->count += status == AD_OK && !config_is_null(e->value.node);
    return status;
}

bool config_tree_has(const config_section *s, const char *key)
{
    bool has = false;
    for (int i = 0; i < s->count; i++) {
        has = has || strcmp(s->entries[i].key, key) == 0;
    }
    return has;
}

/* The entries of a section, and those that overrides add. */
ad_status config_tree_section(config_tree *r, const char *path, const config_view *v,
                              config_section *s)
{
    ad_status status = AD_OK;
    *s = (config_section){.path = path};
    if (v->node->type != YAML_MAPPING_NODE && !config_is_empty(v->node)) {
        return config_blame(r->source, r->error, path, "is no section; allowed: key: value");
    }
    const bool some = v->node->type == YAML_MAPPING_NODE;
    const yaml_node_pair_t *pair = some ? v->node->data.mapping.pairs.start : NULL;
    for (; some && pair < v->node->data.mapping.pairs.top && status == AD_OK; pair++) {
        const config_view key = child(v, pair->key);
        if (!is_scalar(&key) || !*scalar(&key) || strpbrk(scalar(&key), ".[]")) {
            return config_blame(r->source, r->error, path,
                                "a key here is not a word; allowed: key: value");
        }
        status = config_tree_has(s, scalar(&key))
                     ? config_blame(r->source, r->error, path, "%s is given twice; allowed: once",
                                    scalar(&key))
                     : take(r, s, scalar(&key), child(v, pair->value), &key.node->start_mark);
    }
    const size_t length = strlen(path);
    for (int i = 0; i < r->override_count && status == AD_OK; i++) {
        config_override *o = &r->overrides[i];
        const char *key = o->path + length + (length > 0);
        const bool here = strncmp(o->path, path, length) == 0 &&
                          (length == 0 || o->path[length] == '.') && *key && !strpbrk(key, ".[]");
        if (here && !config_tree_has(s, key)) {
            const config_view value = {&o->document, yaml_document_get_root_node(&o->document),
                                       &o->origin};
            status = take(r, s, key, value, NULL);
        }
    }
    return status;
}

/* Blames a key that is none of `allowed`, "range, time". */
ad_status config_tree_unknown(config_tree *r, const config_entry *e, const char *allowed)
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
ad_status config_tree_list(config_tree *r, const char *path, const config_view *v,
                           config_section *s)
{
    *s = (config_section){.path = path};
    const bool is_list = v->node->type == YAML_SEQUENCE_NODE;
    const long count =
        is_list ? v->node->data.sequence.items.top - v->node->data.sequence.items.start : 1;
    ad_status status = AD_OK;
    if (count >= CONFIG_ENTRIES_MAX) {
        return config_blame(r->source, r->error, path, "is too long; allowed: %d",
                            CONFIG_ENTRIES_MAX - 1);
    }
    for (int i = 0; i < (int)count && status == AD_OK; i++) {
        config_entry *e = &s->entries[s->count++];
        *e = (config_entry){.key = "", .value = *v};
        snprintf(e->path, sizeof e->path, "%.140s%s%.*d%s", path, is_list ? "[" : "",
                 is_list ? 1 : 0, is_list ? i : 0, is_list ? "]" : "");
        if (is_list) {
            e->value = child(v, v->node->data.sequence.items.start[i]);
            status = place_view(r, e->path, &e->value, NULL);
        }
    }
    return status;
}

ad_status config_tree_text(config_tree *r, const config_entry *e, const char *what,
                           const char **text)
{
    if (!is_scalar(&e->value) || !*scalar(&e->value)) {
        return config_blame(r->source, r->error, e->path, "is no %s; allowed: one %s", what, what);
    }
    *text = scalar(&e->value);
    return AD_OK;
}

ad_status config_tree_truth(config_tree *r, const config_entry *e, bool *truth)
{
    const char *text = "";
    ad_status status = config_tree_text(r, e, "truth", &text);
    if (status != AD_OK) {
        return status;
    }
    *truth = strcmp(text, "true") == 0;
    return *truth || strcmp(text, "false") == 0
               ? AD_OK
               : config_blame(r->source, r->error, e->path, "is '%.40s'; allowed: true, false",
                              text);
}

static ad_status add_override(config_tree *r, const char *text)
{
    const char *equals = strchr(text, '=');
    const size_t length = equals ? (size_t)(equals - text) : 0;
    config_override *o = &r->overrides[r->override_count];
    *o = (config_override){.origin = {r->origin.file, text}};
    if (length == 0 || length >= sizeof o->path || r->override_count == CONFIG_OVERRIDES_MAX - 1) {
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

ad_status config_tree_open(config_tree *r, const char *path, const char *text, int count,
                           const char *const *overrides, ad_error *error)
{
    size_t size = text ? strlen(text) : 0;
    char *read = NULL;
    *r = (config_tree){.origin = {path, NULL}, .error = error};
    ad_status status = text ? AD_OK : config_file_text(path, &read, &size, error);
    r->source = status == AD_OK ? config_source_create(path) : NULL;
    if (status == AD_OK && !r->source) {
        status = no_memory(r);
    }
    if (status == AD_OK) {
        status = config_document(&r->origin, text ? text : read, size, &r->document, error);
        r->is_open = status == AD_OK;
    }
    for (int i = 0; i < count && status == AD_OK; i++) {
        status = add_override(r, overrides[i]);
    }
    free(read);
    return status;
}

void config_tree_close(config_tree *r)
{
    for (int i = 0; i < r->override_count; i++) {
        yaml_document_delete(&r->overrides[i].document);
    }
    if (r->is_open) {
        yaml_document_delete(&r->document);
    }
    config_source_free(r->source);
    *r = (config_tree){.source = NULL};
}

config_view config_tree_root(config_tree *r)
{
    return (config_view){&r->document, yaml_document_get_root_node(&r->document), &r->origin};
}

ad_status config_tree_all_used(config_tree *r)
{
    for (int i = 0; i < r->override_count; i++) {
        if (!r->overrides[i].used) {
            return ad_fail(r->error, AD_BAD_INPUT,
                           "override %.200s: there is nothing at %.100s that it could change; "
                           "allowed: keys of the file, and new ones in its sections",
                           r->overrides[i].origin.override, r->overrides[i].path);
        }
    }
    return AD_OK;
}
