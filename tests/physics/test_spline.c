/* Splines along samples: what they reproduce, how fast their error falls, how noisy samples are and
 * what is left of noise. */
#include "near.h"

#include "physics/numerics/spline.h"

#include <math.h>

enum { MOST = 400 };

/* Uneven: distances differ by a factor of up to 3. */
static void make_times(int count, double *t)
{
    for (int i = 0; i < count; i++) {
        const double x = (double)i / (count - 1);
        t[i] = x + 0.08 * sin(2 * 3.14159265358979 * x);
    }
}

static double cubic(double t)
{
    return 1 + t * (2 + t * (-3 + 4 * t));
}

/* Of any four samples or more, ends among them; a parabola of three. */
static void test_cubic(void **state)
{
    (void)state;
    double t[MOST], y[MOST], slope[MOST], room[MOST];
    for (int count = 3; count < 30; count += 3) {
        make_times(count, t);
        for (int i = 0; i < count; i++) {
            y[i] = count == 3 ? t[i] * t[i] : cubic(t[i]);
        }
        spline_slopes((size_t)count, t, y, slope, room);
        for (int i = 0; i < count; i++) {
            const double exact = count == 3 ? 2 * t[i] : 2 + t[i] * (-6 + 12 * t[i]);
            assert_near(slope[i], exact, 1e-11);
        }
        assert_true(spline_noise((size_t)count, t, y) < 1e-13);
    }
}

/* The slope's error at samples is of the third order, of equal distances of the fourth: with half
 * of the distance it falls by nearly 8. The second derivative by both pieces is one. */
static void test_order(void **state)
{
    (void)state;
    double t[MOST], y[MOST], slope[MOST], room[MOST], worst[2] = {0};
    for (int fine = 0; fine < 2; fine++) {
        const int count = fine ? 161 : 81;
        make_times(count, t);
        for (int i = 0; i < count; i++) {
            y[i] = sin(7 * t[i]);
        }
        spline_slopes((size_t)count, t, y, slope, room);
        for (int i = 0; i < count; i++) {
            worst[fine] = fmax(worst[fine], fabs(slope[i] - 7 * cos(7 * t[i])));
        }
        for (int i = 1; i + 1 < count; i++) {
            const double a = t[i] - t[i - 1], b = t[i + 1] - t[i];
            const double left = (2 * slope[i - 1] + 4 * slope[i] - 6 * (y[i] - y[i - 1]) / a) / a;
            const double right = (6 * (y[i + 1] - y[i]) / b - 4 * slope[i] - 2 * slope[i + 1]) / b;
            assert_near(left, right, 1e-9);
        }
    }
    print_message("slopes off by %.1e, %.1e\n", worst[0], worst[1]);
    assert_true(worst[1] < worst[0] / 7);
}

/* The noise of 400 samples is found to 10 %, three times the deviation of such an estimate; smooth
 * samples are off the noisy ones by it, are less than half as far off the truth, and their second
 * differences, less those of the truth, are less than a tenth of those of the noise. */
static void test_noise(void **state)
{
    (void)state;
    const double noise = 1e-3;
    double t[MOST], exact[MOST], y[MOST], smooth[MOST], room[6 * MOST];
    double taken = 0, left = 0, bent[2] = {0};
    unsigned seed = 7;
    make_times(MOST, t);
    for (int i = 0; i < MOST; i++) {
        double drawn = 0; /* of twelve uniform ones */
        for (int k = 0; k < 12; k++) {
            seed = seed * 1664525U + 1013904223U;
            drawn += (double)seed / 4294967296.0 - 0.5;
        }
        exact[i] = sin(7 * t[i]);
        y[i] = exact[i] + noise * drawn;
    }
    const double found = spline_noise(MOST, t, y);
    assert_near(found, noise, 0.1 * noise);
    spline_smooth(MOST, t, y, found, smooth, room);
    for (int i = 0; i < MOST; i++) {
        taken += pow(y[i] - smooth[i], 2) / MOST;
        left += pow(exact[i] - smooth[i], 2) / MOST;
    }
    for (int i = 0; i < MOST; i++) {
        y[i] -= exact[i];
        exact[i] = smooth[i] - exact[i];
    }
    for (int i = 1; i + 1 < MOST; i++) {
        bent[0] = fmax(bent[0], fabs(y[i + 1] - 2 * y[i] + y[i - 1]));
        bent[1] = fmax(bent[1], fabs(exact[i + 1] - 2 * exact[i] + exact[i - 1]));
    }
    print_message("noise %.3e, taken off %.3e, left %.3e; second differences %.1e of %.1e\n", found,
                  sqrt(taken), sqrt(left), bent[1], bent[0]);
    assert_near(sqrt(taken), found, 1e-6 * found);
    assert_true(sqrt(left) < 0.5 * noise);
    assert_true(bent[1] < bent[0] / 10);
    spline_smooth(MOST, t, y, 0, smooth, room);
    assert_memory_equal(smooth, y, sizeof y);
}

int main(void)
{
    const struct CMUnitTest tests[] = {cmocka_unit_test(test_cubic), cmocka_unit_test(test_order),
                                       cmocka_unit_test(test_noise)};
    return cmocka_run_group_tests(tests, NULL, NULL);
}
