/* Motions that start from an equilibrium: where they start, what they do when they are let go, and
 * what is refused. */
#include "near.h"
#include "temporary_folder.h"

#include "cpinn.h"
#include "fewer.h"
#include "physics/chain/reduced.h"
#include "tools/prepare/prepare.h"

#include <string.h>

#define ROD                                                                                        \
    "rod: {length: 1, stiffness: {bending: [1, 1], torsion: 0.8, shear: [500, 500], axial: "       \
    "1500},\n"                                                                                     \
    "  inertia: {mass_per_length: 1, rotary: [0.0007, 0.0007, 0.0014]}}\n"                         \
    "boundary: {start: {rotation: [0, 1, 0, 1]}}\n"
#define BEAM                                                                                       \
    "rod: {model: euler_bernoulli, length: 2, stiffness: {bending: [3, 3]},\n"                     \
    "  inertia: {mass_per_length: 0.7}}\n"

static config *read_scene(const char *text, ad_error *error)
{
    config *made = NULL;
    error->message[0] = 0;
    return prepare_read("scene.yaml", text, 0, NULL, &made, error) == AD_OK ? made : NULL;
}

/* Columns of the solution at s, t; the first two are x and z, or w. */
static void solve_at(const char *text, double tolerance, double s, double t, double *values)
{
    ad_error error;
    config *made = read_scene(text, &error);
    cpinn_solution *solved = NULL;
    bool moves = made && scene_is_dynamic(&made->scene);
    if (!made || cpinn_solve_scene(&made->scene, tolerance, moves, &t, &solved, &error) != AD_OK ||
        cpinn_solution_evaluate(solved, 1, &s, moves ? &t : NULL, values, &error) != AD_OK) {
        fail_msg("%s", error.message);
    }
    cpinn_solution_free(solved);
    config_free(made);
}

/* The rod hangs from a load, and the load is cut. */
static void test_starts_from_equilibrium(void **state)
{
    (void)state;
    const double places[] = {0.2, 0.77, 1};
    for (int i = 0; i < 3; i++) {
        double still[MODEL_COLUMNS_MAX], start[MODEL_COLUMNS_MAX];
        solve_at(ROD "loads: {tip: {force: [0, 0, -2]}, gravity: [0, 0, -3]}\n", 1e-11, places[i],
                 0, still);
        solve_at(ROD "loads: {tip: {force: [0, 0, \"where(t, 0, -2)\"]}, gravity: [0, 0, -3]}\n"
                     "time: {duration: 0.01}\ninitial: {state: equilibrium}\n",
                 1e-5, places[i], 0, start);
        for (int k = 0; k < 7; k++) { /* position and rotation: what solve_settle allows */
            assert_near(start[k], still[k], 2e-9);
        }
    }
}

/* Under loads that stay the rod stays: to the tolerance of the motion. */
static void test_stays_in_equilibrium(void **state)
{
    (void)state;
    double still[MODEL_COLUMNS_MAX], later[MODEL_COLUMNS_MAX];
    solve_at(ROD "loads: {tip: {force: [0, 0, -2]}}\n", 1e-11, 1, 0, still);
    solve_at(ROD "loads: {tip: {force: [0, 0, -2]}}\n"
                 "time: {duration: 0.5}\ninitial: {state: equilibrium}\n",
             1e-6, 1, 0.5, later);
    for (int k = 0; k < 3; k++) {
        assert_near(later[k], still[k], 1e-6);
    }
}

/* An equilibrium that is thrown: a point goes on as it begins, as the forces are in balance. */
static void test_thrown(void **state)
{
    (void)state;
    const double t = 1e-3;
    double still[MODEL_COLUMNS_MAX], later[MODEL_COLUMNS_MAX];
    solve_at(ROD "loads: {tip: {force: [0, 0, -2]}}\n", 1e-11, 1, 0, still);
    solve_at(ROD "loads: {tip: {force: [0, 0, -2]}}\ntime: {duration: 0.001}\n"
                 "initial: {state: equilibrium, velocity: [0, '0.2*s^2', 0],\n"
                 "          angular_velocity: ['0.4*s', 0, 0]}\n",
             1e-8, 1, t, later);
    assert_near(later[1] - still[1], 0.2 * t, 2e-2 * 0.2 * t); /* stiffness over mass times t^2 */
    assert_near(later[0], still[0], 1e-6);
    assert_near(later[2], still[2], 1e-6);
}

/* A cantilever beam that a tip force P bent, let go: w = sum of modes of their own frequencies. The
 * static deflection is P L^3/EI sum 2 phi_n(L)/beta_n^4 phi_n (by Parseval, with integral of
 * phi_n^2 = L and phi_n(L)^2 = 4), of which terms fall as n^-4. */
