/* The ansatz: conditions that hold whatever the network says, the undeformed shape, and the
 * numbers and terms that describe a scene. */
#include "fewer.h"
#include "rod_testing.h"

#include "nn/nn.h"
#include "physics/rod/rod_internal.h"

/* ---- a scene for every pair of ends ---------------------------------------------------------- */

static const char *const initial_position[3] = {"0.2+0.1*s^2", "-0.1*s", "0.9*s"};
static const char *const initial_rotation[4] = {"cos(0.25*s+0.1*s^2)", "sin(0.25*s+0.1*s^2)", "0",
                                                "0"};
static const char *const flipped_rotation[4] = {"-cos(0.25*s+0.1*s^2)", "-sin(0.25*s+0.1*s^2)", "0",
                                                "0"};
static const char *const resting_velocity[3] = {"s*(1-s)", "0", "-2*s*(1-s)"};
static const char *const driven_velocity[3] = {"s*(1-s)+0.3*(1-s)", "0", "-2*s*(1-s)"};
static const char *const resting_spin[3] = {"2*s*(1-s)", "s*(1-s)", "0"};
static const char *const driven_spin[3] = {"2*s*(1-s)+0.4*(1-s)", "s*(1-s)", "0"};

/* Held ends, and driven ones that start with the initial state of this scene. */
static const char *const start_position[2][3] = {{"0.2", "0", "0"}, {"0.2+0.3*t", "t^2", "0"}};
static const char *const start_rotation[2][4] = {{"1", "0", "0", "0"},
                                                 {"cos(0.2*t)", "sin(0.2*t)", "0", "0"}};
static const char *const end_position[2][3] = {{"0.3", "-0.1", "0.9"}, {"0.3", "-0.1", "0.9-t^2"}};
static const char *const end_rotation[2][4] = {
    {"cos(0.35)", "sin(0.35)", "0", "0"}, {"cos(0.35+0.1*t^2)", "sin(0.35+0.1*t^2)", "0", "0"}};
static const char *const loads[4][3] = {{"3*cos(t)", "-1", "2"},
                                        {"0.5", "t", "-0.7"},
                                        {"1", "2*sin(t)", "-4"},
                                        {"0.2", "0.3", "0.4+t"}};

static scene ends_scene(scene_end_type start, scene_end_type end, bool dynamic, scene_frame frame)
{
    const double kse[3] = {40, 50, 90}, kbt[3] = {1.2, 0.8, 0.5}, inertia[3] = {0.03, 0.02, 0.05};
    scene made = stiff_scene(1, kse, kbt, 1.3, inertia);
    made.duration = Q(dynamic ? 2.5 : 0);
    made.start.type = start;
    made.end.type = end;
    int moves = start == SCENE_DRIVEN, ends = end == SCENE_DRIVEN;
    for (int i = 0; i < 4; i++) {
        made.start.rotation[i] = Q(start_rotation[moves][i]);
        made.end.rotation[i] = Q(end_rotation[ends][i]);
        made.initial.rotation[i] = Q(dynamic ? initial_rotation[i] : NULL);
    }
    for (int i = 0; i < 3; i++) {
        made.start.position[i] = Q(start_position[moves][i]);
        made.end.position[i] = Q(end_position[ends][i]);
        if (scene_end_slides(start)) {
            made.start.along[i] = quantity_number((double[]){0.3, -0.4, 1.2}[i]);
        }
        if (scene_end_slides(end)) {
            made.end.across[i] = quantity_number((double[]){1, 2, -0.5}[i]);
        }
        made.loads.base.force[i] = Q(loads[0][i]);
        made.loads.base.moment[i] = Q(loads[1][i]);
        made.loads.tip.force[i] = Q(loads[2][i]);
        made.loads.tip.moment[i] = Q(loads[3][i]);
        if (dynamic) {
            made.initial.position[i] = Q(initial_position[i]);
            made.initial.velocity[i] = Q((moves ? driven_velocity : resting_velocity)[i]);
            made.initial.angular_velocity[i] = Q((moves ? driven_spin : resting_spin)[i]);
        }
    }
    made.loads.base.frame = made.loads.tip.frame = frame;
    return made;
}

