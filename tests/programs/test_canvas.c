/* Pictures of characters: a line gives these dots and no others, charts have their numbers where
 * their curves are, and a rod in a plane is seen from the side. */
#include <math.h>
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>
#include <stdio.h>
#include <string.h>

#include <cmocka.h>

#include "tools/programs/chart.h"
#include "tools/programs/shape_views.h"

static canvas c;

static const char *row(int index, bool utf8, bool colours)
{
    static char text[CANVAS_LINE_SIZE + 1];
    const size_t size = canvas_row(&c, index, utf8, colours, text);
    assert_true(size <= CANVAS_LINE_SIZE);
    text[size] = '\0';
    return text;
}

static void a_line_gives_these_dots(void **state)
{
    const canvas_view all = {.columns = 3, .rows = 2, .right = 5, .top = 7};
    (void)state;
    canvas_clear(&c, 3, 2);
    canvas_line(&c, &all, CANVAS_CYAN, 0, 7, 5, 7); /* the uppermost dots */
    assert_string_equal(row(0, true, false), "⠉⠉⠉");
    assert_string_equal(row(1, true, false), "");
    canvas_line(&c, &all, CANVAS_CYAN, 0, 0, 0, 7); /* those to the left */
    assert_string_equal(row(0, true, false), "⡏⠉⠉");
    assert_string_equal(row(1, true, false), "⡇");
    canvas_clear(&c, 3, 2);
    canvas_line(&c, &all, CANVAS_CYAN, 0, 7, 5, 2); /* a diagonal: 0 1 2 3, 4 5 */
    assert_string_equal(row(0, true, false), "⠑⢄");
    assert_string_equal(row(1, true, false), "  ⠑");
    canvas_clear(&c, 3, 2);
    canvas_line(&c, &all, CANVAS_CYAN, 4, 0, 4, 0); /* one dot */
    assert_string_equal(row(0, true, false), "");
    assert_string_equal(row(1, true, false), "  ⡀");
}

/* What is outside, or no number, is not seen, and nothing is written beside the view. */
static void a_line_stays_in_its_view(void **state)
{
    const canvas_view view = {.column = 1,
                              .row = 1,
                              .columns = 2,
                              .rows = 1,
                              .left = -1,
                              .right = 1,
                              .bottom = -1,
                              .top = 1};
    (void)state;
    canvas_clear(&c, 4, 3);
    canvas_line(&c, &view, CANVAS_RED, -1e9, 1, 1e9, 1);
    assert_string_equal(row(1, true, false), " ⠉⠉");
    canvas_line(&c, &view, CANVAS_RED, -1, -5e8, -1, 7e9);
    assert_string_equal(row(1, true, false), " ⡏⠉");
    canvas_line(&c, &view, CANVAS_RED, -2, 0, 0, 2.5);
    canvas_line(&c, &view, CANVAS_RED, NAN, 0, 1, 1);
    canvas_line(&c, &view, CANVAS_RED, 0, 0, INFINITY, 1);
    canvas_line(&c, &view, CANVAS_RED, -1e300, -1e300, 1e300, -1e300);
    assert_string_equal(row(1, true, false), " ⡏⠉");
    assert_string_equal(row(0, true, false), "");
    assert_string_equal(row(2, true, false), "");
}

static void text_and_colours(void **state)
{
    const canvas_view all = {.columns = 8, .rows = 1, .right = 15, .top = 3};
    (void)state;
    canvas_clear(&c, 8, 1);
    canvas_line(&c, &all, CANVAS_CYAN, 0, 3, 15, 3);
    canvas_put(&c, 0, 0, CANVAS_DIM, 0x2524);
    assert_int_equal(canvas_text(&c, 2, 0, CANVAS_PLAIN, "ab"), 4);
    canvas_line(&c, &all, CANVAS_CYAN, 0, 0, 3, 0); /* dots are behind characters */
    canvas_text(&c, 7, 0, CANVAS_PLAIN, "beyond");  /* is cut off */
    assert_string_equal(row(0, true, false), "┤⣉ab⠉⠉⠉b");
    assert_string_equal(row(0, false, false), "+:ab'''b");
    assert_string_equal(row(0, true, true), "\033[2m┤\033[0m\033[36m⣉\033[0mab\033[36m⠉⠉⠉\033[0mb");
}

