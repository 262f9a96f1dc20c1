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

double distance_field_at(const distance_field *field, const double p[3])
{
    const size_t up = (size_t)field->count[0], over = up * (size_t)field->count[1];
    size_t at[3];
    double part[3], line[2][2], plane[2];
    for (int i = 0; i < 3; i++) {
        const double x = (p[i] - field->low[i]) / field->cell;
        if (!(x >= 0 && x < field->count[i] - 1)) {
            return from_box(field, p);
        }
        at[i] = (size_t)x;
        part[i] = x - (double)at[i];
    }
    const float *v = field->value + at[2] * over + at[1] * up + at[0];
    for (int k = 0; k < 2; k++) {
        for (int j = 0; j < 2; j++) {
            const float *w = v + (size_t)k * over + (size_t)j * up;
            line[k][j] = between(w[0], w[1], part[0]);
        }
        plane[k] = between(line[k][0], line[k][1], part[1]);
    }
    return between(plane[0], plane[1], part[2]);
}
