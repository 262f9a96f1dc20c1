/* Paths of equilibria: limit points, bifurcations and branches against independent solutions, ends
 * turned by more than half a turn against closed forms. */
#include "allocations.h"
#include "config_testing.h"
#include "fewer.h"
#include "rod_testing.h"

#include "physics/solve/solve.h"

typedef struct followed {
    config *settings;
    solution_path *path;
    solution *solved;
    solve_report report;
    verdict verdict;
} followed;

static followed solve(const char *text, const char *override, int branch)
{
    ad_error error = {.message = ""};
    const solve_settings asked = {.tolerance = 1e-10, .branch = branch};
    followed x = {.settings = read_with(text, override)};
    const scene *given = &x.settings->scene;
    if (solution_create(given, &asked, 0, NULL, &x.solved, &x.report, &error) != AD_OK) {
        fail_msg("%s", error.message);
    }
    solution_verdict(x.solved, given, &asked, &x.report, &x.verdict);
    return x;
}

static followed follow(const char *text, const char *override, int branch)
{
    ad_error error = {.message = ""};
    const solve_settings asked = {.tolerance = 1e-10, .branch = branch};
    followed x = {.settings = read_with(text, override)};
    if (solution_path_create(&x.settings->scene, &asked, &x.path, &error) != AD_OK) {
        fail_msg("%s", error.message);
    }
    return x;
}

static void release(followed *x)
{
    solution_free(x->solved);
    solution_path_free(x->path);
    config_free(x->settings);
}

/* Position at s, m. */
static void place(const followed *x, double s, double position[3])
{
    assert_int_equal(solution_evaluate(x->solved, 3, 1, &s, NULL, position, NULL), AD_OK);
}

typedef struct expected_mark {
    solution_mark mark;
    double load, tolerance;
} expected_mark;

/* The marks of a path are these, in their order, and no others. */
static void assert_marks(const solution_path *path, const expected_mark *marks, size_t count)
{
    size_t found = 0;
    for (size_t i = 0; i < path->count; i++) {
        const solution_path_point *p = &path->points[i];
        if (p->mark != SOLUTION_PLAIN) {
            assert_true(found < count);
            assert_int_equal(p->mark, marks[found].mark);
            assert_near(p->load, marks[found].load, marks[found].tolerance);
            found++;
        }
    }
    assert_int_equal(found, count);
    assert_true(count == 0 || path->estimate <= 1e-9);
}

/* ---- arches -------------------------------------------------------------------------------- */

/* A circular arch of half angle 0.5 under a dead load of 100 EI/L^3 per length, with shear and
 * stretch. Loads by shooting over the planar rod with 4,000 steps of the classical Runge-Kutta
 * method and complex steps, and Newton's method on equilibrium and determinant: limit points to
 * 1e-11, bifurcations to 5e-10, as 2,000 steps show. */
#define ARCH(start, end)                                                                           \
    "parameters: {a: 0.5}\n"                                                                       \
    "motion: planar\n" /* it would turn about its pins */                                          \
    "rod:\n"                                                                                       \
    "  length: 1\n"                                                                                \
    "  stiffness: {shear: [40000, 40000], axial: 100000, bending: [1, 1], torsion: 0.8}\n"         \
    "  rest: {curvature: [0, 2*a, 0]}\n"                                                           \
    "boundary:\n"                                                                                  \
    "  start: {type: " start "}\n"                                                                 \
    "  end: {type: " end ", position: [sin(a)/a, 0, 0]}\n"                                         \
    "loads: {force: [0, 0, -100]}\n"

static const char clamped_arch[] = ARCH("clamped, rotation: [cos(pi/4-a/2), 0, sin(pi/4-a/2), 0]",
                                        "clamped, rotation: [cos(pi/4+a/2), 0, sin(pi/4+a/2), 0]");
static const char pinned_arch[] = ARCH("pinned", "pinned");

/* Modes become unstable at one mark and stable again at another. */
static void check_modes(const solution_path *path)
{
    static const int modes[] = {0, 1, 2, 1, 0}; /* between the marks of the clamped arch */
    int stretch = 0;
    for (size_t i = 0; i < path->count; i++) {
        const solution_path_point *p = &path->points[i];
        if (p->mark != SOLUTION_PLAIN) {
            stretch++;
        } else if (i + 1 < path->count && p[1].mark == SOLUTION_PLAIN &&
                   (i == 0 || p[-1].mark == SOLUTION_PLAIN)) {
            assert_int_equal(p->unstable_modes, modes[stretch]);
        }
    }
    assert_int_equal(stretch, 4);
}

