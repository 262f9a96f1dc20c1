/* Beams of small deflection by the classical solver: textbook deflections, exact modes,
 * manufactured motions. Error bounds are three to thirty times what is measured where no other
 * reason is given: rounding, which most of it is, turns on the kernels that OpenBLAS chose. */
#include "near.h"
#include "solve_memory.h"

#include "physics/beam/beam.h"
#include "physics/solve/solve.h"
#include "quantity_testing.h"
#include "tools/prepare/prepare.h"

#include <string.h>

static const double pi = 3.14159265358979323846;

enum { POINTS = 21 };

typedef struct solved {
    config *settings;
    solution *solution;
    solve_report report;
} solved;

static solved solve_with(const char *path, const char *text, solve_settings settings, size_t count,
                         const double *times)
{
    ad_error error = {.message = ""};
    solved x = {.settings = NULL};
    if (prepare_read(path, text, 0, NULL, &x.settings, &error) != AD_OK ||
        solution_create(&x.settings->scene, &settings, count, times, &x.solution, &x.report,
                        &error) != AD_OK) {
        fail_msg("%s", error.message);
    }
    return x;
}

static void release(solved *x)
{
    solution_free(x->solution);
    config_free(x->settings);
}

/* values [BEAM_COLUMNS][POINTS] at equal distances and one time. */
static void evaluate(const solved *x, double time, double *s, double *values)
{
    double t[POINTS];
    for (int i = 0; i < POINTS; i++) {
        s[i] = scene_length(&x->settings->scene) * i / (POINTS - 1);
        t[i] = time;
    }
    ad_error error = {.message = ""};
    if (solution_evaluate(x->solution, BEAM_COLUMNS, POINTS, s, t, values, &error) != AD_OK) {
        fail_msg("%s", error.message);
    }
}

/* Largest error of a column against a formula of s and t, relative to its largest value. */
static double error_from(const solved *x, quantity formula, int column, double time)
{
    double s[POINTS], values[BEAM_COLUMNS * POINTS], off = 0, size = 0;
    evaluate(x, time, s, values);
    for (int i = 0; i < POINTS; i++) {
        double exact = quantity_value(formula, s[i], time);
        double here = fabs(values[column * POINTS + i] - exact);
        off = here <= off ? off : here;
        size = fmax(size, fabs(exact));
    }
    return size > 0 ? off / size : off;
}

static double error_of(const solved *x, const char *formula, int column, double time)
{
    return error_from(x, Q(formula), column, time);
}

/* ---- at rest --------------------------------------------------------------------------------- */

#define BEAM "rod: {model: euler_bernoulli, length: 1, stiffness: {bending: [1, 1]}}\n"
#define SHEARING                                                                                   \
    "rod: {model: timoshenko, length: 1, stiffness: {bending: [1, 1], shear: [8, 8]}}\n"
#define ENDS(a, b) "boundary: {start: {type: " a "}, end: {type: " b "}}\n"

