/* Sets of points with data: measured at given places, and targets that follow the network. */
#include "training_testing.h"

enum { POINTS = 24, HIDDEN = 4, STEPS = 7 };

/* ---- sources -----------------------------------------------------------------------------------
 */

static double measured(double x)
{
    return 0.3 + x * x;
}

/* Some of many places, drawn anew every third step. */
static ad_status fill_measured(void *context, const model_draw *draw, ad_error *error)
{
    (void)error;
    int *fills = context;
    (*fills)++;
    assert_null(draw->fields);
    for (size_t i = 0; i < draw->count; i++) {
        draw->x[i] = nn_rng_uniform(draw->rng);
        draw->data[i] = measured(draw->x[i]);
    }
    return AD_OK;
}

static bool follows(const void *context)
{
    (void)context;
    return true;
}

/* Half way from what the network says to cos x; the points are those of the settings. */
static ad_status fill_following(void *context, const model_draw *draw, ad_error *error)
{
    (void)context;
    for (size_t i = 0; i < draw->count; i++) {
        double now = draw->fields ? draw->fields[i] : 0;
        draw->data[i] = 0.5 * (now + cos(draw->x[i]));
    }
    return draw->count > 0 ? AD_OK : ad_fail(error, AD_BAD_INPUT, "no points");
}

static ad_value difference(const void *context, const domain_place *at, const ad_value *fields)
{
    (void)context;
    return ad_sub(fields[0], at->data);
}

/* ---- problems ----------------------------------------------------------------------------------
 */

typedef struct fitted {
    physics_model *m;
    nn_mlp *mlp;
    ad_pool *pool;
    problem *p;
    double *x, *gradient;
    int fills;
} fitted;

/* One set of measured points, one of the interior that follows the network. */
static void fit_make(fitted *f, int threads)
{
    ad_error error = {AD_OK, ""};
    *f = (fitted){.m = model_create(), .pool = ad_pool_create(threads)};
    const model_source given = {.rows = 1,
                                .fill = fill_measured,
                                .context = &f->fills,
                                .points = POINTS,
                                .held_out_points = 8,
                                .draw_every = 3};
    model_add_coordinate(f->m, "x", "", 0, 1, 0);
    model_add_field(f->m, "y", 1);
    int inside = model_add_interior(f->m, "inside");
    model_add_term(f->m, "measured", model_add_given(f->m, "measured", &given), 2, difference,
                   NULL);
    f->m->sets[inside].source =
        (model_source){.rows = 1, .fill = fill_following, .follows = follows};
    model_add_term(f->m, "following", inside, 1, difference, NULL);
    nn_mlp_settings network = nn_mlp_settings_default();
    network.hidden_count = 1;
    network.hidden[0] = HIDDEN;
    nn_rng rng = nn_rng_seed(3);
    problem_settings settings = problem_settings_default();
    settings.interior.points = 10;
    assert_int_equal(nn_mlp_create(&network, &rng, &f->mlp, &error), AD_OK);
    if (problem_create(f->m, f->mlp, &settings, 5, f->pool, &f->p, &error) != AD_OK) {
        fail_msg("%s", error.message);
    }
    f->x = calloc(problem_parameters(f->p), sizeof *f->x);
    f->gradient = calloc(problem_parameters(f->p), sizeof *f->gradient);
    assert_true(f->x && f->gradient);
    nn_mlp_initialize(f->mlp, &rng, f->x);
}

static void fitted_free(fitted *f)
{
    problem_free(f->p);
    nn_mlp_free(f->mlp);
    ad_pool_free(f->pool);
    model_free(f->m);
    free(f->x);
    free(f->gradient);
}

static double fit_loss(fitted *f, bool with_gradient)
{
    double loss;
    assert_int_equal(problem_evaluate(f->p, f->x, &loss, with_gradient ? f->gradient : NULL, NULL),
                     AD_OK);
    return loss;
}

static void descend(fitted *f, int64_t first, int64_t last)
{
    for (int64_t step = first; step <= last; step++) {
        bool changed;
        assert_int_equal(problem_advance(f->p, step, f->x, &changed, NULL), AD_OK);
        assert_true(changed);
        fit_loss(f, true);
        for (size_t i = 0; i < problem_parameters(f->p); i++) {
            f->x[i] -= 0.05 * f->gradient[i];
        }
    }
}

/* ---- tests -------------------------------------------------------------------------------------
 */

