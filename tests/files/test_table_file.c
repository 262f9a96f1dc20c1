/* Tables come back to the last bit, and a file that is not one is refused with one line that names
 * the place. Comparisons are exact, so there are no tolerances. */
#include <dirent.h>
#include <fcntl.h>
#include <hdf5.h>
#include <locale.h>
#include <math.h>
#include <setjmp.h>
#include <signal.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/resource.h>
#include <sys/stat.h>
#include <sys/wait.h>
#include <unistd.h>

#include <cmocka.h>

#include "temporary_folder.h"
#include "tools/files/file_bytes.h"
#include "tools/files/table_file.h"

static void spill(const char *path, const void *bytes, size_t size)
{
    FILE *file = fopen(path, "wb");
    assert_non_null(file);
    assert_int_equal(fwrite(bytes, 1, size, file), size);
    assert_int_equal(fclose(file), 0);
}

static unsigned char *slurp(const char *path, size_t *size)
{
    unsigned char *bytes = NULL;
    size_t file_size = 0;
    assert_int_equal(file_bytes_read(path, 0, &bytes, size, &file_size, NULL), AD_OK);
    return bytes;
}

static ad_status write_words(const char *path, const char *const *names,
                             const double *const *columns, const char *const *const *words,
                             size_t ncols, size_t nrows, ad_error *error)
{
    const table_source table = {names, columns, words, ncols, nrows, NULL};
    return table_write(path, &table, error);
}

/* Numbers without units. */
static ad_status write_table(const char *path, const char *const *names,
                             const double *const *columns, size_t ncols, size_t nrows,
                             ad_error *error)
{
    return write_words(path, names, columns, NULL, ncols, nrows, error);
}

static table_file *read_or_fail(const char *path, table_numbers numbers)
{
    ad_error error = {AD_OK, ""};
    table_file *table;
    if (table_read(path, numbers, &table, &error) != AD_OK) {
        fail_msg("%s", error.message);
    }
    return table;
}

/* The file must be refused by a message that has `reason` in it and starts with the path. */
static void assert_refused(const char *path, const char *reason)
{
    ad_error error = {AD_OK, ""};
    table_file *table;
    ad_status status = table_read(path, TABLE_FINITE, &table, &error);
    assert_null(table);
    assert_true(status == AD_BAD_INPUT || status == AD_IO);
    assert_null(strchr(error.message, '\n'));
    if (!strstr(error.message, reason) || strncmp(error.message, path, strlen(path)) != 0) {
        fail_msg("'%s' names neither '%s' nor '%s'", error.message, path, reason);
    }
}

static void assert_csv_refused(const char *text, const char *reason)
{
    spill(at("bad.csv"), text, strlen(text));
    assert_refused(at("bad.csv"), reason);
}

/* ---- both formats ---- */

static const double first[] = {0.1, -0.0, 5e-324, 1.7976931348623157e308, 1.0 / 3.0, 1e22};
static const double second[] = {1, -2.2250738585072014e-308, 123456789.125, -1e-5, 0.3, 4e15};
#define ROWS (sizeof first / sizeof *first)

static void round_trip_is_exact(void **state)
{
    (void)state;
    static const char *const endings[] = {"t.csv", "t.h5", "t.hdf5"};
    /* Not in the order of the alphabet, to see that order is kept; one might be taken for a number.
     */
    const char *const names[] = {"e1", "arc length [m]"};
    const double *const columns[] = {first, second};
    for (size_t k = 0; k < 3; k++) {
        ad_error error = {AD_OK, ""};
        for (size_t rows = 0; rows <= ROWS; rows += ROWS) {
            if (write_table(at(endings[k]), names, columns, 2, rows, &error) != AD_OK) {
                fail_msg("%s", error.message);
            }
            table_file *table = read_or_fail(at(endings[k]), TABLE_FINITE);
            assert_int_equal(table_rows(table), rows);
            assert_int_equal(table_columns(table), 2);
            assert_string_equal(table_name(table, 0), names[0]);
            assert_string_equal(table_name(table, 1), "arc length [m]");
            assert_null(table_column(table, "absent"));
            assert_memory_equal(table_column(table, names[0]), first, rows * sizeof *first);
            assert_memory_equal(table_column(table, "arc length [m]"), second,
                                rows * sizeof *first);
            table_free(table);
        }
    }
    assert_int_equal(entries(0), 3);
    table_free(NULL);
}

