/* Motions under recorded inputs: derivatives of residuals against differences, also by where the
 * rod is held and how long it is, by plays and lags of inputs and by a Maxwell branch; slow motions
 * of these against equilibria along the same path; what is a recording in a file, and what is not;
 * the same bits for any number of threads. */
#include "open_scene.h"

#include "physics/scene/scene_memory.h"
#include "physics/solve/measured.h"
#include "tools/train/recorded_inputs.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

enum {
    PULL,
    STIFFNESS,
    DAMPING,
    HELD,
    GAP,
    LATE,
    PARAMETERS,
    UNKNOWNS_MAX = 5,
    STATES = 2,
    SAMPLES = 26,
    ROWS = 2 * SAMPLES
};

static const double LENGTH = 0.2;

typedef struct recorded_arm {
    quantities *names;
    scene open;
    double s[ROWS], t[ROWS], known[ROWS * (PARAMETERS + STATES)], pull[ROWS], values[7][ROWS];
    const solve_inputs *of[ROWS];
    recorded_inputs *inputs;
    solve_measured set;
} recorded_arm;

static void put_tension(recorded_arm *x, const char *tension)
{
    const char *key = "";
    ad_error error;
    quantities_know_plays(x->names, true);
    x->open.tendons[0].tension = quantity_formula(x->names, tension);
    quantities_know_plays(x->names, false);
    assert_good(scene_remember(&x->open, 0, NULL, &key, &error), &error);
}

/* The unknowns of tension "pull" are the first three, or all, the last two of a Maxwell branch
 * where the rod relaxes. */
static void make_scene(recorded_arm *x, const char *tension, const char *length, bool relaxes,
                       double duration)
{
    const int unknowns = strcmp(tension, "pull") == 0 && !relaxes ? 3 : UNKNOWNS_MAX;
    static const scene_parameter parameters[PARAMETERS] = {
        {"pull", 0, 5, SCENE_LINEAR},       {"stiffness", 1e-3, 1e-2, SCENE_LOG},
        {"damping", 1e-5, 1e-3, SCENE_LOG}, {"held", -0.1, 0.1, SCENE_LINEAR},
        {"gap", 0, 1, SCENE_LINEAR},        {"late", 1e-3, 1, SCENE_LOG}};
    static const double starts[PARAMETERS] = {1, 4e-3, 1e-4, 0.01, 0.3, 0.05};
    scene *to = &x->open;
    x->names = quantities_create();
    open_scene(to, x->names, 1 + unknowns, unknowns, parameters, starts, LENGTH);
    to->duration = quantity_number(duration);
    for (int k = 0; k < 2; k++) {
        to->rod.bending_stiffness[k] = quantity_formula(x->names, "stiffness");
        to->rod.curvature_damping[k] = quantity_formula(x->names, "damping");
    }
    to->rod.torsional_stiffness = quantity_number(3e-3);
    to->rod.curvature_damping[2] = quantity_number(1e-4);
    to->rod.mass_per_length = quantity_number(0.1);
    for (int k = 0; k < 3; k++) {
        to->rod.rotary_inertia[k] = quantity_number(1e-5);
    }
    if (relaxes) {
        to->rod.maxwell_ratio = quantity_formula(x->names, "gap");
        to->rod.maxwell_time = quantity_formula(x->names, "late");
    }
    to->start.position[1] = quantity_formula(x->names, "held");
    to->initial.state = SCENE_EQUILIBRIUM;
    to->loads.gravity[0] = quantity_number(3);
    to->loads.gravity[2] = quantity_number(9.81);
    to->tendons[0] = (scene_tendon){.offset = {quantity_number(4e-3), quantity_number(2e-3)}};
    to->tendon_count = 1;
    put_tension(x, tension);
    const char *key = "";
    ad_error error;
    scene written = *to;
    written.rod.length = quantity_formula(x->names, length);
    assert_good(scene_map(&written, to, &key, &error), &error);
}

