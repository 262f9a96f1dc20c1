/* One value of a scene file: what a number is, and storing scalars and lists into their fields. */
#include "tools/config/config_parts.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

bool config_is_plain(const yaml_node_t *node)
{
    return node->type == YAML_SCALAR_NODE && node->data.scalar.style == YAML_PLAIN_SCALAR_STYLE;
}

static const char *scalar(const yaml_node_t *node)
{
    return (const char *)node->data.scalar.value;
}

bool config_is_empty(const yaml_node_t *node)
{
    return config_is_plain(node) && node->data.scalar.length == 0;
}

bool config_is_null(const yaml_node_t *node)
{
    return config_is_plain(node) &&
           (strcmp(scalar(node), "null") == 0 || strcmp(scalar(node), "~") == 0);
}

/* ---- numbers ------------------------------------------------------------------------------- */

static bool named_number(const char *text, double *value)
{
    static const char *const infinities[] = {".inf", ".Inf", ".INF"};
    static const char *const not_numbers[] = {".nan", ".NaN", ".NAN"};
    bool negative = *text == '-';
    const char *name = text + (*text == '-' || *text == '+');
    for (int i = 0; i < 3; i++) {
        if (strcmp(name, infinities[i]) == 0) {
            *value = negative ? -INFINITY : INFINITY;
            return true;
        }
        if (strcmp(text, not_numbers[i]) == 0) {
            *value = NAN;
            return true;
        }
    }
    return false;
}

/* Characters of [+-] digits [. digits] [e [+-] digits], 0 when the text does not begin so. */
static size_t decimal_length(const char *text)
{
    const char *digits = "0123456789";
    size_t at = *text == '+' || *text == '-';
    size_t whole = strspn(text + at, digits);
    size_t fraction = 0;
    at += whole;
    if (text[at] == '.') {
        fraction = strspn(text + at + 1, digits);
        at += 1 + fraction;
    }
    if (whole + fraction == 0) {
        return 0;
    }
    if (text[at] == 'e' || text[at] == 'E') {
        size_t sign = text[at + 1] == '+' || text[at + 1] == '-';
        size_t exponent = strspn(text + at + 1 + sign, digits);
        at += exponent ? 1 + sign + exponent : 0;
    }
    return at;
}

const char *config_parse_number(const char *text, double *value)
{
    if (named_number(text, value)) {
        return NULL;
    }
    const char *first = text + (*text == '-' || *text == '+');
    if (first[0] == '0' && (first[1] == 'x' || first[1] == 'X' || first[1] == 'o')) {
        return "is hexadecimal or octal; write it in decimals";
    }
    if (decimal_length(text) == 0 || text[decimal_length(text)] != '\0') {
        return "is not a number";
    }
    if (first[0] == '0' && first[1] >= '0' && first[1] <= '9') {
        return "begins with 0, which some YAML readers take for octal; leave the 0 out";
    }
    *value = strtod(text, NULL);
    if (isinf(*value)) {
        return "is too large for a number";
    }
    size_t mantissa = strcspn(text, "eE");
    if (*value == 0 && strcspn(text, "123456789") < mantissa) {
        return "is too small for a number; write 0";
    }
    return NULL;
}

/* ---- fields -------------------------------------------------------------------------------- */

void *config_field(config *experiment, const config_key *key, const char *path)
{
    const config_list *list = config_list_of(key->path);
    long index = list ? strtol(path + strlen(list->path) + 1, NULL, 10) : 0;
    if (config_parameter_of(path)) {
        return (char *)config_parameter_find(experiment, path) + key->offset -
               offsetof(config, parameters);
    }
    return (char *)config_key_base(experiment, key, (int)index) + key->offset;
}

/* "is 'abc'": long and quoted values are cut and told apart. */
static void value_text(const yaml_node_t *node, char text[96])
{
    if (node->type == YAML_SEQUENCE_NODE) {
        snprintf(text, 96, "is a list");
    } else if (node->type == YAML_MAPPING_NODE) {
        snprintf(text, 96, "is a section");
    } else if (config_is_empty(node)) {
        snprintf(text, 96, "has no value");
    } else if (config_is_plain(node)) {
        snprintf(text, 96, "is %.60s", scalar(node));
    } else {
        snprintf(text, 96, "is the text '%.60s'", scalar(node));
    }
}

static ad_status refuse(config_reader *reader, const config_key *key, const char *path,
                        const char *problem, bool entry)
{
    char allowed[300];
    if (entry) {
        config_key_entry_allowed(key, allowed, sizeof allowed);
    } else {
        config_key_allowed(key, allowed, sizeof allowed);
    }
    return config_blame(reader->experiment->source, reader->error, path, "%s; allowed: %s", problem,
                        allowed);
}

