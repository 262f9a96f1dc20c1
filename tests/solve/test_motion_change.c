/* Derivatives of motions by parameters: a similarity that motions have exactly, differences of
 * solutions by the same modes, and of solutions by spectral elements, which share no equation with
 * them; what is refused. */
#include "config_testing.h"
#include "fewer.h"
#include "good.h"

#include "physics/solve/motion_change.h"
#include "tools/prepare/prepare.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

enum { PLACES = 4, TIMES = 3, POINTS = PLACES * TIMES, COLUMNS = 25, PARAMETERS_MAX = 3 };

typedef struct family {
    config *read;
    double s[POINTS], t[POINTS];
} family;

static family open_family(const char *text)
{
    family x;
    ad_error error = {.message = ""};
    assert_good(prepare_read("family.yaml", text, 0, NULL, &x.read, &error), &error);
    for (int i = 0; i < POINTS; i++) {
        x.s[i] = scene_length(&x.read->scene) * (i % PLACES + 1) / PLACES;
        x.t[i] = scene_duration(&x.read->scene) * (i / PLACES + 1) / TIMES;
    }
    return x;
}

static solve_settings by_modes(int modes, double tolerance)
{
    return (solve_settings){
        .tolerance = tolerance, .method = SOLVE_MODES, .modes = {modes, modes, modes, modes}};
}

/* values [COLUMNS][POINTS] of a member, as written, at the places that are these points' of it. */
static void solution_of(const family *x, const char *text, const double *parameters,
                        const solve_settings *settings, double *values)
{
    ad_error error = {.message = ""};
    char at[200] = "";
    double s[POINTS];
    config *member;
    solution *solved;
    solve_report report;
    for (int k = 0; k < scene_given_count(&x->read->scene); k++) {
        snprintf(at + strlen(at), sizeof at - strlen(at), "%s%s=%.17g", k ? "," : "",
                 x->read->scene.parameters[k].name, parameters[k]);
    }
    assert_good(prepare_read_member("family.yaml", text, 0, NULL, at, &member, &error), &error);
    assert_good(solution_create(&member->scene, settings, POINTS, x->t, &solved, &report, &error),
                &error);
    for (int i = 0; i < POINTS; i++) {
        s[i] = scene_at_place(
            &member->scene, scene_place_at(&x->read->scene, parameters, x->s[i], x->t[i]), x->t[i]);
    }
    assert_good(solution_evaluate(solved, COLUMNS, POINTS, s, x->t, values, &error), &error);
    solution_free(solved);
    config_free(member);
}

static motion_change_report change_of(const family *x, const double *parameters,
                                      const solve_settings *settings, double *by)
{
    ad_error error = {.message = ""};
    motion_change *change;
    motion_change_report report;
    assert_good(motion_change_create(&x->read->scene, parameters, settings, POINTS, x->t, &change,
                                     &report, &error),
                &error);
    assert_good(motion_change_evaluate(change, COLUMNS, POINTS, x->s, x->t, by, &error), &error);
    motion_change_free(change);
    return report;
}

/* ---- a similarity ---------------------------------------------------------------------------- */

/* All stiffness and forces times c: the motion is the same, in a time shorter by c^(1/2), so that
 * c r_c = t/2 r_t, forces grow by c besides, velocities by c^(1/2). Damping by force per velocity
 * grows by c^(1/2), too. */
static const char similar[] =
    "parameters: {e: {range: [0.5, 2]}, f: {range: [0.5, 2]}, d: {range: [0, 2]}}\n"
    "rod: {model: cosserat, length: 1, stiffness: {shear: [\"90*e\", \"90*e\"], axial: \"200*e\",\n"
    "       bending: [\"1.1*e\", \"0.9*e\"], torsion: \"0.8*e\"},\n"
    "      inertia: {mass_per_length: 1, rotary: [0.01, 0.012, 0.02]}}\n"
    "boundary: {start: {type: clamped}, end: {type: loaded}}\n"
    "loads: {drag: d, tip: {force: [\"1.3*f\", \"0.2*f\", \"-0.4*f\"]}}\n"
    "time: {duration: 1.5}\n";

