#include "tools/train/run_events.h"

#include "tools/files/event_file.h"
#include "tools/files/file_bytes.h"

#include <dirent.h>
#include <errno.h>
#include <stdlib.h>
#include <string.h>
#include <time.h>
#include <unistd.h>

#define NAME "events.out.tfevents."
#define END  ".cpinn"

enum { DIGITS = 10 };

void run_events_path(const char *folder, size_t first_row, char *path, size_t size)
{
    snprintf(path, size, "%s/" NAME "%0*zu" END, folder, DIGITS, first_row);
}

/* ---- files of earlier processes ------------------------------------------------------------ */

static int is_ours(const struct dirent *entry)
{
    const char *digits = entry->d_name + sizeof NAME - 1;
    return strncmp(entry->d_name, NAME, sizeof NAME - 1) == 0 &&
           strspn(digits, "0123456789") == DIGITS && strcmp(digits + DIGITS, END) == 0;
}

/* Cuts the file after its first `most` rows, or before what is damaged. */
static ad_status cut(const char *path, size_t most, size_t *kept, ad_error *error)
{
    unsigned char *bytes;
    size_t size, all, end;
    ad_status status = file_bytes_read(path, 0, &bytes, &size, &all, error);
    if (status != AD_OK) {
        return status;
    }
    const size_t records = events_records(bytes, size, EVENTS_BEGIN + most, &end);
    free(bytes);
    *kept = records > EVENTS_BEGIN ? records - EVENTS_BEGIN : 0;
    return end == size || truncate(path, (off_t)end) == 0
               ? AD_OK
               : ad_fail(error, AD_NOT_WRITTEN, "%s: %s", file_bytes_shown(path), strerror(errno));
}

/* Files by their first rows, one behind the other up to row `count`; those that are not among them
 * go. */
static ad_status keep_rows(const char *folder, size_t count, size_t *kept, ad_error *error)
{
    struct dirent **found = NULL;
    const int files = scandir(folder, &found, is_ours, alphasort);
    ad_status status =
        files >= 0 ? AD_OK
                   : ad_fail(error, AD_IO, "%s: %s", file_bytes_shown(folder), strerror(errno));
    *kept = 0;
    for (int i = 0; i < files; i++) {
        char path[4200];
        size_t rows = 0;
        const size_t first = strtoull(found[i]->d_name + sizeof NAME - 1, NULL, 10);
        run_events_path(folder, first, path, sizeof path);
        if (status == AD_OK && first == *kept && first < count) {
            status = cut(path, count - first, &rows, error);
            *kept += rows;
        } else if (status == AD_OK && unlink(path) != 0) {
            status =
                ad_fail(error, AD_NOT_WRITTEN, "%s: %s", file_bytes_shown(path), strerror(errno));
        }
        free(found[i]);
    }
    free(found);
    return status;
}

/* ---- rows ---------------------------------------------------------------------------------- */

static double wall_time(void)
{
    struct timespec now;
    clock_gettime(CLOCK_REALTIME, &now);
    return (double)now.tv_sec + 1e-9 * (double)now.tv_nsec;
}

/* The first column is the step. */
static void write_row(FILE *file, const history *h, size_t row, double wall)
{
    const double *values = h->rows + row * (size_t)h->columns;
    events_scalars(file, wall, (int64_t)values[0], h->columns - 1, h->names + 1, values + 1);
}

static ad_status flush(FILE *file, ad_error *error)
{
    return fflush(file) == 0 && !ferror(file)
               ? AD_OK
               : ad_fail(error, AD_NOT_WRITTEN, NAME "*" END ": %s", strerror(errno));
}

ad_status run_events_begin(const char *folder, const history *h, FILE **result, ad_error *error)
{
    char path[4200];
    size_t kept;
    *result = NULL;
    ad_status status = keep_rows(folder, h->count, &kept, error);
    if (status != AD_OK) {
        return status;
    }
    run_events_path(folder, kept, path, sizeof path);
    FILE *file = fopen(path, "w");
    if (!file) {
        return ad_fail(error, AD_IO, "%s: %s", file_bytes_shown(path), strerror(errno));
    }
    const double wall = wall_time();
    events_begin(file, wall,
                 kept ? (int64_t)h->rows[(kept - 1) * (size_t)h->columns] + 1 : (int64_t)0);
    for (size_t row = kept; row < h->count; row++) { /* as if it had not stopped in between */
        write_row(file, h, row,
                  wall + history_value(h, row, "seconds") -
                      history_value(h, h->count - 1, "seconds"));
    }
    status = flush(file, error);
    if (status != AD_OK) {
        fclose(file);
        return status;
    }
    *result = file;
    return AD_OK;
}

ad_status run_events_append(FILE *file, const history *h, size_t row, ad_error *error)
{
    write_row(file, h, row, wall_time());
    return flush(file, error);
}