static void numbers_that_are_not_finite(void **state)
{
    (void)state;
    static const char *const files[] = {"n.csv", "n.h5"};
    static const char *const places[] = {":3:1: 'nan': the field is not finite",
                                         "column 'x' row 2: nan is not finite"};
    const double x[] = {1.0, NAN, INFINITY, -INFINITY};
    const char *const names[] = {"x"};
    const double *const columns[] = {x};
    for (size_t k = 0; k < 2; k++) {
        assert_int_equal(write_table(at(files[k]), names, columns, 1, 4, NULL), AD_OK);
        assert_refused(at(files[k]), places[k]);
        table_file *table = read_or_fail(at(files[k]), TABLE_NONFINITE);
        const double *back = table_column(table, "x");
        assert_true(back[0] == 1.0 && isnan(back[1]));
        assert_true(back[2] == INFINITY && back[3] == -INFINITY);
        table_free(table);
    }
}

static void bad_writes(void **state)
{
    (void)state;
    ad_error error = {AD_OK, ""};
    const double *const columns[] = {first, second};
    static const char *const bad[] = {"",    "1.5", " x",  "a,b",          "a/b", "#a",
                                      "a\"", ".",   "a\n", "\xef\xbb\xbf", "same"};
    for (size_t k = 0; k < sizeof bad / sizeof *bad; k++) {
        const char *const names[] = {"same", bad[k]};
        assert_int_equal(write_table(at("t.csv"), names, columns, 2, 1, &error), AD_BAD_ARGUMENT);
    }
    assert_non_null(strstr(error.message, "columns 1 and 2 are both named 'same'"));
    const char *const names[] = {"a", "b"};
    assert_int_equal(write_table(at("t.txt"), names, columns, 2, 1, &error), AD_BAD_ARGUMENT);
    assert_non_null(strstr(error.message, "allowed: .csv, .h5, .hdf5, .npz"));
    assert_int_equal(write_table(at("t.csv"), names, columns, 0, 1, &error), AD_BAD_ARGUMENT);
    assert_int_equal(write_table(at("no/t.csv"), names, columns, 2, 1, &error), AD_IO);
    assert_int_equal(entries(0), 0);

    /* A limit on the size of files stands for a full disk. */
    assert_int_equal(write_table(at("t.h5"), names, columns, 2, 1, &error), AD_OK);
    struct rlimit old, small;
    getrlimit(RLIMIT_FSIZE, &old);
    small = old;
    small.rlim_cur = 100;
    signal(SIGXFSZ, SIG_IGN);
    setrlimit(RLIMIT_FSIZE, &small);
    ad_status status = write_table(at("t.h5"), names, columns, 2, ROWS, &error);
    setrlimit(RLIMIT_FSIZE, &old);
    signal(SIGXFSZ, SIG_DFL);
    assert_int_equal(status, AD_NOT_WRITTEN);
    assert_int_equal(entries(0), 1);
    table_file *table = read_or_fail(at("t.h5"), TABLE_FINITE);
    assert_int_equal(table_rows(table), 1);
    table_free(table);
}

static void other_files(void **state)
{
    (void)state;
    assert_refused(at("missing.csv"), "No such file");
    assert_refused(at("missing.h5"), "No such file");
    assert_refused(at("t.txt"), "allowed: .csv, .h5, .hdf5");
    assert_refused(at("csv"), "allowed: .csv, .h5, .hdf5");
    assert_int_equal(mkdir(at("folder.csv"), 0700), 0);
    assert_refused(at("folder.csv"), "is a directory");
}

/* ---- CSV ---- */

