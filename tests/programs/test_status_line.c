/* The status line fits any terminal and keeps what matters most; the time left counts every window
 * and stage. */
#include <math.h>
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>
#include <stdio.h>
#include <string.h>

#include <cmocka.h>

#include "tools/programs/status_line.h"

enum { NARROW = 40, WIDE = 120 };

/* Every part is present and as long as it gets. */
static const status_line longest = {.optimizer = "gauss_newton",
                                    .window = 1000,
                                    .windows = 1000,
                                    .stage = 32,
                                    .stages = 32,
                                    .step = 100000000,
                                    .steps = 1000000000,
                                    .load_factor = 0.123456,
                                    .loss = 1.234e-100,
                                    .held_out = 1.234e-100,
                                    .error = 1.234e-100,
                                    .left = 359999,
                                    .at_most = true,
                                    .points_per_s = 1e10,
                                    .steps_per_s = 1.234e-100};

static const status_line usual = {.optimizer = "gauss_newton",
                                  .window = 3,
                                  .windows = 120,
                                  .stage = 1,
                                  .stages = 1,
                                  .step = 7,
                                  .steps = 200,
                                  .load_factor = 1,
                                  .loss = 1.234e-5,
                                  .held_out = 2.345e-5,
                                  .error = 3.456e-6,
                                  .left = 4805,
                                  .points_per_s = 1.5e6,
                                  .steps_per_s = NAN};

static void every_width_holds_the_error(void **state)
{
    (void)state;
    const status_line *const lines[] = {&longest, &usual};
    char text[STATUS_LINE_SIZE];
    for (size_t i = 0; i < 2; i++) {
        int before = 0;
        for (int width = NARROW; width <= WIDE; width++) {
            int length = status_line_text(lines[i], width, text);
            assert_int_equal(length, strlen(text));
            assert_true(length <= width);
            assert_true(length >= before);
            assert_non_null(strstr(text, i ? "error 3.46e-06" : "error 1.23e-100"));
            assert_non_null(strstr(text, i ? "loss 1.23e-05" : "loss 1.23e-100"));
            before = length;
        }
    }
    assert_true(status_line_text(&usual, 5, text) == 0);
}

static void sixty_columns(void **state)
{
    (void)state;
    char text[STATUS_LINE_SIZE];
    status_line line = usual;
    status_line_text(&line, 59, text);
    assert_string_equal(text, "window 3/120  loss 1.23e-05  error 3.46e-06  1h20m left");
    line.windows = 1;
    line.left = 75;
    line.at_most = true;
    status_line_text(&line, 59, text);
    assert_string_equal(text, "step 7/200  loss 1.23e-05  error 3.46e-06  <1m15s left");
    line.error = line.left = NAN; /* no reference, no estimate */
    line.steps = 0;
    status_line_text(&line, 59, text);
    assert_string_equal(text, "gauss_newton 1/1 step 7  loss 1.23e-05  held-out 2.35e-05");
}

static void a_log_has_room_for_all(void **state)
{
    (void)state;
    char text[STATUS_LINE_SIZE];
    status_line line = usual;
    line.load_factor = 0.25;
    status_line_text(&line, STATUS_LINE_WIDE, text);
    assert_string_equal(text, "window 3/120 gauss_newton 1/1 step 7/200  load factor 0.25  "
                              "loss 1.23e-05  held-out 2.35e-05  error 3.46e-06  1h20m left  "
                              "1.50M points/s");
    line.steps_per_s = 12.34;
    status_line_text(&line, STATUS_LINE_WIDE, text);
    assert_non_null(strstr(text, "1h20m left  12.3 steps/s  1.50M points/s"));
    line.left = 0.2;
    status_line_text(&line, STATUS_LINE_WIDE, text);
    assert_non_null(strstr(text, "  <1s left"));
    line.left = 400000;
    status_line_text(&line, STATUS_LINE_WIDE, text);
    assert_non_null(strstr(text, "  4d15h left"));
    assert_true(status_line_text(&longest, STATUS_LINE_WIDE, text) < STATUS_LINE_WIDE);
}

