#include "physics/scene/view.h"

#include "physics/numerics/quaternion.h"

#include <math.h>
#include <string.h>

/* A view holds nothing but quantities. */
enum { QUANTITIES = sizeof(scene_view) / sizeof(quantity) };

static const quantity *all_of(const scene_view *view)
{
    return (const quantity *)(const void *)view;
}

bool scene_view_is_given(const scene_view *view)
{
    return quantity_any_given(QUANTITIES, all_of(view));
}

bool scene_view_depends_on(const scene_view *view, const char *name)
{
    return quantity_any_depends_on(QUANTITIES, all_of(view), name);
}

void scene_seen_prepare(const scene_view *view, const scene *open, scene_seen *result)
{
    *result = (scene_seen){.of = view, .open = open};
    result->sees_marker = quantity_any_something(3, view->marker);
    result->sees_frame = quantity_any_something(3, view->position) ||
                         quantity_any_given(4, view->rotation) ||
                         quantity_any_something(3, view->rotation_vector);
    result->moves = result->sees_marker || result->sees_frame;
    for (int i = 0; i < open->parameter_count; i++) {
        const char *name = open->parameters[i].name;
        if (scene_view_depends_on(view, name)) {
            result->index[result->count] = i;
            result->names[result->count++] = name;
        }
    }
}

typedef struct place {
    double s, t, values[SCENE_PARAMETERS_MAX];
} place;

static place at(const scene_seen *view, double s, double t, const double *parameters)
{
    place made = {.s = scene_place_at(view->open, parameters, s, t), .t = t};
    for (int i = 0; i < view->count; i++) {
        made.values[i] = parameters[view->index[i]];
    }
    return made;
}

/* 0 where it is not given. */
static double value(const scene_seen *view, const place *p, quantity q)
{
    return !q.is_given ? 0
           : q.node    ? quantity_value_with(q, p->s, p->t, view->count, view->names, p->values)
                       : q.number;
}

double scene_seen_time(const scene_seen *view, double s, double t, const double *parameters)
{
    const place p = at(view, s, t, parameters);
    return t - value(view, &p, view->of->delay);
}

/* The rotation of what measures. */
static void rotation_of(const scene_seen *view, const place *p, double q[4])
{
    double vector[3];
    for (int i = 0; i < 4; i++) {
        q[i] = value(view, p, view->of->rotation[i]);
    }
    if (quantity_any_given(4, view->of->rotation)) {
        quaternion_normalize(q);
        return;
    }
    for (int i = 0; i < 3; i++) {
        vector[i] = value(view, p, view->of->rotation_vector[i]);
    }
    const double angle = sqrt(vector_dot(vector, vector));
    const double factor = angle > 0 ? sin(angle / 2) / angle : 0.5;
    q[0] = cos(angle / 2);
    for (int i = 0; i < 3; i++) {
        q[i + 1] = factor * vector[i];
    }
}

/* Where the marker is, m, along the directors. */
static void marker_of(const scene_seen *view, const place *p, double offset[3])
{
    for (int i = 0; i < 3; i++) {
        offset[i] = value(view, p, view->of->marker[i]);
    }
}

void scene_seen_marker(const scene_seen *view, double s, double t, const double *parameters,
                       double offset[3])
{
    const place p = at(view, s, t, parameters);
    marker_of(view, &p, offset);
}

void scene_seen_place(const scene_seen *view, double s, double t, const double *parameters,
                      double r[3])
{
    const place p = at(view, s, t, parameters);
    double R[3][3], turn[4], from[3];
    if (view->sees_frame) {
        rotation_of(view, &p, turn);
        rotation_matrix(turn, R);
        memcpy(from, r, sizeof from);
        to_world(R, from, r);
        for (int i = 0; i < 3; i++) {
            r[i] += value(view, &p, view->of->position[i]);
        }
    }
}

void scene_seen_take(const scene_seen *view, double s, double t, const double *parameters,
                     double r[3], double q[4])
{
    const place p = at(view, s, t, parameters);
    double R[3][3];
    if (view->sees_marker) {
        double offset[3];
        double beside[3];
        marker_of(view, &p, offset);
        rotation_matrix(q, R);
        to_world(R, offset, beside);
        for (int i = 0; i < 3; i++) {
            r[i] += beside[i];
        }
    }
    if (view->sees_frame) {
        double turn[4], from[3], before[4];
        rotation_of(view, &p, turn);
        rotation_matrix(turn, R);
        for (int i = 0; i < 3; i++) {
            from[i] = r[i] - value(view, &p, view->of->position[i]);
        }
        to_body(R, from, r);
        memcpy(before, q, sizeof before);
        quaternion_quotient(turn, before, q);
    }
}
