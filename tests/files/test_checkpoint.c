/* Checkpoints come back to the last bit, and a file that is not one is refused with one line. All
 * comparisons are of bytes, so there are no tolerances. */
#include "checkpoint_example.h"

static unsigned char *slurp(const char *path, size_t *size)
{
    unsigned char *bytes = NULL;
    size_t file_size = 0;
    assert_int_equal(file_bytes_read(path, 0, &bytes, size, &file_size, NULL), AD_OK);
    return bytes;
}

static void spill(const char *path, const void *bytes, size_t size)
{
    FILE *file = fopen(path, "wb");
    assert_non_null(file);
    assert_int_equal(fwrite(bytes, 1, size, file), size);
    assert_int_equal(fclose(file), 0);
}

static void assert_refused(const char *path, const char *reason)
{
    ad_error error = {AD_OK, ""};
    checkpoint *cp;
    ad_status status = checkpoint_open(path, &cp, &error);
    checkpoint_free(cp);
    assert_true(status == AD_BAD_INPUT || status == AD_IO);
    assert_int_equal(error.status, status);
    assert_null(strchr(error.message, '\n'));
    if (!strstr(error.message, reason) || !strstr(error.message, path)) {
        fail_msg("'%s' names neither '%s' nor '%s'", error.message, path, reason);
    }
}

/* ---- contents ---- */

static void round_trip_is_exact(void **state)
{
    (void)state;
    int rank = -1;
    size_t shape[3];
    checkpoint *cp;
    ad_error error = {AD_OK, ""};
    write_example(at("checkpoint.h5"), 1.5, 1);
    if (checkpoint_open(at("checkpoint.h5"), &cp, &error) != AD_OK) {
        fail_msg("%s", error.message);
    }
    assert_example(cp);
    assert_string_equal(checkpoint_library_version(cp), "0.1.0 test");
    assert_int_equal(checkpoint_count(cp), 12);
    for (size_t k = 1; k < checkpoint_count(cp); k++) {
        assert_true(strcmp(checkpoint_name(cp, k - 1), checkpoint_name(cp, k)) < 0);
    }
    assert_true(checkpoint_has(cp, "stamp"));
    assert_false(checkpoint_has(cp, "points"));
    assert_true(checkpoint_shape(cp, "optimizer/cube", &rank, shape));
    assert_true(rank == 3 && shape[0] == 2 && shape[1] == 3 && shape[2] == 2);
    assert_true(checkpoint_shape(cp, "points/none", &rank, shape));
    assert_true(rank == 2 && shape[0] == 0 && shape[1] == 2 && shape[2] == 1);
    assert_true(checkpoint_shape(cp, "stamp", &rank, shape));
    assert_true(rank == 0 && shape[0] == 1);
    assert_true(checkpoint_shape(cp, "scene/yaml", &rank, shape));
    assert_true(rank == 1 && shape[0] == strlen(scene));
    assert_false(checkpoint_shape(cp, "nothing", &rank, shape));

    /* What was opened can be written again, and equal contents give equal bytes. */
    assert_int_equal(checkpoint_write(cp, &(file_place){.path = at("again.h5")}, NULL), AD_OK);
    size_t one, two;
    unsigned char *first = slurp(at("checkpoint.h5"), &one);
    unsigned char *second = slurp(at("again.h5"), &two);
    assert_int_equal(one, two);
    assert_memory_equal(first, second, one);
    free(first);
    free(second);
    checkpoint_free(cp);
    assert_int_equal(entries(0), 2); /* no partial file stays */
}

static void empty_checkpoint_and_null(void **state)
{
    (void)state;
    checkpoint *cp = checkpoint_create("");
    assert_int_equal(checkpoint_write(cp, &(file_place){.path = at("empty.h5")}, NULL), AD_OK);
    checkpoint_free(cp);
    assert_int_equal(checkpoint_open(at("empty.h5"), &cp, NULL), AD_OK);
    assert_int_equal(checkpoint_count(cp), 0);
    checkpoint_free(cp);
    checkpoint_free(NULL);
}

