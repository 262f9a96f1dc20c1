/* Laws of motion (physics/law/law.h) of what moves with the rod at a point, seen in the world. */
#ifndef PHYSICS_LOCAL_INERTIA_H
#define PHYSICS_LOCAL_INERTIA_H

#include "physics/law/law.h"
#include "physics/law/law_numbers.h"
#include "physics/numerics/processor.h"
#include "physics/numerics/quaternion.h"

#include <stdbool.h>
#include <string.h>

/* What moves: mass and rotary inertia of the section, the fluid's added mass across d3, and of
 * bodies beside the axis the numbers of LAW_ECCENTRICITY. */
typedef struct inertia {
    double mass, rotary[3], added, eccentric[6];
    bool is_beside; /* false: eccentric is 0 */
} inertia;

/* Whether its force is more than -mass acceleration. */
static inline bool inertia_couples(const inertia *what)
{
    return what->added != 0 || what->is_beside;
}

static inline bool inertia_turns(const inertia *what)
{
    return what->rotary[0] != 0 || what->rotary[1] != 0 || what->rotary[2] != 0;
}

static inline bool inertia_any(const inertia *what)
{
    return what->mass != 0 || inertia_turns(what) || what->added != 0;
}

/* The section, R from body to world, and its motion in the world, [3] each; NULL: 0. */
typedef struct inertia_motion {
    const double (*R)[3];
    const double *velocity, *spin, *acceleration, *spin_rate;
} inertia_motion;

/* Force and moment [6] in the world by which it resists. */
void inertia_wrench_coupled(const inertia *what, inertia_motion at, double wrench[6]);

/* The same, sooner where nothing couples. */
static inline void inertia_wrench(const inertia *what, inertia_motion at, double wrench[6])
{
    static const double none[3] = {0};
    double R[3][3], spin[3], spin_rate[3], body[6] = {0};
    if (inertia_couples(what)) {
        inertia_wrench_coupled(what, at, wrench);
        return;
    }
    memcpy(R, at.R, sizeof R);
    to_body(R, at.spin, spin);
    to_body(R, at.spin_rate, spin_rate);
    number_law_rotary_inertia_wrench(none, spin, none, spin_rate, what->rotary, body);
    to_world(R, body + 3, wrench + 3);
    for (int k = 0; k < 3; k++) {
        wrench[k] = -what->mass * at.acceleration[k];
    }
}

/* Its kinetic energy; acceleration and spin_rate are not looked at. */
double inertia_energy(const inertia *what, inertia_motion at);

/* What the moment changes by with a turn of the section, with spin and spin_rate; and where it
 * couples the force, too, and both with velocity and acceleration: else these are not set. The
 * force of the mass is not among them: it is -mass acceleration. */
typedef struct inertia_change {
    double by_turn[6][3], by_velocity[6][3], by_spin[6][3], by_acceleration[6][3],
        by_spin_rate[6][3];
} inertia_change;

void inertia_differentiate(const inertia *what, inertia_motion at, inertia_change *by);

/* R block R^T, three rows. */
PROCESSOR_INLINE void inertia_turn_block(const double (*R)[3], const double *block, double (*to)[3])
{
    for (int i = 0; i < 3; i++) {
        double row[3] = {0};
        for (int k = 0; k < 3; k++) {
            for (int j = 0; j < 3; j++) {
                row[j] += R[i][k] * block[3 * k + j];
            }
        }
        for (int j = 0; j < 3; j++) {
            to[i][j] = row[0] * R[j][0] + row[1] * R[j][1] + row[2] * R[j][2];
        }
    }
}

/* In the world: with a the acceleration and b the spin_rate, the force is -mass a - coupling b, the
 * moment -coupling^T a - rotary b, less what is there without them. */
typedef struct inertia_matrix {
    double mass[3][3], rotary[3][3], coupling[3][3];
} inertia_matrix;

inertia_matrix inertia_matrix_coupled(const inertia *what, const double (*R)[3]);

/* The same, sooner where nothing couples: the mass is then a number times 1, the coupling 0. */
PROCESSOR_INLINE inertia_matrix inertia_matrix_of(const inertia *what, const double (*R)[3])
{
    static const double still[3] = {0};
    inertia_matrix to = {.mass = {{0}}};
    double unused[6] = {0}, by[LAW_BY_MOTION] = {0};
    if (inertia_couples(what)) {
        return inertia_matrix_coupled(what, R);
    }
    number_law_rotary_inertia(still, still, still, still, what->rotary, unused, by);
    inertia_turn_block(R, by + 18 * 3 + 9, to.rotary);
    for (int i = 0; i < 3; i++) {
        for (int k = 0; k < 3; k++) {
            to.rotary[i][k] *= -1;
        }
        to.mass[i][i] = what->mass;
    }
    return to;
}

#endif
