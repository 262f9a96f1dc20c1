#include "tools/optimize/motion.h"

#include "physics/chain/reduced.h"
#include "physics/numerics/gauss.h"
#include "physics/numerics/quaternion.h"
#include "tools/train/clock.h"

#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

enum { STAGES = 3, STARTS = 3, PARTS = 4 };

/* States are at rest at the end up to so much of what they vary by: equalities of what no input
 * moves would depend on each other. */
static const double AT_REST = 1e-7;

/* Shares of the duration of the scene with which the search begins. */
static const double FIRST[STARTS] = {0.5, 1, 0.25};

/* Of the equations, of what states vary by. */
static const double KEPT = 1e-6;

struct optimize_motion {
    const optimize_motion_settings *settings;
    const scene *family;
    reduced_rod *rod;
    gauss_rule rule;
    size_t states, inputs, intervals, width; /* the last: variables of an interval */
    double longest, tip;                     /* s; m along the rod */
    double *from, *to;                       /* [states] at rest */
    double *scale;                           /* [states] what they vary by */
    double given[2][SCENE_PARAMETERS_MAX];   /* inputs there */

    /* Variables: of each interval states at its points over their scales and the inputs as
     * fractions of their ranges, then the duration over the longest. */
    size_t n, m, nonzeros;
    double *x, *limits, *gradient, *row, *by, *multiplier;
    int *entries;
    double value;
    bool known, there;
    double *at;                         /* [n] where it was evaluated last */
    double *rate, *by_state, *by_input; /* of the points of an interval */
    double *state, *memory;             /* [states] */
    ad_error why;
};

void optimize_motion_free(optimize_motion *o)
{
    if (o) {
        double *const numbers[] = {o->x,  o->limits,     o->gradient, o->row,
                                   o->by, o->multiplier, o->memory};
        for (size_t i = 0; i < sizeof numbers / sizeof *numbers; i++) {
            free(numbers[i]);
        }
        free(o->entries);
        reduced_free(o->rod);
        free(o);
    }
}

static bool is_quickest(const optimize_motion *o)
{
    return o->settings->minimize == OPTIMIZE_TIME;
}

static double duration(const optimize_motion *o, const double *x)
{
    return is_quickest(o) ? x[o->n - 1] * o->longest : o->longest;
}

static double input_of(const optimize_motion *o, const double *x, size_t k, size_t i)
{
    const scene_parameter *of = reduced_input(o->rod, (int)i);
    return of->low + (of->high - of->low) * x[k * o->width + STAGES * o->states + i];
}

/* The scaled state at the end of an interval; -1: of the first one. */
static const double *end_of(const optimize_motion *o, const double *x, size_t k)
{
    return x + k * o->width + (STAGES - 1) * o->states;
}

/* ---- the problem --------------------------------------------------------------------------- */

static ad_status find_rates(optimize_motion *o, const double *x, size_t k)
{
    const size_t n = o->states;
    double inputs[SCENE_PARAMETERS_MAX];
    ad_status status = AD_OK;
    for (size_t i = 0; i < o->inputs; i++) {
        inputs[i] = input_of(o, x, k, i);
    }
    for (size_t j = 0; j < STAGES && status == AD_OK; j++) {
        for (size_t c = 0; c < n; c++) {
            o->state[c] = o->scale[c] * x[k * o->width + j * n + c];
        }
        status = reduced_rate(o->rod, 0, o->state, inputs, o->rate + j * n, o->by_state + j * n * n,
                              o->by_input + j * n * o->inputs, &o->why);
    }
    return status;
}

