/* Motions that are looked for, replayed and asked. */
#include "tools/optimize/motion_parts.h"

#include "physics/numerics/clock.h"
#include "physics/numerics/quaternion.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

enum { STARTS = 3, PARTS = 4 };

/* Shares of the duration of the scene with which the search begins. */
static const double FIRST[STARTS] = {0.5, 1, 0.25};

/* Of the equations, of what states vary by. */
static const double KEPT = 1e-6;

/* ---- replaying ----------------------------------------------------------------------------- */

/* What is bounded, at a part of an interval; beyond [bounds]: the furthest so far. */
static ad_status look(const optimize_motion *o, motion_rod *rod, size_t k, double part,
                      const double *state, double *values, double *beyond, ad_error *error)
{
    double inputs[SCENE_PARAMETERS_MAX], rates[SCENE_PARAMETERS_MAX];
    motion_inputs_at(o, o->x, k, part, inputs, rates);
    const ad_status status =
        rod->rows > 0 ? motion_rod_look(rod, state, inputs, rates, values, NULL, error) : AD_OK;
    for (int i = 0; i < rod->bounds && status == AD_OK; i++) {
        for (size_t r = 0; r < rod->bound[i].rows; r++) {
            beyond[i] = fmax(beyond[i], motion_bound_excess(&rod->bound[i], *values++));
        }
    }
    return status;
}

/* Steps of Radau's method with these inputs, from rest to rest of a rod with such modes; what is
 * bounded is looked at after each, at four times the points. */
static ad_status replay(const optimize_motion *o, const int *modes, optimize_replay *found,
                        double *way, ad_error *error)
{
    motion_rod *rod = NULL;
    double inputs[SCENE_PARAMETERS_MAX], after[SCENE_PARAMETERS_MAX];
    reduced_place place[2], now;
    char key[OPTIMIZE_KEY_MAX];
    const size_t points = PARTS * ((size_t)o->settings->points - 1) + 1;
    ad_status status =
        motion_rod_create(o->settings, o->family, o->around, modes, points, &rod, key, error);
    const size_t n = status == AD_OK ? (size_t)rod->states : 0;
    double *state = calloc(2 * n + 1 + (rod ? rod->rows : 0), sizeof *state);
    double *at_rest = state + n, *values = at_rest + n;
    if (status == AD_OK && !state) {
        status = ad_fail(error, AD_NO_MEMORY, "out of memory for a motion");
    }
    status = status == AD_OK ? motion_rest(o, rod->rod, 0, state, error) : status;
    for (int end = 0; end < 2 && status == AD_OK; end++) {
        if (end == 0) {
            memcpy(at_rest, state, n * sizeof *state);
        } else {
            status = motion_rest(o, rod->rod, 1, at_rest, error);
        }
        status = status == AD_OK ? motion_rod_tip(rod, at_rest, o->given[end], &place[end], error)
                                 : status;
    }
    const double h = motion_duration(o, o->x) / (double)(o->intervals * PARTS);
    for (size_t k = 0; k < o->intervals * PARTS && status == AD_OK; k++) {
        const double part = (double)(k % PARTS) / PARTS;
        motion_inputs_at(o, o->x, k / PARTS, part, inputs, NULL);
        motion_inputs_at(o, o->x, k / PARTS, part + 1. / PARTS, after, NULL);
        status =
            reduced_step_linear(rod->rod, 0, h, state, inputs, after, state, NULL, NULL, error);
        status = status == AD_OK ? look(o, rod, k / PARTS, part + 1. / PARTS, state, values,
                                        found->beyond, error)
                                 : status;
    }
    status = status == AD_OK ? motion_rod_tip(rod, state, o->given[1], &now, error) : status;
    if (status == AD_OK) {
        found->off = vector_distance(now.position, place[1].position);
        found->speed = sqrt(vector_dot(now.velocity, now.velocity));
        *way = vector_distance(place[0].position, place[1].position);
    }
    free(state);
    motion_rod_free(rod);
    return status;
}

static bool is_quickest(const optimize_motion *o)
{
    return o->settings->motion.minimize == OPTIMIZE_TIME;
}

static double violation(const optimize_motion *o)
{
    const double *low = o->limits + 2 * o->n, *high = low + o->m;
    double worst = 0;
    for (size_t i = 0; i < o->m; i++) {
        worst = fmax(worst, fmax(low[i] - o->row[i], o->row[i] - high[i]));
    }
    return worst;
}

/* ---- error --------------------------------------------------------------------------------- */

/* Begins with what another with half of the intervals has ended with: by the parabola through its
 * points. */
static void guess_from(optimize_motion *fine, const optimize_motion *o)
{
    double weight[GAUSS_STAGES_MAX], inputs[SCENE_PARAMETERS_MAX];
    const size_t n = o->states;
    for (size_t k = 0; k < fine->intervals; k++) {
        double *x = fine->x + k * fine->width;
        const double *from = o->x + k / 2 * o->width;
        for (size_t j = 0; j < MOTION_STAGES; j++) {
            gauss_lagrange(&o->rule, ((double)(k % 2) + o->rule.nodes[j]) / 2, weight);
            for (size_t c = 0; c < n; c++) {
                x[j * n + c] = 0;
                for (size_t i = 0; i < MOTION_STAGES; i++) {
                    x[j * n + c] += weight[i] * from[i * n + c];
                }
            }
        }
        motion_inputs_at(o, o->x, k / 2, (double)(k % 2 + 1) / 2, inputs, NULL);
        for (size_t l = 0; l < o->inputs; l++) {
            x[MOTION_STAGES * n + l] = motion_share_of(o, l, inputs[l]);
        }
    }
    if (is_quickest(o)) {
        fine->x[fine->n - 1] = o->x[o->n - 1];
    }
}