static void test_arch_paths(void **state)
{
    (void)state;
    static const expected_mark clamped[] = {
        {SOLUTION_BIFURCATION, 0.8097547451193, 1e-9},
        {SOLUTION_LIMIT, 1.060396312021, 2e-11},
        {SOLUTION_BIFURCATION, 0.1760263819263, 1e-9},
        {SOLUTION_LIMIT, 0.1707556555695, 2e-11},
    };
    static const expected_mark pinned[] = {
        {SOLUTION_BIFURCATION, 0.3910040734012, 1e-9},
        {SOLUTION_LIMIT, 0.7730884138173, 2e-11},
        {SOLUTION_LIMIT, -0.3541024371787, 2e-11},
        {SOLUTION_BIFURCATION, -0.1895153925644, 1e-9},
    };
    followed x = follow(clamped_arch, NULL, 0);
    assert_marks(x.path, clamped, 4);
    check_modes(x.path);
    const solution_path_point *last = &x.path->points[x.path->count - 1];
    assert_true(x.path->arrived);
    assert_near(last->load, 1, 0);
    assert_int_equal(last->unstable_modes, 0);
    assert_near(x.path->place, 0.5, 0); /* the crown, downwards */
    assert_near(x.path->direction[2], -1, 1e-9);
    release(&x);
    if (!WATCHED) { /* which the tests below follow as well */
        x = follow(pinned_arch, NULL, 0);
        assert_marks(x.path, pinned, 4);
        release(&x);
    }
}

/* By default the equilibrium beyond the snap, and a word. Below the limit point none. */
static void test_snap(void **state)
{
    (void)state;
    double crown[3];
    followed x = solve(pinned_arch, NULL, 0);
    assert_near(x.report.load_fraction, 1, 0);
    assert_true(x.report.snapped);
    assert_near(x.report.limit_load, 0.7730884138173, 2e-11);
    assert_near(x.report.bifurcation_load, 0.3910040734012, 1e-9);
    assert_true(x.report.estimate <= 1e-10);
    assert_int_equal(verdict_worst(&x.verdict), VERDICT_SNAPPED);
    assert_int_equal(verdict_exit_status(&x.verdict), 3);
    place(&x, 0.5, crown);
    assert_true(crown[2] < -0.1); /* inverted: 0.122 high without loads */
    release(&x);
    x = solve(pinned_arch, "loads.force[2]=-20", 0);
    assert_false(x.report.snapped);
    assert_true(isnan(x.report.limit_load) && isnan(x.report.bifurcation_load));
    assert_int_equal(verdict_outcome_of(&x.verdict), VERDICT_SOLVED);
    place(&x, 0.5, crown);
    assert_true(crown[2] > 0.1);
    release(&x);
}

/* The asymmetric path of an arch leads from one bifurcation to the other and back; it turns where
 * it meets the symmetric one, so that this load comes out of another computation. */
static void test_closed_branch(void **state)
{
    (void)state;
    static const expected_mark marks[] = {{SOLUTION_BIFURCATION, 0.3910040734012, 1e-9},
                                          {SOLUTION_LIMIT, -0.1895153925644, 1e-9}};
    followed x = follow(pinned_arch, NULL, 1);
    assert_false(x.path->arrived);
    assert_marks(x.path, marks, 2);
    release(&x);
    if (!WATCHED) { /* the same path */
        x = solve(pinned_arch, NULL, 1);
        assert_int_equal(verdict_worst(&x.verdict), VERDICT_LOAD_NOT_REACHED);
        release(&x);
    }
}

/* The deep arch of 215 degrees, clamped and hinged, inextensible, with a force at its crown:
 * P R^2/EI = 8.97 (DaDeppo and Schmidt, J. Appl. Mech. 42, 1975); within the digits given. */
