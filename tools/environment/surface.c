#include "tools/environment/surface.h"

#include "physics/numerics/quaternion.h"
#include "tools/files/checkpoint.h"
#include "tools/files/file_bytes.h"

#include <locale.h>
#include <math.h>
#include <stdlib.h>
#include <string.h>
#include <strings.h>

enum { STL_HEAD = 84, STL_TRIANGLE = 50 };

/* What grows while a file is read. */
typedef struct reader {
    surface *to;
    const char *text, *end; /* a zero byte follows */
    double unit;
    size_t corners_max, triangles_max;
    size_t points, points_max; /* of a file, */
    uint32_t *corner_of;       /* [points_max] the corners that they are */
    uint32_t *slots;           /* [slot_count] corners by their places; a power of two */
    size_t slot_count;
    uint32_t line;
    ad_error *error;
} reader;

static ad_status no_memory(reader *r)
{
    return ad_fail(r->error, AD_NO_MEMORY, "%.300s: out of memory for its triangles",
                   file_bytes_shown(r->to->name));
}

static ad_status refuse(const reader *r, const char *why)
{
    return ad_fail(r->error, AD_BAD_INPUT, "%.300s:%u: %.160s", file_bytes_shown(r->to->name),
                   (unsigned)r->line, why);
}

static bool grow(void *array, size_t *most, size_t needed, size_t size)
{
    if (needed <= *most) {
        return true;
    }
    const size_t now = needed * 2 + 1024;
    void *moved = now < UINT32_MAX ? realloc(*(void **)array, now * size) : NULL;
    if (moved) {
        *(void **)array = moved;
        *most = now;
    }
    return moved != NULL;
}

/* ---- corners at one place are one ------------------------------------------------------------ */

static size_t slot_of(const reader *r, const double p[3])
{
    size_t slot = (size_t)checkpoint_hash(CHECKPOINT_HASH_START, p, 3 * sizeof *p);
    for (slot &= r->slot_count - 1; r->slots[slot] != SURFACE_NONE;
         slot = (slot + 1) & (r->slot_count - 1)) {
        if (memcmp(&r->to->corner[3 * (size_t)r->slots[slot]], p, 3 * sizeof *p) == 0) {
            break;
        }
    }
    return slot;
}

static bool more_slots(reader *r)
{
    if (2 * (r->to->corners + 1) < r->slot_count) {
        return true;
    }
    r->slot_count = r->slot_count ? 2 * r->slot_count : 4096;
    free(r->slots);
    r->slots = malloc(r->slot_count * sizeof *r->slots);
    if (!r->slots) {
        return false;
    }
    memset(r->slots, 0xff, r->slot_count * sizeof *r->slots);
    for (size_t i = 0; i < r->to->corners; i++) {
        r->slots[slot_of(r, &r->to->corner[3 * i])] = (uint32_t)i;
    }
    return true;
}

static ad_status add_point(reader *r, const double in_file[3])
{
    surface *to = r->to;
    double p[3];
    for (int i = 0; i < 3; i++) {
        p[i] = in_file[i] * r->unit + 0.0; /* no -0 */
        if (!isfinite(p[i])) {
            return refuse(r, "a coordinate is not finite");
        }
    }
    if (!more_slots(r) || !grow(&r->corner_of, &r->points_max, r->points + 1, sizeof(uint32_t)) ||
        !grow(&to->corner, &r->corners_max, to->corners + 1, 3 * sizeof(double))) {
        return no_memory(r);
    }
    const size_t slot = slot_of(r, p);
    if (r->slots[slot] == SURFACE_NONE) {
        r->slots[slot] = (uint32_t)to->corners;
        memcpy(&to->corner[3 * to->corners++], p, sizeof p);
    }
    r->corner_of[r->points++] = r->slots[slot];
    return AD_OK;
}

