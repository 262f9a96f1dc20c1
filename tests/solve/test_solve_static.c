/* Static rods solved classically, against closed forms and published values, and put into the
 * residuals that networks are trained on. */
#include "rod_testing.h"
#include "solve_memory.h"

#include "physics/solve/static.h"
#include "physics/solve/static_newton.h"
#include "tools/prepare/config_experiment.h"
#include "tools/train/experiment.h"
#include "tools/train/reference.h"

#include <string.h>

/* Lengths; what is asked of the solver, which does better. */
static const double asked = 1e-10;

typedef struct solved {
    config *settings;
    solve_rod *rod;
    static_solution *solution;
    solve_report report;
} solved;

static solved solve_with(const char *path, const char *text, const char *override,
                         solve_settings settings)
{
    ad_error error = {.message = ""};
    solved x = {.settings = NULL};
    if (prepare_read(path, text, override != NULL, &override, &x.settings, &error) != AD_OK ||
        solve_rod_create(&x.settings->scene, &x.rod, &error) != AD_OK ||
        static_solve(x.rod, &settings, NULL, &x.solution, &x.report, &error) != AD_OK) {
        fail_msg("%s", error.message);
    }
    return x;
}

static solved solve(const char *path, const char *text, const char *override, double perturbation)
{
    const solve_settings settings = {.tolerance = 1e-10, .perturbation = perturbation};
    solved x = solve_with(path, text, override, settings);
    assert_near(x.report.load_fraction, 1, 0);
    assert_true(x.report.estimate <= settings.tolerance);
    return x;
}

static void release(solved *x)
{
    static_free(x->solution);
    solve_rod_free(x->rod);
    config_free(x->settings);
}

static solve_state at(const solved *x, double s)
{
    solve_state state;
    assert_int_equal(static_at(x->solution, 1, &s, &state, NULL), AD_OK);
    return state;
}

static void assert_vector(const double *value, double a, double b, double c, double tolerance)
{
    assert_near(value[0], a, tolerance);
    assert_near(value[1], b, tolerance);
    assert_near(value[2], c, tolerance);
}

/* ---- closed forms -------------------------------------------------------------------------- */

/* Against the reference that the scene names, at its points. */
static void check_reference(const char *path, const char *override, double tolerance)
{
    ad_error error = {.message = ""};
    config *settings = NULL;
    experiment *e = NULL;
    reference *r = NULL;
    solution *found = NULL;
    solve_report report;
    reference_errors errors;
    const solve_settings wanted = {.tolerance = asked};
    if (prepare_read(path, NULL, override != NULL, &override, &settings, &error) != AD_OK ||
        config_experiment_create(settings, 1, &e, &error) != AD_OK ||
        reference_create(e, &r, &error) != AD_OK ||
        solution_create(&settings->scene, &wanted, 0, NULL, &found, &report, &error) != AD_OK ||
        reference_compare_solution(r, found, &errors, &error) != AD_OK) {
        fail_msg("%s", error.message);
    }
    assert_near(report.load_fraction, 1, 0);
    assert_true(report.estimate <= asked);
    if (!(errors.position_max <= tolerance && errors.rotation_max <= tolerance)) {
        fail_msg("%s %s: %g, %g rad", path, override ? override : "", errors.position_max,
                 errors.rotation_max);
    }
    solution_free(found);
    reference_free(r);
    experiment_free(e);
}

static void test_closed_forms(void **state)
{
    (void)state;
    check_reference("configs/elastica.yaml", NULL, asked);
    check_reference("configs/elastica.yaml", "loads.tip.force[2]=-10", asked);
    check_reference("configs/elastica.yaml", "loads.tip.force[2]=-1000", asked);
    check_reference("configs/rollup.yaml", NULL, asked);
    check_reference("configs/rollup.yaml", "loads.tip.moment=[0,-4*pi,0]", asked);
    check_reference("configs/rollup.yaml", "loads.tip.moment=[0,10*pi,0]", asked); /* 5 turns */
    check_reference("configs/helix.yaml", NULL, asked);
    check_reference("configs/helix.yaml", "loads.tip.moment=[0,25,20]", asked); /* 5 turns */
    check_reference("configs/cases/tapered.yaml", NULL, asked);
    check_reference("configs/heavy_cantilever.yaml",
                    "reference={solve: null, file: reference/heavy_cantilever.csv}", asked);
}

