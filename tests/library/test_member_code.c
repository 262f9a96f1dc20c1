/* Single members by C that is compiled (cpinn_family_settings.compile): the answers of the library
 * within what both say of their errors, derivatives as differences have them, what is kept, and
 * what happens without a compiler. */
#include "tools/library/trained_family.h"

#include "nn/rng.h"
#include "temporary_folder.h"

#include <math.h>
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>
#include <sys/stat.h>

#include <cmocka.h>

enum { POINTS = 7, COLUMNS = 13, PARAMETERS = 3, MEMBERS = 16, WIDTH = POINTS * COLUMNS };

static const double LENGTH = 0.2;

#define FAMILY(more)                                                                               \
    "parameters: {pull: {range: [0, 2]}, push: {range: [-0.03, 0.03]},\n"                          \
    "             stiff: {range: [0.7, 1.4], scale: log}}\n"                                       \
    "formulation: strain\n"                                                                        \
    "rod: {model: cosserat, length: 0.2, section: {shape: circle, radius: 0.5e-3},\n"              \
    "      material: {youngs_modulus: 60e9*stiff, poissons_ratio: 0.3, density: 6450}}\n" more     \
    "network: {hidden: [24, 24]}\n"                                                                \
    "members: {solved: 600}\n"                                                                     \
    "losses: {interior: {points: 128}, held_out_points: 64}\n"                                     \
    "training: {stages: [{optimizer: soap, steps: 400, learning_rate: 0.01, warmup_steps: 20}]}\n"

static const char loaded[] = FAMILY("boundary: {start: {rotation: [1, 0, 0.1*pull, 0.3*stiff], "
                                    "position: [push, 0, 0]}, end: {type: loaded}}\n"
                                    "loads: {gravity: [0, 0, -9.81], tip: {force: [0, push, 0]}}\n"
                                    "tendons: [{offset: [0.008, 0], tension: pull}]\n");
/* With forces that are sought beside the curvature, and angles of friction. */
static const char pulled[] =
    FAMILY("loads: {gravity: [0, 0, -9.81], tip: {force: [0, push, 0]}}\n"
           "tendons: [{offset: [0.008, 0], tension: pull, friction: 0.3},\n"
           "          {offset: [0, 0.006], displacement: 2e-4*pull, stiffness: 3000}]\n");

static void check(ad_status status, const ad_error *error)
{
    if (status != AD_OK) {
        fail_msg("%s", error->message);
    }
}

static void train(const char *text, const char *name)
{
    const cpinn_options options = {.threads = 1};
    ad_error error = {AD_OK, ""};
    cpinn_model *model = NULL;
    FILE *file = fopen(at("family.yaml"), "w");
    assert_non_null(file);
    fputs(text, file);
    assert_int_equal(fclose(file), 0);
    check(cpinn_train_file(at("family.yaml"), 0, NULL, &options, &model, &error), &error);
    check(cpinn_save(model, at(name), &error), &error);
    cpinn_free(model);
}

static cpinn_family *open_family(const char *name, bool compile)
{
    double s[POINTS];
    for (int i = 0; i < POINTS; i++) {
        s[i] = LENGTH * i / (POINTS - 1);
    }
    const cpinn_family_settings settings = {
        .extrapolate = true, .threads = 1, .points = POINTS, .s = s, .compile = compile};
    ad_error error = {AD_OK, ""};
    cpinn_family *result = NULL;
    check(cpinn_family_open(at(name), &settings, &result, &error), &error);
    assert_int_equal(cpinn_family_parameters(result), PARAMETERS);
    assert_int_equal(cpinn_family_columns(result), COLUMNS);
    return result;
}

static void draw(const cpinn_family *x, double *parameters)
{
    nn_rng random = nn_rng_seed(5);
    for (int i = 0; i < MEMBERS * PARAMETERS; i++) {
        parameters[i] = scene_parameter_at(cpinn_family_parameter(x, i % PARAMETERS),
                                           0.05 + 0.9 * nn_rng_uniform(&random));
    }
}

