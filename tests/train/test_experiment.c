/* An experiment from its settings, and through a checkpoint and back; derivatives of its unknowns
 * by s and t. */
#include "evaluate.h"
#include "temporary_folder.h"
#include "training_testing.h"

#include "physics/learn/derivative_check.h"
#include "tools/train/reference.h"

static const char rod[] = "rod: {length: 2, stiffness: {bending: [1, 1], torsion: 1, "
                          "shear: [100, 100], axial: 100}}\n"
                          "network: {hidden: [6, 5], fourier: {features: 3}}\n"
                          "training: {seed: 5}\n";

static void save(experiment *e)
{
    ad_error error = {.message = ""};
    checkpoint *file = checkpoint_create("test");
    assert_non_null(file);
    train_origin_put(&e->origin, experiment_text_item(e), file);
    experiment_put(e, e->parameters, file);
    if (checkpoint_write(file, &(file_place){.path = at("checkpoint.h5")}, &error) != AD_OK) {
        fail_msg("%s", error.message);
    }
    checkpoint_free(file);
}

static void test_seed(void **state)
{
    (void)state;
    experiment *one = experiment_of("rod.yaml", rod, NULL);
    experiment *same = experiment_of("rod.yaml", rod, NULL);
    experiment *other = experiment_of("rod.yaml", rod, "training.seed=6");
    assert_int_equal(one->count, nn_mlp_parameters(one->mlp));
    assert_memory_equal(one->parameters, same->parameters, one->count * sizeof(double));
    assert_memory_not_equal(one->parameters, other->parameters, one->count * sizeof(double));
    experiment_free(one);
    experiment_free(same);
    experiment_free(other);
}

/* A scene that only shows to be contradictory once it is recorded: the start moves at t = 0, the
 * initial state is at rest. */
static void test_moving_start(void **state)
{
    static const char moving[] =
        "rod: {length: 2, stiffness: {bending: [1, 1], torsion: 1, shear: [9, 9], axial: 9},\n"
        "  inertia: {mass_per_length: 1, rotary: [0.01, 0.01, 0.02]}}\n"
        "time: {duration: 1}\n"
        "boundary: {start: {type: driven, position: [0, 0.1*t, 0], rotation: [1, 0, 0, 0]}}\n";
    (void)state;
    ad_error error = {.message = ""};
    config *settings = NULL;
    assert_int_equal(prepare_read("rod.yaml", moving, 0, NULL, &settings, &error), AD_BAD_INPUT);
    if (!strstr(error.message, "initial.velocity: at t = 0 the velocity differs by 0.1 m/s")) {
        fail_msg("%s", error.message);
    }
}

static void test_round_trip(void **state)
{
    (void)state;
    ad_error error = {.message = ""};
    experiment *e = experiment_of("rod.yaml", rod, NULL);
    experiment *back = NULL, *again = NULL;
    checkpoint *file = NULL;
    size_t count, back_count;
    for (size_t i = 0; i < e->count; i++) {
        e->parameters[i] += 1;
    }
    double *fourier = nn_mlp_fourier(e->mlp, &count);
    fourier[0] = 0.125;
    save(e);
    if (config_experiment_open(directory, 0, NULL, 1, &back, &file, &error) != AD_OK) {
        fail_msg("%s", error.message);
    }
    assert_int_equal(back->count, e->count);
    assert_memory_equal(back->parameters, e->parameters, e->count * sizeof(double));
    const double *back_fourier = nn_mlp_fourier(back->mlp, &back_count);
    assert_int_equal(back_count, count);
    assert_memory_equal(back_fourier, fourier, count * sizeof(double));
    assert_string_equal(back->warning, "");
    char *yaml = train_origin_text(&e->origin), *back_yaml = train_origin_text(&back->origin);
    assert_string_equal(yaml, back_yaml);
    free(yaml);
    free(back_yaml);
    int rank;
    size_t shape[CHECKPOINT_MAX_RANK];
    assert_true(checkpoint_shape(file, "parameters/network/layer1/weight", &rank, shape));
    assert_true(rank == 2 && shape[0] == 5 && shape[1] == 6);
    assert_true(checkpoint_shape(file, "parameters/network/layer1/bias", &rank, shape));
    assert_true(rank == 1 && shape[0] == 5);
    const char *longer = "rod.length=3", *named = "name=other";
    assert_int_equal(
        config_experiment_open(at("checkpoint.h5"), 1, &longer, 1, &again, NULL, &error),
        AD_BAD_INPUT);
    assert_null(again);
    assert_non_null(strstr(error.message, "rod.length"));
    assert_int_equal(
        config_experiment_open(at("checkpoint.h5"), 1, &named, 1, &again, NULL, &error), AD_OK);
    assert_string_equal(again->settings->name, "other");
    experiment_free(again);
    const char *wider = "network.hidden=[6, 7]"; /* no longer the parameters of the file */
    assert_int_equal(
        config_experiment_open(at("checkpoint.h5"), 1, &wider, 1, &again, NULL, &error),
        AD_BAD_INPUT);
    assert_null(again);
    assert_non_null(strstr(error.message, "layer1/weight"));
    checkpoint_free(file);
    experiment_free(back);
    experiment_free(e);
}

