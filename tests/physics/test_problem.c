/* The loss of a scene: gradient, bits, allocations, causal weights, points, bad numbers. */
#include "allocations.h"
#include "fewer.h"
#include "training_testing.h"

#include "physics/learn/problem_internal.h"

/* ---- scenes ------------------------------------------------------------------------------------
 */

#define DYNAMIC  "configs/cantilever_deep.yaml"
#define FULL     "configs/manufactured_dynamic.yaml"
#define ELASTICA "configs/elastica_deep.yaml"

#define DISPLACEMENT  "formulation=displacement"
#define SOFT_BOUNDARY "enforcement.boundary=soft"
#define SOFT_INITIAL  "enforcement.initial=soft"

static const struct scene_case {
    const char *label, *path, *changes[8];
} cases[] = {
    {"static mixed", ELASTICA, {NULL}},
    {"static mixed soft", ELASTICA, {SOFT_BOUNDARY}},
    {"static displacement", "configs/heavy_cantilever.yaml", {DISPLACEMENT, "rod.model=cosserat"}},
    {"dynamic mixed", DYNAMIC, {NULL}},
    {"dynamic mixed soft", DYNAMIC, {SOFT_BOUNDARY, SOFT_INITIAL}},
    {"dynamic displacement", DYNAMIC, {DISPLACEMENT}},
    {"dynamic causal", DYNAMIC, {"losses.causal.slices=4", SOFT_BOUNDARY, SOFT_INITIAL}},
    {"full mixed", FULL, {NULL}},
    {"full displacement soft", FULL, {DISPLACEMENT, SOFT_BOUNDARY, SOFT_INITIAL}},
};

enum { CASES = sizeof cases / sizeof *cases };

static made make_case(const struct scene_case *row, int threads)
{
    return make_problem(row->path, row->changes, threads);
}

static double *copy_of(const double *x, size_t count)
{
    double *copy = malloc(count * sizeof *copy);
    assert_non_null(copy);
    memcpy(copy, x, count * sizeof *copy);
    return copy;
}

/* ---- value and gradient ------------------------------------------------------------------------
 */

/* Central differences of fourth order, (8 (f(h) - f(-h)) - (f(2h) - f(-2h))) / 12h. */
static double difference(const made *m, double *x, size_t i, double h)
{
    static const double at[4] = {1, -1, 2, -2}, weight[4] = {8, -8, -1, 1};
    double before = x[i], sum = 0;
    for (int k = 0; k < 4; k++) {
        x[i] = before + at[k] * h;
        sum += weight[k] * loss_at(m, x, NULL);
    }
    x[i] = before;
    return sum / (12 * h);
}

static void test_gradient(void **state)
{
    (void)state;
    for (int c = 0; c < CASES; c++) {
        made m = make_case(&cases[c], 1);
        size_t count = problem_parameters(m.p);
        double *x = copy_of(m.e->parameters, count), *gradient = copy_of(x, count);
        loss_at(&m, x, gradient);
        double largest = 0, worst = 0;
        for (size_t i = 0; i < count; i++) {
            largest = fmax(largest, fabs(gradient[i]));
        }
        assert_true(largest > 0);
        for (size_t i = 0; i < count; i += 7) {
            worst = fmax(worst, fabs(difference(&m, x, i, 1e-3) - gradient[i]));
        }
        /* The next term is h^4 f5 / 30 with h = 1e-3, and rounding 1e-16 / h of the loss. */
        if (!(worst <= 1e-7 * largest)) {
            fail_msg("%s: off by %g of %g", cases[c].label, worst, largest);
        }
        free(x);
        free(gradient);
        made_free(&m);
    }
}

