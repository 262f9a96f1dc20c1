/* Searching the table of keys, and what it says about a key in words. */
#include "tools/config/config_keys.h"

#include "physics/quantity/spelling.h"

#include <math.h>
#include <stdio.h>
#include <string.h>

/* What follows `section` in `path` ("length" for "rod"), NULL when path does not lie below it. */
static const char *below(const char *path, const char *section)
{
    size_t length = strlen(section);
    if (length == 0) {
        return path;
    }
    return strncmp(path, section, length) == 0 && path[length] == '.' ? path + length + 1 : NULL;
}

const char *config_parameter_of(const char *path)
{
    return below(path, "parameters");
}

config_parameter *config_parameter_find(config *experiment, const char *path)
{
    const char *name = config_parameter_of(path);
    const size_t length = name ? strcspn(name, ".") : 0;
    for (int i = 0; name && i < experiment->parameter_count; i++) {
        const char *known = experiment->parameters[i].name;
        if (strlen(known) == length && strncmp(known, name, length) == 0) {
            return &experiment->parameters[i];
        }
    }
    return NULL;
}

const config_key *config_key_find(const char *pattern)
{
    for (int i = 0; i < config_key_count; i++) {
        if (strcmp(config_keys[i].path, pattern) == 0) {
            return &config_keys[i];
        }
    }
    return NULL;
}

/* Adds the words of a line to `text`, after a space. */
static void add_words(const char *line, char *text, size_t size)
{
    const size_t length = strlen(text);
    line += strspn(line, " ");
    snprintf(text + length, size - length, "%s%.*s", length > 0 ? " " : "",
             (int)strcspn(line, "\n"), line);
}

/* The default of a setting that some optimisers have of their own: "0.9, soap 0.95". */
static void add_own_defaults(const config_key *key, char *text, size_t size)
{
    const char *name = strrchr(key->path, '.') + 1;
    for (int i = 0; i < optim_setting_count; i++) {
        const optim_setting *row = &optim_setting_rows[i];
        optim_settings settings = optim_settings_defaults(OPTIM_METHOD_COUNT);
        size_t used = 0;
        for (int m = 0; m < OPTIM_METHOD_COUNT && strcmp(row->name, name) == 0; m++) {
            if (optim_setting_is_own(row, (optim_method)m)) {
                if (used == 0) {
                    used = (size_t)snprintf(text, size, "%g", optim_setting_value(row, &settings));
                }
                settings = optim_settings_defaults((optim_method)m);
                used += (size_t)snprintf(text + used, size - used, ", %s %g",
                                         optim_method_name((optim_method)m),
                                         optim_setting_value(row, &settings));
            }
        }
    }
}

/* "adam: Adam; ...". */
static void add_optimizers(char *text, size_t size)
{
    for (int m = 0; m < OPTIM_METHOD_COUNT; m++) {
        const size_t length = strlen(text);
        snprintf(text + length, size - length, "%s%s: %s%s", m ? " " : "",
                 optim_method_name((optim_method)m), optim_method_about((optim_method)m),
                 m + 1 < OPTIM_METHOD_COUNT ? ";" : ".");
    }
}

config_words config_words_of(const config_key *key)
{
    static const char otherwise[] = "  default: ";
    config_words words = {"", ""};
    const char *const *line = config_text_keys;
    const size_t length = strlen(key->path);
    add_words(key->help ? key->help : "", words.help, sizeof words.help);
    add_words(key->fallback ? key->fallback : "", words.fallback, sizeof words.fallback);
    if (key->reads) {
        add_own_defaults(key, words.fallback, sizeof words.fallback);
    }
    if (key->names == optim_method_names) {
        add_optimizers(words.help, sizeof words.help);
    }
    while (*line && !(strncmp(*line, key->path, length) == 0 && (*line)[length] == '\n')) {
        line++;
    }
    for (line += *line != NULL; *line && **line == ' '; line++) {
        if (strncmp(*line, otherwise, sizeof otherwise - 1) == 0) {
            add_words(*line + sizeof otherwise - 1, words.fallback, sizeof words.fallback);
        } else if (strncmp(*line, "    ", 4) == 0) {
            add_words(*line, words.fallback, sizeof words.fallback);
        } else {
            add_words(*line, words.help, sizeof words.help);
        }
    }
    return words;
}

