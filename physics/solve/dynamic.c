#include "physics/solve/dynamic.h"

#include "physics/solve/fastest.h"
#include "physics/solve/mesh.h"
#include "physics/solve/quaternion.h"
#include "physics/solve/split.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

/* Intervals between nodes: each mesh has half as many again as the one before. */
enum { COARSEST = 12, FINEST = 2048, COMPARED = 33 };

/* A smooth motion takes few intervals, best in elements of high degree. Where many are asked for
 * there are waves with kinks; fewer points crowd at the edges of elements of lower degree, and
 * LANES of them are one block. */
enum { ELEMENT_DEGREE_MAX = 16, MANY = 48, ELEMENT_DEGREE_OF_MANY = 7 };

/* Of elements that are many because something acts at many places. */
enum { LEAST_DEGREE = 4 };

struct dynamic_solution {
    motion *motion;
    size_t count;
    double *times;          /* [count] */
    double *states;         /* [count][nodes][MOTION_ROWS] */
    solve_energy *energies; /* [count] */
};

void dynamic_free(dynamic_solution *x)
{
    if (x) {
        motion_free(x->motion);
        free(x->times);
        free(x->states);
        free(x->energies);
        free(x);
    }
}

const solve_energy *dynamic_energies(const dynamic_solution *x)
{
    return x->energies;
}

ad_status dynamic_at(const dynamic_solution *x, size_t which, size_t n, const double *s,
                     solve_state *out, ad_error *error)
{
    const double *state = x->states + which * motion_nodes(x->motion) * MOTION_ROWS;
    ad_status status = motion_at(x->motion, x->times[which], error);
    if (status == AD_OK) {
        motion_samples(x->motion, state, n, s, out);
    }
    return status;
}

/* A locked strain is a stiff one, which implicit steps stand: forces of some EI/L^2 stretch it by a
 * hundredth of the tolerance. Beyond the largest, rounding costs more than stiffness gains. */
static double lock_for(double tolerance)
{
    return fmin(100 / tolerance, 1e10);
}

/* Memory for a solution on a mesh of at least so many intervals. */
static ad_status create(const solve_rod *rod, double lock, int intervals, size_t count,
                        const double *times, dynamic_solution **result, ad_error *error)
{
    int most = intervals < MANY ? ELEMENT_DEGREE_MAX : ELEMENT_DEGREE_OF_MANY;
    int elements = (intervals + most - 1) / most;
    double places[SOLVE_JUMPS_MAX], *edges;
    for (int i = 0; i < rod->jumps.count; i++) {
        places[i] = rod->jumps.at[i].s;
    }
    edges = malloc(((size_t)(elements + rod->jumps.count) + 1) * sizeof *edges);
    dynamic_solution *x = calloc(1, sizeof *x);
    if (!x || !edges) {
        free(edges);
        free(x);
        return ad_fail(error, AD_NO_MEMORY, "out of memory for a motion");
    }
    elements = solve_mesh_edges(elements, rod->jumps.count, places, edges);
    int degree = (intervals + elements - 1) / elements;
    degree = rod->jumps.count > 0 && degree < LEAST_DEGREE ? LEAST_DEGREE : degree;
    ad_status status = motion_create(rod, lock, elements, edges, degree, &x->motion, error);
    free(edges);
    if (status == AD_OK) {
        x->count = count;
        x->times = malloc((count + 1) * sizeof *x->times);
        x->states = malloc((count + 1) * motion_nodes(x->motion) * MOTION_ROWS * sizeof(double));
        x->energies = malloc((count + 1) * sizeof *x->energies);
        if (!x->times || !x->states || !x->energies) {
            status = ad_fail(error, AD_NO_MEMORY, "out of memory for %zu times", count);
        }
    }
    if (status != AD_OK) {
        dynamic_free(x);
        return status;
    }
    memcpy(x->times, times, count * sizeof *times);
    *result = x;
    return AD_OK;
}

