/* Answers of families with their errors: for each reason of doubt a network that gives it, on
 * solved members that are bent by a smooth change of curvature; what is solved instead; the same
 * bits for any number of threads; what is refused; how answers are verified. */
#include "allocations.h"
#include "fewer.h"
#include "good.h"

#include "physics/solve/solve.h"
#include "tools/library/trained_family.h"

#include <stdlib.h>
#include <string.h>

enum { POINTS = 11, WIDTH = POINTS * SOLVE_MEMBERS_COLUMNS, COUNT = 4, MEMBERS = 37 };

static const double LENGTH = 0.2;

/* ---- scenes -------------------------------------------------------------------------------- */

typedef struct robot {
    quantities *names;
    scene scene;
} robot;

static void add_range(robot *r, const char *name, double low, double high)
{
    ad_error error = {.message = ""};
    assert_good(quantities_coordinate(r->names, name, &error), &error);
    r->scene.parameters[r->scene.parameter_count++] =
        (scene_parameter){.name = name, .low = low, .high = high};
}

/* A wire of 0.5 mm in radius, with a tendon, a tip force, its weight, and a factor of stiffness. */
static void make_robot(robot *r)
{
    r->names = quantities_create();
    scene_defaults(&r->scene);
    add_range(r, "pull", 0, 3);
    add_range(r, "push", -0.1, 0.1);
    add_range(r, "side", -0.1, 0.1);
    add_range(r, "stiff", 0.5, 2);
    r->scene.parameters[3].scale = SCENE_LOG;
    scene *s = &r->scene;
    s->names = r->names;
    s->rod.section = SCENE_CIRCLE;
    s->rod.length = quantity_number(LENGTH);
    s->rod.radius = quantity_number(0.5e-3);
    s->rod.youngs_modulus = quantity_formula(r->names, "60e9*stiff");
    s->rod.poissons_ratio = quantity_number(0.3);
    s->rod.density = quantity_number(6450);
    s->end.type = SCENE_LOADED;
    for (int i = 0; i < 3; i++) {
        s->loads.gravity[i] = quantity_number(i == 2 ? -9.81 : 0);
    }
    s->loads.tip.force[2] = quantity_number(0);
    s->loads.tip.force[0] = quantity_formula(r->names, "push");
    s->loads.tip.force[1] = quantity_formula(r->names, "side");
    s->tendon_count = 1;
    s->tendons[0] = (scene_tendon){.offset = {quantity_number(8e-3), quantity_number(0)},
                                   .tension = quantity_formula(r->names, "pull")};
}

/* A column of EI = L = 1 with a force along it and one across. */
static void make_column(robot *r)
{
    r->names = quantities_create();
    scene_defaults(&r->scene);
    add_range(r, "along", -6, 6);
    add_range(r, "across", -1, 1);
    scene *s = &r->scene;
    s->names = r->names;
    s->rod.model = SCENE_KIRCHHOFF;
    s->rod.length = quantity_number(1);
    s->rod.bending_stiffness[0] = s->rod.bending_stiffness[1] = quantity_number(1);
    s->rod.torsional_stiffness = quantity_number(1);
    s->end.type = SCENE_LOADED;
    s->loads.tip.force[0] = quantity_formula(r->names, "across");
    s->loads.tip.force[1] = quantity_number(0);
    s->loads.tip.force[2] = quantity_formula(r->names, "along");
}

/* ---- a network ----------------------------------------------------------------------------- */

/* Solved members whose curvature is off by so much, 1/m, along the rod as a wave. */
typedef struct fake {
    solve_members *solver;
    size_t nodes, columns;
    double s[512], off, length;
    bool broken;   /* says nothing but nan */
    bool mirrored; /* is that of the force across the other way */
    double given;  /* if not nan, this curvature about d2 and no other */
} fake;

