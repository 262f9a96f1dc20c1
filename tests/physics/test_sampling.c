/* Random numbers against published outputs; point sets against their defining properties. */
#include "nn/rng.h"
#include "physics/numerics/sampling.h"

#include <math.h>
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>
#include <stdlib.h>
#include <string.h>

#include <cmocka.h>

static const double pi = 3.14159265358979323846;

#define assert_between(value, low, high) check_between(value, low, high, __FILE__, __LINE__)

static void check_between(double value, double low, double high, const char *file, int line)
{
    if (!(value >= low && value <= high)) {
        print_error("%.17g is outside [%.17g, %.17g]\n", value, low, high);
        _fail(file, line);
    }
}

/* ---- generator ---- */

static void rng_meets_published_outputs(void **unused)
{
    (void)unused;
    /* First outputs of the authors' program xoshiro256plusplus.c from state 1, 2, 3, 4. */
    static const uint64_t expected[10] = {UINT64_C(41943041),
                                          UINT64_C(58720359),
                                          UINT64_C(3588806011781223),
                                          UINT64_C(3591011842654386),
                                          UINT64_C(9228616714210784205),
                                          UINT64_C(9973669472204895162),
                                          UINT64_C(14011001112246962877),
                                          UINT64_C(12406186145184390807),
                                          UINT64_C(15849039046786891736),
                                          UINT64_C(10450023813501588000)};
    nn_rng rng = {{1, 2, 3, 4}};
    for (int i = 0; i < 10; i++) {
        assert_true(nn_rng_next(&rng) == expected[i]);
    }
    /* First outputs of Vigna's splitmix64.c from 1234567. */
    uint64_t state = 1234567;
    assert_true(nn_splitmix64(&state) == UINT64_C(6457827717110365317));
    assert_true(nn_splitmix64(&state) == UINT64_C(3203168211198807973));
    assert_true(nn_splitmix64(&state) == UINT64_C(9817491932198370423));
}

static void seeding_is_the_same_everywhere(void **unused)
{
    (void)unused;
    /* Evaluated with arbitrary-precision integers from the definitions of splitmix64, FNV-1a and
     * xoshiro256++. The last name has bytes above 127, where char may be signed or not. */
    nn_rng rng = nn_rng_seed(0);
    assert_true(rng.state[0] == UINT64_C(0xE220A8397B1DCDAF));
    assert_true(rng.state[3] == UINT64_C(0xF88BB8A8724C81EC));
    assert_true(nn_rng_next(&rng) == UINT64_C(0x53175D61490B23DF));
    assert_true(nn_rng_next(&rng) == UINT64_C(0x61DA6F3DC380D507));
    rng = nn_rng_seed(0);
    assert_true(nn_rng_uniform(&rng) == (double)(UINT64_C(0x53175D61490B23DF) >> 11) * 0x1p-53);
    rng = nn_rng_split(42, "initialisation");
    assert_true(nn_rng_next(&rng) == UINT64_C(0xEF7C7CFFD939C023));
    assert_true(nn_rng_next(&rng) == UINT64_C(0xBB8794F5940977D6));
    rng = nn_rng_split(42, "points");
    assert_true(nn_rng_next(&rng) == UINT64_C(0x8F4D5793892C031B));
    rng = nn_rng_split(42, "gr\xC3\xB6\xC3\x9F"
                           "e");
    assert_true(nn_rng_next(&rng) == UINT64_C(0x25114CBF87D16409));
}

static void stored_state_resumes_the_sequence(void **unused)
{
    (void)unused;
    nn_rng rng = nn_rng_split(7, "checkpoint");
    for (int i = 0; i < 5; i++) {
        nn_rng_normal(&rng);
    }
    nn_rng stored;
    memcpy(stored.state, rng.state, sizeof stored.state);
    for (int i = 0; i < 5; i++) {
        assert_true(nn_rng_normal(&rng) == nn_rng_normal(&stored));
    }
}

