/* Balance of energy and momentum of motions that are known: a fall in closed form, right and wrong,
 * and what the classical solver computes of a rod on which all there is acts. */
#include "motion_testing.h"

#include "physics/solve/motion_balance.h"

#include <stdlib.h>
#include <string.h>

#define ROD                                                                                        \
    "rod: {length: 1, stiffness: {bending: [1, 1], torsion: 0.8, shear: [500, 500], axial: 1500}," \
    " inertia: {mass_per_length: 1, rotary: [0.0006, 0.0006, 0.0012]}%s}\n"

static motion_balance balance_of(const scene *given, int count, const double *times,
                                 solve_known_motion *motion, void *context)
{
    ad_error error;
    motion_balance result;
    if (motion_balance_of(given, count, times, motion, context, &result, &error) != AD_OK) {
        fail_msg("%s", error.message);
    }
    return result;
}

/* ---- a fall -------------------------------------------------------------------------------- */

enum { COLUMNS = 25, Y = 1, Z = 2, QW = 3, V3 = 9, VX = 19, VY = 20, VZ = 21 };

typedef struct fall {
    double acceleration, sideways;
} fall;

/* Without turning, from rest; the rod is not strained. */
static ad_status fall_at(void *context, size_t points, const double *s, const double *t,
                         double *values, ad_error *error)
{
    (void)error;
    const fall *f = context;
    memset(values, 0, COLUMNS * points * sizeof *values);
    for (size_t i = 0; i < points; i++) {
        values[Y * points + i] = -0.5 * f->acceleration * t[i] * t[i];
        values[VY * points + i] = -f->acceleration * t[i];
        values[VX * points + i] = f->sideways;
        values[0 * points + i] = f->sideways * t[i];
        values[Z * points + i] = s[i];
        values[QW * points + i] = 1;
        values[V3 * points + i] = 1;
    }
    return AD_OK;
}

/* Of a motion that falls by half of what acts, v = g t/2, half of the work M g^2 t^2/4 is missing,
 * and of the momentum M g t/2; the work as kinetic energy would have M g t/sqrt 2. Ends of
 * stretches of time are taken a billionth of them further in. */
static void test_fall(void **state)
{
    (void)state;
    char text[600];
    snprintf(text, sizeof text,
             ROD "boundary: {start: {type: free}, end: {type: free}}\n"
                 "initial: {position: [0, 0, s], rotation: [1, 0, 0, 0]}\n"
                 "loads: {gravity: [0, -3, 0]}\ntime: {duration: 2}\n",
             "");
    solved x;
    make_rod(&x, "fall.yaml", text);
    const double times[] = {0, 0.7, 2};
    fall right = {3, 0.5}, half = {1.5, 0};
    motion_balance of_right = balance_of(&x.settings->scene, 3, times, fall_at, &right);
    motion_balance of_half = balance_of(&x.settings->scene, 3, times, fall_at, &half);
    assert_true(of_right.energy < 1e-8 && of_right.momentum < 1e-8);
    assert_true(fabs(of_half.energy - 0.5) < 1e-7 && fabs(of_half.momentum - sqrt(0.5)) < 1e-7);
    free_solved(&x);
}

/* ---- all that acts ------------------------------------------------------------------------- */

enum { TIMES_MAX = 4000 };

typedef struct heard {
    size_t count;
    double times[TIMES_MAX]; /* as asked for */
    const solution *solved;  /* NULL: only listen */
} heard;

static ad_status listen(void *context, size_t points, const double *s, const double *t,
                        double *values, ad_error *error)
{
    heard *h = context;
    if (h->solved) {
        return solution_evaluate(h->solved, COLUMNS, points, s, t, values, error);
    }
    assert_true(h->count < TIMES_MAX);
    h->times[h->count++] = *t;
    fall still = {0, 0};
    return fall_at(&still, points, s, t, values, error);
}

/* Damped, so that the solver's steps and mesh resolve all of it; energy is out of balance by what
 * a step of time and this quadrature leave, 1e-6 and less, and by a hundredth if velocities are
 * wrong by as much. */
static motion_balance of_solver(const char *rest)
{
    char text[2000];
    snprintf(text, sizeof text, ROD "%s",
             ", damping: {strain: [0.5, 0.5, 0.5], curvature: [0.02, 0.02, 0.02]}", rest);
    ad_error error;
    solved x;
    solution *found = NULL;
    solve_report report;
    make_rod(&x, "all.yaml", text);
    const scene *given = &x.settings->scene;
    const double times[] = {0, 0.1, scene_duration(given)};
    static heard h;
    h = (heard){.count = 0};
    balance_of(given, 3, times, listen, &h);
    const solve_settings settings = {.tolerance = 1e-7};
    if (solution_create(given, &settings, h.count, h.times, &found, &report, &error) != AD_OK) {
        fail_msg("%s", error.message);
    }
    h.solved = found;
    motion_balance result = balance_of(given, 3, times, listen, &h);
    print_message("energy %.1e (solver %.1e), momentum %.1e\n", result.energy,
                  report.energy_mismatch, result.momentum);
    solution_free(found);
    free_solved(&x);
    return result;
}

static void test_all_that_acts(void **state)
{
    (void)state;
    static const char *const scenes[] = {
        /* tendon, body, spring, point load, gravity, drag */
        "loads: {gravity: [0, -2, 0], drag: 0.3, quadratic_drag: 0.2, tip: {force: [1, 0, 0]},"
        " points: [{at: 0.4, force: [0, '2*sin(3*t)^2', 0]}]}\n"
        "bodies: [{at: 1, mass: 0.3, inertia: [0.01, 0.01, 0.02]}]\n"
        "springs: [{at: 0.7, stiffness: [3, 4, 5]}]\n"
        "tendons: [{offset: [0.05, 0.02], tension: '5*sin(4*t)^2'}]\n"
        "time: {duration: 0.3}\n",
        /* a driven end */
        "boundary: {start: {type: driven, position: [0, 't^2', 0],"
        " rotation: ['cos(t^2)', 0, 'sin(t^2)', 0]}}\ntime: {duration: 0.3}\n",
        /* a joint, and a rest shape that changes */
        "segments: [{length: 0.5}, {length: 0.5, turn: [0, 1, 0]}]\n"
        "loads: {gravity: [0, -2, 0]}\ntime: {duration: 0.3}\n",
        /* bodies and a spring at ends that are held in all directions and in two */
        "boundary: {start: {type: driven, position: [0, 't^2', 0], rotation: [1, 0, 0, 0]},"
        " end: {type: roller, position: [0, 0, 1], along: [0, 1, 0]}}\n"
        "bodies: [{at: 0, mass: 0.2}, {at: 1, mass: 0.3}]\n"
        "springs: [{at: 1, stiffness: [3, 4, 5]}]\n"
        "loads: {gravity: [0, -2, 0]}\ntime: {duration: 0.3}\n"};
    for (size_t i = 0; i < sizeof scenes / sizeof *scenes; i++) {
        motion_balance found = of_solver(scenes[i]);
        assert_true(found.energy < 1e-5 && found.momentum < 1e-5);
    }
}

int main(void)
{
    const struct CMUnitTest tests[] = {cmocka_unit_test(test_fall),
                                       cmocka_unit_test(test_all_that_acts)};
    return cmocka_run_group_tests(tests, NULL, NULL);
}
