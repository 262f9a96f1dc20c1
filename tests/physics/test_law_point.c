/* The laws at a point: the C that is written from them against their tape, in numbers and in lanes;
 * their derivatives against differences, forces against energies and closed forms; their use with
 * values of another tape. */
#include "physics/law/law.h"
#include "physics/law/law_numbers.h"
#include "physics/law/laws_lanes.h"
#include "physics/local/acting.h"
#include "physics/local/acting_lanes.h"

#include "fewer.h"
#include "near.h"
#include "random_numbers.h"

#include "physics/numerics/quaternion.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

enum { OUTPUTS_MAX = 1 + LAW_WRENCH + LAW_BY_MOTION, TRIES = 200 };

#define MOVING(x) (x), (x) + 3, (x) + 6, (x) + 9, (x) + LAW_MOVING

/* Energy, wrench and derivatives of what is given, as C has them. */
static void in_numbers(law_name name, const double *x, double *out)
{
    double *wrench = out + 1, *by = wrench + LAW_WRENCH;
    memset(out, 0, OUTPUTS_MAX * sizeof *out);
    if (name < LAW_ACTUATORS) {
        number_law_actuator_energy((int)name, x, x + 3, x + 6, out);
        number_law_actuator((int)name, x, x + 3, x + 6, wrench, by);
    } else if (name == LAW_UNIT) {
        number_law_unit_energy(x, x + 3, x + 6, out);
        number_law_unit(x, x + 3, x + 6, wrench, by);
    } else if (name == LAW_ROUND_UNIT) {
        number_law_round_unit_energy(x, x + 3, x + 6, out);
        number_law_round_unit(x, x + 3, x + 6, wrench, by);
    } else if (name == LAW_TUBE) {
        number_law_tube_energy(x, x + 3, x + 6, out);
        number_law_tube(x, x + 3, x + 6, wrench, by);
    } else if (name == LAW_ELASTIC) {
        number_law_elastic_energy(x, x + 3, x + 6, out);
        number_law_elastic(x, x + 3, x + 6, wrench, by);
    } else if (name == LAW_DAMPING) {
        number_law_damping_energy(x, x + 3, x + 6, out);
        number_law_damping(x, x + 3, x + 6, wrench, by);
    } else if (name == LAW_FRICTION) {
        number_law_friction_energy(x, x + 3, x + 6, out);
        number_law_friction(x, x + 3, x + 6, wrench, by);
    } else if (name == LAW_ROTARY_INERTIA) {
        number_law_rotary_inertia_energy(MOVING(x), out);
        number_law_rotary_inertia(MOVING(x), wrench, by);
    } else if (name == LAW_ECCENTRICITY) {
        number_law_eccentricity_energy(MOVING(x), out);
        number_law_eccentricity(MOVING(x), wrench, by);
    } else if (name == LAW_ADDED_MASS) {
        number_law_added_mass_energy(MOVING(x), out);
        number_law_added_mass(MOVING(x), wrench, by);
    } else {
        double again[LAW_WRENCH] = {0};
        number_law_outside_energy(name, x, x + 3, x + 7, x + LAW_STATE, out);
        number_law_outside(name, x, x + 3, x + 7, x + LAW_STATE, wrench, by);
        number_law_outside_wrench(name, x, x + 3, x + 7, x + LAW_STATE, again);
        for (int i = 0; i < LAW_WRENCH; i++) {
            assert_near(again[i], wrench[i], 1e-13);
        }
    }
}