/* Names are a user's: no byte of theirs moves the cursor. */
static void names_with_other_bytes(void **state)
{
    (void)state;
    canvas_clear(&c, 8, 1);
    assert_int_equal(canvas_text(&c, 0, 0, CANVAS_PLAIN, "a\033[2J\xc3\xa9"), 7);
    assert_string_equal(row(0, true, false), "a?[2J??");
}

/* The longest line there is has room. */
static void every_cell_of_another_colour(void **state)
{
    (void)state;
    canvas_clear(&c, CANVAS_COLUMNS + 10, CANVAS_ROWS + 10);
    assert_int_equal(c.columns, CANVAS_COLUMNS);
    assert_int_equal(c.rows, CANVAS_ROWS);
    for (int i = 0; i < CANVAS_COLUMNS; i++) {
        canvas_put(&c, i, CANVAS_ROWS - 1, i % 2 ? CANVAS_DIM : CANVAS_BLUE, 0x2500);
    }
    assert_true(strlen(row(CANVAS_ROWS - 1, true, true)) > 8 * CANVAS_COLUMNS);
}

/* ---- charts -------------------------------------------------------------------------------- */

/* The row in which the text stands at the left; -1: none. */
static int row_of(const char *text)
{
    for (int i = 0; i < c.rows; i++) {
        if (strstr(row(i, true, false), text)) {
            return i;
        }
    }
    return -1;
}

static void a_chart_has_its_numbers(void **state)
{
    enum { POINTS = 41 };
    double x[POINTS], y[POINTS];
    chart what = {.x_unit = "s", .count = 1, .series = {{POINTS, x, y, CANVAS_CYAN}}};
    (void)state;
    for (int i = 0; i < POINTS; i++) {
        x[i] = 0.25 * i;
        y[i] = i == 20 ? NAN : pow(10, -0.1 * i); /* from 1 to 1e-4, with a gap */
    }
    canvas_clear(&c, 47, 14);
    chart_draw(&c, &what, 0, 0, 47, 14);
    assert_int_equal(row_of("1e+00┤"), 0);
    assert_int_equal(row_of("1e-04┤"), 11);
    assert_int_equal(row_of("└"), 12);
    assert_int_equal(row_of("10 s"), 13);
    assert_non_null(strstr(row(0, true, false), "┤⠑"));
    assert_string_equal(row(11, true, false) + strlen(row(11, true, false)) - 3, "⢄");
    y[0] = 0; /* cannot be drawn */
    y[1] = -1;
    y[2] = INFINITY;
    canvas_clear(&c, 47, 14);
    chart_draw(&c, &what, 0, 0, 47, 14);
    assert_int_equal(row_of("1e+00┤"), -1); /* the first is 10^-0.3 */
    assert_true(row_of("1e-01┤") > 0);
}

static void charts_of_nothing_and_without_room(void **state)
{
    double x[1] = {3}, y[1] = {1e-300};
    chart what = {.x_unit = "s", .count = 1, .series = {{0, x, y, CANVAS_CYAN}}};
    (void)state;
    canvas_clear(&c, 60, 20);
    chart_draw(&c, &what, 0, 0, 60, 20);
    assert_true(row_of("1e-01┤") > row_of("1e+00┤"));
    what.series[0].points = 1;
    chart_draw(&c, &what, 0, 0, 60, 20);
    assert_true(row_of("1e-300") >= 0);
    for (int columns = 0; columns < 60; columns += 7) {
        for (int rows = 0; rows < 20; rows += 3) {
            canvas_clear(&c, columns, rows);
            chart_draw(&c, &what, 0, 0, columns, rows);
        }
    }
}

/* ---- shapes -------------------------------------------------------------------------------- */

