#include "physics/scene/scene_field.h"

#include "physics/scene/scene_rows.h"

#include <math.h>
#include <stddef.h>
#include <stdio.h>
#include <string.h>

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

/* What a segment does not give is that of the whole rod. */
#define SEGMENT_FIELD(key, count, member, part, rule, bounds, geometry, axes, unit, otherwise,     \
                      ...)                                                                         \
    FIELD(key, count, member, part, rule, bounds, geometry, axes, unit, NOTHING, NULL)

/* clang-format off */
#define TWELVE(X)  X(0) X(1) X(2) X(3) X(4) X(5) X(6) X(7) X(8) X(9) X(10) X(11)
#define FOUR(X)    X(0) X(1) X(2) X(3)
#define SIXTEEN(X) TWELVE(X) X(12) X(13) X(14) X(15)
#define PIECE(i)   SCENE_PIECE_ROWS(FIELD, "segments[" #i "].", segments[i].)
#define MATTER(i)  SCENE_MATTER_ROWS(SEGMENT_FIELD, "segments[" #i "].", segments[i].rod.)
#define DAMPING(i) SCENE_DAMPING_ROWS(SEGMENT_FIELD, "segments[" #i "].", segments[i].rod.)
#define REST(i)    SCENE_REST_ROWS(SEGMENT_FIELD, "segments[" #i "].", segments[i].rod.)
#define TURN(i)    SCENE_TURN_ROWS(FIELD, "segments[" #i "].", segments[i].)
#define POINT(i)   SCENE_POINT_ROWS(FIELD, "loads.points[" #i "].", points[i].)
#define BODY(i)    SCENE_BODY_ROWS(FIELD, "bodies[" #i "].", bodies[i].)
#define SPRING(i)  SCENE_SPRING_ROWS(FIELD, "springs[" #i "].", springs[i].)
#define TENDON(i)  SCENE_TENDON_ROWS(FIELD, "tendons[" #i "].", tendons[i].)
#define CHAMBER(i) SCENE_CHAMBER_ROWS(FIELD, "chambers[" #i "].", chambers[i].)
#define TUBE(i)    SCENE_TUBE_ROWS(FIELD, "tubes[" #i "].", tubes[i].)
#define BEAM_POINT(i) SCENE_BEAM_POINT_ROWS(FIELD, "beam.points[" #i "].", beam.points[i].)

_Static_assert(SCENE_SEGMENTS_MAX == 12 && SCENE_CHAMBERS_MAX == 12, "rows for each");
_Static_assert(SCENE_POINTS_MAX == 16 && SCENE_BODIES_MAX == 16 && SCENE_SPRINGS_MAX == 16 &&
               SCENE_TENDONS_MAX == 16 && SCENE_TUBES_MAX == 4, "rows for each");

const scene_field scene_fields[] = {
    SCENE_LENGTH_ROWS(FIELD)
    TWELVE(PIECE)
    SCENE_DURATION_ROWS(FIELD)
    SCENE_MATTER_ROWS(FIELD, "rod.", rod.)
    SCENE_DAMPING_ROWS(FIELD, "rod.", rod.)
    SCENE_REST_ROWS(FIELD, "rod.", rod.)
    TWELVE(MATTER)
    TWELVE(DAMPING)
    TWELVE(REST)
    TWELVE(TURN)
    SCENE_START_ROWS(FIELD)
    SCENE_BASE_ROWS(FIELD)
    SCENE_END_ROWS(FIELD)
    SCENE_TIP_ROWS(FIELD)
    SCENE_INITIAL_ROWS(FIELD)
    SCENE_LINE_ROWS(FIELD)
    SIXTEEN(POINT)
    SIXTEEN(BODY)
    SIXTEEN(SPRING)
    SIXTEEN(TENDON)
    TWELVE(CHAMBER)
    FOUR(TUBE)
    SCENE_EXACT_ROWS(FIELD)
    SCENE_BEAM_ROWS(FIELD)
    SIXTEEN(BEAM_POINT)
};
/* clang-format on */
const int scene_field_count = sizeof scene_fields / sizeof scene_fields[0];
_Static_assert(sizeof scene_fields / sizeof scene_fields[0] <= SCENE_FIELDS_MAX, "too many");

#define LIST(key, entries, count, most)                                                            \
    {                                                                                              \
        key, offsetof(scene, entries), sizeof(((scene *)NULL)->entries[0]),                        \
            offsetof(scene, count), most                                                           \
    }
const scene_list scene_lists[] = {
    LIST("segments", segments, segment_count, SCENE_SEGMENTS_MAX),
    LIST("loads.points", points, point_count, SCENE_POINTS_MAX),
    LIST("bodies", bodies, body_count, SCENE_BODIES_MAX),
    LIST("springs", springs, spring_count, SCENE_SPRINGS_MAX),
    LIST("tendons", tendons, tendon_count, SCENE_TENDONS_MAX),
    LIST("chambers", chambers, chamber_count, SCENE_CHAMBERS_MAX),
    LIST("tubes", tubes, tube_count, SCENE_TUBES_MAX),
    LIST("beam.points", beam.points, beam.point_count, SCENE_POINTS_MAX),
};
const int scene_list_count = sizeof scene_lists / sizeof scene_lists[0];

