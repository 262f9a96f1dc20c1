/* What checkpoint.c (items) and checkpoint_read.c, checkpoint_write.c (the file) share; not for
 * other files. */
#ifndef TOOLS_FILES_CHECKPOINT_PARTS_H
#define TOOLS_FILES_CHECKPOINT_PARTS_H

#include <hdf5.h>

#include "tools/files/checkpoint.h"

#define CHECKPOINT_USER_BLOCK 512
#define CHECKPOINT_MAGIC      "cpinn checkpoint"
#define CHECKPOINT_MAX_LINKS  (4UL * CHECKPOINT_MAX_ITEMS) /* items and the groups above them */

/* One row per kind of item: name, letter in the checksum, word in messages. */
#define CHECKPOINT_KINDS(X)                                                                        \
    X(CHECKPOINT_DOUBLE, 'd', "float64")                                                           \
    X(CHECKPOINT_INT64, 'i', "int64")                                                              \
    X(CHECKPOINT_UINT64, 'u', "uint64")                                                            \
    X(CHECKPOINT_TEXT, 't', "text")

typedef enum checkpoint_kind {
#define CHECKPOINT_KIND_ENUM(name, letter, word) name,
    CHECKPOINT_KINDS(CHECKPOINT_KIND_ENUM)
#undef CHECKPOINT_KIND_ENUM
} checkpoint_kind;

typedef union checkpoint_scalar {
    double real;
    int64_t integer;
} checkpoint_scalar;

typedef struct checkpoint_item {
    char *name; /* owned */
    checkpoint_kind kind;
    int rank;
    size_t shape[CHECKPOINT_MAX_RANK];
    size_t count;                    /* elements; of a text, bytes without the last zero */
    const void *data;                /* NULL: `scalar` */
    checkpoint_scalar scalar;        /* copied value of a rank 0 item */
    size_t columns;                  /* column names, 0 unless a table */
    const char *const *column_names; /* [columns] */
    void *owned_data;                /* what a reader allocated for data and names */
    void *owned_names;
} checkpoint_item;

struct checkpoint {
    char *path; /* of the file it came from, NULL if it was not opened */
    char *library_version;
    checkpoint_item *items;
    size_t count, capacity;
    ad_error failure; /* of the first failed put */
};

/* The elements of an item, never NULL. */
const void *checkpoint_item_data(const checkpoint_item *item);

/* Add `*item` (its name is copied); on success the checkpoint takes its owned memory over. */
ad_status checkpoint_add(checkpoint *cp, const char *name, const checkpoint_item *item,
                         ad_error *error);

/* Sort the items by name as bytes. */
void checkpoint_sort(checkpoint *cp);

/* Checksum over the items, which must be sorted. */
uint64_t checkpoint_digest(const checkpoint *cp);

/* Fill block [CHECKPOINT_USER_BLOCK] for a file of that many bytes, `hash` over those behind it. */
void checkpoint_user_block(unsigned char *block, size_t file_size, uint64_t hash);

/* HDF5 type of the elements in memory; not for texts. */
hid_t checkpoint_memory_type(checkpoint_kind kind);

/* Copy of a text; NULL when memory ran out. */
char *checkpoint_copy(const char *text);

#endif
