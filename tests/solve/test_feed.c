/* Rods that move through a port, or whose base is turned: rigid motion and the beam that is
 * deployed, in closed form or by another equation; slow insertion against equilibria; energy with
 * the power of the port; what follows an input against the same by a formula, and its derivatives
 * against differences. */
#include "fewer.h"
#include "modes_testing.h"
#include "near.h"

#include "physics/chain/reduced.h"
#include "physics/solve/modes_motion.h"
#include "physics/solve/solve.h"

#include <stdlib.h>
#include <string.h>

#define MATTER                                                                                     \
    "      section: {shape: circle, radius: 0.002},\n"                                             \
    "      material: {youngs_modulus: 1.0e8, poissons_ratio: 0.3, density: 1200"
#define ROD(inserted, more)                                                                        \
    "rod: {model: kirchhoff, length: 0.3, inserted: \"" inserted "\",\n" MATTER more "}}\n"

typedef struct fed {
    config *settings;
    solve_rod *rod;
    modes_solution *motion;
    solve_report report;
} fed;

static fed move(const char *text, double tolerance, size_t count, const double *seconds)
{
    ad_error error = {.message = ""};
    fed x = {0};
    double times[16];
    if (prepare_read("fed.yaml", text, 0, NULL, &x.settings, &error) != AD_OK ||
        solve_rod_create(&x.settings->scene, &x.rod, &error) != AD_OK) {
        fail_msg("%s", error.message);
    }
    for (size_t i = 0; i < count; i++) {
        times[i] = seconds[i] / x.rod->scales.time;
    }
    const solve_settings settings = {.tolerance = tolerance};
    if (modes_motion_solve(x.rod, &settings, count, times, &x.motion, &x.report, &error) != AD_OK) {
        fail_msg("%s", error.message);
    }
    return x;
}

static solve_state look(const fed *x, size_t which, double s)
{
    ad_error error = {.message = ""};
    solve_state state;
    assert_int_equal(modes_motion_at(x->motion, which, 1, &s, &state, &error), AD_OK);
    return state;
}

static void discard_fed(fed *x)
{
    modes_motion_free(x->motion);
    solve_rod_free(x->rod);
    config_free(x->settings);
}

/* A straight rod goes as a whole: all of it at the speed of the feed, the port pushes what is out
 * with mass times acceleration, and the energy is that of the mass that is out. */
static void test_rigid(void **state)
{
    (void)state;
    static const char text[] = ROD("0.1+0.05*t+0.2*t^2", "") "time: {duration: 0.4}\n";
    const double t[2] = {0.2, 0.4}, pi = 3.141592653589793;
    const double mass = 1200 * pi * 0.002 * 0.002;
    fed x = move(text, 1e-8, 2, t);
    const rod_scales *scales = &x.rod->scales;
    const double unit = scales->length / scales->time;
    for (size_t i = 0; i < 2; i++) {
        const double out = 0.1 + 0.05 * t[i] + 0.2 * t[i] * t[i], speed = 0.05 + 0.4 * t[i];
        for (int k = 0; k <= 4; k++) {
            const double s = 0.25 * k;
            const solve_state at = look(&x, i, s);
            assert_near(at.position[2] * scales->length, s * out, 1e-10);
            assert_near(at.velocity[2] * unit, speed, 1e-8);
            assert_near(at.velocity[0], 0, 1e-12);
            assert_near(at.force[2] * scales->force, -mass * out * (1 - s) * 0.4, 1e-9);
        }
        const solve_energy *energy = modes_motion_energies(x.motion) + i;
        const double joule = scales->force * scales->length;
        assert_near(energy->kinetic * joule, 0.5 * mass * out * speed * speed, 1e-10);
    }
    assert_true(x.report.energy_mismatch < 1e-8);
    discard_fed(&x);
}

