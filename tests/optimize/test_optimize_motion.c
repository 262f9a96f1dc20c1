/* Motions of least time and effort against closed forms, and derivatives of their equations. */
#include "near.h"
#include "physics/quantity/quantity.h"
#include "temporary_folder.h"
#include "tools/optimize/motion.h"
#include "tools/optimize/optimize.h"

#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

/* A cantilever, EI = L = rho A = 1, with a small force at its tip. Its curvature is that of one
 * mode: the same all along, so that w = q s^2/2 has the mass 1/20, the stiffness 1 and the load 1/2
 * of the force. q/q_F of the largest force F is then x with x'' = 20 (u - x), |u| <= 1. */
static const double FORCE = 1e-3;

static scene cantilever(quantities *names)
{
    scene of;
    ad_error error;
    scene_defaults(&of);
    of.rod.model = SCENE_KIRCHHOFF;
    of.rod.length = of.rod.mass_per_length = quantity_number(1);
    of.rod.torsional_stiffness = quantity_number(1);
    for (int i = 0; i < 2; i++) {
        of.rod.bending_stiffness[i] = quantity_number(1);
    }
    for (int i = 0; i < 3; i++) {
        of.rod.rotary_inertia[i] = quantity_number(1e-9);
    }
    of.duration = quantity_number(1);
    of.parameter_count = 1;
    of.parameters[0] = (scene_parameter){"force", -FORCE, FORCE, SCENE_LINEAR};
    assert_int_equal(quantities_coordinate(names, "force", &error), AD_OK);
    of.end.type = SCENE_LOADED;
    of.loads.tip.force[0] = quantity_formula(names, "force");
    for (int i = 1; i < 3; i++) {
        of.loads.tip.force[i] = quantity_number(0);
    }
    return of;
}

static optimize_motion *make(const optimize_settings *settings, const scene *of)
{
    optimize_motion *made = NULL;
    ad_error error = {.message = ""};
    char key[64] = "";
    optimize_motion_create(settings, of, NULL, &made, key, &error);
    assert_string_equal(error.message, "");
    return made;
}

static optimize_motion_report run(optimize_motion *motion)
{
    optimize_motion_report report;
    ad_error error = {.message = ""};
    assert_int_equal(optimize_motion_run(motion, &report, &error), AD_OK);
    assert_true(report.found);
    return report;
}

/* Twice what half of the intervals leave is at least the error, and less than twice of it
 * (tools/optimize/motion_run.c); 1e-6 is what IPOPT leaves of it. */
static void assert_error(double estimate, double error)
{
    assert_true(estimate > error - 1e-6 && estimate < 2 * error + 1e-6);
}

/* From rest at x = -1/2 to rest at 1/2: around u = 1 by the angle acos(1/(1 + 1/2)) to x = 0, then
 * around u = -1 as far. The switch is where two of an even number of intervals meet, and the method
 * of order 5 is off by less than the 1e-7 to which the end is at rest. With an odd number it is
 * not, and the motion takes longer. */
static void the_quickest_motion_switches_once(void **state)
{
    (void)state;
    quantities *names = quantities_create();
    const scene of = cantilever(names);
    optimize_settings settings = {.motion = {.start = "force=-0.5e-3",
                                             .end = "force=0.5e-3",
                                             .intervals = 20,
                                             .modes = {1, 0, 0, 0}},
                                  .points = 9,
                                  .radius = NAN};
    const double known = 2 * acos(1 / 1.5) / sqrt(20);
    ad_error error;
    optimize_motion *motion = make(&settings, &of);
    const optimize_motion_report even = run(motion);
    assert_near(even.duration, known, 1e-6 * known);
    assert_true(even.error < 1e-6 * known);
    assert_true(even.same.off < 1e-6 * even.way);
    for (int k = 0; k <= 20; k++) {
        double t, input, tip[3];
        assert_int_equal(optimize_motion_at(motion, k, &t, &input, tip, &error), AD_OK);
        assert_near(t, known * k / 20, 1e-6);
        assert_near(input / FORCE, k < 10 ? 1 : k < 20 ? -1 : 0.5, 1e-4);
    }
    optimize_motion_free(motion);
    settings.motion.intervals = 21;
    motion = make(&settings, &of);
    const optimize_motion_report odd = run(motion);
    assert_true(odd.duration > known + 1e-6 && odd.duration < known * 1.01);
    assert_error(odd.error, odd.duration - known);
    optimize_motion_free(motion);
    quantities_free(names);
}

