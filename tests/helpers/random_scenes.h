/* For tests: random scenes at rest with bands, jumps, narrow bumps and tables along the rod,
 * segments and elbows, loads, bodies and springs at single places, tendons, chambers and held ends;
 * and their solutions by shooting, which shares nothing with the solver: not its equations, nor its
 * formulas, nor where it believes that these jump. */
#ifndef TESTS_RANDOM_SCENES_H
#define TESTS_RANDOM_SCENES_H

#include "physics/scene/scene.h"

#include <stdint.h>
#include <stdio.h>

/* ---- profiles (random_profiles.c) ------------------------------------------------------------ */

/* What one quantity is along the rod: a sum of parts. */
typedef enum profile_kind {
    PROFILE_CONSTANT, /* everywhere */
    PROFILE_BAND,     /* from `at` to `at + width` */
    PROFILE_STEP,     /* from `at` on */
    PROFILE_BUMP,     /* exp(-((s - at)/width)^2) */
    PROFILE_ELBOW,    /* 1 - tanh((s - at)/width)^2 */
    PROFILE_TENT,     /* 1 - |s - at|/width, where that is positive */
    PROFILE_TABLE,    /* a table from s = 0 to the width, the rod's length */
    PROFILE_KINDS
} profile_kind;

enum { PROFILE_PARTS_MAX = 4, PROFILE_ROWS = 5, RANDOM_EDGES_MAX = 512 };

typedef struct profile_part {
    profile_kind kind;
    double at, width, value;
    int spelling;               /* of the several ways to write it as a formula */
    double rows[PROFILE_ROWS];  /* of a table, by `value` */
    double knots[PROFILE_ROWS]; /* their s */
} profile_part;

typedef struct profile {
    int count;
    profile_part parts[PROFILE_PARTS_MAX];
} profile;

/* At s, on the side of a jump on which `inside` is. */
double profile_value(const profile *p, double s, double inside);

/* A formula of one part, or of all of them; where there are none nothing is given. Tables are
 * defined among the names. */
void profile_write(const profile_part *part, const char *table, FILE *to);
quantity profile_quantity(const profile *p, quantities *names);

/* ---- scenes ---------------------------------------------------------------------------------- */

enum { RANDOM_PIECES_MAX = 3, RANDOM_LOADS_MAX = 8, RANDOM_SPRINGS_MAX = 2, RANDOM_PULLS_MAX = 3 };

/* A segment, or all of the rod; in SI units, as everything here. Of a beam bending[0] alone. */
typedef struct random_piece {
    double to;
    double turn[3]; /* against the piece before, a rotation vector */
    profile bending[2], torsion, curvature[3];
} random_piece;

/* Where N and m fall by a force and a moment. Of a beam the first of both. */
typedef struct random_load {
    enum { RANDOM_POINT, RANDOM_BODY, RANDOM_BASE, RANDOM_TIP } kind;
    double at, mass, force[3], moment[3];
    bool follows;
} random_load;

/* Of a beam stiffness[1] against w, turning[0] against psi. */
typedef struct random_spring {
    double at, stiffness[3], turning[3];
    bool is_anchored; /* else it pulls to where the unstressed rod is: */
    double anchor[3], upright[4];
} random_spring;

/* A tendon or a chamber at radius (cos, sin)(winding s + phase); pulls tension, or -pressure times
 * area (1 + taper s/length). */
typedef struct random_pull {
    bool is_chamber;
    double from, to, radius, winding, phase, tension, area, taper;
} random_pull;

typedef struct random_end {
    bool holds_position, holds_rotation;
    double position[3], rotation[4];
} random_end;

/* The stiffness of a strain that is locked is infinite. Of a beam what belongs to it: force[0],
 * moment[0], shear[0], foundation. */
typedef struct random_scene {
    scene scene;
    quantities *names;
    bool is_beam, is_planar, follows; /* distributed force and moment follow */
    double length, stiffness;         /* EI, what others are measured by */
    profile force[3], moment[3], stretch, foundation;
    double shear[2], axial;
    double gravity[3], mass; /* per length */
    random_end ends[2];
    int piece_count, load_count, spring_count, pull_count;
    random_piece pieces[RANDOM_PIECES_MAX];
    random_load loads[RANDOM_LOADS_MAX];
    random_spring springs[RANDOM_SPRINGS_MAX];
    random_pull pulls[RANDOM_PULLS_MAX];
    int edge_count; /* ascending: where anything jumps, acts, or is narrow; 0 and length */
    double edges[RANDOM_EDGES_MAX];
} random_scene;

/* The scene of a seed; released by random_scene_free. */
random_scene *random_scene_create(uint64_t seed, bool is_beam);
void random_scene_free(random_scene *x);

/* Fills in `scene` from all the rest (random_scenes_fill.c). */
void random_scene_fill(random_scene *x);

/* What it is, in words: model and parts. */
void random_scene_describe(const random_scene *x, FILE *to);

/* ---- solutions (random_scenes_shoot.c) ------------------------------------------------------- */

/* y of a rod: r, q, N in the world, m in the body; of a beam: w, psi, V, M. */
enum { RANDOM_ROWS = 13 };

/* y from s = 0, beyond what acts there, to another s, before what acts there; `bare`: of the
 * unstressed rod. */
void random_scene_carry(const random_scene *x, bool bare, double to, double *y);

/* By shooting from s = 0 with y there as a guess for what its end leaves open: position [count][3]
 * at s [count], ascending, of a beam its deflection in the first. False: it did not converge. */
bool random_scene_shoot(const random_scene *x, const double *guess, int count, const double *s,
                        double (*position)[3]);

#endif
