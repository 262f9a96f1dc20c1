/* A checkpoint with every kind of item, and the directory it is written to; shared by the tests of
 * checkpoints. */
#ifndef TESTS_CHECKPOINT_EXAMPLE_H
#define TESTS_CHECKPOINT_EXAMPLE_H

#include <dirent.h>
#include <errno.h>
#include <fcntl.h>
#include <hdf5.h>
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
#include <time.h>
#include <unistd.h>

#include <cmocka.h>

#include "temporary_folder.h"
#include "tools/files/checkpoint.h"
#include "tools/files/checkpoint_parts.h"
#include "tools/files/file_bytes.h"

static uint64_t random_state = 20240607;

/* xorshift64* of S. Vigna, "An experimental exploration of Marsaglia's xorshift generators". */
static inline uint64_t next_random(void)
{
    random_state ^= random_state >> 12;
    random_state ^= random_state << 25;
    random_state ^= random_state >> 27;
    return random_state * UINT64_C(2685821657736338717);
}

static uint64_t special_bits[] = {
    UINT64_C(0x7ff8000000000000), UINT64_C(0x7ff800000000beef), UINT64_C(0xfff0000000000001),
    UINT64_C(0x7ff0000000000000), UINT64_C(0xfff0000000000000), UINT64_C(0x8000000000000000),
    UINT64_C(0x0000000000000001), UINT64_C(0x000fffffffffffff), UINT64_C(0x7fefffffffffffff),
    UINT64_C(0x0000000000000000), UINT64_C(0x3ff0000000000000), UINT64_C(0xbfd5555555555555)};
#define SPECIALS (sizeof special_bits / sizeof *special_bits)

static double specials[SPECIALS];
static const int64_t integers[] = {INT64_MIN, -1, 0, INT64_MAX};
static const uint64_t generator[] = {0, 1, UINT64_MAX, UINT64_C(0x0123456789abcdef)};
static const char *const columns[] = {"step", "loss", "learning_rate"};
static const char scene[] = "rod:\n  length: 1.0  # \xc3\xa9t\xc3\xa9\n";

/* Every kind of item; `stamp` tells one checkpoint from another. */
static inline checkpoint *example(double stamp)
{
    checkpoint *cp = checkpoint_create("0.1.0 test");
    if (!cp) {
        return NULL;
    }
    memcpy(specials, special_bits, sizeof specials);
    checkpoint_put_text(cp, "scene/yaml", scene);
    checkpoint_put_text(cp, "scene/empty", "");
    checkpoint_put_doubles(cp, "parameters/network/layer0/weight", specials, 2,
                           (const size_t[]){4, 3});
    checkpoint_put_doubles(cp, "parameters/network/layer0/bias", specials, 1, (const size_t[]){12});
    checkpoint_put_doubles(cp, "optimizer/cube", specials, 3, (const size_t[]){2, 3, 2});
    checkpoint_put_doubles(cp, "points/none", NULL, 2, (const size_t[]){0, 2});
    checkpoint_put_int64(cp, "counts", integers, 1, (const size_t[]){4});
    checkpoint_put_uint64(cp, "generator/state", generator, 1, (const size_t[]){4});
    checkpoint_put_table(cp, "history/table", specials, 4, 3, columns);
    checkpoint_put_table(cp, "history/fresh", NULL, 0, 3, columns);
    checkpoint_put_double(cp, "stamp", stamp);
    checkpoint_put_integer(cp, "step", INT64_C(-9007199254740993));
    return cp;
}

static inline void write_example(const char *path, double stamp, int keep)
{
    ad_error error = {AD_OK, ""};
    checkpoint *cp = example(stamp);
    assert_non_null(cp);
    if (checkpoint_write(cp, &(file_place){.path = path, .older = keep - 1}, &error) != AD_OK) {
        fail_msg("%s", error.message);
    }
    checkpoint_free(cp);
}

/* The stamp of the file at `path`, NaN if it cannot be opened. */
static inline double stamp_of(const char *path)
{
    ad_error error = {AD_OK, ""};
    double stamp = NAN;
    checkpoint *cp;
    if (checkpoint_open(path, &cp, &error) != AD_OK) {
        print_message("%s\n", error.message);
        return NAN;
    }
    checkpoint_get_doubles(cp, "stamp", &stamp, 1, &error);
    checkpoint_free(cp);
    return stamp;
}

static inline void assert_same_doubles(const checkpoint *cp, const char *name, size_t count)
{
    double read_back[SPECIALS];
    assert_int_equal(checkpoint_get_doubles(cp, name, read_back, count, NULL), AD_OK);
    assert_memory_equal(read_back, special_bits, count * sizeof *read_back);
}

static inline void assert_example(const checkpoint *cp)
{
    int64_t whole[4];
    uint64_t state[4];
    const char *text;
    assert_same_doubles(cp, "parameters/network/layer0/weight", 12);
    assert_same_doubles(cp, "parameters/network/layer0/bias", 12);
    assert_same_doubles(cp, "optimizer/cube", 12);
    assert_same_doubles(cp, "history/table", 12);
    assert_int_equal(checkpoint_get_doubles(cp, "points/none", NULL, 0, NULL), AD_OK);
    assert_int_equal(checkpoint_get_int64(cp, "counts", whole, 4, NULL), AD_OK);
    assert_memory_equal(whole, integers, sizeof whole);
    assert_int_equal(checkpoint_get_uint64(cp, "generator/state", state, 4, NULL), AD_OK);
    assert_memory_equal(state, generator, sizeof state);
    assert_int_equal(checkpoint_get_int64(cp, "step", whole, 1, NULL), AD_OK);
    assert_true(whole[0] == INT64_C(-9007199254740993));
    assert_int_equal(checkpoint_get_text(cp, "scene/yaml", &text, NULL), AD_OK);
    assert_string_equal(text, scene);
    assert_int_equal(checkpoint_get_text(cp, "scene/empty", &text, NULL), AD_OK);
    assert_string_equal(text, "");
    assert_string_equal(checkpoint_column(cp, "history/table", 2), "learning_rate");
    assert_string_equal(checkpoint_column(cp, "history/fresh", 0), "step");
    assert_null(checkpoint_column(cp, "history/table", 3));
    assert_null(checkpoint_column(cp, "counts", 0));
}

#define TEST(function) cmocka_unit_test_setup_teardown(function, make_directory, remove_directory)

#endif