/* How finely a motion is solved. */
typedef struct resolution {
    double lock;
    int intervals;
    double tolerance; /* of adaptive steps of time */
    double shortened; /* steps that are composed of flows: so much shorter than the longest */
    bool follows;     /* every vibration of the mesh, where implicit steps took too long */
    bool is_composed; /* the last solution: its steps shorten with the mesh */
} resolution;

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

static ad_status find_frequency(dynamic_solution *x, double *frequency, ad_error *error)
{
    fastest *f = NULL;
    ad_status status = fastest_create(x->motion, &f, error);
    status = status == AD_OK ? fastest_at_start(f, frequency, error) : status;
    fastest_free(f);
    return status;
}

/* Following every vibration of the mesh, in steps that are as short as that takes. */
static ad_status follow(dynamic_solution *x, const resolution *by, double frequency,
                        integrate_counts *counts, ad_error *error)
{
    integrate_settings settings = {.method = INTEGRATE_EXPLICIT, .tolerance = by->tolerance};
    if (!motion_is_separable(x->motion)) {
        return motion_integrate(x->motion, &settings, x->count, x->times, x->states, x->energies,
                                counts, error);
    }
    settings.step = 1 / (split_steps(frequency) * by->shortened);
    return split_integrate(x->motion, &settings, x->count, x->times, x->states, x->energies, counts,
                           error);
}

/* The implicit method has as many steps as cost what following all vibrations would; where they do
 * not suffice that it is, from then on. So no choice costs more than twice the better one. */
static ad_status integrate_either(const solve_rod *rod, dynamic_solution *x, resolution *by,
                                  solve_report *report, double *work, ad_error *error)
{
    double frequency = 0, nodes = (double)motion_nodes(x->motion);
    integrate_counts counts = {0};
    ad_status status = find_frequency(x, &frequency, error);
    bool composes = motion_is_separable(x->motion), done = false;
    double explicit_steps = rod->duration * (composes ? split_steps(frequency) * by->shortened
                                                      : integrate_explicit_steps(frequency));
    double explicit_work =
        explicit_steps * (composes ? composed_step_work(nodes) : explicit_step_work(nodes));
    double implicit_work = implicit_step_work(rod, nodes);
    if (status == AD_OK && !by->follows) {
        integrate_settings settings = {.method = INTEGRATE_IMPLICIT,
                                       .tolerance = by->tolerance,
                                       .steps_max =
                                           1 + (long)fmin(explicit_work / implicit_work, 1e9)};
        status = motion_integrate(x->motion, &settings, x->count, x->times, x->states, x->energies,
                                  &counts, error);
        report->newton_steps += counts.newton_steps;
        report->time_steps += counts.steps;
        report->time = counts.time / rod->duration;
        *work += (double)counts.steps * implicit_work;
        done = status != AD_NOT_FINITE;
        by->follows = !done;
    }
    if (!done && (status == AD_OK || status == AD_NOT_FINITE)) {
        status = follow(x, by, frequency, &counts, error);
        report->time_steps += counts.steps;
        report->time = counts.time / rod->duration;
        *work += (double)counts.steps * explicit_work / explicit_steps;
    }
    by->is_composed = !done && composes;
    return status;
}

/* The largest energy, and the largest mismatch over it. */
static void take_energies(const dynamic_solution *x, solve_report *report)
{
    double mismatch = 0, largest = 0;
    for (size_t i = 0; i < x->count; i++) {
        const solve_energy *e = &x->energies[i];
        mismatch = fmax(mismatch, fabs(e->mismatch));
        largest = fmax(largest, fmax(e->kinetic + e->strain, fmax(fabs(e->work), e->dissipated)));
    }
    report->energy = largest;
    report->energy_mismatch = mismatch > 0 ? mismatch / largest : 0;
}

