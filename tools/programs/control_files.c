#include "tools/programs/control_run.h"

#include "tools/control/task.h"
#include "tools/files/file_bytes.h"
#include "tools/judge/gnuplot.h"
#include "tools/programs/section_size.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

static ad_status write_table(const control_row *row, const char *path, ad_error *error)
{
    const control_loop *loop = row->loop;
    table_build to;
    table_begin(&to, (size_t)row->report.done);
    for (int i = 0; i < loop_columns(loop); i++) {
        table_add(&to, loop_column_name(loop, i), NULL, loop_column(loop, i), NULL);
    }
    return table_write(path, &to.table, error);
}

ad_status control_write_shapes(const control_row *row, const scene *plant, const char *path,
                               ad_error *error)
{
    return section_write(path, loop_shapes(row->loop), plant, true, error);
}

/* ---- the picture --------------------------------------------------------------------------- */

/* Columns of the record: t, then three times x, y, z, then inputs, then estimates in pairs. */
enum { REFERENCE = 1, TRUE_PLACE = 4, INPUTS = 10 };

static int inputs_of(const control_row *row)
{
    int count = 0;
    while (strncmp(loop_column_name(row->loop, INPUTS + count), "input_", 6) == 0) {
        count++;
    }
    return count;
}

/* The plane that is drawn: that of the task, or of two axes along which the path is longest. */
static void plane_of(const control_row *row, double across[2][3], double origin[3])
{
    const control_task *task = loop_task(row->loop);
    const bool lies = task->path == CONTROL_CIRCLE || task->path == CONTROL_EIGHT;
    double extent[3];
    int least = 0;
    memset(origin, 0, 3 * sizeof *origin);
    if (lies) {
        memcpy(origin, task->centre, 3 * sizeof *origin);
        task_plane(task->normal, across);
        return;
    }
    for (int k = 0; k < 3; k++) {
        const double *x = loop_column(row->loop, REFERENCE + k);
        double low = x[0], high = x[0];
        for (long i = 0; i < row->report.done; i++) {
            low = fmin(low, x[i]);
            high = fmax(high, x[i]);
        }
        extent[k] = high - low;
        least = extent[k] < extent[least] ? k : least;
    }
    memset(across, 0, 6 * sizeof **across);
    across[0][least == 0] = across[1][least == 2 ? 1 : 2] = 1;
}

/* A block of data: t, reference and place in the plane (mm), error (mm), inputs, estimates. */
static ad_status print_data(FILE *file, const void *context, ad_error *error)
{
    const control_row *row = context;
    const control_loop *loop = row->loop;
    const int inputs = inputs_of(row), estimates = row->control.estimate_count;
    double across[2][3], origin[3];
    (void)error;
    plane_of(row, across, origin);
    fprintf(file, "$loop << END\n");
    for (long i = 0; i < row->report.done; i++) {
        double off = 0;
        fprintf(file, "%.6g", loop_column(loop, 0)[i]);
        for (int which = 0; which < 4; which++) {
            double at = 0;
            for (int k = 0; k < 3; k++) {
                const int from = which < 2 ? REFERENCE : TRUE_PLACE;
                at += across[which % 2][k] * (loop_column(loop, from + k)[i] - origin[k]);
            }
            fprintf(file, " %.6g", 1e3 * at);
        }
        for (int k = 0; k < 3; k++) {
            off +=
                pow(loop_column(loop, TRUE_PLACE + k)[i] - loop_column(loop, REFERENCE + k)[i], 2);
        }
        fprintf(file, " %.6g", 1e3 * sqrt(off));
        for (int k = 0; k < inputs + 2 * estimates; k++) {
            fprintf(file, " %.6g", loop_column(loop, INPUTS + k)[i]);
        }
        fputc('\n', file);
    }
    fprintf(file, "END\n");
    return AD_OK;
}

static void print_curves(FILE *file, const control_row *row, int from, int count, int by,
                         bool with_deviation)
{
    static const char *const colours[] = {"#0072B2", "#D55E00", "#009E73", "#CC79A7", "#E69F00"};
    for (int k = 0; k < count; k++) {
        const int column = 7 + from + by * k;
        const char *colour = colours[k % 5],
                   *name = loop_column_name(row->loop, INPUTS + from + by * k);
        fprintf(file, k == 0 ? "plot " : ", \\\n     ");
        if (with_deviation) {
            fprintf(file,
                    "$loop using 1:($%d-2*$%d):($%d+2*$%d) with filledcurves fs transparent solid "
                    "0.2 lc rgb '%s' notitle, \\\n     ",
                    column, column + 1, column, column + 1, colour);
        }
        fprintf(file, "$loop using 1:%d with lines lw 1.5 lc rgb '%s' title ", column, colour);
        gnuplot_quoted(file, strchr(name, '_') + 1);
        fprintf(file, " noenhanced");
    }
    fputc('\n', file);
}

