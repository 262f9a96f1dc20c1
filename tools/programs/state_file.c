#include "tools/programs/state_file.h"

#include "tools/files/file_bytes.h"
#include "tools/files/table_file.h"
#include "tools/programs/samples.h"

#include <math.h>
#include <stdlib.h>

/* Of the length: rows may begin and end so far off. */
static const double AT_END = 1e-6;

enum { LEAST = 6, PLACES = 201, NUMBERS = 13 };

static const char *const columns[NUMBERS] = {"x",  "y",  "z",  "qw", "qx", "qy", "qz",
                                             "vx", "vy", "vz", "w1", "w2", "w3"};
enum { NEEDED = 7 }; /* of these */

/* Rows of the last instant. */
static void list_rows(const table_file *table, size_t *first, size_t *count)
{
    const double *t = table_column(table, "t");
    const size_t rows = table_rows(table);
    double last = -INFINITY;
    *first = 0;
    for (size_t i = 0; t && i < rows; i++) {
        *first = t[i] > last ? i : *first;
        last = fmax(last, t[i]);
    }
    *count = 0;
    while (*first + *count < rows && (!t || t[*first + *count] == last)) {
        ++*count;
    }
}

static ad_status check_places(const char *path, double length, size_t count, const solve_seen *seen,
                              ad_error *error)
{
    bool ascends = count >= LEAST && fabs(seen[0].s) <= AT_END * length &&
                   fabs(seen[count - 1].s - length) <= AT_END * length;
    for (size_t i = 1; i < count; i++) {
        ascends = ascends && seen[i].s > seen[i - 1].s;
    }
    return ascends
               ? AD_OK
               : ad_fail(error, AD_BAD_INPUT,
                         "%s: s of the %zu rows of its last instant; allowed: %d rows at least, "
                         "ascending from 0 to the length %g m",
                         file_bytes_shown(path), count, LEAST, length);
}

ad_status state_file_read(const char *path, double length, solve_seen **seen, size_t *count,
                          ad_error *error)
{
    table_file *table = NULL;
    size_t first = 0;
    ad_status status = table_read(path, TABLE_FINITE, &table, error);
    *seen = NULL;
    for (int k = 0; k <= NEEDED && status == AD_OK; k++) {
        const char *name = k < NEEDED ? columns[k] : "s";
        if (!table_column(table, name)) {
            status = ad_fail(error, AD_BAD_INPUT,
                             "%s: has no column %s; allowed: s, x to z, qw to qz and perhaps t, vx "
                             "to vz, w1 to w3",
                             file_bytes_shown(path), name);
        }
    }
    if (status == AD_OK) {
        list_rows(table, &first, count);
        *seen = calloc(*count + 1, sizeof **seen);
        status = *seen ? AD_OK : ad_fail(error, AD_NO_MEMORY, "out of memory for a state");
    }
    for (size_t i = 0; i < *count && status == AD_OK; i++) {
        double *to = &(*seen)[i].position[0];
        (*seen)[i].s = table_column(table, "s")[first + i];
        for (int k = 0; k < NUMBERS; k++) {
            const double *from = table_column(table, columns[k]);
            to[k] = from ? from[first + i] : 0;
        }
    }
    status = status == AD_OK ? check_places(path, length, *count, *seen, error) : status;
    table_free(table);
    if (status != AD_OK) {
        free(*seen);
        *seen = NULL;
    }
    return status;
}

ad_status state_file_write(const char *path, const solution *solved, const scene *rod_scene,
                           double t, ad_error *error)
{
    samples all = {.count = 0};
    const answer found = answer_of_solution(solved, rod_scene);
    ad_status status = samples_make(&all, PLACES, error);
    for (int i = 0; i < PLACES && status == AD_OK; i++) {
        all.s[i] = scene_length(rod_scene) * i / (PLACES - 1);
        all.t[i] = t;
    }
    status = status == AD_OK ? samples_ask(&all, &found, error) : status;
    status = status == AD_OK ? samples_write(&all, path, error) : status;
    samples_free(&all);
    return status;
}

_Static_assert(sizeof(solve_seen) == (1 + NUMBERS) * sizeof(double), "columns in their order");