/* Of held inputs u_k the state (x, x'/w) at the end is what it would be without, and a sum of b_k
 * u_k: that of least squares is b_k^T W^-1 of what is missing, W the sum of b_k b_k^T. */
static void the_least_effort_is_that_of_least_squares(void **state)
{
    (void)state;
    enum { N = 16 };
    quantities *names = quantities_create();
    const scene of = cantilever(names);
    const optimize_settings settings = {.motion = {.minimize = OPTIMIZE_EFFORT,
                                                   .start = "force=0",
                                                   .end = "force=0.5e-3",
                                                   .intervals = N,
                                                   .modes = {1, 0, 0, 0}},
                                        .points = 9,
                                        .radius = NAN};
    optimize_motion *motion = make(&settings, &of);
    const optimize_motion_report report = run(motion);
    const double turn = sqrt(20) / N;
    double b[N][2], w[3] = {0}, effort = 0;
    for (int k = 0; k < N; k++) { /* what is left of 1 held in interval k, turned on to the end */
        const double on = turn * (N - 1 - k);
        const double x = 1 - cos(turn), v = sin(turn);
        b[k][0] = cos(on) * x + sin(on) * v;
        b[k][1] = -sin(on) * x + cos(on) * v;
        w[0] += b[k][0] * b[k][0];
        w[1] += b[k][0] * b[k][1];
        w[2] += b[k][1] * b[k][1];
    }
    const double over = 0.5 / (w[0] * w[2] - w[1] * w[1]);
    for (int k = 0; k < N; k++) {
        const double u = over * (w[2] * b[k][0] - w[1] * b[k][1]);
        double t, input, tip[3];
        ad_error error;
        assert_int_equal(optimize_motion_at(motion, k, &t, &input, tip, &error), AD_OK);
        assert_near(input / FORCE, u, 1e-4);
        effort += u * u / 4 / N; /* the range is 2 FORCE */
    }
    assert_near(report.duration, 1, 0);
    assert_near(report.effort, effort, 1e-5 * effort);
    /* Of inputs that change at any time: the same sums as integrals. */
    const double half = 10, more = sqrt(20) / 4 * sin(2 * sqrt(20)),
                 cross = sqrt(5) * pow(sin(sqrt(20)), 2);
    const double least = 0.25 * (half + more) / (half * half - more * more - cross * cross) / 4;
    assert_error(report.error, report.effort - least);
    optimize_motion_free(motion);
    quantities_free(names);
}

/* From x = -1/2 to 1/2 as above, but no faster than V: x = 1 - 3/2 cos(w t) until it has the speed
 * V, then at that speed, and the same backwards. Points keep the bound, and their mean is that of
 * the way: no motion is quicker. Held inputs, which switch where intervals meet, take longer by
 * what falls as h^2: 1e-3 with 40. On the way at V the speed is a parabola with the second
 * derivative -20 V: between points, at most 0.49 h apart, it is above V by less than 10 V (0.245
 * h)^2. */
