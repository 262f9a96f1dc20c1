#include "physics/solve/modes_motion.h"

#include "physics/chain/modes_internal.h"
#include "physics/chain/modes_step.h"
#include "physics/solve/events.h"
#include "physics/solve/motion_times.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

enum { STAGES = MODES_MOTION_STAGES, STATES = MODES_MOTION_STATES };

/* Of time. */
static const double ROUNDING = 1e-14;

struct modes_solution {
    modes *m;
    motion_times times;
    double *states;         /* [times.count][STATES][size]: q, q_t, stretches of branches */
    double *looked;         /* [times.count] of solve_events_before */
    solve_energy *all;      /* [times.count] */
    solve_energy *energies; /* [times.given] */
    double initial;         /* energy */
    double may_be_off;      /* what a held end may be, over the length or in rad */
    double *room;           /* [2 STATES + 1][size] */
    long steps;
    double work, reached;
    bool is_stuck; /* a held end hardly gives way, at the time that was reached */
};

void modes_motion_free(modes_solution *solution)
{
    if (solution) {
        modes_free(solution->m);
        motion_times_free(&solution->times);
        free(solution->states);
        free(solution->all);
        free(solution->energies);
        free(solution->room);
        free(solution);
    }
}

const solve_energy *modes_motion_energies(const modes_solution *solution)
{
    return solution->energies;
}

/* ---- one solution -------------------------------------------------------------------------- */

static ad_status create(solve_rod *rod, const modes_counts *counts, int finer, size_t given,
                        const double *times, modes_solution **result, ad_error *error)
{
    modes_solution *solution = calloc(1, sizeof *solution);
    *result = solution;
    if (!solution) {
        return ad_fail(error, AD_NO_MEMORY, "out of memory for a motion");
    }
    ad_status status = modes_create(rod, NULL, counts, finer, &solution->m, error);
    status = status == AD_OK ? motion_times_create(given, times, &solution->times, error) : status;
    if (status != AD_OK) {
        return status;
    }
    const size_t size = (size_t)modes_size(solution->m), count = solution->times.count;
    solution->states = calloc((STATES * size + 1) * count, sizeof *solution->states);
    solution->looked = solution->states + STATES * count * size;
    solution->all = calloc(count, sizeof *solution->all);
    solution->energies = calloc(given + 1, sizeof *solution->energies);
    solution->room = calloc((2 * STATES + 1) * size + 1, sizeof *solution->room);
    return solution->states && solution->all && solution->energies && solution->room
               ? AD_OK
               : ad_fail(error, AD_NO_MEMORY, "out of memory for %zu times", count);
}

/* Of the shape as it is: whether a held end is where it should be. */
static ad_status check_end(const modes_solution *solution, ad_error *error)
{
    const modes *m = solution->m;
    const double off = modes_end_off(m);
    return off <= solution->may_be_off
               ? AD_OK
               : ad_fail(error, AD_NOT_FINITE,
                         "boundary.end: at t = %g s the modes are off what it holds by %.2g of the "
                         "length or rad; allowed: more modes",
                         m->time * m->rod->scales.time, off);
}

/* Whether a held end is hard to move in some direction: the mass that resists there, over that of
 * the rod, is above `most`. So it is where a rod that does not stretch is all but straight. At the
 * present time. */
static bool is_stuck(modes_solution *solution, const double *q, const double *v, double most)
{
    modes *m = solution->m;
    double *a = solution->room + 2 * (STATES * (size_t)m->size);
    solution->is_stuck =
        m->end.count > 0 && (!modes_accelerations(m, q, v, a) || m->end.freedom * most < 1);
    return solution->is_stuck;
}

/* Where the rod is at one of the times, q [STATES][size], with `energy` as it is then. */
static ad_status take(modes_solution *solution, size_t which, const double *q,
                      const solve_energy *energy, ad_error *error)
{
    const size_t size = (size_t)modes_size(solution->m);
    double *to = solution->states + which * STATES * size;
    ad_status status = modes_at(solution->m, solution->times.all[which], NULL, error);
    if (status != AD_OK) {
        return status;
    }
    memcpy(to, q, STATES * size * sizeof *to);
    modes_stretch(solution->m, q + 2 * size);
    modes_shape(solution->m, q, q + size, NULL);
    status = check_end(solution, error);
    if (status == AD_OK && is_stuck(solution, q, q + size, 1e6)) {
        status = modes_end_fail(error);
    }
    const solve_energy now = modes_energy_now(solution->m);
    const double before = solution->initial + energy->work - energy->dissipated;
    solution->all[which] = (solve_energy){now.kinetic, now.strain, energy->work, energy->dissipated,
                                          now.kinetic + now.strain - before};
    return status;
}

