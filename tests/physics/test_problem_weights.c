/* Weights that follow training: balanced loss terms. Causal weights are those of test_problem.c. */
#include "allocations.h"
#include "training_testing.h"

#include "physics/learn/problem_internal.h"

#define DYNAMIC  "configs/cantilever_deep.yaml"
#define ELASTICA "configs/elastica_deep.yaml"

#define SOFT        "enforcement={boundary: soft, initial: soft}"
#define BALANCED    "losses.balance=gradient_norm"
#define FEW_OUTSIDE "losses={boundary: {points: 7}, initial: {points: 9}}"

static bool reweigh(const made *m, int64_t step, const double *x)
{
    ad_error error = {AD_OK, ""};
    bool changed;
    if (problem_reweigh(m->p, step, x, &changed, &error) != AD_OK) {
        fail_msg("%s", error.message);
    }
    return changed;
}

static double *numbers(size_t count)
{
    double *x = calloc(count, sizeof *x);
    assert_non_null(x);
    return x;
}

static double length_of(const double *x, size_t count)
{
    double sum = 0;
    for (size_t i = 0; i < count; i++) {
        sum += x[i] * x[i];
    }
    return sqrt(sum);
}

/* ---- balanced ----------------------------------------------------------------------------------
 */

/* Lengths of the gradients of the terms with their weights, by the programs of gradient checks. */
static double lengths_at(const made *m, const double *x, double lengths[PROBLEM_TERMS])
{
    size_t count = problem_parameters(m->p);
    double *gradient = numbers(count), value, sum = 0;
    for (int k = 0; k < problem_terms(m->p); k++) {
        assert_int_equal(problem_evaluate_term(m->p, k, x, &value, gradient, NULL), AD_OK);
        lengths[k] = problem_term_weight(m->p, k) * length_of(gradient, count);
        sum += lengths[k];
    }
    free(gradient);
    return sum;
}

/* At the first update every gradient has the length of all together; then the factors move by half
 * of what is missing. Tolerances: another order of summation over a few hundred points. */
static void test_balance(void **state)
{
    (void)state;
    const char *const changes[] = {BALANCED, SOFT, "losses.balance_every=2",
                                   "losses.balance_memory=0.5", NULL};
    made m = make_problem(DYNAMIC, changes, 1);
    size_t count = problem_parameters(m.p);
    int terms = problem_terms(m.p);
    assert_int_equal(terms, 7);
    double lengths[PROBLEM_TERMS], before[PROBLEM_TERMS], *x = m.e->parameters;
    for (int k = 0; k < terms; k++) {
        assert_true(problem_balance_weight(m.p, k) == 1);
    }
    assert_true(reweigh(&m, 1, x));
    double sum = lengths_at(&m, x, lengths);
    for (int k = 0; k < terms; k++) {
        before[k] = problem_balance_weight(m.p, k);
        assert_true(fabs(before[k] * lengths[k] - sum) <= 1e-12 * sum);
    }
    for (size_t i = 0; i < count; i++) {
        x[i] *= 1.5;
    }
    assert_false(reweigh(&m, 2, x));
    assert_true(reweigh(&m, 3, x));
    sum = lengths_at(&m, x, lengths);
    for (int k = 0; k < terms; k++) {
        double expected = 0.5 * before[k] + 0.5 * sum / lengths[k];
        assert_true(fabs(problem_balance_weight(m.p, k) - expected) <= 1e-12 * expected);
    }
    assert_false(reweigh(&m, 4, x));
    made_free(&m);
}

/* The loss is the sum of the terms times weight and factor, its gradient that of the terms, and the
 * normal equations are those of the same loss. */