/* Deflection, slope, V, M; from EI w_ssss = q by hand. */
static const struct {
    const char *scene, *exact[4];
} at_rest[] = {
    {BEAM ENDS("clamped", "free") "beam: {force: -1}\n",
     {"-(6*s^2 - 4*s^3 + s^4)/24", "-(3*s - 3*s^2 + s^3)/6", "s - 1", "-(s - 1)^2/2"}},
    {BEAM ENDS("pinned", "pinned") "beam: {force: 1}\n",
     {"(s - 2*s^3 + s^4)/24", "(1 - 6*s^2 + 4*s^3)/24", "1/2 - s", "(s^2 - s)/2"}},
    {BEAM ENDS("clamped", "clamped") "beam: {force: 1}\n",
     {"s^2*(1 - s)^2/24", "s*(1 - s)*(1 - 2*s)/12", "1/2 - s", "(1 - 6*s + 6*s^2)/12"}},
    {BEAM ENDS("clamped", "pinned") "beam: {force: 1}\n",
     {"s^2*(1 - s)*(3 - 2*s)/48", "(8*s^3 - 15*s^2 + 6*s)/48", "5/8 - s", "s^2/2 - 5*s/8 + 1/8"}},
    {BEAM ENDS("clamped", "loaded") "beam: {tip: {force: 2, moment: -0.5}}\n",
     {"s^2 - s^3/3 - s^2/4", "2*s - s^2 - s/2", "2", "2 - 2*s - 0.5"}},
    {BEAM ENDS("loaded", "clamped") "beam: {base: {force: 6, moment: 2}}\n",
     {"2 - 3*s + s^3 - (1 - s)^2", "3*s^2 - 3 + 2*(1 - s)", "-6", "6*s - 2"}},
    {BEAM ENDS("clamped", "free") "beam: {moment: 1}\n",
     {"s^2/2 - s^3/6", "s - s^2/2", "0", "1 - s"}},
    {BEAM ENDS("clamped", "free") "beam: {force: 'where(s-0.5, 1, 0)'}\n",
     {"where(s-0.5, 7/192 + (s-0.5)*7/48 + ((1-s)^4 - 1/16)/24, 3*s^2/16 - s^3/12)",
      "where(s-0.5, 7/48 - (1-s)^3/6, 3*s/8 - s^2/4)", "where(s-0.5, 1-s, 1/2)",
      "where(s-0.5, (1-s)^2/2, 3/8 - s/2)"}},
    {BEAM ENDS("free", "free") "beam: {force: 5 + s, foundation: 10}\n",
     {"0.5 + s/10", "0.1", "0", "0"}},
    {SHEARING ENDS("clamped", "loaded") "beam: {tip: {force: 1}}\n",
     {"s^2/2 - s^3/6 + s/8", "s - s^2/2", "1", "1 - s"}},
    {SHEARING ENDS("pinned", "pinned") "beam: {force: 1}\n",
     {"(s - 2*s^3 + s^4)/24 + (s - s^2)/16", "(1 - 6*s^2 + 4*s^3)/24", "1/2 - s", "(s^2 - s)/2"}},
    {"rod: {model: timoshenko, length: 3, stiffness: {bending: [7, 7], shear: [5, 5]}}\n" ENDS(
         "clamped", "free") "beam: {force: 1}\n",
     {"s^2*(54 - 12*s + s^2)/168 + (3*s - s^2/2)/5", "s*(27 - 9*s + s^2)/42", "3 - s",
      "(3 - s)^2/2"}}};

static void test_polynomials(void **state)
{
    (void)state;
    for (size_t i = 0; i < sizeof at_rest / sizeof *at_rest; i++) {
        solved x = solve_with("beam.yaml", at_rest[i].scene, (solve_settings){.tolerance = 1e-10},
                              0, NULL);
        for (int column = 0; column < 4; column++) {
            double error = error_of(&x, at_rest[i].exact[column], column, 0);
            if (!(error <= 1e-13)) { /* rounding */
                fail_msg("%s column %d: %g", at_rest[i].scene, column, error);
            }
        }
        assert_true(x.report.estimate <= 1e-13 && x.report.load_fraction == 1);
        release(&x);
    }
}

#define TAPERED "rod: {model: euler_bernoulli, length: 1, stiffness: {bending: [1 + s, 2]}}\n"
#define TAPERED_SHEARING                                                                           \
    "rod: {model: timoshenko, length: 1, stiffness: {bending: [1 + s, 2], shear: [1, 8*(1 + "      \
    "s)]}}\n"

/* Deflection, slope, V, M of cantilevers that grow stiffer towards their tips; from M/EI by hand.
 */
