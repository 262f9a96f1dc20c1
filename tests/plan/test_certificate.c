/* What is promised of shapes and ways against many shapes in between. */
#include "physics/numerics/quaternion.h"
#include "plan_testing.h"

/* ---- one shape ------------------------------------------------------------------------------- */

/* An arc of a circle in a bent tube. On an arc of curvature k and chord c the bound between points
 * is k c^2/(4 sqrt 3) and terms of fourth order, which (k c)^2 below 0.01 makes less than a part in
 * a hundred. */
static void an_arc(void **state)
{
    (void)state;
    enum { POINTS = 41, FINE = 200 };
    mesh m = mesh_tube(0.02, 0.01, 0.22, 1, 60, 48); /* another arc, but within */
    environment *of = open_mesh(&m, ENVIRONMENT_INSIDE);
    double s[POINTS], r[3 * POINTS], speed[POINTS], free[POINTS - 1];
    const double k = 5, radius = 0.003, error = 1e-9;
    for (size_t i = 0; i < POINTS; i++) {
        s[i] = 0.2 * (double)i / (POINTS - 1);
        speed[i] = 1;
        r[3 * i] = (1 - cos(k * s[i])) / k;
        r[3 * i + 1] = 0;
        r[3 * i + 2] = sin(k * s[i]) / k;
    }
    const clearance_shape shape = {.points = POINTS,
                                   .s = s,
                                   .r = r,
                                   .speed = speed,
                                   .error = error,
                                   .radius = radius,
                                   .from = 0.05};
    clearance least;
    clearance_of_shape(of, &shape, free, &least);
    double all = INFINITY;
    for (size_t i = 0; i + 1 < POINTS; i++) {
        double nearest = INFINITY;
        for (int j = 0; j <= FINE; j++) {
            const double at_s = s[i] + (s[i + 1] - s[i]) * j / FINE;
            const double p[3] = {(1 - cos(k * at_s)) / k, 0, sin(k * at_s) / k};
            nearest = fmin(nearest, environment_distance(of, p, INFINITY) - radius);
        }
        if (s[i + 1] <= 0.05) {
            assert_true(isinf(free[i]));
            continue;
        }
        const double h = 0.2 / (POINTS - 1), bound = k * h * h / (4 * sqrt(3));
        assert_true(free[i] <= nearest);
        /* what is lost is the bound, the error, and the arc's own way to its line */
        assert_true(nearest - free[i] <= bound + k * h * h / 8 + 2e-6);
        all = fmin(all, free[i]);
    }
    const double h = 0.2 / (POINTS - 1), bound = k * h * h / (4 * sqrt(3));
    assert_true(least.free == all);
    assert_near(least.between_points, bound, 0.01 * bound);
    assert_near(least.free,
                least.distance - least.radius - least.distance_error - least.shape_error -
                    least.between_points,
                1e-15);
    /* what is no number, and a rod that is shorter than the lines, are never free */
    r[3 * 30 + 1] = NAN;
    clearance_of_shape(of, &shape, free, &least);
    assert_false(free[29] >= 0);
    assert_false(free[30] >= 0);
    assert_false(least.free >= 0);
    r[3 * 30 + 1] = 0;
    for (size_t i = 0; i < POINTS; i++) {
        speed[i] = 0.9;
    }
    clearance_of_shape(of, &shape, free, &least);
    assert_false(least.free >= 0);
    environment_free(of);
}

/* ---- a robot -------------------------------------------------------------------------------- */

/* How points move with each variable, against differences of shapes: their own error is that of
 * a third derivative times the step's square, and the solver's 1e-9 of 0.2 m over twice the step,
 * 1e-3 of a variable of size 1 to 6. */
static void motions_of_points(void **state)
{
    (void)state;
    robot r = make_robot(true);
    open_robot(&r, 11);
    assert_int_equal(r.moves.count, 5);
    const double q[5] = {3, 0.5, 1.5, 0.02, 0.4};
    double both[10], moves[11 * 3 * 5];
    assert_int_equal(plan_exact_shapes(r.exact, 1, q, NULL), AD_OK);
    assert_true(r.exact->error[0] < 1e-8);
    memcpy(moves, r.exact->moves, sizeof moves);
    for (int k = 0; k < 5; k++) {
        const double h = 1e-3;
        memcpy(both, q, sizeof q);
        memcpy(both + 5, q, sizeof q);
        both[k] += h;
        both[5 + k] -= h;
        assert_int_equal(plan_exact_shapes(r.exact, 2, both, NULL), AD_OK);
        for (int row = 0; row < 33; row++) {
            assert_near((r.exact->r[row] - r.exact->r[33 + row]) / (2 * h), moves[row * 5 + k],
                        2e-7);
        }
    }
    free_robot(&r);
}

