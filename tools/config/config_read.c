/* The walk through a YAML document along the table of keys: sections, lists of sections, merge
 * keys; and overrides, which are small documents put at one key. */
#include "tools/config/config_parts.h"

#include <stdlib.h>
#include <string.h>

enum { CONFIG_PAIRS_MAX = 64, CONFIG_VISITS_MAX = 20000, CONFIG_MERGES_MAX = 16 };

/* The entries of a section after merging. */
typedef struct section {
    const char *path; /* "rod", "training.stages[1]", "" */
    int count;
    yaml_node_t *keys[CONFIG_PAIRS_MAX];
    yaml_node_t *values[CONFIG_PAIRS_MAX];
} section;

static ad_status read_node(config_reader *reader, const char *path, yaml_node_t *node);

static const char *scalar(const yaml_node_t *node)
{
    return (const char *)node->data.scalar.value;
}

static ad_status no_memory(const config_reader *reader)
{
    return ad_fail(reader->error, AD_NO_MEMORY, "%s: out of memory", reader->origin.file);
}

/* Blame `path`, which stands at `node`. */
static ad_status blame_at(config_reader *reader, const yaml_node_t *node, const char *path,
                          const char *sentence)
{
    config_unplace(reader->experiment->source, path);
    if (!config_place(reader->experiment->source, &reader->origin, path, node->start_mark)) {
        return no_memory(reader);
    }
    return config_blame(reader->experiment->source, reader->error, path, "%s", sentence);
}

static void child_path(const char *path, const char *name, char child[CONFIG_PATH_MAX])
{
    snprintf(child, CONFIG_PATH_MAX, "%.90s%s%.60s", path, *path ? "." : "", name);
}

/* ---- unknown keys -------------------------------------------------------------------------- */

static bool is_known(const char *path)
{
    char pattern[CONFIG_PATH_MAX];
    config_key_pattern(path, pattern);
    return config_key_find(pattern) || config_key_is_section(pattern);
}

static void unknown_key_text(const char *path, char *text, size_t size)
{
    char pattern[CONFIG_PATH_MAX];
    char suggestion[CONFIG_PATH_MAX];
    char siblings[480];
    config_key_pattern(path, pattern);
    config_key_suggest(pattern, suggestion);
    char *dot = strrchr(pattern, '.');
    *(dot ? dot : pattern) = '\0';
    config_key_siblings(pattern, siblings, sizeof siblings);
    if (*suggestion) {
        const char *index = strchr(path, '[');
        const char *list = strstr(suggestion, "[]");
        bool same = index && list && index - path == list - suggestion;
        snprintf(text, size, "unknown key; did you mean %.*s%s?",
                 same ? (int)strcspn(path, "]") + 1 : 0, path, same ? list + 2 : suggestion);
    } else if (*siblings) {
        snprintf(text, size, "unknown key; allowed in %s: %s", *pattern ? pattern : "the file",
                 siblings);
    } else {
        snprintf(text, size, "unknown key; no section has that name");
    }
}

static ad_status unknown_key(config_reader *reader, const yaml_node_t *node, const char *path)
{
    char text[700];
    if (strcmp(path, "equations") == 0) {
        return blame_at(reader, node, path, "is of no scene; cpinn-fit takes files with equations");
    }
    unknown_key_text(path, text, sizeof text);
    return blame_at(reader, node, path, text);
}

/* What is gone, as checkpoints of 0.2.0 have it: a section that was not asked for, and a key that
 * only said what else a run wrote. */
static bool is_gone(const config_reader *reader, const char *path, const yaml_node_t *value)
{
    if (strcmp(path, "output.tensorboard") == 0) {
        return true;
    }
    bool gone = strcmp(path, "losses.self_adaptive") == 0 && value->type == YAML_MAPPING_NODE;
    const yaml_node_pair_t *pair = gone ? value->data.mapping.pairs.start : NULL;
    for (; gone && pair < value->data.mapping.pairs.top; pair++) {
        const yaml_node_t *rate = yaml_document_get_node(reader->document, pair->value);
        gone = rate->type == YAML_SCALAR_NODE && strcmp(scalar(rate), "0") == 0;
    }
    return gone;
}

