#include "tools/files/file_bytes.h"

#include <errno.h>
#include <fcntl.h>
#include <stdbool.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/stat.h>
#include <unistd.h>

/* Longest part of a path put into a message, so that the reason behind it is not cut off. */
#define SHOWN_LENGTH 200

const char *file_bytes_shown(const char *path)
{
    size_t length = strlen(path);
    return length > SHOWN_LENGTH ? path + (length - SHOWN_LENGTH) : path;
}

const char *file_bytes_name(const char *path)
{
    const char *slash = strrchr(path, '/');
    return slash ? slash + 1 : path;
}

ad_status file_bytes_check(const char *path, ad_error *error)
{
    const char *slash = strrchr(path, '/');
    char *folder = slash ? strndup(path, (size_t)(slash - path) + 1) : strdup(".");
    if (!folder) {
        return ad_fail(error, AD_NO_MEMORY, "out of memory for the name of a folder");
    }
    ad_status status = access(folder, W_OK | X_OK) == 0
                           ? AD_OK
                           : ad_fail(error, AD_IO, "%s: no file can be written there: %s",
                                     file_bytes_shown(path), strerror(errno));
    free(folder);
    return status;
}

char *file_bytes_older(const char *path, int index)
{
    const char *dot = strrchr(file_bytes_name(path), '.');
    size_t stem = dot && dot > file_bytes_name(path) ? (size_t)(dot - path) : strlen(path);
    size_t size = strlen(path) + 16;
    char *older = malloc(size);
    if (older) {
        snprintf(older, size, "%.*s.%d%s", (int)stem, path, index, path + stem);
    }
    return older;
}

/* ---- reading ---- */

static ad_status read_fully(int file, unsigned char *bytes, size_t size, const char *path,
                            ad_error *error)
{
    size_t done = 0;
    while (done < size) {
        ssize_t got = read(file, bytes + done, size - done);
        if (got < 0 && errno == EINTR) {
            continue;
        }
        if (got < 0) {
            return ad_fail(error, AD_IO, "%s: cannot be read: %s", file_bytes_shown(path),
                           strerror(errno));
        }
        if (got == 0) {
            return ad_fail(error, AD_IO, "%s: became shorter while it was read; try again",
                           file_bytes_shown(path));
        }
        done += (size_t)got;
    }
    return AD_OK;
}

static ad_status read_open_file(int file, const char *path, size_t limit, unsigned char **bytes,
                                size_t *size, size_t *file_size, ad_error *error)
{
    const char *shown = file_bytes_shown(path);
    struct stat about;
    if (fstat(file, &about) != 0) {
        return ad_fail(error, AD_IO, "%s: cannot be read: %s", shown, strerror(errno));
    }
    if (S_ISDIR(about.st_mode)) {
        return ad_fail(error, AD_IO, "%s: is a directory; name a file", shown);
    }
    if (!S_ISREG(about.st_mode)) {
        return ad_fail(error, AD_IO, "%s: is not a regular file; name one", shown);
    }
    size_t wanted = (size_t)about.st_size;
    if (limit > 0 && wanted > limit) {
        wanted = limit;
    }
    unsigned char *read_bytes = malloc(wanted + 1);
    if (!read_bytes) {
        return ad_fail(error, AD_NO_MEMORY, "%s: no memory to read its %zu bytes", shown, wanted);
    }
    ad_status status = read_fully(file, read_bytes, wanted, path, error);
    if (status != AD_OK) {
        free(read_bytes);
        return status;
    }
    read_bytes[wanted] = 0;
    *bytes = read_bytes;
    *size = wanted;
    *file_size = (size_t)about.st_size;
    return AD_OK;
}

static ad_status read_file(int folder, const char *name, const char *path, size_t limit,
                           unsigned char **bytes, size_t *size, size_t *file_size, ad_error *error)
{
    /* Without O_NONBLOCK, opening a pipe would wait for a writer before it could be refused. */
    int file = openat(folder, name, O_RDONLY | O_NONBLOCK | O_CLOEXEC);
    if (file < 0) {
        return ad_fail(error, AD_IO, "%s: cannot be opened: %s", file_bytes_shown(path),
                       strerror(errno));
    }
    ad_status status = read_open_file(file, path, limit, bytes, size, file_size, error);
    close(file);
    return status;
}

