#include "tools/programs/work_precision.h"

#include "tools/files/table_file.h"
#include "tools/judge/sweep.h"
#include "tools/programs/samples.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

enum { SWEEP_MAX = 32 };
/* Errors are shown as at least this much, because curves are drawn over logarithms. */
static const double SMALLEST = 1e-16;

typedef struct sweep {
    const scene *of;
    samples *grid;
    double *exact; /* [numbers] positions on the grid, by the finest solution */
    size_t numbers;
    int count;
    double size[SWEEP_MAX], seconds[SWEEP_MAX], errors[SWEEP_MAX];
} sweep;

/* Relative L2 of positions, as cpinn-bench measures it. */
static double distance(const double *values, size_t numbers, const double *exact)
{
    double off = 0, size = 0;
    for (size_t i = 0; i < numbers; i++) {
        off += (values[i] - exact[i]) * (values[i] - exact[i]);
        size += exact[i] * exact[i];
    }
    return sqrt(off / size);
}

static double sweep_row(void *context, int size, double seconds, const solution *solved)
{
    sweep *rows = context;
    samples *grid = rows->grid;
    const answer found = answer_of_solution(solved, rows->of);
    ad_error ignored; /* no memory: the table ends there */
    if (rows->count == SWEEP_MAX || samples_ask(grid, &found, &ignored) != AD_OK) {
        return NAN;
    }
    double error = distance(grid->values, rows->numbers, rows->exact);
    rows->size[rows->count] = size;
    rows->seconds[rows->count] = seconds;
    rows->errors[rows->count++] = fmax(SMALLEST, error);
    return error;
}

static ad_status write_rows(const sweep *rows, const char *of, const char *path, bool prints,
                            ad_error *error)
{
    table_build to;
    if (prints) {
        printf("%6s %10s %12s\n", of, "ms", "error");
        for (int i = 0; i < rows->count; i++) {
            printf("%6.0f %10.3f %12.2e\n", rows->size[i], 1e3 * rows->seconds[i], rows->errors[i]);
        }
    }
    table_begin(&to, (size_t)rows->count);
    table_add(&to, "seconds", "s", rows->seconds, NULL);
    table_add(&to, "error", "", rows->errors, NULL);
    table_add(&to, of, "", rows->size, NULL);
    return table_write(path, &to.table, error);
}

ad_status work_precision_write(const scene *scene, const solve_settings *like,
                               const solution *finest, samples *grid, const char *path, bool prints,
                               ad_error *error)
{
    const answer found = answer_of_solution(finest, scene);
    sweep rows = {.of = scene, .grid = grid};
    rows.numbers = (size_t)scene_physics_of(scene)->position_columns * grid->count; /* come first */
    rows.exact = malloc(rows.numbers * sizeof *rows.exact);
    if (!rows.exact) {
        return ad_fail(error, AD_NO_MEMORY, "out of memory for %zu points", grid->count);
    }
    ad_status status = samples_ask(grid, &found, error);
    if (status == AD_OK) {
        memcpy(rows.exact, grid->values, rows.numbers * sizeof *rows.exact);
        status = solve_sweep(scene, like, grid->count, grid->t, sweep_row, &rows, error);
    }
    status = status == AD_OK ? write_rows(&rows, like->method == SOLVE_MODES ? "modes" : "nodes",
                                          path, prints, error)
                             : status;
    free(rows.exact);
    return status;
}