/* n = l u, m = l v + k u and u* = u - Kbt^-1 m leave strains constant: shear, stretch, bending and
 * twist, exactly; k = 0.4, u = (2, -1, 3). The pose is the exponential of the twist s (u, v). */
typedef struct constant_strain {
    double l, u[3], v[3], m[3], rest[3];
    char text[1024];
} constant_strain;

static const double strain_stiffness[3] = {800, 900, 2000}, curvature_stiffness[3] = {1, 1.7, 0.6};

static void cross(const double *a, const double *b, double *result)
{
    for (int i = 0; i < 3; i++) {
        result[i] = a[(i + 1) % 3] * b[(i + 2) % 3] - a[(i + 2) % 3] * b[(i + 1) % 3];
    }
}

/* Rodrigues' formula: the vector turned by the angle |u| s about u. */
static void turn(const double *u, double s, const double *vector, double *result)
{
    double size = sqrt(u[0] * u[0] + u[1] * u[1] + u[2] * u[2]), once[3], twice[3];
    cross(u, vector, once);
    cross(u, once, twice);
    for (int i = 0; i < 3; i++) {
        result[i] = vector[i] + sin(size * s) / size * once[i] +
                    (1 - cos(size * s)) / (size * size) * twice[i];
    }
}

/* The integral of the turned v. */
static void place(const constant_strain *c, double s, double *result)
{
    const double *u = c->u;
    double square = u[0] * u[0] + u[1] * u[1] + u[2] * u[2], size = sqrt(square), once[3], twice[3];
    cross(u, c->v, once);
    cross(u, once, twice);
    for (int i = 0; i < 3; i++) {
        result[i] = s * c->v[i] + (1 - cos(size * s)) / square * once[i] +
                    (s - sin(size * s) / size) / square * twice[i];
    }
}

static constant_strain constant_strain_of(double l)
{
    constant_strain c = {.l = l, .u = {2, -1, 3}};
    double n[3], force[3], moment[3];
    for (int i = 0; i < 3; i++) {
        n[i] = l * c.u[i];
        c.v[i] = (i == 2) + n[i] / strain_stiffness[i];
        c.m[i] = l * c.v[i] + 0.4 * c.u[i];
        c.rest[i] = c.u[i] - c.m[i] / curvature_stiffness[i];
    }
    turn(c.u, 1, n, force);
    turn(c.u, 1, c.m, moment);
    snprintf(c.text, sizeof c.text,
             "motion: spatial\n"
             "rod:\n"
             "  length: 1\n"
             "  stiffness: {shear: [800, 900], axial: 2000, bending: [1, 1.7], torsion: 0.6}\n"
             "  rest: {curvature: [%.17g, %.17g, %.17g]}\n"
             "boundary: {start: {type: clamped}}\n"
             "loads: {tip: {force: [%.17g, %.17g, %.17g], moment: [%.17g, %.17g, %.17g]}}\n",
             c.rest[0], c.rest[1], c.rest[2], force[0], force[1], force[2], moment[0], moment[1],
             moment[2]);
    return c;
}

static void test_constant_strain(void **state)
{
    (void)state;
    constant_strain c = constant_strain_of(2);
    solved x = solve("constant_strain.yaml", c.text, NULL, 0);
    for (int i = 0; i <= 10; i++) {
        solve_state here = at(&x, i / 10.0);
        double position[3];
        place(&c, i / 10.0, position);
        assert_vector(here.position, position[0], position[1], position[2], asked);
        assert_vector(here.curvature, c.u[0], c.u[1], c.u[2], asked);
        assert_vector(here.strain, c.v[0], c.v[1], c.v[2], asked);
    }
    release(&x);
}

