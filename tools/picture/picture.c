#include "tools/picture/picture_parts.h"

#include "physics/numerics/quaternion.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

picture *picture_create(int width, int height)
{
    picture *p = calloc(1, sizeof *p);
    if (p) {
        p->width = width;
        p->height = height;
        p->distance = 1;
        picture_look(p, (const double[3]){0, 0, 0}, (const double[3]){0, 0, 1}, 0, 0.3);
    }
    return p;
}

void picture_clear(picture *p)
{
    for (size_t i = 0; i < p->word_count; i++) {
        free(p->words[i].text);
    }
    p->corner_count = p->face_count = p->point_count = p->stroke_count = p->word_count = 0;
    p->has_floor = false;
}

void picture_free(picture *p)
{
    if (p) {
        picture_clear(p);
        free(p->corners);
        free(p->faces);
        free(p->points);
        free(p->strokes);
        free(p->words);
        free(p);
    }
}

int picture_width(const picture *p)
{
    return p->width;
}

int picture_height(const picture *p)
{
    return p->height;
}

/* ---- colours ------------------------------------------------------------------------------- */

picture_colour picture_rgb(const char *hex)
{
    const unsigned long bits = strtoul(hex, NULL, 16);
    return (picture_colour){(float)(bits >> 16 & 255) / 255, (float)(bits >> 8 & 255) / 255,
                            (float)(bits & 255) / 255};
}

picture_colour picture_between(const char *const *hex, int count, double at)
{
    const double place = fmin(1, fmax(0, at)) * (count - 1);
    const int k = place < count - 1 ? (int)place : count > 1 ? count - 2 : 0;
    const float part = (float)(place - k);
    const picture_colour a = picture_rgb(hex[k]), b = picture_rgb(hex[count > 1 ? k + 1 : k]);
    return (picture_colour){a.red + part * (b.red - a.red), a.green + part * (b.green - a.green),
                            a.blue + part * (b.blue - a.blue)};
}

/* ---- camera -------------------------------------------------------------------------------- */

void picture_level(const double up[3], double side[3], double front[3])
{
    int least = 0;
    for (int k = 1; k < 3; k++) {
        least = fabs(up[k]) < fabs(up[least]) ? k : least;
    }
    for (int k = 0; k < 3; k++) {
        side[k] = (k == least) - up[least] * up[k];
    }
    const double size = sqrt(vector_dot(side, side));
    for (int k = 0; k < 3; k++) {
        side[k] /= size;
    }
    vector_cross(up, side, front);
}

void picture_look(picture *p, const double target[3], const double up[3], double azimuth,
                  double elevation)
{
    double side[3], front[3];
    picture_level(up, side, front);
    for (int k = 0; k < 3; k++) {
        p->target[k] = target[k];
        p->up[k] = up[k];
        p->axis[2][k] = cos(elevation) * (cos(azimuth) * side[k] + sin(azimuth) * front[k]) +
                        sin(elevation) * up[k];
        p->axis[0][k] = cos(azimuth) * front[k] - sin(azimuth) * side[k];
    }
    vector_cross(p->axis[2], p->axis[0], p->axis[1]);
    p->shift[0] = p->shift[1] = 0;
}

const double *picture_axis(const picture *p, int k)
{
    return p->axis[k];
}

double picture_scale(const picture *p)
{
    return p->height / (2 * PICTURE_LENS * p->distance);
}

void picture_project(const picture *p, const double place[3], double seen[3])
{
    const double from[3] = {place[0] - p->target[0], place[1] - p->target[1],
                            place[2] - p->target[2]};
    seen[2] = fmax(p->distance - vector_dot(from, p->axis[2]), 0.05 * p->distance);
    const double scale = p->height / (2 * PICTURE_LENS * seen[2]);
    seen[0] = p->width / 2.0 + p->shift[0] + scale * vector_dot(from, p->axis[0]);
    seen[1] = p->height / 2.0 + p->shift[1] - scale * vector_dot(from, p->axis[1]);
}

