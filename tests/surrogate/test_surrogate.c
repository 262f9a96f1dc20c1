/* One-step models: the step's derivatives against difference quotients, also where the robot is
 * straight; a small training that has to beat the linear map, resumed to the same bits and the same
 * for any number of threads; symmetries that are found and that are not; bad input. */
#include "fewer.h"
#include "near.h"
#include "temporary_folder.h"

#include "autodiff/dense.h"
#include "tools/prepare/config_experiment.h"
#include "tools/prepare/config_surrogate.h"
#include "tools/surrogate/growth.h"
#include "tools/surrogate/training.h"
#include "tools/surrogate/training_parts.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

/* Round, with three chambers: turned and mirrored it is the same robot. */
#define ARM(gravity, chambers)                                                                     \
    "parameters: {f1: {range: [0, 8]}, f2: {range: [0, 8]}, f3: {range: [0, 8]},\n"                \
    "  soft: {range: [0.8, 1.2]}}\n"                                                               \
    "rod:\n"                                                                                       \
    "  length: 0.13\n"                                                                             \
    "  section: {shape: circle, radius: 0.021}\n"                                                  \
    "  material: {youngs_modulus: 8.0e4*soft, poissons_ratio: 0.45, density: 1070,\n"              \
    "             relaxation_time: 0.03}\n"                                                        \
    "time: {duration: 1}\n"                                                                        \
    "boundary: {start: {type: clamped}}\n"                                                         \
    "loads: {gravity: " gravity "}\n"                                                              \
    "chambers:\n"                                                                                  \
    "  - {offset: [0.013, 0], area: 1, pressure: f1}\n" chambers
#define THREE                                                                                      \
    "  - {offset: [-0.0065, 0.013*sqrt(3)/2], area: 1, pressure: f2}\n"                            \
    "  - {offset: [-0.0065, -0.013*sqrt(3)/2], area: 1, pressure: f3}\n"
#define SURROGATE WITH("[1, 1, 1, 0]", "4000")
#define WITH(modes, solved)                                                                        \
    "surrogate: {step: 0.02, modes: " modes ", parameters: [soft], solved: " solved "}\n"          \
    "network: {hidden: [10, 10]}\n"                                                                \
    "training: {stages: [{optimizer: ssbroyden, steps: 60}]}\n"                                    \
    "output: {every: 20}\n"

static const char hanging[] = ARM("[0, 0, 9.81]", THREE) SURROGATE;

static config *read_scene(const char *text, const char *override)
{
    ad_error error = {.message = ""};
    config *given = NULL;
    if (prepare_read("arm.yaml", text, override != NULL, &override, &given, &error) != AD_OK) {
        fail_msg("%s", error.message);
    }
    return given;
}

typedef struct trained {
    config *given;
    ad_pool *pool;
    surrogate_training *own;
} trained;

static trained begin(const char *text, const char *override, int threads)
{
    ad_error error = {.message = ""};
    trained x = {.given = read_scene(text, override), .pool = ad_pool_create(threads)};
    if (surrogate_training_create(&x.given->scene, &x.given->surrogate, &x.given->settings, x.pool,
                                  &x.own, &error) != AD_OK) {
        fail_msg("%s", error.message);
    }
    return x;
}

static void train(trained *x, int64_t until)
{
    ad_error error = {.message = ""};
    fit *f = surrogate_training_fit(x->own);
    while (f->state == FIT_RUNNING && f->at.step < until) {
        if (fit_step(f, &error) != AD_OK) {
            fail_msg("%s", error.message);
        }
    }
}

static void end(trained *x)
{
    surrogate_training_free(x->own);
    ad_pool_free(x->pool);
    config_free(x->given);
}

/* ---- the step ------------------------------------------------------------------------------ */

enum { STATES = 2 * (2 + 1 + 1), INPUTS = 4 };

static void advance(const surrogate_step *m, double *work, const double *x, double *next)
{
    assert_int_equal(
        surrogate_step_advance(m, work, 1, m->step, x, x + STATES, NULL, next, NULL, NULL), 0);
}