/* A beam that is deployed, by its equation where the place x and not the material is held
 * (Tabarrok, Leech, Kim 1974), with q across and P = -m V_t (L - x) along it:
 *
 *   m (w_tt + 2 V w_xt + V_t w_x + V^2 w_xx) + EI w_xxxx - (P w_x)_x = q
 *
 * by Galerkin's method with y^2 .. y^(N+1), y = x/L(t), and Runge and Kutta's. */
enum { N = 6 };

static void beam_rate(double t, const double *a, double EI, double m, double q, double *rate)
{
    const double L = 0.1 + 0.4 * t * t, V = 0.8 * t, V_t = 0.8;
    double M[N][N + 1] = {{0}};
    static const double node[5] = {0.04691007703066802, 0.23076534494715845, 0.5,
                                   0.7692346550528415, 0.9530899229693319};
    static const double weight[5] = {0.11846344252809454, 0.23931433524968324, 0.28444444444444444,
                                     0.23931433524968324, 0.11846344252809454};
    for (int cell = 0; cell < 20; cell++) { /* polynomials of degree 2 N + 2 in 4 would do */
        const double y = (cell / 5 + node[cell % 5]) / 4, by = L * weight[cell % 5] / 4;
        double f[N], f1[N], f2[N], still = 0, bend = 0, slope = 0;
        for (int i = 0; i < N; i++) {
            f[i] = pow(y, i + 2);
            f1[i] = (i + 2) * pow(y, i + 1);
            f2[i] = (i + 2) * (i + 1) * pow(y, i);
        }
        for (int i = 0; i < N; i++) {
            const double w_x = f1[i] / L, w_xx = f2[i] / L / L;
            /* at held x: y_t = -y V/L */
            const double w_xt_of_rate = f1[i] / L, w_xt = -(f2[i] * y + f1[i]) * V / L / L;
            const double w_tt_of_rate = -2 * f1[i] * y * V / L;
            const double w_tt =
                f2[i] * y * y * V * V / L / L + f1[i] * (2 * y * V * V / L / L - y * V_t / L);
            still += (w_tt_of_rate + 2 * V * w_xt_of_rate) * a[N + i] +
                     (w_tt + 2 * V * w_xt + V_t * w_x + V * V * w_xx) * a[i];
            bend += w_xx * a[i];
            slope += w_x * a[i];
        }
        const double P = -m * V_t * L * (1 - y);
        for (int i = 0; i < N; i++) {
            for (int k = 0; k < N; k++) {
                M[i][k] += by * m * f[i] * f[k];
            }
            M[i][N] +=
                by * (f[i] * (q - m * still) - EI * bend * f2[i] / L / L - P * slope * f1[i] / L);
        }
    }
    for (int i = 0; i < N; i++) { /* Gauss */
        for (int r = 0; r < N; r++) {
            const double part = r == i ? 0 : M[r][i] / M[i][i];
            for (int c = i; c <= N; c++) {
                M[r][c] -= part * M[i][c];
            }
        }
    }
    for (int i = 0; i < N; i++) {
        rate[i] = a[N + i];
        rate[N + i] = M[i][N] / M[i][i];
    }
}

static double deployed(double end, double EI, double m, double q)
{
    enum { STEPS = 40000 };
    double a[2 * N] = {0}, k[4][2 * N], b[2 * N], sum = 0;
    const double h = end / STEPS;
    for (int step = 0; step < STEPS; step++) {
        const double t = step * h;
        for (int i = 0; i < 4; i++) {
            const double part = i == 0 ? 0 : i < 3 ? 0.5 * h : h;
            for (int c = 0; c < 2 * N; c++) {
                b[c] = a[c] + (i > 0 ? part * k[i - 1][c] : 0);
            }
            beam_rate(t + part, b, EI, m, q, k[i]);
        }
        for (int c = 0; c < 2 * N; c++) {
            a[c] += h / 6 * (k[0][c] + 2 * k[1][c] + 2 * k[2][c] + k[3][c]);
        }
    }
    for (int i = 0; i < N; i++) {
        sum += a[i];
    }
    return sum;
}

