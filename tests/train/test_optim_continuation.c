/* Continuation in the load: the order of the parts, the shapes it reaches, and its state in a
 * checkpoint. */
#include "fewer.h"
#include "trainer_testing.h"

#include "optim/continuation.h"

/* ---- the numbers ----------------------------------------------------------------------------- */

static optim_continuation make_path(bool gradual)
{
    optim_continuation path;
    assert_true(optim_continuation_create(&path, 1, gradual));
    return path;
}

static void expect_next(optim_continuation *path, bool is_solved, double *x, double part,
                        double start)
{
    assert_true(optim_continuation_next(path, is_solved, x));
    assert_true(optim_continuation_is_sound(path));
    assert_float_equal(path->part, part, 1e-15);
    assert_float_equal(*x, start, 1e-15);
}

/* Halved when it fails, from the last solution; where two are known, on their straight line. */
static void test_parts(void **state)
{
    (void)state;
    optim_continuation path = make_path(false);
    double x = 9;
    assert_float_equal(path.part, 1, 0);
    expect_next(&path, false, &x, 0.5, 0);
    expect_next(&path, false, &x, 0.25, 0);
    x = 3;
    expect_next(&path, true, &x, 0.5, 6);
    x = 7;
    expect_next(&path, true, &x, 0.75, 11);
    expect_next(&path, false, &x, 0.625, 9);
    x = 8;
    expect_next(&path, true, &x, 0.75, 9);
    x = 10;
    expect_next(&path, true, &x, 0.875, 12);
    x = 12;
    expect_next(&path, true, &x, 1, 14);
    assert_false(optim_continuation_next(&path, true, &x));
    optim_continuation_free(&path);
}

static void test_solved_at_once(void **state)
{
    (void)state;
    optim_continuation path = make_path(false);
    double x = 9;
    assert_false(optim_continuation_next(&path, true, &x));
    assert_float_equal(x, 9, 0);
    optim_continuation_free(&path);
}

/* A rod that has no shape beyond 0.3 of its loads: one last try with all of them, then the end. */
static void test_gives_up(void **state)
{
    (void)state;
    optim_continuation path = make_path(true);
    double x = 0;
    int parts = 1;
    assert_float_equal(path.part, 0.125, 0);
    while (optim_continuation_next(&path, path.part < 0.3, &x)) {
        assert_true(optim_continuation_is_sound(&path));
        assert_true(++parts < 1000);
    }
    assert_float_equal(path.part, 1, 0);
    assert_float_equal(path.reached, 0.3, 2e-3);
    assert_false(optim_continuation_next(&path, false, &x));
    optim_continuation_free(&path);
}

/* ---- training -------------------------------------------------------------------------------- */

#define ROLLUP "configs/cases/rollup_2.yaml"
#define COLUMN "configs/cases/buckled_2.yaml"

/* The small network of other tests does not resolve the shapes. */
#define BY_DEFAULT "network=null", "losses=null"

static const char *const by_default[] = {BY_DEFAULT, NULL};
static const char *const four_turns[] = {BY_DEFAULT, "loads.tip.moment=[0, -8*pi, 0]", NULL};
static const char *const upwards[] = {BY_DEFAULT, "rod.rest.imperfection=[0, 1, 0]", NULL};
static const char *const straight[] = {BY_DEFAULT, "rod.rest.imperfection=[0, 0, 0]", NULL};
static const char *const few_steps[] = {BY_DEFAULT, "loads.tip.moment=[0, -8*pi, 0]",
                                        "training.stages=[{optimizer: gauss_newton, steps: 2}]",
                                        NULL};

static double least_part(const run *r)
{
    const history *h = &trainer_fit(r->trainer)->rows;
    double least = 1;
    for (size_t row = 0; row < h->count; row++) {
        least = fmin(least, history_value(h, row, "load_factor"));
    }
    return least;
}

/* From 0 Gauss-Newton does not find a rod that is wound up four times. */
static void test_rollup(void **state)
{
    (void)state;
    run r = start(ROLLUP, four_turns, 1);
    finish(&r);
    const fit *f = trainer_fit(r.trainer);
    const trainer_info *info = trainer_inspect(r.trainer);
    assert_true(least_part(&r) < 1);
    assert_float_equal(f->at.part, 1, 0);
    assert_true(info->solved);
    assert_true(info->errors.position < 1e-9); /* measured 2e-12 */
    stop(&r);
}

/* The imperfection decides the side, and is gone at the end; without one the rod stays straight,
 * which is not solved, as it is not stable. */
static void test_branches(void **state)
{
    (void)state;
    const struct {
        const char *const *changes;
        double least, most;
    } cases[] = {{by_default, 0, 1e-9}, /* measured 5e-12 */
                 {upwards, 1, 3},       /* the mirror image is twice the deflection away */
                 {straight, 0.5, 2}};
    for (size_t i = 0; i < sizeof cases / sizeof *cases; i++) {
        run r = start(COLUMN, cases[i].changes, 1);
        finish(&r);
        double error = trainer_inspect(r.trainer)->errors.position;
        assert_int_equal(trainer_inspect(r.trainer)->solved, cases[i].changes != straight);
        assert_true(error >= cases[i].least && error < cases[i].most);
        stop(&r);
    }
}

/* A limit of the author's ends the stage as ever. */
static void test_limit(void **state)
{
    (void)state;
    run r = start(ROLLUP, few_steps, 1);
    finish(&r);
    assert_int_equal(trainer_fit(r.trainer)->at.step, 2);
    assert_float_equal(least_part(&r), 1, 0);
    stop(&r);
}

/* A run stopped after every few steps has the same bits at the end. */
static void test_resume(void **state)
{
    (void)state;
    ad_error error = {AD_OK, ""};
    run whole = start(ROLLUP, four_turns, 1), part = start(ROLLUP, four_turns, 2);
    finish(&whole);
    while (trainer_fit(part.trainer)->state == FIT_RUNNING) {
        step(&part);
        if (trainer_fit(part.trainer)->at.step % 8 == 0) {
            save(&part, "loads.h5");
            stop(&part);
            part = start(ROLLUP, four_turns, 2);
            assert_int_equal(restore(&part, in_folder("loads.h5"), &error), AD_OK);
        }
    }
    assert_int_equal(trainer_fit(part.trainer)->at.step, trainer_fit(whole.trainer)->at.step);
    assert_memory_equal(experiment_parameters(part.made.e), experiment_parameters(whole.made.e),
                        whole.made.e->count * sizeof(double));
    stop(&part);
    stop(&whole);
    assert_int_equal(unlink(in_folder("loads.h5")), 0);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_parts), cmocka_unit_test(test_solved_at_once),
        cmocka_unit_test(test_gives_up), cmocka_unit_test(test_branches),
        cmocka_unit_test(test_limit)};
    const struct CMUnitTest alike[] = {cmocka_unit_test(test_resume),
                                       cmocka_unit_test(test_rollup)};
    return run_with_alike(tests, alike, make_folder, remove_folder);
}
