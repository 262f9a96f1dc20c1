/* Plays and lags of inputs: a triangular wave by its closed form, in rows and in time, what a loop
 * loses, derivatives, sums, lags by exponentials, and what is refused. */
#include "near.h"

#include "physics/scene/scene_memory.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

enum { ROWS = 81, CYCLE = 32 };

static const double ROUNDING = 1e-14; /* of sums of a few numbers below 1 */

/* Numbered rows of a wave of amplitude 1, from 0 up. */
static double triangle(int row)
{
    const int at = (row + CYCLE / 4) % CYCLE, half = CYCLE / 2;
    return (at < half ? at : CYCLE - at) * 4.0 / CYCLE - 1;
}

/* Of that wave, in the first rise and then: the parallelogram between x - r and x + r. */
static double play_of_triangle(int row, double r)
{
    const double x = triangle(row);
    const bool first = row <= CYCLE / 4, rises = (row + CYCLE / 4) % CYCLE <= CYCLE / 2;
    return first ? fmax(x - r, 0) : rises ? fmax(x - r, r - 1) : fmin(x + r, 1 - r);
}

typedef struct made {
    quantities *names;
    scene open;
} made;

/* A scene whose tip force is a formula of a known pull and unknown r, w. */
static made make(const char *formula, double duration)
{
    static const scene_parameter parameters[] = {
        {"pull", -1, 1, SCENE_LINEAR}, {"r", 0, 0.5, SCENE_LINEAR}, {"w", 0, 1, SCENE_LINEAR}};
    made m = {.names = quantities_create()};
    ad_error error;
    scene_defaults(&m.open);
    for (int i = 0; i < 3 && duration == 0; i++) {
        const scene_parameter *p = &parameters[i];
        assert_int_equal(quantities_parameter(m.names, p->name, p->low, p->high, 0.1, &error),
                         AD_OK);
        m.open.parameters[m.open.parameter_count++] = *p;
    }
    m.open.unknown_count = duration == 0 ? 2 : 0;
    m.open.names = m.names;
    m.open.rod.length = quantity_number(1);
    m.open.duration = quantity_number(duration);
    quantities_know_plays(m.names, true);
    m.open.loads.tip.force[0] = quantity_formula(m.names, formula);
    quantities_know_plays(m.names, false);
    return m;
}

static made make_good(const char *formula, double duration)
{
    made m = make(formula, duration);
    const char *key;
    ad_error error;
    if (quantity_check(m.open.loads.tip.force[0], &error) != AD_OK ||
        scene_remember(&m.open, 0, NULL, &key, &error) != AD_OK) {
        fail_msg("%s", error.message);
    }
    return m;
}

/* The force of each row of the wave. */
static void forces(const made *m, double r, double w, double *parameters, double *slopes,
                   double force[ROWS])
{
    const int count = m->open.parameter_count;
    const char *names[SCENE_PARAMETERS_MAX];
    for (int i = 0; i < count; i++) {
        names[i] = m->open.parameters[i].name;
    }
    for (int row = 0; row < ROWS; row++) {
        parameters[row * count] = triangle(row);
        parameters[row * count + count - 2] = r;
        parameters[row * count + count - 1] = w;
    }
    scene_remember_path(&m->open, ROWS, parameters, slopes);
    for (int row = 0; row < ROWS; row++) {
        force[row] = quantity_value_with(m->open.loads.tip.force[0], 0, 0, count, names,
                                         parameters + row * count);
    }
}

static void test_rows(void **state)
{
    (void)state;
    double parameters[ROWS * 4], force[ROWS], area = 0;
    made m = make_good("play(pull, r)", 0);
    assert_int_equal(m.open.memory_count, 1);
    assert_int_equal(scene_given_count(&m.open), 1);
    forces(&m, 0.2, 0, parameters, NULL, force);
    for (int row = 0; row < ROWS; row++) {
        assert_near(force[row], play_of_triangle(row, 0.2), ROUNDING);
    }
    for (int row = ROWS - 1 - CYCLE; row + 1 < ROWS; row++) { /* one cycle, closed */
        area += (force[row] + force[row + 1]) / 2 * (triangle(row + 1) - triangle(row));
    }
    /* 4 r (1 - r), but for the corners of 2 r between rows, which trapezoids cut off */
    assert_near(-area, 4 * 0.2 * 0.8, 2 * pow(4.0 / CYCLE, 2));
    quantities_free(m.names);
}

/* Derivatives by threshold and weight against central differences, which are exact but for
 * rounding where no row is at a corner. */
