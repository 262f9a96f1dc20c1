/* The self-scaled Broyden method: its matrix against dense formulas, known minima, bits. The line
 * search and its endings are those of test_optim_lbfgs.c. */
#include "optim_testing.h"

#include "allocations.h"

static optim_optimizer *make(size_t count, const double *x)
{
    const optim_settings settings = optim_settings_defaults(OPTIM_SSBROYDEN);
    optim_optimizer *ssb = create_ssbroyden(count, x, &settings, NULL);
    assert_non_null(ssb);
    return ssb;
}

static optim_status steps(optim_optimizer *ssb, problem *p, int number)
{
    optim_status status = OPTIM_RUNNING;
    for (int i = 0; i < number && status == OPTIM_RUNNING; i++) {
        status = step_by(ssb, objective, p);
    }
    return status;
}

static optim_array array(optim_optimizer *ssb, const char *name)
{
    optim_array arrays[OPTIM_STATE_CAPACITY];
    const int count = optim_state(ssb, arrays);
    int i = 0;
    while (i < count && strcmp(arrays[i].name, name) != 0) {
        i++;
    }
    assert_true(i < count);
    return arrays[i];
}

/* Value and gradient of the state are those of the objective at the current point. */
static void assert_state_consistent(optim_optimizer *ssb, const problem *p)
{
    double gradient[MAX_COUNT];
    const double value = p->f(p->count, optim_x(ssb), gradient);
    assert_true(optim_inspect(ssb).value == value);
    assert_memory_equal(array(ssb, "gradient").data, gradient, p->count * sizeof *gradient);
}

/* ---- the matrix against dense formulas ---- */

enum { N = 12 };

typedef struct moment {
    double h[N][N], x[N], g[N];
} moment;

static moment look(optim_optimizer *ssb)
{
    moment m;
    const double *triangle = array(ssb, "matrix").data;
    for (int i = 0; i < N; i++) {
        for (int j = 0; j <= i; j++) {
            m.h[i][j] = m.h[j][i] = *triangle++;
        }
    }
    memcpy(m.x, optim_x(ssb), sizeof m.x);
    memcpy(m.g, array(ssb, "gradient").data, sizeof m.g);
    return m;
}

/* Cholesky, in place; 0 when not positive definite. */
static int factor(double a[N][N])
{
    for (int j = 0; j < N; j++) {
        for (int i = j; i < N; i++) {
            for (int k = 0; k < j; k++) {
                a[i][j] -= a[i][k] * a[j][k];
            }
            if (i == j && !(a[j][j] > 0)) {
                return 0;
            }
            a[i][j] = i == j ? sqrt(a[j][j]) : a[i][j] / a[j][j];
        }
    }
    return 1;
}

/* s.H^-1 s = |L^-1 s|^2 */
static double inverse_form(double h[N][N], const double *s)
{
    double l[N][N], z[N];
    memcpy(l, h, sizeof l);
    assert_true(factor(l));
    for (int i = 0; i < N; i++) {
        z[i] = s[i];
        for (int k = 0; k < i; k++) {
            z[i] -= l[i][k] * z[k];
        }
        z[i] /= l[i][i];
    }
    return dot(N, z, z);
}

static void multiply(double h[N][N], const double *v, double *result)
{
    for (int i = 0; i < N; i++) {
        result[i] = dot(N, h[i], v);
    }
}

/* Which of the cases of theta have been met. */
typedef struct cases {
    int positive, lowest, highest, between;
} cases;

/* H+ by the formulas as published, with b from the inverse of H; at the first pair H is gamma I and
 * keeps its scale. */
