/* Windows of time: each starts exactly where the one before ends, costs no more per step than the
 * first, and a run of several is saved, resumed and evaluated as one. */
#include "fewer.h"
#include "near.h"
#include "rod_testing.h"
#include "trainer_testing.h"

#include "physics/learn/problem_internal.h"
#include "physics/learn/window_state.h"

/* ---- scenes and networks ----------------------------------------------------------------------
 */

enum { WINDOWS = 3, NUMBERS_MAX = 4096, NUMBERS = 2 * WINDOW_STATE_POINTS * ROD_STATE_ROWS };

static const char *const moving_end[3] = {"0.2*t^2", "0", "1-0.1*t^2"};
static const char *const turning_end[4] = {"-cos(0.2*t^2)", "-sin(0.2*t^2)", "0", "0"};
static const char *const still[4] = {"1", "0", "0", "0"};
static const char *const origin[3] = {"0", "0", "0"};
static const char *const curved[3] = {"0.1*s^2", "0", "0.2"};
static const char *const pull[3] = {"sin(3*t)", "0.3", "-0.5*t"};

/* A straight rod, clamped at its start; the other end is loaded, or driven with -q for q. */
static scene windows_scene(bool driven, scene_formulation formulation)
{
    const double kse[3] = {40, 50, 90}, kbt[3] = {1.2, 0.8, 0.5}, inertia[3] = {0.03, 0.02, 0.05};
    scene made = stiff_scene(1, kse, kbt, 1.3, inertia);
    made.duration = Q(2.1);
    made.windows = WINDOWS;
    made.formulation = formulation;
    made.end.type = driven ? SCENE_DRIVEN : SCENE_LOADED;
    for (int i = 0; i < 3; i++) {
        made.start.position[i] = Q(origin[i]);
        made.end.position[i] = Q(driven ? moving_end[i] : NULL);
        made.loads.tip.force[i] = Q(driven ? NULL : pull[i]);
        made.rod.rest_curvature[i] = Q(driven ? "0" : curved[i]);
        made.rod.curvature_damping[i] = Q(0.01);
    }
    for (int i = 0; i < 4; i++) {
        made.start.rotation[i] = Q(still[i]);
        made.end.rotation[i] = Q(driven ? turning_end[i] : NULL);
    }
    return made;
}

static nn_mlp *network_of(const scene *given)
{
    nn_mlp_settings settings = nn_mlp_settings_default();
    settings.inputs = 2; /* s and t */
    settings.outputs = rod_network_outputs(given);
    settings.hidden_count = 2;
    settings.hidden[0] = settings.hidden[1] = 7;
    settings.activation = NN_SIN;
    nn_rng rng = nn_rng_seed(5);
    nn_mlp *mlp = NULL;
    assert_int_equal(nn_mlp_create(&settings, &rng, &mlp, NULL), AD_OK);
    assert_true(WINDOWS * nn_mlp_parameters(mlp) <= NUMBERS_MAX);
    return mlp;
}

/* Networks that were never trained: an exact chain does not depend on what they say. */
static void fill(double *x, size_t count)
{
    nn_rng rng = nn_rng_seed(23);
    for (size_t i = 0; i < count; i++)
        x[i] = 0.2 * nn_rng_normal(&rng);
}

typedef struct chain {
    scene given;
    nn_mlp *mlp;
    double x[NUMBERS_MAX], starts[WINDOWS + 1][NUMBERS];
} chain;

static void chain_make(chain *c, scene given)
{
    ad_error error = {.message = ""};
    if (scene_check(&given, NULL, &error) != AD_OK || rod_check(&given, NULL, &error) != AD_OK)
        fail_msg("%s", error.message);
    c->given = given;
    c->mlp = network_of(&c->given);
    size_t parameters = nn_mlp_parameters(c->mlp);
    fill(c->x, WINDOWS * parameters);
    ad_pool *pool = ad_pool_create(1);
    physics_model *m = NULL;
    window_state *passed = NULL;
    assert_int_equal(model_of_scene(&c->given, NULL, &m, NULL), AD_OK);
    assert_int_equal(window_state_numbers(m), NUMBERS);
    assert_int_equal(window_state_create(m, c->mlp, pool, &passed, NULL), AD_OK);
    for (int i = 0; i < WINDOWS; i++) {
        assert_int_equal(window_state_run(passed, i, c->starts[i], c->x + (size_t)i * parameters,
                                          c->starts[i + 1], NULL),
                         AD_OK);
    }
    window_state_free(passed);
    model_free(m);
    ad_pool_free(pool);
}

