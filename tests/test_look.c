/* What sensors see of a reduced rod: against the rod itself, and derivatives against difference
 * quotients; and the stiffness of an arm, found by what is seen of its tip. */
#include "filter_testing.h"

#include "physics/solve/reduced.h"
#include "tools/config/config.h"
#include "tools/control/look.h"
#include "tools/control/reduced_model.h"

static const char arm[] = "configs/robots/soft_arm_control.yaml";
static const int modes[4] = {2, 1, 2, 1};
static const double apart = 1e-4, places[3] = {0.05, 0.05 - 1e-4, 0.05 + 1e-4}, tip = 0.13;

enum { STATES = 18, ALL = 7 };

static config *read_arm(void)
{
    ad_error error = {.message = ""};
    config *settings = NULL;
    if (config_read(arm, NULL, 0, NULL, &settings, &error) != AD_OK) {
        fail_msg("%s", error.message);
    }
    return settings;
}

static look *make_look(const scene *of, look_what what, int count, const double *s)
{
    ad_error error = {.message = ""};
    const look_sensor sensor = {what, count, s};
    look *made = NULL;
    if (look_create(of, modes, &sensor, &made, &error) != AD_OK) {
        fail_msg("%s", error.message);
    }
    return made;
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

static void see(look *x, int count, const double *states, double *values, double *by_state)
{
    const one_look look = look_of(x);
    assert_int_equal(look.see(look.context, count, states, NULL, values, by_state), 0);
}

/* Of many states at once as of each alone, and as the rod says. */
static void test_values(void **state)
{
    enum { COUNT = 11 };
    config *settings = read_arm();
    reduced_rod *rod = make_rod(&settings->scene, modes);
    double states[COUNT * STATES], inputs[4] = {1, 2, 3, 1}, seen[5][COUNT * 4], alone[4];
    ad_error error;
    (void)state;
    random_states(COUNT, states);
    for (int what = 0; what < 5; what++) {
        look *x = make_look(&settings->scene, (look_what)what, 1, &tip);
        const int values = look_of(x).values;
        assert_int_equal(values, what == LOOK_ROTATION ? 4 : 3);
        assert_int_equal(look_depends_on(x), what < LOOK_VELOCITY ? STATES / 2 : STATES);
        see(x, COUNT, states, seen[what], NULL);
        for (int i = 0; i < COUNT; i++) {
            see(x, 1, states + i * STATES, alone, NULL);
            assert_memory_equal(alone, seen[what] + i * values, (size_t)values * sizeof *alone);
        }
        states[5] = NAN; /* a bending */
        assert_int_not_equal(look_of(x).see(look_of(x).context, COUNT, states, NULL, seen[4], NULL),
                             0);
        random_states(COUNT, states);
        look_free(x);
    }
    look *x = make_look(&settings->scene, LOOK_ANGULAR_VELOCITY, 1, &tip);
    see(x, COUNT, states, seen[4], NULL);
    look_free(x);
    for (int i = 0; i < COUNT; i++) {
        reduced_place at;
        assert_int_equal(reduced_output(rod, 0, states + i * STATES, inputs, &at, NULL, &error),
                         AD_OK);
        const double *q = at.rotation;
        const double d3[3] = {2 * (q[1] * q[3] + q[0] * q[2]), 2 * (q[2] * q[3] - q[0] * q[1]),
                              q[0] * q[0] - q[1] * q[1] - q[2] * q[2] + q[3] * q[3]};
        for (int k = 0; k < 4; k++) {
            assert_near(seen[LOOK_ROTATION][4 * i + k], q[k], 1e-14);
        }
        for (int k = 0; k < 3; k++) {
            assert_near(seen[LOOK_POSITION][3 * i + k], at.position[k], 1e-15);
            assert_near(seen[LOOK_DIRECTION][3 * i + k], d3[k], 1e-14);
            assert_near(seen[LOOK_VELOCITY][3 * i + k], at.velocity[k], 1e-14);
            assert_near(seen[LOOK_ANGULAR_VELOCITY][3 * i + k], at.angular_velocity[k], 1e-13);
        }
    }
    reduced_free(rod);
    config_free(settings);
}

/* Curvature and strain are how rotation and position change along the rod: by differences over
 * 0.2 mm, off by 1e-4 of the third derivatives, 1e-8 times 1e4/m^2 of them. */
static void test_strains(void **state)
{
    config *settings = read_arm();
    look *rotation = make_look(&settings->scene, LOOK_ROTATION, 3, places);
    look *position = make_look(&settings->scene, LOOK_POSITION, 3, places);
    look *curvature = make_look(&settings->scene, LOOK_CURVATURE, 1, places);
    look *strain = make_look(&settings->scene, LOOK_STRAIN, 1, places);
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
    look_free(rotation);
    look_free(position);
    look_free(curvature);
    look_free(strain);
    config_free(settings);
}

/* Derivatives are exact but for the turn between points, of order 6: 1e-5 here; difference
 * quotients are off by 1e-7. A velocity is how a position changes with the rates. */
static void test_derivatives(void **state)
{
    enum { COUNT = 3 };
    config *settings = read_arm();
    (void)state;
    for (int what = 0; what < ALL; what++) {
        look *x = make_look(&settings->scene, (look_what)what, 2, (const double[]){0.07, 0.13});
        const int values = look_of(x).values;
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
            assert_true(c < look_depends_on(x) || size == 0);
        }
        look_free(x);
    }
    look *position = make_look(&settings->scene, LOOK_POSITION, 1, &tip);
    look *velocity = make_look(&settings->scene, LOOK_VELOCITY, 1, &tip);
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
    look_free(position);
    look_free(velocity);
    config_free(settings);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_values),
        cmocka_unit_test(test_strains),
        cmocka_unit_test(test_derivatives),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
