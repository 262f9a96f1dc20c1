/* Problems of scenes whose elementwise work is compiled compute the same bits: loss, gradient, rows
 * of J and products with J^T J. Skipped (77) where there is no compiler. With names of scenes:
 * those instead, as they are. */
#include "training_testing.h"

#include <unistd.h>

enum { NORMAL_MAX = 2500 };

typedef struct numbers {
    double loss, *gradient, *product, *jtj;
} numbers;

static double *new_vector(size_t count)
{
    double *vector = calloc(count + 1, sizeof *vector);
    assert_non_null(vector);
    return vector;
}

static void must(ad_status status, const ad_error *error)
{
    if (status != AD_OK)
        fail_msg("%s", error->message);
}

static numbers compute(const made *m, const double *x)
{
    size_t n = problem_parameters(m->p);
    numbers result = {0, new_vector(n), new_vector(n), NULL};
    ad_error error = {AD_OK, ""};
    must(problem_evaluate(m->p, x, &result.loss, result.gradient, &error), &error);
    must(problem_normal_product(m->p, x, x, result.product, &error), &error);
    if (n <= NORMAL_MAX) {
        double *jtr = new_vector(n);
        result.jtj = new_vector(n * n);
        must(problem_normal_equations(m->p, x, &result.loss, result.jtj, jtr, &error), &error);
        free(jtr);
    }
    return result;
}

static void numbers_free(numbers *n)
{
    free(n->gradient);
    free(n->product);
    free(n->jtj);
}

/* With all programs that its steps may need. */
static made prepare(const char *path, const char *const *changes)
{
    made m = {changes ? make_experiment(path, changes, 1) : experiment_of(path, NULL, NULL), NULL};
    ad_error error = {AD_OK, ""};
    problem_least_squares sizes;
    must(experiment_problem(m.e, &m.p, &error), &error);
    must(problem_prepare_least_squares(m.p, &sizes, &error), &error);
    must(problem_prepare_product(m.p, &sizes, &error), &error);
    return m;
}

/* The next run takes what is kept. */
static void check_kept(const char *path, const char *const *changes, const char *folder)
{
    made m = prepare(path, changes);
    problem_fusing state;
    ad_error error = {AD_OK, ""};
    must(problem_fuse(m.p, folder, PROBLEM_FUSE_KEPT, &state, &error), &error);
    assert_int_equal(state.fused, state.programs);
    made_free(&m);
}

static void check(const char *path, const char *const *changes)
{
    char folder[] = "/tmp/cpinn_test_XXXXXX", command[64];
    made m = prepare(path, changes);
    ad_error error = {AD_OK, ""};
    problem_fusing state;
    assert_non_null(mkdtemp(folder));
    size_t n = problem_parameters(m.p);
    double *x = new_vector(n);
    memcpy(x, experiment_parameters(m.e), n * sizeof *x);
    for (size_t i = 0; i < n; i++)
        x[i] += 0.01 * sin(3.7 * (double)i); /* linear networks begin at 0 */
    numbers before = compute(&m, x);
    must(problem_fuse(m.p, folder, PROBLEM_FUSE_WAIT, &state, &error), &error);
    assert_int_equal(state.fused, state.programs);
    assert_true(state.programs > 0);
    numbers after = compute(&m, x);
    assert_memory_equal(&before.loss, &after.loss, sizeof before.loss);
    assert_memory_equal(before.gradient, after.gradient, n * sizeof *x);
    assert_memory_equal(before.product, after.product, n * sizeof *x);
    if (before.jtj)
        assert_memory_equal(before.jtj, after.jtj, n * n * sizeof *x);
    numbers_free(&before);
    numbers_free(&after);
    free(x);
    made_free(&m);
    check_kept(path, changes, folder);
    snprintf(command, sizeof command, "rm -r %s", folder);
    assert_int_equal(system(command), 0);
}

static const char *const deep[] = {"network.hidden=[13, 12]", NULL};

static void test_rod_in_motion(void **state)
{
    (void)state;
    check("configs/cantilever_deep.yaml", deep);
}

static void test_linear_network(void **state)
{
    (void)state;
    check("configs/beam_vibration.yaml", NULL);
}

int main(int count, char **names)
{
    if (system("cc --version > /dev/null 2>&1") != 0)
        return 77;
    for (int i = 1; i < count; i++) {
        check(names[i], NULL);
        printf("%s: the same bits\n", names[i]);
    }
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_rod_in_motion),
        cmocka_unit_test(test_linear_network),
    };
    return count > 1 ? 0 : cmocka_run_group_tests(tests, NULL, NULL);
}
