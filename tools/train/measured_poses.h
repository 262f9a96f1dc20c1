/* Poses of measured rows: rows of one instant of one experiment are of one shape of the rod. And
 * points along that shape, as rows to be solved with those that were measured. */
#ifndef TOOLS_TRAIN_MEASURED_POSES_H
#define TOOLS_TRAIN_MEASURED_POSES_H

#include "autodiff/memory.h"
#include "tools/train/measurements.h"

/* Rows are those of all sets of the measurements, one set after the other. */
typedef struct measured_poses {
    size_t rows, count;
    size_t *pose; /* [rows] 0 to count - 1, ascending but for rows of further markers */
    size_t
        *marker; /* [rows] from 1 on, of places along and beside the rod; 0: there are too many */
    size_t markers;
    /* each `every`-th pose has a shape */
    size_t every, shapes, points;
    size_t *shape; /* [shapes] its pose */
    int sets;
    solve_measured *set; /* [sets] points of the shapes, whose residuals are their places, m */
    scene_view *late;    /* [sets] their delays */
    double *numbers;     /* what the sets borrow */
    size_t *at;
    const solve_inputs **inputs;
    ad_memory memory;
} measured_poses;

/* Rows in turn are of one pose while what is known and the time are the same, and so are rows with
 * the same place in the same file of several entries; of each marker a pose has one row. values
 * [unknown_count]. AD_NO_MEMORY. */
ad_status measured_poses_create(const scene *open, const measurements *data,
                                const train_settings *settings, const double *values,
                                measured_poses **result, ad_error *error);
void measured_poses_free(measured_poses *poses); /* NULL is allowed */

/* What is known of a row, and the values of unknowns: parameters [parameter_count]. */
void measured_row_parameters(const scene *open, const solve_measured *set, size_t row,
                             const double *values, double *parameters);

#endif