/* Each member in a call of its own. */
static void evaluate(cpinn_family *x, const cpinn_polish *polish, const double *parameters,
                     double *values, cpinn_answer *answers)
{
    ad_error error = {AD_OK, ""};
    for (int i = 0; i < MEMBERS; i++) {
        check(cpinn_family_evaluate(x, polish, 1, parameters + i * PARAMETERS, values + i * WIDTH,
                                    answers ? answers + i : NULL, &error),
              &error);
    }
}

static double distance(const double *a, const double *b)
{
    double largest = 0;
    for (int i = 0; i < POINTS; i++) {
        double square = 0;
        for (int c = 0; c < 3; c++) {
            square += pow(a[i * COLUMNS + c] - b[i * COLUMNS + c], 2);
        }
        largest = fmax(largest, sqrt(square));
    }
    return largest;
}

/* Positions of one curvature differ by what Magnus' steps and meshes leave, 1e-5 of the length; all
 * else of an answer is by the same numbers. What is trusted is as near to the equilibrium as it
 * says. */
static void check_answers(cpinn_family *plain, cpinn_family *compiled)
{
    double parameters[MEMBERS * PARAMETERS], values[MEMBERS * WIDTH], others[MEMBERS * WIDTH],
        solved[MEMBERS * WIDTH];
    cpinn_answer answers[MEMBERS], told[MEMBERS], solver[MEMBERS];
    int trusted = 0;
    draw(plain, parameters);
    evaluate(plain, NULL, parameters, solved, solver);
    for (int steps = 0; steps <= 2; steps++) {
        const cpinn_polish polish = {.steps = steps, .alone = true};
        evaluate(plain, &polish, parameters, values, answers);
        evaluate(compiled, &polish, parameters, others, told);
        for (int i = 0; i < MEMBERS; i++) {
            assert_int_equal(answers[i].trusted, told[i].trusted);
            assert_int_equal(answers[i].reason, told[i].reason);
            if (told[i].trusted) {
                assert_true(distance(values + i * WIDTH, others + i * WIDTH) <= 1e-5 * LENGTH);
                assert_true(fabs(answers[i].error - told[i].error) <=
                            0.3 * answers[i].error + 1e-5 * LENGTH);
                assert_true(solver[i].trusted);
                assert_true(distance(solved + i * WIDTH, others + i * WIDTH) <=
                            2 * (told[i].error + solver[i].error) + CPINN_TOLERANCE * LENGTH);
                trusted++;
            }
        }
    }
    printf("%d of %d are trusted\n", trusted, 3 * MEMBERS);
    assert_true(trusted > 2 * MEMBERS);
    evaluate(plain, NULL, parameters, values, NULL);
    evaluate(compiled, NULL, parameters, others, NULL);
    for (int i = 0; i < MEMBERS; i++) {
        assert_true(distance(values + i * WIDTH, others + i * WIDTH) <= 1e-5 * LENGTH);
    }
}

/* Of equilibria: those of the library, which has them by other means; and central differences of
 * what two steps find, which leave some 1e-7 of the length, over a step of 1e-3 of the range. */
