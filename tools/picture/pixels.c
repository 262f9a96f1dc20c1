/* A picture as pixels: bands of samples with a depth for each. */
#include "tools/picture/picture_parts.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

typedef struct seen_corner {
    float x, y, near; /* samples; one over the depth */
    picture_colour colour;
    float hides;
} seen_corner;

typedef struct canvas {
    const picture *of;
    int samples, width; /* of a row, in samples */
    int top, rows;      /* the band, in samples */
    seen_corner *corners;
    uint32_t *clear; /* faces that are seen through, from far to near */
    size_t clear_count;
    float *shadow; /* [height][width] of the picture: how much of one there is */
    float *near;   /* [rows][width] */
    picture_colour *colours;
} canvas;

static void mix(picture_colour *to, picture_colour colour, float part)
{
    to->red += part * (colour.red - to->red);
    to->green += part * (colour.green - to->green);
    to->blue += part * (colour.blue - to->blue);
}

/* ---- triangles ----------------------------------------------------------------------------- */

typedef void (*put_sample)(canvas *c, size_t at, const seen_corner *what);

static void put_solid(canvas *c, size_t at, const seen_corner *what)
{
    if (what->near > c->near[at]) {
        c->near[at] = what->near;
        c->colours[at] = what->colour;
    }
}

static void put_clear(canvas *c, size_t at, const seen_corner *what)
{
    if (what->near > c->near[at]) {
        mix(&c->colours[at], what->colour, what->hides);
    }
}

static seen_corner between(const seen_corner *v[3], float a, float b)
{
    const float c = 1 - a - b;
    return (seen_corner){
        .near = a * v[0]->near + b * v[1]->near + c * v[2]->near,
        .colour = {a * v[0]->colour.red + b * v[1]->colour.red + c * v[2]->colour.red,
                   a * v[0]->colour.green + b * v[1]->colour.green + c * v[2]->colour.green,
                   a * v[0]->colour.blue + b * v[1]->colour.blue + c * v[2]->colour.blue},
        .hides = a * v[0]->hides + b * v[1]->hides + c * v[2]->hides};
}

/* Where a row crosses a triangle, as the samples [from, to). */
static void span_of(const seen_corner *v[3], float y, int width, int *from, int *to)
{
    float low = INFINITY, high = -INFINITY;
    for (int k = 0; k < 3; k++) {
        const seen_corner *a = v[k], *b = v[(k + 1) % 3];
        if ((a->y <= y) != (b->y <= y)) {
            const float x = a->x + (y - a->y) / (b->y - a->y) * (b->x - a->x);
            low = fminf(low, x);
            high = fmaxf(high, x);
        }
    }
    *from = low < high ? (int)fmaxf(0, ceilf(fmaxf(low, 0) - 0.5F)) : 0;
    *to = low < high ? (int)ceilf(fminf(high, (float)width) - 0.5F) : 0;
}

static void fill_triangle(canvas *c, const seen_corner *v[3], put_sample put)
{
    const float area =
        (v[1]->x - v[0]->x) * (v[2]->y - v[0]->y) - (v[2]->x - v[0]->x) * (v[1]->y - v[0]->y);
    const float low = fminf(v[0]->y, fminf(v[1]->y, v[2]->y));
    const float high = fmaxf(v[0]->y, fmaxf(v[1]->y, v[2]->y));
    const float end = (float)(c->top + c->rows);
    if (!(area != 0) || !(high >= (float)c->top) || !(low <= end)) {
        return;
    }
    const int first = (int)ceilf(fmaxf(low, (float)c->top) - 0.5F);
    for (int row = first; (float)row + 0.5F < fminf(high, end); row++) {
        const float y = (float)row + 0.5F;
        int from, to;
        span_of(v, y, c->width, &from, &to);
        for (int column = from; column < to; column++) {
            const float x = (float)column + 0.5F;
            const float a = ((v[1]->x - x) * (v[2]->y - y) - (v[2]->x - x) * (v[1]->y - y)) / area;
            const float b = ((v[2]->x - x) * (v[0]->y - y) - (v[0]->x - x) * (v[2]->y - y)) / area;
            const seen_corner what = between(v, a, b);
            put(c, (size_t)(row - c->top) * (size_t)c->width + (size_t)column, &what);
        }
    }
}

