/* Shapes in a table as data of a page. */
#include "tools/programs/show.h"

#include <math.h>
#include <stdint.h>
#include <stdlib.h>
#include <string.h>

enum { CURVE_ROWS = 4000 };

/* ---- numbers ------------------------------------------------------------------------------- */

/* Finite numbers only; false: there are none. */
static bool range_of(const double *values, size_t rows, double *low, double *high)
{
    *low = INFINITY;
    *high = -INFINITY;
    for (size_t i = 0; i < rows; i++) {
        if (isfinite(values[i])) {
            *low = fmin(*low, values[i]);
            *high = fmax(*high, values[i]);
        }
    }
    return *low <= *high;
}

static void put_float(json *to, const double *values, size_t rows)
{
    float *numbers = malloc(rows * sizeof *numbers + 1);
    json_text(to, "kind", "f4");
    for (size_t i = 0; numbers && i < rows; i++) {
        numbers[i] = (float)values[i];
    }
    if (numbers) {
        json_bytes(to, "data", numbers, rows * sizeof *numbers);
    }
    free(numbers);
}

static void put_rounded(json *to, const double *values, size_t rows, double low, double high)
{
    int16_t *numbers = malloc(rows * sizeof *numbers + 1);
    json_text(to, "kind", "i2");
    json_number(to, "low", low);
    json_number(to, "high", high);
    for (size_t i = 0; numbers && i < rows; i++) {
        numbers[i] = isfinite(values[i])
                         ? (int16_t)(lround((values[i] - low) / (high - low) * 65534) - 32767)
                         : INT16_MIN;
    }
    if (numbers) {
        json_bytes(to, "data", numbers, rows * sizeof *numbers);
    }
    free(numbers);
}

void show_column(json *to, const char *name, const char *unit, const double *values, size_t rows,
                 bool rounded)
{
    double low, high;
    const bool any = range_of(values, rows, &low, &high);
    bool whole = any;
    for (size_t i = 0; whole && i < rows; i++) {
        whole = isfinite(values[i]);
    }
    json_open(to, NULL, '{');
    json_text(to, "name", name);
    json_text(to, "unit", unit);
    if (!any || (whole && low == high)) {
        json_number(to, "value", any ? low : NAN);
    } else if (rounded && low < high && isfinite(high - low)) {
        put_rounded(to, values, rows, low, high);
    } else {
        put_float(to, values, rows);
    }
    json_close(to, '}');
}

size_t show_thinned(json *to, const char *name, const double *values, size_t rows)
{
    const size_t kept = rows < CURVE_ROWS ? rows : CURVE_ROWS;
    double *few = malloc(kept * sizeof *few + 1);
    for (size_t i = 0; few && i < kept; i++) {
        few[i] = values[kept > 1 ? i * (rows - 1) / (kept - 1) : 0];
    }
    if (few) {
        show_column(to, name, "", few, kept, false);
    }
    free(few);
    return kept;
}

void show_series(json *to, const char *name, const double *x, const double *y, size_t rows)
{
    json_open(to, NULL, '{');
    json_text(to, "name", name);
    json_open(to, "columns", '[');
    show_thinned(to, "x", x, rows);
    const size_t kept = show_thinned(to, "y", y, rows);
    json_close(to, ']');
    json_integer(to, "rows", (int64_t)kept);
    json_close(to, '}');
}

/* ---- what is kept -------------------------------------------------------------------------- */

void show_kept_free(show_kept *kept)
{
    free(kept->frame);
    free(kept->point);
    free(kept->s);
    free(kept->t);
    memset(kept, 0, sizeof *kept);
}

/* Numbers from 0 to count - 1, the ends among them, at most `most` of them. */
static size_t *spread(size_t count, size_t most, size_t *kept)
{
    *kept = count < most ? count : most;
    size_t *which = malloc(*kept * sizeof *which + 1);
    for (size_t i = 0; which && i < *kept; i++) {
        which[i] = *kept > 1 ? i * (count - 1) / (*kept - 1) : 0;
    }
    return which;
}

/* At most so many frames and points. Without a column s, places are counted from 0 to 1. */
static ad_status keep(const table_shapes *from, size_t frames, size_t points, show_kept *kept,
                      ad_error *error)
{
    memset(kept, 0, sizeof *kept);
    kept->frame = spread(from->frames, frames, &kept->frames);
    kept->point = spread(from->points, points, &kept->points);
    kept->s = malloc(kept->points * sizeof *kept->s + 1);
    kept->t = malloc(kept->frames * sizeof *kept->t + 1);
    if (!kept->frame || !kept->point || !kept->s || !kept->t) {
        show_kept_free(kept);
        return ad_fail(error, AD_NO_MEMORY, "out of memory for a report");
    }
    for (size_t i = 0; i < kept->points; i++) {
        kept->s[i] = from->s            ? from->s[kept->point[i]]
                     : from->points > 1 ? (double)kept->point[i] / (double)(from->points - 1)
                                        : 0;
    }
    for (size_t i = 0; i < kept->frames; i++) {
        kept->t[i] = from->t ? from->t[kept->frame[i] * from->points] : (double)kept->frame[i];
    }
    return AD_OK;
}

