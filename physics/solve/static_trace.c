#include "physics/solve/static_trace.h"

#include "physics/solve/stability.h"
#include "physics/solve/static_internal.h"
#include "physics/solve/static_walk.h"

#include <math.h>
#include <stdlib.h>

enum { MESHES = 4 }; /* each twice as fine as the one before */

/* Loads of marks on two meshes that agree as well are taken for exact. */
static const double AGREED = 1e-10;

void static_trace_free(static_trace *trace)
{
    if (trace) {
        free(trace->points);
        free(trace);
    }
}

enum { SAMPLED = sizeof(solve_state) / sizeof(double) * STABILITY_POINTS };

/* values [columns][STABILITY_POINTS] of the scene as it was given, in SI units. */
static ad_status sample(const static_solution *solution, scene *given, double *values,
                        ad_error *error)
{
    enum { N = STABILITY_POINTS };
    double s[N], units[SAMPLED / N];
    solve_state states[N];
    *given = solution->rod->scene;
    int columns = solution_columns(given);
    given->motion = solution->rod->motion;
    ad_status status = stability_points(given, s, error);
    for (int i = 0; i < N && status == AD_OK; i++) {
        s[i] /= solution->rod->scales.length;
    }
    status = status == AD_OK ? static_at(solution, N, s, states, error) : status;
    if (status != AD_OK) {
        return status;
    }
    solve_rod_units(solution->rod, units);
    for (int c = 0; c < columns; c++) {
        for (int i = 0; i < N; i++) {
            values[c * N + i] = ((const double *)&states[i])[c] * units[c];
        }
    }
    return AD_OK;
}

static ad_status count_modes(const static_solution *solution, bool in_space, int *count,
                             ad_error *error)
{
    double values[SAMPLED];
    scene given;
    *count = -1;
    ad_status status = sample(solution, &given, values, error);
    given.motion = in_space ? SCENE_SPATIAL : given.motion;
    return status == AD_OK
               ? stability_count_with(&given, solution->system->path.load, 1, values, count, error)
               : status;
}

ad_status static_unstable(const static_solution *solution, int *count, ad_error *error)
{
    return count_modes(solution, false, count, error);
}

ad_status static_unstable_in_space(const static_solution *solution, int *count, ad_error *error)
{
    int all = -1;
    const ad_status status =
        solution->rod->motion == SCENE_AUTOMATIC ? count_modes(solution, true, &all, error) : AD_OK;
    *count = all >= 0 ? all : *count;
    return status;
}

ad_status static_gives_way(const static_solution *solution, bool *lost, ad_error *error)
{
    double values[SAMPLED];
    scene given;
    stability found;
    *lost = false;
    ad_status status = sample(solution, &given, values, error);
    if (status == AD_OK && rod_plane_of(&given).is_planar) { /* no path leads out of it */
        given.motion = SCENE_PLANAR;
    }
    status = status == AD_OK ? stability_find(&given, values, &found, error) : status;
    *lost = status == AD_OK && stability_is_lost(&found) && !stability_flutters(&found);
    return status;
}

/* ---- meshes -------------------------------------------------------------------------------- */

/* Largest difference of the loads of marks; 1 where these are not the same, NaN without any. */
static double marks_apart(const static_trace *a, const static_trace *b)
{
    size_t i = 0, j = 0;
    double apart = NAN;
    while (true) {
        while (i < a->count && a->points[i].mark == SOLUTION_PLAIN) {
            i++;
        }
        while (j < b->count && b->points[j].mark == SOLUTION_PLAIN) {
            j++;
        }
        if (i == a->count || j == b->count) {
            return i == a->count && j == b->count && a->arrived == b->arrived ? apart : 1;
        }
        if (a->points[i].mark != b->points[j].mark) {
            return 1;
        }
        apart = fmax(apart, fabs(a->points[i++].load - b->points[j++].load));
    }
}

static bool has_marks(const static_trace *trace)
{
    for (size_t i = 0; i < trace->count; i++) {
        if (trace->points[i].mark != SOLUTION_PLAIN) {
            return true;
        }
    }
    return false;
}

/* Every element in two. */
static ad_status halve(const static_solution *coarse, static_solution **fine, ad_error *error)
{
    double *edges;
    int elements = static_halve(coarse, INFINITY, &edges);
    int stages = coarse->system->mesh.stages;
    ad_status status = edges ? static_create(coarse->rod, stages, elements, edges, fine, error)
                             : ad_fail(error, AD_NO_MEMORY, "out of memory for a mesh");
    free(edges);
    return status;
}

/* Anew on a mesh twice as fine, in place of *mesh and *trace. */
static ad_status walk_finer(static_solution **mesh, const solve_settings *settings,
                            const path_shape *path, trace_goal goal, static_trace **trace,
                            long *steps, ad_error *error)
{
    static_solution *fine = NULL;
    static_trace *better = NULL;
    ad_status status = halve(*mesh, &fine, error);
    if (status == AD_OK) {
        status = static_walk(fine, settings, path, goal, &better, steps, error);
    }
    if (status == AD_OK && better) {
        better->estimate = marks_apart(*trace, better);
        static_trace_free(*trace);
        static_free(*mesh);
        *trace = better;
        *mesh = fine;
    } else {
        static_free(fine);
    }
    return status;
}

ad_status static_trace_create(const solve_rod *rod, const solve_settings *settings,
                              const path_shape *path, trace_goal goal, static_trace **result,
                              static_solution **end, solve_report *report, ad_error *error)
{
    static_solution *mesh = NULL;
    static_trace *trace = NULL;
    *result = NULL;
    *end = NULL;
    if (!static_path_is_true(path)) {
        return AD_OK;
    }
    ad_status status = static_begin(rod, settings, path, &mesh, report, error);
    if (status == AD_OK) {
        status = static_walk(mesh, settings, path, goal, &trace, &report->newton_steps, error);
    }
    if (trace) {
        trace->estimate = has_marks(trace) ? 1 : NAN;
    }
    for (int i = 1;
         status == AD_OK && trace && i < MESHES && settings->nodes == 0 && trace->estimate > AGREED;
         i++) {
        status = walk_finer(&mesh, settings, path, goal, &trace, &report->newton_steps, error);
    }
    if (status != AD_OK || !trace || !trace->arrived) {
        static_free(mesh);
        mesh = NULL;
    }
    if (status != AD_OK) {
        static_trace_free(trace);
        trace = NULL;
    }
    *result = trace;
    *end = mesh;
    return status;
}

void static_trace_report(const static_trace *trace, solve_report *report)
{
    report->limit_load = report->bifurcation_load = NAN;
    report->path_estimate = trace->estimate;
    for (size_t i = trace->count; i-- > 0;) {
        const trace_point *point = &trace->points[i];
        if (point->mark == SOLUTION_LIMIT) {
            report->limit_load = point->load;
        } else if (point->mark == SOLUTION_BIFURCATION) {
            report->bifurcation_load = point->load;
        }
    }
    report->snapped = trace->arrived && !isnan(report->limit_load);
}
