/* The table of support: which feature of a scene each form of its equations takes.
 *
 * Readers, checks, solvers, programs and pages ask this table, and all of them say the same
 * sentence where a form does not take a feature. tests/library/test_support.c runs a scene of every
 * feature in every form: what is taken is solved and agrees with another form, what is not is
 * refused. */
#ifndef PHYSICS_SCENE_SUPPORT_H
#define PHYSICS_SCENE_SUPPORT_H

#include "physics/scene/scene.h"

#include <stddef.h>

/* The forms: X(name in C, heading, subject of a sentence, kind, in motion). */
#define SUPPORT_FORM_LIST(X)                                                                       \
    X(SUPPORT_MIXED, "mixed", "formulation mixed", NETWORK, false)                                 \
    X(SUPPORT_DISPLACEMENT, "displacement", "formulation displacement", NETWORK, false)            \
    X(SUPPORT_POSE_STRAIN, "pose_strain", "formulation pose_strain", NETWORK, false)               \
    X(SUPPORT_FAMILY, "strain family", "formulation strain of a family", NETWORK, false)           \
    X(SUPPORT_EXPORT, "its exported C", "the exported C of a family", EXPORT, false)               \
    X(SUPPORT_COLLOCATION, "collocation", "method collocation", SOLVER, false)                     \
    X(SUPPORT_PATH, "path", "a path of equilibria", PATH, false)                                   \
    X(SUPPORT_MIXED_MOTION, "mixed", "formulation mixed", NETWORK, true)                           \
    X(SUPPORT_DISPLACEMENT_MOTION, "displacement", "formulation displacement", NETWORK, true)      \
    X(SUPPORT_POSE_STRAIN_MOTION, "pose_strain", "formulation pose_strain", NETWORK, true)         \
    X(SUPPORT_STRAIN_MOTION, "strain modes", "formulation strain of a motion", NETWORK, true)      \
    X(SUPPORT_NODES, "nodes", "method collocation of a motion", SOLVER, true)                      \
    X(SUPPORT_MODES, "modes", "method modes", SOLVER, true)                                        \
    X(SUPPORT_ONE_STEP, "one-step model", "a one-step model", STEP, true)

#define SUPPORT_FORM_NAME(name, ...) name,
typedef enum support_form { SUPPORT_FORM_LIST(SUPPORT_FORM_NAME) SUPPORT_FORMS } support_form;
#undef SUPPORT_FORM_NAME

/* In a cell. */
typedef enum support_answer {
    SUPPORT_TAKEN,
    SUPPORT_WITHOUT_EFFECT, /* accepted, and the answer is the same without it, as damping at rest
                             */
    SUPPORT_NOT_BUILT,      /* refused; mechanics would allow it */
    SUPPORT_IMPOSSIBLE /* refused; mechanics does not allow it, for the reason of the feature */
} support_answer;

/* Features are the rows 0 to support_feature_count() - 1 of the table, in the order in which they
 * are looked for. All texts are static. */
int support_feature_count(void);
const char *support_feature_name(int feature); /* "a learned law" */

/* Why it is impossible, of rods at rest or in motion; NULL: it never is. */
const char *support_feature_reason(int feature, bool moves);
int support_feature_find(const char *name); /* its row; -1: there is none */

/* The dotted YAML key with which the scene has the feature, that of an entry of a list with its
 * number; NULL: the scene does not have it. Measured data are not of a scene: NULL. */
const char *support_key(const scene *rod_scene, int feature);

const char *support_form_name(support_form form); /* heading of a column */
bool support_form_moves(support_form form);       /* of scenes in motion; else at rest */
support_answer support_of(int feature, support_form form);

/* The sentence with which a form refuses a feature: text [size]. */
void support_sentence(int feature, support_form form, char *text, size_t size);

/* AD_BAD_ARGUMENT for a scene at rest in a form of motions or the other way round, or for a feature
 * of the scene that the form does not take, with its sentence; *key receives the key to blame
 * (NULL: not wanted). The scene may have open names. */
ad_status support_check(const scene *rod_scene, support_form form, const char **key,
                        ad_error *error);

/* AD_BAD_ARGUMENT for a feature that no form takes, of scenes at rest or of scenes in motion. */
ad_status support_check_any(const scene *rod_scene, const char **key, ad_error *error);

/* As support_check, of measured data, which are beside a scene. */
ad_status support_check_data(support_form form, const char **key, ad_error *error);

/* The form of the scene's formulation, at rest or in motion. */
support_form support_formulation(const scene *rod_scene);

#endif