int scene_list_length(const scene *rod_scene, const scene_list *list)
{
    return *(const int *)(const void *)((const char *)rod_scene + list->count_offset);
}

const scene_list *scene_field_list(const scene_field *field, int *index)
{
    for (int i = 0; i < scene_list_count; i++) {
        const scene_list *list = &scene_lists[i];
        size_t into = field->offset - list->offset;
        if (field->offset >= list->offset && into < (size_t)list->most * list->stride) {
            *index = (int)(into / list->stride);
            return list;
        }
    }
    return NULL;
}

const quantity *scene_field_of(const scene *rod_scene, const scene_field *field)
{
    static const quantity nothing[4];
    int index = 0;
    const scene_list *list = scene_field_list(field, &index);
    if (list && index >= scene_list_length(rod_scene, list)) {
        return nothing;
    }
    return (const quantity *)(const void *)((const char *)rod_scene + field->offset);
}

bool scene_field_span(const scene *rod_scene, const scene_field *field, double *from, double *to)
{
    int index = 0;
    const scene_list *list = scene_field_list(field, &index);
    double length = scene_length(rod_scene);
    bool in_list = list && index < scene_list_length(rod_scene, list);
    if (in_list && list->offset == offsetof(scene, segments)) {
        *from = scene_joint(rod_scene, index - 1);
        *to = fmin(scene_joint(rod_scene, index), length);
    } else if (in_list && (list->offset == offsetof(scene, tendons) ||
                           list->offset == offsetof(scene, chambers))) {
        const bool behind = list->offset == offsetof(scene, chambers);
        const scene_actuator one =
            scene_actuator_of(rod_scene, index + (behind ? rod_scene->tendon_count : 0));
        *from = one.from;
        *to = one.to;
    } else if (in_list && list->offset == offsetof(scene, tubes)) {
        *from = 0;
        *to = scene_tube_end(rod_scene, index);
    } else {
        return false;
    }
    return true;
}

const char *scene_key_of(const scene *rod_scene, const quantity *q)
{
    ptrdiff_t offset = (const char *)q - (const char *)rod_scene;
    for (int i = 0; i < scene_field_count; i++) {
        ptrdiff_t into = offset - (ptrdiff_t)scene_fields[i].offset;
        if (into >= 0 && into < scene_fields[i].count * (ptrdiff_t)sizeof *q) {
            return scene_fields[i].key;
        }
    }
    return "";
}

const char *scene_key_in_segment(int index, const char *key)
{
    static const char *const sections[] = {
#define SECTION(i) "segments[" #i "].section",
        TWELVE(SECTION)};
    char prefix[24];
    size_t length = (size_t)snprintf(prefix, sizeof prefix, "segments[%d].", index);
    const char *rest = strncmp(key, "rod.", 4) == 0 ? key + 4 : key;
    for (int i = 0; i < scene_field_count && rest != key; i++) {
        const char *candidate = scene_fields[i].key;
        if (strncmp(candidate, prefix, length) == 0 && strcmp(candidate + length, rest) == 0) {
            return candidate;
        }
    }
    return strcmp(rest, "section") == 0 ? sections[index] : key;
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

void scene_with(const scene *open, int count, const char *const *names, const double *values,
                scene *result)
{
    *result = *open;
    for (int i = 0; i < scene_field_count; i++) {
        quantity *q = (quantity *)(void *)((char *)result + scene_fields[i].offset);
        for (int k = 0; k < scene_fields[i].count; k++) {
            q[k] = quantity_with(q[k], count, names, values);
        }
    }
    result->place = quantity_with(open->place, count, names, values);
    result->rod.growth = quantity_with(open->rod.growth, count, names, values);
    for (int i = 0; i < open->tube_count; i++) {
        result->tubes[i].rod.growth = result->rod.growth;
    }
}

bool scene_memory_uses(const scene *rod_scene, const char *name)
{
    bool any = false;
    for (int i = 0; i < rod_scene->memory_count && !any; i++) {
        const scene_memory *memory = &rod_scene->memory[i];
        any = quantity_depends_on(memory->next, name) || quantity_depends_on(memory->time, name);
    }
    return any;
}

bool scene_uses(const scene *rod_scene, const char *name)
{
    bool any = quantity_depends_on(rod_scene->place, name);
    for (int i = 0; i < scene_field_count && !any; i++) {
        const scene_field *field = &scene_fields[i];
        any = quantity_any_depends_on(field->count, scene_field_of(rod_scene, field), name);
    }
    return any || scene_memory_uses(rod_scene, name);
}