/* The square of twice its area below rounding of that of its longest edge. */
static bool is_flat(const surface *of, const uint32_t corners[3])
{
    double edge[3][3], longest = 0, normal[3];
    for (int k = 0; k < 3; k++) {
        double square = 0;
        for (int i = 0; i < 3; i++) {
            edge[k][i] = of->corner[3 * (size_t)corners[(k + 1) % 3] + (size_t)i] -
                         of->corner[3 * (size_t)corners[k] + (size_t)i];
            square += edge[k][i] * edge[k][i];
        }
        longest = fmax(longest, square);
    }
    double area = 0;
    for (int i = 0; i < 3; i++) {
        const int j = (i + 1) % 3, k = (i + 2) % 3;
        normal[i] = edge[0][j] * edge[1][k] - edge[0][k] * edge[1][j];
        area += normal[i] * normal[i];
    }
    return !(area > 1e-20 * longest * longest);
}

static ad_status add_triangle(reader *r, const size_t points[3])
{
    surface *to = r->to;
    if (!grow(&to->triangle, &r->triangles_max, to->triangles + 1, 3 * sizeof(uint32_t))) {
        return no_memory(r);
    }
    uint32_t *const corners = &to->triangle[3 * to->triangles++];
    for (int k = 0; k < 3; k++) {
        corners[k] = r->corner_of[points[k]];
    }
    if (is_flat(to, corners)) {
        return r->line
                   ? refuse(r, "the triangle has no area; corners must not be on one line")
                   : ad_fail(r->error, AD_BAD_INPUT,
                             "%.300s: triangle %zu has no area; corners must not be on one line",
                             file_bytes_shown(to->name), to->triangles);
    }
    return AD_OK;
}

/* ---- formats --------------------------------------------------------------------------------- */

static ad_status read_binary(reader *r, size_t size)
{
    ad_status status = AD_OK;
    for (size_t at = STL_HEAD; at + STL_TRIANGLE <= size && status == AD_OK; at += STL_TRIANGLE) {
        float numbers[12]; /* the normal, which corners tell too, and three corners */
        memcpy(numbers, r->text + at, sizeof numbers);
        for (int k = 1; k <= 3 && status == AD_OK; k++) {
            status = add_point(
                r, (const double[3]){numbers[3 * k], numbers[3 * k + 1], numbers[3 * k + 2]});
        }
        if (status == AD_OK) {
            status =
                add_triangle(r, (const size_t[3]){r->points - 3, r->points - 2, r->points - 1});
        }
    }
    return status;
}

static bool is_blank(char c)
{
    return c == ' ' || c == '\t' || c == '\r' || c == '\v' || c == '\f';
}

static void skip_blanks(const char **at)
{
    while (is_blank(**at)) {
        ++*at;
    }
}

/* Whether the word comes next, then the place behind it. */
static bool takes(const char **at, const char *word)
{
    const size_t length = strlen(word);
    skip_blanks(at);
    const char behind = strncasecmp(*at, word, length) == 0 ? (*at)[length] : 'x';
    if (behind && behind != '\n' && !is_blank(behind)) {
        return false;
    }
    *at += length;
    return true;
}

static bool takes_numbers(const char **at, double numbers[3])
{
    for (int i = 0; i < 3; i++) {
        char *behind;
        skip_blanks(at);
        if (**at == '\n') {
            return false;
        }
        numbers[i] = strtod(*at, &behind);
        if (behind == *at) {
            return false;
        }
        *at = behind;
    }
    return true;
}

/* One line of STL as text. Only corners count; facets end with every third. */
static ad_status read_stl_line(reader *r, const char *at)
{
    double numbers[3];
    if (takes(&at, "vertex")) {
        if (!takes_numbers(&at, numbers)) {
            return refuse(r, "vertex: needs three numbers");
        }
        ad_status status = add_point(r, numbers);
        if (status == AD_OK && r->points % 3 == 0) {
            status =
                add_triangle(r, (const size_t[3]){r->points - 3, r->points - 2, r->points - 1});
        }
        return status;
    }
    if (takes(&at, "endfacet") || takes(&at, "endloop")) {
        return r->points % 3 ? refuse(r, "a facet has other than three corners") : AD_OK;
    }
    skip_blanks(&at);
    const bool known = takes(&at, "solid") || takes(&at, "facet") || takes(&at, "outer") ||
                       takes(&at, "endsolid") || !*at || *at == '\n';
    return known ? AD_OK : refuse(r, "is no line of STL: solid, facet, outer loop, vertex, end...");
}

