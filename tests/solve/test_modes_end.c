/* Held, sliding and driven ends of rods in motion by strain modes: derivatives against difference
 * quotients, frequencies in closed form, spectral elements, equilibria by collocation, the energy
 * that a driven end puts in, and what has no motion. */
#include "fewer.h"
#include "modes_testing.h"
#include "near.h"
#include "temporary_folder.h"

#include "autodiff/dense.h"
#include "physics/chain/reduced.h"
#include "physics/solve/solve.h"
#include "tools/library/cpinn.h"

#include <stdio.h>
#include <string.h>

/* ---- equations ----------------------------------------------------------------------------- */

/* Of a pose that the state is far off, which moves; and of one that slides. Difference quotients
 * leave 1e-10, a sign that is wrong in any part 1e-3 and more. */
static void test_derivatives(void **state)
{
    (void)state;
    static const char *const ends[3] = {
        "boundary.end={type: driven, position: [0.5*sin(t), 0.1*t, 0.8], rotation: [cos(t), "
        "0.6*sin(t), 0, 0.8*sin(t)]}",
        "boundary.end={type: guided, along: [0.2, -0.3, 1], position: [0, 0.1, 0], rotation: [1, "
        "0.1, 0.2, 0.3]}",
        "boundary.end={type: roller, across: [1, 2, 3], position: [0, 0.1, 0]}"};
    char text[sizeof everything];
    const char *tip = strstr(everything, "  tip:"), *after = strchr(tip, '\n') + 1;
    snprintf(text, sizeof text, "%.*s%s", (int)(tip - everything), everything, after);
    for (int i = 0; i < 3; i++) {
        const char *const sets[] = {ends[i], "enforcement.initial=soft"};
        const double off = worst_derivative_of(text, 4, NULL, 2, sets);
        print_message("derivatives: %.1e\n", off);
        assert_true(off < 1e-9);
    }
}

#define SLENDER                                                                                    \
    "rod: {model: kirchhoff, length: 1, stiffness: {bending: [1, 1], torsion: 0.8},\n"             \
    "      inertia: {mass_per_length: 1, rotary: [1.0e-9, 1.0e-9, 1.0e-9]}}\n"
#define AT_THE_END "position: [0, 0, 1], rotation: [1, 0, 0, 0]"

/* K y - G^T reaction = right, G y = 0; right [size] of a rod at rest, then y. */
static void solve_held(const modes *m, const double *by_q, double *right)
{
    enum { MOST = 32 };
    const int n = m->size, width = m->width;
    double matrix[MOST * MOST];
    int pivots[MOST];
    assert_true(n <= MOST);
    for (int r = 0; r < n; r++) {
        for (int c = 0; c < n; c++) {
            matrix[c * n + r] = (c < m->end.first ? by_q : m->mass)[r * width + c];
        }
    }
    assert_int_equal(ad_dense_lu((size_t)n, matrix, pivots), 0);
    ad_dense_lu_solve((size_t)n, 1, matrix, pivots, right);
}

/* The lowest frequency (beta L)^2 sqrt(EI/(rhoA L^4)) of a rod in a plane, by inverse iteration. */
static double lowest_frequency(const char *boundary)
{
    enum { N = 14, MOST = 32, ROUNDS = 60 };
    char text[1024];
    double by_q[MOST * MOST], by_v[MOST * MOST], q[MOST] = {0}, y[MOST], right[MOST], size = 0;
    snprintf(text, sizeof text, SLENDER "boundary: {%s}\n%stime: {duration: 1}\n", boundary,
             strstr(boundary, "clamped")
                 ? ""
                 : "initial: {position: [0, 0, s], rotation: [1, 0, 0, 0]}\n");
    reduced_test x = make("slender.yaml", text, (modes_counts){{0, 0, 0, 0, N, 0}}, 4);
    const int n = x.m->size, width = x.m->width;
    assert_true(n < MOST && width <= MOST);
    modes_linearise(x.m, q, q, NULL, right, by_q, by_v);
    for (int k = 0; k < n; k++) {
        y[k] = 1.0 / (1 + k);
    }
    for (int round = 0; round < ROUNDS; round++) {
        size = 0;
        for (int r = 0; r < n; r++) {
            right[r] = 0;
            for (int c = 0; c < x.m->end.first && r < x.m->end.first; c++) {
                right[r] += x.m->mass[r * width + c] * y[c];
            }
        }
        solve_held(x.m, by_q, right);
        for (int r = 0; r < x.m->end.first; r++) {
            for (int c = 0; c < x.m->end.first; c++) {
                size += right[r] * x.m->mass[r * width + c] * right[c];
            }
        }
        for (int k = 0; k < n; k++) {
            y[k] = right[k] / sqrt(size);
        }
    }
    discard(&x);
    return pow(size, -0.25);
}

