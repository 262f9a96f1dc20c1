/* The dimensionless numbers of a scene in one line. */
#ifndef TOOLS_PROGRAMS_SCENE_LINE_H
#define TOOLS_PROGRAMS_SCENE_LINE_H

#include "physics/scene.h"

void scene_line_print(const char *scene_name, const scene *of); /* to stdout */

#endif