bool config_in_range(const config_key *key, double value)
{
    bool above = key->flags & CONFIG_LOW_OPEN ? value > key->low : value >= key->low;
    bool under = key->flags & CONFIG_HIGH_OPEN ? value < key->high : value <= key->high;
    return above && under && (isfinite(value) || key->flags & CONFIG_INFINITE);
}

/* NULL, or what is wrong. */
static const char *read_number(const config_key *key, const char *text, void *field)
{
    double value = 0;
    const char *problem = config_parse_number(text, &value);
    if (problem) {
        return problem;
    }
    if (key->type != CONFIG_NUMBER && value != floor(value)) {
        return "is not a whole number";
    }
    if (!config_in_range(key, value)) {
        return "is out of range";
    }
    if (key->type == CONFIG_NUMBER) {
        memcpy(field, &value, sizeof value);
    } else if (key->type == CONFIG_LONG) {
        int64_t whole = (int64_t)value;
        memcpy(field, &whole, sizeof whole);
    } else {
        int whole = (int)value;
        memcpy(field, &whole, sizeof whole);
    }
    return NULL;
}

static const char *read_choice(const config_key *key, const char *text, void *field)
{
    const char *const *names = key->names();
    for (int i = 0; names[i]; i++) {
        if (strcmp(names[i], text) == 0) {
            memcpy(field, &i, sizeof i);
            return NULL;
        }
    }
    return "";
}

static const char out_of_memory[] = "out of memory";

/* A number, or a formula that waits for the parameters. */
static const char *read_quantity(config_reader *reader, const config_key *key,
                                 const yaml_node_t *node, quantity *value)
{
    double number = 0;
    const char *text = scalar(node);
    if (decimal_length(text) != strlen(text) && !named_number(text, &number)) {
        *value = quantity_unparsed(reader->experiment->names, text);
        return NULL;
    }
    const char *problem = config_parse_number(text, &number);
    if (!problem && !config_in_range(key, number)) {
        problem = isfinite(number) || (key->flags & CONFIG_INFINITE) ? "is out of range"
                                                                     : "is not finite";
    }
    *value = quantity_number(number);
    return problem;
}

enum { NAME_MAX_LENGTH = 40 }; /* as quantities have it */

ad_status config_begin_parameter(config_reader *reader, const char *path, bool anew)
{
    config *experiment = reader->experiment;
    const char *name = config_parameter_of(path);
    config_parameter *parameter = config_parameter_find(experiment, path);
    if (!parameter) {
        if (experiment->parameter_count == CONFIG_PARAMETERS_MAX) {
            return config_blame(experiment->source, reader->error, path,
                                "is one parameter too many; allowed: %d", CONFIG_PARAMETERS_MAX);
        }
        if (strcspn(name, ".") > NAME_MAX_LENGTH) {
            return config_blame(experiment->source, reader->error, path,
                                "has a name of %zu characters; allowed: up to %d",
                                strcspn(name, "."), NAME_MAX_LENGTH);
        }
        parameter = &experiment->parameters[experiment->parameter_count++];
        snprintf(parameter->name, sizeof parameter->name, "%.*s", (int)strcspn(name, "."), name);
        anew = true;
    }
    parameter->value = (quantity){.is_given = false};
    if (anew) {
        parameter->range[0] = parameter->range[1] = parameter->identify = NAN;
        parameter->scale = CONFIG_SCALE_OPEN;
        parameter->of_key = false;
    }
    return AD_OK;
}

/* The one named in the path, or all, or one key below its name. */
static void unset_parameter(config *experiment, const config_key *key, const char *path)
{
    config_parameter *parameter = config_parameter_find(experiment, path);
    if (strcmp(path, CONFIG_PARAMETER_PATH) == 0) {
        experiment->parameter_count = 0;
    } else if (parameter && key->type == CONFIG_PARAMETER) {
        config_parameter *end = &experiment->parameters[experiment->parameter_count--];
        memmove(parameter, parameter + 1, (size_t)(end - parameter - 1) * sizeof *parameter);
    } else if (parameter && key->type == CONFIG_CHOICE) {
        parameter->scale = CONFIG_SCALE_OPEN;
    } else if (parameter && key->entries_max > 0) {
        parameter->range[0] = parameter->range[1] = NAN;
    } else if (parameter) {
        parameter->identify = NAN;
    }
}

static const char *read_text(config_reader *reader, const yaml_node_t *node, void *field)
{
    const char *text = scalar(node);
    for (size_t i = 0; i < node->data.scalar.length; i++) {
        if ((unsigned char)text[i] < 0x20) {
            return "holds a control character";
        }
    }
    if (node->data.scalar.length == 0 || node->data.scalar.length > 1000) {
        return "is empty or longer than 1000 bytes";
    }
    const char *kept = config_keep(reader->experiment->source, text);
    memcpy(field, &kept, sizeof kept);
    return kept ? NULL : out_of_memory;
}