/* Rows of stage i: what the state is more than at the beginning, less the integral of its rate. */
static double *put_stage(optimize_motion *o, const double *x, size_t k, size_t i, double *by)
{
    const size_t n = o->states, m = o->inputs;
    const double h = duration(o, x) / (double)o->intervals;
    const double *a = o->rule.matrix[i];
    for (size_t r = 0; r < n; r++) {
        const double begin = k > 0 ? end_of(o, x, k - 1)[r] : o->from[r] / o->scale[r];
        double sum = 0;
        for (size_t j = 0; j < STAGES; j++) {
            sum += a[j] * o->rate[j * n + r] / o->scale[r];
        }
        o->row[(k * STAGES + i) * n + r] = x[k * o->width + i * n + r] - begin - h * sum;
        if (k > 0) {
            *by++ = -1;
        }
        for (size_t j = 0; j < STAGES; j++) {
            for (size_t c = 0; c < n; c++) {
                const double slope = o->by_state[(j * n + r) * n + c] * o->scale[c] / o->scale[r];
                *by++ = (j == i && c == r) - h * a[j] * slope;
            }
        }
        for (size_t l = 0; l < m; l++) {
            const scene_parameter *of = reduced_input(o->rod, (int)l);
            double slope = 0;
            for (size_t j = 0; j < STAGES; j++) {
                slope += a[j] * o->by_input[(j * n + r) * m + l];
            }
            *by++ = -h * slope * (of->high - of->low) / o->scale[r];
        }
        if (is_quickest(o)) {
            *by++ = -o->longest / (double)o->intervals * sum;
        }
    }
    return by;
}

/* The integral of squares of inputs over their ranges, s. */
static double effort_of(const optimize_motion *o, const double *x)
{
    double sum = 0;
    for (size_t k = 0; k < o->intervals; k++) {
        for (size_t l = 0; l < o->inputs; l++) {
            const scene_parameter *of = reduced_input(o->rod, (int)l);
            const double share = input_of(o, x, k, l) / (of->high - of->low);
            sum += share * share;
        }
    }
    return sum * duration(o, x) / (double)o->intervals;
}

static void put_objective(optimize_motion *o, const double *x)
{
    memset(o->gradient, 0, o->n * sizeof *o->gradient);
    if (is_quickest(o)) {
        o->value = x[o->n - 1];
        o->gradient[o->n - 1] = 1;
        return;
    }
    o->value = effort_of(o, x) / o->longest;
    for (size_t k = 0; k < o->intervals; k++) {
        for (size_t l = 0; l < o->inputs; l++) {
            const scene_parameter *of = reduced_input(o->rod, (int)l);
            o->gradient[k * o->width + STAGES * o->states + l] =
                2 * input_of(o, x, k, l) / (of->high - of->low) / (double)o->intervals;
        }
    }
}

static bool evaluate(void *of, const double *x)
{
    optimize_motion *o = of;
    if (o->known && memcmp(o->at, x, o->n * sizeof *x) == 0) {
        return o->there;
    }
    memcpy(o->at, x, o->n * sizeof *x);
    o->known = true;
    o->there = false;
    double *by = o->by;
    for (size_t k = 0; k < o->intervals; k++) {
        const ad_status status = find_rates(o, x, k);
        if (status != AD_OK) {
            o->why.status = status == AD_NOT_FINITE ? AD_OK : status; /* a shorter step is tried */
            return false;
        }
        for (size_t i = 0; i < STAGES; i++) {
            by = put_stage(o, x, k, i, by);
        }
    }
    put_objective(o, x);
    bool finite = isfinite(o->value);
    for (size_t i = 0; i < o->m; i++) {
        finite = finite && isfinite(o->row[i]);
    }
    o->there = finite;
    return finite;
}

static void find_entries(const optimize_motion *o)
{
    int *row = o->entries, *column = o->entries + o->nonzeros;
    for (size_t k = 0; k < o->intervals; k++) {
        const size_t first = k * o->width, own = STAGES * o->states + o->inputs;
        for (size_t r = 0; r < STAGES * o->states; r++) {
            const int at = (int)(k * STAGES * o->states + r);
            if (k > 0) {
                *row++ = at;
                *column++ = (int)(first - o->inputs - o->states + r % o->states);
            }
            for (size_t c = 0; c < own; c++) {
                *row++ = at;
                *column++ = (int)(first + c);
            }
            if (is_quickest(o)) {
                *row++ = at;
                *column++ = (int)o->n - 1;
            }
        }
    }
}