/* Beyond 64 KiB an attribute needs HDF5's dense storage, beyond 1 MiB the image grows. */
static void large_items(void **state)
{
    (void)state;
    enum { many = 1000, rows = 300 };
    char(*texts)[101] = malloc(many * sizeof *texts);
    const char **names = malloc(many * sizeof *names);
    double *data = malloc(sizeof *data * many * rows);
    double *back = malloc(sizeof *back * many * rows);
    for (int k = 0; k < many; k++) {
        snprintf(texts[k], sizeof texts[k], "%0100d", k);
        names[k] = texts[k];
    }
    for (int k = 0; k < many * rows; k++) {
        data[k] = k;
    }
    checkpoint *cp = checkpoint_create("v");
    checkpoint_put_table(cp, "history/table", data, rows, many, names);
    assert_int_equal(checkpoint_write(cp, &(file_place){.path = at("large.h5")}, NULL), AD_OK);
    checkpoint_free(cp);
    assert_int_equal(checkpoint_open(at("large.h5"), &cp, NULL), AD_OK);
    assert_int_equal(checkpoint_get_doubles(cp, "history/table", back, many * rows, NULL), AD_OK);
    assert_memory_equal(back, data, sizeof *data * many * rows);
    assert_string_equal(checkpoint_column(cp, "history/table", 999), texts[999]);
    checkpoint_free(cp);
    free(back);
    free(data);
    free(names);
    free(texts);
}

static void getters_name_the_item(void **state)
{
    (void)state;
    ad_error error = {AD_OK, ""};
    double value[20];
    const char *text;
    checkpoint *cp;
    write_example(at("checkpoint.h5"), 1.0, 1);
    assert_int_equal(checkpoint_open(at("checkpoint.h5"), &cp, NULL), AD_OK);
    assert_int_equal(checkpoint_get_doubles(cp, "absent", value, 1, &error), AD_BAD_INPUT);
    assert_non_null(strstr(error.message, "checkpoint.h5"));
    assert_non_null(strstr(error.message, "'absent'"));
    assert_int_equal(checkpoint_get_doubles(cp, "counts", value, 4, &error), AD_BAD_INPUT);
    assert_non_null(strstr(error.message, "'counts' is int64 where float64"));
    assert_int_equal(checkpoint_get_doubles(cp, "optimizer/cube", value, 11, &error), AD_BAD_INPUT);
    assert_non_null(strstr(error.message, "12 elements"));
    assert_int_equal(checkpoint_get_text(cp, "stamp", &text, &error), AD_BAD_INPUT);
    assert_non_null(strstr(error.message, "'stamp' is float64 where text"));
    checkpoint_free(cp);
}

static void bad_puts_are_remembered(void **state)
{
    (void)state;
    static const char *const names[] = {"",    "/a",   "a/", "a//b",  "./a",   "a/..",
                                        "a b", "a\nb", "x",  "x/sub", "group", "caf\xc3\xa9"};
    const size_t huge[3] = {SIZE_MAX / 8, 8, 8};
    char longest[300];
    memset(longest, 'n', sizeof longest);
    longest[299] = 0;
    write_example(at("checkpoint.h5"), 7.0, 1);
    for (size_t k = 0; k < sizeof names / sizeof *names + 5; k++) {
        ad_error error = {AD_OK, ""};
        double one = 1.0;
        checkpoint *cp = checkpoint_create("v");
        assert_int_equal(checkpoint_put_double(cp, "x", 1.0), AD_OK);
        assert_int_equal(checkpoint_put_double(cp, "group/inner", 1.0), AD_OK);
        size_t extra = k - sizeof names / sizeof *names;
        ad_status status =
            k < sizeof names / sizeof *names ? checkpoint_put_double(cp, names[k], 2.0)
            : extra == 0                     ? checkpoint_put_double(cp, longest, 2.0)
            : extra == 1                     ? checkpoint_put_doubles(cp, "d", &one, 4, huge)
            : extra == 2                     ? checkpoint_put_doubles(cp, "d", &one, 3, huge)
            : extra == 3
                ? checkpoint_put_doubles(cp, "d", NULL, 1, huge)
                : checkpoint_put_table(cp, "d", &one, 1, 1, (const char *const[]){longest});
        assert_int_equal(status, AD_BAD_ARGUMENT);
        assert_int_equal(checkpoint_count(cp), 2);
        assert_int_equal(checkpoint_put_double(cp, "fine", 1.0), AD_OK);
        assert_int_equal(checkpoint_write(cp, &(file_place){.path = at("checkpoint.h5")}, &error),
                         AD_BAD_ARGUMENT);
        assert_non_null(strstr(error.message, "checkpoint item '"));
        assert_null(strchr(error.message, '\n') && k != 7 ? error.message : NULL);
        checkpoint_free(cp);
    }
    assert_true(stamp_of(at("checkpoint.h5")) == 7.0);
}

/* ---- refusal ---- */

static void write_foreign(const char *path)
{
    hid_t file = H5Fcreate(path, H5F_ACC_TRUNC, H5P_DEFAULT, H5P_DEFAULT);
    hid_t group = H5Gcreate2(file, "parameters", H5P_DEFAULT, H5P_DEFAULT, H5P_DEFAULT);
    H5Gclose(group);
    H5Fclose(file);
}

