/* How a rod is seen by what measures it: a marker beside the axis, the frame of the cameras and a
 * delay are found as unknowns, within their deviations, from measurements that are made here by
 * their definition; what is no such thing is refused. */
#include "temporary_folder.h"
#include "training_testing.h"

#include "nn/rng.h"
#include "physics/numerics/quaternion.h"
#include "physics/solve/solve.h"
#include "tools/prepare/config_experiment.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

enum { MARKER, POSITION = 2, TURN = 5, BENDING = 8, UNKNOWNS };

static const double truth[UNKNOWNS] = {0.012, -0.007, 0.4, -0.2, 1.1, 0.3, -1.2, 0.8, 3.1e-3};
static const double NOISE = 2e-4;
static char path[100];

static int make_file(void **state)
{
    const int made = make_directory(state);
    snprintf(path, sizeof path, "%s", at("seen.csv"));
    return made;
}

#define ROD                                                                                        \
    "rod: {model: kirchhoff, length: 0.2, stiffness: {bending: [bending, bending], torsion: "      \
    "2.0e-3}, rest: {curvature: [0, 8, 0]}}\n"                                                     \
    "loads: {tip: {force: [pull*cos(turned), pull*sin(turned), -0.03]}}\n"

/* R = 1 + sin(a) K + (1 - cos(a)) K K (Rodrigues), of the vector's cross product a K. */
static void rodrigues(const double vector[3], double R[3][3])
{
    const double a = sqrt(vector_dot(vector, vector));
    const double k[3] = {vector[0] / a, vector[1] / a, vector[2] / a};
    const double K[3][3] = {{0, -k[2], k[1]}, {k[2], 0, -k[0]}, {-k[1], k[0], 0}};
    for (int i = 0; i < 3; i++) {
        for (int j = 0; j < 3; j++) {
            double square = 0;
            for (int n = 0; n < 3; n++) {
                square += K[i][n] * K[n][j];
            }
            R[i][j] = (i == j) + sin(a) * K[i][j] + (1 - cos(a)) * square;
        }
    }
}

/* Where the cameras see the marker of one place: in mm, as they write it. */
static void write_row(FILE *file, const double pose[7], nn_rng *random)
{
    double R[3][3], camera[3][3], beside[3], seen[3];
    const double offset[3] = {truth[MARKER], truth[MARKER + 1], 0};
    rotation_matrix(pose + 3, R);
    to_world(R, offset, beside);
    rodrigues(truth + TURN, camera);
    for (int i = 0; i < 3; i++) {
        beside[i] += pose[i] - truth[POSITION + i];
    }
    to_body(camera, beside, seen);
    for (int i = 0; i < 3; i++) {
        fprintf(file, ",%.9g", 1000 * (seen[i] + NOISE * nn_rng_normal(random)));
    }
    fputc('\n', file);
}

static void measure_shapes(void)
{
    enum { PULLS = 10, PLACES = 3 };
    static const double s[PLACES] = {0.08, 0.14, 0.2};
    nn_rng random = nn_rng_seed(4);
    FILE *file = fopen(path, "w");
    assert_non_null(file);
    for (int i = 0; i < PULLS; i++) {
        char text[600];
        ad_error error = {AD_OK, ""};
        config *settings;
        solution *solved;
        solve_report report;
        double values[7 * PLACES], pose[7];
        const double pull = 0.02 * i, turned = 0.6 * i;
        snprintf(text, sizeof text, "parameters: {bending: %.17g, pull: %g, turned: %g}\n" ROD,
                 truth[BENDING], pull, turned);
        assert_int_equal(prepare_read("a.yaml", text, 0, NULL, &settings, &error), AD_OK);
        const solve_settings how = solve_settings_default(&settings->scene);
        assert_int_equal(solution_create(&settings->scene, &how, 0, NULL, &solved, &report, &error),
                         AD_OK);
        assert_int_equal(solution_evaluate(solved, 7, PLACES, s, NULL, values, &error), AD_OK);
        for (int place = 0; place < PLACES; place++) {
            for (int c = 0; c < 7; c++) {
                pose[c] = values[c * PLACES + place];
            }
            fprintf(file, "%g,%g,%g", pull, turned, s[place]);
            write_row(file, pose, &random);
        }
        solution_free(solved);
        config_free(settings);
    }
    fclose(file);
}

