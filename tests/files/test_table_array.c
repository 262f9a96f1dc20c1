/* Tables from NumPy's arrays: of every type of number and either order they have the numbers that
 * were put in; what is cut off, damaged, or holds none is refused in one line. Comparisons are
 * exact: all numbers are floats of 4 bytes. */
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
#include "tools/files/table_file.h"
#include "tools/files/zip.h"

enum { BYTES = 2048 };

typedef struct npy {
    unsigned char bytes[BYTES];
    size_t size;
} npy;

static void put(npy *to, const void *bytes, size_t size)
{
    assert_true(to->size + size <= BYTES);
    memcpy(to->bytes + to->size, bytes, size);
    to->size += size;
}

/* A number of a type as NumPy names it: "<f8", ">i2". */
static void put_number(npy *to, const char *type, double value)
{
    unsigned char bytes[8];
    const size_t size = (size_t)(type[2] - '0');
    const float narrow = (float)value;
    int64_t whole = (int64_t)value;
    memcpy(bytes, type[1] == 'f' ? (size == 8 ? (void *)&value : (void *)&narrow) : (void *)&whole,
           size);
    for (size_t i = 0; i < size; i++) {
        put(to, &bytes[*type == '>' ? size - 1 - i : i], 1);
    }
}

static npy header(int version, const char *text)
{
    npy made = {.size = 0};
    const unsigned char begin[8] = {0x93, 'N', 'U', 'M', 'P', 'Y', (unsigned char)version, 0};
    const unsigned char length[4] = {(unsigned char)(strlen(text) + 1)};
    put(&made, begin, sizeof begin);
    put(&made, length, version == 1 ? 2 : 4);
    put(&made, text, strlen(text));
    put(&made, "\n", 1);
    return made;
}

/* value[i][j][k] of 2 x 3 x 2 */
static double value(const char *type, int i, int j, int k)
{
    const double whole = 10 * i + 3 * j + k + 1;
    return type[1] == 'f' ? whole / 4 : type[1] == 'i' ? 20 - 3 * whole : whole;
}

static npy array(int version, const char *type, bool by_columns)
{
    char text[100];
    snprintf(text, sizeof text, "{'descr': '%s', 'fortran_order': %s, 'shape': (2, 3, 2), }", type,
             by_columns ? "True" : "False");
    npy made = header(version, text);
    for (int n = 0; n < 12; n++) {
        const int i = by_columns ? n % 2 : n / 6, j = n / 2 % 3, k = by_columns ? n / 6 : n % 2;
        put_number(&made, type, value(type, i, j, k));
    }
    return made;
}

static ad_status read_bytes(const char *file, const void *bytes, size_t size, table_file **table,
                            ad_error *error)
{
    FILE *to = fopen(at(file), "wb"); /* without waiting for the disk */
    assert_non_null(to);
    assert_int_equal(fwrite(bytes, 1, size, to), size);
    fclose(to);
    return table_read(at(file), TABLE_MEASURED, table, error);
}

static void types_and_orders(void **state)
{
    (void)state;
    static const char *const types[] = {"<f8", ">f8", "<f4", ">f4", "<i2",
                                        ">i8", "|u1", "<u4", "|i1"};
    for (size_t n = 0; n < 2 * sizeof types / sizeof *types; n++) {
        ad_error error = {.message = ""};
        table_file *table;
        const npy a = array(1 + (int)(n % 3), types[n / 2], n % 2);
        if (read_bytes("a.npy", a.bytes, a.size, &table, &error) != AD_OK) {
            fail_msg("%s: %s", types[n / 2], error.message);
        }
        assert_int_equal(table_rows(table), 6);
        assert_int_equal(table_inner(table), 3);
        assert_int_equal(table_columns(table), 2);
        for (int row = 0; row < 6; row++) {
            assert_true(table_column(table, "c1")[row] == value(types[n / 2], row / 3, row % 3, 0));
            assert_true(table_column(table, "c2")[row] == value(types[n / 2], row / 3, row % 3, 1));
        }
        table_free(table);
    }
}