/* The loss is that of the data as they are: the gradient does not see that they follow. */
static void test_gradient(void **state)
{
    (void)state;
    fitted f;
    fit_make(&f, 1);
    descend(&f, 1, 2);
    fit_loss(&f, true);
    for (size_t i = 0; i < problem_parameters(f.p); i++) {
        const double at = f.x[i], h = 1e-4;
        f.x[i] = at + h;
        double above = fit_loss(&f, false);
        f.x[i] = at - h;
        double below = fit_loss(&f, false);
        f.x[i] = at;
        /* h^2 f3 / 6 and rounding 1e-16 / h */
        assert_true(fabs((above - below) / (2 * h) - f.gradient[i]) < 1e-7);
    }
    fitted_free(&f);
}

/* Twice the gradient is what Gauss-Newton's rows make of the same data. */
static void test_least_squares(void **state)
{
    (void)state;
    fitted f;
    fit_make(&f, 1);
    descend(&f, 1, 4);
    size_t n = problem_parameters(f.p);
    double loss, *jtj = calloc(n * n, sizeof *jtj), *jtr = calloc(n, sizeof *jtr);
    problem_least_squares info;
    assert_true(jtj && jtr);
    double value = fit_loss(&f, true);
    assert_int_equal(problem_prepare_least_squares(f.p, &info, NULL), AD_OK);
    assert_int_equal(problem_normal_equations(f.p, f.x, &loss, jtj, jtr, NULL), AD_OK);
    assert_true(fabs(loss - value) < 1e-14);
    for (size_t i = 0; i < n; i++) {
        assert_true(fabs(2 * jtr[i] - f.gradient[i]) < 1e-14);
    }
    assert_int_equal(f.fills, 3); /* trained, held out, and before step 4 */
    free(jtj);
    free(jtr);
    fitted_free(&f);
}

static void keep(fitted *to, fitted *from)
{
    problem_array a[PROBLEM_STATE_MAX], b[PROBLEM_STATE_MAX];
    problem_generator ga[PROBLEM_STATE_MAX], gb[PROBLEM_STATE_MAX];
    int generators, count = problem_state(from->p, a, ga, &generators);
    assert_int_equal(problem_state(to->p, b, gb, &generators), count);
    for (int i = 0; i < count; i++) {
        assert_string_equal(a[i].name, b[i].name);
        if (a[i].drawn && a[i].drawn->still) {
            *b[i].drawn = *a[i].drawn;
        } else {
            memcpy(b[i].data, a[i].data, a[i].rows * a[i].columns * sizeof(double));
        }
    }
    for (int i = 0; i < generators; i++) {
        *gb[i].rng = *ga[i].rng;
    }
    memcpy(to->x, from->x, problem_parameters(from->p) * sizeof *to->x);
    assert_int_equal(problem_restored(to->p, NULL), AD_OK);
}

/* What has been kept goes on to the same bits, by any number of threads; held-out data are those of
 * the seed. */
static void test_resume(void **state)
{
    (void)state;
    fitted whole, part, rest;
    double held_out[2];
    fit_make(&whole, 1);
    fit_make(&part, 2);
    fit_make(&rest, 1);
    descend(&whole, 1, STEPS);
    descend(&part, 1, 5);
    keep(&rest, &part);
    descend(&rest, 6, STEPS);
    assert_memory_equal(whole.x, rest.x, problem_parameters(whole.p) * sizeof *whole.x);
    problem_held_out(whole.p, whole.x, &held_out[0], NULL, NULL);
    problem_held_out(rest.p, rest.x, &held_out[1], NULL, NULL);
    assert_true(held_out[0] == held_out[1]);

    problem_array arrays[PROBLEM_STATE_MAX];
    problem_generator generators[PROBLEM_STATE_MAX];
    int count, damaged = 0, all = problem_state(rest.p, arrays, generators, &count);
    for (int i = 0; i < all; i++) {
        if (strcmp(arrays[i].name, "data/measured") == 0) {
            arrays[i].data[1] = NAN;
            damaged++;
        }
    }
    assert_int_equal(damaged, 1);
    assert_int_equal(problem_restored(rest.p, NULL), AD_BAD_INPUT);
    fitted_free(&whole);
    fitted_free(&part);
    fitted_free(&rest);
}

static void test_refused(void **state)
{
    (void)state;
    const model_source none = {.rows = 1, .fill = fill_measured, .points = 0, .held_out_points = 1};
    physics_model *m = model_create();
    model_add_given(m, "measured", &none);
    assert_int_equal(model_check(m, NULL), AD_BAD_ARGUMENT);
    model_free(m);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_gradient),
        cmocka_unit_test(test_least_squares),
        cmocka_unit_test(test_resume),
        cmocka_unit_test(test_refused),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