static ad_status begin(modes_solution *solution, const solve_settings *settings, double *q,
                       double *v, ad_error *error)
{
    ad_status status = modes_initial(solution->m, q, v, error);
    if (status == AD_OK && settings->from_count > 0 && solution->m->branch.count > 0) {
        status = ad_fail(error, AD_BAD_INPUT,
                         "material.maxwell: what a motion begins with does not say how far it has "
                         "relaxed; allowed: the start of the scene");
    }
    if (status == AD_OK && settings->from_count > 0) {
        status = modes_fit_seen(solution->m, settings->from_count, settings->from, q, v, error);
    }
    status = status == AD_OK ? modes_at(solution->m, 0, NULL, error) : status;
    if (status == AD_OK) {
        modes_stretch(solution->m, NULL);
        modes_shape(solution->m, q, v, NULL);
        const solve_energy now = modes_energy_now(solution->m);
        solution->initial = now.kinetic + now.strain;
        status = check_end(solution, error);
    }
    return status;
}

/* Through all times, with a stop at each instant that no step may pass. */
static ad_status go(modes_solution *solution, const solve_settings *settings, double tolerance,
                    const solve_events *e, ad_error *error)
{
    const size_t size = (size_t)modes_size(solution->m);
    const motion_times *times = &solution->times;
    double *q = solution->room, *v = q + size, *d = v + size, *at = d + size, t = 0;
    const double end = times->all[times->count - 1];
    size_t next = 0, event = 0;
    solve_energy energy = {0};
    collocation *steps = NULL;
    solution->may_be_off = fmax(1e-5, 100 * tolerance);
    for (size_t i = 0; i < times->count; i++) {
        solution->looked[i] = solve_events_before(e, times->all[i]);
    }
    ad_status status = begin(solution, settings, q, v, error);
    memset(d, 0, size * sizeof *d); /* of a rod that has rested */
    status = status == AD_OK ? collocation_create(solution->m, STAGES, &steps, error) : status;
    for (; next < times->count && times->all[next] <= t && status == AD_OK; next++) {
        status = take(solution, next, q, &energy, error);
    }
    while (next < times->count && status == AD_OK) {
        const double from = t;
        while (event < e->count && e->times[event] <= t + ROUNDING * fmax(1, t)) {
            event++;
        }
        const double stop = event < e->count ? fmin(end, e->times[event]) : end;
        status = collocation_next(steps, &t, stop, tolerance, q, v, d, &energy, error);
        for (; next < times->count && times->all[next] <= t && status == AD_OK; next++) {
            solve_energy then;
            collocation_within(steps, (times->all[next] - from) / (t - from), at, at + size,
                               at + 2 * size, &then);
            status = take(solution, next, at, &then, error);
        }
        solution->reached = status == AD_OK ? t : solution->reached;
        if (status == AD_NOT_FINITE && modes_at(solution->m, t, NULL, error) == AD_OK &&
            is_stuck(solution, q, v, 1e2)) {
            status = modes_end_fail(error);
        }
    }
    if (steps) {
        const collocation_counts counts = collocation_counts_of(steps);
        const double n = (double)size, points = solution->m->points;
        solution->steps = counts.steps;
        solution->work =
            (double)counts.iterations * STAGES * (400 * points + 4 * n * points + n * n) +
            (double)counts.matrices * (600 * n * points + 12 * n * n * points + 8 * n * n * n);
    }
    collocation_free(steps);
    return status;
}

ad_status modes_motion_at(const modes_solution *solution, size_t which, size_t n, const double *s,
                          solve_state *out, ad_error *error)
{
    const size_t size = (size_t)modes_size(solution->m), at = solution->times.which[which];
    modes_places *places = NULL;
    ad_status status = modes_at(solution->m, solution->looked[at], NULL, error);
    status = status == AD_OK ? modes_places_create(solution->m, n, s, &places, error) : status;
    status = status == AD_OK ? modes_see(solution->m, solution->states + at * STATES * size,
                                         solution->room, places, out, error)
                             : status;
    modes_places_free(places);
    return status;
}