static rod_state state_of(const chain *c, int index, const recorded *r)
{
    const domain d = rod_domain_of(&c->given);
    double from = domain_window_time(&d, index);
    domain_place at = r->at;
    at.start = ad_scalar(r->tape, from);
    at.span = ad_scalar(r->tape, domain_window_time(&d, index + 1) - from);
    at.goes_on = index > 0;
    at.state = ad_constant(r->tape, NUMBERS, c->starts[index]);
    size_t offset = (size_t)index * nn_mlp_parameters(c->mlp);
    ad_value outputs = nn_mlp_record(c->mlp, domain_network_input(&d, &at), offset);
    return rod_ansatz(&c->given, &at, outputs);
}

static double largest_of(const chain *c, ad_value y, const double *s, const double *t)
{
    double *values = evaluate_at(y, POINTS, s, t, c->x), most = 0;
    int count = ad_extent_of(y) == AD_UNIFORM ? ad_rows(y) : ad_rows(y) * POINTS;
    for (int i = 0; i < count; i++)
        most = fmax(most, fabs(values[i]));
    free(values);
    return most;
}

/* ---- the chain --------------------------------------------------------------------------------
 */

/* Where window `index` begins: r, q, their derivatives by s (in v, u) and by t. The state goes over
 * as a polynomial of degree 48, which is these networks to rounding; a derivative by s multiplies
 * rounding by up to 48^2, a second one by 48^4 / 3. */
static void check_joint(const chain *c, int index)
{
    recorded r = begin(&c->given);
    rod_observables a = rod_observe(&c->given, state_of(c, index - 1, &r), &r.at);
    rod_observables b = rod_observe(&c->given, state_of(c, index, &r), &r.at);
    const struct {
        const char *name;
        ad_value before, after;
        double tolerance;
    } rows[] = {{"position", a.position, b.position, 1e-13},
                {"rotation", a.rotation, b.rotation, 1e-13},
                {"strain", a.strain, b.strain, 1e-11},
                {"curvature", a.curvature, b.curvature, 1e-11},
                {"velocity", a.velocity, b.velocity, 1e-12},
                {"angular velocity", a.angular_velocity, b.angular_velocity, 1e-12},
                {"velocity by s", ad_derivative(a.velocity, r.s, 1),
                 ad_derivative(b.velocity, r.s, 1), 1e-10},
                {"curvature by s", ad_derivative(a.curvature, r.s, 1),
                 ad_derivative(b.curvature, r.s, 1), 1e-9}};
    double t[POINTS];
    const domain d = rod_domain_of(&c->given);
    for (int i = 0; i < POINTS; i++)
        t[i] = domain_window_time(&d, index);
    for (size_t i = 0; i < sizeof rows / sizeof *rows; i++) {
        double worst = largest_of(c, ad_sub(rows[i].after, rows[i].before), unit_s, t);
        double size = largest_of(c, rows[i].before, unit_s, t);
        if (!(worst <= rows[i].tolerance * (1 + size)))
            fail_msg("window %d, %s: %g of %g", index, rows[i].name, worst, size);
    }
    ad_value jump = ad_sub(ad_derivative(b.velocity, r.t, 1), ad_derivative(a.velocity, r.t, 1));
    assert_true(largest_of(c, jump, unit_s, t) > 1e-3); /* the networks are not the same one */
    ad_tape_free(r.tape);
}

static void test_joints(void **state)
{
    (void)state;
    static chain c;
    for (int k = 0; k < 8; k++) {
        scene given = windows_scene(k & 1, k & 2 ? SCENE_DISPLACEMENT : SCENE_MIXED);
        given.rotation = k & 4 ? SCENE_VECTOR : SCENE_QUATERNION;
        chain_make(&c, given);
        for (int index = 1; index < WINDOWS; index++)
            check_joint(&c, index);
        nn_mlp_free(c.mlp);
    }
}

