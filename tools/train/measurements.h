/* What was measured on a scene: the files of its section `data`, CSV or HDF5 in SI with columns
 * named as cpinn-eval writes them: s, in motion t, of a family each parameter that is not to be
 * found, and whatever of the model's columns was measured (of a rotation in space all four). */
#ifndef TOOLS_TRAIN_MEASUREMENTS_H
#define TOOLS_TRAIN_MEASUREMENTS_H

#include "physics/solve/measured.h"
#include "tools/train/settings.h"

#ifdef __cplusplus
extern "C" {
#endif

typedef struct measurements measurements;

/* One set for each file, of which solve_measured.noise is that of the settings, NaN where it is not
 * given. AD_BAD_INPUT with the file, and where it is one row its line: columns missing or unknown,
 * no rows, places off the rod, times beyond the duration, known values out of their range, numbers
 * that are not finite. AD_IO, AD_NO_MEMORY. */
ad_status measurements_read(const scene *open, int count, const train_data *files,
                            measurements **result, ad_error *error);
void measurements_free(measurements *x); /* NULL is allowed */

int measurements_count(const measurements *x);
const solve_measured *measurements_sets(const measurements *x); /* [measurements_count] */

/* What a column of the scene's model measures. */
train_noise measurements_kind(const scene *open, int column);

#ifdef __cplusplus
}
#endif

#endif