static void test_similarity(void **state)
{
    (void)state;
    enum { VELOCITY = 19 };
    static const double at[3] = {1.1, 0.9, 0.3};
    static double values[COLUMNS * POINTS], by[COLUMNS * 3 * POINTS];
    family x = open_family(similar);
    const solve_settings settings = by_modes(4, 1e-10);
    double off = 0, size = 0;
    solution_of(&x, similar, at, &settings, values);
    change_of(&x, at, &settings, by);
    for (int c = 0; c < 3; c++) {
        for (int i = 0; i < POINTS; i++) {
            const double *of = by + c * 3 * POINTS + i;
            const double moved = at[0] * of[0] + at[1] * of[POINTS] + at[2] / 2 * of[2 * POINTS];
            off = fmax(off, fabs(moved - x.t[i] / 2 * values[(VELOCITY + c) * POINTS + i]));
            size = fmax(size, fabs(moved));
        }
    }
    print_message("similarity: %.1e of %.2g\n", off, size);
    assert_true(off < 1e-6 * size); /* changes of turns between points are of order 6 */
    config_free(x.read);
}

/* ---- differences ----------------------------------------------------------------------------- */

/* The largest distance of derivatives from differences of solutions, over the largest derivative of
 * the quantity by that parameter: positions, rotations, velocities and, where they are, forces. */
static double apart(const char *text, const double *at, const solve_settings *settings,
                    const solve_settings *other, double step, int columns)
{
    static double by[COLUMNS * PARAMETERS_MAX * POINTS], values[4][COLUMNS * POINTS];
    static const int ends[] = {3, 7, 10, 13, 16, 19, 22, 25};
    family x = open_family(text);
    const int p = x.read->scene.parameter_count;
    double worst = 0;
    change_of(&x, at, settings, by);
    for (int k = 0; k < scene_given_count(&x.read->scene); k++) {
        const scene_parameter *of = &x.read->scene.parameters[k];
        const double h = step * (of->high - of->low);
        double moved[PARAMETERS_MAX];
        for (int i = 0; i < 4; i++) {
            memcpy(moved, at, (size_t)p * sizeof *moved);
            moved[k] += h * (i < 2 ? i - 2 : i - 1);
            solution_of(&x, text, moved, other, values[i]);
        }
        for (int group = 0, c = 0; c < columns; group++) {
            double off = 0, size = 1e-3;
            for (; c < ends[group]; c++) {
                for (int i = 0; i < POINTS; i++) {
                    const int j = c * POINTS + i;
                    const double slope =
                        (8 * (values[2][j] - values[1][j]) - values[3][j] + values[0][j]) /
                        (12 * h);
                    off = fmax(off, fabs(by[(c * p + k) * POINTS + i] - slope));
                    size = fmax(size, fabs(slope));
                }
            }
            worst = fmax(worst, off / size);
        }
    }
    config_free(x.read);
    return worst;
}

#define ROD(parameters)                                                                            \
    "parameters: {" parameters "}\n"                                                               \
    "rod:\n"                                                                                       \
    "  model: cosserat\n"                                                                          \
    "  length: 1\n"                                                                                \
    "  stiffness: {shear: [60, 60], axial: 100, bending: [\"a\", \"a\"], torsion: 0.8}\n"          \
    "  inertia: {mass_per_length: \"1+b\", rotary: [0.01, 0.01, 0.02]}\n"                          \
    "  damping: {strain: [1, 1, 1], curvature: [0.02, \"0.02*a\", 0.02]}\n"

static const char many[] = ROD(
    "a: {range: [0.5, 2]}, b: {range: [0, 1]}, w: {range: [1, 4]}") "boundary: {start: {type: "
                                                                    "driven, position: "
                                                                    "[\"0.1*b*sin(w*t)^2\", 0, "
                                                                    "0]}, end: {type: loaded}}\n"
                                                                    "loads: {gravity: [\"b\", -1, "
                                                                    "0], tip: {force: [0, "
                                                                    "\"sin(w*t)\", 0.1], frame: "
                                                                    "follower},\n"
                                                                    "        fluid: {along: [0.1, "
                                                                    "0, 0.1], across: [0.2, 0, "
                                                                    "\"b\"], added_mass: 0.2}}\n"
                                                                    "bodies: [{at: 1, mass: "
                                                                    "\"0.2*b\", offset: [0.05, 0, "
                                                                    "0]}]\n"
                                                                    "springs: [{at: 0.5, "
                                                                    "stiffness: [1, \"2*a\", 1]}]\n"
                                                                    "tendons: [{offset: [0.05, "
                                                                    "0.01], tension: "
                                                                    "\"3*b*sin(w*t)^2\"}]\n"
                                                                    "time: {duration: 0.7}\n";

