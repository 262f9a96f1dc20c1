/* Planners, tips that are reached, and ways of a robot around an obstacle. */
#include "physics/numerics/quaternion.h"
#include "plan_testing.h"
#include "tools/plan/ompl_shim.h"
#include "tools/plan/reach.h"
#include "tools/plan/way.h"

/* ---- planners -------------------------------------------------------------------------------- */

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
        square open = {.gap = 0.5}; /* nobody waits for a goal within the wall */
        const ompl_search within = {2,    low, high,  in_square, &open, 0.01, (plan_method)method,
                                    3000, 1,   start, 1,         goals};
        assert_int_equal(ompl_find(&within, &way[0], &length[0], &looked[0], NULL), AD_OK);
        assert_null(way[0]);
        assert_in_range(looked[0], 1, 2);
    }
}

/* ---- tips ------------------------------------------------------------------------------------ */

static void random_configuration(const robot *r, uint64_t *random, double *q)
{
    for (int i = 0; i < r->moves.count; i++) {
        q[i] = random_in(random, r->moves.low[i], r->moves.high[i]);
    }
}

/* By differences of shapes: tangents are of length 1 and along the last piece, but for its bend,
 * and go with variables as they say; differences leave 1e-9/1e-3 and the square of 1e-3 of a range.
 */
static void tangents(void **state)
{
    (void)state;
    robot r = make_robot(true);
    open_robot(&r, 201);
    uint64_t random = 5;
    const size_t n = (size_t)r.moves.count, last = r.exact->points - 1;
    for (int k = 0; k < 5; k++) {
        double q[3 * PLAN_VARIABLES_MAX], t[3], turns[3 * PLAN_VARIABLES_MAX], along[3];
        random_configuration(&r, &random, q);
        assert_int_equal(plan_exact_shapes(r.exact, 1, q, NULL), AD_OK);
        memcpy(t, r.exact->tangent, sizeof t);
        memcpy(turns, r.exact->turns, 3 * n * sizeof *turns);
        for (int i = 0; i < 3; i++) {
            along[i] = r.exact->r[3 * last + (size_t)i] - r.exact->r[3 * last - 3 + (size_t)i];
        }
        assert_near(sqrt(vector_dot(t, t)), 1, 1e-12);
        assert_near(vector_dot(t, along) / sqrt(vector_dot(along, along)), 1, 1e-4);
        for (size_t v = 0; v < n; v++) {
            const double step = 1e-3 * (r.moves.high[v] - r.moves.low[v]);
            memcpy(q + n, q, n * sizeof *q);
            q[v] -= step;
            q[n + v] += step;
            assert_int_equal(plan_exact_shapes(r.exact, 2, q, NULL), AD_OK);
            q[v] += step;
            for (size_t i = 0; i < 3; i++) {
                const double by = (r.exact->tangent[3 + i] - r.exact->tangent[i]) / (2 * step);
                assert_near(turns[i * n + v] * step, by * step, 1e-8);
            }
        }
    }
    free_robot(&r);
}