static double released_tip(double P, double L, double EI, double mass, double t)
{
    double sum = 0;
    for (int n = 1; n <= 400; n++) {
        double beta = (n - 0.5) * 3.14159265358979323846;
        for (int i = 0; i < 50 && n <= 6; i++) { /* 1 + cos cosh = 0 */
            double f = 1 / cosh(beta) + cos(beta), d = -sinh(beta) / pow(cosh(beta), 2) - sin(beta);
            beta -= f / d;
        }
        double omega = beta * beta * sqrt(EI / mass) / (L * L);
        sum += 4 / pow(beta, 4) * cos(omega * t);
    }
    return P * L * L * L / EI * sum;
}

static void test_beam_let_go(void **state)
{
    (void)state;
    const double times[] = {0, 0.4, 1.1};
    for (int i = 0; i < 3; i++) {
        double values[MODEL_COLUMNS_MAX];
        solve_at(BEAM "beam: {tip: {force: \"where(t, 0, 0.1)\"}}\ntime: {duration: 1.1}\n"
                      "initial: {state: equilibrium}\n",
                 1e-6, 2, times[i], values);
        double exact = released_tip(0.1, 2, 3, 0.7, times[i]);
        /* The shear force jumps at the tip, so that high modes matter: 1e-5 of the deflection. */
        assert_near(values[0], exact, 1e-5 * 0.1 * 8 / 9);
    }
}

/* A network starts where the solver does. */
static void test_network(void **state)
{
    (void)state;
    static const char text[] = ROD "loads: {tip: {force: [0, 0, -2]}, drag: 1}\n"
                                   "time: {duration: 0.2}\ninitial: {state: equilibrium}\n";
    FILE *file = fopen(at("scene.yaml"), "w");
    cpinn_model *model = NULL;
    evaluator *tip = NULL;
    ad_error error = {AD_OK, ""};
    double values[2], still[MODEL_COLUMNS_MAX], s = 1, t = 0.2;
    assert_non_null(file);
    fputs(text, file);
    fclose(file);
    if (cpinn_train_file(at("scene.yaml"), 0, NULL, NULL, &model, &error) != AD_OK ||
        cpinn_evaluator(model, "x z", &tip, &error) != AD_OK ||
        evaluator_evaluate(tip, 1, &s, &t, values, &error) != AD_OK) {
        fail_msg("%s", error.message);
    }
    solve_at(ROD "loads: {tip: {force: [0, 0, -2]}}\n", 1e-11, 1, 0, still);
    assert_near(values[0], still[0], 1e-7);
    assert_near(values[1], still[2], 1e-7);
    evaluator_free(tip);
    cpinn_free(model);
}

static void test_refused(void **state)
{
    (void)state;
    static const struct {
        const char *text, *line;
    } rows[] = {
        {ROD "initial: {state: equilibrium}\n",
         "scene.yaml:4:18: initial.state: nothing takes equilibrium at t = 0 at rest: "},
        {ROD "time: {duration: 1}\ninitial: {state: equilibrium, position: [s, 0, 0], rotation: "
             "[0, 1, 0, 1]}\n",
         "scene.yaml:5:18: initial.state: equilibrium says"},
        {ROD "time: {duration: 1}\ninitial: {state: equilibrium}\n"
             "loads: {force: [0, 0, \"where(t, 0, -1e5)\"]}\n",
         "scene.yaml:5:18: initial.state: "},
        /* Pressed along its axis beyond Euler's 2.47 EI/L^2: straight is no minimum. */
        {ROD "time: {duration: 1}\ninitial: {state: equilibrium}\n"
             "loads: {tip: {force: [-12, 0, 0]}}\n",
         "scene.yaml:5:18: initial.state: no equilibrium to start from is found: "}};
    for (size_t i = 0; i < sizeof rows / sizeof *rows; i++) {
        ad_error error;
        config *made = read_scene(rows[i].text, &error);
        assert_null(made);
        if (strncmp(error.message, rows[i].line, strlen(rows[i].line)) != 0) {
            fail_msg("'%s' does not begin with '%s'", error.message, rows[i].line);
        }
    }
}

/* ---- one-step models ---------------------------------------------------------------------------
 */

enum { STATES = 32 };

/* A motion of a family begins in the equilibrium of its inputs: of any of them what the rod settles
 * in from its unstressed shape, so that nothing moves it. */
