/* Tendons and chambers on rods at rest by the classical solver: published robots, closed forms, the
 * equations of Rucker and Webster, derivatives against differences, stability. */
#include "tendon_testing.h"

#include "autodiff/dense.h"
#include "physics/numerics/quaternion.h"
#include "physics/solve/stability.h"
#include "physics/solve/static_system.h"

#include <string.h>

/* ---- published robots ---------------------------------------------------------------------- */

/* Tips of the reference: two derivations of the equations agree to 4e-12 m. */
static void check_tip(const scene *given, const double *position, const double *rotation)
{
    solved x = solve(given, 0, NULL, 1e-12);
    double tip[7], turn[4], off = 0;
    pose_at(&x, scene_length(given), 0, tip);
    for (int i = 0; i < 3; i++) {
        off = fmax(off, fabs(tip[i] - position[i]));
    }
    quaternion_quotient(tip + 3, rotation, turn);
    double angle = 2 * sqrt(vector_dot(turn + 1, turn + 1));
    print_message("off by %.1e m, %.1e rad, estimate %.1e\n", off, angle, x.report.estimate);
    assert_true(off < 4e-12 && angle < 4e-12);
    solution_free(x.solution);
}

static void test_bensch(void **state)
{
    (void)state;
    const double angles[3] = {90, -30, 210};
    static const struct {
        double tension[3], force[3], position[3], rotation[4];
    } rows[] = {
        {{2.5, 0, 0},
         {0, 0, 0},
         {0.0, 0.11617269913245033, 0.14393669781780308},
         {0.7781627556570103, -0.6280626765763809, 0.0, 0.0}},
        {{2.0, 1.0, 0},
         {0.0, 0.1, 0.0},
         {0.03202773292494256, 0.11956271656625204, 0.1395837564217458},
         {0.7975086946194004, -0.5712392376216633, 0.19260100435752994, 0.02388448300430448}}};
    for (int i = 0; i < 2; i++) {
        scene given = robot(0.2, 60e9, 60e9 / 2.6, 0.5e-3);
        given.end.type = SCENE_LOADED;
        for (int k = 0; k < 3; k++) {
            add_tendon(&given, 8e-3, angles[k], rows[i].tension[k]);
            given.loads.tip.force[k] = Q(rows[i].force[k]);
        }
        check_tip(&given, rows[i].position, rows[i].rotation);
    }
}

static void test_weight(void **state)
{
    (void)state;
    scene given = robot(0.5, 200e9, 80e9, 1e-3);
    given.rod.density = Q(8000.0);
    given.loads.gravity[0] = Q(9.81);
    add_tendon(&given, 15.06e-3, 0, 15);
    check_tip(&given, (const double[]){0.18221169454040081, 0, 0.4532292709336714},
              (const double[]){0.930697007657374, 0, 0.36579103315637657, 0});
}

static void test_two_segments(void **state)
{
    (void)state;
    const double angles[3] = {90, -30, 210}, tension[6] = {2, 0, 0, 0, 2, 0};
    scene given = robot(0.4, 54e9, 54e9 / 2.6, 0.7e-3);
    for (int i = 0; i < 6; i++) {
        add_tendon(&given, 10e-3, angles[i % 3], tension[i]);
        given.tendons[i].end = Q(i < 3 ? 0.2 : 0.4);
    }
    check_tip(&given, (const double[]){0.13049249604880186, 0.0365621632966301, 0.3675128551628062},
              (const double[]){0.9428773804947055, 0, 0.33150351551438123, -0.03297975974819839});
}

/* ---- closed forms -------------------------------------------------------------------------- */

/* Without loads n = m = 0 in every section: a tendon at (x, 0) gives u2 = tau x/EI and, as it stays
 * parallel to the axis, v3 = 1 - tau/EA; a chamber pushes where the tendon pulls. */