/* cos cosh = 1, tan = tanh, tan = -tanh. A mode counts 1e-9 by its rotary inertia. */
static void test_frequencies(void **state)
{
    (void)state;
    static const struct {
        const char *boundary;
        double beta;
    } rows[] = {
        {"start: {type: clamped}, end: {type: guided, along: [0, 0, 1], " AT_THE_END "}",
         4.730040744862704},
        {"start: {type: clamped}, end: {type: roller, along: [0, 0, 1], position: [0, 0, 1]}",
         3.926602312047919},
        {"start: {type: clamped}, end: {type: guided, " AT_THE_END "}", 2.365020372431352}};
    for (size_t i = 0; i < sizeof rows / sizeof *rows; i++) {
        const double found = lowest_frequency(rows[i].boundary), exact = pow(rows[i].beta, 2);
        print_message("%s: %.12g of %.12g\n", rows[i].boundary, found, exact);
        assert_near(found, exact, 1e-7 * exact);
    }
}

/* ---- motions ------------------------------------------------------------------------------- */

#define RUBBER                                                                                     \
    "length: 1, section: {shape: circle, radius: 0.02}, material: {youngs_modulus: 1.0e7, "        \
    "poissons_ratio: 0.45, density: 1000}"
#define STRAIGHT "rod: {model: cosserat, " RUBBER "}\n"
#define ARCH     "rod: {model: cosserat, " RUBBER ", rest: {curvature: [0, 1.2, 0]}}\n"
#define PUSHED   "loads: {force: [\"8*sin(3*t)^2\", \"4*sin(2*t)^2*s\", 0]}\n"

/* In its unstressed shape the end of ARCH is where its formulas begin. */
#define DRIVEN                                                                                     \
    "boundary: {start: {type: clamped}, end: {type: driven,\n"                                     \
    "  position: [\"(1 - cos(1.2))/1.2 + 0.1*sin(2*t)^2\", \"0.1*sin(3*t)^2\",\n"                  \
    "             \"sin(1.2)/1.2 - 0.1*sin(2*t)^2\"],\n"                                           \
    "  rotation: [\"cos(0.6 + 0.3*sin(2*t)^2)\", 0, \"sin(0.6 + 0.3*sin(2*t)^2)\", 0]}}\n"

enum { TIMES = 5, PLACES = 9 };

typedef struct moved {
    config *settings;
    solution *solution;
    solve_report report;
    double duration;
} moved;

static ad_status try_to_move(const char *text, const solve_settings *asked, moved *x,
                             ad_error *error)
{
    double times[TIMES];
    *x = (moved){0};
    if (prepare_read("moved.yaml", text, 0, NULL, &x->settings, error) != AD_OK) {
        fail_msg("%s", error->message);
    }
    const bool moves = scene_is_dynamic(&x->settings->scene);
    x->duration = moves ? scene_duration(&x->settings->scene) : 0;
    for (int i = 0; i < TIMES; i++) {
        times[i] = x->duration * (i + 1) / TIMES;
    }
    return solution_create(&x->settings->scene, asked, moves ? TIMES : 0, moves ? times : NULL,
                           &x->solution, &x->report, error);
}

static moved move_by(const char *text, const solve_settings *asked)
{
    ad_error error = {.message = ""};
    moved x;
    if (try_to_move(text, asked, &x, &error) != AD_OK) {
        fail_msg("%s", error.message);
    }
    return x;
}

static moved move(const char *text, solve_method method, double tolerance)
{
    return move_by(text, &(solve_settings){.tolerance = tolerance, .method = method});
}

static void discard_moved(moved *x)
{
    solution_free(x->solution);
    config_free(x->settings);
}

enum { COLUMNS = 19, FORCE = 13, MOMENT = 16 };

/* Columns [COLUMNS] at s, of the i-th time. */
static void look(const moved *x, int i, double s, double columns[COLUMNS])
{
    const double t = x->duration * (i + 1) / TIMES;
    ad_error error = {.message = ""};
    if (solution_evaluate(x->solution, COLUMNS, 1, &s, &t, columns, &error) != AD_OK) {
        fail_msg("%s", error.message);
    }
}

/* How far the reaction is off, force and moment, and the largest in the rod. */
typedef struct apart {
    double place, reaction[2], size[2];
} apart;

static apart compare_at(const moved *x, const moved *y, int i)
{
    apart to = {0};
    double a[COLUMNS], b[COLUMNS];
    for (int k = 0; k < PLACES; k++) { /* the last is the end */
        look(x, i, (double)k / (PLACES - 1), a);
        look(y, i, (double)k / (PLACES - 1), b);
        to.place = fmax(to.place, distance(a, b));
        for (int c = 0; c < 6; c++) {
            to.size[c / 3] = fmax(to.size[c / 3], fabs(b[FORCE + c]));
        }
    }
    for (int c = 0; c < 6; c++) {
        to.reaction[c / 3] = fmax(to.reaction[c / 3], fabs(a[FORCE + c] - b[FORCE + c]));
    }
    return to;
}

