/* What sensors see of a reduced rod: against the rod itself, and derivatives against difference
 * quotients; and the stiffness of an arm, found by what is seen of its tip. */
#include "fewer.h"
#include "filter_testing.h"

#include "physics/chain/reduced.h"
#include "tools/control/clearance_observation.h"
#include "tools/control/observation.h"
#include "tools/control/reduced_model.h"
#include "tools/prepare/prepare.h"

static const char arm[] = "configs/robots/soft_arm_control.yaml";
static const int modes[4] = {2, 1, 2, 1}, finer[4] = {3, 2, 3, 2};
static const double apart = 1e-4, places[3] = {0.05, 0.05 - 1e-4, 0.05 + 1e-4}, tip = 0.13;

enum { STATES = 18, ALL = 7 };

static config *read_arm(int count, const char *const *changes)
{
    ad_error error = {.message = ""};
    config *settings = NULL;
    if (prepare_read(arm, NULL, count, changes, &settings, &error) != AD_OK) {
        fail_msg("%s", error.message);
    }
    return settings;
}

static observation *make_look_of(const scene *of, const int *counts, observation_what what,
                                 int count, const double *s)
{
    ad_error error = {.message = ""};
    const observation_sensor sensor = {what, count, s};
    observation *made = NULL;
    if (observation_create(of, counts, &sensor, &made, &error) != AD_OK) {
        fail_msg("%s", error.message);
    }
    return made;
}

static observation *make_observation(const scene *of, observation_what what, int count,
                                     const double *s)
{
    return make_look_of(of, modes, what, count, s);
}

static reduced_rod *make_rod(const scene *of, const int *counts)
{
    ad_error error = {.message = ""};
    reduced_settings settings = {.count = 1, .s = &tip};
    reduced_rod *rod = NULL;
    memcpy(settings.modes, counts, sizeof settings.modes);
    if (reduced_create(of, &settings, &rod, &error) != AD_OK) {
        fail_msg("%s", error.message);
    }
    return rod;
}

/* Of sizes that bend the arm by about 1 rad and move it at about 1 m/s. */
static void random_states(int count, double *states)
{
    uint64_t seed = 8;
    for (int i = 0; i < count * STATES; i++) {
        const int k = i % (STATES / 2);
        const double size = k < 4 ? 0.1 : 6; /* strains, curvatures */
        states[i] = size * (i % STATES < STATES / 2 ? 1 : 10) * random_in(&seed, -1, 1);
    }
}

static void see(observation *x, int count, const double *states, double *values, double *by_state)
{
    const one_observation observation = observation_of(x);
    assert_int_equal(observation.see(observation.context, count, states, NULL, values, by_state),
                     0);
}

/* Of many states at once as of each alone, and as the rod says. */
static void test_values(void **state)
{
    enum { COUNT = 11 };
    const char *changes[] = {"boundary.start.position=[0.1, -0.2, 0.3]",
                             "boundary.start.rotation=[0.6, 0, 0.8, 0]"};
    config *settings = read_arm(2, changes);
    reduced_rod *rod = make_rod(&settings->scene, modes);
    double states[COUNT * STATES], inputs[4] = {1, 2, 3, 1}, seen[5][COUNT * 4], alone[4];
    ad_error error;
    (void)state;
    random_states(COUNT, states);
    for (int what = 0; what < 5; what++) {
        observation *x = make_observation(&settings->scene, (observation_what)what, 1, &tip);
        const int values = observation_of(x).values;
        assert_int_equal(values, what == OBSERVATION_ROTATION ? 4 : 3);
        assert_int_equal(observation_depends_on(x),
                         what < OBSERVATION_VELOCITY ? STATES / 2 : STATES);
        see(x, COUNT, states, seen[what], NULL);
        for (int i = 0; i < COUNT; i++) {
            see(x, 1, states + i * STATES, alone, NULL);
            assert_memory_equal(alone, seen[what] + i * values, (size_t)values * sizeof *alone);
        }
        states[5] = NAN; /* a bending */
        assert_int_not_equal(
            observation_of(x).see(observation_of(x).context, COUNT, states, NULL, seen[4], NULL),
            0);
        random_states(COUNT, states);
        observation_free(x);
    }
    observation *x = make_observation(&settings->scene, OBSERVATION_ANGULAR_VELOCITY, 1, &tip);
    see(x, COUNT, states, seen[4], NULL);
    observation_free(x);
    for (int i = 0; i < COUNT; i++) {
        reduced_place at;
        assert_int_equal(reduced_output(rod, 0, states + i * STATES, inputs, &at, NULL, &error),
                         AD_OK);
        const double *q = at.rotation;
        const double d3[3] = {2 * (q[1] * q[3] + q[0] * q[2]), 2 * (q[2] * q[3] - q[0] * q[1]),
                              q[0] * q[0] - q[1] * q[1] - q[2] * q[2] + q[3] * q[3]};
        for (int k = 0; k < 4; k++) {
            assert_near(seen[OBSERVATION_ROTATION][4 * i + k], q[k], 1e-14);
        }
        for (int k = 0; k < 3; k++) {
            assert_near(seen[OBSERVATION_POSITION][3 * i + k], at.position[k], 1e-15);
            assert_near(seen[OBSERVATION_DIRECTION][3 * i + k], d3[k], 1e-14);
            assert_near(seen[OBSERVATION_VELOCITY][3 * i + k], at.velocity[k], 1e-14);
            assert_near(seen[OBSERVATION_ANGULAR_VELOCITY][3 * i + k], at.angular_velocity[k],
                        1e-13);
        }
    }
    reduced_free(rod);
    config_free(settings);
}