/* Make the first bytes fit what is behind them, so that only the inner checks are left. */
static void forge_user_block(unsigned char *bytes, size_t size)
{
    checkpoint_user_block(bytes, size,
                          checkpoint_hash(CHECKPOINT_HASH_START, bytes + CHECKPOINT_USER_BLOCK,
                                          size - CHECKPOINT_USER_BLOCK));
}

static void other_files_are_refused(void **state)
{
    (void)state;
    assert_refused(at("missing.h5"), "No such file");
    assert_refused(directory, "is a directory");
    assert_int_equal(mkfifo(at("pipe.h5"), 0600), 0);
    assert_refused(at("pipe.h5"), "not a regular file");
    spill(at("nothing.h5"), "", 0);
    assert_refused(at("nothing.h5"), "is empty");
    spill(at("text.h5"), "x,y\n1,2\n", 8);
    assert_refused(at("text.h5"), "is not a cpinn checkpoint");
    write_foreign(at("foreign.h5"));
    assert_refused(at("foreign.h5"), "is an HDF5 file but not a cpinn checkpoint");
    if (geteuid() != 0) {
        chmod(at("text.h5"), 0);
        assert_refused(at("text.h5"), "Permission denied");
    }
}

/* Opens the example for changes, as someone with HDF5 could; close_crafted makes its bytes fit. */
static hid_t open_crafted(void)
{
    write_example(at("crafted.h5"), 1.0, 1);
    hid_t file = H5Fopen(at("crafted.h5"), H5F_ACC_RDWR, H5P_DEFAULT);
    assert_true(file >= 0);
    return file;
}

static void refuse_crafted(hid_t file, const char *reason)
{
    size_t size;
    H5Fclose(file);
    unsigned char *bytes = slurp(at("crafted.h5"), &size);
    forge_user_block(bytes, size);
    spill(at("crafted.h5"), bytes, size);
    free(bytes);
    assert_refused(at("crafted.h5"), reason);
}

/* Groups with two names would be visited on 2^38 paths, a pipe would be waited for. */
static void crafted_files_are_refused(void **state)
{
    (void)state;
    const hsize_t eight = 8;
    hid_t file = open_crafted(),
          group = H5Gcreate2(file, "0", H5P_DEFAULT, H5P_DEFAULT, H5P_DEFAULT);
    for (int depth = 1; depth < 39; depth++) {
        hid_t next = H5Gcreate2(group, "a", H5P_DEFAULT, H5P_DEFAULT, H5P_DEFAULT);
        H5Lcreate_hard(group, "a", group, "b", H5P_DEFAULT, H5P_DEFAULT);
        H5Gclose(group);
        group = next;
    }
    H5Gclose(group);
    refuse_crafted(file, "item '0' holds something that is not an item");

    file = open_crafted();
    for (size_t k = 0; k < CHECKPOINT_MAX_LINKS + 1; k++) {
        char name[16];
        snprintf(name, sizeof name, "%zu", k);
        H5Gclose(H5Gcreate2(file, name, H5P_DEFAULT, H5P_DEFAULT, H5P_DEFAULT));
    }
    refuse_crafted(file, "is a group of too many items");

    assert_int_equal(mkfifo(at("pipe"), 0600), 0);
    hid_t space = H5Screate_simple(1, &eight, NULL), creation = H5Pcreate(H5P_DATASET_CREATE);
    file = open_crafted();
    H5Pset_external(creation, at("pipe"), 0, 64);
    H5Dclose(H5Dcreate2(file, "x", H5T_IEEE_F64LE, space, H5P_DEFAULT, creation, H5P_DEFAULT));
    H5Pclose(creation);
    refuse_crafted(file, "item 'x' has its values in another file");

    file = open_crafted();
    creation = H5Pcreate(H5P_DATASET_CREATE);
    H5Pset_virtual(creation, space, at("other.h5"), "x", space);
    H5Dclose(H5Dcreate2(file, "x", H5T_IEEE_F64LE, space, H5P_DEFAULT, creation, H5P_DEFAULT));
    H5Pclose(creation);
    H5Sclose(space);
    refuse_crafted(file, "item 'x' has its values in another file");
}

