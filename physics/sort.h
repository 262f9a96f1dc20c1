/* Numbers in ascending order; not for others. */
#ifndef PHYSICS_SORT_H
#define PHYSICS_SORT_H

#include <stdlib.h>

static inline int sort_compare(const void *a, const void *b)
{
    double x = *(const double *)a, y = *(const double *)b;
    return (x > y) - (x < y);
}

static inline void sort_ascending(size_t count, double *x)
{
    qsort(x, count, sizeof *x, sort_compare);
}

#endif