/* The loss is the weighted sum of its terms, and the gradient that of the terms alone. */
static void test_terms(void **state)
{
    (void)state;
    for (int c = 0; c < CASES; c++) {
        made m = make_case(&cases[c], 1);
        size_t count = problem_parameters(m.p);
        double *gradient = copy_of(m.e->parameters, count), *one = copy_of(gradient, count);
        double loss = loss_at(&m, m.e->parameters, gradient), sum = 0, largest = 0;
        bool causal = m.e->settings->losses.causal_slices > 0;
        for (int k = 0; k < problem_terms(m.p); k++) {
            double value;
            assert_int_equal(problem_evaluate_term(m.p, k, m.e->parameters, &value, one, NULL),
                             AD_OK);
            /* Two programs may add the points up in another order. */
            assert_true(fabs(value - problem_losses(m.p)[k]) <= 1e-12 * value);
            assert_true(problem_term_weight(m.p, k) > 0 && problem_term_name(m.p, k)[0]);
            sum += problem_term_weight(m.p, k) * value;
            for (size_t i = 0; i < count; i++) {
                largest = fmax(largest, fabs(gradient[i]));
                gradient[i] -= problem_term_weight(m.p, k) * one[i];
            }
        }
        assert_true(causal ? loss < sum : fabs(loss - sum) <= 1e-12 * sum);
        for (size_t i = 0; i < count && !causal; i++) {
            assert_true(fabs(gradient[i]) <= 1e-11 * largest);
        }
        free(gradient);
        free(one);
        made_free(&m);
    }
}

static void test_same_bits(void **state)
{
    (void)state;
    for (int c = 0; c < CASES; c++) {
        double first_loss = 0, *first = NULL;
        for (int threads = 1; threads <= 3; threads++) {
            struct scene_case row = cases[c];
            int changes = 0;
            while (row.changes[changes]) {
                changes++;
            }
            row.changes[changes] = "losses.interior.points=1500"; /* several tiles */
            made m = make_case(&row, threads);
            size_t count = problem_parameters(m.p);
            double *gradient = copy_of(m.e->parameters, count);
            for (int again = 0; again < 2; again++) {
                double loss = loss_at(&m, m.e->parameters, gradient);
                if (!first) {
                    first = copy_of(gradient, count);
                    first_loss = loss;
                }
                assert_memory_equal(&loss, &first_loss, sizeof loss);
                assert_memory_equal(gradient, first, count * sizeof *first);
                memset(gradient, 0, count * sizeof *gradient);
            }
            free(gradient);
            made_free(&m);
        }
        free(first);
    }
}

static void test_allocates_nothing(void **state)
{
    (void)state;
    for (int c = 0; c < CASES; c++) {
        for (int threads = 1; threads <= 2; threads++) {
            made m = make_case(&cases[c], threads);
            size_t count = problem_parameters(m.p);
            double *gradient = copy_of(m.e->parameters, count), held_out;
            bool changed;
            loss_at(&m, m.e->parameters, gradient);
            problem_held_out(m.p, m.e->parameters, &held_out, NULL, NULL);
            assert_true(allocations > 100); /* the hook is linked in */
            allocations = 0;
            for (int64_t step = 1; step < 120; step += 10) {
                problem_advance(m.p, step, m.e->parameters, &changed, NULL);
                loss_at(&m, m.e->parameters, gradient);
                problem_held_out(m.p, m.e->parameters, &held_out, NULL, NULL);
            }
            long seen = allocations;
            free(gradient);
            made_free(&m);
            assert_int_equal(seen, 0);
        }
    }
}

/* ---- points ------------------------------------------------------------------------------------
 */

static uint64_t points_of_set(problem *p, const char *name)
{
    problem_array arrays[PROBLEM_STATE_MAX];
    problem_generator generators[PROBLEM_STATE_MAX];
    int generator_count, count = problem_state(p, arrays, generators, &generator_count);
    for (int i = 0; i < count; i++) {
        if (strcmp(arrays[i].name, name) == 0) {
            return fingerprint(arrays[i].data, arrays[i].rows * arrays[i].columns);
        }
    }
    fail_msg("no %s", name);
    return 0;
}

