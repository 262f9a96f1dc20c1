/* Rods in motion with what acts at single places: loads, joints, bodies, springs. */
#include "fewer.h"
#include "jump_testing.h"

#include "physics/numerics/quaternion.h"
#include "random_numbers.h"

#include <stdio.h>

/* Stout, so that its waves are slow. */
static scene stout_scene(double length)
{
    const double kse[3] = {40, 50, 90}, kbt[3] = {1.2, 0.8, 0.5}, inertia[3] = {0.03, 0.02, 0.05};
    scene made = stiff_scene(length, kse, kbt, 1.3, inertia);
    set_numbers(made.start.position, 3, (double[]){0, 0, 0});
    set_numbers(made.start.rotation, 4, (double[]){1, 0, 0, 0});
    return made;
}

static solved solve_motion(const scene *given, double tolerance, size_t count, const double *times)
{
    solved x = solve_at(given, tolerance, count, times);
    assert_true(x.report.estimate_l2 <= tolerance);
    return x;
}

/* So many nodes at least, whatever the waves: what is conserved is so on any mesh. */
static solved solve_on(const scene *given, int nodes, size_t count, const double *times)
{
    ad_error error = {.message = ""};
    const solve_settings settings = {.tolerance = 1e-10, .nodes = nodes};
    solved x;
    if (solution_create(given, &settings, count, times, &x.solution, &x.report, &error) != AD_OK) {
        fail_msg("%s", error.message);
    }
    return x;
}

/* ---- momentum and energy -------------------------------------------------------------------- */

typedef struct momenta {
    double linear[3], angular[3], kinetic;
} momenta;

static void add_momentum(momenta *to, double weight, double mass, const double *inertia,
                         const rod_values *at)
{
    double R[3][3], spin[3] = {inertia[0] * at->w[0], inertia[1] * at->w[1], inertia[2] * at->w[2]};
    double orbit[3], turned[3];
    rotation_matrix(at->q, R);
    to_world(R, spin, turned);
    vector_cross(at->r, at->V, orbit);
    for (int i = 0; i < 3; i++) {
        to->linear[i] += weight * mass * at->V[i];
        to->angular[i] += weight * (mass * orbit[i] + turned[i]);
        to->kinetic += weight / 2 * (mass * at->V[i] * at->V[i] + spin[i] * at->w[i]);
    }
}

/* Of the rod, by Gauss-Legendre points of each piece, and of bodies. */
static momenta momenta_of(const scene *given, const solved *x, double t)
{
    enum { SLICES = 64 }; /* edges of elements are among theirs */
    static const double node[3] = {-0.7745966692414834, 0, 0.7745966692414834};
    static const double weight[3] = {5.0 / 18, 8.0 / 18, 5.0 / 18};
    momenta sum = {.kinetic = 0};
    double inertia[3], s = 0;
    for (int i = 0; i < 3; i++) {
        inertia[i] = given->rod.rotary_inertia[i].number;
    }
    for (int piece = 0; piece < given->segment_count; piece++) {
        double h = given->segments[piece].length.number / SLICES;
        for (int k = 0; k < 3 * SLICES; k++) {
            double at = s + h * (k / 3 + 0.5 + 0.5 * node[k % 3]);
            rod_values here = values_at(x, at, t);
            add_momentum(&sum, h * weight[k % 3], given->rod.mass_per_length.number, inertia,
                         &here);
        }
        s += SLICES * h;
    }
    for (int i = 0; i < given->body_count; i++) {
        rod_values here = values_at(x, given->bodies[i].at.number, t);
        for (int k = 0; k < 3; k++) {
            inertia[k] = given->bodies[i].inertia[k].number;
        }
        add_momentum(&sum, 1, given->bodies[i].mass.number, inertia, &here);
    }
    return sum;
}

/* A free elbow that spins, with bodies at its joint, within and at its end: momentum grows by the
 * force of a point, m g t of weights; without them angular momentum stays as well. */
