/* For tests of what acts at single places of a rod: scenes in C, solved classically. */
#ifndef TESTS_JUMP_TESTING_H
#define TESTS_JUMP_TESTING_H

#include "rod_testing.h"

#include "physics/solve/solve.h"

#include <string.h>

/* The columns of a rod, see physics/learn/model.h. */
typedef struct rod_values {
    double r[3], q[4], v[3], u[3], n[3], m[3], V[3], w[3];
} rod_values;

/* Clamped upright at the origin. */
static inline scene slender_scene(double length, double bending, double torsion)
{
    const double free_strain[3] = {1, 1, 1}, stiffness[3] = {bending, bending, torsion};
    scene made = stiff_scene(length, free_strain, stiffness, 1, free_strain);
    made.rod.model = SCENE_KIRCHHOFF;
    for (int i = 0; i < 2; i++) {
        made.rod.shear_stiffness[i] = Q(NULL);
    }
    made.rod.axial_stiffness = Q(NULL);
    set_numbers(made.start.position, 3, (double[]){0, 0, 0});
    set_numbers(made.start.rotation, 4, (double[]){1, 0, 0, 0});
    made.duration = Q(NULL);
    return made;
}

static inline scene_point *add_point(scene *to, double at, scene_frame frame, const double *force,
                                     const double *moment)
{
    scene_point *point = &to->points[to->point_count++];
    *point = (scene_point){.at = Q(at), .load.frame = frame};
    if (force) {
        set_numbers(point->load.force, 3, force);
    }
    if (moment) {
        set_numbers(point->load.moment, 3, moment);
    }
    return point;
}

static inline scene_spring *add_spring(scene *to, double at, const double *stiffness,
                                       const double *turning)
{
    scene_spring *spring = &to->springs[to->spring_count++];
    *spring = (scene_spring){.at = Q(at)};
    if (stiffness) {
        set_numbers(spring->stiffness, 3, stiffness);
    }
    if (turning) {
        set_numbers(spring->turning, 3, turning);
    }
    return spring;
}

static inline void add_body(scene *to, double at, double mass, const double *inertia)
{
    scene_body *body = &to->bodies[to->body_count++];
    *body = (scene_body){.at = Q(at), .mass = Q(mass)};
    if (inertia) {
        set_numbers(body->inertia, 3, inertia);
    }
}

static inline void add_segment(scene *to, double length, const double *turn)
{
    scene_segment *segment = &to->segments[to->segment_count++];
    *segment = (scene_segment){.length = Q(length)};
    if (turn) {
        set_numbers(segment->turn, 3, turn);
    }
}

static inline void load_tip(scene *to, const double *force, const double *moment)
{
    to->end.type = SCENE_LOADED;
    set_numbers(to->loads.tip.force, 3, force ? force : (double[]){0, 0, 0});
    set_numbers(to->loads.tip.moment, 3, moment ? moment : (double[]){0, 0, 0});
}

typedef struct solved {
    solution *solution;
    solve_report report;
} solved;

static inline solved solve_at(const scene *given, double tolerance, size_t count,
                              const double *times)
{
    ad_error error = {.message = ""};
    const solve_settings settings = {.tolerance = tolerance};
    solved x;
    if (solution_create(given, &settings, count, times, &x.solution, &x.report, &error) != AD_OK) {
        fail_msg("%s", error.message);
    }
    return x;
}

/* At rest, to the whole load and the tolerance. */
static inline solved solve_rest_of(const scene *given)
{
    const double tolerance = 1e-11;
    solved x = solve_at(given, tolerance, 0, NULL);
    assert_near(x.report.load_fraction, 1, 0);
    assert_true(x.report.estimate <= 1e-10); /* or as far as rounding allows */
    return x;
}

static inline rod_values values_at(const solved *x, double s, double t)
{
    rod_values values;
    int columns = sizeof values / sizeof(double);
    assert_int_equal(solution_evaluate(x->solution, columns, 1, &s, &t, (double *)&values, NULL),
                     AD_OK);
    return values;
}

static inline void assert_vector(const double *value, const double *expected, double tolerance)
{
    for (int i = 0; i < 3; i++) {
        assert_near(value[i], expected[i], tolerance);
    }
}

#endif
