/* Tables as .npz: a zip archive that stores each column uncompressed as a NumPy array, "x.npy" for
 * the column x. Two more arrays of strings, "columns" and "units", say the order of the columns and
 * their units, in case there are units.
 *
 * Zip: PKWARE's APPNOTE.TXT 6.3.3, sections 4.3 and 4.4, without compression, encryption and zip64.
 * Arrays: numpy.lib.format, version 1.0. The archive has no time stamps: equal tables give equal
 * bytes. */
#include <stdbool.h>
#include <stdint.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "tools/files/table_parts.h"

enum {
    ENTRY_HEADER = 30,     /* bytes before the name of a local entry */
    DIRECTORY_HEADER = 46, /* the same in the central directory */
    DIRECTORY_END = 22,
    ARRAY_HEADER = 128, /* magic, version, length and description of an array, padded */
    EXTRA_ARRAYS = 2    /* columns, units */
};

/* Bytes that grow; sticky when memory runs out. */
typedef struct buffer {
    unsigned char *bytes;
    size_t size, capacity;
    bool failed;
} buffer;

/* `size` more bytes, not written yet; NULL when memory ran out. */
static unsigned char *extend(buffer *b, size_t size)
{
    if (!b->failed && b->size + size > b->capacity) {
        size_t capacity = 2 * (b->size + size);
        unsigned char *grown = realloc(b->bytes, capacity);
        b->failed = !grown;
        b->bytes = grown ? grown : b->bytes;
        b->capacity = grown ? capacity : b->capacity;
    }
    if (b->failed) {
        return NULL;
    }
    b->size += size;
    return b->bytes + b->size - size;
}

/* The lowest `count` bytes of a number, the lowest first. */
static void put_number(buffer *b, uint64_t number, int count)
{
    unsigned char *at = extend(b, (size_t)count);
    for (int i = 0; at && i < count; i++) {
        at[i] = (unsigned char)(number >> 8 * i);
    }
}

static void put_bytes(buffer *b, const void *bytes, size_t size)
{
    unsigned char *at = extend(b, size);
    if (at) {
        memcpy(at, bytes, size);
    }
}

/* CRC-32 of ISO 3309, as zip has it. */
static uint32_t checksum(const unsigned char *bytes, size_t size)
{
    uint32_t table[256], crc = UINT32_MAX;
    for (uint32_t i = 0; i < 256; i++) {
        table[i] = i;
        for (int bit = 0; bit < 8; bit++) {
            table[i] = table[i] >> 1 ^ (table[i] & 1 ? 0xEDB88320u : 0);
        }
    }
    for (size_t i = 0; i < size; i++) {
        crc = crc >> 8 ^ table[(crc ^ bytes[i]) & 0xFF];
    }
    return ~crc;
}

/* ---- arrays -------------------------------------------------------------------------------- */

static void put_array_header(buffer *b, const char *type, size_t rows)
{
    char text[ARRAY_HEADER];
    int length = snprintf(text, sizeof text,
                          "{'descr': '%s', 'fortran_order': False, "
                          "'shape': (%zu,), }",
                          type, rows);
    memset(text + length, ' ', sizeof text - (size_t)length);
    int described = ARRAY_HEADER - 10; /* of which the last byte ends the line */
    text[described - 1] = '\n';
    put_bytes(b, "\x93NUMPY\x01\x00", 8);
    put_number(b, (uint64_t)described, 2);
    put_bytes(b, text, (size_t)described);
}

static void put_doubles(buffer *b, const double *values, size_t rows)
{
    put_array_header(b, "<f8", rows);
    for (size_t i = 0; i < rows; i++) {
        uint64_t bits;
        memcpy(&bits, &values[i], sizeof bits);
        put_number(b, bits, 8);
    }
}

/* The next character of a text in UTF-8; bytes that are not UTF-8 stand for themselves. */
static uint32_t next_character(const char **text)
{
    const unsigned char *at = (const unsigned char *)*text;
    int more = at[0] >= 0xF0 ? 3 : at[0] >= 0xE0 ? 2 : at[0] >= 0xC0 ? 1 : 0;
    uint32_t character = more ? at[0] & (0x3Fu >> more) : at[0];
    for (int i = 1; i <= more; i++) {
        if ((at[i] & 0xC0) != 0x80) {
            more = 0;
            character = at[0];
        } else {
            character = character << 6 | (at[i] & 0x3Fu);
        }
    }
    *text += 1 + more;
    return character;
}

