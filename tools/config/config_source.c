/* Texts of an experiment and the places of its keys, for messages that point into the file. */
#include "tools/config/config_parts.h"

#include <stdarg.h>
#include <stdlib.h>
#include <string.h>

typedef struct kept_text {
    struct kept_text *next;
    char text[];
} kept_text;

typedef struct place {
    char path[CONFIG_PATH_MAX];
    const char *override; /* kept; NULL: the file */
    size_t line;          /* from 1 */
    size_t column;
    bool given;
} place;

struct config_source {
    kept_text *texts;
    const char *file;
    place *places;
    size_t count;
    size_t capacity;
};

config_source *config_source_create(const char *file)
{
    config_source *source = calloc(1, sizeof *source);
    if (source) {
        source->file = config_keep(source, file);
        if (!source->file) {
            config_source_free(source);
            source = NULL;
        }
    }
    return source;
}

void config_source_free(config_source *source)
{
    if (source) {
        while (source->texts) {
            kept_text *next = source->texts->next;
            free(source->texts);
            source->texts = next;
        }
        free(source->places);
        free(source);
    }
}

const char *config_source_file(const config_source *source)
{
    return source->file;
}

const char *config_keep(config_source *source, const char *text)
{
    size_t size = strlen(text) + 1;
    kept_text *kept = malloc(sizeof *kept + size);
    if (!kept) {
        return NULL;
    }
    memcpy(kept->text, text, size);
    kept->next = source->texts;
    source->texts = kept;
    return kept->text;
}

static bool grow(config_source *source)
{
    if (source->count < source->capacity) {
        return true;
    }
    size_t capacity = source->capacity ? 2 * source->capacity : 64;
    place *places = realloc(source->places, capacity * sizeof *places);
    if (!places) {
        return false;
    }
    source->places = places;
    source->capacity = capacity;
    return true;
}

bool config_place(config_source *source, const config_origin *origin, const char *path,
                  yaml_mark_t mark)
{
    const char *override = origin->override ? config_keep(source, origin->override) : NULL;
    if (!grow(source) || (origin->override && !override)) {
        return false;
    }
    place *added = &source->places[source->count++];
    snprintf(added->path, sizeof added->path, "%s", path);
    added->override = override;
    added->line = mark.line + 1;
    added->column = mark.column + 1;
    added->given = true;
    return true;
}

void config_unplace(config_source *source, const char *path)
{
    size_t length = strlen(path);
    for (size_t i = 0; i < source->count; i++) {
        const char *other = source->places[i].path;
        if (strncmp(other, path, length) == 0 &&
            (other[length] == '\0' || other[length] == '.' || other[length] == '[')) {
            source->places[i].given = false;
        }
    }
}

static const place *find(const config_source *source, const char *path)
{
    for (size_t i = source->count; i > 0; i--) {
        const place *candidate = &source->places[i - 1];
        if (candidate->given && strcmp(candidate->path, path) == 0) {
            return candidate;
        }
    }
    return NULL;
}

bool config_given(const config_source *source, const char *path)
{
    return find(source, path) != NULL;
}

bool config_overridden(const config_source *source, const char *path)
{
    const place *found = find(source, path);
    return found && found->override;
}

/* The place of the path or of the nearest section around it. */
static const place *find_nearest(const config_source *source, const char *path)
{
    char around[CONFIG_PATH_MAX];
    snprintf(around, sizeof around, "%s", path);
    const place *found = find(source, around);
    while (!found && around[0]) {
        char *dot = strrchr(around, '.');
        char *bracket = strrchr(around, '[');
        char *end = bracket > dot ? bracket : dot;
        *(end ? end : around) = '\0';
        found = find(source, around);
    }
    return found;
}

void config_one_line(char *text)
{
    for (; *text; text++) {
        if ((unsigned char)*text < 0x20 || *text == 0x7f) {
            *text = '?';
        }
    }
}

ad_status config_blame(const config_source *source, ad_error *error, const char *path,
                       const char *format, ...)
{
    char message[sizeof error->message];
    char where[300];
    const place *found = find_nearest(source, path);
    va_list arguments;
    va_start(arguments, format);
    vsnprintf(message, sizeof message, format, arguments);
    va_end(arguments);
    if (found && found->override) {
        snprintf(where, sizeof where, "override %.200s", found->override);
    } else if (found) {
        snprintf(where, sizeof where, "%.250s:%zu:%zu", source->file, found->line, found->column);
    } else {
        snprintf(where, sizeof where, "%.250s", source->file);
    }
    ad_fail(error, AD_BAD_INPUT, "%s: %s%s%s", where, path, *path ? ": " : "", message);
    if (error) {
        config_one_line(error->message);
    }
    return AD_BAD_INPUT;
}
