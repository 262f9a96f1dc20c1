/* Conditions that networks meet exactly: on faces, at ends, in time and round a circle; which stay
 * terms; and that training learns with them. */
#include "fewer.h"
#include "training_testing.h"

#include "tools/library/cpinn.h"

static const double pi = 3.14159265358979323846;

/* sin(pi x) (1 + y) + y^2, which all conditions below are taken from. */
static ad_value whole(const domain_place *at)
{
    const ad_value x = at->x[0], y = at->x[1];
    const ad_value up = ad_add(ad_scalar(at->tape, 1), y);
    return ad_add(ad_mul(ad_sin(ad_scale(x, pi)), up), ad_square(y));
}

/* Derivatives by a coordinate of it; context: {coordinate, order, added}. */
static ad_value given(const void *context, const domain_place *at)
{
    const double *of = context;
    const ad_value u = whole(at);
    const ad_value part = of[1] > 0 ? ad_derivative(u, at->x[(int)of[0]], (int)of[1]) : u;
    return ad_add(part, ad_scalar(at->tape, of[2]));
}

static ad_value nothing(const void *context, const domain_place *at, const ad_value *u)
{
    (void)context;
    return ad_add(ad_derivative(*u, at->x[0], 2), ad_derivative(*u, at->x[1], 1));
}

typedef struct asked {
    double of[3];
    int end;
    bool exact;
} asked;

static physics_model *made_of(int count, const asked *list, bool periodic)
{
    physics_model *m = model_create();
    const int x = model_add_coordinate(m, "x", "m", -1, 1, 1);
    model_set_time(m, model_add_coordinate(m, "t", "s", 0, 2, 1));
    model_add_field(m, "u", 1);
    model_add_term(m, "balance", model_add_interior(m, "inside"), 1, nothing, NULL);
    for (int i = 0; i < count; i++) {
        char name[16];
        snprintf(name, sizeof name, "c%d", i);
        const model_condition c = {0, 0, (int)list[i].of[0], (int)list[i].of[1], given, list[i].of};
        assert_int_equal(model_add_condition(m, name, c, list[i].end), i + 1);
    }
    if (periodic) {
        model_set_periodic(m, x);
    }
    return m;
}

/* Column `column` of u u_x u_t u_tt... at a place, of a network with random parameters. */
static double column_of(const physics_model *m, const char *name, const double *place)
{
    nn_mlp_settings settings = nn_mlp_settings_default();
    nn_rng rng = nn_rng_split(7, "conditions");
    nn_mlp *mlp;
    ad_error error;
    settings.inputs = m->inputs ? m->inputs : 2;
    settings.outputs = 1;
    settings.hidden_count = 2;
    assert_int_equal(nn_mlp_create(&settings, &rng, &mlp, &error), AD_OK);
    double *parameters = malloc(nn_mlp_parameters(mlp) * sizeof *parameters), value;
    nn_mlp_initialize(mlp, &rng, parameters);
    const evaluator_model model = {
        .physics = m, .mlp = mlp, .windows = 1, .parameters = parameters};
    evaluator *e;
    if (evaluator_create(&model, name, &e, &error) != AD_OK) {
        fail_msg("%s", error.message);
    }
    assert_int_equal(
        evaluator_evaluate_at(e, 1, (const double *const[]){&place[0], &place[1]}, &value, &error),
        AD_OK);
    evaluator_free(e);
    free(parameters);
    nn_mlp_free(mlp);
    return value;
}

/* u and its derivatives by x (along 0) or t (1). */
static double exact_at(int along, int order, const double *p)
{
    const double s = sin(pi * p[0]), c = cos(pi * p[0]);
    return order == 0   ? s * (1 + p[1]) + p[1] * p[1]
           : along      ? order == 1 ? s + 2 * p[1] : 2
           : order == 1 ? pi * c * (1 + p[1])
                        : -pi * pi * s * (1 + p[1]);
}

static const char *const names[2][3] = {{"u", "u_x", "u_xx"}, {"u", "u_t", "u_tt"}};