static void csv_forms(void **state)
{
    (void)state;
    static const char *const texts[] = {
        "x,y\n1,2\n-3.5,4e1\n",
        "x,y\n1,2\n-3.5,4e1",
        "\xef\xbb\xbfx,y\r\n1,2\r\n-3.5,4e1\r\n",
        "# comment\n\n  # another, one\n x ,\ty\n 1 , +2\n# between\n\n-3.50,\t40.\t\n \n",
    };
    for (size_t k = 0; k < sizeof texts / sizeof *texts; k++) {
        spill(at("t.csv"), texts[k], strlen(texts[k]));
        table_file *table = read_or_fail(at("t.csv"), TABLE_FINITE);
        assert_int_equal(table_rows(table), 2);
        const double *x = table_column(table, "x"), *y = table_column(table, "y");
        assert_true(x[0] == 1.0 && x[1] == -3.5 && y[0] == 2.0 && y[1] == 40.0);
        table_free(table);
    }
}

static void csv_words(void **state)
{
    (void)state;
    const char text[] = "x\nNaN\n+Inf\n-infinity\n1e-400\n4.9e-324\n";
    spill(at("t.csv"), text, strlen(text));
    table_file *table = read_or_fail(at("t.csv"), TABLE_NONFINITE);
    const double *x = table_column(table, "x");
    assert_true(isnan(x[0]) && x[1] == INFINITY && x[2] == -INFINITY && x[3] == 0.0);
    assert_true(x[4] == 5e-324);
    table_free(table);
}

static void csv_refusals_name_the_place(void **state)
{
    (void)state;
    assert_csv_refused("", ":1:1: the file has no line");
    assert_csv_refused("\n# only\n", ":1:1: the file has no line");
    assert_csv_refused("1,2\n3,4\n", ":1:1: '1': a number stands where the name");
    assert_csv_refused("x,,y\n", ":1:3: '': a column has no name");
    assert_csv_refused("x,y,\n", ":1:5: '': a column has no name");
    assert_csv_refused("x, y,x\n1,2,3\n", ":1:6: 'x': a column of this name");
    assert_csv_refused("\"x\",y\n", ":1:1: '\"x\"': the name of a column has a comma, quote");
    assert_csv_refused("x,y\n1,2\n1\n", ":3:2: the row has 1 fields; allowed: 2");
    assert_csv_refused("x,y\n1,2,3\n", ":2:6: the row has 3 fields; allowed: 2");
    assert_csv_refused("x,y,z\n1,,\n", ":2:3: '': the field is empty");
    assert_csv_refused("x,y\n1, two\n", ":2:4: 'two': the field is not a number; allowed: a dec");
    assert_csv_refused("x,y\n1,0x10\n", ":2:3: '0x10': the field is not a number");
    assert_csv_refused("x\n1.5.2\n", ":2:1: '1.5.2': the field is not a number");
    assert_csv_refused("x\n1 2\n", ":2:1: '1 2': the field is not a number");
    assert_csv_refused("x\n1;2\n", "is not a number");
    assert_csv_refused("x\n-\n", "is not a number");
    assert_csv_refused("x\nnan(1)\n", "is not a number");
    assert_csv_refused("x\ninfinit\n", "is not a number");
    assert_csv_refused("x\n1e999\n", ":2:1: '1e999': the field is too large for a double");
    assert_csv_refused("x,y\n1,-inf\n", ":2:3: '-inf': the field is not finite");
    assert_csv_refused("x\n1\n\x01\n", ":3:1: '?': the field is not a number");
    spill(at("zero.csv"), "x\n1\n2\0\n", 7);
    assert_refused(at("zero.csv"), ":3:1: '2?': the field is not a number");
}

static void csv_limits(void **state)
{
    (void)state;
    static char text[80000];
    strcpy(text, "x\n1\n");
    memset(text + 4, '1', 70000);
    assert_csv_refused(text, ":3:65537: the line is too long; allowed: 65536 bytes");
    memset(text, 0, sizeof text);
    strcpy(text, "x\n");
    memset(text + 2, '1', 200);
    assert_csv_refused(text, "the field is longer than 127 bytes");
    memset(text, 0, sizeof text);
    memset(text, 'n', 64);
    assert_csv_refused(text, "longer than 63 bytes");
    memset(text, ',', 1024);
    assert_csv_refused(text, ":1:1: too many columns; allowed: 1024");
    /* A long path must not push the reason out of the message. */
    char path[500];
    memset(path, 'p', sizeof path);
    strcpy(path + 490, ".csv");
    ad_error error;
    table_file *table;
    assert_int_equal(table_read(path, TABLE_FINITE, &table, &error), AD_IO);
    assert_non_null(strstr(error.message, "cannot be opened: File name too long"));
}

