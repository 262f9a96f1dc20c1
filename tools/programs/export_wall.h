/* The wall of --wall for cpinn-export: the surface of a scene's section plan. */
#ifndef TOOLS_PROGRAMS_EXPORT_WALL_H
#define TOOLS_PROGRAMS_EXPORT_WALL_H

#include "tools/emit/export_model.h"

typedef struct export_walled {
    surface_tree *tree;
    export_wall wall;
} export_walled;

/* For a model whose family is prepared, whose wall it becomes and which it outlives.
 * AD_BAD_INPUT, with the key or the option: there is no wall, or the shape does not say enough;
 * AD_BAD_ARGUMENT: for another model. Errors of surface_tree_open. */
ad_status export_wall_open(const char *scene_path, export_model *model, export_walled *result,
                           ad_error *error);
void export_wall_close(export_walled *of); /* not itself */

#endif
