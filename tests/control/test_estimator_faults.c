/* What a filter does about measurements, models and settings that are not as they should be; that
 * it stays in the caller's memory and answers the same bits again. */
#include "allocations.h"
#include "filter_testing.h"

/* ---- faults -------------------------------------------------------------------------------- */

static void check_sound(const estimator *x)
{
    double p[N * N];
    estimator_covariance(x, p);
    for (int i = 0; i < N; i++) {
        assert_true(isfinite(estimator_state(x)[i]));
        assert_true(estimator_deviation(x, i) > 0 && isfinite(estimator_deviation(x, i)));
    }
}

/* One that is as if nothing had been measured, and one that was given nothing. */
static void test_bad_measurements(void **state)
{
    linear_test x;
    const double zero[N] = {0}, good[2] = {0.1, 0.2}, bad[2] = {0.1, NAN}, far[2] = {1e3, 0};
    const double huge[2] = {1e200, 0}, infinite[2] = {INFINITY, 0}, u = 0;
    (void)state;
    make_linear(&x, 0, 0);
    x.sensor[0].phase = 0;
    x.settings.sensors = 1;
    filter_test f = make_filter(&x.settings), none = make_filter(&x.settings);
    estimator_start(f.x, zero, zero, NULL);
    estimator_start(none.x, zero, zero, NULL);
    const struct {
        const double *values;
        int age, returned, flags;
    } cases[] = {
        {bad, 0, ESTIMATOR_NOT_FINITE, ESTIMATOR_NOT_FINITE},
        {infinite, 0, ESTIMATOR_NOT_FINITE, ESTIMATOR_NOT_FINITE},
        {huge, 0, ESTIMATOR_NOT_FINITE, ESTIMATOR_NOT_FINITE},
        {far, 0, 0, ESTIMATOR_OUTLIER},
        {good, 1, ESTIMATOR_LATE, ESTIMATOR_LATE | ESTIMATOR_MISSING},
        {good, 20, ESTIMATOR_LATE, ESTIMATOR_LATE | ESTIMATOR_MISSING},
        {NULL, 0, 0, ESTIMATOR_MISSING},
    };
    for (size_t i = 0; i < sizeof cases / sizeof *cases; i++) {
        if (cases[i].values) {
            assert_int_equal(estimator_measure(f.x, 0, cases[i].age, cases[i].values),
                             cases[i].returned);
        }
        assert_int_equal(estimator_update(f.x), cases[i].flags);
        estimator_update(none.x);
        for (int k = 0; k < N; k++) {
            assert_true(estimator_state(f.x)[k] == estimator_state(none.x)[k]);
            assert_true(estimator_deviation(f.x, k) == estimator_deviation(none.x, k));
        }
        for (int k = 0; k < 2; k++) { /* every other sample nothing is due */
            assert_int_equal(estimator_predict(f.x, &u, NULL), 0);
            estimator_predict(none.x, &u, NULL);
            assert_int_equal(k == 0 ? estimator_update(f.x) : 0, 0);
        }
    }
    assert_int_equal(estimator_measure(f.x, 0, 0, good), 0);
    estimator_update(f.x);
    assert_int_equal(estimator_measure(f.x, 0, 0, good), ESTIMATOR_BAD_CALL); /* twice */
    assert_int_equal(estimator_measure(f.x, 1, 0, good), ESTIMATOR_BAD_CALL);
    assert_int_equal(estimator_measure(f.x, -1, 0, good), ESTIMATOR_BAD_CALL);
    const estimator_consistency now = estimator_sensor_now(f.x, 0);
    assert_true(now.used == 1 && now.missing == 3 && now.not_finite == 3 && now.late == 2 &&
                now.outliers == 1);
    free(f.memory);
    free(none.memory);
}

/* A robot that is moved by hand is found again, and a covariance stays bounded where nothing is
 * seen for long. */
