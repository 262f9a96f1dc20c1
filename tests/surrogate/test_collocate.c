/* Nodes of steps, which know no solution, beside the rod's own motion. */
#include "near.h"
#include "rollouts_testing.h"

#include "tools/prepare/prepare.h"
#include "tools/surrogate/training_internal.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

static const char arm[] =
    ARM("{range: [0.8, 1.3]}") "surrogate: {step: 0.02, modes: [1, 0, 1, 0], kind: polynomial}\n";

enum { STATES = 6, INPUTS = 2, STEPS = 12, NODES = SURROGATE_NODES };

/* The end is that of one step of Radau's method, and nodes are near the motion that is solved in 64
 * parts, where inputs jump as well. */
static void test_nodes(void **state)
{
    (void)state;
    ad_error error = {.message = ""};
    const reduced_settings of = {.modes = {1, 0, 1, 0}, .newton = 1e-12};
    config *given = NULL;
    reduced_rod *rod = NULL;
    excitation_rollouts motions;
    surrogate_training t = {.pool = ad_pool_create(2)};
    excitation_settings settings = excitation_settings_default();
    memcpy(settings.modes, of.modes, sizeof of.modes);
    settings.step = 0.02;
    settings.steps = STEPS;
    settings.count = 6;
    settings.shortest = 0.02;
    settings.longest = 0.2;
    if (prepare_read("arm.yaml", arm, 0, NULL, &given, &error) != AD_OK ||
        excitation_run(&given->scene, &settings, t.pool, &motions, &error) != AD_OK) {
        fail_msg("%s", error.message);
    }
    t.open = &given->scene;
    t.settings = &given->surrogate;
    assert_int_equal(motions.states, STATES);
    const size_t rows = (size_t)motions.count * STEPS;
    double *nodes = calloc(rows * NODES * STATES, sizeof *nodes), scale[STATES] = {0};
    double most = 0, size = 0;
    assert_int_equal(reduced_create(t.open, &of, &rod, &error), AD_OK);
    assert_int_equal(surrogate_collocate(&t, &motions, nodes, &error), AD_OK);
    for (size_t i = 0; i < (rows + 6) * STATES; i++) {
        scale[i % STATES] = fmax(scale[i % STATES], fabs(motions.state[i]));
    }
    for (size_t row = 0; row < rows; row++) {
        const size_t from = row / STEPS * (STEPS + 1) + row % STEPS;
        const double *begin = motions.state + from * STATES;
        const double *u = motions.input + from * INPUTS;
        double at[STATES], whole[STATES];
        memcpy(at, begin, sizeof at);
        assert_int_equal(reduced_step(rod, 0, settings.step, begin, u, whole, NULL, NULL, &error),
                         AD_OK);
        for (int i = 0; i < NODES; i++) {
            const double t = surrogate_nodes[i] - (i ? surrogate_nodes[i - 1] : 0);
            const double *node = nodes + (row * NODES + (size_t)i) * STATES;
            for (int p = 0; p < 64; p++) {
                assert_int_equal(
                    reduced_step(rod, 0, t * settings.step / 64, at, u, at, NULL, NULL, &error),
                    AD_OK);
            }
            for (int j = 0; j < STATES / 2; j++) {
                most = fmax(most, fabs(node[j] - at[j]) / scale[j]);
                size = fmax(size, fabs(at[j] - begin[j]) / scale[j]);
            }
            for (int j = 0; j < STATES && i == 2; j++) {
                assert_near(node[j], whole[j], 1e-9 * scale[j]);
            }
        }
    }
    print_message("nodes are off by %.1e of moves by %.1e\n", most, size);
    assert_true(most < 0.02 * size);
    free(nodes);
    reduced_free(rod);
    excitation_free(&motions);
    config_free(given);
    ad_pool_free(t.pool);
}

int main(void)
{
    const struct CMUnitTest tests[] = {cmocka_unit_test(test_nodes)};
    return cmocka_run_group_tests(tests, NULL, NULL);
}
