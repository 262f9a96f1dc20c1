/* The filter against Kalman's own on linear systems, with delays and drop-outs against the state
 * augmented by its past, against programs in Python on a system that is not linear, and by its
 * statistics over many runs. */
#include "filter_testing.h"

/* What a model may say of itself: more from step to step along one direction. by_state is found
 * from points, whose rounding is 1e-16/alpha. */
static const double unsure[N] = {0.02, -0.03, 0.01, 0.05};

static int doubt(void *context, double h, const double *state, const double *inputs,
                 const double *by_state, double *memory, double *covariance)
{
    const linear_model *model = context;
    (void)h, (void)state, (void)inputs;
    if (!by_state) { /* the motion begins */
        *memory = 0;
        return 0;
    }
    *memory += 1;
    for (int i = 0; i < N * N; i++) {
        assert_near(by_state[i], model->a[i / N][i % N], 1e-9);
        covariance[i] = *memory * unsure[i / N] * unsure[i % N];
    }
    return 0;
}

/* Of a step from a sample on. */
static void add_doubt(kalman *k, int sample)
{
    for (int i = 0; i < N * N; i++) {
        k->p[i / N][i % N] += (sample + 1) * unsure[i / N] * unsure[i % N];
    }
}

/* Sigma points of any width: rounding is larger for narrow ones, 1e-16/alpha. */
static void test_kalman(void **state)
{
    const double rules[3][2] = {{0, 0}, {1e-2, 2}, {0.6, 0.1}};
    (void)state;
    for (int rule = 0; rule < 3; rule++) {
        linear_test x;
        make_linear(&x, rules[rule][0], rules[rule][1]);
        x.settings.model.doubts = rule > 0;
        x.settings.model.doubt = doubt;
        filter_test f = make_filter(&x.settings);
        kalman k = {.n = N};
        uint64_t seed = 11;
        double truth[N] = {0}, q[N], p[N * N], values[2], zero[N] = {0};
        for (int i = 0; i < N; i++) {
            q[i] = left_out[i] * left_out[i];
            k.p[i][i] = at_start[i] * at_start[i];
        }
        estimator_start(f.x, zero, zero, NULL);
        for (int sample = 0; sample < 300; sample++) {
            double g[N], u = input_at(sample), nis = 0; /* held, or going on linearly */
            const double end = sample % 3 == 0 ? input_at(sample + 1) : u;
            for (int which = 0; which < 2; which++) {
                if (which == 0 && sample % 2 != 1) {
                    continue;
                }
                measure(&x, which, truth, &seed, values);
                assert_int_equal(estimator_measure(f.x, which, -1, values), 0);
                nis = 0;
                for (int i = 0; i < x.observation[which].values; i++) {
                    const double r = x.sensor[which].noise[i];
                    nis += kalman_correct(&k, x.observation[which].h[i], values[i], r * r);
                }
            }
            assert_int_equal(estimator_update(f.x) & ~ESTIMATOR_INCONSISTENT, 0);
            assert_near(estimator_sensor_now(f.x, 1).last, nis, 1e-9);
            estimator_covariance(f.x, p);
            for (int i = 0; i < N; i++) {
                assert_near(estimator_state(f.x)[i], k.x[i], 1e-10);
                for (int c = 0; c < N; c++) {
                    assert_near(p[i * N + c], k.p[i][c], 1e-10);
                }
                g[i] = masses.b[i] * 0.5 * (u + end);
            }
            assert_int_equal(estimator_predict(f.x, &u, u == end ? NULL : &end), 0);
            kalman_predict(&k, x.model.a, g, q);
            if (rule > 0) {
                add_doubt(&k, sample);
            }
            go_on(&x, 0.5 * (u + end), &seed, truth);
        }
        assert_int_equal(estimator_sample(f.x), 300);
        free(f.memory);
    }
}

/* ---- delays -------------------------------------------------------------------------------- */

enum { LAG = 4 };

/* The state with those of LAG samples before it, newest first. */
static void predict_augmented(kalman *k, const linear_test *x, double u)
{
    static double f[FILTER_STATES][FILTER_STATES];
    double g[FILTER_STATES] = {0}, q[FILTER_STATES] = {0};
    memset(f, 0, sizeof f);
    for (int i = 0; i < N; i++) {
        memcpy(f[i], x->model.a[i], N * sizeof f[i][0]);
        g[i] = x->model.b[i] * u;
        q[i] = left_out[i] * left_out[i];
    }
    for (int i = N; i < k->n; i++) {
        f[i][i - N] = 1;
    }
    kalman_predict(k, f, g, q);
}