static void test_lost(void **state)
{
    linear_test x;
    const double zero[N] = {0}, u = 0, bad_u = NAN;
    double values[2], truth[N] = {0}, kept = 0;
    int flags = 0, all = 0, waited = 0;
    uint64_t seed = 9;
    (void)state;
    make_linear(&x, 0, 0);
    x.sensor[0].every = 1;
    filter_test f = make_filter(&x.settings);
    estimator_start(f.x, zero, zero, NULL);
    for (int sample = 0; sample < 100; sample++) {
        truth[0] += sample == 50 ? 30 : 0;
        for (int which = 0; which < 2; which++) {
            measure(&x, which, truth, &seed, values);
            estimator_measure(f.x, which, 0, values);
        }
        flags = estimator_update(f.x) & ~ESTIMATOR_INCONSISTENT;
        assert_true(sample >= 50 || flags == 0);
        all |= flags;
        waited += (flags & ESTIMATOR_OUTLIER) != 0;
        check_sound(f.x);
        estimator_predict(f.x, &u, NULL);
        go_on(&x, u, &seed, truth);
    }
    assert_int_equal(flags, 0);
    assert_int_equal(all, ESTIMATOR_OUTLIER | ESTIMATOR_INFLATED);
    assert_true(waited > 10 && waited < 30);
    assert_near(estimator_state(f.x)[0], truth[0], 5 * estimator_deviation(f.x, 0));
    for (int sample = 0; sample < 3000; sample++) {
        flags = estimator_predict(f.x, sample % 2 ? &u : &bad_u, NULL);
        assert_int_equal(flags & ESTIMATOR_BAD_INPUTS, sample % 2 ? 0 : ESTIMATOR_BAD_INPUTS);
        assert_true(flags & ESTIMATOR_MISSING);
        check_sound(f.x);
        kept = fmax(kept, estimator_deviation(f.x, 0));
    }
    assert_true(kept <= 100 * at_start[0] * (1 + 1e-12));
    free(f.memory);
}

static double far_out;

static double tell_outside(void *context, const double *state, const double *inputs)
{
    (void)context;
    (void)inputs;
    return state[0] / far_out;
}

/* A model without an answer for all points, then for none; a state that it was not made for. */
static void test_model_faults(void **state)
{
    linear_test x;
    const double start[N] = {1, 0.2, 0, 0}, u = 0;
    double next[N], before[N];
    (void)state;
    make_linear(&x, 0, 0);
    x.settings.sensors = 0;
    x.settings.model.outside = tell_outside;
    far_out = 10;
    filter_test f = make_filter(&x.settings);
    estimator_start(f.x, start, &u, NULL);
    x.model.fails = 1;
    linear_advance(&x.model, 1, 1, start, &u, NULL, next, NULL, NULL);
    assert_int_equal(estimator_predict(f.x, &u, NULL), ESTIMATOR_NO_ANSWER | ESTIMATOR_INFLATED);
    for (int i = 0; i < N; i++) {
        assert_true(estimator_state(f.x)[i] == next[i]);
        assert_near(estimator_deviation(f.x, i), 1.1 * at_start[i], 1e-14);
    }
    x.model.fails = 0;
    x.model.a[2][2] = NAN;
    assert_int_equal(estimator_predict(f.x, &u, NULL), ESTIMATOR_NO_ANSWER | ESTIMATOR_INFLATED);
    x.model.a[2][2] = 1e150; /* squares of it are not finite */
    assert_int_equal(estimator_predict(f.x, &u, NULL), ESTIMATOR_NO_ANSWER | ESTIMATOR_INFLATED);
    for (int i = 0; i < N; i++) {
        assert_true(estimator_state(f.x)[i] == next[i]);
    }
    x.model.a[2][2] = masses.a[2][2];
    far_out = 0.7 * estimator_state(f.x)[0];
    assert_int_equal(estimator_predict(f.x, &u, NULL), ESTIMATOR_OUTSIDE);
    assert_near(estimator_outside(f.x), estimator_state(f.x)[0] / far_out, 1e-14);
    far_out *= 0.3;
    memcpy(before, estimator_state(f.x), sizeof before);
    assert_int_equal(estimator_predict(f.x, &u, NULL),
                     ESTIMATOR_OUTSIDE | ESTIMATOR_NO_ANSWER | ESTIMATOR_INFLATED);
    assert_memory_equal(estimator_state(f.x), before, sizeof before);
    check_sound(f.x);
    free(f.memory);
}

static void test_refusals(void **state)
{
    linear_test x;
    double none[2] = {0.1, 0};
    (void)state;
    make_linear(&x, 0, 0);
    assert_null(estimator_refusal(&x.settings));
    x.settings.period = 0.5;
    assert_non_null(estimator_refusal(&x.settings)); /* the model has no shorter steps */
    x.settings.model.shorter = 1;
    assert_null(estimator_refusal(&x.settings));
    x.sensor[0].noise = none;
    assert_non_null(estimator_refusal(&x.settings));
    x.sensor[0].noise = noise_of_place;
    x.settings.beta = -1;
    assert_non_null(estimator_refusal(&x.settings));
    x.settings.beta = 0;
    estimator_parameter p = {.input = 1, .low = 1, .high = 2};
    x.settings.parameter = &p;
    x.settings.parameters = 1;
    assert_non_null(estimator_refusal(&x.settings)); /* there is one input alone */
    p.input = 0;
    assert_null(estimator_refusal(&x.settings));
    p.high = NAN;
    assert_non_null(estimator_refusal(&x.settings));
}