static ad_status fake_curvature(void *context, size_t members, const double *parameters,
                                double *curvature, ad_error *error)
{
    static double turned[1024][2];
    static solve_member results[1024];
    fake *x = context;
    assert_true(members <= 1024);
    for (size_t i = 0; i < 2 * members && x->mirrored; i++) {
        turned[i / 2][i % 2] = i % 2 ? -parameters[i] : parameters[i];
    }
    ad_status status = solve_members_curvature(
        x->solver, members, x->mirrored ? turned[0] : parameters, NULL, curvature, results, error);
    for (size_t i = 0; i < members * x->nodes; i++) {
        const double wave = x->off * cos(3 * x->s[i % x->nodes] / x->length);
        for (int c = 0; c < 3; c++) {
            curvature[3 * i + (size_t)c] =
                x->broken         ? NAN
                : isnan(x->given) ? curvature[3 * i + (size_t)c] + wave * (c < 2 ? 1 : 0.1)
                : c == 1          ? x->given
                                  : 0;
        }
    }
    return status;
}

/* The same by the solver's own answers: positions that its curvature does not know of. */
static ad_status fake_values(void *context, size_t members, const double *parameters,
                             double *values, ad_error *error)
{
    static solve_member results[1024];
    fake *x = context;
    ad_status status = solve_members_solve(x->solver, members, parameters, values, results, error);
    for (size_t i = 0; i < members * POINTS; i++) {
        values[i * SOLVE_MEMBERS_COLUMNS] += 1e-3 * LENGTH;
    }
    return status;
}

static cpinn_family_settings settings_of(const scene *s, int threads)
{
    static double places[POINTS];
    for (int i = 0; i < POINTS; i++) {
        places[i] = scene_length(s) * i / (POINTS - 1);
    }
    return (cpinn_family_settings){.threads = threads, .points = POINTS, .s = places};
}

static cpinn_family *open_with(const robot *r, const cpinn_family_settings *settings, fake *x)
{
    cpinn_family *result = NULL;
    ad_error error = {.message = ""};
    assert_good(cpinn_family_prepare(&r->scene, 0, settings, &result, &error), &error);
    x->solver = result->solver;
    x->length = scene_length(&r->scene);
    x->given = x->given == 0 ? NAN : x->given;
    if (x->solver) {
        x->nodes = solve_members_nodes(x->solver);
        assert_true(x->nodes <= 512);
        solve_members_places(x->solver, x->s);
    }
    const cpinn_family_network network = {.context = x, .curvature = fake_curvature};
    cpinn_family_attach(result, &network);
    return result;
}

static void draw(double (*members)[COUNT])
{
    nn_rng random = nn_rng_seed(3);
    for (int i = 0; i < MEMBERS; i++) {
        members[i][0] = nn_rng_between(&random, 0, 3);
        members[i][1] = nn_rng_between(&random, -0.1, 0.1);
        members[i][2] = nn_rng_between(&random, -0.1, 0.1);
        members[i][3] = exp2(nn_rng_between(&random, -1, 1));
    }
}

typedef struct batch {
    double parameters[MEMBERS][COUNT], values[MEMBERS][WIDTH], truth[MEMBERS][WIDTH];
    cpinn_answer answers[MEMBERS];
    solve_member solved[MEMBERS];
} batch;

static batch *answer(const robot *r, int threads, double off, const cpinn_polish *polish,
                     bool with_values)
{
    fake network = {.off = off};
    const cpinn_family_settings settings = settings_of(&r->scene, threads);
    ad_error error = {.message = ""};
    batch *b = calloc(1, sizeof *b);
    assert_non_null(b);
    cpinn_family *x = open_with(r, &settings, &network);
    draw(b->parameters);
    assert_good(solve_members_solve(network.solver, MEMBERS, b->parameters[0], b->truth[0],
                                    b->solved, &error),
                &error);
    if (with_values) {
        const cpinn_family_network both = {
            .context = &network, .curvature = fake_curvature, .values = fake_values};
        cpinn_family_attach(x, &both);
    }
    const long before = allocations;
    assert_good(cpinn_family_evaluate(x, polish, MEMBERS, b->parameters[0], b->values[0],
                                      b->answers, &error),
                &error);
    assert_int_equal(allocations, before);
    cpinn_family_free(x);
    return b;
}

