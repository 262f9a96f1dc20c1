/* Zip archives in memory; those that are written are not compressed. PKWARE's APPNOTE.TXT 6.3.3,
 * sections 4.3 and 4.4, without encryption and zip64. There are no time stamps: equal entries give
 * equal bytes. */
#ifndef TOOLS_FILES_ZIP_H
#define TOOLS_FILES_ZIP_H

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

enum {
    ZIP_NAME = 256,         /* room for the name of an entry */
    ZIP_ENTRY_OVERHEAD = 76 /* bytes of an entry beside its own and twice its name */
};

typedef struct zip_entry {
    char name[ZIP_NAME];
    size_t offset, size; /* of the local header; of what the entry holds */
    uint32_t crc;
} zip_entry;

/* Starts as all 0; sticky when memory runs out. */
typedef struct zip {
    unsigned char *bytes; /* [size] so far */
    size_t size, capacity;
    zip_entry *entries;
    size_t count, entry_capacity;
    bool failed;
} zip;

/* What is put between the two becomes an entry of this name, with / between folders. */
void zip_begin(zip *z, const char *name);
void zip_end(zip *z);

void zip_put(zip *z, const void *bytes, size_t size);
void zip_put_number(zip *z, uint64_t number, int count); /* its lowest bytes, the lowest first */

/* The directory, after all entries. The caller owns *bytes [size] from then on; false: memory ran
 * out, the archive reaches 4 GiB, or a name does not fit; there is nothing to free then. */
bool zip_finish(zip *z, unsigned char **bytes, size_t *size);

/* An archive that is read, whose bytes are borrowed. Entries are stored or deflated. */
typedef struct zip_reader {
    const unsigned char *bytes;
    size_t size, at, left; /* of the directory: the next entry, how many are left */
} zip_reader;

/* NULL, or what is wrong with the archive; "" where memory ran out. */
const char *zip_open(zip_reader *r, const unsigned char *bytes, size_t size);

/* The next entry; the caller frees *held [held_size], NULL behind the last one. */
const char *zip_next(zip_reader *r, char name[ZIP_NAME], unsigned char **held, size_t *held_size);

#endif