static void check_derivatives(cpinn_family *plain, cpinn_family *compiled)
{
    enum { ALL = WIDTH * PARAMETERS };
    double parameters[MEMBERS * PARAMETERS], values[WIDTH], jacobian[ALL], others[ALL];
    ad_error error = {AD_OK, ""};
    int compared = 0;
    draw(plain, parameters);
    for (int i = 0; i < MEMBERS; i++) {
        cpinn_answer answer;
        double *at = parameters + i * PARAMETERS, scale[COLUMNS * PARAMETERS] = {0};
        check(cpinn_family_jacobian(compiled, 1, at, values, jacobian, &answer, &error), &error);
        if (!answer.trusted || answer.source != CPINN_FROM_NETWORK ||
            answer.error > 1e-5 * LENGTH) {
            continue;
        }
        check(cpinn_family_jacobian(plain, 1, at, values, others, &answer, &error), &error);
        for (int k = 0; k < ALL; k++) {
            double *largest = &scale[k % (COLUMNS * PARAMETERS)];
            *largest = fmax(*largest, fabs(others[k]));
        }
        for (int k = 0; k < ALL; k++) {
            const double unit = 1e-6 + scale[k % (COLUMNS * PARAMETERS)];
            assert_true(fabs(jacobian[k] - others[k]) <= 1e-3 * unit);
        }
        for (int p = 0; p < PARAMETERS; p++) {
            const scene_parameter *of = cpinn_family_parameter(plain, p);
            const double middle = at[p], step = 1e-3 * (of->high - of->low);
            double side[2][WIDTH];
            for (int k = 0; k < 2; k++) {
                at[p] = middle + (2 * k - 1) * step;
                check(cpinn_family_evaluate(compiled, NULL, 1, at, side[k], &answer, &error),
                      &error);
            }
            at[p] = middle;
            for (int k = 0; k < WIDTH; k++) {
                const double unit = 1e-6 + scale[k % COLUMNS * PARAMETERS + p];
                assert_true(fabs((side[1][k] - side[0][k]) / (2 * step) -
                                 jacobian[k * PARAMETERS + p]) <= 5e-3 * unit);
            }
        }
        compared++;
    }
    printf("derivatives of %d members\n", compared);
    assert_true(compared >= MEMBERS / 4);
}

/* Few members have the bits of one; many, and members outside, those of the library. */
static void check_calls(cpinn_family *plain, cpinn_family *compiled)
{
    double parameters[MEMBERS * PARAMETERS], values[MEMBERS * WIDTH], others[MEMBERS * WIDTH];
    cpinn_answer answers[MEMBERS];
    ad_error error = {AD_OK, ""};
    draw(plain, parameters);
    evaluate(compiled, NULL, parameters, values, answers);
    check(cpinn_family_evaluate(compiled, NULL, CPINN_FEW, parameters, others, answers, &error),
          &error);
    assert_memory_equal(values, others, CPINN_FEW * WIDTH * sizeof *values);
    check(cpinn_family_evaluate(plain, NULL, MEMBERS, parameters, values, answers, &error), &error);
    check(cpinn_family_evaluate(compiled, NULL, MEMBERS, parameters, others, answers, &error),
          &error);
    assert_memory_equal(values, others, sizeof values);
    parameters[0] = 2.1;
    check(cpinn_family_evaluate(plain, NULL, 1, parameters, values, answers, &error), &error);
    check(cpinn_family_evaluate(compiled, NULL, 1, parameters, others, answers, &error), &error);
    assert_true(answers[0].outside);
    assert_memory_equal(values, others, WIDTH * sizeof *values);
}

static void check_family(const char *text, const char *name)
{
    train(text, name);
    cpinn_family *plain = open_family(name, false), *compiled = open_family(name, true);
    assert_string_equal(cpinn_family_not_compiled(compiled), "");
    check_answers(plain, compiled);
    check_derivatives(plain, compiled);
    check_calls(plain, compiled);
    cpinn_family_free(plain);
    cpinn_family_free(compiled);
}

static void test_loaded(void **state)
{
    (void)state;
    check_family(loaded, "loaded.h5");
}

static void test_pulled(void **state)
{
    (void)state;
    check_family(pulled, "pulled.h5");
}

/* ---- members that are solved --------------------------------------------------------------- */

enum { SOLVED = 200 };

#define ROD(stiff)                                                                                 \
    "rod: {model: cosserat, length: 0.2, section: {shape: circle, radius: 0.5e-3},\n"              \
    "      material: {youngs_modulus: 60e9" stiff ", poissons_ratio: 0.3, density: 6450}}\n"

