/* Where the undeformed rod lies, in words. */
#ifndef TOOLS_PROGRAMS_UNDEFORMED_H
#define TOOLS_PROGRAMS_UNDEFORMED_H

#include "physics/scene/scene.h"

enum { UNDEFORMED_TEXT = 200 };

/* "from (0, 0, 0) to (0.3, 0, 0) m, straight along +x"; of a motion whose initial state is given,
 * where the rod is at t = 0. Empty for a beam and for a manufactured solution, which lie where
 * their formulas say. The scene must pass scene_check and rod_check. AD_NO_MEMORY, or what the tape
 * says of a formula. */
ad_status undeformed_describe(const scene *scene, char text[UNDEFORMED_TEXT], ad_error *error);

#endif
