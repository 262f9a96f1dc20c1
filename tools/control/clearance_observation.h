/* How far the places of a reduced rod, with its skin, stay from a surface, as one number: a smooth
 * minimum over places, which is at most their least, and less by no more than `smooth` times the
 * logarithm of their number. Needs no library and allocates nothing: exported C has this very text.
 */
#ifndef CONTROL_CLEARANCE_OBSERVATION_H
#define CONTROL_CLEARANCE_OBSERVATION_H

#include "physics/numerics/triangle_tree.h"
#include "tools/control/kinematic_observation.h"

/* All is borrowed. */
typedef struct clearance_observation {
    one_observation places; /* positions, 3 of each */
    const triangle_tree *surface;
    double radius, smooth; /* m */
    double *room;          /* [clearance_observation_room] */
} clearance_observation;

size_t clearance_observation_room(const one_observation *places);

/* One value, m; one call at a time. */
one_observation clearance_observation_of(clearance_observation *x);

#endif