static void test_settled_start(void **state)
{
    (void)state;
    static const char text[] =
        "parameters: {pull: {range: [0, 40]}}\n"
        "rod: {model: cosserat, length: 0.3, section: {shape: circle, radius: 0.02},\n"
        "  material: {youngs_modulus: 1e6, poissons_ratio: 0.45, density: 1070}}\n"
        "tendons: [{offset: [0, 0.015], tension: pull}]\n"
        "loads: {gravity: [0, 3, -9]}\n"
        "time: {duration: 1, windows: 1}\n"
        "surrogate: {step: 0.02}\n";
    const char *const settled[] = {"initial.state=equilibrium"};
    const double pulls[] = {0, 20, 40}, tip = 0.3;
    const reduced_settings settings = {.modes = {3, 1, 2, 1}, .count = 1, .s = &tip};
    for (int i = 0; i < 3; i++) {
        double x[2][STATES] = {{0}}, rate[STATES], fastest = 0, bent = 0;
        int n = 0;
        for (int from_rest = 0; from_rest < 2; from_rest++) {
            ad_error error = {.message = ""};
            config *given = NULL;
            reduced_rod *rod = NULL;
            if (prepare_read("scene.yaml", text, 1 - from_rest, settled, &given, &error) != AD_OK ||
                reduced_create(&given->scene, &settings, &rod, &error) != AD_OK ||
                reduced_initial(rod, &pulls[i], x[from_rest], &error) != AD_OK ||
                (from_rest && reduced_settle(rod, 0, &pulls[i], x[from_rest], &error) != AD_OK) ||
                reduced_rate(rod, 0, x[0], &pulls[i], rate, NULL, NULL, &error) != AD_OK) {
                fail_msg("%s", error.message);
            }
            n = reduced_states(rod);
            reduced_free(rod);
            config_free(given);
        }
        for (int k = 0; k < n; k++) {
            assert_near(x[0][k], x[1][k], 1e-8); /* Newton's method ends at 1e-9 */
            bent = fmax(bent, fabs(x[0][k]));
            fastest = fmax(fastest, fabs(rate[k]));
        }
        assert_true(bent > 0.3 || pulls[i] == 0);
        assert_true(fastest < 1e-4); /* stiffness over mass of what is left, 1/s^2 */
    }
}

/* A column starts upright below Euler's load, pi^2 EI/(4 L^2) = 2.4674, thrown as the scene says,
 * and not above it. */
static void test_column_start(void **state)
{
    (void)state;
    static const char text[] =
        "parameters: {load: {range: [0, 4]}}\n"
        "rod: {model: cosserat, length: 1, stiffness: {shear: [500, 500], axial: 1500, bending: "
        "[1, "
        "1], torsion: 0.8}, inertia: {mass_per_length: 1, rotary: [7e-4, 7e-4, 1.4e-3]}}\n"
        "loads: {tip: {force: [0, 0, -load]}}\n"
        "initial: {state: equilibrium, velocity: ['0.3*s^2', 0, 0], angular_velocity: [0, '0.6*s', "
        "0]}\n"
        "time: {duration: 1, windows: 1}\n"
        "surrogate: {step: 0.02}\n";
    const double loads[] = {0.5, 2.4, 2.6, 4}, tip = 1;
    const reduced_settings settings = {.modes = {3, 1, 2, 1}, .count = 1, .s = &tip};
    ad_error error = {.message = ""};
    config *given = NULL;
    reduced_rod *rod = NULL;
    if (prepare_read("scene.yaml", text, 0, NULL, &given, &error) != AD_OK ||
        reduced_create(&given->scene, &settings, &rod, &error) != AD_OK) {
        fail_msg("%s", error.message);
    }
    for (int i = 0; i < 4; i++) {
        double x[STATES];
        reduced_place at;
        const ad_status expected = i < 2 ? AD_OK : AD_NOT_FINITE;
        assert_int_equal(reduced_initial(rod, &loads[i], x, &error), expected);
        if (expected == AD_OK) {
            assert_int_equal(reduced_output(rod, 0, x, &loads[i], &at, NULL, &error), AD_OK);
            assert_near(at.position[0], 0, 1e-9);
            assert_near(at.velocity[0], 0.3, 3e-3); /* the nearest of so few modes */
        }
    }
    reduced_free(rod);
    config_free(given);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_thrown),
        cmocka_unit_test(test_settled_start),
        cmocka_unit_test(test_column_start),
        cmocka_unit_test(test_stays_in_equilibrium),
        cmocka_unit_test(test_beam_let_go),
        cmocka_unit_test_setup_teardown(test_network, make_directory, remove_directory),
        cmocka_unit_test(test_refused)};
    const struct CMUnitTest alike[] = {cmocka_unit_test(test_starts_from_equilibrium)};
    return run_with_alike(tests, alike, NULL, NULL);
}