static void test_deployed(void **state)
{
    (void)state;
    static const char text[] = "rod: {model: kirchhoff, length: 0.3, inserted: 0.1+0.4*t^2,\n      "
                               "section: {shape: circle, radius: 0.0002},\n      material: "
                               "{youngs_modulus: 1.0e10, poissons_ratio: 0.3, density: 1200}}\n"
                               "loads: {gravity: [0.1, 0, 0]}\n"
                               "time: {duration: 0.5}\n";
    const double t[2] = {0.25, 0.5}, pi = 3.141592653589793;
    const double area = pi * 2e-4 * 2e-4, EI = 1e10 * area * 2e-4 * 2e-4 / 4, m = 1200 * area;
    fed x = move(text, 1e-8, 2, t);
    for (size_t i = 0; i < 2; i++) {
        const double tip = look(&x, i, 1).position[0] * x.rod->scales.length;
        const double beam = deployed(t[i], EI, m, 0.1 * m);
        print_message("deployed: tip %.9e m, by the beam's equation %.9e m\n", tip, beam);
        /* The motion is asked for to 1e-8 of the length, 2e-5 of the deflection. */
        assert_near(tip, beam, 1e-4 * fabs(beam));
    }
    assert_true(x.report.energy_mismatch < 1e-8);
    discard_fed(&x);
}

/* Far from straight, with damping, a tendon, drag and a tip load: energy that the port, loads and
 * the tendon bring is there or lost. The mismatch falls with the tolerance. */
#define LARGE(speed)                                                                               \
    ROD("0.12+0.06*(1-cos(" speed "*t))", ", relaxation_time: 0.01")                               \
    "loads: {gravity: [9.81, 0, 0], drag: 0.02, tip: {force: [0, 0.02, 0]}}\n"                     \
    "boundary: {end: {type: loaded}}\n"                                                            \
    "bodies: [{at: 0.3, mass: 0.002}]\n"                                                           \
    "tendons: [{offset: [0.002, 0.001], tension: \"3*sin(t)^2\"}]\n"                               \
    "time: {duration: 1}\n"

static void test_energy(void **state)
{
    (void)state;
    static const char text[] = LARGE("6");
    const double end = 1;
    double mismatch[2];
    for (int i = 0; i < 2; i++) {
        fed x = move(text, i ? 1e-7 : 1e-5, 1, &end);
        mismatch[i] = x.report.energy_mismatch;
        assert_true(x.report.estimate_l2 <= (i ? 1e-7 : 1e-5));
        discard_fed(&x);
    }
    print_message("energy: %.1e, then %.1e of the largest\n", mismatch[0], mismatch[1]);
    assert_true(mismatch[0] < 1e-3);
    assert_true(mismatch[1] < 1e-5);
}

/* An inserted rod whose drive is slow is at each time where one at rest with that length is: what
 * differs falls with the square of the speed at an end of the way, where it stands. */
static void test_slow(void **state)
{
    (void)state;
    static const char at_rest[] =
        ROD("0.24", "") "loads: {gravity: [9.81, 0, 0], tip: {force: [0, 0.02, 0]}}\n"
                        "boundary: {end: {type: loaded}}\n";
    static const char *const texts[2] = {ROD(
        "where(t-4, 0.24, 0.18-0.06*cos(pi*t/4))",
        ", relaxation_time: 0.03") "loads: {gravity: [9.81, 0, 0], tip: {force: [0, 0.02, 0]}}\n"
                                   "boundary: {end: {type: loaded}}\n"
                                   "initial: {state: equilibrium}\n"
                                   "time: {duration: 8}\n"};
    const double end = 8;
    ad_error error = {.message = ""};
    config *given = NULL;
    solution *rest = NULL;
    solve_report report;
    double values[7], tip;
    const solve_settings asked = {.tolerance = 1e-10};
    assert_int_equal(prepare_read("rest.yaml", at_rest, 0, NULL, &given, &error), AD_OK);
    assert_int_equal(solution_create(&given->scene, &asked, 0, NULL, &rest, &report, &error),
                     AD_OK);
    tip = scene_length(&given->scene);
    assert_int_equal(solution_evaluate(rest, 7, 1, &tip, NULL, values, &error), AD_OK);
    fed x = move(texts[0], 1e-7, 1, &end);
    const solve_state at = look(&x, 0, 1);
    for (int k = 0; k < 3; k++) { /* 4 s later nothing is left of the motion: damped, 1e-7 */
        assert_near(at.position[k] * x.rod->scales.length, values[k], 1e-6 * 0.24);
    }
    discard_fed(&x);
    solution_free(rest);
    config_free(given);
}

