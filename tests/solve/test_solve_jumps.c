/* Rods at rest with what acts at single places: loads, joints, bodies, springs. */
#include "jump_testing.h"
#include "solve_memory.h"

#include "physics/local/rod_model.h"
#include "physics/numerics/quaternion.h"
#include "physics/rod/rod_internal.h"
#include "random_numbers.h"

static const double asked = 1e-10; /* of a position, by the length */

/* ---- point loads --------------------------------------------------------------------------- */

/* Timoshenko and Young: w = F s^2 (3a - s)/6EI up to the load, F a^2 (3s - a)/6EI beyond it. The
 * load is so small that what is not linear, of the order of its square, is lost in rounding. */
static void test_cantilever_with_point(void **state)
{
    (void)state;
    const double length = 2, bending = 3, a = 0.7, F = 1e-6;
    scene given = slender_scene(length, bending, 1);
    add_point(&given, a, SCENE_DEAD, (double[]){F, 0, 0}, NULL);
    solved x = solve_rest_of(&given);
    for (double s = 0.15; s < length; s += 0.3) {
        double w = s < a ? F * s * s * (3 * a - s) : F * a * a * (3 * s - a);
        rod_values at = values_at(&x, s, 0);
        assert_near(at.r[0], w / (6 * bending), 1e-12 * length);
        assert_near(at.m[1], s < a ? F * (a - s) : 0, 1e-6 * F);
        assert_near(at.n[0], s < a ? F : 0, 1e-6 * F);
    }
    solution_free(x.solution);
}

/* Beyond the load the rod is straight; before it, it is a rod that ends there. Dead and follower,
 * force and moment, at levels that bend it far. */
static void test_free_part_is_straight(void **state)
{
    (void)state;
    const double length = 2, bending = 3, a = 1.3;
    for (int i = 0; i < 4; i++) {
        scene_frame frame = i % 2 ? SCENE_FOLLOWER : SCENE_DEAD;
        const double *force = i < 2 ? (double[]){9, 2, -4} : NULL;
        const double *moment = i < 2 ? NULL : (double[]){3, -2, 1};
        scene given = slender_scene(length, bending, 2), shorter = slender_scene(a, bending, 2);
        add_point(&given, a, frame, force, moment);
        load_tip(&shorter, force, moment);
        shorter.loads.tip.frame = frame;
        solved x = solve_rest_of(&given), y = solve_rest_of(&shorter);
        rod_values tip = values_at(&x, length, 0), end = values_at(&y, a, 0);
        double R[3][3];
        rotation_matrix(end.q, R);
        for (int k = 0; k < 3; k++) {
            assert_near(tip.r[k], end.r[k] + (length - a) * R[k][2], asked * length);
            assert_near(tip.q[k], end.q[k], asked);
        }
        solution_free(x.solution);
        solution_free(y.solution);
    }
}

/* Bisshopp and Drucker's elastica (Quart. Appl. Math. 3, 1945), P a^2/EI = 1: the end moves by
 * 0.3017207738 a across and 0.0564332363 a along (elliptic integrals to the digits given). */
static void test_elastica_within(void **state)
{
    (void)state;
    const double a = 0.4;
    scene given = slender_scene(1, 1, 1);
    add_point(&given, a, SCENE_DEAD, (double[]){1 / (a * a), 0, 0}, NULL);
    solved x = solve_rest_of(&given);
    rod_values at = values_at(&x, a, 0);
    assert_near(at.r[0], 0.3017207738 * a, 1e-10);
    assert_near(at.r[2], (1 - 0.0564332363) * a, 1e-10);
    solution_free(x.solution);
}

