/* Is a gradient the gradient? Central differences of sixth order, and a dot-product test. */
#include "autodiff/ad.h"

#include <math.h>
#include <stdint.h>
#include <stdlib.h>
#include <string.h>

typedef struct checker {
    ad_function function;
    void *context;
    double *x;
    size_t count;
    ad_error *error;
} checker;

static ad_status value_at(const checker *c, double *value)
{
    if (c->function(c->context, c->x, value, NULL) != 0 || !isfinite(*value)) {
        return ad_fail(c->error, AD_NOT_FINITE, "gradient check: the function has no finite value");
    }
    return AD_OK;
}

/* (45 (f_1 - f_-1) - 9 (f_2 - f_-2) + (f_3 - f_-3)) / (60 h) along `direction`; x is restored. */
static ad_status difference(const checker *c, const double *start, const double *direction,
                            double step, double *result)
{
    static const double weight[3] = {45, -9, 1};
    double sum = 0;
    for (int i = 1; i <= 3; i++) {
        double sides[2];
        for (int side = 0; side < 2; side++) {
            double t = side ? -i * step : i * step;
            for (size_t k = 0; k < c->count; k++) {
                c->x[k] = start[k] + t * direction[k];
            }
            ad_status status = value_at(c, &sides[side]);
            if (status != AD_OK) {
                memcpy(c->x, start, c->count * sizeof *start);
                return status;
            }
        }
        sum += weight[i - 1] * (sides[0] - sides[1]);
    }
    memcpy(c->x, start, c->count * sizeof *start);
    *result = sum / (60 * step);
    return AD_OK;
}

static double largest(const double *x, size_t count)
{
    double most = 0;
    for (size_t i = 0; i < count; i++) {
        most = fmax(most, fabs(x[i]));
    }
    return most;
}

/* Entries of a direction in [-1, 1) from a fixed sequence (Weyl): no generator to seed. */
static void fill_direction(double *direction, size_t count)
{
    uint64_t state = 0x9e3779b97f4a7c15u;
    for (size_t i = 0; i < count; i++) {
        state = state * 6364136223846793005u + 1442695040888963407u; /* Knuth's MMIX generator */
        direction[i] = (double)(int64_t)state / 9223372036854775808.0;
    }
}

static ad_status check_entries(const checker *c, const double *start, const double *gradient,
                               double *direction, size_t entries, double step, ad_check *check)
{
    double scale = fmax(largest(gradient, c->count), 1e-300);
    memset(direction, 0, c->count * sizeof *direction);
    for (size_t e = 0; e < entries; e++) {
        size_t i = (size_t)((double)e * (double)c->count / (double)entries);
        double estimate, h = step * fmax(1, fabs(start[i]));
        direction[i] = 1;
        ad_status status = difference(c, start, direction, h, &estimate);
        direction[i] = 0;
        if (status != AD_OK) {
            return status;
        }
        double off = fabs(estimate - gradient[i]) / scale;
        if (off >= check->worst_error) {
            *check = (ad_check){off, i, gradient[i], estimate, 0};
        }
    }
    return AD_OK;
}

static ad_status check_dot(const checker *c, const double *start, const double *gradient,
                           double *direction, double step, ad_check *check)
{
    double dot = 0, estimate, scale = 0;
    fill_direction(direction, c->count);
    for (size_t i = 0; i < c->count; i++) {
        dot += gradient[i] * direction[i];
        scale += gradient[i] * gradient[i] * direction[i] * direction[i];
    }
    double norm = sqrt((double)c->count);
    ad_status status = difference(c, start, direction, step / norm, &estimate);
    check->dot_error = fabs(estimate - dot) / fmax(sqrt(scale), 1e-300);
    return status;
}

ad_status ad_check_gradient(ad_function function, void *context, double *x, size_t count,
                            size_t entries, double step, ad_check *check, ad_error *error)
{
    checker c = {function, context, x, count, error};
    double *memory = malloc((3 * count + 1) * sizeof *memory);
    if (!memory) {
        return ad_fail(error, AD_NO_MEMORY, "out of memory in a gradient check");
    }
    double *start = memory, *gradient = memory + count, *direction = memory + 2 * count, value;
    memcpy(start, x, count * sizeof *x);
    *check = (ad_check){0};
    ad_status status = AD_OK;
    if (function(context, x, &value, gradient) != 0 || !isfinite(value)) {
        status = ad_fail(error, AD_NOT_FINITE, "gradient check: the function has no finite value");
    }
    if (status == AD_OK) {
        entries = entries == 0 || entries > count ? count : entries;
        status = check_entries(&c, start, gradient, direction, entries, step, check);
    }
    if (status == AD_OK) {
        status = check_dot(&c, start, gradient, direction, step, check);
    }
    free(memory);
    return status;
}