/* A parameter that pulls beyond its range stays at its end, which is told, and comes back. From
 * rest state and parameter are uncertain together. */
static void test_ranges(void **state)
{
    linear_model model = {.n = 1, .a = {{0.5}}, .b = {1}};
    const linear_observation observation = {.n = 1, .values = 1, .h = {{1}}};
    const double noise[1] = {0.01}, deviation[1] = {0.01}, process[1] = {0.001};
    const estimator_parameter load = {.input = 0, .low = 1, .high = 2, .walk = 0.05};
    const estimator_sensor sensor = {.observation = {(void *)&observation, 1, 0, 1, linear_see},
                                     .noise = noise};
    const estimator_settings settings = {.model = {.context = &model,
                                                   .states = 1,
                                                   .inputs = 1,
                                                   .step = 1,
                                                   .advance = linear_advance},
                                         .parameters = 1,
                                         .sensors = 1,
                                         .parameter = &load,
                                         .sensor = &sensor,
                                         .deviation = deviation,
                                         .process = process};
    const double start = 1.5, rest = 3, by_load = 2; /* x = x/2 + load */
    filter_test f = make_filter(&settings);
    double p[4];
    (void)state;
    assert_int_equal(estimator_start(f.x, &rest, &start, &by_load), 0);
    assert_near(estimator_state(f.x)[0], 3, 1e-7);
    estimator_covariance(f.x, p);
    /* log 2/sqrt(12) times dx/d log(load) = 2 * 1.5 */
    assert_near(p[1] / p[3], 3, 1e-12);
    int flags = 0, edges = 0;
    for (int k = 0; k < 200; k++) {
        const double force = k < 100 ? 2.2 : 1.3, value = 2 * force;
        estimator_measure(f.x, 0, 0, &value);
        flags = estimator_update(f.x);
        edges += (flags & ESTIMATOR_AT_EDGE) != 0;
        const double now = estimator_parameter_now(f.x, 0);
        assert_true(now >= 1 && now <= 2);
        assert_true(k != 99 || (now > 1.99 && (flags & ESTIMATOR_AT_EDGE)));
        flags = estimator_predict(f.x, &start, NULL);
    }
    assert_true(edges > 20 && edges < 110);
    assert_near(estimator_parameter_now(f.x, 0), 1.3, 0.02);
    free(f.memory);
}

/* ---- the same, and in the caller's memory -------------------------------------------------- */

static void run_for(linear_test *x, estimator *filter, double *result)
{
    double truth[N] = {0}, zero[N] = {0}, values[2], u;
    uint64_t seed = 77;
    estimator_start(filter, zero, zero, NULL);
    for (int sample = 0; sample < 100; sample++) {
        for (int which = 0; which < 2; which++) {
            measure(x, which, truth, &seed, values);
            values[0] = sample % 17 == 3 ? NAN : sample % 19 == 4 ? 1e3 : values[0];
            estimator_measure(filter, which, -1, values);
        }
        estimator_update(filter);
        u = input_at(sample);
        estimator_predict(filter, &u, NULL);
        go_on(x, u, &seed, truth);
    }
    memcpy(result, estimator_state(filter), N * sizeof *result);
    estimator_covariance(filter, result + N);
}

static void test_memory(void **state)
{
    linear_test x;
    double first[N + N * N], again[N + N * N], other[N + N * N];
    (void)state;
    make_linear(&x, 0, 0);
    x.sensor[0].every = 1;
    x.sensor[0].delay = 2;
    const size_t size = estimator_size(&x.settings);
    unsigned char *memory = malloc(size + 32);
    memset(memory, 0xff, size + 32);
    const long before = allocations;
    estimator *filter = estimator_init(memory + 16, &x.settings);
    run_for(&x, filter, first);
    run_for(&x, filter, again);
    assert_int_equal(allocations, before);
    for (int i = 0; i < 16; i++) {
        assert_true(memory[i] == 0xff && memory[size + 16 + i] == 0xff);
    }
    assert_memory_equal(first, again, sizeof first);
    filter_test f = make_filter(&x.settings);
    run_for(&x, f.x, other);
    assert_memory_equal(first, other, sizeof first);
    free(f.memory);
    free(memory);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_bad_measurements), cmocka_unit_test(test_lost),
        cmocka_unit_test(test_model_faults),     cmocka_unit_test(test_refusals),
        cmocka_unit_test(test_ranges),           cmocka_unit_test(test_memory),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
