#include "tools/files/shapes_vtk.h"

#include "tools/files/file_bytes.h"
#include "tools/files/hdf5_image.h"

#include <stdint.h>
#include <stdlib.h>
#include <string.h>

enum { ARRAYS_MAX = TABLE_MAX_COLUMNS + 16 };

typedef struct array {
    const char *name;
    int components;           /* 1 or 3 */
    const double *columns[3]; /* NULL: of a director */
    int director;             /* 0 to 2 */
    bool to_world;            /* components along the directors become those of the world */
} array;

typedef struct shapes {
    const table_source *table;
    table_shapes at;
    const double *place[3];      /* x, y, z; of a beam s, NULL, w */
    const double *quaternion[4]; /* all NULL: there is none */
    int count;
    array arrays[ARRAYS_MAX];
} shapes;

/* ---- what there is ------------------------------------------------------------------------- */

static const struct vector {
    const char *name, *columns[3];
    bool to_world;
} vectors[] = {
    {"strain", {"v1", "v2", "v3"}, false},   {"curvature", {"u1", "u2", "u3"}, false},
    {"force", {"n1", "n2", "n3"}, true},     {"moment", {"m1", "m2", "m3"}, true},
    {"velocity", {"vx", "vy", "vz"}, false}, {"angular_velocity", {"w1", "w2", "w3"}, false}};

enum { VECTORS = sizeof vectors / sizeof *vectors };

static bool is_used(const shapes *shapes, const double *column)
{
    for (int k = 0; k < 3; k++) {
        if (column == shapes->at.place[k]) {
            return true;
        }
    }
    for (int k = 0; k < 4; k++) {
        if (column == shapes->quaternion[k]) {
            return true;
        }
    }
    for (int i = 0; i < shapes->count; i++) {
        for (int k = 0; k < shapes->arrays[i].components; k++) {
            if (column == shapes->arrays[i].columns[k]) {
                return true;
            }
        }
    }
    return column == shapes->at.t || column == shapes->at.member;
}

static void find_vectors(shapes *shapes)
{
    for (int v = 0; v < VECTORS; v++) {
        array a = {.name = vectors[v].name,
                   .components = 3,
                   .to_world = vectors[v].to_world && shapes->quaternion[0]};
        for (int k = 0; k < 3; k++) {
            a.columns[k] = table_source_column(shapes->table, vectors[v].columns[k]);
        }
        if (a.columns[0] && a.columns[1] && a.columns[2]) {
            shapes->arrays[shapes->count++] = a;
        }
    }
    for (int k = 0; k < 3 && shapes->quaternion[0]; k++) {
        static const char *const names[] = {"d1", "d2", "d3"};
        shapes->arrays[shapes->count++] = (array){.name = names[k], .components = 3, .director = k};
    }
}

static ad_status find(shapes *x, const table_source *table, ad_error *error)
{
    static const char *const turned[] = {"qw", "qx", "qy", "qz"};
    *x = (shapes){.table = table};
    ad_status status = table_shapes_of(table, &x->at, error);
    if (status != AD_OK) {
        return status;
    }
    memcpy(x->place, x->at.place, sizeof x->place);
    if (!x->place[0]) {
        x->place[0] = x->at.s;
        x->place[2] = table_source_column(table, "w");
        if (!x->place[0] || !x->place[2]) {
            return ad_fail(error, AD_BAD_ARGUMENT,
                           "there are no shapes; needed: columns x, y, z, or s and w of a beam");
        }
    }
    for (int k = 0; k < 4; k++) {
        x->quaternion[k] = table_source_column(table, turned[k]);
    }
    if (!x->quaternion[0] || !x->quaternion[1] || !x->quaternion[2] || !x->quaternion[3]) {
        memset(x->quaternion, 0, sizeof x->quaternion);
    }
    find_vectors(x);
    for (size_t k = 0; k < table->ncols; k++) {
        const double *column = table_source_column(table, table->names[k]);
        if (column && !is_used(x, column)) {
            x->arrays[x->count++] =
                (array){.name = table->names[k], .components = 1, .columns = {column}};
        }
    }
    return AD_OK;
}

/* Director `which` at a row: a column of the rotation matrix of the quaternion. */
static void director(const shapes *shapes, size_t row, int which, double d[3])
{
    const double w = shapes->quaternion[0][row];
    const double v[3] = {shapes->quaternion[1][row], shapes->quaternion[2][row],
                         shapes->quaternion[3][row]};
    const double twice = 2 / (w * w + v[0] * v[0] + v[1] * v[1] + v[2] * v[2]);
    const int next = (which + 1) % 3, last = (which + 2) % 3;
    d[which] = 1 - twice * (v[next] * v[next] + v[last] * v[last]);
    d[next] = twice * (v[which] * v[next] + w * v[last]);
    d[last] = twice * (v[which] * v[last] - w * v[next]);
}

