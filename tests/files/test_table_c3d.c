/* Tables from C3D: files are put together here, byte by byte as https://www.c3d.org describes them,
 * for three processors, as integers and as reals. Places are numbers of few bits, and comparisons
 * exact, but for the scale of integers and units, which round once. */
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
#include "tools/files/file_bytes.h"
#include "tools/files/table_file.h"

enum { BLOCK = 512, INTEL = 84, DEC = 85, MIPS = 86, POINTS = 3, FRAMES = 2, ANALOG = 2 };

typedef struct image {
    int processor;
    unsigned char bytes[4 * BLOCK];
    size_t at;
} image;

static void put_word(image *to, int word)
{
    to->bytes[to->at + (to->processor == MIPS)] = (unsigned char)(word & 255);
    to->bytes[to->at + (to->processor != MIPS)] = (unsigned char)(word >> 8 & 255);
    to->at += 2;
}

static void put_real(image *to, float real)
{
    uint32_t bits;
    memcpy(&bits, &real, sizeof bits);
    if (to->processor == DEC && real != 0) {
        bits += 2u << 23;
    }
    const int high = (int)(bits >> 16), low = (int)(bits & 0xFFFF);
    put_word(to, to->processor == INTEL ? low : high);
    put_word(to, to->processor == INTEL ? high : low);
}

static void put_bytes(image *to, const void *bytes, size_t size)
{
    memcpy(to->bytes + to->at, bytes, size);
    to->at += size;
}

/* Name and group of an entry, and the way to the next one. */
static void put_entry(image *to, const char *name, int group, int size)
{
    const unsigned char head[] = {(unsigned char)strlen(name), (unsigned char)group};
    put_bytes(to, head, 2);
    put_bytes(to, name, strlen(name));
    put_word(to, 2 + size);
}

static void put_integer(image *to, const char *name, int value)
{
    put_entry(to, name, 5, 5);
    put_bytes(to, (const unsigned char[]){2, 0}, 2);
    put_word(to, value);
    to->bytes[to->at++] = 0; /* no description */
}

static void put_number(image *to, const char *name, float value)
{
    put_entry(to, name, 5, 7);
    put_bytes(to, (const unsigned char[]){4, 0}, 2);
    put_real(to, value);
    to->bytes[to->at++] = 0;
}

static void put_text(image *to, const char *name, const char *text, int width, int count)
{
    put_entry(to, name, 5, 5 + width * count);
    put_bytes(to, (const unsigned char[]){255, 2, (unsigned char)width, (unsigned char)count}, 4);
    put_bytes(to, text, (size_t)(width * count));
    to->bytes[to->at++] = 0;
}

/* Two frames of three markers; the second is lost in the second frame. */
static const float places[FRAMES][POINTS][3] = {{{1, -2, 0.5F}, {3, 4, 5}, {0, -0.25F, 12}},
                                                {{1.5F, -2, 0}, {7, 7, 7}, {8, 16, -32}}};

static void put_frames(image *to, float scale)
{
    const bool real = scale < 0;
    for (int i = 0; i < FRAMES * POINTS; i++) {
        const int lost = i == 4;
        for (int c = 0; c < 4; c++) {
            const float place = c < 3 ? (&places[0][0][0])[3 * i + c] : 0;
            const float number = c < 3 ? (real ? place : place / scale) : lost ? -1 : 0x7F07;
            real ? put_real(to, number) : put_word(to, (int)number);
        }
        for (int a = 0; a < ANALOG && i % POINTS == POINTS - 1; a++) {
            real ? put_real(to, 99) : put_word(to, 99);
        }
    }
}

static void make(image *to, int processor, float scale, const char *unit)
{
    static const char labels[] = "Tip - 1   "
                                 "2nd      *"
                                 "Tip_1     ";
    *to = (image){.processor = processor};
    put_bytes(to, (const unsigned char[]){2, 80}, 2);
    put_word(to, POINTS);
    put_word(to, ANALOG);
    to->at = BLOCK;
    put_bytes(to, (const unsigned char[]){0, 0, 1, (unsigned char)processor}, 4);
    put_integer(to, "USED", POINTS); /* entries may come before the group that they are of */
    put_entry(to, "OTHER", -4, 1);
    to->bytes[to->at++] = 0;
    put_entry(to, "POINT", -5, 1);
    to->bytes[to->at++] = 0;
    put_number(to, "SCALE", scale);
    put_number(to, "RATE", 50);
    put_integer(to, "DATA_START", 3);
    put_integer(to, "FRAMES", FRAMES);
    put_text(to, "LABELS", labels, 10, POINTS);
    put_text(to, "UNITS", unit, (int)strlen(unit), 1);
    to->at = (size_t)2 * BLOCK;
    put_frames(to, scale);
}

