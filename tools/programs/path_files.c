#include "tools/programs/path_files.h"

#include "tools/files/table_file.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

static const char *const mark_words[] = {
    [SOLUTION_PLAIN] = "path", [SOLUTION_LIMIT] = "limit", [SOLUTION_BIFURCATION] = "bifurcation"};

ad_status path_files_write(const solution_path *solutions, const char *path, ad_error *error)
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
