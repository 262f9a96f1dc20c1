/* Exact solutions of the rod have no residual. */
#include "rod_testing.h"

/* ---- exact solutions ------------------------------------------------------------------------- */

/* Pose exp of (u, v) s from the identity: r = (s + s^2 c_2 u^ + s^3 c_3 u^ u^) v, q = exp(su/2). */
static rod_state twisted(ad_value s, const double *u, const double *v)
{
    ad_value turn = ad_mul(s, ad_vector_constant(s.tape, u[0], u[1], u[2]));
    ad_value way = ad_mul(s, ad_vector_constant(s.tape, v[0], v[1], v[2]));
    ad_value square = ad_dot(turn, turn), once = ad_cross(turn, way);
    ad_value bent = ad_add(ad_mul(ad_stumpff(2, square), once),
                           ad_mul(ad_stumpff(3, square), ad_cross(turn, once)));
    return (rod_state){.position = ad_add(way, bent), .rotation = ad_quaternion_exp(turn)};
}

static ad_value constant3(ad_tape *tape, const double *x, double factor)
{
    return ad_vector_constant(tape, x[0] * factor, x[1] * factor, x[2] * factor);
}

/* S5a, S3: dead end couple M bends an isotropic rod to a helix (a circle). */
static void check_helix(const double *couple, double twist_stiffness, const double *tip,
                        const double *tip_rotation)
{
    const double kse[3] = {300, 300, 700}, kbt[3] = {1, 1, twist_stiffness}, none[3] = {0, 0, 0};
    scene given = stiff_scene(1, kse, kbt, 1, none);
    given.end.type = SCENE_LOADED;
    set_numbers(given.loads.tip.moment, 3, couple);
    given.boundary_enforcement = SCENE_SOFT;
    recorded r = begin(&given);
    const double along[3] = {0, 0, 1};
    double unwound[3] = {0, 0, couple[2] * (1 / twist_stiffness - 1)};
    rod_state exact = twisted(r.s, couple, along);
    exact.rotation = ad_quaternion_multiply(
        exact.rotation, ad_quaternion_exp(ad_mul(r.s, constant3(r.tape, unwound, 1))));
    exact.force = ad_zeros(r.tape, 3);
    exact.moment = ad_rotate_inverse(exact.rotation, constant3(r.tape, couple, 1));
    check_interior(&given, &r, exact, 1e-11);
    const double end[POINTS] = {1, 1, 1, 1, 1, 1}, start[POINTS] = {0};
    assert_near(largest(rod_residual(&given, ROD_END, exact, &r.at), end, NULL), 0, 1e-12);
    assert_near(largest(rod_residual(&given, ROD_START, exact, &r.at), start, NULL), 0, 1e-14);
    double *position = evaluate_at(exact.position, 1, end, NULL, NULL);
    double *rotation = evaluate_at(exact.rotation, 1, end, NULL, NULL);
    for (int i = 0; i < 3; i++)
        assert_near(position[i], tip[i], 1e-13);
    for (int i = 0; i < 4; i++)
        assert_near(rotation[i], tip_rotation[i], 1e-13);
    free(position);
    free(rotation);
    ad_tape_free(r.tape);
}

/* Tip values: reference/cases.json, S5a; rolled up once and twice also S3. */
static void test_helix(void **state)
{
    (void)state;
    const double once[3] = {2 * PI, 0, 0}, twice[3] = {4 * PI, 0, 0}, origin[3] = {0, 0, 0};
    const double helix[3] = {0, 3, 4}, many[3] = {0, 25, 20};
    check_helix(once, 0.7, origin, (double[]){-1, 0, 0, 0});
    check_helix(twice, 0.7, origin, (double[]){1, 0, 0, 0});
    check_helix(helix, 1 / 1.3,
                (double[]){0.08596053774441283, 0.5720567303676612, 0.5709574522242542},
                (double[]){-0.9315505919323018, 0.20275367502293265, 0.29636422503621157,
                           -0.05720741257877954});
    check_helix(many, 1 / 1.3,
                (double[]){0.004255902700122457, 0.4792055632270869, 0.40099304596614144},
                (double[]){0.9718599193412969, -0.03254913445371952, 0.22834039852344223,
                           0.04784886024135593});
}

/* S5b: n = lambda u, v = e3 + Kse^-1 n, m = lambda v + mu u, u* = u - Kbt^-1 m; tip from
 * reference/cases.json. */