/* Largest difference of derivatives from difference quotients, by the scales of both. */
static double worst_derivative(const surrogate_step *m, double *work, double *x, double part)
{
    double next[STATES], sides[2][STATES], by_state[STATES * STATES], by_inputs[STATES * INPUTS];
    double worst = 0;
    const double *scale = m->numbers + STATES + INPUTS + STATES; /* behind three centers */
    scale += (1 + 2 * m->slow_count) * (STATES + INPUTS) * STATES;
    assert_int_equal(
        surrogate_step_advance(m, work, 1, m->step, x, x + STATES, NULL, next, by_state, by_inputs),
        0);
    for (int c = 0; c < STATES + INPUTS; c++) {
        const double unit = c < STATES ? fabs(scale[c]) : 1, h = part * unit, was = x[c];
        for (int side = 0; side < 2; side++) {
            x[c] = was + (side ? h : -h);
            advance(m, work, x, sides[side]);
        }
        x[c] = was;
        for (int r = 0; r < STATES; r++) {
            const double by =
                c < STATES ? by_state[r * STATES + c] : by_inputs[r * INPUTS + c - STATES];
            const double quotient = (sides[1][r] - sides[0][r]) / (2 * h);
            worst = fmax(worst, fabs(quotient - by) * unit / fabs(scale[r]));
        }
    }
    return worst;
}

static void test_step(void **state)
{
    (void)state;
    enum { MANY = 21 };
    trained x = begin(hanging, NULL, 1);
    train(&x, 20);
    const surrogate_step *m = surrogate_training_step_of(x.own);
    double *work = calloc(surrogate_step_work(m), sizeof *work);
    double here[STATES + INPUTS], many[MANY * STATES], inputs[MANY * INPUTS], next[MANY * STATES];
    double one[STATES], worst[2] = {0, 0};
    unsigned seed = 3;
    assert_true(m->turns && m->mirrors);
    for (int i = 0; i < MANY; i++) { /* from straight, where the frame is undefined, on */
        const double size = i == 0 ? 0 : i < 4 ? 1e-3 : 1;
        for (int k = 0; k < STATES + INPUTS; k++) {
            seed = seed * 1664525u + 1013904223u;
            const double noise = (double)seed / 4294967296.0 - 0.5;
            here[k] = k < STATES ? m->numbers[k] + size * noise
                                 : m->numbers[k] + size * (k == STATES + 3 ? 0.3 : 4) * noise;
        }
        memcpy(many + i * STATES, here, sizeof *here * STATES);
        memcpy(inputs + i * INPUTS, here + STATES, sizeof *here * INPUTS);
        /* the frame changes within its softness, a thousandth of the usual bending */
        double *to = &worst[i < 4];
        *to = fmax(*to, worst_derivative(m, work, here, i < 4 ? 1e-7 : 1e-6));
    }
    print_message("derivatives: %.1e, near straight %.1e\n", worst[0], worst[1]);
    assert_true(worst[0] < 1e-7);
    assert_true(worst[1] < 1e-6); /* (1e-7 / soft)^2 of the third derivative, and rounding 1e-9 */
    assert_int_equal(
        surrogate_step_advance(m, work, MANY, m->step, many, inputs, NULL, next, NULL, NULL), 0);
    for (int i = 0; i < MANY; i++) { /* many at once: the same bits */
        memcpy(here, many + i * STATES, sizeof one);
        memcpy(here + STATES, inputs + i * INPUTS, INPUTS * sizeof *here);
        advance(m, work, here, one);
        assert_memory_equal(one, next + i * STATES, sizeof one);
    }
    assert_int_not_equal(
        surrogate_step_advance(m, work, 1, 0.5 * m->step, here, inputs, NULL, one, NULL, NULL), 0);
    assert_int_not_equal(
        surrogate_step_advance(m, work, 1, m->step, here, inputs, inputs, one, NULL, NULL), 0);
    here[0] = NAN;
    assert_int_not_equal(
        surrogate_step_advance(m, work, 1, m->step, here, inputs, NULL, one, NULL, NULL), 0);
    assert_true(isinf(surrogate_step_outside(m, here, inputs)));
    free(work);
    end(&x);
}

/* ---- training ------------------------------------------------------------------------------ */