static void expect(moment *m, const double *s, const double *y, int first, cases *met,
                   double result[N][N])
{
    double hy[N];
    const double sy = dot(N, s, y);
    for (int i = 0; first && i < N; i++) {
        for (int j = 0; j < N; j++) {
            m->h[i][j] = i == j ? sy / dot(N, y, y) : 0;
        }
    }
    multiply(m->h, y, hy);
    const double yhy = dot(N, y, hy), b = inverse_form(m->h, s) / sy, h = yhy / sy, a = h * b - 1;
    const double c = sqrt(a / (1 + a)), rho_minus = fmin(1, h * (1 - c));
    const double low = (rho_minus - 1) / a, high = 1 / rho_minus, middle = (1 - b) / b;
    const double theta = fmax(low, fmin(high, middle)), sigma = 1 + a * theta;
    const double phi = (1 - theta) / sigma, rho_plus = fmin(1, 1 / b);
    const double root = pow(sigma, -1. / (N - 1));
    double tau = theta > 0 ? rho_plus * fmin(root, 1 / theta) : fmin(rho_plus * root, sigma);
    tau = first ? 1 : tau;
    met->positive += theta > 0;
    met->lowest += theta == low;
    met->highest += theta == high;
    met->between += theta == middle;
    for (int i = 0; i < N; i++) {
        for (int j = 0; j < N; j++) {
            const double vi = s[i] / sy - hy[i] / yhy, vj = s[j] / sy - hy[j] / yhy;
            result[i][j] =
                (m->h[i][j] - hy[i] * hy[j] / yhy + phi * yhy * vi * vj) / tau + s[i] * s[j] / sy;
        }
    }
}

/* One step from `before` to `after`. */
static void check_update(moment *before, moment *after, int first, cases *met)
{
    double s[N], y[N], got[N], wanted[N][N], largest = 0;
    for (int i = 0; i < N; i++) {
        s[i] = after->x[i] - before->x[i];
        y[i] = after->g[i] - before->g[i];
    }
    expect(before, s, y, first, met, wanted);
    for (int i = 0; i < N; i++) {
        for (int j = 0; j < N; j++) {
            largest = fmax(largest, fabs(wanted[i][j]));
        }
    }
    /* The inverse of a matrix of condition 1e6 and a = h b - 1 lose digits: 1e-8 was seen. */
    for (int i = 0; i < N; i++) {
        assert_below(distance(N, after->h[i], wanted[i]), 1e-7 * largest);
    }
    multiply(after->h, y, got); /* the secant equation, to rounding in the product */
    assert_below(distance(N, got, s), 1e-14 * N * largest * sqrt(dot(N, y, y)));
    double l[N][N];
    memcpy(l, after->h, sizeof l);
    assert_true(factor(l));
}

static void test_update(void **state)
{
    (void)state;
    static const formula functions[] = {chained_rosenbrock, rosenbrock, turned_quadratic, barrier};
    cases met = {0};
    for (size_t k = 0; k < sizeof functions / sizeof *functions; k++) {
        double x[N];
        for (int i = 0; i < N; i++) {
            x[i] = functions[k] == barrier ? 3 + i : i % 2 ? 1 : -1.2;
        }
        problem p = make_problem(functions[k], N);
        optim_optimizer *ssb = make(N, x);
        assert_int_equal(steps(ssb, &p, 1), OPTIM_RUNNING); /* evaluates the start as well */
        moment before = look(ssb);
        for (int i = 0; i < 12; i++) {
            assert_int_equal(steps(ssb, &p, 1), OPTIM_RUNNING);
            assert_int_equal(optim_inspect(ssb).pairs, i + 2);
            moment after = look(ssb);
            check_update(&before, &after, 0, &met);
            before = after;
        }
        optim_objective_changed(ssb);
        p.f(N, optim_x(ssb), before.g);
        assert_int_equal(steps(ssb, &p, 1), OPTIM_RUNNING);
        moment after = look(ssb);
        check_update(&before, &after, 1, &met);
        optim_free(ssb);
    }
    assert_true(met.positive > 3 && met.lowest > 0 && met.between > 3 && met.highest > 0);
}

/* ---- minima ---- */

typedef struct known {
    formula f;
    size_t count;
    double start[2]; /* of the even and the odd variables */
    double minimum;
    int most; /* evaluations */
} known;

