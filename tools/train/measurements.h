/* What was measured on a scene: the files of its list `data` as rows in SI,
 * with columns s, in motion t, of a family each parameter that is known, and those of the
 * quantity, as the file has them or as formulas of its columns (measured_columns.h). Other columns
 * may hold anything. Of the quantity numbers may be missing, as those of a marker that a camera
 * lost: they do not count, and are NaN; rows without any are left out. */
#ifndef TOOLS_TRAIN_MEASUREMENTS_H
#define TOOLS_TRAIN_MEASUREMENTS_H

#include "physics/solve/measured.h"
#include "tools/train/train_settings.h"

typedef struct measurements measurements;

/* One set for each entry of the settings' list; its noise is 1 where none is given. Sets that are
 * held out come last, and no check is of them alone. AD_BAD_INPUT,
 * AD_IO: `key` receives the key to blame, and the error has the file, and where it is one row its
 * line: columns missing, no rows, places off the rod, times beyond the duration, known values out
 * of their range, what is no number, positions that are hardly in m; a quantity that the scene has
 * not. Of a scene with
 * unknowns also: noise given of some files and not of others, weights that differ, fewer numbers
 * than unknowns. AD_NO_MEMORY. */
ad_status measurements_read(const scene *open, const train_settings *settings,
                            measurements **result, char key[TRAIN_KEY_MAX], ad_error *error);
/* The same for what goes through recordings: all may be held out, and files may leave out known
 * parameters of these names [beside]: NaN. */
ad_status measurements_read_beside(const scene *open, const train_settings *settings, int beside,
                                   const char *const *names, measurements **result,
                                   char key[TRAIN_KEY_MAX], ad_error *error);
/* AD_BAD_INPUT where a file is robust, of what takes squares alone. */
ad_status measurements_take_squares(const train_settings *settings, char key[TRAIN_KEY_MAX],
                                    ad_error *error);
void measurements_free(measurements *measurements); /* NULL is allowed */

/* By which motions are followed, where that is by modes. */
void measurements_set_modes(measurements *measurements, const int modes[4]);

int measurements_count(const measurements *measurements);          /* of sets that are fitted */
int measurements_held_out(const measurements *measurements);       /* of those behind them */
int measurements_entry(const measurements *measurements, int set); /* of the settings' list */
size_t
measurements_missing(const measurements *measurements); /* fields of the files without a number */
bool measurements_tell_noise(
    const measurements *measurements); /* of all is given how large it is */
/* [measurements_count + measurements_held_out]. */
const solve_measured *measurements_sets(const measurements *measurements);

#endif
