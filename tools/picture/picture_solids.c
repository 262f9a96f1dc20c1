/* Solids, the floor, lines and words of a picture. */
#include "tools/picture/picture_parts.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

/* Room for `more` in a list; false: there is none. */
static bool reserve(picture *p, void **list, size_t *room, size_t count, size_t more, size_t size)
{
    if (count + more > *room) {
        const size_t wanted = 2 * (count + more);
        void *bigger = realloc(*list, wanted * size);
        if (!bigger) {
            p->failed = true;
            return false;
        }
        *list = bigger;
        *room = wanted;
    }
    return true;
}

/* ---- tubes --------------------------------------------------------------------------------- */

/* A face to be filled in; NULL: no memory. */
static picture_corner *add_face(picture *p, int count, const picture_paint *paint)
{
    if (!reserve(p, (void **)&p->corners, &p->corner_room, p->corner_count, (size_t)count,
                 sizeof *p->corners) ||
        !reserve(p, (void **)&p->faces, &p->face_room, p->face_count, 1, sizeof *p->faces)) {
        return NULL;
    }
    picture_corner *corners = p->corners + p->corner_count;
    p->faces[p->face_count++] = (picture_face){(uint32_t)p->corner_count, count, *paint};
    p->corner_count += (size_t)count;
    return corners;
}

/* Corner j of a ring: [along d1, along d2, normal along d1, normal along d2] in halves. */
static void outline(int j, int sides, bool rectangle, double row[4])
{
    static const double corners[4][2] = {{1, -1}, {1, 1}, {-1, 1}, {-1, -1}};
    if (rectangle) {
        row[0] = corners[j % 4][0];
        row[1] = corners[j % 4][1];
        row[2] = row[0];
        row[3] = row[1];
    } else {
        row[0] = row[2] = cos(2 * PICTURE_PI * j / sides);
        row[1] = row[3] = sin(2 * PICTURE_PI * j / sides);
    }
}

static void place_corner(const picture_ring *ring, const double row[4], picture_corner *corner)
{
    for (int k = 0; k < 3; k++) {
        corner->place[k] = (float)(ring->place[k] + ring->half[0] * row[0] * ring->director[0][k] +
                                   ring->half[1] * row[1] * ring->director[1][k]);
        corner->normal[k] = (float)(row[2] * ring->director[0][k] + row[3] * ring->director[1][k]);
    }
}

static void add_side(picture *p, const picture_ring *a, const picture_ring *b, int j, int sides,
                     bool rectangle, const picture_paint *paint)
{
    double rows[2][4];
    picture_corner *corners = add_face(p, 4, paint);
    if (!corners) {
        return;
    }
    outline(j, sides, rectangle, rows[0]);
    outline((j + 1) % sides, sides, rectangle, rows[1]);
    if (rectangle) { /* flat */
        for (int k = 2; k < 4; k++) {
            rows[0][k] = rows[1][k] = (rows[0][k] + rows[1][k]) / 2;
        }
    }
    place_corner(a, rows[0], &corners[0]);
    place_corner(a, rows[1], &corners[1]);
    place_corner(b, rows[1], &corners[2]);
    place_corner(b, rows[0], &corners[3]);
}

static void add_cap(picture *p, const picture_ring *ring, int sides, bool rectangle, double sign,
                    const picture_paint *paint)
{
    picture_corner *corners = ring->half[0] > 0 ? add_face(p, sides, paint) : NULL;
    for (int j = 0; corners && j < sides; j++) {
        double row[4];
        outline(j, sides, rectangle, row);
        place_corner(ring, row, &corners[j]);
        for (int k = 0; k < 3; k++) {
            corners[j].normal[k] = (float)(sign * ring->director[2][k]);
        }
    }
}

void picture_tube(picture *p, const picture_ring *rings, size_t count, int sides, bool rectangle,
                  const picture_paint *paint)
{
    sides = rectangle ? 4 : sides;
    for (size_t i = 0; i + 1 < count; i++) {
        for (int j = 0; j < sides; j++) {
            add_side(p, &rings[i], &rings[i + 1], j, sides, rectangle, paint);
        }
    }
    if (count > 1) {
        add_cap(p, &rings[0], sides, rectangle, -1, paint);
        add_cap(p, &rings[count - 1], sides, rectangle, 1, paint);
    }
}