/* A rod twisted by three turns: no polynomial of degree 6 is near its quaternion, some are 0. Of a
 * function of 20 radians degree 48 leaves rounding. */
static void test_wound(void **state)
{
    (void)state;
    static chain c;
    static const char *const twisted[4] = {"cos(10*sin(pi*s/2))", "0", "0", "sin(10*sin(pi*s/2))"};
    static const char *const straight[3] = {"0", "0", "s"};
    scene given = windows_scene(false, SCENE_MIXED);
    given.rotation = SCENE_VECTOR;
    for (int i = 0; i < 4; i++)
        given.initial.rotation[i] = Q(twisted[i]);
    for (int i = 0; i < 3; i++) {
        given.initial.position[i] = Q(straight[i]);
        given.rod.rest_curvature[i] = Q("0");
    }
    chain_make(&c, given);
    double values[WINDOW_STATE_POINTS][ROD_STATE_ROWS] = {{0}};
    for (int j = 0; j < WINDOW_STATE_POINTS; j++) {
        for (int k = 0; k < WINDOW_STATE_POINTS; k++) {
            for (int i = 0; i < ROD_STATE_ROWS; i++)
                values[j][i] +=
                    c.starts[1][k * ROD_STATE_ROWS + i] * cos(PI * j * k / WINDOW_STATE_DEGREE);
        }
    }
    assert_true(window_state_misfit(values[0], ROD_STATE_ROWS, 3, 4, 6) > 0.1);
    assert_true(window_state_misfit(values[0], ROD_STATE_ROWS, 3, 4, 24) < 1e-3);
    for (int index = 1; index < WINDOWS; index++)
        check_joint(&c, index);
    nn_mlp_free(c.mlp);
}

/* The error of interpolating cos(k pi x) by its values at a few of the points is what it is found
 * to be at the others; a polynomial has none. */
static void test_misfit(void **state)
{
    (void)state;
    double values[WINDOW_STATE_DEGREE + 1][2];
    for (int j = 0; j <= WINDOW_STATE_DEGREE; j++) {
        double x = cos(PI * j / WINDOW_STATE_DEGREE);
        values[j][0] = 1 - x + 3 * pow(x, 6);
        values[j][1] = cos(12 * acos(fmax(-1, fmin(1, x)))); /* T_12: 1 at the points of degree 6 */
    }
    assert_near(window_state_misfit(values[0], 2, 0, 1, 6), 0, 1e-14); /* rounding */
    assert_near(window_state_misfit(values[0], 2, 1, 1, 6), 2, 1e-14);
    assert_near(window_state_misfit(values[0], 2, 0, 2, 12), 0, 1e-13);
}

/* Held ends stay where they are said to be, in every window, whatever the side of the quaternion.
 */
static void test_ends(void **state)
{
    (void)state;
    static chain c;
    double t[POINTS], starts[POINTS] = {0}, ends[POINTS];
    scene given = windows_scene(true, SCENE_MIXED);
    given.rotation = SCENE_VECTOR;
    chain_make(&c, given);
    scene soft = c.given;
    soft.boundary_enforcement = SCENE_SOFT;
    for (int index = 0; index < WINDOWS; index++) {
        recorded r = begin(&c.given);
        rod_state made = state_of(&c, index, &r);
        const domain d = rod_domain_of(&c.given);
        double from = domain_window_time(&d, index), to = domain_window_time(&d, index + 1);
        for (int i = 0; i < POINTS; i++) {
            t[i] = from + (to - from) * i / (POINTS - 1);
            ends[i] = 1;
        }
        ad_value start = rod_residual(&soft, ROD_START, made, &r.at);
        assert_near(largest_of(&c, start, starts, t), 0, 1e-13); /* rounding */
        assert_near(largest_of(&c, rod_residual(&soft, ROD_END, made, &r.at), ends, t), 0, 1e-13);
        ad_tape_free(r.tape);
    }
    nn_mlp_free(c.mlp);
}

