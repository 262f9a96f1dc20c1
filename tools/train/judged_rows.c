#include "tools/train/judged_rows.h"

#include "autodiff/memory.h"
#include "physics/numerics/vector_size.h"
#include "tools/files/file_bytes.h"

#include <ctype.h>
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

enum { PLACE = 3, NAME = 48 };

struct judged_rows {
    table_build table, shapes;
    char (*file)[TABLE_MAX_NAME + 1]; /* [sets] */
    const char **words;               /* file, judged of each row */
    double *room;
    char names[2 * MODEL_COLUMNS_MAX][NAME];
    ad_memory memory;
};

/* Rows being filled: column c of the model stands in 2 c and 2 c + 1. */
typedef struct filling {
    const judged_found *of;
    judged_rows *to;
    size_t rows, row;
    double *data, *pose, *marker, *s, *t, *distance, *deviation; /* [rows] each */
    double *places;                                              /* [2 PLACE][rows] in the scene */
    double *known;                                               /* [parameters][rows] */
    double *columns; /* [2 columns of the model][rows] */
    bool used[MODEL_COLUMNS_MAX], is_framed;
} filling;

enum { SINGLE = 7 };

void measured_rows_free(judged_rows *rows)
{
    if (rows) {
        ad_memory_free(&rows->memory);
        free(rows);
    }
}

const table_source *measured_rows_table(const judged_rows *rows)
{
    return &rows->table.table;
}

const table_source *measured_rows_shapes(const judged_rows *rows)
{
    return &rows->shapes.table;
}

/* ---- rows ---------------------------------------------------------------------------------- */

/* What was measured and what is computed, as they are seen, in the axes of the scene. */
static void put_places(const filling *to, const solve_measured *set, size_t row,
                       const scene_seen *seen, const double *parameters)
{
    for (int side = 0; side < 2; side++) {
        double place[PLACE];
        for (int k = 0; k < PLACE; k++) {
            place[k] = to->columns[(size_t)(2 * k + side) * to->rows + to->row];
        }
        if (set->view) {
            scene_seen_place(seen, set->s[row], set->t[row], parameters, place);
        }
        for (int k = 0; k < PLACE; k++) {
            to->places[(size_t)(PLACE * side + k) * to->rows + to->row] = place[k];
        }
    }
}

/* Columns of a row; returns how many residuals it has. */
static size_t put_columns(filling *to, const solve_measured *set, size_t row,
                          const double *residuals)
{
    const size_t count = solve_measured_residuals(to->of->open, set, row);
    const double *r = residuals;
    for (int c = 0; c < set->columns; c++) {
        const size_t at = 2 * (size_t)set->column[c] * to->rows + to->row;
        const double measured = set->values[(size_t)c * set->rows + row];
        const bool is_told = set->columns != 4 && !isnan(measured);
        to->columns[at] = measured;
        to->columns[at + to->rows] = is_told ? measured + *r++ * set->noise[c] : NAN;
        to->used[set->column[c]] = true;
    }
    to->distance[to->row] = set->noise[0] * sqrt(vector_square(count, residuals));
    return count;
}

static void put_set(filling *to, int which, const double **residuals)
{
    const judged_found *of = to->of;
    const solve_measured *set = &of->sets[which];
    const size_t parameters = (size_t)of->open->parameter_count;
    const bool is_place = set->column[0] == 0 && set->columns == PLACE;
    double values[SCENE_PARAMETERS_MAX];
    scene_seen seen = {.count = 0};
    if (set->view) {
        scene_seen_prepare(set->view, of->open, &seen);
    }
    to->is_framed = to->is_framed || (is_place && seen.sees_frame);
    for (size_t row = 0; row < set->rows; row++, to->row++) {
        to->to->words[to->row] = to->to->file[which];
        to->to->words[to->rows + to->row] = measured_how(of->open, which >= of->fitted);
        to->data[to->row] = measurements_entry(of->data, which);
        to->pose[to->row] = (double)of->poses->pose[to->row] + 1;
        to->marker[to->row] = (double)of->poses->marker[to->row];
        measured_row_parameters(of->open, set, row, of->values, values);
        to->s[to->row] = scene_place_at(of->open, values, set->s[row], 0);
        to->t[to->row] = set->t[row];
        to->deviation[to->row] = of->deviation * set->noise[0];
        for (size_t i = 0; i < parameters; i++) {
            to->known[i * to->rows + to->row] = set->known[row * parameters + i];
        }
        *residuals += put_columns(to, set, row, *residuals);
        if (is_place) {
            put_places(to, set, row, &seen, values);
        }
    }
}

