/* The models that a scene may choose from, behind one interface: the rods in space of physics/rod.h
 * and the beams of small deflection of physics/beam.h. Problem, field and checks know a model
 * through it only; scenes, scales, windows of time and kinds of residuals are common to all.
 *
 * Everything on the tape is dimensionless, by rod_scales_of. */
#ifndef PHYSICS_MODEL_H
#define PHYSICS_MODEL_H

#include "physics/rod.h"

#ifdef __cplusplus
extern "C" {
#endif

enum { MODEL_FIELDS = 4, MODEL_COLUMNS_MAX = 25 };

/* The name of a column, its unit of the SI, and whether only motion has it. */
typedef struct model_column {
    const char *name, *unit;
    bool of_motion;
} model_column;

typedef struct physics_model {
    /* Symbols of position, rotation, force and moment of a rod_state. */
    const char *fields[MODEL_FIELDS];

    /* Observables in SI units: position_columns and then rotation_columns come first. */
    const model_column *columns;
    int column_count, position_columns, rotation_columns;

    int (*network_outputs)(const scene *scene);

    /* From raw outputs of the window's network to a state, and from a state to residuals; see
     * rod_ansatz, rod_residual_rows, rod_residual. */
    rod_state (*ansatz)(const scene *scene, const rod_window *window, ad_value outputs, ad_value s,
                        ad_value t);
    int (*residual_rows)(const scene *scene, rod_residual_kind kind);
    ad_value (*residual)(const scene *scene, rod_residual_kind kind, rod_state state, ad_value s,
                         ad_value t);

    /* values [column_count], one row each; zeros for those of motion in a static scene. */
    void (*observe)(const scene *scene, rod_state state, ad_value s, ad_value t, ad_value *values);

    /* The state that a window hands on; see rod_window_end. */
    ad_status (*window_end)(const scene *scene, const rod_window *window, const nn_mlp *mlp,
                            const double *x, ad_pool *pool, double *end, ad_error *error);

    /* What only shows when a scene is recorded; see rod_check. */
    ad_status (*check)(const scene *scene, const char **key, ad_error *error);

    /* For people; see rod_terms. */
    int (*terms)(const scene *scene, rod_term *terms);
} physics_model;

const physics_model *model_of(const scene *scene);

#ifdef __cplusplus
}
#endif

#endif