static void test_times(void **state)
{
    (void)state;
    scene given = windows_scene(false, SCENE_MIXED);
    const int counts[] = {1, 2, 3, 7, 49, 256};
    for (size_t k = 0; k < sizeof counts / sizeof *counts; k++) {
        given.windows = counts[k];
        double end = rod_numbers_of(&given).duration;
        const domain d = rod_domain_of(&given);
        assert_true(domain_window_time(&d, 0) == 0);
        assert_true(domain_window_time(&d, counts[k]) == end);
        assert_int_equal(domain_window_at(&d, 0), 0);
        assert_int_equal(domain_window_at(&d, 2 * end), counts[k] - 1);
        for (int i = 0; i < counts[k]; i++) {
            double from = domain_window_time(&d, i), to = domain_window_time(&d, i + 1);
            assert_true(from < to);
            assert_int_equal(domain_window_at(&d, to), i); /* it ends there */
            assert_int_equal(domain_window_at(&d, nextafter(from, to)), i);
        }
    }
}

/* ---- problems ---------------------------------------------------------------------------------
 */

#define SMALL "network.hidden=[6, 6]", "losses.interior.points=24", "losses.held_out_points=16"

/* Parameters of all windows at random, and the problem in window `index`. */
static made make_window(const char *const *changes, int index, int threads)
{
    made m = make_problem(DYNAMIC, changes, threads);
    fill(m.e->parameters, m.e->count * (size_t)m.e->scene->windows);
    while (m.e->window < index)
        assert_int_equal(experiment_next_window(m.e, NULL), AD_OK);
    assert_int_equal(problem_enter(m.p, m.e->window, experiment_start(m.e), NULL), AD_OK);
    return m;
}

/* The windows before are computed once for a set of points, not in every step. */
static void test_steps_do_not_grow(void **state)
{
    (void)state;
    static const char *const changes[] = {SMALL, "time.windows=6", NULL};
    problem_set_info second = {0};
    for (int index = 1; index < 6; index += 2) {
        made m = make_window(changes, index, 1);
        problem_set_info info = problem_set_inspect(m.p, 0);
        second = index == 1 ? info : second;
        assert_int_equal(info.program.instructions, second.program.instructions);
        assert_int_equal(info.fixed_rows, second.fixed_rows);
        assert_true(info.fixed_instructions >= second.fixed_instructions);
        size_t n = m.e->count;
        double loss, *jtj = malloc((n * n + n) * sizeof *jtj);
        assert_int_equal(problem_normal_equations(m.p, experiment_parameters(m.e), &loss, jtj,
                                                  jtj + n * n, NULL),
                         AD_OK);
        const problem_fixed *normal = &m.p->sets[0].normal_fixed;
        assert_true(normal->program != NULL && normal->rows < PROBLEM_FIXED_ROWS / 2);
        free(jtj);
        made_free(&m);
    }
}

/* The first window has programs of its own, all others share theirs; so do all load factors. */
static void test_compiled_once(void **state)
{
    (void)state;
    static const char *const changes[] = {SMALL, "time.windows=6", NULL};
    made m = make_window(changes, 0, 1);
    problem_least_squares sizes;
    assert_int_equal(problem_prepare_least_squares(m.p, &sizes, NULL), AD_OK);
    int first = problem_compiled(m.p).count, later = 0;
    assert_true(first > 0);
    for (int index = 1; index < 6; index++) {
        assert_int_equal(experiment_next_window(m.e, NULL), AD_OK);
        assert_int_equal(problem_enter(m.p, index, experiment_start(m.e), NULL), AD_OK);
        assert_int_equal(problem_prepare_least_squares(m.p, &sizes, NULL), AD_OK);
        later = index == 1 ? problem_compiled(m.p).count : later;
        assert_int_equal(problem_compiled(m.p).count, later);
    }
    assert_int_equal(later, 2 * first);
    made_free(&m);
    static const char *const wide[] = {"network.hidden=null", "network.fourier.features=null",
                                       NULL};
    made column = make_problem("configs/cases/buckled_2.yaml", wide, 1);
    int count = problem_compiled(column.p).count;
    double *x = calloc(column.e->count, sizeof *x), full, half, again;
    assert_int_equal(problem_evaluate(column.p, x, &full, NULL, NULL), AD_OK);
    problem_load(column.p, 0.5);
    assert_int_equal(problem_evaluate(column.p, x, &half, NULL, NULL), AD_OK);
    problem_load(column.p, 1);
    assert_int_equal(problem_evaluate(column.p, x, &again, NULL, NULL), AD_OK);
    assert_int_equal(problem_compiled(column.p).count, count);
    assert_true(full != half && full == again);
    free(x);
    made_free(&column);
}