static void test_free_elbow(void **state)
{
    (void)state;
    const double heavy[3] = {0.06, 0.03, 0.05}, F[3] = {0.3, -0.2, 0.5}, g[3] = {0, 0.4, -1};
    const double times[3] = {0, 0.2, 0.5};
    for (int loaded = 0; loaded < 2; loaded++) {
        scene given = stout_scene(1);
        given.start.type = SCENE_FREE;
        given.duration = Q(0.5);
        add_segment(&given, 0.6, NULL);
        add_segment(&given, 0.4, (double[]){0.4, PI / 3, -0.5});
        add_body(&given, 0.6, 0.2, heavy);
        add_body(&given, 0.3, 0.1, heavy);
        add_body(&given, 1, 0.3, heavy);
        set_quantities(given.initial.velocity, 3,
                       (const char *const[]){"0.3*sin(3*s)", "0.2", "-0.1*s"});
        if (loaded) {
            set_numbers(given.loads.gravity, 3, g);
            add_point(&given, 0.8, SCENE_DEAD, F, NULL);
        }
        solved x = solve_on(&given, 24, 3, times);
        momenta start = momenta_of(&given, &x, 0);
        double mass = 1.3 + 0.2 + 0.1 + 0.3, t = times[2];
        for (int which = 1; which < 3; which++) {
            momenta now = momenta_of(&given, &x, times[which]);
            for (int i = 0; i < 3; i++) {
                double gained = loaded ? times[which] * (F[i] + mass * g[i]) : 0;
                assert_near(now.linear[i] - start.linear[i], gained, 1e-8);
                if (!loaded) {
                    assert_near(now.angular[i], start.angular[i], 1e-7); /* of the quadrature */
                }
            }
        }
        solve_energy energy;
        assert_int_equal(solution_energy(x.solution, t, &energy, NULL), AD_OK);
        assert_near(energy.kinetic, momenta_of(&given, &x, t).kinetic, 1e-5); /* of the mesh */
        assert_near(energy.mismatch, 0, 1e-8);
        assert_true(loaded || energy.work == 0);
        solution_free(x.solution);
    }
}

/* Springs, joints, bodies, follower loads of time: energy is in balance, to the steps of time. */
static void test_energy(void **state)
{
    (void)state;
    const double times[2] = {0.2, 0.4};
    scene given = stout_scene(1);
    given.duration = Q(0.4);
    set_numbers(given.loads.gravity, 3, (double[]){1, 2, -3});
    add_segment(&given, 0.4, NULL);
    add_segment(&given, 0.6, (double[]){0.2, 1, 0.3});
    add_body(&given, 0.4, 0.2, (double[]){0.02, 0.04, 0.01});
    add_body(&given, 1, 0.1, (double[]){0.01, 0.01, 0.01});
    add_spring(&given, 0.4, (double[]){3, 0, 5}, (double[]){0.2, 0.4, 0.1});
    set_numbers(add_spring(&given, 1, (double[]){3, 2, 5}, NULL)->anchor, 3,
                (double[]){0.5, 0.5, 0.5});
    scene_point *point = add_point(&given, 0.4, SCENE_FOLLOWER, NULL, (double[]){0, 0, 0.3});
    set_quantities(point->load.force, 3, (const char *const[]){"2*t", "sin(20*t)", "-1"});
    add_point(&given, 0.7, SCENE_DEAD, (double[]){1, 1, 0}, (double[]){0.3, 0.2, -0.1});
    solved x = solve_on(&given, 24, 2, times);
    solve_energy energy;
    assert_int_equal(solution_energy(x.solution, times[1], &energy, NULL), AD_OK);
    assert_true(fabs(energy.work) > 0.1 && energy.strain > 0.1);
    assert_near(energy.mismatch, 0, 1e-8); /* steps of order 4, as long as is stable */
    solution_free(x.solution);
}

/* ---- against beams and rods at rest -------------------------------------------------------- */