static void fill_face(canvas *c, const picture_face *face, put_sample put)
{
    const seen_corner *corners = c->corners + face->first;
    for (int k = 1; k + 1 < face->count; k++) {
        fill_triangle(c, (const seen_corner *[3]){&corners[0], &corners[k], &corners[k + 1]}, put);
    }
}

/* ---- lines --------------------------------------------------------------------------------- */

typedef float (*fade)(const canvas *c, float x, float y);

static float none(const canvas *c, float x, float y)
{
    (void)c;
    (void)x;
    (void)y;
    return 1;
}

static float floor_fade(const canvas *c, float x, float y)
{
    double centre[2], radii[2];
    picture_floor_seen(c->of, centre, radii);
    const double r = hypot((x / (float)c->samples - centre[0]) / radii[0],
                           (y / (float)c->samples - centre[1]) / radii[1]);
    return (float)fmax(0, 1 - r);
}

/* A line with round ends from a to b, pixels. */
static void draw_segment(canvas *c, const double a[2], const double b[2], double width,
                         picture_colour colour, fade how)
{
    const float n = (float)c->samples, half = (float)width * n / 2;
    const float ax = (float)a[0] * n, ay = (float)a[1] * n;
    const float dx = (float)(b[0] - a[0]) * n, dy = (float)(b[1] - a[1]) * n;
    const float length = dx * dx + dy * dy;
    const int top = (int)fmaxf((float)c->top, fminf(ay, ay + dy) - half);
    const int low = (int)fminf((float)(c->top + c->rows), fmaxf(ay, ay + dy) + half + 1);
    for (int row = top; row < low; row++) {
        const float y = (float)row + 0.5F - ay;
        float from = fminf(0, dx) - half, to = fmaxf(0, dx) + half;
        if (fabsf(dy) > half) { /* the piece of a steep line at this row */
            const float one = fminf(1, fmaxf(0, (y - half) / dy));
            const float other = fminf(1, fmaxf(0, (y + half) / dy));
            const float wide = half * (1 + fabsf(dx / dy));
            from = fminf(one, other) * dx;
            to = fmaxf(one, other) * dx;
            if (from > to) {
                const float swap = from;
                from = to;
                to = swap;
            }
            from -= wide;
            to += wide;
        }
        const int left = (int)fmaxf(0, ax + from);
        const int right = (int)fminf((float)c->width, ax + to + 1);
        for (int column = left; column < right; column++) {
            const float x = (float)column + 0.5F - ax;
            const float part = length > 0 ? fminf(1, fmaxf(0, (x * dx + y * dy) / length)) : 0;
            if (hypotf(x - part * dx, y - part * dy) <= half) {
                mix(&c->colours[(size_t)(row - c->top) * (size_t)c->width + (size_t)column], colour,
                    how(c, x + ax, y + ay));
            }
        }
    }
}

typedef struct pen {
    canvas *on;
    double x, y, width;
    picture_colour colour;
} pen;

static void draw_stroke(void *context, const double *points, size_t count)
{
    const pen *p = context;
    for (size_t i = 0; i + 1 < count; i++) {
        const double a[2] = {p->x + points[2 * i], p->y + points[2 * i + 1]};
        const double b[2] = {p->x + points[2 * i + 2], p->y + points[2 * i + 3]};
        draw_segment(p->on, a, b, p->width, p->colour, none);
    }
}

static void draw_word(canvas *c, const picture_word *word)
{
    const double wide = picture_text_width(word->size, word->text);
    pen p = {.on = c, .y = word->y, .colour = {1, 1, 1}, .width = 0.13 * word->size + 4};
    p.x = word->x - (word->align == PICTURE_RIGHT    ? wide
                     : word->align == PICTURE_MIDDLE ? wide / 2
                                                     : 0);
    const double n = c->samples;
    if ((word->y + word->size) * n < c->top || (word->y - 2 * word->size) * n > c->top + c->rows) {
        return;
    }
    picture_write(word->text, word->size, draw_stroke, &p);
    p.colour = word->colour;
    p.width = 0.115 * word->size;
    picture_write(word->text, word->size, draw_stroke, &p);
}

/* ---- the floor ----------------------------------------------------------------------------- */

static void put_shadow(canvas *c, size_t at, const seen_corner *what)
{
    (void)what;
    c->shadow[at] = 1;
}