/* The scene can be evaluated without the file that it was compared with. */
static void test_lost_reference(void **state)
{
    (void)state;
    char override[600];
    ad_error error = {.message = ""};
    experiment *e, *back = NULL;
    reference *r = NULL;
    FILE *file = fopen(at("reference.csv"), "w");
    assert_non_null(file);
    fputs("s,x,y,z\n0,0,0,0\n", file);
    fclose(file);
    snprintf(override, sizeof override, "reference.file=%s", at("reference.csv"));
    e = experiment_of("rod.yaml", rod, override);
    e->settings->stages[1].stop_error = 0.1; /* nothing to stop at, once the file is gone */
    save(e);
    assert_int_equal(config_experiment_open(at("checkpoint.h5"), 0, NULL, 1, &back, NULL, &error),
                     AD_OK);
    assert_string_equal(back->warning, "");
    experiment_free(back);
    unlink(at("reference.csv"));
    assert_int_equal(config_experiment_open(at("checkpoint.h5"), 0, NULL, 1, &back, NULL, &error),
                     AD_OK);
    assert_non_null(strstr(back->warning, at("reference.csv")));
    assert_int_equal(reference_create(back, &r, &error), AD_OK);
    assert_null(r);
    experiment_free(back);
    const char *wrong = "rod.length=-1"; /* not the file's fault */
    assert_int_equal(config_experiment_open(at("checkpoint.h5"), 1, &wrong, 1, &back, NULL, &error),
                     AD_BAD_INPUT);
    assert_non_null(strstr(error.message, "rod.length"));
    experiment_free(e);
}

/* ---- derivatives by s and t ----------------------------------------------------------------- */

static void test_derivatives(void **state)
{
    static const char *const names[] = {"r_s", "r_ss", "r_tt", "r_st", "q_sst", "N_s", "m_t"};
    (void)state;
    experiment *e = experiment_of("configs/cantilever_deep.yaml", NULL, NULL);
    nn_rng rng = nn_rng_seed(1);
    for (size_t i = 0; i < sizeof names / sizeof *names; i++) {
        derivative_check check;
        ad_error error = {.message = ""};
        if (derivative_check_run(e->model, e->window, experiment_start(e), e->mlp, e->parameters,
                                 names[i], 10, &rng, e->pool, &check, &error) != AD_OK) {
            fail_msg("%s: %s", names[i], error.message);
        }
        /* rounding 1e-16 over a step of 2.5e-4, times some for the third derivative */
        assert_near(check.worst_error, 0, 1e-10);
        assert_true(check.worst_derivative != 0);
    }
    experiment_free(e);
}

/* Thousands of radians over the range: some step of the ladder is short enough. */
static void test_fast_derivatives(void **state)
{
    static const char *const stiff =
        "  stiffness: {shear: [5, 5], axial: 9, bending: [1, 1], torsion: 0.8}\n";
    char driven[600], wound[300];
    const struct {
        const char *path, *text, *override, *name;
    } rows[] = {{"configs/cantilever_deep.yaml", NULL,
                 "network={fourier: {features: 16, frequency: 100, wavenumber: 100}}", "r_tt"},
                {"rod.yaml", driven, "formulation=mixed", "r_tt"},
                {"rod.yaml", wound, NULL, "r_s"}};
    (void)state;
    snprintf(driven, sizeof driven,
             "rod:\n  length: 1\n%s  inertia: {mass_per_length: 1, rotary: [0, 0, 0]}\n"
             "time: {duration: 1}\n"
             "boundary: {start: {type: driven, position: [\"cos(3000*t)\", 0, 0]}}\n",
             stiff);
    snprintf(wound, sizeof wound, "rod:\n  length: 3000\n%s  rest: {curvature: [4, 0, 0]}\n",
             stiff);
    for (size_t i = 0; i < sizeof rows / sizeof *rows; i++) {
        experiment *e = experiment_of(rows[i].path, rows[i].text, rows[i].override);
        nn_rng rng = nn_rng_seed(1);
        derivative_check check;
        ad_error error = {.message = ""};
        if (derivative_check_run(e->model, e->window, experiment_start(e), e->mlp, e->parameters,
                                 rows[i].name, 10, &rng, e->pool, &check, &error) != AD_OK) {
            fail_msg("%s: %s", rows[i].name, error.message);
        }
        /* (0.03)^6/140 of the difference where a step has 0.03 radians; rounding of 12000 radians
         * over such a step is as large */
        assert_near(check.worst_error, 0, 1e-8);
        experiment_free(e);
    }
}

static void test_refused_derivatives(void **state)
{
    static const char *const names[] = {"", "r", "r_", "v_s", "r_ts", "r_sx", "r_t"};
    (void)state;
    experiment *e = experiment_of("configs/elastica_deep.yaml", NULL, NULL);
    nn_rng rng = nn_rng_seed(1);
    derivative_check check;
    for (size_t i = 0; i < sizeof names / sizeof *names; i++) {
        assert_int_equal(derivative_check_run(e->model, e->window, experiment_start(e), e->mlp,
                                              e->parameters, names[i], 10, &rng, e->pool, &check,
                                              NULL),
                         AD_BAD_ARGUMENT);
    }
    e->parameters[0] = INFINITY;
    assert_int_equal(derivative_check_run(e->model, e->window, experiment_start(e), e->mlp,
                                          e->parameters, "r_s", 10, &rng, e->pool, &check, NULL),
                     AD_NOT_FINITE);
    experiment_free(e);
}

int main(void)
{
    const struct CMUnitTest tests[] = {cmocka_unit_test(test_seed),
                                       cmocka_unit_test(test_moving_start),
                                       cmocka_unit_test(test_round_trip),
                                       cmocka_unit_test(test_lost_reference),
                                       cmocka_unit_test(test_derivatives),
                                       cmocka_unit_test(test_fast_derivatives),
                                       cmocka_unit_test(test_refused_derivatives)};
    return cmocka_run_group_tests(tests, make_directory, remove_directory);
}
