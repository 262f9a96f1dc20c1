/* Motion in a plane: whether a scene keeps the rod in one, and its frame.
 *
 * By symmetry: the mirror image of the scene in the plane is the scene itself, so the equations
 * have a solution that is its own mirror image. Its normal is a body director d1 or d2 all along
 * the rod; vectors lie in the plane, axial vectors (moment, curvature, spin) along the normal. */
#include "physics/rod/rod_internal.h"
#include "physics/scene/scene_field.h"

#include <math.h>

enum { PLANE_ITEMS_MAX = SCENE_FIELDS_MAX + 2 };

/* Rounding of numbers that the author wrote; what is exactly 0 there stays so. */
static const double PLANE_ROUNDING = 1e-12;

/* ---- what a scene says ----------------------------------------------------------------------- */

/* One entry of a vector: a number, or a formula of s or t. */
typedef struct plane_entry {
    bool is_number;
    double value;
} plane_entry;

typedef struct plane_item {
    const char *key;
    scene_geometry geometry;
    bool is_body;
    plane_entry x[5];
} plane_item;

/* Entries of a quantity of that kind. */
static int plane_entries(scene_geometry geometry)
{
    return geometry == SCENE_GRADIENT        ? 5
           : geometry == SCENE_ORIENTATION   ? 4
           : geometry == SCENE_SECTION_POINT ? 2
                                             : 3;
}

typedef struct plane_list {
    int count;
    plane_item items[PLANE_ITEMS_MAX];
} plane_list;

/* Of a quaternion that is not given the identity, else 0. */
static void plane_add(plane_list *list, const char *key, scene_geometry geometry, bool is_body,
                      const quantity *given, const double *otherwise)
{
    static const double upright[4] = {1, 0, 0, 0}, zeros[5] = {0};
    bool turns = geometry == SCENE_ORIENTATION;
    plane_item *item = &list->items[list->count++];
    otherwise = otherwise ? otherwise : turns ? upright : zeros;
    *item = (plane_item){.key = key, .geometry = geometry, .is_body = is_body};
    for (int i = 0; i < plane_entries(geometry); i++) {
        item->x[i] = (plane_entry){true, otherwise[i]};
        if (given[i].is_given) {
            item->x[i].is_number = quantity_is_number(given[i], &item->x[i].value);
        }
    }
}

static bool plane_starts_from_given(const scene *rod_scene)
{
    return scene_is_dynamic(rod_scene) && rod_scene->initial.rotation[0].is_given;
}

/* The rotation that the normal is found from: of the unstressed rod, unless that is used nowhere.
 */
static void plane_add_origin(plane_list *list, const scene *rod_scene)
{
    static const char *const keys[2] = {"boundary.start.rotation", "boundary.end.rotation"};
    int anchor = rod_shape_anchor(rod_scene);
    const scene_end *end = anchor ? &rod_scene->end : &rod_scene->start;
    double upright[4];
    rod_shape_upright(rod_scene, upright);
    if (plane_starts_from_given(rod_scene) && rod_scene->initial_enforcement == SCENE_HARD &&
        !scene_end_holds_rotation(end->type)) {
        plane_add(list, "initial.rotation", SCENE_ORIENTATION, false, rod_scene->initial.rotation,
                  NULL);
    } else {
        plane_add(list, keys[anchor], SCENE_ORIENTATION, false, end->rotation, upright);
    }
}

/* Whether the equations know of it: an end has a pose or a load as its type says. */
static bool plane_is_used(const scene *rod_scene, const scene_field *field)
{
    bool turns = field->geometry == SCENE_ORIENTATION;
    const scene_end_type start = rod_scene->start.type, end = rod_scene->end.type;
    const bool given = scene_field_of(rod_scene, field)->is_given;
    switch (field->part) {
    case SCENE_OF_START:
        return turns                                      ? scene_end_holds_rotation(start)
               : field->geometry == SCENE_POSITION_VECTOR ? scene_end_is_placed(start)
                                                          : given; /* how it slides */
    case SCENE_OF_END:
        if (field->geometry == SCENE_POSITION_VECTOR) {
            return scene_end_is_placed(end);
        }
        if (field->geometry == SCENE_POLAR_VECTOR) {
            return given;
        } /* the rotation by its quaternion, or by the vector in its place */
        return scene_end_holds_rotation(end) &&
               (turns ? !rod_scene->end.rotation_vector[0].is_given : given);
    case SCENE_OF_BASE:
        return scene_end_takes_force(start);
    case SCENE_OF_TIP:
        return scene_end_takes_force(end);
    case SCENE_OF_INITIAL:
        return scene_is_dynamic(rod_scene) && given;
    default:
        return given;
    }
}