/* With l = 15 this is not the equilibrium that the unstressed rod, wound four times, leads to; but
 * it is one, tip (0.38696911079710516, -0.5091519824298703, 0.625358820880862). */
static void test_wound(void **state)
{
    (void)state;
    constant_strain c = constant_strain_of(15);
    solved x = solve_with("wound.yaml", c.text, NULL, (solve_settings){.nodes = 12});
    const double edges[3] = {0, 0.5, 1}, size = sqrt(14);
    static_system *system;
    static_newton *newton;
    long steps = 0;
    assert_int_equal(static_system_create(x.rod, 12, 2, edges, &system, NULL), AD_OK);
    assert_int_equal(static_newton_create(system, &newton, NULL), AD_OK);
    size_t rows = (size_t)system->mesh.rows;
    size_t count = elements_unknowns(&system->mesh) / rows;
    double *y = malloc(count * rows * sizeof *y), *s = malloc(count * sizeof *s);
    solve_elements_places(&system->mesh, s);
    for (size_t i = 0; i < count; i++) { /* the exact state, a little off */
        double *to = y + i * rows, n[3], half = size * s[i] / 2;
        place(&c, s[i], to + STATIC_R);
        to[STATIC_Q] = cos(half);
        for (int k = 0; k < 3; k++) {
            to[STATIC_Q + 1 + k] = sin(half) * c.u[k] / size;
            n[k] = c.l * c.u[k];
            to[STATIC_M + k] = c.m[k] + 1e-3;
        }
        turn(c.u, s[i], n, to + STATIC_N);
    }
    assert_true(static_newton_solve(newton, y, &steps));
    assert_vector(y + (count - 1) * rows, 0.38696911079710516, -0.5091519824298703,
                  0.625358820880862, asked);
    free(y);
    free(s);
    static_newton_free(newton);
    static_system_free(system);
    release(&x);
}

/* ---- published values ---------------------------------------------------------------------- */

static const char unit_rod[] =
    "rod: {model: kirchhoff, length: 1, stiffness: {bending: [1, 1], torsion: 0.769230769230769}}\n"
    "boundary: {start: {type: clamped, rotation: [0, 1, 0, 1]}}\n";

static char *join(const char *a, const char *b)
{
    char *text = malloc(strlen(a) + strlen(b) + 1);
    strcpy(text, a);
    return strcat(text, b);
}

/* Dead and follower line load f L^3/EI = 1, 5, 25 (tip x, and down), by shooting to 1e-10;
 * Tschisgale's data (2019) agree to 5e-3. */
static void test_line_load(void **state)
{
    (void)state;
    static const struct {
        double load, dead[2], follower[2];
    } cases[] = {
        {1, {0.9912463953466356, 0.12347140198335155}, {0.9911035286358134, 0.12444373197459282}},
        {5, {0.8466571799542585, 0.4959050446223918}, {0.7955225902969623, 0.5604232444079552}},
        {25, {0.3861597508661928, 0.8559002109794243}, {-0.40317279406701745, 0.47812559724001696}},
    };
    for (size_t i = 0; i < sizeof cases / sizeof *cases; i++) {
        char loads[128];
        snprintf(loads, sizeof loads, "loads: {force: [0, 0, %g]}\n", -cases[i].load);
        char *text = join(unit_rod, loads);
        solved x = solve("dead.yaml", text, NULL, 0);
        assert_vector(at(&x, 1).position, cases[i].dead[0], 0, -cases[i].dead[1], 2 * asked);
        release(&x);
        free(text);
        /* d1 points up at the clamp */
        snprintf(loads, sizeof loads, "loads: {frame: follower, force: [%g, 0, 0]}\n",
                 -cases[i].load);
        text = join(unit_rod, loads);
        x = solve("follower.yaml", text, NULL, 0);
        assert_vector(at(&x, 1).position, cases[i].follower[0], 0, -cases[i].follower[1],
                      2 * asked);
        release(&x);
        free(text);
    }
}

