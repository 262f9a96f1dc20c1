/* Motions under a pulse, of every quantity that may vary in time: no answer is wrong in silence.
 *
 *   test_solve pulses [COUNT [FIRST]]
 *
 * COUNT random motions, of seeds from FIRST on: the quantities in turn, pulses of any shape, place
 * and width. Each is compared with steps on a mesh of its own that are as short as the pulse asks
 * for, whose place and width are known here and are not looked for. A scene that is refused is
 * counted. Without arguments the first of the quantities, in short motions. */
#include "config_testing.h"
#include "fewer.h"
#include "random_numbers.h"

#include "physics/scene/scene_field.h"
#include "physics/solve/motion_compose.h"
#include "physics/solve/motion_fastest.h"
#include "physics/solve/motion_mesh.h"
#include "physics/solve/solve.h"
#include "tools/prepare/prepare.h"

#include <math.h>
#include <string.h>
#include <time.h>

enum { TIMES = 6, PLACES = 5, COLUMNS = 3, COARSE = 24, FINE = 384, TEXT = 4096, NODES_MAX = 1024 };

/* An answer without a warning is not off by more than so many times its estimate, nor by more than
 * this of the length: what is less nobody is misled by, and the comparison itself has some 1e-5. */
static const double TIMES_ESTIMATE = 10, OFF = 1e-4;

/* Of the energy; README says that more is a warning. */
static const double OUT_OF_BALANCE = 0.1;

/* How a quantity is pulsed: its part of a scene, with the pulse p; what 1 of the pulse is, so that
 * it moves the rod by some of its length if it lasts. */
typedef enum pulse_unit {
    FORCE,
    MOMENT,
    LINE,
    LINE_MOMENT,
    PLACE,
    TURN,
    BEND,
    STRETCH,
    FALL,
    PULL,
    PRESSURE,
    LENGTHEN
} pulse_unit;

typedef struct driven {
    const char *key; /* as in scene_fields, without numbers of entries */
    pulse_unit unit;
    const char *text; /* with @ for the pulse */
} driven;

#define CLAMPED "boundary: {start: {type: clamped}}\n"
#define BOTH    "boundary: {start: {type: clamped}, end: {type: driven, "
static const driven all[] = {
    {"tendons.tension", PULL, CLAMPED "tendons: [{offset: [0.008, 0], tension: '@'}]\n"},
    {"tendons.displacement", LENGTHEN,
     CLAMPED "tendons: [{offset: [0.008, 0.002], displacement: '@', stiffness: 50}]\n"},
    {"chambers.pressure", PRESSURE,
     CLAMPED "chambers: [{offset: [0, 0.004], area: 2e-5, pressure: '@'}]\n"},
    {"loads.points.force", FORCE, CLAMPED "loads: {points: [{at: 0.13, force: ['@', 0, 0]}]}\n"},
    {"loads.points.moment", MOMENT, CLAMPED "loads: {points: [{at: 0.07, moment: [0, '@', 0]}]}\n"},
    {"loads.tip.force", FORCE, CLAMPED "loads: {tip: {force: [0, '@', 0], frame: follower}}\n"},
    {"loads.tip.moment", MOMENT, CLAMPED "loads: {tip: {moment: ['@', 0, 0]}}\n"},
    {"loads.base.force", FORCE,
     "boundary: {start: {type: loaded}, end: {type: clamped, position: [0, 0, 0.2], rotation: [1, "
     "0, 0, 0]}}\n"
     "loads: {base: {force: ['@', 0, 0]}}\n"},
    {"loads.base.moment", MOMENT,
     "boundary: {start: {type: loaded}, end: {type: clamped, position: [0, 0, 0.2], rotation: [1, "
     "0, 0, 0]}}\n"
     "loads: {base: {moment: [0, '@', 0]}}\n"},
    {"loads.force", LINE, CLAMPED "loads: {force: [0, '@', 0]}\n"},
    {"loads.moment", LINE_MOMENT, CLAMPED "loads: {moment: [0, '(1+s)*(@)', 0]}\n"},
    {"loads.gravity", FALL, CLAMPED "loads: {gravity: ['@', 0, 0]}\n"},
    {"rod.rest.curvature", BEND, "  rest: {curvature: [0, '@', 0]}\n" CLAMPED},
    {"rod.rest.strain", STRETCH, "  rest: {strain: [0, 0, '1+@']}\n" CLAMPED},
    {"segments.rest.curvature", BEND,
     CLAMPED "segments:\n  - {length: 0.08, rest: {curvature: ['@', 0, 0]}}\n"
             "  - {length: 0.12}\n"},
    {"segments.rest.strain", STRETCH,
     CLAMPED "segments:\n  - {length: 0.08}\n  - {length: 0.12, rest: {strain: [0, 0, '1+@']}}\n"},
    {"boundary.start.position", PLACE,
     "boundary: {start: {type: driven, position: ['@', 0, 0]}}\n"},
    {"boundary.start.rotation", TURN,
     "boundary: {start: {type: driven, rotation: ['cos(@)', 'sin(@)', 0, 0]}}\n"},
    {"boundary.end.position", PLACE, BOTH "position: [0, '@', 0.2], rotation: [1, 0, 0, 0]}}\n"},
    {"boundary.end.rotation", TURN,
     BOTH "position: [0, 0, 0.2], rotation: ['cos(@)', 'sin(@)', 0, 0]}}\n"},
    {"boundary.end.rotation_vector", TURN,
     BOTH "position: [0, 0, 0.2], rotation_vector: [0, '@', 0]}}\n"},
    {"boundary.end.twist", TURN,
     BOTH "position: [0, 0, 0.2], rotation: [1, 0, 0, 0], twist: '@'}}\n"},
    {"loads.magnetic.field", LINE_MOMENT,
     CLAMPED "loads: {magnetic: {moment: [0, 0, 1], field: ['@', 0, 0]}}\n"},
    {"loads.magnetic.gradient", LINE,
     CLAMPED "loads: {magnetic: {moment: [0, 0, 1], gradient: [0, 0, 0, '@', 0]}}\n"},
};
enum { KEYS = sizeof all / sizeof all[0], QUICK = 8 };

