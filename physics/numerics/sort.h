/* Numbers in ascending order, those that are not a number last. */
#ifndef PHYSICS_NUMERICS_SORT_H
#define PHYSICS_NUMERICS_SORT_H

#include <math.h>
#include <stdbool.h>
#include <stdlib.h>

static inline int sort_compare(const void *a, const void *b)
{
    const double x = *(const double *)a, y = *(const double *)b;
    return isnan(x) ? !isnan(y) : isnan(y) ? -1 : (x > y) - (x < y);
}

static inline void sort_ascending(size_t count, double *x)
{
    if (count > 0) { /* of none there is no array */
        qsort(x, count, sizeof *x, sort_compare);
    }
}

/* The same, each once; how many are left. */
static inline size_t sort_once(size_t count, double *x)
{
    size_t left = 0;
    sort_ascending(count, x);
    for (size_t i = 0; i < count; i++) {
        if (left == 0 || x[i] > x[left - 1]) {
            x[left++] = x[i];
        }
    }
    return left;
}

/* Of an even number the upper one; x is sorted. */
static inline double sort_median(size_t count, double *x)
{
    sort_ascending(count, x);
    return x[count / 2];
}

/* The cell between ascending edges [cells + 1] that x is in, before and after all the first and the
 * last one; of two that meet at x the second, or the first. */
static inline size_t sort_cell(size_t cells, const double *edges, double x, bool first)
{
    size_t low = 0, high = cells;
    while (high - low > 1) {
        const size_t middle = low + (high - low) / 2;
        *((first ? edges[middle] < x : edges[middle] <= x) ? &low : &high) = middle;
    }
    return low;
}

#endif