static void test_constant(void **state)
{
    (void)state;
    const double x = 0.01, pull = 2, axial = 100, bending = 0.03;
    for (int chamber = 0; chamber < 2; chamber++) {
        const double kse[3] = {50, 50, axial}, kbt[3] = {bending, bending, 0.02};
        scene given = stiff_scene(0.3, kse, kbt, 1, kbt);
        given.tendon_count = !chamber;
        given.chamber_count = chamber;
        given.tendons[0] = (scene_tendon){.offset = {Q(x), Q(0.0)}, .tension = Q(pull)};
        given.chambers[0] =
            (scene_chamber){.offset = {Q(x), Q(0.0)}, .pressure = Q(pull / 1e-4), .area = Q(1e-4)};
        double sign = chamber ? -1 : 1, bend = sign * pull * x / bending;
        double stretch = 1 - sign * pull / axial, s = 0.3, values[13];
        solved found = solve(&given, 0, NULL, 1e-12);
        ad_error error;
        assert_int_equal(solution_evaluate(found.solution, 13, 1, &s, NULL, values, &error), AD_OK);
        assert_near(values[0], stretch * (1 - cos(bend * s)) / bend, 1e-13);
        assert_near(values[2], stretch * sin(bend * s) / bend, 1e-13);
        assert_near(values[9], stretch, 1e-12);
        assert_near(values[11], bend, 1e-11);
        solve_energy energy;
        double elastic = (pow(pull / axial, 2) * axial + bend * bend * bending) * s / 2;
        assert_int_equal(solution_energy(found.solution, 0, &energy, &error), AD_OK);
        assert_near(energy.strain, elastic, 1e-12 * elastic);
        assert_near(energy.work, 2 * elastic, 1e-12 * elastic); /* linear, at full size */
        solution_free(found.solution);
    }
}

/* ---- lengths ------------------------------------------------------------------------------- */

/* Two tendons at +-x: v3 = 1 - (T1 + T2)/EA and u2 = x (T1 - T2)/EI, and their lengths are those of
 * the rod less d: (v3 -+ u2 x) L = L - d. Where only the first is pulled the other is slack. */
static void test_lengths(void **state)
{
    (void)state;
    const double x = 0.01, length = 0.3, axial = 100, bending = 0.03;
    const double kse[3] = {50, 50, axial}, kbt[3] = {bending, bending, 0.02};
    const double cases[3][2] = {{0.01, -0.01}, {0.01, 0.007}, {-0.01, -0.002}};
    for (int i = 0; i < 3; i++) {
        const double *d = cases[i], own = 1 / axial + x * x / bending;
        double other = 1 / axial - x * x / bending, tension[2] = {0, 0};
        if (i == 0) {
            tension[0] = d[0] / length / own;
        } else if (i == 1) {
            double determinant = (own * own - other * other) * length;
            tension[0] = (own * d[0] - other * d[1]) / determinant;
            tension[1] = (own * d[1] - other * d[0]) / determinant;
        }
        scene given = stiff_scene(length, kse, kbt, 1, kbt);
        for (int k = 0; k < 2; k++) {
            add_tendon(&given, x, 180 * k, 0);
            given.tendons[k].tension = Q(NULL);
            given.tendons[k].displacement = Q(d[k]);
        }
        solved found = solve(&given, 0, NULL, 1e-12);
        double bend = x * (tension[0] - tension[1]) / bending, pose[7];
        double stretch = 1 - (tension[0] + tension[1]) / axial;
        pose_at(&found, length, 0, pose);
        assert_near(pose[2], bend == 0 ? length : stretch * sin(bend * length) / bend, 1e-12);
        for (int k = 0; k < 2; k++) {
            assert_near(solution_tension(found.solution, k), tension[k], 1e-10);
        }
        solution_free(found.solution);
    }
}

/* Three tendons pulled and let out by lengths, beside a load, against the same with the tensions
 * that were found. */