/* The largest of all times. */
static apart compare_all(const moved *x, const moved *y)
{
    apart most = {0};
    for (int i = 0; i < TIMES; i++) {
        const apart now = compare_at(x, y, i);
        most.place = fmax(most.place, now.place);
        for (int k = 0; k < 2; k++) {
            most.reaction[k] = fmax(most.reaction[k], now.reaction[k]);
            most.size[k] = fmax(most.size[k], now.size[k]);
        }
    }
    return most;
}

/* By modes and by spectral elements: places differ by less than what both estimate. The reaction,
 * force and moment at the end, is a third and a second derivative of them, of the last modes: to
 * 5e-3 and 1e-3 of the largest in the rod. */
static void compare(const char *name, const char *text, double tolerance)
{
    moved x = move(text, SOLVE_MODES, tolerance), y = move(text, SOLVE_COLLOCATION, tolerance);
    const double allowed = x.report.estimate + y.report.estimate;
    const apart off = compare_all(&x, &y);
    print_message("%s: off by %.1e, estimates %.1e and %.1e; reaction by %.1e and %.1e of the "
                  "largest; energy %.1e\n",
                  name, off.place, x.report.estimate, y.report.estimate,
                  off.reaction[0] / off.size[0], off.reaction[1] / off.size[1],
                  x.report.energy_mismatch);
    assert_true(x.report.estimate_l2 <= tolerance);
    assert_true(off.place < allowed);
    assert_true(off.reaction[0] < 5e-3 * off.size[0]);
    assert_true(off.reaction[1] < 1e-3 * off.size[1]);
    assert_true(x.report.energy_mismatch < tolerance);
    discard_moved(&x);
    discard_moved(&y);
}

static void test_spectral_elements(void **state)
{
    (void)state;
    static const struct {
        const char *name, *text;
    } rows[] = {
        {"clamped", STRAIGHT "boundary: {start: {type: clamped}, end: {type: clamped, " AT_THE_END
                             "}}\n" PUSHED "time: {duration: 0.6}\n"},
        {"driven", ARCH DRIVEN "time: {duration: 0.8}\n"},
        {"pinned", STRAIGHT "boundary: {start: {type: clamped}, end: {type: pinned, position: [0, "
                            "0, 1]}}\n" PUSHED "time: {duration: 0.6}\n"},
        {"sliding", STRAIGHT "boundary: {start: {type: pinned}, end: {type: guided, along: [0, 0, "
                             "1], " AT_THE_END "}}\n" PUSHED "time: {duration: 0.6}\n"},
        {"aslant in a plane", STRAIGHT
         "boundary: {start: {type: clamped}, end: {type: clamped, " AT_THE_END "}}\n"
         "loads: {force: [\"6*sin(3*t)^2\", \"5*sin(3*t)^2\", 0]}\ntime: {duration: 0.6}\n"},
        {"turned", STRAIGHT "boundary: {start: {type: clamped}, end: {type: driven, " AT_THE_END
                            ", twist: \"2*sin(t)^2\"}}\n" PUSHED "time: {duration: 0.6}\n"}};
    for (size_t i = 0; i < sizeof rows / sizeof *rows; i++) {
        compare(rows[i].name, rows[i].text, 1e-5);
    }
}

/* A sagging arch stays where it is in equilibrium, by collocation at rest, and so does the reaction
 * of its end; modes are so many that 1e-8 is left of the place. */
static void test_equilibrium(void **state)
{
    (void)state;
    static const char *const ends[2] = {"clamped, rotation: [\"cos(0.6)\", 0, \"sin(0.6)\", 0]",
                                        "pinned"};
    char text[1024];
    for (int i = 0; i < 2; i++) {
        moved of[2];
        for (int moves = 0; moves < 2; moves++) {
            snprintf(text, sizeof text,
                     ARCH "boundary: {start: {type: clamped}, end: {type: %s, position: [\"(1 - "
                          "cos(1.2))/1.2\", 0, \"sin(1.2)/1.2\"]}}\n"
                          "loads: {gravity: [-3, 2, -4]}\n%s",
                     ends[i],
                     moves ? "initial: {state: equilibrium}\ntime: {duration: 0.3}\n" : "");
            of[moves] = move(text, moves ? SOLVE_MODES : SOLVE_COLLOCATION, moves ? 1e-7 : 1e-10);
        }
        const apart off = compare_all(&of[1], &of[0]);
        print_message("%s: off by %.1e, reaction by %.1e and %.1e of the largest\n", ends[i],
                      off.place, off.reaction[0] / off.size[0], off.reaction[1] / off.size[1]);
        assert_true(off.place < 1e-8);
        assert_true(off.reaction[0] < 1e-5 * off.size[0]);
        assert_true(off.reaction[1] < 1e-5 * off.size[1]);
        discard_moved(&of[0]);
        discard_moved(&of[1]);
    }
}