static ad_status solve_once(const solve_rod *rod, resolution *by, size_t count, const double *times,
                            dynamic_solution **result, solve_report *report, double *work,
                            ad_error *error)
{
    dynamic_solution *x = NULL;
    solve_report of_this = *report;
    *result = NULL;
    *work = 0;
    ad_status status = create(rod, by->lock, by->intervals, count, times, &x, error);
    if (status != AD_OK) {
        return status;
    }
    status = integrate_either(rod, x, by, &of_this, work, error);
    of_this.nodes = (int)motion_nodes(x->motion);
    if (status != AD_OK) {
        report->time = report->nodes == 0 ? of_this.time : report->time;
        dynamic_free(x);
        return status;
    }
    take_energies(x, &of_this);
    *report = of_this;
    *result = x;
    return AD_OK;
}

/* ---- refining ------------------------------------------------------------------------------ */

/* Of two states: of positions, and of rotations what their angle moves over a tenth of the rod. */
static double apart(const solve_state *a, const solve_state *b)
{
    const double *p = a->position, *q = b->position, lever = 0.1;
    double turn[4];
    quaternion_quotient(a->rotation, b->rotation, turn);
    double angle = 2 * atan2(sqrt(vector_dot(turn + 1, turn + 1)), fabs(turn[0]));
    return fmax(hypot(hypot(p[0] - q[0], p[1] - q[1]), p[2] - q[2]), lever * angle);
}

/* The largest, at all times. */
static ad_status compare(const dynamic_solution *x, const dynamic_solution *y, double *distance,
                         ad_error *error)
{
    double s[COMPARED];
    solve_state of_x[COMPARED], of_y[COMPARED];
    ad_status status = AD_OK;
    *distance = 0;
    for (int i = 0; i < COMPARED; i++) {
        s[i] = (double)i / (COMPARED - 1);
    }
    for (size_t which = 0; which < x->count && status == AD_OK; which++) {
        status = dynamic_at(x, which, COMPARED, s, of_x, error);
        status = status == AD_OK ? dynamic_at(y, which, COMPARED, s, of_y, error) : status;
        for (int i = 0; i < COMPARED && status == AD_OK; i++) {
            *distance = fmax(*distance, apart(&of_x[i], &of_y[i]));
        }
    }
    return status;
}

/* What refining has reached. */
typedef struct refined {
    dynamic_solution *best;
    resolution by;
    double distance;    /* between the last two */
    double work, total; /* of the last solution, and of all, in forces on one node */
} refined;

/* What all solutions together may cost: some 30 s. */
static const double WORK_MOST = 1e9;

/* Replace the best by a solution on the mesh and with the steps at hand. One that fails leaves the
 * best, and *failed. */
static ad_status solve_again(const solve_rod *rod, refined *at, solve_report *report, bool *failed,
                             ad_error *error)
{
    dynamic_solution *next = NULL, *last = at->best;
    ad_status status =
        solve_once(rod, &at->by, last->count, last->times, &next, report, &at->work, error);
    at->total += at->work;
    *failed = status == AD_NOT_FINITE;
    if (status == AD_OK) {
        status = compare(last, next, &at->distance, error);
        dynamic_free(last);
        at->best = next;
    }
    return *failed ? AD_OK : status;
}

/* Whether a solution that costs so many times the last one is allowed. */
static bool affords(const refined *at, double times)
{
    return at->total + times * at->work <= WORK_MOST;
}

/* Steps of time alone, where meshes are coarse and steps cheap: steps of two meshes differ, and
 * their errors would pass for errors of the mesh. What two tolerances of steps differ by is the
 * error of the larger, so that it will do for all meshes. *by_time: what it leaves. Steps that are
 * composed of flows shorten with the mesh; nothing is to be done. */