/* A network whose weights are random numbers as constants, so that no parameters are needed. */
static ad_value random_outputs(const scene *given, const recorded *r)
{
    enum { WIDTH = 12 };
    const domain over = rod_domain_of(given);
    int inputs = over.count, outputs = rod_network_outputs(given);
    double first[2 * WIDTH], second[15 * WIDTH];
    nn_rng rng = nn_rng_seed(17);
    for (int i = 0; i < inputs * WIDTH; i++)
        first[i] = nn_rng_between(&rng, -2, 2);
    for (int i = 0; i < outputs * WIDTH; i++)
        second[i] = nn_rng_between(&rng, -1, 1);
    ad_value x = domain_network_input(&over, &r->at);
    assert_int_equal(ad_rows(x), inputs);
    ad_value phase = ad_add(ad_matvec(ad_constant(r->tape, inputs * WIDTH, first), x),
                            ad_constant(r->tape, WIDTH, second));
    return ad_matvec(ad_constant(r->tape, outputs * WIDTH, second), ad_tanh(phase));
}

static const double at_start[POINTS] = {0}, at_end[POINTS] = {1, 1, 1, 1, 1, 1};

/* The soft conditions of the scene, asked of the state of the hard one. */
static void check_conditions(const scene *hard)
{
    scene soft = *hard;
    soft.boundary_enforcement = soft.initial_enforcement = SCENE_SOFT;
    recorded r = begin(hard);
    rod_state state = rod_ansatz(hard, &r.at, random_outputs(hard, &r));
    double t[POINTS];
    points_of_time(hard, t);
    /* rounding of data up to 7 in units of EI/L^2; exact otherwise */
    assert_near(largest(rod_residual(&soft, ROD_START, state, &r.at), at_start, t), 0, 1e-14);
    assert_near(largest(rod_residual(&soft, ROD_END, state, &r.at), at_end, t), 0, 1e-14);
    assert_true(largest(rod_residual(&soft, ROD_FORCE, state, &r.at), unit_s, t) > 1e-2);
    assert_int_equal(rod_residual_rows(hard, ROD_START), 0);
    assert_int_equal(rod_residual_rows(hard, ROD_END), 0);
    assert_int_equal(rod_residual_rows(hard, ROD_INITIAL), 0);
    if (scene_is_dynamic(hard)) {
        ad_value initial = rod_residual(&soft, ROD_INITIAL, state, &r.at);
        assert_near(largest(initial, unit_s, at_start), 0, 1e-14);
        assert_near(largest(initial, at_start, at_start), 0, 1e-14);
        assert_near(largest(initial, at_end, at_start), 0, 1e-14);
    }
    assert_int_equal(ad_tape_status(r.tape, NULL), AD_OK);
    ad_tape_free(r.tape);
}

static void test_hard_conditions(void **state)
{
    (void)state;
    for (int start = SCENE_CLAMPED; start <= SCENE_ROLLER; start++) {
        for (int end = SCENE_CLAMPED; end <= SCENE_ROLLER; end++) {
            for (int variant = 0; variant < 12; variant++) {
                scene hard = ends_scene((scene_end_type)start, (scene_end_type)end, variant & 1,
                                        variant & 2 ? SCENE_FOLLOWER : SCENE_DEAD);
                hard.rotation = (scene_rotation)(variant / 4);
                check_conditions(&hard);
            }
        }
    }
}

/* q and -q are the same rotation: the clamp may be written with either. */
static void test_rotation_sign(void **state)
{
    (void)state;
    scene hard = ends_scene(SCENE_CLAMPED, SCENE_CLAMPED, true, SCENE_DEAD);
    for (int i = 0; i < 4; i++)
        hard.initial.rotation[i] = Q(flipped_rotation[i]);
    check_conditions(&hard);
    for (int k = SCENE_VECTOR; k <= SCENE_SIX; k++) {
        hard.rotation = (scene_rotation)k;
        check_conditions(&hard);
    }
}

