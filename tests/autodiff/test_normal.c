/* Normal equations: against rows of the Jacobian taken one by one, against the gradient of a
 * scene's loss, bits for any number of threads. */
#include "training_testing.h"

#include "evaluate.h"
#include "fewer.h"

/* ---- a small model ----------------------------------------------------------------------------
 */

enum { WIDTH = 3, INPUTS = 2, COUNT = WIDTH * INPUTS + 2 * WIDTH + 2, POINTS = 70 };

typedef struct model {
    ad_tape *tape;
    ad_value residuals[3];
    ad_value views[4];
} model;

/* 3 rows of residuals that use the parameters as matrices, as vectors, twice, or not at all. The
 * last parameter but one is in no view, the last in no residual. */
static model make_model(void)
{
    model m = {.tape = ad_tape_create()};
    ad_value s = ad_input(m.tape, "s", 1), t = ad_input(m.tape, "t", 1);
    m.views[0] = ad_parameter(m.tape, "w", WIDTH * INPUTS, 0);
    m.views[1] = ad_parameter(m.tape, "b", WIDTH, WIDTH * INPUTS);
    m.views[2] = ad_parameter(m.tape, "v", WIDTH, WIDTH * INPUTS + WIDTH);
    m.views[3] = ad_parameter(m.tape, "unused", 1, COUNT - 1);
    ad_neg(m.views[3]); /* on the tape, but in no residual */
    ad_value x = ad_stack(2, (ad_value[]){s, t});
    ad_value y = ad_matvec(m.views[2], ad_tanh(ad_add(ad_matvec(m.views[0], x), m.views[1])));
    ad_value last = ad_sub(ad_dot(m.views[1], m.views[2]), ad_row(m.views[0], 2));
    ad_value rows[2] = {ad_add(ad_derivative(y, s, 2), ad_mul(y, ad_derivative(y, t, 1))),
                        ad_add(ad_sub(y, ad_sin(s)), ad_row(m.views[0], 1))};
    m.residuals[0] = ad_stack(2, rows);
    m.residuals[1] = ad_zeros(m.tape, 2);
    m.residuals[2] = last; /* the same at every point */
    return m;
}

static void fill(double *x, size_t count, double seed)
{
    for (size_t i = 0; i < count; i++) {
        x[i] = sin(seed + 1.7 * (double)i);
    }
}

static void test_rows(void **state)
{
    (void)state;
    double points[2][POINTS], x[COUNT], rows[3][COUNT * POINTS], r[3][POINTS];
    fill(points[0], POINTS, 0.1);
    fill(points[1], POINTS, 0.7);
    fill(x, COUNT, 2);
    const double *const inputs[2] = {points[0], points[1]};
    memset(rows, 0, sizeof rows);
    model m = make_model();
    ad_value residuals[3] = {ad_row(m.residuals[0], 0), ad_row(m.residuals[0], 1), m.residuals[2]};
    for (int i = 0; i < 3; i++) {
        ad_value adjoints[4];
        assert_int_equal(ad_reverse(residuals[i], 3, m.views, AD_PER_POINT, adjoints), AD_OK);
        double *to[4] = {rows[i], rows[i] + WIDTH * INPUTS * POINTS,
                         rows[i] + (WIDTH * INPUTS + WIDTH) * POINTS, r[i]};
        adjoints[3] = residuals[i];
        evaluate(4, adjoints, POINTS, inputs, x, to);
    }
    for (int threads = 1; threads <= 2; threads++) {
        ad_pool *pool = ad_pool_create(threads);
        ad_normal *normal = NULL;
        ad_error error = {AD_OK, ""};
        if (ad_normal_compile(3, m.residuals, 4, m.views, COUNT, pool, &normal, &error) != AD_OK) {
            fail_msg("%s", error.message);
        }
        assert_int_equal(ad_normal_inspect(normal, POINTS).rows, 3);
        double jtj[COUNT * COUNT] = {0}, jtr[COUNT] = {0}, rtr = 0;
        ad_run run = {.points = POINTS, .inputs = inputs, .parameters = x};
        assert_int_equal(ad_normal_add(normal, &run, jtj, jtr, &rtr, &error), AD_OK);
        double squares = 0;
        for (int a = 0; a < COUNT; a++) {
            double expected_r = 0;
            for (int b = a; b < COUNT; b++) {
                double expected = 0;
                for (int i = 0; i < 3 * POINTS; i++) {
                    const double *row = rows[i / POINTS] + i % POINTS;
                    expected += row[a * POINTS] * row[b * POINTS];
                    expected_r += a == b ? row[a * POINTS] * r[i / POINTS][i % POINTS] : 0;
                    squares += a + b == 0 ? pow(r[i / POINTS][i % POINTS], 2) : 0;
                }
                /* sums of 210 products of numbers below 100 */
                assert_near(jtj[a * COUNT + b], expected, 1e-10);
            }
            assert_near(jtr[a], expected_r, 1e-10);
        }
        assert_near(rtr, squares, 1e-10);
        assert_true(jtj[0] > 1);
        ad_normal_free(normal);
        ad_pool_free(pool);
    }
    ad_tape_free(m.tape);
}