static ad_status refine_time(const solve_rod *rod, double tolerance, refined *at,
                             solve_report *report, double *by_time, ad_error *error)
{
    /* Of time steps: rounding is not far, and nearer where it is multiplied by large stiffness. */
    const scene_properties properties = scene_properties_of(&rod->scene);
    const double finest = scene_is_locked(&properties) ? 1e-8 : 1e-12, of_time = 0.25;
    double *steps = &at->by.tolerance;
    bool failed = false;
    ad_status status = AD_OK;
    *by_time = at->by.is_composed ? 0 : INFINITY;
    while (status == AD_OK && *by_time > of_time * tolerance && *steps > finest && affords(at, 2)) {
        const resolution before = at->by;
        *steps = fmax(*steps / 10, finest);
        status = solve_again(rod, at, report, &failed, error);
        if (failed) {
            break;
        }
        *by_time = at->by.is_composed ? 0 : at->distance;
        if (at->distance <= of_time * tolerance) {
            at->by.tolerance = before.tolerance;
        }
    }
    return status;
}

/* The error that a distance between the last two meshes leaves: of a motion with waves that no mesh
 * resolves distances fall by little, and what is yet to come adds up to
 * distance (ratio + ratio^2 + ...). */
static double left_over(double distance, double before)
{
    const double largest = 0.8; /* ratio: distances of rough motions scatter */
    double ratio = fmin(distance / before, largest);
    return distance * fmax(1, ratio / (1 - ratio));
}

static ad_status refine(const solve_rod *rod, double tolerance, refined *at, solve_report *report,
                        ad_error *error)
{
    double by_time = 0, estimate = INFINITY, before = INFINITY;
    bool failed = false;
    ad_status status = refine_time(rod, tolerance, at, report, &by_time, error);
    for (int meshes = 1; status == AD_OK && !failed && by_time + estimate > tolerance; meshes++) {
        if (at->by.intervals >= FINEST || (meshes > 1 && !affords(at, 3))) {
            break;
        }
        at->by.intervals += at->by.intervals / 2;
        status = solve_again(rod, at, report, &failed, error);
        if (!failed) {
            estimate = left_over(at->distance, before);
            before = at->distance;
        }
    }
    report->estimate = by_time + estimate;
    return status;
}

/* On a mesh that is given steps of time alone are refined, where they do not look after their own
 * error. */
static ad_status shorten(const solve_rod *rod, double tolerance, refined *at, solve_report *report,
                         ad_error *error)
{
    bool failed = false;
    ad_status status = AD_OK;
    at->distance = INFINITY;
    while (status == AD_OK && !failed && at->by.is_composed && at->distance > tolerance &&
           affords(at, 2)) {
        at->by.shortened *= 2;
        status = solve_again(rod, at, report, &failed, error);
    }
    return status;
}

ad_status dynamic_solve(const solve_rod *rod, const solve_settings *settings, size_t count,
                        const double *times, dynamic_solution **result, solve_report *report,
                        ad_error *error)
{
    *result = NULL;
    *report = (solve_report){.estimate = NAN, .load_fraction = 1, .energy_mismatch = NAN};
    for (size_t i = 0; i < count; i++) {
        if (!(times[i] >= (i > 0 ? times[i - 1] : 0) && times[i] <= rod->duration)) {
            return ad_fail(error, AD_BAD_ARGUMENT,
                           "time %zu is %g; allowed: ascending, from 0 to %g", i, times[i],
                           rod->duration);
        }
    }
    bool is_given = settings->nodes > 0;
    refined at = {.by = {.lock = lock_for(settings->tolerance),
                         .tolerance = (is_given ? 1 : 10) * settings->tolerance,
                         .intervals = !is_given             ? COARSEST
                                      : settings->nodes > 2 ? settings->nodes - 1
                                                            : 2,
                         .shortened = 1}};
    ad_status status = solve_once(rod, &at.by, count, times, &at.best, report, &at.work, error);
    at.total = at.work;
    if (status == AD_OK) {
        status = is_given ? shorten(rod, settings->tolerance, &at, report, error)
                          : refine(rod, settings->tolerance, &at, report, error);
    }
    if (status != AD_OK) {
        dynamic_free(at.best);
        return status;
    }
    *result = at.best;
    return AD_OK;
}
