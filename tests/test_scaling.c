/* The model of time over ranks: its limits, and what never grows or falls. */
#include "tools/programs/scaling.h"

#include <math.h>
#include <setjmp.h>
#include <stdarg.h>
#include <stdbool.h>
#include <stddef.h>

#include <cmocka.h>

static const scaling_machine node = {.threads = 2, .processors = 16, .ranks = 8};

static const scaling_load load = {.work = 3e-3, .exchanges = 5, .bytes = 1.6e6, .repeated = 2e-4};

static void assert_near(double x, double expected)
{
    assert_true(fabs(x - expected) <= 1e-12 * fabs(expected));
}

/* One rank sends nothing, whatever it is said to. */
static void test_alone(void **state)
{
    (void)state;
    const scaling_time t = scaling_step(&node, 1, &load);
    assert_true(t.sums == 0);
    assert_near(t.work, load.work);
    assert_near(t.step, load.work + load.repeated);
}

/* What the equations of the header say, by hand, within a machine and beyond it. */
static void test_sums(void **state)
{
    (void)state;
    const scaling_time within = scaling_step(&node, 8, &load),
                       beyond = scaling_step(&node, 9, &load);
    const scaling_network m = scaling_memory, n = scaling_infiniband;
    assert_near(within.sums, 5 * (m.latency + 7 * m.message) + 1.6e6 / m.bandwidth);
    assert_near(beyond.sums, 5 * (n.latency + 8 * n.message) + 8 * 1.6e6 / n.bandwidth);
    assert_true(within.work == load.work && beyond.work == load.work); /* as many processors */
}

/* With more and more ranks of less and less work nothing is left but what is repeated, and the
 * exchanges. */
static void test_many(void **state)
{
    (void)state;
    double before = INFINITY, sums = 0;
    for (int ranks = 1; ranks <= 4096; ranks *= 2) {
        const scaling_load now = {load.work / ranks, load.exchanges, 0, load.repeated};
        const scaling_time t = scaling_step(&node, ranks, &now);
        assert_true(t.work < before && t.sums >= sums && t.repeated == load.repeated);
        assert_near(t.step, t.work + t.sums + t.repeated);
        before = t.work;
        sums = t.sums;
    }
    assert_true(before < 1e-6);
    assert_true(sums > 4095 * load.exchanges * scaling_infiniband.message);
}

/* Threads that have to share processors take that much longer, for what is repeated as well. */
static void test_crowded(void **state)
{
    (void)state;
    const scaling_machine small = {.threads = 2, .processors = 4, .ranks = 8};
    for (int ranks = 1; ranks <= 16; ranks++) {
        const scaling_time t = scaling_step(&small, ranks, &load);
        const double beside = ranks < 8 ? ranks : 8, slower = fmax(1, beside * 2 / 4);
        assert_near(t.work, slower * load.work);
        assert_near(t.repeated, slower * load.repeated);
    }
}

int main(void)
{
    const struct CMUnitTest tests[] = {cmocka_unit_test(test_alone), cmocka_unit_test(test_sums),
                                       cmocka_unit_test(test_many), cmocka_unit_test(test_crowded)};
    return cmocka_run_group_tests(tests, NULL, NULL);
}
