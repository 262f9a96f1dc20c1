#include "tools/train/run.h"

#include "tools/files/file_bytes.h"

#include <errno.h>
#include <fcntl.h>
#include <stdlib.h>
#include <string.h>
#include <sys/file.h>
#include <sys/stat.h>
#include <unistd.h>

ad_status run_name(run_folder *run, const char *path, ad_error *error)
{
    *run = (run_folder){.rows = NULL};
    size_t length = strlen(path);
    while (length > 1 && path[length - 1] == '/') {
        length--;
    }
    if (length == 0 || length >= sizeof run->path) {
        return ad_fail(error, AD_BAD_INPUT,
                       "the folder of the run: a path of %zu bytes; 1 to %zu are allowed", length,
                       sizeof run->path - 1);
    }
    memcpy(run->path, path, length);
    snprintf(run->checkpoint, sizeof run->checkpoint, "%s/checkpoint.h5", run->path);
    snprintf(run->history, sizeof run->history, "%s/history.csv", run->path);
    snprintf(run->config, sizeof run->config, "%s/config.yaml", run->path);
    return AD_OK;
}

ad_status run_open_checkpoint(const char *path, char found[4096], checkpoint **file,
                              ad_error *error)
{
    struct stat info;
    bool folder = stat(path, &info) == 0 && S_ISDIR(info.st_mode);
    int length = snprintf(found, 4096, "%s%s", path, folder ? "/checkpoint.h5" : "");
    *file = NULL;
    if (length < 0 || length >= 4096) {
        return ad_fail(error, AD_BAD_ARGUMENT, "%.200s...: the path is too long", path);
    }
    return checkpoint_open(found, file, error);
}

ad_status run_check_new(const run_folder *run, ad_error *error)
{
    const char *const files[] = {run->checkpoint, run->history, run->config};
    for (size_t i = 0; i < sizeof files / sizeof *files; i++) {
        if (access(files[i], F_OK) == 0) {
            return ad_fail(error, AD_BAD_INPUT,
                           "%s: there is a run already (%s); resume it, or choose another folder",
                           file_bytes_shown(run->path), strrchr(files[i], '/') + 1);
        }
    }
    return AD_OK;
}

static ad_status make_folders(const char *path, mode_t mode, ad_error *error)
{
    char part[4000];
    size_t length = strlen(path);
    for (size_t i = 1; i <= length; i++) {
        if (path[i] != '/' && path[i] != '\0') {
            continue;
        }
        memcpy(part, path, i);
        part[i] = '\0';
        if (mkdir(part, mode) != 0 && errno != EEXIST) {
            return ad_fail(error, AD_IO, "%s: the folder cannot be made: %s",
                           file_bytes_shown(part), strerror(errno));
        }
    }
    struct stat info;
    if (stat(path, &info) != 0 || !S_ISDIR(info.st_mode)) {
        return ad_fail(error, AD_IO, "%s: is not a folder; choose another", file_bytes_shown(path));
    }
    return AD_OK;
}

ad_status run_make_folder(const char *path, ad_error *error)
{
    return make_folders(path, 0777, error);
}

/* Whether another process has this file. */
static bool is_taken(int file)
{
    return file >= 0 && flock(file, LOCK_EX | LOCK_NB) != 0 && errno == EWOULDBLOCK;
}

ad_status run_lock(run_folder *run, bool resume, ad_error *error)
{
    char path[4096];
    if (resume && access(run->checkpoint, F_OK) != 0) {
        return AD_OK; /* there is no run */
    }
    snprintf(path, sizeof path, "%s/lock", run->path);
    run->held = open(run->path, O_RDONLY | O_CLOEXEC | O_DIRECTORY);
    run->lock = open(path, O_RDWR | O_CREAT | O_CLOEXEC | O_NOFOLLOW, 0666);
    if (run->lock < 0) {
        ad_fail(error, AD_IO, "%s: %s; the folder of a run must be writable",
                file_bytes_shown(path), strerror(errno));
        run_end(run);
        return AD_IO;
    }
    if (is_taken(run->held) || is_taken(run->lock)) {
        run_end(run);
        return ad_fail(error, AD_BAD_INPUT,
                       "%s: in use by another process; wait for it, or choose another folder",
                       file_bytes_shown(run->path));
    }
    return AD_OK;
}

ad_status run_check_held(const run_folder *run, ad_error *error)
{
    struct stat held, named;
    if (run->held <= 0 || fstat(run->held, &held) != 0 ||
        (stat(run->path, &named) == 0 && held.st_dev == named.st_dev &&
         held.st_ino == named.st_ino)) {
        return AD_OK;
    }
    return ad_fail(error, AD_NOT_WRITTEN,
                   "%s: is no longer the folder that this run began in; nothing more is written",
                   file_bytes_shown(run->path));
}

/* A path that is not absolute does not count, and folders are the user's alone, says the
 * specification. */
bool run_cache_folder(char *path, size_t room, bool make)
{
    const char *cache = getenv("XDG_CACHE_HOME"), *home = getenv("HOME");
    bool given = cache && *cache == '/';
    if (!given && (!home || *home != '/')) {
        return false;
    }
    int length = snprintf(path, room, "%s%s/cpinn", given ? cache : home, given ? "" : "/.cache");
    return length > 0 && (size_t)length < room &&
           (!make || make_folders(path, 0700, NULL) == AD_OK);
}

/* Header and rows so far as one file; what an interrupted process wrote beyond the checkpoint goes.
 */
static ad_status write_history(const run_folder *run, const history *h, ad_error *error)
{
    char *text = NULL;
    size_t size = 0;
    FILE *file = open_memstream(&text, &size);
    if (!file) {
        return ad_fail(error, AD_NO_MEMORY, "out of memory for %s", run->history);
    }
    history_print(h, -1, file);
    for (size_t row = 0; row < h->count; row++) {
        history_print(h, (long)row, file);
    }
    if (fclose(file) != 0) {
        free(text);
        return ad_fail(error, AD_NO_MEMORY, "out of memory for %s", run->history);
    }
    ad_status status = file_bytes_write(run->history, text, size, error);
    free(text);
    return status;
}

ad_status run_begin(run_folder *run, const char *config, const history *h, ad_error *error)
{
    ad_status status = file_bytes_write(run->config, config, strlen(config), error);
    if (status == AD_OK) {
        status = write_history(run, h, error);
    }
    if (status == AD_OK) {
        run->rows = fopen(run->history, "a");
        run->rows_written = h->count;
        if (!run->rows) {
            return ad_fail(error, errno == ENOMEM ? AD_NO_MEMORY : AD_IO, "%s: %s", run->history,
                           strerror(errno));
        }
    }
    return status;
}

ad_status run_append(run_folder *run, const history *h, ad_error *error)
{
    if (run->rows_written == h->count) {
        return AD_OK;
    }
    while (run->rows_written < h->count) {
        history_print(h, (long)run->rows_written, run->rows);
        run->rows_written++;
    }
    return fflush(run->rows) == 0 && !ferror(run->rows)
               ? AD_OK
               : ad_fail(error, AD_NOT_WRITTEN, "%s: %s", run->history, strerror(errno));
}

void run_end(run_folder *run)
{
    int *const files[] = {&run->held, &run->lock};
    for (size_t i = 0; i < sizeof files / sizeof *files; i++) {
        if (*files[i] > 0) {
            close(*files[i]);
        }
        *files[i] = 0;
    }
    if (run->rows) {
        fclose(run->rows);
        run->rows = NULL;
    }
}
