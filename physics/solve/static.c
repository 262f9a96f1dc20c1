#include "physics/solve/static.h"

#include "physics/local/mesh.h"
#include "physics/numerics/quaternion.h"
#include "physics/solve/static_defect.h"
#include "physics/solve/static_energy.h"
#include "physics/solve/static_friction.h"
#include "physics/solve/static_internal.h"
#include "physics/solve/static_trace.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

enum {
    STAGES = 10,        /* of an element, when the tolerance decides about nodes */
    ELEMENTS_MAX = 600, /* some 300 MB */
    FEW = 64,           /* wavenumber of a rod whose path is quickly followed */
    SAMPLES = 33        /* of a shape, to tell two equilibria apart */
};

/* Positions, in lengths, that are so far apart belong to different equilibria: coarse meshes are
 * better than that. */
static const double ELSEWHERE = 1e-3;

/* Below this a difference that finer meshes do not halve is rounding. */
static const double ROUNDING = 1e-10;

/* ---- meshes -------------------------------------------------------------------------------- */

void static_free(static_solution *solution)
{
    if (solution) {
        static_newton_free(solution->newton);
        static_system_free(solution->system);
        free(solution->y);
        free(solution);
    }
}

ad_status static_create(const solve_rod *rod, int stages, int elements, const double *edges,
                        static_solution **result, ad_error *error)
{
    static_solution *solution = calloc(1, sizeof *solution);
    *result = solution;
    if (!solution) {
        return ad_fail(error, AD_NO_MEMORY, "out of memory");
    }
    solution->rod = rod;
    ad_status status = static_system_create(rod, stages, elements, edges, &solution->system, error);
    if (status == AD_OK) {
        status = static_newton_create(solution->system, &solution->newton, error);
    }
    if (status == AD_OK) {
        solution->y = malloc(elements_unknowns(&solution->system->mesh) * sizeof *solution->y);
        status = solution->y ? AD_OK : ad_fail(error, AD_NO_MEMORY, "out of memory");
    }
    if (status != AD_OK) {
        static_free(solution);
        *result = NULL;
    }
    return status;
}

static size_t rows_of(const static_solution *solution)
{
    return (size_t)solution->system->mesh.rows;
}

/* y at s, by the polynomial of its element; where something acts, before that. */
static void interpolate(const static_solution *solution, double s, double *y)
{
    const solve_elements *mesh = &solution->system->mesh;
    const int element = solve_elements_at(mesh, s);
    double values[(GAUSS_STAGES_MAX + 2) * STATIC_ROWS_MAX];
    static_system_values(solution->system, solution->y, element, values);
    solve_elements_interpolate(mesh, element, s, rows_of(solution), rows_of(solution), values, y);
}

/* The last Chebyshev coefficient over an element: of position and quaternion, and of force and
 * moment relative to the largest, `size`. */
static double last_term(const static_solution *solution, int element, double size)
{
    const gauss_rule *rule = &solution->system->mesh.rule;
    const int stages = rule->stages, rows = solution->system->mesh.rows;
    double y[(GAUSS_STAGES_MAX + 2) * STATIC_ROWS_MAX], result = 0;
    static_system_values(solution->system, solution->y, element, y);
    for (int k = 0; k < rows; k++) {
        double sum = 0; /* the divided difference of the points 0, c; that of 0, c, 1 is 0 */
        for (int i = 0; i <= stages; i++) {
            double point = i == 0 ? 0 : rule->nodes[i - 1];
            sum += rule->barycentric[i] * 2 * (point - 1) * y[i * rows + k];
        }
        result = fmax(result, fabs(sum) / (k < STATIC_N ? 1 : size));
    }
    return ldexp(result, 1 - stages);
}

int static_halve(const static_solution *solution, double threshold, double **edges)
{
    int elements = solution->system->mesh.count, count = 0, halved = 0;
    const double *from = solution->system->mesh.edges;
    double size = 1;
    double *to = malloc((2 * (size_t)elements + 1) * sizeof *to);
    *edges = to;
    for (size_t k = 0; k < elements_unknowns(&solution->system->mesh); k++) {
        size = fmax(size, fabs(solution->y[k]));
    }
    for (int e = 0; e < elements; e++) {
        halved += last_term(solution, e, size) > threshold;
    }
    for (int e = 0; e < elements && to; e++) {
        to[count++] = from[e];
        if (halved == 0 || last_term(solution, e, size) > threshold) {
            to[count++] = (from[e] + from[e + 1]) / 2;
        }
    }
    if (to) {
        to[count] = 1;
    }
    return count;
}