static ad_status read_image(const image *image, size_t size, table_numbers numbers,
                            table_file **table, ad_error *error)
{
    char path[512];
    snprintf(path, sizeof path, "%s", at("markers.c3d"));
    assert_int_equal(file_bytes_write(path, image->bytes, size, error), AD_OK);
    return table_read(path, numbers, table, error);
}

static void assert_places(const table_file *table, double unit, double tolerance)
{
    static const char *const names[POINTS] = {"Tip_1", "_2nd", "marker_3"};
    for (int i = 0; i < FRAMES * POINTS; i++) {
        for (int c = 0; c < 3; c++) {
            char name[32];
            snprintf(name, sizeof name, "%s.%c", names[i % POINTS], "xyz"[c]);
            const double *column = table_column(table, name);
            assert_non_null(column);
            const double is = column[i / POINTS], was = unit * (&places[0][0][0])[3 * i + c];
            assert_true(i == 4 ? isnan(is) : fabs(is - was) <= tolerance * fabs(was));
        }
    }
    assert_true(table_column(table, "t")[1] == 1.0 / 50);
}

static void all_processors_and_units(void **state)
{
    (void)state;
    static const struct {
        float scale;
        const char *unit;
        double metres;
    } cases[] = {{-1e-3F, "m", 1}, {-1, "mm", 1e-3}, {0.25F, "m", 1}, {0.25F, "cm ", 1e-2}};
    for (int processor = INTEL; processor <= MIPS; processor++) {
        for (size_t i = 0; i < sizeof cases / sizeof *cases; i++) {
            image file;
            ad_error error = {AD_OK, ""};
            table_file *table;
            make(&file, processor, cases[i].scale, cases[i].unit);
            if (read_image(&file, file.at, TABLE_MEASURED, &table, &error) != AD_OK) {
                fail_msg("%s", error.message);
            }
            assert_int_equal(table_rows(table), FRAMES);
            assert_int_equal(table_columns(table), 1 + 3 * POINTS);
            assert_places(table, cases[i].metres, cases[i].metres == 1 ? 0 : 4e-16);
            table_free(table);
        }
    }
}

static void assert_refused(const image *file, size_t size, table_numbers numbers,
                           const char *reason)
{
    ad_error error = {AD_OK, ""};
    table_file *table;
    assert_int_equal(read_image(file, size, numbers, &table, &error), AD_BAD_INPUT);
    assert_null(table);
    assert_null(strchr(error.message, '\n'));
    if (!strstr(error.message, reason)) {
        fail_msg("'%s' does not say '%s'", error.message, reason);
    }
}

static void what_is_refused(void **state)
{
    (void)state;
    image file;
    make(&file, INTEL, -1, "ft");
    assert_refused(&file, file.at, TABLE_MEASURED, "POINT:UNITS is not known; allowed: m, cm, mm");
    make(&file, INTEL, INFINITY, "m");
    assert_refused(&file, file.at, TABLE_MEASURED, "POINT lacks one of RATE");
    make(&file, INTEL, -1, "m");
    assert_refused(&file, file.at, TABLE_FINITE, "column '_2nd.x' row 2: the marker was lost");
    assert_refused(&file, file.at - 1, TABLE_MEASURED, "ends before its last frame");
    assert_refused(&file, BLOCK + 40, TABLE_MEASURED, "ends within its parameters");
    assert_refused(&file, 1, TABLE_MEASURED, "is no C3D");
    file.bytes[BLOCK + 3] = 87;
    assert_refused(&file, file.at, TABLE_MEASURED, "unknown processor");
    ad_error error;
    assert_int_equal(table_check_path(at("markers.c3d"), &error), AD_BAD_ARGUMENT);
    assert_non_null(strstr(error.message, ".c3d is read, not written; allowed: .csv"));
}

int main(void)
{
#define TEST(function) cmocka_unit_test_setup_teardown(function, make_directory, remove_directory)
    const struct CMUnitTest tests[] = {TEST(all_processors_and_units), TEST(what_is_refused)};
    return cmocka_run_group_tests(tests, NULL, NULL);
}