/* At t = 0 the end of DRIVEN stands still and is accelerated by 8 times its amplitudes, and turned
 * by twice as much: so is the tip by the accelerations of the modes, with which forces balance. */
static void test_accelerations(void **state)
{
    (void)state;
    enum { MOST = 64 };
    const double push[3] = {0.8, 1.8, -0.8}, turn[3] = {0, 4.8, 0};
    ad_error error = {.message = ""};
    reduced_test x =
        make("driven.yaml", ARCH DRIVEN "time: {duration: 1}\n", modes_counts_of(4, 2, 2, 2), 4);
    const modes_point *tip = &x.m->point[x.m->points - 1];
    const double time = x.rod->scales.time;
    double q[MOST], v[MOST], a[MOST], residual[MOST];
    assert_true(x.m->size <= MOST);
    assert_int_equal(modes_initial(x.m, q, v, &error), AD_OK);
    assert_true(modes_accelerations(x.m, q, v, a));
    modes_shape(x.m, q, v, a);
    modes_forces(x.m, false, residual);
    for (int k = 0; k < 3; k++) {
        assert_near(tip->acceleration[k], push[k] * time * time, 1e-9);
        assert_near(tip->spin_rate[k], turn[k] * time * time, 1e-9);
    }
    for (int k = 0; k < x.m->end.first; k++) {
        assert_near(residual[k], 0, 1e-9);
    }
    discard(&x);
}

/* ---- steps --------------------------------------------------------------------------------- */

#define LOCKED_ARCH                                                                                \
    "rod: {model: kirchhoff, length: 1, section: {shape: circle, radius: 0.01}, material: "        \
    "{youngs_modulus: 1.0e7, poissons_ratio: 0.45, density: 1000}, rest: {curvature: [0, 1.2, "    \
    "0]}}\n"

/* Of few modes, by steps that are shorter and shorter: what is left of places and of reactions
 * falls with the tolerance, and rounding over short steps, which equations of index 3 have, does
 * not end it. */
static void test_steps(void **state)
{
    (void)state;
    static const char text[] = LOCKED_ARCH DRIVEN "time: {duration: 1}\n";
    const double tolerances[3] = {1e-9, 1e-5, 1e-7};
    moved of[3];
    apart off[3];
    for (int i = 0; i < 3; i++) {
        of[i] = move_by(text, &(solve_settings){.tolerance = tolerances[i],
                                                .method = SOLVE_MODES,
                                                .modes = {7, 5, 0, 0}});
        off[i] = compare_all(&of[i], &of[0]);
        print_message("tolerance %.0e: off by %.1e, reaction by %.1e and %.1e of the largest, %ld "
                      "steps\n",
                      tolerances[i], off[i].place, off[i].reaction[0] / off[i].size[0],
                      off[i].reaction[1] / off[i].size[1], of[i].report.time_steps);
        assert_true(off[i].place <= tolerances[i]);
    }
    assert_true(off[2].reaction[0] < 1e-5 * off[2].size[0]);
    assert_true(off[2].reaction[0] < 0.2 * off[1].reaction[0]);
    for (int i = 0; i < 3; i++) {
        discard_moved(&of[i]);
    }
}

/* ---- recordings ---------------------------------------------------------------------------- */

/* A tendon to the middle of a rod between two ends, of which one slides, and its stiffness. */
#define PULLED_AT(pull, factor)                                                                    \
    "rod: {model: cosserat, length: 1, section: {shape: circle, radius: 0.02}, material: "         \
    "{youngs_modulus: \"1.0e7*" factor                                                             \
    "\", poissons_ratio: 0.45, density: 1000, relaxation_time: "                                   \
    "0.01}}\n"                                                                                     \
    "boundary: {start: {type: clamped}, end: {type: guided, along: [0, 0, 1], " AT_THE_END "}}\n"  \
    "tendons: [{offset: [0.03, 0], end: 0.5, tension: " pull "}]\n"                                \
    "loads: {gravity: [0, -2, 0]}\n"
#define SETTLED "initial: {state: equilibrium}\ntime: {duration: 0.5}\n"
#define UNKNOWN                                                                                    \
    "parameters: {pull: {range: [0, 20]}, e: {identify: 0.7, range: [0.4, 2]}}\n" PULLED_AT(       \
        "pull", "e")

static double pull_at(double t)
{
    return t < 0.25 ? 60 * t : 30 - 60 * t;
}

static void write_text(const char *name, const char *text)
{
    FILE *to = fopen(at(name), "w");
    assert_non_null(to);
    fputs(text, to);
    fclose(to);
}

enum { RECORDED_MOST = 5 };

