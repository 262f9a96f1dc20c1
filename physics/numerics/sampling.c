#include "physics/numerics/sampling.h"
#include "physics/numerics/constants.h"

#include <math.h>
#include <string.h>

static const double below_one = 1.0 - 0x1p-53;

static const struct {
    const char *text;
    bool random, tensor;
} kinds[SAMPLING_KIND_COUNT] = {
#define SAMPLING_KIND_ROW(name, text, random, tensor) [name] = {text, random, tensor},
    SAMPLING_KIND_LIST(SAMPLING_KIND_ROW)
#undef SAMPLING_KIND_ROW
};

const char *sampling_kind_text(sampling_kind kind)
{
    return (unsigned)kind < SAMPLING_KIND_COUNT ? kinds[kind].text : "unknown sampling";
}

bool sampling_kind_is_tensor(sampling_kind kind)
{
    return (unsigned)kind < SAMPLING_KIND_COUNT && kinds[kind].tensor;
}

/* ---- tensor grids ---- */

typedef struct shape_search {
    int dimension;
    double most; /* points of an axis */
    size_t best[SAMPLING_MAX_GRID_DIMENSION];
    double best_misfit;
} shape_search;

/* Sum of squared logarithms of ratios, infinite when one is more than a factor of 2. */
static double shape_misfit(int dimension, const size_t *shape)
{
    double misfit = 0;
    for (int i = 0; i < dimension; i++) {
        for (int j = 0; j < i; j++) {
            const double ratio = (double)shape[i] / (double)shape[j];
            if (ratio > 2 || ratio < 0.5) {
                return INFINITY;
            }
            misfit += log(ratio) * log(ratio);
        }
    }
    return misfit;
}

/* Axes from `axis` on share out `left` points. */
static void search_shapes(shape_search *search, int axis, size_t left, size_t *shape)
{
    if (axis + 1 < search->dimension) {
        for (size_t n = 2; (double)n <= search->most && n <= left; n++) {
            shape[axis] = n;
            if (left % n == 0) {
                search_shapes(search, axis + 1, left / n, shape);
            }
        }
        return;
    }
    shape[axis] = left;
    const double misfit = left > 1 ? shape_misfit(search->dimension, shape) : INFINITY;
    /* The margin lets 25 x 40 win over 40 x 25, whatever the rounding of log. */
    if (misfit < search->best_misfit * (1.0 - 1e-9) || isinf(search->best_misfit)) {
        search->best_misfit = misfit;
        memcpy(search->best, shape, sizeof search->best);
    }
}

ad_status sampling_grid_shape(int dimension, size_t count,
                              size_t shape[SAMPLING_MAX_GRID_DIMENSION], size_t *actual,
                              ad_error *error)
{
    if (dimension < 1 || dimension > SAMPLING_MAX_GRID_DIMENSION) {
        return ad_fail(error, AD_BAD_ARGUMENT, "a tensor grid has dimension 1 to %d, not %d",
                       SAMPLING_MAX_GRID_DIMENSION, dimension);
    }
    for (size_t total = count; total > 1; total--) {
        size_t trial[SAMPLING_MAX_GRID_DIMENSION] = {1, 1, 1};
        shape_search search = {.dimension = dimension,
                               .most = 2.01 * pow((double)total, 1.0 / dimension),
                               .best_misfit = INFINITY};
        search_shapes(&search, 0, total, trial);
        if (search.best_misfit < INFINITY) {
            memcpy(shape, search.best, (size_t)dimension * sizeof *shape);
            *actual = total;
            return AD_OK;
        }
    }
    return ad_fail(error, AD_BAD_ARGUMENT,
                   "%zu points are too few for a tensor grid in %d dimensions", count, dimension);
}

ad_status sampling_count(sampling_kind kind, int dimension, size_t count, size_t *actual,
                         ad_error *error)
{
    if (sampling_kind_is_tensor(kind)) {
        size_t shape[SAMPLING_MAX_GRID_DIMENSION];
        return sampling_grid_shape(dimension, count, shape, actual, error);
    }
    *actual = count;
    return AD_OK;
}

/* Point `index` of `count` on one axis. The upper half mirrors the lower, so that the set is
 * symmetric to the last digit; sin^2 keeps relative accuracy near 0. */
static double axis_point(sampling_kind kind, size_t index, size_t count)
{
    const size_t mirrored = count - 1 - index;
    if (mirrored < index) {
        return 1.0 - axis_point(kind, mirrored, count);
    }
    if (mirrored == index) {
        return 0.5;
    }
    if (kind == SAMPLING_GRID) {
        return (double)index / (double)(count - 1);
    }
    const double half_angle = kind == SAMPLING_CHEBYSHEV
                                  ? PI * (double)(2 * index + 1) / (4.0 * (double)count)
                                  : PI * (double)index / (2.0 * (double)(count - 1));
    return sin(half_angle) * sin(half_angle);
}

/* Those that are wanted of `count` points. */
typedef struct part {
    size_t count, first, end;
    double *const *to;
} part;