/* Most of these buckle on their way, and are followed in parts of their loads; 10 places. */
static const char column[] = "parameters: {up: {range: [0, 0.12]}, side: {range: [1e-5, 4e-3]},\n"
                             "             stiff: {range: [0.7, 1.4], scale: log}}\n" ROD(
                                 "*stiff") "loads: {tip: {force: [side, 0.3*side, -5*up]}}\n";
/* Forces turn with the rod; a tendon ends within it. */
static const char followed[] =
    "parameters: {push: {range: [-0.1, 0.1]}, pull: {range: [0, 3]}, moment: {range: [-3e-3, "
    "3e-3]}}\n" ROD(
        "") "loads: {gravity: [0, 0, -9.81], frame: follower, force: [0.3*push, 0, 0],\n"
            "        tip: {force: [0, push, 0], moment: [moment, 0, 0.3*moment], frame: "
            "follower}}\n"
            "tendons: [{offset: [0.008, 0], tension: pull, end: 0.12}]\n";
/* The same all along it, so that the library has it at one point where it is by itself. */
static const char uniform[] = "parameters: {pull: {range: [0, 2]}}\n" ROD(
    "") "tendons: [{offset: [0.008, 0], tension: pull}]\n";
/* What the C does not take, and what its mesh does not resolve. */
static const char held[] = "parameters: {push: {range: [-0.03, 0.03]}}\n" ROD(
    "") "loads: {tip: {force: [0, push, 0]}}\n"
        "tendons: [{offset: [0.008, 0], displacement: 1e-4}]\n";
static const char twisted[] =
    "parameters: {m: {range: [-0.06, 0.06]}, twist: {range: [-0.03, 0.03]}, f: {range: [-1, "
    "1]}}\n" ROD("") "loads: {tip: {force: [f, 0.1, 0.2*f], moment: [m, 0, twist]}}\n";

static cpinn_family *open_with(const char *text, double tolerance, bool compile, bool forces)
{
    double s[POINTS];
    for (int i = 0; i < POINTS; i++) {
        s[i] = LENGTH * i / (POINTS - 1);
    }
    const cpinn_family_settings settings = {.extrapolate = true,
                                            .threads = 1,
                                            .points = POINTS,
                                            .s = s,
                                            .compile = compile,
                                            .forces = forces};
    ad_error error = {AD_OK, ""};
    cpinn_family *result = NULL;
    FILE *file = fopen(at("members.yaml"), "w");
    assert_non_null(file);
    fputs(text, file);
    assert_int_equal(fclose(file), 0);
    check(cpinn_family_file(at("members.yaml"), 0, NULL, tolerance, &settings, &result, &error),
          &error);
    return result;
}

static cpinn_family *open_members(const char *text, double tolerance, bool compile)
{
    return open_with(text, tolerance, compile, false);
}

/* By the solver of members, or compiled C, alone. */
static void solve(cpinn_family *x, int members, const double *parameters, double *values,
                  double *jacobian, cpinn_answer *answers)
{
    static const cpinn_polish alone = {.alone = true};
    ad_error error = {AD_OK, ""};
    check(cpinn_family_answer(x, &alone, (size_t)members, parameters, values, jacobian, answers,
                              &error),
          &error);
}

static void draw_members(const double (*ranges)[2], int count, double *parameters)
{
    nn_rng random = nn_rng_seed(5);
    for (int i = 0; i < count * PARAMETERS; i++) {
        const double *of = ranges[i % PARAMETERS];
        parameters[i] = of[0] + nn_rng_uniform(&random) * (of[1] - of[0]);
    }
}

/* Of the library and compiled: the same members are solved; shapes are as near to those that are
 * solved a thousand times as exactly as both say of themselves, and within the tolerance;
 * derivatives as the library has them, on another mesh: differences of tests above judge both. */
