#include "physics/solve/motion_mesh.h"

#include "physics/local/mesh.h"
#include "physics/solve/motion_compose.h"
#include "physics/solve/motion_fastest.h"

#include <math.h>
#include <stdlib.h>

/* A smooth motion takes few intervals, best in elements of high degree. Where many are asked for
 * there are waves with kinks; fewer points crowd at the edges of elements of lower degree, and
 * LANES of them are one block. */
enum { DEGREE_MAX = 16, MANY = 48, DEGREE_OF_MANY = 7 };

/* Of elements that are short because something jumps nearby. */
enum { DEGREE_MIN = 4 };

/* So many more elements where what is given is narrow. */
enum { DIVISIONS = 256 };

/* ---- meshes -------------------------------------------------------------------------------- */

ad_status motion_mesh(const solve_rod *rod, const solve_quadrature *places, double lock,
                      double tolerance, int intervals, motion **result, ad_error *error)
{
    int most = intervals < MANY ? DEGREE_MAX : DEGREE_OF_MANY;
    int elements = (intervals + most - 1) / most;
    const int room = elements + places->place_count + DIVISIONS;
    const solve_given given = motion_given(rod);
    double *edges = malloc((size_t)(room + 1) * sizeof *edges);
    *result = NULL;
    if (!edges) {
        return ad_fail(error, AD_NO_MEMORY, "out of memory for %d elements", elements);
    }
    elements = solve_mesh_edges(elements, places->place_count, places->places, edges);
    int degree = (intervals + elements - 1) / elements, least = elements > 1 ? DEGREE_MIN : 2;
    degree = degree < least ? least : degree;
    int stages = degree < GAUSS_STAGES_MAX ? degree : GAUSS_STAGES_MAX;
    bool done;
    ad_status status = solve_quadrature_divide(places, &given, stages, tolerance, room, &elements,
                                               edges, &done, error);
    if (status == AD_OK) {
        status = motion_create(rod, lock, elements, edges, degree, result, error);
    }
    free(edges);
    return status;
}

/* ---- ways through time --------------------------------------------------------------------- */

/* What one step costs, in forces on one node. */
static double composed_step_work(double nodes)
{
    return 6 * nodes;
}

/* Six forces, which cost less than the rest of ARKODE's step. */
static double explicit_step_work(double nodes)
{
    return 18 * nodes;
}

/* Measured with 13 to 91 nodes: in between the dense systems take over. Loads of a manufactured
 * solution cost more than all the rest, and are asked for by each. */
static double implicit_step_work(const solve_rod *rod, double nodes)
{
    return scene_is_manufactured(&rod->scene)
               ? 22 * nodes
               : (18 + nodes * nodes / 169) * composed_step_work(nodes);
}

static ad_status find_frequency(motion *m, double *frequency, ad_error *error)
{
    fastest *f = NULL;
    ad_status status = motion_fastest_create(m, &f, error);
    status = status == AD_OK ? motion_fastest_at_start(f, frequency, error) : status;
    motion_fastest_free(f);
    return status == AD_OK && !isfinite(*frequency)
               ? ad_fail(error, AD_NOT_FINITE,
                         "accelerations are not finite at t = 0 s; a load, an end or the rest "
                         "shape is not finite there")
               : status;
}

/* Steps that are too long for what the motion becomes show as energy from nowhere, or as none that
 * is a number. */
static bool is_unstable(const motion_record *record)
{
    const double beyond = 0.1;     /* of the largest energy; where steps suit it is below 1e-4 */
    const double rounding = 1e-16; /* by EI/L */
    double largest = 0, mismatch = 0;
    for (size_t i = 0; i < record->count; i++) {
        const solve_energy *e = &record->energies[i];
        largest = fmax(largest, fmax(e->kinetic + e->strain, fabs(e->work)));
        mismatch = motion_larger(mismatch, fabs(e->mismatch));
    }
    return !(mismatch <= beyond * largest + rounding);
}

static ad_status compose(motion *m, motion_steps *by, double frequency, const motion_record *to,
                         solve_report *report, ad_error *error)
{
    const int attempts = 3;
    ad_status status = AD_NOT_FINITE;
    for (int i = 0; i < attempts; i++) {
        integrate_counts counts = {0};
        integrate_settings settings = {.step =
                                           1 / (motion_compose_steps(frequency) * by->shortened),
                                       .events = by->events,
                                       .clock = &by->clock};
        status = motion_compose(m, &settings, to->count, to->times, to->states, to->energies,
                                &counts, error);
        by->work += (double)counts.steps * composed_step_work((double)motion_nodes(m));
        report->time_steps += counts.steps;
        report->time = counts.time / motion_rod(m)->duration;
        if (status != AD_NOT_FINITE && !(status == AD_OK && is_unstable(to))) {
            break;
        }
        by->shortened *= 2;
    }
    return status;
}

static ad_status integrate(motion *m, motion_steps *by, const integrate_settings *settings,
                           double step_work, const motion_record *to, solve_report *report,
                           ad_error *error)
{
    integrate_counts counts = {0};
    ad_status status = motion_integrate(m, settings, to->count, to->times, to->states, to->energies,
                                        &counts, error);
    by->work += (double)counts.steps * step_work;
    report->newton_steps += counts.newton_steps;
    report->time_steps += counts.steps;
    report->time = counts.time / motion_rod(m)->duration;
    return status;
}

ad_status motion_go(motion *m, motion_steps *by, const motion_record *to, solve_report *report,
                    ad_error *error)
{
    const solve_rod *rod = motion_rod(m);
    double frequency = 0, nodes = (double)motion_nodes(m);
    bool composes = motion_is_separable(m);
    ad_status status = find_frequency(m, &frequency, error);
    by->work = 0;
    by->is_composed = false;
    if (status == AD_OK && !by->follows) {
        double steps = rod->duration * (composes ? motion_compose_steps(frequency) * by->shortened
                                                 : motion_explicit_steps(frequency));
        double work = steps * (composes ? composed_step_work(nodes) : explicit_step_work(nodes));
        double step_work = implicit_step_work(rod, nodes);
        integrate_settings settings = {.method = INTEGRATE_IMPLICIT,
                                       .tolerance = by->tolerance,
                                       .steps_max = 1 + (long)fmin(work / step_work, 1e9),
                                       .events = by->events,
                                       .clock = &by->clock};
        status = integrate(m, by, &settings, step_work, to, report, error);
        by->follows = status == AD_NOT_FINITE;
        if (!by->follows) {
            return status;
        }
        status = AD_OK;
    }
    if (status == AD_OK && composes) {
        by->is_composed = true;
        return compose(m, by, frequency, to, report, error);
    }
    integrate_settings settings = {.method = INTEGRATE_EXPLICIT,
                                   .tolerance = by->tolerance,
                                   .events = by->events,
                                   .clock = &by->clock};
    return status == AD_OK
               ? integrate(m, by, &settings, explicit_step_work(nodes), to, report, error)
               : status;
}