static void uniform_and_normal_have_their_moments(void **unused)
{
    (void)unused;
    enum { COUNT = 400000 };
    nn_rng rng = nn_rng_split(1, "moments");
    double uniform[2] = {0}, normal[4] = {0}, product = 0, previous = 0;
    int within = 0;
    for (int i = 0; i < COUNT; i++) {
        const double u = nn_rng_uniform(&rng) - 0.5, z = nn_rng_normal(&rng);
        assert_true(u >= -0.5 && u < 0.5);
        uniform[0] += u / COUNT;
        uniform[1] += u * u / COUNT;
        for (int power = 1; power <= 4; power++) {
            normal[power - 1] += pow(z, power) / COUNT;
        }
        product += z * previous / COUNT;
        previous = z;
        within += fabs(z) < 1.0;
    }
    /* Five standard errors of each mean: variances 1/12, 1/180; 1, 2, 15, 96; 1. */
    const double bound = 5.0 / sqrt(COUNT);
    assert_between(uniform[0], -bound * sqrt(1.0 / 12), bound * sqrt(1.0 / 12));
    assert_between(uniform[1] - 1.0 / 12, -bound * sqrt(1.0 / 180), bound * sqrt(1.0 / 180));
    assert_between(normal[0], -bound, bound);
    assert_between(normal[1] - 1, -bound * sqrt(2), bound * sqrt(2));
    assert_between(normal[2], -bound * sqrt(15), bound * sqrt(15));
    assert_between(normal[3] - 3, -bound * sqrt(96), bound * sqrt(96));
    assert_between(product, -bound, bound);
    /* P(|z| < 1) = 0.682689..., variance p (1 - p) < 0.25. */
    assert_between((double)within / COUNT - 0.682689492137086, -0.5 * bound, 0.5 * bound);
}

static void streams_are_uncorrelated(void **unused)
{
    (void)unused;
    enum { COUNT = 100000 };
    nn_rng first = nn_rng_split(3, "a"), second = nn_rng_split(3, "b"),
           third = nn_rng_split(4, "a");
    double names = 0, seeds = 0;
    for (int i = 0; i < COUNT; i++) {
        const double x = nn_rng_uniform(&first) - 0.5;
        names += 12.0 * x * (nn_rng_uniform(&second) - 0.5) / COUNT;
        seeds += 12.0 * x * (nn_rng_uniform(&third) - 0.5) / COUNT;
    }
    /* Correlation of independent samples: standard error 1/sqrt(COUNT), five of them. */
    assert_between(names, -5.0 / sqrt(COUNT), 5.0 / sqrt(COUNT));
    assert_between(seeds, -5.0 / sqrt(COUNT), 5.0 / sqrt(COUNT));
}

static void below_is_unbiased_and_between_stays_inside(void **unused)
{
    (void)unused;
    enum { BINS = 7, COUNT = 70000 };
    nn_rng rng = nn_rng_split(5, "integers");
    int hits[BINS] = {0};
    for (int i = 0; i < COUNT; i++) {
        hits[nn_rng_below(&rng, BINS)]++;
    }
    double chi_squared = 0;
    for (int bin = 0; bin < BINS; bin++) {
        const double excess = hits[bin] - (double)COUNT / BINS;
        chi_squared += excess * excess / ((double)COUNT / BINS);
    }
    /* Six degrees of freedom: 30 is passed with probability 4e-5. */
    assert_between(chi_squared, 0, 30);
    /* A plain remainder would favour the lower half 2 : 1 here. */
    const uint64_t large = UINT64_C(3) << 62;
    int lower = 0;
    for (int i = 0; i < 10000; i++) {
        const uint64_t draw = nn_rng_below(&rng, large);
        assert_true(draw < large);
        lower += draw < large / 2;
    }
    assert_between(lower, 4750, 5250); /* five standard errors of 50 */
    assert_true(nn_rng_below(&rng, 1) == 0 && nn_rng_below(&rng, 0) == 0);
    for (int i = 0; i < 10000; i++) {
        const double next = nextafter(1.0, 2.0);
        assert_true(nn_rng_between(&rng, 1.0, next) == 1.0);
        assert_true(isfinite(nn_rng_between(&rng, -1.7e308, 1.7e308)));
    }
}

