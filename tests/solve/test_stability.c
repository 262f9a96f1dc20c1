/* Equilibria that give way, at critical loads that are known in closed form. */
#include <math.h>
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>
#include <stdio.h>

#include <cmocka.h>

#include "fewer.h"

#include "physics/solve/stability.h"
#include "tools/prepare/config_session.h"

#define COLUMN                                                                                     \
    "rod:\n"                                                                                       \
    "  length: 2\n"                                                                                \
    "  model: kirchhoff\n"                                                                         \
    "  stiffness: {bending: [3, 3], torsion: 2}\n"                                                 \
    "loads: {units: EI, tip: {force: [0, 0, -1]}}\n"

/* Between two clamps, too near by P L/EA. */
#define STRUT                                                                                      \
    "rod:\n"                                                                                       \
    "  length: 1\n"                                                                                \
    "  model: cosserat\n"                                                                          \
    "  stiffness: {shear: [.inf, .inf], axial: 1000, bending: [1, 1], torsion: 1}\n"               \
    "boundary: {end: {type: clamped, position: [0, 0, 1], rotation: [1, 0, 0, 0]}}\n"

static const double euler = 2.4674011002723395; /* pi^2/4 */

static int count_ways(const experiment *e)
{
    const scene *rod_scene = e->scene;
    double at[STABILITY_POINTS], values[MODEL_COLUMNS_MAX * STABILITY_POINTS];
    int ways = -2;
    field *shape;
    ad_error error;
    assert_int_equal(stability_points(rod_scene, at, NULL), AD_OK);
    assert_int_equal(field_create(e->model, e->mlp, false, e->pool, &shape, &error), AD_OK);
    assert_int_equal(field_evaluate(shape, experiment_parameters(e), STABILITY_POINTS,
                                    (const double *const[]){at}, values, &error),
                     AD_OK);
    assert_int_equal(stability_count(rod_scene, values, &ways, &error), AD_OK);
    field_free(shape);
    return ways;
}

/* Trained, as the default network is, and counted. */
static int ways_of(const char *text, const char *first, const char *second, verdict *found)
{
    const char *overrides[] = {first, second};
    ad_error error = {AD_OK, ""};
    config *settings;
    session s;
    if (prepare_read("scene.yaml", text, second ? 2 : 1, overrides, &settings, &error) != AD_OK ||
        config_session_create(settings, 1, &s, &error) != AD_OK) {
        fail_msg("%s", error.message);
    }
    while (trainer_fit(s.trainer)->state == FIT_RUNNING) {
        assert_int_equal(trainer_step(s.trainer, &error), AD_OK);
    }
    int ways = count_ways(s.e);
    trainer_verdict(s.trainer, found);
    session_free(&s);
    return ways;
}

/* The modes of a cantilever give way at 1, 9, 25 times Euler's load, on elements of 1/128 within
 * 0.1%. */
static void test_columns(void **state)
{
    (void)state;
    static const struct {
        double load;
        const char *override;
        int ways;
    } rows[] = {{-1, NULL, 0}, /* pulled */
                {0.995, NULL, 0},
                {1.005, NULL, 1},
                {8.95, NULL, 1},
                {9.05, NULL, 2},
                {0.995, "motion=spatial", 0},
                {1.005, "motion=spatial", 2},                 /* to any side */
                {1.005, "rod.stiffness.bending=[3, 12]", 0},  /* in the plane, about d2 */
                {0.252, "rod.stiffness.bending=[12, 3]", 1}}; /* EI is that about d1 */
    for (size_t i = 0; i < sizeof rows / sizeof *rows; i++) {
        char load[64];
        verdict found;
        snprintf(load, sizeof load, "loads.tip.force[2]=%.17g", -rows[i].load * euler);
        int ways = ways_of(COLUMN, load, rows[i].override, &found);
        if (ways != rows[i].ways) {
            fail_msg("row %zu: %d ways instead of %d", i, ways, rows[i].ways);
        }
        assert_int_equal(verdict_has(&found, VERDICT_UNSTABLE), rows[i].load > 1 || ways > 0);
    }
}

/* With both ends held the force may change: P (1 - P/EA) = 4 pi^2. */
static void test_strut(void **state)
{
    (void)state;
    const double critical = 500 * (1 - sqrt(1 - 16 * 4 * euler / 1000));
    for (int i = 0; i < 2; i++) {
        char place[80];
        verdict found;
        double load = critical * (i ? 1.01 : 0.99);
        snprintf(place, sizeof place, "boundary.end.position=[0, 0, %.17g]", 1 - load / 1000);
        assert_int_equal(ways_of(STRUT, place, NULL, &found), i);
        assert_int_equal(ways_of(STRUT, place, "motion=spatial", &found), 2 * i);
    }
}

static void test_not_asked(void **state)
{
    (void)state;
    verdict found;
    assert_int_equal(ways_of(COLUMN, "loads.tip.frame=follower", NULL, &found), -1);
    assert_int_equal(ways_of(COLUMN, "loads.tip={moment: [0, 1, 1]}", NULL, &found), -1);
    assert_int_equal(ways_of(COLUMN, "loads.tip={moment: [0, 1, 0]}", NULL, &found), 0);
}

int main(void)
{
    const struct CMUnitTest tests[] = {cmocka_unit_test(test_columns)};
    const struct CMUnitTest alike[] = {cmocka_unit_test(test_strut),
                                       cmocka_unit_test(test_not_asked)};
    return run_with_alike(tests, alike, NULL, NULL);
}
