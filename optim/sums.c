#include "internal.h"

#include <math.h>
#include <stdint.h>
#include <stdlib.h>
#include <string.h>

void *optim_room_create(size_t size, int parts, const optim_part *part)
{
    enum { ALIGNED = 64 };
    const size_t own = (size + ALIGNED - 1) / ALIGNED * ALIGNED;
    size_t all = own / sizeof(double);
    for (int i = 0; i < parts; i++) {
        const size_t rows = part[i].rows, most = SIZE_MAX / sizeof(double) - all;
        if (rows > 0 && part[i].count > most / rows) {
            return NULL;
        }
        all += rows * part[i].count;
    }
    char *room = calloc(all, sizeof(double));
    double *at = room ? (double *)(void *)(room + own) : NULL;
    for (int i = 0; i < parts && room; i++) {
        if (part[i].rows > 0) {
            memcpy(room + part[i].offset, &at, sizeof at);
        }
        at += part[i].rows * part[i].count;
    }
    return room;
}

int optim_parts_add(int parts, optim_part *part, int more, const optim_part *of)
{
    memcpy(part + parts, of, (size_t)more * sizeof *of);
    return parts + more;
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
