/* Unknowns from hundreds of poses of a robot that tendons pull by lengths: derivatives of residuals
 * against differences, pretension found again where tendons go slack, and the same bits for any
 * number of threads. */
#include "open_scene.h"

#include "nn/rng.h"
#include "physics/chain/solve_members.h"
#include "tools/train/identify.h"

#include <stdlib.h>
#include <string.h>

enum { TENDONS = 3, LEVER = TENDONS, PRETENSION, BENDING, PARAMETERS, UNKNOWNS = 3, POSES = 200 };

/* A motor that turns by 3 mm from a pretension of 1.5 N over 2000 N/m, 0.75 mm, leaves one or two
 * of the three tendons slack. */
static const double LENGTH = 0.18, STIFFNESS = 2000, PULLED = 3e-3;
static const double truth[UNKNOWNS] = {4.5e-3, 1.5, 2.5e-3};

typedef struct poses {
    quantities *names;
    scene open;
    double s[POSES], known[POSES][PARAMETERS], values[13 * POSES];
    solve_measured set;
} poses;

static quantity formula(poses *x, const char *form, int i)
{
    char text[80];
    snprintf(text, sizeof text, form, i);
    return quantity_formula(x->names, text);
}

static void make_scene(poses *x)
{
    static const scene_parameter parameters[PARAMETERS] = {
        {"pull0", -0.01, 0.01, SCENE_LINEAR}, {"pull1", -0.01, 0.01, SCENE_LINEAR},
        {"pull2", -0.01, 0.01, SCENE_LINEAR}, {"lever", 3e-3, 6e-3, SCENE_LINEAR},
        {"pretension", 0.2, 5, SCENE_LOG},    {"bending", 1e-3, 1e-2, SCENE_LOG}};
    static const double starts[PARAMETERS] = {0, 0, 0, 4e-3, 0.5, 4e-3};
    scene *to = &x->open;
    x->names = quantities_create();
    open_scene(to, x->names, PARAMETERS, UNKNOWNS, parameters, starts, LENGTH);
    to->rod.bending_stiffness[0] = to->rod.bending_stiffness[1] =
        quantity_formula(x->names, "bending");
    to->rod.torsional_stiffness = quantity_number(2e-3);
    for (int i = 0; i < TENDONS; i++) {
        to->tendons[i] = (scene_tendon){.offset = {formula(x, "lever*cos(2*pi*%d/3)", i),
                                                   formula(x, "lever*sin(2*pi*%d/3)", i)},
                                        .displacement = formula(x, "pull%d + pretension/2000", i),
                                        .stiffness = quantity_number(STIFFNESS)};
    }
    to->tendon_count = TENDONS;
}

/* Poses by the members at the truth, of which the tip and how it is turned are measured. */
static void make_poses(poses *x, int rows, double noise)
{
    static double shapes[POSES * SOLVE_MEMBERS_COLUMNS], with[POSES][PARAMETERS];
    static solve_member results[POSES];
    const solve_members_settings settings = {
        .tolerance = 1e-9, .threads = 1, .points = 1, .s = &LENGTH};
    solve_members *members;
    ad_error error;
    nn_rng random = nn_rng_seed(7);
    make_scene(x);
    for (int i = 0; i < rows; i++) {
        for (int k = 0; k < TENDONS; k++) {
            x->known[i][k] = with[i][k] = PULLED * (2 * nn_rng_uniform(&random) - 1);
        }
        memcpy(with[i] + LEVER, truth, sizeof truth);
        x->s[i] = LENGTH;
    }
    assert_good(solve_members_create(&x->open, &settings, &members, &error), &error);
    assert_good(solve_members_solve(members, (size_t)rows, with[0], shapes, results, &error),
                &error);
    solve_members_free(members);
    x->set = (solve_measured){.rows = (size_t)rows,
                              .s = x->s,
                              .known = x->known[0],
                              .columns = 7,
                              .column = {0, 1, 2, 3, 4, 5, 6},
                              .values = x->values};
    for (int c = 0; c < x->set.columns; c++) {
        x->set.noise[c] = noise;
        for (int i = 0; i < rows; i++) {
            assert_true(results[i].solved);
            x->values[c * rows + i] =
                shapes[i * SOLVE_MEMBERS_COLUMNS + c] + noise * (c < 3) * nn_rng_normal(&random);
        }
    }
}

