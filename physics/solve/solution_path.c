#include "physics/solve/solve.h"
#include "physics/solve/static_trace.h"

#include <math.h>
#include <stdlib.h>

void solution_path_free(solution_path *path)
{
    if (path) {
        free(path->points);
        free(path);
    }
}

/* The place that moves the furthest from where it is unstressed, and where to; in lengths. */
static void find_place(const static_trace *trace, int *place, double direction[3])
{
    double furthest = 0;
    *place = TRACE_PLACES - 1;
    for (int k = 0; k < 3; k++) {
        direction[k] = 0;
    }
    for (size_t i = 0; i < trace->count; i++) {
        for (int j = 0; j < TRACE_PLACES; j++) {
            const double *from = trace->points[0].position[j], *to = trace->points[i].position[j];
            double moved[3], square = 0;
            for (int k = 0; k < 3; k++) {
                moved[k] = to[k] - from[k];
                square += moved[k] * moved[k];
            }
            /* of places alike by symmetry, the first */
            if (sqrt(square) > furthest * (1 + 1e-9) + 1e-12) {
                furthest = sqrt(square);
                *place = j;
                for (int k = 0; k < 3; k++) {
                    direction[k] = moved[k] / furthest;
                }
            }
        }
    }
}

static solution_path *path_of(const static_trace *trace, double length)
{
    solution_path *path = calloc(1, sizeof *path);
    solution_path_point *points = calloc(trace->count, sizeof *points);
    int place;
    if (!path || !points) {
        free(path);
        free(points);
        return NULL;
    }
    *path = (solution_path){.count = trace->count,
                            .points = points,
                            .arrived = trace->arrived,
                            .estimate = trace->estimate};
    find_place(trace, &place, path->direction);
    for (int k = 0; k < 3; k++) { /* no rounding in what is printed */
        path->direction[k] = fabs(path->direction[k]) > 1e-12 ? path->direction[k] : 0;
    }
    path->place = length * place / (TRACE_PLACES - 1);
    for (size_t i = 0; i < trace->count; i++) {
        const trace_point *from = &trace->points[i];
        points[i] = (solution_path_point){.load = from->load,
                                          .arclength = from->arclength,
                                          .unstable_modes = from->unstable,
                                          .mark = from->mark};
        for (int k = 0; k < 3; k++) {
            double at = from->position[place][k], rest = trace->points[0].position[place][k];
            points[i].position[k] = length * at;
            points[i].deflection += length * (at - rest) * path->direction[k];
        }
    }
    return path;
}

/* NULL: settings that a path is followed by. */
static const char *refusal(const solve_settings *settings)
{
    return settings->method != SOLVE_COLLOCATION
               ? "its arc length is followed by collocation alone; allowed: the method collocation"
           : settings->perturbation != 0
               ? "a perturbation is given; allowed: a branch, which leaves at a bifurcation"
               : NULL;
}

ad_status solution_path_create(const scene *rod_scene, const solve_settings *settings,
                               solution_path **result, ad_error *error)
{
    solve_rod *rod = NULL;
    path_shape shape;
    static_trace *trace = NULL;
    static_solution *end = NULL;
    solve_report report = {.nodes = 0};
    const char *why = refusal(settings);
    *result = NULL;
    ad_status status = solve_check(rod_scene, settings, true, NULL, error);
    if (status == AD_OK && why) {
        status = ad_fail(error, AD_BAD_ARGUMENT, "path: %s", why);
    }
    status = status == AD_OK ? solve_rod_create(rod_scene, &rod, error) : status;
    if (status == AD_OK) {
        status = static_path_shape(rod, settings, &shape, error);
    }
    if (status == AD_OK) {
        status =
            static_trace_create(rod, settings, &shape, TRACE_WHOLE, &trace, &end, &report, error);
    }
    if (status == AD_OK && !trace) {
        status = ad_fail(error, AD_BAD_ARGUMENT,
                         "path: without its loads nothing holds the rod where it is, so that no "
                         "path begins there");
    }
    if (status == AD_OK) {
        *result = path_of(trace, scene_length(rod_scene));
        status = *result ? AD_OK : ad_fail(error, AD_NO_MEMORY, "out of memory for a path");
    }
    static_free(end);
    static_trace_free(trace);
    solve_rod_free(rod);
    return status;
}