static void test_slopes(void **state)
{
    (void)state;
    enum { COUNT = 5 };
    static const double H = 1e-6;
    static double parameters[ROWS * COUNT], slopes[ROWS * 2 * COUNT], other[ROWS * COUNT];
    double force[3][ROWS];
    made m = make_good("play(w*play(pull, r), 0.3*r) + pull", 0);
    assert_int_equal(m.open.parameter_count, COUNT);
    assert_int_equal(m.open.memory_count, 2);
    forces(&m, 0.231, 0.77, parameters, slopes, force[0]);
    for (int u = 3; u < COUNT; u++) {
        for (int side = 0; side < 2; side++) {
            const double by = side ? H : -H;
            forces(&m, 0.231 + (u == 3) * by, 0.77 + (u == 4) * by, side ? other : parameters, NULL,
                   force[1 + side]);
        }
        for (int row = 0; row < ROWS; row++) {
            for (int k = 0; k < 2; k++) {
                const int at = row * COUNT + 1 + k;
                assert_near(slopes[(row * 2 + k) * COUNT + u],
                            (other[at] - parameters[at]) / (2 * H), 1e-9);
            }
        }
    }
    quantities_free(m.names);
}

/* The same wave in time, against rows between which it is straight; and a sum of plays. */
static void test_time(void **state)
{
    (void)state;
    made m = make_good("play(asin(sin(2*pi*t))*2/pi, 0.2) - 0.5*play(asin(sin(2*pi*t))*2/pi, 0.6)",
                       (ROWS - 1.0) / CYCLE);
    assert_int_equal(m.open.memory_count, 0);
    for (int row = 0; row < ROWS; row++) {
        const double t = (double)row / CYCLE;
        const double exact = play_of_triangle(row, 0.2) - 0.5 * play_of_triangle(row, 0.6);
        /* asin loses half of the digits at the turns */
        assert_near(quantity_value(m.open.loads.tip.force[0], 0, t), exact, 1e-7);
    }
    quantities_free(m.names);
}

/* A smooth input: the state keeps what the largest value has left, by the closed form, and a
 * printed scene says play again. */
static void test_smooth(void **state)
{
    (void)state;
    made m = make_good("2*play(exp(-0.3*t)*sin(t), 0.1)", 12);
    const double first = atan2(1, 0.3); /* tan t = 1/0.3 where it turns back */
    const double top = exp(-0.3 * first) * sin(first) - 0.1;
    const quantity force = m.open.loads.tip.force[0];
    assert_near(quantity_value(force, 0, first + 0.2), 2 * top, ROUNDING);
    double z = 0;
    for (int i = 0; i <= 120000; i++) {
        const double t = i * 1e-4, x = exp(-0.3 * t) * sin(t);
        z = fmax(x - 0.1, fmin(x + 0.1, z));
        /* steps miss the top of x by x'' (h/2)^2/2 */
        assert_near(quantity_value(force, 0, t), 2 * z, 1e-8);
    }
    char *text = quantity_text(force, true);
    assert_string_equal(text, "2*play(exp(-0.3*t)*sin(t), 0.1)");
    free(text);
    quantities_free(m.names);
}

/* In motion, of parameters: states from sample to sample. */
static made make_sampled(const char *formula)
{
    made m = make(formula, 0);
    const char *key;
    ad_error error;
    m.open.duration = quantity_number(1);
    if (scene_remember(&m.open, 0, NULL, &key, &error) != AD_OK) {
        fail_msg("%s", error.message);
    }
    return m;
}

/* Lags by their closed forms, of inputs that go linearly from sample to sample: up within the first
 * sample and then held, and rising all the time, from rest. */
static void test_lag(void **state)
{
    enum { COUNT = 5, PULL = 0, LAG = 2, LATE = 4, STEPS = 40 };
    static const double TAU = 0.3, STEP = 0.05;
    (void)state;
    made m = make_sampled("lag(play(pull, r), 0.1 + w)");
    const scene_values values = scene_values_of(&m.open);
    assert_int_equal(m.open.parameter_count, COUNT);
    assert_int_equal(scene_given_count(&m.open), 1);
    for (int rises = 0; rises < 2; rises++) {
        double now[COUNT] = {[LATE] = TAU - 0.1}, after[COUNT];
        const double first = 1 - (1 - exp(-STEP / TAU)) * TAU / STEP;
        scene_memory_start(&m.open, &values, now, 0, NULL);
        for (int i = 1; i <= STEPS; i++) {
            const double t = i * STEP;
            memcpy(after, now, sizeof now);
            after[PULL] = rises ? t / 2 : 1;
            scene_memory_step(&m.open, &values, STEP, now, after, 0, NULL, NULL);
            memcpy(now, after, sizeof now);
            assert_near(now[LAG],
                        rises ? (t - TAU * (1 - exp(-t / TAU))) / 2
                              : 1 - (1 - first) * exp((STEP - t) / TAU),
                        1e-14);
        }
    }
    quantities_free(m.names);
}

