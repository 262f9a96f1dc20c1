/* The rows of stress.yaml, whose head explains them. */
#include "tools/judge/stress.h"

#include <stddef.h>
#include <stdlib.h>
#include <string.h>
#include <yaml.h>

struct stress_rows {
    yaml_document_t file; /* texts of rows are in it */
    stress_row *rows;     /* their scenes are allocated */
    size_t count;
};

typedef struct reader {
    yaml_document_t *file;
    ad_error *error;
} reader;

static ad_status blame(const reader *r, const yaml_node_t *node, const char *what)
{
    return ad_fail(r->error, AD_BAD_INPUT, "stress.yaml:%zu: %s", node->start_mark.line + 1, what);
}

static const yaml_node_t *node_of(const reader *r, int index)
{
    return yaml_document_get_node(r->file, index);
}

static const char *text_of(const yaml_node_t *node)
{
    return node->type == YAML_SCALAR_NODE ? (const char *)node->data.scalar.value : "";
}

static bool is_named(const yaml_node_t *node, const char *name)
{
    return strcmp(text_of(node), name) == 0;
}

/* How many entries a list has; -1: it is none. */
static int entries_of(const yaml_node_t *node)
{
    return node->type == YAML_SEQUENCE_NODE
               ? (int)(node->data.sequence.items.top - node->data.sequence.items.start)
               : -1;
}

static const yaml_node_t *entry_of(const reader *r, const yaml_node_t *list, int index)
{
    return node_of(r, list->data.sequence.items.start[index]);
}

/* Calls `take` for every key of a mapping. */
static ad_status walk(const reader *r, const yaml_node_t *node, void *to,
                      ad_status (*take)(const reader *r, const yaml_node_t *key,
                                        const yaml_node_t *value, void *to))
{
    ad_status status =
        node->type == YAML_MAPPING_NODE ? AD_OK : blame(r, node, "is no section with keys");
    for (yaml_node_pair_t *pair = node->data.mapping.pairs.start;
         status == AD_OK && pair < node->data.mapping.pairs.top; pair++) {
        status = take(r, node_of(r, pair->key), node_of(r, pair->value), to);
    }
    return status;
}

static ad_status take_expected(const reader *r, const yaml_node_t *key, const yaml_node_t *value,
                               void *to)
{
    stress_expectation *expected = to;
    const char *text = text_of(value);
    if (is_named(key, "solved") || is_named(key, "bound")) {
        expected->bound = strtod(text, NULL);
    } else if (is_named(key, "warning")) {
        expected->outcome = VERDICT_WARNING;
        expected->reason = verdict_reason_find(text);
        return expected->reason != VERDICT_NONE || strcmp(text, "none") == 0
                   ? AD_OK
                   : blame(r, value, "is no reason of a verdict");
    } else if (is_named(key, "refused") || is_named(key, "stopped")) {
        expected->outcome = is_named(key, "refused") ? VERDICT_REFUSED : VERDICT_STOPPED;
        expected->text = text;
    } else if (is_named(key, "why")) {
        expected->why = text;
    } else {
        return blame(r, key, "is not known of what is expected");
    }
    return AD_OK;
}

/* The texts of a list, each on lines of its own. */
static ad_status join(const reader *r, const yaml_node_t *list, const char **scene)
{
    char *text = NULL;
    size_t size = 0;
    FILE *file = open_memstream(&text, &size);
    for (int i = 0; file && i < entries_of(list); i++) {
        const char *part = text_of(entry_of(r, list, i));
        const size_t length = strlen(part);
        fprintf(file, "%s%s", part, length > 0 && part[length - 1] == '\n' ? "" : "\n");
    }
    if (!file || fclose(file) != 0) {
        free(text);
        return ad_fail(r->error, AD_NO_MEMORY, "out of memory for a scene");
    }
    *scene = text;
    return AD_OK;
}

static ad_status take_set(const reader *r, const yaml_node_t *list, stress_row *row)
{
    const int count = entries_of(list);
    if (count < 1 || count >= STRESS_OVERRIDES_MAX) {
        return blame(r, list, "is no list of few overrides");
    }
    for (int i = 0; i < count; i++) {
        row->overrides[i] = text_of(entry_of(r, list, i));
    }
    return AD_OK;
}