static ad_status fill_tensor(sampling_kind kind, int dimension, const part *wanted, ad_error *error)
{
    size_t shape[SAMPLING_MAX_GRID_DIMENSION] = {0}, actual = 0;
    const ad_status status = sampling_grid_shape(dimension, wanted->count, shape, &actual, error);
    if (status != AD_OK) {
        return status;
    }
    if (actual != wanted->count) {
        return ad_fail(error, AD_BAD_ARGUMENT,
                       "%zu points have no %s shape; the nearest below is %zu", wanted->count,
                       sampling_kind_text(kind), actual);
    }
    size_t stride = wanted->count;
    for (int axis = 0; axis < dimension; axis++) {
        stride /= shape[axis];
        for (size_t i = wanted->first; i < wanted->end; i++) {
            wanted->to[axis][i] = axis_point(kind, i / stride % shape[axis], shape[axis]);
        }
    }
    return AD_OK;
}

/* ---- random sets ---- */

static void fill_uniform(nn_rng *rng, const part *wanted, double *coordinate)
{
    for (size_t i = 0; i < wanted->count; i++) {
        const double x = nn_rng_uniform(rng);
        if (i >= wanted->first && i < wanted->end) {
            coordinate[i] = x;
        }
    }
}

/* One coordinate: a point in each slice, then shuffled (Fisher and Yates). */
static void fill_latin(nn_rng *rng, size_t count, double *coordinate)
{
    for (size_t i = 0; i < count; i++) {
        const double place = ((double)i + nn_rng_uniform(rng)) / (double)count;
        coordinate[i] = fmin(place, below_one);
    }
    for (size_t i = count; i > 1; i--) {
        const size_t other = (size_t)nn_rng_below(rng, i);
        const double kept = coordinate[i - 1];
        coordinate[i - 1] = coordinate[other];
        coordinate[other] = kept;
    }
}

/* ---- Sobol' sequence ---- */

/* Joe and Kuo, SIAM J. Sci. Comput. 30 (2008), new-joe-kuo-6: degree, inner coefficients of the
 * primitive polynomial, initial direction integers. Row 0 stands for the first coordinate, whose
 * direction integers are all 1. */
static const struct {
    int degree;
    unsigned coefficients;
    uint32_t initial[8];
} joe_kuo[SAMPLING_MAX_DIMENSION] = {
    {0, 0, {0}},
    {1, 0, {1}},
    {2, 1, {1, 3}},
    {3, 1, {1, 3, 1}},
    {3, 2, {1, 1, 1}},
    {4, 1, {1, 1, 3, 3}},
    {4, 4, {1, 3, 5, 13}},
    {5, 2, {1, 1, 5, 5, 17}},
    {5, 4, {1, 1, 5, 5, 5}},
    {5, 7, {1, 1, 7, 11, 19}},
    {5, 11, {1, 1, 5, 1, 1}},
    {5, 13, {1, 1, 1, 3, 11}},
    {5, 14, {1, 3, 5, 5, 31}},
    {6, 1, {1, 3, 3, 9, 7, 49}},
    {6, 13, {1, 1, 1, 15, 21, 21}},
    {6, 16, {1, 3, 1, 13, 27, 49}},
    {6, 19, {1, 1, 1, 15, 7, 5}},
    {6, 22, {1, 3, 1, 15, 13, 25}},
    {6, 25, {1, 1, 5, 5, 19, 61}},
    {7, 1, {1, 3, 7, 11, 23, 15, 103}},
    {7, 4, {1, 3, 7, 13, 13, 15, 69}},
    {7, 7, {1, 1, 3, 13, 7, 35, 63}},
    {7, 8, {1, 3, 5, 9, 1, 25, 53}},
    {7, 14, {1, 3, 1, 13, 9, 35, 107}},
    {7, 19, {1, 3, 1, 5, 27, 61, 31}},
    {7, 21, {1, 1, 5, 11, 19, 41, 61}},
    {7, 28, {1, 3, 5, 3, 3, 13, 69}},
    {7, 31, {1, 1, 7, 13, 1, 19, 1}},
    {7, 32, {1, 3, 7, 5, 13, 19, 59}},
    {7, 37, {1, 1, 3, 9, 25, 29, 41}},
    {7, 41, {1, 3, 5, 13, 23, 1, 55}},
    {7, 42, {1, 3, 7, 3, 13, 59, 17}},
    {7, 50, {1, 3, 1, 3, 5, 53, 69}},
    {7, 55, {1, 1, 5, 5, 23, 33, 13}},
    {7, 56, {1, 1, 7, 7, 1, 61, 123}},
    {7, 59, {1, 1, 7, 9, 13, 61, 49}},
    {7, 62, {1, 3, 3, 5, 3, 55, 33}},
    {8, 14, {1, 3, 1, 15, 31, 13, 49, 245}},
    {8, 21, {1, 3, 5, 15, 31, 59, 63, 97}},
    {8, 22, {1, 3, 1, 11, 11, 11, 77, 249}},
    {8, 38, {1, 3, 1, 11, 27, 43, 71, 9}},
    {8, 47, {1, 1, 7, 15, 21, 11, 81, 45}},
    {8, 49, {1, 3, 7, 3, 25, 31, 65, 79}},
    {8, 50, {1, 3, 1, 1, 19, 11, 3, 205}},
    {8, 52, {1, 1, 5, 9, 19, 21, 29, 157}},
    {8, 56, {1, 3, 7, 11, 1, 33, 89, 185}},
    {8, 67, {1, 3, 3, 3, 15, 9, 79, 71}},
    {8, 70, {1, 3, 7, 11, 15, 39, 119, 27}},
};