static void a_speed_that_is_bounded_is_kept(void **state)
{
    (void)state;
    quantities *names = quantities_create();
    const scene of = cantilever(names);
    char text[100];
    const double w = sqrt(20), V = 3, at = asin(V / (1.5 * w));
    const double known = 2 * at / w + 2 * (1.5 * cos(at) - 1) / V;
    const double tip = FORCE / 4; /* m of x = 1 */
    optimize_settings settings = {.motion = {.start = "force=-0.5e-3",
                                             .end = "force=0.5e-3",
                                             .intervals = 40,
                                             .modes = {1, 0, 0, 0}},
                                  .constraint_count = 1,
                                  .constraints = {text},
                                  .points = 9,
                                  .radius = NAN};
    snprintf(text, sizeof text, "tip.vx <= %.17g", V * tip);
    for (int i = 0; i < 2; i++) {
        optimize_motion *motion = make(&settings, &of);
        const optimize_motion_report found = run(motion);
        const double h = found.duration / settings.motion.intervals;
        assert_true(found.duration > known * (1 - 1e-6));
        assert_true(found.duration < known * (1 + (i ? 2.5e-4 : 1e-3)));
        assert_error(found.error, found.duration - known);
        assert_near(found.spread[0], V * tip, 1e-12);
        assert_true(found.same.beyond[0] > 0);
        assert_true(found.same.beyond[0] < 10 * V * tip * 0.06 * h * h);
        assert_true(found.finer.beyond[0] > found.same.beyond[0]); /* what is left out shakes */
        optimize_motion_free(motion);
        settings.motion.intervals *= 2;
    }
    quantities_free(names);
}

/* An input that changes by no more than r a second, from x = u = 0 to 1/2: of rates r, -r, r. With
 * r = 3/2 w/pi each takes a third of T = pi/w, which leaves u = 1/2 and, as the integral of
 * the rate by exp(iwt) is 0, the rod at rest. */
static void an_input_changes_no_faster_than_its_bound(void **state)
{
    (void)state;
    quantities *names = quantities_create();
    const scene of = cantilever(names);
    char text[100];
    const double w = sqrt(20), pi = acos(-1), known = pi / w;
    const optimize_settings settings = {.motion = {.start = "force=0",
                                                   .end = "force=0.5e-3",
                                                   .intervals = 12,
                                                   .modes = {1, 0, 0, 0}},
                                        .constraint_count = 1,
                                        .constraints = {text},
                                        .points = 9,
                                        .radius = NAN};
    snprintf(text, sizeof text, "abs(force.rate) <= %.17g", 1.5 * w / pi * FORCE);
    optimize_motion *motion = make(&settings, &of);
    const optimize_motion_report found = run(motion);
    assert_true(optimize_motion_is_linear(motion));
    assert_near(found.duration, known, 1e-6 * known);
    assert_true(found.same.beyond[0] < 1e-6 * found.spread[0]);
    assert_true(found.same.off < 1e-6 * found.way);
    for (int k = 0; k <= 12; k++) {
        static const double wanted[] = {0, 1, 0, 1};
        const double low = wanted[k / 4], high = wanted[k < 12 ? k / 4 + 1 : 3];
        double t, input, tip[3];
        ad_error error;
        assert_int_equal(optimize_motion_at(motion, k, &t, &input, tip, &error), AD_OK);
        assert_near(input / FORCE, (low + (high - low) * (k % 4) / 4) / 2, 1e-4);
    }
    optimize_motion_free(motion);
    quantities_free(names);
}

/* Of all rows, where the rod is bent far and moves, by differences of fourth order, which do not
 * change with their step. Derivatives of the rod are exact but for the turn between its points, of
 * order 6 (physics/chain/modes.h): 2e-8 here. */
