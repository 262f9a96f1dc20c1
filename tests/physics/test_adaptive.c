/* Points that move to where residuals are large. */
#include "allocations.h"
#include "fewer.h"
#include "training_testing.h"

#include "physics/learn/problem_internal.h"

#define DYNAMIC "configs/cantilever_deep.yaml"

/* Of two pieces along s. */
#define PIECES "segments=[{length: 0.1}, {length: 0.2, rest: {curvature: [0, 1, 0]}}]"

static made make(const char *path, const char *kind, const char *more, const char *again)
{
    char text[128];
    snprintf(text, sizeof text, "losses.interior.adaptive={kind: %s, every: 3, candidates: 2000}",
             kind);
    const char *const changes[] = {text, "losses.interior.points=200", more, again, NULL};
    return make_problem(path, changes, 1);
}

static double *points_of(const made *m)
{
    const problem_set *set = &m->p->sets[0];
    size_t numbers = set->trained.count * (size_t)m->p->model->domain.count;
    double *copy = malloc(numbers * sizeof *copy);
    assert_non_null(copy);
    memcpy(copy, set->trained.x, numbers * sizeof *copy);
    return copy;
}

/* |r| at a cloud, by the weights of the settings. */
static double *residuals(const made *m, const problem_cloud *cloud)
{
    problem_set *set = &m->p->sets[0];
    double *squares = malloc((size_t)set->term_count * cloud->count * sizeof *squares);
    assert_non_null(squares);
    assert_int_equal(problem_set_squares(set, cloud, m->e->parameters, squares, NULL), AD_OK);
    for (size_t k = 0; k < cloud->count; k++) {
        double sum = 0;
        for (int i = 0; i < set->term_count; i++) {
            sum += problem_term_weight(m->p, set->terms[i]) * squares[(size_t)i * cloud->count + k];
        }
        squares[k] = sqrt(sum);
    }
    return squares;
}

static bool moves(made *m, int64_t step)
{
    bool changed;
    assert_int_equal(problem_advance(m->p, step, m->e->parameters, &changed, NULL), AD_OK);
    assert_int_equal(problem_restored(m->p, NULL), AD_OK); /* all points lie inside */
    return changed;
}

/* The mean of |r| over points drawn with weights w is sum w r/sum w over the candidates, to four
 * standard errors and what drawing a hundredth of them without replacement takes off. */
static void test_density(void **state)
{
    (void)state;
    static const char *const more[] = {"losses.interior.adaptive.power=1",
                                       "losses.interior.adaptive.power=2"};
    for (int i = 0; i < 2; i++) {
        made m = make(DYNAMIC, "rad", more[i], "losses.interior.adaptive.candidates=20000");
        const problem_set *set = &m.p->sets[0];
        assert_false(moves(&m, 1));
        assert_false(moves(&m, 3));
        assert_true(moves(&m, 4));
        double *of = residuals(&m, &set->candidates), *now = residuals(&m, &set->trained);
        double plain = 0, mean = 0, sum = 0, first = 0, second = 0, found = 0;
        size_t count = set->candidates.count, points = set->trained.count;
        for (size_t k = 0; k < count; k++) {
            plain += of[k] / (double)count;
            mean += pow(of[k], i + 1) / (double)count;
        }
        for (size_t k = 0; k < count; k++) {
            double weight = pow(of[k], i + 1) / mean + 1;
            sum += weight;
            first += weight * of[k];
            second += weight * of[k] * of[k];
        }
        for (size_t k = 0; k < points; k++) {
            found += now[k] / (double)points;
        }
        first /= sum;
        double deviation = sqrt((second / sum - first * first) / (double)points);
        assert_true(fabs(found - first) < 4 * deviation + 0.01 * (first - plain));
        free(of);
        free(now);
        made_free(&m);
    }
}

static int descending(const void *a, const void *b)
{
    double x = *(const double *)a, y = *(const double *)b;
    return (x < y) - (x > y);
}