/* Writes recorded.csv: places at s of the motion of a scene, and what is recorded beside them. */
static void record(const char *made, const solve_settings *asked, double duration, int samples,
                   double s, const char *names, int count, void at_time(double t, double *values))
{
    enum { SAMPLES_MOST = 101 };
    ad_error error = {.message = ""};
    config *of = NULL;
    solution *motion = NULL;
    solve_report report;
    double times[SAMPLES_MOST], values[2 * RECORDED_MOST];
    assert_true(samples <= SAMPLES_MOST && count <= RECORDED_MOST);
    for (int i = 0; i < samples; i++) {
        times[i] = duration * i / (samples - 1);
    }
    if (prepare_read("made.yaml", made, 0, NULL, &of, &error) != AD_OK ||
        solution_create(&of->scene, asked, (size_t)samples, times, &motion, &report, &error) !=
            AD_OK) {
        fail_msg("%s", error.message);
    }
    FILE *to = fopen(at("recorded.csv"), "w");
    assert_non_null(to);
    fprintf(to, "s,t,x,y,z,%s\n", names);
    for (int i = 0; i < samples; i++) {
        double r[3];
        assert_int_equal(solution_evaluate(motion, 3, 1, &s, &times[i], r, &error), AD_OK);
        fprintf(to, "%g,%.12g,%.12g,%.12g,%.12g", s, times[i], r[0], r[1], r[2]);
        at_time(times[i], values);
        for (int k = 0; k < count; k++) {
            fprintf(to, ",%.12g", values[k]);
        }
        fputc('\n', to);
    }
    fclose(to);
    solution_free(motion);
    config_free(of);
}

/* The stiffness of a scene of recorded.csv, of which 1e-5 is the noise. */
static void find_stiffness(const char *text, const char *name)
{
    ad_error error = {.message = ""};
    cpinn_unknowns *found = NULL;
    write_text("scene.yaml", text);
    if (cpinn_identify_file(at("scene.yaml"), 0, NULL, 1, &found, &error) != AD_OK) {
        fail_msg("%s", error.message);
    }
    const double e = cpinn_unknowns_value(found, 0), deviation = cpinn_unknowns_deviation(found, 0);
    cpinn_unknowns_free(found);
    print_message("%s: %.6f +- %.1e\n", name, e, deviation);
    assert_near(e, 1, deviation);
    assert_true(deviation < 1e-2);
}

#define RECORDED "data: [{quantity: position, file: recorded.csv, noise: 1.0e-5}]\n"

static void at_pull(double t, double *values)
{
    values[0] = pull_at(t);
}

/* The stiffness by which a recording was made is found from places in the middle, of which one unit
 * in the last place is the noise, to its deviation and what modes of recordings leave. */
static void test_recording(void **state)
{
    (void)state;
    const solve_settings asked = {.tolerance = 1e-6, .method = SOLVE_MODES};
    record(PULLED_AT("'where(0.25 - t, 60*t, 30 - 60*t)'", "1") SETTLED, &asked, 0.5, 21, 0.5,
           "pull", 1, at_pull);
    find_stiffness(UNKNOWN SETTLED RECORDED, "recorded");
}

/* Derivatives of a step by state and inputs against difference quotients, of steps solved to 1e-10;
 * the states are those of modes alone. */
static void test_reduced(void **state)
{
    (void)state;
    enum { MOST = 64 };
    const double place = 0.5, by = 1e-5, h = 0.02;
    const reduced_settings settings = {
        .modes = {3, 1, 1, 1}, .count = 1, .s = &place, .newton = 1e-10};
    ad_error error = {.message = ""};
    config *given = NULL;
    reduced_rod *rod = NULL;
    double x[MOST], inputs[2] = {7, 1.2}, next[MOST], ends[2][MOST], S[MOST * MOST], T[MOST * 2];
    double worst = 0, size = 0;
    static const char text[] =
        "parameters: {pull: {range: [0, 20]}, e: {range: [0.4, 2]}}\n" PULLED_AT(
            "pull", "e") "time: {duration: 0.5}\n";
    if (prepare_read("reduced.yaml", text, 0, NULL, &given, &error) != AD_OK ||
        reduced_create(&given->scene, &settings, &rod, &error) != AD_OK ||
        reduced_initial(rod, inputs, x, &error) != AD_OK) {
        fail_msg("%s", error.message);
    }
    const int n = reduced_states(rod);
    assert_int_equal(n, 2 * 2 * (3 + 3 + 1 + 1 + 1 + 1)); /* of two pieces */
    inputs[0] = 15;
    for (int i = 0; i < 3; i++) { /* into motion */
        assert_int_equal(reduced_step(rod, 0, h, x, inputs, x, NULL, NULL, &error), AD_OK);
    }
    assert_int_equal(reduced_step(rod, 0, h, x, inputs, next, S, T, &error), AD_OK);
    for (int c = 0; c < n + 2; c++) {
        double *to = c < n ? &x[c] : &inputs[c - n];
        const double kept = *to;
        for (int side = 0; side < 2; side++) {
            *to = kept + (side ? by : -by);
            assert_int_equal(reduced_step(rod, 0, h, x, inputs, ends[side], NULL, NULL, &error),
                             AD_OK);
        }
        *to = kept;
        for (int r = 0; r < n; r++) {
            const double quotient = (ends[1][r] - ends[0][r]) / (2 * by);
            worst = fmax(worst, fabs(quotient - (c < n ? S[r * n + c] : T[r * 2 + c - n])));
            size = fmax(size, fabs(quotient));
        }
    }
    print_message("derivatives of a step: %.1e of %.1e\n", worst, size);
    assert_true(worst < 1e-6 * size);
    assert_int_equal(reduced_rate(rod, 0, x, inputs, next, NULL, NULL, &error), AD_BAD_ARGUMENT);
    reduced_free(rod);
    config_free(given);
}