static void derivatives_are_those_of_the_equations(void **state)
{
    (void)state;
    static const double weight[4] = {1, -8, 8, -1}, way[4] = {-2, -1, 1, 2};
    quantities *names = quantities_create();
    scene of = cantilever(names);
    of.rod.rotary_inertia[0] = of.rod.rotary_inertia[1] = quantity_number(0.01);
    of.rod.rotary_inertia[2] = quantity_number(0.02);
    of.parameters[0].low = -3;
    of.parameters[0].high = 3;
    for (int i = 0; i < 4; i++) { /* the first two without bounds, the others linear */
        const optimize_settings settings = {
            .motion = {.minimize = i % 2 ? OPTIMIZE_EFFORT : OPTIMIZE_TIME,
                       .start = "force=0",
                       .end = "force=2",
                       .intervals = 4,
                       .modes = {2, 1, 0, 0}},
            .constraint_count = i / 2 * 6,
            .constraints = {"tip.x*middle.speed + tip.qw <= 1.5", "max(curvature + force*s) <= 6",
                            "force.rate^2 <= 30", "-9 <= mean(w1 + tx + w3*vz) <= 9",
                            "energy + force*force.rate <= 90", "min(vx - u3) >= -2"},
            .place_count = 1,
            .places = {{"middle", 0.4}},
            .points = 9,
            .radius = NAN};
        optimize_motion *motion = make(&settings, &of);
        const descent d = optimize_motion_problem(motion);
        double *x = malloc(d.n * sizeof *x), *by = malloc(d.nonzeros * sizeof *by);
        double *slope = calloc(d.m, sizeof *slope), *gradient = malloc(d.n * sizeof *gradient);
        for (size_t i = 0; i < d.n; i++) {
            x[i] = 0.4 + 0.3 * sin(1.7 * (double)i);
        }
        assert_true(d.at(d.of, x));
        memcpy(by, d.by, d.nonzeros * sizeof *by);
        memcpy(gradient, d.gradient, d.n * sizeof *gradient);
        for (size_t i = 0; i < d.n; i++) {
            const double step = 1e-3, kept = x[i];
            double of_value = 0, largest = 1;
            memset(slope, 0, d.m * sizeof *slope);
            for (int k = 0; k < 4; k++) {
                x[i] = kept + way[k] * step;
                assert_true(d.at(d.of, x));
                of_value += weight[k] * *d.value / (12 * step);
                for (size_t r = 0; r < d.m; r++) {
                    slope[r] += weight[k] * d.row[r] / (12 * step);
                    largest = fmax(largest, fabs(d.row[r]));
                }
            }
            x[i] = kept;
            assert_near(gradient[i], of_value, 1e-10);
            for (size_t e = 0; e < d.nonzeros; e++) {
                if ((size_t)d.column_of[e] == i) {
                    slope[d.row_of[e]] -= by[e];
                }
            }
            for (size_t r = 0; r < d.m; r++) {
                assert_near(slope[r], 0, 1e-7 * largest);
            }
        }
        free(x);
        free(by);
        free(slope);
        free(gradient);
        optimize_motion_free(motion);
    }
    quantities_free(names);
}

/* Inside of a box whose nearest wall is at x = 1.5, which a rod of radius 0.25 comes close to: rows
 * and derivatives are those of 1.25 - x. */
static void a_clearance_is_that_of_a_wall(void **state)
{
    static const char box[] = "v -9 -9 -9\nv 1.5 -9 -9\nv 1.5 9 -9\nv -9 9 -9\nv -9 -9 9\n"
                              "v 1.5 -9 9\nv 1.5 9 9\nv -9 9 9\nf 1 4 3\nf 1 3 2\nf 5 6 7\n"
                              "f 5 7 8\nf 1 2 6\nf 1 6 5\nf 2 3 7\nf 2 7 6\nf 3 4 8\nf 3 8 7\n"
                              "f 4 1 5\nf 4 5 8\n";
    (void)state;
    environment_settings around = ENVIRONMENT_DEFAULT;
    environment *room = NULL;
    ad_error error = {.message = ""};
    char key[64];
    if (!environment_is_built()) {
        return;
    }
    FILE *file = fopen(at("box.obj"), "w");
    assert_non_null(file);
    fputs(box, file);
    fclose(file);
    around.file = at("box.obj");
    assert_int_equal(environment_open(&around, 1, &room, &error), AD_OK);
    quantities *names = quantities_create();
    const scene of = cantilever(names);
    optimize_motion *motion[2];
    descent d[2];
    for (int i = 0; i < 2; i++) {
        const optimize_settings settings = {
            .motion = {.start = "force=0",
                       .end = "force=1e-3",
                       .intervals = 4,
                       .modes = {2, 1, 0, 0}},
            .constraint_count = 1,
            .constraints = {i ? "min(1.25 - x) >= 0.5" : "min(clearance) >= 0.5"},
            .points = 9,
            .radius = 0.25};
        optimize_motion_create(&settings, &of, room, &motion[i], key, &error);
        assert_string_equal(error.message, "");
        d[i] = optimize_motion_problem(motion[i]);
        for (size_t k = 0; k < d[i].n; k++) {
            d[i].x[k] += 0.3 * sin(1.7 * (double)k);
        }
        assert_true(d[i].at(d[i].of, d[i].x));
    }
    for (size_t r = 0; r < d[0].m; r++) {
        assert_near(d[0].row[r] - d[0].row_low[r], d[1].row[r] - d[1].row_low[r], 1e-12);
    }
    for (size_t e = 0; e < d[0].nonzeros; e++) {
        assert_near(d[0].by[e], d[1].by[e], 1e-11 * fmax(1, fabs(d[1].by[e])));
    }
    for (int i = 0; i < 2; i++) {
        optimize_motion_free(motion[i]);
    }
    quantities_free(names);
    environment_free(room);
}