/* *fine with the solution of `coarse` as a guess, at *points, allocated. */
static ad_status refine(const static_solution *coarse, double threshold, static_solution **fine,
                        double **points, ad_error *error)
{
    double *edges;
    int elements = static_halve(coarse, threshold, &edges);
    int stages = coarse->system->mesh.stages;
    *fine = NULL;
    *points = NULL;
    ad_status status = edges ? static_create(coarse->rod, stages, elements, edges, fine, error)
                             : ad_fail(error, AD_NO_MEMORY, "out of memory");
    free(edges);
    if (status != AD_OK) {
        return status;
    }
    size_t count = elements_unknowns(&(*fine)->system->mesh) / rows_of(coarse);
    *points = malloc(count * sizeof **points);
    if (!*points) {
        return ad_fail(error, AD_NO_MEMORY, "out of memory");
    }
    solve_elements_places(&(*fine)->system->mesh, *points);
    memcpy((*fine)->system->tensions, coarse->system->tensions,
           SOLVE_ACTUATORS_MAX * sizeof(double));
    static_friction_refine(coarse->system, (*fine)->system);
    if (coarse->system->earlier) {
        status = static_friction_follow((*fine)->system, coarse->system->earlier, error);
    }
    for (size_t i = 0; i < count; i++) {
        interpolate(coarse, (*points)[i], (*fine)->y + i * rows_of(coarse));
    }
    return status;
}

/* Largest distance of the positions at the nodes of the finer one, and largest turn about the
 * tangent, rad, which positions do not show. */
static double difference(const static_solution *coarse, const static_solution *fine,
                         const double *points)
{
    size_t rows = rows_of(fine), count = elements_unknowns(&fine->system->mesh) / rows;
    double result = 0, y[STATIC_ROWS_MAX], off[3];
    for (size_t i = 0; i < count; i++) {
        interpolate(coarse, points[i], y);
        for (int k = 0; k < 3; k++) {
            off[k] = y[k] - fine->y[i * rows + (size_t)k];
        }
        double turn[4];
        quaternion_quotient(y + STATIC_Q, fine->y + i * rows + STATIC_Q, turn);
        result = fmax(result, fmax(sqrt(vector_dot(off, off)), 2 * fabs(turn[3])));
    }
    return result;
}

/* A finer solution in place of *x, and how far the two are apart. */
static ad_status improve(static_solution **x, const path_shape *path, double tolerance,
                         solve_report *report, ad_error *error)
{
    static_solution *fine;
    double *points;
    ad_status status = refine(*x, tolerance / 10, &fine, &points, error);
    if (status == AD_OK) {
        static_path end = static_path_at(path, path->last);
        static_system_set(fine->system, &end);
        bool solved = static_newton_solve(fine->newton, fine->y, &report->newton_steps);
        double off = solved ? difference(*x, fine, points) : INFINITY;
        if (off > PATH_OFF_MAX && !path->traced) { /* the coarse mesh was no guide */
            bool leaps;
            status = static_path_follow(fine->system, fine->newton, path, fine->y, &leaps, report,
                                        error);
            off = INFINITY;
        }
        report->estimate = off;
    }
    free(points);
    if (status == AD_OK) {
        static_free(*x);
        *x = fine;
    } else {
        static_free(fine);
    }
    return status;
}

/* The estimate is no smaller than what the solution leaves undone between its points. */
static ad_status look_between(const static_solution *solution, solve_report *report,
                              ad_error *error)
{
    double defect = INFINITY;
    if (report->load_fraction < 1) {
        return AD_OK;
    }
    ad_status status =
        static_defect(solution->system, solution->rod->quadrature, solution->y, &defect, error);
    report->estimate = fmax(report->estimate, defect); /* NaN: no other mesh yet */
    return status;
}

static int nodes_of(const static_solution *solution)
{
    return solution->system->mesh.count * solution->system->mesh.stages;
}