static void test_tapered(void **state)
{
    (void)state;
    static const char *const rows[][5] = {
        {TAPERED ENDS("clamped", "loaded") "beam: {tip: {force: 1}}\n",
         "2*((1 + s)*log(1 + s) - s) - s^2/2", "2*log(1 + s) - s", "1", "1 - s"},
        {TAPERED ENDS("clamped", "free") "beam: {force: 1}\n",
         "s^3/12 - 3*s^2/4 + 2*((1 + s)*log(1 + s) - s)", "s^2/4 - 3*s/2 + 2*log(1 + s)", "1 - s",
         "(1 - s)^2/2"},
        {TAPERED_SHEARING ENDS("clamped", "loaded") "beam: {tip: {force: 1}}\n",
         "2*((1 + s)*log(1 + s) - s) - s^2/2 + log(1 + s)/8", "2*log(1 + s) - s", "1", "1 - s"}};
    for (size_t i = 0; i < sizeof rows / sizeof *rows; i++) {
        solved x =
            solve_with("beam.yaml", rows[i][0], (solve_settings){.tolerance = 1e-12}, 0, NULL);
        for (int column = 0; column < 4; column++) {
            double error = error_of(&x, rows[i][1 + column], column, 0);
            if (!(error <= 1e-13)) { /* rounding */
                fail_msg("%s column %d: %g", rows[i][0], column, error);
            }
        }
        assert_true(x.report.estimate <= 1e-12);
        release(&x);
    }
}

#define SINE                                                                                       \
    BEAM ENDS("pinned",                                                                            \
              "pinned") "beam: {foundation: 1e3*(1 + s), force: (pi^4 + 1e3*(1 + s))*sin(pi*s)}\n"

/* One element of more and more points: faster than any power. */
static void test_order_at_rest(void **state)
{
    (void)state;
    double before = 1;
    for (int nodes = 3; nodes <= 9; nodes += 2) {
        solved x = solve_with("beam.yaml", SINE, (solve_settings){.nodes = nodes}, 0, NULL);
        double error = error_of(&x, "sin(pi*s)", 0, 0);
        print_message("%d nodes: %.1e\n", nodes, error);
        assert_int_equal(x.report.nodes, nodes);
        assert_true(isnan(x.report.estimate));
        assert_true(error < before / (nodes > 3 ? 20 : 2));
        before = error;
        release(&x);
    }
}

/* Layers as thin as a hundredth of the beam: Hetenyi 1946, a long beam with a load at its end,
 * w = 2 b/k exp(-b s) cos(b s), b = (k/4)^(1/4), here 100. */
static void test_stiff_foundation(void **state)
{
    (void)state;
    solved x = solve_with("beam.yaml",
                          BEAM ENDS("loaded", "free") "beam: {base: {force: 1}, foundation: 4e8}\n",
                          (solve_settings){.tolerance = 1e-10}, 0, NULL);
    assert_true(x.report.estimate <= 1e-10);
    assert_near(error_of(&x, "5e-7*exp(-100*s)*cos(100*s)", 0, 0), 0, 1e-11);
    assert_near(error_of(&x, "-5e-5*exp(-100*s)*(cos(100*s) + sin(100*s))", 1, 0), 0, 1e-11);
    release(&x);
}

/* ---- in motion ------------------------------------------------------------------------------- */