static double distance(const double *a, const double *b)
{
    double largest = 0;
    for (int i = 0; i < POINTS; i++) {
        double square = 0;
        for (int c = 0; c < 3; c++) {
            const double off = a[i * SOLVE_MEMBERS_COLUMNS + c] - b[i * SOLVE_MEMBERS_COLUMNS + c];
            square += off * off;
        }
        largest = fmax(largest, sqrt(square));
    }
    return largest;
}

/* ---- tests --------------------------------------------------------------------------------- */

/* Errors are predicted to a tenth, and each step lessens them; solved members are right to 1e-6 of
 * the length. Whatever the steps, the error of the network alone is the same, but for
 * second order. */
static void test_errors(void **state)
{
    (void)state;
    robot r;
    make_robot(&r);
    double before = INFINITY, alone[MEMBERS];
    for (int steps = 0; steps <= 2; steps++) {
        const cpinn_polish polish = {.steps = steps};
        batch *b = answer(&r, 1, 0.3, &polish, false);
        double worst = 0;
        for (int i = 0; i < MEMBERS; i++) {
            const double off = distance(b->values[i], b->truth[i]), error = b->answers[i].error;
            assert_true(b->answers[i].trusted);
            assert_int_equal(b->answers[i].source, CPINN_FROM_NETWORK);
            assert_false(b->answers[i].outside);
            assert_near(error, off, 0.1 * off + 1e-6 * LENGTH);
            alone[i] = steps == 0 ? error : alone[i];
            assert_near(b->answers[i].network_error, alone[i], 0.01 * alone[i]);
            worst = fmax(worst, off);
        }
        assert_true(worst < before / 10);
        before = worst;
        free(b);
    }
    quantities_free(r.names);
}

/* A network that has positions of its own is judged by these, though its curvature is right. */
static void test_own_values(void **state)
{
    (void)state;
    const cpinn_polish polish = {.steps = 0};
    robot r;
    make_robot(&r);
    batch *b = answer(&r, 1, 1e-6, &polish, true);
    for (int i = 0; i < MEMBERS; i++) {
        assert_true(b->answers[i].trusted);
        assert_near(distance(b->values[i], b->truth[i]), 1e-3 * LENGTH, 1e-12);
        assert_near(b->answers[i].error, 1e-3 * LENGTH, 2e-6 * LENGTH);
    }
    free(b);
    quantities_free(r.names);
}

static void test_same_bits(void **state)
{
    (void)state;
    const cpinn_polish polish = {.steps = 1};
    robot r;
    make_robot(&r);
    batch *one = answer(&r, 1, 4, &polish, false), *two = answer(&r, 2, 4, &polish, false);
    assert_memory_equal(one->values, two->values, sizeof one->values);
    for (int i = 0; i < MEMBERS; i++) {
        assert_true(one->answers[i].error == two->answers[i].error);
        assert_int_equal(one->answers[i].source, two->answers[i].source);
    }
    free(one);
    free(two);
    quantities_free(r.names);
}

/* One member of the robot, or of the column; `reason` of the network alone. */
static cpinn_answer ask(const robot *r, fake *network, const cpinn_polish *polish,
                        const double *member, bool extrapolate, double *values)
{
    cpinn_family_settings settings = settings_of(&r->scene, 1);
    cpinn_answer result;
    ad_error error = {.message = ""};
    settings.extrapolate = extrapolate;
    cpinn_family *x = open_with(r, &settings, network);
    assert_good(cpinn_family_evaluate(x, polish, 1, member, values, &result, &error), &error);
    cpinn_family_free(x);
    return result;
}

