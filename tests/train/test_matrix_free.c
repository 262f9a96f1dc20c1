/* Products with J and J^T J: against each other, against differences, against J^T J itself; and the
 * steps made of them. */
#include "allocations.h"
#include "fewer.h"
#include "training_testing.h"

#include "evaluate.h"
#include "tools/train/linear_model.h"

static void fill(double *x, size_t count, double seed)
{
    for (size_t i = 0; i < count; i++) {
        x[i] = sin(seed + 1.7 * (double)i);
    }
}

static double dot(const double *a, const double *b, size_t count)
{
    double sum = 0;
    for (size_t i = 0; i < count; i++) {
        sum += a[i] * b[i];
    }
    return sum;
}

/* ---- a small model: residuals with derivatives, and one that is the same at every point --------
 */

enum {
    WIDTH = 3,
    INPUTS = 2,
    COUNT = WIDTH * INPUTS + 2 * WIDTH,
    POINTS = 37,
    VIEWS = 3,
    ROWS = 3
};

static const int view_rows[VIEWS] = {WIDTH * INPUTS, WIDTH, WIDTH};

typedef struct model {
    ad_tape *tape;
    ad_value residuals[2], views[VIEWS], along[VIEWS];
} model;

static model make_model(void)
{
    model m = {.tape = ad_tape_create()};
    ad_value s = ad_input(m.tape, "s", 1), t = ad_input(m.tape, "t", 1);
    size_t offset = 0;
    for (int i = 0; i < VIEWS; i++) {
        m.views[i] = ad_parameter(m.tape, "x", view_rows[i], offset);
        m.along[i] = ad_parameter(m.tape, "v", view_rows[i], COUNT + offset);
        offset += (size_t)view_rows[i];
    }
    ad_value x = ad_stack(2, (ad_value[]){s, t});
    ad_value y = ad_matvec(m.views[2], ad_tanh(ad_add(ad_matvec(m.views[0], x), m.views[1])));
    ad_value rows[2] = {ad_add(ad_derivative(y, s, 2), ad_mul(y, ad_derivative(y, t, 1))),
                        ad_sub(y, ad_sin(s))};
    m.residuals[0] = ad_stack(2, rows);
    m.residuals[1] = ad_dot(m.views[1], m.views[2]);
    return m;
}

typedef struct numbers {
    double s[POINTS], t[POINTS], w[ROWS * POINTS];
    double x[2 * COUNT]; /* x, then v */
    const double *inputs[3];
} numbers;

static void make_numbers(numbers *n)
{
    fill(n->s, POINTS, 0.1);
    fill(n->t, POINTS, 0.7);
    fill(n->w, ROWS * POINTS, 5);
    fill(n->x, 2 * COUNT, 2);
    n->inputs[0] = n->s;
    n->inputs[1] = n->t;
    n->inputs[2] = n->w;
}

static void test_adjoint(void **state)
{
    (void)state;
    model m = make_model();
    numbers n;
    make_numbers(&n);
    ad_value values[2 + VIEWS], w = ad_input(m.tape, "w", ROWS);
    ad_value root = ad_dot(ad_stack(2, m.residuals), w);
    assert_int_equal(ad_directional(2, m.residuals, VIEWS, m.views, m.along, values), AD_OK);
    assert_int_equal(ad_reverse(root, VIEWS, m.views, AD_SUMMED, values + 2), AD_OK);
    static double jv[ROWS * POINTS], jtw[VIEWS][WIDTH * INPUTS * POINTS];
    double *results[2 + VIEWS] = {jv, jv + 2 * POINTS, jtw[0], jtw[1], jtw[2]};
    evaluate(2 + VIEWS, values, POINTS, n.inputs, n.x, results);
    double left = dot(n.w, jv, ROWS * POINTS), right = 0;
    const double *v = n.x + COUNT;
    for (int i = 0; i < VIEWS; i++) {
        for (int row = 0; row < view_rows[i]; row++) {
            right += *v++ * jtw[i][row * POINTS];
        }
    }
    assert_true(fabs(left) > 0.1);
    assert_near(left, right, 1e-12 * dot(n.w, n.w, ROWS * POINTS)); /* sums of 111 numbers */
    ad_tape_free(m.tape);
}

