#include "tools/programs/samples.h"

#include "tools/programs/cli.h"
#include "tools/programs/section_size.h"
#include "tools/train/reference.h"

#include <math.h>
#include <stdlib.h>

ad_status samples_make(samples *p, size_t count, int columns, ad_error *error)
{
    p->count = count;
    p->columns = columns;
    p->s = calloc(2 * count + 1, sizeof *p->s);
    p->values = calloc((size_t)columns * count + 1, sizeof *p->values);
    if (!p->s || !p->values) {
        return ad_fail(error, AD_NO_MEMORY, "out of memory for %zu points", count);
    }
    p->t = p->s + count;
    return AD_OK;
}

void samples_free(samples *p)
{
    free(p->s);
    free(p->values);
}

ad_status samples_of_grid(samples *p, const char *grid, const scene *scene, double until,
                          int columns, ad_error *error)
{
    bool dynamic = scene_is_dynamic(scene);
    const char *text = grid ? grid : dynamic ? "51x21" : "101";
    long ns, nt;
    if (!cli_grid(text, dynamic, &ns, &nt)) {
        return ad_fail(error, AD_BAD_ARGUMENT,
                       "--grid %s: allowed: NSxNT, the number of points along s and t%s", text,
                       dynamic ? "" : "; this scene is static, so NT is 1");
    }
    ad_status status = samples_make(p, (size_t)(ns * nt), columns, error);
    for (long i = 0; status == AD_OK && i < ns * nt; i++) {
        long at_s = i % ns, at_t = i / ns;
        p->s[i] = ns > 1 ? scene_length(scene) * (double)at_s / (double)(ns - 1) : 0;
        p->t[i] = nt > 1 ? until * (double)at_t / (double)(nt - 1) : 0;
    }
    return status;
}

/* Refuses a point of the file that lies outside the scene by more than rounding. */
static ad_status check_point(const char *path, const table_file *table, size_t row,
                             const char *name, double value, double limit, ad_error *error)
{
    if (value >= -REFERENCE_END_TOLERANCE * limit &&
        value <= (1 + REFERENCE_END_TOLERANCE) * limit) {
        return AD_OK;
    }
    char where[64];
    size_t line = table_line(table, row);
    snprintf(where, sizeof where, line ? "%zu" : " row %zu", line ? line : row + 1);
    return ad_fail(error, AD_BAD_INPUT,
                   "%s:%s: %s = %.10g is outside the scene; allowed: 0 to %g %s", path, where, name,
                   value, limit, *name == 's' ? "m" : "s");
}

static ad_status take_points(samples *p, const char *path, const table_file *table,
                             const scene *scene, double until, int columns, ad_error *error)
{
    const double *s, *t = NULL;
    bool dynamic = scene_is_dynamic(scene);
    size_t rows = table_rows(table);
    ad_status status = table_find(table, "s", TABLE_FINITE, &s, error);
    if (status == AD_OK && dynamic) {
        status = table_find(table, "t", TABLE_FINITE, &t, error);
    }
    if (status != AD_OK) {
        return status;
    }
    if (!s || (dynamic && !t)) {
        return ad_fail(error, AD_BAD_INPUT, "%s: column '%s' is missing; points have columns s%s",
                       path, s ? "t" : "s", dynamic ? " and t" : "");
    }
    if (rows == 0) {
        return ad_fail(error, AD_BAD_INPUT, "%s: there are no rows; at least one is needed", path);
    }
    status = samples_make(p, rows, columns, error);
    for (size_t i = 0; i < rows && status == AD_OK; i++) {
        p->s[i] = s[i];
        p->t[i] = t ? t[i] : 0;
        status = check_point(path, table, i, "s", s[i], scene_length(scene), error);
        if (status == AD_OK && dynamic) {
            status = check_point(path, table, i, "t", t[i], until, error);
        }
    }
    return status;
}

ad_status samples_of_file(samples *p, const char *path, const scene *scene, double until,
                          int columns, ad_error *error)
{
    table_file *table = NULL;
    ad_status status = table_read(path, TABLE_MEASURED, &table, error);
    if (status == AD_OK) {
        status = take_points(p, path, table, scene, until, columns, error);
    }
    table_free(table);
    return status;
}

void samples_fill(const samples *p, const scene *scene, samples_table *result_table)
{
    const model_column *model = scene_physics_of(scene)->columns;
    *result_table = (samples_table){{"s", "t"}, {"m", "s"}, {p->s, p->t}, {.nrows = p->count}};
    for (int i = 0; i < p->columns; i++) {
        result_table->names[2 + i] = model[i].name;
        result_table->units[2 + i] = model[i].unit;
        result_table->columns[2 + i] = p->values + (size_t)i * p->count;
    }
    result_table->table.names = result_table->names;
    result_table->table.columns = result_table->columns;
    result_table->table.units = result_table->units;
    result_table->table.ncols = (size_t)p->columns + 2;
}

ad_status samples_write(const samples *p, const scene *scene, const char *path, ad_error *error)
{
    samples_table result_table;
    samples_fill(p, scene, &result_table);
    return section_write(path, &result_table.table, scene, false, error);
}