/* A dead tip force EI/L^2 with shear and stretch, circle, nu = 0.3, by the length over the radius;
 * to 1e-11. */
static void test_shear(void **state)
{
    (void)state;
    static const double cases[][3] = {{5, 0.9388463703844738, 0.3272763990337084},
                                      {20, 0.9432705160167113, 0.30331622724805596},
                                      {1000, 0.9435666451848842, 0.30172141193366697}};
    for (size_t i = 0; i < sizeof cases / sizeof *cases; i++) {
        char text[512];
        double axial = 4 * cases[i][0] * cases[i][0], shear = 0.8863636363636364 / 2.6 * axial;
        snprintf(text, sizeof text,
                 "rod: {length: 1, stiffness: {bending: [1, 1], torsion: 0.769, axial: %.17g, "
                 "shear: [%.17g, %.17g]}}\n"
                 "boundary: {start: {type: clamped, rotation: [0, 1, 0, 1]}}\n"
                 "loads: {tip: {force: [0, 0, -1]}}\n",
                 axial, shear, shear);
        solved x = solve("shear.yaml", text, NULL, 0);
        assert_vector(at(&x, 1).position, cases[i][1], 0, -cases[i][2], asked);
        release(&x);
    }
}

/* An arc of 45 degrees and radius 100, a force across its plane (Bathe, Bolourchi 1979), with shear
 * area 1 and J = 1/6; to 1e-10 of the radius. Exudyn agrees to 0.01. */
static void test_bend(void **state)
{
    (void)state;
    static const char text[] =
        "rod:\n"
        "  length: 78.53981633974483\n"
        "  stiffness: {shear: [5.0e6, 5.0e6], axial: 1.0e7, torsion: 833333.33333333333,\n"
        "    bending: [833333.33333333333, 833333.33333333333]}\n"
        "  rest: {curvature: [0, 0.01, 0]}\n"
        "boundary: {start: {type: clamped, rotation: [0.5, 0.5, 0.5, 0.5]}}\n"
        "loads: {tip: {force: [0, 0, 300]}}\n";
    const double length = 78.53981633974483;
    solved x = solve("bend.yaml", text, NULL, 0);
    assert_vector(at(&x, 1).position, 58.77912248968315 / length, 22.244780945366887 / length,
                  40.19189167014654 / length, asked);
    release(&x);
    x = solve("bend.yaml", text, "loads.tip.force[2]=600", 0);
    assert_vector(at(&x, 1).position, 47.150438573629316 / length, 15.68480053403841 / length,
                  53.4748587918227 / length, asked);
    release(&x);
}

/* ---- several equilibria -------------------------------------------------------------------- */

/* A column under 1.01 and 2 times Euler's load; buckled: elliptic integrals, to 1e-13. */
static void test_column(void **state)
{
    (void)state;
    static const char column[] =
        "rod: {model: kirchhoff, length: 1, stiffness: {bending: [1, 1], torsion: 0.8}}\n"
        "boundary: {start: {type: clamped}}\n"
        "loads: {tip: {force: [0, 0, -1.01*pi^2/4]}}\n";
    solved x = solve("column.yaml", column, NULL, 0);
    assert_vector(at(&x, 1).position, 0, 0, 1, 1e-15);
    assert_true(x.report.may_buckle);
    release(&x);
    x = solve("column.yaml", column, NULL, 10);
    double sideways = fabs(at(&x, 1).position[0]);
    assert_near(sideways, 0.177948360856423, 1e-12);
    assert_near(at(&x, 1).position[2], 0.980222588015058, 1e-12);
    release(&x);
    x = solve("column.yaml", column, "loads.tip.force[2]=-pi^2/2", 10);
    sideways = fabs(at(&x, 1).position[0]);
    assert_near(sideways, 0.796961415519955, 1e-12);
    assert_near(at(&x, 1).position[2], 0.0708618164017102, 1e-12);
    release(&x);
}

