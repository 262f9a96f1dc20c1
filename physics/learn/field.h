/* A trained network, or one for each window of time, as a field: the observables of its model
 * anywhere in the domain, in SI units. */
#ifndef PHYSICS_LEARN_FIELD_H
#define PHYSICS_LEARN_FIELD_H

#include "nn/nn.h"
#include "physics/learn/model.h"

typedef struct field field;

/* Of the model's first window until field_enter says more, under all loads until field_load does.
 * `pose_only`: position and rotation alone, which needs no derivatives. The model, `mlp` and `pool`
 * must outlive the field. A NULL mlp: the manufactured solution of the scene. */
ad_status field_create(const physics_model *m, const nn_mlp *mlp, bool pose_only, ad_pool *pool,
                       field **result, ad_error *error);
void field_free(field *f);

/* From now on the field reaches from the beginning of time to the end of window `index`; parameters
 * of the windows before are earlier [index][parameters], the states they start from starts
 * [index + 1][window_state_numbers]; both have to live on, unchanged. */
void field_enter(field *f, int index, const double *earlier, const double *starts);

/* From now on this factor of the loads acts. */
void field_load(field *f, double factor);

/* From now on the field is that of one member of a family, values [parameter_count] in SI units,
 * and the coordinates that it is asked at are s and t alone. */
void field_member(field *f, const double *values);

/* Those of the model, in its order, at most MODEL_COLUMNS_MAX. */
int field_columns(const field *f);
const char *field_column_name(const field *f, int column);

/* values [columns][points] at the coordinates at[coordinates of the domain][points], in SI units,
 * for parameters x of the last window. An instant between two windows belongs to the one that it
 * ends; a time beyond the last window is taken as that window's. Grows its memory to the largest
 * number of points asked for. */
ad_status field_evaluate(field *f, const double *x, size_t points, const double *const *at,
                         double *values, ad_error *error);

#endif