ad_status static_begin(const solve_rod *rod, const solve_settings *settings, const path_shape *path,
                       static_solution **result, solve_report *report, ad_error *error)
{
    int nodes = settings->nodes, stages = STAGES,
        elements = 1 + (int)fmin(path->wavenumber / 4, 63);
    const solve_quadrature *along = rod->quadrature;
    const solve_given given = solve_rod_given(rod);
    double edges[ELEMENTS_MAX + 1];
    bool fine = true;
    int most = along->unresolved ? ELEMENTS_MAX / 4 : ELEMENTS_MAX; /* what is lost is not sought */
    ad_status status = AD_OK;
    if (nodes > 0) {
        elements = (nodes + GAUSS_STAGES_MAX - 1) / GAUSS_STAGES_MAX;
        elements = elements < ELEMENTS_MAX / 2 ? elements : ELEMENTS_MAX / 2;
    }
    elements = solve_mesh_edges(elements, along->place_count, along->places, edges);
    if (nodes > 0) {
        stages = (nodes + elements - 1) / elements;
        stages = stages < GAUSS_STAGES_MAX ? stages : GAUSS_STAGES_MAX;
    } else {
        status = solve_quadrature_divide(along, &given, stages, settings->tolerance / 10, most,
                                         &elements, edges, &fine, error);
    }
    report->unresolved = along->unresolved ? along->unresolved : fine ? NULL : "rod";
    return status == AD_OK ? static_create(rod, stages, elements, edges, result, error) : status;
}

/* Whether an equilibrium under the full load is another one than that of the true path. */
static bool leads_elsewhere(const static_solution *solution, const static_solution *end)
{
    double y[STATIC_ROWS_MAX], other[STATIC_ROWS_MAX], off = 0;
    for (int i = 0; i < SAMPLES; i++) {
        double s = (double)i / (SAMPLES - 1);
        interpolate(solution, s, y);
        interpolate(end, s, other);
        for (int k = 0; k < 3; k++) {
            off = fmax(off, fabs(y[k] - other[k]));
        }
    }
    return off > ELSEWHERE;
}

/* By arc length, where the load alone does not lead on, or not to what is asked for: the solution
 * there takes the place of *x. */
static ad_status trace(static_solution **x, const solve_settings *settings, path_shape *path,
                       trace_goal goal, solve_report *report, ad_error *error)
{
    static_trace *way = NULL;
    static_solution *end = NULL;
    ad_status status = AD_OK;
    if ((*x)->rod->lengths + (*x)->rod->frictions == 0) { /* these tensions have no arc length */
        status = static_trace_create((*x)->rod, settings, path, goal, &way, &end, report, error);
    }
    if (status == AD_OK && way) {
        static_trace_report(way, report);
    } else if (status == AD_OK && settings->branch > 0) {
        status = ad_fail(error, AD_BAD_ARGUMENT,
                         "branch %d: this scene has no path from its unstressed shape to leave",
                         settings->branch);
    }
    const bool marked = !isnan(report->limit_load) || !isnan(report->bifurcation_load);
    bool better = end && (goal != TRACE_FIRST_MARK || !marked);
    if (better && settings->branch == 0 && report->load_fraction == 1) {
        bool here = false, there = false;
        better = leads_elsewhere(*x, end);
        status = better ? static_gives_way(*x, &here, error) : status;
        status = better && status == AD_OK ? static_gives_way(end, &there, error) : status;
        better = better && (here || !there); /* never for one that is worse */
    }
    if (better && status == AD_OK) {
        static_free(*x);
        *x = end;
        end = NULL;
        path->traced = true;
        report->load_fraction = 1;
    }
    static_trace_free(way);
    static_free(end);
    return status;
}

/* Where a path that is not stable at its end has lost its stability, or the equilibrium to which it
 * truly leads: the load alone steps across the bend of an imperfect column. Of a rod that winds a
 * lot nobody waits for that. */
static ad_status find_loss(static_solution **x, const solve_settings *settings, path_shape *path,
                           solve_report *report, ad_error *error)
{
    bool lost;
    ad_status status = static_gives_way(*x, &lost, error);
    return status == AD_OK && lost && path->wavenumber < FEW
               ? trace(x, settings, path, TRACE_FIRST_MARK, report, error)
               : status;
}

/* On finer meshes until the estimate is within the tolerance. */
static ad_status converge(static_solution **x, const solve_settings *settings, path_shape *path,
                          solve_report *report, ad_error *error)
{
    bool done = settings->nodes > 0 || report->load_fraction < 1;
    double before = NAN; /* of two meshes */
    report->estimate = NAN;
    ad_status status = done ? AD_OK : look_between(*x, report, error);
    while (status == AD_OK && !done && 2 * (*x)->system->mesh.count <= ELEMENTS_MAX) {
        status = improve(x, path, settings->tolerance, report, error);
        status = status == AD_OK ? look_between(*x, report, error) : status;
        bool rounding = report->estimate < ROUNDING && report->estimate > before / 2;
        done = report->estimate <= settings->tolerance || rounding || report->load_fraction < 1;
        before = report->estimate;
    }
    return status;
}