/* ---- collecting the entries of a section --------------------------------------------------- */

static int find_name(const section *into, const char *name, int from)
{
    for (int i = from; i < into->count; i++) {
        if (strcmp(scalar(into->keys[i]), name) == 0) {
            return i;
        }
    }
    return -1;
}

static bool is_merge(const yaml_node_t *key)
{
    return config_is_plain(key) && strcmp(scalar(key), "<<") == 0;
}

/* Take one entry in, unless a section closer to the reader has that key. `from`: the first entry of
 * the mapping being read, among which a repeated key is an error. */
static ad_status take_entry(config_reader *reader, section *into, int from, bool merged,
                            yaml_node_t *key, yaml_node_t *value)
{
    char path[CONFIG_PATH_MAX];
    if (key->type != YAML_SCALAR_NODE || strlen(scalar(key)) != key->data.scalar.length ||
        key->data.scalar.length == 0) {
        return blame_at(reader, key, into->path, "a key here is not a word; allowed: key: value");
    }
    child_path(into->path, scalar(key), path);
    if (is_gone(reader, path, value)) {
        return AD_OK;
    }
    if (!is_known(path) || strpbrk(scalar(key), ".[]")) {
        return unknown_key(reader, key, path);
    }
    if (find_name(into, scalar(key), from) >= 0) {
        return blame_at(reader, key, path, "is given twice in this section; allowed: once");
    }
    if (merged && find_name(into, scalar(key), 0) >= 0) {
        return AD_OK;
    }
    if (into->count == CONFIG_PAIRS_MAX) {
        return blame_at(reader, key, path, "this section has too many keys");
    }
    into->keys[into->count] = key;
    into->values[into->count++] = value;
    return AD_OK;
}

static ad_status collect(config_reader *reader, section *into, yaml_node_t *node, int depth);

/* The value of `<<`: a section, or a list of sections of which earlier ones win. */
static ad_status merge(config_reader *reader, section *into, yaml_node_t *node, int depth)
{
    if (depth >= CONFIG_MERGES_MAX) {
        return blame_at(reader, node, into->path,
                        "<< merges are nested too deeply or refer to themselves");
    }
    if (node->type == YAML_MAPPING_NODE) {
        return collect(reader, into, node, depth + 1);
    }
    if (node->type != YAML_SEQUENCE_NODE) {
        return blame_at(reader, node, into->path, "<< needs an alias of a section, as <<: *name");
    }
    ad_status status = AD_OK;
    const yaml_node_item_t *item = node->data.sequence.items.start;
    for (; item < node->data.sequence.items.top && status == AD_OK; item++) {
        yaml_node_t *entry = yaml_document_get_node(reader->document, *item);
        if (entry->type == YAML_MAPPING_NODE) {
            status = collect(reader, into, entry, depth + 1);
        } else {
            status = blame_at(reader, entry, into->path, "<< needs a list of aliases of sections");
        }
        if (status == AD_OK && ++reader->visits > CONFIG_VISITS_MAX) {
            status = blame_at(reader, entry, into->path, "aliases expand to too many entries");
        }
    }
    return status;
}

/* The entries of a mapping: first its own, then those it merges, which never replace its own. */
static ad_status collect(config_reader *reader, section *into, yaml_node_t *node, int depth)
{
    yaml_node_t *merged = NULL;
    int from = into->count;
    ad_status status = AD_OK;
    yaml_node_pair_t *pair = node->data.mapping.pairs.start;
    for (; pair < node->data.mapping.pairs.top && status == AD_OK; pair++) {
        yaml_node_t *key = yaml_document_get_node(reader->document, pair->key);
        yaml_node_t *value = yaml_document_get_node(reader->document, pair->value);
        if (++reader->visits > CONFIG_VISITS_MAX) {
            status = blame_at(reader, key, into->path, "aliases expand to too many entries");
        } else if (!is_merge(key)) {
            status = take_entry(reader, into, from, depth > 0, key, value);
        } else if (merged) {
            status = blame_at(reader, key, into->path, "<< is given twice; allowed: <<: [*a, *b]");
        } else {
            merged = value;
        }
    }
    return status == AD_OK && merged ? merge(reader, into, merged, depth) : status;
}

