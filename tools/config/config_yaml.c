/* From bytes to one YAML document, with every failure as one line that names its place. */
#include "tools/config/config_parts.h"

#include <errno.h>
#include <stdlib.h>
#include <string.h>
#include <sys/stat.h>

enum { CONFIG_BYTES_MAX = 1 << 20, DEPTH_MAX = 64, ANCHORS_MAX = 256 };

ad_status config_file_text(const char *path, char **text, size_t *size, ad_error *error)
{
    struct stat status;
    *text = NULL;
    if (stat(path, &status) != 0) {
        return ad_fail(error, AD_IO, "%s: cannot be read: %s", path, strerror(errno));
    }
    if (!S_ISREG(status.st_mode)) {
        return ad_fail(error, AD_IO, "%s: is %s; allowed: a YAML file", path,
                       S_ISDIR(status.st_mode) ? "a directory" : "not a regular file");
    }
    if (status.st_size > CONFIG_BYTES_MAX) {
        return ad_fail(error, AD_BAD_INPUT, "%s: is larger than 1 MB; allowed: a scene file", path);
    }
    FILE *file = fopen(path, "rb");
    if (!file) {
        return ad_fail(error, errno == ENOMEM ? AD_NO_MEMORY : AD_IO, "%s: cannot be read: %s",
                       path, strerror(errno));
    }
    *text = malloc((size_t)CONFIG_BYTES_MAX + 1);
    if (!*text) {
        fclose(file);
        return ad_fail(error, AD_NO_MEMORY, "%s: out of memory", path);
    }
    *size = fread(*text, 1, CONFIG_BYTES_MAX, file);
    bool failed = ferror(file) != 0;
    fclose(file);
    if (failed) {
        free(*text);
        *text = NULL;
        return ad_fail(error, AD_IO, "%s: cannot be read", path);
    }
    (*text)[*size] = '\0';
    return AD_OK;
}

static void where_text(const config_origin *origin, yaml_mark_t mark, char *text, size_t size)
{
    if (origin->override) {
        snprintf(text, size, "override %.200s", origin->override);
    } else {
        snprintf(text, size, "%.250s:%zu:%zu", origin->file, mark.line + 1, mark.column + 1);
    }
}

/* The scanner marks what it could not read only by a byte offset when the encoding is at fault. */
static yaml_mark_t mark_of_offset(const char *text, size_t size, size_t offset)
{
    yaml_mark_t mark = {offset, 0, 0};
    for (size_t i = 0; i < offset && i < size; i++) {
        mark.line += text[i] == '\n';
        mark.column = text[i] == '\n' ? 0 : mark.column + 1;
    }
    return mark;
}

static ad_status syntax_error(const config_origin *origin, const yaml_parser_t *parser,
                              const char *text, size_t size, ad_error *error)
{
    char where[300];
    const char *problem = parser->problem; /* none: memory, whatever libyaml calls it */
    yaml_mark_t mark = parser->problem_mark;
    if (parser->error == YAML_MEMORY_ERROR || !parser->problem) {
        return ad_fail(error, AD_NO_MEMORY, "%s: out of memory", origin->file);
    }
    if (parser->error == YAML_READER_ERROR) {
        mark = mark_of_offset(text, size, parser->problem_offset);
    }
    where_text(origin, mark, where, sizeof where);
    if (parser->error == YAML_SCANNER_ERROR && mark.index < size && text[mark.index] == '\t') {
        ad_fail(error, AD_BAD_INPUT, "%s: a tab indents this line; YAML allows spaces only", where);
    } else {
        ad_fail(error, AD_BAD_INPUT, "%s: not valid YAML: %s%s%s", where, problem,
                parser->context ? " " : "", parser->context ? parser->context : "");
    }
    if (error) {
        config_one_line(error->message);
    }
    return AD_BAD_INPUT;
}