static void a_way_that_holds(void **state)
{
    (void)state;
    mesh m = mesh_tube(0.06, 0.01, 0.3, 0.3, 40, 32);
    environment *of = open_mesh(&m, ENVIRONMENT_INSIDE);
    robot r = make_robot(false), fine = make_robot(false);
    open_robot(&r, 61);
    open_robot(&fine, 181);
    const certificate_settings settings = {
        .radius = 0.004, .from = 0, .promised = 0.0005, .shapes_max = 2000};
    const double way[3 * 3] = {0, 0, 0, 1.2, 0.2, 0, 0.3, 1.1, 0.1};
    certificate *c = NULL;
    ad_error error = {.message = ""};
    assert_int_equal(
        certificate_create(r.exact, of, ENVIRONMENT_INSIDE, &settings, 3, way, &c, &error), AD_OK);
    assert_int_equal(c->end, CERTIFICATE_HOLDS);
    assert_true(c->count >= 3 && c->all.free >= settings.promised);
    try_way(&fine, of, c, settings.radius, 4, 1024, 0, false);
    certificate_free(c);
    /* the same shapes are outside of what has them inside */
    assert_int_equal(
        certificate_create(r.exact, of, ENVIRONMENT_OUTSIDE, &settings, 3, way, &c, &error), AD_OK);
    assert_int_equal(c->end, CERTIFICATE_OTHER_SIDE);
    certificate_free(c);
    /* a pull that bends it through the wall */
    const double through[2 * 3] = {0, 0, 0, 6, 0, 0};
    assert_int_equal(
        certificate_create(r.exact, of, ENVIRONMENT_INSIDE, &settings, 2, through, &c, &error),
        AD_OK);
    assert_int_equal(c->end, CERTIFICATE_TOO_NEAR);
    assert_int_equal(c->which, c->count - 1); /* of those that are given the last */
    certificate_free(c);
    environment_free(of);
    free_robot(&r);
    free_robot(&fine);
}

/* For all stiffnesses of a range: shapes of any of them keep what is promised, and of the middle
 * one alone more would be. */
static void an_unknown_stiffness(void **state)
{
    (void)state;
    mesh m = mesh_tube(0.06, 0.01, 0.3, 0.3, 40, 32);
    environment *of = open_mesh(&m, ENVIRONMENT_INSIDE);
    robot r = make_robot_of(false, NULL), fine = make_robot(false),
          middle = make_robot_of(false, "stiffness=1.05");
    open_robot(&r, 61);
    open_robot(&fine, 181);
    open_robot(&middle, 61);
    const certificate_settings settings = {
        .radius = 0.004, .from = 0.05, .promised = 0.0005, .shapes_max = 2000};
    const double way[3 * 3] = {0, 0, 0, 1.0, 0.2, 0, 0.3, 0.9, 0.1};
    certificate *c = NULL, *alone = NULL;
    ad_error error = {.message = ""};
    assert_int_equal(r.moves.count, 3);
    assert_int_equal(
        certificate_create(r.exact, of, ENVIRONMENT_INSIDE, &settings, 3, way, &c, &error), AD_OK);
    assert_int_equal(c->end, CERTIFICATE_HOLDS);
    assert_int_equal(
        certificate_create(middle.exact, of, ENVIRONMENT_INSIDE, &settings, 3, way, &alone, &error),
        AD_OK);
    assert_int_equal(alone->end, CERTIFICATE_HOLDS);
    assert_true(c->all.unknown > 1e-3 && c->all.free < alone->all.free - 1e-3);
    for (int k = 0; k < 8; k++) {
        try_way(&fine, of, c, settings.radius, (uint64_t)k, PLAN_BATCH, settings.from, true);
    }
    /* Where it bends most the softest robot comes nearest. What is taken off there is not much more
     * than that: the bound adds what curvature, which is as 1/stiffness, differs from the
     * derivative, a seventh of a change of a seventh, and goes in all directions. */
    size_t bent = 0;
    while (c->configuration[3 * bent] != 1.0) {
        bent++;
    }
    double softest = INFINITY;
    fine.moves.fixed[3] = 0.9;
    assert_int_equal(plan_exact_shapes(fine.exact, 1, &way[3], NULL), AD_OK);
    for (size_t k = 0; k < fine.exact->points; k++) {
        const double d = environment_distance(of, &fine.exact->r[3 * k], INFINITY);
        softest = fine.exact->s[k] < settings.from ? softest : fmin(softest, d - settings.radius);
    }
    assert_true(c->shape[bent].free <= softest);
    assert_true(softest - c->shape[bent].free < 0.5 * c->shape[bent].unknown);
    certificate_free(c);
    certificate_free(alone);
    environment_free(of);
    free_robot(&r);
    free_robot(&fine);
    free_robot(&middle);
}

