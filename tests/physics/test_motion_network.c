/* Networks of one motion in the strain form: their normal equations, the same bits after a restore,
 * rods with all that they can have against the classical solver by strain modes, what is known of
 * their error, derivatives of what is seen. */
#include "everything.h"
#include "fewer.h"
#include "trainer_testing.h"

#include "physics/learn/motion_network.h"
#include "physics/solve/solve.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

static const char soft[] = "rod:\n"
                           "  length: 0.6\n"
                           "  section: {shape: circle, radius: 0.03}\n"
                           "  material: {youngs_modulus: 1.0e6, poissons_ratio: 0.5,\n"
                           "             density: 1000}\n"
                           "  damping: {strain: [10, 10, 10], curvature: [0.02, 0.02, 0.02]}\n"
                           "time: {duration: 0.3}\n"
                           "boundary: {start: {type: clamped}}\n"
                           "loads: {gravity: [-9.81, -9.81, 0]}\n";

static const char everything[] = EVERYTHING("p: 200, e: 1", "0.6");

static run begin(const char *text, const char *override)
{
    ad_error error = {.message = ""};
    run r = {.made = {.e = experiment_of("motion.yaml", text, override)}};
    if (experiment_problem(r.made.e, &r.made.p, &error) != AD_OK ||
        trainer_create(r.made.e, r.made.p, NULL, 0, &r.trainer, &error) != AD_OK) {
        fail_msg("%s", error.message);
    }
    return r;
}

/* ---- least squares ------------------------------------------------------------------------- */

/* Where residuals vanish the loss is |J (x - x_0)|^2 but for what is of third order, so that its
 * second difference is that of the normal equations; their right side is half the gradient. */
static void test_normal_equations(void **state)
{
    (void)state;
    const double step = 1e-4;
    ad_error error = {.message = ""};
    run r = begin(soft, "network.modes=[3, 2, 2, 2]");
    problem *p = r.made.p;
    const size_t n = problem_parameters(p);
    double *x = calloc(n * n + 5 * n, sizeof *x), *jtj = x + n, *jtr = jtj + n * n;
    double *gradient = jtr + n, *by = gradient + n, *moved = by + n, loss, other;
    nn_rng rng = nn_rng_seed(3);
    finish(&r);
    memcpy(x, experiment_parameters(r.made.e), n * sizeof *x);
    for (size_t i = 0; i < n; i++) {
        by[i] = nn_rng_normal(&rng);
        moved[i] = x[i] + 0.1 * by[i];
    }
    assert_int_equal(problem_evaluate(p, moved, &loss, gradient, &error), AD_OK);
    assert_int_equal(problem_normal_equations(p, moved, &other, jtj, jtr, &error), AD_OK);
    assert_true(fabs(loss - other) <= 1e-12 * loss);
    double apart = 0, size = 0;
    for (size_t i = 0; i < n; i++) {
        apart = fmax(apart, fabs(gradient[i] - 2 * jtr[i]));
        size = fmax(size, fabs(gradient[i]));
    }
    assert_true(apart <= 1e-11 * size); /* sums in another order */
    assert_int_equal(problem_normal_equations(p, x, &other, jtj, jtr, &error), AD_OK);
    double square = 0, sides[2];
    for (size_t i = 0; i < n; i++) {
        for (size_t k = 0; k < n; k++) {
            square += by[i] * by[k] * jtj[i <= k ? i * n + k : k * n + i];
        }
    }
    for (int side = 0; side < 2; side++) {
        for (size_t i = 0; i < n; i++) {
            moved[i] = x[i] + (side ? step : -step) * by[i];
        }
        assert_int_equal(problem_evaluate(p, moved, &sides[side], NULL, &error), AD_OK);
    }
    const double difference = (sides[0] + sides[1] - 2 * other) / (2 * step * step);
    print_message("J^T J along a direction: %.9e, by differences %.9e\n", square, difference);
    assert_true(fabs(difference - square) <= 1e-6 * square); /* fourth order in the step */
    free(x);
    stop(&r);
}

/* ---- the same bits ------------------------------------------------------------------------- */

