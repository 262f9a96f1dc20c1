#include "physics/solve/beam_solver.h"

#include "physics/local/mesh.h"
#include "physics/solve/beam_motion.h"
#include "physics/solve/defect.h"

#include <math.h>
#include <stdlib.h>

/* Nodes: each mesh of a static beam has twice as many as the one before, of a motion half as many
 * again. The last two are elements of static beams: at the beginning, by halving. */
enum { COARSEST = 12, FINEST_MOVING = 90, ELEMENTS_MAX = 512, FINEST_ELEMENTS = 256 };
static const double ROUNDING = 1e-12; /* below which finer meshes need not be better */

/* A step of time, of a unit of time / nodes^2 where EI/rhoA is 1, as frequencies of bending grow
 * with the square of the wavenumber; half of it leaves the error as it is, that of the mesh. */
static const double STEP = 7;

struct beam_solution {
    const solve_beam *beam;
    beam_system *system;
    size_t count;   /* of times, 1 if static */
    double *fields; /* [count][2][places][BEAM_ROWS]: y, y_t */
};

void beam_free(beam_solution *solution)
{
    if (solution) {
        beam_system_free(solution->system);
        free(solution->fields);
        free(solution);
    }
}

static double *fields_of(const beam_solution *solution, size_t which, int order)
{
    return solution->fields +
           (2 * which + (size_t)order) * beam_system_places(solution->system) * BEAM_ROWS;
}

void beam_at(const beam_solution *solution, size_t which, size_t n, const double *s,
             beam_state *out)
{
    for (size_t i = 0; i < n; i++) {
        double y[BEAM_ROWS], rate[BEAM_ROWS];
        beam_system_at(solution->system, fields_of(solution, which, 0), s[i], y);
        beam_system_at(solution->system, fields_of(solution, which, 1), s[i], rate);
        out[i] = (beam_state){.deflection = y[BEAM_W],
                              .slope = y[BEAM_PSI],
                              .shear = y[BEAM_V],
                              .moment = y[BEAM_M],
                              .velocity = rate[BEAM_W],
                              .slope_rate = rate[BEAM_PSI]};
    }
}

/* ---- meshes ---------------------------------------------------------------------------------- */

typedef struct beam_mesh {
    int nodes; /* as asked for */
    int stages, elements;
    double edges[ELEMENTS_MAX + 1];
} beam_mesh;

/* As many nodes as asked for or a few more: elements of as many points as may be, with edges where
 * something jumps. */
static void place(beam_mesh *mesh, const solve_beam *beam, int nodes)
{
    int least = (nodes + GAUSS_STAGES_MAX - 1) / GAUSS_STAGES_MAX;
    mesh->nodes = nodes;
    least = least < ELEMENTS_MAX / 2 ? least : ELEMENTS_MAX / 2;
    mesh->elements = solve_mesh_edges(least, beam->quadrature->place_count,
                                      beam->quadrature->places, mesh->edges);
    mesh->stages = (nodes + mesh->elements - 1) / mesh->elements;
    mesh->stages = mesh->stages < GAUSS_STAGES_MAX ? mesh->stages : GAUSS_STAGES_MAX;
}

/* At rest, for all that is given along the beam. */
static ad_status begin(beam_mesh *mesh, const solve_beam *beam, double tolerance,
                       solve_report *report, ad_error *error)
{
    const solve_given given = solve_beam_given(beam);
    bool fine = true;
    mesh->stages = GAUSS_STAGES_MAX;
    ad_status status =
        solve_quadrature_divide(beam->quadrature, &given, mesh->stages, tolerance / 10,
                                ELEMENTS_MAX, &mesh->elements, mesh->edges, &fine, error);
    mesh->nodes = mesh->elements * mesh->stages;
    report->unresolved = report->unresolved ? report->unresolved : fine ? NULL : "beam";
    return status;
}

/* False: there would be too many. */
static bool halve(beam_mesh *mesh)
{
    if (2 * mesh->elements > FINEST_ELEMENTS) {
        return false;
    }
    for (int e = mesh->elements; e > 0; e--) {
        mesh->edges[2 * e] = mesh->edges[e];
    }
    mesh->elements *= 2;
    mesh->nodes *= 2;
    for (int e = 0; e < mesh->elements; e += 2) {
        mesh->edges[e + 1] = (mesh->edges[e] + mesh->edges[e + 2]) / 2;
    }
    return true;
}

/* ---- one mesh -------------------------------------------------------------------------------- */

