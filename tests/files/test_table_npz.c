/* Tables as .npz: every byte of the archive is where the descriptions of zip and of NumPy's arrays
 * put it. Units of columns, there and in HDF5. Comparisons are exact, so there are no tolerances.
 */
#include <hdf5.h>
#include <math.h>
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>

#include <cmocka.h>

#include "temporary_folder.h"
#include "tools/files/file_bytes.h"
#include "tools/files/table_file.h"

enum { ROWS = 3 };
static const double first[ROWS] = {0.1, -2.5e-308, 1e300};
static const double second[ROWS] = {-0.0, INFINITY, NAN};
static const char *const methods[ROWS] = {"pinn", "L\xc3\xb6sung",
                                          ("\xe2\x82\xac"
                                           "5")};
static const char *const names[] = {"s", "method", "u1"};
static const char *const units[] = {"m", "", "1/m"};
static const double *const columns[] = {first, NULL, second};
static const char *const *const words[] = {NULL, methods, NULL};

static const table_source table = {names, columns, words, 3, ROWS, units};

/* ---- a reader of its own ------------------------------------------------------------------- */

static uint64_t number_at(const unsigned char *at, int count)
{
    uint64_t number = 0;
    while (count-- > 0) {
        number = number << 8 | at[count];
    }
    return number;
}

/* CRC-32 bit by bit. */
static uint32_t crc_of(const void *bytes, size_t size)
{
    uint32_t crc = 0xFFFFFFFF;
    for (size_t i = 0; i < 8 * size; i++) {
        uint32_t bit = ((const unsigned char *)bytes)[i / 8] >> i % 8 & 1;
        crc = crc >> 1 ^ ((crc ^ bit) & 1 ? 0xEDB88320 : 0);
    }
    return ~crc;
}

/* The entry at *at, which moves behind it: its name and the array's bytes. Checks the header. */
static const unsigned char *take_entry(const unsigned char **at, const char *name, size_t *size)
{
    const unsigned char *header = *at;
    size_t length = strlen(name);
    *size = number_at(header + 18, 4);
    assert_int_equal(number_at(header, 4), 0x04034b50);
    assert_int_equal(number_at(header + 4, 2), 20);        /* version needed: 2.0 */
    assert_int_equal(number_at(header + 8, 2), 0);         /* stored */
    assert_int_equal(number_at(header + 10, 4), 0x210000); /* 1980-01-01, 0:00 */
    assert_int_equal(number_at(header + 22, 4), *size);
    assert_int_equal(number_at(header + 26, 2), length);
    assert_int_equal(number_at(header + 28, 2), 0);
    assert_memory_equal(header + 30, name, length);
    const unsigned char *array = header + 30 + length;
    assert_int_equal(number_at(header + 14, 4), crc_of(array, *size));
    *at = array + *size;
    return array;
}

/* The data of an array of `rows` of that type; version 1.0 with a header of 128 bytes. */
static const unsigned char *array_data(const unsigned char *array, const char *type, int rows)
{
    char text[119];
    int length = snprintf(text, sizeof text,
                          "{'descr': '%s', 'fortran_order': False, 'shape': (%d,), }", type, rows);
    memset(text + length, ' ', sizeof text - (size_t)length);
    text[117] = '\n';
    assert_memory_equal(array, "\x93NUMPY\x01\x00\x76\x00", 10);
    assert_memory_equal(array + 10, text, 118);
    return array + 128;
}

static void assert_text(const unsigned char *at, size_t width, const uint32_t *expected)
{
    for (size_t i = 0; i < width; i++) {
        assert_int_equal(number_at(at + 4 * i, 4), *expected);
        expected += *expected != 0;
    }
}

/* ---- tests --------------------------------------------------------------------------------- */

