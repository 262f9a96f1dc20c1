/* Roadmaps: what they know, what they look at again, and their files. */
#include "plan_testing.h"
#include "tools/files/checkpoint.h"
#include "tools/plan/way.h"

/* ---- in a square ----------------------------------------------------------------------------- */

static const double low[2] = {0, -1}, high[2] = {2, 5}, start[2] = {0.1, -0.5},
                    goals[4] = {1, 0, 1.9, 4}; /* the first is within the wall */

static ompl_search search_in(square *of, size_t states)
{
    return (ompl_search){.count = 2,
                         .low = low,
                         .high = high,
                         .is_free = in_square,
                         .context = of,
                         .step = 0.01,
                         .states = states,
                         .seed = 1,
                         .start = start,
                         .goals = 2,
                         .goal = goals};
}

/* Steps are a hundredth of the ranges, so a corner of the wall may be cut by half of one. */
static void is_free_way(const square *of, const double *way, size_t length)
{
    const double *const last = &way[2 * (length - 1)];
    assert_near(way[0], start[0], 1e-12);
    assert_near(last[0], goals[2], 1e-12);
    assert_near(last[1], goals[3], 1e-12);
    for (size_t i = 0; i + 1 < length; i++) {
        for (int j = 0; j <= 50; j++) {
            const double *const a = &way[2 * i], part = j / 50.0;
            const double q[2] = {a[0] + part * (a[2] - a[0]), a[1] + part * (a[3] - a[1])};
            assert_true(fabs(q[0] - 1) > 0.17 || (q[1] > 1.9 && q[1] < 2.1 + of->gap));
        }
    }
}

static void what_is_known(void **state)
{
    (void)state;
    square open = {.gap = 0.5}, closed = {.gap = 0};
    ompl_search asked = search_in(&open, 20000);
    ompl_roadmap made, again;
    assert_int_equal(ompl_roadmap_make(&asked, 500, &made, NULL), AD_OK);
    assert_int_equal(ompl_roadmap_make(&asked, 500, &again, NULL), AD_OK);
    assert_int_equal(made.nodes, 500);
    assert_true(made.edges > 500 && again.edges == made.edges);
    assert_memory_equal(made.node, again.node, 1000 * sizeof *made.node);
    assert_memory_equal(made.edge, again.edge, 2 * made.edges * sizeof *made.edge);
    for (size_t i = 0; i < made.nodes; i++) {
        assert_true(in_square(&open, &made.node[2 * i]));
    }
    /* Where all is known only the ends are looked at, and what makes the way shorter. */
    size_t looked[2];
    for (int known = 0; known < 2; known++) {
        ompl_map *map = NULL;
        assert_int_equal(ompl_map_create(&asked, &made, known, &map, NULL), AD_OK);
        for (int k = 0; k < 3; k++) {
            double *way = NULL;
            size_t length;
            open.asked = 0;
            assert_int_equal(
                ompl_map_find(map, &asked, k == 2, &way, &length, &looked[known], NULL), AD_OK);
            assert_non_null(way);
            assert_int_equal(looked[known], open.asked);
            is_free_way(&open, way, length);
            free(way);
        }
        ompl_map_free(map);
    }
    /* A wall that has closed meanwhile. */
    ompl_map *map = NULL;
    double *way = NULL;
    size_t length;
    assert_int_equal(ompl_map_create(&asked, &made, false, &map, NULL), AD_OK);
    asked = search_in(&closed, 3000);
    assert_int_equal(ompl_map_find(map, &asked, false, &way, &length, &looked[0], NULL), AD_OK);
    assert_null(way);
    assert_in_range(looked[0], 3000, 3200);
    ompl_map_free(map);
    free(made.node);
    free(made.edge);
    free(again.node);
    free(again.edge);
}

/* ---- in a file ------------------------------------------------------------------------------- */

/* A post where the robot would go straight to its goal, moved across that. */
static environment *open_post(double moved, distance_grid **grid)
{
    mesh m = mesh_make(8, 12);
    add_box(&m, (const double[3]){0.05, moved - 0.006, 0.1},
            (const double[3]){0.06, moved + 0.006, 0.25});
    environment *const of = open_mesh(&m, ENVIRONMENT_OUTSIDE);
    assert_int_equal(distance_grid_create(of, ENVIRONMENT_OUTSIDE, 50000, NULL, grid, NULL), AD_OK);
    return of;
}

