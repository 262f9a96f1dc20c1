/* cpinn-show: closed loops, and folders of tables and pictures. */
#include "tools/files/file_bytes.h"
#include "tools/programs/show_source.h"

#include <dirent.h>
#include <math.h>
#include <stdlib.h>
#include <string.h>

/* ---- closed loops -------------------------------------------------------------------------- */

static void put_named(showing *x, const table_source *table, const char *title,
                      const char *beginning)
{
    const double *t = table_source_column(table, "t");
    show_open_curve(&x->to, title, "t", "s", "", false);
    for (size_t k = 0; k < table->ncols; k++) {
        if (strncmp(table->names[k], beginning, strlen(beginning)) == 0) {
            show_series(&x->to, table->names[k] + strlen(beginning), t, table->columns[k],
                        table->nrows);
        }
    }
    show_close_curve(&x->to);
}

/* Distances of the true place from that which is wanted [nrows]. */
static void distances(const table_source *table, double *off)
{
    static const char *const names[][2] = {
        {"reference_x", "true_x"}, {"reference_y", "true_y"}, {"reference_z", "true_z"}};
    memset(off, 0, table->nrows * sizeof *off);
    for (int k = 0; k < 3; k++) {
        const double *wanted = table_source_column(table, names[k][0]);
        const double *found = table_source_column(table, names[k][1]);
        for (size_t i = 0; i < table->nrows; i++) {
            off[i] = hypot(off[i], found[i] - wanted[i]);
        }
    }
}

/* The columns t, and x, y, z by other names. */
static table_source path_of(const table_source *table, const char *kind, const double *columns[4])
{
    static const char *const names[] = {"t", "x", "y", "z"}, *const units[] = {"s", "m", "m", "m"};
    columns[0] = table_source_column(table, "t");
    for (int k = 0; k < 3; k++) {
        char name[32];
        snprintf(name, sizeof name, "%s_%c", kind, "xyz"[k]);
        columns[1 + k] = table_source_column(table, name);
    }
    return (table_source){
        .names = names, .columns = columns, .ncols = 4, .nrows = table->nrows, .units = units};
}

ad_status show_loop(showing *x, const table_source *table, ad_error *error)
{
    const double *wanted[4], *found[4];
    const table_source path = path_of(table, "true", found);
    const table_source ghost = path_of(table, "reference", wanted);
    double *off = malloc(table->nrows * sizeof *off + 1), square = 0, most = 0;
    for (int k = 0; k < 4; k++) {
        if (!found[k] || !wanted[k] || !off) {
            free(off);
            return ad_fail(error, off ? AD_BAD_INPUT : AD_NO_MEMORY,
                           "%s: needs columns t, reference_x to _z and true_x to _z", x->source);
        }
    }
    distances(table, off);
    for (size_t i = 0; i < table->nrows; i++) {
        square += off[i] * off[i] / (double)table->nrows;
        most = fmax(most, off[i]);
    }
    json_open(&x->to, "facts", '[');
    show_fact(&x->to, "duration", "%g s", found[0][table->nrows - 1]);
    show_fact(&x->to, "off the path, rms, approach included", "%.3g mm", 1e3 * sqrt(square));
    show_fact(&x->to, "at most", "%.3g mm", 1e3 * most);
    json_close(&x->to, ']');
    json_open(&x->to, "curves", '[');
    show_open_curve(&x->to, "Distance from the path", "t", "s", "m", true);
    show_series(&x->to, "distance", found[0], off, table->nrows);
    show_close_curve(&x->to);
    put_named(x, table, "Inputs", "input_");
    put_named(x, table, "Estimates", "estimate_");
    json_close(&x->to, ']');
    free(off);
    x->wanted = &ghost;
    return show_put_motion(x, &path, NULL, &ghost, "wanted path", error);
}

/* ---- folders ------------------------------------------------------------------------------- */

enum { ROWS_MAX = 400, FILES_MAX = 400 };

static bool is_kind(const char *name, const char *ending)
{
    const char *dot = strrchr(name, '.');
    return dot && strcmp(dot, ending) == 0;
}

/* Fields between commas; changes the text. */
static void put_row(json *to, char *line)
{
    json_open(to, NULL, '[');
    for (char *field = line, *end; field; field = end) {
        end = strchr(field, ',');
        if (end) {
            *end++ = '\0';
        }
        json_text(to, NULL, field);
    }
    json_close(to, ']');
}

static void put_csv(json *to, const char *name, char *text)
{
    int rows = 0;
    char *rest = NULL;
    json_open(to, NULL, '{');
    json_text(to, "title", name);
    json_open(to, "rows", '[');
    for (char *line = strtok_r(text, "\r\n", &rest); line && rows < ROWS_MAX;
         line = strtok_r(NULL, "\r\n", &rest)) {
        if (*line != '#') {
            put_row(to, line);
            rows++;
        }
    }
    json_close(to, ']');
    json_text(to, "cut", rest && *rest ? "yes" : NULL);
    json_close(to, '}');
}

static int by_name(const void *a, const void *b)
{
    return strcmp(*(char *const *)a, *(char *const *)b);
}

/* Names of the files with one of the endings, sorted; to be freed one by one. */
static int list_files(const char *folder, const char *ending, char *names[FILES_MAX])
{
    int count = 0;
    DIR *directory = opendir(folder);
    for (struct dirent *entry; directory && count < FILES_MAX && (entry = readdir(directory));) {
        if (is_kind(entry->d_name, ending) && (names[count] = strdup(entry->d_name))) {
            count++;
        }
    }
    if (directory) {
        closedir(directory);
    }
    qsort(names, (size_t)count, sizeof *names, by_name);
    return count;
}

static int put_files(showing *x, const char *key, const char *ending)
{
    char *names[FILES_MAX], path[4400];
    const int count = list_files(x->source, ending, names);
    json_open(&x->to, key, '[');
    for (int i = 0; i < count; i++) {
        unsigned char *bytes = NULL;
        size_t size, length;
        ad_error why;
        snprintf(path, sizeof path, "%.4000s/%.300s", x->source, names[i]);
        if (file_bytes_read(path, 0, &bytes, &size, &length, &why) != AD_OK) {
            cli_warn("cpinn-show", "%s", why.message);
        } else if (strcmp(ending, ".csv") == 0) {
            put_csv(&x->to, names[i], (char *)bytes);
        } else {
            json_open(&x->to, NULL, '{');
            json_text(&x->to, "title", names[i]);
            json_bytes(&x->to, "data", bytes, size);
            json_close(&x->to, '}');
        }
        free(bytes);
        free(names[i]);
    }
    json_close(&x->to, ']');
    return count;
}

ad_status show_folder(showing *x, ad_error *error)
{
    show_title_of(x, x->source);
    const int tables = put_files(x, "tables", ".csv");
    const int images = put_files(x, "images", ".svg");
    return tables + images > 0
               ? AD_OK
               : ad_fail(error, AD_BAD_INPUT,
                         "%s: there is nothing to show; allowed: a folder with checkpoint.h5, .csv "
                         "or .svg",
                         file_bytes_shown(x->source));
}