/* ---- point sets ---- */

static double *fill(sampling_kind kind, nn_rng *rng, int dimension, size_t count)
{
    double *points = malloc((size_t)dimension * count * sizeof *points);
    assert_non_null(points);
    ad_error error;
    assert_int_equal(sampling_fill(kind, rng, dimension, count, points, &error), AD_OK);
    for (size_t i = 0; i < (size_t)dimension * count; i++) {
        assert_true(points[i] >= 0.0 && points[i] <= 1.0);
    }
    return points;
}

/* Exactly one point in every one of `slices` equal slices, slice width a power of two or not. */
static bool one_in_each_slice(const double *coordinate, size_t slices)
{
    bool *seen = calloc(slices, sizeof *seen);
    assert_non_null(seen);
    bool single = true;
    for (size_t i = 0; i < slices; i++) {
        const size_t slice = (size_t)floor(coordinate[i] * (double)slices);
        single = single && slice < slices && !seen[slice < slices ? slice : 0];
        seen[slice < slices ? slice : 0] = true;
    }
    free(seen);
    return single;
}

static void latin_hypercube_fills_every_slice(void **unused)
{
    (void)unused;
    nn_rng rng = nn_rng_split(11, "latin");
    for (size_t count = 1; count <= 1024; count *= 4) {
        double *points = fill(SAMPLING_LATIN_HYPERCUBE, &rng, 3, count);
        for (int axis = 0; axis < 3; axis++) {
            assert_true(one_in_each_slice(points + (size_t)axis * count, count));
        }
        free(points);
    }
}

static void sobol_meets_published_points(void **unused)
{
    (void)unused;
    /* Points 0 .. 15 times 16, Joe-Kuo numbers in Gray-code order; and number 1000 times 1024 and
     * number 100000 times 2^17. From scipy.stats.qmc.Sobol (scipy 1.17, unscrambled). */
    static const double expected[16][16] = {
        {0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0},
        {8, 8, 8, 8, 8, 8, 8, 8, 8, 8, 8, 8, 8, 8, 8, 8},
        {12, 4, 4, 4, 12, 12, 4, 12, 12, 12, 12, 12, 4, 4, 12, 4},
        {4, 12, 12, 12, 4, 4, 12, 4, 4, 4, 4, 4, 12, 12, 4, 12},
        {6, 6, 10, 14, 6, 2, 6, 14, 14, 10, 14, 6, 6, 10, 6, 14},
        {14, 14, 2, 6, 14, 10, 14, 6, 6, 2, 6, 14, 14, 2, 14, 6},
        {10, 2, 14, 10, 10, 14, 2, 2, 2, 6, 2, 10, 2, 14, 10, 10},
        {2, 10, 6, 2, 2, 6, 10, 10, 10, 14, 10, 2, 10, 6, 2, 2},
        {3, 5, 15, 7, 9, 5, 7, 15, 15, 5, 11, 1, 15, 15, 13, 15},
        {11, 13, 7, 15, 1, 13, 15, 7, 7, 13, 3, 9, 7, 7, 5, 7},
        {15, 1, 11, 3, 5, 9, 3, 3, 3, 9, 7, 13, 11, 11, 1, 11},
        {7, 9, 3, 11, 13, 1, 11, 11, 11, 1, 15, 5, 3, 3, 9, 3},
        {5, 3, 5, 9, 15, 7, 1, 1, 1, 15, 5, 7, 9, 5, 11, 1},
        {13, 11, 13, 1, 7, 15, 9, 9, 9, 7, 13, 15, 1, 13, 3, 9},
        {9, 7, 1, 13, 3, 11, 5, 13, 13, 3, 9, 11, 13, 1, 7, 5},
        {1, 15, 9, 5, 11, 3, 13, 5, 5, 11, 1, 3, 5, 9, 15, 13},
    };
    static const double thousandth[48] = {
        225, 99,  531,  693, 287, 929, 47,  921, 513, 71,  87,  261,  165, 393, 147, 379,
        737, 353, 1015, 743, 535, 563, 973, 553, 597, 929, 41,  1003, 61,  349, 151, 149,
        303, 607, 821,  789, 869, 851, 315, 491, 935, 261, 983, 719,  861, 95,  893, 941};
    static const double late[48] = {
        8005,  14101, 123677, 81371, 79371,  126573, 7997,  4685,   2673,  100921, 36431, 59227,
        74081, 25803, 12609,  7771,  127815, 32269,  56835, 14275,  32067, 16711,  89601, 11525,
        13973, 64081, 20049,  38067, 125127, 17091,  89861, 62215,  40753, 35765,  80375, 64119,
        10515, 60997, 111773, 36565, 98781,  105157, 99045, 104621, 33621, 12357,  84801, 5697};
    const size_t count = 100001;
    double *points = fill(SAMPLING_SOBOL, NULL, 48, count);
    for (size_t axis = 0; axis < 48; axis++) {
        for (size_t i = 0; i < 16 && axis < 16; i++) {
            assert_true(16 * points[axis * count + i] == expected[i][axis]);
        }
        assert_true(1024 * points[axis * count + 1000] == thousandth[axis]);
        assert_true(131072 * points[axis * count + 100000] == late[axis]);
    }
    free(points);
}