void picture_mesh(picture *p, const double *corners, const uint32_t *triangles, size_t count,
                  const picture_paint *paint)
{
    for (size_t i = 0; i < count; i++) {
        const uint32_t *const t = triangles + 3 * i;
        const double *const a = corners + 3 * t[0], *const b = corners + 3 * t[1];
        const double *const c = corners + 3 * t[2];
        picture_corner *const face = add_face(p, 3, paint);
        for (int j = 0; face && j < 3; j++) {
            for (int k = 0; k < 3; k++) {
                const int m = (k + 1) % 3, n = (k + 2) % 3;
                face[j].place[k] = (float)corners[3 * t[j] + (uint32_t)k];
                face[j].normal[k] =
                    (float)((b[m] - a[m]) * (c[n] - a[n]) - (b[n] - a[n]) * (c[m] - a[m]));
            }
        }
    }
}

/* ---- threads, arrows, balls ---------------------------------------------------------------- */

static double direction(const double from[3], const double to[3], double unit[3])
{
    double size = 0;
    for (int k = 0; k < 3; k++) {
        unit[k] = to[k] - from[k];
        size = hypot(size, unit[k]);
    }
    for (int k = 0; k < 3; k++) {
        unit[k] = size > 0 ? unit[k] / size : k == 2;
    }
    return size;
}

/* Directors of a ring from its third; the first is that of the ring before, turned as little as
 * can be. */
static void turn_ring(picture_ring *ring, const picture_ring *before)
{
    double *d1 = ring->director[0], *d2 = ring->director[1];
    const double *d3 = ring->director[2];
    if (before) {
        double along = 0, size = 0;
        for (int k = 0; k < 3; k++) {
            along += before->director[0][k] * d3[k];
        }
        for (int k = 0; k < 3; k++) {
            d1[k] = before->director[0][k] - along * d3[k];
            size = hypot(size, d1[k]);
        }
        for (int k = 0; k < 3 && size > 0; k++) {
            d1[k] /= size;
        }
        if (!(size > 1e-9)) {
            before = NULL;
        }
    }
    if (!before) {
        picture_level(d3, d1, d2);
    }
    for (int k = 0; k < 3; k++) {
        d2[k] = d3[(k + 1) % 3] * d1[(k + 2) % 3] - d3[(k + 2) % 3] * d1[(k + 1) % 3];
    }
}

void picture_thread(picture *p, const double *places, size_t count, double radius,
                    const picture_paint *paint)
{
    enum { SIDES = 6 };
    picture_ring rings[2];
    for (size_t i = 0; i < count && count > 1; i++) {
        picture_ring *ring = &rings[i % 2];
        memcpy(ring->place, places + 3 * i, sizeof ring->place);
        ring->half[0] = ring->half[1] = radius;
        direction(places + 3 * (i > 0 ? i - 1 : 0), places + 3 * (i + 1 < count ? i + 1 : i),
                  ring->director[2]);
        turn_ring(ring, i > 0 ? &rings[(i + 1) % 2] : NULL);
        for (int j = 0; i > 0 && j < SIDES; j++) {
            add_side(p, &rings[(i + 1) % 2], ring, j, SIDES, false, paint);
        }
    }
}

void picture_arrow(picture *p, const double from[3], const double vector[3], double radius,
                   int heads, const picture_paint *paint)
{
    enum { SIDES = 12 };
    picture_ring ring = {.half = {0, 0}};
    const double zero[3] = {0, 0, 0}, length = direction(zero, vector, ring.director[2]);
    const double head = fmin(5.5 * radius, 0.6 * length / heads);
    const double marks[5] = {0, length - heads * head, length - (heads - 1) * head, length - head,
                             length};
    if (length < 2 * radius) {
        return;
    }
    turn_ring(&ring, NULL);
    for (int piece = 0; piece <= heads; piece++) { /* shaft, heads */
        picture_ring ends[2];
        for (int e = 0; e < 2; e++) {
            const double along = piece == 0       ? marks[e]
                                 : piece == heads ? marks[3 + e]
                                                  : marks[1 + e];
            ends[e] = ring;
            ends[e].half[0] = ends[e].half[1] = piece == 0 ? radius
                                                : e == 0   ? 2.4 * radius
                                                           : 1e-3 * radius;
            for (int k = 0; k < 3; k++) {
                ends[e].place[k] = from[k] + along * ring.director[2][k];
            }
        }
        picture_tube(p, ends, 2, SIDES, false, paint);
    }
}