/* Complete elliptic integrals K and E of modulus k by the arithmetic-geometric mean (DLMF 19.8). */
static void elliptic(double k, double *first, double *second)
{
    double a = 1, b = sqrt(1 - k * k), c = k, sum = c * c / 2;
    for (double power = 1; fabs(c) > 1e-16; power *= 2) {
        double mean = (a + b) / 2;
        c = (a - b) / 2;
        b = sqrt(a * b);
        a = mean;
        sum += power * c * c;
    }
    *first = PI / (2 * a);
    *second = *first * (1 - sum);
}

/* Two clamped ends moved together: the elastica of modulus k has their distance 2E/K - 1 and the
 * force 16 K^2 (Love, Mathematical Theory of Elasticity, 263). Locked stretch and shear. */
static void test_two_clamps(void **state)
{
    (void)state;
    static const char text[] =
        "rod: {model: kirchhoff, length: 1, stiffness: {bending: [1, 1], torsion: 0.8}}\n"
        "boundary:\n"
        "  start: {type: clamped}\n"
        "  end: {type: clamped, position: [0, 0, 0.6], rotation: [1, 0, 0, 0]}\n";
    double low = 0, high = 0.99, first, second;
    while (high - low > 1e-15) {
        double k = (low + high) / 2;
        elliptic(k, &first, &second);
        if (2 * second / first - 1 > 0.6) {
            low = k;
        } else {
            high = k;
        }
    }
    solved x = solve("clamps.yaml", text, NULL, 10);
    assert_near(at(&x, 0).force[2], -16 * first * first, 1e-9);
    assert_vector(at(&x, 1).position, 0, 0, 0.6, 1e-14);
    release(&x);
    x = solve_with("clamps.yaml", text, NULL,
                   (solve_settings){.tolerance = 1e-10}); /* straight it cannot shorten */
    assert_true(x.report.load_fraction < 1 && x.report.load_fraction > 0.9);
    release(&x);
}

/* A round rod between two pins, sagging; its spin about itself is nobody's. Held at the other end
 * and loaded at s = 0, a rod is the mirror image of a cantilever. */
static void test_other_ends(void **state)
{
    (void)state;
    static const char pins[] = "rod: {length: 1, stiffness: {bending: [1, 1], torsion: 0.8, axial: "
                               "400, shear: [99, 99]}}\n"
                               "boundary:\n"
                               "  start: {type: pinned, position: [0, 0, 0]}\n"
                               "  end: {type: pinned, position: [0, 0, 1]}\n"
                               "loads: {force: [3, 10, 0]}\n";
    solved x = solve("pins.yaml", pins, NULL, 0);
    solve_state left = at(&x, 0.3), right = at(&x, 0.7), middle = at(&x, 0.5);
    assert_near(left.position[1], right.position[1], 1e-12);
    assert_near(left.position[0], 0.3 * left.position[1], 1e-12);
    assert_true(middle.position[1] > 0.05);
    assert_vector(at(&x, 0).moment, 0, 0, 0, 1e-12);
    release(&x);
    static const char base[] =
        "rod: {model: kirchhoff, length: 1, stiffness: {bending: [1, 1], torsion: 0.8}}\n"
        "boundary: {start: {type: loaded}, end: {type: clamped, position: [0, 0, 0], "
        "rotation: [0, 1, 0, 1]}}\n"
        "loads: {base: {force: [0, 0, -1]}}\n";
    x = solve("base.yaml", base, NULL, 0);
    assert_vector(at(&x, 0).position, -0.9435667637166231, 0, -0.3017207737998135, asked);
    release(&x);
}

/* ---- the discretisation -------------------------------------------------------------------- */

