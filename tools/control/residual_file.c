/* A residual as a table of one column, value: states, inputs, units, then D, c, C and the numbers
 * of the network. */
#include "tools/control/residual_internal.h"

#include "tools/files/table_file.h"

#include <math.h>
#include <stdbool.h>
#include <stdlib.h>
#include <string.h>

enum { HEAD = 3 };

ad_status residual_write(const residual *residual, const char *path, ad_error *error)
{
    const size_t sizes = residual->states + 2 * residual->inputs,
                 rows = HEAD + sizes + residual_count(residual);
    double *all = malloc(rows * sizeof *all);
    if (!all) {
        return ad_fail(error, AD_NO_MEMORY, "out of memory for a residual");
    }
    all[0] = (double)residual->states;
    all[1] = (double)residual->inputs;
    all[2] = (double)residual->units;
    memcpy(all + HEAD, residual->size, sizes * sizeof *all);
    memcpy(all + HEAD + sizes, residual->numbers, residual_count(residual) * sizeof *all);
    table_build to;
    table_begin(&to, rows);
    table_add(&to, "value", NULL, all, NULL);
    const ad_status status = table_write(path, &to.table, error);
    free(all);
    return status;
}

/* Whether inputs have the ranges that middles [count] and halves [count] behind them are of. */
static bool is_of_ranges(size_t count, const double *middle, const scene_parameter *ranges)
{
    bool same = true;
    for (size_t i = 0; i < count; i++) {
        const double low = middle[i] - middle[count + i], high = middle[i] + middle[count + i];
        const double slack = 1e-9 * (ranges[i].high - ranges[i].low);
        same = same && fabs(low - ranges[i].low) <= slack && fabs(high - ranges[i].high) <= slack;
    }
    return same;
}

ad_status residual_read(const char *path, const one_step *of, const scene_parameter *ranges,
                        residual **result, ad_error *error)
{
    table_file *file = NULL;
    *result = NULL;
    ad_status status = table_read(path, TABLE_FINITE, &file, error);
    if (status != AD_OK) {
        return status;
    }
    const double *all = table_column(file, "value");
    const size_t n = (size_t)of->states, m = (size_t)of->inputs, rows = table_rows(file);
    const double units = all && rows > HEAD ? all[2] : 0;
    const size_t sizes = n + 2 * m;
    const bool fits = units >= 1 && all[0] == (double)n && all[1] == (double)m &&
                      (double)rows == HEAD + (double)sizes + units * (double)(1 + 2 * n + m) &&
                      is_of_ranges(m, all + HEAD + n, ranges);
    if (!fits) {
        status = ad_fail(error, AD_BAD_INPUT,
                         "%s: is no residual of a model of %zu states and %zu inputs of these "
                         "ranges; allowed: one that cpinn-residual has learned for this scene and "
                         "these modes",
                         path, n, m);
    } else {
        const double *size = all + HEAD;
        status = residual_create(of, (int)units, size, size + n, size + n + m, result, error);
    }
    if (status == AD_OK) {
        memcpy((*result)->numbers, all + HEAD + sizes, residual_count(*result) * sizeof *all);
    }
    table_free(file);
    return status;
}