static void refuse(const char *file, const void *bytes, size_t size, const char *message)
{
    ad_error error = {.message = ""};
    table_file *table;
    assert_int_equal(read_bytes(file, bytes, size, &table, &error), AD_BAD_INPUT);
    assert_null(table);
    assert_null(strchr(error.message, '\n'));
    if (!strstr(error.message, message)) {
        fail_msg("'%s' is not in '%s'", message, error.message);
    }
}

static void refuse_header(const char *text, const char *message)
{
    npy a = header(1, text);
    put(&a, (const double[4]){0}, 32);
    refuse("a.npy", a.bytes, a.size, message);
}

static void refusals(void **state)
{
    (void)state;
    static const char cut[] = "is cut off: it has fewer numbers than its shape says";
    static const char none[] = "holds no real numbers; allowed: floats of 4 or 8 bytes";
    static const char damaged[] = "has a damaged header";
    const npy whole = array(1, "<f8", false);
    for (size_t size = 0; size < whole.size; size++) { /* wherever it is cut */
        refuse("a.npy", whole.bytes, size,
               size < 10                ? "is no NumPy array"
               : size < whole.size - 96 ? damaged
                                        : cut);
    }
    refuse_header("{'descr': '<c16', 'fortran_order': False, 'shape': (2,), }", none);
    refuse_header("{'descr': '|O', 'fortran_order': False, 'shape': (2,), }", none);
    refuse_header("{'descr': [('a', '<f8')], 'fortran_order': False, 'shape': (2,), }", none);
    refuse_header("{'descr': '<f16', 'fortran_order': False, 'shape': (2,), }", none);
    refuse_header("{'descr': '<f8', 'fortran_order': False, 'shape': (1, 1, 1, 1), }",
                  "has more than 3 dimensions");
    refuse_header("{'descr': '<f8', 'fortran_order': False, 'shape': (0, 3), }", "is empty");
    refuse_header("{'descr': '<f8', 'fortran_order': False, 'shape': (1, 4000), }", cut);
    refuse_header("{'descr': '<f8', 'fortran_order': False, 'shape': (4294967296, 4294967296), }",
                  cut);
    refuse_header("{'descr': '<f8', 'fortran_order': False, 'shape': (-2,), }", damaged);
    refuse_header("{'descr': '<f8', 'fortran_order': False, 'shape': (2, }", damaged);
    refuse_header("{'descr': '<f8', 'shape': (2,), }", damaged);
    refuse_header("", damaged);
}

/* ---- archives ------------------------------------------------------------------------------ */

/* Arrays of 2 x 3 x 2 and of 2, one number, a text, and one of other rows. */
static unsigned char *archive(size_t *size)
{
    static const char *const names[] = {"p", "time", "rate", "made_by", "other"};
    npy parts[5] = {array(1, "<f8", false),
                    header(1, "{'descr': '<f8', 'fortran_order': False, 'shape': (2,), }"),
                    header(1, "{'descr': '<f8', 'fortran_order': False, 'shape': (), }"),
                    header(1, "{'descr': '<U1', 'fortran_order': False, 'shape': (1,), }"),
                    header(1, "{'descr': '<f8', 'fortran_order': False, 'shape': (1,), }")};
    put(&parts[1], (const double[]){0.5, 1.5}, 16);
    put(&parts[2], (const double[]){100}, 8);
    put(&parts[3], "a\0\0", 4);
    put(&parts[4], (const double[]){7}, 8);
    zip z = {.bytes = NULL};
    unsigned char *bytes;
    for (int i = 0; i < 5; i++) {
        char name[20];
        snprintf(name, sizeof name, "%s.npy", names[i]);
        zip_begin(&z, name);
        zip_put(&z, parts[i].bytes, parts[i].size);
        zip_end(&z);
    }
    assert_true(zip_finish(&z, &bytes, size));
    return bytes;
}