static double tip_error(int nodes)
{
    solve_settings settings = {.nodes = nodes};
    solved x = solve_with("configs/elastica.yaml", NULL, "loads.tip.force[2]=-5", settings);
    assert_int_equal(x.report.nodes, nodes);
    assert_true(isnan(x.report.estimate));
    solve_state tip = at(&x, 1);
    double error =
        hypot(tip.position[0] - 0.6123716392755701, tip.position[2] + 0.7137915236119127);
    release(&x);
    return error;
}

/* One element of p Gauss points has order 2p at its end: more nodes gain faster and faster. Two
 * elements of 12 points: rounding. */
static void test_convergence(void **state)
{
    (void)state;
    double four = tip_error(4), six = tip_error(6), eight = tip_error(8), ten = tip_error(10);
    assert_true(four < 2e-2);
    assert_true(six < four / 20 && eight < six / 20 && ten < eight / 20);
    assert_near(tip_error(24), 0, 1e-14);
}

/* The solution of a scene with everything static, as a Chebyshev polynomial, in the residuals that
 * networks are trained on. */
enum { DEGREE = 48, STATE_ROWS = 13 };

static ad_value polynomial(ad_value s, const solved *x)
{
    static double matrix[STATE_ROWS * (DEGREE + 1)];
    double samples[DEGREE + 1][STATE_ROWS];
    ad_value powers[DEGREE + 1] = {ad_scalar(s.tape, 1),
                                   ad_sub(ad_scale(s, 2), ad_scalar(s.tape, 1))};
    for (int j = 0; j <= DEGREE; j++) {
        solve_state here = at(x, (1 + cos(PI * j / DEGREE)) / 2);
        memcpy(samples[j], here.position, sizeof here.position);
        memcpy(samples[j] + 3, here.rotation, sizeof here.rotation);
        memcpy(samples[j] + 7, here.force, sizeof here.force);
        memcpy(samples[j] + 10, here.moment, sizeof here.moment);
    }
    for (int row = 0; row < STATE_ROWS; row++) {
        for (int k = 0; k <= DEGREE; k++) {
            double sum = 0;
            for (int j = 0; j <= DEGREE; j++) {
                sum += samples[j][row] * cos(PI * j * k / DEGREE) / (j % DEGREE ? 1 : 2);
            }
            matrix[row * (DEGREE + 1) + k] = 2 * sum / (DEGREE * (k % DEGREE ? 1 : 2));
        }
    }
    for (int k = 2; k <= DEGREE; k++) {
        powers[k] = ad_sub(ad_scale(ad_mul(powers[1], powers[k - 1]), 2), powers[k - 2]);
    }
    return ad_matvec(ad_constant(s.tape, STATE_ROWS * (DEGREE + 1), matrix),
                     ad_stack(DEGREE + 1, powers));
}

#define LOADED                                                                                     \
    "  rest: {strain: [0.1*s, 0, 1.1], curvature: [0.3*cos(s), -0.2, 0.4*s]}\n"                    \
    "boundary: {start: {type: clamped, rotation: [1, 0.5, 0, 0.2]}}\n"                             \
    "loads:\n"                                                                                     \
    "  gravity: [0.1, -0.2, -0.4]\n"                                                               \
    "  frame: follower\n"                                                                          \
    "  force: [0.1, 0.2*s, sin(s)]\n"                                                              \
    "  moment: [0.1*cos(s), 0.2, -0.1*s]\n"                                                        \
    "  tip: {force: [0.3, 0.2, -0.5], moment: [0.2, 0.5, -0.3], frame: follower}\n"

static void check_residuals(const char *text)
{
    solved x = solve("everything.yaml", text, NULL, 0);
    const scene *given = &x.settings->scene;
    recorded r = begin(given);
    ad_value y = polynomial(r.s, &x), q = ad_slice(y, 3, 4);
    rod_state exact = {.position = ad_slice(y, 0, 3),
                       .rotation = q,
                       .force = ad_rotate(q, ad_slice(y, 7, 3)),
                       .moment = ad_slice(y, 10, 3)};
    check_interior(given, &r, exact, 1e-9); /* derivatives cost digits: degree^2 times rounding */
    ad_tape_free(r.tape);
    release(&x);
}

