/* All that a scene says along one coordinate, each formula and each place once; not for callers. */
#ifndef PHYSICS_SCENE_SCENE_WALK_H
#define PHYSICS_SCENE_SCENE_WALK_H

#include "physics/scene/scene.h"

typedef struct scene_walker {
    /* A formula of the coordinate, under its dotted YAML key, and where along the rod it counts. */
    void (*formula)(void *context, const char *key, quantity q, quantity_interval s);
    /* Where something sits or ends along the rod, m; NULL: not asked for. */
    void (*place)(void *context, const char *key, double s);
    void *context;
} scene_walker;

/* coordinate: "s" or "t" */
void scene_walk(const scene *rod_scene, const char *coordinate, const scene_walker *walker);

/* How many formulas it comes by. */
size_t scene_walk_formulas(const scene *rod_scene, const char *coordinate);

#endif
