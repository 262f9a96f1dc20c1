/* Every method through the one interface: each finds the minimum, and a state is all there is to
 * continue from. */
#include "allocations.h"
#include "optim/optimizer.h"
#include "optim_testing.h"

enum { COUNT = 2, CONTINUED = 20 };

static const double start[COUNT] = {-1.2, 1};

/* ---- Rosenbrock's function as a sum of squares of 10 (x_1 - x_0^2) and 1 - x_0 ---- */

typedef struct squares {
    double j[2][2], r[2];
} squares;

static double residuals(const double *x, double *r)
{
    r[0] = 10 * (x[1] - x[0] * x[0]);
    r[1] = 1 - x[0];
    return r[0] * r[0] + r[1] * r[1];
}

static int evaluate_squares(void *context, const double *x, double *value)
{
    double r[2];
    (void)context;
    *value = residuals(x, r);
    return OPTIM_OBJECTIVE_OK;
}

static int linearize(void *context, const double *x, double *value, double *jtr, double *diagonal)
{
    squares *s = context;
    *value = residuals(x, s->r);
    memcpy(s->j, (double[2][2]){{-20 * x[0], 10}, {-1, 0}}, sizeof s->j);
    for (int i = 0; i < 2; i++) {
        jtr[i] = s->j[0][i] * s->r[0] + s->j[1][i] * s->r[1];
        diagonal[i] = s->j[0][i] * s->j[0][i] + s->j[1][i] * s->j[1][i];
    }
    return OPTIM_OBJECTIVE_OK;
}

/* Cramer's rule. */
static int solve(void *context, double damping, const double *scale, double *step)
{
    const squares *s = context;
    double a[2][2], b[2];
    for (int i = 0; i < 2; i++) {
        b[i] = -(s->j[0][i] * s->r[0] + s->j[1][i] * s->r[1]);
        for (int k = 0; k < 2; k++) {
            a[i][k] = s->j[0][i] * s->j[0][k] + s->j[1][i] * s->j[1][k];
        }
        a[i][i] += damping * scale[i];
    }
    const double determinant = a[0][0] * a[1][1] - a[0][1] * a[1][0];
    step[0] = (b[0] * a[1][1] - b[1] * a[0][1]) / determinant;
    step[1] = (a[0][0] * b[1] - a[1][0] * b[0]) / determinant;
    return !(determinant > 0);
}

static optim_settings settings_for(int method)
{
    optim_settings settings = optim_settings_defaults((optim_method)method);
    static const optim_matrix row = {0, 1, COUNT};
    settings.learning_rate = 0.02;
    settings.matrices = &row;
    settings.matrix_count = 1;
    return settings;
}

static void test_methods(void **state)
{
    (void)state;
    for (int m = 0; m < OPTIM_METHOD_COUNT; m++) {
        problem p = make_problem(rosenbrock, COUNT);
        squares s;
        const optim_linear_model model = {&s, evaluate_squares, linearize, solve, NULL};
        const optim_target target = {objective, &p, &model};
        const optim_settings settings = settings_for(m);
        const char *why = "";
        assert_int_equal(optim_method_of(optim_method_name(m)), m);
        assert_null(optim_settings_check(&settings));
        optim_optimizer *o = optim_create(COUNT, start, &settings, &why);
        assert_non_null(o);
        assert_null(why);
        for (int i = 0; i < 10; i++) {
            assert_int_equal(optim_step(o, &target), OPTIM_RUNNING);
        }
        optim_array from[OPTIM_STATE_CAPACITY], to[OPTIM_STATE_CAPACITY];
        optim_optimizer *other = optim_create(COUNT, start, &settings, NULL);
        const int arrays = optim_state(o, from);
        assert_int_equal(optim_state(other, to), arrays);
        for (int i = 0; i < arrays; i++) {
            memcpy(to[i].data, from[i].data, from[i].count * sizeof(double));
        }
        assert_null(optim_state_check(other));
        for (int i = 0; i < CONTINUED; i++) {
            optim_step(o, &target);
            optim_step(other, &target);
            assert_memory_equal(optim_x(o), optim_x(other), COUNT * sizeof(double));
        }
        for (int i = 0; i < 5000 && optim_step(o, &target) == OPTIM_RUNNING; i++) {
        }
        /* Methods with a rate go round the minimum at a distance of it; the others converge. */
        const double within = optim_method_reads((optim_method)m) & OPTIM_READS_RATE ? 0.02 : 1e-8;
        assert_near(optim_best_x(o)[0], 1, within);
        assert_near(optim_best_x(o)[1], 1, 2 * within);
        const optim_info info = optim_inspect(o);
        assert_true(info.steps > 10 && info.evaluations >= info.steps);
        assert_true(isfinite(info.value) && isfinite(info.gradient_norm) && info.rate > 0);
        assert_true(optim_advice(settings.method)[0] != '\0');
        assert_true(optim_method_about(settings.method)[0] != '\0');
        assert_true(optim_bytes(&settings, COUNT) >= 2 * COUNT * sizeof(double));
        optim_objective_changed(o);
        optim_free(o);
        optim_free(other);
    }
    optim_free(NULL);
    assert_int_equal(optim_method_of("newton"), OPTIM_METHOD_COUNT);
    assert_int_equal(optim_count_max(OPTIM_SSBROYDEN), OPTIM_SSBROYDEN_COUNT_MAX);
}