/* A rigid body at the tip is a load m g there. */
static void test_heavy_tip(void **state)
{
    (void)state;
    scene given = slender_scene(1.5, 3, 1), loaded = given;
    set_numbers(given.loads.gravity, 3, (double[]){9.81, 0, 0});
    loaded.loads = given.loads;
    add_body(&given, 1.5, 0.3, NULL);
    load_tip(&loaded, (double[]){0.3 * 9.81, 0, 0}, NULL);
    solved x = solve_rest_of(&given), y = solve_rest_of(&loaded);
    assert_vector(values_at(&x, 1.5, 0).r, values_at(&y, 1.5, 0).r, asked);
    assert_near(values_at(&x, 1.5, 0).n[0], values_at(&y, 1.5, 0).n[0], 1e-8);
    solution_free(x.solution);
    solution_free(y.solution);
}

/* As much as a scene may have, each at a place of its own, and a load at the tip. */
static void test_most(void **state)
{
    (void)state;
    static const double three[3] = {1, 2, 3};
    scene given = slender_scene(1, 1, 1);
    ad_error error = {.message = ""};
    solve_rod *rod = NULL;
    set_numbers(given.loads.gravity, 3, three);
    for (int i = 0; i < SCENE_POINTS_MAX; i++) {
        add_point(&given, (i + 0.2) / SCENE_POINTS_MAX, SCENE_DEAD, three, three);
    }
    for (int i = 0; i < SCENE_BODIES_MAX; i++) {
        add_body(&given, (i + 0.4) / SCENE_BODIES_MAX, 1, NULL);
    }
    for (int i = 0; i < SCENE_SPRINGS_MAX; i++) {
        add_spring(&given, (i + 0.6) / SCENE_SPRINGS_MAX, three, three);
    }
    load_tip(&given, three, three);
    assert_int_equal(solve_rod_create(&given, &rod, &error), AD_OK);
    assert_int_equal(rod->jumps.count, SCENE_POINTS_MAX + SCENE_BODIES_MAX + SCENE_SPRINGS_MAX + 1);
    assert_int_equal(rod->jumps.numbers,
                     6 * SCENE_POINTS_MAX + 3 * SCENE_BODIES_MAX + (9 + 7) * SCENE_SPRINGS_MAX + 6);
    solve_rod_free(rod);
}

/* ---- joints -------------------------------------------------------------------------------- */

/* A column with an arm: small loads at the end of the arm bend and, out of the plane, twist it. */
static void test_small_elbow(void **state)
{
    (void)state;
    const double a = 0.8, b = 0.5, bending = 3, torsion = 2, P = 1e-6;
    scene given = slender_scene(a + b, bending, torsion);
    add_segment(&given, a, NULL);
    add_segment(&given, b, (double[]){0, PI / 2, 0}); /* d3 from z to x */
    load_tip(&given, (double[]){0, P, -P}, NULL);
    solved x = solve_rest_of(&given);
    rod_values tip = values_at(&x, a + b, 0);
    assert_near(tip.r[0], b + P * b * a * a / (2 * bending), 1e-12);
    assert_near(tip.r[1], P * (a * a * a + b * b * b) / (3 * bending) + P * b * b * a / torsion,
                1e-12);
    assert_near(tip.r[2], a - P * (b * b * a + b * b * b / 3) / bending, 1e-12);
    solution_free(x.solution);
}

/* The planar elastica of the same shape by shooting: x_s = sin h, z_s = cos h, EI h_s = M,
 * M_s = Fz sin h - Fx cos h, h jumps by the turn; the moment at the base such that the tip has
 * none. Returns the moment at the tip. */
