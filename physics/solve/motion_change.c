#include "physics/solve/motion_change.h"

#include "autodiff/memory.h"
#include "physics/chain/modes_internal.h"
#include "physics/chain/modes_step.h"
#include "physics/numerics/sort.h"
#include "physics/scene/breaks.h"
#include "physics/scene/scene_memory.h"
#include "physics/scene/support.h"
#include "physics/solve/dynamic.h"
#include "physics/solve/events.h"
#include "physics/solve/modes_motion.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

enum { STATES = MODES_MOTION_STATES, WIDTH = sizeof(solve_state) / sizeof(double) };

struct motion_change {
    scene family;
    scene_values names; /* its, of states of memory */
    solve_rod *rod;
    modes *m;
    size_t count;    /* times */
    double *times;   /* [count] ascending, s; */
    double *looked;  /* [count] of solve_events_before, s */
    double *values;  /* [parameters] */
    double *states;  /* [count][STATES][size] */
    double *changes; /* [count][moving][parameters] */
    double *state;   /* [STATES][size] as it goes, and */
    double *change;  /* [moving + parameters][parameters] how it changes: of q, v and branches */
    double *trial;   /* [STATES][size], and room [2][size] behind it */
    modes_linear room;
    size_t from_count;
    const solve_seen *from; /* [from_count] as solve_settings have it */
    ad_memory memory;
    long steps;
};

/* Numbers of a state that change. */
static size_t moving(const motion_change *x)
{
    return 2 * (size_t)x->m->size + (size_t)x->m->branch.count;
}

void motion_change_free(motion_change *x)
{
    if (x) {
        modes_free(x->m);
        solve_rod_free(x->rod);
        ad_memory_free(&x->memory);
        free(x);
    }
}

/* What is wanted; times in s. */
typedef struct asked {
    const scene *family;
    const double *parameters;
    const solve_settings *settings;
    scene_values names;
    size_t count, stop_count;
    double *times; /* [count] ascending, and of solve_events_before */
    double *looked;
    double *stops; /* [stop_count] ascending: instants that no step may pass */
} asked;

/* ---- what has no derivatives --------------------------------------------------------------- */

static ad_status refuse(ad_error *error, const char *what)
{
    return ad_fail(error, AD_BAD_ARGUMENT, "derivatives of a motion: not yet of %s", what);
}

/* Where a jump or a kink in time moves with a parameter, what it does to the motion is not the
 * derivative of a formula. */
static ad_status check_breaks(const scene *family, const double *parameters, ad_error *error)
{
    static const double PART = 1e-4;
    scene_breaks breaks;
    int moved_by = -1;
    const ad_status status =
        scene_breaks_moved(family, "t", parameters, PART, &breaks, &moved_by, error);
    if (status == AD_OK && breaks.unresolved) {
        return ad_fail(error, AD_BAD_ARGUMENT,
                       "%s jumps where that is not found: there are no derivatives by parameters",
                       breaks.unresolved);
    }
    return status == AD_OK && moved_by >= 0
               ? ad_fail(error, AD_BAD_ARGUMENT,
                         "the parameter %s moves an instant at which a formula jumps or has a "
                         "kink: there are no derivatives by it",
                         family->parameters[moved_by].name)
               : status;
}

static ad_status check(const scene *family, const solve_settings *settings, ad_error *error)
{
    scene middle;
    if (!scene_is_family(family) || !scene_is_dynamic(family) || scene_is_beam(family)) {
        return ad_fail(error, AD_BAD_ARGUMENT,
                       "derivatives of a motion: allowed: of a rod in motion whose parameters have "
                       "ranges");
    }
    scene_middle(family, &middle);
    const ad_status status = support_check(&middle, SUPPORT_MODES, NULL, error);
    return status != AD_OK ? status
           : family->memory_count > 0 && family->unknown_count > 0
               ? refuse(error, "plays and lags of parameters beside what is to be found")
           : settings->from_count > 0 && family->place.is_given
               ? refuse(error, "lengths and places from a given state on")
           : settings->from_count > 0 && scene_has_branch(family)
               ? refuse(error, "a Maxwell branch from a given state on")
               : AD_OK;
}

/* ---- one solution -------------------------------------------------------------------------- */

/* The values, with one parameter more by so much; -1: none. Parameters have been there for long. */
static void beside(const motion_change *x, int parameter, double by, double *values)
{
    memcpy(values, x->values, (size_t)x->m->inputs * sizeof *values);
    if (parameter >= 0) {
        values[parameter] += by;
    }
    scene_memory_start(&x->family, &x->names, values, 0, NULL);
}