/* ---- sections ------------------------------------------------------------------------------ */

/* null for a section: as if none of its keys had been given. */
static ad_status reset_section(config_reader *reader, const char *path)
{
    char pattern[CONFIG_PATH_MAX];
    ad_status status = AD_OK;
    config_key_pattern(path, pattern);
    size_t length = strlen(pattern);
    for (int i = 0; i < config_key_count && status == AD_OK; i++) {
        const config_key *key = &config_keys[i];
        char child[CONFIG_PATH_MAX];
        const char *rest = key->path + length;
        if (strncmp(key->path, pattern, length) != 0 || *rest != '.') {
            continue;
        }
        if (strstr(rest, "[]")) {
            status = config_reset_list(reader, config_list_of(key->path), -1);
        } else {
            child_path(path, rest + 1, child);
            status = config_unset(reader, key, child);
        }
    }
    config_unplace(reader->experiment->source, path);
    return status;
}

/* "section: name" in place of "section: {name: 0}", 0 for a default yet to be filled in; nothing
 * else of the section is then given. */
static ad_status read_name(config_reader *reader, const config_key *key, const char *path,
                           const yaml_node_t *node)
{
    ad_status status = reset_section(reader, path);
    if (status == AD_OK &&
        !config_place(reader->experiment->source, &reader->origin, key->path, node->start_mark)) {
        status = no_memory(reader);
    }
    if (status == AD_OK) {
        *(double *)config_field(reader->experiment, key, key->path) = 0;
    }
    return status;
}

/* Neither a section nor a name that stands for one. */
static ad_status blame_kind(config_reader *reader, const char *path, const config_key *by_name,
                            const yaml_node_t *node)
{
    char siblings[480], pattern[CONFIG_PATH_MAX], sentence[580];
    config_key_pattern(path, pattern);
    config_key_siblings(pattern, siblings, sizeof siblings);
    snprintf(sentence, sizeof sentence, "is a %s; allowed: %s%sa section with the keys %s",
             node->type == YAML_SEQUENCE_NODE ? "list" : "single value",
             by_name ? strrchr(by_name->path, '.') + 1 : "", by_name ? ", or " : "", siblings);
    return blame_at(reader, node, path, sentence);
}

static ad_status read_section(config_reader *reader, const char *path, yaml_node_t *node)
{
    section entries = {.path = path};
    const config_key *by_name = config_key_by_name(path);
    if (config_is_null(node)) {
        return reset_section(reader, path);
    }
    if (config_is_empty(node)) {
        return AD_OK;
    }
    if (node->type != YAML_MAPPING_NODE) {
        bool named = by_name && node->type == YAML_SCALAR_NODE &&
                     strcmp(scalar(node), strrchr(by_name->path, '.') + 1) == 0;
        return named ? read_name(reader, by_name, path, node)
                     : blame_kind(reader, path, by_name, node);
    }
    if (!reader->origin.override &&
        !config_place(reader->experiment->source, &reader->origin, path, node->start_mark)) {
        return no_memory(reader);
    }
    ad_status status = collect(reader, &entries, node, 0);
    for (int i = 0; i < entries.count && status == AD_OK; i++) {
        char child[CONFIG_PATH_MAX];
        child_path(path, scalar(entries.keys[i]), child);
        status = read_node(reader, child, entries.values[i]);
    }
    return status;
}

/* One entry of a list, whose other keys are at their defaults. */
static ad_status read_list_entry(config_reader *reader, const config_list *list, int index,
                                 yaml_node_t *node)
{
    config *experiment = reader->experiment;
    char path[CONFIG_PATH_MAX], required[CONFIG_PATH_MAX], pattern[CONFIG_PATH_MAX], allowed[300];
    snprintf(path, sizeof path, "%s[%d]", list->path, index);
    ad_status status = config_reset_list(reader, list, index);
    if (status == AD_OK) {
        status = read_node(reader, path, node);
    }
    if (status != AD_OK || !list->required) {
        return status;
    }
    child_path(path, list->required, required);
    if (config_given(experiment->source, required)) {
        return AD_OK;
    }
    config_key_pattern(required, pattern);
    config_key_allowed(config_key_find(pattern), allowed, sizeof allowed);
    return config_blame(experiment->source, reader->error, required, "missing; allowed: %s",
                        allowed);
}

