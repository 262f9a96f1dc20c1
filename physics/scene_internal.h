/* What the scene_check files share; not for callers. */
#ifndef PHYSICS_SCENE_INTERNAL_H
#define PHYSICS_SCENE_INTERNAL_H

#include "physics/scene_field.h"

typedef struct scene_checker {
    const scene *scene;
    const char **key; /* receives the key to blame */
    ad_error *error;
} scene_checker;

/* Write key and sentence, return AD_BAD_INPUT. */
ad_status scene_refuse(const scene_checker *check, const char *key, const char *sentence);

/* A beam; and that a rod in space has nothing of one (scene_check_beam.c). */
ad_status scene_check_beam(const scene_checker *check);
ad_status scene_check_no_beam(const scene_checker *check);

/* Section, material, stiffness, inertia, damping (scene_check_rod.c). */
ad_status scene_check_rod(const scene_checker *check);

#endif
