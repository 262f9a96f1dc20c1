/* Where formulas of a scene switch, and where its lists have places. */
#include "fewer.h"
#include "quantity_testing.h"

#include "near.h"
#include "physics/learn/model.h"
#include "physics/local/drives.h"
#include "physics/numerics/constants.h"
#include "physics/scene/breaks.h"
#include "physics/scene/scene_field.h"
#include "physics/scene/scene_walk.h"
#include "physics/solve/events.h"
#include "random_numbers.h"

#include <float.h>
#include <stdio.h>
#include <string.h>

static scene rod_of_length(double length)
{
    scene rod;
    scene_defaults(&rod);
    rod.rod.length = Q(length);
    return rod;
}

static scene_breaks breaks_of(const scene *rod, const char *coordinate)
{
    scene_breaks found;
    ad_error error = {AD_OK, ""};
    if (scene_breaks_of(rod, coordinate, &found, &error) != AD_OK) {
        fail_msg("%s", error.message);
    }
    return found;
}

/* Of a load on a rod of length 1. */
static scene_breaks along(const char *load)
{
    scene rod = rod_of_length(1);
    rod.loads.force[0] = Q(load);
    return breaks_of(&rod, "s");
}

static void assert_places(const scene_breaks *found, int count, const double *places)
{
    assert_null(found->unresolved);
    if (found->count != count) {
        fail_msg("%d places, not %d, the first at %.17g", found->count, count, found->place[0]);
    }
    for (int i = 0; i < count; i++) { /* exact to rounding of the condition */
        assert_near(found->place[i], places[i], 2 * DBL_EPSILON);
    }
}

#define ASSERT_ALONG(load, ...)                                                                    \
    do {                                                                                           \
        const double places[] = {__VA_ARGS__};                                                     \
        scene_breaks found = along(load);                                                          \
        assert_places(&found, sizeof places / sizeof *places, places);                             \
    } while (0)

static void test_places(void **state)
{
    (void)state;
    ASSERT_ALONG("where(s-0.3, 1, 0)", 0.3);
    ASSERT_ALONG("where(0.3-s, 1, 0)", 0.3);
    ASSERT_ALONG("where((s-0.123)*(0.124-s), -2, 0)", 0.123, 0.124);
    ASSERT_ALONG("where((s-0.7)*(0.7000001-s), -2, 0)", 0.7, 0.7000001);
    ASSERT_ALONG("step(s-0.25)*s + abs(s-0.5)", 0.25, 0.5);
    ASSERT_ALONG("min(s, 1-s)", 0.5);
    ASSERT_ALONG("max(s^2, 0.25)", 0.5);
    ASSERT_ALONG("where(sin(6*pi*s), 1, -1)", 1.0 / 6, 2.0 / 6, 3.0 / 6, 4.0 / 6, 5.0 / 6);
    ASSERT_ALONG("sqrt(where(s-0.5, s-0.5, 0))", 0.5); /* written in two ways, one place */
    ASSERT_ALONG("asin(1.25*s)", 0.8);
    ASSERT_ALONG("(s-0.5)^3*abs(s-0.5)^1.5", 0.5);
    ASSERT_ALONG("where(step(s-0.3)-0.5, 1, 0)", 0.3); /* of a jump */
    ASSERT_ALONG("where(max(s-0.3, 0), 1, 0)", 0.3);   /* of a stretch of 0 */
    ASSERT_ALONG("where(s^3-0.6*s^2+0.11*s-0.006, 1, 0)", 0.1, 0.2, 0.3);
    ASSERT_ALONG("where(0.01 - (s-0.5)^2 + where(s-0.45, 0, 0.02), 1, 0)", 0.5 - sqrt(0.03), 0.45,
                 0.6);
}