typedef struct pulse_scene {
    const driven *of;
    double at, width, duration; /* s */
    char text[TEXT];
} pulse_scene;

/* ---- scenes ---------------------------------------------------------------------------------- */

static const char *const shapes[] = {
    "exp(-((t-%.9g)/%.9g)^2)",
    "1/cosh((t-%.9g)/%.9g)^2",
    "0.5*(tanh((t-%.9g)/%.9g+2)-tanh((t-%.9g)/%.9g-2))",
    "(t-%.9g)/%.9g*exp(-((t-%.9g)/%.9g)^2)",
    "sin(3*(t-%.9g)/%.9g)*exp(-((t-%.9g)/%.9g)^2)",
    "exp(-((t-%.9g)/%.9g)^4)",
};
enum { SHAPES = sizeof shapes / sizeof shapes[0], GAUSSIANS = 3 };

static void print_pulse(uint64_t *random, const pulse_scene *x, double size, char *to)
{
    /* tensions, and sizes of what may not be less than 0, do not change their sign */
    bool is_positive = x->of->unit == PULL;
    int shape = random_below(random, is_positive ? GAUSSIANS : SHAPES);
    int at = sprintf(to, "%.6g*", size);
    sprintf(to + at, shapes[shape], x->at, x->width, x->at, x->width);
}

/* What 1 of the pulse is, of a rod of length 0.2 m; short: width over the time of the rod, less
 * than 1 where the rod cannot follow. */
static double size_of(pulse_unit unit, double EI, double radius, double acceleration, double narrow)
{
    const double L = 0.2, force = EI / (L * L) * fmin(narrow, 300);
    switch (unit) {
    case FORCE:
        return force;
    case MOMENT:
        return force * L;
    case LINE:
        return force / L;
    case LINE_MOMENT:
        return force;
    case FALL:
        return acceleration * fmin(narrow, 300);
    case PULL:
        return fmin(force * L / 0.008, 0.1 * EI * 4 / (radius * radius));
    case PRESSURE:
        return fmin(force * L / 0.004, 0.1 * EI * 4 / (radius * radius)) / 2e-5;
    case LENGTHEN:
        return 0.002;
    case PLACE:
        return 0.1 * L;
    case TURN:
        return 0.3;
    case BEND:
        return 1 / L;
    case STRETCH:
        return 0.05;
    }
    return 0;
}