static void test_resampling(void **state)
{
    (void)state;
    static const char *const samplers[] = {"uniform", "latin_hypercube", "sobol"};
    for (int k = 0; k < 3; k++) {
        char interior[64];
        snprintf(interior, sizeof interior, "losses.interior.sampler=%s", samplers[k]);
        const char *changes[] = {SOFT_BOUNDARY,
                                 SOFT_INITIAL,
                                 interior,
                                 "losses.interior.resample_every=3",
                                 "losses.initial.resample_every=5",
                                 "losses.initial.sampler=uniform",
                                 "losses.boundary.sampler=uniform",
                                 NULL};
        made m = make_problem(DYNAMIC, changes, 1);
        uint64_t inside = points_of_set(m.p, "points/interior");
        uint64_t initial = points_of_set(m.p, "points/initial");
        uint64_t start = points_of_set(m.p, "points/start");
        for (int64_t step = 1; step <= 31; step++) {
            bool changed;
            assert_int_equal(problem_advance(m.p, step, m.e->parameters, &changed, NULL), AD_OK);
            uint64_t now_inside = points_of_set(m.p, "points/interior");
            uint64_t now_initial = points_of_set(m.p, "points/initial");
            bool third = step > 1 && (step - 1) % 3 == 0, fifth = step > 1 && (step - 1) % 5 == 0;
            assert_int_equal(now_inside != inside, third);
            assert_int_equal(now_initial != initial, fifth);
            assert_int_equal(changed, third || fifth);
            assert_true(points_of_set(m.p, "points/start") == start);
            assert_int_equal(problem_restored(m.p, NULL), AD_OK);
            inside = now_inside;
            initial = now_initial;
        }
        made_free(&m);
    }
}

/* No point of what is watched is a point of what is trained on, whatever the sampler. A set that
 * is a single point, an end of a static rod, has no other. */
static void test_held_out(void **state)
{
    (void)state;
    static const char *const samplers[] = {"uniform",   "latin_hypercube",   "sobol",
                                           "chebyshev", "chebyshev_lobatto", "grid"};
    for (int k = 0; k < 6; k++) {
        char texts[3][64];
        const char *changes[8] = {SOFT_BOUNDARY, SOFT_INITIAL, "losses.held_out_points=64",
                                  "losses.interior.points=64"};
        static const char *const sets[] = {"interior", "boundary", "initial"};
        for (int i = 0; i < 3; i++) {
            snprintf(texts[i], sizeof texts[i], "losses.%s.sampler=%s", sets[i], samplers[k]);
            changes[4 + i] = texts[i];
        }
        made m = make_problem(DYNAMIC, changes, 1);
        for (int i = 0; i < problem_sets(m.p); i++) {
            const problem_cloud *a = &m.p->sets[i].trained, *b = &m.p->sets[i].held_out;
            assert_int_equal(b->count, 64);
            for (size_t n = 0; n < a->count * b->count; n++) {
                size_t one = n / b->count, other = n % b->count;
                assert_false(a->x[one] == b->x[other] &&
                             a->x[a->count + one] == b->x[b->count + other]);
            }
        }
        made_free(&m);
    }
}

/* ---- causal weights ----------------------------------------------------------------------------
 */

static void test_causal(void **state)
{
    (void)state;
    enum { SLICES = 4 };
    static const char *const changes[] = {"losses.causal.slices=4",
                                          "losses.causal.epsilon=[1e-6, 1e-4, 1e-3]",
                                          "losses.causal.threshold=0.5",
                                          "losses.causal.update_every=2",
                                          SOFT_INITIAL,
                                          NULL};
    static const double epsilons[] = {1e-6, 1e-4, 1e-3};
    made m = make_problem(DYNAMIC, changes, 1);
    problem_set *set = &m.p->sets[0];
    double weights[SLICES] = {1, 0, 0, 0}; /* until the first update only the first slice counts */
    int at = 0, advanced = 0;
    for (int64_t step = 1; step <= 12; step++) {
        bool changed;
        double losses[SLICES] = {0}, counts[SLICES] = {0}, before = 0, loss;
        double epsilon = epsilons[at];
        for (size_t i = 0; i < set->trained.count; i++) {
            int slice =
                (int)(problem_time_of(m.p, &set->trained, i) / m.p->setting.window[1] * SLICES);
            losses[slice] += set->point_losses[i];
            counts[slice]++;
        }
        assert_int_equal(problem_advance(m.p, step, m.e->parameters, &changed, NULL), AD_OK);
        assert_int_equal(changed, step > 1 && step % 2 == 1);
        if (changed) {
            for (int k = 0; k < SLICES; k++) {
                weights[k] = exp(-epsilon * before);
                before += losses[k] / counts[k];
            }
            at += weights[SLICES - 1] > 0.5 && at < 2;
        }
        advanced += changed;
        assert_true(problem_causal_epsilon(m.p) == epsilons[at]);
        assert_true(problem_causal_least_weight(m.p) == weights[SLICES - 1]);
        for (size_t i = 0; i < set->trained.count; i++) {
            int slice =
                (int)(problem_time_of(m.p, &set->trained, i) / m.p->setting.window[1] * SLICES);
            assert_true(set->point_weights[i] == weights[slice]);
        }
        assert_int_equal(problem_evaluate(m.p, m.e->parameters, &loss, NULL, NULL), AD_OK);
        double sum = 0, initial = 0;
        for (size_t i = 0; i < set->trained.count; i++) {
            sum += set->point_weights[i] * set->point_losses[i] / (double)set->trained.count;
        }
        for (int k = set->term_count; k < problem_terms(m.p); k++) {
            initial += problem_term_weight(m.p, k) * problem_losses(m.p)[k];
        }
        assert_true(fabs(loss - sum - initial) <= 1e-12 * loss); /* another order of summation */
    }
    assert_true(advanced == 5 && at == 2); /* so that every epsilon was reached */
    made_free(&m);
}