/* Each sensor has a delay of its own; some measurements are lost and some one sample later than
 * they should be. */
static void test_delays(void **state)
{
    linear_test x;
    kalman k = {.n = N * (LAG + 1)};
    uint64_t seed = 5, luck = 6;
    double truth[N] = {0}, zero[N] = {0}, seen[200][3] = {{0}};
    int late_ones = 0, lost = 0, flags;
    (void)state;
    make_linear(&x, 0, 0);
    x.sensor[0].delay = 3;
    x.sensor[1].delay = 1;
    x.settings.late = 1;
    x.settings.model.doubts = 1; /* its memory goes back with the filter */
    x.settings.model.doubt = doubt;
    filter_test f = make_filter(&x.settings);
    estimator_start(f.x, zero, zero, NULL);
    for (int i = 0; i < N; i++) { /* there is nothing before the start, which is not seen either */
        k.p[i][i] = at_start[i] * at_start[i];
    }
    bool waits[2] = {false, false};
    for (int sample = 0; sample < 200; sample++) {
        double u = input_at(sample);
        int missing = 0;
        measure(&x, 0, truth, &seed, seen[sample]);
        measure(&x, 1, truth, &seed, seen[sample] + 2);
        for (int which = 0; which < 2; which++) {
            const int delay = x.sensor[which].delay, taken = sample - delay;
            const bool due = taken >= 0 && (which == 1 || taken % 2 == 1);
            const double chance = random_in(&luck, 0, 1);
            const bool later = due && chance < 0.1, drops = due && chance > 0.85;
            const int age[2] = {delay + 1, delay};
            const bool arrives[2] = {waits[which], due && !later && !drops};
            for (int a = 0; a < 2; a++) {
                if (arrives[a]) {
                    const double *values = seen[sample - age[a]] + 2 * which;
                    assert_int_equal(estimator_measure(f.x, which, a ? -1 : age[a], values), 0);
                    for (int i = 0; i < x.observation[which].values; i++) {
                        double h[FILTER_STATES] = {0};
                        memcpy(h + age[a] * N, x.observation[which].h[i], N * sizeof *h);
                        kalman_correct(&k, h, values[i],
                                       x.sensor[which].noise[i] * x.sensor[which].noise[i]);
                    }
                }
            }
            late_ones += waits[which];
            waits[which] = later;
            missing += later || drops;
            lost += drops;
        }
        flags = estimator_update(f.x) & ~ESTIMATOR_INCONSISTENT;
        assert_int_equal(flags, missing > 0 ? ESTIMATOR_MISSING : 0);
        for (int i = 0; i < N; i++) {
            assert_near(estimator_state(f.x)[i], k.x[i], 1e-10);
            const int before = N + i; /* of the sample before, as the shortest delay is 1 */
            assert_true(sample == 0 ||
                        fabs(estimator_deviation(f.x, i) - sqrt(k.p[before][before])) < 1e-10);
        }
        assert_int_equal(estimator_predict(f.x, &u, NULL), 0);
        predict_augmented(&k, &x, u);
        add_doubt(&k, sample);
        go_on(&x, u, &seed, truth);
    }
    assert_true(late_ones > 10 && lost > 10);
    free(f.memory);
}

/* ---- statistics ---------------------------------------------------------------------------- */

/* Over independent runs of a filter that knows its system, (x - x^)^T P^-1 (x - x^) is chi-squared
 * of N degrees, and so are normalised innovations of theirs: means over R runs lie within 4
 * standard deviations sqrt(2 N/R) of N, but for one in 16,000. Innovations of all samples are
 * independent, too. */