static void test_none(void **state)
{
    static const char *const smooth[] = {"sin(20*s)",    "where(s+1, s, 0)", "abs(2+sin(9*s))",
                                         "step(-1-s^2)", "(s-0.5)^2",        "3"};
    (void)state;
    for (size_t i = 0; i < sizeof smooth / sizeof *smooth; i++) {
        scene_breaks found = along(smooth[i]);
        assert_places(&found, 0, NULL);
    }
    scene rod = rod_of_length(1);
    rod.loads.force[0] = Q("where(s-0.5, 1, 0)");
    scene_breaks found = breaks_of(&rod, "t");
    assert_places(&found, 0, NULL);
}

/* A zero that touches may be a place or not; the work stays bounded. */
static void test_touching(void **state)
{
    static const char *const texts[] = {
        "where((s-0.3)^2, 1, 0)", "where(-(s-0.3)^2, 1, 0)", "where(s*s-0.6*s+0.09, 1, 0)",
        "abs((s-0.3)^4)",         "where(s-s, 1, 0)",        "where(0*s, 1, 0)"};
    (void)state;
    for (size_t i = 0; i < sizeof texts / sizeof *texts; i++) {
        scene_breaks found = along(texts[i]);
        assert_null(found.unresolved);
        assert_true(found.count <= 1);
    }
}

static void test_unresolved(void **state)
{
    (void)state;
    scene_breaks many = along("where(sin(3000*s), 1, 0)");
    assert_string_equal(many.unresolved, "loads.force");
    scene rod = rod_of_length(1);
    rod.duration = Q(2.0);
    rod.loads.force[1] = Q("where(0.1-abs(s-t), 1, 0)");
    rod.loads.force[2] = Q("where(s-0.5, t, 0) + where(t-0.25, s, 0)");
    rod.loads.tip.force[0] = Q("step((t-1.5)*(2+sin(t)))");
    scene_breaks curve = breaks_of(&rod, "s"), instants = breaks_of(&rod, "t");
    assert_string_equal(curve.unresolved, "loads.force");
    assert_string_equal(instants.unresolved, "loads.force");
    assert_near(curve.place[0], 0.5, 0);
    assert_int_equal(instants.count, 2);
    assert_near(instants.place[0], 0.25, 0);
    assert_near(instants.place[1], 1.5, 0);
}

/* Of both coordinates, but switching at one place for all times. */
static void test_product(void **state)
{
    (void)state;
    scene rod = rod_of_length(2);
    rod.duration = Q(3.0);
    rod.loads.force[1] = Q("where((s-0.7)*(1+t^2), 1, 0)");
    scene_breaks found = breaks_of(&rod, "s");
    assert_null(found.unresolved);
    assert_int_equal(found.count, 1);
    assert_near(found.place[0], 0.7, 1e-12);
}

static void test_lists(void **state)
{
    static const double places[] = {0.25, 0.4, 0.5, 0.75, 1.0, 1.1, 1.25, 1.5, 1.75};
    (void)state;
    scene rod = rod_of_length(2);
    rod.segment_count = 3;
    rod.segments[0].length = Q(0.5);
    rod.segments[0].rod.radius = Q("where(s-0.25, 1, 2) + where(s-0.75, 1, 2)"); /* one within */
    rod.segments[1].length = Q(0.5);
    rod.segments[2].length = Q(1.0);
    rod.point_count = rod.body_count = rod.spring_count = 1;
    rod.points[0].at = Q(0.75);
    rod.bodies[0].at = Q(2.0); /* an end is no break */
    rod.springs[0].at = Q(1.25);
    rod.tendon_count = rod.chamber_count = 1;
    rod.tendons[0].start = Q(0.0);
    rod.tendons[0].end = Q(1.5);
    rod.tendons[0].offset[0] = Q("abs(s-0.4)");
    rod.chambers[0].start = Q(0.5);
    rod.chambers[0].end = Q(1.75);
    rod.chambers[0].area = Q("1 + step(s-1.1)");
    scene_breaks found = breaks_of(&rod, "s");
    assert_places(&found, sizeof places / sizeof *places, places);
}

