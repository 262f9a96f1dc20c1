/* Shapes as VTKHDF: every dataset is where the description of the format, version 2.0, has it
 * (docs.vtk.org, VTKHDF file format: PolyData, and Steps for what changes in time), and its numbers
 * are those of the table. They are copied, so comparisons are exact, but for forces that are turned
 * into the world's axes. */
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
#include "tools/files/shapes_vtk.h"

enum { FRAMES = 3, POINTS = 4, ROWS = FRAMES * POINTS, COLUMNS = 14 };

static const char *const names[COLUMNS] = {"s",  "t",  "x",  "y",  "z",  "qw",    "qx",
                                           "qy", "qz", "n1", "n2", "n3", "extra", "other"};
static double numbers[COLUMNS][ROWS];
static const double *columns[COLUMNS];
static const table_source table = {
    .names = names, .columns = columns, .ncols = COLUMNS, .nrows = ROWS};

/* Directors turned by 90 degrees about z: d1 is y, d2 is -x. */
static void fill(void)
{
    for (int k = 0; k < COLUMNS; k++) {
        columns[k] = numbers[k];
        for (int i = 0; i < ROWS; i++) {
            numbers[k][i] = k == 0             ? 0.1 * (i % POINTS)
                            : k == 1           ? 0.25 * (i / POINTS)
                            : k == 5 || k == 8 ? sqrt(0.5)
                            : k == 6 || k == 7 ? 0
                                               : k + sin(i);
        }
    }
}

/* A dataset of `rank` extents as doubles, to be freed; its numbers. */
static double *read_dataset(hid_t file, const char *name, int rank, size_t *count)
{
    hsize_t extent[2] = {0, 1};
    hid_t dataset = H5Dopen2(file, name, H5P_DEFAULT);
    if (dataset < 0) {
        fail_msg("%s is missing", name);
    }
    hid_t space = H5Dget_space(dataset);
    assert_int_equal(H5Sget_simple_extent_ndims(space), rank);
    H5Sget_simple_extent_dims(space, extent, NULL);
    *count = (size_t)(extent[0] * extent[1]);
    double *values = calloc(*count + 1, sizeof *values);
    assert_non_null(values);
    assert_true(H5Dread(dataset, H5T_NATIVE_DOUBLE, H5S_ALL, H5S_ALL, H5P_DEFAULT, values) >= 0);
    H5Sclose(space);
    H5Dclose(dataset);
    return values;
}

/* Number i of a dataset is first + step (i / each), of `count`. */
static void check_steps(hid_t file, const char *name, size_t count, double first, double step,
                        size_t each)
{
    size_t found;
    double *values = read_dataset(file, name, 1, &found);
    assert_int_equal(found, count);
    for (size_t i = 0; i < count; i++) {
        if (values[i] != first + step * (double)(i / each)) {
            fail_msg("%s: number %zu is %g", name, i, values[i]);
        }
    }
    free(values);
}

static void check_cells(hid_t file)
{
    static const char *const empty[] = {"Vertices", "Polygons", "Strips"};
    char name[64];
    size_t count;
    for (int k = 0; k < 3; k++) {
        snprintf(name, sizeof name, "VTKHDF/%s/NumberOfCells", empty[k]);
        check_steps(file, name, FRAMES, 0, 0, 1);
        snprintf(name, sizeof name, "VTKHDF/%s/Connectivity", empty[k]);
        check_steps(file, name, 0, 0, 0, 1);
        snprintf(name, sizeof name, "VTKHDF/%s/Offsets", empty[k]); /* cells + 1 of each part */
        check_steps(file, name, FRAMES, 0, 0, 1);
    }
    check_steps(file, "VTKHDF/Lines/NumberOfCells", FRAMES, 1, 0, 1);
    check_steps(file, "VTKHDF/Lines/NumberOfConnectivityIds", FRAMES, POINTS, 0, 1);
    double *offsets = read_dataset(file, "VTKHDF/Lines/Offsets", 1, &count);
    double *ids = read_dataset(file, "VTKHDF/Lines/Connectivity", 1, &count);
    assert_int_equal(count, ROWS);
    for (int k = 0; k < FRAMES; k++) {
        assert_true(offsets[2 * k] == 0 && offsets[2 * k + 1] == POINTS);
        for (int i = 0; i < POINTS; i++) {
            assert_true(ids[k * POINTS + i] == i);
        }
    }
    free(offsets);
    free(ids);
}

static void check_instants(hid_t file)
{
    int64_t steps = 0;
    size_t count;
    hid_t attribute = H5Aopen_by_name(file, "VTKHDF/Steps", "NSteps", H5P_DEFAULT, H5P_DEFAULT);
    assert_true(H5Aread(attribute, H5T_NATIVE_INT64, &steps) >= 0 && steps == FRAMES);
    H5Aclose(attribute);
    check_steps(file, "VTKHDF/Steps/Values", FRAMES, 0, 0.25, 1);
    check_steps(file, "VTKHDF/Steps/NumberOfParts", FRAMES, 1, 0, 1);
    check_steps(file, "VTKHDF/Steps/PartOffsets", FRAMES, 0, 1, 1);
    check_steps(file, "VTKHDF/Steps/PointOffsets", FRAMES, 0, POINTS, 1);
    check_steps(file, "VTKHDF/Steps/PointDataOffsets/force", FRAMES, 0, POINTS, 1);
    check_steps(file, "VTKHDF/Steps/PointDataOffsets/extra", FRAMES, 0, POINTS, 1);
    double *cells = read_dataset(file, "VTKHDF/Steps/CellOffsets", 2, &count);
    double *ids = read_dataset(file, "VTKHDF/Steps/ConnectivityIdOffsets", 2, &count);
    assert_int_equal(count, 4 * FRAMES);
    for (int k = 0; k < 4 * FRAMES; k++) { /* vertices, lines, polygons, strips */
        assert_true(cells[k] == (k % 4 == 1 ? k / 4 : 0));
        assert_true(ids[k] == (k % 4 == 1 ? POINTS * (k / 4) : 0));
    }
    free(cells);
    free(ids);
}