static void find_limits(optimize_motion *o)
{
    double *low = o->limits, *high = low + o->n;
    memset(high + o->n, 0, 2 * o->m * sizeof *high);
    for (size_t i = 0; i < o->n; i++) {
        const bool is_state = i % o->width < STAGES * o->states;
        low[i] = is_state ? -INFINITY : 0;
        high[i] = is_state ? INFINITY : 1;
    }
    if (is_quickest(o)) {
        low[o->n - 1] = 1e-3;
        high[o->n - 1] = 1;
    }
    for (size_t c = 0; c < o->states; c++) {
        const size_t i = (size_t)(end_of(o, o->x, o->intervals - 1) - o->x) + c;
        low[i] = o->to[c] / o->scale[c] - AT_REST;
        high[i] = o->to[c] / o->scale[c] + AT_REST;
    }
}

/* In proportion from one rest to the other. */
static void guess(optimize_motion *o, double share)
{
    for (size_t k = 0; k < o->intervals; k++) {
        double *x = o->x + k * o->width;
        for (size_t j = 0; j < STAGES; j++) {
            const double way = ((double)k + o->rule.nodes[j]) / (double)o->intervals;
            for (size_t c = 0; c < o->states; c++) {
                x[j * o->states + c] = (o->from[c] + way * (o->to[c] - o->from[c])) / o->scale[c];
            }
        }
        for (size_t l = 0; l < o->inputs; l++) {
            const double way = ((double)k + 0.5) / (double)o->intervals;
            x[STAGES * o->states + l] =
                scene_parameter_fraction(reduced_input(o->rod, (int)l),
                                         o->given[0][l] + way * (o->given[1][l] - o->given[0][l]));
        }
    }
    if (is_quickest(o)) {
        o->x[o->n - 1] = share;
    }
    o->known = false;
}

/* ---- making -------------------------------------------------------------------------------- */

static ad_status read_end(optimize_motion *o, int end, char *key, ad_error *error)
{
    const char *const text = end ? o->settings->end : o->settings->start;
    snprintf(key, 64, "optimize.motion.%s", end ? "end" : "start");
    if (!text) {
        return ad_fail(error, AD_BAD_INPUT,
                       "is not given; allowed: the inputs under which the rod is at rest there, "
                       "\"tension=1\"");
    }
    return scene_member_read(o->family->parameter_count, o->family->parameters, false, text,
                             o->given[end], error);
}

/* What states vary by: the largest change of a mode of such strains, and of its rate in the longest
 * motion. */
static void find_scales(optimize_motion *o, double length)
{
    const size_t half = o->states / 2;
    double most[2] = {1e-3, 1e-3 / length}; /* strains, curvatures */
    for (size_t c = 0; c < half; c++) {
        double *to = &most[reduced_mode_of(o->rod, (int)c).strain >= 3];
        *to = fmax(*to, fabs(o->to[c] - o->from[c]));
    }
    for (size_t c = 0; c < half; c++) {
        o->scale[c] = most[reduced_mode_of(o->rod, (int)c).strain >= 3];
        o->scale[half + c] = o->scale[c] * 2 * acos(-1) / o->longest;
    }
}

static ad_status allocate(optimize_motion *o, ad_error *error)
{
    const size_t n = o->states, m = o->inputs;
    o->width = STAGES * n + m;
    o->n = o->intervals * o->width + is_quickest(o);
    o->m = o->intervals * STAGES * n;
    o->nonzeros = o->m * (1 + o->width + is_quickest(o)) - STAGES * n;
    o->x = calloc(o->n, sizeof *o->x);
    o->limits = calloc(2 * o->n + 2 * o->m, sizeof *o->limits);
    o->gradient = calloc(o->n, sizeof *o->gradient);
    o->row = calloc(o->m, sizeof *o->row);
    o->by = calloc(o->nonzeros, sizeof *o->by);
    o->multiplier = calloc(o->m, sizeof *o->multiplier);
    o->entries = calloc(2 * o->nonzeros, sizeof *o->entries);
    o->memory = calloc(o->n + (4 + STAGES * (1 + n + m)) * n, sizeof *o->memory);
    if (!o->x || !o->limits || !o->gradient || !o->row || !o->by || !o->multiplier || !o->entries ||
        !o->memory) {
        return ad_fail(error, AD_NO_MEMORY, "out of memory for a motion");
    }
    double **const parts[] = {&o->from, &o->to,       &o->scale,   &o->state,
                              &o->rate, &o->by_state, &o->by_input};
    const size_t sizes[] = {n, n, n, n, STAGES * n, STAGES * n * n, STAGES * n * m};
    o->at = o->memory;
    double *next = o->memory + o->n;
    for (size_t i = 0; i < sizeof sizes / sizeof *sizes; i++) {
        *parts[i] = next;
        next += sizes[i];
    }
    return AD_OK;
}