/* New points get the weights of their slices also before the first update; causal weighting of
 * nothing is no weighting. */
static void test_causal_corners(void **state)
{
    (void)state;
    static const char *const early[] = {"losses.causal.slices=2",
                                        "losses.interior.resample_every=3",
                                        "losses.interior.sampler=uniform", NULL};
    made m = make_problem(DYNAMIC, early, 1);
    bool changed;
    for (int64_t step = 1; step <= 4; step++) {
        assert_int_equal(problem_advance(m.p, step, m.e->parameters, &changed, NULL), AD_OK);
        for (size_t i = 0; i < m.p->sets[0].trained.count; i++) {
            assert_true(
                m.p->sets[0].point_weights[i] ==
                (problem_time_of(m.p, &m.p->sets[0].trained, i) < m.p->setting.window[1] / 2));
        }
    }
    assert_true(changed);
    made_free(&m);
    static const char *const outside[] = {"losses.causal.slices=2",
                                          "losses.causal.update_every=1",
                                          "losses.interior.weights.strain=0",
                                          "losses.interior.weights.curvature=0",
                                          "losses.interior.weights.force=0",
                                          "losses.interior.weights.moment=0",
                                          SOFT_INITIAL,
                                          NULL};
    m = make_problem(DYNAMIC, outside, 1);
    double loss;
    problem_array arrays[PROBLEM_STATE_MAX];
    problem_generator generators[PROBLEM_STATE_MAX];
    int generator_count;
    for (int64_t step = 1; step <= 3; step++) {
        assert_int_equal(problem_advance(m.p, step, m.e->parameters, &changed, NULL), AD_OK);
        assert_int_equal(problem_evaluate(m.p, m.e->parameters, &loss, NULL, NULL), AD_OK);
        assert_false(changed);
    }
    assert_int_equal(problem_state(m.p, arrays, generators, &generator_count), 1);
    made_free(&m);
}

/* A restored state that nobody could have saved. */
static void test_bad_state(void **state)
{
    (void)state;
    static const char *const changes[] = {"losses.causal.slices=4", SOFT_INITIAL, NULL};
    static const struct {
        const char *name;
        double value;
    } bad[] = {{"points/interior", 1.5},      {"points/interior", -1e-9},
               {"points/interior", NAN},      {"points/initial", INFINITY},
               {"causal/weights", 1.1},       {"causal/weights", NAN},
               {"causal/epsilon_index", 5},   {"causal/epsilon_index", -1},
               {"causal/epsilon_index", NAN}, {"causal/point_weights", -0.1},
               {"causal/point_weights", NAN}, {"causal/point_losses", -1},
               {"causal/point_losses", NAN}};
    made m = make_problem(DYNAMIC, changes, 1);
    problem_array arrays[PROBLEM_STATE_MAX];
    problem_generator generators[PROBLEM_STATE_MAX];
    int generator_count, count = problem_state(m.p, arrays, generators, &generator_count);
    assert_int_equal(problem_restored(m.p, NULL), AD_OK);
    for (size_t k = 0; k < sizeof bad / sizeof *bad; k++) {
        int found = 0;
        for (int i = 0; i < count; i++) {
            if (strcmp(arrays[i].name, bad[k].name) == 0) {
                ad_error error = {AD_OK, ""};
                double good = arrays[i].data[0];
                if (arrays[i].drawn) {
                    arrays[i].drawn->still = false; /* else they would be drawn again */
                }
                arrays[i].data[0] = bad[k].value;
                assert_int_equal(problem_restored(m.p, &error), AD_BAD_INPUT);
                assert_true(strlen(error.message) > 20 && !strchr(error.message, '\n'));
                arrays[i].data[0] = good;
                found++;
            }
        }
        assert_int_equal(found, 1);
    }
    assert_int_equal(problem_restored(m.p, NULL), AD_OK);
    made_free(&m);
}