/* t in units of the rod. */
static ad_status at(const motion_change *x, double t, int parameter, double by, ad_error *error)
{
    double values[SCENE_PARAMETERS_MAX];
    beside(x, parameter, by, values);
    return modes_at(x->m, t, values, error);
}

/* The state that the motion begins with. */
static ad_status begin(motion_change *x, int parameter, double by, double *state, ad_error *error)
{
    const size_t size = (size_t)x->m->size;
    double values[SCENE_PARAMETERS_MAX];
    beside(x, parameter, by, values);
    ad_status status = x->from_count > 0
                           ? modes_at(x->m, 0, values, error)
                           : modes_begin_open(x->m, &x->family, values, NULL, &x->room, error);
    if (status == AD_OK && x->from_count > 0) {
        status = modes_initial(x->m, x->room.q, x->room.v, error);
        status = status == AD_OK
                     ? modes_fit_seen(x->m, x->from_count, x->from, x->room.q, x->room.v, error)
                     : status;
    }
    memcpy(state, x->room.q, size * sizeof *state);
    memcpy(state + size, x->room.v, size * sizeof *state);
    memset(state + 2 * size, 0, size * sizeof *state);
    return status;
}

/* The start, and how it changes. */
static ad_status begin_change(motion_change *x, ad_error *error)
{
    const size_t size = (size_t)x->m->size, p = (size_t)x->m->inputs, rows = moving(x);
    ad_status status = AD_OK;
    memset(x->change, 0, (rows + p) * p * sizeof *x->change);
    for (size_t k = 0; k < p && status == AD_OK; k++) {
        double along[SCENE_PARAMETERS_MAX] = {0}, values[SCENE_PARAMETERS_MAX];
        beside(x, -1, 0, values);
        along[k] = 1;
        scene_memory_start(&x->family, &x->names, values, 1, along);
        for (size_t i = 0; i < p; i++) {
            x->change[(rows + i) * p + k] = along[i];
        }
        for (int side = -1; side <= 1 && status == AD_OK; side += 2) {
            status = begin(x, (int)k, side * x->m->input_step[k], x->trial, error);
            for (size_t i = 0; i < 2 * size && status == AD_OK; i++) {
                x->change[i * p + k] += side * x->trial[i] / (2 * x->m->input_step[k]);
            }
        }
    }
    return status == AD_OK ? begin(x, -1, 0, x->state, error) : status;
}

/* On to `end`. */
static ad_status go_on(motion_change *x, collocation *by, double *room, double *t, double end,
                       double tolerance, ad_error *error)
{
    const size_t size = (size_t)x->m->size;
    double *q = x->state, *v = q + size, *d = v + size;
    solve_energy unused = {0};
    ad_status status = AD_OK;
    while (*t < end && status == AD_OK) {
        const double from = *t;
        memcpy(x->trial, x->state, STATES * size * sizeof *x->trial);
        status = at(x, from, -1, 0, error);
        status = status == AD_OK ? collocation_next(by, t, end, tolerance, q, v, d, &unused, error)
                                 : status;
        status = status == AD_OK
                     ? collocation_along(by, from, *t - from, x->values, NULL,
                                         (collocation_ends){0, 0}, x->trial, x->trial + size,
                                         x->trial + 2 * size, x->m->inputs, room, x->change, error)
                     : status;
        x->steps++;
    }
    return status;
}

/* Through all times, with a stop at each and at each instant that no step may pass. */
static ad_status go(motion_change *x, const asked *of, double tolerance, ad_error *error)
{
    const size_t size = (size_t)x->m->size, p = (size_t)x->m->inputs, rows = moving(x);
    const double unit = x->rod->scales.time;
    collocation *by = NULL;
    double t = 0;
    size_t stop = 0;
    ad_status status = begin_change(x, error);
    status = status == AD_OK ? collocation_create(x->m, MODES_MOTION_STAGES, &by, error) : status;
    double *room =
        status == AD_OK ? malloc(collocation_along_room(by, 0, x->m->inputs) * sizeof *room) : NULL;
    if (status == AD_OK && !room) {
        status = ad_fail(error, AD_NO_MEMORY, "out of memory for derivatives of a step");
    }
    for (size_t i = 0; i < x->count && status == AD_OK; i++) {
        for (; stop < of->stop_count && of->stops[stop] < x->times[i] && status == AD_OK; stop++) {
            status = go_on(x, by, room, &t, of->stops[stop] / unit, tolerance, error);
        }
        status =
            status == AD_OK ? go_on(x, by, room, &t, x->times[i] / unit, tolerance, error) : status;
        memcpy(x->states + i * STATES * size, x->state, STATES * size * sizeof *x->state);
        memcpy(x->changes + i * rows * p, x->change, rows * p * sizeof *x->change);
    }
    free(room);
    collocation_free(by);
    return status;
}