ad_status static_solve(const solve_rod *rod, const solve_settings *settings,
                       const static_solution *before, static_solution **result,
                       solve_report *report, ad_error *error)
{
    path_shape path;
    static_solution *solution = NULL;
    bool leaps = false;
    *report = solve_report_blank();
    *result = NULL;
    ad_status status = static_path_shape(rod, settings, &path, error);
    if (status == AD_OK) {
        status = static_begin(rod, settings, &path, &solution, report, error);
    }
    if (status == AD_OK && before && rod->frictions > 0) {
        status = static_friction_follow(solution->system, before->system, error);
    }
    if (status == AD_OK && settings->branch > 0) {
        report->load_fraction = 0;
        static_system_set(solution->system, &(static_path){.load = 0});
        status = static_system_guess(solution->system, solution->y, error);
    } else if (status == AD_OK && settings->guess) {
        status = static_from_guess(solution, settings, &path, &path.traced, report, error);
    }
    if (status == AD_OK && settings->branch == 0 && !path.traced) {
        status = static_path_follow(solution->system, solution->newton, &path, solution->y, &leaps,
                                    report, error);
    }
    if (status == AD_OK && !path.traced &&
        (report->load_fraction < 1 || (leaps && path.turn == 0) || path.may_snap)) {
        trace_goal goal = settings->branch > 0 ? TRACE_WHOLE : TRACE_FULL_LOAD;
        status = trace(&solution, settings, &path, goal, report, error);
    }
    status = status == AD_OK ? converge(&solution, settings, &path, report, error) : status;
    if (status == AD_OK && report->load_fraction == 1 && isnan(report->bifurcation_load) &&
        !path.traced) {
        status = find_loss(&solution, settings, &path, report, error);
        if (status == AD_OK && path.traced) {
            status = converge(&solution, settings, &path, report, error);
        }
    }
    if (status != AD_OK) {
        static_free(solution);
        return status;
    }
    report->nodes = nodes_of(solution);
    report->may_buckle = path.may_buckle;
    *result = solution;
    return AD_OK;
}

/* ---- the solution at a point --------------------------------------------------------------- */

/* s within the element that y is taken from: what is given along the rod is that of this side of a
 * place where it jumps, also where rounding has moved s or the place. */
static double within(const static_solution *solution, double s)
{
    const double margin = 1e-14, *edge = solution->system->mesh.edges;
    const int e = solve_elements_at(&solution->system->mesh, s),
              last = solution->system->mesh.count - 1;
    s = e > 0 ? fmax(s, edge[e] + margin) : s;
    return e < last ? fmin(s, edge[e + 1] - margin) : s;
}

ad_status static_at(const static_solution *solution, size_t n, const double *s, solve_state *out,
                    ad_error *error)
{
    double *inside = calloc(n + 1, sizeof *inside);
    solve_rod_points given = {0};
    ad_status status =
        inside ? AD_OK : ad_fail(error, AD_NO_MEMORY, "out of memory for %zu points", n);
    for (size_t i = 0; i < n && status == AD_OK; i++) {
        inside[i] = within(solution, s[i]);
    }
    status =
        status == AD_OK ? solve_rod_points_make(solution->rod, n, inside, &given, error) : status;
    for (size_t i = 0; i < n && status == AD_OK; i++) {
        const static_point at = static_system_given(solution->system, &given, i, inside[i]);
        double y[STATIC_ROWS_MAX], square = 0;
        interpolate(solution, s[i], y);
        for (int k = 0; k < 4; k++) {
            square += y[STATIC_Q + k] * y[STATIC_Q + k];
        }
        for (int k = 0; k < 4; k++) {
            y[STATIC_Q + k] /= sqrt(square);
        }
        out[i] = (solve_state){.tubes = {0}};
        memcpy(out[i].position, y + STATIC_R, sizeof out[i].position);
        memcpy(out[i].rotation, y + STATIC_Q, sizeof out[i].rotation);
        memcpy(out[i].moment, y + STATIC_M, sizeof out[i].moment);
        memcpy(out[i].tubes, y + STATIC_TUBES, (rows_of(solution) - STATIC_TUBES) * sizeof *y);
        static_body_force(y, out[i].force);
        static_strains(&at, y, out[i].strain, out[i].curvature);
    }
    solve_rod_points_clear(&given);
    free(inside);
    return status;
}

ad_status static_energy(const static_solution *solution, solve_energy *energy, ad_error *error)
{
    return static_energy_of(solution->system, solution->y, energy, error);
}

double static_tension(const static_solution *solution, int tendon)
{
    return solution->system->tensions[tendon];
}

double static_tension_at(const static_solution *solution, int tendon, double s)
{
    return static_friction_tension(solution->system, tendon, s);
}