/* ---- bad numbers -------------------------------------------------------------------------------
 */

/* A load that stops being finite only beyond s = 1.93 m (NaN), or after t = 0.96 s, where no check
 * looks: the place named lies there, in SI units, and the term is the balance of forces. */
static void test_locate(void **state)
{
    (void)state;
    static const char *const beyond[] = {"loads.force=[0, 0, \"log(1.93-s)\"]", "rod.length=2",
                                         "loads.tip=null", "reference.file=null", NULL};
    static const char *const later[] = {"loads.force=[0, \"sqrt(0.96-t)\", 0]", "loads.tip=null",
                                        "reference.file=null", NULL};
    for (int k = 0; k < 2; k++) {
        made m = make_problem(DYNAMIC, k ? later : beyond, 1);
        double loss = 0, *gradient = copy_of(m.e->parameters, problem_parameters(m.p));
        problem_place place;
        ad_error error = {AD_OK, ""};
        assert_int_equal(problem_evaluate(m.p, m.e->parameters, &loss, gradient, &error),
                         AD_NOT_FINITE);
        assert_true(strlen(error.message) > 10);
        assert_int_equal(problem_locate(m.p, m.e->parameters, &place, NULL), AD_OK);
        assert_true(place.term >= 0);
        assert_string_equal(problem_term_name(m.p, place.term), "force");
        assert_true(k ? place.x[1] > 0.96 && place.x[1] <= 1
                      : place.x[0] > 1.93 && place.x[0] <= 2);
        free(gradient);
        made_free(&m);
    }
}

/* Parameters so large that squares overflow; finite ones have no such place. */
static void test_locate_parameters(void **state)
{
    (void)state;
    for (int c = 0; c < CASES; c++) {
        made m = make_case(&cases[c], 1);
        size_t count = problem_parameters(m.p);
        double loss, *x = copy_of(m.e->parameters, count);
        problem_place place;
        assert_int_equal(problem_locate(m.p, x, &place, NULL), AD_OK);
        assert_int_equal(place.term, -1);
        for (size_t i = 0; i < count; i++) {
            x[i] *= 1e200;
        }
        assert_int_equal(problem_evaluate(m.p, x, &loss, NULL, NULL), AD_NOT_FINITE);
        assert_int_equal(problem_locate(m.p, x, &place, NULL), AD_OK);
        assert_in_range(place.term, 0, problem_terms(m.p) - 1);
        assert_true(place.x[0] >= 0 && place.x[0] <= scene_length(m.e->scene));
        assert_true(place.x[1] >= 0 && place.x[1] <= scene_duration(m.e->scene));
        free(x);
        made_free(&m);
    }
}

static void test_nothing_to_learn(void **state)
{
    (void)state;
    static const char *const changes[] = {NULL};
    experiment *e = make_experiment(DYNAMIC, changes, 1);
    for (int i = 0; i < e->model->term_count; i++) { /* a scene file with these is refused */
        e->model->terms[i].weight = 0;
    }
    problem *p = (problem *)e;
    ad_error error = {AD_OK, ""};
    assert_int_equal(experiment_problem(e, &p, &error), AD_BAD_INPUT);
    assert_null(p);
    assert_non_null(strstr(error.message, "weight 0"));
    experiment_free(e);
    problem_free(NULL);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_resampling),       cmocka_unit_test(test_held_out),
        cmocka_unit_test(test_causal),           cmocka_unit_test(test_causal_corners),
        cmocka_unit_test(test_bad_state),        cmocka_unit_test(test_locate),
        cmocka_unit_test(test_nothing_to_learn),
    };
    const struct CMUnitTest alike[] = {
        cmocka_unit_test(test_same_bits), cmocka_unit_test(test_allocates_nothing),
        cmocka_unit_test(test_terms), cmocka_unit_test(test_gradient),
        cmocka_unit_test(test_locate_parameters)};
    return run_with_alike(tests, alike, NULL, NULL);
}