static ad_status allocate(motion_change *x, ad_error *error)
{
    const size_t size = (size_t)x->m->size, p = (size_t)x->m->inputs;
    const size_t square = size * (size_t)x->m->width;
    AD_TAKE(x, states, x->count * STATES * size);
    AD_TAKE(x, changes, x->count * moving(x) * p);
    AD_TAKE(x, state, STATES * size);
    AD_TAKE(x, change, (moving(x) + p) * p);
    AD_TAKE(x, trial, (STATES + 2) * size);
    AD_TAKE(x, room.q, size);
    AD_TAKE(x, room.v, size);
    AD_TAKE(x, room.a, size);
    AD_TAKE(x, room.residual, size);
    AD_TAKE(x, room.by_q, square);
    AD_TAKE(x, room.by_v, square);
    AD_TAKE(x, room.factor, square);
    AD_TAKE(x, room.pivots, size);
    return ad_memory_status(&x->memory, error, "out of memory for derivatives of a motion");
}

static ad_status solve(const asked *of, const modes_counts *counts, double tolerance,
                       motion_change **result, ad_error *error)
{
    enum { FINER = 4 };
    const size_t p = (size_t)of->family->parameter_count;
    motion_change *x = *result = calloc(1, sizeof *x);
    if (!x) {
        return ad_fail(error, AD_NO_MEMORY, "out of memory for derivatives of a motion");
    }
    x->family = *of->family;
    x->names = of->names;
    for (size_t k = 0; k < p; k++) { /* sums over parameters hold within their ranges */
        scene_parameter *range = &x->family.parameters[k];
        range->low = fmin(range->low, of->parameters[k]);
        range->high = fmax(range->high, of->parameters[k]);
    }
    x->count = of->count;
    x->from = of->settings->from;
    x->from_count = of->settings->from_count;
    AD_TAKE(x, values, p);
    AD_TAKE(x, times, of->count);
    AD_TAKE(x, looked, of->count);
    ad_status status =
        ad_memory_status(&x->memory, error, "out of memory for derivatives of a motion");
    if (status == AD_OK) {
        memcpy(x->values, of->parameters, p * sizeof *x->values);
        memcpy(x->times, of->times, of->count * sizeof *x->times);
        memcpy(x->looked, of->looked, of->count * sizeof *x->looked);
        status =
            modes_create_open(&x->family, true, UINT64_MAX, counts, FINER, &x->rod, &x->m, error);
    }
    status = status == AD_OK ? allocate(x, error) : status;
    return status == AD_OK ? go(x, of, tolerance, error) : status;
}

/* ---- refining ------------------------------------------------------------------------------ */

/* Derivatives of positions [3][parameters][points]. */
static ad_status look(const motion_change *x, double *by, ad_error *error)
{
    const size_t points = x->count * MOTION_COMPARED;
    double *s = malloc(2 * points * sizeof *s), *t = s + points;
    if (!s) {
        return ad_fail(error, AD_NO_MEMORY, "out of memory for %zu points", points);
    }
    for (size_t i = 0; i < points; i++) {
        s[i] = x->rod->scales.length * (double)(i % MOTION_COMPARED) / (MOTION_COMPARED - 1);
        t[i] = x->times[i / MOTION_COMPARED];
    }
    const ad_status status = motion_change_evaluate(x, 3, points, s, t, by, error);
    free(s);
    return status;
}

/* The distance of derivatives over the latter, by the parameter for which that is the most, *worst.
 * Of one that hardly moves the rod it counts over what moves it by so little. */
static double compare(const motion_change *x, const double *by, const double *before, int *worst)
{
    const double hardly = 1e-6;
    const size_t p = (size_t)x->m->inputs, points = x->count * MOTION_COMPARED;
    double most = -1;
    for (size_t k = 0; k < p; k++) {
        const scene_parameter *of = &x->family.parameters[k];
        const double least = hardly * x->rod->scales.length / (of->high - of->low);
        double apart = 0, size = least * least * (double)points;
        for (size_t i = 0; i < 3 * points; i++) {
            const size_t j = (i / points * p + k) * points + i % points;
            apart += (by[j] - before[j]) * (by[j] - before[j]);
            size += by[j] * by[j];
        }
        if (!(sqrt(apart / size) <= most)) {
            most = sqrt(apart / size);
            *worst = (int)k;
        }
    }
    return most;
}