/* Texts become strings of one length in UTF-32, which NumPy calls U. */
static void put_texts(buffer *b, const char *const *texts, size_t rows)
{
    size_t longest = 1;
    char type[32];
    for (size_t i = 0; i < rows; i++) {
        longest = strlen(texts[i]) > longest ? strlen(texts[i]) : longest;
    }
    snprintf(type, sizeof type, "<U%zu", longest);
    put_array_header(b, type, rows);
    for (size_t i = 0; i < rows; i++) {
        const char *at = texts[i];
        for (size_t k = 0; k < longest; k++) {
            put_number(b, *at ? next_character(&at) : 0, 4);
        }
    }
}

/* ---- the archive --------------------------------------------------------------------------- */

typedef struct entry {
    char name[TABLE_MAX_NAME + 8];
    size_t offset, size; /* of the local header; of the array */
    uint32_t crc;
} entry;

/* What local headers and directory have in common, from the version on: 2.0 suffices to unpack, the
 * name is UTF-8, nothing is compressed, and the date is the first that zip knows. */
static void put_common(buffer *b, const entry *e)
{
    put_number(b, 20, 2);
    put_number(b, 0x0800, 2);
    put_number(b, 0, 2);
    put_number(b, 0x00210000, 4);
    put_number(b, e->crc, 4);
    put_number(b, e->size, 4);
    put_number(b, e->size, 4);
    put_number(b, strlen(e->name), 2);
    put_number(b, 0, 2);
}

/* The header is written last, when the checksum is known. */
static void begin_entry(buffer *b, entry *e, const char *column)
{
    snprintf(e->name, sizeof e->name, "%s.npy", column);
    e->offset = b->size;
    extend(b, ENTRY_HEADER + strlen(e->name));
}

static void end_entry(buffer *b, entry *e)
{
    size_t end = b->size, data = e->offset + ENTRY_HEADER + strlen(e->name);
    if (b->failed) {
        return;
    }
    e->size = end - data;
    e->crc = checksum(b->bytes + data, e->size);
    b->size = e->offset;
    put_number(b, 0x04034b50, 4);
    put_common(b, e);
    put_bytes(b, e->name, strlen(e->name));
    b->size = end;
}

static void put_directory(buffer *b, const entry *entries, size_t count)
{
    size_t start = b->size;
    for (size_t i = 0; i < count; i++) {
        put_number(b, 0x02014b50, 4);
        put_number(b, 20, 2);
        put_common(b, &entries[i]);
        put_number(b, 0, 2); /* no comment, on the first disk, no attributes */
        put_number(b, 0, 8);
        put_number(b, entries[i].offset, 4);
        put_bytes(b, entries[i].name, strlen(entries[i].name));
    }
    size_t size = b->size - start;
    put_number(b, 0x06054b50, 4);
    put_number(b, 0, 4);
    put_number(b, count, 2);
    put_number(b, count, 2);
    put_number(b, size, 4);
    put_number(b, start, 4);
    put_number(b, 0, 2);
}

bool table_fits_npz(const table_source *source)
{
    uint64_t bytes = 0, rows = source->nrows;
    for (size_t k = 0; k < source->ncols; k++) {
        bool words = source->words && source->words[k];
        bytes += 2 * (ENTRY_HEADER + DIRECTORY_HEADER + TABLE_MAX_NAME) + ARRAY_HEADER;
        bytes += words ? 4 * TABLE_MAX_NAME * rows : 8 * rows;
    }
    bytes += DIRECTORY_END + 8 * TABLE_MAX_NAME * (uint64_t)source->ncols;
    return bytes < UINT32_MAX && rows < UINT32_MAX;
}

ad_status table_to_npz(const table_source *source, unsigned char **bytes, size_t *size)
{
    buffer b = {.bytes = NULL};
    size_t count = 0;
    entry *entries = calloc(source->ncols + EXTRA_ARRAYS, sizeof *entries);
    if (!entries) {
        return AD_NO_MEMORY;
    }
    for (size_t k = 0; k < source->ncols; k++) {
        begin_entry(&b, &entries[count], source->names[k]);
        if (source->words && source->words[k]) {
            put_texts(&b, source->words[k], source->nrows);
        } else {
            put_doubles(&b, source->columns[k], source->nrows);
        }
        end_entry(&b, &entries[count++]);
    }
    const struct {
        const char *name;
        const char *const *texts;
    } extra[EXTRA_ARRAYS] = {{"columns", source->names}, {"units", source->units}};
    for (int i = 0; source->units && i < EXTRA_ARRAYS; i++) {
        begin_entry(&b, &entries[count], extra[i].name);
        put_texts(&b, extra[i].texts, source->ncols);
        end_entry(&b, &entries[count++]);
    }
    put_directory(&b, entries, count);
    free(entries);
    if (b.failed) {
        free(b.bytes);
        return AD_NO_MEMORY;
    }
    *bytes = b.bytes;
    *size = b.size;
    return AD_OK;
}
