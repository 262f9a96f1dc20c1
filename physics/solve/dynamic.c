#include "physics/solve/dynamic.h"

#include "physics/numerics/quaternion.h"
#include "physics/solve/motion_mesh.h"
#include "physics/solve/motion_times.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

/* Intervals between nodes: each mesh has half as many again as the one before. Solutions are
 * compared at so many points and times, which have nothing to do with the times given. */
enum { COARSEST = 12, FINEST = 2048, COMPARED = MOTION_COMPARED, FIXED_TIMES = MOTION_FIXED_TIMES };

struct dynamic_solution {
    motion *motion;
    motion_times times;
    motion_record at;       /* these times */
    solve_energy *energies; /* [given] */
};

/* What refining has reached. */
typedef struct refined {
    const solve_rod *rod;
    solve_quadrature *places;
    solve_events *events;
    double lock, of_loads; /* what meshes may miss of them */
    size_t count;
    const double *given; /* [count] times */
    int intervals;
    motion_steps by;
    dynamic_solution *best;
    solve_state
        *seen[3]; /* [FIXED_TIMES][COMPARED] of the last solutions, the best first; NULL: none */
    motion_apart distance; /* between the last two */
    double total;          /* work of all */
} refined;

/* ---- a solution on one mesh ---------------------------------------------------------------- */

void dynamic_free(dynamic_solution *solution)
{
    if (solution) {
        motion_free(solution->motion);
        motion_times_free(&solution->times);
        free(solution->at.states);
        free(solution->at.energies);
        free(solution->energies);
        free(solution);
    }
}

const solve_energy *dynamic_energies(const dynamic_solution *solution)
{
    return solution->energies;
}

static ad_status at_time(const dynamic_solution *solution, size_t which, size_t n, const double *s,
                         solve_state *out, ad_error *error)
{
    const double *state = solution->at.states + which * motion_size(solution->motion);
    ad_status status = motion_at(solution->motion, solution->at.times[which], error);
    if (status == AD_OK) {
        motion_samples(solution->motion, state, n, s, out);
    }
    return status;
}

ad_status dynamic_at(const dynamic_solution *solution, size_t which, size_t n, const double *s,
                     solve_state *out, ad_error *error)
{
    return at_time(solution, solution->times.which[which], n, s, out, error);
}

/* A locked strain is a stiff one, which implicit steps stand: forces of some EI/L^2 stretch it by a
 * hundredth of the tolerance, larger ones by more; stiffer ones ring faster, and that takes more
 * steps. Beyond the largest, rounding costs more than stiffness gains. */
static double lock_for(double tolerance)
{
    return fmin(100 / tolerance, 1e10);
}

/* Memory for a solution on a mesh of at least so many intervals. */
static ad_status create(const refined *at, dynamic_solution **result, ad_error *error)
{
    dynamic_solution *solution = calloc(1, sizeof *solution);
    if (!solution) {
        return ad_fail(error, AD_NO_MEMORY, "out of memory for a motion");
    }
    ad_status status = motion_mesh(at->rod, at->places, at->lock, at->of_loads, at->intervals,
                                   &solution->motion, error);
    status = status == AD_OK ? motion_times_create(at->count, at->given, &solution->times, error)
                             : status;
    if (status == AD_OK) {
        size_t count = solution->times.count;
        solution->energies = malloc((at->count + 1) * sizeof *solution->energies);
        solution->at = (motion_record){
            .count = count,
            .times = solution->times.all,
            .states = malloc(count * motion_size(solution->motion) * sizeof(double)),
            .energies = malloc(count * sizeof *solution->at.energies)};
        if (!solution->energies || !solution->at.states || !solution->at.energies) {
            status = ad_fail(error, AD_NO_MEMORY, "out of memory for %zu times", count);
        }
    }
    if (status != AD_OK) {
        dynamic_free(solution);
        return status;
    }
    *result = solution;
    return AD_OK;
}

/* ---- refining ------------------------------------------------------------------------------ */

/* What all solutions together may cost, in forces on one node: some 40 s; and where distances tell
 * that the tolerance will be met by then, some two minutes. */
static const double WORK_MOST = 1e9, WORK_TO_MEET = 4e9;

static const motion_apart NOTHING = {0, 0}, UNKNOWN = {INFINITY, INFINITY};

static bool is_within(motion_apart error, double tolerance)
{
    return error.l2 <= tolerance && error.most <= SOLVE_PEAK * tolerance;
}

/* Whether a solution that costs so many times the last one is allowed. */
static bool affords(const refined *at, double times)
{
    return at->total + times * at->by.work <= WORK_MOST;
}