static void test_lengths_and_load(void **state)
{
    (void)state;
    const double angles[3] = {90, -30, 210}, lengths[3] = {0.012, -0.004, -0.0079};
    scene given = robot(0.2, 60e9, 60e9 / 2.6, 0.5e-3);
    given.end.type = SCENE_LOADED;
    set_numbers(given.loads.tip.force, 3, (const double[]){0.02, 0.03, -0.05});
    for (int k = 0; k < 3; k++) {
        add_tendon(&given, 8e-3, angles[k], 0);
        given.tendons[k].tension = Q(NULL);
        given.tendons[k].displacement = Q(lengths[k]);
    }
    scene same = given;
    double tip[2][7];
    solved x = solve(&given, 0, NULL, 1e-10);
    for (int k = 0; k < 3; k++) {
        same.tendons[k].tension = Q(solution_tension(x.solution, k));
        same.tendons[k].displacement = Q(NULL);
        print_message("tension %.6f N\n", solution_tension(x.solution, k));
    }
    solved y = solve(&same, 0, NULL, 1e-10);
    pose_at(&x, 0.2, 0, tip[0]);
    pose_at(&y, 0.2, 0, tip[1]);
    for (int k = 0; k < 3; k++) {
        assert_near(tip[0][k], tip[1][k], 2e-11);
        enum { POINTS = 400 };
        double excess = lengths[k]; /* the length along the solution, by the midpoint rule */
        for (int i = 0; i < POINTS; i++) {
            double s = 0.2 * (i + 0.5) / POINTS, values[13], p[3];
            double angle = angles[k] * PI / 180, r[3] = {8e-3 * cos(angle), 8e-3 * sin(angle), 0};
            ad_error error;
            assert_int_equal(solution_evaluate(x.solution, 13, 1, &s, NULL, values, &error), AD_OK);
            vector_cross(values + 10, r, p);
            for (int j = 0; j < 3; j++) {
                p[j] += values[7 + j];
            }
            excess += (sqrt(vector_dot(p, p)) - 1) * 0.2 / POINTS;
        }
        bool taut = solution_tension(x.solution, k) > 0;
        assert_true(taut ? fabs(excess) < 1e-8 : excess < 0); /* 1e-8: of the midpoint rule */
    }
    solution_free(x.solution);
    solution_free(y.solution);
}

/* ---- friction ------------------------------------------------------------------------------ */

/* A tendon at (0, y) in a rod without other loads stays parallel to it, so that the angle theta of
 * both is that of the rod: theta_s = T y/EI, T = T_0 exp(-mu theta), with the solution
 * theta = log(1 + mu T_0 y/EI s)/mu. */
static void test_friction(void **state)
{
    (void)state;
    const double friction[2] = {0.3, 1.5}, length = 0.2, pull = 2, lever = 0.008, radius = 0.0005;
    double area = PI * radius * radius, stretch = 60e9 * area;
    double rate = pull * lever / (stretch * radius * radius / 4);
    for (int i = 0; i < 2; i++) {
        enum { POINTS = 2000 };
        const double mu = friction[i];
        scene given = robot(length, 60e9, 60e9 / 2.6, radius);
        add_tendon(&given, lever, 90, pull);
        given.tendons[0].friction = Q(mu);
        solved x = solve(&given, 0, NULL, 1e-11);
        double tip[7], y = 0, z = 0;
        for (int k = 0; k < POINTS; k++) { /* Gauss, two points */
            for (int g = -1; g <= 1; g += 2) {
                double s = (k + 0.5 + g / sqrt(12)) * length / POINTS;
                double angle = log(1 + mu * rate * s) / mu;
                double v = (1 - pull * exp(-mu * angle) / stretch) * length / (2 * POINTS);
                y += v * sin(angle);
                z += v * cos(angle);
            }
        }
        pose_at(&x, length, 0, tip);
        print_message("off by %.1e, %.1e m, estimate %.1e\n", tip[1] - y, tip[2] - z,
                      x.report.estimate);
        assert_near(tip[1], y, 1e-12);
        assert_near(tip[2], z, 1e-12);
        solution_free(x.solution);
    }
}

/* Two tendons with friction, of which one winds and one ends, and a force at the tip; where that
 * one ends the other has a kink. By Rucker and Webster's equations with T' = -mu |t'| T, which have
 * second derivatives of the routing, shot with Dormand and Prince's method in Python, to 1e-12. */