/* The entries of a list replace what was there. */
static ad_status read_entries(config_reader *reader, const config_list *list, yaml_node_t *node)
{
    config *experiment = reader->experiment;
    char sentence[100];
    bool is_list = node->type == YAML_SEQUENCE_NODE;
    if (config_is_null(node)) {
        return config_reset_list(reader, list, -1);
    }
    long count = is_list ? node->data.sequence.items.top - node->data.sequence.items.start : 0;
    if (!is_list || count < list->least || count > list->most) {
        snprintf(sentence, sizeof sentence, "%s; allowed: a list of %d to %d %s",
                 !is_list    ? "is not a list"
                 : count < 1 ? "is empty"
                             : "is too long",
                 list->least, list->most, list->many);
        return blame_at(reader, node, list->path, sentence);
    }
    ad_status status = config_reset_list(reader, list, -1);
    if (status == AD_OK &&
        !config_place(experiment->source, &reader->origin, list->path, node->start_mark)) {
        status = no_memory(reader);
    }
    *(int *)(void *)((char *)experiment + list->count_offset) = (int)count;
    for (int i = 0; i < (int)count && status == AD_OK; i++) {
        status = read_list_entry(
            reader, list, i,
            yaml_document_get_node(reader->document, node->data.sequence.items.start[i]));
    }
    return status;
}

/* `path` is known. */
static ad_status read_node(config_reader *reader, const char *path, yaml_node_t *node)
{
    char pattern[CONFIG_PATH_MAX];
    config_key_pattern(path, pattern);
    const config_key *key = config_key_find(pattern);
    if (key && key->type == CONFIG_PARAMETER && node->type == YAML_MAPPING_NODE) {
        config_unplace(reader->experiment->source, path);
        ad_status status = config_begin_parameter(reader, path, true);
        return status == AD_OK ? read_section(reader, path, node) : status;
    }
    if (key) {
        return config_read_value(reader, key, path, node);
    }
    const config_list *list = config_list_find(pattern);
    if (list) {
        return read_entries(reader, list, node);
    }
    return read_section(reader, path, node);
}

/* "rod.material.youngs_modulus" -> "material_youngs_modulus"; false: too long for a name. */
static bool name_of(const char *path, char name[CONFIG_PARAMETER_BYTES])
{
    const char *from = strncmp(path, "rod.", 4) == 0 ? path + 4 : path;
    size_t length = 0;
    for (; *from && length + 1 < CONFIG_PARAMETER_BYTES; from++) {
        if (strchr(".[]", *from)) {
            name[length] = '_';
            length += length > 0 && name[length - 1] != '_';
        } else {
            name[length++] = *from;
        }
    }
    length -= length > 0 && name[length - 1] == '_';
    name[length] = '\0';
    return !*from && length <= 40;
}

ad_status config_read_range(config_reader *reader, const char *path, yaml_node_t *node,
                            quantity *field)
{
    char name[CONFIG_PARAMETER_BYTES], at[CONFIG_PATH_MAX];
    const bool named = name_of(path, name);
    snprintf(at, sizeof at, "parameters.%s", name);
    const config_parameter *before = named ? config_parameter_find(reader->experiment, at) : NULL;
    if (node->type != YAML_MAPPING_NODE) { /* others of that name are not of this key */
        return before && before->of_key
                   ? config_unset(reader, config_key_find(CONFIG_PARAMETER_PATH), at)
                   : AD_OK;
    }
    if (!named) {
        return blame_at(reader, node, path,
                        "has too long a path for a name; name it under parameters");
    }
    if (before && !before->of_key) {
        return blame_at(reader, node, path,
                        "would be a parameter of a name that parameters has; give it its range "
                        "there, and its name here");
    }
    ad_status status = config_begin_parameter(reader, at, true);
    if (status == AD_OK) {
        config_parameter_find(reader->experiment, at)->of_key = true;
    }
    *field = quantity_unparsed(reader->experiment->names, name);
    return status == AD_OK ? read_section(reader, at, node) : status;
}

