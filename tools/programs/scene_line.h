/* What a scene is, to stdout. */
#ifndef TOOLS_PROGRAMS_SCENE_LINE_H
#define TOOLS_PROGRAMS_SCENE_LINE_H

#include "physics/scene/scene.h"

/* Its dimensionless numbers in one line. */
void scene_line_print(const char *scene_name, const scene *of);

/* Sizes that are hardly meant, a line each, before work on them begins. */
void scene_line_implausible(const scene *of);

#endif
