#include "tools/files/zip.h"

#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include <zlib.h>

/* Bytes before the name of a local entry, of one of the directory, and of the directory's end; of a
 * comment behind it; how much deflate shrinks at most (zlib's documentation). */
enum { ENTRY_HEADER = 30, LISTED_HEADER = 46, END_HEADER = 22, COMMENT = 65535, SHRINKS = 1032 };

/* `size` more bytes, not written yet; NULL when memory ran out. */
static unsigned char *extend(zip *z, size_t size)
{
    if (!z->failed && z->size + size > z->capacity) {
        size_t capacity = 2 * (z->size + size);
        unsigned char *grown = realloc(z->bytes, capacity);
        z->failed = !grown;
        z->bytes = grown ? grown : z->bytes;
        z->capacity = grown ? capacity : z->capacity;
    }
    if (z->failed) {
        return NULL;
    }
    z->size += size;
    return z->bytes + z->size - size;
}

void zip_put_number(zip *z, uint64_t number, int count)
{
    unsigned char *at = extend(z, (size_t)count);
    for (int i = 0; at && i < count; i++) {
        at[i] = (unsigned char)(number >> 8 * i);
    }
}

void zip_put(zip *z, const void *bytes, size_t size)
{
    unsigned char *at = size > 0 ? extend(z, size) : NULL;
    if (at) {
        memcpy(at, bytes, size);
    }
}

/* What local headers and directory have in common, from the version on: 2.0 suffices to unpack, the
 * name is UTF-8, nothing is compressed, and the date is the first that zip knows. */
static void put_common(zip *z, const zip_entry *e)
{
    zip_put_number(z, 20, 2);
    zip_put_number(z, 0x0800, 2);
    zip_put_number(z, 0, 2);
    zip_put_number(z, 0x00210000, 4);
    zip_put_number(z, e->crc, 4);
    zip_put_number(z, e->size, 4);
    zip_put_number(z, e->size, 4);
    zip_put_number(z, strlen(e->name), 2);
    zip_put_number(z, 0, 2);
}

static zip_entry *new_entry(zip *z)
{
    if (!z->failed && z->count == z->entry_capacity) {
        size_t capacity = 2 * z->count + 8;
        zip_entry *grown = realloc(z->entries, capacity * sizeof *grown);
        z->failed = !grown;
        z->entries = grown ? grown : z->entries;
        z->entry_capacity = grown ? capacity : z->entry_capacity;
    }
    return z->failed ? NULL : &z->entries[z->count++];
}

/* The header is written last, when the checksum is known. */
void zip_begin(zip *z, const char *name)
{
    size_t length = strlen(name);
    z->failed = z->failed || length >= ZIP_NAME;
    zip_entry *e = new_entry(z);
    if (e) {
        memcpy(e->name, name, length + 1);
        e->offset = z->size;
        extend(z, ENTRY_HEADER + length);
    }
}

void zip_end(zip *z)
{
    if (z->failed) {
        return;
    }
    zip_entry *e = &z->entries[z->count - 1];
    size_t end = z->size, data = e->offset + ENTRY_HEADER + strlen(e->name);
    e->size = end - data;
    e->crc = (uint32_t)crc32_z(0, z->bytes + data, e->size);
    z->size = e->offset;
    zip_put_number(z, 0x04034b50, 4);
    put_common(z, e);
    zip_put(z, e->name, strlen(e->name));
    z->size = end;
}

static void put_directory(zip *z)
{
    size_t start = z->size;
    for (size_t i = 0; i < z->count; i++) {
        const zip_entry *e = &z->entries[i];
        zip_put_number(z, 0x02014b50, 4);
        zip_put_number(z, 20, 2);
        put_common(z, e);
        zip_put_number(z, 0, 2); /* no comment, on the first disk, no attributes */
        zip_put_number(z, 0, 8);
        zip_put_number(z, e->offset, 4);
        zip_put(z, e->name, strlen(e->name));
    }
    size_t size = z->size - start;
    zip_put_number(z, 0x06054b50, 4);
    zip_put_number(z, 0, 4);
    zip_put_number(z, z->count, 2);
    zip_put_number(z, z->count, 2);
    zip_put_number(z, size, 4);
    zip_put_number(z, start, 4);
    zip_put_number(z, 0, 2);
}