static void test_balanced_loss(void **state)
{
    (void)state;
    const char *const changes[] = {BALANCED, SOFT, NULL};
    made m = make_problem(DYNAMIC, changes, 1);
    size_t count = problem_parameters(m.p);
    double *x = m.e->parameters, *gradient = numbers(count), *one = numbers(count);
    double *jtj = numbers(count * count), *jtr = numbers(count), value, sum = 0, held_out, again;
    assert_int_equal(problem_held_out(m.p, x, &held_out, NULL, NULL), AD_OK);
    double plain = loss_at(&m, x, NULL);
    reweigh(&m, 1, x);
    double loss = loss_at(&m, x, gradient), length = length_of(gradient, count);
    assert_true(loss > 2 * plain); /* no factor is below 1 */
    assert_int_equal(problem_normal_equations(m.p, x, &value, jtj, jtr, NULL), AD_OK);
    assert_true(fabs(value - loss) <= 1e-12 * loss);
    for (size_t i = 0; i < count; i++) {
        assert_true(fabs(2 * jtr[i] - gradient[i]) <= 1e-11 * length);
    }
    for (int k = 0; k < problem_terms(m.p); k++) {
        double factor = problem_balance_weight(m.p, k) * problem_term_weight(m.p, k);
        assert_int_equal(problem_evaluate_term(m.p, k, x, &value, one, NULL), AD_OK);
        assert_true(fabs(value - problem_losses(m.p)[k]) <= 1e-12 * value); /* without factors */
        sum += factor * value;
        for (size_t i = 0; i < count; i++) {
            gradient[i] -= factor * one[i];
        }
    }
    assert_true(fabs(sum - loss) <= 1e-12 * loss);
    assert_true(length_of(gradient, count) <= 1e-11 * length);
    assert_int_equal(problem_held_out(m.p, x, &again, NULL, NULL), AD_OK);
    assert_true(again == held_out); /* which knows the weights of the settings alone */
    free(gradient);
    free(one);
    free(jtj);
    free(jtr);
    made_free(&m);
}

/* Points count by their causal weights: the balanced gradients of the terms add up to that of the
 * loss, and are equally long. */
static void test_balance_causal(void **state)
{
    (void)state;
    const char *const changes[] = {BALANCED, SOFT, "losses.causal.slices=4", NULL};
    made m = make_problem(DYNAMIC, changes, 1);
    size_t count = problem_parameters(m.p);
    double *x = m.e->parameters, *gradient = numbers(count), *one = numbers(count), value;
    reweigh(&m, 1, x);
    loss_at(&m, x, gradient);
    double whole = length_of(gradient, count), first = 0;
    for (int k = 0; k < problem_terms(m.p); k++) {
        problem_set *set = problem_set_of_term(m.p, k);
        double factor = problem_balance_weight(m.p, k) * problem_term_weight(m.p, k);
        assert_int_equal(problem_set_run_term(m.p, set, k, true, x, &value, one, NULL), AD_OK);
        for (size_t i = 0; i < count; i++) {
            gradient[i] -= factor * one[i];
        }
        double length = factor * length_of(one, count);
        first = k == 0 ? length : first;
        assert_true(fabs(length - first) <= 1e-12 * first);
    }
    assert_true(length_of(gradient, count) <= 1e-11 * whole);
    free(gradient);
    free(one);
    made_free(&m);
}

/* A term whose gradient is next to nothing gets 1e6, not everything there is. */
static void test_balance_floor(void **state)
{
    (void)state;
    const char *const changes[] = {BALANCED, "losses.interior.weights.force=1e-30", NULL};
    made m = make_problem(ELASTICA, changes, 1);
    reweigh(&m, 1, m.e->parameters);
    for (int k = 0; k < problem_terms(m.p); k++) {
        bool force = strcmp(problem_term_name(m.p, k), "force") == 0;
        double factor = problem_balance_weight(m.p, k);
        assert_true(force ? fabs(factor - 1e6) <= 1e-9 * 1e6 : factor >= 1 && factor < 1e6);
    }
    made_free(&m);
}

/* ---- without, memory, states and settings -------------------------------------------------------
 */