/* Wrench and derivatives. */
FOR_EACH_PROCESSOR static void in_lanes(law_name name, const lanes *x, lanes *out)
{
    memset(out, 0, OUTPUTS_MAX * sizeof *out);
    if (name < LAW_ACTUATORS) {
        lanes_law_actuator((int)name, x, x + 3, x + 6, out + 1, out + 1 + LAW_WRENCH);
    } else if (name == LAW_UNIT) {
        lanes_law_unit(x, x + 3, x + 6, out + 1, out + 1 + LAW_WRENCH);
    } else if (name == LAW_ROUND_UNIT) {
        lanes_law_round_unit(x, x + 3, x + 6, out + 1, out + 1 + LAW_WRENCH);
    } else if (name == LAW_TUBE) {
        lanes_law_tube(x, x + 3, x + 6, out + 1, out + 1 + LAW_WRENCH);
    } else if (name == LAW_ELASTIC) {
        lanes_law_elastic(x, x + 3, x + 6, out + 1, out + 1 + LAW_WRENCH);
    } else if (name == LAW_DAMPING) {
        lanes_law_damping(x, x + 3, x + 6, out + 1, out + 1 + LAW_WRENCH);
    } else if (name == LAW_FRICTION) {
        lanes_law_friction(x, x + 3, x + 6, out + 1, out + 1 + LAW_WRENCH);
    } else if (name == LAW_ROTARY_INERTIA) {
        lanes_law_rotary_inertia(MOVING(x), out + 1, out + 1 + LAW_WRENCH);
    } else if (name == LAW_ECCENTRICITY) {
        lanes_law_eccentricity(MOVING(x), out + 1, out + 1 + LAW_WRENCH);
    } else if (name == LAW_ADDED_MASS) {
        lanes_law_added_mass(MOVING(x), out + 1, out + 1 + LAW_WRENCH);
    } else {
        lanes_law_outside(name, x, x + 3, x + 7, x + LAW_STATE, out + 1, out + 1 + LAW_WRENCH);
    }
}

static bool of_strains(law_name name)
{
    return law_table[name].state == LAW_WITHIN || law_table[name].state == LAW_TURNED;
}

/* A section that is about straight, or a unit rotation; and whatever else it is given. Angles from
 * an upright rotation are beyond half a turn, and no whole one. */
static void draw(uint64_t *from, law_name name, double *given)
{
    for (int i = 0; i < law_given(name); i++) {
        given[i] = random_in(from, -1, 1);
    }
    given[2] += of_strains(name) ? 3 : 0; /* p' is not 0 */
    if (name == LAW_TUBE) {
        const double theta = given[3];
        given[3] = cos(theta);
        given[4] = sin(theta);
    }
    if (name == LAW_FRICTION) { /* which is a jump without a speed of creep */
        given[7] += 2;
    }
    if (law_table[name].state == LAW_OUTSIDE) {
        quaternion_normalize(given + 3);
    }
    if (name == LAW_SLENDER_DRAG) { /* its power 1.5 has no second derivative at a part of 0 */
        const double velocity[3] = {0.5, 0.3, given[9] < 0 ? -0.4 : 0.4};
        double R[3][3];
        rotation_matrix(given + 3, R);
        to_world(R, velocity, given + 7);
    }
    if (name == LAW_TURNING_SPRING) {
        const double angle = random_in(from, 0, 4), *axis = given;
        const double by = sin(angle / 2) / sqrt(vector_dot(axis, axis));
        const double turn[4] = {cos(angle / 2), -by * axis[0], -by * axis[1], -by * axis[2]};
        quaternion_product(given + 3, turn, given + LAW_STATE + 3);
    }
}

/* Outputs of a law on its tape, one after the other: energy, wrench, derivatives. */
static int outputs_of(law_name name, const law_formula *x, ad_value *outputs)
{
    int count = 0;
    outputs[count++] = x->energy;
    for (int i = 0; i < LAW_WRENCH; i++) {
        outputs[count++] = x->wrench[i];
    }
    for (int i = 0; i < law_derivatives(name); i++) {
        outputs[count++] = x->by[i];
    }
    return count;
}

/* Values of outputs of a tape with so many scalar inputs at one point. */
static void evaluate(int count, const ad_value *outputs, int inputs, const double *given,
                     double *values)
{
    ad_error error;
    ad_program *program = NULL;
    ad_pool *pool = ad_pool_create(1);
    const double *input[LAW_GIVEN_MAX];
    double *output[OUTPUTS_MAX];
    for (int i = 0; i < inputs; i++) {
        input[i] = &given[i];
    }
    for (int i = 0; i < count; i++) {
        output[i] = &values[i];
    }
    const ad_run run = {.points = 1, .inputs = input, .outputs = output};
    if (!pool || ad_compile(count, outputs, NULL, pool, &program, &error) != AD_OK ||
        ad_execute(program, &run, &error) != AD_OK) {
        fail_msg("%s", error.message);
    }
    ad_program_free(program);
    ad_pool_free(pool);
}

/* What is written is what is recorded, to rounding of some sums of numbers of about 10, or of 100
 * in derivatives of a spring that has turned by most of a turn. */