static ad_status solve_static(beam_solution *solution, ad_error *error)
{
    size_t nodes = beam_system_nodes(solution->system);
    double ends[4];
    beam_load jump_loads[BEAM_JUMPS_MAX];
    beam_load *loads = malloc(nodes * sizeof *loads);
    ad_status status = loads ? solve_beam_load(solution->beam, nodes, solution->system->mesh.points,
                                               0, loads, error)
                             : ad_fail(error, AD_NO_MEMORY, "out of memory for %zu nodes", nodes);
    status = status == AD_OK ? solve_beam_ends(solution->beam, 0, ends, error) : status;
    status = status == AD_OK ? solve_beam_jump_loads(solution->beam, 0, jump_loads, error) : status;
    if (status == AD_OK) {
        beam_system_solve(solution->system, loads, jump_loads, ends, solution->fields);
    }
    free(loads);
    return status;
}

/* By how much waves are faster, where they are fastest, than those of the scales. */
static double speed(const beam_system *system)
{
    const beam_section *sections = system->sections;
    double square = 0;
    for (size_t i = 0; i < beam_system_nodes(system); i++) {
        square = fmax(square, 1 / (sections[i].bending_compliance * sections[i].mass));
    }
    return sqrt(square);
}

static ad_status solve_on(beam_solution *solution, const beam_mesh *mesh, const double *times,
                          solve_report *report, ad_error *error)
{
    double stiffening = solution->beam->dynamic ? BEAM_MOTION_STIFFENING : 0;
    ad_status status = beam_system_create(solution->beam, mesh->stages, mesh->elements, mesh->edges,
                                          stiffening, &solution->system, error);
    if (status != AD_OK) {
        return status;
    }
    size_t numbers = 2 * solution->count * beam_system_places(solution->system) * BEAM_ROWS;
    solution->fields = calloc(numbers, sizeof *solution->fields);
    report->nodes = (int)beam_system_nodes(solution->system);
    if (!solution->fields) {
        return ad_fail(error, AD_NO_MEMORY, "out of memory for %zu times", solution->count);
    }
    if (solution->beam->dynamic) {
        double nodes = mesh->nodes;
        long steps =
            (long)ceil(solution->beam->duration * nodes * nodes * speed(solution->system) / STEP);
        status = beam_motion_solve(solution->beam, solution->system, &steps, solution->count, times,
                                   solution->fields, error);
        report->time_steps += steps;
    } else {
        status = solve_static(solution, error);
    }
    for (size_t i = 0; status == AD_OK && i < numbers; i++) {
        if (!isfinite(solution->fields[i])) {
            status = ad_fail(error, AD_NOT_FINITE,
                             "the deflection is not finite; loads, foundation and initial state "
                             "have to be");
        }
    }
    return status;
}

static ad_status solve_once(const solve_beam *beam, const beam_mesh *mesh, size_t count,
                            const double *times, beam_solution **result, solve_report *report,
                            ad_error *error)
{
    *result = NULL;
    beam_solution *solution = calloc(1, sizeof *solution);
    if (!solution) {
        return ad_fail(error, AD_NO_MEMORY, "out of memory for a beam");
    }
    solution->beam = beam;
    solution->count = count;
    ad_status status = solve_on(solution, mesh, times, report, error);
    if (status != AD_OK) {
        beam_free(solution);
        return status;
    }
    *result = solution;
    return AD_OK;
}

/* ---- refining -------------------------------------------------------------------------------- */

double beam_largest(const beam_solution *solution)
{
    size_t places = beam_system_places(solution->system);
    double largest = 0;
    for (size_t i = 0; i < 2 * solution->count * places; i++) {
        bool is_rate = i / places % 2 == 1;
        largest = fmax(largest, is_rate ? 0 : fabs(solution->fields[i * BEAM_ROWS + BEAM_W]));
    }
    return largest;
}

/* Largest difference of the deflection at the nodes of the finer one, over its largest. */
static double difference(const beam_solution *coarse, const beam_solution *fine)
{
    const double *points = fine->system->mesh.points;
    double off = 0, size = beam_largest(fine);
    for (size_t which = 0; which < fine->count; which++) {
        for (size_t i = 0; i < beam_system_nodes(fine->system); i++) {
            beam_state a, b;
            beam_at(coarse, which, 1, points + i, &a);
            beam_at(fine, which, 1, points + i, &b);
            double here = fabs(a.deflection - b.deflection);
            off = here <= off ? off : here; /* not a number stays */
        }
    }
    return size > 0 ? off / size : off;
}