static shape_views shapes;

/* A quarter of a circle from x towards axis `towards`, and so far out of that plane. */
static void bend(int towards, double out)
{
    const double radius = 2 / acos(-1);
    memset(&shapes, 0, sizeof shapes);
    shapes.length = 1;
    shapes.count = 1;
    shapes.points = SHAPE_VIEWS_POINTS;
    for (int i = 0; i < SHAPE_VIEWS_POINTS; i++) {
        const double s = (double)i / (SHAPE_VIEWS_POINTS - 1);
        double *place = shapes.places[0][i];
        place[0] = radius * sin(s / radius);
        place[towards] = radius * (1 - cos(s / radius));
        place[3 - towards] = out * s;
    }
}

static int count_of(const char *text)
{
    int count = 0;
    for (int i = 0; i < c.rows; i++) {
        for (const char *at = row(i, true, false); (at = strstr(at, text)); at++) {
            count++;
        }
    }
    return count;
}

static void one_view_of_a_plane(void **state)
{
    (void)state;
    for (int towards = 1; towards <= 2; towards++) {
        bend(towards, 0.01);
        canvas_clear(&c, 40, 20);
        shape_views_draw(&shapes, &c, 0, 0, 40, 20);
        assert_int_equal(count_of("→"), 1);
        assert_int_equal(count_of(towards == 2 ? "z↑ x→" : "y↑ x→"), 1);
        assert_int_equal(count_of("┤ 0.1 m"), 1);
    }
    bend(1, 0.3);
    canvas_clear(&c, 40, 20);
    shape_views_draw(&shapes, &c, 0, 0, 40, 20);
    assert_int_equal(count_of("→"), 2);
    assert_int_equal(count_of("z↑ x→") + count_of("y↑ x→"), 2);
}

/* Both axes have one scale: a quarter of a circle is as wide as tall. */
static void a_quarter_of_a_circle(void **state)
{
    int columns = 0, rows = 0;
    bool seen[CANVAS_COLUMNS] = {false};
    (void)state;
    bend(2, 0);
    canvas_clear(&c, 80, 31);
    shape_views_draw(&shapes, &c, 0, 0, 80, 31);
    for (int i = 0; i < 30; i++) {
        bool any = false;
        for (int k = 0; k < 80; k++) {
            any = any || c.cells[i][k].dots;
            seen[k] = seen[k] || c.cells[i][k].dots;
        }
        rows += any;
    }
    for (int k = 0; k < 80; k++) {
        columns += seen[k];
    }
    assert_true(rows > 20);
    assert_in_range(columns * CANVAS_ACROSS, (rows - 2) * CANVAS_DOWN, (rows + 2) * CANVAS_DOWN);
}

static void shapes_that_are_none(void **state)
{
    (void)state;
    for (int kind = 0; kind < 3; kind++) {
        bend(2, 0);
        shapes.count = kind == 0 ? 0 : SHAPE_VIEWS_SHAPES;
        for (int i = 0; i < SHAPE_VIEWS_POINTS; i++) {
            shapes.places[0][i][2] = kind == 1 ? NAN : 1e300;
        }
        for (int columns = 0; columns < 60; columns += 7) {
            for (int rows = 0; rows < 20; rows += 3) {
                canvas_clear(&c, columns, rows);
                shape_views_draw(&shapes, &c, 0, 0, columns, rows);
                shapes.beam = !shapes.beam;
            }
        }
    }
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(a_line_gives_these_dots),
        cmocka_unit_test(a_line_stays_in_its_view),
        cmocka_unit_test(text_and_colours),
        cmocka_unit_test(names_with_other_bytes),
        cmocka_unit_test(every_cell_of_another_colour),
        cmocka_unit_test(a_chart_has_its_numbers),
        cmocka_unit_test(charts_of_nothing_and_without_room),
        cmocka_unit_test(one_view_of_a_plane),
        cmocka_unit_test(a_quarter_of_a_circle),
        cmocka_unit_test(shapes_that_are_none),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
