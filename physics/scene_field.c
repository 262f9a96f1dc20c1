#include "physics/scene_field.h"

#include "physics/scene_rows.h"

#include <stddef.h>

#define FIELD(key, count, member, part, rule, bounds, geometry, axes, unit, otherwise, ...)        \
    {key,                                                                                          \
     count,                                                                                        \
     offsetof(scene, member),                                                                      \
     SCENE_OF_##part,                                                                              \
     SCENE_##rule,                                                                                 \
     SCENE_##bounds,                                                                               \
     SCENE_##geometry,                                                                             \
     SCENE_##axes,                                                                                 \
     SCENE_##otherwise},

/* clang-format off */
const scene_field scene_fields[] = {
    SCENE_LENGTH_ROWS(FIELD)
    SCENE_DURATION_ROWS(FIELD)
    SCENE_MATTER_ROWS(FIELD)
    SCENE_DAMPING_ROWS(FIELD)
    SCENE_REST_ROWS(FIELD)
    SCENE_START_ROWS(FIELD)
    SCENE_BASE_ROWS(FIELD)
    SCENE_END_ROWS(FIELD)
    SCENE_TIP_ROWS(FIELD)
    SCENE_INITIAL_ROWS(FIELD)
    SCENE_LINE_ROWS(FIELD)
    SCENE_EXACT_ROWS(FIELD)
    SCENE_BEAM_ROWS(FIELD)
};
/* clang-format on */
const int scene_field_count = sizeof scene_fields / sizeof scene_fields[0];
_Static_assert(sizeof scene_fields / sizeof scene_fields[0] <= SCENE_FIELDS_MAX, "too many");

const quantity *scene_field_of(const scene *rod_scene, const scene_field *field)
{
    return (const quantity *)(const void *)((const char *)rod_scene + field->offset);
}

quantity scene_field_otherwise(const scene_field *field, int entry)
{
    static const double straight[3] = {0, 0, 1}, upright[4] = {1, 0, 0, 0};
    switch (field->otherwise) {
    case SCENE_ZERO:
        return quantity_number(0);
    case SCENE_STRAIGHT:
        return quantity_number(straight[entry]);
    case SCENE_UPRIGHT:
        return quantity_number(upright[entry]);
    case SCENE_NOTHING:
        break;
    }
    return (quantity){0};
}

bool scene_field_says(const scene *rod_scene, const scene_field *field)
{
    const quantity *given = scene_field_of(rod_scene, field);
    for (int i = 0; i < field->count; i++) {
        quantity otherwise = scene_field_otherwise(field, i);
        bool same = otherwise.is_given && quantity_is(given[i], otherwise.number);
        if (given[i].is_given && !same) {
            return true;
        }
    }
    return false;
}