static void shifted_sobol_keeps_its_balance(void **unused)
{
    (void)unused;
    enum { COUNT = 256 };
    nn_rng rng = nn_rng_split(12, "shift");
    double *first = fill(SAMPLING_SOBOL, &rng, 3, COUNT);
    double *second = fill(SAMPLING_SOBOL, &rng, 3, COUNT);
    assert_memory_not_equal(first, second, 3 * COUNT * sizeof *first);
    for (int axis = 0; axis < 3; axis++) {
        assert_true(one_in_each_slice(first + axis * COUNT, COUNT));
    }
    /* The first two coordinates are a (0, 8, 2)-net: one point in each box 2^-k by 2^-(8-k). */
    for (int k = 0; k <= 8; k++) {
        double box[COUNT];
        const double columns = ldexp(1.0, k), rows = ldexp(1.0, 8 - k);
        for (int i = 0; i < COUNT; i++) {
            box[i] = (floor(first[i] * columns) * rows + floor(first[COUNT + i] * rows)) / COUNT;
        }
        assert_true(one_in_each_slice(box, COUNT));
    }
    free(first);
    free(second);
}

/* Star discrepancy in two dimensions: the supremum over boxes [0,a) x [0,b), which is attained with
 * corners at the points' coordinates or 1, counting boundaries out or in (Niederreiter 1972). */
static double star_discrepancy(const double *points, size_t count)
{
    double worst = 0;
    for (size_t i = 0; i <= count; i++) {
        const double a = i < count ? points[i] : 1.0;
        for (size_t j = 0; j <= count; j++) {
            const double b = j < count ? points[count + j] : 1.0;
            size_t open = 0, closed = 0;
            for (size_t k = 0; k < count; k++) {
                open += points[k] < a && points[count + k] < b;
                closed += points[k] <= a && points[count + k] <= b;
            }
            worst = fmax(worst, fmax(a * b - (double)open / (double)count,
                                     (double)closed / (double)count - a * b));
        }
    }
    return worst;
}