static double shoot(double moment, double a, double b, double turn, double EI, const double *F,
                    double *end)
{
    enum { STEPS = 4000 };
    double y[4] = {0, 0, 0, moment};
    for (int i = 0; i < 2 * STEPS; i++) {
        double h = (i < STEPS ? a : b) / STEPS, k[5][4] = {{0}};
        static const double part[4] = {0, 0.5, 0.5, 1};
        y[2] += i == STEPS ? turn : 0;
        for (int j = 0; j < 4; j++) { /* Runge and Kutta, order 4 */
            double z[4];
            for (int c = 0; c < 4; c++) {
                z[c] = y[c] + h * part[j] * k[j][c];
            }
            k[j + 1][0] = sin(z[2]);
            k[j + 1][1] = cos(z[2]);
            k[j + 1][2] = z[3] / EI;
            k[j + 1][3] = F[2] * sin(z[2]) - F[0] * cos(z[2]);
        }
        for (int c = 0; c < 4; c++) {
            y[c] += h * (k[1][c] + 2 * k[2][c] + 2 * k[3][c] + k[4][c]) / 6;
        }
    }
    memcpy(end, y, 3 * sizeof *end);
    return y[3];
}

static void test_large_elbow(void **state)
{
    (void)state;
    const double a = 0.8, b = 0.5, EI = 3, turn = 2.1, F[3] = {4, 0, -6};
    double end[3], low = -6, high = -1, at_low = shoot(low, a, b, turn, EI, F, end);
    for (int i = 0; i < 40 && fabs(high - low) > 1e-14; i++) { /* secant */
        double at_high = shoot(high, a, b, turn, EI, F, end);
        double next = high - at_high * (high - low) / (at_high - at_low);
        low = high;
        at_low = at_high;
        high = next;
        if (at_high == 0) {
            break;
        }
    }
    scene given = slender_scene(a + b, EI, 2);
    add_segment(&given, a, NULL);
    add_segment(&given, b, (double[]){0, turn, 0});
    load_tip(&given, F, NULL);
    solved x = solve_rest_of(&given);
    rod_values tip = values_at(&x, a + b, 0), base = values_at(&x, 0, 0);
    assert_near(tip.r[0], end[0], 1e-10); /* 4000 steps of order 4: below 1e-12 */
    assert_near(tip.r[2], end[1], 1e-10);
    assert_near(base.m[1], high, 1e-9);
    solution_free(x.solution);
}

/* Nothing loads it: it has the unloaded shape, also clamped at its other end. */
static void test_unloaded_elbow(void **state)
{
    (void)state;
    scene given = slender_scene(1, 1, 1);
    set_numbers(given.rod.rest_curvature, 3, (double[]){0.4, 0, 0.3});
    add_segment(&given, 0.4, NULL);
    add_segment(&given, 0.25, (double[]){0, PI / 2, 0});
    add_segment(&given, 0.35, (double[]){0.3, -0.2, 1});
    solved x = solve_rest_of(&given);
    rod_values tip = values_at(&x, 1, 0);
    scene turned = given;
    turned.start = (scene_end){.type = SCENE_FREE};
    turned.end = (scene_end){.type = SCENE_CLAMPED};
    set_numbers(turned.end.position, 3, tip.r);
    set_numbers(turned.end.rotation, 4, tip.q);
    solved y = solve_rest_of(&turned);
    for (double s = 0; s <= 1; s += 0.125) {
        assert_vector(values_at(&x, s, 0).r, values_at(&y, s, 0).r, 1e-12);
        assert_vector(values_at(&x, s, 0).m, (double[]){0, 0, 0}, 1e-11);
    }
    assert_vector(values_at(&y, 0, 0).r, (double[]){0, 0, 0}, 1e-12);
    solution_free(x.solution);
    solution_free(y.solution);
}

/* ---- springs ------------------------------------------------------------------------------- */

/* w = F/(3EI/L^3 + k) at the tip; a spring within shares the load as the beam's influence says. */
static void test_cantilever_on_spring(void **state)
{
    (void)state;
    const double L = 2, EI = 3, F = 1e-6, k = 5, a = 1.2;
    scene given = slender_scene(L, EI, 1);
    load_tip(&given, (double[]){F, 0, 0}, NULL);
    add_spring(&given, L, (double[]){k, 0, 0}, NULL);
    solved x = solve_rest_of(&given);
    assert_near(values_at(&x, L, 0).r[0], F / (3 * EI / (L * L * L) + k), 1e-12);
    solution_free(x.solution);

    given.springs[0].at = Q(a);
    x = solve_rest_of(&given);
    double by_tip = a * a * (3 * L - a) / (6 * EI), by_spring = a * a * a / (3 * EI);
    assert_near(values_at(&x, a, 0).r[0], F * by_tip / (1 + k * by_spring), 1e-12);
    solution_free(x.solution);
}