static bool plane_is_body(const scene *rod_scene, const scene_field *field)
{
    const scene_loads *loads = &rod_scene->loads;
    int index = 0;
    bool of_list = scene_field_list(field, &index) != NULL; /* loads in one: points */
    scene_frame frame = field->part == SCENE_OF_BASE  ? loads->base.frame
                        : field->part == SCENE_OF_TIP ? loads->tip.frame
                        : of_list                     ? rod_scene->points[index].load.frame
                                                      : loads->frame;
    return field->axes == SCENE_BODY || (field->axes == SCENE_BY_LOAD && frame == SCENE_FOLLOWER);
}

/* The rotations, or everything else with a direction. */
static void plane_add_fields(plane_list *list, const scene *rod_scene, bool rotations)
{
    for (int i = 0; i < scene_field_count; i++) {
        const scene_field *field = &scene_fields[i];
        if (field->geometry != SCENE_SCALAR &&
            (field->geometry == SCENE_ORIENTATION) == rotations &&
            plane_is_used(rod_scene, field)) {
            plane_add(list, field->key, field->geometry, plane_is_body(rod_scene, field),
                      scene_field_of(rod_scene, field), NULL);
        }
    }
    if (!rotations && scene_end_holds_rotation(rod_scene->end.type)) {
        const quantity about_d3[3] = {[2] = rod_scene->end.twist};
        plane_add(list, "boundary.end.twist", SCENE_AXIAL_VECTOR, true, about_d3, NULL);
    }
}

/* Everything with a direction that a scene has. A rotation that leaves the plane takes much else
 * along, so that it is named first. */
static void plane_list_of(const scene *rod_scene, plane_list *list)
{
    list->count = 0;
    plane_add_origin(list, rod_scene);
    plane_add_fields(list, rod_scene, true);
    plane_add_fields(list, rod_scene, false);
}

/* ---- whether it stays in a plane ------------------------------------------------------------- */

/* sum of coefficient x [count] = height, with every entry that counts a number. */
static bool plane_sum_is(int count, const double *coefficient, const plane_entry *entry,
                         double height)
{
    double sum = -height, size = fabs(height);
    for (int i = 0; i < count; i++) {
        if (coefficient[i] == 0) {
            continue;
        }
        if (!entry[i].is_number) {
            return false;
        }
        sum += coefficient[i] * entry[i].value;
        size += fabs(coefficient[i] * entry[i].value);
    }
    return fabs(sum) <= PLANE_ROUNDING * size;
}

/* x - n (n . x) = 0 */
static bool plane_is_along(const double *normal, const plane_entry *entry)
{
    bool along = true;
    for (int i = 0; i < 3; i++) {
        double across[3];
        for (int j = 0; j < 3; j++) {
            across[j] = (i == j) - normal[i] * normal[j];
        }
        along = along && plane_sum_is(3, across, entry, 0);
    }
    return along;
}

/* R(q) e_k for all s and t, or false. A formula may turn about director k itself: q = (a, b e_k);
 * or the same after half a turn about an axis across: q has neither of these two entries. */