static void test_consistency(void **state)
{
    enum { RUNS = 400, SAMPLES = 60 };
    linear_test x;
    double nees = 0, nis[2] = {0};
    int used[2] = {0}, inconsistent = 0, biased = 0, correlated = 0;
    uint64_t seed = 21;
    (void)state;
    make_linear(&x, 0, 0);
    x.settings.gate = 1e-12;
    x.settings.window = 30;
    filter_test f = make_filter(&x.settings);
    for (int run = 0; run < RUNS; run++) {
        double truth[N] = {0}, zero[N] = {0}, values[2], u = 0, p[N * N];
        for (int i = 0; i < N; i++) {
            truth[i] = at_start[i] * random_normal(&seed);
        }
        estimator_start(f.x, zero, zero, NULL);
        for (int sample = 0; sample < SAMPLES; sample++) {
            for (int which = 0; which < 2; which++) {
                if (which == 1 || sample % 2 == 1) {
                    measure(&x, which, truth, &seed, values);
                    estimator_measure(f.x, which, -1, values);
                }
            }
            const int flags = estimator_update(f.x);
            for (int which = 0; which < 2; which++) {
                if (which == 1 || sample % 2 == 1) {
                    nis[which] += estimator_sensor_now(f.x, which).last;
                    used[which]++;
                }
            }
            if (sample == SAMPLES - 1) {
                inconsistent += (flags & ESTIMATOR_INCONSISTENT) != 0;
                for (int which = 0; which < 2; which++) {
                    const estimator_consistency last = estimator_sensor_now(f.x, which);
                    biased += last.bias > last.bias_high;
                    correlated += fabs(last.correlation) > last.correlation_high;
                }
                break;
            }
            u = input_at(sample);
            estimator_predict(f.x, &u, NULL);
            go_on(&x, u, &seed, truth);
        }
        /* e^T P^-1 e, one eliminated after the other */
        estimator_covariance(f.x, p);
        double e[N];
        for (int i = 0; i < N; i++) {
            e[i] = truth[i] - estimator_state(f.x)[i];
        }
        for (int i = 0; i < N; i++) {
            nees += e[i] * e[i] / p[i * N + i];
            for (int r = i + 1; r < N; r++) {
                const double by = p[r * N + i] / p[i * N + i];
                e[r] -= by * e[i];
                for (int c = i; c < N; c++) {
                    p[r * N + c] -= by * p[i * N + c];
                }
            }
        }
    }
    assert_near(nees / RUNS, N, 4 * sqrt(2.0 * N / RUNS));
    assert_near(nis[0] / used[0], 1, 4 * sqrt(2.0 / (2 * used[0])));
    assert_near(nis[1] / used[1], 1, 4 * sqrt(2.0 / used[1]));
    /* Two sensors, each out of bounds with a chance of 1e-3: 0.8 expected in 400 runs; at most 6
     * but for one in 10^5. */
    assert_true(inconsistent <= 6 && biased <= 6 && correlated <= 6);
    assert_near(estimator_doubt(f.x), 1, 1e-12);
    const estimator_consistency now = estimator_sensor_now(f.x, 1);
    /* scipy.stats.chi2.ppf([0.0005, 0.9995], 30)/30 */
    assert_near(now.low, 0.36014549, 1e-7);
    assert_near(now.high, 2.07206176, 1e-7);
    assert_near(now.bias_high, 10.82756617, 1e-6); /* scipy.stats.chi2.ppf(0.999, 1) */
    assert_int_equal(now.used, SAMPLES);
    free(f.memory);
}

/* Noise that is twice what the filter was told is found out. */
static void test_inconsistency(void **state)
{
    linear_test x;
    double truth[N] = {0}, zero[N] = {0}, values[2], u = 0, too_small[1] = {0.1};
    uint64_t seed = 31;
    int flags = 0;
    (void)state;
    make_linear(&x, 0, 0);
    x.settings.gate = 1e-12;
    x.sensor[1].noise = too_small;
    filter_test f = make_filter(&x.settings);
    estimator_start(f.x, zero, zero, NULL);
    for (int sample = 0; sample < 60; sample++) {
        linear_see(&x.observation[1], 1, truth, NULL, values, NULL);
        values[0] += 0.2 * random_normal(&seed);
        estimator_measure(f.x, 1, -1, values);
        flags = estimator_update(f.x);
        estimator_predict(f.x, &u, NULL);
        go_on(&x, u, &seed, truth);
    }
    assert_true(flags & ESTIMATOR_INCONSISTENT);
    assert_true(estimator_sensor_now(f.x, 1).mean > estimator_sensor_now(f.x, 1).high);
    free(f.memory);
}

/* A model that leaves out ten times as much as is said: what is adapted makes innovations of both
 * sensors consistent, or less than 1 for the one that asks for less. */