static void print_panels(FILE *file, const void *context)
{
    const control_row *row = context;
    const int inputs = inputs_of(row), estimates = row->control.estimate_count;
    fprintf(file,
            "set multiplot layout %d,2\nset key outside top center horizontal\nset xlabel "
            "'mm'\nset ylabel 'mm'\n"
            "set size ratio -1\n"
            "plot $loop using 2:3 with lines lw 3 lc rgb '#BBBBBB' title 'wanted', \\\n"
            "     $loop using 4:5 with lines lw 1.2 lc rgb '#0072B2' title 'true'\n"
            "set size noratio\nset xlabel 't (s)'\nset ylabel 'error (mm)'\nset logscale y\n"
            "plot $loop using 1:($6 > 0 ? $6 : NaN) with lines lw 1.2 lc rgb '#0072B2' notitle\n"
            "unset logscale y\nset ylabel 'inputs'\n",
            2);
    print_curves(file, row, 0, inputs, 1, false);
    fprintf(file, "set ylabel 'estimates'\n");
    if (estimates > 0) {
        print_curves(file, row, inputs, estimates, 2, true);
    }
    fprintf(file, "unset multiplot\n");
}

/* The path as it is drawn, a frame every twentieth of a second. */
static ad_status write_moving(const control_row *row, const gnuplot_place *place, ad_error *error)
{
    char *text = NULL, path[4200];
    size_t size = 0;
    const long every = lround(fmax(1, 0.05 / row->control.period));
    FILE *file = open_memstream(&text, &size);
    if (!file) {
        return ad_fail(error, AD_NO_MEMORY, "out of memory for a picture");
    }
    fprintf(file, "# In this folder: gnuplot %s_moving.gp\n\n", place->name);
    ad_status status = print_data(file, row, error);
    fprintf(file, "set terminal gif animate delay 5 size 480,480\nset output ");
    snprintf(path, sizeof path, "%s.gif", place->name);
    gnuplot_quoted(file, path);
    fprintf(
        file,
        "\nset size ratio -1\nset xlabel 'mm'\nset ylabel 'mm'\nset key top right\n"
        "stats $loop using 2 nooutput name 'X'\nstats $loop using 3 nooutput name 'Y'\n"
        "set xrange [X_min-5:X_max+5]\nset yrange [Y_min-5:Y_max+5]\n"
        "do for [i=0:%ld:%ld] {\n"
        "plot $loop using 2:3 with lines lw 3 lc rgb '#BBBBBB' title 'wanted', \\\n"
        "     $loop every ::0::i using 4:5 with lines lw 1.5 lc rgb '#0072B2' title 'true', \\\n"
        "     $loop every ::i::i using 4:5 with points pt 7 ps 1.5 lc rgb '#0072B2' notitle\n"
        "}\nunset output\n",
        row->report.done - 1, every);
    if (fclose(file) != 0 && status == AD_OK) {
        status = ad_fail(error, AD_NO_MEMORY, "out of memory for a picture");
    }
    snprintf(path, sizeof path, "%s/%s_moving.gp", place->folder, place->name);
    status = status == AD_OK ? file_bytes_write(path, text, size, error) : status;
    free(text);
    return status;
}

ad_status control_write(const control_row *row, const scene *plant, const char *path, bool moves,
                        ad_error *error)
{
    gnuplot_place place;
    char shapes[4200];
    ad_status status = gnuplot_beside(path, &place, error);
    status = status == AD_OK ? write_table(row, path, error) : status;
    if (status == AD_OK) {
        snprintf(shapes, sizeof shapes, "%s/%s_shapes.h5", place.folder, place.name);
        status = control_write_shapes(row, plant, shapes, error);
    }
    const gnuplot_picture picture = {.name = place.name,
                                     .about = "# A closed loop, by cpinn-control --out.\n",
                                     .width = 900,
                                     .height = 720,
                                     .print = print_data,
                                     .panels = print_panels,
                                     .context = row};
    status = status == AD_OK ? gnuplot_write(&picture, place.folder, error) : status;
    return status == AD_OK && moves ? write_moving(row, &place, error) : status;
}

ad_status control_draw(const char *path, bool moves, ad_error *error)
{
    gnuplot_place place;
    ad_status status = gnuplot_beside(path, &place, error);
    status = status == AD_OK ? gnuplot_draw(place.name, place.folder, error) : status;
    if (status == AD_OK && moves) {
        memcpy(place.name + strlen(place.name), "_moving", 8); /* gnuplot_beside leaves 9 bytes */
        status = gnuplot_draw(place.name, place.folder, error);
    }
    return status;
}