/* A way inside of a pipe is certified, and holds for shapes of a robot that may be a finer one. */
static void try_certified(const robot *r, robot *fine, mesh m, double radius, size_t count,
                          const double *way, uint64_t seed)
{
    ad_error error = {.message = ""};
    environment *of = open_mesh(&m, ENVIRONMENT_INSIDE);
    const certificate_settings asked = {
        .radius = radius, .from = 0, .promised = 0.001, .shapes_max = 2000};
    certificate *c = NULL;
    assert_int_equal(
        certificate_create(r->exact, of, ENVIRONMENT_INSIDE, &asked, count, way, &c, &error),
        AD_OK);
    assert_int_equal(c->end, CERTIFICATE_HOLDS);
    try_way(fine, of, c, radius, seed, 256, 0, false);
    certificate_free(c);
    environment_free(of);
}

/* Of a robot that comes out of a port s counts otherwise than metres; lines between points are no
 * longer than speeds allow, and hardly shorter. Bends of 10 1/m take (0.003*10)^2/24 off. */
static void an_inserted_robot(void **state)
{
    (void)state;
    robot r = {.owner = NULL};
    ad_error error = {.message = ""};
    char key[PLAN_KEY];
    const plan_settings settings = plan_settings_default();
    assert_int_equal(
        config_read("configs/families/insertion.yaml", NULL, 0, NULL, &r.owner, &error), AD_OK);
    assert_int_equal(plan_robot_create(&settings, &r.owner->scene, &r.moves, key, &error), AD_OK);
    open_robot(&r, 61);
    const double q[3 * 5] = {1, 0.5, 0, 0.06, 1, 1, 0.5, 0, 0.19, 1, 0.2, 0.1, 0.3, 0.1, -2};
    assert_int_equal(plan_exact_shapes(r.exact, 3, q, NULL), AD_OK);
    for (size_t m = 0; m < 3; m++) {
        for (size_t k = 0; k < 60; k++) {
            const size_t row = m * 61 + k;
            const double *const p = &r.exact->r[3 * row];
            const double length = (r.exact->s[k + 1] - r.exact->s[k]) * r.exact->speed[row];
            const double line = sqrt((p[3] - p[0]) * (p[3] - p[0]) + (p[4] - p[1]) * (p[4] - p[1]) +
                                     (p[5] - p[2]) * (p[5] - p[2]));
            assert_true(line <= length * (1 + 1e-6) && line >= length * (1 - 1e-4));
        }
    }
    const double way[2 * 5] = {0, 0, 0, 0.06, 1, 1, 0.5, 0, 0.19, 1};
    try_certified(&r, &r, mesh_tube(0.09, 0.05, 0.35, 0.1, 30, 32), 0.002, 2, way, 3);
    free_robot(&r);
}

/* A robot of text, as long as it is built. */
static robot robot_of(const char *text, const char *turned)
{
    robot r = {.owner = NULL};
    ad_error error = {.message = ""};
    char key[PLAN_KEY] = "";
    plan_settings settings = plan_settings_default();
    if (turned) {
        settings.slide[0] = -0.05, settings.slide[1] = 0.05;
        settings.turn[0] = -1, settings.turn[1] = 1;
    }
    assert_int_equal(config_read(turned ? turned : "robot.yaml", text, 0, NULL, &r.owner, &error),
                     AD_OK);
    assert_int_equal(plan_robot_create(&settings, &r.owner->scene, &r.moves, key, &error), AD_OK);
    return r;
}