/* ---- inputs -------------------------------------------------------------------------------- */

#define FOLLOWS                                                                                    \
    "parameters: {out: {range: [0.12, 0.24]}, pull: {range: [0, 4]}}\n" ROD(                       \
        "out", ", relaxation_time: 0.01")
#define ACTS                                                                                       \
    "loads: {gravity: [9.81, 0, 0], drag: 0.02}\n"                                                 \
    "bodies: [{at: 0.3, mass: 0.002}]\n"                                                           \
    "tendons: [{offset: [\"0.002*cos(20*s)\", \"0.002*sin(20*s)\"], tension: pull}]\n"             \
    "time: {duration: 0.3, windows: 1}\n"
static const char follows[] =
    "parameters: {out: {range: [0.12, 0.24]}, pull: {range: [0, 4]}}\n"
    "rod: {model: kirchhoff, length: 0.3, inserted: out, feed_time: 0.04,\n" MATTER
    ", relaxation_time: 0.01}}\n" ACTS;

/* The same insertion as a formula: from 0.18 to 0.22, as the drive goes there. */
static const char formula[] = "parameters: {pull: {range: [0, 4]}}\n"
                              "rod: {model: kirchhoff, length: 0.3,\n"
                              "      inserted: \"0.22-0.04*(1+t/0.04)*exp(-t/0.04)\",\n" MATTER
                              ", relaxation_time: 0.01}}\n" ACTS;

/* A base that is turned, by an input and as a formula: from 0 to 0.5 rad, as the drive goes there.
 */
#define TURNS(start)                                                                               \
    "rod: {model: kirchhoff, length: 0.3,\n" MATTER ", relaxation_time: 0.01}}\n"                  \
    "boundary: {start: {position: [0.1, 0, 0], " start "}}\n" ACTS
static const char turns[] = "parameters: {turn: {range: [-1, 2]}, pull: {range: [0, 4]}}\n" TURNS(
    "rotation: [cos(turn/2), 0.1*cos(turn/2), -0.1*sin(turn/2), sin(turn/2)], turn_time: 0.04");
#define HALF "(0.25-0.25*(1+t/0.04)*exp(-t/0.04))"
static const char turned[] = "parameters: {pull: {range: [0, 4]}}\n" TURNS(
    "type: driven, rotation: [cos(" HALF "), 0.1*cos(" HALF "), -0.1*sin(" HALF "), sin(" HALF
    ")]");

/* Both at once. */
static const char goes[] =
    "parameters: {out: {range: [0.12, 0.24]}, pull: {range: [0, 4]}, turn: {range: [-1, 2]}}\n"
    "rod: {model: kirchhoff, length: 0.3, inserted: out, feed_time: 0.04,\n" MATTER
    ", relaxation_time: 0.01}}\n"
    "boundary: {start: {rotation: [cos(turn/2), 0, 0, sin(turn/2)], turn_time: 0.05}}\n"
    "loads: {gravity: [9.81, 0, 0], drag: 0.02}\n"
    "bodies: [{at: 0.3, mass: 0.002}]\n"
    "tendons: [{offset: [0.002, 0.001], tension: pull}]\n"
    "time: {duration: 0.3, windows: 1}\n";