static void save(trained *x, const char *path)
{
    ad_error error = {.message = ""};
    const train_origin origin = config_origin(x->given);
    fit *f = surrogate_training_fit(x->own);
    f->origin = &origin;
    if (fit_save(f, &(file_place){.path = path}, &error) != AD_OK) {
        fail_msg("%s", error.message);
    }
}

/* The network takes most of the linear map's squared errors of rollouts that it has not seen: 60
 * steps of so small a network leave 0.04 to 0.18, by how many of these begin far from rest. */
static void test_training(void **state)
{
    (void)state;
    ad_error error = {.message = ""};
    checkpoint *file = NULL;
    surrogate *loaded = NULL;
    char path[512];
    snprintf(path, sizeof path, "%s", at("checkpoint.h5"));
    trained whole = begin(hanging, NULL, 1), part = begin(hanging, NULL, 2);
    train(&whole, 60);
    train(&part, 33);
    const double stage_seconds = fit_stage_seconds(surrogate_training_fit(part.own));
    save(&part, path);
    end(&part);
    part = begin(hanging, NULL, 2);
    assert_int_equal(checkpoint_open(path, &file, &error), AD_OK);
    if (fit_restore(surrogate_training_fit(part.own), file, &error) != AD_OK) {
        fail_msg("%s", error.message);
    }
    checkpoint_free(file);
    /* what was saved and more: stop.seconds is of the whole stage */
    assert_true(fit_stage_seconds(surrogate_training_fit(part.own)) >= stage_seconds);
    train(&part, 60);
    const fit *info = surrogate_training_fit(whole.own);
    const surrogate_step *a = surrogate_training_step_of(whole.own);
    const surrogate_step *b = surrogate_training_step_of(part.own);
    print_message("of the linear map's: loss %.3f, held out %.3f\n", info->loss, info->held_out);
    assert_true(surrogate_training_fit(whole.own)->state == FIT_OVER &&
                surrogate_training_fit(part.own)->state == FIT_OVER);
    assert_true(info->held_out < 0.35);
    assert_memory_equal(a->numbers, b->numbers, surrogate_step_numbers(a) * sizeof *a->numbers);
    save(&whole, path);
    if (surrogate_load(path, &loaded, &error) != AD_OK) {
        fail_msg("%s", error.message);
    }
    assert_memory_equal(a->numbers, loaded->step.numbers,
                        surrogate_step_numbers(a) * sizeof *a->numbers);
    assert_false(surrogate_is_parameter(loaded, 0));
    assert_true(surrogate_is_parameter(loaded, 3));
    one_step model;
    assert_int_equal(surrogate_one_step(loaded, &model, &error), AD_OK);
    double x[STATES], next[STATES];
    const double u[INPUTS] = {4, 4, 4, 1};
    memcpy(x, a->numbers, sizeof x);
    assert_int_equal(model.advance(model.context, 1, 0.02, x, u, NULL, next, NULL, NULL), 0);
    surrogate_one_step_free(&model);
    surrogate_free(loaded);
    end(&whole);
    end(&part);
}

/* Parts of a step: the state at its begin, the whole step at its end, derivatives between. */
static void check_parts(const one_step *model, const double *state)
{
    const double u[INPUTS] = {4, 3, 4, 1}, by = 1e-4, step = model->step;
    double next[STATES], ends[2][STATES], moved[STATES], A[STATES * STATES], B[STATES * INPUTS];
    assert_int_equal(
        model->advance(model->context, 1, 1e-7 * step, state, u, NULL, next, NULL, NULL), 0);
    for (int j = 0; j < STATES; j++) {
        assert_near(next[j], state[j], 1e-4);
    }
    for (int side = 0; side < 2; side++) {
        assert_int_equal(model->advance(model->context, 1, side ? step : (1 - 1e-7) * step, state,
                                        u, NULL, ends[side], NULL, NULL),
                         0);
    }
    for (int j = 0; j < STATES; j++) {
        assert_near(ends[0][j], ends[1][j], 1e-4);
    }
    assert_int_equal(model->advance(model->context, 1, 0.35 * step, state, u, NULL, next, A, B), 0);
    for (int c = 0; c < STATES; c++) {
        for (int side = 0; side < 2; side++) {
            memcpy(moved, state, sizeof moved);
            moved[c] += side ? by : -by;
            model->advance(model->context, 1, 0.35 * step, moved, u, NULL, ends[side], NULL, NULL);
        }
        for (int r = 0; r < STATES; r++) {
            assert_near(A[r * STATES + c], (ends[1][r] - ends[0][r]) / (2 * by), 1e-3);
        }
    }
    assert_int_equal(
        model->advance(model->context, 1, 1.1 * step, state, u, NULL, next, NULL, NULL) != 0, 1);
}