static void csv_ignores_the_locale(void **state)
{
    (void)state;
    static const char *const commas[] = {"de_DE.UTF-8", "fr_FR.UTF-8", "de_DE", "fr_FR"};
    const char *found = NULL;
    for (size_t k = 0; !found && k < sizeof commas / sizeof *commas; k++) {
        found = setlocale(LC_ALL, commas[k]);
    }
    if (!found) {
        skip(); /* no locale with a decimal comma is installed */
    }
    const char *const names[] = {"x"};
    const double *const columns[] = {first};
    assert_int_equal(write_table(at("t.csv"), names, columns, 1, ROWS, NULL), AD_OK);
    table_file *table = read_or_fail(at("t.csv"), TABLE_FINITE);
    assert_memory_equal(table_column(table, "x"), first, sizeof first);
    table_free(table);
    assert_string_equal(localeconv()->decimal_point, ",");
    setlocale(LC_ALL, "C");
}

static void csv_numbers_are_short(void **state)
{
    (void)state;
    const double x[] = {0.1, 100.0, 1.0 / 3.0};
    const char *const names[] = {"x", "y"};
    const double *const columns[] = {x, x};
    size_t size;
    assert_int_equal(write_table(at("t.csv"), names, columns, 2, 3, NULL), AD_OK);
    unsigned char *bytes = slurp(at("t.csv"), &size);
    assert_string_equal((char *)bytes, "x,y\n0.1,0.1\n100,100\n0.3333333333333333,"
                                       "0.3333333333333333\n");
    free(bytes);
}

/* ---- HDF5 of other writers ---- */

typedef struct foreign {
    hid_t type;
    int rank;
    hsize_t shape[2], chunk;
    int deflate;
} foreign;

/* A file with the double column "x" of 3 rows and an object "y" as described. */
static hid_t write_foreign(const char *path, const foreign *what)
{
    const hsize_t three = 3;
    const double values[] = {1.0, 2.0, 3.0};
    hid_t file = H5Fcreate(path, H5F_ACC_TRUNC, H5P_DEFAULT, H5P_DEFAULT);
    hid_t space = H5Screate_simple(1, &three, NULL);
    hid_t x =
        H5Dcreate2(file, "x", H5T_NATIVE_DOUBLE, space, H5P_DEFAULT, H5P_DEFAULT, H5P_DEFAULT);
    H5Dwrite(x, H5T_NATIVE_DOUBLE, H5S_ALL, H5S_ALL, H5P_DEFAULT, values);
    H5Dclose(x);
    H5Sclose(space);
    if (what) {
        hid_t creation = H5Pcreate(H5P_DATASET_CREATE);
        if (what->chunk > 0) {
            H5Pset_chunk(creation, 1, &what->chunk);
        }
        if (what->deflate) {
            H5Pset_deflate(creation, 9);
        }
        space =
            what->rank ? H5Screate_simple(what->rank, what->shape, NULL) : H5Screate(H5S_SCALAR);
        hid_t y = H5Dcreate2(file, "y", what->type, space, H5P_DEFAULT, creation, H5P_DEFAULT);
        H5Dclose(y);
        H5Sclose(space);
        H5Pclose(creation);
    }
    return file;
}

