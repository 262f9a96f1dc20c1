/* For tests of the rod: scenes from numbers, and residuals at points. */
#ifndef TESTS_ROD_TESTING_H
#define TESTS_ROD_TESTING_H

#include "evaluate.h"

#include "physics/rod/rod.h"
#include "quantity_testing.h"

#define PI 3.14159265358979323846

enum { POINTS = 6 };

/* Dimensionless points; sets[0] s, sets[1] t. */
static const double unit_s[POINTS] = {0.03, 0.21, 0.4, 0.55, 0.83, 0.98};

typedef struct recorded {
    ad_tape *tape;
    ad_value s, t; /* dimensionless; t is the constant 0 in a static scene */
    domain_place at;
} recorded;

static inline recorded begin(const scene *given)
{
    recorded r = {.tape = ad_tape_create()};
    r.s = ad_input(r.tape, "s", 1);
    r.t = scene_is_dynamic(given) ? ad_input(r.tape, "t", 1) : ad_scalar(r.tape, 0);
    r.at = rod_place(given, r.s, r.t);
    return r;
}

/* Points in t spread over the duration, in units of the scene's time. */
static inline void points_of_time(const scene *given, double *t)
{
    double end = rod_numbers_of(given).duration;
    for (int i = 0; i < POINTS; i++)
        t[i] = end * fmod(0.07 + 0.37 * i, 1.0);
}

static inline double largest(ad_value value, const double *s, const double *t)
{
    double *numbers = evaluate_at(value, POINTS, s, t, NULL), result = 0;
    for (int i = 0; i < ad_rows(value) * POINTS; i++)
        result = !(fabs(numbers[i]) <= result) ? fabs(numbers[i]) : result;
    free(numbers);
    return result;
}

/* In space: the tests write their states in the world frame. */
static inline scene stiff_scene(double length, const double *kse, const double *kbt, double mass,
                                const double *inertia)
{
    scene made;
    scene_defaults(&made);
    made.motion = SCENE_SPATIAL;
    made.rod.length = Q(length);
    for (int i = 0; i < 2; i++) {
        made.rod.shear_stiffness[i] = Q(kse[i]);
        made.rod.bending_stiffness[i] = Q(kbt[i]);
    }
    made.rod.axial_stiffness = Q(kse[2]);
    made.rod.torsional_stiffness = Q(kbt[2]);
    made.rod.mass_per_length = Q(mass);
    for (int i = 0; i < 3; i++)
        made.rod.rotary_inertia[i] = Q(inertia[i]);
    return made;
}

/* Every interior residual of the state, in either form, is below the tolerance. */
static inline void check_interior(const scene *given, const recorded *r, rod_state exact,
                                  double tolerance)
{
    double t[POINTS];
    points_of_time(given, t);
    for (int kind = ROD_STRAIN; kind <= ROD_MOMENT; kind++) {
        if (rod_residual_rows(given, (rod_residual_kind)kind) == 0)
            continue;
        ad_value residual = rod_residual(given, (rod_residual_kind)kind, exact, &r->at);
        double worst = largest(residual, unit_s, t);
        if (!(worst < tolerance))
            fail_msg("%s: %g", rod_residual_name((rod_residual_kind)kind), worst);
    }
}

#endif