/* A motion so small that it is that of Timoshenko's beam, which another solver has: a force within
 * that grows, on a body; another body and a spring at the tip. What is not linear is of the order
 * of the square of the deflection, 1e-8. */
static void test_small_motion(void **state)
{
    (void)state;
    const double L = 1.5, EI = 1.2, kGA = 50, rhoA = 1.3, rhoI = 0.03, small = 1e-4, t = 1.4;
    scene beam;
    scene_defaults(&beam);
    beam.rod.model = SCENE_TIMOSHENKO;
    beam.rod.length = Q(L);
    beam.rod.bending_stiffness[0] = Q(EI);
    beam.rod.shear_stiffness[1] = Q(kGA);
    beam.rod.mass_per_length = Q(rhoA);
    beam.rod.rotary_inertia[0] = Q(rhoI);
    beam.duration = Q(t);
    scene rod = stout_scene(L);
    rod.duration = Q(t);
    for (int i = 0; i < 2; i++) {
        scene *to = i ? &rod : &beam;
        add_body(to, 0.6, 0.4, (double[]){0.02, 0.02, 0.02});
        add_body(to, L, 0.2, (double[]){0.03, 0.02, 0.02});
        add_spring(to, L, (double[]){0, 2, 0}, (double[]){0.5, 0, 0});
    }
    scene_beam_point *load = &beam.beam.points[beam.beam.point_count++];
    *load = (scene_beam_point){.at = Q(0.6)};
    load->load = (scene_beam_load){Q("1e-4*t^4"), Q("2e-5*t^4")};
    scene_point *point = add_point(&rod, 0.6, SCENE_DEAD, NULL, NULL);
    point->load.force[1] = Q("1e-4*t^4");
    point->load.moment[0] = Q("-2e-5*t^4"); /* d3 towards d2 turns about -d1 */
    solved x = solve_motion(&beam, 1e-8, 1, &t), y = solve_motion(&rod, 1e-10, 1, &t);
    for (double s = 0.3; s <= L; s += 0.4) {
        double w[6];
        assert_int_equal(solution_evaluate(x.solution, 6, 1, &s, &t, w, NULL), AD_OK);
        rod_values at = values_at(&y, s, t);
        assert_near(at.r[1], w[0], 1e-6 * small);
        assert_near(at.V[1], w[4], 3e-5 * small);
    }
    solution_free(x.solution);
    solution_free(y.solution);
}

/* A rod that starts from its equilibrium, which another solver found, stays there: joints, springs,
 * bodies, points, also at the ends and where several are. */
static void test_equilibrium_stays(void **state)
{
    (void)state;
    quantities *names = quantities_create();
    const double times[2] = {0.15, 0.3};
    scene given = stout_scene(1);
    set_numbers(given.loads.gravity, 3, (double[]){0.5, 1, -1});
    set_numbers(given.loads.force, 3, (double[]){0.2, 0.1, 0.3});
    given.loads.frame = SCENE_FOLLOWER;
    add_segment(&given, 0.45, NULL);
    add_segment(&given, 0.55, (double[]){0.3, 1.2, -0.4});
    add_body(&given, 1, 0.2, (double[]){0.02, 0.04, 0.01});
    add_spring(&given, 0.45, (double[]){3, 0, 5}, (double[]){0.2, 0.4, 0.1});
    set_numbers(add_spring(&given, 1, (double[]){3, 2, 5}, NULL)->anchor, 3,
                (double[]){0.5, 0.2, 0.4});
    add_point(&given, 0.45, SCENE_FOLLOWER, (double[]){0.5, 0.2, -0.4}, (double[]){0.1, 0.3, 0.2});
    add_point(&given, 0.8, SCENE_DEAD, (double[]){0.3, 0.1, 0}, (double[]){0.3, 0.2, -0.1});
    given.duration = Q(NULL);
    solved still = solve_rest_of(&given);
    given.duration = Q(0.3);
    given.initial.state = SCENE_EQUILIBRIUM;
    ad_error error = {.message = ""};
    if (solve_settle(&given, names, &error) != AD_OK) {
        fail_msg("%s", error.message);
    }
    solved x = solve_motion(&given, 1e-8, 2, times);
    for (double s = 0; s <= 1; s += 0.15) {
        rod_values now = values_at(&x, s, 0.3), rest = values_at(&still, s, 0);
        assert_vector(now.r, rest.r, 2e-8);
        assert_vector(now.m, rest.m, 1e-5);
        assert_vector(now.n, rest.n, 1e-5);
        for (int k = 0; k < 4; k++) {
            assert_near(now.q[k], rest.q[k], 1e-7);
        }
    }
    solution_free(still.solution);
    solution_free(x.solution);
    quantities_free(names);
}

