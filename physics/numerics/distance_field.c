#include "physics/numerics/distance_field.h"

#include <math.h>
#include <stddef.h>

/* From the box, of a point beyond it. */
static double from_box(const distance_field *field, const double p[3], double *gradient)
{
    const double sign = field->inside ? -1 : 1;
    double off[3], square = 0;
    for (int i = 0; i < 3; i++) {
        off[i] = fmax(p[i] - field->box_high[i], 0) - fmax(field->box_low[i] - p[i], 0);
        square += off[i] * off[i];
    }
    const double distance = sqrt(square);
    for (int i = 0; i < 3 && gradient; i++) {
        gradient[i] = distance > 0 ? sign * off[i] / distance : 0;
    }
    return sign * distance;
}

static double between(double low, double high, double part)
{
    return low + part * (high - low);
}

double distance_field_at(const distance_field *field, const double p[3], double *gradient)
{
    const size_t up = (size_t)field->count[0], over = up * (size_t)field->count[1];
    size_t at[3];
    double part[3], line[2][2], plane[2];
    for (int i = 0; i < 3; i++) {
        const double x = (p[i] - field->low[i]) / field->cell;
        if (!(x >= 0 && x < field->count[i] - 1)) {
            return from_box(field, p, gradient);
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
    if (gradient) {
        double slope[2];
        for (int k = 0; k < 2; k++) {
            const float *w = v + (size_t)k * over;
            slope[k] = between((double)w[1] - w[0], (double)w[up + 1] - w[up], part[1]);
        }
        gradient[0] = between(slope[0], slope[1], part[2]) / field->cell;
        gradient[1] =
            between(line[0][1] - line[0][0], line[1][1] - line[1][0], part[2]) / field->cell;
        gradient[2] = (plane[1] - plane[0]) / field->cell;
    }
    return between(plane[0], plane[1], part[2]);
}