static ad_status take_key(const reader *r, const yaml_node_t *key, const yaml_node_t *value,
                          void *to)
{
    stress_row *row = to;
    const struct {
        const char *name, **text;
        double *number;
        bool *flag;
    } fields[] = {
        {"name", .text = &row->name},         {"about", .text = &row->about},
        {"file", .text = &row->file},         {"solver_set", .text = &row->solver_override},
        {"seconds", .number = &row->seconds}, {"tolerance", .number = &row->tolerance},
        {"quick", .flag = &row->quick},       {"long", .flag = &row->is_long}};
    for (size_t i = 0; i < sizeof fields / sizeof *fields; i++) {
        if (is_named(key, fields[i].name) && fields[i].text) {
            *fields[i].text = text_of(value);
            return AD_OK;
        }
        if (is_named(key, fields[i].name) && fields[i].number) {
            *fields[i].number = strtod(text_of(value), NULL);
            return AD_OK;
        }
        if (is_named(key, fields[i].name) && fields[i].flag) {
            *fields[i].flag = true;
            return AD_OK;
        }
    }
    if (is_named(key, "write")) {
        row->write = stress_formula(text_of(value));
        return row->write ? AD_OK : blame(r, value, "is no closed form");
    }
    if (is_named(key, "measure")) {
        row->measure = is_named(value, "rotation") ? stress_rotation : stress_energy_drift;
        return row->measure == stress_rotation || is_named(value, "energy_drift")
                   ? AD_OK
                   : blame(r, value, "is no measure");
    }
    return is_named(key, "scene") && entries_of(value) > 0 && !row->scene
               ? join(r, value, &row->scene)
           : is_named(key, "set")     ? take_set(r, value, row)
           : is_named(key, "network") ? walk(r, value, &row->expected[JUDGE_NETWORK], take_expected)
           : is_named(key, "solver")  ? walk(r, value, &row->expected[JUDGE_SOLVER], take_expected)
                                      : blame(r, key, "is not known of a row");
}

/* Parts, files and expectations stand where rows refer to them. */
static ad_status take_section(const reader *r, const yaml_node_t *key, const yaml_node_t *value,
                              void *to)
{
    stress_rows *all = to;
    ad_status status = AD_OK;
    const int count = is_named(key, "rows") ? entries_of(value) : 0;
    if (count > STRESS_ROWS_MAX || all->rows) {
        return blame(r, key, "is given twice, or has too many rows");
    }
    if (count > 0) {
        all->rows = calloc((size_t)count, sizeof *all->rows);
        status = all->rows ? AD_OK : ad_fail(r->error, AD_NO_MEMORY, "out of memory for rows");
    }
    for (int i = 0; i < count && status == AD_OK && all->rows; i++) {
        stress_row *row = &all->rows[all->count++];
        status = walk(r, entry_of(r, value, i), row, take_key);
        if (status == AD_OK && !(row->name && strchr(row->name, '/') && row->scene)) {
            status = blame(r, entry_of(r, value, i), "has no name, \"subject/case\", or no scene");
        }
    }
    return status;
}

ad_status stress_rows_open(stress_rows **result, ad_error *error)
{
    char *text = NULL;
    size_t size = 0;
    yaml_parser_t parser;
    FILE *file = open_memstream(&text, &size);
    stress_rows *all = calloc(1, sizeof *all);
    *result = NULL;
    for (const char *const *line = stress_text_stress; file && *line; line++) {
        fputs(*line, file);
    }
    if (!file || fclose(file) != 0 || !all || !yaml_parser_initialize(&parser)) {
        free(text);
        free(all);
        return ad_fail(error, AD_NO_MEMORY, "out of memory for rows");
    }
    yaml_parser_set_input_string(&parser, (const unsigned char *)text, size);
    const bool loaded = yaml_parser_load(&parser, &all->file) != 0;
    const yaml_node_t *root = loaded ? yaml_document_get_root_node(&all->file) : NULL;
    ad_status status = root ? walk(&(reader){&all->file, error}, root, all, take_section)
                       : parser.problem ? ad_fail(error, AD_BAD_INPUT, "stress.yaml:%zu: %s",
                                                  parser.problem_mark.line + 1, parser.problem)
                                        : ad_fail(error, AD_NO_MEMORY, "out of memory for rows");
    yaml_parser_delete(&parser);
    free(text);
    if (status != AD_OK) {
        stress_rows_free(all);
        return status;
    }
    *result = all;
    return AD_OK;
}

void stress_rows_free(stress_rows *all)
{
    for (size_t i = 0; all && i < all->count; i++) {
        free((char *)all->rows[i].scene);
    }
    if (all) {
        free(all->rows);
        yaml_document_delete(&all->file);
        free(all);
    }
}

const stress_row *stress_rows_of(const stress_rows *all, size_t *count)
{
    *count = all->count;
    return all->rows;
}
