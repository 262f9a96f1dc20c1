/* Error over run time, in a picture for each scene. */
#include "tools/judge/compare.h"
#include "tools/judge/gnuplot.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

/* Okabe & Ito's palette, which colour-blind readers can tell apart, without its yellow, which is
 * too pale for a line: https://jfly.uni-koeln.de/color/. */
static const char *const colours[] = {"#0072B2", "#D55E00", "#009E73", "#CC79A7",
                                      "#E69F00", "#56B4E9", "#000000"};
/* Curves of others are grey; their points tell them apart. */
static const char *const greys[] = {"#333333", "#777777", "#999999"};
static const int points[] = {5, 7, 9, 11, 13, 4, 6, 8, 10, 12};

static const char *const dashes[] = {"solid", "(8,4)", "(2,3)", "(8,3,2,3)", "(16,4)"};

enum { COLOURS = sizeof colours / sizeof *colours, DASHES = sizeof dashes / sizeof *dashes };

/* ---- the script ---------------------------------------------------------------------------- */

/* What is drawn of a scene. */
typedef struct drawing {
    const compare_results *results;
    int first, end; /* its cells */
    bool many_methods, many_networks;
    const compare_curves *curves;
    double top; /* spreads without an upper end are drawn up to here */
} drawing;

static drawing drawing_of(const compare_results *results, int scene, const compare_curves *curves,
                          compare_band *band)
{
    drawing d = {.results = results, .curves = curves};
    while (d.first < results->cell_count && results->cells[d.first].scene != scene) {
        d.first++;
    }
    for (d.end = d.first; d.end < results->cell_count && results->cells[d.end].scene == scene;
         d.end++) {
        const compare_cell *cell = &results->cells[d.end];
        d.many_methods =
            d.many_methods || strcmp(cell->method, results->cells[d.first].method) != 0;
        d.many_networks =
            d.many_networks || strcmp(cell->network, results->cells[d.first].network) != 0;
        compare_band_of(results, d.end, band);
        for (size_t i = 0; i < band->count; i++) {
            const compare_spread *spread = &band->errors[i];
            d.top = fmax(d.top, isfinite(spread->high) ? spread->high : spread->median);
        }
    }
    return d;
}

static bool print_band(FILE *file, const drawing *d, int cell, compare_band *band)
{
    compare_band_of(d->results, cell, band);
    if (band->count == 0) {
        return false;
    }
    fprintf(file, "$band%d << END\n", cell - d->first);
    for (size_t i = 0; i < band->count; i++) {
        const compare_spread *spread = &band->errors[i];
        fprintf(file, "%.6g %.6g %.6g %.6g\n", band->seconds[i], spread->median, spread->low,
                isfinite(spread->high) ? spread->high : d->top);
    }
    fprintf(file, "END\n");
    return true;
}

static void print_curve(FILE *file, const compare_curve *curve, int index)
{
    fprintf(file, "$curve%d << END\n", index);
    for (size_t i = 0; i < curve->count; i++) {
        fprintf(file, "%.9g %.9g\n", curve->seconds[i], curve->errors[i]);
    }
    fprintf(file, "END\n");
}

static void print_heading(FILE *file, const drawing *d, const char *note)
{
    fprintf(file, "set title ");
    gnuplot_quoted(file, d->results->cells[d->first].scene_name);
    fprintf(file, " noenhanced font ',15' offset 0,%s\n", *note ? "1" : "0");
    if (*note) {
        fprintf(file, "set label 1 ");
        gnuplot_quoted(file, note);
        fprintf(file, " at graph 0.5,1 center offset 0,0.8 noenhanced font ',10' tc rgb "
                      "'#555555'\n");
    }
    fprintf(file, "set tmargin 4.5\n"
                  "set key outside right top Left reverse noenhanced samplen 2.6 spacing 1.35\n"
                  "set style fill transparent solid 0.16 noborder\n\n");
}

static void print_title(FILE *file, const drawing *d, const compare_cell *cell)
{
    char title[2 * COMPARE_NAME + 2];
    bool has_network = cell->parameters > 0; /* the solver has none */
    bool both = d->many_methods && d->many_networks && has_network;
    snprintf(title, sizeof title, "%s%s%s",
             d->many_methods || !d->many_networks ? cell->method : "", both ? ", " : "",
             d->many_networks && has_network ? cell->network : "");
    gnuplot_quoted(file, title);
}