/* Ten times ten of 200 points become the worst ten candidates of the time; the others stay. */
static void test_greed(void **state)
{
    (void)state;
    made m = make(DYNAMIC, "rar_g", NULL, NULL);
    const problem_set *set = &m.p->sets[0];
    size_t points = set->trained.count, moved_in_all = 0;
    for (int64_t step = 1; step <= 40; step++) {
        double *before = points_of(&m);
        size_t moved = 0;
        bool due = step > 1 && step <= 31 && (step - 1) % 3 == 0;
        assert_int_equal(moves(&m, step), due);
        double *of = due ? residuals(&m, &set->candidates) : NULL;
        double *now = residuals(&m, &set->trained);
        if (due) {
            qsort(of, set->candidates.count, sizeof *of, descending);
        }
        for (size_t k = 0; k < points; k++) {
            bool stays =
                set->trained.x[k] == before[k] && set->trained.x[points + k] == before[points + k];
            assert_true(stays || (k >= points / 2 && now[k] >= of[9]));
            moved += !stays;
        }
        assert_int_equal(moved, due ? 10 : 0);
        moved_in_all += moved;
        free(before);
        free(of);
        free(now);
    }
    assert_int_equal(moved_in_all, 100);
    made_free(&m);
}

/* Half of the points lie around the worst ten candidates, the others stay. */
static void test_gaussians(void **state)
{
    (void)state;
    made m = make(DYNAMIC, "gaussian", "losses.interior.adaptive.width=0.01", NULL);
    const problem_set *set = &m.p->sets[0];
    size_t points = set->trained.count, count = set->trained.count;
    double *before = points_of(&m), square = 0;
    assert_true(moves(&m, 4));
    double *of = residuals(&m, &set->candidates);
    for (size_t k = 0; k < points; k++) {
        const double *x = set->trained.x;
        if (k < points / 2) {
            assert_true(x[k] == before[k] && x[count + k] == before[count + k]);
            continue;
        }
        double nearest = INFINITY; /* of the candidates, in parts of the ranges */
        for (size_t i = 0; i < set->candidates.count; i++) {
            size_t worse = 0;
            for (size_t j = 0; j < set->candidates.count; j++) {
                worse += of[j] > of[i];
            }
            const double *c = set->candidates.x;
            double t = (x[count + k] - c[set->candidates.count + i]) / m.p->setting.window[1];
            nearest = worse < 10 ? fmin(nearest, hypot(x[k] - c[i], t)) : nearest;
        }
        assert_true(nearest < 0.05); /* 5 standard deviations */
        square += nearest * nearest / 100;
    }
    assert_true(square > 1e-6); /* and not upon them */
    free(before);
    free(of);
    made_free(&m);
}

/* Also in pieces along s, and in the second window of time, all points lie inside; nothing is
 * allocated once points have moved. */
static void test_inside(void **state)
{
    (void)state;
    static const char *const kinds[] = {"rad", "rar_g", "gaussian"};
    for (int i = 0; i < 6; i++) {
        made m = i < 3 ? make("configs/elastica_deep.yaml", kinds[i], PIECES, "reference=null")
                       : make(DYNAMIC, kinds[i % 3], "time.windows=2", "network.hidden=[4]");
        double *start = calloc(1000 * 13, sizeof *start);
        assert_int_equal(domain_pieces(&m.p->model->domain), i < 3 ? 2 : 1);
        if (i >= 3) {
            assert_int_equal(problem_enter(m.p, 1, start, NULL), AD_OK);
        }
        assert_true(moves(&m, 4));
        allocations = 0;
        assert_true(moves(&m, 7));
        assert_true(allocations == 0);
        const problem_cloud *cloud = &m.p->sets[0].trained;
        for (size_t k = 0; i >= 3 && k < cloud->count; k++) {
            assert_true(problem_time_of(m.p, cloud, k) >= m.p->setting.window[0]);
        }
        free(start);
        made_free(&m);
    }
}

static void test_settings(void **state)
{
    (void)state;
    experiment *e = make_experiment(DYNAMIC, NULL, 1);
    problem_settings good = e->settings->losses, bad[7];
    good.adaptive.kind = PROBLEM_ADAPTIVE_RAD;
    assert_null(problem_settings_check(&good, e->model));
    for (int i = 0; i < 7; i++) {
        bad[i] = good;
    }
    bad[0].adaptive.kind = PROBLEM_ADAPTIVE_COUNT;
    bad[1].adaptive.every = 0;
    bad[2].adaptive.candidates = -1;
    bad[3].adaptive.power = 0;
    bad[4].adaptive.floor = NAN;
    bad[5].adaptive.width = 0;
    bad[6].interior.resample_every = 3;
    for (int i = 0; i < 7; i++) {
        assert_non_null(problem_settings_check(&bad[i], e->model));
    }
    experiment_free(e);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_density),
        cmocka_unit_test(test_greed),
        cmocka_unit_test(test_inside),
        cmocka_unit_test(test_settings),
    };
    const struct CMUnitTest alike[] = {cmocka_unit_test(test_gaussians)};
    return run_with_alike(tests, alike, NULL, NULL);
}