static void test_friction_wound(void **state)
{
    (void)state;
    const double kse[3] = {80, 80, 100}, kbt[3] = {0.03, 0.04, 0.02};
    scene given = stiff_scene(0.3, kse, kbt, 1, kbt), smooth;
    given.end.type = SCENE_LOADED;
    set_numbers(given.loads.tip.force, 3, (const double[]){0.1, -0.05, 0.08});
    given.tendon_count = 1;
    given.tendons[0] =
        (scene_tendon){.offset = {Q("0.012*cos(20*s)"), Q("0.012*sin(20*s)")}, .tension = Q(3.0)};
    add_tendon(&given, 0.01, -90, 2);
    given.tendons[1].end = Q(0.18);
    smooth = given;
    given.tendons[0].friction = Q(0.3);
    given.tendons[1].friction = Q(0.2);
    check_tip(&given,
              (const double[]){0.021203153571571102, -0.01827811096096332, 0.28769304730907425},
              (const double[]){0.9948024713315664, 0.07554279105305145, 0.04734781782686028,
                               -0.049188554558530224});
    /* Without friction, and with next to none. */
    double pose[2][7];
    for (int i = 0; i < 2; i++) {
        smooth.tendons[0].friction = Q(i * 1e-9);
        solved x = solve(&smooth, 0, NULL, 1e-12);
        pose_at(&x, 0.3, 0, pose[i]);
        solution_free(x.solution);
    }
    for (int k = 0; k < 3; k++) {
        assert_near(pose[0][k], pose[1][k], 1e-9);
    }
    assert_true(fabs(pose[0][0] - pose[1][0]) > 1e-12);
}

/* ---- Rucker and Webster -------------------------------------------------------------------- */

/* Their equations, which have second derivatives of the rod: of v and u, in the notation of
 * "Statics and dynamics of continuum robots with general tendon routing and external loading", IEEE
 * Trans. Robotics 27 (2011), eqs. 17, 18, for straight unstressed rods, without couples. */
typedef struct webster {
    double kse[3], kbt[3], tension[2], radius, winding, force[3]; /* f: world, per length */
} webster;

/* The second tendon winds about the rod, the first is straight: r, r', r''. */
static void route(const webster *w, int tendon, double s, double r[3][3])
{
    double k = tendon ? w->winding : 0, c = w->radius * cos(k * s), d = w->radius * sin(k * s);
    memcpy(r[0], (const double[]){c, d, 0}, sizeof r[0]);
    memcpy(r[1], (const double[]){-k * d, k * c, 0}, sizeof r[1]);
    memcpy(r[2], (const double[]){-k * k * c, -k * k * d, 0}, sizeof r[2]);
}

/* A x = -tension p' x (p' x x)/|p'|^3 */
static void apply(double tension, const double p[3], const double x[3], double out[3])
{
    double once[3], size = sqrt(vector_dot(p, p));
    vector_cross(p, x, once);
    vector_cross(p, once, out);
    for (int k = 0; k < 3; k++) {
        out[k] *= -tension / (size * size * size);
    }
}

/* Adds what a tendon has in the matrix [6][6], column-major, and in the right side of v_s, u_s. */
static void add_routed(double tension, double r[3][3], const double *v, const double *u,
                       double *matrix, double *right)
{
    double p[3], up[3], ur[3], sum[3], a[3], b[3];
    vector_cross(u, r[0], p);
    for (int k = 0; k < 3; k++) {
        p[k] += r[1][k] + v[k];
    }
    vector_cross(u, p, up);
    vector_cross(u, r[1], ur);
    for (int k = 0; k < 3; k++) {
        sum[k] = up[k] + ur[k] + r[2][k];
    }
    apply(tension, p, sum, a);
    vector_cross(r[0], a, b);
    for (int c = 0; c < 6; c++) {
        double unit[3] = {0}, x[3], force[3], moment[3];
        unit[c % 3] = 1;
        vector_cross(unit, r[0], x); /* u_s x r, which they write -r^ u_s */
        apply(tension, p, c < 3 ? unit : x, force);
        vector_cross(r[0], force, moment);
        for (int k = 0; k < 3; k++) {
            matrix[c * 6 + k] += force[k];
            matrix[c * 6 + 3 + k] += moment[k];
        }
    }
    for (int k = 0; k < 3; k++) {
        right[k] -= a[k];
        right[3 + k] -= b[k];
    }
}