/* ---- refining ------------------------------------------------------------------------------ */

typedef struct refined {
    solve_rod *rod;
    size_t given;
    const double *times; /* [given] */
    solve_events *events;
    modes_solution *best;
    solve_state *seen[2]; /* [fixed times][MOTION_COMPARED] of the last solutions, the best first */
    double work;
    bool is_stuck; /* the last that was tried */
} refined;

/* What solutions together may cost, in operations: some 20 s. */
static const double WORK_MOST = 2e11;

static ad_status look(refined *at, ad_error *error)
{
    modes_solution *solution = at->best;
    const size_t size = (size_t)modes_size(solution->m);
    double s[MOTION_COMPARED];
    solve_state *all = malloc(solution->times.fixed * MOTION_COMPARED * sizeof *all);
    ad_status status = all ? AD_OK : ad_fail(error, AD_NO_MEMORY, "out of memory for times");
    free(at->seen[1]);
    at->seen[1] = at->seen[0];
    at->seen[0] = all;
    for (int i = 0; i < MOTION_COMPARED; i++) {
        s[i] = (double)i / (MOTION_COMPARED - 1);
    }
    modes_places *places = NULL;
    status = status == AD_OK ? modes_places_create(solution->m, MOTION_COMPARED, s, &places, error)
                             : status;
    for (size_t i = 0; i < solution->times.count && status == AD_OK; i++) {
        const double *q = solution->states + i * STATES * size;
        if (!solution->times.aside[i]) {
            status = modes_at(solution->m, solution->times.all[i], NULL, error);
            modes_shape(solution->m, q, q + size, NULL);
            modes_samples(solution->m, places, all);
            all += MOTION_COMPARED;
        }
    }
    modes_places_free(places);
    return status;
}

static ad_status solve_once(refined *at, const solve_settings *settings, const modes_counts *counts,
                            int finer, double tolerance, solve_report *report, ad_error *error)
{
    modes_solution *next = NULL;
    ad_status status = create(at->rod, counts, finer, at->given, at->times, &next, error);
    if (status == AD_OK) {
        status = go(next, settings, tolerance, at->events, error);
        at->work += next->work;
        report->time_steps += next->steps;
    }
    if (status != AD_OK) {
        report->time = next ? next->reached / at->rod->duration : 0;
        at->is_stuck = next && next->is_stuck;
        modes_motion_free(next);
        return status;
    }
    modes_motion_free(at->best);
    at->best = next;
    return look(at, error);
}

/* Which strains are left out of those that stay 0. All, but where an end is held: there only those
 * that have no modes, and such as leave the rod in a plane. Without twist, say, modes of bending
 * about both directors do not turn the end of a straight rod about its axis. */
static void leave_out(const modes *m, const bool is_still[MODES_STRAINS], bool out[MODES_STRAINS])
{
    memcpy(out, is_still, MODES_STRAINS * sizeof *out);
    for (int a = 0; a < m->end.first && m->end.count > 0; a++) {
        out[m->mode[a].strain] = false;
    }
    for (int plane = 0; plane < 2; plane++) { /* bent about d2, about d1 */
        const int of[3] = {MODES_U + plane, MODES_V + 1 - plane, MODES_U + 2};
        for (int k = 0; k < 3 && is_still[of[0]] && is_still[of[1]] && is_still[of[2]]; k++) {
            out[of[k]] = true;
        }
    }
}

/* More modes of strains whose last two move the rod by more than a share of the tolerance, one of
 * others; none of what stays 0, or so near that it counts for nothing beside the tolerance. False:
 * there are no more. */
