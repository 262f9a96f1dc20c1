/* Numbers in ascending order, those that are not a number last. */
#ifndef PHYSICS_NUMERICS_SORT_H
#define PHYSICS_NUMERICS_SORT_H

#include <math.h>
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

/* Of an even number the upper one; x is sorted. */
static inline double sort_median(size_t count, double *x)
{
    sort_ascending(count, x);
    return x[count / 2];
}

#endif