/* y: r, q, v, u. */
static void webster_rate(const webster *w, double s, const double *y, double *rate)
{
    const double *q = y + 3, *v = y + 7, *u = y + 10;
    double R[3][3], matrix[36] = {0}, right[6], n[3], m[3], cross[3][3], load[3];
    int pivots[6];
    rotation_matrix(q, R);
    to_world(R, v, rate);
    quaternion_times_vector(q, u, rate + 3);
    to_body(R, w->force, load);
    for (int k = 0; k < 3; k++) {
        n[k] = w->kse[k] * (v[k] - (k == 2));
        m[k] = w->kbt[k] * u[k];
        matrix[k * 6 + k] = w->kse[k];
        matrix[(3 + k) * 6 + 3 + k] = w->kbt[k];
    }
    vector_cross(u, n, cross[0]);
    vector_cross(u, m, cross[1]);
    vector_cross(v, n, cross[2]);
    for (int k = 0; k < 3; k++) {
        right[k] = -cross[0][k] - load[k];
        right[3 + k] = -cross[1][k] - cross[2][k];
    }
    for (int i = 0; i < 2; i++) {
        double r[3][3];
        route(w, i, s, r);
        add_routed(w->tension[i], r, v, u, matrix, right);
    }
    for (int k = 0; k < 4; k++) {
        rate[3 + k] /= 2;
    }
    assert_int_equal(ad_dense_lu(6, matrix, pivots), 0);
    ad_dense_lu_solve(6, 1, matrix, pivots, right);
    memcpy(rate + 7, right, sizeof right);
}

/* By Runge and Kutta's method, from s = 0. */
static void webster_integrate(const webster *w, double length, double *y)
{
    enum { STEPS = 2000 };
    double h = length / STEPS, k[4][13], moved[13];
    for (int step = 0; step < STEPS; step++) {
        for (int stage = 0; stage < 4; stage++) {
            double share = stage == 0 ? 0 : stage == 3 ? 1 : 0.5;
            for (int i = 0; i < 13; i++) {
                moved[i] = y[i] + (stage ? share * h * k[stage - 1][i] : 0);
            }
            webster_rate(w, (step + share) * h, moved, k[stage]);
        }
        for (int i = 0; i < 13; i++) {
            y[i] += h / 6 * (k[0][i] + 2 * k[1][i] + 2 * k[2][i] + k[3][i]);
        }
    }
}

static const webster routed = {.kse = {400, 500, 900},
                               .kbt = {0.03, 0.04, 0.02},
                               .tension = {1.5, 4},
                               .radius = 0.008,
                               .winding = 20,
                               .force = {0.3, -0.2, 0.5}};

static scene routed_scene(const webster *w, double length)
{
    scene given = stiff_scene(length, w->kse, w->kbt, 1, w->kbt);
    given.tendon_count = 2;
    given.tendons[0] =
        (scene_tendon){.offset = {Q(w->radius), Q(0.0)}, .tension = Q(w->tension[0])};
    given.tendons[1] = (scene_tendon){.offset = {Q("0.008*cos(20*s)"), Q("0.008*sin(20*s)")},
                                      .tension = Q(w->tension[1])};
    set_numbers(given.loads.force, 3, w->force);
    return given;
}

/* From v and u at the clamp their equations lead to our tip, and to tensions that the rod bears
 * there alone: elastic n = -sum tau t, m = -sum r x tau t. */