static const char held[] =
    ROD("a: {range: [0.5, 2]}, b: {range: [0, 1]}") "boundary: {start: {type: clamped},\n"
                                                    "           end: {type: clamped, position: "
                                                    "[0.1, 0, 0.87], rotation: [1, 0.1, 0, 0]}}\n"
                                                    "initial: {state: equilibrium}\n"
                                                    "loads: {force: [0, \"2*cos(4*b*t)\", 0]}\n"
                                                    "time: {duration: 0.3}\n";

static const char started[] = ROD(
    "a: {range: [0.5, 2]}, b: {range: [0, 1]}") "boundary: {start: {type: clamped, rotation: [1, "
                                                "0, \"0.2*b\", 0]}}\n"
                                                "initial: {velocity: [\"b*s^2\", \"0.3*s^2\", 0]}\n"
                                                "loads: {force: [\"where(t-0.3, b, 0)\", 0, 0]}\n"
                                                "time: {duration: 1}\n";

/* Springs of Maxwell branches, of which parameters are the ratio and the time. */
static const char relaxing[] =
    "parameters: {a: {range: [0.2, 1]}, b: {range: [0.05, 0.5]}}\n"
    "rod:\n"
    "  model: cosserat\n"
    "  length: 0.3\n"
    "  material: {youngs_modulus: 2e5, poissons_ratio: 0.4, density: 1000, relaxation_time: 0.01,\n"
    "             maxwell: {ratio: a, time: b}}\n"
    "  section: {shape: circle, radius: 0.01}\n"
    "boundary: {start: {type: clamped}}\n"
    "loads: {gravity: [0, 0, -9.81], tip: {force: [0, \"0.02*sin(20*t)\", 0]}}\n"
    "time: {duration: 0.4}\n";

/* It begins in the equilibrium of a base that rests, though the base is moved at once. */
static const char moved[] =
    ROD("a: {range: [0.5, 2]}, b: {range: [0, 1]}") "boundary: {start: {type: driven, position: "
                                                    "[\"b*sin(3*t)^2\", 0, 0]}}\n"
                                                    "initial: {state: equilibrium}\n"
                                                    "loads: {gravity: [0.5, \"b\", 0]}\n"
                                                    "time: {duration: 0.3}\n";

/* Lengths and places: the shape at rest is locked, or all strains have modes. */
#define LONG(model, stiffness, more)                                                               \
    "parameters: {l: {range: [0.4, 0.8]}, p: {range: [0.1, 0.3]}}\n"                               \
    "rod: {model: " model ", stiffness: {" stiffness "bending: [1, \"1+s\"], torsion: 0.8},\n"     \
    "      inertia: {mass_per_length: 1, rotary: [0.01, 0.01, 0.02]}, " more "}\n"                 \
    "segments: [{length: l}, {length: 0.4, inertia: {mass_per_length: 2}}]\n"                      \
    "boundary: {start: {type: clamped, rotation: [0, 1, 0, 1]}, end: {type: loaded}}\n"            \
    "initial: {velocity: [0, \"s^2\", 0]}\n"                                                       \
    "loads: {gravity: [0, 0, -2], foundation: [0, \"2+9*s\", 0],\n"                                \
    "        fluid: {across: [0.1, 0, 0.1], added_mass: 0.2},\n"                                   \
    "        tip: {force: [0, 0.5, 0], frame: follower}}\n"                                        \
    "bodies: [{at: p, mass: 0.3, offset: [0, 0.1, 0]}, {at: \"l+0.4\", mass: 0.2}]\n"              \
    "springs: [{at: l, stiffness: [1, 1, 1], turning: [0.1, 0.1, 0.1]}]\n"                         \
    "tendons: [{offset: [\"0.1*cos(3*s)\", \"0.1*sin(3*s)\"], tension: \"4*sin(3*t)^2\"},\n"       \
    "          {offset: [0.1, 0], end: l, tension: \"3*sin(4*t)^2\"}]\n"                           \
    "time: {duration: 0.4}\n"

static const char locked[] = LONG("kirchhoff", "", "damping: {curvature: [0.02, 0.02, 0.02]}");
static const char extending[] = LONG("cosserat", "shear: [60, 60], axial: 100, ",
                                     "damping: {strain: [1, 1, 1], curvature: [0.02, 0.02, 0.02]}");