static void cast(canvas *c, const picture_face *face)
{
    seen_corner corners[3];
    for (int k = 1; k + 1 < face->count; k++) {
        const int which[3] = {0, k, k + 1};
        for (int i = 0; i < 3; i++) {
            double seen[2];
            picture_shadow(c->of, c->of->corners[face->first + (uint32_t)which[i]].place, seen);
            corners[i] = (seen_corner){.x = (float)seen[0], .y = (float)seen[1]};
        }
        fill_triangle(c, (const seen_corner *[3]){&corners[0], &corners[1], &corners[2]},
                      put_shadow);
    }
}

/* Means of 2 reach + 1 values, `step` apart; `line` [count] is overwritten. */
static void blur_line(float *values, int count, size_t step, int reach, float *line)
{
    double sum = 0;
    for (int i = 0; i < count; i++) {
        line[i] = values[(size_t)i * step];
    }
    for (int i = -reach; i < count; i++) {
        sum += i + reach < count ? (double)line[i + reach] : 0;
        sum -= i - reach > 0 ? (double)line[i - reach - 1] : 0;
        if (i >= 0) {
            values[(size_t)i * step] = (float)(sum / (2 * reach + 1));
        }
    }
}

static ad_status make_shadow(canvas *c, ad_error *error)
{
    const picture *p = c->of;
    const int longest = p->width > p->height ? p->width : p->height;
    canvas one = *c; /* a sample for each pixel */
    float *line = malloc((size_t)longest * sizeof *line);
    if (!line) {
        return ad_fail(error, AD_NO_MEMORY, "out of memory for a picture");
    }
    one.width = p->width;
    one.top = 0;
    one.rows = p->height;
    for (size_t i = 0; i < p->face_count && p->has_floor; i++) {
        if (p->faces[i].paint.shadow) {
            cast(&one, &p->faces[i]);
        }
    }
    const int reach = p->width / 240 + 1;
    for (int round = 0; round < 3 && p->has_floor; round++) {
        for (int i = 0; i < p->height; i++) {
            blur_line(c->shadow + (size_t)i * (size_t)p->width, p->width, 1, reach, line);
        }
        for (int i = 0; i < p->width; i++) {
            blur_line(c->shadow + i, p->height, (size_t)p->width, reach, line);
        }
    }
    free(line);
    return AD_OK;
}

static void draw_floor(canvas *c)
{
    const picture_colour grid = picture_rgb("8f9bab"), dark = picture_rgb("26303d");
    const size_t count = (size_t)c->rows * (size_t)c->width;
    double from[2], to[2];
    for (size_t i = 0; i < count; i++) {
        c->colours[i] = (picture_colour){1, 1, 1};
        c->near[i] = 0;
    }
    if (!c->of->has_floor) {
        return;
    }
    for (int k = 0; picture_grid_line(c->of, k, from, to); k++) {
        draw_segment(c, from, to, 1, grid, floor_fade);
    }
    for (int row = 0; row < c->rows; row++) {
        const size_t y = (size_t)((c->top + row) / c->samples);
        for (int column = 0; column < c->width; column++) {
            const size_t x = (size_t)(column / c->samples);
            const float part = c->shadow[y * (size_t)c->of->width + x];
            mix(&c->colours[(size_t)row * (size_t)c->width + (size_t)column], dark, 0.30F * part);
        }
    }
}

/* ---- all of it ----------------------------------------------------------------------------- */

static void see_corners(canvas *c)
{
    const picture *p = c->of;
    for (size_t i = 0; i < p->face_count; i++) {
        const picture_face *face = &p->faces[i];
        for (uint32_t k = face->first; k < face->first + (uint32_t)face->count; k++) {
            const picture_corner *from = &p->corners[k];
            const double place[3] = {from->place[0], from->place[1], from->place[2]};
            double seen[3];
            picture_project(p, place, seen);
            c->corners[k] = (seen_corner){
                (float)(seen[0] * c->samples), (float)(seen[1] * c->samples), (float)(1 / seen[2]),
                picture_light(p, from->place, from->normal, face->paint.colour),
                picture_hides(p, from->place, from->normal, face->paint.opacity)};
        }
    }
}

typedef struct depth {
    float near;
    uint32_t face;
} depth;

