/* Checkpoints: named arrays and texts in one HDF5 file that is either complete and unchanged or
 * refused. The trainer decides what is in it; format, atomicity, checksums and refusal are here.
 *
 * The file, readable by any HDF5 tool (h5py, h5dump):
 *   bytes 0..511   HDF5 user block, ASCII, zero padded, skipped by HDF5 itself:
 *                      cpinn checkpoint
 *                      format_version 2
 *                      bytes <length of the whole file, decimal>
 *                      fnv1a64 <checksum of bytes 512..end, 16 hexadecimal digits>
 *   root attributes
 *     format           text "cpinn checkpoint"
 *     format_version   int64, 2
 *     library_version  text
 *     checksum         uint64, over the items, see below
 *   items            one dataset each, at the path that is its name ("optimizer/step"):
 *     doubles          float64 little-endian, rank 0 to 3
 *     integers         int64 or uint64 little-endian, rank 0 to 3
 *     texts            scalar fixed-length UTF-8 string, ended by a zero
 *     tables           float64 [rows, columns], attribute "columns": their names
 *
 * The user block lets every byte be checked before HDF5 interprets any of it. The checksum
 * of the items lets another reader check what it was given: 64-bit FNV-1a over the items in the
 * order of their names as bytes, each as: name and a zero byte; one of the letters d (double), i
 * (int64), u (uint64), t (text); rank and each extent as little-endian 64-bit integers (a text has
 * rank 1 and its length without the zero as extent); the elements, little-endian, row by row; the
 * number of column names as a 64-bit integer; each column name and a zero byte. FNV-1a, offset
 * basis 14695981039346656037, prime 1099511628211: G. Fowler, L. C. Noll, K.-P. Vo, D. Eastlake,
 * "The FNV Non-Cryptographic Hash Algorithm", IETF draft-eastlake-fnv. Each of its steps is
 * invertible, so a change confined to one byte always changes it. It guards against accidents, not
 * against forgery.
 *
 * Numbers come back to the last bit, including the payload of a NaN. */
#ifndef TOOLS_FILES_CHECKPOINT_H
#define TOOLS_FILES_CHECKPOINT_H

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

#include "autodiff/error.h"
#include "tools/files/file_bytes.h"

#define CHECKPOINT_FORMAT_VERSION 2
#define CHECKPOINT_FORMAT_SINCE   "0.2.0" /* the first version that reads it; see CHANGELOG.md */
#define CHECKPOINT_MAX_RANK       3
#define CHECKPOINT_MAX_NAME       255  /* bytes of an item's name or a column's name */
#define CHECKPOINT_MAX_ITEMS      4096 /* items of one file, columns of one table */

/* Items by name. Either filled by the put functions and written, or opened from a file. */
typedef struct checkpoint checkpoint;

/* Empty; `library_version` (copied) says who writes it. NULL when memory ran out. */
checkpoint *checkpoint_create(const char *library_version);
void checkpoint_free(checkpoint *cp);

/* ---- filling ----
 * Add the item `name`: parts joined by single '/', printable ASCII without blanks, no part "." or
 * "..", new, and neither inside nor above another item. `data` and `columns` are borrowed until
 * the last checkpoint_write, texts are copied; `data` may be NULL when an extent is 0. Arrays are
 * row by row, `shape` has `rank` <= 3 extents, rank 0 (shape NULL) is a scalar. Errors:
 * AD_BAD_ARGUMENT (name, rank, shape, data), AD_NO_MEMORY. A failed put adds nothing and is
 * remembered, so a caller may ignore the results: checkpoint_write then reports the first failure
 * and writes nothing. */
ad_status checkpoint_put_doubles(checkpoint *cp, const char *name, const double *data, int rank,
                                 const size_t *shape);
ad_status checkpoint_put_int64(checkpoint *cp, const char *name, const int64_t *data, int rank,
                               const size_t *shape);
ad_status checkpoint_put_uint64(checkpoint *cp, const char *name, const uint64_t *data, int rank,
                                const size_t *shape);
ad_status checkpoint_put_text(checkpoint *cp, const char *name, const char *text);
/* `data` is [rows, columns], `column_names` are `columns` texts. */
ad_status checkpoint_put_table(checkpoint *cp, const char *name, const double *data, size_t rows,
                               size_t columns, const char *const *column_names);
/* Scalars are copied. */
ad_status checkpoint_put_double(checkpoint *cp, const char *name, double value);
ad_status checkpoint_put_integer(checkpoint *cp, const char *name, int64_t value);

/* Write all items atomically, keeping older ones as "checkpoint.1.h5", "checkpoint.2.h5", ...
 * beside "checkpoint.h5". Once a first write has succeeded, the file is complete at every instant,
 * whatever kills the process. Errors: the first failed put, else as of file_bytes_put; the old file
 * is then untouched. */
ad_status checkpoint_write(checkpoint *cp, const file_place *place, ad_error *error);

/* ---- reading ----
 * Read and verify the whole file into a new checkpoint owned by the caller; the file is closed
 * again. Errors: AD_IO (cannot be read), AD_BAD_INPUT (not a checkpoint, truncated, damaged, newer
 * format), AD_NO_MEMORY; `*cp` is then NULL. */
ad_status checkpoint_open(const char *path, checkpoint **cp, ad_error *error);

/* Number of items, and the name of one of them (0 <= index < count); an opened checkpoint has them
 * in the order of their names. */
size_t checkpoint_count(const checkpoint *cp);
const char *checkpoint_name(const checkpoint *cp, size_t index);
const char *checkpoint_library_version(const checkpoint *cp);

bool checkpoint_has(const checkpoint *cp, const char *name);
/* Rank and extents of an item, unused extents 1; a text has rank 1 and its length. False: no such
 * item. */
bool checkpoint_shape(const checkpoint *cp, const char *name, int *rank,
                      size_t shape[CHECKPOINT_MAX_RANK]);

/* Copy the elements of an item to `destination` [expected_count]. Errors: AD_BAD_INPUT, the message
 * names file and item: missing, another type, another number of elements; nothing is then copied.
 */
ad_status checkpoint_get_doubles(const checkpoint *cp, const char *name, double *destination,
                                 size_t expected_count, ad_error *error);
/* One integer; AD_BAD_INPUT also: not within low to high. */
ad_status checkpoint_get_integer(const checkpoint *cp, const char *name, int64_t low, int64_t high,
                                 int64_t *value, ad_error *error);
ad_status checkpoint_get_int64(const checkpoint *cp, const char *name, int64_t *destination,
                               size_t expected_count, ad_error *error);
ad_status checkpoint_get_uint64(const checkpoint *cp, const char *name, uint64_t *destination,
                                size_t expected_count, ad_error *error);
/* `*text` belongs to the checkpoint. */
ad_status checkpoint_get_text(const checkpoint *cp, const char *name, const char **text,
                              ad_error *error);
/* Name of a table's column, NULL if the item has none there; belongs to the checkpoint. */
const char *checkpoint_column(const checkpoint *cp, const char *name, size_t column);

/* For programs, before anything else here: HDF5 does not close itself when the process ends, which
 * without memory it does in an endless loop that it reports. */
void checkpoint_at_exit(void);

/* 64-bit FNV-1a, continued from `hash`; start with CHECKPOINT_HASH_START. */
#define CHECKPOINT_HASH_START UINT64_C(14695981039346656037)
uint64_t checkpoint_hash(uint64_t hash, const void *bytes, size_t size);

#endif