static void sobol_has_low_discrepancy(void **unused)
{
    (void)unused;
    nn_rng rng = nn_rng_split(13, "discrepancy");
    const double one_point[2] = {0.5, 0.5};
    /* By hand: the closed box [0,1/2]^2 holds all of the points and a quarter of the area. */
    assert_between(star_discrepancy(one_point, 1), 0.75, 0.75);
    for (size_t count = 64; count <= 256; count *= 2) {
        double *sobol = fill(SAMPLING_SOBOL, NULL, 2, count);
        double *shifted = fill(SAMPLING_SOBOL, &rng, 2, count);
        double *uniform = fill(SAMPLING_UNIFORM, &rng, 2, count);
        /* Niederreiter 1992, chapter 4, base 2: a (0,m,2)-net has N D* <= m/2 + 3/2. */
        const double bound = (0.5 * log2((double)count) + 1.5) / (double)count;
        assert_between(star_discrepancy(sobol, count), 0, bound);
        assert_between(star_discrepancy(shifted, count), 0, bound);
        /* Random points: of the order of 1/sqrt(N), never near the bound above. */
        assert_between(star_discrepancy(uniform, count), 0.4 / sqrt((double)count),
                       3.0 / sqrt((double)count));
        free(sobol);
        free(shifted);
        free(uniform);
    }
}

/* Root mean square error over 64 sets of the mean of prod(pi/2 sin(pi x)), whose integral is 1. */
static double integration_error(sampling_kind kind, nn_rng *rng, size_t count)
{
    enum { SETS = 64 };
    double squares = 0;
    for (int set = 0; set < SETS; set++) {
        double *points = fill(kind, rng, 2, count);
        double mean = 0;
        for (size_t i = 0; i < count; i++) {
            mean += 0.25 * pi * pi * sin(pi * points[i]) * sin(pi * points[count + i]);
        }
        squares += pow(mean / (double)count - 1.0, 2) / SETS;
        free(points);
    }
    return sqrt(squares);
}

static void integrals_converge_at_their_rates(void **unused)
{
    (void)unused;
    nn_rng rng = nn_rng_split(14, "integral");
    /* Variance of the integrand: (pi^2/8)^2 - 1 = 0.5220; the interaction part, which a Latin
     * hypercube leaves, is (pi^2/8 - 1)^2 = 0.0546 (Stein 1987). The root of a mean of 64 squares
     * scatters by 9 per cent: 0.6 to 1.4 are more than four standard errors. */
    const double plain = sqrt(0.5220), latin = sqrt(0.0546);
    for (size_t count = 64; count <= 4096; count *= 8) {
        const double root = sqrt((double)count);
        assert_between(integration_error(SAMPLING_UNIFORM, &rng, count) * root, 0.6 * plain,
                       1.4 * plain);
        assert_between(integration_error(SAMPLING_LATIN_HYPERCUBE, &rng, count) * root, 0.6 * latin,
                       1.4 * latin);
        /* The integrand varies by pi^2 (Hardy and Krause; it vanishes on the far edges), so the
         * net's discrepancy bounds every single error by pi^2 (m/2 + 3/2)/N (Koksma and Hlawka);
         * the root mean square is far smaller, at most 0.033 m/N as measured. Three times that
         * still separates the set from both of the above at 4096 points. */
        const double sobol = integration_error(SAMPLING_SOBOL, &rng, count);
        assert_between(sobol, 0, 0.1 * log2((double)count) / (double)count);
    }
}

static void chebyshev_and_grid_points_are_exact(void **unused)
{
    (void)unused;
    ad_error error;
    double line[5];
    assert_int_equal(sampling_fill(SAMPLING_CHEBYSHEV, NULL, 1, 5, line, &error), AD_OK);
    for (int i = 0; i < 5; i++) {
        assert_between(line[i] - 0.5 * (1 - cos((2 * i + 1) * pi / 10)), -2e-16, 2e-16);
        assert_true(line[i] == 1.0 - line[4 - i] || line[4 - i] == 1.0 - line[i]);
    }
    assert_int_equal(sampling_fill(SAMPLING_CHEBYSHEV_LOBATTO, NULL, 1, 5, line, &error), AD_OK);
    const double root_eighth = 0.35355339059327376;
    const double lobatto[5] = {0, 0.5 - root_eighth, 0.5, 0.5 + root_eighth, 1};
    for (int i = 0; i < 5; i++) {
        assert_between(line[i] - lobatto[i], -2e-16, 2e-16);
    }
    assert_int_equal(sampling_fill(SAMPLING_GRID, NULL, 1, 5, line, &error), AD_OK);
    for (int i = 0; i < 5; i++) {
        assert_true(line[i] == 0.25 * i);
    }
    /* Two dimensions: 2 x 4, first axis slowest. */
    double plane[16];
    assert_int_equal(sampling_fill(SAMPLING_GRID, NULL, 2, 8, plane, &error), AD_OK);
    for (int i = 0; i < 8; i++) {
        assert_true(plane[i] == i / 4);
        assert_between(plane[8 + i] - (i % 4) / 3.0, -2e-16, 2e-16);
    }
}