static void add_columns(filling *from)
{
    static const char *const beside[] = {"x_in_scene",          "y_in_scene",
                                         "z_in_scene",          "x_computed_in_scene",
                                         "y_computed_in_scene", "z_computed_in_scene"};
    const scene *open = from->of->open;
    const scene_physics *physics = scene_physics_of(open);
    table_build *to = &from->to->table;
    table_add(to, "file", NULL, NULL, from->to->words);
    table_add(to, "data", NULL, from->data, NULL);
    table_add(to, "judged", NULL, NULL, from->to->words + from->rows);
    table_add(to, "pose", NULL, from->pose, NULL);
    table_add(to, "marker", NULL, from->marker, NULL);
    table_add(to, "s", NULL, from->s, NULL);
    if (scene_is_dynamic(open)) {
        table_add(to, "t", NULL, from->t, NULL);
    }
    for (int i = 0; i < scene_given_count(open); i++) {
        table_add(to, open->parameters[i].name, NULL, from->known + (size_t)i * from->rows, NULL);
    }
    for (int c = 0; c < physics->column_count; c++) {
        const double *values = from->columns + 2 * (size_t)c * from->rows;
        char *computed = from->to->names[c];
        snprintf(computed, NAME, "%.30s_computed", physics->columns[c].name);
        if (from->used[c]) {
            table_add(to, physics->columns[c].name, NULL, values, NULL);
            table_add(to, computed, NULL, values + from->rows, NULL);
        }
    }
    for (int k = 0; k < 2 * PLACE && from->is_framed; k++) {
        table_add(to, beside[k], NULL, from->places + (size_t)k * from->rows, NULL);
    }
    table_add(to, "distance", NULL, from->distance, NULL);
    table_add(to, "deviation", NULL, from->deviation, NULL);
}

/* ---- shapes -------------------------------------------------------------------------------- */

/* residuals: [shapes points][columns], which are the places. */
static void put_shapes(const judged_found *of, judged_rows *to, double *room,
                       const double *residuals)
{
    const measured_poses *poses = of->poses;
    const scene_physics *physics = scene_physics_of(of->open);
    const size_t rows = poses->shapes * poses->points, columns = (size_t)physics->position_columns;
    for (size_t i = 0; i < rows; i++) {
        room[i] = (double)poses->shape[i / poses->points] + 1;
        room[rows + i] = poses->numbers[i];
        for (size_t c = 0; c < columns; c++) {
            room[(2 + c) * rows + i] = residuals[i * columns + c];
        }
    }
    table_begin(&to->shapes, rows);
    table_add(&to->shapes, "member", "", room, NULL);
    table_add(&to->shapes, "s", "m", room + rows, NULL);
    for (size_t c = 0; c < columns; c++) {
        table_add(&to->shapes, physics->columns[c].name, physics->columns[c].unit,
                  room + (2 + c) * rows, NULL);
    }
}

/* ---- all ----------------------------------------------------------------------------------- */

/* The name of a file as a word of a table has it. */
static void name_file(const char *path, char name[TABLE_MAX_NAME + 1])
{
    snprintf(name, TABLE_MAX_NAME + 1, "%.*s", TABLE_MAX_NAME, file_bytes_name(path));
    for (char *c = name; *c; c++) {
        *c = strchr(",\"#", *c) || iscntrl((unsigned char)*c) ? '_' : *c;
    }
}

static ad_status make_room(filling *f, size_t *spare, ad_error *error)
{
    const judged_found *of = f->of;
    const size_t wide = 2 * (size_t)scene_physics_of(of->open)->column_count;
    const size_t each = SINGLE + 2 * PLACE + (size_t)of->open->parameter_count + wide;
    const size_t shapes = of->poses->shapes * of->poses->points * (2 + PLACE);
    judged_rows *to = f->to;
    *spare = each * f->rows;
    AD_TAKE(to, room, *spare + shapes + 1);
    AD_TAKE(to, words, 2 * f->rows + 1);
    AD_TAKE(to, file, (size_t)of->count + 1);
    if (to->memory.is_short) {
        return ad_fail(error, AD_NO_MEMORY, "out of memory for %zu rows", f->rows);
    }
    for (size_t i = 0; i < *spare; i++) {
        to->room[i] = NAN;
    }
    double **const single[SINGLE] = {&f->data, &f->pose,     &f->marker,   &f->s,
                                     &f->t,    &f->distance, &f->deviation};
    for (size_t k = 0; k < SINGLE; k++) {
        *single[k] = to->room + k * f->rows;
    }
    f->places = to->room + SINGLE * f->rows;
    f->known = f->places + (size_t)(2 * PLACE) * f->rows;
    f->columns = f->known + (size_t)of->open->parameter_count * f->rows;
    return AD_OK;
}

ad_status measured_rows_create(const judged_found *found, const double *residuals,
                               judged_rows **result, ad_error *error)
{
    filling f = {.of = found, .rows = found->poses->rows};
    size_t spare = 0;
    *result = f.to = calloc(1, sizeof *f.to);
    ad_status status = f.to ? make_room(&f, &spare, error)
                            : ad_fail(error, AD_NO_MEMORY, "out of memory for rows");
    if (status != AD_OK) {
        measured_rows_free(f.to);
        *result = NULL;
        return status;
    }
    for (int i = 0; i < found->count; i++) {
        name_file(found->settings->data[measurements_entry(found->data, i)].file, f.to->file[i]);
        put_set(&f, i, &residuals);
    }
    table_begin(&f.to->table, f.rows);
    add_columns(&f);
    put_shapes(found, f.to, f.to->room + spare, residuals);
    return AD_OK;
}