/* Curvature and strain are how rotation and position change along the rod: by differences over
 * 0.2 mm, off by 1e-4 of the third derivatives, 1e-8 times 1e4/m^2 of them. */
static void test_strains(void **state)
{
    config *settings = read_arm(0, NULL);
    observation *rotation = make_observation(&settings->scene, OBSERVATION_ROTATION, 3, places);
    observation *position = make_observation(&settings->scene, OBSERVATION_POSITION, 3, places);
    observation *curvature = make_observation(&settings->scene, OBSERVATION_CURVATURE, 1, places);
    observation *strain = make_observation(&settings->scene, OBSERVATION_STRAIN, 1, places);
    double x[STATES], q[12], r[9], u[3], v[3];
    (void)state;
    random_states(1, x);
    see(rotation, 1, x, q, NULL);
    see(position, 1, x, r, NULL);
    see(curvature, 1, x, u, NULL);
    see(strain, 1, x, v, NULL);
    const double *a = q + 4, *b = q + 8;
    for (int i = 0; i < 3; i++) {
        const int j = (i + 1) % 3, k = (i + 2) % 3;
        const double along = (r[6 + i] - r[3 + i]) / (2 * apart);
        const double turn = a[0] * b[1 + i] - b[0] * a[1 + i] - a[1 + j] * b[1 + k] +
                            a[1 + k] * b[1 + j]; /* half of it */
        const double n = q[0] * q[0] - q[1] * q[1] - q[2] * q[2] - q[3] * q[3];
        const double dot = q[1] * v[0] + q[2] * v[1] + q[3] * v[2];
        const double turned =
            n * v[i] + 2 * dot * q[1 + i] + 2 * q[0] * (q[1 + j] * v[k] - q[1 + k] * v[j]);
        assert_near(turn / apart, u[i], 1e-4);
        assert_near(along, turned, 1e-4);
        assert_true(fabs(u[i]) > 0.1);
    }
    observation_free(rotation);
    observation_free(position);
    observation_free(curvature);
    observation_free(strain);
    config_free(settings);
}

/* Derivatives are exact but for the turn between points, of order 6: 1e-5 here; difference
 * quotients are off by 1e-7. A velocity is how a position changes with the rates. */