/* Springs and the foundation, too, begin with a curved shape, by formulas along it and without. */
static const char curved[] =
    LONG("cosserat", "shear: [60, 60], axial: 100, ",
         "damping: {strain: [1, 1, 1], curvature: [0.02, 0.02, 0.02]},\n"
         "rest: {curvature: [\"9*p*s\", \"1+4*p\", \"l*sin(3*s)\"], strain: [0, 0.1, \"1-p\"]}");
static const char bent[] =
    "parameters: {a: {range: [0.5, 2]}, b: {range: [-1, 1]}}\n"
    "rod: {model: kirchhoff, length: 1, stiffness: {bending: [1, 1], torsion: 0.8},\n"
    "      inertia: {mass_per_length: 1, rotary: [0.01, 0.01, 0.02]},\n"
    "      damping: {curvature: [0.02, 0.02, 0.02]}, rest: {curvature: [a, b, 0]}}\n"
    "boundary: {start: {type: driven, position: [0, \"b*sin(3*t)^2\", 0]}}\n"
    "springs: [{at: 1, stiffness: [1, 2, 3]}, {at: 0.4, turning: [1, 1, 1]}]\n"
    "loads: {gravity: [0, 0, -2]}\n"
    "time: {duration: 0.4}\n";

/* What comes out of a port, which moves; it stays, follows a formula, or a drive. */
#define INSERTED(out)                                                                              \
    "parameters: {l: {range: [0.5, 0.9]}}\n"                                                       \
    "rod: {model: kirchhoff, length: 1, inserted: " out ",\n"                                      \
    "      stiffness: {bending: [1, 1], torsion: 0.8},\n"                                          \
    "      inertia: {mass_per_length: 1, rotary: [0.01, 0.01, 0.02]},\n"                           \
    "      damping: {curvature: [0.02, 0.02, 0.02]}}\n"                                            \
    "boundary: {start: {type: driven, position: [0, \"l*sin(3*t)^2\", 0]}}\n"                      \
    "loads: {gravity: [0, 1, -2]}\n"                                                               \
    "bodies: [{at: 1, mass: 0.2}]\n"                                                               \
    "tendons: [{offset: [\"0.1*cos(3*s)\", \"0.1*sin(3*s)\"], tension: \"4*sin(3*t)^2\"}]\n"       \
    "time: {duration: 0.4}\n"

static void test_lengths(void **state)
{
    (void)state;
    static const double at[2] = {0.65, 0.17};
    const solve_settings settings = by_modes(2, 1e-10);
    const double held = apart(locked, at, &settings, &settings, 1e-3, COLUMNS);
    const double free = apart(extending, at, &settings, &settings, 1e-3, COLUMNS);
    const double shaped = apart(curved, at, &settings, &settings, 1e-3, COLUMNS);
    const double uniform =
        apart(bent, (const double[]){1.1, 0.3}, &settings, &settings, 1e-3, COLUMNS);
    const double out = apart(INSERTED("l"), at, &settings, &settings, 1e-3, COLUMNS);
    const double moves = apart(INSERTED("\"l*(1-t^2)\""), at, &settings, &settings, 1e-3, COLUMNS);
    const double fed =
        apart(INSERTED("l, feed_time: 0.1"), at, &settings, &settings, 1e-3, COLUMNS);
    print_message("lengths: locked %.1e, free %.1e, inserted %.1e, moved %.1e, driven %.1e; curved "
                  "at rest %.1e, uniformly %.1e\n",
                  held, free, out, moves, fed, shaped, uniform);
    assert_true(shaped < 1e-6);
    assert_true(uniform < 1e-6);
    assert_true(out < 1e-6);
    assert_true(moves < 1e-6);
    assert_true(held < 1e-6);
    assert_true(free < 1e-6);
    assert_true(fed < 1e-6);
}

/* A play that has been where parameters are for long. */
static const char played[] =
    ROD("a: {range: [0.5, 2]}, b: {range: [0, 1]}") "boundary: {start: {type: clamped}}\n"
                                                    "loads: {force: [\"play(3*b, 0.2*a)\", 0, 0]}\n"
                                                    "time: {duration: 0.4}\n";