static void test_refusals(void **state)
{
    (void)state;
    for (int m = 0; m < OPTIM_METHOD_COUNT; m++) {
        optim_settings settings = settings_for(m);
        settings.beta1 = settings.curvature = settings.damping_increase = NAN;
        const char *why = NULL;
        assert_null(optim_create(COUNT, start, &settings, &why));
        assert_string_equal(why, optim_settings_check(&settings));
    }
    optim_settings settings = settings_for(OPTIM_METHOD_COUNT);
    assert_non_null(optim_settings_check(&settings));
    assert_null(optim_create(COUNT, start, &settings, NULL));
}

/* A value beyond a limit, or at one that is open, is refused by the name of its setting; the limit
 * itself is not. Limits of one setting by another are left out. */
static void test_limits(void **state)
{
    (void)state;
    for (int i = 0; i < optim_setting_count; i++) {
        const optim_setting *row = &optim_setting_rows[i];
        for (int end = 0; end < 2; end++) {
            optim_settings settings = optim_settings_defaults(OPTIM_ADAM);
            void *at = (char *)&settings + row->offset;
            const double limit = end ? row->high : row->low;
            const bool open = row->open & (end ? OPTIM_HIGH_OPEN : OPTIM_LOW_OPEN);
            for (int beyond = 0; beyond < 2; beyond++) {
                const double value = limit + beyond * (end ? 1 : -1);
                const char *why;
                if (row->kind == OPTIM_NUMBER) {
                    *(double *)at = value;
                } else if (row->kind == OPTIM_LONG) {
                    *(int64_t *)at = (int64_t)value;
                } else {
                    *(int *)at = (int)value;
                }
                assert_true(optim_setting_value(row, &settings) == value);
                why = optim_settings_check(&settings);
                if (beyond || open || isinf(limit)) {
                    assert_memory_equal(why, row->name, strlen(row->name));
                } else {
                    assert_null(why);
                }
            }
        }
    }
}

/* What a method does not read is left as it would be without; lists of methods by what they read.
 */
static void test_own(void **state)
{
    (void)state;
    optim_settings settings = optim_settings_defaults(OPTIM_ADAM);
    settings.beta1 = 0.5;
    settings.memory = 7;
    settings.gradient_tolerance = 1;
    const optim_settings own = optim_settings_own(&settings);
    assert_near(own.beta1, 0.5, 0);
    assert_int_equal(own.memory, 50);
    assert_near(own.gradient_tolerance, 0, 0);
    char text[80];
    optim_method_list(0, OPTIM_READS_LINES, text, sizeof text);
    assert_memory_equal(text, "lbfgs, ssbroyden", 16);
    optim_method_list(1u << OPTIM_NEEDS_SQUARES, 0, text, sizeof text);
    assert_memory_equal(text, "gauss_newton", 12);
}

static void test_out_of_memory(void **state)
{
    (void)state;
    for (int m = 0; m < OPTIM_METHOD_COUNT; m++) {
        const optim_settings settings = settings_for(m);
        optim_optimizer *o = NULL;
        long fail_at = 0;
        while (!o) {
            const char *why = NULL;
            allocations = 0;
            failing_allocation = ++fail_at;
            allocations_count = true;
            o = optim_create(COUNT, start, &settings, &why);
            allocations_count = false;
            assert_true(o != NULL || (why && strcmp(why, "out of memory") == 0));
        }
        assert_true(fail_at > 2);
        optim_free(o);
    }
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_methods),       cmocka_unit_test(test_refusals),
        cmocka_unit_test(test_limits),        cmocka_unit_test(test_own),
        cmocka_unit_test(test_out_of_memory),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