/* One period of a mode; the columns of the Timoshenko beam are those its configuration tells. */
static void test_free_vibration(void **state)
{
    (void)state;
    static const char *const paths[2] = {"configs/beam_vibration.yaml",
                                         "configs/timoshenko_vibration.yaml"};
    static const char *const columns[BEAM_COLUMNS] = {
        "0.05*sin(pi*s)*cos(9.4299468776380748*t)",
        "0.05*2.9340200437442482*cos(pi*s)*cos(9.4299468776380748*t)",
        "0.05*136.36363636363637*(pi - 2.9340200437442482)*cos(pi*s)*cos(9.4299468776380748*t)",
        "-0.05*pi*2.9340200437442482*sin(pi*s)*cos(9.4299468776380748*t)",
        "-0.05*9.4299468776380748*sin(pi*s)*sin(9.4299468776380748*t)",
        "-0.05*9.4299468776380748*2.9340200437442482*cos(pi*s)*sin(9.4299468776380748*t)"};
    /* Rates and V, which are third derivatives of the deflection, follow it at a distance. */
    static const double bounds[BEAM_COLUMNS] = {1e-12, 3e-12, 1e-9, 3e-11, 1e-10, 1e-10};
    for (int which = 0; which < 2; which++) {
        ad_error error = {.message = ""};
        config *settings;
        assert_int_equal(prepare_read(paths[which], NULL, 0, NULL, &settings, &error), AD_OK);
        double period = scene_duration(&settings->scene);
        const double times[3] = {0.3 * period, 0.71 * period, period};
        solved x = solve_with(paths[which], NULL, (solve_settings){.tolerance = 1e-11}, 3, times);
        assert_true(x.report.estimate <= 1e-11);
        for (int i = 0; i < 3; i++) {
            assert_near(error_from(&x, settings->settings.reference_deflection, 0, times[i]), 0,
                        1e-11);
            for (int column = 0; column < BEAM_COLUMNS && which == 1 && i < 2; column++) {
                double off = error_of(&x, columns[column], column, times[i]);
                print_message("column %d: %.1e\n", column, off);
                assert_true(off <= bounds[column]);
            }
        }
        release(&x);
        config_free(settings);
    }
}

/* As slender as a hair: kGA L^2/EI = 1e8, rhoI/(rhoA L^2) = 3.4e-9; modes of shear swing ten
 * thousand times and more for one of bending. */
static void test_slender_vibration(void **state)
{
    (void)state;
    static const char text[] =
        "rod: {model: timoshenko, length: 1, stiffness: {bending: [1, 1], shear: [1e8, 1e8]},\n"
        "  inertia: {mass_per_length: 1, rotary: [3.4e-9, 3.4e-9, 1]}}\n"
        "time: {duration: 0.63661981446492045509}\n" ENDS(
            "pinned", "pinned") "beam:\n"
                                "  initial:\n"
                                "    deflection: 0.05*sin(pi*s)\n"
                                "    slope: 0.05*3.141592343527067442096*cos(pi*s)\n";
    static const char exact[] = "0.05*sin(pi*s)*cos(9.869603748448529769763*t)";
    const double time = 0.5;
    solved x = solve_with("beam.yaml", text, (solve_settings){.tolerance = 1e-10}, 1, &time);
    assert_true(x.report.estimate <= 1e-10);
    assert_near(error_of(&x, exact, 0, time), 0, 1e-10);
    assert_near(error_of(&x, exact, 0, 0.63661981446492045509), 0, 1e-10);
    release(&x);
}

/* Every term of the equations, V and M at the tip: w = s^4 sin 2t; k = 3 + s, c = 0.7, mu = s cos
 * t.
 */
static const char forced_bending[] =
    "rod: {model: euler_bernoulli, length: 1, stiffness: {bending: [2, 2]},\n"
    "  inertia: {mass_per_length: 1.5}}\n"
    "time: {duration: 3}\n"
    "loads: {drag: 0.7}\n" ENDS(
        "clamped",
        "loaded") "beam:\n"
                  "  force: (48 - 6*s^4 + (3 + s)*s^4)*sin(2*t) + 1.4*s^4*cos(2*t) + cos(t)\n"
                  "  moment: s*cos(t)\n"
                  "  foundation: 3 + s\n"
                  "  tip: {force: -48*sin(2*t) - cos(t), moment: 24*sin(2*t)}\n"
                  "  initial: {velocity: 2*s^4}\n";

