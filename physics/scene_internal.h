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

/* Quantities under one key: all given or none, each parses, and uses only the coordinates it may.
 */
typedef struct scene_group {
    const char *key;
    int count;
    const quantity *entries;
    bool s_allowed;
    bool t_allowed;
    const char *s_sentence; /* what to say when s is used all the same */
    const char *t_sentence;
} scene_group;

ad_status scene_check_group(const scene_checker *check, const scene_group *group);

ad_status scene_check_drag(const scene_checker *check);

/* A beam; and that a rod in space has nothing of one (scene_check_beam.c). */
ad_status scene_check_beam(const scene_checker *check);
ad_status scene_check_no_beam(const scene_checker *check);

/* Length, section, material, stiffness, inertia, damping (scene_check_rod.c). */
ad_status scene_check_rod(const scene_checker *check);

#endif
