/* cpinn-show: a folder of tables and pictures. */
#include "tools/files/file_bytes.h"
#include "tools/programs/show_source.h"

#include <dirent.h>
#include <stdlib.h>
#include <string.h>

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

ad_status show_csv(showing *showing, ad_error *error)
{
    unsigned char *bytes = NULL;
    size_t size, length;
    const ad_status status = file_bytes_read(showing->source, 0, &bytes, &size, &length, error);
    if (status == AD_OK) {
        json_open(&showing->to, "tables", '[');
        put_csv(&showing->to, showing->title, (char *)bytes);
        json_close(&showing->to, ']');
    }
    free(bytes);
    return status;
}

static void put_curves(json *to, const table_source *table)
{
    enum { CURVES_MAX = 12 };
    bool ascends = table->nrows > 1;
    for (size_t i = 1; i < table->nrows && ascends; i++) {
        ascends = table->columns[0][i] > table->columns[0][i - 1];
    }
    json_open(to, "curves", '[');
    for (size_t k = 1; k < table->ncols && k <= CURVES_MAX && ascends; k++) {
        show_open_curve(to, table->names[k], table->names[0], table->units[0], table->units[k],
                        false);
        show_series(to, table->names[k], table->columns[0], table->columns[k], table->nrows);
        show_close_curve(to);
    }
    json_close(to, ']');
}

ad_status show_numbers(showing *showing, const table_source *table, ad_error *error)
{
    json *to = &showing->to;
    if (table->nrows == 0) {
        return ad_fail(error, AD_BAD_INPUT, "%s: there are no rows to be shown", showing->source);
    }
    put_curves(to, table);
    json_open(to, "tables", '[');
    json_open(to, NULL, '{');
    json_text(to, "title", showing->title);
    json_open(to, "rows", '[');
    for (size_t i = 0; i <= table->nrows && i <= ROWS_MAX; i++) {
        json_open(to, NULL, '[');
        for (size_t k = 0; k < table->ncols; k++) {
            char text[32];
            snprintf(text, sizeof text, "%.7g", i > 0 ? table->columns[k][i - 1] : 0);
            json_text(to, NULL, i > 0 ? text : table->names[k]);
        }
        json_close(to, ']');
    }
    json_close(to, ']');
    json_text(to, "cut", table->nrows > ROWS_MAX ? "yes" : NULL);
    json_close(to, '}');
    json_close(to, ']');
    return AD_OK;
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

static int put_files(showing *showing, const char *key, const char *ending)
{
    char *names[FILES_MAX], path[4400];
    const int count = list_files(showing->source, ending, names);
    json_open(&showing->to, key, '[');
    for (int i = 0; i < count; i++) {
        unsigned char *bytes = NULL;
        size_t size, length;
        ad_error why;
        snprintf(path, sizeof path, "%.4000s/%.300s", showing->source, names[i]);
        if (file_bytes_read(path, 0, &bytes, &size, &length, &why) != AD_OK) {
            cli_warn("cpinn-show", "%s", why.message);
        } else if (strcmp(ending, ".csv") == 0) {
            put_csv(&showing->to, names[i], (char *)bytes);
        } else {
            json_open(&showing->to, NULL, '{');
            json_text(&showing->to, "title", names[i]);
            json_bytes(&showing->to, "data", bytes, size);
            json_close(&showing->to, '}');
        }
        free(bytes);
        free(names[i]);
    }
    json_close(&showing->to, ']');
    return count;
}

ad_status show_folder(showing *showing, ad_error *error)
{
    show_title_of(showing, showing->source);
    const int tables = put_files(showing, "tables", ".csv");
    const int images = put_files(showing, "images", ".svg");
    return tables + images > 0
               ? AD_OK
               : ad_fail(error, AD_BAD_INPUT,
                         "%s: there is nothing to show; allowed: a folder with checkpoint.h5, .csv "
                         "or .svg",
                         file_bytes_shown(showing->source));
}