static void test_restore(void **state)
{
    (void)state;
    ad_error error = {.message = ""};
    run whole = begin(soft, "network.modes=[4, 2, 2, 2]"),
        half = begin(soft, "network.modes=[4, 2, 2, 2]");
    assert_true(whole.made.e->modes && whole.made.e->scene->windows == 3);
    finish(&whole);
    for (int i = 0; i < 6; i++) { /* within the second window */
        step(&half);
    }
    assert_int_equal(trainer_fit(half.trainer)->at.window, 1);
    /* Of a text there is no file to save: a config from one is written as it is. */
    save(&half, "half.h5");
    stop(&half);
    half = begin(soft, "network.modes=[4, 2, 2, 2]");
    assert_int_equal(restore(&half, in_folder("half.h5"), &error), AD_OK);
    unlink(in_folder("half.h5"));
    finish(&half);
    const size_t numbers = 3 * whole.made.e->count;
    assert_memory_equal(whole.made.e->parameters, half.made.e->parameters,
                        numbers * sizeof(double));
    assert_true(trainer_estimate(whole.trainer) == trainer_estimate(half.trainer));
    stop(&whole);
    stop(&half);
}

/* ---- against the classical solver ---------------------------------------------------------- */

enum { PLACES = 5, TIMES = 4, POINTS = PLACES * TIMES };

static void list_points(const scene *rod_scene, double *s, double *t)
{
    for (int i = 0; i < POINTS; i++) {
        s[i] = scene_length(rod_scene) * (i % PLACES + 1) / PLACES;
        t[i] = scene_duration(rod_scene) * (i / PLACES + 1) / TIMES;
    }
}

/* The largest difference of each kind of columns, over its size, at points of both. */
static void compare(const run *r, const solve_settings *settings, double apart[4])
{
    static const int kinds[MODEL_COLUMNS_MAX] = {0, 0, 0, 0, 0, 0, 0, 1, 1, 1, 1, 1, 1,
                                                 2, 2, 2, 2, 2, 2, 3, 3, 3, 3, 3, 3};
    enum { COLUMNS = 25 };
    ad_error error = {.message = ""};
    const scene *rod_scene = r->made.e->scene;
    const evaluator_model trained = experiment_trained(r->made.e);
    double s[POINTS], t[POINTS], solved[COLUMNS * POINTS], found[COLUMNS * POINTS];
    solve_report report;
    solution *x;
    evaluator *e;
    list_points(rod_scene, s, t);
    if (solution_create(rod_scene, settings, POINTS, t, &x, &report, &error) != AD_OK ||
        solution_evaluate(x, COLUMNS, POINTS, s, t, solved, &error) != AD_OK ||
        evaluator_create(&trained, NULL, &e, &error) != AD_OK ||
        evaluator_evaluate(e, POINTS, s, t, found, &error) != AD_OK) {
        fail_msg("%s", error.message);
    }
    memset(apart, 0, 4 * sizeof *apart);
    for (int c = 0; c < COLUMNS; c++) {
        double most = 0, size = 1e-2;
        for (int i = 0; i < POINTS; i++) {
            most = fmax(most, fabs(solved[c * POINTS + i] - found[c * POINTS + i]));
            size = fmax(size, fabs(solved[c * POINTS + i]));
        }
        apart[kinds[c]] = fmax(apart[kinds[c]], most / size);
    }
    solution_free(x);
    evaluator_free(e);
}

/* The same modes in the same equations, so that only the ways through time differ: least squares of
 * polynomials, and Radau's steps. */
static void test_everything(void **state)
{
    (void)state;
    double apart[4];
    const solve_settings settings = {
        .tolerance = 1e-9, .method = SOLVE_MODES, .modes = {5, 3, 3, 3}};
    run r = begin(everything, "network.modes=[5, 3, 3, 3]");
    finish(&r);
    compare(&r, &settings, apart);
    print_message("everything: pose %.1e, strains %.1e, forces %.1e, rates %.1e\n", apart[0],
                  apart[1], apart[2], apart[3]);
    assert_true(apart[0] < 1e-6 && apart[1] < 1e-5);
    assert_true(apart[2] < 1e-3 && apart[3] < 1e-4); /* have further derivatives */
    stop(&r);
}