/* Each within four deviations, chi squared within four of its own. */
static void check_found(const char *text, int count, const char *const *names, const double *values)
{
    ad_error error = {.message = ""};
    config *settings = NULL;
    identified found;
    if (prepare_read("scene.yaml", text, 0, NULL, &settings, &error) != AD_OK ||
        config_identify(settings, 1, NULL, NULL, &found, &error) != AD_OK) {
        fail_msg("%s", error.message);
    }
    const scene *open = &settings->scene;
    assert_int_equal(found.count, count);
    for (int i = 0; i < count; i++) {
        int k = 0;
        while (strcmp(open->parameters[scene_known_count(open) + k].name, names[i]) != 0) {
            assert_true(++k < count);
        }
        assert_true(found.deviation[k] > 0 &&
                    fabs(found.value[k] - values[i]) < 4 * found.deviation[k]);
    }
    const double freedom = (double)found.residuals - count;
    assert_true(fabs(found.chi_squared - freedom) < 4 * sqrt(2 * freedom));
    config_free(settings);
}

static void test_marker_and_frame(void **state)
{
    (void)state;
    static const char *const names[UNKNOWNS] = {"data_0_marker_0",
                                                "data_0_marker_1",
                                                "data_0_frame_position_0",
                                                "data_0_frame_position_1",
                                                "data_0_frame_position_2",
                                                "turn0",
                                                "turn1",
                                                "turn2",
                                                "bending"};
    char text[2000];
    measure_shapes();
    snprintf(text, sizeof text,
             "parameters: {bending: {identify: 2.0e-3, range: [1.0e-3, 1.0e-2]}, pull: {range: [0, "
             "1]}, turned: {range: [0, 9]}, turn0: {identify: 0, range: [-3, 3]}, turn1: "
             "{identify: -1, range: [-3, 3]}, turn2: {identify: 0, range: [-3, 3]}}\n" ROD "data:\n"
             "  - {quantity: position, file: %s, noise: %g, columns: {pull: c1, turned: c2, s: c3, "
             "x: c4/1000, y: c5/1000, z: c6/1000}, marker: [{identify: 0, range: [-0.03, 0.03]}, "
             "{identify: 0, range: [-0.03, 0.03]}], frame: {position: [{identify: 0, range: [-2, "
             "2]}, {identify: 0, range: [-2, 2]}, {identify: 0, range: [-2, 2]}], "
             "rotation_vector: [turn0, turn1, turn2]}}\n",
             path, NOISE);
    check_found(text, UNKNOWNS, names, truth);
}

#define BEAM                                                                                       \
    "rod: {model: euler_bernoulli, length: 1, stiffness: {bending: [bending, bending]}, "          \
    "inertia: {mass_per_length: 1}}\ntime: {duration: 1.7}\n"                                      \
    "beam: {initial: {deflection: \"0.05*(cosh(1.8751040687119612*s) - "                           \
    "cos(1.8751040687119612*s) - 0.7340955137589128*(sinh(1.8751040687119612*s) - "                \
    "sin(1.8751040687119612*s)))\"}}\n"
static const double FREQUENCY = 3.5160152685001512;

/* A beam in its first mode, cos(w (t - delay)) at its tip, 50 times a second. */
static void test_delay(void **state)
{
    (void)state;
    static const char *const names[] = {"delay", "bending"};
    static const double values[] = {0.03, 1}, noise = 1e-3;
    char text[2000];
    nn_rng random = nn_rng_seed(5);
    FILE *file = fopen(path, "w");
    assert_non_null(file);
    for (int i = 0; i < 80; i++) {
        fprintf(file, "%.9g\n",
                0.1 * cos(FREQUENCY * (i / 50.0 - values[0])) + noise * nn_rng_normal(&random));
    }
    fclose(file);
    snprintf(
        text, sizeof text,
        "parameters: {delay: {identify: 0.05, range: [0, 0.1]}, bending: {identify: 0.9, "
        "range: [0.5, 1.5]}}\n" BEAM
        "data: [{quantity: position, file: %s, noise: %g, rate: 50, delay: delay, rows: {from: "
        "11}, columns: {w: c1, s: 1}}]\n",
        path, noise);
    check_found(text, 2, names, values);
}