static void test_adaptation(void **state)
{
    linear_test x;
    double truth[N] = {0}, zero[N] = {0}, values[2], u = 0, tenth[N];
    uint64_t seed = 41;
    int flags = 0, outliers = 0;
    (void)state;
    make_linear(&x, 0, 0);
    for (int i = 0; i < N; i++) {
        tenth[i] = 0.1 * left_out[i];
    }
    x.settings.process = tenth;
    x.settings.adapt = 0; /* the default */
    x.settings.window = 500;
    filter_test f = make_filter(&x.settings);
    estimator_start(f.x, zero, zero, NULL);
    for (int sample = 0; sample < 2000; sample++) {
        for (int which = 0; which < 2; which++) {
            measure(&x, which, truth, &seed, values);
            estimator_measure(f.x, which, -1, values);
        }
        flags = estimator_update(f.x);
        outliers += sample > 500 && (flags & ESTIMATOR_OUTLIER);
        estimator_predict(f.x, &u, NULL);
        go_on(&x, u, &seed, truth);
    }
    assert_true(estimator_process(f.x) > 5 && estimator_process(f.x) < 20);
    assert_true(estimator_doubt(f.x) > 5 && estimator_doubt(f.x) < 20);
    assert_int_equal(outliers, 0);
    assert_true(estimator_sensor_now(f.x, 0).mean < estimator_sensor_now(f.x, 0).high);
    assert_true(estimator_sensor_now(f.x, 1).mean < estimator_sensor_now(f.x, 1).high);
    free(f.memory);
}

/* ---- not linear ---------------------------------------------------------------------------- */

/* A pendulum whose stiffness is not known. */
static int pendulum_advance(void *context, int count, double h, const double *states,
                            const double *inputs, const double *after, double *next,
                            double *by_state, double *by_inputs)
{
    (void)context;
    (void)after;
    (void)by_state;
    (void)by_inputs;
    for (int i = 0; i < count; i++) {
        const double angle = states[2 * i], rate = states[2 * i + 1];
        const double a = -inputs[2 * i] * sin(angle) - 0.3 * rate + inputs[2 * i + 1];
        next[2 * i] = angle + h * rate + 0.5 * h * h * a;
        next[2 * i + 1] = rate + h * a;
    }
    return 0;
}

static int pendulum_see(void *context, int count, const double *states, const double *inputs,
                        double *values, double *by_state)
{
    (void)context;
    (void)inputs;
    (void)by_state;
    for (int i = 0; i < count; i++) {
        values[2 * i] = sin(states[2 * i]);
        values[2 * i + 1] = hypot(1 + cos(states[2 * i]), 0.5 + states[2 * i + 1]);
    }
    return 0;
}

/* Numbers of filterpy 2.0.0, UnscentedKalmanFilter with MerweScaledSigmaPoints, and of a textbook's
 * formulas in numpy, for the same measurements: by covariances and weights of either sign, so that
 * all but rounding is equal. */
static void test_pendulum(void **state)
{
    static const struct {
        double alpha, beta, kappa, z[3], deviation[3], nis;
    } known[] = {
        {0,
         0,
         0,
         {0.05854558746815129, 0.37746714606859166, 2.0336971557879147},
         {0.008056365525527444, 0.029316368493896336, 0.0346838164619537},
         0.3913707417929476},
        {0.5,
         2,
         0,
         {0.05867089816183531, 0.37749005359412496, 2.036106216094697},
         {0.0080532029552004, 0.02931925210006258, 0.03461238726622849},
         0.3959561407488874},
        {1,
         0,
         1,
         {0.05854732464005642, 0.3774663613354734, 2.0337332296542887},
         {0.008056621205389887, 0.029317160926582934, 0.03469977877437695},
         0.39143078222585015},
    };
    const double noise[2] = {0.02, 0.05}, deviation[2] = {0.2, 0.3}, process[2] = {0.01, 0.05};
    const estimator_parameter stiffness = {
        .low = 0.1, .high = 100, .deviation = 0.25, .walk = 0.02};
    const estimator_sensor sensor = {.observation = {NULL, 2, 2, 2, pendulum_see}, .noise = noise};
    (void)state;
    for (size_t i = 0; i < sizeof known / sizeof *known; i++) {
        const estimator_settings settings = {
            .model = {.states = 2, .inputs = 2, .step = 0.05, .advance = pendulum_advance},
            .parameters = 1,
            .sensors = 1,
            .parameter = &stiffness,
            .sensor = &sensor,
            .deviation = deviation,
            .process = process,
            .adapt = 1,
            .alpha = known[i].alpha,
            .beta = known[i].beta,
            .kappa = known[i].kappa};
        const double start[2] = {0.4, 0}, inputs[2] = {9, 0};
        filter_test f = make_filter(&settings);
        estimator_start(f.x, start, inputs, NULL);
        for (int k = 0; k < 80; k++) {
            const double t = 0.05 * k * 2.9, fades = exp(-0.02 * k);
            const double truth[2] = {0.5 * cos(t) * fades, -0.5 * 2.9 * sin(t) * fades};
            const double u[2] = {NAN, 0.2 * sin(0.1 * k)};
            double values[2];
            pendulum_see(NULL, 1, truth, NULL, values, NULL);
            values[0] += 0.01 * sin(7 * k);
            values[1] += 0.02 * cos(5 * k);
            assert_int_equal(estimator_measure(f.x, 0, 0, values), 0);
            estimator_update(f.x);
            if (k < 79) {
                assert_int_equal(estimator_predict(f.x, u, NULL), 0);
            }
        }
        for (int k = 0; k < 2; k++) {
            assert_near(estimator_state(f.x)[k], known[i].z[k], 1e-12);
            assert_near(estimator_deviation(f.x, k), known[i].deviation[k], 1e-12);
        }
        assert_near(log(estimator_parameter_now(f.x, 0)), known[i].z[2], 1e-12);
        assert_near(estimator_parameter_deviation(f.x, 0) / estimator_parameter_now(f.x, 0),
                    known[i].deviation[2], 1e-12);
        assert_near(estimator_sensor_now(f.x, 0).last, known[i].nis, 1e-10);
        assert_true(estimator_inputs(f.x)[0] == estimator_parameter_now(f.x, 0));
        free(f.memory);
    }
}