/* ---- time left ----------------------------------------------------------------------------- */

/* Numbers of seconds below are small integers and halves, so that sums of them are exact. */
static const train_stage stages[] = {{.optim.method = OPTIM_ADAM, .steps = 100},
                                     {.optim.method = OPTIM_GAUSS_NEWTON, .steps = 40}};

static const status_pace pace_0 = {.stages = stages,
                                   .stage_count = 2,
                                   .stage_step = 20,
                                   .stage_seconds = 10,
                                   .step_seconds = 0.5,
                                   .window_seconds = 10,
                                   .limit_left = INFINITY};

static void steps_of_all_stages_and_windows(void **state)
{
    (void)state;
    bool at_most;
    status_pace pace = pace_0;
    assert_true(status_time_left(&pace, &at_most) == (80 + 40) * 0.5);
    assert_true(at_most); /* gauss_newton may end by itself */
    pace.windows_left = 3;
    assert_true(status_time_left(&pace, &at_most) == (80 + 40 + 3 * 140) * 0.5);
    pace.stage = 1;
    assert_true(status_time_left(&pace, &at_most) == (20 + 3 * 140) * 0.5);
    pace.stage = 0;
    pace.stage_count = 1;
    pace.windows_left = 0;
    assert_true(status_time_left(&pace, &at_most) == 80 * 0.5);
    assert_false(at_most);
    pace.step_seconds = NAN;
    assert_true(isnan(status_time_left(&pace, &at_most)));
}

static void stop_seconds_come_first(void **state)
{
    (void)state;
    bool at_most;
    train_stage limited[2] = {stages[0], stages[1]};
    status_pace pace = pace_0;
    pace.stages = limited;
    pace.windows_left = 1;
    limited[0].stop_seconds = 30; /* in place of 50 */
    limited[1].stop_seconds = 5;  /* in place of 20 */
    assert_true(status_time_left(&pace, &at_most) == (30 - 10) + 5 + 30 + 5);
    pace.stage_seconds = 40;
    assert_true(status_time_left(&pace, &at_most) == 0 + 5 + 30 + 5);
    pace.step_seconds = NAN; /* the limits hold without a step */
    assert_true(status_time_left(&pace, &at_most) == 0 + 5 + 30 + 5);
}

static void windows_that_were_timed(void **state)
{
    (void)state;
    bool at_most;
    status_pace pace = pace_0;
    pace.windows_left = 3;
    pace.windows_timed = 2;
    pace.windows_seconds = 24; /* 12 each */
    assert_true(status_time_left(&pace, &at_most) == (12 - 10) + 3 * 12);
    assert_false(at_most);
    pace.window_seconds = 20; /* longer than usual: its end is near */
    assert_true(status_time_left(&pace, &at_most) == 3 * 12);
    pace.windows_seconds = 4e4; /* no more than all the steps take */
    assert_true(status_time_left(&pace, &at_most) == (80 + 40 + 3 * 140) * 0.5);
}

static void what_is_not_known(void **state)
{
    (void)state;
    bool at_most;
    status_pace pace = pace_0;
    pace.repeats = true;
    assert_true(isnan(status_time_left(&pace, &at_most)));
    pace.limit_left = 7;
    assert_true(status_time_left(&pace, &at_most) == 7);
    assert_true(at_most);
    pace.repeats = false;
    pace.limit_left = 1e6;
    assert_true(status_time_left(&pace, &at_most) == (80 + 40) * 0.5);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(every_width_holds_the_error),
        cmocka_unit_test(sixty_columns),
        cmocka_unit_test(a_log_has_room_for_all),
        cmocka_unit_test(steps_of_all_stages_and_windows),
        cmocka_unit_test(stop_seconds_come_first),
        cmocka_unit_test(windows_that_were_timed),
        cmocka_unit_test(what_is_not_known),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