bool zip_finish(zip *z, unsigned char **bytes, size_t *size)
{
    put_directory(z);
    free(z->entries);
    z->entries = NULL;
    if (z->failed || z->size >= UINT32_MAX || z->count >= UINT16_MAX) {
        free(z->bytes);
        return false;
    }
    *bytes = z->bytes;
    *size = z->size;
    return true;
}

/* ---- reading ------------------------------------------------------------------------------- */

static size_t number_at(const unsigned char *at, int count)
{
    size_t number = 0;
    for (int i = count; i-- > 0;) {
        number = number << 8 | at[i];
    }
    return number;
}

const char *zip_open(zip_reader *r, const unsigned char *bytes, size_t size)
{
    static const unsigned char sign[] = {'P', 'K', 5, 6};
    size_t end = size < END_HEADER ? 0 : size - END_HEADER;
    const size_t least = end > COMMENT ? end - COMMENT : 0;
    while (end > least && memcmp(bytes + end, sign, sizeof sign) != 0) {
        end--;
    }
    if (size < END_HEADER || memcmp(bytes + end, sign, sizeof sign) != 0) {
        return "is no zip archive, or its end is missing";
    }
    *r = (zip_reader){.bytes = bytes,
                      .size = end,
                      .at = number_at(bytes + end + 16, 4),
                      .left = number_at(bytes + end + 10, 2)};
    return NULL;
}

static const char *inflate_all(const unsigned char *packed, size_t packed_size,
                               unsigned char *bytes, size_t size)
{
    z_stream z = {.next_in = (unsigned char *)packed, .avail_in = (unsigned)packed_size};
    z.next_out = bytes;
    z.avail_out = (unsigned)size;
    if (inflateInit2(&z, -MAX_WBITS) != Z_OK) {
        return "";
    }
    const int code = inflate(&z, Z_FINISH);
    const bool whole = (code == Z_STREAM_END || code == Z_BUF_ERROR) && z.avail_out == 0;
    inflateEnd(&z);
    return whole ? NULL : "has an entry whose compressed bytes are damaged";
}

/* bytes [size + 1] of an entry that is stored, or deflated. */
static const char *unpack(const unsigned char *packed, size_t packed_size, size_t method,
                          unsigned char *bytes, size_t size)
{
    if (method == 0 && packed_size == size) {
        memcpy(bytes, packed, size);
        return NULL;
    }
    return method == 8 ? inflate_all(packed, packed_size, bytes, size)
                       : "has an entry that is neither stored nor deflated";
}

const char *zip_next(zip_reader *r, char name[ZIP_NAME], unsigned char **held, size_t *held_size)
{
    static const char cut[] = "is cut off, or its directory is damaged";
    *held = NULL;
    if (r->left == 0) {
        return NULL;
    }
    const unsigned char *e = r->bytes + r->at;
    if (r->at > r->size || r->size - r->at < LISTED_HEADER || memcmp(e, "PK\1\2", 4) != 0) {
        return cut;
    }
    const size_t method = number_at(e + 10, 2), crc = number_at(e + 16, 4);
    const size_t packed = number_at(e + 20, 4), size = number_at(e + 24, 4);
    const size_t length = number_at(e + 28, 2), local = number_at(e + 42, 4);
    const size_t all = LISTED_HEADER + length + number_at(e + 30, 2) + number_at(e + 32, 2);
    if (r->size - r->at < all || local > r->size || r->size - local < ENTRY_HEADER) {
        return cut;
    }
    const unsigned char *from = r->bytes + local;
    const size_t skip = ENTRY_HEADER + number_at(from + 26, 2) + number_at(from + 28, 2);
    if (r->size - local < skip || r->size - local - skip < packed ||
        (method == 8 && size / SHRINKS > packed)) {
        return cut;
    }
    snprintf(name, ZIP_NAME, "%.*s", (int)(length < ZIP_NAME ? length : ZIP_NAME - 1),
             (const char *)e + LISTED_HEADER);
    unsigned char *bytes = malloc(size + 1);
    const char *problem = bytes ? unpack(from + skip, packed, method, bytes, size) : "";
    if (!problem && crc32_z(0, bytes, size) != crc) {
        problem = "has an entry whose checksum is wrong";
    }
    if (problem) {
        free(bytes);
        return problem;
    }
    bytes[size] = 0;
    *held = bytes;
    *held_size = size;
    r->at += all;
    r->left--;
    return NULL;
}