static void assert_shape(int dimension, size_t count, size_t first, size_t second, size_t third)
{
    size_t shape[SAMPLING_MAX_GRID_DIMENSION] = {1, 1, 1}, actual;
    ad_error error;
    assert_int_equal(sampling_grid_shape(dimension, count, shape, &actual, &error), AD_OK);
    assert_int_equal(shape[0], first);
    assert_int_equal(shape[1], second);
    assert_int_equal(shape[2], third);
    assert_int_equal(actual, first * second * third);
}

static void counts_map_to_shapes(void **unused)
{
    (void)unused;
    assert_shape(1, 17, 17, 1, 1);
    assert_shape(2, 1000, 25, 40, 1);
    assert_shape(2, 997, 31, 32, 1);
    assert_shape(3, 1000, 10, 10, 10);
    assert_shape(3, 256, 4, 8, 8);
    size_t shape[SAMPLING_MAX_GRID_DIMENSION], actual, again;
    ad_error error;
    for (size_t count = 4; count < 3000; count += 7) {
        assert_int_equal(sampling_count(SAMPLING_GRID, 2, count, &actual, &error), AD_OK);
        /* Little is lost (at most 11 of any count to 3000, counted), and what was mapped stays. */
        assert_true(actual <= count && actual + 11 >= count);
        assert_int_equal(sampling_count(SAMPLING_GRID, 2, actual, &again, &error), AD_OK);
        assert_int_equal(actual, again);
    }
    assert_int_equal(sampling_count(SAMPLING_SOBOL, 2, 997, &actual, &error), AD_OK);
    assert_int_equal(actual, 997);
    assert_int_equal(sampling_grid_shape(4, 1000000, shape, &actual, &error), AD_BAD_ARGUMENT);
    assert_int_equal(sampling_grid_shape(2, 3, shape, &actual, &error), AD_BAD_ARGUMENT);
}

static void sets_are_deterministic(void **unused)
{
    (void)unused;
    for (int kind = 0; kind < SAMPLING_KIND_COUNT; kind++) {
        nn_rng first = nn_rng_split(15, "points"), second = nn_rng_split(15, "points");
        double *a = fill((sampling_kind)kind, &first, 2, 1000);
        double *b = fill((sampling_kind)kind, &second, 2, 1000);
        assert_memory_equal(a, b, 2000 * sizeof *a);
        free(a);
        free(b);
    }
}

static void kinds_have_names_and_errors_are_clear(void **unused)
{
    (void)unused;
    ad_error error;
    nn_rng rng = nn_rng_seed(1);
    double points[32];
    for (int kind = 0; kind < SAMPLING_KIND_COUNT; kind++) {
        for (int other = 0; other < kind; other++) {
            assert_string_not_equal(sampling_kind_text((sampling_kind)kind),
                                    sampling_kind_text((sampling_kind)other));
        }
    }
    assert_string_equal(sampling_kind_text(SAMPLING_KIND_COUNT), "unknown sampling");
    assert_int_equal(sampling_fill(SAMPLING_UNIFORM, NULL, 2, 4, points, &error), AD_BAD_ARGUMENT);
    assert_int_equal(sampling_fill(SAMPLING_UNIFORM, &rng, 49, 1, points, &error), AD_BAD_ARGUMENT);
    assert_int_equal(sampling_fill(SAMPLING_SOBOL, &rng, 2, 0, points, &error), AD_BAD_ARGUMENT);
    assert_int_equal(sampling_fill(SAMPLING_GRID, NULL, 4, 8, points, &error), AD_BAD_ARGUMENT);
    assert_int_equal(sampling_fill(SAMPLING_GRID, NULL, 2, 13, points, &error), AD_BAD_ARGUMENT);
    assert_string_equal(error.message, "13 points have no grid shape; the nearest below is 12");
}

