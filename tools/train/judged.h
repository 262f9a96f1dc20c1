/* How far a scene is from what was measured on it, file by file, those that are held out, too. */
#ifndef TOOLS_TRAIN_JUDGED_H
#define TOOLS_TRAIN_JUDGED_H

#include "tools/train/measurements.h"

/* Of the rows of a file in which nothing is missing that others have, such as the one coordinate
 * that was measured: distances between measured and computed, of rotations angles, in SI. NaN where
 * the scene has no solution. */
typedef struct judged_set {
    int entry; /* of the settings' list */
    bool held_out;
    size_t rows;
    double rms, mean, median, worst;
    double chi_squared; /* of all its numbers, each over its noise as it is given, else 1 */
    size_t numbers;
} judged_set;

typedef struct judged {
    int count;
    judged_set set[TRAIN_DATA_MAX]; /* those that are held out last */
} judged;

/* The scene at values [unknown_count]; threads as of solve_trials_create. Errors as of this. */
ad_status measured_judge(const scene *open, const measurements *data, const double *values,
                         int threads, judged *result, ad_error *error);

/* Writes a table of all rows: file, judged (fitted, held_out), s, in motion t, the parameters that
 * are known, and of each column that was measured what was measured, "x", and what is computed,
 * "x_computed" (of rotations missing); distance, as above. Errors as of table_write, too. */
ad_status measured_write(const scene *open, const measurements *data,
                         const train_settings *settings, const double *values, int threads,
                         const char *path, ad_error *error);

#endif