/* A parameter may move strains that the motion itself leaves as they are. */
static ad_status refine(const asked *of, const solve_settings *settings, motion_change **best,
                        motion_change_report *report, ad_error *error)
{
    enum { LEVELS = 5 };
    const int *given = settings->modes;
    const bool is_given = given[0] + given[1] + given[2] + given[3] > 0;
    const size_t numbers = 3 * (size_t)of->family->parameter_count * of->count * MOTION_COMPARED;
    int n[4] = {4, 3, 2, 2};
    double distance[2] = {INFINITY, INFINITY}; /* of the last two, and of those before */
    double tolerance = (is_given ? 1 : 10) * settings->tolerance;
    double *by = malloc(2 * numbers * sizeof *by), *before = by + numbers;
    ad_status status = by ? AD_OK : ad_fail(error, AD_NO_MEMORY, "out of memory for derivatives");
    for (int i = 0; i < LEVELS && status == AD_OK; i++) {
        const int *modes = is_given ? given : n;
        const modes_counts counts = modes_counts_of(modes[0], modes[1], modes[2], modes[3]);
        motion_change *next = NULL;
        status = solve(of, &counts, tolerance, &next, error);
        report->time_steps += next ? next->steps : 0;
        if (status != AD_OK) {
            motion_change_free(next);
            break;
        }
        motion_change_free(*best);
        *best = next;
        status = is_given ? AD_OK : look(next, by, error);
        if (i > 0 && status == AD_OK) {
            distance[0] = distance[1];
            distance[1] = compare(next, by, before, &report->worst);
            report->estimate = motion_left_over(2, distance) * distance[1];
        }
        if (is_given || report->estimate <= MOTION_CHANGE_OF_TOLERANCE * settings->tolerance) {
            break;
        }
        memcpy(before, by, numbers * sizeof *by);
        for (int k = 0; k < 4; k++) {
            const int more = n[k] + (n[k] > 4 ? n[k] / 2 : 2);
            n[k] = more < SOLVE_MODES_MAX ? more : SOLVE_MODES_MAX;
        }
        tolerance = settings->tolerance;
    }
    free(by);
    if (status == AD_NOT_FINITE && *best) { /* the last that came to an end */
        status = AD_OK;
    }
    return status;
}

/* Each once. */
static ad_status take_times(asked *of, size_t count, const double *times, ad_error *error)
{
    of->times = malloc(2 * (count + 1) * sizeof *of->times);
    if (!of->times) {
        return ad_fail(error, AD_NO_MEMORY, "out of memory for %zu times", count);
    }
    for (size_t i = 0; i < count; i++) {
        of->times[i] = fmin(scene_duration(of->family), fmax(0, times[i]));
    }
    of->count = sort_once(count, of->times);
    of->looked = of->times + of->count;
    return AD_OK;
}

/* Instants of the member that no step may pass. */
static ad_status find_stops(asked *of, ad_error *error)
{
    scene member;
    solve_rod *rod = NULL;
    solve_events *events = NULL;
    scene_member(of->family, of->parameters, &member);
    ad_status status = solve_rod_create(&member, &rod, error);
    status = status == AD_OK ? solve_events_create(rod, &events, error) : status;
    if (status == AD_OK) {
        of->stops = malloc((events->count + 1) * sizeof *of->stops);
        status = of->stops ? AD_OK : ad_fail(error, AD_NO_MEMORY, "out of memory for instants");
    }
    for (size_t i = 0; status == AD_OK && i < events->count; i++) {
        of->stops[of->stop_count++] = events->times[i] * rod->scales.time;
    }
    for (size_t i = 0; status == AD_OK && i < of->count; i++) {
        const double t = of->times[i] / rod->scales.time, before = solve_events_before(events, t);
        of->looked[i] = before < t ? before * rod->scales.time : of->times[i];
    }
    solve_events_free(events);
    solve_rod_free(rod);
    return status;
}

ad_status motion_change_create(const scene *family, const double *parameters,
                               const solve_settings *settings, size_t count, const double *times,
                               motion_change **result, motion_change_report *report,
                               ad_error *error)
{
    double values[SCENE_PARAMETERS_MAX];
    asked of = {.family = family, .parameters = values, .settings = settings};
    if (family->memory_count > 0) {
        of.names = scene_values_of(family);
    }
    *result = NULL;
    *report = (motion_change_report){.estimate = NAN};
    memcpy(values, parameters, (size_t)family->parameter_count * sizeof *values);
    scene_memory_start(family, &of.names, values, 0, NULL);
    ad_status status = check(family, settings, error);
    status = status == AD_OK ? check_breaks(family, values, error) : status;
    status = status == AD_OK ? take_times(&of, count, times, error) : status;
    status = status == AD_OK ? find_stops(&of, error) : status;
    status = status == AD_OK ? refine(&of, settings, result, report, error) : status;
    free(of.stops);
    free(of.times);
    if (status != AD_OK) {
        motion_change_free(*result);
        *result = NULL;
    }
    return status;
}