static void in_a_file(void **state)
{
    (void)state;
    distance_grid *grid[2];
    environment *const of[2] = {open_post(0, &grid[0]), open_post(0.004, &grid[1])};
    mover m;
    open_mover(&m, false);
    plan_settings settings = plan_settings_default();
    settings.environment.side = ENVIRONMENT_OUTSIDE;
    settings.radius = 0.003;
    settings.start_count = settings.goal.count = 3;
    settings.goal.actuators[0] = 4.5;
    const way_shapes shapes = {by_solver, m.quick, 41, SOLVE_MEMBERS_COLUMNS, m.s, 2e-7};
    roadmap_settings kept = {.file = at("roadmap.h5"), .nodes = 200};
    char key[PLAN_KEY] = "", file[300];
    ad_error error = {.message = ""};
    snprintf(file, sizeof file, "%s", kept.file);
    kept.file = file;
    /* The file is that of the first; it stays so. */
    static const struct {
        int post;
        double clearance;
        uint64_t surface, shapes;
        roadmap_source source;
    } tries[] = {{0, 0.001, 1, 2, ROADMAP_MADE},         {0, 0.001, 1, 2, ROADMAP_KEPT},
                 {0, 0.0005, 1, 2, ROADMAP_KEPT},        {1, 0.001, 3, 2, ROADMAP_OTHER_SURFACE},
                 {0, 0.001, 1, 4, ROADMAP_OTHER_SHAPES}, {0, 0.002, 1, 2, ROADMAP_NEARER},
                 {0, 0.001, 1, 2, ROADMAP_KEPT}};
    size_t looked[sizeof tries / sizeof *tries], shapes_of[sizeof tries / sizeof *tries];
    for (size_t k = 0; k < sizeof tries / sizeof *tries; k++) {
        const int i = tries[k].post;
        const way_problem problem = {&settings, of[i], grid[i], m.exact.exact, &shapes, &kept};
        way found;
        settings.clearance = tries[k].clearance;
        kept.surface = tries[k].surface;
        kept.shapes = tries[k].shapes;
        assert_int_equal(way_find(&problem, &found, key, &error), AD_OK);
        assert_int_equal(found.source, tries[k].source);
        assert_int_equal(found.nodes, 200);
        assert_int_equal(found.end, WAY_CERTIFIED);
        assert_true(found.corners > 2); /* straight on is the post */
        assert_true(found.certificate->all.free >= settings.clearance);
        try_way(&m.fine, of[i], found.certificate, settings.radius, k, 256, 0, false);
        looked[k] = found.looked;
        shapes_of[k] = found.certificate->count;
        way_free(&found);
    }
    assert_true(looked[0] == looked[1] && looked[1] == looked[6]);
    assert_true(shapes_of[0] == shapes_of[1] && shapes_of[1] == shapes_of[6]);
    assert_true(looked[4] > looked[1]); /* what is not known is looked at */
    /* Another robot, and what is no roadmap, which stays as it is. */
    mover other;
    way found;
    open_mover(&other, true);
    settings.start_count = settings.goal.count = 5;
    settings.goal.actuators[0] = 0;
    const way_problem problem = {&settings, of[0], grid[0], other.exact.exact, &shapes, &kept};
    assert_int_equal(way_find(&problem, &found, key, &error), AD_BAD_INPUT);
    assert_string_equal(key, "plan.roadmap.file");
    assert_non_null(strstr(error.message, "roadmap.h5: is a roadmap of other variables: pull_1 0 "
                                          "to 6, pull_2 0 to 6, pull_3 0 to 6; allowed: pull_1 0"));
    checkpoint *const cp = checkpoint_create("1");
    assert_int_equal(checkpoint_put_double(cp, "variables", 1), AD_OK);
    assert_int_equal(checkpoint_write(cp, &(file_place){.path = file}, NULL), AD_OK);
    checkpoint_free(cp);
    assert_int_equal(way_find(&problem, &found, key, &error), AD_BAD_INPUT);
    assert_non_null(strstr(error.message, "roadmap.h5: is no roadmap; allowed: one, or no file"));
    close_mover(&other);
    close_mover(&m);
    for (int i = 0; i < 2; i++) {
        distance_grid_free(grid[i]);
        environment_free(of[i]);
    }
}

int main(void)
{
    const struct CMUnitTest tests[] = {cmocka_unit_test(what_is_known),
                                       cmocka_unit_test(in_a_file)};
    return environment_is_built() && ompl_is_built()
               ? cmocka_run_group_tests(tests, make_directory, remove_directory)
               : 77;
}
