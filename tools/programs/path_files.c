#include "tools/programs/path_files.h"

#include "tools/files/table_file.h"
#include "tools/programs/gnuplot.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

static const char *const mark_words[] = {
    [SOLUTION_PLAIN] = "path", [SOLUTION_LIMIT] = "limit", [SOLUTION_BIFURCATION] = "bifurcation"};

static ad_status write_table(const solution_path *solutions, const char *path, ad_error *error)
{
    enum { NUMBERS = 7 };
    static const struct {
        const char *name, *unit;
    } columns[NUMBERS] = {{"load_factor", ""}, {"arclength", ""}, {"deflection", "m"}, {"x", "m"},
                          {"y", "m"},          {"z", "m"},        {"unstable", ""}};
    double *values = malloc(NUMBERS * solutions->count * sizeof *values);
    const char **marks = malloc(solutions->count * sizeof *marks);
    ad_status status =
        values && marks ? AD_OK : ad_fail(error, AD_NO_MEMORY, "out of memory for %s", path);
    for (size_t i = 0; i < solutions->count && status == AD_OK; i++) {
        const solution_path_point *p = &solutions->points[i];
        double modes = p->unstable_modes < 0 ? NAN : p->unstable_modes;
        const double row[NUMBERS] = {p->load,        p->arclength,   p->deflection, p->position[0],
                                     p->position[1], p->position[2], modes};
        for (int c = 0; c < NUMBERS; c++) {
            values[(size_t)c * solutions->count + i] = row[c] + 0.0;
        }
        marks[i] = mark_words[p->mark];
    }
    if (status == AD_OK) {
        table_build to;
        table_begin(&to, solutions->count);
        for (int c = 0; c < NUMBERS; c++) {
            table_add(&to, columns[c].name, columns[c].unit, values + (size_t)c * solutions->count,
                      NULL);
        }
        table_add(&to, "mark", "", NULL, marks);
        status = table_write(path, &to.table, error);
    }
    free(values);
    free(marks);
    return status;
}

/* ---- the picture --------------------------------------------------------------------------- */

/* The parts of the path that are stable, are not, or were not asked; each stretch by itself. */
static void print_stretches(FILE *file, const solution_path *path, const char *name, int low,
                            int high)
{
    fprintf(file, "$%s << END\n", name);
    for (size_t i = 1; i < path->count; i++) {
        const solution_path_point *a = &path->points[i - 1], *b = &path->points[i];
        if (b->unstable_modes >= low && b->unstable_modes <= high) {
            fprintf(file, "%.9g %.9g\n%.9g %.9g\n\n", a->deflection, a->load, b->deflection,
                    b->load);
        }
    }
    fprintf(file, "NaN NaN\nEND\n"); /* gnuplot warns of what is empty */
}

static void print_marks(FILE *file, const solution_path *path, solution_mark mark)
{
    fprintf(file, "$%s << END\n", mark_words[mark]);
    for (size_t i = 0; i < path->count; i++) {
        if (path->points[i].mark == mark) {
            fprintf(file, "%.9g %.9g\n", path->points[i].deflection, path->points[i].load);
        }
    }
    fprintf(file, "NaN NaN\nEND\n");
}

static ad_status print_picture(FILE *file, const void *context, ad_error *error)
{
    const solution_path *path = context;
    (void)error;
    fprintf(file,
            "set xlabel 'deflection (m) at s = %.6g m, along (%.3g, %.3g, %.3g)'\n"
            "set ylabel 'load factor'\nset key outside top horizontal Left reverse\n\n",
            path->place, path->direction[0], path->direction[1], path->direction[2]);
    print_stretches(file, path, "stable", 0, 0);
    print_stretches(file, path, "unstable", 1, 1 << 20);
    print_stretches(file, path, "unknown", -1, -1);
    print_marks(file, path, SOLUTION_LIMIT);
    print_marks(file, path, SOLUTION_BIFURCATION);
    bool asked = true;
    for (size_t i = 0; i < path->count; i++) {
        asked = asked && path->points[i].unstable_modes >= 0;
    }
    fprintf(file,
            "\nplot $stable with lines lw 2 lc rgb '#0072B2' title 'stable', \\\n"
            "     $unstable with lines lw 1.5 dt 2 lc rgb '#D55E00' title 'unstable', \\\n"
            "     $unknown with lines lw 1.5 lc rgb '#666666' %s, \\\n"
            "     $limit with points pt 7 ps 0.9 lc rgb '#000000' title 'limit point', \\\n"
            "     $bifurcation with points pt 6 ps 1 lc rgb '#000000' title 'bifurcation'\n",
            asked ? "notitle" : "title 'not asked'");
    return AD_OK;
}

ad_status path_files_write(const solution_path *solutions, const char *path, ad_error *error)
{
    gnuplot_place parts;
    ad_status status = gnuplot_beside(path, &parts, error);
    status = status == AD_OK ? write_table(solutions, path, error) : status;
    return status == AD_OK
               ? gnuplot_write(&(const gnuplot_picture){.name = parts.name,
                                                        .about = "# Load against deflection, by "
                                                                 "cpinn-solve --path.\n",
                                                        .width = 720,
                                                        .height = 480,
                                                        .print = print_picture,
                                                        .context = solutions},
                               parts.folder, error)
               : status;
}

ad_status path_files_draw(const char *path, ad_error *error)
{
    gnuplot_place parts;
    ad_status status = gnuplot_beside(path, &parts, error);
    return status == AD_OK ? gnuplot_draw(parts.name, parts.folder, error) : status;
}

/* ---- as text ------------------------------------------------------------------------------- */

void path_files_print(const solution_path *path, FILE *file)
{
    static const char *const texts[] = {
        [SOLUTION_LIMIT] = "limit point", [SOLUTION_BIFURCATION] = "bifurcation"};
    fprintf(file, "path: %zu points, deflection at s = %.6g m along (%.4g, %.4g, %.4g)\n",
            path->count, path->place, path->direction[0], path->direction[1], path->direction[2]);
    for (size_t i = 0; i < path->count; i++) {
        const solution_path_point *p = &path->points[i];
        if (p->mark != SOLUTION_PLAIN) {
            fprintf(file, "  %-24s at %.12g of the load, deflection %.9g m\n", texts[p->mark],
                    p->load, p->deflection);
        }
    }
    if (!isnan(path->estimate)) {
        fprintf(file, "  %-24s %.3e of the load\n", "estimated error of these", path->estimate);
    }
}

static void print_loads(const solution_path *path, solution_mark mark, const char *name, json *to)
{
    json_open(to, name, '[');
    for (size_t i = 0; i < path->count; i++) {
        if (path->points[i].mark == mark) {
            json_number(to, NULL, path->points[i].load);
        }
    }
    json_close(to, ']');
}

void path_files_json(const solution_path *solutions, const char *path, json *to)
{
    if (!solutions) {
        json_null(to, "path");
        return;
    }
    json_open(to, "path", '{');
    json_text(to, "file", path);
    json_integer(to, "points", (int64_t)solutions->count);
    json_number(to, "place", solutions->place);
    json_open(to, "direction", '[');
    for (int k = 0; k < 3; k++) {
        json_number(to, NULL, solutions->direction[k]);
    }
    json_close(to, ']');
    print_loads(solutions, SOLUTION_LIMIT, "limit_points", to);
    print_loads(solutions, SOLUTION_BIFURCATION, "bifurcations", to);
    json_number(to, "estimated_error", solutions->estimate);
    json_close(to, '}');
}