/* Of two states: of positions, and of rotations what their angle moves over a tenth of the rod. */
static double apart_at(const solve_state *a, const solve_state *b)
{
    const double *p = a->position, *q = b->position, lever = 0.1;
    double turn[4];
    quaternion_quotient(a->rotation, b->rotation, turn);
    double angle = 2 * atan2(sqrt(vector_dot(turn + 1, turn + 1)), fabs(turn[0]));
    return hypot(hypot(hypot(p[0] - q[0], p[1] - q[1]), p[2] - q[2]), lever * angle);
}

/* Of what is seen of two solutions at `count` times. L2 is relative to positions as they are seen
 * from where the rod starts, so that it does not depend on where that is. */
motion_apart motion_compare(size_t count, const solve_state *state, const solve_state *y)
{
    double most = 0, off = 0, size = 0;
    for (size_t i = 0; i < count * COMPARED; i++) {
        const double *p = state[i].position, *start = state[i - i % COMPARED].position;
        const double r[3] = {p[0] - start[0], p[1] - start[1], p[2] - start[2]};
        double here = apart_at(&state[i], &y[i]);
        most = fmax(most, here);
        off += here * here;
        size += vector_dot(r, r);
    }
    return (motion_apart){off > 0 ? sqrt(off / size) : 0, most};
}

/* Look at the best solution, and forget the third last. */
static ad_status look(refined *at, ad_error *error)
{
    const dynamic_solution *solution = at->best;
    double s[COMPARED];
    ad_status status = AD_OK;
    for (int i = 0; i < COMPARED; i++) {
        s[i] = (double)i / (COMPARED - 1);
    }
    solve_state *all =
        at->seen[2] ? at->seen[2] : malloc((size_t)FIXED_TIMES * COMPARED * sizeof *all);
    at->seen[2] = at->seen[1];
    at->seen[1] = at->seen[0];
    at->seen[0] = all;
    if (!all) {
        return ad_fail(error, AD_NO_MEMORY, "out of memory for %d times", FIXED_TIMES);
    }
    for (size_t which = 0; which < solution->at.count && status == AD_OK; which++) {
        if (!solution->times.aside[which]) {
            status = at_time(solution, which, COMPARED, s, all, error);
            all += COMPARED;
        }
    }
    return status;
}

/* Through time, again with more instants where steps have not met what drives the rod, however well
 * they agree with one another. */
static ad_status go(refined *at, dynamic_solution *solution, solve_report *report, ad_error *error)
{
    const int rounds = 6;
    const char *key = NULL;
    size_t missed = 1;
    ad_status status = AD_OK;
    for (int i = 0; i < rounds && missed > 0 && status == AD_OK; i++) {
        status = motion_go(solution->motion, &at->by, &solution->at, report, error);
        at->total += at->by.work;
        if (status == AD_OK) {
            status = solve_events_meet(at->events, &at->by.clock, &missed, &key, error);
        }
        if (!affords(at, 1)) {
            break;
        }
    }
    report->unresolved = status == AD_OK && missed > 0 ? key : report->unresolved;
    return status;
}

static ad_status solve_once(refined *at, dynamic_solution **result, solve_report *report,
                            ad_error *error)
{
    dynamic_solution *solution = NULL;
    solve_report of_this = *report;
    *result = NULL;
    ad_status status = create(at, &solution, error);
    if (status != AD_OK) {
        return status;
    }
    status = go(at, solution, &of_this, error);
    of_this.nodes = (int)motion_nodes(solution->motion);
    if (status != AD_OK) {
        report->time = at->best ? report->time : of_this.time;
        dynamic_free(solution);
        return status;
    }
    motion_times_energies(&solution->times, solution->at.energies, solution->energies, &of_this);
    *report = of_this;
    *result = solution;
    return AD_OK;
}

/* Replace the best by a solution on the mesh and with the steps at hand. One that comes to nothing
 * leaves the best, and *failed. */
static ad_status solve_again(refined *at, solve_report *report, bool *failed, ad_error *error)
{
    dynamic_solution *next = NULL;
    ad_status status = solve_once(at, &next, report, error);
    *failed = status == AD_NOT_FINITE;
    if (status == AD_OK) {
        dynamic_free(at->best);
        at->best = next;
        status = look(at, error);
    }
    if (status == AD_OK) {
        at->distance = motion_compare(at->best->times.fixed, at->seen[0], at->seen[1]);
    }
    return *failed ? AD_OK : status;
}

/* Steps of time alone, where meshes are coarse and steps cheap: steps of two meshes differ, and
 * their errors would pass for errors of the mesh. What two tolerances of steps differ by is the
 * error of the larger, so that it will do for all meshes. *by_time: what it leaves. Nor may steps
 * damp so many waves that the energy is out of balance. Steps that are composed of flows shorten
 * with the mesh; nothing is to be done. */