/* "f 1 2/5 -1//7 ...": a polygon, which must be convex, as triangles from its first corner. */
static ad_status read_obj_face(reader *r, const char *at)
{
    size_t points[3];
    ad_status status = AD_OK;
    int count = 0;
    for (skip_blanks(&at); *at && *at != '\n' && *at != '#' && status == AD_OK; skip_blanks(&at)) {
        char *behind;
        const long given = strtol(at, &behind, 10);
        const long point = given < 0 ? (long)r->points + given : given - 1;
        if (behind == at || point < 0 || (size_t)point >= r->points) {
            return refuse(r, "f: needs numbers of corners that are given before it");
        }
        points[count < 2 ? count : 2] = (size_t)point;
        if (++count >= 3) {
            status = add_triangle(r, points);
            points[1] = points[2];
        }
        for (at = behind; *at && *at != '\n' && !is_blank(*at);) {
            at++;
        }
    }
    return status == AD_OK && count < 3 ? refuse(r, "f: needs three corners or more") : status;
}

static ad_status read_obj_line(reader *r, const char *at)
{
    double numbers[3];
    if (takes(&at, "v")) {
        return takes_numbers(&at, numbers) ? add_point(r, numbers)
                                           : refuse(r, "v: needs three numbers");
    }
    return takes(&at, "f") ? read_obj_face(r, at) : AD_OK; /* what else there is has no shape */
}

static ad_status read_lines(reader *r, ad_status (*read_line)(reader *, const char *))
{
    surface *to = r->to;
    const char *at = r->text;
    size_t lines_max = 0;
    ad_status status = AD_OK;
    while (at < r->end && status == AD_OK) {
        r->line++;
        const size_t before = to->triangles;
        status = read_line(r, at);
        if (status == AD_OK && !grow(&to->line, &lines_max, to->triangles, sizeof(uint32_t))) {
            status = no_memory(r);
        }
        for (size_t i = before; i < to->triangles && status == AD_OK; i++) {
            to->line[i] = r->line;
        }
        const char *const line_end = memchr(at, '\n', (size_t)(r->end - at));
        at = line_end ? line_end + 1 : r->end;
    }
    return status;
}

static ad_status read_text(reader *r, bool is_obj)
{
    const locale_t plain = newlocale(LC_NUMERIC_MASK, "C", (locale_t)0);
    if (!plain) {
        return no_memory(r);
    }
    const locale_t before = uselocale(plain);
    ad_status status = read_lines(r, is_obj ? read_obj_line : read_stl_line);
    uselocale(before);
    freelocale(plain);
    if (status == AD_OK && !is_obj && r->points % 3) {
        status = refuse(r, "the file ends within a facet");
    }
    return status;
}

static ad_status read_any(reader *r, size_t size)
{
    const surface *to = r->to;
    const char *const dot = strrchr(to->name, '.');
    if (dot && strcasecmp(dot, ".obj") == 0) {
        return read_text(r, true);
    }
    if (!dot || strcasecmp(dot, ".stl") != 0) {
        return ad_fail(r->error, AD_BAD_INPUT, "%.300s: has another ending than .stl and .obj",
                       file_bytes_shown(to->name));
    }
    uint32_t count = 0;
    if (size >= STL_HEAD) {
        memcpy(&count, r->text + STL_HEAD - 4, 4);
        if (size == STL_HEAD + STL_TRIANGLE * (size_t)count) {
            return read_binary(r, size);
        }
    }
    if (strncasecmp(r->text, "solid", 5) != 0 || memchr(r->text, 0, size)) {
        return ad_fail(r->error, AD_BAD_INPUT,
                       "%.300s: has %zu bytes, and its head says %u triangles, which are %zu bytes "
                       "of STL",
                       file_bytes_shown(to->name), size, (unsigned)count,
                       STL_HEAD + STL_TRIANGLE * (size_t)count);
    }
    return read_text(r, false);
}

/* ---- edges ----------------------------------------------------------------------------------- */

typedef struct edge {
    uint32_t low, high; /* corners */
    uint32_t triangle, side;
} edge;

static int compare_edges(const void *one, const void *other)
{
    const edge *const a = one, *const b = other;
    if (a->low != b->low) {
        return a->low < b->low ? -1 : 1;
    }
    if (a->high != b->high) {
        return a->high < b->high ? -1 : 1;
    }
    return a->triangle < b->triangle ? -1 : a->triangle > b->triangle;
}

