#include "physics/numerics/distance_field.h"

#include <math.h>
#include <stddef.h>

/* From the box, of a point beyond it. */
static double from_box(const distance_field *field, const double p[3])
{
    double square = 0;
    for (int i = 0; i < 3; i++) {
        const double off = fmax(p[i] - field->box_high[i], 0) - fmax(field->box_low[i] - p[i], 0);
        square += off * off;
    }
    return field->inside ? -sqrt(square) : sqrt(square);
}

static double between(double low, double high, double part)
{
    return low + part * (high - low);
}

/* Its first node, NULL beyond the grid, and where p is from there, in cells. */
static const float *cell_of(const distance_field *field, const double p[3], double part[3])
{
    size_t at = 0, stride = 1;
    for (int i = 0; i < 3; i++) {
        const double x = (p[i] - field->low[i]) / field->cell;
        if (!(x >= 0 && x < field->count[i] - 1)) {
            return NULL;
        }
        const size_t node = (size_t)x;
        at += node * stride;
        part[i] = x - (double)node;
        stride *= (size_t)field->count[i];
    }
    return field->value + at;
}

double distance_field_at(const distance_field *field, const double p[3])
{
    const size_t up = (size_t)field->count[0], over = up * (size_t)field->count[1];
    double part[3], line[2][2], plane[2];
    const float *v = cell_of(field, p, part);
    if (!v) {
        return from_box(field, p);
    }
    for (int k = 0; k < 2; k++) {
        for (int j = 0; j < 2; j++) {
            const float *w = v + (size_t)k * over + (size_t)j * up;
            line[k][j] = between(w[0], w[1], part[0]);
        }
        plane[k] = between(line[k][0], line[k][1], part[1]);
    }
    return between(plane[0], plane[1], part[2]);
}

double distance_field_least(const distance_field *field, const double p[3])
{
    static const double FLOAT = 1e-7; /* as distances are kept */
    const size_t up = (size_t)field->count[0], over = up * (size_t)field->count[1];
    double part[3], least = -INFINITY;
    const float *v = cell_of(field, p, part);
    for (size_t node = 0; v && node < 8; node++) {
        const size_t i = node & 1, j = node >> 1 & 1, k = node >> 2;
        const double x = part[0] - (double)i, y = part[1] - (double)j, z = part[2] - (double)k;
        const double value = v[k * over + j * up + i];
        const double away = field->cell * sqrt(x * x + y * y + z * z);
        least = fmax(least, value - FLOAT * fabs(value) - away);
    }
    return v ? least : from_box(field, p);
}