static ad_status no_more_documents(const config_origin *origin, yaml_parser_t *parser,
                                   const char *text, size_t size, ad_error *error)
{
    yaml_document_t second;
    char where[300];
    if (!yaml_parser_load(parser, &second)) {
        return syntax_error(origin, parser, text, size, error);
    }
    yaml_node_t *root = yaml_document_get_root_node(&second);
    ad_status status = AD_OK;
    if (root) {
        where_text(origin, root->start_mark, where, sizeof where);
        status = ad_fail(error, AD_BAD_INPUT,
                         "%s: a second YAML document begins here; allowed: one", where);
    }
    yaml_document_delete(&second);
    return status;
}

static bool is_anchored(const yaml_event_t *event)
{
    return (event->type == YAML_SCALAR_EVENT && event->data.scalar.anchor) ||
           (event->type == YAML_SEQUENCE_START_EVENT && event->data.sequence_start.anchor) ||
           (event->type == YAML_MAPPING_START_EVENT && event->data.mapping_start.anchor);
}

/* The time that libyaml takes grows with the square of the depth and of the number of anchors. */
static ad_status check_limits(const config_origin *origin, const char *text, size_t size,
                              ad_error *error)
{
    yaml_parser_t parser;
    yaml_event_t event;
    ad_status status = AD_OK;
    bool over = false;
    if (!yaml_parser_initialize(&parser)) {
        return ad_fail(error, AD_NO_MEMORY, "%s: out of memory", origin->file);
    }
    yaml_parser_set_input_string(&parser, (const unsigned char *)text, size);
    for (int depth = 0, anchors = 0;
         status == AD_OK && !over && yaml_parser_parse(&parser, &event);) {
        anchors += is_anchored(&event);
        depth += event.type == YAML_SEQUENCE_START_EVENT || event.type == YAML_MAPPING_START_EVENT;
        depth -= event.type == YAML_SEQUENCE_END_EVENT || event.type == YAML_MAPPING_END_EVENT;
        over = event.type == YAML_STREAM_END_EVENT;
        char where[300] = "";
        if (anchors > ANCHORS_MAX || depth > DEPTH_MAX) {
            where_text(origin, event.start_mark, where, sizeof where);
        }
        if (anchors > ANCHORS_MAX) {
            status = ad_fail(error, AD_BAD_INPUT, "%s: anchor %d; allowed: %d in a file", where,
                             anchors, ANCHORS_MAX);
        }
        if (depth > DEPTH_MAX) {
            status = ad_fail(error, AD_BAD_INPUT, "%s: nested %d deep; allowed: %d", where, depth,
                             DEPTH_MAX);
        }
        yaml_event_delete(&event);
    }
    yaml_parser_delete(&parser);
    return status; /* of what is not YAML the place is told where it is read */
}

ad_status config_document(const config_origin *origin, const char *text, size_t size,
                          yaml_document_t *document, ad_error *error)
{
    yaml_parser_t parser;
    ad_status status = check_limits(origin, text, size, error);
    if (status != AD_OK) {
        return status;
    }
    if (!yaml_parser_initialize(&parser)) {
        return ad_fail(error, AD_NO_MEMORY, "%s: out of memory", origin->file);
    }
    yaml_parser_set_input_string(&parser, (const unsigned char *)text, size);
    if (!yaml_parser_load(&parser, document)) {
        status = syntax_error(origin, &parser, text, size, error);
        yaml_parser_delete(&parser);
        return status;
    }
    if (!yaml_document_get_root_node(document)) {
        status = ad_fail(error, AD_BAD_INPUT, "%s%s: is empty; allowed: %s",
                         origin->override ? "override " : "",
                         origin->override ? origin->override : origin->file,
                         origin->override ? "key=value" : "the sections of a scene file");
    } else {
        status = no_more_documents(origin, &parser, text, size, error);
    }
    if (status != AD_OK) {
        yaml_document_delete(document);
    }
    yaml_parser_delete(&parser);
    return status;
}
