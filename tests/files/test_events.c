/* Event files of TensorBoard: checksums, fields read back against the history, and what is left of
 * them when a run is killed and resumed. The reading here knows the format by itself. */
#include <math.h>
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include <cmocka.h>

#include "temporary_folder.h"
#include "tools/files/event_file.h"
#include "tools/files/file_bytes.h"
#include "tools/train/run.h"
#include "tools/train/run_events.h"

enum { COLUMNS = 4, ROWS_MAX = 32 };

static void checksums(void **state)
{
    unsigned char bytes[32] = {0};
    (void)state;
    assert_int_equal(events_crc(bytes, 32), 0x8a9136aa); /* RFC 3720 B.4 */
    memset(bytes, 0xff, sizeof bytes);
    assert_int_equal(events_crc(bytes, 32), 0x62a8ab43);
    for (int i = 0; i < 32; i++) {
        bytes[i] = (unsigned char)i;
    }
    assert_int_equal(events_crc(bytes, 32), 0x46dd794e);
    for (int i = 0; i < 32; i++) {
        bytes[i] = (unsigned char)(31 - i);
    }
    assert_int_equal(events_crc(bytes, 32), 0x113fdb5c);
    assert_int_equal(events_crc("123456789", 9), 0xe3069283);
}

/* ---- reading ------------------------------------------------------------------------------- */

typedef struct row {
    int64_t step;
    double wall;
    int scalars;
    char names[COLUMNS][32];
    float values[COLUMNS];
} row;

static uint64_t varint(const unsigned char **at)
{
    uint64_t value = 0;
    for (int shift = 0;; shift += 7) {
        value |= (uint64_t)(**at & 0x7f) << shift;
        if (!(*(*at)++ & 0x80)) {
            return value;
        }
    }
}

static void read_value(const unsigned char *at, size_t size, row *to)
{
    const unsigned char *end = at + size;
    assert_int_equal(*at++, 10); /* tag, text */
    const size_t length = (size_t)varint(&at);
    assert_true(length < sizeof to->names[0]);
    memcpy(to->names[to->scalars], at, length);
    at += length;
    assert_int_equal(*at++, 21); /* simple_value, float */
    memcpy(&to->values[to->scalars++], at, 4);
    assert_ptr_equal(at + 4, end);
}

/* Whether the event has a summary. */
static bool read_event(const unsigned char *at, size_t size, row *to)
{
    const unsigned char *end = at + size;
    bool summary = false;
    memset(to, 0, sizeof *to);
    while (at < end) {
        const unsigned key = *at++;
        if (key == 9) { /* wall_time, double */
            memcpy(&to->wall, at, 8);
            at += 8;
        } else if (key == 16) { /* step */
            to->step = (int64_t)varint(&at);
        } else if (key == 42) { /* summary */
            const unsigned char *stop;
            size_t length = (size_t)varint(&at);
            summary = true;
            for (stop = at + length; at < stop; at += length) {
                assert_int_equal(*at++, 10);
                length = (size_t)varint(&at);
                read_value(at, length, to);
            }
        } else { /* file_version, session_log */
            assert_true(key == 26 || key == 58);
            const size_t length = (size_t)varint(&at);
            at += length;
        }
    }
    assert_ptr_equal(at, end);
    return summary;
}

/* The rows of the file that begins with row `first`; -1: there is none. */
static int read_rows(size_t first, row *rows)
{
    char path[512];
    unsigned char *bytes;
    size_t size, all;
    int count = 0;
    run_events_path(directory, first, path, sizeof path);
    if (file_bytes_read(path, 0, &bytes, &size, &all, NULL) != AD_OK) {
        return -1;
    }
    for (size_t at = 0; at < size;) {
        uint64_t length;
        uint32_t sums[2], masked[2];
        memcpy(&length, bytes + at, 8);
        memcpy(&sums[0], bytes + at + 8, 4);
        memcpy(&sums[1], bytes + at + 12 + length, 4);
        masked[0] = events_crc(bytes + at, 8);
        masked[1] = events_crc(bytes + at + 12, (size_t)length);
        for (int i = 0; i < 2; i++) {
            assert_int_equal(sums[i], (uint32_t)((masked[i] >> 15 | masked[i] << 17) + 0xa282ead8));
        }
        count += read_event(bytes + at + 12, (size_t)length, &rows[count]);
        at += 16 + (size_t)length;
    }
    free(bytes);
    return count;
}

/* ---- runs ---------------------------------------------------------------------------------- */

static history made = {.names = {"step", "seconds", "loss", "error"}, .columns = COLUMNS};

static void add_rows(size_t count)
{
    while (made.count < count) {
        const double at = (double)made.count;
        const double numbers[COLUMNS] = {10 * at + 1, 0.1 * at, exp(-at),
                                         made.count % 3 ? 0.1 / (at + 1) : NAN};
        assert_int_equal(history_add(&made, numbers, NULL), AD_OK);
    }
}