/* w = s^2 sin 2t, psi = s^3 cos 3t; EI = 2, kGA = 30, rhoI = 0.05. */
static const char forced_shearing[] =
    "rod: {model: timoshenko, length: 1, stiffness: {bending: [2, 2], shear: [30, 30]},\n"
    "  inertia: {mass_per_length: 1.5, rotary: [0.05, 0.05, 0.1]}}\n"
    "time: {duration: 3}\n"
    "loads: {drag: 0.7}\n" ENDS(
        "clamped", "loaded") "beam:\n"
                             "  force: (-6*s^2 - 60 + (3 + s)*s^2)*sin(2*t) + 90*s^2*cos(3*t) + "
                             "1.4*s^2*cos(2*t)\n"
                             "  moment: (-0.45*s^3 - 12*s + 30*s^3)*cos(3*t) - 60*s*sin(2*t)\n"
                             "  foundation: 3 + s\n"
                             "  tip: {force: 60*sin(2*t) - 30*cos(3*t), moment: 6*cos(3*t)}\n"
                             "  initial: {velocity: 2*s^2, slope: s^3, slope_rate: 0}\n";

/* The same of beams whose stiffness and inertia vary, free at the tip and held at both ends. */
static const char tapered_bending[] =
    "rod: {model: euler_bernoulli, length: 1, stiffness: {bending: [1 + s, 2]},\n"
    "  inertia: {mass_per_length: 2 - s}}\n"
    "time: {duration: 3}\n"
    "beam:\n"
    "  force: (12*(6*s - 2) - 1.69*(2 - s)*s^2*(6 - 4*s + s^2))*cos(1.3*t)\n"
    "  initial: {deflection: s^2*(6 - 4*s + s^2)}\n";

static const char tapered_shearing[] =
    "rod: {model: timoshenko, length: 1,\n"
    "  stiffness: {bending: [1 + s, 2], shear: [1, 8*(1 + s)]},\n"
    "  inertia: {mass_per_length: 2 - s, rotary: [0.05*(1 + s), 1, 1]}}\n"
    "time: {duration: 3}\n"
    "boundary: {end: {type: clamped}}\n"
    "beam:\n"
    "  force: (-1.69*(2 - s)*sin(pi*s)^2\n"
    "    - 8*(pi - 1)*(sin(2*pi*s) + 2*pi*(1 + s)*cos(2*pi*s)))*cos(1.3*t)\n"
    "  moment: (-0.0845*(1 + s)*sin(2*pi*s) - 8*(pi - 1)*(1 + s)*sin(2*pi*s)\n"
    "    - 2*pi*(cos(2*pi*s) - 2*pi*(1 + s)*sin(2*pi*s)))*cos(1.3*t)\n"
    "  initial: {deflection: sin(pi*s)^2, slope: sin(2*pi*s)}\n";

static void test_forced_motion(void **state)
{
    (void)state;
    static const struct {
        const char *scene;
        double rounding; /* how much more of it than in the first */
        const char *exact[BEAM_COLUMNS];
    } rows[] = {
        {forced_bending,
         1,
         {"s^4*sin(2*t)", "4*s^3*sin(2*t)", "-48*s*sin(2*t) - s*cos(t)", "24*s^2*sin(2*t)",
          "2*s^4*cos(2*t)", "8*s^3*cos(2*t)"}},
        {forced_shearing,
         1,
         {"s^2*sin(2*t)", "s^3*cos(3*t)", "60*s*sin(2*t) - 30*s^3*cos(3*t)", "6*s^2*cos(3*t)",
          "2*s^2*cos(2*t)", "-3*s^3*sin(3*t)"}},
        {tapered_bending,
         1,
         {"s^2*(6 - 4*s + s^2)*cos(1.3*t)", "4*s*(3 - 3*s + s^2)*cos(1.3*t)",
          "12*(1 - s)*(1 + 3*s)*cos(1.3*t)", "12*(1 + s)*(1 - s)^2*cos(1.3*t)",
          "-1.3*s^2*(6 - 4*s + s^2)*sin(1.3*t)", "-5.2*s*(3 - 3*s + s^2)*sin(1.3*t)"}},
        {tapered_shearing,
         10,
         {"sin(pi*s)^2*cos(1.3*t)", "sin(2*pi*s)*cos(1.3*t)",
          "8*(pi - 1)*(1 + s)*sin(2*pi*s)*cos(1.3*t)", "2*pi*(1 + s)*cos(2*pi*s)*cos(1.3*t)",
          "-1.3*sin(pi*s)^2*sin(1.3*t)", "-1.3*sin(2*pi*s)*sin(1.3*t)"}}};
    static const double bounds[BEAM_COLUMNS] = {1e-12, 1e-12, 1e-10, 1e-11, 1e-10, 1e-10};
    const double times[3] = {0.7, 1.9, 3};
    for (size_t row = 0; row < sizeof rows / sizeof *rows; row++) {
        solved x = solve_with("beam.yaml", rows[row].scene, (solve_settings){.tolerance = 1e-10}, 3,
                              times);
        for (int i = 0; i < 3; i++) {
            for (int column = 0; column < BEAM_COLUMNS; column++) {
                double error = error_of(&x, rows[row].exact[column], column, times[i]);
                print_message("%zu column %d: %.1e\n", row, column, error);
                assert_true(error <= rows[row].rounding * bounds[column]);
            }
        }
        release(&x);
    }
}