/* A section of names and formulas becomes lines "name=formula". */
static ad_status read_formulas(config_reader *reader, const config_key *key, const char *path,
                               yaml_node_t *node)
{
    char *text = NULL;
    size_t size = 0;
    FILE *lines = open_memstream(&text, &size);
    char value[96];
    const char *problem = node->type == YAML_MAPPING_NODE ? NULL : value;
    value_text(node, value);
    if (!lines) {
        return ad_fail(reader->error, AD_NO_MEMORY, "%s: out of memory", reader->origin.file);
    }
    const yaml_node_pair_t *pair = problem ? NULL : node->data.mapping.pairs.start;
    for (; !problem && pair < node->data.mapping.pairs.top; pair++) {
        const yaml_node_t *name = yaml_document_get_node(reader->document, pair->key);
        const yaml_node_t *formula = yaml_document_get_node(reader->document, pair->value);
        if (name->type != YAML_SCALAR_NODE || formula->type != YAML_SCALAR_NODE ||
            strpbrk(scalar(name), "=\n") || !*scalar(name) || strchr(scalar(formula), '\n') ||
            !*scalar(formula)) {
            problem = "has what is not a name with a number or a formula";
        } else {
            fprintf(lines, "%s=%s\n", scalar(name), scalar(formula));
        }
    }
    const bool complete = fclose(lines) == 0;
    const char *kept = complete ? config_keep(reader->experiment->source, text) : NULL;
    problem = !problem && size == 0 ? "is empty" : problem;
    free(text);
    if (!kept) {
        return ad_fail(reader->error, AD_NO_MEMORY, "%s: out of memory", reader->origin.file);
    }
    if (problem) {
        return refuse(reader, key, path, problem, false);
    }
    *(const char **)config_field(reader->experiment, key, path) = kept;
    return AD_OK;
}

static bool tag_is_known(const yaml_node_t *node)
{
    static const char *const kinds[] = {"str", "int", "float", "null", "bool", "seq", "map"};
    const char *prefix = "tag:yaml.org,2002:";
    const char *tag = (const char *)node->tag;
    if (!tag || strncmp(tag, prefix, strlen(prefix)) != 0) {
        return tag == NULL;
    }
    for (size_t i = 0; i < sizeof kinds / sizeof *kinds; i++) {
        if (strcmp(tag + strlen(prefix), kinds[i]) == 0) {
            return true;
        }
    }
    return false;
}

/* One scalar into one field. */
static ad_status read_scalar(config_reader *reader, const config_key *key, const char *path,
                             yaml_node_t *node, void *field, bool entry)
{
    char value[96];
    char problem_text[200];
    const char *problem = NULL;
    value_text(node, value);
    bool numeric =
        key->type == CONFIG_NUMBER || key->type == CONFIG_INTEGER || key->type == CONFIG_LONG;
    if (!tag_is_known(node)) {
        return refuse(reader, key, path, "has a YAML tag", entry);
    }
    if (key->type == CONFIG_QUANTITY) {
        ad_status status = config_read_range(reader, path, node, field);
        if (status != AD_OK || node->type == YAML_MAPPING_NODE) {
            return status;
        }
    }
    if (node->type != YAML_SCALAR_NODE || config_is_empty(node) || config_is_null(node) ||
        (numeric && !config_is_plain(node))) {
        return refuse(reader, key, path, value, entry);
    }
    if (memchr(scalar(node), 0, node->data.scalar.length)) {
        return refuse(reader, key, path, "holds a zero byte", entry);
    }
    if (numeric) {
        problem = read_number(key, scalar(node), field);
    } else if (key->type == CONFIG_CHOICE) {
        problem = read_choice(key, scalar(node), field);
    } else if (key->type == CONFIG_TEXT) {
        problem = read_text(reader, node, field);
    } else if (key->type == CONFIG_PARAMETER) {
        config_parameter *parameter = config_parameter_find(reader->experiment, path);
        problem = read_quantity(reader, key, node, &parameter->value);
    } else {
        problem = read_quantity(reader, key, node, field);
    }
    if (!problem) {
        return AD_OK;
    }
    if (problem == out_of_memory) {
        return ad_fail(reader->error, AD_NO_MEMORY, "%s: out of memory", reader->origin.file);
    }
    snprintf(problem_text, sizeof problem_text, "%s%s%s", value, *problem ? ", which " : "",
             problem);
    return refuse(reader, key, path, problem_text, entry);
}