/* Derivatives of a step by states before it, threshold and time against differences. */
static void test_sample_slopes(void **state)
{
    enum { COUNT = 5, DIRECTIONS = 4 };
    static const double H = 1e-6, STEP = 0.07;
    static const double at[COUNT] = {-0.2, 0.05, 0.3, 0.2, 0.2}, end[COUNT] = {0.6, 0, 0, 0.2, 0.2};
    static const int moved[DIRECTIONS] = {1, 2, 3, 4};
    double now[COUNT], after[COUNT], sides[2][COUNT];
    double by_now[DIRECTIONS * COUNT] = {0}, by_after[DIRECTIONS * COUNT] = {0};
    (void)state;
    made m = make_sampled("lag(play(pull, r), 0.1 + w)");
    const scene_values values = scene_values_of(&m.open);
    memcpy(after, end, sizeof end);
    for (int i = 0; i < DIRECTIONS; i++) {
        by_now[i * COUNT + moved[i]] = 1;
        by_after[i * COUNT + moved[i]] = i >= 2;
    }
    scene_memory_step(&m.open, &values, STEP, at, after, DIRECTIONS, by_now, by_after);
    assert_near(after[1], 0.4, ROUNDING); /* pushed, by 0.6 less 0.2 */
    for (int i = 0; i < DIRECTIONS; i++) {
        for (int side = 0; side < 2; side++) {
            memcpy(now, at, sizeof at);
            memcpy(sides[side], end, sizeof end);
            now[moved[i]] += side ? H : -H;
            sides[side][moved[i]] = now[moved[i]];
            scene_memory_step(&m.open, &values, STEP, now, sides[side], 0, NULL, NULL);
        }
        for (int k = 1; k <= 2; k++) {
            assert_near(by_after[i * COUNT + k], (sides[1][k] - sides[0][k]) / (2 * H), 1e-8);
        }
    }
    quantities_free(m.names);
}

static void test_numbers(void **state)
{
    (void)state;
    made m = make_good("play(0.5, 0.2) + play(-0.1, 0.2)", 0);
    assert_near(m.open.loads.tip.force[0].number, 0.3, ROUNDING);
    assert_int_equal(m.open.memory_count, 0);
    quantities_free(m.names);
}

static void test_refusals(void **state)
{
    (void)state;
    static const struct {
        const char *formula;
        double duration;
        const char *what;
    } wrong[] = {{"play(pull, -0.1)", 0, "threshold of play is negative"},
                 {"play(pull)", 0, "play takes 2 arguments"},
                 {"play(pull*s, r)", 0, "play along the rod"},
                 {"play(pull, w-0.5)", 0, "may be negative"},
                 {"play(sin(t), 0.1*t)", 1, "changes in time"},
                 {"lag(sin(t), 0.1)", 1, "a lag of a formula of t"},
                 {"lag(pull, w)", 0, "may be 0 or negative"},
                 {"lag(pull, 0)", 0, "time of lag is not positive"},
                 {"play(sin(2000*t), 0.1)", 1, "more than 400 times"}};
    for (size_t i = 0; i < sizeof wrong / sizeof *wrong; i++) {
        made m = make(wrong[i].formula, wrong[i].duration);
        const char *key = "";
        ad_error error = {.message = ""};
        ad_status status = quantity_check(m.open.loads.tip.force[0], &error);
        status = status == AD_OK ? scene_remember(&m.open, 0, NULL, &key, &error) : status;
        assert_int_equal(status, AD_BAD_INPUT);
        assert_non_null(strstr(error.message, wrong[i].what));
        quantities_free(m.names);
    }
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_rows),    cmocka_unit_test(test_slopes),
        cmocka_unit_test(test_time),    cmocka_unit_test(test_smooth),
        cmocka_unit_test(test_lag),     cmocka_unit_test(test_sample_slopes),
        cmocka_unit_test(test_numbers), cmocka_unit_test(test_refusals),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