/* Within a step the curve is the rod's motion, too: from rest under some inputs, by others. Modes
 * are off by so many of their own sizes. */
static double off_within(const surrogate *of, const one_step *model)
{
    const double u[INPUTS] = {4, 4, 4, 1}, other[INPUTS] = {6, 3, 4, 1}, h = 0.4 * model->step;
    double from[STATES], next[STATES], exact[STATES], off = 0, size = 0;
    ad_error error = {.message = ""};
    reduced_rod *rod = NULL;
    assert_int_equal(surrogate_rod(of, 0, NULL, &rod, &error), AD_OK);
    assert_int_equal(reduced_initial(rod, u, from, &error), AD_OK);
    assert_int_equal(reduced_settle(rod, 0, u, from, &error), AD_OK);
    memcpy(exact, from, sizeof exact);
    for (int i = 0; i < 8; i++) {
        assert_int_equal(reduced_step(rod, 0, h / 8, exact, other, exact, NULL, NULL, &error),
                         AD_OK);
    }
    assert_int_equal(model->advance(model->context, 1, h, from, other, NULL, next, NULL, NULL), 0);
    const surrogate_numbers at = surrogate_numbers_of(&of->step, of->numbers);
    for (int k = 0; k < STATES / 2; k++) {
        off = fmax(off, fabs(next[k] - exact[k]) / at.state_scale[k]);
        size = fmax(size, fabs(exact[k] - from[k]) / at.state_scale[k]);
    }
    print_message("within a step: off by %.1e, moved by %.1e\n", off, size);
    reduced_free(rod);
    return off;
}

/* Curves in time: a stage of Adam on batches and one on whole, resumed to the same bits by another
 * number of threads, and what is loaded steps any part of a step. */
static void test_curves(void **state)
{
    (void)state;
    static const char scene[] = ARM(
        "[0, 0, 9.81]",
        THREE) "surrogate: {step: 0.02, modes: [1, 1, 1, 0], parameters: [soft], solved: 1000}\n"
               "network: {hidden: [8, 8]}\n"
               "training: {stages: [{optimizer: adam, steps: 60}, {optimizer: lbfgs, steps: 3}]}\n";
    static const char kind[] = "surrogate.kind=polynomial";
    ad_error error = {.message = ""};
    checkpoint *file = NULL;
    surrogate *loaded[2] = {NULL};
    one_step model;
    char path[2][512];
    snprintf(path[0], sizeof path[0], "%s", at("part.h5"));
    snprintf(path[1], sizeof path[1], "%s", at("whole.h5"));
    trained whole = begin(scene, kind, 1), part = begin(scene, kind, 2);
    train(&whole, 63);
    save(&whole, path[1]);
    train(&part, 33);
    save(&part, path[0]);
    end(&part);
    part = begin(scene, kind, 2);
    assert_int_equal(checkpoint_open(path[0], &file, &error), AD_OK);
    if (fit_restore(surrogate_training_fit(part.own), file, &error) != AD_OK) {
        fail_msg("%s", error.message);
    }
    checkpoint_free(file);
    train(&part, 63);
    save(&part, path[0]);
    const fit *info = surrogate_training_fit(whole.own);
    print_message("%s: held out %.3f\n", kind, info->held_out);
    assert_true(surrogate_training_fit(whole.own)->state == FIT_OVER &&
                surrogate_training_fit(part.own)->state == FIT_OVER);
    assert_true(info->held_out < 1); /* better than the linear map, after so few steps */
    for (int i = 0; i < 2; i++) {
        if (surrogate_load(path[i], &loaded[i], &error) != AD_OK) {
            fail_msg("%s", error.message);
        }
    }
    const size_t count = 3 * surrogate_step_numbers(&loaded[0]->step);
    assert_memory_equal(loaded[0]->numbers, loaded[1]->numbers, count * sizeof *loaded[0]->numbers);
    assert_int_equal(surrogate_one_step(loaded[0], &model, &error), AD_OK);
    assert_true(model.shorter);
    check_parts(&model, loaded[0]->numbers);
    assert_true(off_within(loaded[0], &model) < 0.01);
    surrogate_one_step_free(&model);
    surrogate_free(loaded[0]);
    surrogate_free(loaded[1]);
    end(&whole);
    end(&part);
}