static void hdf5_shapes(void **state)
{
    (void)state;
    const struct {
        foreign what;
        const char *reason;
    } cases[] = {
        {{H5T_IEEE_F32LE, 1, {3, 0}, 0, 0}, "column 'y' is not float64"},
        {{H5T_STD_I64LE, 1, {3, 0}, 0, 0}, "column 'y' is not float64"},
        {{H5T_C_S1, 1, {3, 0}, 0, 0}, "column 'y' is not float64"},
        {{H5T_IEEE_F64LE, 2, {3, 1}, 0, 0}, "column 'y' is not one-dimensional"},
        {{H5T_IEEE_F64LE, 0, {0, 0}, 0, 0}, "column 'y' is not one-dimensional"},
        {{H5T_IEEE_F64LE, 1, {4, 0}, 0, 0}, "has another length than the first"},
        {{H5T_IEEE_F64LE, 1, {1000000000, 0}, 0, 0}, "more rows than the file can hold"},
        {{H5T_IEEE_F64LE, 1, {1000000000000, 0}, 1000, 0}, "more rows than the file can hold"},
    };
    for (size_t k = 0; k < sizeof cases / sizeof *cases; k++) {
        H5Fclose(write_foreign(at("f.h5"), &cases[k].what));
        assert_refused(at("f.h5"), cases[k].reason);
    }
    hid_t file = write_foreign(at("f.h5"), NULL);
    H5Gclose(H5Gcreate2(file, "y", H5P_DEFAULT, H5P_DEFAULT, H5P_DEFAULT));
    H5Fclose(file);
    assert_refused(at("f.h5"), "column 'y' is not a dataset");
    file = write_foreign(at("f.h5"), NULL);
    H5Lcreate_external("other.h5", "/x", file, "y", H5P_DEFAULT, H5P_DEFAULT);
    H5Fclose(file);
    assert_refused(at("f.h5"), "object 2 is a link elsewhere");
    file = write_foreign(at("f.h5"), NULL);
    H5Lcreate_hard(file, "x", file, "y", H5P_DEFAULT, H5P_DEFAULT);
    H5Fclose(file);
    assert_refused(at("f.h5"), "object 1 is a link elsewhere, has a second name");
    file = write_foreign(at("f.h5"), NULL);
    hid_t creation = H5Pcreate(H5P_DATASET_CREATE),
          space = H5Screate_simple(1, (hsize_t[]){3}, NULL);
    H5Pset_chunk(creation, 1, (hsize_t[]){3});
    H5Pset_scaleoffset(creation, H5Z_SO_FLOAT_DSCALE, 3);
    H5Dclose(H5Dcreate2(file, "y", H5T_IEEE_F64LE, space, H5P_DEFAULT, creation, H5P_DEFAULT));
    H5Sclose(space);
    H5Pclose(creation);
    H5Fclose(file);
    assert_refused(at("f.h5"), "column 'y' is stored with a filter other than gzip");
    H5Fclose(H5Fcreate(at("f.h5"), H5F_ACC_TRUNC, H5P_DEFAULT, H5P_DEFAULT));
    assert_refused(at("f.h5"), "has 0 columns");
    spill(at("f.h5"), "x,y\n", 4);
    assert_refused(at("f.h5"), "is not an HDF5 file");
    spill(at("f.h5"), "", 0);
    assert_refused(at("f.h5"), "is not an HDF5 file");
}

static void hdf5_variants_are_read(void **state)
{
    (void)state;
    const foreign big_endian = {H5T_IEEE_F64BE, 1, {3, 0}, 0, 0};
    const foreign compressed = {H5T_IEEE_F64LE, 1, {3, 0}, 3, 1};
    const foreign *const variants[] = {&big_endian, &compressed};
    const double values[] = {-1.5, 0.1, 1e300};
    for (size_t k = 0; k < 2; k++) {
        hid_t file = write_foreign(at("v.h5"), variants[k]);
        hid_t y = H5Dopen2(file, "y", H5P_DEFAULT);
        H5Dwrite(y, H5T_NATIVE_DOUBLE, H5S_ALL, H5S_ALL, H5P_DEFAULT, values);
        H5Dclose(y);
        H5Fclose(file);
        table_file *table = read_or_fail(at("v.h5"), TABLE_FINITE);
        assert_memory_equal(table_column(table, "y"), values, sizeof values);
        table_free(table);
    }
}

static void truncation_is_refused(void **state)
{
    (void)state;
    size_t size;
    table_file *table;
    const char *const names[] = {"a", "b"};
    const double *const columns[] = {first, second};
    assert_int_equal(write_table(at("t.h5"), names, columns, 2, ROWS, NULL), AD_OK);
    unsigned char *bytes = slurp(at("t.h5"), &size);
    for (size_t length = 0; length < size; length += 13) {
        spill(at("cut.h5"), bytes, length);
        assert_int_equal(table_read(at("cut.h5"), TABLE_FINITE, &table, NULL), AD_BAD_INPUT);
    }
    free(bytes);
}

