/* How far shapes are apart. */
#ifndef PHYSICS_NUMERICS_DISTANCE_H
#define PHYSICS_NUMERICS_DISTANCE_H

#include <math.h>
#include <stddef.h>

/* The largest distance between points of two shapes, of which coordinate c [coordinates] of point i
 * is at i * of_point + c * of_coordinate; infinite where one is not a number. */
static inline double largest_distance(size_t points, int coordinates, size_t of_point,
                                      size_t of_coordinate, const double *a, const double *b)
{
    double largest = 0;
    for (size_t i = 0; i < points; i++) {
        double square = 0;
        for (int c = 0; c < coordinates; c++) {
            const size_t at = i * of_point + (size_t)c * of_coordinate;
            square += (a[at] - b[at]) * (a[at] - b[at]);
        }
        largest = square <= largest ? largest : isnan(square) ? INFINITY : square;
    }
    return sqrt(largest);
}

#endif