static int by_depth(const void *a, const void *b)
{
    const depth *depth = a, *y = b;
    return depth->near != y->near  ? (depth->near > y->near ? 1 : -1)
           : depth->face < y->face ? -1
                                   : 1;
}

static ad_status sort_clear(canvas *c, ad_error *error)
{
    const picture *p = c->of;
    depth *list = malloc((p->face_count + 1) * sizeof *list);
    if (!list) {
        return ad_fail(error, AD_NO_MEMORY, "out of memory for a picture");
    }
    for (size_t i = 0; i < p->face_count; i++) {
        const picture_face *face = &p->faces[i];
        if (face->paint.opacity < 1 && picture_faces_eye(p, face)) {
            depth *d = &list[c->clear_count++];
            *d = (depth){0, (uint32_t)i};
            for (uint32_t k = face->first; k < face->first + (uint32_t)face->count; k++) {
                d->near += c->corners[k].near / (float)face->count;
            }
        }
    }
    qsort(list, c->clear_count, sizeof *list, by_depth);
    for (size_t i = 0; i < c->clear_count; i++) {
        c->clear[i] = list[i].face;
    }
    free(list);
    return AD_OK;
}

static void draw_band(canvas *c)
{
    const picture *p = c->of;
    draw_floor(c);
    for (size_t i = 0; i < p->face_count; i++) {
        if (p->faces[i].paint.opacity >= 1) {
            fill_face(c, &p->faces[i], put_solid);
        }
    }
    for (size_t i = 0; i < c->clear_count; i++) {
        fill_face(c, &p->faces[c->clear[i]], put_clear);
    }
    for (size_t i = 0; i < p->stroke_count; i++) {
        const picture_stroke *s = &p->strokes[i];
        pen with = {c, 0, 0, s->width, s->colour};
        draw_stroke(&with, p->points[s->first], s->count);
    }
    for (size_t i = 0; i < p->word_count; i++) {
        draw_word(c, &p->words[i]);
    }
}

/* Means of the samples of each pixel. */
static void take_band(const canvas *c, unsigned char *rgb)
{
    const int n = c->samples, width = c->of->width;
    const float scale = 255.0F / (float)(n * n);
    for (int row = 0; row < c->rows / n; row++) {
        unsigned char *to = rgb + 3 * (size_t)(c->top / n + row) * (size_t)width;
        for (int column = 0; column < width; column++, to += 3) {
            picture_colour sum = {0, 0, 0};
            for (int k = 0; k < n * n; k++) {
                const picture_colour *from =
                    &c->colours[(size_t)(row * n + k / n) * (size_t)c->width +
                                (size_t)(column * n + k % n)];
                sum.red += from->red;
                sum.green += from->green;
                sum.blue += from->blue;
            }
            to[0] = (unsigned char)lrintf(scale * sum.red);
            to[1] = (unsigned char)lrintf(scale * sum.green);
            to[2] = (unsigned char)lrintf(scale * sum.blue);
        }
    }
}

ad_status picture_pixels(const picture *p, int samples, unsigned char *rgb, ad_error *error)
{
    enum { BAND = 48 };
    canvas c = {.of = p, .samples = samples, .width = p->width * samples};
    const size_t band = (size_t)(BAND * samples) * (size_t)c.width;
    c.corners = malloc((p->corner_count + 1) * sizeof *c.corners);
    c.clear = malloc((p->face_count + 1) * sizeof *c.clear);
    c.shadow = calloc((size_t)p->width * (size_t)p->height, sizeof *c.shadow);
    c.near = malloc(band * sizeof *c.near);
    c.colours = malloc(band * sizeof *c.colours);
    ad_status status = AD_OK;
    if (p->failed || !c.corners || !c.clear || !c.shadow || !c.near || !c.colours) {
        status = ad_fail(error, AD_NO_MEMORY, "out of memory for a picture");
    }
    if (status == AD_OK) {
        see_corners(&c);
        status = sort_clear(&c, error);
    }
    status = status == AD_OK ? make_shadow(&c, error) : status;
    for (int top = 0; status == AD_OK && top < p->height; top += BAND) {
        c.top = top * samples;
        c.rows = (p->height - top < BAND ? p->height - top : BAND) * samples;
        draw_band(&c);
        take_band(&c, rgb);
    }
    free(c.corners);
    free(c.clear);
    free(c.shadow);
    free(c.near);
    free(c.colours);
    return status;
}
