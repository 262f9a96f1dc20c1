/* Whole files as bytes: read one with clear refusals, write one so that it never half exists.
 * Shared by the checkpoints and the tables; this is the one place that touches the disk for them.
 *
 * Writing: the bytes go to "<path>.partial" in the same directory, are synchronised to the disk,
 * and are renamed over `path`; then the directory is synchronised. A process killed at any moment
 * leaves either the old or the new file complete under `path`, at worst beside a stale ".partial"
 * that the next write reuses. The ".partial" is locked while in use, so a second process writing
 * the same path is refused instead of mixing its bytes in. */
#ifndef TOOLS_FILES_FILE_BYTES_H
#define TOOLS_FILES_FILE_BYTES_H

#include <stddef.h>

#include "autodiff/error.h"

/* Read the first `limit` bytes (0: all) of the regular file `path`. On success the caller owns
 * `*bytes` (never NULL, a zero byte follows the last one), `*size` is how many were read and
 * `*file_size` how long the file is. Errors: AD_IO (missing, unreadable, a directory, not a
 * regular file, changed meanwhile), AD_NO_MEMORY; the outputs are then untouched. */
ad_status file_bytes_read(const char *path, size_t limit, unsigned char **bytes, size_t *size,
                          size_t *file_size, ad_error *error);

/* Where a file goes. Its last part is looked up in the open folder `folder`, if that is > 0:
 * whatever has taken the place of that folder under its name is not written to. */
typedef struct file_place {
    const char *path;
    int older;  /* >= 0 generations that are kept beside the new file */
    int folder; /* descriptor of the folder that `path` led to; 0: the one it leads to now */
} file_place;

/* Put `size` bytes at a place: the file so far becomes generation 1 (see file_bytes_older),
 * generation 1 becomes 2, up to `older`. The path itself never disappears meanwhile: the old file
 * gets its second name by link(2), by a copy where the file system has no links. Errors:
 * AD_BAD_ARGUMENT (older), AD_IO (no place for a file), AD_NOT_WRITTEN (the disk is full or fails),
 * AD_NO_MEMORY; the file that was there is then untouched and the partial one removed. */
ad_status file_bytes_put(const file_place *place, const void *bytes, size_t size, ad_error *error);

/* The same, where `path` leads, with nothing older. */
ad_status file_bytes_write(const char *path, const void *bytes, size_t size, ad_error *error);

/* Whether a file can be written there, as far as its folder tells. AD_IO, AD_NO_MEMORY. */
ad_status file_bytes_check(const char *path, ad_error *error);

/* Name of the generation `index` >= 1 of `path`: "run/checkpoint.h5" gives "run/checkpoint.1.h5".
 * The caller frees it; NULL when memory ran out. */
char *file_bytes_older(const char *path, int index);

/* What follows the last / of `path`; points into it. */
const char *file_bytes_name(const char *path);

/* The end of `path` that fits a one-line message; points into `path`. */
const char *file_bytes_shown(const char *path);

#endif