static void check_members(const char *text, const double (*ranges)[2])
{
    enum { ALL = WIDTH * PARAMETERS };
    const double tolerance = 1e-6;
    cpinn_family *plain = open_members(text, tolerance, false),
                 *compiled = open_members(text, tolerance, true),
                 *exact = open_members(text, tolerance / 1000, false);
    double parameters[SOLVED * PARAMETERS], values[WIDTH], others[WIDTH], best[WIDTH],
        jacobian[ALL], slopes[ALL];
    int solved = 0, by_code = 0;
    assert_string_equal(cpinn_family_not_compiled(compiled), "");
    draw_members(ranges, SOLVED, parameters);
    for (int i = 0; i < SOLVED; i++) {
        const double *of = parameters + i * PARAMETERS;
        cpinn_answer one, other, third;
        solve(plain, 1, of, others, slopes, &one);
        solve(compiled, 1, of, values, jacobian, &other);
        solve(exact, 1, of, best, NULL, &third);
        assert_int_equal(one.trusted, other.trusted);
        assert_int_equal(one.source, other.source);
        assert_int_equal(one.reason, other.reason);
        if (!one.trusted || !isfinite(third.error)) {
            continue;
        }
        double scale[PARAMETERS * COLUMNS] = {0};
        assert_true(other.error <= tolerance * LENGTH);
        assert_true(distance(values, best) <= tolerance * LENGTH);
        assert_true(distance(values, best) <= 1.5 * other.error);
        assert_true(distance(values, others) <= 1.5 * (one.error + other.error));
        for (int k = 0; k < ALL; k++) {
            double *largest = &scale[k % (COLUMNS * PARAMETERS)];
            *largest = fmax(*largest, fabs(slopes[k]));
        }
        for (int k = 0; k < ALL; k++) {
            assert_true(fabs(jacobian[k] - slopes[k]) <=
                        1e-3 * (1e-6 + scale[k % (COLUMNS * PARAMETERS)]));
        }
        by_code += memcmp(values, others, sizeof values) != 0;
        solved++;
    }
    printf("%d of %d members are solved, %d by compiled C\n", solved, SOLVED, by_code);
    assert_true(solved > SOLVED / 2 && 4 * by_code > 3 * solved);
    cpinn_family_free(plain);
    cpinn_family_free(compiled);
    cpinn_family_free(exact);
}

static void test_columns(void **state)
{
    (void)state;
    static const double ranges[PARAMETERS][2] = {{0, 0.12}, {1e-5, 4e-3}, {0.7, 1.4}};
    check_members(column, ranges);
}

static void test_followers(void **state)
{
    (void)state;
    static const double ranges[PARAMETERS][2] = {{-0.1, 0.1}, {0, 3}, {-3e-3, 3e-3}};
    check_members(followed, ranges);
}

/* Force and moment in the rod, which the C has by what is recorded of the balance. Positions are
 * within 1e-8 of the length, and curvature, of which forces are, by what that is over the square of
 * an element, which is a tenth: 1e-5 of those of the library, or of EI/L^2 and EI/L. Derivatives
 * are within 1e-7 of differences of fourth order, 5e-3 of the range apart, of members whose mesh is
 * the same one and which are solved to some 1e-11. */