static void test_differences(void **state)
{
    (void)state;
    enum { SIDES = 2 };
    const double step = 1e-5;
    model m = make_model();
    numbers n;
    make_numbers(&n);
    ad_value values[2];
    assert_int_equal(ad_directional(2, m.residuals, VIEWS, m.views, m.along, values), AD_OK);
    static double jv[ROWS * POINTS], r[SIDES][ROWS * POINTS];
    evaluate(2, values, POINTS, n.inputs, n.x, (double *[]){jv, jv + 2 * POINTS});
    for (int side = 0; side < SIDES; side++) {
        double x[COUNT];
        for (int i = 0; i < COUNT; i++) {
            x[i] = n.x[i] + (side ? step : -step) * n.x[COUNT + i];
        }
        evaluate(2, m.residuals, POINTS, n.inputs, x, (double *[]){r[side], r[side] + 2 * POINTS});
    }
    for (int i = 0; i < ROWS * POINTS; i++) {
        /* step^2 times a third derivative of some tens, and rounding over step */
        assert_near(jv[i], (r[1][i] - r[0][i]) / (2 * step), 1e-8);
    }
    ad_tape_free(m.tape);
}

/* The product of the tape against J^T J summed without it. */
static void test_small_product(void **state)
{
    (void)state;
    model m = make_model();
    numbers n;
    make_numbers(&n);
    ad_value products[VIEWS];
    assert_int_equal(ad_normal_product(2, m.residuals, VIEWS, m.views, m.along, products), AD_OK);
    static double found[VIEWS][WIDTH * INPUTS * POINTS];
    evaluate(VIEWS, products, POINTS, n.inputs, n.x, (double *[]){found[0], found[1], found[2]});
    ad_pool *pool = ad_pool_create(1);
    ad_normal *normal = NULL;
    ad_error error = {AD_OK, ""};
    assert_int_equal(
        ad_normal_compile(2, m.residuals, VIEWS, m.views, COUNT, pool, &normal, &error), AD_OK);
    double jtj[COUNT * COUNT] = {0}, jtr[COUNT] = {0}, rtr = 0;
    ad_run run = {.points = POINTS, .inputs = n.inputs, .parameters = n.x};
    assert_int_equal(ad_normal_add(normal, &run, jtj, jtr, &rtr, &error), AD_OK);
    for (int a = 0, i = 0, row = 0; a < COUNT; a++) {
        double expected = 0;
        for (int b = 0; b < COUNT; b++) {
            expected += (a <= b ? jtj[a * COUNT + b] : jtj[b * COUNT + a]) * n.x[COUNT + b];
        }
        assert_near(found[i][row * POINTS], expected, 1e-10); /* sums of 111 below 100 */
        row = row + 1 < view_rows[i] ? row + 1 : 0;
        i += row == 0;
    }
    assert_true(jtj[0] > 1);
    ad_normal_free(normal);
    ad_pool_free(pool);
    ad_tape_free(m.tape);
}

static void test_refusals(void **state)
{
    (void)state;
    for (int i = 0; i < 3; i++) {
        model m = make_model();
        ad_value out[VIEWS], wrong[VIEWS] = {m.along[0], m.along[1], m.along[2]};
        ad_value result = ad_tanh(m.views[1]);
        wrong[0] = i == 0 ? m.along[1] : result;
        ad_status status = i == 0   ? ad_directional(2, m.residuals, VIEWS, m.views, wrong, out)
                           : i == 1 ? ad_directional(2, m.residuals, VIEWS, wrong, m.along, out)
                                    : ad_normal_product(2, m.residuals, VIEWS, wrong, m.along, out);
        assert_int_equal(status, i == 0 ? AD_BAD_SHAPE : AD_BAD_ARGUMENT);
        assert_false(ad_is_valid(out[0]));
        assert_int_equal(ad_tape_status(m.tape, NULL), status);
        ad_tape_free(m.tape);
    }
}

/* ---- scenes ------------------------------------------------------------------------------------
 */

static const struct {
    const char *path, *changes[6];
} cases[] = {
    {"configs/elastica_deep.yaml", {"losses.interior.points=50"}},
    {"configs/cantilever_deep.yaml",
     {"losses.interior.points=60", "network.hidden=[20, 20]", "losses.causal.slices=4"}},
    {"configs/manufactured_dynamic.yaml",
     {"enforcement.boundary=soft", "enforcement.initial=soft", "losses.initial.points=20",
      "losses.boundary.points=20", "losses.interior.points=30"}},
};