/* ---- a pendulum ---------------------------------------------------------------------------- */

/* A rod so stiff that it stays straight, pinned, with a heavy bob: of mass M and inertia J about
 * the axis that it swings about, and of the rod's own, a compound pendulum, by Runge and Kutta. */
static void test_pendulum(void **state)
{
    (void)state;
    enum { STEPS = 4000 };
    const double L = 1, M = 2, J = 0.3, g = 5, t = 1, rhoA = 1.3, rhoI = 0.03;
    const double stiff[3] = {1e6, 1e6, 1e6}, inertia[3] = {rhoI, 0.02, 0.05};
    scene given = stiff_scene(L, stiff, stiff, rhoA, inertia);
    given.start.type = SCENE_PINNED;
    set_numbers(given.start.position, 3, (double[]){0, 0, 0});
    set_numbers(given.loads.gravity, 3, (double[]){0, 0, -g});
    double angle = 2.5, rate = 0; /* from hanging */
    set_numbers(given.initial.position, 3, (double[]){0, 0, 0});
    char y[64], z[64];
    snprintf(y, sizeof y, "%.17g*s", sin(angle));
    snprintf(z, sizeof z, "%.17g*s", -cos(angle));
    given.initial.position[1] = Q((const char *)y);
    given.initial.position[2] = Q((const char *)z);
    double turn = PI - angle; /* d3 from z towards y is about -x */
    set_numbers(given.initial.rotation, 4, (double[]){cos(turn / 2), -sin(turn / 2), 0, 0});
    given.duration = Q(t);
    add_body(&given, L, M, (double[]){J, 0.2, 0.1});
    solved x = solve_at(&given, 1e-5, 1, &t);
    double about = M * L * L + J + rhoA * L * L * L / 3 + rhoI * L;
    double pull = -(M * g * L + rhoA * g * L * L / 2) / about, h = t / STEPS;
    for (int i = 0; i < STEPS; i++) {
        double k[5][2] = {{0}};
        static const double part[4] = {0, 0.5, 0.5, 1};
        for (int j = 0; j < 4; j++) {
            k[j + 1][0] = rate + h * part[j] * k[j][1];
            k[j + 1][1] = pull * sin(angle + h * part[j] * k[j][0]);
        }
        angle += h * (k[1][0] + 2 * k[2][0] + 2 * k[3][0] + k[4][0]) / 6;
        rate += h * (k[1][1] + 2 * k[2][1] + 2 * k[3][1] + k[4][1]) / 6;
    }
    rod_values tip = values_at(&x, L, t);
    assert_near(tip.r[1], L * sin(angle), 1e-4); /* bends by some M g L^3/EI, 1e-5 */
    assert_near(tip.r[2], -L * cos(angle), 1e-4);
    assert_near(tip.w[0], rate, 1e-2);
    solution_free(x.solution);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_small_motion),
        cmocka_unit_test(test_equilibrium_stays),
    };
    const struct CMUnitTest alike[] = {cmocka_unit_test(test_pendulum),
                                       cmocka_unit_test(test_free_elbow),
                                       cmocka_unit_test(test_energy)};
    return run_with_alike(tests, alike, NULL, NULL);
}