static void test_manufactured_conditions(void **state)
{
    (void)state;
    static const char *const position[3] = {"0.1*s^2*cos(t)", "0.2*s*sin(3*t)", "s"};
    static const char *const angles[3] = {"0.7*s*cos(2*t)", "0.5*s*sin(3*t+s)", "0.9*s"};
    for (int type = SCENE_CLAMPED; type <= SCENE_ROLLER; type++) {
        scene hard = ends_scene(SCENE_DRIVEN, (scene_end_type)type, true, SCENE_DEAD);
        for (int i = 0; i < 3; i++) {
            hard.manufactured.position[i] = Q(position[i]);
            hard.manufactured.angles[i] = Q(angles[i]);
        }
        check_conditions(&hard);
    }
}

/* The ansatz cannot meet an end and an initial state that disagree: refused, by key. */
static void test_incompatible(void **state)
{
    (void)state;
    const char *key = NULL;
    ad_error error;
    scene fine = ends_scene(SCENE_DRIVEN, SCENE_CLAMPED, true, SCENE_DEAD);
    assert_int_equal(rod_check(&fine, &key, &error), AD_OK);
    for (int i = 0; i < 4; i++)
        fine.initial.rotation[i] = Q(flipped_rotation[i]);
    assert_int_equal(rod_check(&fine, &key, &error), AD_OK); /* the same rotation */
    const struct {
        quantity *text;
        const char *wrong, *key;
    } mistakes[] = {
        {&fine.start.position[1], "0.1+t^2", "initial.position"},
        {&fine.end.rotation[2], "0.1", "initial.rotation"},
        {&fine.start.position[2], "0.2*sin(3*t)", "initial.velocity"},
        {&fine.initial.angular_velocity[1], "0.1*s", "initial.angular_velocity"},
    };
    for (size_t i = 0; i < sizeof mistakes / sizeof mistakes[0]; i++) {
        quantity right = *mistakes[i].text;
        *mistakes[i].text = Q(mistakes[i].wrong);
        assert_int_equal(rod_check(&fine, &key, &error), AD_BAD_INPUT);
        assert_string_equal(key, mistakes[i].key);
        fine.initial_enforcement = SCENE_SOFT;
        assert_int_equal(rod_check(&fine, &key, &error), AD_OK);
        fine.initial_enforcement = SCENE_HARD;
        *mistakes[i].text = right;
    }
    fine.end.rotation[0] = Q("-sin(0.35)"); /* half a turn about d1 */
    fine.end.rotation[1] = Q("cos(0.35)");
    assert_int_equal(rod_check(&fine, &key, &error), AD_BAD_INPUT);
    assert_non_null(strstr(error.message, "the rotation differs by 3.14 rad"));
    fine.start.type = fine.end.type = SCENE_FREE;
    fine.start.position[0] = Q("7");
    assert_int_equal(rod_check(&fine, &key, &error), AD_OK); /* nothing is held */
}

/* ---- loads by hand --------------------------------------------------------------------------- */

static void check_rows(ad_value value, const double *s, const double *expected, double tolerance)
{
    double *numbers = evaluate_at(value, 1, s, NULL, NULL);
    for (int i = 0; i < ad_rows(value); i++)
        assert_near(numbers[i], expected[i], tolerance);
    free(numbers);
}

/* At s = 0 the outside pulls the other way than the rod does: N = -F, m = -R^T T. A follower load
 * is fixed in the body: n = F, M = R T. */
static void test_load_signs(void **state)
{
    (void)state;
    scene given = ends_scene(SCENE_LOADED, SCENE_CLAMPED, false, SCENE_DEAD);
    rod_scales scale = rod_scales_of(&given); /* EI = 0.8, L = 1 */
    assert_near(scale.force, 0.8, 1e-15);
    recorded r = begin(&given);
    rod_state s = rod_ansatz(&given, &r.at, random_outputs(&given, &r));
    check_rows(s.force, at_start, (double[]){-3 / 0.8, 1 / 0.8, -2 / 0.8}, 1e-14);
    check_rows(ad_rotate(s.rotation, s.moment), at_start, (double[]){-0.5 / 0.8, 0, 0.7 / 0.8},
               1e-14);
    ad_tape_free(r.tape);
    given = ends_scene(SCENE_CLAMPED, SCENE_LOADED, false, SCENE_FOLLOWER);
    r = begin(&given);
    s = rod_ansatz(&given, &r.at, random_outputs(&given, &r));
    check_rows(ad_rotate_inverse(s.rotation, s.force), at_end, (double[]){1 / 0.8, 0, -4 / 0.8},
               1e-14);
    check_rows(s.moment, at_end, (double[]){0.2 / 0.8, 0.3 / 0.8, 0.4 / 0.8}, 1e-14);
    ad_tape_free(r.tape);
}

