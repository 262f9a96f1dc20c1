/* Tables of what was judged. Not for callers of judged.h. */
#ifndef TOOLS_TRAIN_JUDGED_ROWS_H
#define TOOLS_TRAIN_JUDGED_ROWS_H

#include "tools/train/judged.h"
#include "tools/train/measured_poses.h"

typedef struct judged_found {
    const scene *open;
    const measurements *data;
    const train_settings *settings;
    const double *values;
    double deviation;
    const solve_measured *sets; /* [count], of which `fitted` come first */
    int count, fitted;
    measured_poses *poses; /* NULL: no rows are wanted */
} judged_found;

/* residuals: of all rows, then of the points of shapes. AD_NO_MEMORY. */
ad_status measured_rows_create(const judged_found *found, const double *residuals,
                               judged_rows **result, ad_error *error);

#endif
