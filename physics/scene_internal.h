/* What the scene_check files share; not for callers. */
#ifndef PHYSICS_SCENE_INTERNAL_H
#define PHYSICS_SCENE_INTERNAL_H

#include "physics/scene.h"

typedef struct scene_checker {
    const scene *scene;
    const char **key; /* receives the key to blame */
    ad_error *error;
} scene_checker;

/* Write key and sentence, return AD_BAD_INPUT. */
ad_status scene_refuse(const scene_checker *check, const char *key, const char *sentence);

/* Length, section, material, stiffness, inertia, damping (scene_check_rod.c). */
ad_status scene_check_rod(const scene_checker *check);

#endif