static void test_derivatives(void **state)
{
    enum { COUNT = 3 };
    config *settings = read_arm(0, NULL);
    (void)state;
    for (int what = 0; what < ALL; what++) {
        observation *x = make_observation(&settings->scene, (observation_what)what, 2,
                                          (const double[]){0.07, 0.13});
        const int values = observation_of(x).values;
        double states[COUNT * STATES], y[2][COUNT * 8], by[COUNT * 8 * STATES];
        random_states(COUNT, states);
        see(x, COUNT, states, y[0], by);
        for (int c = 0; c < STATES; c++) {
            const double step = 1e-4;
            double size = 0;
            for (int side = 0; side < 2; side++) {
                for (int i = 0; i < COUNT; i++) {
                    states[i * STATES + c] += side ? 2 * step : -step;
                }
                see(x, COUNT, states, y[side], NULL);
            }
            for (int i = 0; i < COUNT; i++) {
                states[i * STATES + c] -= step;
            }
            for (int i = 0; i < COUNT * values; i++) {
                size = fmax(size, fabs(by[i * STATES + c]));
            }
            for (int i = 0; i < COUNT * values; i++) {
                assert_near(by[i * STATES + c], (y[1][i] - y[0][i]) / (2 * step),
                            3e-5 * size + 1e-9);
            }
            assert_true(c < observation_depends_on(x) || size == 0);
        }
        observation_free(x);
    }
    observation *position = make_observation(&settings->scene, OBSERVATION_POSITION, 1, &tip);
    observation *velocity = make_observation(&settings->scene, OBSERVATION_VELOCITY, 1, &tip);
    double moving[3 * STATES], r[9], v[3];
    random_states(1, moving);
    for (int k = 0; k < STATES; k++) {
        const double rate = k < STATES / 2 ? moving[STATES / 2 + k] : 0;
        moving[STATES + k] = moving[k] + 1e-5 * rate;
        moving[2 * STATES + k] = moving[k] - 1e-5 * rate;
    }
    see(position, 3, moving, r, NULL);
    see(velocity, 1, moving, v, NULL);
    for (int k = 0; k < 3; k++) {
        assert_near(v[k], (r[3 + k] - r[6 + k]) / 2e-5, 1e-6);
    }
    observation_free(position);
    observation_free(velocity);
    config_free(settings);
}

/* Within a large box of two sides that are near, x = 0.05 and z = 0.13, the smaller distance is
 * that from their planes. Of one place the smooth minimum is the distance; of four it is less by at
 * most log(4) of `smooth`, and derivatives are those of places, differences of which are off by the
 * step's square over that of `smooth`: 1e-5. */
static void test_clearance(void **state)
{
    enum { COUNT = 3 };
    static const float corner[8][3] = {{-9, -9, -9},   {0.05f, -9, -9},  {-9, 9, -9},
                                       {0.05f, 9, -9}, {-9, -9, 0.13f},  {0.05f, -9, 0.13f},
                                       {-9, 9, 0.13f}, {0.05f, 9, 0.13f}};
    static const int triangle[12][3] = {{0, 2, 3}, {0, 3, 1}, {4, 5, 7}, {4, 7, 6},
                                        {0, 1, 5}, {0, 5, 4}, {2, 6, 7}, {2, 7, 3},
                                        {0, 4, 6}, {0, 6, 2}, {1, 3, 7}, {1, 7, 5}};
    static const float box[2][6] = {{0}, {-9, -9, -9, 0.05f, 9, 0.13f}};
    const triangle_tree surface = {8, 12, 0, -1, corner[0], triangle[0], box[0]};
    const double along[4] = {0.03, 0.07, 0.1, 0.13};
    config *settings = read_arm(0, NULL);
    (void)state;
    for (int count = 1; count <= 4; count += 3) {
        observation *places_seen =
            make_observation(&settings->scene, OBSERVATION_POSITION, count, along);
        clearance_observation x = {.places = observation_of(places_seen),
                                   .surface = &surface,
                                   .radius = 0.021,
                                   .smooth = 1e-3};
        double room[12 * (2 + STATES)], states[COUNT * STATES], r[COUNT * 12], by[COUNT * STATES];
        double found[COUNT], y[2];
        assert_true(clearance_observation_room(&x.places) <= sizeof room / sizeof *room);
        x.room = room;
        const one_observation seen = clearance_observation_of(&x);
        random_states(COUNT, states);
        see(places_seen, COUNT, states, r, NULL);
        assert_int_equal(seen.values, 1);
        assert_int_equal(seen.see(seen.context, COUNT, states, NULL, found, by), 0);
        for (int i = 0; i < COUNT; i++) {
            double least = INFINITY;
            for (int k = 0; k < count; k++) {
                const double *const p = &r[3 * (i * count + k)];
                least = fmin(least, fmin((double)0.05f - p[0], (double)0.13f - p[2]));
            }
            assert_true(found[i] <= least - 0.021 + 1e-15);
            assert_true(found[i] >= least - 0.021 - 1e-3 * log(count) - 1e-15);
            for (int c = 0; c < STATES; c++) {
                const double h = 1e-5;
                for (int side = 0; side < 2; side++) {
                    states[i * STATES + c] += side ? 2 * h : -h;
                    seen.see(seen.context, 1, states + i * STATES, NULL, &y[side], NULL);
                }
                states[i * STATES + c] -= h;
                assert_near(by[i * STATES + c], (y[1] - y[0]) / (2 * h), 1e-5);
            }
        }
        states[5] = NAN;
        assert_int_not_equal(seen.see(seen.context, 1, states, NULL, found, NULL), 0);
        observation_free(places_seen);
    }
    config_free(settings);
}