/* One row in ten is off by tenths of a metre: the logarithm of Cauchy's distribution finds the
 * truth within four deviations, which are those of normal errors but for a third.
 * Squares do not: stiffness is off by more than ten of these. */
static void test_robust(void **state)
{
    (void)state;
    enum { ROWS = 200 };
    double off[2], deviation[2];
    nn_rng random = nn_rng_seed(6);
    FILE *file = fopen(path, "w");
    assert_non_null(file);
    for (int i = 0; i < ROWS; i++) {
        const double error = i % 10 == 3 ? 0.05 + 0.1 * nn_rng_uniform(&random) : 0;
        fprintf(file, "%.9g,%.9g\n", i / 100.0,
                0.1 * cos(FREQUENCY * i / 100.0) + error + 1e-3 * nn_rng_normal(&random));
    }
    fclose(file);
    for (int robust = 0; robust < 2; robust++) {
        char text[2000];
        ad_error error = {.message = ""};
        config *settings = NULL;
        identified found;
        snprintf(text, sizeof text,
                 "parameters: {bending: {identify: 0.9, range: [0.5, 1.5]}}\n" BEAM
                 "data: [{quantity: position, file: %s, noise: 1e-3, robust: %s, rows: {to: 170}, "
                 "columns: {w: c2, "
                 "t: c1, s: 1}}]\n",
                 path, robust ? "cauchy" : "squares");
        if (prepare_read("scene.yaml", text, 0, NULL, &settings, &error) != AD_OK ||
            config_identify(settings, 1, NULL, NULL, &found, &error) != AD_OK) {
            fail_msg("%s", error.message);
        }
        off[robust] = fabs(found.value[0] - 1);
        deviation[robust] = found.deviation[0];
        print_message("off by %g, deviation %g\n", off[robust], deviation[robust]);
        config_free(settings);
    }
    assert_true(off[1] < 4 * deviation[1]);
    assert_true(off[0] > 10 * deviation[1]);
    /* squares have the deviation of the noise that is stated, 1e-3 */
    assert_true(deviation[1] > 0.75 * deviation[0] && deviation[1] < 1.33 * deviation[0]);
}

static void test_refusals(void **state)
{
    (void)state;
    static const char *const bad[][2] = {
        {"quantity: rotation, marker: [0.1, 0]",
         "data[0].marker: is given here; allowed: of positions of a rod"},
        {"quantity: moment, frame: {rotation: [1, 0, 0, 0]}",
         "data[0].frame.rotation: is given here; allowed: of positions and rotations of a rod"},
        {"quantity: position, frame: {rotation: [1, 0, 0, 0], rotation_vector: [0, 0, 1]}",
         "data[0].frame.rotation_vector: is given here; allowed: of positions and rotations of a "
         "rod, without frame.rotation"},
        {"quantity: position, delay: 0.1", "data[0].delay: is given here; allowed: in motion"},
        {"quantity: position, rate: 10", "data[0].rate: is given here; allowed: in motion"}};
    for (size_t i = 0; i < sizeof bad / sizeof *bad; i++) {
        char text[1000];
        ad_error error = {.message = ""};
        config *settings = NULL;
        identified found;
        snprintf(text, sizeof text,
                 "parameters: {bending: {identify: 2.0e-3, range: [1.0e-3, 1.0e-2]}, pull: 0.1, "
                 "turned: 0}\n" ROD "data: [{file: %s, %s}]\n",
                 path, bad[i][0]);
        assert_int_equal(prepare_read("scene.yaml", text, 0, NULL, &settings, &error), AD_OK);
        assert_int_equal(config_identify(settings, 1, NULL, NULL, &found, &error), AD_BAD_INPUT);
        assert_non_null(strstr(error.message, bad[i][1]));
        config_free(settings);
    }
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_marker_and_frame),
        cmocka_unit_test(test_delay),
        cmocka_unit_test(test_robust),
        cmocka_unit_test(test_refusals),
    };
    return cmocka_run_group_tests(tests, make_file, remove_directory);
}