static ad_status make_rod(const optimize_motion *o, const int *modes, reduced_rod **rod,
                          ad_error *error)
{
    const reduced_settings settings = {.modes = {modes[0], modes[1], modes[2], modes[3]},
                                       .count = 1,
                                       .s = &o->tip,
                                       .newton = 1e-10};
    return reduced_create(o->family, &settings, rod, error);
}

/* At rest at an end, from the state that is there. */
static ad_status rest(const optimize_motion *o, reduced_rod *rod, int end, double *state,
                      ad_error *error)
{
    ad_status status = end == 0 ? reduced_initial(rod, o->given[0], state, error) : AD_OK;
    return status == AD_OK ? reduced_settle(rod, 0, o->given[end], state, error) : status;
}

ad_status optimize_motion_create(const optimize_motion_settings *settings, const scene *family,
                                 optimize_motion **result, char key[64], ad_error *error)
{
    optimize_motion *o = calloc(1, sizeof *o);
    *result = NULL;
    if (!o) {
        return ad_fail(error, AD_NO_MEMORY, "out of memory for a motion");
    }
    o->settings = settings;
    o->family = family;
    o->rule = gauss_radau_rule_of(STAGES);
    o->intervals = (size_t)settings->intervals;
    o->longest = scene_duration(family);
    o->tip = scene_length(family);
    snprintf(key, 64, "optimize.motion");
    ad_status status = AD_OK;
    if (!scene_is_dynamic(family)) {
        status = ad_fail(error, AD_BAD_INPUT,
                         "asks for a motion, and the rod is at rest; allowed with time.duration, "
                         "which is that of the motion, or the longest");
    } else if (scene_uses(family, "t")) {
        status = ad_fail(error, AD_BAD_INPUT,
                         "chooses when things happen, and formulas of the scene depend on t; "
                         "allowed: those that do not");
    }
    status = status == AD_OK ? read_end(o, 0, key, error) : status;
    status = status == AD_OK ? read_end(o, 1, key, error) : status;
    status = status == AD_OK ? make_rod(o, settings->modes, &o->rod, error) : status;
    if (status == AD_OK) {
        o->states = (size_t)reduced_states(o->rod);
        o->inputs = (size_t)reduced_inputs(o->rod);
        status = allocate(o, error);
    }
    status = status == AD_OK ? rest(o, o->rod, 0, o->from, error) : status;
    if (status == AD_OK) {
        memcpy(o->to, o->from, o->states * sizeof *o->to);
        status = rest(o, o->rod, 1, o->to, error);
    }
    if (status != AD_OK) {
        optimize_motion_free(o);
        return status;
    }
    find_scales(o, o->tip);
    find_limits(o);
    find_entries(o);
    *result = o;
    return AD_OK;
}

/* ---- running ------------------------------------------------------------------------------- */