/* ---- an arm that is filtered --------------------------------------------------------------- */

/* Chambers that are inflated one after the other, once in 2 s. */
static void excite(double t, double *inputs)
{
    for (int i = 0; i < 3; i++) {
        inputs[i] = 3 + 3 * cos(3.141592653589793 * t - 2.0943951023931953 * i);
    }
}

/* Sizes of the states of an arm that is excited, rms. */
static void find_sizes(reduced_rod *rod, const double *at_rest, double *size)
{
    double x[STATES], inputs[8] = {0};
    ad_error error;
    memcpy(x, at_rest, sizeof x);
    inputs[3] = 1;
    memset(size, 0, STATES * sizeof *size);
    for (int k = 0; k < 100; k++) {
        excite(0.02 * k, inputs);
        assert_int_equal(reduced_step(rod, 0, 0.02, x, inputs, x, NULL, NULL, &error), AD_OK);
        for (int i = 0; i < STATES; i++) {
            size[i] += x[i] * x[i] / 100;
        }
    }
    for (int i = 0; i < STATES; i++) {
        size[i] = sqrt(size[i]);
    }
}

/* What is seen, in the order of observation_what. */
typedef struct seen_by {
    observation_what what;
    int count, every, delay;
    double noise;
} seen_by;

typedef struct watched {
    observation *filter, *robot; /* of the filter's and the robot's modes */
    double noise[8], values[8][8];
} watched;

static const double markers[2] = {0.13, 0.07};

static void watch(const config *settings, const seen_by *by, watched *x, estimator_sensor *sensor)
{
    x->filter = make_observation(&settings->scene, by->what, by->count, markers);
    x->robot = make_look_of(&settings->scene, finer, by->what, by->count, markers);
    for (int i = 0; i < 8; i++) {
        x->noise[i] = by->noise;
    }
    *sensor = (estimator_sensor){.observation = observation_of(x->filter),
                                 .rotations = by->what == OBSERVATION_ROTATION,
                                 .noise = x->noise,
                                 .every = by->every,
                                 .delay = by->delay,
                                 .depends = observation_depends_on(x->filter)};
}

/* Values of sample k; a rotation is turned about an axis at random. */
static void measure_robot(const seen_by *by, watched *x, const double *state, int k, uint64_t *seed)
{
    double *values = x->values[k % 8];
    see(x->robot, 1, state, values, NULL);
    if (by->what != OBSERVATION_ROTATION) {
        for (int i = 0; i < 3 * by->count; i++) {
            values[i] += by->noise * random_normal(seed);
        }
        return;
    }
    for (int q = 0; q < by->count; q++) {
        double *of = values + 4 * q, w[3], d[4];
        for (int i = 0; i < 3; i++) {
            w[i] = 0.5 * by->noise * random_normal(seed);
        }
        d[0] = -(of[1] * w[0] + of[2] * w[1] + of[3] * w[2]);
        for (int i = 0; i < 3; i++) {
            const int j = (i + 1) % 3, m = (i + 2) % 3;
            d[1 + i] = of[0] * w[i] + of[1 + j] * w[m] - of[1 + m] * w[j];
        }
        for (int i = 0; i < 4; i++) {
            of[i] += d[i];
        }
    }
}

/* Of 3 s, the last one. */
typedef struct followed {
    double stiffness, load; /* off the truth, largest */
    double position;        /* m, rms, of the tip */
    int flags;
    estimator_consistency seen[2];
} followed;