static void every_byte(void **state)
{
    (void)state;
    static const char *const entries[] = {"s.npy", "method.npy", "u1.npy", "columns.npy",
                                          "units.npy"};
    ad_error error = {AD_OK, ""};
    unsigned char *bytes;
    size_t size, whole, file_size;
    assert_int_equal(crc_of("123456789", 9), 0xCBF43926); /* the check value of CRC-32 */
    assert_int_equal(table_write(at("t.npz"), &table, &error), AD_OK);
    assert_int_equal(file_bytes_read(at("t.npz"), 0, &bytes, &whole, &file_size, NULL), AD_OK);

    const unsigned char *p = bytes, *array = take_entry(&p, "s.npy", &size);
    assert_int_equal(size, 128 + 8 * ROWS);
    assert_memory_equal(array_data(array, "<f8", ROWS), first, sizeof first);
    array = take_entry(&p, "method.npy", &size);
    assert_int_equal(size, 128 + 4 * 7 * ROWS);
    const unsigned char *data = array_data(array, "<U7", ROWS); /* 7: bytes of the longest */
    assert_text(data, 7, (const uint32_t[]){'p', 'i', 'n', 'n', 0});
    assert_text(data + 28, 7, (const uint32_t[]){'L', 0xF6, 's', 'u', 'n', 'g', 0});
    assert_text(data + 56, 7, (const uint32_t[]){0x20AC, '5', 0});
    array = take_entry(&p, "u1.npy", &size);
    assert_memory_equal(array_data(array, "<f8", ROWS), second, sizeof second);
    data = array_data(take_entry(&p, "columns.npy", &size), "<U6", 3);
    assert_text(data + 24, 6, (const uint32_t[]){'m', 'e', 't', 'h', 'o', 'd', 0});
    data = array_data(take_entry(&p, "units.npy", &size), "<U3", 3);
    assert_text(data, 3, (const uint32_t[]){'m', 0});
    assert_text(data + 12, 3, (const uint32_t[]){0});
    assert_text(data + 24, 3, (const uint32_t[]){'1', '/', 'm', 0});

    size_t directory = (size_t)(p - bytes);
    for (int i = 0; i < 5; i++) {
        const unsigned char *local = bytes + number_at(p + 42, 4);
        assert_int_equal(number_at(p, 4), 0x02014b50);
        assert_memory_equal(p + 6, local + 4, 26); /* from the version needed on */
        assert_memory_equal(p + 46, entries[i], strlen(entries[i]));
        assert_memory_equal(local + 30, entries[i], strlen(entries[i]));
        p += 46 + strlen(entries[i]);
    }
    assert_int_equal(number_at(p, 4), 0x06054b50);
    assert_int_equal(number_at(p + 8, 2), 5);
    assert_int_equal(number_at(p + 10, 2), 5);
    assert_int_equal(number_at(p + 12, 4), (size_t)(p - bytes) - directory);
    assert_int_equal(number_at(p + 16, 4), directory);
    assert_int_equal((size_t)(p - bytes) + 22, whole);
    free(bytes);
}

static void without_rows_and_units(void **state)
{
    (void)state;
    table_source bare = table;
    unsigned char *bytes;
    size_t size, whole, file_size;
    bare.units = NULL;
    bare.nrows = 0;
    assert_int_equal(table_write(at("t.npz"), &bare, NULL), AD_OK);
    assert_int_equal(file_bytes_read(at("t.npz"), 0, &bytes, &whole, &file_size, NULL), AD_OK);
    const unsigned char *p = bytes;
    array_data(take_entry(&p, "s.npy", &size), "<f8", 0);
    array_data(take_entry(&p, "method.npy", &size), "<U1", 0);
    array_data(take_entry(&p, "u1.npy", &size), "<f8", 0);
    assert_int_equal(number_at(p, 4), 0x02014b50);
    free(bytes);
}

static void refusals(void **state)
{
    (void)state;
    ad_error error = {AD_OK, ""};
    table_file *read;
    table_source huge = table;
    huge.nrows = (size_t)1 << 29; /* 4 GiB of one column; nothing is read of them */
    assert_int_equal(table_write(at("t.npz"), &huge, &error), AD_BAD_ARGUMENT);
    assert_non_null(strstr(error.message, "536870912 x 3 numbers are more than 4 GiB; allowed"));
    assert_int_equal(entries(0), 0);
    assert_int_equal(table_write(at("t.npz"), &table, &error), AD_OK);
    assert_int_equal(table_read(at("t.npz"), TABLE_FINITE, &read, &error), AD_BAD_INPUT);
    assert_non_null(strstr(error.message, "column 'u1' row 2 is not finite"));
    assert_null(read);
    assert_int_equal(table_write(at("t.npy"), &table, &error), AD_BAD_ARGUMENT);
    assert_non_null(strstr(error.message, "allowed: .csv, .h5, .hdf5, .npz"));
}

/* The attribute of each dataset; the table reads back as if it were not there. */
static void units_in_hdf5(void **state)
{
    (void)state;
    table_file *read;
    assert_int_equal(table_write(at("t.h5"), &table, NULL), AD_OK);
    hid_t file = H5Fopen(at("t.h5"), H5F_ACC_RDONLY, H5P_DEFAULT);
    for (int i = 0; i < 3; i++) {
        char unit[16] = "";
        hid_t attribute = H5Aopen_by_name(file, names[i], "units", H5P_DEFAULT, H5P_DEFAULT);
        hid_t type = H5Aget_type(attribute);
        assert_true(H5Aread(attribute, type, unit) >= 0);
        assert_string_equal(unit, units[i]);
        H5Tclose(type);
        H5Aclose(attribute);
    }
    H5Fclose(file);
    assert_int_equal(table_read_words(at("t.h5"), TABLE_NONFINITE,
                                      (const char *const[]){"method", NULL}, &read, NULL),
                     AD_OK);
    assert_memory_equal(table_column(read, "u1"), second, sizeof second);
    assert_string_equal(table_words(read, "method")[1], methods[1]);
    table_free(read);
}

int main(void)
{
#define TEST(function) cmocka_unit_test_setup_teardown(function, make_directory, remove_directory)
    const struct CMUnitTest tests[] = {
        TEST(every_byte),
        TEST(without_rows_and_units),
        TEST(refusals),
        TEST(units_in_hdf5),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