/* Steps of Radau's method with these inputs, from rest to rest of a rod with such modes. */
static ad_status replay(const optimize_motion *o, const int *modes, optimize_replay *found,
                        double *way, ad_error *error)
{
    reduced_rod *rod = NULL;
    double inputs[SCENE_PARAMETERS_MAX];
    reduced_place place[2], now;
    ad_status status = make_rod(o, modes, &rod, error);
    const size_t n = status == AD_OK ? (size_t)reduced_states(rod) : 0;
    double *state = calloc(2 * n + 1, sizeof *state), *at_rest = state + n;
    if (status == AD_OK && !state) {
        status = ad_fail(error, AD_NO_MEMORY, "out of memory for a motion");
    }
    status = status == AD_OK ? rest(o, rod, 0, state, error) : status;
    for (int end = 0; end < 2 && status == AD_OK; end++) {
        if (end == 0) {
            memcpy(at_rest, state, n * sizeof *state);
        } else {
            status = rest(o, rod, 1, at_rest, error);
        }
        status = status == AD_OK
                     ? reduced_output(rod, 0, at_rest, o->given[end], &place[end], NULL, error)
                     : status;
    }
    const double h = duration(o, o->x) / (double)(o->intervals * PARTS);
    for (size_t k = 0; k < o->intervals * PARTS && status == AD_OK; k++) {
        for (size_t l = 0; l < o->inputs; l++) {
            inputs[l] = input_of(o, o->x, k / PARTS, l);
        }
        status = reduced_step(rod, 0, h, state, inputs, state, NULL, NULL, error);
    }
    status =
        status == AD_OK ? reduced_output(rod, 0, state, o->given[1], &now, NULL, error) : status;
    if (status == AD_OK) {
        found->off = vector_distance(now.position, place[1].position);
        found->speed = sqrt(vector_dot(now.velocity, now.velocity));
        *way = vector_distance(place[0].position, place[1].position);
    }
    free(state);
    reduced_free(rod);
    return status;
}

static double violation(const optimize_motion *o)
{
    double worst = 0;
    for (size_t i = 0; i < o->m; i++) {
        worst = fmax(worst, fabs(o->row[i]));
    }
    return worst;
}

descent optimize_motion_problem(optimize_motion *o)
{
    return (descent){.n = o->n,
                     .m = o->m,
                     .nonzeros = o->nonzeros,
                     .x_low = o->limits,
                     .x_high = o->limits + o->n,
                     .row_low = o->limits + 2 * o->n,
                     .row_high = o->limits + 2 * o->n + o->m,
                     .row_of = o->entries,
                     .column_of = o->entries + o->nonzeros,
                     .at = evaluate,
                     .of = o,
                     .value = &o->value,
                     .gradient = o->gradient,
                     .row = o->row,
                     .by = o->by,
                     .why = &o->why,
                     .x = o->x,
                     .multiplier = o->multiplier};
}

ad_status optimize_motion_run(optimize_motion *o, optimize_motion_report *report, ad_error *error)
{
    const double begin = train_seconds();
    const int *given = o->settings->modes;
    const int finer[4] = {given[0] + 2, given[1] + 1, given[2] > 2 ? given[2] + 1 : 2,
                          given[3] > 1 ? given[3] + 1 : 1};
    const descent d = optimize_motion_problem(o);
    ad_status status = AD_OK;
    *report = (optimize_motion_report){.violation = INFINITY};
    memcpy(report->modes, finer, sizeof finer);
    for (int i = 0; i < (is_quickest(o) ? STARTS : 1) && !report->found && status == AD_OK; i++) {
        int steps = 0;
        bool converged = false;
        guess(o, FIRST[i]);
        o->why.status = AD_OK;
        status = optimize_descent(&d, &steps, &converged, error);
        report->violation = status == AD_OK && evaluate(o, o->x) ? violation(o) : INFINITY;
        report->found = converged && report->violation <= KEPT;
        report->steps += steps;
        report->starts++;
    }
    report->duration = duration(o, o->x);
    report->effort = effort_of(o, o->x);
    if (report->found && status == AD_OK) {
        status = replay(o, given, &report->same, &report->way, error);
        status = status == AD_OK ? replay(o, finer, &report->finer, &report->way, error) : status;
    }
    report->seconds = train_seconds() - begin;
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

ad_status optimize_motion_at(optimize_motion *o, int k, double *t, double *inputs, double tip[3],
                             ad_error *error)
{
    const size_t at = (size_t)k;
    reduced_place place;
    for (size_t l = 0; l < o->inputs; l++) {
        inputs[l] = at < o->intervals ? input_of(o, o->x, at, l) : o->given[1][l];
    }
    for (size_t c = 0; c < o->states; c++) {
        o->state[c] = k > 0 ? o->scale[c] * end_of(o, o->x, at - 1)[c] : o->from[c];
    }
    *t = duration(o, o->x) * k / (double)o->intervals;
    const ad_status status = reduced_output(o->rod, 0, o->state, inputs, &place, NULL, error);
    if (status == AD_OK) {
        memcpy(tip, place.position, sizeof place.position);
    }
    return status;
}