/* Two concentric tubes that turn and come out, of a base that is pushed and turned. */
static void a_robot_of_tubes(void **state)
{
    (void)state;
    static const char text[] =
        "parameters: {a: {range: [-1.5, 1.5]}, out: {range: [0.03, 0.08]}, more: {range: [0.03, "
        "0.1]}}\n"
        "rod: {model: kirchhoff, length: out+more, rest: {curvature: [10, 0, 0]},\n"
        "  section: {shape: tube, radius: 0.0006, inner_radius: 0.00045},\n"
        "  material: {youngs_modulus: 60e9, poissons_ratio: 0.3, density: 6450}}\n"
        "tubes: [{section: {radius: 0.0009, inner_radius: 0.0007}, end: out, turned: a,\n"
        "  material: {youngs_modulus: 60e9, poissons_ratio: 0.3, density: 6450},\n"
        "  rest: {curvature: [6, 0, 0]}, transmission: 0.2-out}]\n";
    const double way[3 * 5] = {0,    0.03, 0.03, 0,    0,   1.2, 0.05, 0.06,
                               0.02, 0.5,  0.3,  0.08, 0.1, 0,   1};
    robot r = robot_of(text, "tubes.yaml"), fine = robot_of(text, "tubes.yaml");
    open_robot(&r, 61);
    open_robot(&fine, 181);
    assert_int_equal(r.moves.count, 5);
    try_certified(&r, &fine, mesh_tube(0.15, 0.05, 0.35, 0.3, 30, 32), 0.0015, 3, way, 5);
    free_robot(&r);
    free_robot(&fine);
}

/* A shape that jumps on the way is not certified, however much room there is, though derivatives
 * are 0 to both sides. */
static void a_jump(void **state)
{
    (void)state;
    static const char text[] =
        "parameters: {a: {range: [0, 1]}}\n"
        "rod: {length: 0.2, section: {shape: circle, radius: 0.5e-3},\n"
        "  material: {youngs_modulus: 60e9, poissons_ratio: 0.3, density: 6450},\n"
        "  rest: {curvature: [\"where(a-0.41, 2, 0)\", 0, 0]}}\n"
        "loads: {tip: {force: [0, 0.01, 0]}}\n";
    const double way[2] = {0, 1};
    robot r = robot_of(text, NULL);
    open_robot(&r, 61);
    mesh m = mesh_tube(0.3, 0.1, 0.4, 0.3, 40, 32);
    environment *of = open_mesh(&m, ENVIRONMENT_INSIDE);
    const certificate_settings asked = {
        .radius = 0.001, .from = 0, .promised = 0.001, .shapes_max = 2000};
    certificate *c = NULL;
    assert_int_equal(certificate_create(r.exact, of, ENVIRONMENT_INSIDE, &asked, 2, way, &c, NULL),
                     AD_OK);
    assert_int_equal(c->end, CERTIFICATE_JUMPS);
    certificate_free(c);
    environment_free(of);
    free_robot(&r);
}

/* A robot with tendons along helices that comes out of a port and turns. At all points what tendons
 * pull is in balance with the strains, here from the numbers of the scene: within 1e-6 of the
 * largest moment, as strains are interpolated. Then a way of it, as above. */