/* States are at rest at the end up to so much of what they vary by, one after the other: equalities
 * of what no input moves would depend on each other, and what is narrow from the first on keeps the
 * search from going anywhere. */
static const double REST[] = {1e-3, 1e-5, 1e-7};
enum { RESTS = sizeof REST / sizeof *REST };

static ad_status descend(optimize_motion *o, int first, int *steps, bool *converged,
                         ad_error *error)
{
    const descent d = optimize_motion_problem(o);
    ad_status status = AD_OK;
    *steps = 0;
    *converged = true;
    for (int i = first; i < RESTS && status == AD_OK && *converged; i++) {
        int more = 0;
        motion_rest_within(o, REST[i]);
        status = optimize_descent(&d, &more, converged, error);
        *steps += more;
    }
    return status;
}

/* Where inputs may change twice as often the objective is better by at least half of the error: at
 * most a half is left of what a switch at a share p of an interval costs, which goes as
 * p (1 - p) h^2, and a quarter of what goes as h^2. So the error is at most twice the difference.
 */
static ad_status find_error(const optimize_motion *o, optimize_motion_report *report,
                            ad_error *error)
{
    optimize_settings settings = *o->settings;
    optimize_motion *fine = NULL;
    char key[OPTIMIZE_KEY_MAX];
    int steps = 0;
    bool converged = false;
    settings.motion.intervals *= 2;
    ad_status status = optimize_motion_create(&settings, o->family, o->around, &fine, key, error);
    if (status == AD_OK) {
        guess_from(fine, o);
        status = descend(fine, 1, &steps, &converged, error);
    }
    report->steps += steps;
    if (status == AD_OK && converged && motion_evaluate(fine, fine->x) && violation(fine) <= KEPT) {
        report->error = is_quickest(o) ? 2 * fabs(motion_duration(fine, fine->x) - report->duration)
                                       : 2 * fabs(motion_effort(fine, fine->x) - report->effort);
    }
    optimize_motion_free(fine);
    return status;
}

/* ---- running ------------------------------------------------------------------------------- */

ad_status optimize_motion_run(optimize_motion *o, optimize_motion_report *report, ad_error *error)
{
    const double begin = clock_seconds(CLOCK_MONOTONIC);
    const int *given = o->settings->motion.modes;
    const int finer[4] = {given[0] + 2, given[1] + 1, given[2] > 2 ? given[2] + 1 : 2,
                          given[3] > 1 ? given[3] + 1 : 1};
    ad_status status = AD_OK;
    *report = (optimize_motion_report){
        .violation = INFINITY, .error = INFINITY, .bounds = o->rod->bounds};
    memcpy(report->modes, finer, sizeof finer);
    for (int i = 0; i < report->bounds; i++) {
        report->spread[i] = 1 / o->rod->bound[i].scale;
    }
    for (int i = 0; i < (is_quickest(o) ? STARTS : 1) && !report->found && status == AD_OK; i++) {
        int steps = 0;
        bool converged = false;
        motion_guess(o, FIRST[i]);
        o->why.status = AD_OK;
        status = descend(o, 0, &steps, &converged, error);
        report->violation = status == AD_OK && motion_evaluate(o, o->x) ? violation(o) : INFINITY;
        report->found = converged && report->violation <= KEPT;
        report->steps += steps;
        report->starts++;
    }
    report->duration = motion_duration(o, o->x);
    report->effort = motion_effort(o, o->x);
    if (report->found && status == AD_OK) {
        status = find_error(o, report, error);
        status = status == AD_OK ? replay(o, given, &report->same, &report->way, error) : status;
        status = status == AD_OK ? replay(o, finer, &report->finer, &report->way, error) : status;
    }
    report->seconds = clock_seconds(CLOCK_MONOTONIC) - begin;
    return status;
}

/* ---- asking -------------------------------------------------------------------------------- */

int optimize_motion_intervals(const optimize_motion *o)
{
    return (int)o->intervals;
}

int optimize_motion_inputs(const optimize_motion *o)
{
    return (int)o->inputs;
}

bool optimize_motion_is_linear(const optimize_motion *o)
{
    return o->linear;
}

ad_status optimize_motion_at(optimize_motion *o, int k, double *t, double *inputs, double tip[3],
                             ad_error *error)
{
    const size_t at = (size_t)k;
    reduced_place place;
    if (at < o->intervals) {
        motion_inputs_at(o, o->x, at, 0, inputs, NULL);
    } else {
        memcpy(inputs, o->given[1], o->inputs * sizeof *inputs);
    }
    for (size_t c = 0; c < o->states; c++) {
        o->state[c] = k > 0 ? o->scale[c] * motion_end_of(o, o->x, at - 1)[c] : o->from[c];
    }
    *t = motion_duration(o, o->x) * k / (double)o->intervals;
    const ad_status status = motion_rod_tip(o->rod, o->state, inputs, &place, error);
    if (status == AD_OK) {
        memcpy(tip, place.position, sizeof place.position);
    }
    return status;
}