static void test_written(void **state)
{
    (void)state;
    static const double rounding = 1e-13;
    uint64_t from = 7;
    for (law_name l = 0; l < LAW_COUNT; l++) {
        law_formula x = law_formula_create(l);
        ad_value outputs[OUTPUTS_MAX];
        const int count = outputs_of(l, &x, outputs);
        for (int k = 0; k < TRIES; k++) {
            double given[LAW_GIVEN_MAX], values[OUTPUTS_MAX], got[OUTPUTS_MAX];
            lanes side[LAW_GIVEN_MAX], beside[OUTPUTS_MAX];
            draw(&from, l, given);
            for (int i = 0; i < law_given(l); i++) {
                side[i] = (lanes){0} + given[i];
            }
            evaluate(count, outputs, law_given(l), given, values);
            in_numbers(l, given, got);
            in_lanes(l, side, beside);
            for (int i = 0; i < count; i++) {
                const double size = fmax(1, fabs(values[i]));
                assert_near(got[i], values[i], rounding * size);
                assert_near(i > 0 ? beside[i][k % LANES] : values[0], values[i], rounding * size);
            }
        }
        law_formula_free(&x);
    }
}

/* given, with its i-th variable moved by h: a number of the state; of a law outside 3 .. 5 are
 * turns in the world; of a tube u, theta, m and nothing. */
static void move(law_name name, int i, double h, const double *given, double *moved)
{
    memcpy(moved, given, LAW_GIVEN_MAX * sizeof *moved);
    if (name == LAW_TUBE && i >= 3) {
        moved[3] = i == 3 ? cos(h) * given[3] - sin(h) * given[4] : given[3];
        moved[4] = i == 3 ? cos(h) * given[4] + sin(h) * given[3] : given[4];
        moved[5] += i == 4 ? h : 0;
    } else if (law_table[name].state != LAW_OUTSIDE || i < 3) {
        moved[i] += h;
    } else if (i > 5) {
        moved[i + 1] += h;
    } else {
        double turn[4] = {cos(h / 2)};
        turn[1 + i - 3] = sin(h / 2);
        quaternion_product(turn, given + 3, moved + 3);
    }
}

/* Central differences with h = 1e-5: h^2 and rounding over h are below 1e-9 of numbers of about 1,
 * and 1e-7 near a whole turn, where derivatives are large. The force of an energy is minus what
 * that changes by; within the rod it is the change itself. */
static void test_derivatives(void **state)
{
    (void)state;
    static const double h = 1e-5, close = 1e-8;
    uint64_t from = 11;
    for (law_name l = 0; l < LAW_COUNT; l++) {
        const law *of = &law_table[l];
        const bool within = of_strains(l), motion = law_table[l].state == LAW_OF_MOTION;
        for (int k = 0; k < TRIES; k++) {
            double given[LAW_GIVEN_MAX], at[OUTPUTS_MAX], beside[2][OUTPUTS_MAX];
            draw(&from, l, given);
            in_numbers(l, given, at);
            for (int j = 0; j < (within ? 6 : motion ? 12 : 9); j++) {
                for (int side = 0; side < 2; side++) {
                    double moved[LAW_GIVEN_MAX];
                    move(l, j, side ? h : -h, given, moved);
                    in_numbers(l, moved, beside[side]);
                }
                const double by_energy = (beside[1][0] - beside[0][0]) / (2 * h);
                if (of->has_energy && j < 6 && !motion) {
                    assert_near(within ? by_energy : -by_energy, at[1 + j], close);
                }
                for (int i = 0; i < 6; i++) {
                    const double change = (beside[1][1 + i] - beside[0][1 + i]) / (2 * h);
                    const double got =
                        at[7 + (within ? law_entry(i, j) : (j / 3 * 6 + i) * 3 + j % 3)];
                    assert_near(got, change, close * fmax(1, fabs(change)));
                }
            }
        }
    }
}