/* The full solver writes other equations; the estimate is of what the modes miss. */
static void test_estimate(void **state)
{
    (void)state;
    static const char *const modes[] = {"network.modes=[3, 1, 1, 1]", "network.modes=[6, 2, 4, 4]",
                                        "network.modes=[10, 2, 8, 8]"};
    const double most[] = {2e-2, 1e-3, 2e-5};
    for (int i = 0; i < 3; i++) {
        double apart[4];
        const solve_settings settings = {.tolerance = 1e-7};
        run r = begin(soft, modes[i]);
        finish(&r);
        compare(&r, &settings, apart);
        const double estimate = trainer_estimate(r.trainer);
        print_message("%s: %.1e, estimated %.1e\n", modes[i], apart[0], estimate);
        assert_true(apart[0] < most[i]);
        /* Columns are by their own size, the estimate is of the length and twice the error. */
        assert_true(apart[0] < 2 * estimate && estimate < 10 * apart[0]);
        stop(&r);
    }
}

/* What is begun with is off by 1e-3: that is modes' doing, not time's. */
static void test_tolerance(void **state)
{
    (void)state;
    int modes[4], degree;
    run r = begin(soft, "network.tolerance=1e-4");
    const train_settings *settings = r.made.e->settings;
    assert_true(settings->modes[0] < 6 && !trainer_needs(r.trainer, modes, &degree));
    finish(&r);
    assert_true(trainer_needs(r.trainer, modes, &degree));
    print_message("estimated %.1e, next %d, %d, %d, %d, degree %d\n", trainer_estimate(r.trainer),
                  modes[0], modes[1], modes[2], modes[3], degree);
    for (int i = 0; i < 4; i++) {
        assert_true(modes[i] > settings->modes[i]);
    }
    stop(&r);
    r = begin(soft, "network.tolerance=0.05");
    finish(&r);
    assert_false(trainer_needs(r.trainer, modes, &degree));
    stop(&r);
}

/* ---- what is seen -------------------------------------------------------------------------- */

/* Polynomials through values have derivatives: the velocity, which is a column by itself, and the
 * tangent, which the strains say. */
static void test_derivatives(void **state)
{
    (void)state;
    ad_error error = {.message = ""};
    run r = begin(soft, "network.modes=[10, 2, 6, 6]");
    finish(&r);
    const evaluator_model trained = experiment_trained(r.made.e);
    double s[POINTS], t[POINTS], found[10 * POINTS], worst[2] = {0};
    evaluator *e;
    list_points(r.made.e->scene, s, t);
    if (evaluator_create(&trained, "x_t vx z_s qw qx qy qz v1 v2 v3", &e, &error) != AD_OK ||
        evaluator_evaluate(e, POINTS, s, t, found, &error) != AD_OK) {
        fail_msg("%s", error.message);
    }
    for (int i = 0; i < POINTS; i++) {
        double q[4];
        for (int k = 0; k < 4; k++) {
            q[k] = found[(3 + k) * POINTS + i];
        }
        const double *v = found + 7 * POINTS + i;
        const double along =
            2 * (q[1] * q[3] - q[0] * q[2]) * v[0] + 2 * (q[2] * q[3] + q[0] * q[1]) * v[POINTS] +
            (q[0] * q[0] - q[1] * q[1] - q[2] * q[2] + q[3] * q[3]) * v[2 * POINTS];
        worst[0] = fmax(worst[0], fabs(found[i] - found[POINTS + i]));
        worst[1] = fmax(worst[1], fabs(found[2 * POINTS + i] - along));
    }
    print_message("velocity off by %.1e m/s, tangent by %.1e\n", worst[0], worst[1]);
    assert_true(worst[0] < 1e-6);
    assert_true(worst[1] < 1e-4); /* R v is a polynomial through 8 Gauss points of half the rod */
    evaluator_free(e);
    stop(&r);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_normal_equations),
        cmocka_unit_test(test_restore),
        cmocka_unit_test(test_everything),
        cmocka_unit_test(test_tolerance),
    };
    const struct CMUnitTest alike[] = {cmocka_unit_test(test_estimate),
                                       cmocka_unit_test(test_derivatives)};
    return run_with_alike(tests, alike, make_folder, remove_folder);
}