static void value(const shapes *shapes, const array *a, size_t row, double to[3])
{
    if (!a->columns[0]) {
        director(shapes, row, a->director, to);
        return;
    }
    for (int k = 0; k < a->components; k++) {
        to[k] = a->columns[k][row];
    }
    if (a->to_world) {
        double world[3] = {0, 0, 0}, d[3];
        for (int i = 0; i < 3; i++) {
            director(shapes, row, i, d);
            for (int k = 0; k < 3; k++) {
                world[k] += to[i] * d[k];
            }
        }
        memcpy(to, world, sizeof world);
    }
}

/* values [rows][components]; `a` NULL: the places. */
static void fill(const shapes *shapes, const array *a, size_t rows, double *values)
{
    for (size_t i = 0; i < rows; i++) {
        if (a) {
            value(shapes, a, i, values + i * (size_t)a->components);
            continue;
        }
        for (int k = 0; k < 3; k++) {
            values[3 * i + (size_t)k] = shapes->place[k] ? shapes->place[k][i] : 0;
        }
    }
}

/* The time of a frame; members are counted, and so are instants of several members. */
static double time_of(const shapes *shapes, size_t frame)
{
    return shapes->at.t && !shapes->at.member ? shapes->at.t[frame * shapes->at.points]
                                              : (double)frame;
}

/* ---- one HDF5 file ------------------------------------------------------------------------- */

/* A dataset of `rows` by `columns` numbers; columns 0: of one dimension. */
static bool put(hid_t group, const char *name, hid_t type, const void *values, size_t rows,
                size_t columns)
{
    hid_t dataset = hdf5_image_dataset(group, name, type, type, columns ? 2 : 1,
                                       (const hsize_t[]){rows, columns}, values);
    hdf5_image_close(dataset);
    return dataset >= 0;
}

/* numbers [2 + frames] scratch: first + step k, k = 0 .. count - 1. */
static const int64_t *counted(int64_t *numbers, size_t count, int64_t first, int64_t step)
{
    for (size_t k = 0; k < count; k++) {
        numbers[k] = first + step * (int64_t)k;
    }
    return numbers;
}

/* One polyline for each instant, all with the numbers 0 .. points - 1: VTK needs them again for
 * each instant. `lines` false: a kind of cells of which there are none. */
static bool put_cells(hid_t root, const char *kind, bool lines, const shapes *shapes,
                      int64_t *numbers)
{
    const size_t frames = shapes->at.frames, points = shapes->at.points;
    hid_t group = hdf5_image_group(root, kind);
    bool good = group >= 0;
    good = good && put(group, "NumberOfCells", H5T_NATIVE_INT64, counted(numbers, frames, lines, 0),
                       frames, 0);
    good = good && put(group, "NumberOfConnectivityIds", H5T_NATIVE_INT64,
                       counted(numbers, frames, lines ? (int64_t)points : 0, 0), frames, 0);
    for (size_t k = 0; k < 2 * frames; k++) {
        numbers[k] = lines && k % 2 ? (int64_t)points : 0;
    }
    good = good && put(group, "Offsets", H5T_NATIVE_INT64, numbers, lines ? 2 * frames : frames, 0);
    for (size_t k = 0; lines && k < frames * points; k++) {
        numbers[k] = (int64_t)(k % points);
    }
    good = good &&
           put(group, "Connectivity", H5T_NATIVE_INT64, numbers, lines ? frames * points : 0, 0);
    hdf5_image_close(group);
    return good;
}

/* Where the numbers of each instant begin. */
static bool put_steps(hid_t root, const shapes *shapes, int64_t *numbers, double *values)
{
    const size_t frames = shapes->at.frames, points = shapes->at.points;
    const int64_t count = (int64_t)frames;
    hid_t steps = hdf5_image_group(root, "Steps"),
          offsets = hdf5_image_group(steps, "PointDataOffsets");
    bool good = offsets >= 0 && hdf5_image_attribute(steps, "NSteps", H5T_NATIVE_INT64,
                                                     H5T_NATIVE_INT64, 0, &count);
    for (size_t k = 0; k < frames; k++) {
        values[k] = time_of(shapes, k);
    }
    good = good && put(steps, "Values", H5T_NATIVE_DOUBLE, values, frames, 0);
    good = good &&
           put(steps, "NumberOfParts", H5T_NATIVE_INT64, counted(numbers, frames, 1, 0), frames, 0);
    good = good &&
           put(steps, "PartOffsets", H5T_NATIVE_INT64, counted(numbers, frames, 0, 1), frames, 0);
    counted(numbers, frames, 0, (int64_t)points);
    good = good && put(steps, "PointOffsets", H5T_NATIVE_INT64, numbers, frames, 0);
    for (int i = 0; good && i < shapes->count; i++) {
        good = put(offsets, shapes->arrays[i].name, H5T_NATIVE_INT64, numbers, frames, 0);
    }
    enum { KINDS = 4, LINES = 1 }; /* vertices, lines, polygons, strips */
    for (size_t k = 0; k < KINDS * frames; k++) {
        numbers[k] = k % KINDS == LINES ? (int64_t)(k / KINDS) : 0;
    }
    good = good && put(steps, "CellOffsets", H5T_NATIVE_INT64, numbers, frames, KINDS);
    for (size_t k = 0; k < KINDS * frames; k++) {
        numbers[k] *= (int64_t)points;
    }
    good = good && put(steps, "ConnectivityIdOffsets", H5T_NATIVE_INT64, numbers, frames, KINDS);
    hdf5_image_close(offsets);
    hdf5_image_close(steps);
    return good;
}