/* What the table says of a law: what it depends on, and what it gives. */
static void test_table(void **state)
{
    (void)state;
    uint64_t from = 17;
    for (law_name l = 0; l < LAW_COUNT; l++) {
        if (!of_strains(l)) {
            continue;
        }
        double given[LAW_GIVEN_MAX], at[OUTPUTS_MAX], apart = 0;
        draw(&from, l, given);
        in_numbers(l, given, at);
        for (int i = 0; i < LAW_WRENCH; i++) {
            for (int j = i + 1; j < LAW_WRENCH; j++) {
                apart += fabs(at[7 + law_entry(i, j)]);
            }
        }
        assert_int_equal(apart > 0, law_table[l].couples);
    }
    for (law_name l = 0; l < LAW_COUNT; l++) {
        if (law_table[l].state != LAW_OUTSIDE) {
            continue;
        }
        const law *of = &law_table[l];
        const bool depends[3] = {of->by_position, of->by_rotation, of->by_velocity};
        double given[LAW_GIVEN_MAX], at[OUTPUTS_MAX], sums[5] = {0}, moved = 0;
        draw(&from, l, given);
        for (int i = LAW_STATE; i < law_given(l) && of->kind == LAW_DISSIPATES; i++) {
            given[i] = fabs(given[i]);
        }
        in_numbers(l, given, at);
        for (int i = 0; i < LAW_WRENCH; i++) {
            sums[i / 3] += fabs(at[1 + i]);
        }
        for (int i = 0; i < LAW_BY; i++) {
            sums[2 + i / 18] += fabs(at[7 + i]);
        }
        for (int i = 0; i < 9; i++) {
            moved += fabs(at[7 + i]);
        }
        assert_int_equal(moved > 0, law_force_by_position(of));
        assert_int_equal(sums[0] > 0, of->has_force);
        assert_int_equal(sums[1] > 0, of->has_moment);
        for (int i = 0; i < 3; i++) {
            assert_int_equal(sums[2 + i] > 0, depends[i]);
        }
        if (of->kind == LAW_DISSIPATES) { /* a force, which solvers of motion split off */
            assert_true(vector_dot(at + 1, given + 7) < 0 && !of->has_moment && !of->has_energy);
        }
        assert_true(of->kind != LAW_STORES || of->has_energy);
    }
}

/* The section of a path: R of a turn by angles that depend on t, r; and what moves, in the world.
 */
static void path_at(double t, double R[3][3], double r[3])
{
    double q[4] = {1, sin(t), 0.5 * t * t, 0.3 * cos(2 * t)};
    quaternion_normalize(q);
    rotation_matrix(q, R);
    r[0] = cos(t);
    r[1] = 0.4 * sin(2 * t);
    r[2] = t * t * t;
}

/* Central differences of the path: V, w and the rates A, w_t of both, body frame. */
static void motion_at(double t, double *motion)
{
    static const double h = 1e-3;
    double R[5][3][3], r[5][3], world[4][3] = {{0}}, spin[3][3];
    for (int k = 0; k < 5; k++) {
        path_at(t + (k - 2) * h, R[k], r[k]);
    }
    for (int k = 1; k < 4; k++) { /* of R' R^T */
        for (int i = 0; i < 3; i++) {
            const int a = (i + 2) % 3, b = (i + 1) % 3;
            double rate = 0;
            for (int c = 0; c < 3; c++) {
                rate += (R[k + 1][a][c] - R[k - 1][a][c]) / (2 * h) * R[k][b][c];
            }
            spin[k - 1][i] = rate;
        }
    }
    for (int i = 0; i < 3; i++) {
        world[0][i] = (r[3][i] - r[1][i]) / (2 * h);
        world[1][i] = spin[1][i];
        world[2][i] = (r[3][i] - 2 * r[2][i] + r[1][i]) / (h * h);
        world[3][i] = (spin[2][i] - spin[0][i]) / (2 * h);
    }
    for (int k = 0; k < 4; k++) {
        to_body(R[2], world[k], motion + 3 * k);
    }
}

/* Momentum and moment of momentum about the origin, world, of a body with the momenta P and L of a
 * law of motion: those that its energy has, which is homogeneous of degree 2. */
static void momenta_at(law_name name, double t, const double *numbers, double momenta[6])
{
    static const double h = 1e-4;
    double given[LAW_GIVEN_MAX] = {0}, R[3][3], r[3], body[6], arm[3];
    path_at(t, R, r);
    motion_at(t, given);
    memcpy(given + LAW_MOVING, numbers, 3 * sizeof *numbers);
    for (int i = 0; i < 6; i++) {
        double beside[2][OUTPUTS_MAX], kept = given[i];
        for (int side = 0; side < 2; side++) {
            given[i] = kept + (side ? h : -h);
            in_numbers(name, given, beside[side]);
        }
        given[i] = kept;
        body[i] = (beside[1][0] - beside[0][0]) / (2 * h);
    }
    to_world(R, body, momenta);
    to_world(R, body + 3, momenta + 3);
    vector_cross(r, momenta, arm);
    for (int i = 0; i < 3; i++) {
        momenta[3 + i] += arm[i];
    }
}

