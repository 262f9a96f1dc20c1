/* cpinn-show: shapes as pictures, by gnuplot: .svg and .png of some instants, .gif of all. */
#include "tools/files/file_bytes.h"
#include "tools/judge/gnuplot.h"
#include "tools/programs/show_source.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

enum { STILL_FRAMES = 25, GIF_FRAMES = 120 };

typedef struct plot {
    const table_source *table;
    table_shapes at;
    size_t frames; /* drawn, */
    size_t last;   /* and the number of the last there is */
    double low[3], high[3];
    int axes[3]; /* those along which it moves first */
    bool flat;   /* it moves along the first two alone */
} plot;

static size_t frame_of(const plot *x, size_t drawn)
{
    return x->frames > 1 ? drawn * x->last / (x->frames - 1) : 0;
}

/* The box around all shapes, and the axes from the longest side to the shortest. */
static void measure(plot *x)
{
    double size = 0;
    for (int k = 0; k < 3; k++) {
        x->low[k] = INFINITY;
        x->high[k] = -INFINITY;
        for (size_t i = 0; i < x->table->nrows; i++) {
            x->low[k] = fmin(x->low[k], x->at.place[k][i]);
            x->high[k] = fmax(x->high[k], x->at.place[k][i]);
        }
        size = fmax(size, x->high[k] - x->low[k]);
    }
    int thin = 1; /* of equal ones y, so that x lies and z stands */
    for (int k = 0; k < 3; k += 2) {
        thin = x->high[k] - x->low[k] < x->high[thin] - x->low[thin] ? k : thin;
    }
    x->axes[0] = thin == 0;
    x->axes[1] = thin == 2 ? 1 : 2;
    x->axes[2] = thin;
    x->flat = x->high[thin] - x->low[thin] < 1e-6 * size;
}

/* A block of lines for each frame: place in mm, time. */
static ad_status print_data(FILE *file, const void *context, ad_error *error)
{
    const plot *x = context;
    (void)error;
    fprintf(file, "$rod << END\n");
    for (size_t k = 0; k < x->frames; k++) {
        const size_t first = frame_of(x, k) * x->at.points;
        for (size_t i = first; i < first + x->at.points; i++) {
            for (int d = 0; d < 3; d++) {
                const int axis = x->flat ? x->axes[d] : d;
                fprintf(file, "%.6g ", 1e3 * x->at.place[axis][i]);
            }
            fprintf(file, "%.6g\n", x->at.t ? x->at.t[i] : (double)frame_of(x, k) + 1);
        }
        fprintf(file, "\n\n");
    }
    fprintf(file, "END\n");
    return AD_OK;
}

static void print_axes(FILE *file, const plot *x)
{
    static const char *const commands[] = {"x", "y", "z"};
    for (int d = 0; d < (x->flat ? 2 : 3); d++) {
        const int axis = x->flat ? x->axes[d] : d;
        double room = 0.05 * (x->high[x->axes[0]] - x->low[x->axes[0]]);
        room += 0.05 * (x->high[axis] - x->low[axis]) + 1e-6;
        fprintf(file, "set %slabel '%c (mm)'\nset %srange [%.6g:%.6g]\n", commands[d], "xyz"[axis],
                commands[d], 1e3 * (x->low[axis] - room), 1e3 * (x->high[axis] + room));
    }
    if (x->flat) {
        fprintf(file, "set size ratio -1\n");
    } else {
        const double wide = fmax(x->high[0] - x->low[0], x->high[1] - x->low[1]);
        const double size = 1e3 * fmax(wide, x->high[2] - x->low[2]);
        const double power = pow(10, floor(log10(size / 6))), digit = size / 6 / power;
        const double step = power * (digit < 2 ? 2 : digit < 5 ? 5 : 10);
        fprintf(file,
                "set view 65,40,%.3g\nset view equal xyz\nset xyplane relative 0\n"
                "set xtics %g\nset ytics %g\nset ztics %g\n",
                fmin(1.1, 1.6e3 * wide / size), step, step, step);
    }
    fprintf(file,
            "set cblabel '%s'\nset palette defined (0 '#440154', 0.25 '#3b528b', 0.5 '#21918c', "
            "0.75 '#5ec962', 1 '#fde725')\nunset key\n",
            x->at.t ? "t (s)" : "member");
}

