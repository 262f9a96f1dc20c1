/* The equations of the rod: a manufactured solution against check values of another derivation
 * (sympy), and against the equations in the world frame by finite differences in plain C. */
#include "rod_testing.h"

#include <stdio.h>

/* ---- D7: manufactured solution with all terms of the dynamic rod ----------------------------- */

static const double d7_kse[3] = {40, 50, 90}, d7_kbt[3] = {1.2, 0.8, 0.5};
static const double d7_inertia[3] = {0.03, 0.02, 0.05}, d7_mass = 1.3;

static scene d7_scene(double length, double duration)
{
    static const char *const position[3] = {"0.3*s^2*cos(2*t) + 0.1*s^3", "0.2*s^2*sin(3*t)",
                                            "s + 0.05*s^2*sin(t)"};
    static const char *const angles[3] = {"0.7*sin(pi*s/2)*cos(2*t) + 0.4*s^2", "0.5*s*sin(3*t+s)",
                                          "0.9*s*(1+s*sin(t))"};
    scene made = stiff_scene(length, d7_kse, d7_kbt, d7_mass, d7_inertia);
    made.duration = Q(duration);
    made.start.type = SCENE_DRIVEN;
    made.end.type = SCENE_LOADED;
    for (int i = 0; i < 3; i++) {
        made.manufactured.position[i] = Q(position[i]);
        made.manufactured.angles[i] = Q(angles[i]);
    }
    return made;
}

enum { D7_POINTS = 5 };
static const double d7_s[D7_POINTS] = {0, 0.25, 0.5, 0.8, 1},
                    d7_t[D7_POINTS] = {0, 0.4, 1, 1.7, 2.3};

/* reference/cases.json of the project's reference values, case D7 (sympy, 1e-14). */
static const double d7_position[D7_POINTS][3] = {
    {0, 0, 0},
    {0.014625750800259352, 0.01165048857459033, 0.25121693231971454},
    {-0.01871101274103568, 0.007056000402993361, 0.5105183873100987},
    {-0.13442525297525657, -0.11850427933794977, 0.831733273934479},
    {0.06635424191948355, 0.11568795287763987, 1.037285260608836}};
static const double d7_rotation[D7_POINTS][4] = {
    {1, 0, 0, 0},
    {0.9841334232568355, 0.11220597877371524, 0.04820790172982627, 0.12871372019727173},
    {0.9463672137961691, -0.06399012914100928, -0.024926238385995746, 0.3157103778213791},
    {0.7729360536177443, -0.1975197300090563, 0.0570101796306005, 0.6002546565362604},
    {0.6482472695465072, 0.28218250011318347, 0.062793771027198, 0.7044185236601572}};
static const double d7_strain[D7_POINTS][3] = {
    {0, 0, 1},
    {0.07657629782618282, 0.2934083879592694, 0.9754446660098329},
    {-0.01583137908333634, -0.0906211328133422, 1.0395842839490834},
    {-0.6935342311393542, -0.056768980835014776, 0.9178978300210728},
    {0.5591522037815149, 0.24882120055328397, 0.9422455499742219}};
static const double d7_curvature[D7_POINTS][3] = {
    {1.0995574287564276, 0, 0.9},
    {0.9984511023645557, 0.27575684108093135, 1.1875919812897562},
    {-0.18322502198437085, -0.37406206996737335, 1.6506286612908092},
    {0.26191021486163096, -0.2452680914370846, 2.2815858324239384},
    {0.47623195817594854, -0.7024301502867147, 2.6254381351106906}};
static const double d7_spin[D7_POINTS][3] = {
    {0, 0, 0},
    {-0.3587632900148965, 0.13702719249479867, 0.004241003163905234},
    {-1.1386556406668644, -0.028602966039729227, 0.20040700390060515},
    {1.1626031983550618, -0.016238335510273982, -0.12490922771551524},
    {-0.0694164006134993, -1.2211937081561695, 0.06666643095978686}};