static void test_residuals(void **state)
{
    (void)state;
    check_residuals("motion: spatial\n"
                    "rod:\n"
                    "  length: 2\n"
                    "  stiffness: {shear: [40, 50], axial: 90, bending: [1.2, 0.8], torsion: 0.5}\n"
                    "  inertia: {mass_per_length: 1.3}\n" LOADED);
    check_residuals("motion: spatial\n"
                    "rod:\n"
                    "  length: 2\n"
                    "  stiffness:\n"
                    "    shear: [40*(1 + s), 50]\n"
                    "    axial: 90*exp(-s)\n"
                    "    bending: [1.2 - 0.3*s, 0.8 + 0.2*s^2]\n"
                    "    torsion: 0.5*(1 + 0.2*sin(2*s))\n"
                    "  inertia: {mass_per_length: 1.3*(1 - s/3)}\n" LOADED);
}

/* Loads from the tape that make a chosen pose the solution, which the solver does not know. */
static void test_manufactured(void **state)
{
    (void)state;
    static const char text[] =
        "rod:\n"
        "  length: 1\n"
        "  stiffness: {shear: [40, 50], axial: 90, bending: [1.2, 0.8], torsion: 0.5}\n"
        "  inertia: {mass_per_length: 1.3}\n"
        "  rest: {curvature: [0.3*cos(s), -0.2, 0.4*s]}\n"
        "loads: {gravity: [0.5, -1, -2]}\n"
        "manufactured:\n"
        "  position: [0.3*s^2 + 0.1*s^3, -0.2*s^2*sin(3*s), s + 0.05*s^2]\n"
        "  angles: [0.7*sin(pi*s/2), 0.5*s, 0.9*s*(1 + s)]\n";
    solved x = solve("manufactured.yaml", text, NULL, 0);
    for (int i = 0; i <= 8; i++) {
        double s = i / 8.0;
        assert_vector(at(&x, s).position, 0.3 * s * s + 0.1 * s * s * s, -0.2 * s * s * sin(3 * s),
                      s + 0.05 * s * s, asked);
    }
    release(&x);
}

/* A load that begins suddenly: the mesh is refined where it does. */
static void test_jump(void **state)
{
    (void)state;
    char *text = join(unit_rod, "loads: {force: [0, 0, '-4*step(s - 0.37)']}\n");
    solved x = solve("jump.yaml", text, NULL, 0);
    assert_true(x.report.nodes < 1000);
    /* n3 = 0 at the clamp, the force is that of the loaded part */
    assert_near(at(&x, 0).force[0], -4 * 0.63, 1e-9);
    release(&x);
    free(text);
}

static void test_no_memory(void **state)
{
    (void)state;
    config *settings = NULL;
    const solve_settings rough = {.tolerance = 1e-3};
    assert_int_equal(prepare_read("configs/elastica.yaml", NULL, 0, NULL, &settings, NULL), AD_OK);
    check_no_memory(&settings->scene, &rough, 0, NULL, 20, 7);
    config_free(settings);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_closed_forms), cmocka_unit_test(test_constant_strain),
        cmocka_unit_test(test_wound),        cmocka_unit_test(test_line_load),
        cmocka_unit_test(test_shear),        cmocka_unit_test(test_bend),
        cmocka_unit_test(test_column),       cmocka_unit_test(test_two_clamps),
        cmocka_unit_test(test_other_ends),   cmocka_unit_test(test_convergence),
        cmocka_unit_test(test_residuals),    cmocka_unit_test(test_manufactured),
        cmocka_unit_test(test_jump),         cmocka_unit_test(test_no_memory),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