/* Neighbours across edges of two triangles. */
static ad_status find_neighbours(surface *of)
{
    const size_t count = 3 * of->triangles;
    edge *const edges = malloc(count * sizeof *edges);
    of->neighbour = malloc(count * sizeof *of->neighbour);
    if (!edges || !of->neighbour) {
        free(edges);
        return AD_NO_MEMORY;
    }
    for (size_t i = 0; i < count; i++) {
        const uint32_t a = of->triangle[i], b = of->triangle[i % 3 == 2 ? i - 2 : i + 1];
        edges[i] = (edge){a < b ? a : b, a < b ? b : a, (uint32_t)(i / 3), (uint32_t)(i % 3)};
        of->neighbour[i] = SURFACE_NONE;
    }
    qsort(edges, count, sizeof *edges, compare_edges);
    for (size_t i = 0, next; i < count; i = next) {
        for (next = i + 1; next < count && edges[next].low == edges[i].low &&
                           edges[next].high == edges[i].high;) {
            next++;
        }
        if (next - i == 2) {
            const edge *const a = &edges[i], *const b = a + 1;
            of->neighbour[3 * (size_t)a->triangle + a->side] = b->triangle;
            of->neighbour[3 * (size_t)b->triangle + b->side] = a->triangle;
        }
    }
    free(edges);
    return AD_OK;
}

static void find_bounds(surface *of)
{
    for (size_t i = 0; i < 3 * of->corners; i++) {
        const double at = of->corner[i];
        of->low[i % 3] = i < 3 ? at : fmin(of->low[i % 3], at);
        of->high[i % 3] = i < 3 ? at : fmax(of->high[i % 3], at);
    }
}

ad_status surface_read(const char *path, double unit, surface **result, ad_error *error)
{
    *result = NULL;
    unsigned char *bytes = NULL;
    size_t size = 0, file_size;
    ad_status status = file_bytes_read(path, 0, &bytes, &size, &file_size, error);
    if (status != AD_OK) {
        return status;
    }
    surface *const of = calloc(1, sizeof *of);
    reader r = {.to = of, .unit = unit, .error = error, .text = (const char *)bytes};
    r.end = r.text + size;
    if (of) {
        of->name = malloc(strlen(path) + 1);
    }
    if (!of || !of->name) {
        status = ad_fail(error, AD_NO_MEMORY, "out of memory for a surface");
    } else {
        strcpy(of->name, path);
        of->hash = checkpoint_hash(checkpoint_hash(CHECKPOINT_HASH_START, bytes, size), &unit,
                                   sizeof unit);
        status = read_any(&r, size);
    }
    if (status == AD_OK && of->triangles == 0) {
        status = ad_fail(error, AD_BAD_INPUT, "%.300s: has no triangles", file_bytes_shown(path));
    }
    if (status == AD_OK && find_neighbours(of) != AD_OK) {
        status = no_memory(&r);
    }
    free(bytes);
    free(r.corner_of);
    free(r.slots);
    if (status != AD_OK) {
        surface_free(of);
        return status;
    }
    find_bounds(of);
    *result = of;
    return AD_OK;
}

void surface_place(surface *of, const double position[3], const double rotation[4])
{
    double q[4], matrix[3][3], turned[3];
    memcpy(q, rotation, sizeof q);
    quaternion_normalize(q);
    rotation_matrix(q, matrix);
    for (size_t i = 0; i < of->corners; i++) {
        to_world(matrix, &of->corner[3 * i], turned);
        for (size_t k = 0; k < 3; k++) {
            of->corner[3 * i + k] = position[k] + turned[k];
        }
    }
    of->hash = checkpoint_hash(of->hash, position, 3 * sizeof *position);
    of->hash = checkpoint_hash(of->hash, rotation, 4 * sizeof *rotation);
    find_bounds(of);
}

void surface_free(surface *of)
{
    if (of) {
        free(of->name);
        free(of->corner);
        free(of->triangle);
        free(of->neighbour);
        free(of->line);
        free(of);
    }
}

/* ---- what is wrong --------------------------------------------------------------------------- */