static const double d7_force[D7_POINTS][3] = {
    {0, 0, 0},
    {3.0630519130473126, 14.670419397963471, -2.2099800591150256},
    {-0.6332551633334538, -4.53105664066711, 3.562585555417513},
    {-27.741369245574163, -2.838449041750737, -7.389195298103445},
    {22.36608815126059, 12.4410600276642, -5.197900502320024}};
static const double d7_moment[D7_POINTS][3] = {
    {1.319468914507713, 0, 0.45},
    {1.198141322837467, 0.22060547286474508, 0.5937959906448781},
    {-0.21987002638124498, -0.29924965597389874, 0.8253143306454046},
    {0.3142922578339572, -0.19621447314966772, 1.1407929162119692},
    {0.571478349811138, -0.5619441202293718, 1.3127190675553453}};
static const double d7_load_force[D7_POINTS][3] = {
    {-24, -54.97787143782138, 0},
    {5.2990602096788795, -62.20390950034758, -5.849141785019917},
    {-19.173442034630856, -5.394768685560287, -8.499928312388462},
    {31.050329897685, -3.5475201669680847, 0.14687432139138856},
    {-10.644852886166131, -35.40301033629879, -3.243429171769691}};
static const double d7_load_moment[D7_POINTS][3] =
    {/* body */
     {-0.96, -0.7010398314119213, 0},
     {14.34750702354882, -3.0884667533299797, -0.7224584507080289},
     {-4.438568333828118, 1.7458926330972655, -0.6532842230400278},
     {-4.474229898179891, 32.20450578970098, -1.19117323164993},
     {14.892183632169875, -23.457209162744018, -2.6326077889529}};

static void check_d7(ad_value value, const double *expected, int rows)
{
    scene given = d7_scene(1, 3);
    double t[D7_POINTS], time = rod_scales_of(&given).time;
    for (int i = 0; i < D7_POINTS; i++)
        t[i] = d7_t[i] / time;
    double *numbers = evaluate_at(value, D7_POINTS, d7_s, t, NULL);
    for (int i = 0; i < D7_POINTS; i++) {
        for (int row = 0; row < rows; row++) /* values to 60 from third derivatives: 1e-14 each */
            assert_near(numbers[row * D7_POINTS + i], expected[i * rows + row], 3e-12);
    }
    free(numbers);
}

static void test_d7_values(void **state)
{
    (void)state;
    scene given = d7_scene(1, 3);
    recorded r = begin(&given);
    rod_state exact = rod_manufactured(&given, r.s, r.t);
    rod_observables seen = rod_observe(&given, exact, &r.at);
    rod_load load = rod_manufactured_load(&given, r.s, r.t);
    rod_scales scale = rod_scales_of(&given);
    check_d7(seen.position, d7_position[0], 3);
    check_d7(seen.rotation, d7_rotation[0], 4);
    check_d7(seen.strain, d7_strain[0], 3);
    check_d7(seen.curvature, d7_curvature[0], 3);
    check_d7(seen.angular_velocity, d7_spin[0], 3);
    check_d7(seen.force, d7_force[0], 3);
    check_d7(seen.moment, d7_moment[0], 3);
    check_d7(ad_scale(load.force, scale.force), d7_load_force[0], 3);
    check_d7(ad_rotate_inverse(exact.rotation, ad_scale(load.moment, scale.moment)),
             d7_load_moment[0], 3);
    ad_tape_free(r.tape);
}

/* ---- all terms, against differences of the world-frame equations ----------------------------- */

/* What the plain reference knows; SI. */
typedef struct plain {
    bool dynamic, varies; /* along the rod, gravity and the rest shape in time */
    double kse[3], kbt[3], bse[3], bbt[3], mass, inertia[3], gravity[3], drag, quadratic;
} plain;

/* What each of these is multiplied by where the rod varies: 1 + slope s. */
static const double SLOPE_KSE = 0.3, SLOPE_KBT = -0.2, SLOPE_BSE = 0.1, SLOPE_BBT = 0.5,
                    SLOPE_MASS = 0.4, SLOPE_INERTIA = 0.7, SLOPE_DRAG = 0.6, SLOPE_QUADRATIC = -0.1;