/* Laws of motion: what they give is what the momenta about a fixed place change by, in the world,
 * whatever the path. Differences with h = 1e-3 leave about h^2 of numbers of 1
 * to 30. */
static void test_momenta(void **state)
{
    (void)state;
    static const double h = 1e-3, numbers[3] = {0.7, 0.4, 1.1};
    for (law_name l = 0; l < LAW_COUNT; l++) {
        if (law_table[l].state != LAW_OF_MOTION) {
            continue;
        }
        for (int k = 0; k < 10; k++) {
            const double t = 0.1 + 0.2 * k;
            double given[LAW_GIVEN_MAX] = {0}, out[OUTPUTS_MAX], R[3][3], r[3], at[2][6];
            double wrench[6], arm[3];
            path_at(t, R, r);
            motion_at(t, given);
            memcpy(given + LAW_MOVING, numbers, sizeof numbers);
            in_numbers(l, given, out);
            to_world(R, out + 1, wrench);
            to_world(R, out + 4, wrench + 3);
            vector_cross(r, wrench, arm);
            momenta_at(l, t - h, numbers, at[0]);
            momenta_at(l, t + h, numbers, at[1]);
            for (int i = 0; i < 6; i++) {
                const double rate = (at[1][i] - at[0][i]) / (2 * h);
                assert_near(wrench[i] + (i < 3 ? 0 : arm[i - 3]), -rate,
                            1e-5 * fmax(10, fabs(rate)));
            }
        }
    }
}

/* On a tape of its own rows: three points side by side are three points. */
static void test_called(void **state)
{
    (void)state;
    enum { POINTS = 3 };
    uint64_t from = 13;
    for (law_name l = 0; l < LAW_COUNT; l++) {
        ad_tape *tape = ad_tape_create();
        double given[POINTS][LAW_GIVEN_MAX], columns[LAW_GIVEN_MAX][POINTS];
        ad_value constants[LAW_GIVEN_MAX], energy, wrench[LAW_WRENCH], by[LAW_BY_MOTION];
        for (int p = 0; p < POINTS; p++) {
            draw(&from, l, given[p]);
        }
        for (int i = 0; i < law_given(l); i++) {
            for (int p = 0; p < POINTS; p++) {
                columns[i][p] = given[p][i];
            }
            constants[i] = ad_constant(tape, POINTS, columns[i]);
        }
        law_record(l, tape, constants, &energy, wrench, by);
        assert_int_equal(ad_tape_status(tape, NULL), AD_OK);
        for (int p = 0; p < POINTS; p++) {
            double got[OUTPUTS_MAX], out[LAW_WRENCH][POINTS];
            double *output[LAW_WRENCH];
            in_numbers(l, given[p], got);
            ad_error error;
            ad_program *program = NULL;
            ad_pool *pool = ad_pool_create(1);
            for (int i = 0; i < LAW_WRENCH; i++) {
                output[i] = out[i];
                wrench[i] = ad_rows(wrench[i]) == 1 ? ad_repeat(wrench[i], POINTS) : wrench[i];
            }
            const ad_run run = {.points = 1, .outputs = output};
            if (ad_compile(LAW_WRENCH, wrench, NULL, pool, &program, &error) != AD_OK ||
                ad_execute(program, &run, &error) != AD_OK) {
                fail_msg("%s", error.message);
            }
            for (int i = 0; i < LAW_WRENCH; i++) {
                assert_near(out[i][p], got[1 + i], 1e-13 * fmax(1, fabs(got[1 + i])));
            }
            ad_program_free(program);
            ad_pool_free(pool);
        }
        ad_tape_free(tape);
    }
}

/* Nothing moves, nothing resists, and derivatives are finite. */
static void test_at_rest(void **state)
{
    (void)state;
    const double none[4] = {0}, coefficients[2] = {0.5, 2};
    double wrench[6] = {0}, by[LAW_BY] = {0};
    number_law_resistance(none, none, none, coefficients, wrench, by);
    for (int i = 0; i < 9; i++) {
        assert_near(by[36 + i], i % 4 == 0 ? -0.5 : 0, 0);
        assert_near(wrench[i % 6], 0, 0);
    }
}