/* 1e-14 of their size: rounding. */
static void check_faces(int count, const asked *list)
{
    ad_error error = {AD_OK, ""};
    physics_model *m = made_of(count, list, false), *network;
    assert_int_equal(model_for_network(m, &network, &error), AD_OK);
    for (int i = 0; i < count; i++) {
        const int along = (int)list[i].of[0], order = (int)list[i].of[1];
        assert_int_equal(model_condition_is_exact(network, i + 1), list[i].exact);
        assert_true((network->terms[i + 1].weight == 0) == list[i].exact);
        assert_true(m->terms[i + 1].weight == 100);
        double worst = 0;
        for (int k = 0; k <= 8; k++) {
            double place[2] = {k / 4.0 - 1, k / 4.0};
            place[along] = along ? 2.0 * list[i].end : 2.0 * list[i].end - 1;
            const double wanted = exact_at(along, order, place) + list[i].of[2];
            const double off = column_of(network, names[along][order], place) - wanted;
            worst = fmax(worst, fabs(off) / (1 + fabs(wanted)));
        }
        if (list[i].exact ? worst > 1e-14 : worst < 1e-3) {
            fail_msg("condition %d: off by %.1e", i, worst);
        }
    }
    assert_false(model_has_ansatz(m)); /* as patches see it */
    model_free(network);
    model_free(m);
}

static void test_faces(void **state)
{
    (void)state;
    const asked start[] = {{{1, 0, 0}, 0, true}, {{0, 0, 0}, 0, true}, {{0, 0, 0}, 1, true}};
    check_faces(3, start);
    const asked slopes[] = {{{1, 0, 0}, 0, true}, {{1, 1, 0}, 0, true}, {{0, 0, 0}, 0, true},
                            {{0, 1, 0}, 0, true}, {{0, 0, 0}, 1, true}, {{0, 1, 0}, 1, true},
                            {{0, 2, 0}, 1, true}};
    check_faces(7, slopes);
    const asked one[] = {{{1, 0, 0}, 0, true}, {{0, 0, 0}, 1, true}, {{0, 1, 0}, 1, true}};
    check_faces(3, one);
    const asked around[] = {
        {{1, 0, 0}, 0, true}, {{1, 0, 0}, 1, true}, {{0, 0, 0}, 0, true}, {{0, 0, 0}, 1, true}};
    check_faces(4, around);
}

/* Contradictions at a corner, a slope without its value, two values of one face. */
static void test_not_met(void **state)
{
    (void)state;
    const asked corner[] = {{{1, 0, 0}, 0, false}, {{0, 0, 0.5}, 0, false}, {{0, 0, 0}, 1, true}};
    check_faces(3, corner);
    const asked slope[] = {{{1, 0, 0}, 0, true}, {{0, 1, 0}, 0, false}, {{0, 0, 0}, 1, true}};
    check_faces(3, slope);
    const asked twice[] = {{{1, 0, 0}, 0, true}, {{0, 0, 0}, 0, false}, {{0, 0, 0}, 0, false}};
    check_faces(3, twice);
    /* the value goes with the corner, and with it the slope */
    const asked later[] = {{{1, 0, 0.5}, 0, false}, {{1, 1, 0}, 0, false}, {{0, 0, 0}, 1, false}};
    check_faces(3, later);
}

static ad_value wave(const void *context, const domain_place *at)
{
    return ad_add(ad_sin(ad_scale(at->x[0], pi)), ad_scale(at->x[0], *(const double *)context));
}

static void test_periodic(void **state)
{
    (void)state;
    static const double tilt[2] = {0, 0.1};
    ad_error error = {AD_OK, ""};
    for (int tilted = 0; tilted < 2; tilted++) {
        physics_model *m = made_of(0, NULL, true), *network;
        model_add_condition(m, "start", (model_condition){0, 0, 1, 0, wave, &tilt[tilted]}, 0);
        assert_int_equal(model_for_network(m, &network, &error), AD_OK);
        assert_int_equal(network->inputs, 3);
        assert_int_equal(model_condition_is_exact(network, 1), !tilted);
        for (int order = 0; order < 3; order++) {
            const double low[2] = {-1, 0.7}, high[2] = {1, 0.7};
            const double at_low = column_of(network, names[0][order], low);
            assert_true(fabs(column_of(network, names[0][order], high) - at_low) <
                        1e-13 * (1 + fabs(at_low)));
        }
        model_free(network);
        model_free(m);
    }
}

static ad_value front(const void *context, const domain_place *at)
{
    return ad_tanh(ad_scale(at->x[0], *(const double *)context));
}

/* A front stays a term where it is narrow, and with it what is said of its row: tanh of 2 x and of
 * 50 x. */