enum { CASES = sizeof cases / sizeof *cases };

/* y = (J^T J + damping) x from its upper triangle. */
static void multiply(const double *jtj, size_t n, double damping, const double *x, double *y)
{
    for (size_t i = 0; i < n; i++) {
        y[i] = damping * x[i];
        for (size_t k = 0; k < n; k++) {
            y[i] += (i <= k ? jtj[i * n + k] : jtj[k * n + i]) * x[k];
        }
    }
}

static void test_products(void **state)
{
    (void)state;
    for (int i = 0; i < CASES; i++) {
        double *of_one = NULL;
        for (int threads = 1; threads <= 2; threads++) {
            made m = make_problem(cases[i].path, cases[i].changes, threads);
            size_t n = m.e->count;
            double *jtj = calloc(n, n * 8), *jtr = calloc(n, 8), *v = calloc(n, 8), loss;
            double *found = calloc(n, 8), *expected = calloc(n, 8), largest = 0;
            ad_error error = {AD_OK, ""};
            fill(v, n, 3);
            const double *x = m.e->parameters;
            assert_int_equal(problem_normal_equations(m.p, x, &loss, jtj, jtr, &error), AD_OK);
            assert_int_equal(problem_normal_product(m.p, x, v, found, &error), AD_OK);
            const long before = allocations;
            assert_int_equal(problem_normal_product(m.p, x, v, found, &error), AD_OK);
            assert_int_equal(allocations, before);
            multiply(jtj, n, 0, v, expected);
            for (size_t k = 0; k < n; k++) {
                largest = fmax(largest, fabs(expected[k]));
            }
            for (size_t k = 0; k < n; k++) {
                assert_near(found[k], expected[k], 1e-12 * largest); /* two orders of summation */
            }
            assert_true(largest > 1e-3);
            if (of_one) {
                assert_memory_equal(found, of_one, n * 8);
            }
            free(of_one);
            of_one = found;
            v[0] = (double)NAN;
            assert_int_equal(problem_normal_product(m.p, x, v, expected, &error), AD_NOT_FINITE);
            free(jtj);
            free(jtr);
            free(v);
            free(expected);
            made_free(&m);
        }
        free(of_one);
    }
}

/* ---- steps -------------------------------------------------------------------------------------
 */

typedef struct solved {
    size_t count;
    double value, damping, *jtr, *diagonal, *scale, *step;
    int64_t iterations;
} solved;

/* damping: 0 for 1e-4 of the largest entry of the diagonal. */
static solved solve_with(made *m, train_linear_algebra form, double damping)
{
    const train_stage stage = {.optim.method = OPTIM_GAUSS_NEWTON, .linear_algebra = form};
    linear_model_info plan;
    linear_model *model = NULL;
    ad_error error = {AD_OK, ""};
    size_t n = m->e->count;
    solved s = {n, 0, damping, calloc(n, 8), calloc(n, 8), calloc(n, 8), calloc(n, 8), 0};
    assert_int_equal(linear_model_plan(m->p, &stage, 0, &plan, &error), AD_OK);
    assert_int_equal(linear_model_create(m->p, &plan, m->e->pool, &model, &error), AD_OK);
    for (int twice = 0; twice < 2; twice++) {
        const long before = allocations;
        assert_int_equal(
            linear_model_linearize(model, m->e->parameters, &s.value, s.jtr, s.diagonal, &error),
            AD_OK);
        for (size_t k = 0; k < n; k++) {
            s.damping = damping > 0 ? damping : fmax(s.damping, 1e-4 * s.diagonal[k]);
            s.scale[k] = 1;
        }
        assert_int_equal(linear_model_solve(model, s.damping, s.scale, s.step), 0);
        assert_true(twice == 0 || allocations == before);
    }
    assert_int_equal(linear_model_inspect(model).form, form);
    s.iterations = linear_model_inspect(model).iterations;
    linear_model_free(model);
    return s;
}

static void solved_free(solved *s)
{
    free(s->jtr);
    free(s->diagonal);
    free(s->scale);
    free(s->step);
}