/* A process works on the run until it has so many rows, and saves at `saved` of them. */
static void work(bool tensorboard, size_t count, size_t saved)
{
    run_folder run;
    ad_error error = {AD_OK, ""};
    assert_int_equal(run_name(&run, directory, &error), AD_OK);
    assert_int_equal(run_begin(&run, "a: b\n", &made, tensorboard, &error), AD_OK);
    while (made.count < count) {
        add_rows(made.count + 1);
        assert_int_equal(run_append(&run, &made, &error), AD_OK);
    }
    run_end(&run);
    made.count = saved;
}

static void check_row(const row *found, size_t wanted)
{
    int n = 0;
    assert_int_equal(found->step, (int64_t)history_value(&made, wanted, "step"));
    assert_true(found->wall > 1.7e9 && found->wall < 1e11);
    for (int i = 1; i < COLUMNS; i++) {
        const double value = history_value(&made, wanted, made.names[i]);
        if (!isnan(value)) {
            assert_string_equal(found->names[n], made.names[i]);
            assert_true(found->values[n] == (float)value);
            n++;
        }
    }
    assert_int_equal(found->scalars, n);
}

/* All rows are in these files [files], one behind the other. */
static void check_rows(const size_t *firsts, int files, size_t count)
{
    static row rows[ROWS_MAX];
    size_t done = 0;
    add_rows(count);
    for (int i = 0; i < files; i++) {
        assert_int_equal(firsts[i], done);
        const int found = read_rows(firsts[i], rows);
        assert_true(found >= 0);
        for (int k = 0; k < found; k++, done++) {
            check_row(&rows[k], done);
            assert_true(k == 0 || rows[k].wall >= rows[k - 1].wall);
        }
    }
    assert_int_equal(done, count);
}

static void rows_of_a_run(void **state)
{
    (void)state;
    work(true, 7, 7);
    check_rows((const size_t[]){0}, 1, 7);
}

static void no_row_twice(void **state)
{
    static row rows[ROWS_MAX];
    (void)state;
    work(true, 9, 5); /* killed after the row of its checkpoint */
    work(true, 12, 12);
    check_rows((const size_t[]){0, 5}, 2, 12);
    made.count = 3; /* an older checkpoint */
    work(true, 6, 6);
    check_rows((const size_t[]){0, 3}, 2, 6);
    assert_int_equal(read_rows(5, rows), -1);
    made.count = 0; /* the first */
    work(true, 2, 2);
    check_rows((const size_t[]){0}, 1, 2);
    assert_int_equal(read_rows(3, rows), -1);
}

/* The last record is not whole, or a bit of one has changed. */
static void damaged_tails(void **state)
{
    char path[512];
    unsigned char *bytes;
    size_t size, all, end;
    (void)state;
    for (int damage = 0; damage < 2; damage++) {
        work(true, 6, 6);
        run_events_path(directory, 0, path, sizeof path);
        assert_int_equal(file_bytes_read(path, 0, &bytes, &size, &all, NULL), AD_OK);
        bytes[size - 9] ^= damage == 0 ? 1 : 0;
        assert_int_equal(file_bytes_write(path, bytes, damage ? size - 1 : size, NULL), AD_OK);
        assert_int_equal(events_records(bytes, damage ? size - 1 : size, 100, &end),
                         EVENTS_BEGIN + 5);
        assert_int_equal(events_records(bytes, size, 4, &end), 4);
        free(bytes);
        work(true, 8, 8);
        check_rows((const size_t[]){0, 5}, 2, 8);
        made.count = 0;
    }
}

/* They begin when the key is set. */
static void wanted_later(void **state)
{
    static row rows[ROWS_MAX];
    (void)state;
    work(false, 4, 4);
    assert_int_equal(read_rows(0, rows), -1);
    work(true, 6, 6);
    check_rows((const size_t[]){0}, 1, 6);
}

static void full_disk(void **state)
{
    ad_error error = {AD_OK, ""};
    FILE *full = fopen("/dev/full", "w");
    (void)state;
    assert_non_null(full);
    add_rows(2);
    assert_int_equal(run_events_append(full, &made, 1, &error), AD_NOT_WRITTEN);
    assert_non_null(strstr(error.message, "No space left"));
    fclose(full);
}

static int forget(void **state)
{
    history_free(&made);
    return remove_directory(state);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(checksums),
        cmocka_unit_test_setup_teardown(rows_of_a_run, make_directory, forget),
        cmocka_unit_test_setup_teardown(no_row_twice, make_directory, forget),
        cmocka_unit_test_setup_teardown(damaged_tails, make_directory, forget),
        cmocka_unit_test_setup_teardown(wanted_later, make_directory, forget),
        cmocka_unit_test_setup_teardown(full_disk, make_directory, forget),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