static void test_in_time(void **state)
{
    (void)state;
    scene rod = rod_of_length(2);
    rod.duration = Q(4.0);
    rod.loads.tip.force[0] = Q("where(t-0.5, 1, 0)");
    rod.point_count = 1;
    rod.points[0].at = Q(1.0);
    rod.points[0].load.force[1] = Q("where((t-1)*(1.0001-t), 1e4, 0)");
    scene_breaks found = breaks_of(&rod, "t");
    const double places[] = {0.5, 1, 1.0001};
    assert_places(&found, 3, places);
}

/* Bands of any width, as long as doubles tell their ends apart. */
static void test_bands(void **unused)
{
    uint64_t state = 3;
    (void)unused;
    for (int i = 0; i < 200; i++) {
        double width = pow(10, random_in(&state, -9, -1)), a = random_in(&state, 0.01, 0.8);
        double b = a + width;
        char text[128];
        snprintf(text, sizeof text, "where((s-%.17g)*(%.17g-s), -2, 0)", a, b);
        const double places[] = {a, b};
        scene_breaks found = along(text);
        assert_places(&found, 2, places);
    }
}

/* ---- panels ---------------------------------------------------------------------------------- */

static scene_panels panels_of(const char *load)
{
    scene rod = rod_of_length(1);
    scene_panels found;
    ad_error error = {AD_OK, ""};
    rod.loads.force[0] = Q(load);
    if (scene_panels_of(&rod, "s", &found, &error) != AD_OK) {
        fail_msg("%s", error.message);
    }
    assert_null(found.unresolved);
    assert_true(found.edges[0] == 0 && found.edges[found.count] == 1);
    for (int i = 0; i < found.count; i++) {
        assert_true(found.edges[i] < found.edges[i + 1]);
    }
    return found;
}

/* What does not vary much takes one panel between breaks. */
static void test_few_panels(void **state)
{
    static const struct {
        const char *load;
        int most;
    } rows[] = {{"3", 1},
                {"sin(5*s)*exp(s)-s^3", 2},
                {"where((s-0.3)*(0.305-s), -2, 0)", 3},
                {"where(s*(0.7-s)-0.12, 1, 2)", 3}, /* 0.3, 0.4, by a condition that cancels */
                {"max(0, 1-abs(s-0.4)/0.01)", 4},
                {"sqrt(s)", 12},
                {"exp(-((s-0.3)/1e-6)^2)", 60},
                {"1/cosh((s-0.3)/1e-5)^2", 60}};
    (void)state;
    for (size_t i = 0; i < sizeof rows / sizeof *rows; i++) {
        scene_panels found = panels_of(rows[i].load);
        if (found.count > rows[i].most) {
            fail_msg("%s: %d panels", rows[i].load, found.count);
        }
        scene_panels_free(&found);
    }
}

/* A bump that is narrow lies on panels that are, whatever else there is. */
static void test_narrow(void **unused)
{
    static const char *const beside[] = {"", "1000*s + ", "20*sin(9*s) + ",
                                         "where(s-0.1, 5, 0) + "};
    uint64_t state = 11;
    (void)unused;
    for (int i = 0; i < 200; i++) {
        double width = pow(10, random_in(&state, -7, -2)), at = random_in(&state, 0.05, 0.95);
        char text[160];
        snprintf(text, sizeof text, "%s0.1*exp(-((s-%.17g)/%.17g)^2)", beside[i % 4], at, width);
        scene_panels found = panels_of(text);
        for (int k = 0; k < found.count; k++) {
            bool around = found.edges[k] <= at && at <= found.edges[k + 1];
            /* as many points as panels are joined by */
            if (around && found.edges[k + 1] - found.edges[k] > 24 * width) {
                fail_msg("%s: a panel from %.17g to %.17g", text, found.edges[k],
                         found.edges[k + 1]);
            }
        }
        scene_panels_free(&found);
    }
}

/* Formulas that vary little on their own length make neither panels nor pieces, however many they
 * are, and hide none that does. */