ad_status file_bytes_read(const char *path, size_t limit, unsigned char **bytes, size_t *size,
                          size_t *file_size, ad_error *error)
{
    return read_file(AT_FDCWD, path, path, limit, bytes, size, file_size, error);
}

/* ---- writing ---- */

/* A place as the system takes it: names within an open folder, or paths. */
typedef struct target {
    int folder;
    const char *name, *path;
    int older;
} target;

static ad_status fail_write(ad_error *error, const char *path, const char *action, int code)
{
    const char *advice = "the file is left as it was";
    const bool place = code == EACCES || code == EROFS || code == ENOENT || code == ENOTDIR ||
                       code == ENAMETOOLONG || code == ELOOP || code == EISDIR;
    if (code == ENOSPC || code == EDQUOT || code == EFBIG) {
        advice = "the file is left as it was; free some space or choose another place";
    } else if (place) {
        advice = "its directory must exist and be writable";
    }
    return ad_fail(error, place ? AD_IO : AD_NOT_WRITTEN, "%s: cannot be written (%s): %s; %s",
                   file_bytes_shown(path), action, strerror(code), advice);
}

/* Open and lock the partial file; returns its descriptor or -1 with errno set. EAGAIN and EACCES
 * after opening mean that another process holds it. */
static int open_partial(int folder, const char *partial, bool *busy)
{
    struct flock lock = {.l_type = F_WRLCK, .l_whence = SEEK_SET};
    struct stat opened, named;
    int file = openat(folder, partial, O_RDWR | O_CREAT | O_CLOEXEC | O_NOFOLLOW, 0666);
    if (file < 0) {
        return -1;
    }
    /* A file system without locks (ENOLCK, EINVAL) is still written to. */
    *busy = fcntl(file, F_SETLK, &lock) != 0 && (errno == EAGAIN || errno == EACCES);
    /* Another process may have renamed its partial file away between our open and our lock. */
    *busy = *busy || fstat(file, &opened) != 0 || fstatat(folder, partial, &named, 0) != 0 ||
            opened.st_ino != named.st_ino || opened.st_dev != named.st_dev;
    if (*busy || ftruncate(file, 0) != 0) {
        int code = errno;
        if (!*busy) {
            unlinkat(folder, partial, 0);
        }
        close(file);
        errno = code;
        return -1;
    }
    return file;
}

/* Write and synchronise; returns 0 or the errno of what failed. */
static int write_fully(int file, const unsigned char *bytes, size_t size)
{
    size_t done = 0;
    while (done < size) {
        ssize_t put = write(file, bytes + done, size - done);
        if (put < 0 && errno != EINTR) {
            return errno;
        }
        done += put > 0 ? (size_t)put : 0;
    }
    while (fsync(file) != 0) {
        if (errno == EINVAL) { /* the file system cannot synchronise */
            break;
        }
        if (errno != EINTR) {
            return errno;
        }
    }
    return 0;
}

static bool is_there(const target *to, const char *name)
{
    return faccessat(to->folder, name, F_OK, 0) == 0;
}

static bool same_file(const target *to, const char *older)
{
    struct stat one, two;
    return fstatat(to->folder, to->name, &one, 0) == 0 &&
           fstatat(to->folder, older, &two, 0) == 0 && one.st_ino == two.st_ino &&
           one.st_dev == two.st_dev;
}

static ad_status put_file(const target *to, const void *bytes, size_t size, ad_error *error);

/* Give the file the second name `older`, which must not exist. */
static ad_status add_name(const target *to, const char *older, ad_error *error)
{
    if (linkat(to->folder, to->name, to->folder, older, 0) == 0) {
        return AD_OK;
    }
    const target copy = {to->folder, older, to->path, 0};
    unsigned char *bytes = NULL;
    size_t size = 0, file_size = 0;
    ad_status status =
        read_file(to->folder, to->name, to->path, 0, &bytes, &size, &file_size, error);
    if (status == AD_OK) {
        status = put_file(&copy, bytes, size, error);
    }
    free(bytes);
    return status;
}

/* Rename the generation `index` one up after making room above it. Stops at the first gap, which a
 * kill in the middle of an earlier rotation can leave. */