/* ---- ends that follow columns -------------------------------------------------------------- */

/* An arch of two moved ends, of which the start goes along x and turns about x by twice an angle,
 * and the end goes along z and turns about y; each by a formula of t, or an input. */
#define MOVED_BY(x, a, z, b)                                                                       \
    "rod: {model: cosserat, length: 1, section: {shape: circle, radius: 0.02}, material: "         \
    "{youngs_modulus: \"1.0e7*e\", poissons_ratio: 0.45, density: 1000, relaxation_time: 0.01}, "  \
    "rest: {curvature: [0, 1.2, 0]}}\n"                                                            \
    "boundary:\n"                                                                                  \
    "  start: {type: driven, position: [\"" x "\", 0, 0], rotation: [\"cos(" a ")\", \"sin(" a     \
    ")\", 0, 0]}\n"                                                                                \
    "  end: {type: driven, position: [\"(1 - cos(1.2))/1.2\", 0, \"sin(1.2)/1.2 - (" z             \
    ")\"], rotation: [\"cos(0.6 + " b ")\", 0, \"sin(0.6 + " b ")\", 0]}\n"                        \
    "loads: {gravity: [1, 2, 0]}\ntime: {duration: 1}\n"

enum { MOVING = 4 };

#define ENDS_MOVED MOVED_BY("0.1*sin(2*t)^2", "0.2*sin(3*t)^2", "0.1*sin(2*t)^2", "0.3*sin(2*t)^2")
#define ENDS_RECORDED                                                                              \
    "  x: {range: [-1, 1]}\n  a: {range: [-1, 1]}\n  z: {range: [-1, 1]}\n"                        \
    "  b: {range: [-1, 1]}\n" MOVED_BY("x", "a", "z", "b")

static void moved_ends(double t, double inputs[MOVING], double rates[MOVING])
{
    const double s2 = sin(2 * t), s3 = sin(3 * t);
    const double by2 = 4 * s2 * cos(2 * t), by3 = 6 * s3 * cos(3 * t);
    const double values[MOVING] = {0.1 * s2 * s2, 0.2 * s3 * s3, 0.1 * s2 * s2, 0.3 * s2 * s2};
    const double of[MOVING] = {0.1 * by2, 0.2 * by3, 0.1 * by2, 0.3 * by2};
    memcpy(inputs, values, sizeof values);
    memcpy(rates, of, sizeof of);
}

/* Steps whose ends follow inputs by their values and rates are those whose ends are the formulas of
 * t: what is left is Hermite's cubic over a step, of fourth order in values, of second in
 * accelerations, and falls by 8 and more with half of the step. */