static bool plane_director(const plane_entry *q, int director, double *axis)
{
    int k = director + 1, other = 3 - k;
    const plane_entry *on[2] = {&q[0], &q[k]}, *off[2] = {&q[other], &q[3]};
    bool numbers = true, none_off = true, none_on = true;
    for (int i = 0; i < 2; i++) {
        numbers = numbers && on[i]->is_number && off[i]->is_number;
        none_off = none_off && off[i]->is_number && off[i]->value == 0;
        none_on = none_on && on[i]->is_number && on[i]->value == 0;
    }
    axis[0] = axis[1] = axis[2] = 0;
    axis[director] = none_off ? 1 : -1;
    if (none_off || none_on || !numbers) {
        return none_off || none_on;
    }
    double w = q[0].value, v[3] = {q[1].value, q[2].value, q[3].value}, square = w * w;
    for (int i = 0; i < 3; i++) {
        square += v[i] * v[i];
    }
    int a = (director + 1) % 3, b = (director + 2) % 3;
    axis[director] = 1 - 2 * (v[a] * v[a] + v[b] * v[b]) / square;
    axis[a] = 2 * (v[a] * v[director] + w * v[b]) / square;
    axis[b] = 2 * (v[b] * v[director] - w * v[a]) / square;
    for (int i = 0; i < 3; i++) {
        double whole = round(axis[i]);
        axis[i] = fabs(axis[i] - whole) < PLANE_ROUNDING ? whole : axis[i];
    }
    return true;
}

/* Whether the normal is an axis of the diagonal tensor: K n - n (n . K n) = 0. */
static bool plane_is_axis(const double *normal, const plane_entry *entry)
{
    bool is_axis = true;
    for (int i = 0; i < 3; i++) {
        double across[3];
        for (int j = 0; j < 3; j++) {
            across[j] = ((i == j) - normal[i] * normal[j]) * normal[j];
        }
        is_axis = is_axis && plane_sum_is(3, across, entry, 0);
    }
    return is_axis;
}

/* The same of the matrix of a gradient, and G r has nothing along n in the plane n . r = height. */
static bool plane_is_axis_of_gradient(const rod_plane *plane, const plane_entry *entry)
{
    static const int at[3][3] = {{0, 2, 3}, {2, 1, 4}, {3, 4, -1}};
    const double *n = plane->normal;
    double by[3][5] = {{0}}, along[5] = {0}; /* G n, n . G n */
    bool is_axis = true;
    for (int i = 0; i < 3; i++) {
        for (int j = 0; j < 3; j++) {
            if (at[i][j] >= 0) {
                by[i][at[i][j]] += n[j];
            } else { /* zz = -xx - yy */
                by[i][0] -= n[j];
                by[i][1] -= n[j];
            }
        }
        for (int k = 0; k < 5; k++) {
            along[k] += n[i] * by[i][k];
        }
    }
    for (int i = 0; i < 3; i++) {
        for (int k = 0; k < 5 && plane->height == 0; k++) {
            by[i][k] -= n[i] * along[k];
        }
        is_axis = is_axis && plane_sum_is(5, by[i], entry, 0);
    }
    return is_axis;
}

static bool plane_item_stays(const plane_item *item, const rod_plane *plane)
{
    const double along[3] = {plane->director == 0, plane->director == 1, 0};
    const double *normal = item->is_body ? along : plane->normal;
    double axis[3], apart = 0;
    switch (item->geometry) {
    case SCENE_ORIENTATION:
        if (!plane_director(item->x, plane->director, axis)) {
            return false;
        }
        for (int i = 0; i < 3; i++) {
            apart = fmax(apart, fabs(axis[i] - normal[i]));
        }
        return apart <= PLANE_ROUNDING;
    case SCENE_POSITION_VECTOR:
        return plane_sum_is(3, normal, item->x, plane->height);
    case SCENE_POLAR_VECTOR:
        return plane_sum_is(3, normal, item->x, 0);
    case SCENE_SECTION_POINT:
        return item->x[plane->director].is_number && item->x[plane->director].value == 0;
    case SCENE_TENSOR:
        return plane_is_axis(plane->normal, item->x);
    case SCENE_GRADIENT:
        return plane_is_axis_of_gradient(plane, item->x);
    case SCENE_AXIAL_VECTOR:
    case SCENE_SCALAR:
        break;
    }
    return plane_is_along(normal, item->x);
}

