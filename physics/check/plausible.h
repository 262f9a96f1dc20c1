/* Sizes that a scene may have but is hardly meant to have: a modulus in MPa where Pa is expected,
 * an arm as long as a street. They are told to the user, and nothing else follows from them. */
#ifndef PHYSICS_CHECK_PLAUSIBLE_H
#define PHYSICS_CHECK_PLAUSIBLE_H

#include "physics/scene/scene.h"
#include "physics/scene/verdict.h"

enum { SCENE_WARNINGS_MAX = 12, SCENE_WARNING_TEXT = 200 };

typedef struct scene_warnings {
    int count;
    char texts[SCENE_WARNINGS_MAX][SCENE_WARNING_TEXT]; /* "KEY: what is odd; what may be meant" */
} scene_warnings;

/* Of a scene that passes scene_check. Numbers in SI units are only judged where the scene names a
 * material, which ties it to them, unless its Young's modulus is exactly 1, which only scenes
 * without dimension have; ratios are judged in every scene. */
scene_warnings scene_implausible(const scene *rod_scene);

/* The same as a remark of a verdict. */
void scene_judge_sizes(const scene *rod_scene, verdict *result);

/* Whether positions in a table, position[3][rows], of a beam [1][rows], NaN where one is
 * missing, are hardly of this rod, since a fourth of them lies more than ten lengths from
 * where it is held, wherever its parameters put that; `text` then says so. AD_NO_MEMORY, without a
 * message. */
ad_status scene_positions_implausible(const scene *open, size_t rows, const double *const *position,
                                      bool *implausible, char text[SCENE_WARNING_TEXT]);

#endif