/* ---- forms, soft conditions ------------------------------------------------------------------ */

static void test_displacement(void **state)
{
    (void)state;
    const int rows[] = {0, 3, 6, 6, 0, 3, 6}; /* clamped, pinned, free, loaded, driven, sliding */
    for (int type = SCENE_CLAMPED; type <= SCENE_ROLLER; type++) {
        scene hard = ends_scene(SCENE_CLAMPED, (scene_end_type)type, true, SCENE_DEAD);
        hard.formulation = SCENE_DISPLACEMENT;
        assert_int_equal(rod_network_outputs(&hard), 7);
        assert_int_equal(rod_residual_rows(&hard, ROD_START), 0);
        assert_int_equal(rod_residual_rows(&hard, ROD_END), rows[type]);
        assert_int_equal(rod_residual_rows(&hard, ROD_STRAIN), 0);
        recorded r = begin(&hard);
        rod_state made = rod_ansatz(&hard, &r.at, random_outputs(&hard, &r));
        if (rows[type] > 0) {
            ad_value natural = rod_residual(&hard, ROD_END, made, &r.at);
            assert_int_equal(ad_rows(natural), rows[type]);
        }
        scene mixed = hard; /* N and m obey the law that the mixed form asks for */
        mixed.formulation = SCENE_MIXED;
        double t[POINTS];
        points_of_time(&hard, t);
        assert_near(largest(rod_residual(&mixed, ROD_STRAIN, made, &r.at), unit_s, t), 0, 1e-13);
        assert_near(largest(rod_residual(&mixed, ROD_CURVATURE, made, &r.at), unit_s, t), 0, 1e-12);
        ad_tape_free(r.tape);
    }
}

/* A rotation vector turns the rod by itself, about itself, from where it lies without a network. */
static void test_rotation_vector(void **state)
{
    (void)state;
    scene given = ends_scene(SCENE_CLAMPED, SCENE_FREE, false, SCENE_DEAD);
    given.formulation = SCENE_DISPLACEMENT;
    given.rotation = SCENE_VECTOR;
    assert_int_equal(rod_network_outputs(&given), 6);
    recorded r = begin(&given);
    const double outputs[6] = {0, 0, 0, 0.6, 0, 0.8};
    rod_state still = rod_ansatz(&given, &r.at, ad_zeros(r.tape, 6));
    rod_state made = rod_ansatz(&given, &r.at, ad_constant(r.tape, 6, outputs));
    ad_value half = ad_scale(r.s, 0.5), sine = ad_sin(half); /* at s by s, held at 0 */
    ad_value turn[4] = {ad_cos(half), ad_scale(sine, 0.6), ad_scalar(r.tape, 0),
                        ad_scale(sine, 0.8)};
    ad_value wanted = ad_quaternion_multiply(still.rotation, ad_stack(4, turn));
    assert_near(largest(ad_sub(made.rotation, wanted), unit_s, NULL), 0, 1e-15); /* rounding */
    given.rotation = SCENE_QUATERNION;
    assert_int_equal(rod_network_outputs(&given), 7);
    ad_tape_free(r.tape);
}

/* Six numbers turn the rod by the matrix of which they are the first columns: of the rotation about
 * an axis by 0.1 to 6.2, through all four entries of a quaternion as the largest; and the same
 * when the columns are neither unit vectors nor at right angles (Zhou et al., CVPR 2019, eq. 15).
 */
