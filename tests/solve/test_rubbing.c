/* Friction of tendons with memory: pulled, released and pulled again, by a closed form, with the
 * part that sticks and what a cycle loses. */
#include "fewer.h"
#include "tendon_testing.h"

#include "physics/solve/rows.h"

#include <string.h>

/* A tendon at (0, y) in a rod without other loads stays parallel to it, so that it turns by theta'
 * = T y/EI for each m. Where it slides T' = -+mu theta' T, by which (1/T)' = +-mu y/EI: 1/T(s) is a
 * play of 1/T(0) with the threshold mu y s/EI. */
static const double LENGTH = 0.2, MU = 0.6, LEVER = 0.008, RADIUS = 0.0005, MODULUS = 60e9;

enum { PLACES = 201 };

static double rate(void)
{
    return LEVER / (MODULUS * PI * pow(RADIUS, 4) / 4);
}

static void play(double pull, double inverse[PLACES])
{
    for (int i = 0; i < PLACES; i++) {
        const double threshold = MU * rate() * LENGTH * i / (PLACES - 1);
        inverse[i] = fmax(1 / pull - threshold, fmin(1 / pull + threshold, inverse[i]));
    }
}

static scene pulled(double pull)
{
    scene given = robot(LENGTH, MODULUS, MODULUS / 2.6, RADIUS);
    add_tendon(&given, LEVER, 90, pull);
    given.tendons[0].friction = Q(MU);
    return given;
}

static solution *follow(double pull, double tolerance, const solution *before, solve_report *report)
{
    const solve_settings settings = {.tolerance = tolerance, .before = before};
    const scene given = pulled(pull);
    solution *found;
    ad_error error;
    if (solution_create(&given, &settings, 0, NULL, &found, report, &error) != AD_OK) {
        fail_msg("%s", error.message);
    }
    assert_near(report->load_fraction, 1, 0);
    return found;
}

/* How far the tip has turned. */
static double turned(const solution *at)
{
    double pose[7], s = LENGTH;
    ad_error error;
    assert_int_equal(solution_evaluate(at, 7, 1, &s, NULL, pose, &error), AD_OK);
    return 2 * atan2(fabs(pose[4]), fabs(pose[3]));
}

/* The turn that the tensions of the closed form make, by trapezoids. */
static double exact_turn(const double inverse[PLACES])
{
    double sum = 0;
    for (int i = 0; i < PLACES; i++) {
        sum += (i % (PLACES - 1) ? 1 : 0.5) / inverse[i];
    }
    return rate() * sum * LENGTH / (PLACES - 1);
}

static void pull_from_nothing(double inverse[PLACES])
{
    for (int i = 0; i < PLACES; i++) {
        inverse[i] = INFINITY;
    }
}

/* Tensions along the tendon and the rod's turn, of each pull in turn: small loops within large
 * ones. Where the part that sticks begins, T has a kink within an element, of 2 mu y T^2/EI; it is
 * off there by that over a distance of nodes of 0.5 mm, and the turn by no more than the estimate
 * and the trapezoids. */
static void test_pulls(void **state)
{
    (void)state;
    static const double pulls[] = {2, 1.2, 1.9, 0.6, 1.1, 0.9, 2.5};
    double inverse[PLACES];
    solution *before = NULL;
    pull_from_nothing(inverse);
    for (size_t k = 0; k < sizeof pulls / sizeof *pulls; k++) {
        solve_report report;
        solution *here = follow(pulls[k], 1e-7, before, &report);
        double off = 0;
        play(pulls[k], inverse);
        for (int i = 0; i < PLACES; i++) {
            const double s = LENGTH * i / (PLACES - 1);
            off = fmax(off, fabs(solution_tension_at(here, 0, s) - 1 / inverse[i]));
        }
        print_message("pull %.1f: tension off by %.1e N, turn by %.1e, estimate %.1e, nodes %d\n",
                      pulls[k], off, turned(here) - exact_turn(inverse), report.estimate,
                      report.nodes);
        assert_true(off < 2 * MU * rate() * pulls[k] * pulls[k] * 5e-4);
        assert_near(turned(here), exact_turn(inverse), 5e-6);
        assert_true(report.estimate < 1e-7);
        solution_free(before);
        before = here;
    }
    solution_free(before);
}

/* Work that a closed cycle loses, the area of its loop of tension and length: that of the closed
 * form at the same pulls, and none where nothing rubs. */
static void test_cycle(void **state)
{
    (void)state;
    enum { STEPS = 8 };
    double inverse[PLACES], lost = 0, exact = 0, last = 0, exact_last = 0, at = 2;
    solution *before = NULL;
    pull_from_nothing(inverse);
    for (int i = 0; i <= 3 * STEPS; i++) { /* down, up, and down again to the first place */
        const int down = i % (2 * STEPS);
        const double pull = 2 - 1.4 * (down < STEPS ? down : 2 * STEPS - down) / STEPS;
        solve_report report;
        solution *here = follow(pull, 1e-6, before, &report);
        play(pull, inverse);
        if (i > STEPS) {
            lost += (pull + at) / 2 * LEVER * (turned(here) - last);
            exact += (pull + at) / 2 * LEVER * (exact_turn(inverse) - exact_last);
        }
        at = pull;
        last = turned(here);
        exact_last = exact_turn(inverse);
        solution_free(before);
        before = here;
    }
    solution_free(before);
    print_message("a cycle loses %.6g J, by the closed form %.6g J\n", lost, exact);
    assert_true(exact > 1e-3);
    assert_near(lost, exact, 1e-4 * exact);
}

/* Another robot has other tendons. */
static void test_other(void **state)
{
    (void)state;
    solve_report report;
    ad_error error;
    solution *before = follow(1, 1e-6, NULL, &report), *found = NULL;
    scene given = pulled(1);
    const solve_settings settings = {.tolerance = 1e-6, .before = before};
    add_tendon(&given, LEVER, 0, 1);
    given.tendons[1].friction = Q(MU);
    assert_int_equal(solution_create(&given, &settings, 0, NULL, &found, &report, &error),
                     AD_BAD_ARGUMENT);
    assert_non_null(strstr(error.message, "an equilibrium of the same robot"));
    solution_free(before);
}

int main(void)
{
    const struct CMUnitTest tests[] = {cmocka_unit_test(test_pulls), cmocka_unit_test(test_other)};
    const struct CMUnitTest alike[] = {cmocka_unit_test(test_cycle)};
    return run_with_alike(tests, alike, NULL, NULL);
}