/* direction[bit] is the direction number of bit `bit` of the Gray code, scaled by 2^32. */
static void sobol_directions(int coordinate, uint32_t direction[32])
{
    const int degree = joe_kuo[coordinate].degree;
    for (int bit = 0; bit < 32; bit++) {
        if (degree == 0) {
            direction[bit] = UINT32_C(1) << (31 - bit);
        } else if (bit < degree) {
            direction[bit] = joe_kuo[coordinate].initial[bit] << (31 - bit);
        } else {
            uint32_t value = direction[bit - degree] ^ (direction[bit - degree] >> degree);
            for (int term = 1; term < degree; term++) {
                if (joe_kuo[coordinate].coefficients >> (degree - 1 - term) & 1U) {
                    value ^= direction[bit - term];
                }
            }
            direction[bit] = value;
        }
    }
}

static void fill_sobol(nn_rng *rng, int axis, const part *wanted, double *coordinate)
{
    uint32_t direction[32];
    sobol_directions(axis, direction);
    const uint64_t shift = rng ? nn_rng_next(rng) >> 11 : 0,
                   gray = wanted->first ^ wanted->first >> 1;
    uint32_t word = 0;
    for (int bit = 0; bit < 32; bit++) {
        word ^= gray >> bit & 1U ? direction[bit] : 0;
    }
    for (size_t i = wanted->first; i < wanted->end; i++) {
        coordinate[i] = (double)(((uint64_t)word << 21) ^ shift) * 0x1p-53;
        /* Going from Gray code i to i + 1 flips the bit of the lowest zero of i. The last index
         * of a full 2^32 has none within 32 bits and needs no successor. */
        int bit = 0;
        while (bit < 31 && (i >> bit & 1U)) {
            bit++;
        }
        word ^= direction[bit];
    }
}

/* ---- */

ad_status sampling_fill_part(sampling_kind kind, nn_rng *rng, int dimension, size_t count,
                             size_t first, size_t end, double *const *to, ad_error *error)
{
    const part all = {count, first, end, to}, *wanted = &all;
    if ((unsigned)kind >= SAMPLING_KIND_COUNT) {
        return ad_fail(error, AD_BAD_ARGUMENT, "sampling kind %d does not exist", (int)kind);
    }
    if (dimension < 1 || dimension > SAMPLING_MAX_DIMENSION || count == 0 || wanted->end > count) {
        return ad_fail(error, AD_BAD_ARGUMENT,
                       "%s sampling of %zu points in dimension %d; allowed: 1 or more points, "
                       "dimension 1 to %d",
                       kinds[kind].text, count, dimension, SAMPLING_MAX_DIMENSION);
    }
    if (kinds[kind].random && !rng) {
        return ad_fail(error, AD_BAD_ARGUMENT, "%s sampling needs a random generator",
                       kinds[kind].text);
    }
    if (kinds[kind].tensor) {
        return fill_tensor(kind, dimension, wanted, error);
    }
    if (kind == SAMPLING_SOBOL && (uint64_t)count > (UINT64_C(1) << 32)) {
        return ad_fail(error, AD_BAD_ARGUMENT, "sobol sampling gives at most 2^32 points, not %zu",
                       count);
    }
    for (int axis = 0; axis < dimension; axis++) {
        if (kind == SAMPLING_LATIN_HYPERCUBE) {
            fill_latin(rng, count, wanted->to[axis]);
        } else if (kind == SAMPLING_UNIFORM) {
            fill_uniform(rng, wanted, wanted->to[axis]);
        } else {
            fill_sobol(rng, axis, wanted, wanted->to[axis]);
        }
    }
    return AD_OK;
}

ad_status sampling_fill(sampling_kind kind, nn_rng *rng, int dimension, size_t count,
                        double *points, ad_error *error)
{
    double *to[SAMPLING_MAX_DIMENSION];
    for (int axis = 0; axis < dimension && axis < SAMPLING_MAX_DIMENSION; axis++) {
        to[axis] = points + (size_t)axis * count;
    }
    return sampling_fill_part(kind, rng, dimension, count, 0, count, to, error);
}

size_t sampling_along(double length, size_t even, size_t count, const double *more, double *s)
{
    size_t points = even;
    for (size_t i = 0; i < even; i++) {
        s[i] = i + 1 < even ? length * (double)i / (double)(even - 1) : length;
    }
    for (size_t k = 0; k < count; k++) {
        size_t at = 0;
        while (at < points && s[at] < more[k]) {
            at++;
        }
        if (at > 0 && at < points && s[at] > more[k]) {
            memmove(s + at + 1, s + at, (points - at) * sizeof *s);
            s[at] = more[k];
            points++;
        }
    }
    return points;
}