ad_status config_read_entry(config_reader *reader, const config_key *key, const char *path,
                            int index, yaml_node_t *node)
{
    char entry[CONFIG_PATH_MAX];
    char *field = config_field(reader->experiment, key, path);
    snprintf(entry, sizeof entry, "%.140s[%d]", path, index);
    if (!config_place(reader->experiment->source, &reader->origin, entry, node->start_mark)) {
        return ad_fail(reader->error, AD_NO_MEMORY, "%s: out of memory", reader->origin.file);
    }
    return read_scalar(reader, key, entry, node, field + (size_t)index * config_key_entry_size(key),
                       true);
}

static ad_status read_list(config_reader *reader, const config_key *key, const char *path,
                           yaml_node_t *node)
{
    char problem[160];
    const char *hint =
        key->type == CONFIG_QUANTITY ? " (a formula that contains a comma needs quotes)" : "";
    if (node->type != YAML_SEQUENCE_NODE) {
        value_text(node, problem);
        return refuse(reader, key, path, problem, false);
    }
    long count = node->data.sequence.items.top - node->data.sequence.items.start;
    if (count < key->entries_min || count > key->entries_max) {
        snprintf(problem, sizeof problem, "has %ld entries%s", count,
                 count > key->entries_max ? hint : "");
        return refuse(reader, key, path, problem, false);
    }
    for (int i = 0; i < (int)count; i++) {
        yaml_node_t *entry =
            yaml_document_get_node(reader->document, node->data.sequence.items.start[i]);
        ad_status status = config_read_entry(reader, key, path, i, entry);
        if (status != AD_OK) {
            return status;
        }
    }
    if (key->entries_min != key->entries_max) {
        int length = (int)count;
        char *field = config_field(reader->experiment, key, path);
        memcpy(field - key->offset + key->count_offset, &length, sizeof length);
    }
    return AD_OK;
}

ad_status config_reset_list(config_reader *reader, const config_list *list, int entry)
{
    config *pristine = malloc(sizeof *pristine);
    char *to = (char *)reader->experiment;
    size_t last = list->offset + (size_t)(list->most - 1) * list->stride;
    if (!pristine) {
        return ad_fail(reader->error, AD_NO_MEMORY, "%s: out of memory", reader->origin.file);
    }
    config_defaults(pristine);
    if (entry >= 0) {
        memcpy(to + list->offset + (size_t)entry * list->stride, (char *)pristine + last,
               list->stride);
    } else {
        memcpy(to + list->offset, (char *)pristine + list->offset,
               (size_t)list->most * list->stride);
        memcpy(to + list->count_offset, (char *)pristine + list->count_offset, sizeof(int));
        config_unplace(reader->experiment->source, list->path);
    }
    free(pristine);
    return AD_OK;
}

ad_status config_unset(config_reader *reader, const config_key *key, const char *path)
{
    if (config_parameter_of(key->path)) {
        unset_parameter(reader->experiment, key, path);
        config_unplace(reader->experiment->source, path);
        return AD_OK;
    }
    config *pristine = malloc(sizeof *pristine);
    if (!pristine) {
        return ad_fail(reader->error, AD_NO_MEMORY, "%s: out of memory", reader->origin.file);
    }
    config_defaults(pristine);
    const config_list *list = config_list_of(key->path);
    size_t entries = key->entries_max ? (size_t)key->entries_max : 1;
    const char *from = config_key_base(pristine, key, list ? list->most - 1 : 0);
    char *to = (char *)config_field(reader->experiment, key, path) - key->offset;
    memcpy(to + key->offset, from + key->offset, entries * config_key_entry_size(key));
    if (key->entries_min != key->entries_max) {
        memcpy(to + key->count_offset, from + key->count_offset, sizeof(int));
    }
    free(pristine);
    config_unplace(reader->experiment->source, path);
    return AD_OK;
}

ad_status config_read_value(config_reader *reader, const config_key *key, const char *path,
                            yaml_node_t *node)
{
    config_unplace(reader->experiment->source, path);
    if (!config_place(reader->experiment->source, &reader->origin, path, node->start_mark)) {
        return ad_fail(reader->error, AD_NO_MEMORY, "%s: out of memory", reader->origin.file);
    }
    if (config_is_null(node)) {
        return config_unset(reader, key, path);
    }
    if (config_parameter_of(path)) {
        ad_status status = config_begin_parameter(reader, path, key->type == CONFIG_PARAMETER);
        if (status != AD_OK) {
            return status;
        }
    }
    if (key->entries_max > 0) {
        return read_list(reader, key, path, node);
    }
    if (key->type == CONFIG_FORMULAS) {
        return read_formulas(reader, key, path, node);
    }
    return read_scalar(reader, key, path, node, config_field(reader->experiment, key, path), false);
}