static void test_many_formulas(void **state)
{
    (void)state;
    scene few = rod_of_length(1);
    few.chamber_count = SCENE_CHAMBERS_MAX;
    few.chambers[SCENE_CHAMBERS_MAX - 1].offset[1] = Q("0.01*exp(-((s-0.3)/1e-3)^2)");
    scene many = few;
    many.rod.density = Q("1000+s");
    many.tendon_count = SCENE_TENDONS_MAX;
    for (int i = 0; i < SCENE_TENDONS_MAX + SCENE_CHAMBERS_MAX - 1; i++) {
        quantity *offset = i < SCENE_TENDONS_MAX ? many.tendons[i].offset
                                                 : many.chambers[i - SCENE_TENDONS_MAX].offset;
        offset[0] = Q("0.01*cos(s)");
        offset[1] = Q("0.01*sin(s)");
    }
    for (int i = 0; i < 3; i++) {
        many.rod.rest_curvature[i] = Q("0.1*s^2");
        many.loads.force[i] = Q("sin(s)");
        many.loads.moment[i] = Q("exp(s)");
    }
    many.loads.foundation[0] = Q("0.3+1e-17*s"); /* varies by rounding */
    assert_true(scene_walk_formulas(&many, "s") > 64);
    scene_panels of_few, of_many;
    domain pieces_few, pieces_many;
    assert_int_equal(scene_panels_of(&few, "s", &of_few, NULL), AD_OK);
    assert_int_equal(scene_panels_of(&many, "s", &of_many, NULL), AD_OK);
    assert_int_equal(of_many.count, of_few.count);
    assert_int_equal(model_domain_of(&few, &pieces_few, NULL), AD_OK);
    assert_int_equal(model_domain_of(&many, &pieces_many, NULL), AD_OK);
    assert_true(pieces_few.pieces > 2);
    assert_int_equal(pieces_many.pieces, pieces_few.pieces);
    scene_panels_free(&of_few);
    scene_panels_free(&of_many);
}

/* Scenes that differ in one thing each, with formulas of the same names. */
static scene kept_scene(quantities *names, int number)
{
    static const char *const loads[] = {"exp(-((s-0.3)/1e-3)^2)", "exp(-((s-0.6)/1e-3)^2)*t"};
    scene rod = rod_of_length(number == 1 ? 1.25 : 1);
    rod.duration = quantity_number(number == 2 ? 2 : 1);
    rod.loads.force[0] = quantity_formula(names, loads[number == 3]);
    rod.point_count = number == 4 || number == 5;
    rod.points[0].at = quantity_number(number == 4 ? 0.4 : 0.7);
    rod.tendon_count = number > 5;
    rod.tendons[0].offset[0] = quantity_formula(names, "0.01*exp(-((s-0.8)/1e-3)^2)");
    rod.tendons[0].end = quantity_number(number == 6 ? 0.81 : 0.75);
    rod.loads.moment[1] = quantity_formula(names, number == 8 ? "where(sin(3000*s), 1, 0)" : "s");
    return rod;
}

/* What is kept of a scene is what is found for it alone, to the last bit. */
static void test_kept(void **state)
{
    enum { SCENES = 9, ROUNDS = 3 };
    (void)state;
    quantities *together = quantities_create();
    assert_non_null(together);
    for (int i = 0; i < SCENES * ROUNDS * 2; i++) {
        const char *coordinate = i % 2 == 0 ? "s" : "t";
        quantities *alone = quantities_create();
        scene one = kept_scene(together, i / 2 % SCENES), same = kept_scene(alone, i / 2 % SCENES);
        scene_panels found, again, expected;
        assert_int_equal(scene_panels_of(&one, coordinate, &found, NULL), AD_OK);
        assert_int_equal(scene_panels_of(&one, coordinate, &again, NULL), AD_OK);
        assert_int_equal(scene_panels_of(&same, coordinate, &expected, NULL), AD_OK);
        const size_t size = ((size_t)expected.count + 1) * sizeof *expected.edges;
        assert_true(found.count == expected.count && again.count == expected.count);
        assert_memory_equal(found.edges, expected.edges, size);
        assert_memory_equal(again.edges, expected.edges, size);
        assert_ptr_equal(found.unresolved, expected.unresolved);
        assert_ptr_equal(again.unresolved, expected.unresolved);
        scene_panels_free(&found);
        scene_panels_free(&again);
        scene_panels_free(&expected);
        quantities_free(alone);
    }
    quantities_free(together);
}

