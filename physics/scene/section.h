/* What follows from the shape of a cross-section. */
#ifndef PHYSICS_SCENE_SECTION_H
#define PHYSICS_SCENE_SECTION_H

#include "physics/scene/scene.h"

/* Geometry of a filled-in section, of s; nothing given for SCENE_SECTION_NONE. */
typedef struct scene_section_geometry {
    quantity area;             /* m^2 */
    quantity second_moment[2]; /* about d1, d2; m^4 */
    quantity torsion_constant; /* m^4; Saint-Venant */
} scene_section_geometry;

scene_section_geometry scene_section_geometry_of(const scene_rod *rod);

/* Cowper's shear correction (J. Appl. Mech. 33, 1966) for the section and Poisson's ratio; not
 * given when either is missing. */
quantity scene_shear_correction(const scene_rod *rod);

#endif