static void test_minima(void **state)
{
    (void)state;
    static const known all[] = {
        {rosenbrock, 2, {-1.2, 1}, 0, 100},           {rosenbrock, 10, {-1.2, 1}, 0, 200},
        {chained_rosenbrock, 20, {0.5, 0.6}, 0, 300}, {diagonal_quadratic, 20, {3, -3}, 0, 300},
        {turned_quadratic, 20, {3, -3}, 0, 300},      {barrier, 10, {20, 1e-3}, 10, 300},
        {hyperbolic_cosine, 1, {50, 0}, 1, 120},
    };
    for (size_t k = 0; k < sizeof all / sizeof *all; k++) {
        double x[MAX_COUNT];
        for (size_t i = 0; i < all[k].count; i++) {
            x[i] = all[k].start[i % 2];
        }
        problem p = make_problem(all[k].f, all[k].count);
        optim_optimizer *ssb = make(all[k].count, x);
        double before = INFINITY;
        for (int i = 0; i < 400 && steps(ssb, &p, 1) == OPTIM_RUNNING; i++) {
            const optim_info info = optim_inspect(ssb);
            assert_true(info.value <= before && info.best_value == p.lowest);
            before = info.value;
        }
        /* Near its minimum the value is rounded; zero is reached to the square of rounding. */
        assert_near(before, all[k].minimum, 1e-14 * fmax(1, all[k].minimum));
        assert_memory_equal(best_x_of(ssb), p.lowest_x, p.count * sizeof(double));
        assert_state_consistent(ssb, &p);
        if (p.evaluations > all[k].most) {
            fail_msg("problem %zu took %ld evaluations", k, p.evaluations);
        }
        optim_free(ssb);
    }
}

/* The gradient falls ever faster: on a quadratic of condition 1e6, ten steps bring it down by 1e6
 * in the end, where steepest descent gains a factor 1 - 2e-6 per step. */
static void test_superlinear(void **state)
{
    (void)state;
    double x[20], norms[200];
    classic_start(20, x);
    problem p = make_problem(turned_quadratic, 20);
    optim_optimizer *ssb = make(20, x);
    int n = 0;
    while (n < 200 && steps(ssb, &p, 1) == OPTIM_RUNNING) {
        norms[n++] = optim_inspect(ssb).gradient_norm;
        if (norms[n - 1] < 1e-7) { /* rounding of gradients of 1e6 is 1e-10 */
            break;
        }
    }
    assert_true(n > 12 && n < 120);
    assert_below(norms[n - 1], 1e-6 * norms[n - 11]);
    optim_free(ssb);
}

/* ---- safeguards ---- */

/* A threshold that most pairs miss: they are dropped, and the run still descends. */
static void test_skips(void **state)
{
    (void)state;
    double x[10];
    classic_start(10, x);
    optim_settings settings = optim_settings_defaults(OPTIM_SSBROYDEN);
    settings.curvature_threshold = 0.9;
    problem p = make_problem(rosenbrock, 10);
    optim_optimizer *ssb = create_ssbroyden(10, x, &settings, NULL);
    for (int i = 0; i < 50; i++) {
        const double before = optim_inspect(ssb).value;
        assert_int_equal(steps(ssb, &p, 1), OPTIM_RUNNING);
        assert_true(optim_inspect(ssb).value < before);
    }
    const optim_info info = optim_inspect(ssb);
    assert_true(info.skipped > 10 && info.pairs > 0);
    assert_int_equal(info.pairs + info.skipped, info.steps);
    optim_free(ssb);
}

/* The objective misbehaves from the first, the second, or a later evaluation on; then the run goes
 * on to the minimum. */