static void test_six_numbers(void **state)
{
    (void)state;
    scene given = ends_scene(SCENE_CLAMPED, SCENE_FREE, false, SCENE_DEAD);
    static const double axes[4][3] = {{0.6, 0.8, 0}, {0, 0.6, -0.8}, {0.8, 0, 0.6}, {0, 0, 1}};
    for (int k = 0; k < 4 * 62; k++) {
        const double *n = axes[k % 4], angle = 0.1 * (1 + k / 4), c = cos(angle), s = sin(angle);
        double m[3][3], columns[6];
        for (int i = 0; i < 3; i++) {
            for (int j = 0; j < 3; j++) { /* Rodrigues */
                double cross = i == j ? 0 : ((j - i + 3) % 3 == 2 ? 1 : -1) * n[3 - i - j];
                m[i][j] = (i == j) * c + s * cross + (1 - c) * n[i] * n[j];
            }
        }
        for (int i = 0; i < 3; i++) {
            columns[i] = 2.5 * m[i][0] - (i == 0);
            columns[3 + i] = 0.3 * m[i][1] - 1.7 * m[i][0] - (i == 1);
        }
        double real = cos(angle / 2), part = sin(angle / 2) * (real < 0 ? -1 : 1);
        const double wanted[4] = {fabs(real), part * n[0], part * n[1], part * n[2]};
        recorded r = begin(&given);
        ad_value q = rod_rotation_by_six(ad_constant(r.tape, 6, columns));
        ad_value missing = ad_sub(q, ad_constant(r.tape, 4, wanted));
        assert_near(largest(missing, unit_s, NULL), 0, 2e-15); /* rounding */
        ad_tape_free(r.tape);
    }
}

/* A twist of several turns is met by the rod as it lies without a network, in proportion to s and
 * in the frame that the rotation vector turns. */
static void test_twist(void **state)
{
    (void)state;
    scene given = ends_scene(SCENE_CLAMPED, SCENE_CLAMPED, false, SCENE_DEAD);
    for (int i = 0; i < 4; i++) {
        given.start.rotation[i] = given.end.rotation[i] = Q(NULL);
    }
    for (int i = 0; i < 3; i++) {
        given.end.rotation_vector[i] = Q(i == 0 ? "3" : "0");
        given.start.position[i] = Q("0");
        given.end.position[i] = Q(i == 2 ? "0.7" : "0");
    }
    given.motion = SCENE_AUTOMATIC;
    given.end.twist = Q("-17");
    assert_false(rod_plane_of(&given).is_planar);
    recorded r = begin(&given);
    rod_state still = rod_ansatz(&given, &r.at, ad_zeros(r.tape, rod_network_outputs(&given)));
    ad_value zero = ad_scalar(r.tape, 0);
    ad_value bend = ad_quaternion_exp(ad_vector(ad_scale(r.s, 3), zero, zero));
    ad_value twist = ad_quaternion_exp(ad_vector(zero, zero, ad_scale(r.s, -17)));
    ad_value wanted = ad_quaternion_multiply(bend, twist);
    assert_near(largest(ad_sub(still.rotation, wanted), unit_s, NULL), 0, 1e-14); /* rounding */
    given.end.twist = Q("0");
    assert_true(rod_plane_of(&given).is_planar);
    ad_tape_free(r.tape);
}

static void test_soft_conditions(void **state)
{
    (void)state;
    scene soft = ends_scene(SCENE_CLAMPED, SCENE_LOADED, true, SCENE_DEAD);
    soft.boundary_enforcement = soft.initial_enforcement = SCENE_SOFT;
    recorded r = begin(&soft);
    rod_state made = rod_ansatz(&soft, &r.at, random_outputs(&soft, &r));
    double t[POINTS];
    points_of_time(&soft, t);
    assert_true(largest(rod_residual(&soft, ROD_START, made, &r.at), at_start, t) > 1e-2);
    assert_true(largest(rod_residual(&soft, ROD_END, made, &r.at), at_end, t) > 1e-2);
    assert_true(largest(rod_residual(&soft, ROD_INITIAL, made, &r.at), unit_s, at_start) > 1e-2);
    assert_int_equal(ad_tape_status(r.tape, NULL), AD_OK);
    ad_tape_free(r.tape);
}

/* ---- undeformed shape ------------------------------------------------------------------------ */

/* Between two pinned ends the tangent of the straight rod is along the line, a half turn included.
 */