static ad_status refuse_triangle(const surface *of, size_t triangle, const char *why,
                                 ad_error *error)
{
    const double *const p = &of->corner[3 * (size_t)of->triangle[3 * triangle]];
    if (of->line) {
        return ad_fail(error, AD_BAD_INPUT, "%.250s:%u: near (%.6g, %.6g, %.6g) m %s",
                       file_bytes_shown(of->name), (unsigned)of->line[triangle], p[0], p[1], p[2],
                       why);
    }
    return ad_fail(error, AD_BAD_INPUT, "%.250s: triangle %zu, near (%.6g, %.6g, %.6g) m: %s",
                   file_bytes_shown(of->name), triangle + 1, p[0], p[1], p[2], why);
}

/* Whether the neighbour across an edge goes along it the other way. */
static bool turns_alike(const surface *of, size_t edge_index)
{
    const size_t other = of->neighbour[edge_index];
    const uint32_t a = of->triangle[edge_index];
    const uint32_t b = of->triangle[edge_index % 3 == 2 ? edge_index - 2 : edge_index + 1];
    for (size_t k = 0; k < 3; k++) {
        if (of->triangle[3 * other + k] == b && of->triangle[3 * other + (k + 1) % 3] == a) {
            return true;
        }
    }
    return false;
}

/* Triangles that have the two corners of an edge. */
static size_t triangles_at(const surface *of, size_t edge_index)
{
    const uint32_t a = of->triangle[edge_index];
    const uint32_t b = of->triangle[edge_index % 3 == 2 ? edge_index - 2 : edge_index + 1];
    size_t count = 0;
    for (size_t i = 0; i < of->triangles; i++) {
        const uint32_t *const t = &of->triangle[3 * i];
        count += (t[0] == a || t[1] == a || t[2] == a) && (t[0] == b || t[1] == b || t[2] == b);
    }
    return count;
}

static double enclosed(const surface *of)
{
    double sum = 0;
    for (size_t i = 0; i < of->triangles; i++) {
        double p[3][3];
        for (size_t k = 0; k < 3; k++) {
            for (size_t j = 0; j < 3; j++) {
                p[k][j] = of->corner[3 * (size_t)of->triangle[3 * i + k] + j] - of->low[j];
            }
        }
        sum += p[0][0] * (p[1][1] * p[2][2] - p[1][2] * p[2][1]) +
               p[0][1] * (p[1][2] * p[2][0] - p[1][0] * p[2][2]) +
               p[0][2] * (p[1][0] * p[2][1] - p[1][1] * p[2][0]);
    }
    return sum / 6;
}

ad_status surface_check_closed(const surface *of, ad_error *error)
{
    for (size_t i = 0; i < 3 * of->triangles; i++) {
        if (of->neighbour[i] == SURFACE_NONE) {
            const bool open = triangles_at(of, i) == 1;
            return refuse_triangle(of, i / 3,
                                   open
                                       ? "the surface is open: an edge has one triangle; close it, "
                                         "or let side be any"
                                       : "an edge has more than two triangles; let side be any, or "
                                         "repair it",
                                   error);
        }
        if (!turns_alike(of, i)) {
            return refuse_triangle(of, i / 3,
                                   "two triangles at an edge turn different ways; repair it, or "
                                   "let side be any",
                                   error);
        }
    }
    const double volume = enclosed(of);
    if (!(volume > 0)) {
        return ad_fail(error, AD_BAD_INPUT,
                       "%.300s: is inside out: it encloses %.3g m^3; turn all triangles around",
                       file_bytes_shown(of->name), volume);
    }
    return AD_OK;
}

ad_status surface_check_size(const surface *of, double length, ad_error *error)
{
    double square = 0;
    for (int i = 0; i < 3; i++) {
        square += (of->high[i] - of->low[i]) * (of->high[i] - of->low[i]);
    }
    const double ratio = sqrt(square) / length;
    if (ratio > 100 || ratio < 0.005) {
        return ad_fail(error, AD_BAD_INPUT,
                       "%.300s: is %.3g m across, and the robot %.3g m long; is its unit another?",
                       file_bytes_shown(of->name), sqrt(square), length);
    }
    return AD_OK;
}