/* Linear congruential generator of D. Knuth, MMIX. */
static uint64_t random_state = 7;

static uint64_t next_random(void)
{
    random_state = random_state * UINT64_C(6364136223846793005) + UINT64_C(1442695040888963407);
    return random_state >> 33;
}

/* A CSV file has no checksum: damage may give other numbers, but never a crash or a broken table.
 */
static void damaged_csv_never_crashes(void **state)
{
    (void)state;
    size_t size;
    const char *const names[] = {"a", "b"};
    const double *const columns[] = {first, second};
    assert_int_equal(write_table(at("t.csv"), names, columns, 2, ROWS, NULL), AD_OK);
    unsigned char *bytes = slurp(at("t.csv"), &size);
    for (int trial = 0; trial < 3000; trial++) {
        ad_error error = {AD_OK, ""};
        table_file *table;
        size_t place = next_random() % size;
        unsigned char old = bytes[place];
        static const unsigned char likely[] = ",\n\r#-.en0 \t\0";
        bytes[place] = trial % 2 ? likely[next_random() % 13] : (unsigned char)next_random();
        spill(at("bad.csv"), bytes, trial % 5 ? size : place);
        if (table_read(at("bad.csv"), TABLE_FINITE, &table, &error) == AD_OK) {
            for (size_t k = 0; k < table_columns(table); k++) {
                const double *values = table_column(table, table_name(table, k));
                for (size_t row = 0; row < table_rows(table); row++) {
                    assert_true(isfinite(values[row]));
                }
            }
            table_free(table);
        } else {
            assert_null(strchr(error.message, '\n'));
            assert_int_not_equal(error.message[0], 0);
        }
        bytes[place] = old;
    }
    free(bytes);
}

/* Number of trials, each with one flipped bit, after which the table is neither refused nor whole.
 */
static int read_damaged_hdf5(unsigned char *bytes, size_t size)
{
    int broken = 0;
    for (int trial = 0; trial < 500; trial++) {
        table_file *table;
        size_t place = next_random() % size;
        unsigned char flip = (unsigned char)(1u << next_random() % 8);
        bytes[place] ^= flip;
        spill(at("bad.h5"), bytes, size);
        ad_status status = table_read(at("bad.h5"), TABLE_NONFINITE, &table, NULL);
        broken += !(status == AD_OK ? table_rows(table) == ROWS : status == AD_BAD_INPUT);
        table_free(table);
        bytes[place] ^= flip;
    }
    return broken;
}

/* Written tables have HDF5's own checksums over most of their metadata, so damage is refused or
 * changes numbers only. In a process of its own, because HDF5 1.10 leaks memory of its own when it
 * refuses some files. */
static void damaged_hdf5_never_crashes(void **state)
{
    (void)state;
    size_t size;
    int status = -1;
    const char *const names[] = {"a", "b"};
    const double *const columns[] = {first, second};
    assert_int_equal(write_table(at("t.h5"), names, columns, 2, ROWS, NULL), AD_OK);
    unsigned char *bytes = slurp(at("t.h5"), &size);
    pid_t child = fork();
    if (child == 0) {
        _exit(read_damaged_hdf5(bytes, size) == 0 ? 0 : 1);
    }
    assert_int_equal(waitpid(child, &status, 0), child);
    free(bytes);
    assert_true(WIFEXITED(status) && WEXITSTATUS(status) == 0);
}

static void csv_rows_know_their_lines(void **state)
{
    static const char text[] = "# comment\n\ns,t\n1,2\n\n# more\n3,4\n";
    const double one[1] = {1};
    (void)state;
    spill(at("lines.csv"), text, sizeof text - 1);
    table_file *table = read_or_fail(at("lines.csv"), TABLE_FINITE);
    assert_int_equal(table_line(table, 0), 4);
    assert_int_equal(table_line(table, 1), 7);
    assert_int_equal(table_line(table, 2), 0); /* there is no such row */
    table_free(table);
    assert_int_equal(write_table(at("lines.h5"), (const char *const[]){"s"},
                                 (const double *const[]){one}, 1, 1, NULL),
                     AD_OK);
    table = read_or_fail(at("lines.h5"), TABLE_FINITE);
    assert_int_equal(table_line(table, 0), 0);
    table_free(table);
}

