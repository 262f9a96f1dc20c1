/* Planners, tips that are reached, and ways of a robot around an obstacle. */
#include "plan_testing.h"
#include "tools/plan/ompl_shim.h"
#include "tools/plan/reach.h"
#include "tools/plan/way.h"

/* ---- planners -------------------------------------------------------------------------------- */

/* A wall across the square at x = 1 with a gap, or none. */
typedef struct square {
    double gap;
    size_t asked;
} square;

static bool in_square(void *context, const double *q)
{
    square *const s = context;
    s->asked++;
    return fabs(q[0] - 1) > 0.2 || (q[1] > 2 && q[1] < 2 + s->gap);
}

static void planners(void **state)
{
    (void)state;
    const double low[2] = {0, -1}, high[2] = {2, 5}, start[2] = {0.1, -0.5};
    const double goals[4] = {1, 0, 1.9, 4}; /* the first is within the wall */
    for (int method = PLAN_RRT_CONNECT; method <= PLAN_PRM; method++) {
        double *way[3] = {NULL, NULL, NULL};
        size_t length[3], looked[3];
        for (int k = 0; k < 3; k++) {
            square s = {.gap = 0.5};
            const ompl_search asked = {
                2,     low,    high,  in_square, &s,   0.01, (plan_method)method,
                20000, k == 2, start, 2,         goals};
            assert_int_equal(ompl_find(&asked, &way[k], &length[k], &looked[k], NULL), AD_OK);
            assert_non_null(way[k]);
            assert_int_equal(looked[k], s.asked);
            const double *const last = &way[k][2 * (length[k] - 1)];
            assert_near(way[k][0], start[0], 1e-12);
            assert_near(last[0], goals[2], 1e-12);
            assert_near(last[1], goals[3], 1e-12);
            for (size_t i = 0; i + 1 < length[k]; i++) { /* steps are a hundredth of the ranges */
                for (int j = 0; j <= 50; j++) {
                    const double *const a = &way[k][2 * i], part = j / 50.0;
                    const double q[2] = {a[0] + part * (a[2] - a[0]), a[1] + part * (a[3] - a[1])};
                    assert_true(fabs(q[0] - 1) > 0.17 || (q[1] > 1.9 && q[1] < 2.6));
                }
            }
        }
        assert_int_equal(length[0], length[1]); /* the same seed */
        assert_int_equal(looked[0], looked[1]);
        assert_memory_equal(way[0], way[1], 2 * length[0] * sizeof(double));
        for (int k = 0; k < 3; k++) {
            free(way[k]);
        }
        square closed = {.gap = 0};
        const ompl_search none = {2,    low, high,  in_square, &closed, 0.01, (plan_method)method,
                                  3000, 1,   start, 2,         goals};
        assert_int_equal(ompl_find(&none, &way[0], &length[0], &looked[0], NULL), AD_OK);
        assert_null(way[0]);
        assert_in_range(looked[0], 3000, 3200);
    }
}

/* ---- tips ------------------------------------------------------------------------------------ */

static void tips(void **state)
{
    (void)state;
    robot r = make_robot(true);
    open_robot(&r, 21);
    reach *const found = malloc(sizeof *found);
    uint64_t random = 8;
    const double start[PLAN_VARIABLES_MAX] = {0};
    for (int k = 0; k < 10; k++) {
        double q[PLAN_VARIABLES_MAX], tip[3];
        for (int i = 0; i < r.moves.count; i++) {
            q[i] = random_in(&random, r.moves.low[i], r.moves.high[i]);
        }
        assert_int_equal(plan_exact_shapes(r.exact, 1, q, NULL), AD_OK);
        memcpy(tip, &r.exact->r[3 * (r.exact->points - 1)], sizeof tip);
        assert_int_equal(reach_tip(r.exact, tip, 1e-6, start, 1, found, NULL), AD_OK);
        assert_true(found->count > 0 && found->nearest <= 1e-6);
        for (size_t i = 0; i < found->count; i++) {
            const double *const at_q = &found->configuration[i * (size_t)r.moves.count];
            assert_int_equal(plan_exact_shapes(r.exact, 1, at_q, NULL), AD_OK);
            for (int j = 0; j < r.moves.count; j++) {
                assert_in_range((at_q[j] - r.moves.low[j]) * 1e6, 0,
                                (r.moves.high[j] - r.moves.low[j]) * 1e6 + 1);
            }
            double square = 0;
            for (size_t j = 0; j < 3; j++) {
                const double off = r.exact->r[3 * (r.exact->points - 1) + j] - tip[j];
                square += off * off;
            }
            assert_true(sqrt(square) <= 1e-6);
        }
    }
    /* 0.2 m of rod from a base that slides by 0.05 m does not come nearer than 0.25 m to what is
     * 0.5 m away */
    const double beyond[3] = {r.moves.base[0], r.moves.base[1], r.moves.base[2] + 0.5};
    assert_int_equal(reach_tip(r.exact, beyond, 1e-6, start, 1, found, NULL), AD_OK);
    assert_int_equal(found->count, 0);
    assert_near(found->nearest, 0.25, 1e-3);
    free(found);
    free_robot(&r);
}