/* Values, gradients and normal equations of a later window agree, whatever is kept for the points,
 * and do not depend on the number of threads. */
static void test_gradients(void **state)
{
    (void)state;
    static const char *const changes[] = {SMALL, "time.windows=3",
                                          "losses.interior.sampler=uniform",
                                          "losses.interior.resample_every=3", NULL};
    double losses[2][2] = {{0}};
    for (int threads = 1; threads <= 2; threads++) {
        made m = make_window(changes, 2, threads);
        size_t n = m.e->count;
        const domain *d = &m.e->model->domain;
        assert_near(domain_window_time(d, 2), 0.5, 1e-15); /* where the load has a kink */
        double *x = experiment_parameters(m.e), loss, *jtj = malloc((n * n + 3 * n) * sizeof *jtj);
        double *jtr = jtj + n * n, *gradient = jtr + n;
        for (int pass = 0; pass < 2; pass++) {
            assert_int_equal(problem_evaluate(m.p, x, &losses[threads - 1][pass], gradient, NULL),
                             AD_OK);
            assert_int_equal(problem_normal_equations(m.p, x, &loss, jtj, jtr, NULL), AD_OK);
            assert_near(loss / losses[threads - 1][pass], 1, 1e-13); /* sums in another order */
            double worst = 0, size = 0;
            for (size_t i = 0; i < n; i++) {
                worst = fmax(worst, fabs(2 * jtr[i] - gradient[i]));
                size = fmax(size, fabs(gradient[i]));
            }
            assert_true(worst < 1e-11 * size);
            for (size_t i = 0; i < m.p->sets[0].trained.count; i++) {
                double t = problem_time_of(m.p, &m.p->sets[0].trained, i);
                assert_true(t >= domain_window_time(d, 2) && t <= 1);
            }
            bool changed;
            assert_int_equal(problem_advance(m.p, 4, x, &changed, NULL), AD_OK);
            assert_true(changed);
        }
        free(jtj);
        made_free(&m);
    }
    assert_true(losses[0][0] == losses[1][0] && losses[0][1] == losses[1][1]);
    assert_true(losses[0][0] != losses[0][1]);
}

/* ---- runs -------------------------------------------------------------------------------------
 */

static const char *const run_changes[] = {SMALL,
                                          "time.windows=3",
                                          "training.stages=[{optimizer: adam, steps: 9}, "
                                          "{optimizer: gauss_newton, steps: 5}]",
                                          "losses.interior.sampler=uniform",
                                          "losses.interior.resample_every=4",
                                          "losses.causal.slices=3",
                                          "losses.causal.update_every=3",
                                          "output.every=2",
                                          NULL};

static void check_same_runs(run *a, run *b)
{
    const history *one = &trainer_fit(a->trainer)->rows, *two = &trainer_fit(b->trainer)->rows;
    size_t numbers = a->made.e->count * 3;
    assert_int_equal(trainer_fit(a->trainer)->at.window, 2);
    assert_memory_equal(a->made.e->parameters, b->made.e->parameters, numbers * sizeof(double));
    assert_int_equal(one->count, two->count);
    for (size_t i = 0; i < one->count; i++) {
        for (int k = 0; k < one->columns; k++) {
            double p = one->rows[i * (size_t)one->columns + (size_t)k];
            double q = two->rows[i * (size_t)two->columns + (size_t)k];
            if (strcmp(one->names[k], "seconds") != 0 && !(p == q || (isnan(p) && isnan(q)))) {
                fail_msg("row %zu, %s: %g and %g", i, one->names[k], p, q);
            }
        }
    }
}

/* Every stage in every window; stopped at any step, also in the middle of window 2, a run goes on
 * to the same bits, on any number of threads. */
