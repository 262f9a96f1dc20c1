/* For tests: random scenes at rest with bands, steps, jumps and narrow bumps along the rod, and
 * their solutions by shooting, which shares nothing with the solver: not its equations, nor its
 * formulas, nor where it believes that these jump. */
#ifndef TESTS_RANDOM_SCENES_H
#define TESTS_RANDOM_SCENES_H

#include "physics/scene.h"

#include <stdint.h>

/* What one quantity is along the rod: a sum of parts. */
typedef enum profile_kind {
    PROFILE_CONSTANT, /* everywhere */
    PROFILE_BAND,     /* from `at` to `at + width` */
    PROFILE_STEP,     /* from `at` on */
    PROFILE_BUMP,     /* exp(-((s - at)/width)^2) */
    PROFILE_ELBOW,    /* 1 - tanh((s - at)/width)^2 */
    PROFILE_TENT,     /* 1 - |s - at|/width, where that is positive */
    PROFILE_KINDS
} profile_kind;

typedef struct profile_part {
    profile_kind kind;
    double at, width, value;
    int spelling; /* of the several ways to write it as a formula */
} profile_part;

enum { PROFILE_PARTS_MAX = 4, RANDOM_EDGES_MAX = 256 };

typedef struct profile {
    int count;
    profile_part parts[PROFILE_PARTS_MAX];
} profile;

/* At s, on the side of a jump on which `inside` is. */
double profile_value(const profile *p, double s, double inside);

/* In SI units; the stiffness of a strain that is locked is infinite. Of a beam what belongs to it:
 * force[0], moment[0], bending[0], shear[0], foundation, tip_force[0]. */
typedef struct random_scene {
    scene scene;
    quantities *names;
    double length;
    profile force[3], moment[3], curvature[3], bending[2], torsion;
    double shear[2], axial;
    profile foundation;
    double rotation[4], tip_force[3];
    bool follower_line, follower_tip; /* of rods */
    int edge_count;
    double
        edges[RANDOM_EDGES_MAX]; /* ascending: where anything jumps, or is narrow; 0 and length */
} random_scene;

/* The scene of a seed; released by random_scene_free. */
random_scene *random_scene_create(uint64_t seed, bool is_beam);
void random_scene_free(random_scene *x);

/* What it is, in words: model and parts. */
void random_scene_describe(const random_scene *x, char *text, size_t size);

/* By shooting from s = 0 with the internal force and moment there as a guess, of a rod N (world)
 * and m (body), 6 numbers, of a beam V and M: position [count][3] at s [count], ascending, of a
 * beam its deflection in the first. False: it did not converge. */
bool random_scene_shoot(const random_scene *x, const double *guess, int count, const double *s,
                        double (*position)[3]);

#endif