/* Every change of sign that samples show of random conditions is among the places. */
static void test_none_missed(void **unused)
{
    enum { CONDITIONS = 300, SAMPLES = 2000 };
    uint64_t state = 5;
    (void)unused;
    for (int i = 0; i < CONDITIONS; i++) {
        char text[256], load[300];
        snprintf(text, sizeof text, "sin(%.3g*s+%.3g)*%.3g + cos(%.3g*s^2) - %.3g*exp(-%.3g*s)",
                 random_in(&state, 0, 40), random_in(&state, 0, 6), random_in(&state, 0, 2),
                 random_in(&state, 0, 20), random_in(&state, 0, 2), random_in(&state, 0, 9));
        snprintf(load, sizeof load, "where(%s, 1, 0)", text);
        scene_breaks found = along(load);
        quantity condition = Q(text);
        int next = 0, changes = 0;
        assert_null(found.unresolved);
        for (int k = 0; k < SAMPLES; k++) {
            double low = (double)k / SAMPLES, high = (k + 1.0) / SAMPLES;
            bool before = quantity_value(condition, low, 0) > 0;
            bool changed = (quantity_value(condition, high, 0) > 0) != before;
            int here = 0;
            for (; next < found.count && found.place[next] < high; next++) {
                here++;
            }
            changes += changed;
            if (changed != (here % 2 == 1)) {
                fail_msg("%s: %d places between %g and %g", text, here, low, high);
            }
        }
        assert_true(changes <= found.count);
    }
}

static double rise_of(const char *tip, const char *driven)
{
    scene rod = rod_of_length(1);
    rod.duration = Q(1.0);
    rod.loads.tip.force[0] = Q(tip);
    rod.start.position[1] = Q(driven);
    double rise = 0;
    assert_int_equal(scene_rise_time(&rod, &rise, NULL), AD_OK);
    return rise;
}

/* The largest size over the largest rate, which samples miss by a few hundredths; a third where the
 * rate jumps, from rest at t = 0 too, but not that of an end with which the rod moves. */
static void test_rise_time(void **state)
{
    (void)state;
    const double close = 0.03;
    assert_near(rise_of("2*where(0.1-t, sin(5*pi*t)^2, 1)", "0"), 1 / (5 * PI), close / (5 * PI));
    assert_near(rise_of("where(0.1-t, t/0.1, 1)", "0"), 0.1 / 3, close * 0.1 / 3);
    assert_near(rise_of("sin(2*t)", "0"), 1.0 / 6, close / 6);
    assert_near(rise_of("0", "sin(4*t)"), 0.25, close * 0.25);
    assert_true(isinf(rise_of("-3", "0")));
    assert_true(isinf(rise_of("where(t-0.5, 1, 3)", "0"))); /* jumps are sudden */
}

/* The other quantities of its entry of a list get what is allowed, so that formulas are looked at.
 */
static void give_entry(scene *of, const scene_list *list, int index)
{
    int *count = (int *)(void *)((char *)of + list->count_offset);
    *count = index + 1;
    for (int i = 0; i < scene_field_count; i++) {
        int at = 0;
        const scene_field *field = &scene_fields[i];
        quantity *q = (quantity *)(void *)((char *)of + field->offset);
        if (scene_field_list(field, &at) == list && at == index) {
            for (int k = 0; k < field->count; k++) {
                q[k] = field->rule == SCENE_PLACE ? q[k] : Q(0.5);
            }
        }
    }
}