/* Whatever part is drawn, its points are those of all, and the generator ends where it does then.
 */
static void parts_are_those_of_the_whole(void **state)
{
    (void)state;
    enum { COUNT = 1023, DIMENSION = 3 };
    static const size_t cuts[] = {0, 1, 8, 500, 512, 777, 1022, COUNT};
    const nn_rng before = nn_rng_seed(7);
    for (int kind = 0; kind < SAMPLING_KIND_COUNT; kind++) {
        size_t count;
        nn_rng rng = before;
        assert_int_equal(sampling_count((sampling_kind)kind, DIMENSION, COUNT, &count, NULL),
                         AD_OK);
        double *whole = fill((sampling_kind)kind, &rng, DIMENSION, count);
        for (size_t i = 0; i + 1 < sizeof cuts / sizeof *cuts; i++) {
            const size_t first = cuts[i] < count ? cuts[i] : count,
                         end = cuts[i + 1] < count ? cuts[i + 1] : count;
            nn_rng again = before;
            double *part = calloc(DIMENSION * count, sizeof *part), *to[DIMENSION];
            for (int axis = 0; axis < DIMENSION; axis++) {
                to[axis] = part + (size_t)axis * count;
            }
            assert_int_equal(sampling_fill_part((sampling_kind)kind, &again, DIMENSION, count,
                                                first, end, to, NULL),
                             AD_OK);
            assert_memory_equal(&again, &rng, sizeof rng);
            for (size_t k = 0; k < DIMENSION * count; k++) {
                const bool wanted = k % count >= first && k % count < end;
                assert_true(part[k] == (wanted || kind == SAMPLING_LATIN_HYPERCUBE ? whole[k] : 0));
            }
            free(part);
        }
        free(whole);
    }
}

/* The last is the length to the last bit, of which 0.12*240/240 is none. */
static void points_along_a_length_have_its_end(void **state)
{
    (void)state;
    const double more[6] = {0.05, -1, 0.12, NAN, 0.0003, 0.03};
    double s[241 + 6];
    assert_int_equal(sampling_along(0.12, 241, 6, more, s), 243); /* 0.03 is one of them */
    assert_true(s[0] == 0 && s[242] == 0.12 && s[1] == 0.0003);
    int found = 0;
    for (int i = 0; i < 243; i++) {
        assert_true(i == 0 || s[i] > s[i - 1]);
        found += s[i] == 0.05;
    }
    assert_int_equal(found, 1);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(rng_meets_published_outputs),
        cmocka_unit_test(seeding_is_the_same_everywhere),
        cmocka_unit_test(stored_state_resumes_the_sequence),
        cmocka_unit_test(uniform_and_normal_have_their_moments),
        cmocka_unit_test(streams_are_uncorrelated),
        cmocka_unit_test(below_is_unbiased_and_between_stays_inside),
        cmocka_unit_test(latin_hypercube_fills_every_slice),
        cmocka_unit_test(sobol_meets_published_points),
        cmocka_unit_test(shifted_sobol_keeps_its_balance),
        cmocka_unit_test(sobol_has_low_discrepancy),
        cmocka_unit_test(integrals_converge_at_their_rates),
        cmocka_unit_test(chebyshev_and_grid_points_are_exact),
        cmocka_unit_test(counts_map_to_shapes),
        cmocka_unit_test(sets_are_deterministic),
        cmocka_unit_test(parts_are_those_of_the_whole),
        cmocka_unit_test(kinds_have_names_and_errors_are_clear),
        cmocka_unit_test(points_along_a_length_have_its_end),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