static void test_webster(void **state)
{
    (void)state;
    const double length = 0.3, start = 0;
    scene given = routed_scene(&routed, length);
    solved x = solve(&given, 0, NULL, 1e-13);
    double y[13] = {0, 0, 0, 1}, values[19], tip[19], n[3], m[3];
    ad_error error;
    assert_int_equal(ad_dense_load(&error), AD_OK);
    assert_int_equal(solution_evaluate(x.solution, 19, 1, &start, NULL, values, &error), AD_OK);
    assert_int_equal(solution_evaluate(x.solution, 19, 1, &length, NULL, tip, &error), AD_OK);
    memcpy(y + 7, values + 7, 6 * sizeof *y);
    webster_integrate(&routed, length, y);
    for (int k = 0; k < 13; k++) {
        if (!(fabs(y[k] - tip[k]) < 1e-10 * (k < 10 ? 1 : 20))) { /* measured: 2e-12 */
            fail_msg("row %d: %.15g here, %.15g there", k, tip[k], y[k]);
        }
    }
    for (int k = 0; k < 3; k++) {
        n[k] = routed.kse[k] * (y[7 + k] - (k == 2));
        m[k] = routed.kbt[k] * y[10 + k];
    }
    for (int i = 0; i < 2; i++) {
        double r[3][3], p[3], moment[3];
        route(&routed, i, length, r);
        vector_cross(y + 10, r[0], p);
        for (int k = 0; k < 3; k++) {
            p[k] += r[1][k] + y[7 + k];
        }
        double size = sqrt(vector_dot(p, p));
        vector_cross(r[0], p, moment);
        for (int k = 0; k < 3; k++) {
            n[k] += routed.tension[i] * p[k] / size;
            m[k] += routed.tension[i] * moment[k] / size;
        }
    }
    for (int k = 0; k < 3; k++) {
        assert_near(n[k], 0, 1e-8); /* of some N */
        assert_near(m[k], 0, 1e-10);
    }
    solution_free(x.solution);
}

/* ---- derivatives --------------------------------------------------------------------------- */

/* y_s by y against differences, for all that pulls, also with locked strains. */
static void test_derivatives(void **state)
{
    (void)state;
    const double compliance[2][6] = {{0.01, 0.02, 0.03, 1, 0.8, 1.3}, {0, 0, 0, 1, 0.8, 1.3}};
    enum { TUBES = 2, PULLING = 3, ROWS = STATIC_TUBES + 2 * TUBES };
    const solve_extent extents[PULLING + TUBES] = {{.end = 1},
                                                   {.end = 1},
                                                   {.end = 1, .law = LAW_CHAMBER},
                                                   {.end = 1, .law = LAW_TUBE},
                                                   {.end = 1, .law = LAW_TUBE}};
    const solve_actuator actuators[PULLING + TUBES] = {
        {.offset = {0.1, 0.2}, .pull = 3},
        {.offset = {-0.2, 0.1}, .slope = {0.4, -0.3}, .pull = 5},
        {.offset = {0.1, -0.1}, .pull = -2},
        {.bending = {2, 3}, .softness = 0.7, .curvature = {1.1, -0.3, 0.2}},
        {.bending = {0.5, 0.4}, .softness = 0, .curvature = {-0.6, 1.4, 0}}};
    const double y[ROWS] = {0.1, 0.2, 0.3,  0.7, -0.2, 0.5,  0.4, -1.1, 0.9,
                            0.6, 0.3, -0.8, 0.5, 1.3,  -0.4, 2.2, 0.6};
    acting loads = {.count = 0};
    acting_add(&loads, LAW_MOMENT);
    acting_add(&loads, LAW_FOLLOWER_FORCE);
    for (int locked = 0; locked < 2; locked++) {
        const static_point at = {.rest = {.strain = {0, 0, 1}, .curvature = {0.1, -0.2, 0.3}},
                                 .acting = &loads,
                                 .numbers = {0.3, 0.2, 0.1, -0.5, 0.1, 0.2},
                                 .compliance = compliance[locked],
                                 .actuation = {.count = PULLING + TUBES,
                                               .extents = extents,
                                               .actuators = actuators,
                                               .factor = 0.9},
                                 .tubes = TUBES};
        double rate[ROWS], jacobian[ROWS][STATIC_ROWS_MAX];
        ad_error error;
        assert_int_equal(ad_dense_load(&error), AD_OK);
        static_rate(&at, y, rate, jacobian);
        for (int c = 0; c < ROWS; c++) {
            const double step = 1e-3;
            double moved[4][ROWS];
            for (int i = 0; i < 4; i++) { /* of fourth order */
                double here[ROWS];
                memcpy(here, y, sizeof here);
                here[c] += step * (i < 2 ? i - 2 : i - 1);
                static_rate(&at, here, moved[i], NULL);
            }
            for (int r = 0; r < ROWS; r++) {
                double slope = moved[0][r] - 8 * moved[1][r] + 8 * moved[2][r] - moved[3][r];
                assert_near(jacobian[r][c], slope / (12 * step), 1e-9); /* measured: 3e-11 */
            }
        }
    }
}