static void test_endings(void **state)
{
    (void)state;
    double x[10];
    classic_start(10, x);
    for (int how = STOP; how <= WRONG_GRADIENT; how++) {
        for (long from = how == WRONG_GRADIENT ? 20 : 1; from < 25; from++) {
            problem p = make_problem(rosenbrock, 10);
            p.misbehave_from = from;
            p.misbehaviour = how;
            optim_optimizer *ssb = make(10, x);
            const optim_status status = steps(ssb, &p, 100);
            if (how == STOP) {
                assert_int_equal(status, OPTIM_STOPPED_BY_OBJECTIVE);
            } else if (how == WRONG_GRADIENT) {
                assert_int_equal(status, OPTIM_LINE_SEARCH_FAILED);
                assert_true(optim_inspect(ssb).resets >= 1);
            } else if (from == 1) {
                assert_int_equal(status, OPTIM_NOT_FINITE);
            } else {
                assert_true(status == OPTIM_NO_FINITE_STEP || status == OPTIM_LINE_SEARCH_FAILED);
            }
            assert_true(optim_inspect(ssb).best_value == p.lowest);
            if (from > 1 && how != WRONG_GRADIENT) {
                assert_state_consistent(ssb, &p);
                p.misbehave_from = 0;
                steps(ssb, &p, 300);
                assert_below(optim_inspect(ssb).value, 1e-14);
            }
            optim_free(ssb);
        }
    }
}

/* After a change of the objective the run is that of a new optimiser at the same point. */
static void test_objective_changed(void **state)
{
    (void)state;
    double x[10];
    classic_start(10, x);
    problem first = make_problem(rosenbrock, 10), second = make_problem(chained_rosenbrock, 10);
    optim_optimizer *ssb = make(10, x);
    assert_int_equal(steps(ssb, &first, 12), OPTIM_RUNNING);
    optim_objective_changed(ssb);
    assert_int_equal(optim_inspect(ssb).pairs, 0);
    optim_optimizer *fresh = make(10, optim_x(ssb));
    for (int i = 0; i < 20; i++) {
        assert_int_equal(steps(ssb, &second, 1), steps(fresh, &second, 1));
        assert_memory_equal(optim_x(ssb), optim_x(fresh), sizeof x);
        assert_true(optim_inspect(ssb).best_value == optim_inspect(fresh).best_value);
    }
    optim_free(ssb);
    optim_free(fresh);
}

/* ---- memory, state ---- */

static void test_create(void **state)
{
    (void)state;
    const double bad_x[2] = {0, NAN};
    static double many[OPTIM_SSBROYDEN_COUNT_MAX + 1];
    const char *why = NULL;
    optim_settings settings = optim_settings_defaults(OPTIM_SSBROYDEN);
    assert_null(create_ssbroyden(2, bad_x, &settings, &why));
    assert_non_null(strstr(why, "finite"));
    assert_null(create_ssbroyden(0, many, &settings, &why));
    assert_non_null(strstr(why, "count"));
    assert_null(create_ssbroyden(OPTIM_SSBROYDEN_COUNT_MAX + 1, many, &settings, &why));
    assert_non_null(strstr(why, "10000"));
    settings.curvature = 2;
    assert_null(create_ssbroyden(2, many, &settings, &why));
    assert_non_null(strstr(why, "curvature"));
    optim_free(NULL);
}

/* Every allocation of create fails once: no crash, no leak (run under ASan), and a reason. Steps
 * allocate nothing. */
static void test_allocation(void **state)
{
    (void)state;
    const optim_settings settings = optim_settings_defaults(OPTIM_SSBROYDEN);
    double x[10];
    classic_start(10, x);
    problem p = make_problem(rosenbrock, 10);
    optim_optimizer *ssb = NULL;
    long n = 0;
    while (!ssb) {
        const char *why = NULL;
        allocations = 0;
        failing_allocation = ++n;
        ssb = create_ssbroyden(10, x, &settings, &why);
        failing_allocation = 0;
        assert_true(ssb || (why && strcmp(why, "out of memory") == 0));
    }
    assert_true(n > 2); /* the hook is linked in */
    allocations = 0;
    assert_int_equal(steps(ssb, &p, 20), OPTIM_RUNNING);
    optim_objective_changed(ssb);
    assert_int_equal(steps(ssb, &p, 5), OPTIM_RUNNING);
    assert_int_equal(allocations, 0);
    optim_free(ssb);
}