static bool same(const drawing *d, bool methods, int a, int b)
{
    const compare_cell *cell = &d->results->cells[a], *y = &d->results->cells[b];
    return strcmp(methods ? cell->method : cell->network, methods ? y->method : y->network) == 0;
}

/* How many other methods, or networks, come before that of the cell. */
static int index_of(const drawing *d, bool methods, int cell)
{
    int index = 0;
    for (int i = d->first; !same(d, methods, i, cell); i++) {
        bool fresh = true;
        for (int k = d->first; k < i; k++) {
            fresh = fresh && !same(d, methods, k, i);
        }
        index += fresh;
    }
    return index;
}

/* Colours tell methods apart and dashes networks; with one method, colours tell networks apart. */
static const char *colour_of(const drawing *d, int cell)
{
    return colours[index_of(d, d->many_methods, cell) % COLOURS];
}

static const char *dash_of(const drawing *d, int cell)
{
    return dashes[d->many_methods ? index_of(d, false, cell) % DASHES : 0];
}

/* Spreads first, lines above them, so that no line is veiled. */
static void print_plot(FILE *file, const drawing *d, const bool *drawn)
{
    const char *separator = "plot ";
    for (int i = d->first; i < d->end; i++) {
        if (drawn[i - d->first]) {
            fprintf(file, "%s$band%d using 1:3:4 with filledcurves fc rgb '%s' notitle", separator,
                    i - d->first, colour_of(d, i));
            separator = ", \\\n     ";
        }
    }
    for (int i = d->first; i < d->end; i++) {
        if (drawn[i - d->first]) {
            fprintf(file, "%s$band%d using 1:2 with lines lw 2.2 dt %s lc rgb '%s' title ",
                    separator, i - d->first, dash_of(d, i), colour_of(d, i));
            print_title(file, d, &d->results->cells[i]);
            separator = ", \\\n     ";
        }
    }
    for (int i = 0; i < d->curves->count; i++) {
        fprintf(file,
                "%s$curve%d using 1:2 with linespoints lw 1.4 dt (6,4) pt %d ps 0.9 lc rgb '%s' "
                "title ",
                separator, i, points[i % (int)(sizeof points / sizeof *points)],
                greys[i % (int)(sizeof greys / sizeof *greys)]);
        gnuplot_quoted(file, d->curves->curves[i].name);
        separator = ", \\\n     ";
    }
    fputc('\n', file);
}

/* What a script is made of. */
typedef struct picture {
    const compare_results *results;
    int scene;
    const compare_curves *curves;
    const char *note;
} picture;

static ad_status print_picture(FILE *file, const void *context, ad_error *error)
{
    const picture *p = context;
    compare_band *band = malloc(sizeof *band);
    bool *drawn = calloc((size_t)p->results->cell_count + 1, sizeof *drawn);
    ad_status status =
        band && drawn ? AD_OK : ad_fail(error, AD_NO_MEMORY, "out of memory for a picture");
    if (status == AD_OK) {
        drawing d = drawing_of(p->results, p->scene, p->curves, band);
        for (int i = d.first; i < d.end; i++) {
            drawn[i - d.first] = print_band(file, &d, i, band);
        }
        for (int i = 0; i < p->curves->count; i++) {
            print_curve(file, &p->curves->curves[i], i);
        }
        print_heading(file, &d, p->note);
        print_plot(file, &d, drawn);
    }
    free(band);
    free(drawn);
    return status;
}

ad_status compare_plot_write(const compare_results *results, int scene,
                             const compare_curves *curves, const char *note, const char *folder,
                             ad_error *error)
{
    const picture what = {results, scene, curves, note};
    int cell = 0;
    while (results->cells[cell].scene != scene) {
        cell++;
    }
    return gnuplot_write(
        &(const gnuplot_picture){
            .name = results->cells[cell].scene_name,
            .about = "# Error against training time, by cpinn-bench.\n"
                     "# $band: seconds, median, smallest and largest over seeds; "
                     "$curve: seconds, error.\n",
            .error = results->measure == JUDGE_ROTATION ? "rotation error (rad)"
                                                        : judge_measure_text(results->measure),
            .width = 860,
            .height = 520,
            .print = print_picture,
            .context = &what},
        folder, error);
}
