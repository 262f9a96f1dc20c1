#include "tools/programs/section_size.h"

#include "tools/files/shapes_vtk.h"

#include <math.h>
#include <stdlib.h>

static double size_at(quantity size, double s)
{
    const double value = size.is_given ? quantity_value(size, s, 0) : 0;
    return isfinite(value) ? value : 0;
}

double section_half(const scene *of, double s, bool along_d2)
{
    scene_piece piece = scene_piece_of(of, 0);
    for (int i = 1; i < scene_pieces(of) && s > piece.to; i++) {
        piece = scene_piece_of(of, i);
    }
    const scene_rod *rod = &piece.rod;
    if (rod->section == SCENE_RECTANGLE) {
        return size_at(along_d2 ? rod->height : rod->width, s) / 2;
    }
    double radius = size_at(rod->radius, s);
    for (int i = 0; i < of->tube_count; i++) {
        if (s <= scene_tube_end(of, i)) {
            radius = fmax(radius, size_at(of->tubes[i].rod.radius, s));
        }
    }
    return radius;
}

double section_ball(const scene *of, double s)
{
    const double least = 0.01 * scene_length(of), most = 0.03 * scene_length(of);
    const double half = fmax(least, fmax(section_half(of, s, false), section_half(of, s, true)));
    return fmin(1.6 * half, fmax(1.2 * half, most));
}

static ad_status write_with(const char *path, const table_source *table, const double *radius,
                            ad_error *error)
{
    table_build with;
    table_begin(&with, table->nrows);
    for (size_t k = 0; k < table->ncols; k++) {
        table_add(&with, table->names[k], table->units ? table->units[k] : "", table->columns[k],
                  table->words ? table->words[k] : NULL);
    }
    table_add(&with, "radius", "m", radius, NULL);
    return shapes_write(path, &with.table, error);
}

ad_status section_write(const char *path, const table_source *table, const scene *of, bool always,
                        ad_error *error)
{
    const double *s = table_source_column(table, "s");
    if (!s || table->ncols == TABLE_MAX_COLUMNS || !(always || shapes_is_vtk(path))) {
        return shapes_write(path, table, error);
    }
    double *radius = malloc(table->nrows * sizeof *radius + 1);
    if (!radius) {
        return ad_fail(error, AD_NO_MEMORY, "out of memory for shapes");
    }
    for (size_t i = 0; i < table->nrows; i++) {
        radius[i] = fmax(section_half(of, s[i], false), section_half(of, s[i], true));
    }
    const ad_status status = write_with(path, table, radius, error);
    free(radius);
    return status;
}