static void columns_of_words(void **state)
{
    static const char *const files[] = {"words.csv", "words.h5"};
    static const char *const places[] = {"tip", "1e5", "\xc3\xa9t\xc3\xa9 2"};
    static const double numbers[] = {1, -0.5, NAN};
    const char *const wanted[] = {"place", "absent", NULL};
    const char *const names[] = {"place", "value"};
    const double *const columns[] = {NULL, numbers};
    const char *const *const words[] = {places, NULL};
    (void)state;
    for (int i = 0; i < 2; i++) {
        table_file *table;
        ad_error error = {AD_OK, ""};
        assert_int_equal(write_words(at(files[i]), names, columns, words, 2, 3, NULL), AD_OK);
        if (table_read_words(at(files[i]), TABLE_NONFINITE, wanted, &table, &error) != AD_OK) {
            fail_msg("%s", error.message);
        }
        assert_int_equal(table_rows(table), 3);
        assert_null(table_column(table, "place"));
        assert_null(table_words(table, "value"));
        assert_null(table_words(table, "absent"));
        for (int row = 0; row < 3; row++) {
            assert_string_equal(table_words(table, "place")[row], places[row]);
        }
        assert_true(table_column(table, "value")[1] == -0.5);
        assert_true(isnan(table_column(table, "value")[2]));
        table_free(table);
    }
}

/* Of what was measured nobody minds what stands in columns that nobody asks for. */
static void measured_columns(void **state)
{
    static const char text[] = "name,x,y,z,w\n\"a,b\",1,,nan,1\nc,2,7,-3,inf\n";
    static const char *const missing[] = {":2: column 'y' has no number",
                                          " row 1: column 'y' has no number"};
    static const char *const words[] = {":2:1: '\"a,b\"': the field is not a number",
                                        "column 'name' is not float64"};
    static const char *const infinite[] = {":3:10: 'inf': the field is not finite",
                                           "column 'w' row 2: inf is not finite"};
    const char *const names[] = {"name", "x", "y", "z", "w"}, *const texts[] = {"a b", "c"};
    const double x[] = {1, 2}, y[] = {NAN, 7}, z[] = {NAN, -3}, w[] = {1, INFINITY};
    const double *const columns[] = {NULL, x, y, z, w}, *found;
    const char *const *const held[] = {texts, NULL, NULL, NULL, NULL};
    (void)state;
    spill(at("m.csv"), text, sizeof text - 1);
    assert_int_equal(write_words(at("m.h5"), names, columns, held, 5, 2, NULL), AD_OK);
    for (int i = 0; i < 2; i++) {
        table_file *table = read_or_fail(at(i ? "m.h5" : "m.csv"), TABLE_MEASURED);
        ad_error error = {.message = ""};
        assert_int_equal(table_rows(table), 2);
        assert_memory_equal(table_column(table, "x"), x, sizeof x);
        assert_true(isnan(table_column(table, "y")[0]) && table_column(table, "y")[1] == 7);
        assert_int_equal(table_find(table, "z", TABLE_MEASURED, &found, &error), AD_OK);
        assert_true(isnan(found[0]) && found[1] == -3);
        assert_int_equal(table_find(table, "absent", TABLE_FINITE, &found, &error), AD_OK);
        assert_null(found);
        assert_int_equal(table_find(table, "y", TABLE_FINITE, &found, &error), AD_BAD_INPUT);
        assert_non_null(strstr(error.message, missing[i]));
        assert_null(table_column(table, "name"));
        assert_int_equal(table_find(table, "name", TABLE_MEASURED, &found, &error), AD_BAD_INPUT);
        assert_non_null(strstr(error.message, words[i]));
        assert_int_equal(table_find(table, "w", TABLE_MEASURED, &found, &error), AD_BAD_INPUT);
        assert_non_null(strstr(error.message, infinite[i]));
        assert_null(found);
        table_free(table);
    }
    spill(at("rows.csv"), "x\n1,2\n", 6); /* a row that is none is refused all the same */
    assert_int_equal(table_read(at("rows.csv"), TABLE_MEASURED, &(table_file *){NULL}, NULL),
                     AD_BAD_INPUT);
}

