/* Tables as .npz: a zip archive that stores each column uncompressed as a NumPy array, "x.npy" for
 * the column x. Two more arrays of strings, "columns" and "units", say the order of the columns and
 * their units, in case there are units.
 *
 * Arrays: numpy.lib.format, version 1.0. Equal tables give equal bytes. */
#include <stdbool.h>
#include <stdint.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "tools/files/table_parts.h"
#include "tools/files/zip.h"

enum {
    DIRECTORY_END = 22,
    ARRAY_HEADER = 128, /* magic, version, length and description of an array, padded */
    EXTRA_ARRAYS = 2    /* columns, units */
};

/* ---- arrays -------------------------------------------------------------------------------- */

static void put_array_header(zip *z, const char *type, size_t rows)
{
    char text[ARRAY_HEADER];
    int length = snprintf(text, sizeof text,
                          "{'descr': '%s', 'fortran_order': False, "
                          "'shape': (%zu,), }",
                          type, rows);
    memset(text + length, ' ', sizeof text - (size_t)length);
    int described = ARRAY_HEADER - 10; /* of which the last byte ends the line */
    text[described - 1] = '\n';
    zip_put(z, "\x93NUMPY\x01\x00", 8);
    zip_put_number(z, (uint64_t)described, 2);
    zip_put(z, text, (size_t)described);
}

static void put_doubles(zip *z, const double *values, size_t rows)
{
    put_array_header(z, "<f8", rows);
    for (size_t i = 0; i < rows; i++) {
        uint64_t bits;
        memcpy(&bits, &values[i], sizeof bits);
        zip_put_number(z, bits, 8);
    }
}

/* The next character of a text in UTF-8; bytes that are not UTF-8 stand for themselves, as do those
 * of what NumPy takes for no character: halves of pairs, beyond 0x10FFFF, not the shortest form. */
static uint32_t next_character(const char **text)
{
    static const uint32_t least[] = {0, 0x80, 0x800, 0x10000};
    const unsigned char *at = (const unsigned char *)*text;
    int more = at[0] >= 0xF0 ? 3 : at[0] >= 0xE0 ? 2 : at[0] >= 0xC0 ? 1 : 0;
    uint32_t character = more ? at[0] & (0x3Fu >> more) : at[0];
    bool is_character = true;
    for (int i = 1; is_character && i <= more; i++) {
        is_character = (at[i] & 0xC0) == 0x80;
        character = character << 6 | (at[i] & 0x3Fu);
    }
    if (!is_character || character < least[more] || character > 0x10FFFF ||
        (character >= 0xD800 && character < 0xE000)) {
        more = 0;
        character = at[0];
    }
    *text += 1 + more;
    return character;
}

/* Texts become strings of one length in UTF-32, which NumPy calls U. */
static void put_texts(zip *z, const char *const *texts, size_t rows)
{
    size_t longest = 1;
    char type[32];
    for (size_t i = 0; i < rows; i++) {
        longest = strlen(texts[i]) > longest ? strlen(texts[i]) : longest;
    }
    snprintf(type, sizeof type, "<U%zu", longest);
    put_array_header(z, type, rows);
    for (size_t i = 0; i < rows; i++) {
        const char *at = texts[i];
        for (size_t k = 0; k < longest; k++) {
            zip_put_number(z, *at ? next_character(&at) : 0, 4);
        }
    }
}

/* ---- the archive --------------------------------------------------------------------------- */

static void begin_array(zip *z, const char *column)
{
    char name[TABLE_MAX_NAME + 8];
    snprintf(name, sizeof name, "%s.npy", column);
    zip_begin(z, name);
}

bool table_fits_npz(const table_source *source)
{
    uint64_t bytes = 0, rows = source->nrows;
    for (size_t k = 0; k < source->ncols; k++) {
        bool words = source->words && source->words[k];
        bytes += ZIP_ENTRY_OVERHEAD + 2 * (TABLE_MAX_NAME + 4) + ARRAY_HEADER;
        bytes += words ? rows * 4 * TABLE_MAX_NAME : rows * 8;
    }
    bytes += DIRECTORY_END + (uint64_t)source->ncols * 8 * TABLE_MAX_NAME;
    return bytes < UINT32_MAX && rows < UINT32_MAX;
}

ad_status table_to_npz(const table_source *source, unsigned char **bytes, size_t *size)
{
    zip z = {.bytes = NULL};
    for (size_t k = 0; k < source->ncols; k++) {
        begin_array(&z, source->names[k]);
        if (source->words && source->words[k]) {
            put_texts(&z, source->words[k], source->nrows);
        } else {
            put_doubles(&z, source->columns[k], source->nrows);
        }
        zip_end(&z);
    }
    const struct {
        const char *name;
        const char *const *texts;
    } extra[EXTRA_ARRAYS] = {{"columns", source->names}, {"units", source->units}};
    for (int i = 0; source->units && i < EXTRA_ARRAYS; i++) {
        begin_array(&z, extra[i].name);
        put_texts(&z, extra[i].texts, source->ncols);
        zip_end(&z);
    }
    return zip_finish(&z, bytes, size) ? AD_OK : AD_NO_MEMORY;
}