/* A pinned rod on a spring that turns: M/k, whatever the angle; the rod bends beyond it. */
static void test_turning_spring(void **state)
{
    (void)state;
    const double k = 0.7, M = 1.5, EI = 3;
    scene given = slender_scene(1, EI, 1);
    given.start.type = SCENE_PINNED;
    given.start.rotation[0] = Q(NULL);
    load_tip(&given, NULL, (double[]){0, M, 0});
    add_spring(&given, 0, NULL, (double[]){k, k, k});
    solved x = solve_rest_of(&given);
    rod_values base = values_at(&x, 0, 0), tip = values_at(&x, 1, 0);
    assert_near(2 * atan2(base.q[2], base.q[0]), M / k, 1e-10); /* 123 degrees */
    assert_near(2 * atan2(tip.q[2], tip.q[0]), M / k + M / EI, 1e-10);
    solution_free(x.solution);
}

/* Held by two springs alone, a weight in the middle: F/2k + F L^3/48EI. */
static void test_held_by_springs(void **state)
{
    (void)state;
    const double L = 2, EI = 3, F = 1e-6, k = 5;
    scene given = slender_scene(L, EI, 1);
    given.start = (scene_end){.type = SCENE_FREE};
    for (int i = 0; i < 2; i++) {
        add_spring(&given, i * L, (double[]){k, k, i == 0 ? k : 0},
                   i == 0 ? (double[]){0, 0, 1e-3} : NULL);
    }
    add_point(&given, L / 2, SCENE_DEAD, (double[]){F, 0, 0}, NULL);
    solved x = solve_rest_of(&given);
    assert_near(values_at(&x, L / 2, 0).r[0], F / (2 * k) + F * L * L * L / (48 * EI), 1e-12);
    assert_near(values_at(&x, 0, 0).r[0], F / (2 * k), 1e-12);
    assert_near(values_at(&x, L, 0).r[0], F / (2 * k), 1e-12);
    solve_energy energy;
    assert_int_equal(solution_energy(x.solution, 0, &energy, NULL), AD_OK);
    double work = F * (F / (2 * k) + F * L * L * L / (48 * EI));
    assert_near(energy.work, work, 1e-6 * work);
    assert_near(energy.strain, work / 2, 1e-6 * work); /* a linear system */
    solution_free(x.solution);
}

/* A spring pulls the tip to its anchor: a stiff one almost there. */
static void test_anchor(void **state)
{
    (void)state;
    const double k = 1e3, anchor[3] = {0.5, 0.2, 0.7};
    scene given = slender_scene(1, 3, 1);
    set_numbers(add_spring(&given, 1, (double[]){k, k, k}, NULL)->anchor, 3, anchor);
    solved x = solve_rest_of(&given);
    rod_values tip = values_at(&x, 1, 0);
    double R[3][3], force[3];
    rotation_matrix(tip.q, R);
    to_world(R, tip.n, force);
    for (int i = 0; i < 3; i++) {
        assert_near(force[i], -k * (tip.r[i] - anchor[i]), 1e-7);
    }
    assert_vector(tip.r, anchor, 0.05);
    solution_free(x.solution);
}

/* The moment of a spring of the energy 1/2 sum_i k_i phi_i^2, in the body, phi from upright to q:
 * -(d phi/d eta)^T k phi with d phi/d eta = 1 + phi^/2 + c phi^ phi^, c = (1 - b cot b)/|phi|^2, b
 * = |phi|/2 (Bullo, Murray 1995). */