static void test_deep_arch(void **state)
{
    (void)state;
    static const char text[] =
        "parameters: {b: 215*pi/180}\n"
        "rod:\n"
        "  model: kirchhoff\n"
        "  length: 215*pi/180\n"
        "  stiffness: {bending: [1, 1], torsion: 0.8}\n"
        "  rest: {curvature: [0, 1, 0]}\n"
        "boundary:\n"
        "  start: {type: clamped, rotation: [cos((pi-b)/4), 0, sin((pi-b)/4), 0]}\n"
        "  end: {type: pinned, position: [2*sin(b/2), 0, 0]}\n"
        "loads: {points: [{at: 215*pi/360, force: [0, 0, -10]}]}\n";
    followed x = follow(text, NULL, 0);
    size_t i = 0;
    while (i < x.path->count && x.path->points[i].mark == SOLUTION_PLAIN) {
        i++;
    }
    assert_true(i < x.path->count && x.path->points[i].mark == SOLUTION_LIMIT);
    assert_near(10 * x.path->points[i].load, 8.97, 0.005);
    release(&x);
}

/* ---- columns ------------------------------------------------------------------------------- */

/* Twice Euler's load: bifurcations at pi^2/4 (2k - 1)^2; buckled: elliptic integrals. */
static void test_column(void **state)
{
    (void)state;
    static const char column[] =
        "rod: {model: kirchhoff, length: 1, stiffness: {bending: [1, 1], torsion: 0.8}}\n"
        "boundary: {start: {type: clamped}}\n"
        "loads: {tip: {force: [0, 0, -pi^2/2]}}\n";
    double tip[3];
    const expected_mark first = {SOLUTION_BIFURCATION, 0.5, 1e-12};
    followed x = follow(column, NULL, 1);
    assert_marks(x.path, &first, 1);
    release(&x);
    x = solve(column, NULL, 0);
    assert_int_equal(verdict_worst(&x.verdict), VERDICT_UNSTABLE);
    assert_near(x.report.bifurcation_load, 0.5, 1e-12);
    release(&x);
    x = solve(column, NULL, 1);
    assert_int_equal(verdict_outcome_of(&x.verdict), VERDICT_SOLVED);
    place(&x, 1, tip);
    assert_near(fabs(tip[0]), 0.796961415519955, 1e-12);
    assert_near(tip[2], 0.0708618164017102, 1e-12);
    release(&x);
    x = solve(column, "loads.tip.force[2]=-3*pi^2", 0); /* 12 times */
    assert_near(x.report.bifurcation_load, 1.0 / 12, 1e-12);
    release(&x);
}

/* A tall strip under a force at its tip falls over at P = 4.0126 (EI GJ)^(1/2)/L^2 (Michell and
 * Prandtl 1899), where its path in the plane has no mark. Bending downwards by 1e-5 and elements of
 * 1/512 change it by less than 0.1 %. */
static void test_falling_over(void **state)
{
    (void)state;
    static const char strip[] =
        "rod: {model: kirchhoff, length: 1, stiffness: {bending: [1, 1e5], torsion: 0.5}}\n"
        "loads: {tip: {force: [2*2.837337, 0, 0]}}\n";
    const char *const motions[] = {"motion=automatic", "motion=planar"};
    for (int kept = 0; kept < 2; kept++) {
        followed x = follow(strip, motions[kept], 0);
        int both[2] = {0};
        assert_marks(x.path, NULL, 0);
        for (size_t i = 0; i < x.path->count; i++) {
            const solution_path_point *p = &x.path->points[i];
            if (fabs(p->load - 0.5) > 5e-4) {
                assert_int_equal(p->unstable_modes, kept ? 0 : p->load > 0.5);
                both[p->load > 0.5]++;
            }
        }
        assert_true(both[0] > 0 && both[1] > 0);
        release(&x);
    }
}

/* A column that leans a little bends off just below Euler's load, where the straight, unstable
 * equilibria of the perfect one are near. */
static void test_leaning_column(void **state)
{
    (void)state;
    static const char column[] =
        "rod: {model: kirchhoff, length: 1, stiffness: {bending: [1, 1], torsion: 0.8}}\n"
        "boundary: {start: {type: clamped}}\n"
        "loads: {tip: {force: [1.0e-3, 0, -1.01*pi^2/4]}}\n";
    double tip[3];
    followed x = solve(column, NULL, 0);
    assert_int_equal(verdict_outcome_of(&x.verdict), VERDICT_SOLVED);
    assert_true(isnan(x.report.bifurcation_load) && isnan(x.report.limit_load));
    place(&x, 1, tip);
    assert_true(tip[0] > 0.177948360856423); /* that of the column that does not lean, buckled */
    release(&x);
    x = follow(column, NULL, 0);
    assert_marks(x.path, NULL, 0);
    release(&x);
}