/* Who does not ask gets no weights, no memory for them and no program. */
static void test_not_asked_for(void **state)
{
    (void)state;
    const char *const changes[] = {SOFT, NULL};
    made m = make_problem(DYNAMIC, changes, 1);
    problem_array arrays[PROBLEM_STATE_MAX];
    problem_generator generators[PROBLEM_STATE_MAX];
    int generator_count;
    loss_at(&m, m.e->parameters, NULL);
    for (int step = 1; step < 4; step++) {
        assert_false(reweigh(&m, step, m.e->parameters));
    }
    for (int k = 0; k < m.p->set_count; k++) {
        const problem_set *set = &m.p->sets[k];
        assert_null(set->balance);
        assert_true(!set->point_weights && !set->point_losses);
        assert_null(set->share_gradient[0]);
    }
    assert_int_equal(problem_state(m.p, arrays, generators, &generator_count), m.p->set_count);
    assert_true(problem_balance_weight(m.p, 0) == 1);
    made_free(&m);
}

static void test_allocates_nothing(void **state)
{
    (void)state;
    for (int k = 0; k < 2; k++) {
        const char *const changes[] = {BALANCED, SOFT, NULL};
        made m = make_problem(DYNAMIC, changes, 1 + k);
        double *gradient = numbers(problem_parameters(m.p));
        loss_at(&m, m.e->parameters, gradient);
        reweigh(&m, 1, m.e->parameters);
        assert_true(allocations > 100); /* the hook is linked in */
        allocations = 0;
        for (int step = 101; step < 500; step += 100) {
            assert_true(reweigh(&m, step, m.e->parameters));
            loss_at(&m, m.e->parameters, gradient);
        }
        long seen = allocations;
        free(gradient);
        made_free(&m);
        assert_int_equal(seen, 0);
    }
}

static void test_bad_state(void **state)
{
    (void)state;
    static const struct {
        const char *name;
        double value;
    } bad[] = {{"balance/weights", -1},
               {"balance/weights", NAN},
               {"balance/weights", INFINITY},
               {"balance/updates", -1},
               {"balance/updates", NAN}};
    for (size_t k = 0; k < sizeof bad / sizeof *bad; k++) {
        const char *const changes[] = {BALANCED, SOFT, NULL};
        made m = make_problem(DYNAMIC, changes, 1);
        problem_array arrays[PROBLEM_STATE_MAX];
        problem_generator generators[PROBLEM_STATE_MAX];
        int generator_count, found = 0;
        int count = problem_state(m.p, arrays, generators, &generator_count);
        assert_true(count <= PROBLEM_STATE_MAX);
        assert_int_equal(problem_restored(m.p, NULL), AD_OK);
        for (int i = 0; i < count; i++) {
            if (strcmp(arrays[i].name, bad[k].name) == 0) {
                ad_error error = {AD_OK, ""};
                arrays[i].data[0] = bad[k].value;
                assert_int_equal(problem_restored(m.p, &error), AD_BAD_INPUT);
                assert_true(strlen(error.message) > 20 && !strchr(error.message, '\n'));
                found++;
            }
        }
        assert_int_equal(found, 1);
        made_free(&m);
    }
}

/* What a scene file refuses with its place, a program that fills in the settings is refused too. */
static void test_settings(void **state)
{
    (void)state;
    experiment *e = make_experiment(DYNAMIC, NULL, 1);
    const physics_model *m = e->model;
    const problem_settings good = e->settings->losses;
    problem_settings bad[3] = {good, good, good};
    assert_null(problem_settings_check(&good, m));
    bad[0].balance_every = 0;
    bad[1].balance_memory = 1;
    bad[2].balance_memory = -0.1;
    for (int i = 0; i < 3; i++) {
        assert_non_null(problem_settings_check(&bad[i], m));
    }
    experiment_free(e);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_balance),        cmocka_unit_test(test_balanced_loss),
        cmocka_unit_test(test_balance_causal), cmocka_unit_test(test_balance_floor),
        cmocka_unit_test(test_not_asked_for),  cmocka_unit_test(test_allocates_nothing),
        cmocka_unit_test(test_bad_state),      cmocka_unit_test(test_settings),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
