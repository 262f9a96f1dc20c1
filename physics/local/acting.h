/* What acts from outside on a rod in numbers, per length or at a place: laws outside of the rod
 * (physics/law/law.h) with their numbers. A solver knows none of them by its name. */
#ifndef PHYSICS_LOCAL_ACTING_H
#define PHYSICS_LOCAL_ACTING_H

#include "physics/rod/rod_internal.h"

/* Kinds of laws, which add up. Dead loads are the same wherever the section is and goes. */
typedef enum acting_kind {
    ACTING_STORES = 1,
    ACTING_DEAD = 2,
    ACTING_OTHER_LOADS = 4,
    ACTING_DISSIPATES = 8,
    ACTING_LOADS = ACTING_DEAD | ACTING_OTHER_LOADS,
    ACTING_ALL = 15
} acting_kind;

/* Laws in their order, and of their numbers one after the other how many there are. */
typedef struct acting {
    int count, numbers, kinds; /* of laws: acting_kind, summed */
    bool by_position, by_rotation, by_velocity, has_moment;
    bool force_by_position, moment_by_position;
    bool follows; /* a force turns with the rod */
    law_name law[ROD_AT_PLACES_MAX + ROD_AT_ENDS_MAX];
    acting_kind kind[ROD_AT_PLACES_MAX + ROD_AT_ENDS_MAX];
} acting;

_Static_assert((int)ROD_ALONG_MAX <= (int)ROD_AT_PLACES_MAX, "room for laws along a rod");

enum { ACTING_ALONG_MAX = ROD_ALONG_MAX * LAW_NUMBERS_MAX };

void acting_add(acting *acting, law_name law);

/* The section: r, world; q of any length but 0; V, NULL: at rest. */
typedef struct acting_on {
    const double *position, *rotation, *velocity;
} acting_on;

/* Force and moment, world, and what they change by: [6] by r, by a turn in the world, by V. */
typedef struct acting_change {
    double wrench[6], by_position[6][3], by_turn[6][3], by_velocity[6][3];
} acting_change;

/* wrench [6] += weight times those of the kinds (acting_kind, summed). */
void acting_wrench(const acting *acting, const double *numbers, acting_on at, int kinds,
                   double weight, double *wrench);

/* result = weight times all of them. */
void acting_differentiate(const acting *acting, const double *numbers, acting_on at, double weight,
                          acting_change *result);

/* Energy that they store. */
double acting_energy(const acting *acting, const double *numbers, acting_on at);

/* The work of loads from one section to another; not a number of those that have no energy. */
double acting_work(const acting *acting, const double *numbers, acting_on from, acting_on to);

/* On the unstressed rod: sums of the sizes of loads, and of the lengths by which what stores pulls;
 * whether a force of them turns with the rod. */
typedef struct acting_size {
    double force, moment, pulled;
    bool follows;
} acting_size;

void acting_measure(const acting *acting, const double *numbers, acting_on at, acting_size *sum);

/* Numbers on the way to the full load, of which loads have `load`, and what else grows `way`. */
void acting_on_way(const acting *acting, const double *full, double load, double way,
                   double *numbers);

#endif
