/* What is seen of a reduced rod: where places of it are and how they move, of many states at once,
 * with derivatives by the state. Needs no library and allocates nothing, so that exported C has
 * this very text; physics/chain/modes.h says what modes are, reduced.h what the state is.
 *
 * Rotations are Magnus' expansion of order 6 from point to point, all else integrals by Gauss'
 * points; derivatives are exact ones of that but for the turn between points (order 6). SI units.
 */
#ifndef PHYSICS_CHAIN_KINEMATICS_H
#define PHYSICS_CHAIN_KINEMATICS_H

#include <stddef.h>

#ifdef __cplusplus
extern "C" {
#endif

enum {
    KINEMATICS_STAGES_MAX = 12,
    KINEMATICS_STRAINS = 6, /* v and then u */
    KINEMATICS_START = 13,  /* position, rotation, velocity; angular velocity, body */
    KINEMATICS_SEEN = 19,   /* position, rotation (w, x, y, z), velocity, world; angular velocity,
                             * strain v, curvature u, body */
    KINEMATICS_ROWS = 18    /* of derivatives: the same with the turn, a rotation vector in the
                             * world, in place of the rotation */
};

/* Constants of a rod, by X(name, count), so that they can be made and written one by one. Elements
 * have `stages` points each; a step goes from the element's start or a point to the next point or
 * to the element's end, and one more to each place. */
#define KINEMATICS_INTEGERS(X)                                                                     \
    X(strain, modes) /* which of the strains a mode is of */                                       \
    X(own, elements) /* modes own .. own_end - 1 are those of an element */                        \
    X(own_end, elements)                                                                           \
    X(place_element, places)                                                                       \
    X(place_before, places) /* the point before a place; -1: none in its element */                \
    X(row, rows)            /* of derivatives that are wanted, ascending: place *                  \
                             * KINEMATICS_ROWS + row */
#define KINEMATICS_NUMBERS(X)                                                                      \
    X(start, KINEMATICS_START)                                                                     \
    X(joint, (elements * 4))                            /* rotation behind an element */           \
    X(origin, (elements * stages * KINEMATICS_STRAINS)) /* strains of modes that are all 0 */      \
    X(value, (elements * stages * modes))               /* of each mode */                         \
    X(integral, (elements * (stages + 1) * stages))     /* from an element's start to its points   \
                                                         * and its end */                          \
    X(step, (elements * (stages + 1) * 9))              /* terms of Magnus' expansion [3][3] */    \
    X(step_by, (elements * (stages + 1) * modes * 3))   /* by each mode [modes][terms] */          \
    X(place_step, (places * 9))                                                                    \
    X(place_step_by, (places * modes * 3))                                                         \
    X(place_integral, (places * stages))                                                           \
    X(place_origin, (places * KINEMATICS_STRAINS))                                                 \
    X(place_value, (places * modes))

typedef struct kinematics {
    int modes, elements, stages, places, rows;
#define KINEMATICS_ARRAY(name, count) const int *name;
    KINEMATICS_INTEGERS(KINEMATICS_ARRAY)
#undef KINEMATICS_ARRAY
#define KINEMATICS_ARRAY(name, count) const double *name;
    KINEMATICS_NUMBERS(KINEMATICS_ARRAY)
#undef KINEMATICS_ARRAY
} kinematics;

/* Numbers of `room` that kinematics_see works in; no more than one call at a time may use it. */
size_t kinematics_room(const kinematics *kinematics);

/* states [count][2 modes], modes and their rates; seen [count][places][KINEMATICS_SEEN]; by_state
 * [count][rows][2 modes] or NULL. Not a number in a state makes what depends on it no number. */
void kinematics_see(const kinematics *kinematics, int count, const double *states, double *seen,
                    double *by_state, double *room);

#ifdef __cplusplus
}
#endif

#endif