static void test_same_step(void **state)
{
    (void)state;
    for (int i = 0; i < CASES; i++) {
        made m = make_problem(cases[i].path, cases[i].changes, 1);
        made two = make_problem(cases[i].path, cases[i].changes, 2);
        solved a = solve_with(&m, TRAIN_NORMAL_EQUATIONS, 0);
        solved b = solve_with(&m, TRAIN_MATRIX_FREE, a.damping);
        solved c = solve_with(&two, TRAIN_MATRIX_FREE, a.damping);
        size_t n = a.count;
        double *jtj = calloc(n, n * 8), *jtr = calloc(n, 8), *image = calloc(n, 8), loss;
        double *miss = calloc(n, 8), top_a = 0, top_b = 0;
        ad_error error = {AD_OK, ""};
        assert_int_equal(problem_normal_equations(m.p, m.e->parameters, &loss, jtj, jtr, &error),
                         AD_OK);
        multiply(jtj, n, a.damping, a.step, image);
        const double energy = dot(a.step, image, n);
        for (size_t k = 0; k < n; k++) {
            miss[k] = b.step[k] - a.step[k];
            top_a = fmax(top_a, a.diagonal[k]);
            top_b = fmax(top_b, b.diagonal[k]);
        }
        multiply(jtj, n, a.damping, miss, image);
        /* in the norm of the matrix: the tolerance times the root of the condition that is left,
         * here below 30 */
        const double tolerance = 30 * LINEAR_MODEL_TOLERANCE;
        assert_true(energy > 0 && dot(miss, image, n) < tolerance * tolerance * energy);
        assert_near(a.value, b.value, 1e-12 * a.value);
        for (size_t k = 0; k < n; k++) {
            assert_near(a.jtr[k], b.jtr[k], 1e-12 * sqrt(dot(a.jtr, a.jtr, n)));
        }
        /* the diagonal that a low rank shows lies below, and its top does not depend on the rest */
        assert_true(top_b < (1 + 1e-9) * top_a && top_b > 0.9 * top_a);
        assert_true(b.iterations > 0 && b.iterations < 2 * 200);
        assert_memory_equal(b.step, c.step, n * 8);
        free(jtj);
        free(jtr);
        free(image);
        free(miss);
        solved_free(&a);
        solved_free(&b);
        solved_free(&c);
        made_free(&m);
        made_free(&two);
    }
}

static void test_choice(void **state)
{
    (void)state;
    const char *const large[] = {"network.hidden=[120, 120]", "losses.interior.points=2500", NULL};
    made m = make_problem("configs/elastica_deep.yaml", large, 1);
    train_stage stage = {.optim.method = OPTIM_GAUSS_NEWTON};
    linear_model_info plan;
    ad_error error = {AD_OK, ""};
    char text[160];
    assert_int_equal(linear_model_plan(m.p, &stage, 0, &plan, &error), AD_OK);
    assert_int_equal(plan.form, TRAIN_MATRIX_FREE);
    assert_true(plan.parameters > 10000 && plan.rows > 10000);
    assert_true(plan.bytes > 8e2 * (double)plan.parameters && plan.bytes < 1e8);
    linear_model_describe(&plan, text);
    assert_memory_equal(text, "matrix_free for ", 16);
    static const struct {
        train_linear_algebra form;
        const char *begin, *advice;
    } refused[] = {
        {TRAIN_LINEAR_AUTOMATIC, "training.stages[3].optimizer: gauss_newton by ",
         "or take scaling identity with linear_algebra matrix_free"},
        {TRAIN_MATRIX_FREE, "training.stages[3].linear_algebra: matrix_free has no diagonal",
         "allowed with it: scaling identity"},
    };
    stage.optim.scaling = OPTIM_SCALING_DIAGONAL;
    for (int i = 0; i < 2; i++) {
        stage.linear_algebra = refused[i].form;
        assert_int_equal(linear_model_plan(m.p, &stage, 3, &plan, &error), AD_BAD_INPUT);
        assert_memory_equal(error.message, refused[i].begin, strlen(refused[i].begin));
        assert_non_null(strstr(error.message, refused[i].advice));
    }
    made_free(&m);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_adjoint),       cmocka_unit_test(test_differences),
        cmocka_unit_test(test_small_product), cmocka_unit_test(test_refusals),
        cmocka_unit_test(test_products),      cmocka_unit_test(test_choice)};
    const struct CMUnitTest alike[] = {cmocka_unit_test(test_same_step)};
    return run_with_alike(tests, alike, NULL, NULL);
}