/* A base that could be turned and stays: the rod is that without it. */
static const char could_turn[] =
    "parameters: {out: {range: [0.12, 0.24]}, pull: {range: [0, 4]}, turn: {range: [-1, 2]}}\n"
    "rod: {model: kirchhoff, length: 0.3, inserted: out, feed_time: 0.04,\n" MATTER
    ", relaxation_time: 0.01}}\n"
    "boundary: {start: {rotation: [cos(turn/2), 0, 0, sin(turn/2)], turn_time: 0.05}}\n" ACTS;

static reduced_rod *reduced(const char *text, config **given)
{
    const double tip = 0.18;
    const reduced_settings settings = {
        .modes = {3, 2, 0, 0}, .count = 1, .s = &tip, .newton = 1e-11};
    ad_error error = {.message = ""};
    reduced_rod *rod = NULL;
    if (prepare_read("follows.yaml", text, 0, NULL, given, &error) != AD_OK ||
        reduced_create(&(*given)->scene, &settings, &rod, &error) != AD_OK) {
        fail_msg("%s", error.message);
    }
    return rod;
}

enum { STATES = 32, INPUTS = 3 };

static void follow(const char *input, const char *in_time, double from, double to)
{
    enum { STEPS = 300 };
    ad_error error = {.message = ""};
    config *given[2];
    reduced_rod *rods[2] = {reduced(input, &given[0]), reduced(in_time, &given[1])};
    double x[2][STATES], inputs[2][INPUTS] = {{from, 2}, {2}};
    reduced_place tip[2];
    assert_int_equal(reduced_initial(rods[0], inputs[0], x[0], &error), AD_OK);
    assert_int_equal(reduced_initial(rods[1], inputs[1], x[1], &error), AD_OK);
    inputs[0][0] = to;
    for (int i = 0; i < STEPS; i++) {
        for (int k = 0; k < 2; k++) {
            if (reduced_step(rods[k], 1e-3 * i, 1e-3, x[k], inputs[k], x[k], NULL, NULL, &error) !=
                AD_OK) {
                fail_msg("%s", error.message);
            }
        }
    }
    for (int k = 0; k < 2; k++) {
        assert_int_equal(
            reduced_output(rods[k], 1e-3 * STEPS, x[k], inputs[k], &tip[k], NULL, &error), AD_OK);
    }
    print_message("follows: tip %.9f %.9f %.9f m\n", tip[0].position[0], tip[0].position[1],
                  tip[0].position[2]);
    for (int k = 0; k < 3; k++) { /* errors of steps in both, of order 5 */
        assert_near(tip[0].position[k], tip[1].position[k], 1e-8);
        assert_near(tip[0].velocity[k], tip[1].velocity[k], 1e-6);
    }
    for (int k = 0; k < 2; k++) {
        reduced_free(rods[k]);
        config_free(given[k]);
    }
}

static void test_follows(void **state)
{
    (void)state;
    follow(follows, formula, 0.18, 0.22);
    follow(turns, turned, 0, 0.5);
    follow(could_turn, formula, 0.18, 0.22);
}

/* A stiff arc of curvature 2 goes round with its base, r = R(a) r0 and r_t = a_t e3 x r, and a
 * follows the drive's equation. It bends by at most rho A a_tt r L^4/8EI = 6e-6 m, in some
 * hundredths of a second. */
