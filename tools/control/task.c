#include "tools/control/task.h"

#include "physics/numerics/sort.h"
#include "physics/numerics/vector_size.h"
#include "tools/files/table_file.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

static const double PI = 3.14159265358979323846;

struct task_path {
    control_task of;
    double start[3], across[2][3];
    table_file *table; /* of a file */
    const double *columns[4];
};

/* From 0 at x <= 0 to 1 at x >= 1, with two derivatives 0 at both. */
static double blend(double x)
{
    x = fmin(fmax(x, 0), 1);
    return x * x * x * (10 - 15 * x + 6 * x * x);
}

void task_plane(const double normal[3], double across[2][3])
{
    const double size = vector_length(normal);
    const double n[3] = {normal[0] / size, normal[1] / size, normal[2] / size};
    const int axis = fabs(n[0]) < 0.9 ? 0 : 1;
    const double left = sqrt(1 - n[axis] * n[axis]);
    for (int k = 0; k < 3; k++) {
        across[0][k] = ((k == axis) - n[axis] * n[k]) / left;
    }
    for (int k = 0; k < 3; k++) {
        const int a = (k + 1) % 3, b = (k + 2) % 3;
        across[1][k] = n[a] * across[0][b] - n[b] * across[0][a];
    }
}

/* ---- files --------------------------------------------------------------------------------- */

static ad_status read_file(task_path *path, ad_error *error)
{
    static const char *const names[4] = {"t", "x", "y", "z"};
    const char *file = path->of.file;
    ad_status status = table_read(file, TABLE_MEASURED, &path->table, error);
    for (int k = 0; k < 4 && status == AD_OK; k++) {
        status = table_find(path->table, names[k], TABLE_FINITE, &path->columns[k], error);
        if (status == AD_OK && !path->columns[k]) {
            status = ad_fail(error, AD_BAD_INPUT, "%.300s: has no column %s; allowed: t, x, y, z",
                             file, names[k]);
        }
    }
    if (status == AD_OK && table_rows(path->table) < 2) {
        status = ad_fail(error, AD_BAD_INPUT, "%.300s: has %zu rows; allowed: 2 or more", file,
                         table_rows(path->table));
    }
    for (size_t i = 1; status == AD_OK && i < table_rows(path->table); i++) {
        if (!(path->columns[0][i] > path->columns[0][i - 1])) {
            status = ad_fail(error, AD_BAD_INPUT,
                             "%.300s: t of row %zu is not above that of the row before; allowed: "
                             "times that ascend",
                             file, i + 1);
        }
    }
    return status;
}

/* Slope of column k at row i: of the parabola through it and its neighbours. */
static double slope_at(const task_path *path, int k, size_t i)
{
    const double *t = path->columns[0], *y = path->columns[k];
    const size_t last = table_rows(path->table) - 1;
    if (i == 0 || i == last) {
        return 0; /* the path begins and ends at rest */
    }
    const double before = t[i] - t[i - 1], after = t[i + 1] - t[i];
    return ((y[i] - y[i - 1]) / before * after + (y[i + 1] - y[i]) / after * before) /
           (before + after);
}

static void in_file(const task_path *path, double t, double position[3])
{
    const double *times = path->columns[0];
    const size_t last = table_rows(path->table) - 1;
    t = fmin(fmax(t + times[0], times[0]), times[last]);
    const size_t low = sort_cell(last, times, t, false), high = low + 1;
    const double h = times[high] - times[low], at = (t - times[low]) / h;
    for (int k = 0; k < 3; k++) {
        const double *y = path->columns[k + 1];
        const double from = y[low], to = y[high];
        const double a = h * slope_at(path, k + 1, low) - (to - from);
        const double b = -h * slope_at(path, k + 1, high) + (to - from);
        position[k] = (1 - at) * from + at * to + at * (1 - at) * ((1 - at) * a + at * b);
    }
}

/* ---- the others ---------------------------------------------------------------------------- */

static void in_points(const task_path *path, double t, double position[3])
{
    const control_task *of = &path->of;
    const control_point *points = of->points;
    double left = t - points[0].stay, part = 0; /* of the way from i to the next */
    int i = 0;
    while (i + 1 < of->point_count && left > 0) {
        if (left < of->travel) {
            part = blend(left / of->travel);
            break;
        }
        left -= of->travel + points[++i].stay;
    }
    for (int k = 0; k < 3; k++) {
        const double from = points[i].position[k];
        position[k] = from + (part > 0 ? part * (points[i + 1].position[k] - from) : 0);
    }
}

static void in_plane(const task_path *path, double t, double position[3])
{
    const control_task *of = &path->of;
    const double phase = 2 * PI * of->frequency * t;
    const bool eight = of->path == CONTROL_EIGHT;
    const double one = of->radius * (eight ? sin(phase) : cos(phase));
    const double two = of->radius * (eight ? sin(2 * phase) / 2 : sin(phase));
    double height = of->heights[0];
    for (int k = 1; k <= CONTROL_HEIGHTS; k++) {
        height += of->heights[2 * k - 1] * cos(k * phase) + of->heights[2 * k] * sin(k * phase);
    }
    for (int k = 0; k < 3; k++) {
        position[k] = of->centre[k] + one * path->across[0][k] + two * path->across[1][k] +
                      height * of->normal[k];
    }
}

void task_path_at(const task_path *path, double t, double position[3])
{
    const double part = path->of.approach > 0 ? blend(t / path->of.approach) : 1;
    if (path->of.path == CONTROL_FILE) {
        in_file(path, t - path->of.approach, position);
    } else if (path->of.path == CONTROL_POINTS) {
        in_points(path, t - path->of.approach, position);
    } else {
        in_plane(path, t, position);
    }
    for (int k = 0; k < 3; k++) {
        position[k] = (1 - part) * path->start[k] + part * position[k];
    }
}

double task_path_end(const task_path *path)
{
    double end = path->of.approach;
    if (path->of.path == CONTROL_FILE) {
        return end + path->columns[0][table_rows(path->table) - 1] - path->columns[0][0];
    }
    for (int i = 0; i < path->of.point_count; i++) {
        end += path->of.points[i].stay + (i > 0 ? path->of.travel : 0);
    }
    return path->of.path == CONTROL_POINTS ? end : 0;
}

ad_status task_path_create(const control_task *task, const double start[3], task_path **result,
                           ad_error *error)
{
    task_path *path = calloc(1, sizeof *path);
    *result = NULL;
    if (!path) {
        return ad_fail(error, AD_NO_MEMORY, "out of memory for a path");
    }
    path->of = *task;
    memcpy(path->start, start, sizeof path->start);
    task_plane(task->normal, path->across);
    const ad_status status = task->path == CONTROL_FILE ? read_file(path, error) : AD_OK;
    if (status != AD_OK) {
        task_path_free(path);
        return status;
    }
    *result = path;
    return AD_OK;
}

void task_path_free(task_path *path)
{
    if (path) {
        table_free(path->table);
        free(path);
    }
}