/* The network alone is not trusted for this reason, and the product is what the solver says. */
static void check_doubt(const robot *r, fake network, const double *member, int steps,
                        cpinn_reason reason, cpinn_source source)
{
    double values[WIDTH];
    fake again = network;
    const cpinn_polish alone = {.steps = steps, .alone = true}, both = {.steps = steps};
    const cpinn_answer by_network = ask(r, &network, &alone, member, true, values);
    assert_string_equal(cpinn_reason_word(by_network.reason), cpinn_reason_word(reason));
    assert_false(by_network.trusted);
    assert_int_equal(by_network.source, CPINN_FROM_NETWORK);
    const cpinn_answer product = ask(r, &again, &both, member, true, values);
    assert_string_equal(cpinn_source_word(product.source), cpinn_source_word(source));
    assert_true(product.trusted == (source == CPINN_FROM_MEMBERS));
    assert_true(isfinite(values[WIDTH - 1]) == (source != CPINN_FROM_NOTHING));
    if (source == CPINN_FROM_MEMBERS) {
        assert_true(product.error <= 1e-6 * scene_length(&r->scene));
        assert_string_equal(cpinn_reason_word(product.reason), cpinn_reason_word(reason));
    }
}

static void test_reasons(void **state)
{
    (void)state;
    robot r, column;
    make_robot(&r);
    make_column(&column);
    const double member[COUNT] = {1, 0.05, 0, 1};
    const double buckled[2] = {-3, 0.2}, upright[2] = {-5, 0}, near[2] = {-2.465, 1e-5};
    check_doubt(&r, (fake){.broken = true}, member, 0, CPINN_REASON_NOT_FINITE, CPINN_FROM_MEMBERS);
    check_doubt(&r, (fake){.off = 30}, member, 0, CPINN_REASON_TOO_FAR, CPINN_FROM_MEMBERS);
    check_doubt(&r, (fake){.off = 30}, member, 2, CPINN_REASON_TOO_FAR, CPINN_FROM_MEMBERS);
    /* straight beyond Euler's load, pi^2/4 = 2.467 */
    check_doubt(&column, (fake){.given = 1e-9}, buckled, 0, CPINN_REASON_UNSTABLE,
                CPINN_FROM_MEMBERS);
    check_doubt(&column, (fake){.given = 1e-9}, upright, 2, CPINN_REASON_UNSTABLE,
                CPINN_FROM_SOLVER); /* which warns: unstable */
    /* there it is Newton's method for a triple root, whose steps become shorter by a third */
    check_doubt(&column, (fake){.off = 0.12}, near, 2, CPINN_REASON_NOT_SETTLING,
                CPINN_FROM_MEMBERS);
    quantities_free(r.names);
    quantities_free(column.names);
}

/* What only solution_create finds has derivatives, too: the upright column beyond Euler's load goes
 * against a force across by (tan k - k)/k^3 for each unit, k^2 = 5 (EI = L = 1). To the tolerance
 * of the mesh, 1e-6. */
static void test_derivative_of_solver(void **state)
{
    (void)state;
    static double values[WIDTH], jacobian[WIDTH * 2];
    const double upright[2] = {-5, 0}, k = sqrt(5);
    fake straight = {.given = 1e-9};
    robot column;
    cpinn_answer said;
    ad_error error = {.message = ""};
    make_column(&column);
    const cpinn_family_settings settings = settings_of(&column.scene, 1);
    cpinn_family *x = open_with(&column, &settings, &straight);
    assert_good(cpinn_family_jacobian(x, 1, upright, values, jacobian, &said, &error), &error);
    assert_int_equal(said.source, CPINN_FROM_SOLVER);
    const double *tip = jacobian + (WIDTH - WIDTH / POINTS) * 2;
    assert_near(tip[1], (tan(k) - k) / (k * k * k), 1e-6);
    assert_near(tip[0], 0, 1e-6);
    cpinn_family_free(x);
    quantities_free(column.names);
}

