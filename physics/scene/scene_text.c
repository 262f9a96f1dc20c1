/* Entries of the lists of a scene in words. */
#include "physics/scene/scene_field.h"

#include <stdarg.h>
#include <stddef.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

typedef struct line {
    char *text;
    size_t size, used;
} line;

static void add(line *to, const char *format, ...) __attribute__((format(printf, 2, 3)));

static void add(line *to, const char *format, ...)
{
    va_list arguments;
    va_start(arguments, format);
    int length = vsnprintf(to->text + to->used, to->size - to->used, format, arguments);
    va_end(arguments);
    to->used += length > 0 ? (size_t)length : 0;
    to->used = to->used < to->size ? to->used : to->size - 1;
}

static void add_field(line *to, const scene *rod_scene, const scene_field *field, const char *name)
{
    const quantity *q = scene_field_of(rod_scene, field);
    add(to, " %s", name);
    for (int i = 0; i < field->count; i++) {
        char *text = quantity_text(q[i], true);
        add(to, "%s%s", i ? ", " : " ", text ? text : "out of memory");
        free(text);
    }
    add(to, ";");
}

/* What is no quantity. */
static void add_choices(line *to, const scene *rod_scene, const scene_list *list, int index)
{
    if (list->offset == offsetof(scene, segments)) {
        scene_piece piece = scene_piece_of(rod_scene, index);
        add(to, " %g to %g m", piece.from, piece.to);
        if (piece.rod.section != SCENE_SECTION_NONE) {
            add(to, ", %s", scene_section_names()[piece.rod.section]);
        }
    } else if (list->offset == offsetof(scene, points)) {
        add(to, " %s", scene_frame_names()[rod_scene->points[index].load.frame]);
    } else {
        to->used--; /* the last semicolon */
        to->text[to->used] = '\0';
    }
}

bool scene_entry_text(const scene *rod_scene, int index, char *text, size_t size)
{
    const scene_list *list = scene_lists;
    line to = {text, size, 0};
    while (list < scene_lists + scene_list_count && index >= scene_list_length(rod_scene, list)) {
        index -= scene_list_length(rod_scene, list++);
    }
    if (list == scene_lists + scene_list_count) {
        return false;
    }
    add(&to, "%s[%d]:", list->key, index);
    size_t prefix = to.used;
    for (int i = 0; i < scene_field_count; i++) {
        int at = 0;
        const scene_field *field = &scene_fields[i];
        if (scene_field_list(field, &at) == list && at == index &&
            scene_field_says(rod_scene, field)) {
            add_field(&to, rod_scene, field, field->key + prefix);
        }
    }
    add_choices(&to, rod_scene, list, index);
    return true;
}