/* Middle and tip of every sample, measured somewhere: derivatives do not ask where. */
static void make(recorded_arm *x, const char *tension, const char *length, bool relaxes,
                 double duration)
{
    const double *known[PARAMETERS + STATES] = {x->pull};
    ad_error error;
    memset(x, 0, sizeof *x);
    make_scene(x, tension, length, relaxes, duration);
    for (int i = 0; i < ROWS; i++) {
        x->s[i] = LENGTH / (1 + (i + 1) % 2);
        x->t[i] = i / 2 * duration / (SAMPLES - 1);
        x->pull[i] = 1.5 + sin(9 * x->t[i] / duration + 0.3);
        x->known[i * x->open.parameter_count] = x->pull[i];
        x->values[3][i] = 1;
    }
    assert_good(recorded_inputs_create(&x->inputs, &error), &error);
    assert_good(
        recorded_inputs_find(x->inputs, &x->open, "arm.csv", ROWS, x->t, known, x->of, &error),
        &error);
    x->set = (solve_measured){.rows = ROWS,
                              .s = x->s,
                              .t = x->t,
                              .known = x->known,
                              .columns = 7,
                              .column = {0, 1, 2, 3, 4, 5, 6},
                              .values = x->values[0],
                              .inputs = x->of};
    for (int c = 0; c < 7; c++) {
        x->set.noise[c] = 1;
    }
}

static void finish(recorded_arm *x)
{
    recorded_inputs_free(x->inputs);
    quantities_free(x->names);
}

/* Exact derivatives of steps that Newton's method solves to 1e-10, against central differences with
 * the error of their third derivatives, some 1e-6; no sample is so near to where a play begins to
 * move that the differences meet both sides. */
static void check_derivatives(const char *tension, const char *length, bool relaxes)
{
    enum { NUMBERS = 6 * ROWS };
    static double residuals[NUMBERS], room[2 * UNKNOWNS_MAX * NUMBERS],
        jacobian[UNKNOWNS_MAX][NUMBERS], beside[2 * UNKNOWNS_MAX][NUMBERS], again[NUMBERS];
    static const double values[UNKNOWNS_MAX] = {4e-3, 1e-4, 0.01, 0.3, 0.05}, off = 1e-3;
    static recorded_arm x;
    double ends[2 * UNKNOWNS_MAX], trial[2 * UNKNOWNS_MAX * UNKNOWNS_MAX];
    solve_trials *trials, *alone;
    size_t solved;
    ad_error error;
    make(&x, tension, length, relaxes, 1);
    const int unknowns = x.open.unknown_count;
    assert_good(solve_trials_create(&x.open, 1, &x.set, 1e-6, 2, &trials, &error), &error);
    assert_good(solve_trials_create(&x.open, 1, &x.set, 1e-6, 1, &alone, &error), &error);
    assert_int_equal(solve_trials_residuals(trials), NUMBERS);
    assert_int_equal(solve_trials_experiments(trials), 1);
    assert_good(solve_trials_run(trials, 1, values, false, residuals, &error), &error);
    assert_good(solve_trials_run(alone, 1, values, false, again, &error), &error);
    assert_memory_equal(residuals, again, sizeof residuals);
    for (int k = 0; k < 2 * unknowns; k++) {
        double *at = trial + k * unknowns;
        memcpy(at, values, (size_t)unknowns * sizeof *at);
        at[k / 2] *= 1 + (k % 2 ? off : -off);
        ends[k] = at[k / 2];
    }
    assert_good(solve_trials_differentiate(trials, values, ends, residuals, room, jacobian[0],
                                           &solved, &error),
                &error);
    assert_int_equal(solved, 0); /* none by differences */
    assert_good(solve_trials_run(trials, 2 * (size_t)unknowns, trial, false, beside[0], &error),
                &error);
    for (int i = 0; i < unknowns; i++) {
        double largest = 0, worst = 0;
        for (int k = 0; k < NUMBERS; k++) {
            const double by =
                (beside[2 * i + 1][k] - beside[2 * i][k]) / (ends[2 * i + 1] - ends[2 * i]);
            largest = fmax(largest, fabs(by));
            worst = fmax(worst, fabs(by - jacobian[i][k]));
        }
        assert_true(largest > 0);
        if (worst > 1e-5 * largest) {
            fail_msg("%s, unknown %d: %g of %g", tension, i, worst, largest);
        }
    }
    solve_trials_free(trials);
    solve_trials_free(alone);
    finish(&x);
}