static void test_refusals(void **state)
{
    (void)state;
    ad_pool *pool = ad_pool_create(1);
    ad_error error = {AD_OK, ""};
    ad_normal *normal;
    model m = make_model();
    ad_value bad = ad_input(m.tape, "no parameter", 1);
    assert_int_equal(ad_normal_compile(3, m.residuals, 1, &bad, COUNT, pool, &normal, &error),
                     AD_BAD_ARGUMENT);
    assert_null(normal);
    assert_int_equal(ad_normal_compile(3, m.residuals, 4, m.views, 5, pool, &normal, &error),
                     AD_BAD_ARGUMENT);
    assert_int_equal(
        ad_normal_compile(1, m.residuals + 1, 4, m.views, COUNT, pool, &normal, &error),
        AD_BAD_ARGUMENT); /* every residual is 0 */
    ad_value sum = ad_mul(ad_row(m.residuals[0], 0), ad_sum_points(ad_row(m.residuals[0], 1)));
    assert_int_equal(ad_normal_compile(1, &sum, 4, m.views, COUNT, pool, &normal, &error),
                     AD_NO_RULE);
    ad_tape_free(m.tape);
    m = make_model();
    ad_value unknown = ad_parameter(m.tape, "typo", 2, WIDTH * INPUTS);
    assert_int_equal(ad_normal_compile(3, m.residuals, 1, &unknown, COUNT, pool, &normal, &error),
                     AD_BAD_ARGUMENT);
    assert_non_null(strstr(error.message, "typo, 2 rows from 6 on"));
    ad_tape_free(m.tape);
    ad_pool_free(pool);
}

/* ---- structural zeros --------------------------------------------------------------------------
 */

/* A linear last layer [OUTPUTS][FEATURES] and biases: residual i depends on a few outputs. */
enum { OUTPUTS = 5, FEATURES = 70, LINEAR = OUTPUTS * (FEATURES + 1), ROWS = 4 };

static const bool occurs[ROWS][OUTPUTS] = {
    {1, 1, 0, 0, 0}, {1, 1, 0, 0, 0}, {0, 0, 1, 0, 1}, {1, 0, 0, 0, 1}};

static void linear_residuals(ad_tape *tape, ad_value views[2], ad_value residuals[ROWS])
{
    double frequencies[FEATURES];
    fill(frequencies, FEATURES, 0.3);
    ad_value s = ad_input(tape, "s", 1);
    ad_value features = ad_sin(ad_mul(ad_constant(tape, FEATURES, frequencies), s));
    views[0] = ad_parameter(tape, "w", OUTPUTS * FEATURES, 0);
    views[1] = ad_parameter(tape, "b", OUTPUTS, OUTPUTS * FEATURES);
    ad_value y = ad_add(ad_matvec(views[0], features), views[1]);
    for (int i = 0; i < ROWS; i++) {
        residuals[i] = s;
        for (int k = 0; k < OUTPUTS; k++) {
            ad_value output = ad_row(y, k);
            ad_value term = ad_add(ad_mul(output, output), ad_derivative(output, s, 1 + i % 2));
            residuals[i] = occurs[i][k] ? ad_add(residuals[i], term) : residuals[i];
        }
    }
}

static int output_of(int column)
{
    return column < OUTPUTS * FEATURES ? column / FEATURES : column - OUTPUTS * FEATURES;
}

static bool any_with(int a, int b)
{
    bool any = false;
    for (int i = 0; i < ROWS; i++) {
        any = any || (occurs[i][a] && occurs[i][b]);
    }
    return any;
}

typedef struct linear_equations {
    double jtj[LINEAR][LINEAR], jtr[LINEAR], rtr;
    double jt[LINEAR][ROWS * POINTS], r[ROWS * POINTS];
} linear_equations;

static const double UNTOUCHED = 7;

static void compute_linear(linear_equations *q, ad_normal_info *info)
{
    double points[POINTS], x[LINEAR];
    const double *const inputs[1] = {points};
    ad_value views[2], residuals[ROWS];
    ad_normal *normal;
    ad_error error = {AD_OK, ""};
    ad_pool *pool = ad_pool_create(2);
    ad_tape *tape = ad_tape_create();
    fill(points, POINTS, 0.1);
    fill(x, LINEAR, 2);
    for (int i = 0; i < LINEAR; i++) {
        x[i] *= 0.1; /* residuals of the order of 1 */
    }
    linear_residuals(tape, views, residuals);
    assert_int_equal(ad_normal_compile(ROWS, residuals, 2, views, LINEAR, pool, &normal, &error),
                     AD_OK);
    *info = ad_normal_inspect(normal, POINTS);
    for (int i = 0; i < LINEAR; i++) {
        for (int k = 0; k < ROWS * POINTS; k++) {
            q->jt[i][k] = NAN;
        }
        for (int k = 0; k < LINEAR; k++) {
            q->jtj[i][k] = UNTOUCHED;
        }
    }
    ad_run run = {.points = POINTS, .inputs = inputs, .parameters = x};
    ad_normal_jacobian(normal, &run, 0, ROWS * POINTS, q->jt[0], q->r);
    assert_int_equal(ad_normal_add(normal, &run, q->jtj[0], q->jtr, &q->rtr, &error), AD_OK);
    ad_normal_free(normal);
    ad_tape_free(tape);
    ad_pool_free(pool);
}