static void test_followed(void **state)
{
    (void)state;
    enum { MOST = 64 };
    const double place = 0.5, duration = 0.8;
    const reduced_settings settings = {
        .modes = {4, 2, 2, 2}, .count = 1, .s = &place, .newton = 1e-10, .follows = true};
    static const char *const texts[2] = {"parameters:\n  e: {range: [0.5, 1.5]}\n" ENDS_MOVED,
                                         "parameters:\n  e: {range: [0.5, 1.5]}\n" ENDS_RECORDED};
    double off[2] = {0}, fast[2] = {0};
    for (int fine = 0; fine < 2; fine++) {
        const int steps = fine ? 40 : 20;
        const double h = duration / steps;
        reduced_place seen[2];
        for (int by = 0; by < 2; by++) {
            ad_error error = {.message = ""};
            config *given = NULL;
            reduced_rod *rod = NULL;
            double x[MOST], inputs[2][1 + MOVING] = {{0}}, rates[2][1 + MOVING] = {{0}};
            if (prepare_read("followed.yaml", texts[by], 0, NULL, &given, &error) != AD_OK ||
                reduced_create(&given->scene, &settings, &rod, &error) != AD_OK) {
                fail_msg("%s", error.message);
            }
            assert_int_equal(reduced_followed(rod), by ? 30 : 0);
            assert_true(reduced_states(rod) <= MOST);
            for (int i = 0; i <= steps; i++) {
                inputs[1][0] = 1;
                if (by) {
                    moved_ends(i * h, inputs[1] + 1, rates[1] + 1);
                    reduced_follow(rod, rates[i > 0 ? 0 : 1], rates[1]);
                }
                if ((i > 0 ? reduced_step_linear(rod, (i - 1) * h, h, x, inputs[0], inputs[1], x,
                                                 NULL, NULL, &error)
                           : reduced_initial(rod, inputs[1], x, &error)) != AD_OK) {
                    fail_msg("%s", error.message);
                }
                memcpy(inputs[0], inputs[1], sizeof inputs[0]);
                memcpy(rates[0], rates[1], sizeof rates[0]);
            }
            if (by) {
                reduced_follow(rod, rates[1], rates[1]);
            }
            assert_int_equal(reduced_output(rod, duration, x, inputs[1], &seen[by], NULL, &error),
                             AD_OK);
            reduced_free(rod);
            config_free(given);
        }
        for (int k = 0; k < 3; k++) {
            off[fine] = fmax(off[fine], fabs(seen[0].position[k] - seen[1].position[k]));
            fast[fine] = fmax(fast[fine], fabs(seen[0].velocity[k] - seen[1].velocity[k]));
        }
    }
    print_message("followed: off by %.1e, %.1e; velocity %.1e, %.1e\n", off[0], off[1], fast[0],
                  fast[1]);
    assert_true(off[1] < 1e-5 && fast[1] < 1e-4);
    assert_true(off[1] < off[0] / 8 && fast[1] < fast[0] / 8);
}

static void at_ends(double t, double *values)
{
    double rates[MOVING];
    moved_ends(t, values, rates);
}

#define KNOWS_COLUMNS                                                                              \
    "parameters:\n  e: {identify: 0.7, range: [0.4, 2]}\n  X: {range: [-1, 1]}\n"                  \
    "  a: {range: [-4, 4]}\n  Z: {range: [-1, 1]}\n  b: {range: [-1, 1]}\n" MOVED_BY(              \
        "X", "a", "Z", "b") RECORDED

/* The stiffness of a rod whose ends were moved, by columns of its ends 50 times a second. The modes
 * are those of recordings, so that what goes between the samples is all that differs. */
static void test_recorded_ends(void **state)
{
    (void)state;
    const solve_settings asked = {.tolerance = 1e-6, .method = SOLVE_MODES, .modes = {5, 3, 3, 2}};
    record("parameters: {e: 1}\n" ENDS_MOVED, &asked, 1, 51, 0.5, "X,a,Z,b", MOVING, at_ends);
    find_stiffness(KNOWS_COLUMNS, "ends that follow columns");
}

/* A cable that hangs at rest and whose ends move at once, at 2 m/s to both sides: a step from one
 * sample to the next is too long for Newton's method, halves of it are not. */
static void test_sudden(void **state)
{
    (void)state;
    ad_error error = {.message = ""};
    cpinn_unknowns *found = NULL;
    write_text("recorded.csv", "s,t,x,y,z,a,b,p\n0.5,0,0.35,-0.2,0.1,-0.2,-0.2,0.38\n"
                               "0.5,0.01,0.35,-0.2,0.1,-0.18,-0.22,0.38\n"
                               "0.5,0.02,0.35,-0.2,0.1,-0.16,-0.24,0.38\n"
                               "0.5,0.03,0.35,-0.2,0.1,-0.14,-0.26,0.38\n");
    write_text("scene.yaml",
               "parameters: {a: {range: [-1.2, 0.8]}, b: {range: [-1.2, 0.8]}, p: {range: [-1.6, "
               "2.4]},\n"
               "  tau: {identify: 0.35, range: [0.3, 0.4]}}\n"
               "rod: {model: kirchhoff, length: 1.035, stiffness: {bending: [1.0e-3, 1.0e-3], "
               "torsion: 1.0e-3},\n"
               "  inertia: {mass_per_length: 0.04, rotary: [1.0e-7, 1.0e-7, 2.0e-7]}, material: "
               "{relaxation_time: tau}}\n"
               "boundary:\n"
               "  start: {type: driven, position: [0.6, a, 0.5], rotation: [p, 0, -0.92388, 0]}\n"
               "  end: {type: driven, position: [0.1, b, 0.5], rotation: [0.92388, 0, -0.382683, "
               "0]}\n"
               "loads: {gravity: [0, 0, -9.81]}\ninitial: {state: equilibrium}\n"
               "time: {duration: 1}\n"
               "data: [{quantity: position, file: recorded.csv, noise: 1.0e-2}]\n");
    if (cpinn_identify_file(at("scene.yaml"), 0, NULL, 1, &found, &error) != AD_OK) {
        fail_msg("%s", error.message);
    }
    cpinn_unknowns_free(found);
}