static void test_turns_rigidly(void **state)
{
    (void)state;
    static const char stiff[] =
        "parameters: {turn: {range: [-2, 2]}}\n"
        "rod: {model: kirchhoff, length: 0.3, section: {shape: circle, radius: 0.002},\n"
        "      material: {youngs_modulus: 1.0e13, poissons_ratio: 0.3, density: 1200, "
        "relaxation_time: 0.01}, rest: {curvature: [2, 0, 0]}}\n"
        "boundary: {start: {rotation: [cos(turn/2), 0, 0, sin(turn/2)], turn_time: 0.05}}\n"
        "time: {duration: 1, windows: 1}\n";
    const double lag = 0.05, goal = 1.5, tip = 0.3, r0[2] = {(cos(0.6) - 1) / 2, sin(0.6) / 2};
    const reduced_settings settings = {.modes = {2, 1, 0, 0}, .count = 1, .s = &tip};
    ad_error error = {.message = ""};
    config *given = NULL;
    reduced_rod *rod = NULL;
    double x[STATES], input = 0;
    if (prepare_read("stiff.yaml", stiff, 0, NULL, &given, &error) != AD_OK ||
        reduced_create(&given->scene, &settings, &rod, &error) != AD_OK ||
        reduced_initial(rod, &input, x, &error) != AD_OK) {
        fail_msg("%s", error.message);
    }
    input = goal;
    for (int i = 0; i < 100; i++) {
        reduced_place at;
        assert_int_equal(reduced_step(rod, 2e-3 * i, 2e-3, x, &input, x, NULL, NULL, &error),
                         AD_OK);
        assert_int_equal(reduced_output(rod, 2e-3 * (i + 1), x, &input, &at, NULL, &error), AD_OK);
        const double t = 2e-3 * (i + 1), left = exp(-t / lag);
        const double a = goal * (1 - (1 + t / lag) * left), a_t = goal * t / lag / lag * left;
        assert_near(at.position[0], -sin(a) * r0[0], 7e-6);
        assert_near(at.position[1], cos(a) * r0[0], 7e-6);
        assert_near(at.position[2], r0[1], 7e-6);
        assert_near(at.velocity[0], -a_t * cos(a) * r0[0], 5e-4);
        assert_near(at.velocity[1], -a_t * sin(a) * r0[0], 5e-4);
    }
    assert_int_equal(reduced_settle(rod, 0, &input, x, &error), AD_OK);
    assert_near(x[0], goal, 1e-10);
    reduced_free(rod);
    config_free(given);
}

static void compare(const char *what, int rows, int columns, int column, double by,
                    const double *low, const double *high, const double *derivative,
                    double tolerance)
{
    double worst = 0, size = 0;
    for (int r = 0; r < rows; r++) {
        const double quotient = (high[r] - low[r]) / by;
        worst = fmax(worst, fabs(quotient - derivative[r * columns + column]));
        size = fmax(size, fabs(quotient));
    }
    if (!(worst <= tolerance * (1 + size))) {
        fail_msg("%s, column %d: %.2e of %.2e", what, column, worst, size);
    }
}

/* Differences leave 1e-7 of what they are of. Derivatives leave out what steps of finite length
 * along the rod add: 2e-6 of the largest in rods that are bent as far as the second, turned or not.
 */
static void derive(const char *text, double first, double other, double tolerance)
{
    ad_error error = {.message = ""};
    config *given;
    reduced_rod *rod = reduced(text, &given);
    const int n = reduced_states(rod), count = reduced_inputs(rod);
    double x[STATES], inputs[INPUTS] = {first, 2, 0.7}, rate[STATES], A[STATES * STATES];
    double B[STATES * INPUTS], S[STATES * STATES], T[STATES * INPUTS], next[STATES];
    double ends[2][STATES];
    unsigned seed = 5;
    assert_true(n <= STATES);
    assert_int_equal(reduced_initial(rod, inputs, x, &error), AD_OK);
    for (int k = 0; k < n; k++) {
        x[k] += (k < n / 2 ? 0.2 : 2) * noise(&seed);
    }
    inputs[0] = other;
    assert_int_equal(reduced_rate(rod, 0, x, inputs, rate, A, B, &error), AD_OK);
    assert_int_equal(reduced_step(rod, 0, 0.005, x, inputs, next, S, T, &error), AD_OK);
    for (int c = 0; c < n + count; c++) {
        double *to = c < n ? &x[c] : &inputs[c - n];
        const double kept = *to, by = 2e-5 * (c < n ? 1 : kept);
        for (int which = 0; which < 2; which++) {
            for (int side = 0; side < 2; side++) {
                *to = kept + (side ? by : -by);
                assert_int_equal(
                    which ? reduced_step(rod, 0, 0.005, x, inputs, ends[side], NULL, NULL, &error)
                          : reduced_rate(rod, 0, x, inputs, ends[side], NULL, NULL, &error),
                    AD_OK);
            }
            const double *by_state = which ? S : A, *by_inputs = which ? T : B;
            compare(which ? "step" : "rate", n, c < n ? n : count, c < n ? c : c - n, 2 * by,
                    ends[0], ends[1], c < n ? by_state : by_inputs, tolerance);
        }
        *to = kept;
    }
    reduced_free(rod);
    config_free(given);
}