static ad_status refine_time(refined *at, double tolerance, solve_report *report,
                             motion_apart *by_time, ad_error *error)
{
    /* Of time steps: rounding is not far, and nearer where it is multiplied by large stiffness. */
    const double finest = scene_locks_somewhere(&at->rod->scene) ? 1e-8 : 1e-12, of_time = 0.25;
    double *steps = &at->by.tolerance;
    bool failed = false, is_met = at->by.is_composed;
    ad_status status = AD_OK;
    *by_time = at->by.is_composed ? NOTHING : UNKNOWN;
    while (status == AD_OK && !is_met && *steps > finest && affords(at, 2)) {
        const double before = *steps;
        const bool balances = solve_energy_is_met(report);
        *steps = fmax(before / 10, finest);
        status = solve_again(at, report, &failed, error);
        if (failed) {
            *steps = before;
            break;
        }
        *by_time = at->by.is_composed ? NOTHING : at->distance;
        bool suffice = is_within(at->distance, of_time * tolerance);
        *steps = suffice && balances ? before : *steps;
        is_met = at->by.is_composed || (suffice && solve_energy_is_met(report));
    }
    return status;
}

/* What locks give way by, as far as it moves the rod: by a solution whose locks are softer by a
 * factor, on the mesh and with the steps at hand, and the last one of all. Errors that fall with
 * the stiffness are a third of what both differ by, those of locks that ring, with its root, all of
 * it. */
static ad_status find_give(refined *at, const solve_report *report, motion_apart *give,
                           ad_error *error)
{
    const double softer = 4, share = 0.5;
    *give = NOTHING;
    if (!scene_locks_somewhere(&at->rod->scene)) {
        return AD_OK;
    }
    dynamic_solution *kept = at->best;
    solve_report unused = *report;
    at->lock /= softer;
    ad_status status = solve_once(at, &at->best, &unused, error);
    status = status == AD_OK ? look(at, error) : status;
    if (status == AD_OK) {
        *give = motion_compare(kept->times.fixed, at->seen[1], at->seen[0]);
        give->l2 *= share;
        give->most *= share;
    }
    dynamic_free(at->best);
    at->best = kept;
    if (status == AD_NOT_FINITE) {
        *give = UNKNOWN;
        return AD_OK;
    }
    return status;
}

double motion_left_over(int count, const double *distance)
{
    const double largest = 0.8; /* ratio: distances of rough motions scatter */
    if (count < 2) {
        return 1;
    }
    int back = count > 2 ? 2 : 1;
    double ratio = fmin(pow(distance[count - 1] / distance[count - 1 - back], 1.0 / back), largest);
    return fmax(1, ratio / (1 - ratio));
}

/* The same of the last three solutions where their errors e are at right angles, as those of waves
 * that meshes get the phases of wrong are: e_1^2 + e_2^2 = before^2, e_2^2 + e_3^2 = distance^2,
 * e_1^2 + e_3^2 = over^2. What they leave is then less than the distance. INFINITY: they are not;
 * the last two distances do not point apart. */
static double left_over_at_right_angles(const refined *at)
{
    const double safe = 1.5, least = 0.5;
    double first = motion_compare(at->best->times.fixed, at->seen[1], at->seen[2]).l2;
    double over = motion_compare(at->best->times.fixed, at->seen[0], at->seen[2]).l2;
    double last = at->distance.l2 * at->distance.l2, before = first * first;
    double of_last = last + over * over - before; /* 2 e_3^2 */
    bool points_apart = over * over < before + last;
    if (!(first > at->distance.l2) || !points_apart) {
        return INFINITY;
    }
    return fmin(1, fmax(least, safe * sqrt(fmax(0, of_last) / (2 * last))));
}

/* Whether to go on to the next mesh, after distances [count] in L2: it costs so many times the last
 * one, half as many nodes and steps again of each. */
static bool goes_on(const refined *at, double tolerance, double estimate, int count,
                    const double *distance)
{
    const double dearer = 3, slowest = 0.8;
    double work = at->by.work, total = at->total, ratio;
    if (at->intervals >= FINEST) {
        return false;
    }
    if (count < 3 || affords(at, dearer)) {
        return count == 0 || affords(at, dearer);
    }
    ratio = fmin(sqrt(distance[count - 1] / distance[count - 3]), slowest);
    while (estimate > tolerance && total <= WORK_TO_MEET) {
        work *= dearer;
        total += work;
        estimate *= ratio;
    }
    return total <= WORK_TO_MEET;
}

static motion_apart sum_of(motion_apart a, motion_apart b)
{
    return (motion_apart){a.l2 + b.l2, a.most + b.most};
}

/* Half as many again: of what there are, where places ask for many more than were asked for. */
static int finer(const refined *at)
{
    int present = (int)motion_nodes(at->best->motion) - 1;
    int from = present > at->intervals + at->intervals / 4 ? present : at->intervals;
    return from + from / 2;
}