static void test_constant_strain(void **state)
{
    (void)state;
    const double kse[3] = {800, 900, 2000}, kbt[3] = {1, 1.7, 0.6}, none[3] = {0, 0, 0};
    const double u[3] = {2, -1, 3}, lambda = 15, mu = 0.4;
    const double tip_force[3] = {30, -15, 45};
    const double tip_moment[3] = {14.893956896131227, -1.9971546405561305, 7.067477189060469};
    double v[3], m[3], rest[3];
    for (int i = 0; i < 3; i++) {
        v[i] = (i == 2) + lambda * u[i] / kse[i];
        m[i] = lambda * v[i] + mu * u[i];
        rest[i] = u[i] - m[i] / kbt[i];
    }
    scene given = stiff_scene(1, kse, kbt, 1, none);
    set_numbers(given.rod.rest_curvature, 3, rest);
    set_numbers(given.loads.tip.force, 3, tip_force);
    set_numbers(given.loads.tip.moment, 3, tip_moment);
    given.end.type = SCENE_LOADED;
    given.boundary_enforcement = SCENE_SOFT;
    rod_scales scale = rod_scales_of(&given);
    recorded r = begin(&given);
    rod_state exact = twisted(r.s, u, v);
    exact.force = ad_rotate(exact.rotation, constant3(r.tape, u, lambda / scale.force));
    exact.moment = constant3(r.tape, m, 1 / scale.moment);
    check_interior(&given, &r, exact, 1e-11);
    const double end[POINTS] = {1, 1, 1, 1, 1, 1};
    ad_value at_end = rod_residual(&given, ROD_END, exact, &r.at);
    assert_near(largest(at_end, end, NULL), 0, 1e-12);
    ad_tape_free(r.tape);
}

/* The exact states below are written in SI and brought to the scales of the scene. */
static rod_state scaled(const scene *given, rod_state si)
{
    rod_scales scale = rod_scales_of(given);
    si.position = ad_scale(si.position, 1 / scale.length);
    si.force = ad_scale(si.force, 1 / scale.force);
    si.moment = ad_scale(si.moment, 1 / scale.moment);
    return si;
}

/* D4: q = exp(f e3/2), f = 20 sin(pi s/2) cos(pi c t/2), c = sqrt(GJ/rhoJ). */
static void test_torsion_wave(void **state)
{
    (void)state;
    const double kse[3] = {500, 500, 1600}, kbt[3] = {1, 1, 1 / 1.3};
    const double inertia[3] = {0.000625, 0.000625, 0.00125};
    scene given = stiff_scene(1, kse, kbt, 1, inertia);
    given.duration = Q(0.2);
    recorded r = begin(&given);
    double time = rod_scales_of(&given).time, speed = sqrt(kbt[2] / inertia[2]);
    ad_value beat = ad_cos(ad_scale(r.t, PI * speed * time / 2));
    ad_value angle = ad_scale(ad_mul(ad_sin(ad_scale(r.s, PI / 2)), beat), 20);
    ad_value zeros = ad_zeros(r.tape, 2);
    rod_state exact = {
        .position = ad_stack(2, (ad_value[]){zeros, r.s}),
        .rotation = ad_quaternion_exp(ad_stack(2, (ad_value[]){zeros, angle})),
        .force = ad_zeros(r.tape, 3),
        .moment = ad_stack(2, (ad_value[]){zeros, ad_scale(ad_derivative(angle, r.s, 1), kbt[2])})};
    check_interior(&given, &r, scaled(&given, exact), 2e-11); /* s^-2 terms reach 50 */
    ad_tape_free(r.tape);
}