static void test_derivatives(void **state)
{
    (void)state;
    derive(follows, 0.2, 0.23, 1e-6);
    derive(turns, 0.4, -0.3, 5e-6);
    derive(goes, 0.2, 0.23, 5e-6);
}

/* ---- what is refused ----------------------------------------------------------------------- */

static void refuse(const char *text, const char *why)
{
    ad_error error = {.message = ""};
    config *given = NULL;
    reduced_rod *rod = NULL;
    const double tip = 0;
    const reduced_settings settings = {.count = 1, .s = &tip};
    ad_status status = prepare_read("refused.yaml", text, 0, NULL, &given, &error);
    status = status == AD_OK ? reduced_create(&given->scene, &settings, &rod, &error) : status;
    assert_int_not_equal(status, AD_OK);
    if (!strstr(error.message, why)) {
        fail_msg("%s", error.message);
    }
    config_free(given);
}

static void test_refusals(void **state)
{
    (void)state;
    refuse(ROD("0.1+0.05*abs(t-0.1)", "") "time: {duration: 1}\n", "jumps, or its speed does");
    refuse(ROD("0.1+0.5*t", "") "time: {duration: 1}\n", "allowed: up to its length");
    refuse(ROD("0.1+0.05*t", "}, rest: {curvature: [1, 0, 0]") "time: {duration: 1}\n",
           "does not take a rest shape that is not straight yet");
    refuse(FOLLOWS ACTS, "rod.feed_time");
    refuse("parameters: {turn: {range: [-1, 2]}, pull: {range: [0, 4]}}\n" TURNS(
               "rotation: [cos(turn), 0, 0, sin(turn)], turn_time: 0.04"),
           "turned about d3 by one parameter");
    refuse("parameters: {turn: {range: [-1, 2]}, pull: {range: [0, 4]}}\n" TURNS(
               "rotation: [cos(turn/2), sin(turn/2), 0, 0], turn_time: 0.04"),
           "turned about d3 by one parameter");
    refuse("parameters: {pull: {range: [0, 2]}}\n" TURNS(
               "rotation: [cos(pull/2), 0, 0, sin(pull/2)], turn_time: 0.04"),
           "depends on pull, which turns the base");
    refuse(ROD("0.1+0.05*t", "") "bodies: [{at: 0.18, mass: 1}]\ntime: {duration: 2}\n",
           "places change their order");
    refuse(ROD("0.1+0.05*t", "") "springs: [{at: 0.3, stiffness: [1, 1, 1]}]\n"
                                 "time: {duration: 1}\n",
           "does not take springs yet");
    refuse(
        ROD("0.1+0.05*t", "") "tendons: [{offset: [0.01, 0], displacement: 0.01, stiffness: 100}]\n"
                              "time: {duration: 1}\n",
        "does not take tendons of given displacement yet");
}

int main(void)
{
    const struct CMUnitTest tests[] = {cmocka_unit_test(test_rigid), cmocka_unit_test(test_slow),
                                       cmocka_unit_test(test_turns_rigidly),
                                       cmocka_unit_test(test_derivatives),
                                       cmocka_unit_test(test_refusals)};
    const struct CMUnitTest alike[] = {cmocka_unit_test(test_deployed),
                                       cmocka_unit_test(test_energy),
                                       cmocka_unit_test(test_follows)};
    return run_with_alike(tests, alike, NULL, NULL);
}