static ad_status shift_generation(const target *to, int index, ad_error *error)
{
    char *from = file_bytes_older(to->name, index), *above = file_bytes_older(to->name, index + 1);
    ad_status status = AD_OK;
    if (!from || !above) {
        status =
            ad_fail(error, AD_NO_MEMORY, "%s: no memory to write it", file_bytes_shown(to->path));
    } else if (index < to->older && is_there(to, from)) {
        status = shift_generation(to, index + 1, error);
        if (status == AD_OK && renameat(to->folder, from, to->folder, above) != 0) {
            status = fail_write(error, to->path, "keeping the older ones", errno);
        }
    } else if (index == to->older && unlinkat(to->folder, from, 0) != 0 && errno != ENOENT) {
        status = fail_write(error, to->path, "removing the oldest one", errno);
    }
    free(from);
    free(above);
    return status;
}

static ad_status keep_older(const target *to, ad_error *error)
{
    if (to->older == 0 || !is_there(to, to->name)) {
        return AD_OK;
    }
    char *older = file_bytes_older(to->name, 1);
    ad_status status = AD_OK;
    if (!older) {
        return ad_fail(error, AD_NO_MEMORY, "%s: no memory to write it",
                       file_bytes_shown(to->path));
    }
    /* A kill between link and rename leaves both names on one file: it is kept already. */
    if (!same_file(to, older)) {
        status = shift_generation(to, 1, error);
        if (status == AD_OK) {
            status = add_name(to, older, error);
        }
    }
    free(older);
    return status;
}

/* Make the rename itself durable. A directory that cannot be opened or synchronised is no error:
 * the file is complete either way. */
static void synchronise_directory(char *scratch, const target *to)
{
    size_t length = (size_t)(file_bytes_name(to->name) - to->name);
    memcpy(scratch, to->name, length);
    scratch[length] = 0;
    int directory =
        openat(to->folder, length > 0 ? scratch : ".", O_RDONLY | O_DIRECTORY | O_CLOEXEC);
    if (directory >= 0) {
        fsync(directory);
        close(directory);
    }
}

static ad_status write_partial(const target *to, char *partial, const void *bytes, size_t size,
                               ad_error *error)
{
    bool busy = false;
    struct stat about;
    if (fstatat(to->folder, to->name, &about, 0) == 0 && !S_ISREG(about.st_mode)) {
        return ad_fail(error, AD_IO, "%s: cannot be written: %s is there; name a file",
                       file_bytes_shown(to->path),
                       S_ISDIR(about.st_mode) ? "a directory" : "something else than a file");
    }
    int file = open_partial(to->folder, partial, &busy);
    if (busy) {
        return ad_fail(error, AD_IO, "%s: another process is writing it; write elsewhere or wait",
                       file_bytes_shown(to->path));
    }
    if (file < 0) {
        return fail_write(error, to->path, "creating a partial file beside it", errno);
    }
    int code = write_fully(file, bytes, size);
    ad_status status =
        code == 0 ? keep_older(to, error) : fail_write(error, to->path, "writing", code);
    if (status == AD_OK && renameat(to->folder, partial, to->folder, to->name) != 0) {
        status = fail_write(error, to->path, "renaming the finished file", errno);
    }
    if (status == AD_OK) {
        synchronise_directory(partial, to);
    } else {
        unlinkat(to->folder, partial, 0);
    }
    close(file); /* last, because it gives the lock up */
    return status;
}

static ad_status put_file(const target *to, const void *bytes, size_t size, ad_error *error)
{
    static const char ending[] = ".partial";
    size_t length = strlen(to->name);
    char *partial = malloc(length + sizeof ending);
    if (!partial) {
        return ad_fail(error, AD_NO_MEMORY, "%s: no memory to write it",
                       file_bytes_shown(to->path));
    }
    memcpy(partial, to->name, length);
    memcpy(partial + length, ending, sizeof ending);
    ad_status status = write_partial(to, partial, bytes, size, error);
    free(partial);
    return status;
}

ad_status file_bytes_put(const file_place *place, const void *bytes, size_t size, ad_error *error)
{
    const bool within = place->folder > 0;
    const target to = {within ? place->folder : AT_FDCWD,
                       within ? file_bytes_name(place->path) : place->path, place->path,
                       place->older};
    if (place->older < 0) {
        return ad_fail(error, AD_BAD_ARGUMENT, "%s: %d older ones; at least 0 can be kept",
                       file_bytes_shown(place->path), place->older);
    }
    return put_file(&to, bytes, size, error);
}

ad_status file_bytes_write(const char *path, const void *bytes, size_t size, ad_error *error)
{
    return file_bytes_put(&(file_place){.path = path}, bytes, size, error);
}
