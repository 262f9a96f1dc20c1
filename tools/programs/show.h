/* Reports for cpinn-show: one JSON object, in one HTML file with all that shows it (tools/show).
 *
 *   title, program, verdict    as everywhere; null: nobody has judged
 *   facts       [[name, value], ...] texts
 *   motion      frames, points, s, t or labels, columns, reference {name, ...}: show_motion
 *   scene       what is drawn beside the rod: show_scene
 *   wall        places of corners, and triangles of them, around the rod: show_wall
 *   live        parameters, columns, steps, s, reasons, members with their tips, and a module
 *               that finds shapes and what is drawn, in place of a motion: show_live; or a text
 *               "advice" that says why there is none
 *   workspace   {rows, columns, says, directions, moves}: tips of members and what is known of each
 *   paths       [motion of one point, ...] of a closed loop: wanted, then what was gone
 *   residuals   rows, what they are of and how far they are off, of the poses of a motion:
 *               show_residuals
 *   curves      [{title, x, x_unit, y, y_unit, log, series: [{name, dashed, x, y, half}]}]
 *   tables      [{title, columns: [...], rows: [[...], ...]}]
 *   images      [{title, data}]  SVG
 *   texts       [{title, text}]
 *
 * Numbers in bulk are base64 of what processors of today have in memory, little endian: {name,
 * unit, kind, data}, of kind f4 (float), i2 (int16 k for low + (high - low) (k + 32767)/65534,
 * -32768: not a number) or all equal ("value" in place of data). */
#ifndef TOOLS_PROGRAMS_SHOW_H
#define TOOLS_PROGRAMS_SHOW_H

#include "physics/scene/scene.h"
#include "tools/emit/export_module.h"
#include "tools/files/json.h"
#include "tools/files/table_shapes.h"

/* More frames or points are thinned out evenly. */
enum { SHOW_FRAMES_MAX = 401, SHOW_POINTS_MAX = 201 };

/* values [rows], where `stride` is how far apart those of one column are. */
void show_column(json *to, const char *name, const char *unit, const double *values, size_t rows,
                 bool rounded);

/* A column of curves, thinned out if there are very many rows: how many are kept. */
size_t show_thinned(json *to, const char *name, const double *values, size_t rows);

/* A curve of a chart: x and y [rows]. */
void show_series(json *to, const char *name, const double *x, const double *y, size_t rows);

/* What happens to the shapes of a table, frames and points thinned out; `labels` [frames], NULL:
 * none. The instants [*frames] and places [*points] that are kept, as rows of the table's first
 * block and first rows of blocks, are added to `kept` for show_scene, to be freed by the caller. */
typedef struct show_kept {
    size_t frames, points;
    size_t *frame, *point;
    double *s, *t; /* [points], [frames] */
} show_kept;

void show_kept_free(show_kept *kept);
ad_status show_motion(json *to, const table_source *table, const char *const *labels,
                      const table_source *reference, const char *reference_name, show_kept *kept,
                      ad_error *error);

/* All shapes of a table as "motion", with nothing but their places. */
ad_status show_poses(json *to, const table_source *table, ad_error *error);

/* A place over time, columns t, x, y, z, as a member of "paths". */
ad_status show_path(json *to, const char *name, const table_source *table, ad_error *error);
/* The value of q at s and t, of a family that of its member [parameter_count]; 0: it is not given.
 */
double show_value(const scene *of, const double *member, quantity q, double s, double t);

/* What a page computes for itself, by export_module.h; the list is to be freed. */
typedef struct show_drawn {
    export_drawn *list;
    int count, room;
} show_drawn;

/* Section, ends, loads, tendons, chambers and bodies of a scene at the kept instants; of a family
 * values [frames of the table][parameter_count], of any other scene NULL. What loads and actuators
 * do by formulas is added to `drawn`, unless NULL, and is the member "live" of its column. */
ad_status show_scene(json *to, const scene *of, const double *values, const show_kept *kept,
                     show_drawn *drawn, ad_error *error);

/* Files of tools/show as lines, ended by NULL. */
typedef const char *const show_lines[];
extern show_lines show_text_page, show_text_style, show_text_vectors, show_text_scene,
    show_text_draw, show_text_charts, show_text_live, show_text_workspace, show_text_loop,
    show_text_residuals, show_text_measured, show_text_picture, show_text_player, show_text_main;

/* Ends `to` and writes the page. AD_IO, AD_NO_MEMORY. */
ad_status show_page(json *to, const char *title, const char *path, ad_error *error);

#endif