/* Along the normal, of the first position that is given; 0 without one or for a formula. */
static double plane_height(const plane_list *list, const double *normal)
{
    for (int i = 0; i < list->count; i++) {
        const plane_item *item = &list->items[i];
        double height = 0;
        if (item->geometry != SCENE_POSITION_VECTOR) {
            continue;
        }
        for (int j = 0; j < 3; j++) {
            height += normal[j] != 0 && item->x[j].is_number ? normal[j] * item->x[j].value : 0;
        }
        return height;
    }
    return 0;
}

/* Axes of the plane's frame as columns: the normal is axis `director`, axis 2 a world axis where
 * that is possible, so that the frame is the world with axes renamed. */
static void plane_axes(rod_plane *plane)
{
    const double *n = plane->normal;
    int k = plane->director, third = fabs(n[2]) <= 0.5 ? 2 : fabs(n[0]) <= 0.5 ? 0 : 1;
    double t[3], size = 0, side[3];
    for (int i = 0; i < 3; i++) {
        t[i] = (i == third) - n[third] * n[i];
        size += t[i] * t[i];
    }
    for (int i = 0; i < 3; i++) {
        t[i] /= sqrt(size);
    }
    for (int i = 0; i < 3; i++) {
        int a = (i + 1) % 3, b = (i + 2) % 3;
        side[i] = k == 1 ? n[a] * t[b] - n[b] * t[a] : t[a] * n[b] - t[b] * n[a];
    }
    for (int i = 0; i < 3; i++) {
        plane->axes[i][k] = n[i];
        plane->axes[i][2] = t[i];
        plane->axes[i][1 - k] = side[i];
    }
}

/* How many items leave the plane across `director`; plane->leaves: the first of them. */
static int plane_try(const plane_list *list, int director, rod_plane *plane)
{
    *plane = (rod_plane){.director = director};
    if (!plane_director(list->items[0].x, director, plane->normal)) {
        plane->leaves = list->items[0].key;
        return list->count;
    }
    plane->height = plane_height(list, plane->normal);
    int count = 0;
    for (int i = 0; i < list->count; i++) {
        if (!plane_item_stays(&list->items[i], plane)) {
            plane->leaves = count == 0 ? list->items[i].key : plane->leaves;
            count++;
        }
    }
    return count;
}

rod_plane rod_plane_of(const scene *rod_scene)
{
    if (rod_scene->motion == SCENE_SPATIAL) {
        return (rod_plane){.leaves = "motion"};
    }
    if (scene_is_manufactured(rod_scene)) {
        return (rod_plane){.leaves = "manufactured"};
    }
    if (rod_scene->tube_count > 0) { /* they twist */
        return (rod_plane){.leaves = "tubes"};
    }
    const scene_law *law = rod_scene->rod.law;
    if (law && law->symmetry < SCENE_SYMMETRY_MIRRORS) {
        return (rod_plane){.leaves = "rod.law"};
    }
    plane_list list;
    plane_list_of(rod_scene, &list);
    rod_plane first, second;
    int leave_first = plane_try(&list, 1, &first), leave_second = plane_try(&list, 0, &second);
    rod_plane plane = leave_second < leave_first ? second : first;
    plane.is_planar = !plane.leaves;
    if (plane.is_planar) {
        plane_axes(&plane);
    }
    return plane;
}

bool rod_has_energy(const scene *rod_scene, bool planar)
{
    const scene_loads *loads = &rod_scene->loads;
    for (int i = 0; i < rod_scene->point_count; i++) {
        const scene_load *load = &rod_scene->points[i].load;
        if (load->frame == SCENE_FOLLOWER || (!planar && load->moment[0].is_given)) {
            return false;
        }
    }
    bool moments = loads->moment[0].is_given || loads->tip.moment[0].is_given ||
                   loads->base.moment[0].is_given;
    bool followers = loads->frame == SCENE_FOLLOWER || loads->tip.frame == SCENE_FOLLOWER ||
                     loads->base.frame == SCENE_FOLLOWER;
    return !scene_is_dynamic(rod_scene) && !scene_is_manufactured(rod_scene) && !followers &&
           (planar || !moments) && !scene_has_displaced_tendons(rod_scene) &&
           !scene_has_rubbing_tendons(rod_scene);
}
