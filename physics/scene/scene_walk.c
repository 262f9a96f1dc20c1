#include "physics/scene/scene_walk.h"

#include "physics/scene/scene_field.h"

#include <string.h>

/* Formulas count where they hold; of the numbers some are places along the rod. */
static void walk_field(const scene *rod_scene, const char *coordinate, const scene_field *field,
                       const scene_walker *walker)
{
    const quantity *q = scene_field_of(rod_scene, field);
    quantity_interval s = {0, scene_length(rod_scene)};
    bool along = strcmp(coordinate, "s") == 0;
    scene_field_span(rod_scene, field, &s.low, &s.high);
    for (int i = 0; i < field->count; i++) {
        if (quantity_depends_on(q[i], coordinate)) {
            walker->formula(walker->context, field->key, q[i], s);
        }
    }
    if (along && walker->place && field->rule == SCENE_PLACE && q->is_given) {
        walker->place(walker->context, field->key, q->number);
    }
}

void scene_walk(const scene *rod_scene, const char *coordinate, const scene_walker *walker)
{
    bool along = strcmp(coordinate, "s") == 0;
    for (int i = 0; i < scene_field_count; i++) {
        walk_field(rod_scene, coordinate, &scene_fields[i], walker);
    }
    for (int i = 0; i < rod_scene->segment_count && along && walker->place; i++) {
        walker->place(walker->context, "segments", scene_joint(rod_scene, i));
    }
}

static void count_formula(void *context, const char *key, quantity q, quantity_interval s)
{
    size_t *count = context;
    (void)key;
    (void)q;
    (void)s;
    ++*count;
}

size_t scene_walk_formulas(const scene *rod_scene, const char *coordinate)
{
    size_t count = 0;
    scene_walk(rod_scene, coordinate, &(scene_walker){.formula = count_formula, .context = &count});
    return count;
}