/* A copy of the state goes on with the same bits, from wherever it is taken. */
static void test_resume(void **state)
{
    (void)state;
    double x[20], zero[20] = {0};
    classic_start(20, x);
    optim_settings settings = optim_settings_defaults(OPTIM_SSBROYDEN);
    for (int k = 0; k < 80; k++) { /* half of them with pairs skipped on the way */
        settings.curvature_threshold = k % 2 ? 0.3 : 1e-12;
        problem p = make_problem(chained_rosenbrock, 20);
        optim_array a[OPTIM_STATE_CAPACITY], b[OPTIM_STATE_CAPACITY];
        optim_optimizer *one = create_ssbroyden(20, x, &settings, NULL);
        optim_optimizer *two = create_ssbroyden(20, zero, &settings, NULL);
        steps(one, &p, k);
        const int count = optim_state(one, a);
        assert_int_equal(optim_state(two, b), count);
        for (int i = 0; i < count; i++) {
            assert_int_equal(a[i].count, b[i].count);
            memcpy(b[i].data, a[i].data, a[i].count * sizeof(double));
        }
        assert_null(optim_state_check(two));
        for (int i = 0; i < 30; i++) {
            assert_int_equal(steps(one, &p, 1), steps(two, &p, 1));
            for (int j = 0; j < count; j++) {
                assert_memory_equal(a[j].data, b[j].data, a[j].count * sizeof(double));
            }
        }
        optim_free(one);
        optim_free(two);
    }
}

/* NaN in any one array is found; a scalar that cannot be also stops the step; a matrix that is not
 * positive definite is dropped. */
static void test_bad_state(void **state)
{
    (void)state;
    double x[4];
    classic_start(4, x);
    problem p = make_problem(rosenbrock, 4);
    optim_array a[OPTIM_STATE_CAPACITY];
    optim_optimizer *ssb = make(4, x);
    steps(ssb, &p, 5);
    const int count = optim_state(ssb, a);
    assert_int_equal(optim_state(ssb, a), count);
    optim_state(ssb, a);
    for (int i = 0; i < count; i++) {
        const double good = a[i].data[0];
        a[i].data[0] = NAN;
        const char *why = optim_state_check(ssb);
        assert_int_equal(strncmp(why, a[i].name, strlen(a[i].name)), 0);
        a[i].data[0] = good;
        assert_null(optim_state_check(ssb));
    }
    int stopped = 0;
    for (size_t i = 0; i < a[count - 1].count; i++) {
        double *scalar = a[count - 1].data + i;
        const double good = *scalar;
        *scalar = -1.5; /* no counter; but a value, best value or step may be */
        if (optim_state_check(ssb)) {
            assert_int_equal(steps(ssb, &p, 1), OPTIM_BAD_STATE);
            stopped++;
        }
        *scalar = good;
    }
    assert_int_equal(stopped, (int)a[count - 1].count - 3);
    optim_array matrix = array(ssb, "matrix");
    for (size_t i = 0; i < matrix.count; i++) {
        matrix.data[i] = -matrix.data[i];
    }
    problem q = make_problem(rosenbrock, 4);
    optim_optimizer *other = make(4, x);
    optim_array b[OPTIM_STATE_CAPACITY];
    optim_state(other, b);
    for (int i = 0; i < count; i++) {
        memcpy(b[i].data, a[i].data, a[i].count * sizeof(double));
    }
    assert_int_equal(steps(other, &q, 1), OPTIM_RUNNING);
    assert_int_equal(optim_inspect(other).resets, 1);
    assert_int_equal(optim_inspect(other).pairs, 1);
    optim_free(ssb);
    optim_free(other);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_update),      cmocka_unit_test(test_minima),
        cmocka_unit_test(test_superlinear), cmocka_unit_test(test_skips),
        cmocka_unit_test(test_endings),     cmocka_unit_test(test_objective_changed),
        cmocka_unit_test(test_create),      cmocka_unit_test(test_allocation),
        cmocka_unit_test(test_resume),      cmocka_unit_test(test_bad_state),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