static void test_between_pins(void **state)
{
    (void)state;
    static const char *const ends[3][3] = {{"1", "0", "0"}, {"0", "0", "-1"}, {"0", "0.6", "0.8"}};
    for (int k = 0; k < 3; k++) {
        scene given = ends_scene(SCENE_PINNED, SCENE_PINNED, false, SCENE_DEAD);
        given.boundary_enforcement = SCENE_SOFT;
        double chord[3];
        for (int i = 0; i < 4; i++)
            given.start.rotation[i] = given.end.rotation[i] = Q(NULL);
        for (int i = 0; i < 3; i++) {
            given.start.position[i] = Q("0");
            given.end.position[i] = Q(ends[k][i]);
            chord[i] = strtod(ends[k][i], NULL);
        }
        recorded r = begin(&given);
        rod_state s = rod_ansatz(&given, &r.at, ad_zeros(r.tape, 13));
        ad_value tangent = ad_rotate(s.rotation, ad_vector_constant(r.tape, 0, 0, 1));
        check_rows(tangent, at_end, chord, 1e-15); /* rounding */
        check_rows(s.position, at_end, chord, 1e-15);
        ad_tape_free(r.tape);
    }
}

static void check_undeformed(bool held_at_start, const char *const *strain,
                             const char *const *curvature, double tolerance)
{
    scene given = ends_scene(held_at_start ? SCENE_CLAMPED : SCENE_FREE,
                             held_at_start ? SCENE_FREE : SCENE_CLAMPED, false, SCENE_DEAD);
    given.rod.length = Q(1.3);
    for (int i = 0; i < 3; i++) {
        given.rod.rest_strain[i] = Q(strain[i]);
        given.rod.rest_curvature[i] = Q(curvature[i]);
    }
    recorded r = begin(&given);
    rod_state rest = rod_ansatz(&given, &r.at, ad_zeros(r.tape, 13));
    assert_true(ad_is_constant(rest.force, 0));
    for (int kind = ROD_STRAIN; kind <= ROD_MOMENT; kind++) {
        ad_value residual = rod_residual(&given, (rod_residual_kind)kind, rest, &r.at);
        assert_near(largest(residual, unit_s, NULL), 0, tolerance);
    }
    const double start[3] = {0.2 / 1.3, 0, 0}, end[3] = {0.3 / 1.3, -0.1 / 1.3, 0.9 / 1.3};
    check_rows(rest.position, held_at_start ? at_start : at_end, held_at_start ? start : end,
               1e-14);
    assert_int_equal(ad_tape_status(r.tape, NULL), AD_OK);
    ad_tape_free(r.tape);
}

static void test_undeformed_shape(void **state)
{
    (void)state;
    static const char *const straight[2][3] = {{"0", "0", "1"}, {"0", "0", "0"}};
    static const char *const helix[2][3] = {{"0.1", "0", "1.05"}, {"1", "-2", "0.5"}};
    static const char *const coiled[2][3] = {{"0.1*s", "0", "1"}, {"2*sin(3*s)", "-1", "5*s^2"}};
    for (int start = 0; start <= 1; start++) {
        check_undeformed(start, straight[0], straight[1], 1e-14);
        check_undeformed(start, helix[0], helix[1], 1e-13);
        /* a polynomial of degree 40 through a solution of 4th order: 1e-13, differentiated */
        check_undeformed(start, coiled[0], coiled[1], 1e-10);
    }
}

/* ---- the whole composition, differentiated --------------------------------------------------- */

typedef struct trained {
    ad_program *program;
    const double *inputs[2];
    size_t points, views;
    const nn_view *view;
} trained;

static int loss_function(void *context, const double *x, double *value, double *gradient)
{
    trained *problem = context;
    static double ignored[13 * 16];
    double *outputs[1 + 2 * (NN_HIDDEN_MAX + 1)] = {value};
    for (size_t i = 0; i < problem->views; i++)
        outputs[i + 1] = gradient ? gradient + problem->view[i].offset : ignored;
    ad_run run = {
        .points = problem->points, .inputs = problem->inputs, .parameters = x, .outputs = outputs};
    return ad_execute(problem->program, &run, NULL) == AD_OK ? 0 : 1;
}