static void make_scene(uint64_t seed, bool quick, pulse_scene *x)
{
    uint64_t random = 0x9e3779b9u * (seed + 1);
    static const double durations[] = {0.2, 0.5, 1};
    const double radius = random_in(&random, 0.004, 0.008), youngs = random_in(&random, 5e5, 2e6);
    const double area = 3.141592653589793 * radius * radius,
                 EI = youngs * area * radius * radius / 4;
    const double T = 0.04 * sqrt(1100 * area / EI), density = 1100;
    const bool locks = random_below(&random, 3) == 0, damps = random_below(&random, 2) == 0;
    char formula[512], damping[64] = "";
    *x = (pulse_scene){.of = &all[seed % KEYS]};
    x->duration = durations[random_below(&random, quick ? 1 : 3)];
    x->at = x->duration * random_in(&random, 0.08, 0.92);
    x->width = x->duration * pow(10, random_in(&random, quick ? -2.5 : -3.3, -1.2));
    double narrow = fmax(1, T / x->width), falls = EI / (density * area * 0.008);
    print_pulse(&random, x,
                random_in(&random, 0.1, 0.5) * size_of(x->of->unit, EI, radius, falls, narrow),
                formula);
    bool stretches = x->of->unit == STRETCH || x->of->unit == LENGTHEN;
    if (damps) {
        sprintf(damping, ", viscosity: %.4g", youngs * T * random_in(&random, 1e-3, 3e-2));
    }
    int at = snprintf(x->text, TEXT,
                      "time: {duration: %g}\nrod:\n  model: %s\n%s"
                      "  section: {shape: circle, radius: %.6g}\n"
                      "  material: {youngs_modulus: %.6g, poissons_ratio: 0.45, density: 1100%s}\n",
                      x->duration, locks && !stretches ? "kirchhoff" : "cosserat",
                      strncmp(x->of->key, "segments", 8) == 0 ? "" : "  length: 0.2\n", radius,
                      youngs, damping);
    for (const char *from = x->of->text; *from; from++) {
        if (*from == '@') {
            at += snprintf(x->text + at, TEXT - (size_t)at, "%s", formula);
        } else {
            x->text[at++] = *from;
        }
    }
    x->text[at] = 0;
}

/* ---- the same by steps of its own ------------------------------------------------------------ */

/* Instants every fourth of the width around the pulse. */
static void place_instants(const pulse_scene *x, const solve_rod *rod, solve_events *to)
{
    enum { AROUND = 32 };
    static double times[2 * AROUND + 1];
    to->count = 0;
    to->times = times;
    for (int i = -AROUND; i <= AROUND; i++) {
        double t = (x->at + 0.25 * x->width * i) / rod->scales.time;
        if (t > 0 && t < rod->duration) {
            times[to->count++] = t;
        }
    }
}