/* Meshes; FINEST is reached after 13. */
static ad_status refine_mesh(refined *at, double tolerance, motion_apart by_time,
                             solve_report *report, ad_error *error)
{
    enum { MESHES_MAX = 16 };
    const double of_first = 0.5; /* of the tolerance: how fast distances fall is not known yet */
    double l2[MESHES_MAX], most[MESHES_MAX];
    motion_apart estimate = UNKNOWN;
    bool failed = false, is_met = false;
    ad_status status = AD_OK;
    for (int i = 0; i < MESHES_MAX && status == AD_OK && !is_met; i++) {
        if (!goes_on(at, tolerance, by_time.l2 + estimate.l2, i, l2)) {
            break;
        }
        const int before = at->intervals;
        at->intervals = finer(at);
        status = solve_again(at, report, &failed, error);
        if (failed) {
            at->intervals = before;
            break;
        }
        l2[i] = at->distance.l2;
        most[i] = at->distance.most;
        bool waves = i > 0 && at->by.is_composed;
        double share = waves ? left_over_at_right_angles(at) : INFINITY;
        estimate.l2 = at->distance.l2 * fmin(share, motion_left_over(i + 1, l2));
        estimate.most = at->distance.most * fmin(share, motion_left_over(i + 1, most));
        is_met = i == 0 ? is_within(estimate, of_first * tolerance)
                        : is_within(sum_of(by_time, estimate), tolerance);
    }
    report->estimate = by_time.most + estimate.most;
    report->estimate_l2 = by_time.l2 + estimate.l2;
    return status;
}

/* On a mesh that is given only steps of time are refined, where they do not look after their own
 * error. */
static ad_status shorten(refined *at, double tolerance, solve_report *report, ad_error *error)
{
    bool failed = false;
    ad_status status = AD_OK;
    at->distance = UNKNOWN;
    while (status == AD_OK && !failed && at->by.is_composed &&
           !is_within(at->distance, tolerance) && affords(at, 2)) {
        at->by.shortened *= 2;
        status = solve_again(at, report, &failed, error);
    }
    return status;
}

static ad_status solve_refined(refined *at, const solve_settings *settings, solve_report *report,
                               ad_error *error)
{
    motion_apart by_time = NOTHING;
    ad_status status = motion_places_of(at->rod, &at->places, error);
    status = status == AD_OK ? solve_events_create(at->rod, &at->events, error) : status;
    at->by.events = at->events;
    if (status == AD_OK) {
        const char *of_t = at->events->drives->unresolved;
        report->unresolved = at->places->unresolved ? at->places->unresolved : of_t;
    }
    status = status == AD_OK ? solve_once(at, &at->best, report, error) : status;
    status = status == AD_OK ? look(at, error) : status;
    if (status != AD_OK || settings->nodes > 0) {
        return status == AD_OK ? shorten(at, settings->tolerance, report, error) : status;
    }
    motion_apart give = NOTHING;
    status = refine_time(at, settings->tolerance, report, &by_time, error);
    status =
        status == AD_OK ? refine_mesh(at, settings->tolerance, by_time, report, error) : status;
    status = status == AD_OK ? find_give(at, report, &give, error) : status;
    report->estimate += give.most;
    report->estimate_l2 += give.l2;
    return status;
}

ad_status dynamic_solve(const solve_rod *rod, const solve_settings *settings, size_t count,
                        const double *times, dynamic_solution **result, solve_report *report,
                        ad_error *error)
{
    *result = NULL;
    *report = solve_report_blank();
    for (size_t i = 0; i < count; i++) {
        if (!(times[i] >= (i > 0 ? times[i - 1] : 0) && times[i] <= rod->duration)) {
            return ad_fail(error, AD_BAD_ARGUMENT,
                           "time %zu is %g; allowed: ascending, from 0 to %g", i, times[i],
                           rod->duration);
        }
    }
    bool is_given = settings->nodes > 0;
    int intervals = settings->nodes > 2 ? settings->nodes - 1 : 2;
    refined at = {.rod = rod,
                  .lock = lock_for(settings->tolerance),
                  .of_loads = is_given ? INFINITY : 0.1 * settings->tolerance,
                  .count = count,
                  .given = times,
                  .intervals = is_given ? intervals : COARSEST,
                  .by = {.tolerance = (is_given ? 1 : 10) * settings->tolerance, .shortened = 1}};
    ad_status status = solve_refined(&at, settings, report, error);
    solve_quadrature_free(at.places);
    solve_events_free(at.events);
    free(at.by.clock.ends);
    for (size_t i = 0; i < sizeof at.seen / sizeof *at.seen; i++) {
        free(at.seen[i]);
    }
    if (status != AD_OK) {
        dynamic_free(at.best);
        return status;
    }
    *result = at.best;
    return AD_OK;
}
