/* The forms of Gauss-Newton's linear model: the same model, the same step. */
#include "allocations.h"
#include "fewer.h"
#include "near.h"
#include "training_testing.h"

#include "tools/train/linear_model.h"

typedef struct solved {
    size_t count;
    double value, *jtr, *diagonal, *step;
} solved;

static train_stage stage_of(train_linear_algebra form)
{
    return (train_stage){.optim.method = OPTIM_GAUSS_NEWTON, .linear_algebra = form};
}

static linear_model *make_model(const made *m, train_linear_algebra form)
{
    const train_stage stage = stage_of(form);
    linear_model_info plan;
    linear_model *model = NULL;
    ad_error error = {AD_OK, ""};
    if (linear_model_plan(m->p, &stage, 0, &plan, &error) != AD_OK ||
        linear_model_create(m->p, &plan, m->e->pool, &model, &error) != AD_OK) {
        fail_msg("%s", error.message);
    }
    assert_int_equal(linear_model_inspect(model).form, form);
    return model;
}

/* Twice linearized and solved with two dampings before the one that counts. */
static solved solve_with(const char *path, const char *const *changes, train_linear_algebra form,
                         bool scaled, int threads)
{
    made m = make_problem(path, changes, threads);
    linear_model *model = make_model(&m, form);
    size_t n = m.e->count;
    solved s = {n, 0, calloc(n, 8), calloc(n, 8), calloc(n, 8)};
    double *scale = calloc(n, 8), largest = 0;
    ad_error error = {AD_OK, ""};
    for (int i = 0; i < 2; i++) {
        if (linear_model_linearize(model, m.e->parameters, &s.value, s.jtr, s.diagonal, &error) !=
            AD_OK) {
            fail_msg("%s", error.message);
        }
        for (size_t k = 0; k < n; k++) {
            largest = fmax(largest, s.diagonal[k]);
        }
        for (size_t k = 0; k < n; k++) {
            scale[k] = scaled ? fmax(s.diagonal[k], 1e-12 * largest) : 1;
        }
        const long before = allocations;
        double unit = scaled ? 1 : largest;
        assert_int_equal(linear_model_solve(model, 1 * unit, scale, s.step), 0);
        assert_int_equal(linear_model_solve(model, 1e-5 * unit, scale, s.step), 0);
        assert_int_equal(allocations, before);
    }
    assert_int_equal(linear_model_inspect(model).factors, 4);
    linear_model_free(model);
    made_free(&m);
    free(scale);
    return s;
}

static void solved_free(solved *s)
{
    free(s->jtr);
    free(s->diagonal);
    free(s->step);
}

static double largest_of(const double *x, size_t count)
{
    double largest = 0;
    for (size_t i = 0; i < count; i++) {
        largest = fmax(largest, fabs(x[i]));
    }
    return largest;
}

static const struct {
    const char *path, *changes[6];
} cases[] = {
    {"configs/elastica_deep.yaml", {"losses.interior.points=20"}},
    {"configs/cantilever_deep.yaml", {"losses.interior.points=30", "network.hidden=[20, 20]"}},
    {"configs/manufactured_dynamic.yaml",
     {"enforcement.boundary=soft", "enforcement.initial=soft", "losses.initial.points=20",
      "losses.boundary.points=20", "losses.interior.points=30"}},
};

static void test_same_step(void **state)
{
    (void)state;
    for (size_t i = 0; i < sizeof cases / sizeof *cases; i++) {
        for (int scaled = 0; scaled < 2; scaled++) {
            const char *path = cases[i].path, *const *changes = cases[i].changes;
            solved a = solve_with(path, changes, TRAIN_NORMAL_EQUATIONS, scaled, 1);
            solved b = solve_with(path, changes, TRAIN_KERNEL, scaled, 1);
            solved c = solve_with(path, changes, TRAIN_KERNEL, scaled, 2);
            double step = largest_of(a.step, a.count);
            double jtr = largest_of(a.jtr, a.count), top = largest_of(a.diagonal, a.count);
            assert_near(a.value, b.value, 1e-12 * a.value);
            for (size_t k = 0; k < a.count; k++) {
                assert_near(a.jtr[k], b.jtr[k], 1e-12 * jtr);
                assert_near(a.diagonal[k], b.diagonal[k], 1e-12 * top);
                /* the largest eigenvalue, at most some hundred times the largest entry of the
                 * diagonal, over the damping: a condition below 1e8, times rounding */
                assert_near(a.step[k], b.step[k], 1e-7 * step);
            }
            assert_true(step > 1e-6);
            assert_memory_equal(b.step, c.step, b.count * sizeof(double));
            solved_free(&a);
            solved_free(&b);
            solved_free(&c);
        }
    }
}

