#include "physics/solve/dynamic.h"

#include "physics/solve/quaternion.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

/* Intervals between nodes: each mesh has half as many again as the one before. */
enum { COARSEST = 12, FINEST = 128, ELEMENT_DEGREE_MAX = 16, COMPARED = 33 };

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
    int elements = (intervals + ELEMENT_DEGREE_MAX - 1) / ELEMENT_DEGREE_MAX;
    int degree = (intervals + elements - 1) / elements;
    dynamic_solution *x = calloc(1, sizeof *x);
    if (!x) {
        return ad_fail(error, AD_NO_MEMORY, "out of memory for a motion");
    }
    ad_status status = motion_create(rod, lock, elements, NULL, degree, &x->motion, error);
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
    double tolerance;     /* of time steps */
    double implicit_part; /* of the time, that implicit steps came in the time explicit ones take;
                           * 1: all the way, or not tried */
} resolution;

/* The implicit method has as many steps as cost what the explicit one would; where they do not
 * suffice the explicit one it is. So no choice costs more than twice the better one. Implicit steps
 * that came less than half the way before are not tried again. */
static ad_status integrate_either(const solve_rod *rod, dynamic_solution *x, resolution *by,
                                  solve_report *report, ad_error *error)
{
    /* Measured: 6 to 10 with 13 to 43 nodes; the loads of a manufactured solution cost more than
     * all the rest, and are asked for as often. */
    const double explicit_steps_per_implicit = scene_is_manufactured(&rod->scene) ? 1.2 : 6;
    double needed = 0;
    integrate_counts counts;
    ad_status status = motion_explicit_steps(x->motion, &needed, error);
    if (status != AD_OK) {
        return status;
    }
    double allowed = fmin(needed * rod->duration / explicit_steps_per_implicit, 1e9);
    integrate_settings settings = {.tolerance = by->tolerance, .steps_max = 1 + (long)allowed};
    for (int method = by->implicit_part < 0.5; method < 2; method++) {
        if (method == 1) {
            settings.method = INTEGRATE_EXPLICIT;
            settings.steps_max = 0;
        }
        status = motion_integrate(x->motion, &settings, x->count, x->times, x->states, x->energies,
                                  &counts, error);
        report->newton_steps += counts.newton_steps;
        report->time_steps += counts.steps;
        report->time = counts.time / rod->duration;
        if (method == 1 || counts.steps < settings.steps_max) {
            break;
        }
        by->implicit_part = report->time;
    }
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
                            dynamic_solution **result, solve_report *report, ad_error *error)
{
    dynamic_solution *x = NULL;
    *result = NULL;
    ad_status status = create(rod, by->lock, by->intervals, count, times, &x, error);
    if (status != AD_OK) {
        return status;
    }
    status = integrate_either(rod, x, by, report, error);
    report->nodes = (int)motion_nodes(x->motion);
    take_energies(x, report);
    if (status != AD_OK) {
        dynamic_free(x);
        return status;
    }
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
    double distance; /* between the last two */
} refined;

/* Replace the best by a solution on the mesh and with the steps at hand. */
static ad_status solve_again(const solve_rod *rod, refined *at, solve_report *report,
                             ad_error *error)
{
    dynamic_solution *next = NULL, *last = at->best;
    ad_status status = solve_once(rod, &at->by, last->count, last->times, &next, report, error);
    if (status == AD_OK) {
        status = compare(last, next, &at->distance, error);
        dynamic_free(last);
        at->best = next;
    }
    return status;
}

/* First t, where meshes are coarse and steps cheap, then s: steps of two meshes differ, and their
 * errors would pass for errors of the mesh. What two tolerances of steps differ by is the error of
 * the larger, so that it will do for all meshes. */
static ad_status refine(const solve_rod *rod, double tolerance, refined *at, solve_report *report,
                        ad_error *error)
{
    /* Of time steps: rounding is not far, and nearer where it is multiplied by large stiffness. */
    const scene_properties properties = scene_properties_of(&rod->scene);
    const double finest = scene_is_locked(&properties) ? 1e-8 : 1e-12, of_time = 0.25,
                 of_mesh = 0.5;
    double *steps = &at->by.tolerance;
    resolution before;
    ad_status status = AD_OK;
    do {
        before = at->by;
        *steps = fmax(*steps / 10, finest);
        status = solve_again(rod, at, report, error);
    } while (status == AD_OK && at->distance > of_time * tolerance && *steps > finest);
    double by_time = at->distance;
    at->by = by_time <= of_time * tolerance ? before : at->by;
    do {
        at->by.intervals += at->by.intervals / 2;
        status = status == AD_OK ? solve_again(rod, at, report, error) : status;
    } while (status == AD_OK && at->distance > of_mesh * tolerance && at->by.intervals < FINEST);
    report->estimate = by_time + at->distance;
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
                         .implicit_part = 1}};
    ad_status status = solve_once(rod, &at.by, count, times, &at.best, report, error);
    if (status == AD_OK && !is_given) {
        status = refine(rod, settings->tolerance, &at, report, error);
    }
    if (status != AD_OK) {
        dynamic_free(at.best);
        return status;
    }
    *result = at.best;
    return AD_OK;
}
