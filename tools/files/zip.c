#include "tools/files/zip.h"

#include <stdlib.h>
#include <string.h>

enum { ENTRY_HEADER = 30 }; /* bytes before the name of a local entry */

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
    e->crc = checksum(z->bytes + data, e->size);
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