ad_status config_read_document(config_reader *reader)
{
    return read_section(reader, "", yaml_document_get_root_node(reader->document));
}

/* ---- overrides ----------------------------------------------------------------------------- */

/* The first index in brackets of `path`, -1 when there is none. */
static long index_in(const char *path, const char **behind)
{
    const char *bracket = strchr(path, '[');
    char *end = NULL;
    if (!bracket || bracket[1] < '0' || bracket[1] > '9') {
        return -1;
    }
    long index = strtol(bracket + 1, &end, 10);
    *behind = end;
    return *end == ']' && index < 10000 ? index : -1;
}

/* path[index] = value for an entry of a list: whether `path` is such, and its key and place. */
static const config_key *entry_of(const char *path, char list[CONFIG_PATH_MAX], int *index)
{
    char pattern[CONFIG_PATH_MAX];
    const char *behind = NULL;
    snprintf(list, CONFIG_PATH_MAX, "%s", path);
    char *bracket = strrchr(list, '[');
    long number = bracket ? index_in(bracket, &behind) : -1;
    if (number < 0 || behind[1] != '\0') {
        return NULL;
    }
    *bracket = '\0';
    *index = (int)number;
    config_key_pattern(list, pattern);
    const config_key *key = config_key_find(pattern);
    return key && key->entries_max > 0 ? key : NULL;
}

static ad_status override_entry(config_reader *reader, const config_key *key, const char *path,
                                int index, yaml_node_t *node)
{
    int count = key->entries_max;
    const char *field = config_field(reader->experiment, key, path);
    if (key->entries_min != key->entries_max) {
        memcpy(&count, field - key->offset + key->count_offset, sizeof count);
    }
    bool given = count >= 0 && (key->type != CONFIG_QUANTITY ||
                                ((const quantity *)(const void *)field)->is_given);
    if (!given || index >= count) {
        return blame_at(reader, node, path,
                        given ? "the list is shorter; entries count from 0"
                              : "the list is not given; set all of it");
    }
    if (!config_given(reader->experiment->source, path) &&
        !config_place(reader->experiment->source, &reader->origin, path, node->start_mark)) {
        return no_memory(reader);
    }
    return config_read_entry(reader, key, path, index, node);
}

/* Whether the list has the entry that `path` speaks of; where it lies in none, it is fine. */
static ad_status find_entry(config_reader *reader, const yaml_node_t *node, const char *path)
{
    const config_list *list = config_list_of(path);
    const char *behind = NULL;
    char sentence[160];
    int count = list ? config_list_length(reader->experiment, list) : 0;
    long index = list ? index_in(path, &behind) : 0;
    if (!list || (index >= 0 && index < count)) {
        return AD_OK;
    }
    if (count == 0) {
        snprintf(sentence, sizeof sentence, "no such %s, the list is empty; give all of %s",
                 list->one, list->path);
    } else {
        snprintf(sentence, sizeof sentence, "no such %s; allowed: 0 to %d", list->one, count - 1);
    }
    return blame_at(reader, node, path, sentence);
}

ad_status config_read_override(config_reader *reader, const char *path)
{
    char list[CONFIG_PATH_MAX];
    int index = 0;
    yaml_node_t *node = yaml_document_get_root_node(reader->document);
    const config_key *key = entry_of(path, list, &index);
    if (strstr(path, "[]")) {
        return blame_at(reader, node, path, "needs an index, as in training.stages[0].steps");
    }
    if (!key && (!is_known(path) || strlen(path) > 80)) {
        return unknown_key(reader, node, path);
    }
    ad_status status = find_entry(reader, node, path);
    if (status != AD_OK) {
        return status;
    }
    return key ? override_entry(reader, key, list, index, node) : read_node(reader, path, node);
}