/* Positions [TIMES][PLACES][3] at times [TIMES], in units of the rod, and places s. */
static void follow(const pulse_scene *x, const solve_rod *rod, double tolerance, int intervals,
                   const double *times, const double *s, double *to)
{
    static double states[TIMES * NODES_MAX * MOTION_ROWS];
    ad_error error = {.message = ""};
    solve_quadrature *places = NULL;
    solve_events *found = NULL;
    motion *m = NULL;
    solve_energy energies[TIMES];
    integrate_counts counts;
    assert_int_equal(solve_events_create(rod, &found, &error), AD_OK);
    solve_events own = *found;
    place_instants(x, rod, &own);
    assert_int_equal(motion_places_of(rod, &places, &error), AD_OK);
    assert_int_equal(motion_mesh(rod, places, 100 / tolerance, INFINITY, intervals, &m, &error),
                     AD_OK);
    assert_true(motion_nodes(m) <= NODES_MAX);
    const bool composes = motion_is_separable(m) && !scene_locks_strains(&rod->scene);
    fastest *vibration = NULL;
    double frequency = 1;
    assert_int_equal(motion_fastest_create(m, &vibration, &error), AD_OK);
    assert_int_equal(motion_fastest_at_start(vibration, &frequency, &error), AD_OK);
    motion_fastest_free(vibration);
    const integrate_settings settings = {
        .method = INTEGRATE_IMPLICIT, .tolerance = 1e-3 * tolerance, .events = &own};
    ad_status status =
        composes ? motion_compose(m, &settings, TIMES, times, states, energies, &counts, &error)
                 : motion_integrate(m, &settings, TIMES, times, states, energies, &counts, &error);
    if (status != AD_OK) {
        fail_msg("%s", error.message);
    }
    for (size_t i = 0; i < TIMES; i++) {
        solve_state at[PLACES];
        assert_int_equal(motion_at(m, times[i], &error), AD_OK); /* ends as they are driven */
        motion_samples(m, states + i * motion_nodes(m) * MOTION_ROWS, PLACES, s, at);
        for (size_t k = 0; k < PLACES; k++) {
            memcpy(to + (i * PLACES + k) * 3, at[k].position, sizeof at[k].position);
        }
    }
    motion_free(m);
    solve_quadrature_free(places);
    solve_events_free(found);
}

/* ---- judging --------------------------------------------------------------------------------- */

typedef struct outcome {
    double error, estimate, balance, moved, seconds;
    bool warned, refused;
    char text[VERDICT_TEXT + 64];
} outcome;

/* Positions of the solver at the same times and places, over the length. */
static void solve_pulse(const pulse_scene *x, const scene *of, const solve_settings *settings,
                        size_t count, const double *times, const double *s, double *to,
                        outcome *out)
{
    ad_error error = {.message = ""};
    solution *made = NULL;
    solve_report report;
    verdict judged = {0};
    const double length = scene_length(of);
    ad_status status = solution_create(of, settings, count, times, &made, &report, &error);
    if (status != AD_OK && status != AD_NO_MEMORY && out) { /* no answer is no wrong one */
        *out = (outcome){.estimate = NAN, .warned = true, .refused = status != AD_NOT_FINITE};
        snprintf(out->text, sizeof out->text, "%s", error.message);
        return;
    }
    if (status != AD_OK) {
        fail_msg("%s\n%s", error.message, x->text);
    }
    for (size_t i = 0; i < count && to; i++) {
        double values[COLUMNS * PLACES], at[PLACES], t[PLACES];
        for (size_t k = 0; k < PLACES; k++) {
            at[k] = s[k] * length;
            t[k] = times[i];
        }
        assert_int_equal(solution_evaluate(made, COLUMNS, PLACES, at, t, values, &error), AD_OK);
        for (size_t k = 0; k < PLACES * COLUMNS; k++) {
            to[(i * PLACES + k % PLACES) * 3 + k / PLACES] = values[k] / length;
        }
    }
    if (out) {
        solution_verdict(made, of, settings, &report, &judged);
        out->warned = verdict_exit_status(&judged) != 0;
        out->estimate = report.estimate;
        out->balance = report.energy_mismatch;
        snprintf(out->text, sizeof out->text, "%s",
                 out->warned ? verdict_reason_name(verdict_worst(&judged)) : "solved");
    }
    solution_free(made);
}

static bool is_silent(const outcome *out)
{
    bool off = out->error > TIMES_ESTIMATE * out->estimate && out->error > OFF;
    return !out->warned && (off || !(out->balance <= OUT_OF_BALANCE));
}

static void compare(const double *solved, const double *trusted, outcome *out)
{
    out->error = out->moved = 0;
    for (int i = 0; i < TIMES * PLACES; i++) {
        const double *a = solved + i * 3, *b = trusted + i * 3, *c = trusted + i % PLACES * 3;
        out->error = fmax(out->error, hypot(hypot(a[0] - b[0], a[1] - b[1]), a[2] - b[2]));
        out->moved = fmax(out->moved, hypot(hypot(b[0] - c[0], b[1] - c[1]), b[2] - c[2]));
    }
}