static double along(const plain *p, double slope, double s)
{
    return p->varies ? 1 + slope * s : 1;
}

static quantity varying(const plain *p, double number, double slope)
{
    char text[96];
    snprintf(text, sizeof text, "%.17g*(1 + %.17g*s)", number, slope);
    return p->varies ? Q(text) : Q(number);
}

/* Of gravity, and what is added to v*_1 and u*_2. */
static double pulling(const plain *p, double t)
{
    return p->varies && p->dynamic ? cos(3 * t) : 1;
}

static double stretching(const plain *p, double t)
{
    return p->varies && p->dynamic ? 0.1 * sin(2 * t) : 0;
}

static double curling(const plain *p, double s, double t)
{
    return p->varies && p->dynamic ? 0.2 * s * t : 0;
}

static void plain_cross(const double *a, const double *b, double *c)
{
    c[0] = a[1] * b[2] - a[2] * b[1];
    c[1] = a[2] * b[0] - a[0] * b[2];
    c[2] = a[0] * b[1] - a[1] * b[0];
}

static void plain_multiply(const double *p, const double *q, double *pq)
{
    pq[0] = p[0] * q[0] - p[1] * q[1] - p[2] * q[2] - p[3] * q[3];
    pq[1] = p[0] * q[1] + p[1] * q[0] + p[2] * q[3] - p[3] * q[2];
    pq[2] = p[0] * q[2] - p[1] * q[3] + p[2] * q[0] + p[3] * q[1];
    pq[3] = p[0] * q[3] + p[1] * q[2] - p[2] * q[1] + p[3] * q[0];
}

static void plain_conjugate(const double *q, double *p)
{
    for (int i = 0; i < 4; i++)
        p[i] = i == 0 ? q[i] : -q[i];
}

static void plain_rotate(const double *q, const double *x, double *y)
{
    double pure[4] = {0, x[0], x[1], x[2]}, back[4], half[4], full[4];
    plain_conjugate(q, back);
    plain_multiply(q, pure, half);
    plain_multiply(half, back, full);
    memcpy(y, full + 1, 3 * sizeof *y);
}

static void plain_position(const plain *p, double s, double t, double *r)
{
    t = p->dynamic ? t : 0;
    r[0] = 0.3 * s * s * cos(2 * t) + 0.1 * s * s * s;
    r[1] = 0.2 * s * s * sin(3 * t);
    r[2] = s + 0.05 * s * s * sin(t);
}

static void plain_rotation(const plain *p, double s, double t, double *q)
{
    t = p->dynamic ? t : 0;
    double a = 0.7 * sin(PI * s / 2) * cos(2 * t) + 0.4 * s * s, b = 0.5 * s * sin(3 * t + s);
    double c = 0.9 * s * (1 + s * sin(t));
    double qa[4] = {cos(a / 2), sin(a / 2), 0, 0}, qb[4] = {cos(b / 2), 0, sin(b / 2), 0};
    double qc[4] = {cos(c / 2), 0, 0, sin(c / 2)}, ab[4];
    plain_multiply(qa, qb, ab);
    plain_multiply(ab, qc, q);
}

typedef void plain_field(const plain *p, double s, double t, double *y);

/* Sixth-order central difference, step 0.01: error about 1e-12 of a seventh derivative. */
static void difference(const plain *p, plain_field *field, int rows, bool along_s, double s,
                       double t, double *y)
{
    static const double weights[3] = {0.75, -0.15, 1.0 / 60};
    const double h = 0.01;
    for (int row = 0; row < rows; row++)
        y[row] = 0;
    for (int i = 1; i <= 3; i++) {
        double ahead[4], behind[4], ds = along_s ? i * h : 0, dt = along_s ? 0 : i * h;
        field(p, s + ds, t + dt, ahead);
        field(p, s - ds, t - dt, behind);
        for (int row = 0; row < rows; row++)
            y[row] += weights[i - 1] * (ahead[row] - behind[row]) / h;
    }
}