static void test_differences(void **state)
{
    (void)state;
    static const double at[3] = {1.2, 0.4, 2.3};
    const solve_settings settings = by_modes(3, 1e-10);
    /* Of the held end modes are of another reference shape: as many as the tolerance asks for. */
    const solve_settings usual = {.tolerance = 1e-6, .method = SOLVE_MODES};
    const double all = apart(many, at, &settings, &settings, 1e-3, COLUMNS);
    const double free = apart(started, at, &settings, &settings, 1e-3, COLUMNS);
    const double closed = apart(held, at, &usual, &usual, 1e-2, 7);
    const double relaxed =
        apart(relaxing, (double[]){0.6, 0.2}, &settings, &settings, 5e-3, COLUMNS);
    enum { SEEN = 9 };
    solve_seen seen[SEEN];
    for (int i = 0; i < SEEN; i++) {
        const double s = i / (SEEN - 1.0);
        seen[i] =
            (solve_seen){s, {0.1 * s * s, 0, s}, {1, 0, 0.1 * s, 0}, {0, 0.3 * s * s, 0}, {0}};
    }
    solve_settings from = settings;
    from.from = seen;
    from.from_count = SEEN;
    const double given = apart(started, at, &from, &from, 1e-3, COLUMNS);
    const double rests = apart(played, at, &settings, &settings, 1e-3, COLUMNS);
    const double begun = apart(moved, at, &usual, &usual, 1e-2, 7);
    print_message("differences: %.1e, %.1e, of a branch %.1e, of a held end %.1e, of a moved base "
                  "%.1e, from a state %.1e, of a play %.1e\n",
                  all, free, relaxed, closed, begun, given, rests);
    assert_true(rests < 1e-6);
    assert_true(given < 1e-6);
    assert_true(all < 1e-6); /* solutions are off by 1e-10 over a step of 1e-3; and steps differ */
    assert_true(free < 1e-6);
    assert_true(relaxed < 1e-6);
    assert_true(closed < 1e-4); /* what both are asked for */
    assert_true(begun < 1e-4);
}

static void test_elements(void **state)
{
    (void)state;
    static const double at[3] = {1.2, 0.4, 2.3};
    static double by[COLUMNS * PARAMETERS_MAX * POINTS];
    const solve_settings settings = {.tolerance = 1e-6, .method = SOLVE_MODES};
    const solve_settings nodes = {.tolerance = 1e-6, .method = SOLVE_COLLOCATION};
    family x = open_family(many);
    const motion_change_report report = change_of(&x, at, &settings, by);
    const double off = apart(many, at, &settings, &nodes, 1e-2, 3);
    config_free(x.read);
    print_message("spectral elements: %.1e, estimated %.1e\n", off, report.estimate);
    assert_true(report.estimate <= MOTION_CHANGE_OF_TOLERANCE * settings.tolerance);
    assert_true(off < 3 * MOTION_CHANGE_OF_TOLERANCE * settings.tolerance); /* at most, not rms */
}

/* ---- refusals -------------------------------------------------------------------------------- */

static void refused(const char *text, const char *why)
{
    static const double at[3] = {0.7, 0.4, 2.3};
    const solve_settings settings = by_modes(2, 1e-6);
    ad_error error = {.message = ""};
    motion_change *change;
    motion_change_report report;
    family x = open_family(text);
    assert_int_equal(
        motion_change_create(&x.read->scene, at, &settings, POINTS, x.t, &change, &report, &error),
        AD_BAD_ARGUMENT);
    assert_null(change);
    if (!strstr(error.message, why)) {
        fail_msg("%s, not %s", error.message, why);
    }
    config_free(x.read);
}

static void test_refusals(void **state)
{
    (void)state;
    refused(ROD("a: {range: [0.5, 2]}, b: {range: [0, 1]}") "boundary: {start: {type: clamped}}\n"
                                                            "loads: {force: [\"where(t-0.5*b, 1, "
                                                            "0)\", 0, 0]}\n"
                                                            "time: {duration: 1}\n",
            "the parameter b moves an instant");
    refused(ROD("a: {range: [0.5, 2]}, b: {range: [0, 1]}") "boundary: {start: {type: clamped}}\n"
                                                            "loads: {force: [\"where(s-0.5*b, 1, "
                                                            "0)\", 0, 0]}\n"
                                                            "time: {duration: 1}\n",
            "the parameter b moves a place");
}

int main(void)
{
    const struct CMUnitTest tests[] = {cmocka_unit_test(test_differences),
                                       cmocka_unit_test(test_lengths),
                                       cmocka_unit_test(test_refusals)};
    const struct CMUnitTest alike[] = {cmocka_unit_test(test_similarity),
                                       cmocka_unit_test(test_elements)};
    return run_with_alike(tests, alike, NULL, NULL);
}
