#include "tools/programs/plan_files.h"

#include "tools/files/shapes_vtk.h"

#include <math.h>
#include <stdlib.h>

static const struct {
    const char *word, *column;
    size_t offset;
} parts[PLAN_PARTS] = {
    {"distance", "distance", offsetof(clearance, distance)},
    {"radius", "radius", offsetof(clearance, radius)},
    {"rounding", "rounding", offsetof(clearance, distance_error)},
    {"shape", "shape", offsetof(clearance, shape_error)},
    {"unknown", "unknown", offsetof(clearance, unknown)},
    {"between points", "between_points", offsetof(clearance, between_points)},
    {"between configurations", "between_configurations",
     offsetof(clearance, between_configurations)},
    {"left", "left", offsetof(clearance, free)},
};

double plan_part(const clearance *of, int part)
{
    return *(const double *)((const char *)of + parts[part].offset);
}

const char *plan_part_word(int part)
{
    return parts[part].word;
}

const char *plan_part_column(int part)
{
    return parts[part].column;
}

/* Rows of a table by columns. */
ad_status plan_write(const plan_robot *robot, const certificate *c, const char *path,
                     ad_error *error)
{
    const size_t rows = c->count, variables = (size_t)c->variables;
    const size_t columns = variables + PLAN_PARTS + 5;
    double *const numbers = malloc(rows * columns * sizeof *numbers);
    if (!numbers) {
        return ad_fail(error, AD_NO_MEMORY, "out of memory for a table");
    }
    static const char *const tips[] = {"tip_x", "tip_y", "tip_z"};
    table_build to;
    table_begin(&to, rows);
    double *at = numbers;
    for (size_t k = 0; k < variables; k++, at += rows) {
        for (size_t i = 0; i < rows; i++) {
            at[i] = c->configuration[i * variables + k];
        }
        table_add(&to, robot->names[k], NULL, at, NULL);
    }
    for (size_t i = 0; i < rows; i++) {
        for (size_t k = 0; k < 3; k++) {
            at[k * rows + i] = c->tip[3 * i + k];
        }
        at[3 * rows + i] = c->least[i];
        at[4 * rows + i] = c->shape[i].at;
        for (size_t k = 0; k < PLAN_PARTS; k++) {
            at[(5 + k) * rows + i] = plan_part(&c->shape[i], (int)k);
        }
    }
    table_add(&to, "left", "m", at + (5 + PLAN_PARTS - 1) * rows, NULL);
    table_add(&to, "left_on_way", "m", at + 3 * rows, NULL);
    table_add(&to, "s", "m", at + 4 * rows, NULL);
    for (size_t k = 0; k + 2 < PLAN_PARTS; k++) { /* what a way takes off is of no shape */
        table_add(&to, parts[k].column, "m", at + (5 + k) * rows, NULL);
    }
    for (size_t k = 0; k < 3; k++) {
        table_add(&to, tips[k], "m", at + k * rows, NULL);
    }
    const ad_status status = table_write(path, &to.table, error);
    free(numbers);
    return status;
}

/* Of points from pieces: the lesser of the two beside it. */
static void leave(const double *pieces, size_t points, double *left)
{
    for (size_t k = 0; k < points; k++) {
        const double before = k > 0 ? pieces[k - 1] : INFINITY;
        const double least = k + 1 < points ? fmin(before, pieces[k]) : before;
        left[k] = isinf(least) ? NAN : least;
    }
}

ad_status plan_write_shapes(plan_exact *exact, const environment *environment,
                            const plan_settings *settings, const certificate *of, const char *path,
                            ad_error *error)
{
    enum { T, S, X, RADIUS = 5, LEFT, COLUMNS };
    static const char *const names[COLUMNS] = {"t", "s", "x", "y", "z", "radius", "left"};
    static const char *const units[COLUMNS] = {"s", "m", "m", "m", "m", "m", "m"};
    const size_t points = exact->points, rows = of->count * points;
    double *const numbers = malloc((COLUMNS * rows + points) * sizeof *numbers);
    ad_status status =
        numbers ? AD_OK : ad_fail(error, AD_NO_MEMORY, "out of memory for %zu shapes", of->count);
    double *const pieces = numbers + COLUMNS * rows;
    for (size_t i = 0; i < of->count && status == AD_OK; i++) {
        const size_t member = i % PLAN_BATCH;
        if (member == 0) {
            const size_t members = of->count - i < PLAN_BATCH ? of->count - i : PLAN_BATCH;
            status = plan_exact_shapes(exact, members,
                                       &of->configuration[i * (size_t)of->variables], error);
        }
        const clearance_shape shape = {
            .points = points,
            .s = exact->s,
            .r = &exact->r[3 * member * points],
            .speed = &exact->speed[member * points],
            .error = exact->error[member],
            .spread = exact->robot->unknowns ? &exact->spread[member * points] : NULL,
            .radius = settings->radius,
            .from = settings->from};
        clearance least;
        clearance_of_shape(environment, &shape, pieces, &least);
        leave(pieces, points, &numbers[LEFT * rows + i * points]);
        for (size_t k = 0; k < points; k++) {
            const size_t row = i * points + k;
            numbers[T * rows + row] = (double)i;
            numbers[S * rows + row] = exact->s[k];
            numbers[RADIUS * rows + row] = settings->radius;
            for (size_t j = 0; j < 3; j++) {
                numbers[(X + j) * rows + row] = shape.r[3 * k + j];
            }
        }
    }
    if (status == AD_OK) {
        table_build to;
        table_begin(&to, rows);
        for (size_t k = 0; k < COLUMNS; k++) {
            table_add(&to, names[k], units[k], &numbers[k * rows], NULL);
        }
        status = shapes_write(path, &to.table, error);
    }
    free(numbers);
    return status;
}