static bool add_modes(const modes_solution *solution, double tolerance, modes_counts *counts)
{
    const modes *m = solution->m;
    const bool is_held = m->end.count > 0; /* by which small strains may matter, too */
    const double share = 0.2, nothing = fmax(1e-13, is_held ? 0 : 1e-2 * tolerance);
    double size[MODES_STRAINS] = {0}, tail[MODES_STRAINS] = {0};
    bool is_still[MODES_STRAINS], out[MODES_STRAINS], more = false;
    for (size_t i = 0; i < solution->times.count; i++) {
        for (int a = solution->times.aside[i] ? m->end.first : m->hinges; a < m->end.first; a++) {
            if (a == m->feed.mode) {
                continue;
            }
            const modes_mode *mode = &m->mode[a];
            const int c = mode->strain, k = mode->degree + 1;
            const double q = fabs(solution->states[i * STATES * (size_t)m->size + (size_t)a]);
            size[c] = fmax(size[c], q);
            if (k + 1 >= counts->of[c]) { /* a curvature is integrated twice */
                tail[c] = fmax(tail[c], q / (c >= MODES_U ? k * k : k));
            }
        }
    }
    for (int c = 0; c < MODES_STRAINS; c++) {
        is_still[c] = size[c] <= nothing;
    }
    leave_out(m, is_still, out);
    for (int c = 0; c < MODES_STRAINS; c++) {
        int *n = &counts->of[c], before = *n;
        *n += tail[c] > share * tolerance ? (*n > 6 ? *n / 3 : 2) : 1;
        *n = out[c] ? 0 : *n > SOLVE_MODES_MAX ? SOLVE_MODES_MAX : *n;
        more |= *n > before;
    }
    return more;
}

static void take_report(const refined *at, solve_report *report)
{
    const modes_solution *solution = at->best;
    motion_times_energies(&solution->times, solution->all, solution->energies, report);
    report->nodes = solution->m->points - solution->m->hinges * (solution->m->stages + 1);
    report->time = 1;
    report->mode_count = solution->m->end.first;
    for (int a = 0; a < solution->m->end.first; a++) { /* a locked strain has none */
        const int c = solution->m->mode[a].strain;
        report->modes[c] = solution->m->counts.of[c];
    }
}

static ad_status refine(refined *at, const solve_settings *settings, solve_report *report,
                        ad_error *error)
{
    enum { SOLUTIONS_MAX = 10, FINER = 2 };
    const int *given = settings->modes;
    const bool is_given = given[0] + given[1] + given[2] + given[3] > 0;
    modes_counts counts = is_given ? modes_counts_of(given[0], given[1], given[2], given[3])
                                   : modes_counts_of(3, 2, 2, 2);
    double distance[2] = {INFINITY, INFINITY}; /* of the last two, and of those before */
    double tolerance = (is_given ? 1 : 10) * settings->tolerance;
    ad_status status = AD_OK;
    for (int i = 0; i < SOLUTIONS_MAX && status == AD_OK; i++) {
        const double before = at->work;
        status =
            solve_once(at, settings, &counts, FINER * (is_given ? 2 : i), tolerance, report, error);
        if (status != AD_OK || is_given) {
            break;
        }
        if (i > 0) {
            const motion_apart apart =
                motion_compare(at->best->times.fixed, at->seen[0], at->seen[1]);
            distance[0] = distance[1];
            distance[1] = apart.l2;
            const double left = motion_left_over(2, distance);
            report->estimate_l2 = left * apart.l2;
            report->estimate = left * apart.most;
            if (report->estimate_l2 <= settings->tolerance &&
                report->estimate <= SOLVE_PEAK * settings->tolerance) {
                break;
            }
        }
        tolerance = fmax(tolerance / 10, 0.1 * settings->tolerance);
        modes_counts next = counts;
        const bool more = add_modes(at->best, settings->tolerance, &next);
        counts = more ? next : counts; /* of a rod at rest the same tell that it is */
        if ((!more && i > 0) || at->work + 4 * (at->work - before) > WORK_MOST) {
            break;
        }
    }
    if (status == AD_NOT_FINITE && at->best && !at->is_stuck) { /* the last that came to an end */
        status = AD_OK;
    }
    return status;
}

ad_status modes_motion_solve(solve_rod *rod, const solve_settings *settings, size_t count,
                             const double *times, modes_solution **result, solve_report *report,
                             ad_error *error)
{
    refined at = {.rod = rod, .given = count, .times = times};
    *result = NULL;
    *report = solve_report_blank();
    ad_status status = solve_events_create(rod, &at.events, error);
    report->unresolved = status == AD_OK ? at.events->drives->unresolved : NULL;
    status = status == AD_OK ? refine(&at, settings, report, error) : status;
    solve_events_free(at.events);
    free(at.seen[0]);
    free(at.seen[1]);
    if (status != AD_OK) {
        modes_motion_free(at.best);
        return status;
    }
    take_report(&at, report);
    *result = at.best;
    return AD_OK;
}
