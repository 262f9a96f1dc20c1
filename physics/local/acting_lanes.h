/* What acts from outside on LANES rods side by side (acting.h). */
#ifndef PHYSICS_LOCAL_ACTING_LANES_H
#define PHYSICS_LOCAL_ACTING_LANES_H

#include "physics/local/acting.h"
#include "physics/numerics/processor.h"

/* Force and moment, world, and what they change by: as acting_change. */
typedef struct acting_lanes {
    lanes wrench[6], by_position[6][3], by_turn[6][3], by_velocity[6][3];
} acting_lanes;

/* Of sections at rest, the rotation unit. A rod of which the turns are known gives forces, these
 * the positions, and both the rest: before the positions are known forces and moments that do not
 * depend on them, which `position` does not change; then (placed) forces and moments that do, and
 * moments of all laws that depend on the position. */
void acting_lanes_of(const acting *acting, const lanes *numbers, bool placed, const lanes *position,
                     const lanes *rotation, acting_lanes *result);

/* What force and moment [6] of these laws change by with a change of their numbers, the section
 * where it is. */
void acting_lanes_change(const acting *acting, const lanes *numbers, const lanes *change,
                         bool placed, const lanes *position, const lanes *rotation, lanes *wrench);

/* Numbers where all that grows has its share of the full load. */
void acting_lanes_on_way(const acting *acting, const lanes *full, const lanes *share,
                         lanes *numbers);

#endif