/* Nothing holds it: it falls and turns as a rigid body. */
static void test_rigid_motion(void **state)
{
    (void)state;
    static const char text[] =
        "rod: {model: euler_bernoulli, length: 1, stiffness: {bending: [1, 1]},\n"
        "  inertia: {mass_per_length: 2}}\n"
        "time: {duration: 4}\n" ENDS("free", "free") "beam: {force: 3, initial: {velocity: s}}\n";
    solved x =
        solve_with("beam.yaml", text, (solve_settings){.tolerance = 1e-10}, 1, (double[]){1.3});
    for (int i = 0; i < 2; i++) {
        double time = i == 0 ? 1.3 : 4;
        assert_near(error_of(&x, "0.75*t^2 + s*t", 0, time), 0, 1e-11);
        assert_near(error_of(&x, "t", 1, time), 0, 1e-11);
        assert_near(error_of(&x, "1.5*t + s", 4, time), 0, 1e-10);
    }
    release(&x);
}

/* The error is no larger than its estimate. */
static void test_estimate(void **state)
{
    (void)state;
    static const char sudden[] =
        "rod: {model: euler_bernoulli, length: 1, stiffness: {bending: [1, 1]},\n"
        "  inertia: {mass_per_length: 1}}\n"
        "time: {duration: 0.5}\n" ENDS("pinned", "pinned") "beam: {force: 1}\n";
    const double t = 0.5;
    solved x = solve_with("beam.yaml", sudden, (solve_settings){.tolerance = 1e-5}, 1, &t);
    double exact = 0, s = 0.5, w; /* at mid-span, a series over modes */
    for (int n = 1; n < 1000; n += 2) {
        double k = n * pi, omega = k * k, sign = n % 4 == 1 ? 1 : -1;
        exact += sign * 4 / k * (1 - cos(omega * t)) / (omega * omega);
    }
    assert_int_equal(solution_evaluate(x.solution, 1, 1, &s, &t, &w, NULL), AD_OK);
    print_message("error %.1e, estimate %.1e, %d nodes\n", fabs(w - exact) / exact,
                  x.report.estimate, x.report.nodes);
    assert_true(fabs(w - exact) <= x.report.estimate * exact && x.report.estimate <= 1e-5);
    release(&x);
}

/* ---- what is refused ------------------------------------------------------------------------- */

static void refuse(const char *path, solve_settings asked, const char *words)
{
    ad_error error = {.message = ""};
    config *settings = NULL;
    solution *x = NULL;
    solve_report report;
    assert_int_equal(prepare_read(path, NULL, 0, NULL, &settings, &error), AD_OK);
    assert_int_equal(solution_create(&settings->scene, &asked, 0, NULL, &x, &report, &error),
                     AD_BAD_ARGUMENT);
    assert_null(x);
    if (!strstr(error.message, words)) {
        fail_msg("'%s' lacks '%s'", error.message, words);
    }
    config_free(settings);
}