const config_key *config_key_by_name(const char *section)
{
    for (int i = 0; i < config_key_count; i++) {
        const char *name = below(config_keys[i].path, section);
        if ((config_keys[i].flags & CONFIG_BY_NAME) && name && !strchr(name, '.')) {
            return &config_keys[i];
        }
    }
    return NULL;
}

bool config_key_is_section(const char *pattern)
{
    for (int i = 0; i < config_key_count; i++) {
        if (below(config_keys[i].path, pattern)) {
            return true;
        }
    }
    return config_list_find(pattern) != NULL;
}

const config_list *config_list_find(const char *path)
{
    for (int i = 0; i < config_list_count; i++) {
        if (strcmp(config_lists[i].path, path) == 0) {
            return &config_lists[i];
        }
    }
    return NULL;
}

const config_list *config_list_of(const char *path)
{
    for (int i = 0; i < config_list_count; i++) {
        size_t length = strlen(config_lists[i].path);
        if (strncmp(config_lists[i].path, path, length) == 0 && path[length] == '[') {
            return &config_lists[i];
        }
    }
    return NULL;
}

int config_list_length(const config *experiment, const config_list *list)
{
    return *(const int *)(const void *)((const char *)experiment + list->count_offset);
}

int config_key_fields(const config *experiment, const config_key *key)
{
    const config_list *list = config_list_of(key->path);
    return list ? config_list_length(experiment, list) : 1;
}

void config_key_path(const config_key *key, int index, char path[CONFIG_PATH_MAX])
{
    const config_list *list = config_list_of(key->path);
    if (list) {
        snprintf(path, CONFIG_PATH_MAX, "%s[%d]%s", list->path, index,
                 key->path + strlen(list->path) + 2);
    } else {
        snprintf(path, CONFIG_PATH_MAX, "%s", key->path);
    }
}

const char *config_key_base(const config *experiment, const config_key *key, int index)
{
    const config_list *list = config_list_of(key->path);
    const char *base = (const char *)experiment;
    return list ? base + (size_t)index * list->stride : base;
}

void config_key_pattern(const char *path, char pattern[CONFIG_PATH_MAX])
{
    size_t at = 0;
    const char *named = config_parameter_of(path);
    if (named) {
        at = (size_t)snprintf(pattern, CONFIG_PATH_MAX, "%s", CONFIG_PARAMETER_PATH);
        path = named + strcspn(named, ".");
    }
    while (*path && at + 2 < CONFIG_PATH_MAX) {
        pattern[at++] = *path;
        if (*path == '[') {
            size_t digits = strspn(path + 1, "0123456789");
            path += digits;
        }
        path++;
    }
    pattern[at] = '\0';
}

bool config_key_applies(const config *experiment, const config_key *key, int index)
{
    return !key->reads ||
           (key->reads & optim_method_reads(experiment->settings.stages[index].optim.method));
}

static size_t part_length(const char *part)
{
    return strcspn(part, ".[");
}

static const char *last_part(const char *path)
{
    const char *dot = strrchr(path, '.');
    return dot ? dot + 1 : path;
}

void config_key_suggest(const char *pattern, char suggestion[CONFIG_PATH_MAX])
{
    const char *name = last_part(pattern);
    size_t length = strlen(name);
    int best = 1 + (int)length / 3;
    char section[CONFIG_PATH_MAX];
    suggestion[0] = '\0';
    snprintf(section, sizeof section, "%.*s", name > pattern ? (int)(name - pattern - 1) : 0,
             pattern);
    for (int i = 0; i < config_key_count; i++) {
        const char *part = below(config_keys[i].path, section);
        int far = part ? spelling_distance(name, length, part, part_length(part)) : 0;
        if (part && (far < best || (far == best && !*suggestion))) {
            best = far;
            snprintf(suggestion, CONFIG_PATH_MAX, "%.*s",
                     (int)(part - config_keys[i].path + (ptrdiff_t)part_length(part)),
                     config_keys[i].path);
        }
    }
    bool weak = !*suggestion || 2 * best >= (int)length; /* half of it is different */
    size_t most = 0;
    for (int i = 0; i < config_key_count && weak; i++) {
        const char *path = config_keys[i].path;
        size_t shared = 1; /* with one, of the same part of the file */
        while (path[shared - 1] && path[shared - 1] == pattern[shared - 1]) {
            shared++;
        }
        if (strcmp(last_part(path), name) == 0 && shared > most) {
            snprintf(suggestion, CONFIG_PATH_MAX, "%s", path);
            most = shared;
        }
    }
}