/* A straight rod between clamps, twisted by an end: it buckles at the moment 2 x with tan x = x,
 * 8.986818915818128 EI/L (Greenhill 1883, clamped ends), here at 4 pi GJ/L times the load. Shear
 * and stretch, 1e-8 of their usual softness, do not enter. Two modes at once, in space. */
static void test_twist(void **state)
{
    (void)state;
    static const char text[] =
        "rod:\n"
        "  length: 1\n"
        "  stiffness: {shear: [1.0e9, 1.0e9], axial: 1.0e9, bending: [1, 1], torsion: 0.8}\n"
        "boundary:\n"
        "  start: {type: clamped}\n"
        "  end: {type: clamped, position: [0, 0, 1], rotation_vector: [0, 0, 4*pi]}\n";
    followed x = solve(text, NULL, 0);
    assert_int_equal(verdict_worst(&x.verdict), VERDICT_UNSTABLE);
    assert_near(x.report.bifurcation_load, 8.986818915818128 / (0.8 * 4 * PI), 1e-8);
    release(&x);
}

/* A straight rod bent into a ring about x, then twisted: it writhes beyond the twist
 * 2 pi 3^(1/2) B/C (Zajac 1962, J. Appl. Mech. 29). Without the spring, which nothing pulls at, the
 * whole ring could turn about its tangent where it is held. The
 * path ends at 3^(1/2) times that twist, where more than three modes are unstable. Off by at most
 * 5.4e-10, which is the mesh's; with any kernels of BLAS. */
static void test_ring(void **state)
{
    (void)state;
    static const char text[] =
        "parameters: {B: 2, C: 1}\n"
        "rod: {model: kirchhoff, length: 1, stiffness: {bending: [B, B], torsion: C}}\n"
        "boundary:\n"
        "  start: {type: clamped}\n"
        "  end: {type: clamped, position: [0, 0, 0], rotation_vector: [2*pi, 0, 0],\n"
        "        twist: 2*pi*3*B/C}\n"
        "springs: [{at: 0.5, stiffness: [B, 0, 0]}]\n";
    const solve_settings asked = {.tolerance = 1e-10, .nodes = 80};
    for (int i = 0; i < FEWER(3); i++) {
        solution_path *path = NULL;
        size_t mark = 0;
        config *settings =
            read_with(text, (const char *[]){NULL, "parameters.C=1.6", "parameters.C=3"}[i]);
        assert_int_equal(solution_path_create(&settings->scene, &asked, &path, NULL), AD_OK);
        while (mark < path->count && path->points[mark].mark == SOLUTION_PLAIN) {
            mark++;
        }
        assert_true(mark < path->count);
        assert_int_equal(path->points[mark].mark, SOLUTION_BIFURCATION);
        assert_int_equal(path->points[mark - 1].unstable_modes, 0);
        assert_near(path->points[mark].load, 1 / sqrt(3), 1e-9);
        solution_path_free(path);
        config_free(settings);
    }
}

/* ---- turned ends --------------------------------------------------------------------------- */

#define TURNED                                                                                     \
    "parameters: {a: 1.5*pi}\n"                                                                    \
    "motion: planar\n" /* in space more than a turn gives way to the side */                       \
    "rod: {model: kirchhoff, length: 1, stiffness: {bending: [1, 1], torsion: 0.8}}\n"             \
    "boundary:\n"                                                                                  \
    "  start: {type: clamped}\n"                                                                   \
    "  end: {type: clamped, position: [(1-cos(a))/a, 0, sin(a)/a], "

/* A clamped end turned by the angle a about y: an arc, with moment a EI/L and no force. */
static void check_arc(const char *override, double a)
{
    followed x = solve(TURNED "rotation_vector: [0, a, 0]}\n", override, 0);
    for (int i = 0; i <= 8; i++) {
        double s = i / 8.0, position[3];
        place(&x, s, position);
        assert_near(position[0], (1 - cos(a * s)) / a, 1e-10);
        assert_near(position[1], 0, 1e-10);
        assert_near(position[2], sin(a * s) / a, 1e-10);
    }
    solve_energy energy;
    assert_int_equal(solution_energy(x.solved, 0, &energy, NULL), AD_OK);
    assert_near(energy.strain / (a * a / 2), 1, 1e-9);
    assert_int_equal(verdict_outcome_of(&x.verdict), VERDICT_SOLVED);
    release(&x);
}