static void plain_strain(const plain *p, double s, double t, double *v)
{
    double q[4], back[4], slope[3];
    plain_rotation(p, s, t, q);
    plain_conjugate(q, back);
    difference(p, plain_position, 3, true, s, t, slope);
    plain_rotate(back, slope, v);
}

static void plain_rate(const plain *p, bool along_s, double s, double t, double *u)
{
    double q[4], back[4], slope[4], product[4];
    plain_rotation(p, s, t, q);
    plain_conjugate(q, back);
    difference(p, plain_rotation, 4, along_s, s, t, slope);
    plain_multiply(back, slope, product);
    for (int i = 0; i < 3; i++)
        u[i] = 2 * product[i + 1];
}

static void plain_curvature(const plain *p, double s, double t, double *u)
{
    plain_rate(p, true, s, t, u);
}

/* Rest strain and curvature of the test scene below. */
static void plain_force(const plain *p, double s, double t, double *force)
{
    double v[3], rate[3] = {0, 0, 0}, q[4], body[3];
    double rest[3] = {0.1 * s + stretching(p, t), 0, 1 + 0.05 * sin(s)};
    plain_strain(p, s, t, v);
    if (p->dynamic)
        difference(p, plain_strain, 3, false, s, t, rate);
    for (int i = 0; i < 3; i++)
        body[i] = along(p, SLOPE_KSE, s) * p->kse[i] * (v[i] - rest[i]) +
                  along(p, SLOPE_BSE, s) * p->bse[i] * rate[i];
    plain_rotation(p, s, t, q);
    plain_rotate(q, body, force);
}

static void plain_moment(const plain *p, double s, double t, double *moment)
{
    double u[3], rate[3] = {0, 0, 0}, q[4], body[3];
    double rest[3] = {0.4, cos(s) + curling(p, s, t), -0.3 * s};
    plain_curvature(p, s, t, u);
    if (p->dynamic)
        difference(p, plain_curvature, 3, false, s, t, rate);
    for (int i = 0; i < 3; i++)
        body[i] = along(p, SLOPE_KBT, s) * p->kbt[i] * (u[i] - rest[i]) +
                  along(p, SLOPE_BBT, s) * p->bbt[i] * rate[i];
    plain_rotation(p, s, t, q);
    plain_rotate(q, body, moment);
}

static void plain_velocity(const plain *p, double s, double t, double *velocity)
{
    difference(p, plain_position, 3, false, s, t, velocity);
}

static void plain_angular_momentum(const plain *p, double s, double t, double *world)
{
    double w[3], q[4];
    plain_rate(p, false, s, t, w);
    for (int i = 0; i < 3; i++)
        w[i] *= along(p, SLOPE_INERTIA, s) * p->inertia[i];
    plain_rotation(p, s, t, q);
    plain_rotate(q, w, world);
}

/* Distributed force, moment as the scene gives them, before turning by the rotation. */
static void plain_given(double s, double t, double *force, double *moment)
{
    const double f[3] = {2 * s, sin(t + s), -1}, l[3] = {0.3, s * s, 0.5 * cos(t)};
    memcpy(force, f, sizeof f);
    memcpy(moment, l, sizeof l);
}