static void turning_moment(const double k[3], const double upright[4], const double q[4],
                           double moment[3])
{
    double p[4], phi[3], pull[3], once[3], again[3];
    quaternion_quotient(upright, q, p);
    const double size = sqrt(vector_dot(p + 1, p + 1)), b = atan2(size, p[0]);
    const double c = b > 1e-3 ? (1 - b / tan(b)) / (4 * b * b) : 1.0 / 12;
    for (int i = 0; i < 3; i++) {
        phi[i] = size > 0 ? 2 * b * p[1 + i] / size : 0;
        pull[i] = k[i] * phi[i];
    }
    vector_cross(phi, pull, once);
    vector_cross(phi, once, again);
    for (int i = 0; i < 3; i++) {
        moment[i] = -(pull[i] - 0.5 * once[i] + c * again[i]);
    }
}

/* On the tape it is that, for unequal turnings up to angles beyond half a turn; 1e-12 of an angle
 * that is a difference of rounded numbers. */
static void test_spring_law(void **state)
{
    (void)state;
    static const double turning[3] = {1.3, 0.4, 2.2}, upright[4] = {1};
    scene given = slender_scene(1, 1, 1);
    add_spring(&given, 1, NULL, turning);
    ad_tape *tape = ad_tape_create();
    ad_value s = ad_input(tape, "s", 1), q = ad_input(tape, "q", 4);
    const domain_place place = rod_place(&given, s, s);
    const rod_context rod = rod_context_of(&given, &place);
    rod_acting acts[ROD_AT_PLACES_MAX];
    assert_int_equal(rod_acting_at_places(&rod, acts), 1);
    const ad_value none = ad_zeros(tape, 3);
    ad_value moment = rod_acting_wrench(&rod, acts, (rod_pose){none, q}, none).moment;
    for (double angle = 1e-9; angle < 5.5; angle = angle < 0.1 ? 10 * angle : angle + 0.6) {
        const double axis[3] = {0.48, -0.6, 0.64};
        double at[4] = {cos(angle / 2)}, closed[3], on_tape[3];
        for (int i = 0; i < 3; i++) {
            at[1 + i] = sin(angle / 2) * axis[i];
        }
        turning_moment(turning, upright, at, closed);
        const double *inputs[2] = {&angle, at};
        evaluate(1, &moment, 1, inputs, NULL, (double *[]){on_tape});
        for (int i = 0; i < 3; i++) {
            assert_near(on_tape[i], closed[i] / rod.scales.moment, 1e-12 * (1 + angle));
        }
    }
    ad_tape_free(tape);
}

/* ---- whole rods ---------------------------------------------------------------------------- */

/* out += a x b */
static void add_cross(const double *a, const double *b, double *out)
{
    double c[3];
    vector_cross(a, b, c);
    for (int i = 0; i < 3; i++) {
        out[i] += c[i];
    }
}

static void random_vector(uint64_t *random, double size, double *to)
{
    for (int i = 0; i < 3; i++) {
        to[i] = random_in(random, -size, size);
    }
}