static void test_derivatives(void **state)
{
    (void)state;
    check_derivatives("pull", "0.2", false);
    check_derivatives("pull", "0.2+held", false);
    check_derivatives("lag(play(pull, gap), late)", "0.2", false);
    check_derivatives("pull", "0.2+held/2", true);
}

/* What is measured less what is computed of the places of an arm. */
static void residuals_of(const recorded_arm *x, const solve_measured *set, double *residuals)
{
    static const double values[UNKNOWNS_MAX] = {4e-3, 1e-4, 0.01, 0.3, 0.05};
    solve_trials *trials;
    ad_error error;
    assert_good(solve_trials_create(&x->open, 1, set, 1e-7, 2, &trials, &error), &error);
    assert_good(solve_trials_run(trials, 1, values, true, residuals, &error), &error);
    solve_trials_free(trials);
}

/* Along a path of 100 s, a thousand times its slowest period, the arm is where it rests on the same
 * path: the motion steps the play from sample to sample, rows at rest from row to row. What is left
 * is the lag of the damping, rate times late, and the reduced rod's modes. */
static void test_slow(void **state)
{
    enum { NUMBERS = 6 * ROWS };
    static double moving[NUMBERS], resting[NUMBERS];
    static recorded_arm x, still;
    double largest = 0;
    (void)state;
    make(&x, "play(pull, gap) + 0*late", "0.2", false, 100);
    residuals_of(&x, &x.set, moving);
    make(&still, "play(pull, gap) + 0*late", "0.2", false, 0);
    for (int i = 0; i < ROWS; i++) {
        still.t[i] = 0;
        still.known[i * still.open.parameter_count] = still.pull[i] = x.pull[i];
        still.of[i] = NULL;
    }
    residuals_of(&still, &still.set, resting);
    for (int k = 0; k < NUMBERS; k++) {
        largest = fmax(largest, fabs(moving[k] - resting[k]));
    }
    if (largest > 1e-3 * LENGTH) {
        fail_msg("off by %g m", largest);
    }
    finish(&x);
    finish(&still);
}

/* Files whose t falls have two; values that differ at one instant are no inputs; the same rows in
 * another list are the same recording. */
static void test_what_is_one(void **state)
{
    static recorded_arm x;
    static const solve_inputs *again[ROWS];
    double t[6] = {0, 1, 2, 0, 1, 2}, pull[6] = {1, 2, 3, 1, 1, 2}, at_once[6] = {0, 0, 1, 1, 2, 2};
    const double *known[PARAMETERS] = {x.pull}, *others[PARAMETERS] = {pull};
    const solve_inputs *of[6];
    ad_error error;
    (void)state;
    make(&x, "pull", "0.2", false, 1);
    assert_good(recorded_inputs_find(x.inputs, &x.open, "arm.csv", ROWS, x.t, known, again, &error),
                &error);
    assert_ptr_equal(again[0], x.of[0]);
    assert_int_equal(x.of[0]->count, SAMPLES);
    assert_good(recorded_inputs_find(x.inputs, &x.open, "two.csv", 6, t, others, of, &error),
                &error);
    assert_int_equal(of[2]->number, 2);
    assert_int_equal(of[3]->number, 3);
    pull[1] = 7;
    assert_good(recorded_inputs_find(x.inputs, &x.open, "no.csv", 6, at_once, others, of, &error),
                &error);
    assert_null(of[0]);
    t[0] = 0.5;
    assert_int_equal(recorded_inputs_find(x.inputs, &x.open, "late.csv", 3, t, others, of, &error),
                     AD_BAD_INPUT);
    assert_string_equal(error.message,
                        "late.csv: inputs begin at t = 0.5 s; allowed: from t = 0 on, "
                        "where the motion begins");
    finish(&x);
}

int main(void)
{
    const struct CMUnitTest tests[] = {cmocka_unit_test(test_derivatives),
                                       cmocka_unit_test(test_slow),
                                       cmocka_unit_test(test_what_is_one)};
    return cmocka_run_group_tests(tests, NULL, NULL);
}