/* The equations on the tape have the same solution: one that is chosen, with loads by the tape. */
static void test_manufactured(void **state)
{
    (void)state;
    scene given = routed_scene(&routed, 0.3);
    memset(given.loads.force, 0, sizeof given.loads.force);
    const char *const angles[3] = {"2*s", "sin(5*s)", "s^2"};
    given.manufactured.position[0] = Q("0.1*s^2");
    given.manufactured.position[1] = Q("0.2*s*sin(4*s)");
    given.manufactured.position[2] = Q("0.95*s");
    set_quantities(given.manufactured.angles, 3, angles);
    given.chamber_count = 1;
    given.chambers[0] = (scene_chamber){
        .offset = {Q("0.01*s"), Q(0.004)}, .pressure = Q(3e4), .area = Q("1e-4*(1+s)")};
    solved x = solve(&given, 0, NULL, 1e-12);
    for (int i = 0; i <= 6; i++) {
        double s = 0.05 * i, pose[7];
        pose_at(&x, s, 0, pose);
        assert_near(pose[0], 0.1 * s * s, 1e-12);
        assert_near(pose[1], 0.2 * s * sin(4 * s), 1e-12);
        assert_near(pose[2], 0.95 * s, 1e-12);
    }
    solution_free(x.solution);
}

/* ---- stability ----------------------------------------------------------------------------- */

/* A narrow strip under P at its tip turns sideways from P L^2 = 4.0126 (EI GJ)^(1/2) on (Prandtl;
 * Timoshenko and Gere, Theory of Elastic Stability, 6.3). Two tendons at +-x wind with it: they add
 * 2 tau x^2 to GJ. A chamber along the axis and the force that bears it do nothing. */
static int ways_of(double load, double tension)
{
    const double stiff[3] = {INFINITY, INFINITY, INFINITY}, bending[3] = {2000, 1, 0.5};
    double at[STABILITY_POINTS], values[MODEL_COLUMNS_MAX * STABILITY_POINTS];
    int ways = -2;
    ad_error error;
    scene given = stiff_scene(1, stiff, bending, 1, bending);
    given.end.type = SCENE_LOADED;
    set_numbers(given.loads.tip.force, 3, (const double[]){0, load, 0});
    add_tendon(&given, 0.1, 0, tension);
    add_tendon(&given, 0.1, 180, tension);
    given.chamber_count = 1;
    given.chambers[0] =
        (scene_chamber){.offset = {Q(0.0), Q(0.0)}, .pressure = Q(100.0), .area = Q(1.0)};
    solved x = solve(&given, 0, NULL, 1e-10);
    assert_int_equal(stability_points(&given, at, NULL), AD_OK);
    assert_int_equal(solution_evaluate(x.solution, solution_columns(&given), STABILITY_POINTS, at,
                                       NULL, values, &error),
                     AD_OK);
    assert_int_equal(stability_count(&given, values, &ways, &error), AD_OK);
    solution_free(x.solution);
    return ways;
}

static void test_strip(void **state)
{
    (void)state;
    const double tension[2] = {1e-9, 25};
    for (int i = 0; i < 2; i++) {
        double critical = 4.0126 * sqrt(0.5 + 2 * tension[i] * 0.01);
        assert_int_equal(ways_of(0.99 * critical, tension[i]), 0);
        assert_int_equal(ways_of(1.01 * critical, tension[i]), 1);
    }
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_bensch),           cmocka_unit_test(test_weight),
        cmocka_unit_test(test_two_segments),     cmocka_unit_test(test_constant),
        cmocka_unit_test(test_webster),          cmocka_unit_test(test_lengths),
        cmocka_unit_test(test_lengths_and_load), cmocka_unit_test(test_derivatives),
        cmocka_unit_test(test_friction),         cmocka_unit_test(test_friction_wound),
        cmocka_unit_test(test_manufactured),     cmocka_unit_test(test_strip),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
