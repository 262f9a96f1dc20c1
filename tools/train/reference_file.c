/* The reference of a file: positions and, where it knows them, rotations at points of its own. */
#include "physics/check/plausible.h"
#include "physics/numerics/vector_size.h"
#include "tools/files/table_file.h"
#include "tools/train/reference_internal.h"

#include <math.h>
#include <string.h>

/* Columns of the file by their place in a pose; t is NULL in a static scene. */
typedef struct file_columns {
    const double *s, *t, *pose[REFERENCE_POSE];
} file_columns;

/* "x, y, z" */
static void list_columns(const scene_physics *model, int first, int count, char text[64])
{
    int length = 0;
    for (int k = first; k < first + count; k++) {
        length += snprintf(text + length, 64 - (size_t)length, "%s%s", k > first ? ", " : "",
                           model->columns[k].name);
    }
}

static ad_status blame_missing(const char *path, const char *missing, const scene_physics *model,
                               bool dynamic, ad_error *error)
{
    char positions[64], rotations[64];
    list_columns(model, 0, model->position_columns, positions);
    list_columns(model, model->position_columns, model->rotation_columns, rotations);
    return ad_fail(error, AD_BAD_INPUT,
                   "%s: column '%s' is missing; a reference has columns s, %s%s and, where it "
                   "knows rotations, %s",
                   path, missing, dynamic ? "t, " : "", positions, rotations);
}

static ad_status find_columns(reference *r, const char *path, const table_file *table, bool dynamic,
                              file_columns *columns, ad_error *error)
{
    const char *missing = NULL;
    const double *t = NULL;
    size_t positions = (size_t)r->model->position_columns;
    int turns = 0;
    ad_status status = table_find(table, "s", TABLE_FINITE, &columns->s, error);
    status = status == AD_OK ? table_find(table, "t", TABLE_FINITE, &t, error) : status;
    columns->t = dynamic ? t : NULL;
    for (size_t k = 0; k < r->pose && status == AD_OK; k++) {
        status =
            table_find(table, r->model->columns[k].name, TABLE_MEASURED, &columns->pose[k], error);
        turns += k >= positions && columns->pose[k];
    }
    if (status != AD_OK) {
        return status;
    }
    missing = !columns->s ? "s" : dynamic && !columns->t ? "t" : NULL;
    r->rotations = turns > 0;
    for (size_t k = 0; !missing && k < (turns ? r->pose : positions); k++) {
        missing = columns->pose[k] ? NULL : r->model->columns[k].name;
    }
    if (missing) {
        return blame_missing(path, missing, r->model, dynamic, error);
    }
    for (size_t i = 1; t && !dynamic && i < table_rows(table); i++) {
        if (t[i] != t[0]) {
            return ad_fail(error, AD_BAD_INPUT,
                           "%s: column 't' holds several times, but the scene is static; allowed: "
                           "one time, or no column t",
                           path);
        }
    }
    return AD_OK;
}

static bool within(double value, double limit)
{
    return value >= -REFERENCE_END_TOLERANCE * limit &&
           value <= (1 + REFERENCE_END_TOLERANCE) * limit;
}

static bool normalized(double rotation[4])
{
    double size = hypot(hypot(rotation[0], rotation[1]), hypot(rotation[2], rotation[3]));
    for (int i = 0; i < 4; i++) {
        rotation[i] /= size;
    }
    return size > 0;
}

static ad_status check_positions(const scene *of, const char *path, const file_columns *columns,
                                 size_t rows, ad_error *error)
{
    char text[SCENE_WARNING_TEXT];
    bool implausible;
    if (scene_positions_implausible(of, rows, columns->pose, &implausible, text) != AD_OK) {
        return ad_fail(error, AD_NO_MEMORY, "out of memory for %zu points", rows);
    }
    return implausible ? ad_fail(error, AD_BAD_INPUT, "%s: %s", path, text) : AD_OK;
}

/* Points outside the scene, and those without a number, are passed over; the arrays have room for
 * every row. */
static ad_status take_rows(reference *r, const char *path, const file_columns *columns, size_t rows,
                           ad_error *error)
{
    size_t kept = 0, positions = (size_t)r->model->position_columns;
    bool is_quaternion = r->model->rotation_columns == 4;
    for (size_t i = 0; i < rows; i++) {
        double pose[REFERENCE_POSE] = {0};
        if (!within(columns->s[i], r->length) ||
            (columns->t && !within(columns->t[i], r->duration))) {
            continue;
        }
        for (size_t k = 0; k < r->pose; k++) {
            pose[k] = columns->pose[k] ? columns->pose[k][i] : 0;
        }
        if (!vector_is_finite(r->pose, pose)) {
            continue;
        }
        if (r->rotations && is_quaternion && !normalized(pose + positions)) {
            return ad_fail(error, AD_BAD_INPUT,
                           "%s: row %zu: the quaternion qw, qx, qy, qz is 0; allowed: not 0", path,
                           i + 1);
        }
        r->s[kept] = columns->s[i];
        r->t[kept] = columns->t ? columns->t[i] : 0;
        reference_put_pose(r, kept++, pose, pose + positions);
    }
    r->left_out = rows - kept;
    if (kept == 0) {
        return ad_fail(
            error, AD_BAD_INPUT,
            "%s: none of its %zu points lies in the scene and has all its numbers: s from 0 to "
            "%g m%s",
            path, rows, r->length, columns->t ? ", t within the duration" : "");
    }
    for (size_t k = 1; k < r->pose; k++) { /* rows of poses follow one another */
        memmove(r->poses + k * kept, r->poses + k * r->points, kept * sizeof *r->poses);
    }
    r->points = kept;
    return AD_OK;
}

ad_status reference_read(reference *r, const experiment *e, ad_error *error)
{
    const char *path = e->settings->reference_file;
    const char *slash = strrchr(path, '/');
    table_file *table = NULL;
    file_columns columns;
    snprintf(r->name, sizeof r->name, "%s", slash ? slash + 1 : path);
    ad_status status = table_read(path, TABLE_MEASURED, &table, error);
    if (status == AD_OK) {
        status = find_columns(r, path, table, scene_is_dynamic(e->scene), &columns, error);
    }
    if (status == AD_OK && table_rows(table) == 0) {
        status =
            ad_fail(error, AD_BAD_INPUT, "%s: there are no rows; at least one is needed", path);
    }
    if (status == AD_OK) {
        status = check_positions(e->scene, path, &columns, table_rows(table), error);
    }
    if (status == AD_OK) {
        status = reference_allocate(r, table_rows(table), error);
    }
    if (status == AD_OK) {
        status = take_rows(r, path, &columns, table_rows(table), error);
    }
    table_free(table);
    return status;
}