static void what_is_no_motion_is_refused(void **state)
{
    (void)state;
    const struct {
        const char *start, *end, *force, *key, *says;
        double duration;
        const char *bound;
    } cases[] = {
        {"force=0", NULL, "force", "optimize.motion.end", "is not given", 1, NULL},
        {"force=1", "force=0", "force", "optimize.motion.start", "range", 1, NULL},
        {"force=0", "force=0", "force", "optimize.motion", "the rod is at rest", 0, NULL},
        {"force=0", "force=0", "force*t", "optimize.motion", "depend on t", 1, NULL},
        {"force=0", "force=0", "force", NULL, "an equality", 1, "tip.x = 0"},
        {"force=0", "force=1e-3", "force", NULL, "at rest at the end", 1, "tip.x <= 1e-6"},
        {"force=0", "force=0", "force", NULL, "what damping adds", 1, "tip.m1 <= 1"},
        {"force=0", "force=0", "force", NULL, "has the time t", 1, "tip.x + t <= 1"},
        {"force=0", "force=0", "force", NULL, "unknown name 'time.rate'", 1, "time.rate <= 1"},
    };
    for (size_t i = 0; i < sizeof cases / sizeof *cases; i++) {
        quantities *names = quantities_create();
        scene of = cantilever(names);
        const optimize_settings settings = {.motion = {.start = cases[i].start,
                                                       .end = cases[i].end,
                                                       .intervals = 4,
                                                       .modes = {1, 0, 0, 0}},
                                            .constraint_count = cases[i].bound != NULL,
                                            .constraints = {cases[i].bound},
                                            .points = 9,
                                            .radius = NAN};
        optimize_motion *motion = NULL;
        char key[64] = "";
        ad_error error = {.message = ""};
        of.duration = quantity_number(cases[i].duration);
        of.loads.tip.force[0] = quantity_formula(names, cases[i].force);
        assert_int_equal(optimize_motion_create(&settings, &of, NULL, &motion, key, &error),
                         AD_BAD_INPUT);
        assert_null(motion);
        assert_string_equal(key, cases[i].bound ? "optimize.constraints[0]" : cases[i].key);
        assert_non_null(strstr(error.message, cases[i].says));
        quantities_free(names);
    }
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(derivatives_are_those_of_the_equations),
        cmocka_unit_test(a_clearance_is_that_of_a_wall),
        cmocka_unit_test(what_is_no_motion_is_refused),
        cmocka_unit_test(the_quickest_motion_switches_once),
        cmocka_unit_test(a_speed_that_is_bounded_is_kept),
        cmocka_unit_test(an_input_changes_no_faster_than_its_bound),
        cmocka_unit_test(the_least_effort_is_that_of_least_squares),
    };
    return cmocka_run_group_tests(tests, make_directory, remove_directory);
}