static void check_forces(const char *text, const double (*ranges)[2])
{
    enum { WIDE = COLUMNS + SOLVE_MEMBERS_FORCES, ALL = POINTS * WIDE, FEW = 10 };
    static const double unit[2] = {0.07, 0.015}; /* of E I = 2.9e-3 N m^2 */
    static double values[ALL], others[ALL], jacobian[ALL * PARAMETERS], side[4][ALL];
    cpinn_family *plain = open_with(text, 1e-8, false, true),
                 *compiled = open_with(text, 1e-8, true, true);
    double parameters[FEW * PARAMETERS], worst = 0;
    int compared = 0;
    cpinn_answer one, other;
    assert_string_equal(cpinn_family_not_compiled(compiled), "");
    assert_int_equal(cpinn_family_columns(compiled), WIDE);
    draw_members(ranges, FEW, parameters);
    for (int i = 0; i < FEW; i++) {
        double *of = parameters + i * PARAMETERS;
        solve(plain, 1, of, others, NULL, &one);
        solve(compiled, 1, of, values, jacobian, &other);
        assert_int_equal(one.trusted, other.trusted);
        if (!one.trusted || memcmp(values, others, sizeof values) == 0) {
            continue;
        }
        for (int k = 0; k < ALL; k++) {
            const double size = k % WIDE < COLUMNS ? 1 : unit[k % WIDE >= COLUMNS + 3];
            assert_true(k % WIDE < COLUMNS ||
                        fabs(values[k] - others[k]) <= 1e-5 * (size + fabs(others[k])));
        }
        for (int p = 0; p < PARAMETERS; p++) {
            const double middle = of[p], h = 5e-3 * (ranges[p][1] - ranges[p][0]);
            for (int k = 0; k < 4; k++) {
                of[p] = middle + (double[]){-2, -1, 1, 2}[k] * h;
                solve(compiled, 1, of, side[k], NULL, &other);
            }
            of[p] = middle;
            for (int k = 0; k < ALL; k++) {
                const double slope =
                    (8 * (side[2][k] - side[1][k]) - (side[3][k] - side[0][k])) / 12 / 5e-3;
                const double by = jacobian[k * PARAMETERS + p] * (ranges[p][1] - ranges[p][0]);
                const double size = unit[k % WIDE >= COLUMNS + 3];
                if (k % WIDE >= COLUMNS) {
                    worst = fmax(worst, fabs(slope - by) / (size + fabs(slope)));
                }
            }
        }
        compared++;
    }
    printf("forces of %d members, derivatives to %.1e\n", compared, worst);
    assert_true(compared > FEW / 2 && worst <= 1e-7);
    cpinn_family_free(plain);
    cpinn_family_free(compiled);
}

static void test_forces(void **state)
{
    (void)state;
    static const double columns[PARAMETERS][2] = {{0, 0.01}, {1e-3, 4e-3}, {0.8, 1.4}},
                        followers[PARAMETERS][2] = {{-0.1, 0.1}, {0, 3}, {-3e-3, 3e-3}};
    check_forces(column, columns);
    check_forces(followed, followers);
}

/* Many members, those outside of the ranges, and what is not compiled have the bits of the library.
 */
static void test_members_of_library(void **state)
{
    (void)state;
    enum { MANY = CPINN_FEW + 1 };
    double parameters[MANY * PARAMETERS], values[MANY * WIDTH], others[MANY * WIDTH];
    static const double ranges[PARAMETERS][2] = {{0, 0.02}, {1e-5, 4e-3}, {0.7, 1.4}};
    cpinn_answer answers[MANY];
    cpinn_family *plain = open_members(column, 1e-6, false),
                 *compiled = open_members(column, 1e-6, true);
    assert_string_equal(cpinn_family_not_compiled(compiled), "");
    draw_members(ranges, MANY, parameters);
    solve(plain, MANY, parameters, values, NULL, answers);
    solve(compiled, MANY, parameters, others, NULL, answers);
    assert_memory_equal(values, others, sizeof values);
    parameters[0] = -0.01;
    solve(plain, 1, parameters, values, NULL, answers);
    solve(compiled, 1, parameters, others, NULL, answers);
    assert_true(answers[0].trusted && answers[0].outside);
    assert_memory_equal(values, others, WIDTH * sizeof *values);
    cpinn_family_free(plain);
    cpinn_family_free(compiled);
    compiled = open_members(uniform, 1e-6, true);
    assert_string_equal(cpinn_family_not_compiled(compiled), "");
    cpinn_family_free(compiled);
    compiled = open_members(held, 1e-6, true);
    assert_non_null(strstr(cpinn_family_not_compiled(compiled), "given length"));
    cpinn_family_free(compiled);
    plain = open_members(twisted, 1e-6, false), compiled = open_members(twisted, 1e-6, true);
    assert_non_null(strstr(cpinn_family_not_compiled(compiled), "too few"));
    solve(plain, 1, (double[]){0.02, 0.01, 0.1}, values, NULL, answers);
    solve(compiled, 1, (double[]){0.02, 0.01, 0.1}, others, NULL, answers);
    assert_memory_equal(values, others, WIDTH * sizeof *values);
    cpinn_family_free(plain);
    cpinn_family_free(compiled);
}