static void test_resume(void **state)
{
    (void)state;
    run whole = start(DYNAMIC, run_changes, 1);
    int most = 0;
    while (trainer_fit(whole.trainer)->state == FIT_RUNNING) {
        const fit_place before = trainer_fit(whole.trainer)->at;
        step(&whole);
        most = before.window_step > most ? (int)before.window_step : most;
        assert_true(before.window == trainer_fit(whole.trainer)->at.window || before.stage == 1);
    }
    assert_int_equal(most, 13);
    const history *h = &trainer_fit(whole.trainer)->rows;
    assert_true(history_value(h, 0, "window") == 1 &&
                history_value(h, h->count - 1, "window") == 3);
    const int stops[] = {3, 14, 17, 26, 28, 41, 42};
    for (size_t k = 0; k < sizeof stops / sizeof *stops; k++) {
        run first = start(DYNAMIC, run_changes, 2);
        for (int i = 0; i < stops[k]; i++) {
            step(&first);
        }
        save(&first, "stopped.h5");
        ad_error error = {AD_OK, ""};
        run next = start(DYNAMIC, run_changes, 1);
        if (restore(&next, in_folder("stopped.h5"), &error) != AD_OK) {
            fail_msg("%s", error.message);
        }
        finish(&next);
        check_same_runs(&whole, &next);
        finish(&first); /* and back again */
        assert_int_equal(restore(&first, in_folder("stopped.h5"), &error), AD_OK);
        finish(&first);
        check_same_runs(&whole, &first);
        unlink(in_folder("stopped.h5"));
        stop(&next);
        stop(&first);
    }
    stop(&whole);
}

/* A window begins with the parameters of the one before, and the file of a single window stays what
 * it was. */
static void test_checkpoint(void **state)
{
    (void)state;
    run r = start(DYNAMIC, run_changes, 1);
    for (int i = 0; i < 14; i++) {
        step(&r);
    }
    size_t count = r.made.e->count;
    const double *x = r.made.e->parameters;
    assert_int_equal(trainer_fit(r.trainer)->at.window, 1);
    assert_memory_equal(x, x + count, count * sizeof *x);
    save(&r, "two.h5");
    checkpoint *file;
    int64_t window;
    assert_int_equal(checkpoint_open(in_folder("two.h5"), &file, NULL), AD_OK);
    assert_true(checkpoint_has(file, "parameters/window1/network/layer0/weight"));
    assert_true(checkpoint_has(file, "parameters/window2/network/layer0/weight"));
    assert_false(checkpoint_has(file, "parameters/window3/network/layer0/weight"));
    assert_int_equal(checkpoint_get_int64(file, "training/window", &window, 1, NULL), AD_OK);
    assert_int_equal(window, 1);
    checkpoint_free(file);
    unlink(in_folder("two.h5"));
    stop(&r);

    r = start(DYNAMIC, static_changes, 1);
    save(&r, "one.h5");
    assert_int_equal(checkpoint_open(in_folder("one.h5"), &file, NULL), AD_OK);
    assert_true(checkpoint_has(file, "parameters/network/layer0/weight"));
    assert_false(checkpoint_has(file, "training/window"));
    assert_true(isnan(history_value(&trainer_fit(r.trainer)->rows, 0, "window")));
    checkpoint_free(file);
    unlink(in_folder("one.h5"));
    stop(&r);
}

/* One field over all windows: the same as each by itself, and without a seam. */
static void test_field(void **state)
{
    (void)state;
    static const char *const changes[] = {SMALL, "time.windows=3", NULL};
    enum { SEAMS = 2, SIDES = 2, ALL = SEAMS * SIDES };
    made m = make_window(changes, 2, 1);
    field *f;
    assert_int_equal(field_create(m.e->model, m.e->mlp, false, m.e->pool, &f, NULL), AD_OK);
    field_enter(f, 2, m.e->parameters, m.e->starts);
    const double joints[SEAMS] = {1.0 / 3, 2.0 / 3}, s[ALL] = {0.9, 0.7, 0.9, 0.7};
    const double t[ALL] = {joints[1] - 1e-13, joints[0] - 1e-13, joints[1] + 1e-13,
                           joints[0] + 1e-13};
    double values[ALL * MODEL_COLUMNS_MAX], scene_values[MODEL_COLUMNS_MAX];
    assert_int_equal(field_evaluate(f, experiment_parameters(m.e), ALL,
                                    (const double *const[]){s, t}, values, NULL),
                     AD_OK);
    for (int column = 0; column < field_columns(f); column++) {
        const char *name = field_column_name(f, column);
        for (int k = 0; k < SEAMS && !strchr("nm", name[0]); k++) { /* these are no state */
            double a = values[column * ALL + k], b = values[column * ALL + k + SEAMS];
            assert_near(a, b, 1e-11 * (1 + fabs(a))); /* 2e-13 times accelerations up to 100 */
        }
    }
    for (int k = 0; k < ALL; k++) { /* no point knows of the others */
        assert_int_equal(field_evaluate(f, experiment_parameters(m.e), 1,
                                        (const double *const[]){&s[k], &t[k]}, scene_values, NULL),
                         AD_OK);
        for (int column = 0; column < field_columns(f); column++) {
            assert_true(scene_values[column] == values[column * ALL + k]);
        }
    }
    field_free(f);
    made_free(&m);
}