static bool may_vary(const scene_field *field)
{
    return field->rule == SCENE_IN_TIME || field->rule == SCENE_AT_END ||
           field->rule == SCENE_AT_PLACE || field->rule == SCENE_HELD ||
           field->rule == SCENE_EVERYWHERE;
}

/* Every quantity of a scene that may depend on t, set to a narrow pulse, is seen by the one place
 * that windows, steps, meshes and points ask: panels narrow down on it, and so do the instants at
 * which solvers of rods look, those at which a beam's panels end, and the rise time. */
static void test_every_pulse(void **state)
{
    (void)state;
    enum { KEYS_LEAST = 30 };
    const double at = 0.437, width = 2e-3, close = 8 * width;
    int keys = 0;
    for (int i = 0; i < scene_field_count; i++) {
        const scene_field *field = &scene_fields[i];
        int index = 0;
        const scene_list *list = scene_field_list(field, &index);
        scene of = rod_of_length(1);
        of.duration = Q(1.0);
        if (!may_vary(field) || index > 0) {
            continue;
        }
        if (list) {
            give_entry(&of, list, index);
        }
        for (int k = 0; k < field->count; k++) {
            quantity *q = (quantity *)(void *)((char *)&of + field->offset);
            *(q + k) = Q("1 + 3*exp(-((t-0.437)/2e-3)^2)");
        }
        scene_panels panels;
        scene_breaks divisions;
        double rise = 0, wide = 0, nearest = 1;
        assert_int_equal(scene_panels_of(&of, "t", &panels, NULL), AD_OK);
        for (int p = 0; p < panels.count; p++) {
            const double low = panels.edges[p], high = panels.edges[p + 1];
            wide = low < at + width && high > at - width ? fmax(wide, high - low) : wide;
        }
        scene_panels_free(&panels);
        assert_int_equal(scene_divisions_of(&of, "t", BREAKS_MAX, &divisions, NULL), AD_OK);
        for (int p = 0; p < divisions.count; p++) {
            nearest = fmin(nearest, fabs(divisions.place[p] - at));
        }
        assert_int_equal(scene_rise_time(&of, &rise, NULL), AD_OK);
        solve_drives *drives = NULL;
        solve_events *events = NULL;
        const solve_rod rod = {.scene = of, .scales = {.time = 1}, .duration = 1, .dynamic = true};
        assert_int_equal(solve_drives_create(&rod, &drives, NULL), AD_OK);
        assert_int_equal(solve_events_create(&rod, &events, NULL), AD_OK);
        double instant = 1;
        for (size_t k = 0; k < events->count; k++) {
            instant = fmin(instant, fabs(events->times[k] - at));
        }
        if (!(wide <= close && nearest <= close && rise <= close && drives->count > 0 &&
              instant <= close)) {
            fail_msg("%s: panels %g, divisions %g, rise %g, %zu drives, instants %g", field->key,
                     wide, nearest, rise, drives->count, instant);
        }
        assert_string_equal(drives->all[0].key, field->key);
        solve_events_free(events);
        solve_drives_free(drives);
        keys++;
    }
    assert_true(keys >= KEYS_LEAST);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_places),        cmocka_unit_test(test_none),
        cmocka_unit_test(test_touching),      cmocka_unit_test(test_unresolved),
        cmocka_unit_test(test_product),       cmocka_unit_test(test_lists),
        cmocka_unit_test(test_in_time),       cmocka_unit_test(test_bands),
        cmocka_unit_test(test_few_panels),    cmocka_unit_test(test_narrow),
        cmocka_unit_test(test_none_missed),   cmocka_unit_test(test_rise_time),
        cmocka_unit_test(test_many_formulas), cmocka_unit_test(test_every_pulse),
    };
    const struct CMUnitTest alike[] = {cmocka_unit_test(test_kept)};
    return run_with_alike(tests, alike, NULL, NULL);
}