/* Beyond the range: refused, or answered and said to be so; a rod of negative stiffness is none. */
static void test_outside(void **state)
{
    (void)state;
    robot r;
    make_robot(&r);
    const cpinn_family_settings settings = settings_of(&r.scene, 1);
    const double outside[COUNT] = {3.5, 0, 0, 1}, none[COUNT] = {1, 0, 0, NAN};
    const double negative[COUNT] = {1, 0, 0, -1}, edge[COUNT] = {3 * (1 + 1e-15), 0, 0, 0.5};
    const cpinn_polish polish = {.steps = 1};
    double values[WIDTH];
    fake network = {.off = 0.01}, same = network, broken = {.broken = true};
    cpinn_answer said;
    ad_error error = {.message = ""};
    cpinn_family *x = open_with(&r, &settings, &network);
    assert_int_equal(cpinn_family_evaluate(x, &polish, 1, outside, values, &said, &error),
                     AD_BAD_ARGUMENT);
    assert_string_equal(error.message,
                        "member 0: pull = 3.5 is outside its range; allowed: 0 to 3");
    assert_int_equal(cpinn_family_evaluate(x, &polish, 1, none, values, &said, &error),
                     AD_BAD_ARGUMENT);
    assert_good(cpinn_family_evaluate(x, &polish, 1, edge, values, &said, &error), &error);
    assert_false(said.outside);
    const cpinn_polish many = {.steps = 3};
    assert_int_equal(cpinn_family_evaluate(x, &many, 1, edge, values, &said, &error),
                     AD_BAD_ARGUMENT);
    cpinn_family_free(x);
    said = ask(&r, &same, &polish, outside, true, values);
    assert_true(said.outside && said.trusted);
    said = ask(&r, &broken, &polish, negative, true, values);
    assert_true(said.outside && !said.trusted && isnan(values[0]));
    assert_int_equal(said.source, CPINN_FROM_NOTHING);
    assert_int_equal(said.reason, CPINN_REASON_REFUSED);
    quantities_free(r.names);
}

/* Of a scene that the batch solver does not take errors are not predicted, and nothing is trusted.
 */
static ad_status zeros(void *context, size_t members, const double *parameters, double *values,
                       ad_error *error)
{
    (void)context;
    (void)parameters;
    (void)error;
    memset(values, 0, members * POINTS * MODEL_COLUMNS_MAX * sizeof *values);
    return AD_OK;
}

static void test_without_errors(void **state)
{
    (void)state;
    robot r;
    make_robot(&r);
    r.scene.tendons[r.scene.tendon_count++] = r.scene.tendons[0];
    r.scene.tendons[0].friction = quantity_number(0.1);
    r.scene.tendons[1].end = quantity_number(LENGTH / 2);
    const cpinn_family_settings settings = settings_of(&r.scene, 1);
    static double values[POINTS * MODEL_COLUMNS_MAX];
    const double member[COUNT] = {1, 0.05, 0, 1};
    const cpinn_polish polish = {.steps = 2};
    cpinn_answer said;
    cpinn_family *x = NULL;
    ad_error error = {.message = ""};
    assert_good(cpinn_family_prepare(&r.scene, 0, &settings, &x, &error), &error);
    assert_non_null(
        strstr(cpinn_family_without_error(x), "friction of a tendon where strains jump"));
    const cpinn_family_network network = {.values = zeros};
    cpinn_family_attach(x, &network);
    assert_good(cpinn_family_evaluate(x, &polish, 1, member, values, &said, &error), &error);
    assert_true(isnan(said.error) && !said.trusted);
    assert_int_equal(said.reason, CPINN_REASON_NO_ESTIMATE);
    cpinn_family_check check;
    assert_good(cpinn_family_verify(x, 3, 1, &check, &error), &error);
    assert_int_equal(check.by_solver, 3);
    assert_int_equal(check.rows[CPINN_WAY_NETWORK].not_trusted, 3);
    assert_true(check.rows[CPINN_WAY_NETWORK].worst > 0.5 * LENGTH); /* all at the start */
    cpinn_family_free(x);
    quantities_free(r.names);
}