static bool put_root(hid_t root, const shapes *shapes, int64_t *numbers, double *values)
{
    static const char type_name[] = "PolyData";
    const size_t frames = shapes->at.frames, rows = frames * shapes->at.points;
    const int64_t version[] = {2, 0};
    hid_t text = H5Tcopy(H5T_C_S1);
    bool good =
        H5Tset_size(text, sizeof type_name - 1) >= 0 && H5Tset_strpad(text, H5T_STR_NULLPAD) >= 0 &&
        hdf5_image_attribute(root, "Type", text, text, 0, type_name) &&
        hdf5_image_attribute(root, "Version", H5T_NATIVE_INT64, H5T_NATIVE_INT64, 2, version);
    hdf5_image_close(text);
    counted(numbers, frames, (int64_t)shapes->at.points, 0);
    good = good && put(root, "NumberOfPoints", H5T_NATIVE_INT64, numbers, frames, 0);
    fill(shapes, NULL, rows, values);
    good = good && put(root, "Points", H5T_NATIVE_DOUBLE, values, rows, 3);
    static const char *const kinds[] = {"Vertices", "Lines", "Polygons", "Strips"};
    for (int k = 0; k < 4; k++) {
        good = good && put_cells(root, kinds[k], k == 1, shapes, numbers);
    }
    hid_t data = hdf5_image_group(root, "PointData");
    for (int i = 0; good && i < shapes->count; i++) {
        const array *a = &shapes->arrays[i];
        fill(shapes, a, rows, values);
        good = put(data, a->name, H5T_NATIVE_DOUBLE, values, rows, a->components == 3 ? 3 : 0);
    }
    hdf5_image_close(data);
    return good && put_steps(root, shapes, numbers, values);
}

/* Shapes, and room for their numbers. */
typedef struct filling {
    const shapes *shapes;
    int64_t *numbers;
    double *values;
} filling;

static bool put_file(hid_t file, const void *context)
{
    const filling *f = context;
    hid_t root = hdf5_image_group(file, "VTKHDF");
    bool written = root >= 0 && put_root(root, f->shapes, f->numbers, f->values);
    hdf5_image_close(root);
    return written;
}

static ad_status write_hdf5(const shapes *shapes, const char *path, ad_error *error)
{
    const size_t rows = shapes->at.frames * shapes->at.points;
    filling f = {.shapes = shapes};
    f.numbers = malloc((4 * shapes->at.frames + rows) * sizeof *f.numbers);
    f.values = malloc((3 * rows + shapes->at.frames) * sizeof *f.values);
    unsigned char *bytes = NULL;
    size_t size = 0;
    const size_t each = 3 * sizeof *f.values * rows; /* bytes of points or an array, at most */
    ad_status status =
        f.numbers && f.values
            ? hdf5_image_write(0, each * (size_t)(shapes->count + 2), put_file, &f, &bytes, &size)
            : AD_NO_MEMORY;
    status = status == AD_OK ? file_bytes_write(path, bytes, size, error)
                             : ad_fail(error, status, "%s: cannot be written: out of memory",
                                       file_bytes_shown(path));
    free(bytes);
    free(f.values);
    free(f.numbers);
    return status;
}

/* ---- the face ------------------------------------------------------------------------------ */

bool shapes_is_vtk(const char *path)
{
    static const char ending[] = ".vtkhdf";
    const size_t length = strlen(path), more = strlen(ending);
    return length > more && strcmp(path + length - more, ending) == 0;
}

ad_status shapes_check_path(const char *path, ad_error *error)
{
    if (shapes_is_vtk(path)) {
        return file_bytes_check(path, error);
    }
    ad_error why;
    ad_status status = table_check_path(path, &why);
    return status == AD_OK ? AD_OK
                           : ad_fail(error, status, "%s%s", why.message,
                                     status == AD_BAD_ARGUMENT ? ", and for ParaView .vtkhdf" : "");
}

ad_status shapes_write(const char *path, const table_source *table, ad_error *error)
{
    shapes x;
    ad_error why;
    if (!shapes_is_vtk(path)) {
        return table_write(path, table, error);
    }
    ad_status status = shapes_check_path(path, error);
    if (status == AD_OK && find(&x, table, &why) != AD_OK) {
        status = ad_fail(error, AD_BAD_ARGUMENT, "%s: %s", file_bytes_shown(path), why.message);
    }
    return status == AD_OK ? write_hdf5(&x, path, error) : status;
}