/* What a spreadsheet would run stands behind an apostrophe, in CSV alone; numbers are as they are.
 */
static void formulas_are_text(void **state)
{
    enum { CELLS = 5 };
    static const char *const files[] = {"f.csv", "f.h5"};
    static const char *const cells[CELLS] = {"=1+1", "+1", "-x", "@SUM(1)", "a=b"};
    static const char expected[] = "'=call,value\n'=1+1,-1\n'+1,-1\n'-x,-1\n'@SUM(1),-1\na=b,-1\n";
    static const double numbers[CELLS] = {-1, -1, -1, -1, -1};
    const char *const wanted[] = {"=call", NULL}, *const names[] = {"=call", "value"};
    const double *const columns[] = {NULL, numbers};
    const char *const *const words[] = {cells, NULL};
    char text[sizeof expected + 1] = "";
    (void)state;
    for (int i = 0; i < 2; i++) {
        table_file *table;
        ad_error error = {AD_OK, ""};
        assert_int_equal(write_words(at(files[i]), names, columns, words, 2, CELLS, NULL), AD_OK);
        if (table_read_words(at(files[i]), TABLE_FINITE, wanted, &table, &error) != AD_OK) {
            fail_msg("%s", error.message);
        }
        for (int row = 0; row < CELLS; row++) {
            assert_string_equal(table_words(table, "=call")[row], cells[row]);
        }
        table_free(table);
    }
    FILE *file = fopen(at(files[0]), "r");
    assert_non_null(file);
    assert_int_equal(fread(text, 1, sizeof text, file), sizeof expected - 1);
    fclose(file);
    assert_string_equal(text, expected);
}

static void words_refused(void **state)
{
    const double one[] = {1};
    const char *const names[] = {"place"};
    const char *const wanted[] = {"place", NULL};
    const char *const fine[] = {"tip"}, *const comma[] = {"a,b"};
    const char *const *const good[] = {fine}, *const *const bad[] = {comma};
    const double *const columns[] = {one};
    ad_error error;
    table_file *table;
    (void)state;
    assert_int_equal(write_words(at("w.csv"), names, columns, bad, 1, 1, NULL), AD_BAD_ARGUMENT);
    assert_int_equal(write_words(at("w.csv"), names, columns, good, 1, 1, NULL), AD_OK);
    assert_refused(at("w.csv"), ":2:1: 'tip': the field is not a number");
    assert_int_equal(write_words(at("w.h5"), names, columns, good, 1, 1, NULL), AD_OK);
    assert_refused(at("w.h5"), "column 'place' is not float64");
    assert_int_equal(write_table(at("n.h5"), names, columns, 1, 1, NULL), AD_OK);
    assert_int_equal(table_read_words(at("n.h5"), TABLE_FINITE, wanted, &table, &error),
                     AD_BAD_INPUT);
    assert_non_null(strstr(error.message, "column 'place' does not hold strings"));
    spill(at("e.csv"), "place,x\nq,1\n ,2\n", 16);
    assert_int_equal(table_read_words(at("e.csv"), TABLE_FINITE, wanted, &table, &error),
                     AD_BAD_INPUT);
    assert_non_null(strstr(error.message, ":3:2: '': a word is missing"));
}

int main(void)
{
#define TEST(function) cmocka_unit_test_setup_teardown(function, make_directory, remove_directory)
    const struct CMUnitTest tests[] = {
        TEST(round_trip_is_exact),
        TEST(numbers_that_are_not_finite),
        TEST(bad_writes),
        TEST(other_files),
        TEST(csv_forms),
        TEST(csv_words),
        TEST(csv_refusals_name_the_place),
        TEST(csv_limits),
        TEST(csv_rows_know_their_lines),
        TEST(columns_of_words),
        TEST(measured_columns),
        TEST(formulas_are_text),
        TEST(words_refused),
        TEST(csv_ignores_the_locale),
        TEST(csv_numbers_are_short),
        TEST(hdf5_shapes),
        TEST(hdf5_variants_are_read),
        TEST(truncation_is_refused),
        TEST(damaged_csv_never_crashes),
        TEST(damaged_hdf5_never_crashes),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