/* What is kept needs no compiler; without one the library answers. */
static void test_without_compiler(void **state)
{
    (void)state;
    double parameters[MEMBERS * PARAMETERS], values[MEMBERS * WIDTH], others[MEMBERS * WIDTH];
    char path[4096];
    cpinn_family *plain = open_family("loaded.h5", false);
    snprintf(path, sizeof path, "%s", getenv("PATH"));
    assert_int_equal(setenv("PATH", "/nowhere", 1), 0);
    cpinn_family *kept = open_family("loaded.h5", true);
    assert_string_equal(cpinn_family_not_compiled(kept), "");
    assert_int_equal(setenv("XDG_CACHE_HOME", at("other"), 1), 0);
    cpinn_family *none = open_family("loaded.h5", true);
    assert_non_null(strstr(cpinn_family_not_compiled(none), "no compiler"));
    assert_int_equal(setenv("PATH", path, 1), 0);
    draw(plain, parameters);
    evaluate(plain, NULL, parameters, values, NULL);
    evaluate(none, NULL, parameters, others, NULL);
    assert_memory_equal(values, others, sizeof values);
    cpinn_family_free(plain);
    cpinn_family_free(kept);
    cpinn_family_free(none);
}

/* Of C of families and of solvers some is compiled as users have it. The rest is by a cc that
 * hardly optimises, which takes a third of the time. */
static char usual[4096];

static int as_users(void **state)
{
    (void)state;
    return setenv("PATH", usual, 1);
}

static int quickly(void **state)
{
    char path[sizeof usual + sizeof directory];
    (void)state;
    snprintf(path, sizeof path, "%s:%s", directory, usual);
    return setenv("PATH", path, 1);
}

static int set_up(void **state)
{
    snprintf(usual, sizeof usual, "%s", getenv("PATH"));
    if (make_directory(state) != 0 || setenv("XDG_CACHE_HOME", directory, 1) != 0) {
        return -1;
    }
    FILE *file = fopen(at("cc"), "w");
    if (!file) {
        return -1;
    }
    fputs("#!/bin/sh\nPATH=${PATH#*:}\nexec cc \"$@\" -O1\n", file);
    return fclose(file) == 0 ? chmod(at("cc"), 0700) : -1;
}

static int clear(void **state)
{
    (void)state;
    char command[600];
    snprintf(command, sizeof command, "rm -rf %s", directory);
    return system(command);
}

int main(void)
{
    if (system("cc --version >/dev/null 2>&1") != 0) {
        return 77;
    }
    const struct CMUnitTest tests[] = {cmocka_unit_test_setup(test_loaded, quickly),
                                       cmocka_unit_test_setup(test_pulled, as_users),
                                       cmocka_unit_test_setup(test_columns, quickly),
                                       cmocka_unit_test_setup(test_followers, as_users),
                                       cmocka_unit_test_setup(test_forces, quickly),
                                       cmocka_unit_test_setup(test_members_of_library, quickly),
                                       cmocka_unit_test_setup(test_without_compiler, as_users)};
    return cmocka_run_group_tests(tests, set_up, clear);
}