/* ---- a way ----------------------------------------------------------------------------------- */

static ad_status by_solver(void *context, const double *parameters, double *values, ad_error *error)
{
    solve_member said;
    return solve_members_solve(context, 1, parameters, values, &said, error);
}

static void add_box(mesh *m, const double low[3], const double high[3])
{
    static const size_t quads[6][4] = {{0, 2, 3, 1}, {4, 5, 7, 6}, {0, 1, 5, 4},
                                       {2, 6, 7, 3}, {0, 4, 6, 2}, {1, 3, 7, 5}};
    const size_t first = m->corners;
    for (int i = 0; i < 8; i++) {
        mesh_corner(m, i & 1 ? high[0] : low[0], i & 2 ? high[1] : low[1],
                    i & 4 ? high[2] : low[2]);
    }
    for (int i = 0; i < 6; i++) {
        const size_t *const q = quads[i];
        mesh_triangle(m, first + q[0], first + q[1], first + q[2]);
        mesh_triangle(m, first + q[0], first + q[2], first + q[3]);
    }
}

/* A post that stands where the robot would go straight to its goal. */
static mesh post(void)
{
    mesh m = mesh_make(8, 12);
    add_box(&m, (const double[3]){0.05, -0.006, 0.1}, (const double[3]){0.06, 0.006, 0.25});
    return m;
}

/* A solver for searches, at 41 points s along the 0.2 m. */
static solve_members *quick_solver(const robot *of, double *s)
{
    for (int k = 0; k <= 40; k++) {
        s[k] = 0.005 * k;
    }
    const solve_members_settings members = {.tolerance = 1e-6, .threads = 1, .points = 41, .s = s};
    solve_members *quick = NULL;
    assert_int_equal(solve_members_create(&of->owner->scene, &members, &quick, NULL), AD_OK);
    return quick;
}

static void around_a_post(void **state)
{
    (void)state;
    mesh m = post();
    environment *of = open_mesh(&m, ENVIRONMENT_OUTSIDE);
    distance_grid *grid = NULL;
    robot r = make_robot(false), fine = make_robot(false);
    open_robot(&r, 61);
    open_robot(&fine, 151);
    double s[41];
    solve_members *quick = quick_solver(&r, s);
    assert_int_equal(distance_grid_create(of, ENVIRONMENT_OUTSIDE, 50000, NULL, &grid, NULL),
                     AD_OK);
    plan_settings settings = plan_settings_default();
    settings.environment.side = ENVIRONMENT_OUTSIDE;
    settings.radius = 0.003;
    settings.clearance = 0.001;
    settings.start_count = settings.goal_count = 3;
    settings.goal[0] = 4.5;
    const way_shapes shapes = {by_solver, quick, 41, SOLVE_MEMBERS_COLUMNS, s, 2e-7};
    const way_problem problem = {&settings, of, grid, r.exact, &shapes};
    char key[PLAN_KEY] = "";
    ad_error error = {.message = ""};
    way found, again;
    assert_int_equal(way_find(&problem, &found, key, &error), AD_OK);
    assert_int_equal(found.end, WAY_CERTIFIED);
    assert_true(found.corners > 2); /* straight on is the post */
    assert_true(found.certificate->all.free >= 0.001);
    try_way(&fine, of, found.certificate, settings.radius, 6, 1024, 0, false);
    assert_int_equal(way_find(&problem, &again, key, &error), AD_OK);
    assert_int_equal(again.certificate->count, found.certificate->count);
    assert_memory_equal(again.certificate->configuration, found.certificate->configuration,
                        3 * found.certificate->count * sizeof(double));
    way_free(&again);
    way_free(&found);
    /* starts and goals that touch, or are beyond their ranges */
    settings.goal[0] = 1.9;
    assert_int_equal(way_find(&problem, &found, key, &error), AD_BAD_INPUT);
    assert_string_equal(key, "plan.goal.actuators");
    assert_non_null(strstr(error.message, "too near"));
    settings.start[0] = 7;
    assert_int_equal(way_find(&problem, &found, key, &error), AD_BAD_INPUT);
    assert_string_equal(key, "plan.start");
    assert_non_null(strstr(error.message, "pull_1 = 7 is outside its range; allowed: 0 to 6"));
    distance_grid_free(grid);
    solve_members_free(quick);
    environment_free(of);
    free_robot(&r);
    free_robot(&fine);
}