static const char *curve(const plot *x)
{
    return x->flat ? "plot $rod using 1:2:4" : "splot $rod using 1:2:3:4";
}

static ad_status print_still(FILE *file, const void *context, ad_error *error)
{
    const plot *x = context;
    ad_status status = print_data(file, x, error);
    print_axes(file, x);
    fprintf(file, "%s with lines lw 2 %s\n", curve(x),
            x->frames > 1 ? "lc palette" : "lc rgb '#0072B2'");
    return status;
}

/* The shape of each frame before those that were, in grey, for eight seconds. */
static ad_status write_gif(const plot *x, const gnuplot_place *place, ad_error *error)
{
    char *text = NULL, path[4200];
    size_t size = 0;
    FILE *file = open_memstream(&text, &size);
    if (!file) {
        return ad_fail(error, AD_NO_MEMORY, "out of memory for a picture");
    }
    fprintf(file, "# In this folder: gnuplot %s.gp\n\n", place->name);
    ad_status status = print_data(file, x, error);
    fprintf(file, "set terminal gif animate delay %ld size 720,540\nset output ",
            lround(fmax(3, 800.0 / (double)x->frames)));
    snprintf(path, sizeof path, "%s.gif", place->name);
    gnuplot_quoted(file, path);
    fputc('\n', file);
    print_axes(file, x);
    fprintf(file,
            "set encoding utf8\ndo for [i=0:%zu] {\n%s index 0:i with lines lw 1 lc rgb '#CCCCCC', "
            "\\\n  $rod index i using %s with lines lw 4 lc rgb '#0072B2'\n}\nunset output\n",
            x->frames - 1, curve(x), x->flat ? "1:2" : "1:2:3");
    if (fclose(file) != 0 && status == AD_OK) {
        status = ad_fail(error, AD_NO_MEMORY, "out of memory for a picture");
    }
    snprintf(path, sizeof path, "%s/%s.gp", place->folder, place->name);
    status = status == AD_OK ? file_bytes_write(path, text, size, 1, error) : status;
    free(text);
    return status;
}

bool show_is_plot(const char *path)
{
    const char *dot = path ? strrchr(path, '.') : NULL;
    return dot &&
           (strcmp(dot, ".svg") == 0 || strcmp(dot, ".png") == 0 || strcmp(dot, ".gif") == 0);
}

ad_status show_plot(const table_source *table, const char *path, ad_error *error)
{
    plot x = {.table = table};
    gnuplot_place place;
    const bool moves = strcmp(strrchr(path, '.'), ".gif") == 0;
    const size_t most = moves ? GIF_FRAMES : STILL_FRAMES;
    ad_status status = table_shapes_of(table, &x.at, error);
    if (status == AD_OK && !x.at.place[0]) {
        status = ad_fail(error, AD_BAD_INPUT, "there are no columns x, y, z to be drawn");
    }
    status = status == AD_OK ? gnuplot_beside(path, &place, error) : status;
    if (status != AD_OK) {
        return status;
    }
    x.last = x.at.frames - 1;
    x.frames = x.at.frames < most ? x.at.frames : most;
    measure(&x);
    const gnuplot_picture still = {.name = place.name,
                                   .about = "# Shapes of a rod, by cpinn-show.\n",
                                   .width = 720,
                                   .height = 540,
                                   .print = print_still,
                                   .context = &x};
    status = moves ? write_gif(&x, &place, error) : gnuplot_write(&still, place.folder, error);
    return status == AD_OK ? gnuplot_draw(place.name, place.folder, error) : status;
}
