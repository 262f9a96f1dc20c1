/* Reduced rods for tests. */
#ifndef MODES_TESTING_H
#define MODES_TESTING_H

#include "motion_testing.h"

#include "physics/solve/modes_internal.h"

/* All that a rod can have: segments with a joint, tendon, chamber, bodies, springs, a foundation,
 * drag of both kinds, loads dead and following, damping, a driven start. */
static const char everything[] =
    "parameters: {p: {range: [100, 300]}, e: {range: [0.5, 2]}}\n"
    "rod:\n"
    "  length: 1\n"
    "  stiffness: {shear: [30*e, 40*e], axial: 50*e, bending: [e, 1.5*e], torsion: 0.8*e}\n"
    "  inertia: {mass_per_length: 1, rotary: [0.01, 0.02, 0.03]}\n"
    "  rest: {curvature: [0.2, 0, 0.1*s]}\n"
    "  damping: {strain: [0.1, 0.1, 0.1], curvature: [0.05, 0.05, 0.05]}\n"
    "segments: [{length: 0.6}, {length: 0.4, turn: [0.3, 0.4, 0]}]\n"
    "boundary:\n"
    "  start: {type: driven, position: [0.1*sin(2*t)^2, 0, 0.05*t^2],\n"
    "          rotation: [cos(t^2), 0.6*sin(t^2), 0, 0.8*sin(t^2)]}\n"
    "  end: {type: loaded}\n"
    "tendons: [{offset: [0.03*(1+s), 0.02], end: 0.6, tension: 2*(p/200)}]\n"
    "chambers: [{offset: [-0.02, 0.03], pressure: 10*p, area: 1.0e-3}]\n"
    "bodies: [{at: 1, mass: 0.2, inertia: [0.01, 0.02, 0.03]}, {at: 0.6, mass: 0.1}]\n"
    "springs: [{at: 1, stiffness: [3, 1, 2], turning: [0.2, 0.2, 0.2]}]\n"
    "loads:\n"
    "  gravity: [1, -2, -3]\n"
    "  drag: 0.3\n"
    "  quadratic_drag: 0.2\n"
    "  foundation: [1, 2, 3]\n"
    "  frame: follower\n"
    "  force: [0.3, 0.2*s, 0.1*p/200]\n"
    "  moment: [0.02, 0.03, 0.01]\n"
    "  tip: {force: [0.2*cos(t), 0.1, 0.3], moment: [0.1, 0, 0.05], frame: follower}\n"
    "time: {duration: 1}\n";

typedef struct reduced_test {
    config *settings;
    solve_rod *rod;
    modes *m;
} reduced_test;

static inline reduced_test make(const char *path, const char *text, modes_counts counts, int finer)
{
    ad_error error = {.message = ""};
    reduced_test x = {0};
    if (config_read_member(path, text, 0, NULL, text == everything ? "p=170,e=1.3" : NULL,
                           &x.settings, &error) != AD_OK ||
        solve_rod_create(&x.settings->scene, &x.rod, &error) != AD_OK ||
        modes_create(x.rod, NULL, &counts, finer, &x.m, &error) != AD_OK) {
        fail_msg("%s", error.message);
    }
    return x;
}

static inline void discard(reduced_test *x)
{
    modes_free(x->m);
    solve_rod_free(x->rod);
    config_free(x->settings);
}

static inline double noise(unsigned *state)
{
    *state = *state * 1664525u + 1013904223u;
    return (double)*state / 4294967296.0 - 0.5;
}

#endif