/* Closed forms, of a list of laws: a spring pulls by its stiffness along each axis of the world, to
 * a place that is half way there at half the load; one that turns by its stiffness about a
 * director, for a rotation about it alone, by angles up to a whole turn, towards which rounding of
 * the rotation counts more and more; a medium against the velocity. */
static void test_acting(void **state)
{
    (void)state;
    static const double full[] = {0.2, 0.4, -0.6, 1,   2,   3,   0.1,
                                  0.2, 0.3,                           /* shift, k, place */
                                  4,   5,   6,    0.5, 0.5, 0.5, 0.5, /* k, upright */
                                  0.7, 0.1};
    static const double r[3] = {1, -1, 2}, V[3] = {3, 0, 4};
    acting list = {.count = 0};
    acting_add(&list, LAW_SPRING);
    acting_add(&list, LAW_TURNING_SPRING);
    acting_add(&list, LAW_RESISTANCE);
    assert_int_equal(list.numbers, sizeof full / sizeof *full);
    assert_true(list.by_position && list.by_rotation && list.by_velocity);
    for (int axis = 0; axis < 3; axis++) {
        for (double angle = 1e-9; angle < 6; angle += 0.37) {
            double turn[4] = {cos(angle / 2)}, q[4], numbers[18], R[3][3], body[3] = {0}, T[3];
            double wrench[6] = {0}, slowed[6] = {0}, energy = 0.5 * full[9 + axis] * angle * angle;
            const double near = 1e-14 * (1 + full[9 + axis] * angle) / (1 + cos(angle / 2));
            turn[1 + axis] = sin(angle / 2);
            quaternion_product(full + 12, turn, q);
            rotation_matrix(q, R);
            body[axis] = -full[9 + axis] * angle;
            to_world(R, body, T);
            for (int i = 0; i < 4; i++) {
                q[i] *= 1.25; /* of any length */
            }
            acting_on_way(&list, full, 7, 0.5, numbers);
            acting_wrench(&list, numbers, (acting_on){r, q, V}, ACTING_STORES, 2, wrench);
            acting_wrench(&list, numbers, (acting_on){r, q, V}, ACTING_DISSIPATES, 1, slowed);
            for (int i = 0; i < 3; i++) {
                const double off = r[i] - full[6 + i] - 0.5 * full[i];
                energy += 0.5 * full[3 + i] * off * off;
                assert_near(wrench[i], -2 * full[3 + i] * off, 1e-14);
                assert_near(wrench[3 + i], 2 * T[i], near);
                assert_near(slowed[i], -(0.7 + 0.1 * 5) * V[i], 1e-14);
                assert_near(slowed[3 + i], 0, 0);
            }
            assert_near(acting_energy(&list, numbers, (acting_on){r, q, NULL}), energy, 7 * near);
        }
    }
    acting_size size = {.force = 0};
    acting_measure(&list, full, (acting_on){r, full + 12, NULL}, &size);
    assert_near(size.pulled, sqrt(0.04 + 0.16 + 0.36), 1e-15);
    assert_true(size.force == 0 && size.moment == 0 && !size.follows);
}

/* Loads: dead ones stay, those that follow turn by 120 degrees about (1, 1, 1), axis to axis; the
 * work of a force is f . dr, and none is known of others. At half the load they are half. */
static void test_loads(void **state)
{
    (void)state;
    static const double full[] = {1, 2, 3, 4, 5, 6, 0.1, 0.2, 0.3, 0.4, 0.5, 0.6};
    static const double q[4] = {0.5, 0.5, 0.5, 0.5}, from[3] = {1, 0, 0}, to[3] = {0, 2, 3};
    static const double wrench[6] = {1.3, 2.1, 3.2, 4.6, 5.4, 6.5};
    acting list = {.count = 0};
    double numbers[12], found[6] = {0}, none[6] = {0};
    acting_size size = {.force = 0};
    acting_add(&list, LAW_FORCE);
    assert_near(acting_work(&list, full, (acting_on){from, q, NULL}, (acting_on){to, q, NULL}),
                -1 + 4 + 9, 1e-14);
    acting_add(&list, LAW_MOMENT);
    assert_false(list.follows);
    acting_add(&list, LAW_FOLLOWER_FORCE);
    acting_add(&list, LAW_FOLLOWER_MOMENT);
    assert_true(list.follows && !list.by_position);
    acting_on_way(&list, full, 0.5, 7, numbers);
    acting_wrench(&list, numbers, (acting_on){to, q, NULL}, ACTING_ALL, 2, found);
    acting_wrench(&list, numbers, (acting_on){to, q, NULL}, ACTING_STORES, 2, none);
    for (int i = 0; i < 6; i++) {
        assert_near(found[i], wrench[i], 1e-14);
        assert_near(none[i], 0, 0);
    }
    assert_near(acting_energy(&list, full, (acting_on){to, q, NULL}), 0, 0);
    assert_true(
        isnan(acting_work(&list, full, (acting_on){from, q, NULL}, (acting_on){to, q, NULL})));
    acting_measure(&list, full, (acting_on){to, q, NULL}, &size);
    assert_near(size.force, sqrt(14) + sqrt(0.14), 1e-14);
    assert_near(size.moment, sqrt(77) + sqrt(0.77), 1e-14);
    assert_true(size.follows && size.pulled == 0);
}