static void test_front(void **state)
{
    (void)state;
    static const double steepness[2] = {2, 50};
    ad_error error = {AD_OK, ""};
    for (int narrow = 0; narrow < 2; narrow++) {
        physics_model *m = made_of(0, NULL, false), *network;
        model_add_condition(m, "start", (model_condition){0, 0, 1, 0, front, &steepness[narrow]},
                            0);
        model_add_condition(m, "end", (model_condition){0, 0, 0, 0, front, &steepness[narrow]}, 0);
        assert_int_equal(model_for_network(m, &network, &error), AD_OK);
        assert_int_equal(model_condition_is_exact(network, 1), !narrow);
        assert_int_equal(model_condition_is_exact(network, 2), !narrow);
        model_free(network);
        model_free(m);
    }
}

/* ---- training ----------------------------------------------------------------------------------
 */

static int loss_of(void *p, const double *x, double *value, double *gradient)
{
    return problem_evaluate(p, x, value, gradient, NULL) != AD_OK;
}

/* Against differences; as for other losses. */
static void test_gradient(void **state)
{
    (void)state;
    const asked list[] = {{{1, 0, 0}, 0, true}, {{0, 0, 0}, 0, true}, {{0, 1, 0}, 0, true}};
    ad_error error = {AD_OK, ""};
    physics_model *m = made_of(3, list, false), *network;
    nn_mlp_settings settings = nn_mlp_settings_default();
    problem_settings few = problem_settings_default();
    nn_rng rng = nn_rng_split(1, "gradient");
    ad_pool *pool = ad_pool_create(1);
    ad_check check = {.worst_error = NAN};
    nn_mlp *mlp;
    problem *loss;
    settings.inputs = 2;
    settings.outputs = 1;
    few.interior.points = 50;
    assert_int_equal(model_for_network(m, &network, &error), AD_OK);
    assert_int_equal(nn_mlp_create(&settings, &rng, &mlp, &error), AD_OK);
    assert_int_equal(problem_create(network, mlp, &few, 1, pool, &loss, &error), AD_OK);
    assert_int_equal(problem_terms(loss), 1); /* the balance alone */
    double *x = malloc(nn_mlp_parameters(mlp) * sizeof *x);
    nn_mlp_initialize(mlp, &rng, x);
    ad_check_gradient(loss_of, loss, x, nn_mlp_parameters(mlp), 200, 1e-3, &check, &error);
    assert_true(check.worst_error < 1e-6 && check.dot_error < 1e-6);
    free(x);
    problem_free(loss);
    nn_mlp_free(mlp);
    ad_pool_free(pool);
    model_free(network);
    model_free(m);
}

static ad_value carried(const void *context, const domain_place *at, const ad_value *u)
{
    (void)context;
    return ad_add(ad_derivative(*u, at->x[1], 1), ad_derivative(*u, at->x[0], 1));
}

/* u_t + u_x = 0 on a circle: sin(pi (x - t)); waves leave 9.5e-6, and ten times that is allowed. */
static void test_convection(void **state)
{
    (void)state;
    static const double none = 0;
    physics_model *m = model_create();
    ad_error error = {AD_OK, ""};
    cpinn_model *trained;
    evaluator *e;
    model_set_periodic(m, model_add_coordinate(m, "x", "m", -1, 1, 1));
    model_set_time(m, model_add_coordinate(m, "t", "s", 0, 1, 1));
    model_add_field(m, "u", 1);
    model_add_term(m, "balance", model_add_interior(m, "inside"), 1, carried, NULL);
    model_add_condition(m, "start", (model_condition){0, 0, 1, 0, wave, &none}, 0);
    if (cpinn_train_physics(m, NULL, NULL, &trained, &error) != AD_OK) {
        fail_msg("%s", error.message);
    }
    assert_int_equal(cpinn_evaluator(trained, "u", &e, &error), AD_OK);
    double worst = 0, u;
    for (int i = 0; i <= 100; i++) {
        const double x = i / 50.0 - 1, t = (7 * i % 101) / 100.0;
        evaluator_evaluate_at(e, 1, (const double *const[]){&x, &t}, &u, &error);
        worst = fmax(worst, fabs(u - sin(pi * (x - t))));
    }
    if (!(worst < 1e-4)) {
        fail_msg("off by %.1e", worst);
    }
    evaluator_free(e);
    cpinn_free(trained);
    model_free(m);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_faces), cmocka_unit_test(test_not_met), cmocka_unit_test(test_front),
        cmocka_unit_test(test_periodic), cmocka_unit_test(test_convection)};
    const struct CMUnitTest alike[] = {cmocka_unit_test(test_gradient)};
    return run_with_alike(tests, alike, NULL, NULL);
}