/* Shearable, curved, with up to three of everything, two of them at the same place. */
static scene random_scene(uint64_t *random)
{
    const double L = random_in(random, 0.5, 2);
    double kse[3], kbt[3], inertia[3] = {1, 1, 1}, a[3], b[3];
    for (int i = 0; i < 3; i++) {
        kse[i] = random_in(random, 100, 300);
        kbt[i] = random_in(random, 1, 3);
    }
    scene given = stiff_scene(L, kse, kbt, 1, inertia);
    given.duration = Q(NULL);
    set_numbers(given.start.position, 3, (double[]){0, 0, 0});
    set_numbers(given.start.rotation, 4, (double[]){0.5, 0.5, -0.5, 0.5});
    random_vector(random, 0.5, a);
    set_numbers(given.rod.rest_curvature, 3, a);
    random_vector(random, 1, a);
    set_numbers(given.loads.gravity, 3, a);
    double joint = L * random_in(random, 0.2, 0.8);
    random_vector(random, 1.5, a);
    add_segment(&given, joint, NULL);
    add_segment(&given, L - joint, a);
    for (int i = 0; i < 3; i++) {
        random_vector(random, 1, a);
        random_vector(random, 0.5, b);
        scene_frame frame = random_in(random, 0, 1) < 0.5 ? SCENE_DEAD : SCENE_FOLLOWER;
        add_point(&given, i == 2 ? joint : L * random_in(random, 0.05, 0.95), frame, a, b);
    }
    add_body(&given, random_in(random, 0, 1) < 0.5 ? L : 0.5 * joint, 1, NULL);
    for (int i = 0; i < 3; i++) {
        a[i] = random_in(random, 0, 3);
        b[i] = random_in(random, 0, 1);
    }
    add_spring(&given, random_in(random, 0, 1) < 0.5 ? L : given.points[0].at.number, a, b);
    random_vector(random, 0.3, b);
    add_spring(&given, 0.3 * L, a, NULL);
    set_numbers(given.springs[1].anchor, 3, b);
    return given;
}

/* What springs, points and bodies, gravity and the clamp do to the rod adds up to nothing: force,
 * and moment about the clamp. */
static void check_balance(const scene *given)
{
    solved x = solve_rest_of(given);
    double force[3] = {0}, moment[3] = {0}, R[3][3], world[3], size = 1;
    const double L = scene_length(given), none[3] = {0};
    rod_values base = values_at(&x, 0, 0);
    rotation_matrix(base.q, R);
    to_world(R, base.n, force); /* the clamp exerts -N(0), -M(0) */
    to_world(R, base.m, moment);
    for (int i = 0; i < 3; i++) {
        force[i] = -force[i];
        moment[i] = -moment[i];
        size += fabs(force[i]) + fabs(moment[i]);
    }
    for (int k = 0; k < given->point_count + given->body_count + given->spring_count; k++) {
        int b = k - given->point_count, c = b - given->body_count;
        double at = b < 0   ? given->points[k].at.number
                    : c < 0 ? given->bodies[b].at.number
                            : given->springs[c].at.number;
        rod_values here = values_at(&x, at, 0);
        double pull[3] = {0}, turn[3] = {0};
        rotation_matrix(here.q, R);
        for (int i = 0; i < 3; i++) {
            if (b < 0) {
                pull[i] = given->points[k].load.force[i].number;
                turn[i] = given->points[k].load.moment[i].number;
            } else if (c < 0) {
                pull[i] = given->bodies[b].mass.number * given->loads.gravity[i].number;
            }
        }
        if (b < 0 && given->points[k].load.frame == SCENE_FOLLOWER) {
            to_world(R, pull, world);
            memcpy(pull, world, sizeof world);
            to_world(R, turn, world);
            memcpy(turn, world, sizeof world);
        }
        if (c >= 0) {
            const scene_spring *spring = &given->springs[c];
            double turning[3];
            scene unloaded = *given; /* where springs are not pulled */
            unloaded.point_count = unloaded.body_count = unloaded.spring_count = 0;
            set_numbers(unloaded.loads.gravity, 3, none);
            solved y = solve_rest_of(&unloaded);
            rod_values rest = values_at(&y, at, 0);
            for (int i = 0; i < 3; i++) {
                double anchor = spring->anchor[i].is_given ? spring->anchor[i].number : rest.r[i];
                pull[i] = -spring->stiffness[i].number * (here.r[i] - anchor);
                turning[i] = spring->turning[i].number;
            }
            turning_moment(turning, rest.q, here.q, world);
            to_world(R, world, turn);
            solution_free(y.solution);
        }
        add_cross(here.r, pull, moment);
        for (int i = 0; i < 3; i++) {
            force[i] += pull[i];
            moment[i] += turn[i];
        }
    }
    enum { SLICES = 400 }; /* the weight of the rod, by Simpson's rule between joint and ends */
    double weight[3], joint = given->segments[0].length.number;
    for (int i = 0; i < 3; i++) {
        weight[i] = given->rod.mass_per_length.number * given->loads.gravity[i].number;
        force[i] += L * weight[i];
    }
    for (int piece = 0; piece < 2; piece++) {
        double from = piece ? joint : 0, to = piece ? L : joint;
        for (int k = 0; k <= SLICES; k++) {
            double part = (k == 0 || k == SLICES ? 1 : k % 2 ? 4 : 2) / (3.0 * SLICES);
            rod_values here = values_at(&x, from + (to - from) * k / SLICES, 0);
            const double pull[3] = {part * (to - from) * weight[0], part * (to - from) * weight[1],
                                    part * (to - from) * weight[2]};
            add_cross(here.r, pull, moment);
        }
    }
    assert_vector(force, none, 1e-9 * size);
    assert_vector(moment, none, 2e-8 * size); /* of Simpson's rule across kinks of curvature */
    solution_free(x.solution);
}