void picture_ball(picture *p, const double centre[3], double radius, const picture_paint *paint)
{
    enum { RINGS = 8, SIDES = 14 };
    for (int i = 0; i < RINGS; i++) {
        for (int j = 0; j < SIDES; j++) {
            picture_corner *corners = add_face(p, 4, paint);
            for (int c = 0; corners && c < 4; c++) {
                const double a = PICTURE_PI * (i + (c > 1)) / RINGS;
                const double b = 2 * PICTURE_PI * (j + (c == 1 || c == 2)) / SIDES;
                const double n[3] = {sin(a) * cos(b), sin(a) * sin(b), cos(a)};
                for (int k = 0; k < 3; k++) {
                    corners[c].normal[k] = (float)n[k];
                    corners[c].place[k] = (float)(centre[k] + radius * n[k]);
                }
            }
        }
    }
}

/* ---- floor --------------------------------------------------------------------------------- */

void picture_floor(picture *p, double height, double step, double reach)
{
    p->has_floor = true;
    p->floor = height;
    p->step = step;
    p->reach = reach;
}

/* A place on the floor, from where the target is above it. */
static void on_floor(const picture *p, double right, double deep, double place[3])
{
    double side[3], front[3], above = -p->floor;
    picture_level(p->up, side, front);
    for (int k = 0; k < 3; k++) {
        above += p->target[k] * p->up[k];
    }
    for (int k = 0; k < 3; k++) {
        place[k] = p->target[k] - above * p->up[k] + right * side[k] + deep * front[k];
    }
}

bool picture_grid_line(const picture *p, int k, double from[2], double to[2])
{
    const int lines = p->has_floor ? (int)(p->reach / p->step) : -1, number = k / 2 - lines;
    double side[3], front[3], place[3], seen[3];
    if (lines < 0 || number > lines) {
        return false;
    }
    picture_level(p->up, side, front);
    const double *across = k % 2 ? front : side;
    double centre = 0; /* lines are at multiples of the step in space */
    for (int i = 0; i < 3; i++) {
        centre += across[i] * p->target[i];
    }
    const double off = p->step * (round(centre / p->step) + number) - centre;
    const double half = sqrt(fmax(0, p->reach * p->reach - off * off));
    for (int end = 0; end < 2; end++) {
        const double along = end ? half : -half;
        on_floor(p, k % 2 ? along : off, k % 2 ? off : along, place);
        picture_project(p, place, seen);
        (end ? to : from)[0] = seen[0];
        (end ? to : from)[1] = seen[1];
    }
    return true;
}

void picture_floor_seen(const picture *p, double centre[2], double radii[2])
{
    double place[3], seen[3], flat = 0;
    on_floor(p, 0, 0, place);
    picture_project(p, place, seen);
    for (int k = 0; k < 3; k++) {
        flat += p->axis[2][k] * p->up[k];
    }
    centre[0] = seen[0];
    centre[1] = seen[1];
    radii[0] = p->reach * p->height / (2 * PICTURE_LENS * seen[2]);
    radii[1] = radii[0] * fmax(fabs(flat), 0.05);
}

void picture_shadow(const picture *p, const float place[3], double seen[2])
{
    double flat[3], above = -p->floor, full[3];
    for (int k = 0; k < 3; k++) {
        above += p->up[k] * (double)place[k];
    }
    for (int k = 0; k < 3; k++) {
        flat[k] = (double)place[k] - above * p->up[k];
    }
    picture_project(p, flat, full);
    seen[0] = full[0];
    seen[1] = full[1];
}

/* ---- lines and words ----------------------------------------------------------------------- */

void picture_line(picture *p, const double *points, size_t count, double width,
                  picture_colour colour)
{
    if (reserve(p, (void **)&p->points, &p->point_room, p->point_count, count, sizeof *p->points) &&
        reserve(p, (void **)&p->strokes, &p->stroke_room, p->stroke_count, 1, sizeof *p->strokes)) {
        memcpy(p->points + p->point_count, points, count * sizeof *p->points);
        p->strokes[p->stroke_count++] = (picture_stroke){p->point_count, count, width, colour};
        p->point_count += count;
    }
}

void picture_text(picture *p, double x, double y, double size, picture_align align,
                  picture_colour colour, const char *text)
{
    char *copy = strdup(text);
    if (!copy ||
        !reserve(p, (void **)&p->words, &p->word_room, p->word_count, 1, sizeof *p->words)) {
        p->failed = true;
        free(copy);
        return;
    }
    p->words[p->word_count++] = (picture_word){x, y, size, align, colour, copy};
}