static void test_turned_ends(void **state)
{
    (void)state;
    check_arc(NULL, 1.5 * PI);
    check_arc("parameters.a=-1.5*pi", -1.5 * PI);
    check_arc("parameters.a=2*pi", 2 * PI);
    check_arc("parameters.a=4*pi", 4 * PI); /* a ring of two turns */
    check_arc("parameters.a=9.25*pi", 9.25 * PI);
    check_arc("parameters.a=54*pi", 54 * PI); /* wound 27 times */
}

/* The quaternion of three quarters of a turn is that of a quarter back, which is said. */
static void test_quaternion(void **state)
{
    (void)state;
    followed x = solve(TURNED "rotation: [cos(a/2), 0, sin(a/2), 0]}\n", NULL, 0);
    assert_true(verdict_has(&x.verdict, VERDICT_END_TURN));
    release(&x);
    x = solve(TURNED "rotation: [cos(a/2), 0, sin(a/2), 0]}\n", "parameters.a=0.5*pi", 0);
    assert_false(verdict_has(&x.verdict, VERDICT_END_TURN));
    release(&x);
}

/* ---- what has no path ---------------------------------------------------------------------- */

static void refuse(const char *text, solve_settings asked, const char *word)
{
    ad_error error = {.message = ""};
    solution_path *path = NULL;
    config *settings = read_with(text, NULL);
    assert_int_equal(solution_path_create(&settings->scene, &asked, &path, &error),
                     AD_BAD_ARGUMENT);
    assert_null(path);
    if (!strstr(error.message, word)) {
        fail_msg("%s: %s", word, error.message);
    }
    config_free(settings);
}

static void test_refusals(void **state)
{
    (void)state;
    static const char column[] =
        "rod: {model: kirchhoff, length: 1, stiffness: {bending: [1, 1], torsion: 0.8}}\n"
        "boundary: {start: {type: clamped}}\n"
        "loads: {tip: {force: [0, 0, -3]}}\n";
    static const char hanging[] = /* its weight turns it out of the plane of its arc */
        "rod: {model: kirchhoff, length: 1, stiffness: {bending: [1, 1], torsion: 0.8},\n"
        "  inertia: {mass_per_length: 1}, rest: {curvature: [0, 1, 0]}}\n"
        "boundary:\n"
        "  start: {type: pinned}\n"
        "  end: {type: pinned, position: [0.9, 0, 0]}\n"
        "loads: {gravity: [0, 1, 0]}\n";
    refuse(column, (solve_settings){.tolerance = 1e-8, .perturbation = 1}, "perturbation");
    refuse(column, (solve_settings){.tolerance = 1e-8, .branch = 2}, "1 bifurcation");
    refuse(hanging, (solve_settings){.tolerance = 1e-8}, "nothing holds the rod");
}

static void test_no_memory(void **state)
{
    (void)state;
    static const char column[] =
        "rod: {model: kirchhoff, length: 1, stiffness: {bending: [1, 1], torsion: 0.8}}\n"
        "boundary: {start: {type: clamped}}\n"
        "loads: {tip: {force: [0, 0, -3]}}\n";
    const solve_settings asked = {.tolerance = 1e-8, .branch = 1};
    config *settings = read_with(column, NULL);
    long needed = 0;
    int told = 0;
    for (long n = 0; n <= needed; n += n < 20 ? 1 : 37) {
        solution_path *path = NULL;
        allocations = 0;
        failing_allocation = n;
        ad_status status = solution_path_create(&settings->scene, &asked, &path, NULL);
        failing_allocation = 0;
        needed = n == 0 ? allocations : needed;
        assert_true(status == AD_OK || (status == AD_NO_MEMORY && path == NULL));
        told += status == AD_NO_MEMORY;
        solution_path_free(path);
    }
    assert_true(needed > 100 && told > 20);
    config_free(settings);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_snap),       cmocka_unit_test(test_closed_branch),
        cmocka_unit_test(test_quaternion), cmocka_unit_test(test_refusals),
        cmocka_unit_test(test_no_memory),  cmocka_unit_test(test_ring),
    };
    const struct CMUnitTest alike[] = {
        cmocka_unit_test(test_column),       cmocka_unit_test(test_leaning_column),
        cmocka_unit_test(test_falling_over), cmocka_unit_test(test_arch_paths),
        cmocka_unit_test(test_deep_arch),    cmocka_unit_test(test_twist),
        cmocka_unit_test(test_turned_ends),
    };
    return run_with_alike(tests, alike, NULL, NULL);
}
