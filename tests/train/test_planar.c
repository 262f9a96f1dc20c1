/* What motion in a plane saves, and that it is trained to the known solution. */
#include "near.h"
#include "trainer_testing.h"

#define MOVING "configs/cantilever_deep.yaml"

typedef struct cost {
    size_t instructions, flops, parameters;
} cost;

static cost cost_of(const char *path, const char *motion, const char *more)
{
    char text[32];
    snprintf(text, sizeof text, "motion=%s", motion);
    const char *changes[] = {text, more, NULL};
    made m = make_problem(path, changes, 1);
    problem_set_info set = problem_set_inspect(m.p, 0);
    cost found = {set.program.instructions, set.program.flops_per_point, m.e->count};
    made_free(&m);
    return found;
}

static void test_cost(void **state)
{
    (void)state;
    static const struct {
        const char *path, *more;
        double most; /* of the instructions of motion in space */
    } rows[] = {{ELASTICA, "formulation=mixed", 0.55},
                {MOVING, "formulation=mixed", 0.55},
                {MOVING, "enforcement.initial=soft", 0.55},
                {MOVING, "formulation=displacement", 0.45}};
    for (size_t i = 0; i < sizeof rows / sizeof *rows; i++) {
        cost flat = cost_of(rows[i].path, "automatic", rows[i].more);
        cost space = cost_of(rows[i].path, "spatial", rows[i].more);
        double ratio = (double)flat.instructions / (double)space.instructions;
        if (!(ratio < rows[i].most))
            fail_msg("row %zu: %zu instructions against %zu", i, flat.instructions,
                     space.instructions);
        assert_true(flat.flops < space.flops); /* of the last layer, which is 6 wide, not 13 */
        assert_int_equal(space.parameters - flat.parameters,
                         (i == 3 ? 4 : 7) * (5 + 1)); /* of 5 units and a bias */
    }
}

/* By default, to the elliptic integrals; then what leaves the plane is the number 0. */
static void test_elastica(void **state)
{
    (void)state;
    static const char *const changes[] = {
        "motion=planar", "network.hidden=[12, 12]", "losses.interior.points=32",
        "training.stages=[{optimizer: adam, steps: 200, learning_rate: 1e-2}, "
        "{optimizer: lbfgs, steps: 1500}]",
        NULL};
    run r = start(ELASTICA, changes, 1);
    finish(&r);
    reference_errors errors;
    ad_error error = {AD_OK, ""};
    assert_int_equal(reference_compare(r.known, r.made.e->parameters, &errors, &error), AD_OK);
    assert_true(errors.position < 1e-3); /* a small network, a second of training */
    assert_true(errors.rotation < 1e-3);
    enum { AT = 5 };
    double s[AT] = {0, 0.07, 0.15, 0.22, 0.3}, values[MODEL_COLUMNS_MAX * AT];
    field *f = NULL;
    assert_int_equal(
        field_create(r.made.e->model, r.made.e->mlp, false, r.made.e->pool, &f, &error), AD_OK);
    assert_int_equal(
        field_evaluate(f, r.made.e->parameters, AT, (const double *const[]){s}, values, &error),
        AD_OK);
    static const char *const across[] = {"y", "qw", "qy", "v2", "u1", "u3", "n2", "m1", "m3"};
    int found = 0;
    for (int column = 0; column < field_columns(f); column++) {
        for (size_t k = 0; k < sizeof across / sizeof *across; k++) {
            if (strcmp(field_column_name(f, column), across[k]) == 0) {
                found++;
                for (int i = 0; i < AT; i++)
                    assert_true(values[column * AT + i] == 0);
            }
        }
    }
    assert_int_equal(found, sizeof across / sizeof *across);
    field_free(f);
    stop(&r);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_cost),
        cmocka_unit_test(test_elastica),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