/* What cannot be written is refused, and the same text is written again. */
static void test_text(void **state)
{
    (void)state;
    ad_tape *tape = ad_tape_create();
    ad_value x = ad_input(tape, "x", 3), y = ad_input(tape, "y", 1), sum = ad_sum_rows(x);
    const ad_inline_argument input = {"y", 1, &y};
    const ad_inline_argument bad = {"z", 1, &sum};
    ad_error error = {AD_OK, ""};
    char *text[2] = {NULL, NULL};
    size_t size;
    FILE *file = open_memstream(&text[0], &size);
    assert_int_equal(ad_write_inline("f", 1, &input, 1, &bad, file, &error), AD_BAD_ARGUMENT);
    assert_non_null(strstr(error.message, "allowed: elementwise"));
    fclose(file);
    free(text[0]);
    ad_value z = ad_exp(ad_mul(ad_sqrt(y), ad_scalar(tape, 0.1)));
    const ad_inline_argument good = {"z", 1, &z};
    for (int i = 0; i < 2; i++) {
        file = open_memstream(&text[i], &size);
        assert_int_equal(ad_write_inline("f", 1, &input, 1, &good, file, &error), AD_OK);
        fclose(file);
    }
    assert_string_equal(text[0], text[1]);
    assert_non_null(strstr(text[0], "0.10000000000000001"));
    assert_non_null(strstr(text[0], "ALGEBRA(exp)("));
    free(text[0]);
    free(text[1]);
    ad_tape_free(tape);
}

/* A fluid around an upright section: each part of the velocity by its own numbers; without a
 * velocity, or without one of its parts, nothing is lost to 0/0. */
static void test_slender_drag(void **state)
{
    (void)state;
    static const double V[4][3] = {{0, 0, 4}, {0, 9, 0}, {0, 9, 4}, {0, 0, 0}};
    double given[LAW_GIVEN_MAX] = {0, 0, 0, 1};
    for (int i = 0; i < 6; i++) {
        given[LAW_STATE + i] = i + 1;
    }
    for (int k = 0; k < 4; k++) {
        const double along = V[k][2], across = V[k][1];
        const double f[3] = {0, -(4 + 5 * sqrt(across) + 6 * across) * across,
                             -(1 + 2 * sqrt(along) + 3 * along) * along};
        const double by[3] = {-(4 + 5 * sqrt(across) + 6 * across),
                              -(4 + 7.5 * sqrt(across) + 12 * across),
                              -(1 + 3 * sqrt(along) + 6 * along)};
        double out[OUTPUTS_MAX];
        memcpy(given + 7, V[k], sizeof V[k]);
        in_numbers(LAW_SLENDER_DRAG, given, out);
        for (int i = 0; i < 3; i++) {
            assert_near(out[1 + i], f[i], 1e-12);
            assert_near(out[4 + i], 0, 0);
            assert_near(out[7 + (12 + i) * 3 + i], by[i], 1e-12);
        }
        for (int i = 0; i < OUTPUTS_MAX; i++) {
            assert_true(isfinite(out[i]));
        }
    }
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_derivatives),  cmocka_unit_test(test_table),
        cmocka_unit_test(test_called),       cmocka_unit_test(test_at_rest),
        cmocka_unit_test(test_acting),       cmocka_unit_test(test_loads),
        cmocka_unit_test(test_slender_drag), cmocka_unit_test(test_momenta),
        cmocka_unit_test(test_text)};
    const struct CMUnitTest alike[] = {cmocka_unit_test(test_written)};
    return run_with_alike(tests, alike, NULL, NULL);
}
