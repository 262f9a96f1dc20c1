#include "tools/optimize/response.h"

#include <math.h>

enum { NEAR = 4 };

/* Of the mean distance of points: what is nearer to the one before, as a place that is nearly one
 * of the others, has the weight 0. Polynomials through both would make much of what they differ by.
 */
static const double APART = 0.01;

/* Adds to weights those of the integral from a to b of what has values at points kept [count] of s:
 * of the cubic through the four next to it, which two points of Gauss integrate exactly. */
static void add_integral(size_t count, const size_t *kept, const double *s, double a, double b,
                         double *weights)
{
    const size_t near = count < NEAR ? count : NEAR;
    size_t first = 0;
    while (first + near < count && s[kept[first + near / 2]] <= a) {
        first++;
    }
    for (int g = -1; g <= 1; g += 2) {
        const double x = (a + b) / 2 + g * (b - a) / (2 * sqrt(3));
        for (size_t j = first; j < first + near; j++) {
            double value = (b - a) / 2;
            for (size_t k = first; k < first + near; k++) {
                value *= k == j ? 1 : (x - s[kept[k]]) / (s[kept[j]] - s[kept[k]]);
            }
            weights[kept[j]] += value;
        }
    }
}

void response_weights(size_t points, const double *s, int breaks, const double *at, size_t *kept,
                      double *weights)
{
    size_t first = 0, next = 0;
    for (int piece = 0; piece <= breaks; piece++) {
        const double low = piece > 0 ? at[piece - 1] : 0, high = piece < breaks ? at[piece] : 1;
        size_t end = first;
        for (; next < points && (s[next] <= high || piece == breaks); next++) {
            if (end == first || s[next] - s[kept[end - 1]] > APART / (double)points) {
                kept[end++] = next;
            }
        }
        if (end == first) {
            weights[first > 0 ? kept[first - 1] : 0] += high - low;
            continue;
        }
        for (size_t i = first; i <= end; i++) {
            add_integral(end - first, kept + first, s, i > first ? s[kept[i - 1]] : low,
                         i < end ? s[kept[i]] : high, weights);
        }
        first = end;
    }
}