/* What is promised of ways among boxes at random, from and to shapes at random, is so. */
#ifndef WAYS
#define WAYS 6
#endif

static void ways_among_boxes(void **state)
{
    (void)state;
    enum { BOXES = 12 };
    robot r = make_robot(false), fine = make_robot(false);
    open_robot(&r, 61);
    open_robot(&fine, 151);
    double s[41];
    solve_members *quick = quick_solver(&r, s);
    uint64_t random = 12;
    int ends[5] = {0};
    for (int i = 0; i < WAYS; i++) {
        mesh m = mesh_make(8 * BOXES, 12 * BOXES);
        for (int k = 0; k < BOXES; k++) {
            double low[3], high[3];
            for (int j = 0; j < 3; j++) {
                low[j] = j < 2 ? random_in(&random, -0.15, 0.14) : random_in(&random, 0.02, 0.2);
                high[j] = low[j] + random_in(&random, 0.003, 0.04);
            }
            add_box(&m, low, high);
        }
        environment *of = open_mesh(&m, ENVIRONMENT_OUTSIDE);
        distance_grid *grid = NULL;
        assert_int_equal(distance_grid_create(of, ENVIRONMENT_OUTSIDE, 30000, NULL, &grid, NULL),
                         AD_OK);
        plan_settings settings = plan_settings_default();
        settings.environment.side = ENVIRONMENT_OUTSIDE;
        settings.radius = random_in(&random, 0, 0.004);
        settings.clearance = random_in(&random, 0, 0.002);
        settings.start_count = settings.goal_count = 3;
        settings.states = 10000;
        settings.seed = i;
        const way_shapes shapes = {by_solver, quick, 41, SOLVE_MEMBERS_COLUMNS, s, 2e-7};
        const way_problem problem = {&settings, of, grid, r.exact, &shapes};
        way found;
        ad_status status = AD_BAD_INPUT;
        for (int k = 0; k < 200 && status == AD_BAD_INPUT; k++) { /* until both are free */
            char key[PLAN_KEY];
            for (int j = 0; j < 3; j++) {
                settings.start[j] = random_in(&random, 0, 6);
                settings.goal[j] = random_in(&random, 0, 6);
            }
            status = way_find(&problem, &found, key, NULL);
        }
        if (status == AD_OK) {
            ends[found.end]++;
            if (found.end == WAY_CERTIFIED) {
                assert_true(found.certificate->all.free >= settings.clearance);
                try_way(&fine, of, found.certificate, settings.radius, random_bits(&random), 256, 0,
                        false);
            }
            way_free(&found);
        }
        distance_grid_free(grid);
        environment_free(of);
    }
    print_message("%d certified, %d not, %d not found\n", ends[WAY_CERTIFIED],
                  ends[WAY_NOT_CERTIFIED], ends[WAY_NOT_FOUND]);
    assert_true(ends[WAY_CERTIFIED] >= WAYS / 2);
    solve_members_free(quick);
    free_robot(&r);
    free_robot(&fine);
}

int main(void)
{
    const struct CMUnitTest tests[] = {cmocka_unit_test(planners), cmocka_unit_test(tips),
                                       cmocka_unit_test(around_a_post),
                                       cmocka_unit_test(ways_among_boxes)};
    return environment_is_built() && ompl_is_built()
               ? cmocka_run_group_tests(tests, make_directory, remove_directory)
               : 77;
}