static void check_points(hid_t file)
{
    size_t count;
    double *places = read_dataset(file, "VTKHDF/Points", 2, &count);
    assert_int_equal(count, 3 * ROWS);
    double *force = read_dataset(file, "VTKHDF/PointData/force", 2, &count);
    assert_int_equal(count, 3 * ROWS);
    double *d1 = read_dataset(file, "VTKHDF/PointData/d1", 2, &count);
    double *extra = read_dataset(file, "VTKHDF/PointData/extra", 1, &count);
    assert_int_equal(count, ROWS);
    for (int i = 0; i < ROWS; i++) {
        const double turned[] = {-numbers[10][i], numbers[9][i], numbers[11][i]};
        for (int k = 0; k < 3; k++) {
            assert_true(places[3 * i + k] == numbers[2 + k][i]);
            assert_true(fabs(force[3 * i + k] - turned[k]) < 1e-14);
            assert_true(fabs(d1[3 * i + k] - (k == 1)) < 1e-15);
        }
        assert_true(extra[i] == numbers[12][i]);
    }
    assert_true(H5Lexists(file, "VTKHDF/PointData/qw", H5P_DEFAULT) == 0);
    assert_true(H5Lexists(file, "VTKHDF/PointData/t", H5P_DEFAULT) == 0);
    free(places);
    free(force);
    free(d1);
    free(extra);
}

static void format(void **state)
{
    ad_error error;
    char type[16] = "";
    int64_t version[2] = {0, 0};
    (void)state;
    fill();
    assert_int_equal(shapes_write(at("rod.vtkhdf"), &table, &error), AD_OK);
    hid_t file = H5Fopen(at("rod.vtkhdf"), H5F_ACC_RDONLY, H5P_DEFAULT);
    assert_true(file >= 0);
    hid_t attribute = H5Aopen_by_name(file, "VTKHDF", "Type", H5P_DEFAULT, H5P_DEFAULT);
    hid_t kind = H5Aget_type(attribute); /* of fixed length, ASCII: a reader takes no other */
    assert_true(H5Tis_variable_str(kind) == 0 && H5Tget_cset(kind) == H5T_CSET_ASCII);
    assert_true(H5Aread(attribute, kind, type) >= 0);
    assert_string_equal(type, "PolyData");
    H5Tclose(kind);
    H5Aclose(attribute);
    attribute = H5Aopen_by_name(file, "VTKHDF", "Version", H5P_DEFAULT, H5P_DEFAULT);
    assert_true(H5Aread(attribute, H5T_NATIVE_INT64, version) >= 0 && version[0] == 2);
    H5Aclose(attribute);
    check_steps(file, "VTKHDF/NumberOfPoints", FRAMES, POINTS, 0, 1);
    check_cells(file);
    check_instants(file);
    check_points(file);
    H5Fclose(file);
}

static void refusals(void **state)
{
    ad_error error;
    double apart[ROWS];
    const double *uneven[COLUMNS];
    (void)state;
    fill();
    memcpy(uneven, columns, sizeof uneven);
    memcpy(apart, numbers[1], sizeof apart);
    apart[ROWS - 1] = 9;
    uneven[1] = apart;
    const table_source short_of = {
        .names = names, .columns = uneven, .ncols = COLUMNS, .nrows = ROWS};
    assert_int_equal(shapes_write(at("rod.vtkhdf"), &short_of, &error), AD_BAD_ARGUMENT);
    assert_non_null(strstr(error.message, "rows 9 to 11"));
    const table_source flat = {.names = names, .columns = columns, .ncols = 2, .nrows = ROWS};
    assert_int_equal(shapes_write(at("rod.vtkhdf"), &flat, &error), AD_BAD_ARGUMENT);
    assert_non_null(strstr(error.message, "columns x, y, z"));
    const table_source none = {.names = names, .columns = columns, .ncols = COLUMNS, .nrows = 0};
    assert_int_equal(shapes_write(at("rod.vtkhdf"), &none, &error), AD_BAD_ARGUMENT);
    assert_int_equal(shapes_check_path("rod.pvd", &error), AD_BAD_ARGUMENT);
    assert_int_equal(shapes_check_path("rod.vtk", &error), AD_BAD_ARGUMENT);
    assert_int_equal(entries(0), 0);
}

int main(void)
{
#define TEST(function) cmocka_unit_test_setup_teardown(function, make_directory, remove_directory)
    const struct CMUnitTest tests[] = {TEST(format), TEST(refusals)};
    return cmocka_run_group_tests(tests, NULL, NULL);
}
