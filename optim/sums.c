#include "internal.h"

#include <math.h>
#include <stdlib.h>

double *optim_vector_create(size_t rows, size_t count)
{
    if (count && rows > SIZE_MAX / sizeof(double) / count) {
        return NULL;
    }
    return calloc(rows * count, sizeof(double));
}

double *optim_room_create(int parts, const optim_part *part)
{
    size_t all = 0;
    for (int i = 0; i < parts; i++) {
        const size_t rows = part[i].rows, most = SIZE_MAX / sizeof(double) - all;
        if (rows > 0 && part[i].count > most / rows) {
            return NULL;
        }
        all += rows * part[i].count;
    }
    double *room = optim_vector_create(1, all), *at = room;
    for (int i = 0; i < parts && room; at += part[i].rows * part[i].count, i++) {
        *part[i].at = at;
    }
    return room;
}

const char *optim_check_start(const char *problem, size_t count, const double *x)
{
    return problem                       ? problem
           : count == 0                  ? "count must be at least 1"
           : !optim_all_finite(count, x) ? "the starting point x must be finite"
                                         : NULL;
}

double optim_dot(size_t count, const double *a, const double *b)
{
    /* Sixteen independent sums: enough for the compiler to use vector registers and to hide the
     * latency of the additions without changing their order. */
    enum { LANES = 16 };
    double sum[LANES] = {0};
    size_t i = 0;
    for (; i + LANES <= count; i += LANES) {
        for (size_t lane = 0; lane < LANES; lane++) {
            sum[lane] += a[i + lane] * b[i + lane];
        }
    }
    for (size_t lane = 0; i < count; i++, lane++) {
        sum[lane] += a[i] * b[i];
    }
    for (size_t half = LANES / 2; half > 0; half /= 2) {
        for (size_t lane = 0; lane < half; lane++) {
            sum[lane] += sum[lane + half];
        }
    }
    return sum[0];
}

double optim_max_abs(size_t count, const double *a)
{
    double largest = 0;
    for (size_t i = 0; i < count; i++) {
        const double size = fabs(a[i]);
        largest = size > largest ? size : largest;
    }
    return largest;
}

int optim_all_finite(size_t count, const double *a)
{
    for (size_t i = 0; i < count; i++) {
        if (!isfinite(a[i])) {
            return 0;
        }
    }
    return 1;
}

int optim_is_counter(double value, double limit)
{
    return value >= 0 && value <= limit && floor(value) == value;
}

int optim_copy_rows(optim_array *arrays, int capacity, const optim_array *rows, int row_count)
{
    for (int i = 0; i < row_count && i < capacity; i++) {
        arrays[i] = rows[i];
    }
    return row_count;
}