/* ---- symmetry ------------------------------------------------------------------------------ */

static void expect_symmetry(const char *text, bool turns, bool mirrors)
{
    trained x = begin(text, "surrogate.kind=linear", 1);
    const surrogate_step *m = surrogate_training_step_of(x.own);
    print_message("%s\n", surrogate_training_inspect(x.own)->frame);
    assert_int_equal(m->turns, turns);
    assert_int_equal(m->mirrors, mirrors);
    end(&x);
}

static void test_frames(void **state)
{
    (void)state;
    expect_symmetry(hanging, true, true);
    /* across gravity one mirror is left, d1 and d3 its plane */
    expect_symmetry(ARM("[9.81, 0, 0]", THREE) SURROGATE, false, true);
    expect_symmetry(ARM("[4, 7, 0]", THREE) SURROGATE, false, false);
    /* also where stiff modes of shear outweigh it in the rates, so that only their change within
     * a step can tell */
    expect_symmetry(ARM("[9.81, 0, 0]", THREE) WITH("[3, 1, 3, 2]", "1000"), false, true);
    /* unequal chambers bend it even where all have the same pressure; the sum of two is a
     * coordinate beside their pair; what is thicker one way is not round */
    expect_symmetry(ARM("[0, 0, 9.81]", "  - {offset: [0.0, 0.013], area: 1, pressure: f2}\n"
                                        "  - {offset: [-0.009, -0.005], area: 0.7, pressure: f3}\n")
                        SURROGATE,
                    true, true);
    expect_symmetry(ARM("[0, 0, 9.81]", "  - {offset: [0, 0.009], area: 1, pressure: f2 + f3}\n")
                        SURROGATE,
                    true, true);
    expect_symmetry(ARM("[0, 0, 9.81]", THREE "springs: [{at: 0.13, stiffness: [20, 0, 0]}]\n")
                        SURROGATE,
                    false, true);
}

/* Two chambers in a plane, but for rounding: beside the plane, where motions never are and a filter
 * looks, the robot is not far outside, and it has a step. */
static void test_plane(void **state)
{
    (void)state;
    const char *const scene =
        ARM("[9.81, 0, 0]", "  - {offset: [-0.013, 1e-18], area: 1, pressure: f2 + f3}\n")
            SURROGATE;
    const char *const kinds[2] = {NULL, "surrogate.kind=polynomial"};
    for (int kind = 0; kind < FEWER(2); kind++) { /* the other is below */
        ad_error error = {.message = ""};
        surrogate *loaded = NULL;
        one_step model;
        double at_rest[STATES] = {0}, next[STATES];
        const double inputs[INPUTS] = {4, 4, 4, 1};
        trained x = begin(scene, kinds[kind], 1);
        train(&x, 5);
        save(&x, at("plane.h5"));
        assert_int_equal(surrogate_load(at("plane.h5"), &loaded, &error), AD_OK);
        assert_int_equal(surrogate_one_step(loaded, &model, &error), AD_OK);
        for (int k = 0; k < STATES; k++) {
            at_rest[k] = 1e-3;
            assert_true(model.outside(model.context, at_rest, inputs) < 1e6);
            assert_int_equal(model.advance(model.context, 1, model.step, at_rest, inputs, NULL,
                                           next, NULL, NULL),
                             0);
            for (int i = 0; i < STATES; i++) { /* rates are some thousand times as large */
                assert_true(fabs(next[i]) < 1e3);
            }
            at_rest[k] = 0;
        }
        surrogate_one_step_free(&model);
        surrogate_free(loaded);
        end(&x);
    }
}

/* ---- stability ----------------------------------------------------------------------------- */