static void damage_is_named(void **state)
{
    (void)state;
    size_t size;
    write_example(at("checkpoint.h5"), 1.0, 1);
    unsigned char *bytes = slurp(at("checkpoint.h5"), &size);

    unsigned char *version = bytes + strlen("cpinn checkpoint\n");
    assert_memory_equal(version, "format_version 2\n", 17);
    version[15] = '3';
    spill(at("bad.h5"), bytes, size);
    assert_refused(
        at("bad.h5"),
        "has format_version 3, of a cpinn later than this; this one reads format_version 2");
    version[15] = '1';
    spill(at("bad.h5"), bytes, size);
    assert_refused(
        at("bad.h5"),
        "has format_version 1, of a cpinn before 0.2.0; this one reads format_version 2");
    version[15] = '2';

    spill(at("bad.h5"), bytes, size - 1);
    assert_refused(at("bad.h5"), "is truncated: it has");
    bytes[size - 1] ^= 1;
    spill(at("bad.h5"), bytes, size);
    assert_refused(at("bad.h5"), "bytes do not match their checksum");
    /* The generation before it is pointed at when there is one. */
    spill(at("bad.1.h5"), "", 0);
    assert_refused(at("bad.h5"), "bad.1.h5");
    spill(at("bad.2.h5"), "", 0);
    assert_refused(at("bad.1.h5"), "bad.2.h5");
    assert_refused(at("bad.2.h5"), "train anew");
    bytes[size - 1] ^= 1;

    /* Only the checksum over the items can notice a consistent file with another number. */
    const uint64_t wanted = special_bits[11];
    size_t place = CHECKPOINT_USER_BLOCK;
    while (place + 8 <= size && memcmp(bytes + place, &wanted, 8) != 0) {
        place++;
    }
    assert_true(place + 8 <= size);
    bytes[place] ^= 4;
    forge_user_block(bytes, size);
    spill(at("bad.h5"), bytes, size);
    assert_refused(at("bad.h5"), "items do not match their checksum");
    free(bytes);
}

/* A step of FNV-1a is invertible, so a change of one byte must always be noticed. */
static void every_changed_byte_is_refused(void **state)
{
    (void)state;
    size_t size;
    checkpoint *cp;
    write_example(at("checkpoint.h5"), 1.0, 1);
    unsigned char *bytes = slurp(at("checkpoint.h5"), &size);
    for (int trial = 0; trial < 1500; trial++) {
        /* The first bytes, which are read as text, get a third of the trials. */
        size_t place = (size_t)(next_random() % (trial % 3 == 0 ? 100 : size));
        unsigned char flip = (unsigned char)(1u << next_random() % 8);
        bytes[place] ^= flip;
        spill(at("bad.h5"), bytes, size);
        assert_int_equal(checkpoint_open(at("bad.h5"), &cp, NULL), AD_BAD_INPUT);
        assert_null(cp);
        bytes[place] ^= flip;
    }
    free(bytes);
}

static void every_truncation_is_refused(void **state)
{
    (void)state;
    size_t size;
    checkpoint *cp;
    write_example(at("checkpoint.h5"), 1.0, 1);
    unsigned char *bytes = slurp(at("checkpoint.h5"), &size);
    for (size_t length = 0; length < size; length += length < 600 ? 7 : 61) {
        spill(at("bad.h5"), bytes, length);
        assert_int_equal(checkpoint_open(at("bad.h5"), &cp, NULL), AD_BAD_INPUT);
    }
    unsigned char *longer = calloc(1, size + 5);
    memcpy(longer, bytes, size);
    spill(at("bad.h5"), longer, size + 5);
    assert_int_equal(checkpoint_open(at("bad.h5"), &cp, NULL), AD_BAD_INPUT);
    free(longer);
    free(bytes);
}

static void hdf5_stays_silent(void **state)
{
    (void)state;
    size_t size;
    H5E_auto2_t before, after;
    void *data_before, *data_after;
    write_example(at("checkpoint.h5"), 1.0, 1);
    unsigned char *bytes = slurp(at("checkpoint.h5"), &size);
    memset(bytes + CHECKPOINT_USER_BLOCK + 100, 0, 200); /* destroys HDF5's metadata */
    forge_user_block(bytes, size);
    spill(at("bad.h5"), bytes, size);
    free(bytes);
    H5Eget_auto2(H5E_DEFAULT, &before, &data_before);
    fflush(stderr);
    int kept = dup(STDERR_FILENO);
    int file = open(at("stderr"), O_RDWR | O_CREAT, 0600);
    dup2(file, STDERR_FILENO);
    checkpoint *cp;
    ad_status status = checkpoint_open(at("bad.h5"), &cp, NULL);
    fflush(stderr);
    dup2(kept, STDERR_FILENO);
    close(kept);
    assert_int_equal(status, AD_BAD_INPUT);
    assert_int_equal(lseek(file, 0, SEEK_END), 0);
    close(file);
    H5Eget_auto2(H5E_DEFAULT, &after, &data_after);
    assert_true(before == after && data_before == data_after);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        TEST(round_trip_is_exact),
        TEST(empty_checkpoint_and_null),
        TEST(large_items),
        TEST(getters_name_the_item),
        TEST(bad_puts_are_remembered),
        TEST(other_files_are_refused),
        TEST(crafted_files_are_refused),
        TEST(damage_is_named),
        TEST(every_changed_byte_is_refused),
        TEST(every_truncation_is_refused),
        TEST(hdf5_stays_silent),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