/* A row without a number, a quaternion that goes on as its opposite, and a spring whose place at
 * rest would go with the start: such a rod was off by some hundredths of its length. */
static void test_bad_columns(void **state)
{
    (void)state;
    static const struct {
        const char *row, *message, *beside;
    } rows[] = {
        {"0.5,0.04,0,0,0,,0,0,0", "recorded.csv: row 3 has no X; an input is given in ", ""},
        {"0.5,0.04,0,0,0,0,0.1,0,0",
         "boundary.start follows the input a, and springs or a foundation are measured from "
         "the unstressed rod there; allowed: springs that do not turn, with an anchor",
         "springs: [{at: 0.5, stiffness: [1, 1, 1]}]\n"},
        {"0.5,0.04,0,0,0,0,3,0,0",
         "boundary.start.rotation changes its sign at t = 0.04 s of the inputs; allowed: "
         "quaternions that go on, of which q and -q are one rotation",
         ""}};
    for (size_t i = 0; i < sizeof rows / sizeof *rows; i++) {
        ad_error error = {.message = ""};
        cpinn_unknowns *found = NULL;
        char text[2048];
        snprintf(text, sizeof text,
                 "s,t,x,y,z,X,a,Z,b\n0.5,0,0,0,0,0,0,0,0\n0.5,0.02,0,0,0,0,0.1,0,0\n%s\n",
                 rows[i].row);
        write_text("recorded.csv", text);
        snprintf(text, sizeof text, "%s%s", rows[i].beside, KNOWS_COLUMNS);
        write_text("scene.yaml", text);
        assert_int_not_equal(cpinn_identify_file(at("scene.yaml"), 0, NULL, 1, &found, &error),
                             AD_OK);
        print_message("%s\n", error.message);
        assert_non_null(strstr(error.message, rows[i].message));
    }
}

/* ---- what has no motion -------------------------------------------------------------------- */

/* A rod that does not stretch between two ends as far apart as it is long, at once or at the end of
 * a motion; modes that are fewer than directions. */
static void test_refused(void **state)
{
    (void)state;
    static const struct {
        const char *text, *message;
        int modes[4];
    } rows[] = {
        {"rod: {model: kirchhoff, " RUBBER "}\n"
         "boundary: {start: {type: clamped}, end: {type: clamped, " AT_THE_END "}}\n" PUSHED
         "time: {duration: 0.1}\n",
         "boundary.end: the modes do not move",
         {0}},
        {LOCKED_ARCH "boundary: {start: {type: pinned}, end: {type: driven,\n"
                     "  position: [0, 0, \"sin(0.6)/0.6*(1 - t^2) + t^2\"],\n"
                     "  rotation: [\"cos(0.3*(1 - t^2))\", 0, \"sin(0.3*(1 - t^2))\", 0]}}\n"
                     "initial: {position: [\"(cos(0.6 - 1.2*s) - cos(0.6))/1.2\", 0,\n"
                     "  \"(sin(0.6) - sin(0.6 - 1.2*s))/1.2\"],\n"
                     "  rotation: [\"cos(0.3 - 0.6*s)\", 0, \"-sin(0.3 - 0.6*s)\", 0]}\n"
                     "time: {duration: 1}\n",
         "boundary.end: the modes do not move",
         {0}},
        {ARCH DRIVEN "time: {duration: 0.1}\n", "boundary.end holds 6 directions", {1, 1, 1, 1}}};
    for (size_t i = 0; i < sizeof rows / sizeof *rows; i++) {
        solve_settings asked = {.tolerance = 1e-4, .method = SOLVE_MODES};
        ad_error error = {.message = ""};
        moved x;
        memcpy(asked.modes, rows[i].modes, sizeof asked.modes);
        assert_int_not_equal(try_to_move(rows[i].text, &asked, &x, &error), AD_OK);
        print_message("%s\n", error.message);
        assert_non_null(strstr(error.message, rows[i].message));
        discard_moved(&x);
    }
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_derivatives),       cmocka_unit_test(test_frequencies),
        cmocka_unit_test(test_spectral_elements), cmocka_unit_test(test_accelerations),
        cmocka_unit_test(test_recording),         cmocka_unit_test(test_reduced),
        cmocka_unit_test(test_followed),          cmocka_unit_test(test_sudden),
        cmocka_unit_test(test_bad_columns),       cmocka_unit_test(test_refused)};
    const struct CMUnitTest alike[] = {cmocka_unit_test(test_recorded_ends),
                                       cmocka_unit_test(test_steps),
                                       cmocka_unit_test(test_equilibrium)};
    return run_with_alike(tests, alike, make_directory, remove_directory);
}