static outcome judge(const pulse_scene *x)
{
    const solve_settings settings = {.tolerance = 1e-4};
    double times[TIMES], scaled[TIMES], s[PLACES], by_solver[TIMES * PLACES * 3];
    double trusted[TIMES * PLACES * 3];
    config *made = NULL;
    solve_rod *rod = NULL;
    ad_error error = {.message = ""};
    outcome out = {0};
    ad_status status = prepare_read("scene.yaml", x->text, 0, NULL, &made, &error);
    if (status ==
        AD_BAD_INPUT) { /* such as held ends that are farther apart than the rod is long */
        out = (outcome){.estimate = NAN, .warned = true, .refused = true};
        snprintf(out.text, sizeof out.text, "%s", error.message);
        return out;
    }
    assert_int_equal(status, AD_OK);
    assert_int_equal(solve_rod_create(&made->scene, &rod, &error), AD_OK);
    for (int i = 0; i < TIMES; i++) {
        times[i] = x->at + (x->duration - x->at) * i / (TIMES - 1);
        scaled[i] = fmin(rod->duration, times[i] / rod->scales.time);
    }
    for (int i = 0; i < PLACES; i++) {
        s[i] = (i + 1.0) / PLACES;
    }
    clock_t begun = clock();
    solve_pulse(x, &made->scene, &settings, TIMES, times, s, by_solver, &out);
    out.seconds = (double)(clock() - begun) / CLOCKS_PER_SEC;
    out.error = INFINITY; /* a mesh that is too coarse for waves is not what is looked for */
    for (int nodes = COARSE; nodes <= FINE && is_silent(&out); nodes *= 2) {
        follow(x, rod, settings.tolerance, nodes, scaled, s, trusted);
        compare(by_solver, trusted, &out);
    }
    solve_rod_free(rod);
    config_free(made);
    return out;
}

/* How many were wrong in silence. */
static int judge_all(int count, int first, bool quick)
{
    int silent = 0, warned = 0, refused = 0;
    double seconds = 0, longest = 0;
    for (int i = first; i < first + count; i++) {
        static pulse_scene x;
        make_scene((uint64_t)i, quick, &x);
        outcome out = judge(&x);
        bool bad = is_silent(&out);
        print_message(
            "%4d %-29s width %.1e of %-4g moved %.1e error %.1e estimate %.1e %.1f s %s%s\n", i,
            x.of->key, x.width, x.duration, out.moved, out.error, out.estimate, out.seconds,
            out.text, bad ? "  WRONG IN SILENCE" : "");
        if (bad) {
            print_message("%s\n", x.text);
        }
        silent += bad;
        warned += out.warned && !out.refused;
        refused += out.refused;
        seconds += out.seconds;
        longest = fmax(longest, out.seconds);
    }
    print_message(
        "%d motions, %d refused, %d warned, %d wrong in silence; %.1f s, the longest %.1f "
        "s\n",
        count, refused, warned, silent, seconds, longest);
    if (2 * refused > count && count > 1) {
        fail_msg("%d of %d scenes are refused", refused, count);
    }
    return silent;
}

/* ---- tests ----------------------------------------------------------------------------------- */

static void without_numbers(const char *key, char *to)
{
    while (*key) {
        const char *end = *key == '[' ? strchr(key, ']') : NULL;
        if (end) {
            key = end + 1;
        } else {
            *to++ = *key++;
        }
    }
    *to = 0;
}

/* Each quantity that may vary in time is pulsed here; but for beams, which have a solver of their
 * own, and what manufactured solutions are given by. */
static void test_all_quantities(void **state)
{
    (void)state;
    for (int i = 0; i < scene_field_count; i++) {
        const scene_field *field = &scene_fields[i];
        char key[128];
        bool found = false, varies = field->rule == SCENE_IN_TIME || field->rule == SCENE_AT_END ||
                                     field->rule == SCENE_AT_PLACE || field->rule == SCENE_HELD ||
                                     field->rule == SCENE_EVERYWHERE;
        without_numbers(field->key, key);
        for (int k = 0; k < KEYS; k++) {
            found |= strcmp(key, all[k].key) == 0;
        }
        if (varies && !found && field->part != SCENE_OF_BEAM && field->part != SCENE_OF_EXACT) {
            fail_msg("%s may vary in time, and no pulse is tried", field->key);
        }
    }
}