static ad_status rate(const void *context, size_t n, const double *s, const double *y, double *to,
                      ad_error *error)
{
    const solve_beam *beam = context;
    beam_section *sections = malloc(n * sizeof *sections);
    beam_load *loads = malloc(n * sizeof *loads);
    ad_status status = sections && loads
                           ? solve_beam_sections(beam, n, s, sections, error)
                           : ad_fail(error, AD_NO_MEMORY, "out of memory for %zu points", n);
    status = status == AD_OK ? solve_beam_load(beam, n, s, 0, loads, error) : status;
    for (size_t i = 0; i < n && status == AD_OK; i++) {
        beam_system_rate(&sections[i], y + i * BEAM_ROWS, &loads[i], to + i * BEAM_ROWS);
    }
    free(sections);
    free(loads);
    return status;
}

/* At rest: the estimate is no smaller than what the solution leaves undone between its points. */
static ad_status look_between(beam_solution *solution, solve_report *report, ad_error *error)
{
    const solve_equations equations = {.rate = rate, .context = solution->beam};
    const solve_elements *mesh = &solution->system->mesh;
    const size_t each = ((size_t)mesh->stages + 1) * BEAM_ROWS, elements = (size_t)mesh->count;
    const size_t places = beam_system_places(solution->system);
    double *residual = malloc((elements * each + places * BEAM_ROWS) * sizeof *residual);
    ad_status status = residual ? AD_OK : ad_fail(error, AD_NO_MEMORY, "out of memory");
    for (size_t e = 0; e < elements && status == AD_OK; e++) {
        status =
            solve_defect(solution->beam->quadrature, &equations, mesh, (int)e,
                         solution->fields + e * (each + BEAM_ROWS), residual + e * each, error);
    }
    if (status == AD_OK) {
        double *step = residual + elements * each, off = 0, size = beam_largest(solution);
        beam_system_correct(solution->system, residual, step);
        for (size_t i = 0; i < places; i++) {
            double here = fabs(step[i * BEAM_ROWS + BEAM_W]);
            off = here <= off ? off : here; /* not a number stays */
        }
        off = size > 0 ? off / size : off;
        report->estimate = isnan(off) ? INFINITY : fmax(report->estimate, off);
    }
    free(residual);
    return status;
}

/* Replace *x by solutions on finer and finer meshes. */
static ad_status refine(beam_solution **x, beam_mesh *mesh, double tolerance, const double *times,
                        solve_report *report, ad_error *error)
{
    const solve_beam *beam = (*x)->beam;
    double before = NAN; /* of two meshes */
    bool done = false;
    ad_status status = beam->dynamic ? AD_OK : look_between(*x, report, error);
    while (status == AD_OK && !done) {
        beam_solution *finer = NULL;
        if (beam->dynamic ? mesh->nodes >= FINEST_MOVING : !halve(mesh)) {
            break;
        }
        if (beam->dynamic) {
            place(mesh, beam, mesh->nodes + mesh->nodes / 2);
        }
        status = solve_once(beam, mesh, (*x)->count, times, &finer, report, error);
        if (status == AD_OK) {
            report->estimate = difference(*x, finer);
            beam_free(*x);
            *x = finer;
            status = beam->dynamic ? AD_OK : look_between(*x, report, error);
            bool rounding = report->estimate < ROUNDING && report->estimate > before / 2;
            done = report->estimate <= tolerance || rounding;
            before = report->estimate;
        }
    }
    return status;
}

ad_status beam_solve(const solve_beam *beam, const solve_settings *settings, size_t count,
                     const double *times, beam_solution **result, solve_report *report,
                     ad_error *error)
{
    *result = NULL;
    *report = solve_report_blank();
    report->time = 1;
    if (beam->dynamic && settings->nodes > BEAM_MOTION_NODES_MAX) {
        return ad_fail(error, AD_BAD_ARGUMENT, "%d nodes; allowed for a beam in motion: at most %d",
                       settings->nodes, BEAM_MOTION_NODES_MAX);
    }
    if (settings->perturbation != 0) {
        return ad_fail(
            error, AD_BAD_ARGUMENT,
            "a perturbation is given, but beams of small deflection do not buckle; leave "
            "it out, or take rod.model kirchhoff or cosserat");
    }
    beam_solution *solution = NULL;
    beam_mesh mesh;
    bool is_given = settings->nodes > 0;
    ad_status status = AD_OK;
    report->unresolved = beam->quadrature->unresolved;
    place(&mesh, beam, is_given ? settings->nodes : COARSEST);
    if (!is_given && !beam->dynamic) {
        status = begin(&mesh, beam, settings->tolerance, report, error);
    }
    if (status == AD_OK) {
        status =
            solve_once(beam, &mesh, beam->dynamic ? count : 1, times, &solution, report, error);
    }
    if (status == AD_OK && !is_given) {
        status = refine(&solution, &mesh, settings->tolerance, times, report, error);
    }
    if (status != AD_OK) {
        beam_free(solution);
        return status;
    }
    *result = solution;
    return AD_OK;
}
