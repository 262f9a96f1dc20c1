#include "physics/numerics/spline.h"

#include <math.h>
#include <stdbool.h>
#include <string.h>

static double chord(const double *t, const double *y, size_t i)
{
    return (y[i + 1] - y[i]) / (t[i + 1] - t[i]);
}

/* The right side of the row of an end, by the widths and chords of its two pieces. */
static double end_row(double at_end, double beside, double chord_at_end, double chord_beside)
{
    const double both = at_end + beside;
    return ((at_end + 2 * both) * beside * chord_at_end + at_end * at_end * chord_beside) / both;
}

static void few(size_t count, const double *t, const double *y, double *slope)
{
    const double first = count > 1 ? chord(t, y, 0) : 0;
    const double bend = count > 2 ? (chord(t, y, 1) - first) / (t[2] - t[0]) : 0;
    for (size_t i = 0; i < count; i++) {
        slope[i] = count > 2 ? first + bend * (2 * t[i] - t[0] - t[1]) : first;
    }
}

/* Elimination of rows `lower` slope[i - 1] + `diagonal` slope[i] + `upper` slope[i + 1] = right. */
static void eliminate(size_t i, double lower, double diagonal, double upper, double right,
                      double *slope, double *room)
{
    const double pivot = diagonal - (i > 0 ? lower * room[i - 1] : 0);
    room[i] = upper / pivot;
    slope[i] = (right - (i > 0 ? lower * slope[i - 1] : 0)) / pivot;
}

void spline_slopes(size_t count, const double *t, const double *y, double *slope, double *room)
{
    if (count < 4) {
        few(count, t, y, slope);
        return;
    }
    const size_t last = count - 1;
    double before = t[1] - t[0], after = t[2] - t[1];
    eliminate(0, 0, after, before + after, end_row(before, after, chord(t, y, 0), chord(t, y, 1)),
              slope, room);
    for (size_t i = 1; i < last; i++) {
        before = t[i] - t[i - 1];
        after = t[i + 1] - t[i];
        eliminate(i, after, 2 * (before + after), before,
                  3 * (after * chord(t, y, i - 1) + before * chord(t, y, i)), slope, room);
    }
    before = t[last - 1] - t[last - 2];
    after = t[last] - t[last - 1];
    eliminate(last, before + after, before, 0,
              end_row(after, before, chord(t, y, last - 1), chord(t, y, last - 2)), slope, room);
    for (size_t i = last; i-- > 0;) {
        slope[i] -= room[i] * slope[i + 1];
    }
}

enum { OVER = 5 }; /* samples that a cubic does not go through */

double spline_noise(size_t count, const double *t, const double *y)
{
    double sum = 0;
    for (size_t i = 0; i + OVER <= count; i++) {
        double off = 0, size = 0;
        for (size_t k = i; k < i + OVER; k++) {
            double weight = 1;
            for (size_t j = i; j < i + OVER; j++) {
                weight /= j == k ? 1 : (t[k] - t[j]) / (t[i + 1] - t[i]);
            }
            off += weight * y[k];
            size += weight * weight;
        }
        sum += off * off / size;
    }
    return count < OVER ? 0 : sqrt(sum / (double)(count - OVER + 1));
}

/* Row k of Q^T, second differences around sample k + 1. */
static void difference_row(const double *t, size_t k, double row[3])
{
    const double before = t[k + 1] - t[k], after = t[k + 2] - t[k + 1];
    row[0] = 1 / before;
    row[1] = -1 / before - 1 / after;
    row[2] = 1 / after;
}

/* smooth = y - by Q g with (R + by Q^T Q) g = Q^T y, and the root of the mean square of what is
 * taken off. R [count - 2] of three diagonals is that of hat functions; L D L^T is of five. */
static double smooth_by(size_t count, const double *t, const double *y, double by, double *smooth,
                        double *room)
{
    const size_t n = count - 2;
    double *d = room, *first = d + n, *second = first + n, *g = second + n, sum = 0;
    for (size_t k = 0; k < n; k++) {
        double row[3], next[3] = {0}, after[3] = {0};
        difference_row(t, k, row);
        if (k + 1 < n) {
            difference_row(t, k + 1, next);
        }
        if (k + 2 < n) {
            difference_row(t, k + 2, after);
        }
        d[k] = (t[k + 2] - t[k]) / 3 + by * (row[0] * row[0] + row[1] * row[1] + row[2] * row[2]);
        first[k] =
            k + 1 < n ? (t[k + 2] - t[k + 1]) / 6 + by * (row[1] * next[0] + row[2] * next[1]) : 0;
        second[k] = by * row[2] * after[0];
        g[k] = row[0] * y[k] + row[1] * y[k + 1] + row[2] * y[k + 2];
    }
    for (size_t k = 0; k < n; k++) { /* first and second become L */
        const double one = k > 0 ? first[k - 1] : 0, two = k > 1 ? second[k - 2] : 0;
        d[k] -= (k > 0 ? one * one * d[k - 1] : 0) + (k > 1 ? two * two * d[k - 2] : 0);
        g[k] -= (k > 0 ? one * g[k - 1] : 0) + (k > 1 ? two * g[k - 2] : 0);
        first[k] = (first[k] - (k > 0 ? one * second[k - 1] * d[k - 1] : 0)) / d[k];
        second[k] /= d[k];
    }
    for (size_t k = n; k-- > 0;) {
        g[k] = g[k] / d[k] - (k + 1 < n ? first[k] * g[k + 1] : 0) -
               (k + 2 < n ? second[k] * g[k + 2] : 0);
    }
    memcpy(smooth, y, count * sizeof *y);
    for (size_t k = 0; k < n; k++) {
        double row[3];
        difference_row(t, k, row);
        for (size_t i = 0; i < 3; i++) {
            smooth[k + i] -= by * row[i] * g[k];
        }
    }
    for (size_t i = 0; i < count; i++) {
        sum += (y[i] - smooth[i]) * (y[i] - smooth[i]);
    }
    return sqrt(sum / (double)count);
}

void spline_smooth(size_t count, const double *t, const double *y, double noise, double *smooth,
                   double *room)
{
    enum { HALVES = 50 };
    memcpy(smooth, y, count * sizeof *y);
    if (count < OVER || !(noise > 0)) {
        return;
    }
    const double piece = (t[count - 1] - t[0]) / (double)(count - 1);
    double low = -30, high = 30; /* of the natural logarithm, beside a piece */
    for (int i = 0; i < HALVES; i++) {
        const double middle = low + (high - low) / 2;
        const bool less = smooth_by(count, t, y, pow(piece, 3) * exp(middle), smooth, room) < noise;
        low = less ? middle : low;
        high = less ? high : middle;
    }
}
