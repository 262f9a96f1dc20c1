#include "tools/programs/control_run.h"

#include "tools/files/table_shapes.h"
#include "tools/programs/section_size.h"

static ad_status write_table(const control_row *row, const char *path, ad_error *error)
{
    const control_loop *loop = row->loop;
    table_build to;
    table_begin(&to, (size_t)row->report.done);
    for (int i = 0; i < loop_columns(loop); i++) {
        table_add(&to, loop_column_name(loop, i), NULL, loop_column(loop, i), NULL);
    }
    return table_write(path, &to.table, error);
}

ad_status control_write_shapes(const control_row *row, const scene *plant, const char *path,
                               ad_error *error)
{
    return section_write(path, loop_shapes(row->loop), plant, true, error);
}

/* NAME_shapes.h5 beside NAME.csv. */
ad_status control_write(const control_row *row, const scene *plant, const char *path,
                        ad_error *error)
{
    char shapes[TABLE_PATH_MAX];
    const ad_status status = write_table(row, path, error);
    table_shapes_beside(path, shapes);
    return status == AD_OK ? control_write_shapes(row, plant, shapes, error) : status;
}