/* The box of all places on the picture. */
static void box_of(const picture *p, size_t count, const double *places, double low[2],
                   double high[2])
{
    for (int k = 0; k < 2; k++) {
        low[k] = INFINITY;
        high[k] = -INFINITY;
    }
    for (size_t i = 0; i < count; i++) {
        double seen[3];
        picture_project(p, places + 3 * i, seen);
        for (int k = 0; k < 2; k++) {
            low[k] = fmin(low[k], seen[k]);
            high[k] = fmax(high[k], seen[k]);
        }
    }
}

void picture_fit(picture *p, size_t count, const double *places, double part)
{
    double low[2], high[2], size = 0;
    for (size_t i = 0; i < count; i++) {
        for (int k = 0; k < 3; k++) {
            size = fmax(size, fabs(places[3 * i + k] - p->target[k]));
        }
    }
    p->distance = 10 * size > 0 ? 10 * size : 1;
    p->shift[0] = p->shift[1] = 0;
    for (int round = 0; round < 8 && count > 0 && size > 0; round++) {
        box_of(p, count, places, low, high);
        const double wide = (high[0] - low[0]) / (part * p->width);
        const double tall = (high[1] - low[1]) / (part * p->height);
        p->distance = fmax(p->distance * fmax(wide, tall), 1.5 * size);
        box_of(p, count, places, low, high);
        p->shift[0] += p->width / 2.0 - (low[0] + high[0]) / 2;
        p->shift[1] += p->height / 2.0 - (low[1] + high[1]) / 2;
    }
}

/* ---- light --------------------------------------------------------------------------------- */

static float unit(float v[3])
{
    const float size = sqrtf(v[0] * v[0] + v[1] * v[1] + v[2] * v[2]);
    for (int k = 0; k < 3 && size > 0; k++) {
        v[k] /= size;
    }
    return size;
}

static float product(const float a[3], const float b[3])
{
    return a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
}

/* A key light over the left shoulder, the sky, a darker edge and a highlight. */
picture_colour picture_light(const picture *p, const float place[3], const float normal[3],
                             picture_colour colour)
{
    float n[3], view[3], key[3], between[3], up[3];
    for (int k = 0; k < 3; k++) {
        n[k] = normal[k];
        view[k] = (float)(p->target[k] + p->distance * p->axis[2][k]) - place[k];
        key[k] = (float)(-0.45 * p->axis[0][k] + 0.75 * p->axis[1][k] + 0.55 * p->axis[2][k]);
        up[k] = (float)p->up[k];
    }
    unit(n);
    unit(view);
    unit(key);
    if (product(n, view) < 0) {
        n[0] = -n[0];
        n[1] = -n[1];
        n[2] = -n[2];
    }
    for (int k = 0; k < 3; k++) {
        between[k] = key[k] + view[k];
    }
    unit(between);
    const float sky = 0.5F + 0.5F * product(n, up), facing = product(n, view);
    const float edge = (1 - facing) * (1 - facing) * (1 - facing);
    const float light =
        (0.46F + 0.22F * sky + 0.50F * fmaxf(product(n, key), 0)) * (1 - 0.4F * edge);
    float shine = fmaxf(product(n, between), 0);
    shine *= shine;
    shine *= shine;
    shine *= shine;
    shine *= shine * shine;
    shine = 0.30F * shine * shine;
    return (picture_colour){fminf(1, colour.red * light + shine),
                            fminf(1, colour.green * light + shine),
                            fminf(1, colour.blue * light + shine)};
}

float picture_hides(const picture *p, const float place[3], const float normal[3], float opacity)
{
    float n[3], view[3];
    if (opacity >= 1) {
        return 1;
    }
    for (int k = 0; k < 3; k++) {
        n[k] = normal[k];
        view[k] = (float)(p->target[k] + p->distance * p->axis[2][k]) - place[k];
    }
    unit(n);
    unit(view);
    const float edge = 1 - fabsf(product(n, view));
    return fminf(1, opacity * (0.55F + 2.6F * edge * edge));
}

bool picture_faces_eye(const picture *p, const picture_face *face)
{
    float sum = 0;
    for (int j = 0; j < face->count; j++) {
        const picture_corner *c = &p->corners[face->first + (uint32_t)j];
        for (int k = 0; k < 3; k++) {
            sum +=
                c->normal[k] * ((float)(p->target[k] + p->distance * p->axis[2][k]) - c->place[k]);
        }
    }
    return sum > 0;
}