/* Products of weights that no residual has together are not touched, and not counted. */
static void test_structural_zeros(void **state)
{
    (void)state;
    static linear_equations q;
    ad_normal_info info;
    compute_linear(&q, &info);
    for (int a = 0; a < LINEAR; a++) {
        double expected_r = 0;
        for (int b = a; b < LINEAR; b++) {
            double expected = UNTOUCHED;
            for (int k = 0; k < ROWS * POINTS; k++) {
                expected += q.jt[a][k] * q.jt[b][k];
                expected_r += a == b ? q.jt[a][k] * q.r[k] : 0;
            }
            /* sums of 280 products of numbers below 100 */
            assert_near(q.jtj[a][b], expected, 1e-9);
            bool weights = b < OUTPUTS * FEATURES;
            bool met = !weights || any_with(output_of(a), output_of(b));
            assert_true(met || q.jtj[a][b] == UNTOUCHED);
            assert_true(a == b || q.jtj[b][a] == UNTOUCHED);
        }
        assert_near(q.jtr[a], expected_r, 1e-9);
        for (int i = 0; i < ROWS; i++) { /* points of a residual follow each other */
            bool zero = q.jt[a][i * POINTS + 3] == 0;
            assert_true(zero != occurs[i][output_of(a)]);
        }
    }
    /* less than half of what dense rows take, though a basis of 70 fills 72 columns */
    assert_true(info.flops < (size_t)ROWS * LINEAR * (LINEAR + 1) / 2);
}

/* ---- scenes ------------------------------------------------------------------------------------
 */

static const struct scene_case {
    const char *path, *changes[6];
} cases[] = {
    {"configs/elastica_deep.yaml", {"losses.interior.points=200"}},
    {"configs/cantilever_deep.yaml", {"losses.interior.points=300"}},
    {"configs/manufactured_dynamic.yaml",
     {"enforcement.boundary=soft", "enforcement.initial=soft", "losses.initial.points=20"}},
    {"configs/cantilever_deep.yaml",
     {"formulation=displacement", "losses.causal.slices=4", "network.fourier.features=3"}},
    {"configs/helix.yaml", {"network.hidden=[31, 17, 23]"}},
    {"configs/helix.yaml", {"network=null", "losses=null"}},
};

typedef struct equations {
    size_t count;
    double loss, *jtj, *jtr;
} equations;

static equations equations_of(const struct scene_case *c, int threads)
{
    made m = make_problem(c->path, c->changes, threads);
    size_t n = m.e->count;
    equations q = {n, 0, malloc(n * n * sizeof(double)), malloc(n * sizeof(double))};
    double loss, *gradient = malloc(n * sizeof(double)), largest = 0;
    ad_error error = {AD_OK, ""};
    if (problem_normal_equations(m.p, m.e->parameters, &q.loss, q.jtj, q.jtr, &error) != AD_OK ||
        problem_evaluate(m.p, m.e->parameters, &loss, gradient, &error) != AD_OK) {
        fail_msg("%s", error.message);
    }
    for (size_t i = 0; i < n; i++) {
        largest = fmax(largest, fabs(gradient[i]));
    }
    /* two orders of summation over some thousand terms */
    assert_near(q.loss, loss, 1e-12 * loss);
    for (size_t i = 0; i < n; i++) {
        assert_near(2 * q.jtr[i], gradient[i], 1e-12 * largest);
        for (size_t k = 0; k < i; k++) {
            assert_true(q.jtj[i * n + k] == 0);
        }
    }
    free(gradient);
    made_free(&m);
    return q;
}

static void test_scenes(void **state)
{
    (void)state;
    for (size_t i = 0; i < sizeof cases / sizeof *cases; i++) {
        equations one = equations_of(&cases[i], 1), two = equations_of(&cases[i], 2);
        assert_memory_equal(one.jtj, two.jtj, one.count * one.count * sizeof(double));
        assert_memory_equal(one.jtr, two.jtr, one.count * sizeof(double));
        assert_memory_equal(&one.loss, &two.loss, sizeof one.loss);
        free(one.jtj);
        free(one.jtr);
        free(two.jtj);
        free(two.jtr);
    }
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_rows),
        cmocka_unit_test(test_refusals),
        cmocka_unit_test(test_structural_zeros),
    };
    const struct CMUnitTest alike[] = {cmocka_unit_test(test_scenes)};
    return run_with_alike(tests, alike, NULL, NULL);
}