static void test_growth(void **state)
{
    (void)state;
    /* 1.2 and a half turn, in coordinates that are far from orthogonal */
    const double p = 30, map[9] = {1.2, 1.2 * p, 0, 0, 0, 0.5, 0, -0.5, 0};
    double room[18];
    ad_error error = {.message = ""};
    ad_pool *pool = ad_pool_create(1);
    assert_int_equal(ad_dense_load(&error), AD_OK);
    assert_near(surrogate_growth(pool, 3, map, room), 1.2, 1e-5); /* 20 squares: 30^(2^-20) */
    ad_pool_free(pool);
}

/* Columns of 0.3 m: L^3 rho A g / EI is 4.2 and 21, and they buckle at 7.84. */
#define COLUMN(e)                                                                                  \
    "parameters: {f: {range: [-0.01, 0.01]}}\n"                                                    \
    "rod:\n"                                                                                       \
    "  length: 0.3\n"                                                                              \
    "  section: {shape: circle, radius: 0.01}\n"                                                   \
    "  material: {youngs_modulus: " e ", poissons_ratio: 0.45, density: 1100,\n"                   \
    "             relaxation_time: 0.03}\n"                                                        \
    "time: {duration: 1}\n"                                                                        \
    "boundary: {start: {type: clamped}}\n"                                                         \
    "loads: {gravity: [0, 0, -9.81], tip: {force: [f, 0, 0]}}\n"

static void test_rest(void **state)
{
    (void)state;
    const char *const scenes[2] = {COLUMN("2.8e6"), COLUMN("5.6e5")};
    const double length = 0.3;
    const reduced_settings settings = {.modes = {2, 1, 1, 0}, .count = 1, .s = &length};
    for (int i = 0; i < 2; i++) {
        ad_error error = {.message = ""};
        config *given = read_scene(scenes[i], NULL);
        ad_pool *pool = ad_pool_create(1);
        reduced_rod *rod = NULL;
        double result = NAN;
        assert_int_equal(reduced_create(&given->scene, &settings, &rod, &error), AD_OK);
        assert_int_equal(surrogate_rest_growth(pool, rod, 0.02, &result, &error), AD_OK);
        print_message("a column grows by %g\n", result);
        assert_int_equal(result <= SURROGATE_STABLE, i == 0);
        assert_true(isfinite(result));
        reduced_free(rod);
        ad_pool_free(pool);
        config_free(given);
    }
}

/* ---- bad input ----------------------------------------------------------------------------- */

static void expect_refusal(const char *override, const char *needle)
{
    ad_error error = {.message = ""};
    config *given = NULL;
    assert_int_equal(prepare_read("arm.yaml", hanging, 1, &override, &given, &error), AD_BAD_INPUT);
    if (!strstr(error.message, needle)) {
        fail_msg("%s: %s", override, error.message);
    }
}

static void test_refusals(void **state)
{
    (void)state;
    expect_refusal("surrogate.inputs=[f1, f2]", "surrogate.inputs: do not hold f3");
    expect_refusal("surrogate.inputs=[f1, f2, f4]", "f4 is no parameter with a range");
    expect_refusal("surrogate.inputs=[f1, f2, f2, f3]", "f2 is there twice");
    expect_refusal("surrogate.inputs=[f1, f2, f3, soft]", "soft is among the other list");
    expect_refusal("surrogate.step=0", "surrogate.step");
    expect_refusal("surrogate.step=null", "surrogate.step: is not given");
    expect_refusal("surrogate.kind=flows", "flow, linear");
    expect_refusal("time.duration=null", "time.duration");
    expect_refusal("network.hidden=[]", "network.hidden");
    expect_refusal("training.stages[0].optimizer=gauss_newton", "training.stages[0].optimizer");
    expect_refusal("training.stages[0].stop.error=0.1", "training.stages[0].stop.error");
    expect_refusal("reference=solve", "reference");
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_step),   cmocka_unit_test(test_curves),
        cmocka_unit_test(test_frames), cmocka_unit_test(test_growth),
        cmocka_unit_test(test_rest),   cmocka_unit_test(test_refusals),
    };
    const struct CMUnitTest alike[] = {
        cmocka_unit_test(test_training),
        cmocka_unit_test(test_plane),
    };
    return run_with_alike(tests, alike, make_directory, remove_directory);
}