static void tips(void **state)
{
    (void)state;
    robot r = make_robot(true);
    open_robot(&r, 21);
    reach *const found = malloc(sizeof *found);
    uint64_t random = 8;
    const double start[PLAN_VARIABLES_MAX] = {0};
    for (int k = 0; k < 20; k++) {
        double q[PLAN_VARIABLES_MAX];
        reach_goal goal = {.tolerance = 1e-6, .direction = {NAN, NAN, NAN}, .angle = 0.01};
        random_configuration(&r, &random, q);
        assert_int_equal(plan_exact_shapes(r.exact, 1, q, NULL), AD_OK);
        memcpy(goal.tip, &r.exact->r[3 * (r.exact->points - 1)], sizeof goal.tip);
        if (k % 2) { /* and where it points there */
            memcpy(goal.direction, r.exact->tangent, sizeof goal.direction);
        }
        assert_int_equal(reach_tip(r.exact, &goal, start, 1, found, NULL), AD_OK);
        assert_true(found->count > 0 && found->nearest <= 1e-6);
        for (size_t i = 0; i < found->count; i++) {
            const double *const at_q = &found->configuration[i * (size_t)r.moves.count];
            assert_int_equal(plan_exact_shapes(r.exact, 1, at_q, NULL), AD_OK);
            for (int j = 0; j < r.moves.count; j++) {
                assert_in_range((at_q[j] - r.moves.low[j]) * 1e6, 0,
                                (r.moves.high[j] - r.moves.low[j]) * 1e6 + 1);
            }
            assert_true(vector_distance(&r.exact->r[3 * (r.exact->points - 1)], goal.tip) <= 1e-6);
            assert_true(k % 2 == 0 || vector_dot(r.exact->tangent, goal.direction) >= cos(0.01));
        }
    }
    /* 0.2 m of rod from a base that slides by 0.05 m does not come nearer than 0.25 m to what is
     * 0.5 m away; nor does it point back to where it comes from. */
    reach_goal goal = {.tip = {r.moves.base[0], r.moves.base[1], r.moves.base[2] + 0.5},
                       .tolerance = 1e-6,
                       .direction = {NAN, NAN, NAN},
                       .angle = 0.01};
    assert_int_equal(reach_tip(r.exact, &goal, start, 1, found, NULL), AD_OK);
    assert_int_equal(found->count, 0);
    assert_near(found->nearest, 0.25, 1e-3);
    assert_true(found->angle == 0);
    goal.tip[2] -= 0.3;
    goal.direction[0] = goal.direction[1] = 0;
    goal.direction[2] = 1;
    assert_int_equal(reach_tip(r.exact, &goal, start, 1, found, NULL), AD_OK);
    assert_true(found->count > 0);
    goal.direction[2] = -1;
    assert_int_equal(reach_tip(r.exact, &goal, start, 1, found, NULL), AD_OK);
    assert_int_equal(found->count, 0);
    assert_true(found->angle > 0.01);
    free(found);
    free_robot(&r);
}

/* ---- a way ----------------------------------------------------------------------------------- */

/* A post that stands where the robot would go straight to its goal. */
static mesh post(void)
{
    mesh m = mesh_make(8, 12);
    add_box(&m, (const double[3]){0.05, -0.006, 0.1}, (const double[3]){0.06, 0.006, 0.25});
    return m;
}

