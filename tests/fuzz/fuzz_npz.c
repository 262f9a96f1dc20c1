/* A table, from its CSV, as .npz: every byte is read again by the descriptions of zip and of
 * NumPy's arrays, to the same names, bits and words. */
#include "tests/fuzz/fuzz.h"
#include "tools/files/table_parts.h"

typedef struct archive {
    const unsigned char *bytes;
    size_t size, at, entries;
} archive;

static uint64_t number_at(const archive *a, size_t at, int count)
{
    uint64_t number = 0;
    fuzz_require(at + (size_t)count <= a->size);
    while (count-- > 0) {
        number = number << 8 | a->bytes[at + (size_t)count];
    }
    return number;
}

/* CRC-32 bit by bit. */
static uint32_t crc_of(const unsigned char *bytes, size_t size)
{
    uint32_t crc = 0xFFFFFFFF;
    for (size_t i = 0; i < 8 * size; i++) {
        const uint32_t bit = bytes[i / 8] >> i % 8 & 1;
        crc = crc >> 1 ^ ((crc ^ bit) & 1 ? 0xEDB88320 : 0);
    }
    return ~crc;
}

/* Moves behind the next array, of this name: its data, of `rows` items of `type` f8 or U, of which
 * *width are the characters. */
static const unsigned char *take_array(archive *a, const char *column, char type, size_t rows,
                                       size_t *width)
{
    char name[TABLE_MAX_NAME + 8], text[160];
    const size_t length = (size_t)snprintf(name, sizeof name, "%s.npy", column), at = a->at;
    const size_t size = number_at(a, at + 18, 4), data = at + 30 + length;
    fuzz_require(number_at(a, at, 4) == 0x04034b50 && number_at(a, at + 8, 2) == 0);
    fuzz_require(number_at(a, at + 26, 2) == length && number_at(a, at + 28, 2) == 0);
    fuzz_require(data + size <= a->size && memcmp(a->bytes + at + 30, name, length) == 0);
    fuzz_require(number_at(a, at + 14, 4) == crc_of(a->bytes + data, size));
    const size_t described = number_at(a, data + 8, 2), head = 10 + described;
    fuzz_require(memcmp(a->bytes + data, "\x93NUMPY\x01\x00", 8) == 0 && head % 64 == 0);
    fuzz_require(described < sizeof text && head <= size);
    memcpy(text, a->bytes + data + 10, described);
    text[described] = 0;
    fuzz_require(text[described - 1] == '\n');
    size_t told = 0;
    if (type == 'f') {
        fuzz_require(sscanf(text, "{'descr': '<f8', 'fortran_order': False, 'shape': (%zu,), }",
                            &told) == 1);
        *width = 2;
    } else {
        fuzz_require(sscanf(text, "{'descr': '<U%zu', 'fortran_order': False, 'shape': (%zu,), }",
                            width, &told) == 2);
    }
    fuzz_require(told == rows && size == head + rows * 4 * *width);
    a->at = data + size;
    a->entries++;
    return a->bytes + data + head;
}

/* A word as characters, which NumPy takes up to 0x10FFFF and without halves of pairs. */
static void check_word(const unsigned char *data, size_t width, const char *word)
{
    const archive whole = {.bytes = data, .size = 4 * width};
    const size_t length = strlen(word);
    bool ascii = true;
    for (size_t k = 0; k < length; k++) {
        ascii = ascii && (unsigned char)word[k] < 0x80;
    }
    for (size_t k = 0; k < width; k++) {
        const uint64_t character = number_at(&whole, 4 * k, 4);
        fuzz_require(character <= 0x10FFFF && !(character >= 0xD800 && character < 0xE000));
        fuzz_require((character != 0) == (k < length) || !ascii);
        fuzz_require(!ascii || k >= length || character == (unsigned char)word[k]);
    }
}

static void check_columns(archive *a, const table_file *table)
{
    size_t width = 0;
    for (size_t k = 0; k < table->columns; k++) {
        const char type = table->values[k] ? 'f' : 'U';
        const unsigned char *data = take_array(a, table->names[k], type, table->rows, &width);
        for (size_t row = 0; row < table->rows; row++) {
            if (type == 'f') {
                fuzz_require(memcmp(data + 8 * row, &table->values[k][row], 8) == 0);
            } else {
                check_word(data + 4 * width * row, width, table->words[k][row]);
            }
        }
    }
    take_array(a, "columns", 'U', table->columns, &width);
    take_array(a, "units", 'U', table->columns, &width);
}

/* The directory names every entry, and where it is. */
static void check_directory(const archive *a)
{
    const size_t end = a->size - 22;
    fuzz_require(a->size >= 22 && number_at(a, end, 4) == 0x06054b50);
    fuzz_require(number_at(a, end + 10, 2) == a->entries && number_at(a, end + 16, 4) == a->at);
    size_t at = a->at;
    for (size_t i = 0; i < a->entries; i++) {
        const size_t length = number_at(a, at + 28, 2), local = number_at(a, at + 42, 4);
        fuzz_require(number_at(a, at, 4) == 0x02014b50 && number_at(a, local, 4) == 0x04034b50);
        fuzz_require(number_at(a, local + 26, 2) == length && at + 46 + length <= end);
        fuzz_require(memcmp(a->bytes + at + 46, a->bytes + local + 30, length) == 0);
        at += 46 + length;
    }
    fuzz_require(at == end && number_at(a, end + 12, 4) == at - a->at);
}

int LLVMFuzzerTestOneInput(const uint8_t *bytes, size_t size)
{
    const char *const words[] = {"place", NULL};
    const table_wanted wanted = {"fuzz.csv", TABLE_NONFINITE, words};
    ad_error error = {AD_OK, ""};
    table_file *table;
    unsigned char *text = (unsigned char *)fuzz_text(bytes, size), *written = NULL;
    const ad_status status = table_from_csv(&wanted, text, size, &table, &error);
    free(text);
    if (status != AD_OK) {
        return 0;
    }
    const char **names = calloc(table->columns, sizeof *names);
    fuzz_require(names);
    for (size_t k = 0; k < table->columns; k++) {
        names[k] = table->names[k];
    }
    const table_source source = {.names = names,
                                 .columns = (const double *const *)table->values,
                                 .words = (const char *const *const *)table->pointers,
                                 .ncols = table->columns,
                                 .nrows = table->rows,
                                 .units = names};
    archive a = {0};
    fuzz_require(table_fits_npz(&source));
    fuzz_require(table_to_npz(&source, &written, &a.size) == AD_OK);
    a.bytes = written;
    check_columns(&a, table);
    check_directory(&a);
    free(written);
    free(names);
    table_free(table);
    return 0;
}
