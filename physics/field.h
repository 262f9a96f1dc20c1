/* A trained network, or one for each window of time, as a field: the observables of
 * the scene's model at any (s, t), in SI units. */
#ifndef PHYSICS_FIELD_H
#define PHYSICS_FIELD_H

#include "nn/nn.h"
#include "physics/model.h"

#ifdef __cplusplus
extern "C" {
#endif

typedef struct field field;

/* Of the scene's first window until field_enter says more. `pose_only`: position and rotation
 * alone, which needs no derivatives. `mlp` and `pool` must outlive the field. A NULL mlp: the
 * manufactured solution of the scene. */
ad_status field_create(const scene *scene, const nn_mlp *mlp, bool pose_only, ad_pool *pool,
                       field **result, ad_error *error);
void field_free(field *f);

/* From now on the field reaches from t = 0 to the end of window `index`; parameters of the windows
 * before are earlier [index][parameters], the states they start from starts [index + 1]
 * [ROD_WINDOW_NUMBERS]; both have to live on, unchanged. */
void field_enter(field *f, int index, const double *earlier, const double *starts);

/* Those of the scene's model, in its order, at most MODEL_COLUMNS_MAX. */
int field_columns(const field *f);
const char *field_column_name(const field *f, int column);

/* values [columns][points] at s [points] (m) and t [points] (s; ignored in a static scene, may
 * then be NULL), for parameters x of the last window. An instant between two windows belongs to the
 * one that it ends; a time beyond the last window is taken as that window's. Grows its memory to
 * the largest number of points asked for. */
ad_status field_evaluate(field *f, const double *x, size_t points, const double *s, const double *t,
                         double *values, ad_error *error);

#ifdef __cplusplus
}
#endif

#endif