/* Sum of squares of all residuals at all points. */
static ad_value sum_of_squares(const scene *given, const recorded *r, rod_state made)
{
    ad_value sum = ad_scalar(r->tape, 0);
    for (int kind = ROD_STRAIN; kind <= ROD_MOMENT; kind++) {
        if (rod_residual_rows(given, (rod_residual_kind)kind) > 0) {
            ad_value rows = rod_residual(given, (rod_residual_kind)kind, made, &r->at);
            sum = ad_add(sum, ad_sum_points(ad_dot(rows, rows)));
        }
    }
    return sum;
}

static void check_loss_gradient(const scene *given)
{
    nn_mlp_settings settings = nn_mlp_settings_default();
    const domain over = rod_domain_of(given);
    settings.inputs = over.count;
    settings.outputs = rod_network_outputs(given);
    settings.hidden_count = 1;
    settings.hidden[0] = 8;
    nn_rng rng = nn_rng_seed(3);
    nn_mlp *mlp = NULL;
    assert_int_equal(nn_mlp_create(&settings, &rng, &mlp, NULL), AD_OK);
    recorded r = begin(given);
    ad_value outputs = nn_mlp_record(mlp, domain_network_input(&over, &r.at), 0);
    ad_value loss = sum_of_squares(given, &r, rod_ansatz(given, &r.at, outputs));
    double t[POINTS], x[400];
    points_of_time(given, t);
    trained problem = {.inputs = {unit_s, t}, .points = POINTS};
    problem.views = (size_t)nn_mlp_views(mlp, &problem.view);
    ad_value parameters[4], wanted[5] = {loss};
    for (size_t i = 0; i < problem.views; i++) {
        const nn_view *view = &problem.view[i];
        parameters[i] = ad_parameter(r.tape, view->name, view->rows * view->columns, view->offset);
    }
    int views = (int)problem.views;
    assert_int_equal(ad_reverse(loss, views, parameters, AD_SUMMED, wanted + 1), AD_OK);
    ad_pool *pool = ad_pool_create(1);
    ad_settings compile = ad_settings_default();
    assert_int_equal(ad_compile(views + 1, wanted, &compile, pool, &problem.program, NULL), AD_OK);
    nn_mlp_initialize(mlp, &rng, x);
    ad_check check;
    assert_int_equal(ad_check_gradient(loss_function, &problem, x, nn_mlp_parameters(mlp), 0, 1e-3,
                                       &check, NULL),
                     AD_OK);
    assert_near(check.worst_error, 0, 1e-8); /* rounding of the differences: 1e-16 / 1e-3 */
    assert_near(check.dot_error, 0, 1e-8);
    ad_program_free(problem.program);
    ad_pool_free(pool);
    ad_tape_free(r.tape);
    nn_mlp_free(mlp);
}

static void test_loss_gradient(void **state)
{
    (void)state;
    static const scene_formulation forms[] = {SCENE_MIXED, SCENE_DISPLACEMENT, SCENE_POSE_STRAIN};
    for (int variant = 0; variant < 9; variant++) {
        scene given = ends_scene(SCENE_DRIVEN, SCENE_LOADED, true, SCENE_FOLLOWER);
        given.formulation = forms[variant % 3];
        given.rotation = (scene_rotation)(variant / 3);
        given.loads.drag = Q(0.3);
        for (int i = 0; i < 3; i++) {
            given.rod.strain_damping[i] = given.rod.curvature_damping[i] = Q(0.1 + 0.1 * i);
            given.loads.gravity[i] = Q(1);
        }
        check_loss_gradient(&given);
    }
}

/* ---- numbers, terms -------------------------------------------------------------------------- */

/* D8a of the reference values: L/a = 20, nu = 0.3, Cowper's kappa; tip load 4 sin^2 then 4. */
static scene dynamic_cantilever(void)
{
    const double kse[3] = {545.4545454545455, 545.4545454545455, 1600}, kbt[3] = {1, 1, 1 / 1.3};
    const double inertia[3] = {0.000625, 0.000625, 0.00125};
    scene made = stiff_scene(1, kse, kbt, 1, inertia);
    made.duration = Q(2);
    made.end.type = SCENE_LOADED;
    made.loads.tip.force[2] = Q("where(0.5-t, -4*sin(pi*t)^2, -4)");
    return made;
}