/* The tip of a cantilever after blows of an impulse of 1 in all from the time `from` on, `width`
 * long: all modes, 4/w sin(w t) each, set off by a constant force. */
static double struck(double t, double from, double width)
{
    enum { MODES = 3000 };
    double sum = 0;
    for (int n = 1; n <= MODES; n++) {
        double k = (n - 0.5) * pi;
        for (int i = 0; i < 60 && n < 10; i++) { /* cos k cosh k = -1 */
            k = (n - 0.5) * pi - (n % 2 ? -1 : 1) * asin(1 / cosh(k));
        }
        double w = k * k, x = w * width / 2;
        sum += 4 / w * sin(w * (t - from - width / 2)) * sin(x) / x;
    }
    return sum;
}

/* Shorter than any step of time; of many mild ones each has its step. */
static void test_blow(void **state)
{
    const double from = 0.5, widths[] = {1e-4, 1e-3};
    (void)state;
    for (int i = 0; i < 2; i++) {
        char text[400];
        snprintf(text, sizeof text,
                 "rod: {model: euler_bernoulli, length: 1, stiffness: {bending: [1, 1]},\n"
                 "  inertia: {mass_per_length: 1}}\n" ENDS(
                     "clamped",
                     "loaded") "beam: {tip: {force: 'where((t-%.17g)*(%.17g-t), %.17g, 0)'}}\n"
                               "time: {duration: 1}\n",
                 from, from + widths[i], 1 / widths[i]);
        const double end = 1;
        solved x = solve_with("blow.yaml", text, (solve_settings){.tolerance = 1e-3}, 1, &end);
        double s[POINTS], values[BEAM_COLUMNS * POINTS], exact = struck(1, from, widths[i]);
        evaluate(&x, 1, s, values);
        print_message("blow of %g: tip %.6f, exactly %.6f, estimate %.1e\n", widths[i],
                      values[POINTS - 1], exact, x.report.estimate);
        /* relative to the largest deflection, which is no smaller than here; a blow takes all
         * modes, so that the estimate cannot be small */
        assert_near(values[POINTS - 1], exact, 10 * x.report.estimate * x.report.size);
        assert_true(x.report.estimate < 0.02);
        release(&x);
    }
}

static void test_refusals(void **state)
{
    (void)state;
    refuse("configs/beam_vibration.yaml", (solve_settings){.nodes = 129, .tolerance = 1},
           "129 nodes; allowed for a beam in motion: at most 128");
    refuse("configs/beam_cantilever.yaml", (solve_settings){.perturbation = 1, .tolerance = 1},
           "beams of small deflection do not buckle");
}

static void test_no_memory(void **state)
{
    (void)state;
    static const char *const paths[] = {"configs/beam_cantilever.yaml",
                                        "configs/timoshenko_vibration.yaml"};
    const solve_settings rough = {.tolerance = 1e-2};
    for (int i = 0; i < 2; i++) {
        config *settings;
        assert_int_equal(prepare_read(paths[i], NULL, 0, NULL, &settings, NULL), AD_OK);
        check_no_memory(&settings->scene, &rough, 0, NULL, 0, 1);
        config_free(settings);
    }
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_polynomials),    cmocka_unit_test(test_tapered),
        cmocka_unit_test(test_order_at_rest),  cmocka_unit_test(test_stiff_foundation),
        cmocka_unit_test(test_free_vibration), cmocka_unit_test(test_slender_vibration),
        cmocka_unit_test(test_forced_motion),  cmocka_unit_test(test_rigid_motion),
        cmocka_unit_test(test_estimate),       cmocka_unit_test(test_blow),
        cmocka_unit_test(test_refusals),       cmocka_unit_test(test_no_memory),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