static void a_robot_of_helices(void **state)
{
    (void)state;
    enum { POINTS = 121, TENDONS = 3 };
    static const double angle[TENDONS][2] = {{0, 0}, {1.571, 50}, {-1.571, -50}};
    const double whole = 0.12, radius = 0.003, offset = 0.0025, E = 2.1e6, G = E / 2.6;
    const double area = acos(-1) * radius * radius, inertia = area * radius * radius / 4;
    const double shear[3] = {G * area, G * area, E * area};
    const double bend[3] = {E * inertia, E * inertia, 2 * G * inertia};
    const double q[3 * 5] = {0.1, 0.1, 0.1, 0.06, 3.1, 2, 1, 0.5, 0.11, 0, 3, 0, 0, 0.02, 1.5};
    robot r = {.owner = NULL}, fine = {.owner = NULL};
    ad_error error = {.message = ""};
    for (int k = 0; k < 2; k++) {
        robot *const to = k ? &fine : &r;
        char key[PLAN_KEY];
        assert_int_equal(
            config_read("configs/plan/bentley.yaml", NULL, 0, NULL, &to->owner, &error), AD_OK);
        assert_int_equal(
            plan_robot_create(&to->owner->plan, &to->owner->scene, &to->moves, key, &error), AD_OK);
        open_robot(to, k ? 3 * POINTS - 2 : POINTS);
    }
    assert_int_equal(plan_exact_shapes(r.exact, 3, q, NULL), AD_OK);
    for (size_t row = 0; row < (size_t)3 * POINTS; row++) {
        const double *const at = &q[row / POINTS * 5];
        const double *const values = &r.exact->values[row * SOLVE_MEMBERS_COLUMNS];
        const double *const v = &values[7], *const u = &values[10];
        const double s = whole + at[3] * (r.exact->s[row % POINTS] / r.exact->length - 1);
        double force[3] = {shear[0] * v[0], shear[1] * v[1], shear[2] * (v[2] - 1)};
        double moment[3] = {bend[0] * u[0], bend[1] * u[1], bend[2] * u[2]};
        for (int k = 0; k < TENDONS; k++) {
            const double a = angle[k][0] + angle[k][1] * s, by = offset * angle[k][1];
            const double place[3] = {offset * sin(a), offset * cos(a), 0};
            double t[3], arm[3];
            vector_cross(u, place, t);
            t[0] += v[0] + by * cos(a);
            t[1] += v[1] - by * sin(a);
            t[2] += v[2];
            const double pull = at[k] / sqrt(vector_dot(t, t));
            vector_cross(place, t, arm);
            for (int i = 0; i < 3; i++) {
                force[i] += pull * t[i];
                moment[i] += pull * arm[i];
            }
        }
        assert_true(sqrt(vector_dot(moment, moment)) < 1e-6 * 3 * offset);
        assert_true(sqrt(vector_dot(force, force)) < 1e-6 * 3);
    }
    try_certified(&r, &fine, mesh_tube(0.09, 0.05, 0.35, 0.1, 30, 32), 0.003, 3, q, 6);
    free_robot(&r);
    free_robot(&fine);
}

/* A wall between two shapes that are both free of it is seen, however thin. */
static void a_wall_between(void **state)
{
    (void)state;
    mesh m = mesh_make(8, 4);
    mesh_corner(&m, 0.03, -0.05, 0.15);
    mesh_corner(&m, 0.03, 0.05, 0.15);
    mesh_corner(&m, 0.03, 0.05, 0.3);
    mesh_corner(&m, 0.03, -0.05, 0.3);
    mesh_triangle(&m, 0, 1, 2);
    mesh_triangle(&m, 0, 2, 3);
    environment *of = open_mesh(&m, ENVIRONMENT_ANY);
    robot r = make_robot(false);
    open_robot(&r, 61);
    const certificate_settings settings = {
        .radius = 0.001, .from = 0, .promised = 0.0002, .shapes_max = 2000};
    const double way[2 * 3] = {0, 0, 0, 3, 0, 0};
    certificate *c = NULL;
    assert_int_equal(certificate_create(r.exact, of, ENVIRONMENT_ANY, &settings, 2, way, &c, NULL),
                     AD_OK);
    assert_int_equal(c->end, CERTIFICATE_TOO_NEAR);
    assert_true(c->which > 0 && c->which + 1 < c->count);
    assert_true(c->shape[0].free > 0.02 && c->shape[c->count - 1].free > 0.002);
    certificate_free(c);
    environment_free(of);
    free_robot(&r);
}

int main(void)
{
    const struct CMUnitTest tests[] = {cmocka_unit_test(an_arc),
                                       cmocka_unit_test(motions_of_points),
                                       cmocka_unit_test(a_way_that_holds),
                                       cmocka_unit_test(an_unknown_stiffness),
                                       cmocka_unit_test(an_inserted_robot),
                                       cmocka_unit_test(a_robot_of_helices),
                                       cmocka_unit_test(a_robot_of_tubes),
                                       cmocka_unit_test(a_jump),
                                       cmocka_unit_test(a_wall_between)};
    return environment_is_built() ? cmocka_run_group_tests(tests, make_directory, remove_directory)
                                  : 77;
}