/* The error is that of the windows trained so far: with the exact solution's file as reference it
 * is that of a field compared point by point. */
static void test_reference(void **state)
{
    (void)state;
    static const char *const changes[] = {SMALL, "time.windows=4", NULL};
    double errors[2];
    for (int way = 0; way < 2; way++) { /* window after window, or at once */
        made m = {make_experiment(DYNAMIC, changes, 1), NULL};
        reference *r;
        reference_errors found;
        fill(m.e->parameters, 4 * m.e->count);
        while (way && m.e->window < 2)
            assert_int_equal(experiment_next_window(m.e, NULL), AD_OK);
        assert_int_equal(reference_create(m.e, &r, NULL), AD_OK);
        assert_int_equal(reference_compare(r, experiment_parameters(m.e), &found, NULL), AD_OK);
        while (m.e->window < 2) {
            double before = found.position_max;
            assert_int_equal(experiment_next_window(m.e, NULL), AD_OK);
            assert_int_equal(reference_enter(r, m.e, m.e->window - 1, NULL), AD_OK);
            assert_int_equal(reference_compare(r, experiment_parameters(m.e), &found, NULL), AD_OK);
            assert_true(found.position_max >= before);
        }
        errors[way] = found.position;
        reference_free(r);
        made_free(&m);
    }
    assert_true(errors[0] == errors[1] && errors[0] > 0);
}

/* A manufactured solution over three windows, each learned from the end of the one before. */
static void test_manufactured(void **state)
{
    (void)state;
    static const char *const changes[] = {"time.windows=3",
                                          "network.hidden=[16]",
                                          "losses.interior.points=64",
                                          "output.every=100",
                                          "manufactured.position=[0.1*s^2*sin(2*t), 0.05*s^2*t, s]",
                                          "manufactured.angles=[0, 0.2*s*sin(2*t), 0.1*s*t]",
                                          "training.stages=[{optimizer: gauss_newton, steps: 50}]",
                                          "training.seed=1",
                                          NULL};
    run r = start("configs/manufactured_dynamic.yaml", changes, 1);
    finish(&r);
    const fit *f = trainer_fit(r.trainer);
    const trainer_info *info = trainer_inspect(r.trainer);
    assert_int_equal(f->at.window, 2);
    assert_int_equal(f->at.step, 150);
    assert_true(info->errors.position <
                3e-4); /* 7e-5, other seeds up to 2.7e-4; at first it is 0.2 */
    stop(&r);
}

int main(void)
{
    const struct CMUnitTest tests[] = {cmocka_unit_test(test_ends),
                                       cmocka_unit_test(test_wound),
                                       cmocka_unit_test(test_misfit),
                                       cmocka_unit_test(test_times),
                                       cmocka_unit_test(test_steps_do_not_grow),
                                       cmocka_unit_test(test_compiled_once),
                                       cmocka_unit_test(test_gradients),
                                       cmocka_unit_test(test_checkpoint),
                                       cmocka_unit_test(test_field),
                                       cmocka_unit_test(test_reference)};
    const struct CMUnitTest alike[] = {cmocka_unit_test(test_manufactured),
                                       cmocka_unit_test(test_resume),
                                       cmocka_unit_test(test_joints)};
    return run_with_alike(tests, alike, make_folder, remove_folder);
}