/* f = rhoA r_tt - N_s - rhoA g + c r_t - given; l = (R rhoJ w)_t - M_s - r_s x N - given. */
static void plain_load(const plain *p, bool follower, double s, double t, double *f, double *l)
{
    double slope[3], velocity[3], acceleration[3], n[3], n_s[3], m_s[3], momentum[3], arm[3], q[4];
    double force[3], moment[3];
    difference(p, plain_position, 3, true, s, t, slope);
    plain_velocity(p, s, t, velocity);
    difference(p, plain_velocity, 3, false, s, t, acceleration);
    plain_force(p, s, t, n);
    difference(p, plain_force, 3, true, s, t, n_s);
    difference(p, plain_moment, 3, true, s, t, m_s);
    difference(p, plain_angular_momentum, 3, false, s, t, momentum);
    plain_cross(slope, n, arm);
    plain_given(s, t, force, moment);
    plain_rotation(p, s, t, q);
    if (follower) {
        plain_rotate(q, force, force);
        plain_rotate(q, moment, moment);
    }
    double rate = p->dynamic ? 1 : 0, mass = along(p, SLOPE_MASS, s) * p->mass;
    double speed =
        sqrt(velocity[0] * velocity[0] + velocity[1] * velocity[1] + velocity[2] * velocity[2]);
    double drag =
        along(p, SLOPE_DRAG, s) * p->drag + along(p, SLOPE_QUADRATIC, s) * p->quadratic * speed;
    for (int i = 0; i < 3; i++) {
        f[i] = rate * (mass * acceleration[i] + drag * velocity[i]) - n_s[i] -
               mass * pulling(p, t) * p->gravity[i] - force[i];
        l[i] = rate * momentum[i] - m_s[i] - arm[i] - moment[i];
    }
}

static scene full_scene(const plain *p, double length, scene_frame frame)
{
    scene made = d7_scene(length, p->dynamic ? 2.0 : 0.0);
    static const char *const still[2][3] = {{"0.3*s^2 + 0.1*s^3", "0", "s"},
                                            {"0.7*sin(pi*s/2) + 0.4*s^2", "0.5*s*sin(s)", "0.9*s"}};
    static const char *const strain[3] = {"0.1*s", "0", "1+0.05*sin(s)"};
    static const char *const curvature[3] = {"0.4", "cos(s)", "-0.3*s"};
    static const char *const force[3] = {"2*s", "sin(t+s)", "-1"};
    static const char *const moment[3] = {"0.3", "s^2", "0.5*cos(t)"};
    for (int i = 0; i < 3; i++) {
        if (!p->dynamic) {
            made.manufactured.position[i] = Q(still[0][i]);
            made.manufactured.angles[i] = Q(still[1][i]);
        }
        made.rod.rest_strain[i] = Q(strain[i]);
        made.rod.rest_curvature[i] = Q(curvature[i]);
        made.rod.strain_damping[i] = varying(p, p->bse[i], SLOPE_BSE);
        made.rod.curvature_damping[i] = varying(p, p->bbt[i], SLOPE_BBT);
        made.rod.rotary_inertia[i] = varying(p, p->inertia[i], SLOPE_INERTIA);
        made.loads.gravity[i] = Q(p->gravity[i]);
        made.loads.force[i] = Q(force[i]);
        made.loads.moment[i] = Q(moment[i]);
    }
    for (int i = 0; i < 2; i++) {
        made.rod.shear_stiffness[i] = varying(p, p->kse[i], SLOPE_KSE);
        made.rod.bending_stiffness[i] = varying(p, p->kbt[i], SLOPE_KBT);
    }
    made.rod.axial_stiffness = varying(p, p->kse[2], SLOPE_KSE);
    made.rod.torsional_stiffness = varying(p, p->kbt[2], SLOPE_KBT);
    made.rod.mass_per_length = varying(p, p->mass, SLOPE_MASS);
    made.loads.drag = varying(p, p->drag, SLOPE_DRAG);
    made.loads.quadratic_drag = varying(p, p->quadratic, SLOPE_QUADRATIC);
    made.loads.frame = frame;
    if (p->varies && p->dynamic) {
        made.loads.gravity[0] = Q("3*cos(3*t)");
        made.loads.gravity[1] = Q("-2*cos(3*t)");
        made.loads.gravity[2] = Q("-9.81*cos(3*t)");
        made.rod.rest_strain[0] = Q("0.1*s + 0.1*sin(2*t)");
        made.rod.rest_curvature[1] = Q("cos(s) + 0.2*s*t");
    }
    return made;
}