static void test_numbers(void **state)
{
    (void)state;
    scene given = dynamic_cantilever();
    rod_numbers numbers = rod_numbers_of(&given);
    assert_near(numbers.axial_ratio, 1600, 1e-10);
    assert_near(numbers.shear_ratio, 545.4545454545455, 1e-10);
    assert_near(numbers.torsion_ratio, 1 / 1.3, 1e-15);
    assert_near(numbers.rotary_inertia, 0.000625, 1e-18);
    assert_near(numbers.tip_force, 4, 1e-14);
    assert_near(numbers.duration, 2, 1e-14);
    assert_near(numbers.periods, 2 * 3.516 / (2 * PI), 1e-5); /* 3.516 is rounded */
    assert_near(numbers.weight + numbers.curvature_damping, 0, 0);
    given.rod.length = Q(2); /* ratios grow with L^2, time too */
    given.loads.gravity[1] = Q(-3);
    numbers = rod_numbers_of(&given);
    assert_near(numbers.axial_ratio, 6400, 1e-9);
    assert_near(numbers.duration, 0.5, 1e-14);
    assert_near(numbers.weight, 24, 1e-12);
    assert_near(numbers.tip_force, 16, 1e-12);
    assert_near(rod_moment_scale(&given), 16, 1e-12); /* the tip force on a lever of the length */
    given.loads.moment[0] = Q("-5*s*t");              /* 20 N at s = 2, t = 2; times L^2/EI = 4 */
    numbers = rod_numbers_of(&given);
    assert_near(numbers.distributed_moment, 80, 1e-12);
    assert_near(rod_moment_scale(&given), 80, 1e-12);
}

static const char *reason_of(const scene *given, const char *name)
{
    rod_term terms[ROD_TERM_MAX];
    int count = rod_terms(given, terms);
    assert_true(count <= ROD_TERM_MAX);
    for (int i = 0; i < count; i++) {
        assert_int_equal(terms[i].present, terms[i].reason == NULL);
        if (strcmp(terms[i].name, name) == 0)
            return terms[i].reason ? terms[i].reason : "present";
    }
    fail_msg("no term '%s'", name);
    return "";
}

static void test_terms(void **state)
{
    (void)state;
    scene given = dynamic_cantilever();
    assert_string_equal(reason_of(&given, "stretch"), "present");
    assert_string_equal(reason_of(&given, "rotary inertia"), "present");
    assert_string_equal(reason_of(&given, "gyroscopic moment"), "present");
    assert_string_equal(reason_of(&given, "tip load"), "present");
    assert_string_equal(reason_of(&given, "base load"), "the end is not loaded");
    assert_string_equal(reason_of(&given, "gravity"), "not given");
    assert_string_equal(reason_of(&given, "rest curvature"), "not given");
    assert_string_equal(reason_of(&given, "curvature damping"), "not given");
    given.rod.model = SCENE_KIRCHHOFF;
    given.rod.rest_curvature[0] = Q("0.1*s");
    given.duration = Q(0);
    assert_string_equal(reason_of(&given, "stretch"), "infinite stiffness");
    assert_string_equal(reason_of(&given, "rest curvature"), "present");
    assert_string_equal(reason_of(&given, "translational inertia"), "static scene");
    given.duration = Q(1);
    for (int i = 0; i < 3; i++)
        given.rod.rotary_inertia[i] = Q(0);
    assert_string_equal(reason_of(&given, "rotary inertia"), "rho I = 0");
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_rotation_sign),
        cmocka_unit_test(test_manufactured_conditions),
        cmocka_unit_test(test_incompatible),
        cmocka_unit_test(test_load_signs),
        cmocka_unit_test(test_displacement),
        cmocka_unit_test(test_rotation_vector),
        cmocka_unit_test(test_six_numbers),
        cmocka_unit_test(test_twist),
        cmocka_unit_test(test_soft_conditions),
        cmocka_unit_test(test_between_pins),
        cmocka_unit_test(test_undeformed_shape),
        cmocka_unit_test(test_numbers),
        cmocka_unit_test(test_terms),
    };
    const struct CMUnitTest alike[] = {cmocka_unit_test(test_hard_conditions),
                                       cmocka_unit_test(test_loss_gradient)};
    return run_with_alike(tests, alike, NULL, NULL);
}