static double distance(const double *a, const double *b)
{
    return sqrt((a[0] - b[0]) * (a[0] - b[0]) + (a[1] - b[1]) * (a[1] - b[1]) +
                (a[2] - b[2]) * (a[2] - b[2]));
}

static void compare(const estimator *x, const double *truth, const double *tips, followed *result)
{
    const double off = fabs(estimator_parameter_now(x, 0) - truth[3]);
    result->stiffness = fmax(result->stiffness, off);
    if (truth[4] != 0) {
        result->load = fmax(result->load, fabs(estimator_parameter_now(x, 1) - truth[4]));
    }
    result->position += distance(tips, tips + 3) * distance(tips, tips + 3) / 50;
}

/* A robot of 30 states, a filter of 18. Inputs are three forces, stiffness, and with two parameters
 * a force at the tip; truth [5] has theirs. */
static followed follow(const config *settings, int parameters, int sensors, const seen_by *by,
                       double *truth)
{
    const estimator_parameter parameter[2] = {{.input = 3, .low = 0.6, .high = 1.4},
                                              {.input = 4, .low = -0.2, .high = 0.2}};
    reduced_rod *rod = make_rod(&settings->scene, modes);
    reduced_rod *robot = make_rod(&settings->scene, finer);
    observation *tip_of[2] = {make_observation(&settings->scene, OBSERVATION_POSITION, 1, &tip),
                              make_look_of(&settings->scene, finer, OBSERVATION_POSITION, 1, &tip)};
    double deviation[STATES], process[STATES], size[STATES], rest[STATES], x[40], tips[6];
    const double inputs[8] = {0, 0, 0, 1};
    watched watching[2];
    estimator_sensor sensor[2];
    followed result = {.flags = 0};
    uint64_t seed = 12;
    ad_error error = {.message = ""};
    assert_int_equal(reduced_inputs(rod), 3 + parameters);
    assert_int_equal(reduced_states(rod), STATES);
    assert_int_equal(reduced_initial(rod, inputs, rest, &error), AD_OK);
    assert_int_equal(reduced_initial(robot, truth, x, &error), AD_OK);
    assert_int_equal(reduced_settle(robot, 0, truth, x, &error), AD_OK);
    find_sizes(rod, rest, size);
    observation_noise(STATES / 2, size, deviation, process);
    for (int i = 0; i < sensors; i++) {
        watch(settings, &by[i], &watching[i], &sensor[i]);
    }
    const estimator_settings given = {.model = reduced_one_step(rod, 0.02),
                                      .parameters = parameters,
                                      .sensors = sensors,
                                      .parameter = parameter,
                                      .sensor = sensor,
                                      .deviation = deviation,
                                      .process = process};
    filter_test f = make_filter(&given);
    assert_int_equal(estimator_start(f.x, rest, inputs, NULL), 0);
    for (int k = 0; k < 150; k++) {
        for (int i = 0; i < sensors; i++) {
            const int taken = k - by[i].delay;
            measure_robot(&by[i], &watching[i], x, k, &seed);
            if (taken >= 0 && taken % by[i].every == 0) {
                estimator_measure(f.x, i, -1, watching[i].values[taken % 8]);
            }
        }
        const int flags = estimator_update(f.x);
        if (k >= 100) {
            see(tip_of[0], 1, estimator_state(f.x), tips, NULL);
            see(tip_of[1], 1, x, tips + 3, NULL);
            compare(f.x, truth, tips, &result);
            result.flags |= flags;
        }
        excite(0.02 * k, truth);
        estimator_predict(f.x, truth, NULL);
        assert_int_equal(reduced_step(robot, 0, 0.02, x, truth, x, NULL, NULL, &error), AD_OK);
    }
    result.position = sqrt(result.position);
    for (int i = 0; i < sensors; i++) {
        result.seen[i] = estimator_sensor_now(f.x, i);
        observation_free(watching[i].filter);
        observation_free(watching[i].robot);
    }
    free(f.memory);
    observation_free(tip_of[0]);
    observation_free(tip_of[1]);
    reduced_free(rod);
    reduced_free(robot);
    return result;
}

