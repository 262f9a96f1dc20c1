/* Shapes in a table as a file for ParaView and VTK, as polylines: ".vtkhdf", one file with all
 * instants (VTKHDF 2.0, PolyData, of ParaView 5.12 and later). After
 * docs.vtk.org/en/latest/vtk_file_formats.
 *
 * Point data, of what columns the table has: strain, curvature, angular_velocity in the directors'
 * components, force, moment, velocity in the world's, directors d1, d2, d3, and further columns as
 * they are; `radius` is what the filter Tube takes. Of a beam points are (s, 0, w). */
#ifndef TOOLS_FILES_SHAPES_VTK_H
#define TOOLS_FILES_SHAPES_VTK_H

#include "tools/files/table_shapes.h"

#include <stdbool.h>

/* table_check_path and table_write, for this ending, too. AD_BAD_ARGUMENT also: a table without
 * shapes, or with blocks of different size. */
ad_status shapes_check_path(const char *path, ad_error *error);
ad_status shapes_write(const char *path, const table_source *table, ad_error *error);

/* Whether a path has this ending. */
bool shapes_is_vtk(const char *path);

#endif
