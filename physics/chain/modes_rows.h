/* Rows of changes by each mode, four columns at a time. For functions that are compiled
 * FOR_EACH_PROCESSOR. */
#ifndef PHYSICS_CHAIN_MODES_ROWS_H
#define PHYSICS_CHAIN_MODES_ROWS_H

#include "physics/chain/modes_internal.h"
#include "physics/numerics/processor.h"

#include <string.h>

/* Rows are `width` doubles apart; four columns of three of them. */
PROCESSOR_INLINE void load_rows(const double *rows, int width, quad x[3])
{
    for (int k = 0; k < 3; k++) {
        memcpy(&x[k], rows + k * width, sizeof x[k]);
    }
}

PROCESSOR_INLINE void store_rows(const quad x[3], int width, double *rows)
{
    for (int k = 0; k < 3; k++) {
        memcpy(rows + k * width, &x[k], sizeof x[k]);
    }
}

/* to += a x b, to += b x a: a the same for all columns. */
PROCESSOR_INLINE void add_cross(const double a[3], const quad b[3], quad to[3])
{
    to[0] += a[1] * b[2] - a[2] * b[1];
    to[1] += a[2] * b[0] - a[0] * b[2];
    to[2] += a[0] * b[1] - a[1] * b[0];
}

PROCESSOR_INLINE void add_crossed(const quad b[3], const double a[3], quad to[3])
{
    to[0] += b[1] * a[2] - b[2] * a[1];
    to[1] += b[2] * a[0] - b[0] * a[2];
    to[2] += b[0] * a[1] - b[1] * a[0];
}

PROCESSOR_INLINE void add_applied(double A[3][3], double factor, const quad x[3], quad to[3])
{
    for (int i = 0; i < 3; i++) {
        to[i] += factor * (A[i][0] * x[0] + A[i][1] * x[1] + A[i][2] * x[2]);
    }
}

PROCESSOR_INLINE void add_scaled(double factor, const quad x[3], quad to[3])
{
    for (int i = 0; i < 3; i++) {
        to[i] += factor * x[i];
    }
}

/* ---- sums over the points of an element ---------------------------------------------------- */

/* to [stages + 1] = from + matrix rate [stages]: rows of `length` doubles, multiple of QUAD, those
 * of rates and of results as far apart as their strides. */
PROCESSOR_INLINE void integrate_rows(const modes *m, int e, int length, const double *from,
                                     const double *rate, int rate_stride, double *to, int stride)
{
    const modes_element *element = &m->element[e];
    const int n = m->stages;
    for (int i = 0; i <= n; i++) {
        const double *by = element->matrix[i];
        for (int c = 0; c < length; c += QUAD) {
            quad sum, x;
            memcpy(&sum, from + c, sizeof sum);
            for (int j = 0; j < n; j++) {
                memcpy(&x, rate + j * rate_stride + c, sizeof x);
                sum += by[j] * x;
            }
            memcpy(to + i * stride + c, &sum, sizeof sum);
        }
    }
}

/* R e P of each own mode of v, u: [2][3] rows, zeros elsewhere; values [points][width] of P. */
PROCESSOR_INLINE void rows_of(const modes *m, const double *values, int e, int p, int width,
                              double *rows)
{
    const modes_element *element = &m->element[e];
    const modes_point *at = &m->point[p];
    memset(rows, 0, (size_t)(6 * width) * sizeof *rows);
    for (int a = element->own; a < element->end; a++) {
        const int c = m->mode[a].strain;
        const double value = values[p * m->width + a];
        for (int k = 0; k < 3; k++) {
            rows[(c / 3 * 3 + k) * width + a] = value * at->R[k][c % 3];
        }
    }
}

PROCESSOR_INLINE void own_rows(const modes *m, int e, int p, int width, double *rows)
{
    rows_of(m, m->value, e, p, width, rows);
}

/* The same of slopes of P along s. */
PROCESSOR_INLINE void slope_rows(const modes *m, int e, int p, int width, double *rows)
{
    rows_of(m, m->feed.slope, e, p, width, rows);
}

#endif