/* ---- values -------------------------------------------------------------------------------- */

static size_t nearest(const motion_change *x, double t)
{
    size_t found = 0;
    for (size_t i = 1; i < x->count; i++) {
        found = fabs(x->times[i] - t) < fabs(x->times[found] - t) ? i : found;
    }
    return found;
}

/* seen [2][places]: along the derivative by a parameter, to both sides. */
static ad_status see_beside(const motion_change *x, size_t which, size_t parameter,
                            const modes_places *places, solve_state *seen, ad_error *error)
{
    const size_t size = (size_t)x->m->size, p = (size_t)x->m->inputs;
    const double *state = x->states + which * STATES * size;
    const double *change = x->changes + which * moving(x) * p;
    ad_status status = AD_OK;
    for (size_t side = 0; side < 2 && status == AD_OK; side++) {
        const double by = side ? x->m->input_step[parameter] : -x->m->input_step[parameter];
        memcpy(x->trial, state, STATES * size * sizeof *state);
        for (size_t i = 0; i < moving(x); i++) {
            const size_t to = i < 2 * size ? i : 2 * size + (size_t)x->m->branch.mode[i - 2 * size];
            x->trial[to] += by * change[i * p + parameter];
        }
        status = at(x, x->looked[which] / x->rod->scales.time, (int)parameter, by, error);
        status = status == AD_OK ? modes_see(x->m, x->trial, x->trial + STATES * size, places,
                                             seen + side * places->count, error)
                                 : status;
    }
    return status;
}

/* Of states on both sides strains by metres as written; s in m. */
static void shrink(const motion_change *x, size_t which, size_t parameter, size_t count,
                   const double *s, solve_state *seen)
{
    for (size_t i = 0; i < 2 * count && x->family.rod.growth.is_given; i++) {
        double values[SCENE_PARAMETERS_MAX];
        const double by = x->m->input_step[parameter];
        beside(x, (int)parameter, i < count ? -by : by, values);
        const double growth = scene_growth_at(&x->family, values, s[i % count], x->times[which]);
        for (int k = 0; k < 3; k++) {
            seen[i].strain[k] /= growth;
            seen[i].curvature[k] /= growth;
        }
    }
}

/* Points of one time, from `first` on. */
static ad_status give(const motion_change *x, size_t which, const modes_places *places,
                      const double *s, solve_state *seen, int columns, size_t first, size_t points,
                      double *by, ad_error *error)
{
    const size_t p = (size_t)x->m->inputs;
    double units[WIDTH];
    solve_rod_units(x->rod, units);
    ad_status status = AD_OK;
    for (size_t k = 0; k < p && status == AD_OK; k++) {
        status = see_beside(x, which, k, places, seen, error);
        shrink(x, which, k, status == AD_OK ? places->count : 0, s + first, seen);
        for (size_t i = 0; i < places->count && status == AD_OK; i++) {
            const double *low = (const double *)&seen[i];
            const double *high = (const double *)&seen[places->count + i];
            for (size_t c = 0; c < (size_t)columns; c++) {
                by[(c * p + k) * points + first + i] =
                    (high[c] - low[c]) / (2 * x->m->input_step[k]) * units[c] + 0.0;
            }
        }
    }
    return status;
}

ad_status motion_change_evaluate(const motion_change *x, int columns, size_t points,
                                 const double *s, const double *t, double *by, ad_error *error)
{
    double *scaled = malloc(points * sizeof *scaled);
    solve_state *seen = malloc(2 * points * sizeof *seen);
    ad_status status = scaled && seen
                           ? AD_OK
                           : ad_fail(error, AD_NO_MEMORY, "out of memory for %zu points", points);
    for (size_t i = 0; i < points && status == AD_OK; i++) {
        scaled[i] = fmin(1, fmax(0, s[i] / x->rod->scales.length));
    }
    for (size_t first = 0, end; first < points && status == AD_OK; first = end) {
        modes_places *places = NULL;
        for (end = first; end < points && t[end] == t[first]; end++) {
        }
        status = modes_places_create(x->m, end - first, scaled + first, &places, error);
        status = status == AD_OK ? give(x, nearest(x, t[first]), places, s, seen, columns, first,
                                        points, by, error)
                                 : status;
        modes_places_free(places);
    }
    free(scaled);
    free(seen);
    return status;
}