/* Without damping a matrix of deficient rank has no factor; that is said and counted. */
static void test_no_factor(void **state)
{
    (void)state;
    const train_linear_algebra forms[] = {TRAIN_NORMAL_EQUATIONS, TRAIN_KERNEL};
    const char *const few[] = {"losses.interior.points=8", NULL};
    const char *const many[] = {"network.hidden=[3]", NULL};
    for (int i = 0; i < 2; i++) {
        made m = make_problem("configs/elastica_deep.yaml", i == 0 ? few : many, 1);
        linear_model *model = make_model(&m, forms[i]);
        double *scale = calloc(3 * m.e->count, 8), value;
        ad_error error = {AD_OK, ""};
        assert_int_equal(linear_model_linearize(model, m.e->parameters, &value, scale + m.e->count,
                                                scale, &error),
                         AD_OK);
        for (size_t k = 0; k < m.e->count; k++) {
            scale[k] = 1;
        }
        assert_int_not_equal(linear_model_solve(model, -1e-6, scale, scale + 2 * m.e->count), 0);
        assert_int_equal(linear_model_inspect(model).failed, 1);
        m.e->parameters[0] = (double)NAN;
        assert_int_equal(linear_model_linearize(model, m.e->parameters, &value, scale + m.e->count,
                                                scale, &error),
                         AD_NOT_FINITE);
        free(scale);
        linear_model_free(model);
        made_free(&m);
    }
}

static void test_choice(void **state)
{
    (void)state;
    const train_stage stage = stage_of(TRAIN_LINEAR_AUTOMATIC);
    const char *const few[] = {"losses.interior.points=8", NULL};
    const char *const many[] = {"losses.interior.points=500", NULL};
    const struct {
        const char *const *changes;
        train_linear_algebra form;
    } choices[] = {{few, TRAIN_KERNEL}, {many, TRAIN_NORMAL_EQUATIONS}};
    for (int i = 0; i < 2; i++) {
        made m = make_problem("configs/elastica_deep.yaml", choices[i].changes, 1);
        linear_model_info plan;
        ad_error error = {AD_OK, ""};
        char text[160];
        assert_int_equal(linear_model_plan(m.p, &stage, 0, &plan, &error), AD_OK);
        assert_int_equal(plan.form, choices[i].form);
        double n = (double)plan.parameters, rows = (double)plan.rows;
        assert_true(plan.bytes >= 16 * fmin(n, rows) * fmin(n, rows));
        linear_model_describe(&plan, text);
        assert_non_null(strstr(text, train_linear_algebra_names()[plan.form]));
        made_free(&m);
    }
}

static void test_allocations(void **state)
{
    (void)state;
    const char *const changes[] = {"network.hidden=[3]", "losses.interior.points=8", NULL};
    const train_linear_algebra forms[] = {TRAIN_NORMAL_EQUATIONS, TRAIN_KERNEL, TRAIN_MATRIX_FREE};
    made m = make_problem("configs/elastica_deep.yaml", changes, 1);
    for (int i = 0; i < 3; i++) {
        const train_stage stage = stage_of(forms[i]);
        linear_model_info plan;
        linear_model *model = NULL;
        ad_error error = {AD_OK, ""};
        assert_int_equal(linear_model_plan(m.p, &stage, 0, &plan, &error), AD_OK);
        for (long k = 1; !model; k++) {
            assert_true(k < 20);
            allocations = 0;
            failing_allocation = k;
            ad_status status = linear_model_create(m.p, &plan, m.e->pool, &model, &error);
            failing_allocation = 0;
            assert_int_equal(status, model ? AD_OK : AD_NO_MEMORY);
        }
        linear_model_free(model);
    }
    linear_model_free(NULL);
    made_free(&m);
}

int main(void)
{
    const struct CMUnitTest tests[] = {cmocka_unit_test(test_no_factor),
                                       cmocka_unit_test(test_choice),
                                       cmocka_unit_test(test_allocations)};
    const struct CMUnitTest alike[] = {cmocka_unit_test(test_same_step)};
    return run_with_alike(tests, alike, NULL, NULL);
}
