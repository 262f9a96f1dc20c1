/* How far a scene is from what was measured on it, file by file, those that are held out, too. */
#ifndef TOOLS_TRAIN_JUDGED_H
#define TOOLS_TRAIN_JUDGED_H

#include "tools/files/table_file.h"
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
    size_t unsolved; /* rows, also with missing numbers, for which there is no solution */
} judged_set;

typedef struct judged {
    int count;
    judged_set set[TRAIN_DATA_MAX]; /* those that are held out last */
    ad_error unsolved;              /* its message: why there is none for some row, where known */
} judged;

/* How a file was judged: "held_out", else "fitted", or where nothing is unknown "compared". */
const char *measured_how(const scene *open, bool held_out);

/* rows, rms, mean, median and worst of distances [rows], which are sorted. */
void measured_distances(size_t rows, double *distances, judged_set *result);

/* The rows of all files, and shapes of the rod beside them, as tables. */
typedef struct judged_rows judged_rows;

/* The scene at values [unknown_count], solved once; threads as of solve_trials_create. rows: NULL,
 * they are not wanted. deviation: by which the noise of the measurements is to be multiplied; NaN:
 * it is not known. What is given outlives the rows. Errors as of solve_trials_create. */
ad_status measured_judge(const scene *open, const measurements *data,
                         const train_settings *settings, const double *values, double deviation,
                         int threads, judged *result, judged_rows **rows, ad_error *error);
void measured_rows_free(judged_rows *rows); /* NULL is allowed */

/* Columns file, data (which of the list), judged (measured_how), pose and marker (from 1 on, as of
 * measured_poses), s, in motion t, the parameters that are known, and of each column that was
 * measured what was measured, "x", and what is computed, "x_computed" (of rotations missing). Where
 * a frame of cameras is given also x_in_scene, ... and x_computed_in_scene, ..., of positions.
 * distance, as above; deviation, what is assumed of a number. */
const table_source *measured_rows_table(const judged_rows *rows);
/* Columns member (the pose), s and those of places, for table_shapes_of; at most 4000 poses. */
const table_source *measured_rows_shapes(const judged_rows *rows);

#endif