static void archives(void **state)
{
    (void)state;
    size_t size;
    table_file *table;
    ad_error error = {.message = ""};
    const double *column;
    unsigned char *bytes = archive(&size);
    assert_int_equal(read_bytes("a.npz", bytes, size, &table, &error), AD_OK);
    assert_int_equal(table_rows(table), 6);
    for (int row = 0; row < 6; row++) {
        assert_true(table_column(table, "p_2")[row] == value("<f8", row / 3, row % 3, 1));
        assert_true(table_column(table, "time")[row] == (row < 3 ? 0.5 : 1.5));
        assert_true(table_column(table, "rate")[row] == 100);
    }
    assert_int_equal(table_find(table, "made_by", TABLE_MEASURED, &column, &error), AD_BAD_INPUT);
    assert_non_null(strstr(error.message, "a.npz: the array 'made_by' holds no real numbers"));
    assert_int_equal(table_find(table, "other", TABLE_MEASURED, &column, &error), AD_BAD_INPUT);
    assert_non_null(strstr(error.message, "has 1 rows, of others the file has 2 by 3"));
    table_free(table);
    for (size_t cut = 0; cut < size; cut++) {
        assert_int_equal(read_bytes("a.npz", bytes, cut, &table, &error), AD_BAD_INPUT);
    }
    bytes[200] ^= 1; /* a number of the first array */
    refuse("a.npz", bytes, size, "has an entry whose checksum is wrong");
    free(bytes);
}

/* One entry, "x.npy" of the numbers 1 and 2, that zlib has deflated. */
static void deflated(void **state)
{
    (void)state;
    static const unsigned char bytes[] = {
        80,  75,  3,   4,   20,  0,   0,   0,   8,   0,   0,   0,   33,  0,   119, 54,  111,
        185, 74,  0,   0,   0,   84,  0,   0,   0,   5,   0,   0,   0,   120, 46,  110, 112,
        121, 155, 236, 23,  234, 27,  16,  201, 200, 96,  197, 80,  173, 158, 146, 90,  156,
        92,  164, 110, 165, 160, 110, 147, 102, 161, 174, 163, 160, 158, 150, 95,  84,  82,
        148, 152, 23,  159, 95,  148, 146, 10,  18,  119, 75,  204, 41,  78,  5,   138, 23,
        103, 36,  22,  164, 2,   249, 26,  70,  58,  154, 58,  10,  181, 92,  12,  96,  240,
        193, 30,  66,  51,  56,  0,   0,   80,  75,  1,   2,   20,  3,   20,  0,   0,   0,
        8,   0,   0,   0,   33,  0,   119, 54,  111, 185, 74,  0,   0,   0,   84,  0,   0,
        0,   5,   0,   0,   0,   0,   0,   0,   0,   0,   0,   0,   0,   128, 1,   0,   0,
        0,   0,   120, 46,  110, 112, 121, 80,  75,  5,   6,   0,   0,   0,   0,   1,   0,
        1,   0,   51,  0,   0,   0,   109, 0,   0,   0,   0,   0};
    table_file *table;
    ad_error error = {.message = ""};
    if (read_bytes("a.npz", bytes, sizeof bytes, &table, &error) != AD_OK) {
        fail_msg("%s", error.message);
    }
    assert_int_equal(table_rows(table), 2);
    assert_true(table_column(table, "x")[0] == 1 && table_column(table, "x")[1] == 2);
    table_free(table);
}

/* ---- CSV ----------------------------------------------------------------------------------- */

static void csv_without_header(void **state)
{
    (void)state;
    table_file *table;
    ad_error error = {.message = ""};
    static const char numbers[] = "# by a camera\n0,0.5,\n1,,2.5\n",
                      index[] = ",x [m/s],y\n0,1,2\n";
    assert_int_equal(read_bytes("a.csv", numbers, strlen(numbers), &table, &error), AD_OK);
    assert_int_equal(table_rows(table), 2);
    assert_true(table_column(table, "c2")[0] == 0.5 && table_column(table, "c3")[1] == 2.5);
    assert_true(isnan(table_column(table, "c3")[0]) && isnan(table_column(table, "c2")[1]));
    assert_int_equal(table_line(table, 0), 2);
    table_free(table);
    assert_int_equal(read_bytes("a.csv", index, strlen(index), &table, &error), AD_OK);
    assert_true(table_column(table, "c2")[0] == 1 && table_column(table, "y")[0] == 2);
    table_free(table);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test_setup_teardown(types_and_orders, make_directory, remove_directory),
        cmocka_unit_test_setup_teardown(refusals, make_directory, remove_directory),
        cmocka_unit_test_setup_teardown(archives, make_directory, remove_directory),
        cmocka_unit_test_setup_teardown(deflated, make_directory, remove_directory),
        cmocka_unit_test_setup_teardown(csv_without_header, make_directory, remove_directory),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
