/* For tests of tendons and chambers: robots from numbers, solved classically. */
#ifndef TESTS_TENDON_TESTING_H
#define TESTS_TENDON_TESTING_H

#include "near.h"
#include "rod_testing.h"

#include "physics/solve/solve.h"

typedef struct solved {
    solution *solution;
    solve_report report;
} solved;

static inline solved solve(const scene *given, size_t count, const double *times, double tolerance)
{
    ad_error error = {.message = ""};
    const char *key = "";
    solve_settings settings = {.tolerance = tolerance};
    solved x;
    if (scene_check(given, &key, &error) != AD_OK || rod_check(given, &key, &error) != AD_OK ||
        solution_create(given, &settings, count, times, &x.solution, &x.report, &error) != AD_OK) {
        fail_msg("%s: %s", key, error.message);
    }
    assert_near(x.report.load_fraction, 1, 0);
    return x;
}

/* r and q at s, t. */
static inline void pose_at(const solved *x, double s, double t, double pose[7])
{
    ad_error error;
    assert_int_equal(solution_evaluate(x->solution, 7, 1, &s, &t, pose, &error), AD_OK);
}

static inline scene robot(double length, double modulus, double shear_modulus, double radius)
{
    scene made;
    scene_defaults(&made);
    made.motion = SCENE_SPATIAL;
    made.rod.length = Q(length);
    made.rod.section = SCENE_CIRCLE;
    made.rod.radius = Q(radius);
    made.rod.youngs_modulus = Q(modulus);
    made.rod.poissons_ratio = Q(modulus / (2 * shear_modulus) - 1);
    made.rod.shear_correction = Q(1.0);
    return made;
}

static inline void add_tendon(scene *given, double distance, double degrees, double tension)
{
    double angle = degrees * PI / 180;
    given->tendons[given->tendon_count++] = (scene_tendon){
        .offset = {Q(distance * cos(angle)), Q(distance * sin(angle))}, .tension = Q(tension)};
}

#endif