/* Of a step of 1e-3 of the value central differences of fourth order are off by 1e-12 of the fifth
 * derivative, and solutions of a tolerance of 1e-12 by 1e-9. Where a tendon becomes slack there is
 * none. */
static void test_derivatives(void **state)
{
    (void)state;
    enum { ROWS = 12, RESIDUALS = 6 * ROWS };
    static const double AT[4] = {-2, -1, 1, 2},
                        WEIGHT[4] = {1.0 / 12, -8.0 / 12, 8.0 / 12, -1.0 / 12};
    static poses x;
    double values[UNKNOWNS] = {4.2e-3, 1.2, 3e-3}, ends[2 * UNKNOWNS] = {0};
    double residuals[RESIDUALS], room[2 * UNKNOWNS * RESIDUALS], by[UNKNOWNS * RESIDUALS];
    double beside[4 * RESIDUALS], trial[4 * UNKNOWNS], largest = 0, worst = 0;
    size_t solved;
    solve_trials *trials;
    ad_error error;
    make_poses(&x, ROWS, 1e-3);
    assert_good(solve_trials_create(&x.open, 1, &x.set, 1e-12, 1, &trials, &error), &error);
    assert_int_equal(solve_trials_residuals(trials), RESIDUALS);
    assert_good(solve_trials_run(trials, 1, values, false, residuals, &error), &error);
    assert_good(
        solve_trials_differentiate(trials, values, ends, residuals, room, by, &solved, &error),
        &error);
    assert_int_equal(solved, 0);
    for (int i = 0; i < UNKNOWNS; i++) {
        const double step = 1e-3 * values[i];
        for (int k = 0; k < 4; k++) {
            memcpy(trial + k * UNKNOWNS, values, sizeof values);
            trial[k * UNKNOWNS + i] += AT[k] * step;
        }
        assert_good(solve_trials_run(trials, 4, trial, false, beside, &error), &error);
        for (int r = 0; r < RESIDUALS; r++) {
            double difference = 0;
            for (int k = 0; k < 4; k++) {
                difference += WEIGHT[k] * beside[k * RESIDUALS + r] / step;
            }
            largest = fmax(largest, fabs(values[i] * by[i * RESIDUALS + r]));
            worst = fmax(worst, fabs(values[i] * (by[i * RESIDUALS + r] - difference)));
        }
    }
    print_message("derivatives off by %.2g of %.3g\n", worst, largest);
    assert_true(worst < 1e-7 * largest);
    solve_trials_free(trials);
    quantities_free(x.names);
}

/* Within four deviations, and to the last bit by two threads as by one. */
static void test_found_again(void **state)
{
    (void)state;
    static poses x;
    identified found[2];
    ad_error error;
    make_poses(&x, POSES, 5e-4);
    x.set.columns = 3;
    for (int k = 0; k < 2; k++) {
        const identify_settings settings = {.threads = 1 + k};
        assert_good(identify(&x.open, 1, &x.set, &settings, &found[k], &error), &error);
    }
    assert_true(found[0].by_members && found[0].converged);
    assert_int_equal(found[0].experiments, POSES);
    for (int i = 0; i < UNKNOWNS; i++) {
        print_message("%.6g +- %.2g\n", found[0].value[i], found[0].deviation[i]);
        assert_near(found[0].value[i], truth[i], 4 * found[0].deviation[i]);
        assert_true(found[0].deviation[i] < 0.05 * truth[i]);
    }
    assert_memory_equal(found[0].value, found[1].value, sizeof found[0].value);
    assert_memory_equal(found[0].deviation, found[1].deviation, sizeof found[0].deviation);
    quantities_free(x.names);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_derivatives),
        cmocka_unit_test(test_found_again),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