/* ---- motions ------------------------------------------------------------------------------- */

static void put_kept(json *to, const char *name, const char *unit, const double *values,
                     const table_shapes *from, const show_kept *kept, bool rounded)
{
    const size_t rows = kept->frames * kept->points;
    double *few = malloc(rows * sizeof *few + 1);
    for (size_t i = 0; few && i < rows; i++) {
        few[i] =
            values[kept->frame[i / kept->points] * from->points + kept->point[i % kept->points]];
    }
    if (few) {
        show_column(to, name, unit, few, rows, rounded);
    }
    free(few);
}

static bool is_place(const char *name)
{
    return strlen(name) == 1 && strchr("xyzw", *name);
}

/* What no picture needs. */
static bool is_angular_velocity(const char *name)
{
    return strlen(name) == 2 && *name == 'w' && strchr("123", name[1]);
}

static void put_shapes(json *to, const table_source *table, const table_shapes *from,
                       const show_kept *kept, bool places_alone)
{
    json_integer(to, "frames", (int64_t)kept->frames);
    json_integer(to, "points", (int64_t)kept->points);
    json_integer(to, "frames_of", (int64_t)from->frames);
    json_integer(to, "points_of", (int64_t)from->points);
    json_open(to, "s", '[');
    show_column(to, "s", "m", kept->s, kept->points, false);
    json_close(to, ']');
    if (from->t) {
        json_open(to, "t", '[');
        show_column(to, "t", "s", kept->t, kept->frames, false);
        json_close(to, ']');
    }
    json_open(to, "columns", '[');
    for (size_t k = 0; k < table->ncols; k++) {
        const char *name = table->names[k];
        const double *values = table->columns[k];
        if ((places_alone && !is_place(name) && strcmp(name, "radius") != 0) || values == from->s ||
            values == from->t || values == from->member || is_angular_velocity(name) ||
            (table->words && table->words[k])) {
            continue;
        }
        put_kept(to, name, table->units ? table->units[k] : "", values, from, kept,
                 places_alone || !is_place(name));
    }
    json_close(to, ']');
}

ad_status show_motion(json *to, const table_source *table, const char *const *labels,
                      const table_source *reference, const char *reference_name, show_kept *kept,
                      ad_error *error)
{
    table_shapes from;
    show_kept other;
    memset(kept, 0, sizeof *kept);
    ad_status status = table_shapes_of(table, &from, error);
    double low, high;
    if (status == AD_OK && from.place[0] && !range_of(from.place[0], table->nrows, &low, &high)) {
        status = ad_fail(error, AD_BAD_INPUT, "no place is a finite number");
    }
    status = status == AD_OK ? keep(&from, SHOW_FRAMES_MAX, SHOW_POINTS_MAX, kept, error) : status;
    if (status != AD_OK) {
        return status;
    }
    json_open(to, "motion", '{');
    put_shapes(to, table, &from, kept, false);
    if (labels) {
        json_open(to, "labels", '[');
        for (size_t i = 0; i < kept->frames; i++) {
            json_text(to, NULL, labels[kept->frame[i]]);
        }
        json_close(to, ']');
    }
    if (reference && table_shapes_of(reference, &from, error) == AD_OK) {
        status = keep(&from, SHOW_FRAMES_MAX / 2, SHOW_POINTS_MAX / 2, &other, error);
        if (status == AD_OK) {
            json_open(to, "reference", '{');
            json_text(to, "name", reference_name);
            put_shapes(to, reference, &from, &other, true);
            json_close(to, '}');
            show_kept_free(&other);
        }
    }
    json_close(to, '}');
    return status;
}

ad_status show_poses(json *to, const table_source *table, ad_error *error)
{
    table_shapes from;
    show_kept kept;
    ad_status status = table_shapes_of(table, &from, error);
    status = status == AD_OK ? keep(&from, SIZE_MAX, SHOW_POINTS_MAX, &kept, error) : status;
    if (status == AD_OK) {
        json_open(to, "motion", '{');
        put_shapes(to, table, &from, &kept, true);
        json_close(to, '}');
        show_kept_free(&kept);
    }
    return status;
}

ad_status show_path(json *to, const char *name, const table_source *table, ad_error *error)
{
    enum { PATH_ROWS = 1000 };
    table_shapes from;
    show_kept kept;
    ad_status status = table_shapes_of(table, &from, error);
    status = status == AD_OK ? keep(&from, PATH_ROWS, 1, &kept, error) : status;
    if (status == AD_OK) {
        json_open(to, NULL, '{');
        json_text(to, "name", name);
        put_shapes(to, table, &from, &kept, true);
        json_close(to, '}');
        show_kept_free(&kept);
    }
    return status;
}