/* The stiffness from what is seen. The tip, of which a position is off by 0.35 mm, is found better
 * than that, and a delay of two samples costs little: what happens in between is known. Limits are
 * about twice what is found; what 18 states leave out of 30 moves the bounds of what is consistent,
 * by a fifth. */
static void test_stiffness(void **state)
{
    static const struct {
        seen_by by[2];
        int sensors;
        double stiffness, position;
    } cases[] = {
        {{{OBSERVATION_POSITION, 1, 1, 0, 2e-4}}, 1, 0.008, 1.5e-4},
        {{{OBSERVATION_POSITION, 1, 1, 2, 2e-4}}, 1, 0.008, 1.5e-4},
        {{{OBSERVATION_POSITION, 2, 2, 1, 2e-4}}, 1, 0.008, 2e-4},
        {{{OBSERVATION_ROTATION, 1, 1, 0, 5e-3}}, 1, 0.016, 5e-4},
        {{{OBSERVATION_POSITION, 1, 4, 2, 2e-4}, {OBSERVATION_ANGULAR_VELOCITY, 1, 1, 0, 0.05}},
         2,
         0.014,
         3.5e-4},
        {{{OBSERVATION_CURVATURE, 2, 1, 0, 0.1}}, 1, 0.016, 5e-4},
        {{{OBSERVATION_DIRECTION, 1, 1, 0, 5e-3}, {OBSERVATION_VELOCITY, 1, 1, 0, 5e-3}},
         2,
         0.016,
         5e-4},
    };
    config *settings = read_arm(0, NULL);
    (void)state;
    for (size_t i = 0; i < sizeof cases / sizeof *cases; i++) {
        double truth[8] = {0, 0, 0, 0.8};
        const followed found = follow(settings, 1, cases[i].sensors, cases[i].by, truth);
        assert_true(found.stiffness < cases[i].stiffness);
        assert_true(found.position < cases[i].position);
        for (int k = 0; k < cases[i].sensors; k++) {
            const estimator_consistency *seen = &found.seen[k];
            assert_true(0.8 * seen->low < seen->mean && seen->mean < 1.2 * seen->high);
        }
        assert_int_equal(found.flags & ~ESTIMATOR_INCONSISTENT, 0);
    }
    config_free(settings);
}

/* A force at the tip, 0.08 N at an arm that weighs 1.9 N, is found beside the stiffness. */
static void test_load(void **state)
{
    const char *changes[] = {"parameters.load={range: [-0.2, 0.2]}",
                             "loads.tip.force=[load, 0, 0]"};
    const seen_by by = {OBSERVATION_POSITION, 1, 1, 0, 2e-4};
    config *settings = read_arm(2, changes);
    double truth[8] = {0, 0, 0, 1.2, 0.08};
    (void)state;
    const followed found = follow(settings, 2, 1, &by, truth);
    assert_true(found.stiffness < 0.012);
    assert_true(found.load < 0.008);
    assert_true(found.position < 1.5e-4);
    config_free(settings);
}

/* A start that is moved in time is none that a filter can start from. */
static void test_refusal(void **state)
{
    static const char moved[] =
        "rod: {length: 0.2, section: {shape: circle, radius: 0.01},\n"
        "      material: {youngs_modulus: 1.0e5, poissons_ratio: 0.4, density: 1000}}\n"
        "boundary: {start: {type: driven, position: [0.01*sin(t)^2, 0, 0]}}\n"
        "time: {duration: 1}\n";
    const observation_sensor sensor = {OBSERVATION_POSITION, 1, &tip};
    ad_error error = {.message = ""};
    config *settings = NULL;
    observation *x = NULL;
    (void)state;
    if (prepare_read("moved.yaml", moved, 0, NULL, &settings, &error) != AD_OK) {
        fail_msg("%s", error.message);
    }
    assert_int_equal(observation_create(&settings->scene, modes, &sensor, &x, &error),
                     AD_BAD_INPUT);
    assert_null(x);
    config_free(settings);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_values),      cmocka_unit_test(test_strains),
        cmocka_unit_test(test_derivatives), cmocka_unit_test(test_load),
        cmocka_unit_test(test_refusal),     cmocka_unit_test(test_clearance),
    };
    const struct CMUnitTest alike[] = {cmocka_unit_test(test_stiffness)};
    return run_with_alike(tests, alike, NULL, NULL);
}