static void around_a_post(void **state)
{
    (void)state;
    mesh m = post();
    environment *of = open_mesh(&m, ENVIRONMENT_OUTSIDE);
    distance_grid *grid = NULL;
    robot r = make_robot(false), fine = make_robot(false);
    open_robot(&r, 61);
    open_robot(&fine, 181);
    double s[41];
    solve_members *quick = quick_solver(&r, s);
    assert_int_equal(distance_grid_create(of, ENVIRONMENT_OUTSIDE, 50000, NULL, &grid, NULL),
                     AD_OK);
    plan_settings settings = plan_settings_default();
    settings.environment.side = ENVIRONMENT_OUTSIDE;
    settings.radius = 0.003;
    settings.clearance = 0.001;
    settings.start_count = settings.goal.count = 3;
    settings.goal.actuators[0] = 4.5;
    const way_shapes shapes = {by_solver, quick, 41, SOLVE_MEMBERS_COLUMNS, s, 2e-7};
    const way_problem problem = {&settings, of, grid, r.exact, &shapes, NULL};
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
    /* there, back and there again: the certificate goes on from goal to goal */
    settings.goal_count = 3;
    settings.goals[0] = settings.goals[2] = settings.goal;
    settings.goals[1].count = 3;
    assert_int_equal(way_find(&problem, &found, key, &error), AD_OK);
    assert_int_equal(found.end, WAY_CERTIFIED);
    assert_int_equal(found.certificate->count, found.goal[2].row + 1);
    for (size_t k = 0; k < 3; k++) {
        const double *const at_q = &found.certificate->configuration[3 * found.goal[k].row];
        assert_memory_equal(at_q, settings.goals[k].actuators, 3 * sizeof *at_q);
        assert_true(found.goal[k].row > (k ? found.goal[k - 1].row : 0));
    }
    for (size_t i = 0; i < found.certificate->count; i++) {
        assert_true(found.certificate->least[i] >= found.certificate->all.free);
    }
    try_way(&fine, of, found.certificate, settings.radius, 7, 1024, 0, false);
    way_free(&found);
    settings.goals[1].actuators[0] = 1.9;
    assert_int_equal(way_find(&problem, &found, key, &error), AD_BAD_INPUT);
    assert_string_equal(key, "plan.goals[1].actuators");
    settings.goal_count = 0;
    /* starts and goals that touch, or are beyond their ranges */
    settings.goal.actuators[0] = 1.9;
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

enum { BOXES = 12, WAYS = 6 };

static environment *open_boxes(uint64_t *random)
{
    mesh m = mesh_make(8 * BOXES, 12 * BOXES);
    for (int k = 0; k < BOXES; k++) {
        double low[3], high[3];
        for (int j = 0; j < 3; j++) {
            low[j] = j < 2 ? random_in(random, -0.15, 0.14) : random_in(random, 0.02, 0.2);
            high[j] = low[j] + random_in(random, 0.003, 0.04);
        }
        add_box(&m, low, high);
    }
    return open_mesh(&m, ENVIRONMENT_OUTSIDE);
}

/* A way among boxes at random, from and to shapes at random; so many shapes of it are tried. */
static way_end random_way(mover *of, int number, int shapes, double *worst)
{
    uint64_t random = 12 + (uint64_t)number;
    environment *boxes = open_boxes(&random);
    distance_grid *grid = NULL;
    assert_int_equal(distance_grid_create(boxes, ENVIRONMENT_OUTSIDE, 30000, NULL, &grid, NULL),
                     AD_OK);
    const plan_robot *const moves = &of->exact.moves;
    plan_settings settings = plan_settings_default();
    settings.environment.side = ENVIRONMENT_OUTSIDE;
    settings.radius = random_in(&random, 0, 0.004);
    settings.clearance = random_in(&random, 0, 0.002);
    settings.start_count = settings.goal.count = moves->count;
    settings.states = 10000;
    settings.seed = number;
    const way_shapes shapes_of = {by_solver, of->quick, 41, SOLVE_MEMBERS_COLUMNS, of->s, 2e-7};
    const way_problem problem = {&settings, boxes, grid, of->exact.exact, &shapes_of, NULL};
    way found = {.end = WAY_NOT_TRIED};
    ad_status status = AD_BAD_INPUT;
    for (int k = 0; k < 200 && status == AD_BAD_INPUT; k++) { /* until both are free */
        char key[PLAN_KEY];
        for (int j = 0; j < moves->count; j++) {
            settings.start[j] = random_in(&random, moves->low[j], moves->high[j]);
            settings.goal.actuators[j] = random_in(&random, moves->low[j], moves->high[j]);
        }
        status = way_find(&problem, &found, key, NULL);
    }
    assert_true(status == AD_OK || status == AD_BAD_INPUT);
    if (status == AD_BAD_INPUT) { /* boxes are all around */
        found.end = WAY_NOT_TRIED;
    } else if (found.end == WAY_CERTIFIED) {
        assert_true(found.certificate->all.free >= settings.clearance);
        print_message("way %d: ", number);
        *worst = fmin(*worst, try_way(&of->fine, boxes, found.certificate, settings.radius,
                                      random_bits(&random), shapes, 0, false));
    }
    const way_end end = found.end;
    way_free(&found);
    distance_grid_free(grid);
    environment_free(boxes);
    return end;
}

/* What is promised of ways is so. CPINN_WAYS=FIRST-LAST tries these, with 1,024 shapes each; see
 * tools/bench/README.md. Every other robot has a base that moves. */
static void ways_among_boxes(void **state)
{
    (void)state;
    mover movers[2];
    const char *const asked = getenv("CPINN_WAYS");
    int first = 0, last = WAYS - 1, ends[WAY_NOT_TRIED + 1] = {0};
    double worst = INFINITY;
    assert_true(!asked || sscanf(asked, "%d-%d", &first, &last) == 2);
    open_mover(&movers[0], false);
    open_mover(&movers[1], true);
    for (int i = first; i <= last; i++) {
        ends[random_way(&movers[i % 2], i, asked ? 1024 : 256, &worst)]++;
    }
    print_message("%d certified, %d not, %d not found, %d without a start; %.2g m more than "
                  "promised at least\n",
                  ends[WAY_CERTIFIED], ends[WAY_NOT_CERTIFIED], ends[WAY_NOT_FOUND],
                  ends[WAY_NOT_TRIED], worst);
    assert_true(ends[WAY_CERTIFIED] >= (last + 1 - first) / 2);
    close_mover(&movers[0]);
    close_mover(&movers[1]);
}

int main(void)
{
    const struct CMUnitTest tests[] = {cmocka_unit_test(planners), cmocka_unit_test(tangents),
                                       cmocka_unit_test(tips), cmocka_unit_test(around_a_post),
                                       cmocka_unit_test(ways_among_boxes)};
    return environment_is_built() && ompl_is_built()
               ? cmocka_run_group_tests(tests, make_directory, remove_directory)
               : 77;
}