static void test_pulses(void **state)
{
    (void)state;
    assert_int_equal(judge_all(QUICK, 0, true), 0);
}

/* ---- times that are asked for ---------------------------------------------------------------- */

/* Bits of a motion at a few times, and of its report, where it is asked for at `count` times. */
typedef struct asked {
    double x[COLUMNS * PLACES * TIMES], energies[TIMES];
    solve_report report;
} asked;

static void ask(const scene *of, solve_method method, size_t count, asked *to)
{
    enum { MOST = 61 };
    const solve_settings settings = {.tolerance = 1e-4, .method = method};
    ad_error error = {.message = ""};
    solution *made = NULL;
    double times[MOST];
    const size_t each = (count - 1) / (TIMES - 1);
    for (size_t i = 0; i < count; i++) {
        times[i] = scene_duration(of) * /* the few to the last bit */
                   ((double)(i / each) + (double)(i % each) / (double)each) / (TIMES - 1);
    }
    if (solution_create(of, &settings, count, times, &made, &to->report, &error) != AD_OK) {
        fail_msg("%s", error.message);
    }
    for (size_t i = 0; i < TIMES; i++) {
        double s[PLACES], t[PLACES];
        solve_energy energy;
        for (size_t k = 0; k < PLACES; k++) {
            s[k] = scene_length(of) * (double)(k + 1) / PLACES;
            t[k] = times[i * each];
        }
        assert_int_equal(
            solution_evaluate(made, COLUMNS, PLACES, s, t, to->x + i * COLUMNS * PLACES, &error),
            AD_OK);
        assert_int_equal(solution_energy(made, times[i * each], &energy, &error), AD_OK);
        to->energies[i] = energy.kinetic + energy.strain + energy.work;
    }
    solution_free(made);
}

/* Where and when a motion is looked at changes no bit of it, nor its estimate and balance: steps
 * that are composed, implicit ones, those of modes. */
static void test_times_asked_for(void **state)
{
    (void)state;
    static const struct {
        const char *change;
        solve_method method;
    } rows[] = {{"rod.model=cosserat", SOLVE_COLLOCATION},
                {"rod.model=kirchhoff", SOLVE_COLLOCATION},
                {"rod.material.viscosity=100", SOLVE_COLLOCATION},
                {"loads.quadratic_drag=0.1", SOLVE_COLLOCATION},
                {"rod.model=cosserat", SOLVE_MODES},
                {"rod.material.viscosity=100", SOLVE_MODES}};
    static const char text[] =
        "time: {duration: 0.1}\n"
        "rod: {length: 0.2, section: {shape: circle, radius: 0.005},\n"
        "  material: {youngs_modulus: 1e6, poissons_ratio: 0.45, density: 1100}}\n"
        "tendons: [{offset: [0.003, 0], tension: '0.3*exp(-((t-0.07)/0.004)^2)'}]\n"
        "loads: {gravity: [0, 3, -9.81]}\n";
    for (size_t i = 0; i < sizeof rows / sizeof *rows; i += FARTHER(1)) {
        static asked few, many;
        config *made = read_with(text, rows[i].change);
        ask(&made->scene, rows[i].method, TIMES, &few);
        ask(&made->scene, rows[i].method, 10 * (TIMES - 1) + 1, &many);
        assert_memory_equal(few.x, many.x, sizeof few.x);
        assert_memory_equal(few.energies, many.energies, sizeof few.energies);
        assert_true(few.report.estimate == many.report.estimate);
        assert_true(few.report.energy_mismatch == many.report.energy_mismatch);
        assert_int_equal(few.report.time_steps, many.report.time_steps);
        config_free(made);
    }
}

int main(int count, char **arguments)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_all_quantities),
        cmocka_unit_test(test_pulses),
    };
    const struct CMUnitTest alike[] = {cmocka_unit_test(test_times_asked_for)};
    if (count > 1) {
        return judge_all(atoi(arguments[1]), count > 2 ? atoi(arguments[2]) : 0, false) > 0;
    }
    return run_with_alike(tests, alike, NULL, NULL);
}
