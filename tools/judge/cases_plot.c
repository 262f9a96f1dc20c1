/* All cases in one picture, drawn by gnuplot from a script that holds its numbers. */
#include "tools/judge/cases.h"
#include "tools/judge/gnuplot.h"

#include <math.h>

/* Errors are drawn over logarithms; smaller ones are rounding. */
static const double SMALLEST = 1e-16;

static bool is_drawn(const cases_row *row)
{
    return !isnan(row->result.errors[JUDGE_POSITION]) && row->result.seconds > 0;
}

/* Cases are numbered in the order of their first rows. */
static int number_of(const cases_row *rows, size_t row)
{
    int number = 1;
    for (size_t i = 1; i <= row; i++) {
        number += rows[i].method <= rows[i - 1].method;
    }
    return number;
}

/* The larger of both, so that a rod that only twists has an error. */
static double error_of(const cases_row *row)
{
    return fmax(SMALLEST, fmax(row->result.errors[JUDGE_POSITION],
                               row->result.errors[JUDGE_ROTATION])); /* fmax leaves NaN out */
}

static void print_points(FILE *file, const cases_row *rows, size_t count, judge_method method)
{
    fprintf(file, "$%s << END\n", judge_method_name(method));
    for (size_t i = 0; i < count; i++) {
        if (rows[i].method == method && is_drawn(&rows[i])) {
            fprintf(file, "%.6g %.6g %d %s\n", rows[i].result.seconds, error_of(&rows[i]),
                    number_of(rows, i), rows[i].name);
        }
    }
    fprintf(file, "END\n");
}

/* From the network's point to the solver's. */
static void print_links(FILE *file, const cases_row *rows, size_t count)
{
    fprintf(file, "$links << END\n");
    for (size_t i = 1; i < count; i++) {
        const cases_row *from = &rows[i - 1], *to = &rows[i];
        if (number_of(rows, i) == number_of(rows, i - 1) && is_drawn(from) && is_drawn(to)) {
            fprintf(file, "%.6g %.6g\n%.6g %.6g\n\n", from->result.seconds, error_of(from),
                    to->result.seconds, error_of(to));
        }
    }
    fprintf(file, "END\n");
}

/* Numbers and names beside the picture, in columns of LINES. */
static void print_names(FILE *file, const cases_row *rows, size_t count)
{
    enum { LINES = 30 };
    for (size_t i = 0; i < count; i++) {
        int number = number_of(rows, i);
        if (i == 0 || number != number_of(rows, i - 1)) {
            fprintf(file,
                    "set label '%d' at screen %.3f,%.3f right font ',10'\n"
                    "set label '%s' at screen %.3f,%.3f left noenhanced font ',10'\n",
                    number, 0.665 + 0.18 * ((number - 1) / LINES),
                    0.90 - 0.027 * ((number - 1) % LINES), rows[i].name,
                    0.67 + 0.18 * ((number - 1) / LINES), 0.90 - 0.027 * ((number - 1) % LINES));
        }
    }
}

typedef struct table {
    const cases_row *rows;
    size_t count;
} table;

static ad_status print_picture(FILE *file, const void *context, ad_error *error)
{
    const cases_row *rows = ((const table *)context)->rows;
    size_t count = ((const table *)context)->count;
    (void)error;
    print_points(file, rows, count, JUDGE_NETWORK);
    print_points(file, rows, count, JUDGE_SOLVER);
    print_links(file, rows, count);
    fprintf(file, "set rmargin at screen 0.63\nset key at screen 0.66,0.97 left top "
                  "horizontal Left reverse samplen 1\n");
    print_names(file, rows, count);
    fprintf(file,
            "\nplot $links using 1:2 with lines lw 0.7 lc rgb '#BBBBBB' notitle, \\\n"
            "     $solver using 1:2 with points pt 5 ps 0.7 lc rgb '#D55E00' title 'solver', \\\n"
            "     $network using 1:2 with points pt 7 ps 0.8 lc rgb '#0072B2' title 'network', \\\n"
            "     $solver using 1:2:3 with labels font ',9' offset 0.9,0.4 notitle, \\\n"
            "     $network using 1:2:3 with labels font ',9' offset 0.9,0.4 notitle\n");
    return AD_OK;
}

ad_status cases_plot_write(const cases_row *rows, size_t count, const char *folder, ad_error *error)
{
    return gnuplot_write(
        &(const gnuplot_picture){.name = "cases",
                                 .about = "# Error against run time of all cases, by cpinn-cases.\n"
                                          "# Columns: seconds, error, number, name of the case.\n",
                                 .error = "error: position, relative L2, or rotation, rad",
                                 .width = 1100,
                                 .height = 640,
                                 .print = print_picture,
                                 .context = &(const table){rows, count}},
        folder, error);
}