/* Fresh members of a network that is off by a wave: no error is above what was predicted. */
static void test_verify(void **state)
{
    (void)state;
    enum { CHECKED = FEWER(700) };
    robot r;
    make_robot(&r);
    const cpinn_family_settings settings = settings_of(&r.scene, 1);
    fake network = {.off = 0.1};
    cpinn_family_check check, again;
    ad_error error = {.message = ""};
    cpinn_family *x = open_with(&r, &settings, &network);
    assert_good(cpinn_family_verify(x, CHECKED, 1, &check, &error), &error);
    assert_int_equal(check.by_members + check.by_solver + check.unsolved, CHECKED);
    assert_int_equal(check.by_members, CHECKED);
    assert_int_equal(check.compared, 30);
    assert_true(check.apart < 1e-6 * LENGTH);
    for (int k = 0; k < CPINN_WAY_COUNT; k++) {
        const cpinn_family_row *row = &check.rows[k];
        assert_int_equal(row->wrong, 0);
        assert_true(row->median <= row->p95 && row->p95 <= row->p999 && row->p999 <= row->worst);
        assert_true(row->alone > 0 && row->batch > 0);
    }
    const cpinn_family_row *plain = &check.rows[CPINN_WAY_NETWORK];
    assert_true(plain->median > 1e-4 * LENGTH && plain->worst < 0.1 * LENGTH);
    assert_true(plain->within > 0.9 && fabs(plain->ratio[1] - 1) < 0.02);
    assert_int_equal(check.rows[CPINN_WAY_PRODUCT].not_trusted, 0);
    assert_true(check.rows[CPINN_WAY_PRODUCT].worst < 2e-6 * LENGTH);
    assert_good(cpinn_family_verify(x, CHECKED, 1, &again, &error), &error);
    assert_true(again.rows[0].worst == check.rows[0].worst);
    assert_good(cpinn_family_verify(x, CHECKED, 2, &again, &error), &error);
    assert_true(again.rows[0].worst != check.rows[0].worst);
    assert_int_equal(cpinn_family_verify(x, 0, 1, &again, &error), AD_BAD_ARGUMENT);
    cpinn_family_free(x);
    quantities_free(r.names);
}

/* A network on the other branch of a buckled column, a stable equilibrium like that of the solver:
 * nothing but a solved member shows that it is wrong, and it is counted. */
static void test_wrong(void **state)
{
    (void)state;
    robot column;
    make_column(&column);
    /* in a plane: about d2 it is soft */
    column.scene.rod.bending_stiffness[0] = quantity_number(10);
    column.scene.rod.torsional_stiffness = quantity_number(10);
    column.scene.parameters[0].low = -4;
    column.scene.parameters[0].high = -3;
    column.scene.parameters[1].low = 1e-3;
    column.scene.parameters[1].high = 5e-3;
    const cpinn_family_settings settings = settings_of(&column.scene, 1);
    fake network = {.mirrored = true};
    cpinn_family_check check;
    ad_error error = {.message = ""};
    cpinn_family *x = open_with(&column, &settings, &network);
    assert_good(cpinn_family_verify(x, 20, 1, &check, &error), &error);
    assert_int_equal(check.by_members, 20);
    for (int k = 0; k < CPINN_WAY_COUNT; k++) {
        assert_int_equal(check.rows[k].wrong, 20);
        assert_true(check.rows[k].median > 0.5);
    }
    cpinn_family_free(x);
    quantities_free(column.names);
}

/* The n-th allocation fails: an error, and nothing is left behind. */
static void test_memory(void **state)
{
    (void)state;
    robot r;
    make_robot(&r);
    const cpinn_family_settings settings = settings_of(&r.scene, 1);
    ad_status status = AD_NO_MEMORY;
    for (long n = 1; status == AD_NO_MEMORY; n += 1 + n / 8) {
        ad_error error = {.message = ""};
        cpinn_family *x = NULL;
        allocations = 0;
        failing_allocation = n;
        status = cpinn_family_prepare(&r.scene, 0, &settings, &x, &error);
        failing_allocation = 0;
        assert_true(status == AD_OK || (status == AD_NO_MEMORY && !x));
        cpinn_family_free(x);
    }
    assert_int_equal(status, AD_OK);
    quantities_free(r.names);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_errors),
        cmocka_unit_test(test_own_values),
        cmocka_unit_test(test_same_bits),
        cmocka_unit_test(test_reasons),
        cmocka_unit_test(test_outside),
        cmocka_unit_test(test_without_errors),
        cmocka_unit_test(test_verify),
        cmocka_unit_test(test_wrong),
        cmocka_unit_test(test_derivative_of_solver),
        cmocka_unit_test(test_memory),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