void config_key_siblings(const char *section, char *text, size_t size)
{
    size_t at = 0;
    const char *before = "";
    text[0] = '\0';
    for (int i = 0; i < config_key_count && at < size; i++) {
        const char *part = below(config_keys[i].path, section);
        size_t length = part ? part_length(part) : 0;
        if (part && !(strncmp(part, before, length) == 0 && part_length(before) == length)) {
            int written =
                snprintf(text + at, size - at, "%s%.*s", at ? ", " : "", (int)length, part);
            at += written > 0 ? (size_t)written : 0;
            before = part;
        }
    }
}

/* "> 0", "0 to 1", "" when any number will do. */
static void range_of(const config_key *key, char *text, size_t size)
{
    const char *more = key->flags & CONFIG_LOW_OPEN ? ">" : ">=";
    const char *less = key->flags & CONFIG_HIGH_OPEN ? "<" : "<=";
    bool numeric =
        key->type != CONFIG_CHOICE && key->type != CONFIG_TEXT && key->type != CONFIG_FORMULAS;
    text[0] = '\0';
    if (!numeric || (isinf(key->low) && isinf(key->high))) {
        return;
    }
    if (isinf(key->high)) {
        snprintf(text, size, "%s %.16g%s", more, key->low,
                 key->flags & CONFIG_INFINITE ? " or .inf" : "");
    } else if (key->flags & (CONFIG_LOW_OPEN | CONFIG_HIGH_OPEN)) {
        snprintf(text, size, "%s %.16g and %s %.16g", more, key->low, less, key->high);
    } else {
        snprintf(text, size, "%.16g to %.16g", key->low, key->high);
    }
}

static const char *type_text(config_type type, bool many)
{
    switch (type) {
    case CONFIG_NUMBER:
        return many ? "finite numbers" : "a finite number";
    case CONFIG_INTEGER:
    case CONFIG_LONG:
        return many ? "whole numbers" : "a whole number";
    case CONFIG_QUANTITY:
        return many ? "numbers or formulas" : "a number or a formula";
    case CONFIG_PARAMETER:
        return "a number, a formula or {range: [low, high], scale: linear or log, identify: "
               "number}";
    case CONFIG_CHOICE:
        return "one of";
    case CONFIG_FORMULAS:
        return "a section of names, each with a number or a formula";
    case CONFIG_TEXT:
        break;
    }
    return "text";
}

static void describe(const config_key *key, bool many, char *text, size_t size)
{
    char range[80];
    const char *type = type_text(key->type, many);
    range_of(key, range, sizeof range);
    if ((key->flags & CONFIG_INFINITE) && key->type == CONFIG_NUMBER) {
        type = many ? "numbers" : "a number";
    }
    size_t at = (size_t)snprintf(text, size, "%s%s%s%s%s", type, *range ? " " : "", range,
                                 key->unit ? ", in " : "", key->unit ? key->unit : "");
    for (int i = 0; key->names && key->names()[i] && at < size; i++) {
        at += (size_t)snprintf(text + at, size - at, "%s%s", i ? ", " : " ", key->names()[i]);
    }
}

void config_key_entry_allowed(const config_key *key, char *text, size_t size)
{
    describe(key, false, text, size);
}

void config_key_allowed(const config_key *key, char *text, size_t size)
{
    if (key->entries_max == 0) {
        describe(key, false, text, size);
        return;
    }
    char count[32];
    char entries[200];
    snprintf(count, sizeof count, key->entries_min == key->entries_max ? "%d" : "%d to %d",
             key->entries_min, key->entries_max);
    describe(key, true, entries, sizeof entries);
    snprintf(text, size, "a list of %s %s", count, entries);
}

size_t config_key_entry_size(const config_key *key)
{
    switch (key->type) {
    case CONFIG_NUMBER:
        return sizeof(double);
    case CONFIG_LONG:
        return sizeof(int64_t);
    case CONFIG_INTEGER:
    case CONFIG_CHOICE:
        return sizeof(int);
    case CONFIG_QUANTITY:
        return sizeof(quantity);
    case CONFIG_TEXT:
    case CONFIG_FORMULAS:
    case CONFIG_PARAMETER:
        break;
    }
    return sizeof(const char *);
}