static void test_balance(void **state)
{
    (void)state;
    uint64_t random = 7;
    for (int i = 0; i < 8; i++) {
        scene given = random_scene(&random);
        check_balance(&given);
    }
}

/* ---- memory -------------------------------------------------------------------------------- */

/* A rod and a beam, at rest and in motion. */
static void test_no_memory(void **state)
{
    (void)state;
    const double t = 0.01;
    uint64_t random = 3;
    for (int i = 0; i < 4; i++) {
        scene given = random_scene(&random);
        solve_settings settings = {.tolerance = 1, .nodes = 9};
        if (i % 2) {
            given.duration = Q(t);
        }
        if (i > 1) {
            given.rod.model = SCENE_TIMOSHENKO;
        }
        check_no_memory(&given, &settings, 1, &t, 60, 17);
    }
}

/* Springs pull to where the unstressed rod is, however narrow its bends are: there they are slack.
 */
static void test_slack_beyond_bends(void **state)
{
    (void)state;
    static const char *const bends[] = {"200*(1-tanh((s-0.31)/0.004)^2)",
                                        "90*exp(-((s-0.57)/0.008)^2)",
                                        "300*max(0, 1-abs(s-0.42)/0.005)"};
    const double k[3] = {5, 3, 4}, turning[3] = {2, 1, 3};
    scene given = slender_scene(1, 1, 1);
    set_quantities(given.rod.rest_curvature, 3, bends);
    add_spring(&given, 1, k, turning);
    add_spring(&given, 0.6, k, NULL);
    solved x = solve_rest_of(&given);
    for (double s = 0; s < 1; s += 0.11) {
        rod_values at = values_at(&x, s, 0);
        for (int i = 0; i < 3; i++) {
            assert_near(at.n[i], 0, 1e-10);
            assert_near(at.m[i], 0, 1e-10);
        }
    }
    solution_free(x.solution);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_slack_beyond_bends),
        cmocka_unit_test(test_cantilever_with_point),
        cmocka_unit_test(test_free_part_is_straight),
        cmocka_unit_test(test_elastica_within),
        cmocka_unit_test(test_heavy_tip),
        cmocka_unit_test(test_most),
        cmocka_unit_test(test_small_elbow),
        cmocka_unit_test(test_large_elbow),
        cmocka_unit_test(test_unloaded_elbow),
        cmocka_unit_test(test_cantilever_on_spring),
        cmocka_unit_test(test_turning_spring),
        cmocka_unit_test(test_held_by_springs),
        cmocka_unit_test(test_anchor),
        cmocka_unit_test(test_spring_law),
        cmocka_unit_test(test_balance),
        cmocka_unit_test(test_no_memory),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