/* ---- rotations ----------------------------------------------------------------------------- */

static const double axis[3] = {0.6, 0, 0.8};

static void turn_by(double angle, double *q)
{
    q[0] = cos(0.5 * angle);
    for (int i = 0; i < 3; i++) {
        q[1 + i] = sin(0.5 * angle) * axis[i];
    }
}

static int turn_see(void *context, int count, const double *states, const double *inputs,
                    double *values, double *by_state)
{
    const linear_model *x = context;
    (void)inputs;
    (void)by_state;
    for (int i = 0; i < count; i++) {
        turn_by(states[i * x->n], values + 4 * i);
    }
    return 0;
}

/* About a fixed axis rotation vectors are angles: the filter is that of angles, for all turns and
 * either sign of the quaternion, though what is measured wraps around. */
static void test_rotations(void **state)
{
    linear_model model = {.n = 2, .a = {{1, 0.1}, {0, 0.99}}, .b = {0, 0.1}};
    const double noise[3] = {0.05, 0.05, 0.05}, deviation[2] = {0.3, 1}, process[2] = {0.02, 0.3};
    const estimator_sensor sensor = {
        .observation = {&model, 2, 0, 4, turn_see}, .rotations = 1, .noise = noise, .depends = 1};
    const estimator_settings settings = {.model = {.context = &model,
                                                   .states = 2,
                                                   .inputs = 1,
                                                   .step = 1,
                                                   .advance = linear_advance},
                                         .sensors = 1,
                                         .sensor = &sensor,
                                         .deviation = deviation,
                                         .process = process,
                                         .adapt = 1};
    filter_test f = make_filter(&settings);
    kalman k = {.n = 2, .p = {{0.09, 0}, {0, 1}}};
    const double zero[2] = {0}, q[2] = {0.0004, 0.09}, h[2] = {1, 0};
    double angle = 0, u = 1, g[2] = {0, 0.1}, value[4];
    uint64_t seed = 3;
    (void)state;
    estimator_start(f.x, zero, zero, NULL);
    for (int sample = 0; sample < 300; sample++) {
        const double seen = angle + 0.05 * random_normal(&seed);
        turn_by(seen, value);
        for (int i = 0; i < 4; i++) {
            value[i] *= sample % 3 ? 1 : -1;
        }
        assert_int_equal(estimator_measure(f.x, 0, 0, value), 0);
        assert_int_equal(estimator_update(f.x) & ~ESTIMATOR_INCONSISTENT, 0);
        kalman_correct(&k, h, seen, 0.0025);
        for (int i = 0; i < 2; i++) {
            assert_near(estimator_state(f.x)[i], k.x[i], 1e-10);
            assert_near(estimator_deviation(f.x, i), sqrt(k.p[i][i]), 1e-10);
        }
        estimator_predict(f.x, &u, NULL);
        kalman_predict(&k, model.a, g, q);
        angle += 0.7 * (1 - exp(-0.01 * sample));
    }
    assert_true(k.x[0] > 20 * 3.14);
    value[0] = value[1] = value[2] = value[3] = 1; /* no rotation */
    assert_int_equal(estimator_measure(f.x, 0, 0, value), ESTIMATOR_NOT_FINITE);
    free(f.memory);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_kalman),      cmocka_unit_test(test_delays),
        cmocka_unit_test(test_consistency), cmocka_unit_test(test_inconsistency),
        cmocka_unit_test(test_adaptation),  cmocka_unit_test(test_pendulum),
        cmocka_unit_test(test_rotations),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