/* D5: spinning about d1, stretched: x = sin(k(s - 1/2)) / (k cos(k/2)), k = Omega sqrt(rhoA/EA). */
static void test_spinning_rod(void **state)
{
    (void)state;
    const double kse[3] = {40, 50, 90}, kbt[3] = {1.2, 0.8, 0.5}, inertia[3] = {0.03, 0.02, 0.05};
    const double spin = 4, k = 4 * sqrt(1.3 / 90);
    scene given = stiff_scene(1, kse, kbt, 1.3, inertia);
    given.duration = Q(2);
    given.start.type = given.end.type = SCENE_FREE;
    recorded r = begin(&given);
    ad_value zero = ad_scalar(r.tape, 0);
    ad_value s = ad_sub(r.s, ad_scalar(r.tape, 0.5)), ks = ad_scale(s, k);
    ad_value angle = ad_scale(r.t, spin * rod_scales_of(&given).time);
    ad_value q = ad_quaternion_exp(ad_vector(angle, zero, zero));
    ad_value reach = ad_scale(ad_sin(ks), 1 / (k * cos(k / 2)));
    ad_value stretch = ad_sub(ad_scale(ad_cos(ks), 1 / cos(k / 2)), ad_scalar(r.tape, 1));
    rod_state exact = {.position = ad_rotate(q, ad_vector(zero, zero, reach)),
                       .rotation = q,
                       .force = ad_rotate(q, ad_vector(zero, zero, ad_scale(stretch, 90))),
                       .moment = ad_zeros(r.tape, 3)};
    check_interior(&given, &r, scaled(&given, exact), 1e-11);
    ad_tape_free(r.tape);
}

/* D6: travelling helix, translation d t u, then exp of the twist (u, v)(s + ct). */
static void test_travelling_helix(void **state)
{
    (void)state;
    const double kse[3] = {40, 50, 90}, kbt[3] = {1.2, 0.8, 0.5}, inertia[3] = {0.03, 0.02, 0.05};
    const double u[3] = {1, -2, 3}, c = 1.5, d = 0.4, lambda = 0.7, mu = -0.1, mass = 1.3;
    double v[3], n[3], m[3], rest[3];
    for (int i = 0; i < 3; i++) {
        v[i] = ((i == 2) * kse[i] + lambda * u[i]) / (kse[i] - mass * c * c);
        n[i] = mass * c * c * v[i] + lambda * u[i];
        m[i] = c * c * inertia[i] * u[i] + lambda * v[i] + mu * u[i];
        rest[i] = u[i] - m[i] / kbt[i];
    }
    scene given = stiff_scene(1, kse, kbt, mass, inertia);
    set_numbers(given.rod.rest_curvature, 3, rest);
    given.duration = Q(1);
    for (int form = SCENE_MIXED; form <= SCENE_DISPLACEMENT; form++) {
        given.formulation = (scene_formulation)form;
        recorded r = begin(&given);
        ad_value t = ad_scale(r.t, rod_scales_of(&given).time);
        rod_state exact = twisted(ad_add(r.s, ad_scale(t, c)), u, v);
        exact.position = ad_add(exact.position, ad_mul(t, constant3(r.tape, u, d)));
        exact.force = ad_rotate(exact.rotation, constant3(r.tape, n, 1));
        exact.moment = constant3(r.tape, m, 1);
        check_interior(&given, &r, scaled(&given, exact), 1e-11);
        ad_tape_free(r.tape);
    }
}

/* ---- folding --------------------------------------------------------------------------------- */

/* Absent physics is gone: without loads, a Kirchhoff rod's strain residual is v - v* alone. */
static void test_locked_strain(void **state)
{
    (void)state;
    const double kse[3] = {INFINITY, INFINITY, INFINITY}, kbt[3] = {1, 1, 0.8}, none[3] = {0, 0, 0};
    scene given = stiff_scene(1, kse, kbt, 1, none);
    recorded r = begin(&given);
    rod_state straight = {.position = ad_vector(ad_zeros(r.tape, 1), ad_zeros(r.tape, 1), r.s),
                          .rotation = ad_constant(r.tape, 4, (double[]){1, 0, 0, 0}),
                          .force = ad_input(r.tape, "force", 3),
                          .moment = ad_input(r.tape, "moment", 3)};
    ad_value residual = rod_residual(&given, ROD_STRAIN, straight, &r.at);
    assert_true(ad_is_constant(residual, 0)); /* whatever the force */
    assert_int_equal(ad_tape_status(r.tape, NULL), AD_OK);
    ad_value refused = rod_residual(&given, ROD_INITIAL, straight, &r.at);
    assert_false(ad_is_valid(refused));
    assert_int_equal(ad_tape_status(r.tape, NULL), AD_BAD_ARGUMENT);
    ad_tape_free(r.tape);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_helix),
        cmocka_unit_test(test_constant_strain),
        cmocka_unit_test(test_torsion_wave),
        cmocka_unit_test(test_spinning_rod),
        cmocka_unit_test(test_travelling_helix),
        cmocka_unit_test(test_locked_strain),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