static plain full_plain(bool dynamic, bool varies)
{
    return (plain){.dynamic = dynamic,
                   .varies = varies,
                   .kse = {40, 50, 90},
                   .kbt = {1.2, 0.8, 0.5},
                   .bse = {2, 3, 5},
                   .bbt = {0.11, 0.07, 0.05},
                   .mass = 1.3,
                   .inertia = {0.03, 0.02, 0.05},
                   .gravity = {3, -2, -9.81},
                   .drag = 0.7,
                   .quadratic = 0.9};
}

static void check_full(bool dynamic, bool varies, scene_frame frame, double length)
{
    plain p = full_plain(dynamic, varies);
    scene given = full_scene(&p, length, frame);
    recorded r = begin(&given);
    rod_scales scale = rod_scales_of(&given);
    rod_load load = rod_manufactured_load(&given, r.s, r.t);
    double t[POINTS];
    points_of_time(&given, t);
    double *force =
        evaluate_at(ad_scale(load.force, scale.force / length), POINTS, unit_s, t, NULL);
    double *moment =
        evaluate_at(ad_scale(load.moment, scale.moment / length), POINTS, unit_s, t, NULL);
    for (int k = 0; k < POINTS; k++) {
        double f[3], l[3];
        plain_load(&p, frame == SCENE_FOLLOWER, unit_s[k] * length, t[k] * scale.time, f, l);
        for (int i = 0; i < 3; i++) { /* three nested differences leave 1e-8 */
            assert_near(force[i * POINTS + k], f[i], 1e-7 * fmax(1, fabs(f[i])));
            assert_near(moment[i * POINTS + k], l[i], 1e-7 * fmax(1, fabs(l[i])));
        }
    }
    free(force);
    free(moment);
    ad_tape_free(r.tape);
}

static void test_all_terms(void **state)
{
    (void)state;
    for (int varies = 0; varies < 2; varies++) {
        check_full(true, varies, SCENE_DEAD, 1.7);
        check_full(true, varies, SCENE_FOLLOWER, 0.8);
        check_full(false, varies, SCENE_DEAD, 0.8);
        check_full(false, varies, SCENE_FOLLOWER, 1.7);
    }
}

/* Both forms, all rows, with everything switched on: the exact state has no residual. */
static void test_manufactured_residuals(void **state)
{
    (void)state;
    for (int variant = 0; variant < 16; variant++) {
        plain p = full_plain(variant & 1, variant & 8);
        scene given = full_scene(&p, 1.7, variant & 2 ? SCENE_FOLLOWER : SCENE_DEAD);
        given.formulation = variant & 4 ? SCENE_DISPLACEMENT : SCENE_MIXED;
        given.boundary_enforcement = given.initial_enforcement = SCENE_SOFT;
        recorded r = begin(&given);
        rod_state exact = rod_manufactured(&given, r.s, r.t);
        check_interior(&given, &r, exact, 1e-11);
        double t[POINTS], start[POINTS] = {0}, end[POINTS] = {1, 1, 1, 1, 1, 1};
        points_of_time(&given, t);
        ad_value at_start = rod_residual(&given, ROD_START, exact, &r.at);
        ad_value at_end = rod_residual(&given, ROD_END, exact, &r.at);
        assert_int_equal(ad_rows(at_end), 6);
        assert_near(largest(at_start, start, t), 0, 1e-12);
        assert_near(largest(at_end, end, t), 0, 1e-11);
        if (p.dynamic) {
            ad_value initial = rod_residual(&given, ROD_INITIAL, exact, &r.at);
            assert_int_equal(ad_rows(initial), 12);
            assert_near(largest(initial, unit_s, start), 0, 1e-12);
            assert_true(largest(initial, unit_s, t) > 0.1); /* not by accident */
        }
        assert_true(largest(at_end, start, t) > 0.1);
        ad_tape_free(r.tape);
    }
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_d7_values),
        cmocka_unit_test(test_all_terms),
        cmocka_unit_test(test_manufactured_residuals),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
