#include "tools/optimize/motion_parts.h"

#include "physics/numerics/vector_size.h"

#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

enum { STAGES = MOTION_STAGES };

/* Of what it varies by, by which a bound may be missed at rest. */
static const double KEPT_AT_REST = 1e-9;

void optimize_motion_free(optimize_motion *o)
{
    if (o) {
        ad_memory_free(&o->memory);
        motion_rod_free(o->rod);
        free(o);
    }
}

static bool is_quickest(const optimize_motion *o)
{
    return o->settings->motion.minimize == OPTIMIZE_TIME;
}

double motion_duration(const optimize_motion *o, const double *x)
{
    return is_quickest(o) ? x[o->n - 1] * o->longest : o->longest;
}

static double range_of(const optimize_motion *o, size_t i)
{
    const scene_parameter *of = reduced_input(o->rod->rod, (int)i);
    return of->high - of->low;
}

/* Where the input i of an interval is among all variables; -1: of the first one. */
static size_t variable_of(const optimize_motion *o, size_t k, size_t i)
{
    return k * o->width + STAGES * o->states + i;
}

static double input_of(const optimize_motion *o, const double *x, size_t k, size_t i)
{
    return reduced_input(o->rod->rod, (int)i)->low + range_of(o, i) * x[variable_of(o, k, i)];
}

/* That before interval k, from where inputs go linearly. */
static double input_before(const optimize_motion *o, const double *x, size_t k, size_t i)
{
    return k > 0 ? input_of(o, x, k - 1, i) : o->given[0][i];
}

void motion_inputs_at(const optimize_motion *o, const double *x, size_t k, double part,
                      double *inputs, double *rates)
{
    const double h = motion_duration(o, x) / (double)o->intervals;
    for (size_t i = 0; i < o->inputs; i++) {
        const double own = input_of(o, x, k, i), before = input_before(o, x, k, i);
        inputs[i] = o->linear ? before + part * (own - before) : own;
        if (rates) {
            rates[i] = o->linear ? (own - before) / h : 0;
        }
    }
}

const double *motion_end_of(const optimize_motion *o, const double *x, size_t k)
{
    return x + k * o->width + (STAGES - 1) * o->states;
}

/* ---- the problem --------------------------------------------------------------------------- */

/* The state of point j, and the inputs there. */
static void take_point(optimize_motion *o, const double *x, size_t k, size_t j, double *inputs,
                       double *rates)
{
    const double *at = x + k * o->width + j * o->states;
    for (size_t c = 0; c < o->states; c++) {
        o->state[c] = o->scale[c] * at[c];
    }
    motion_inputs_at(o, x, k, o->rule.nodes[j], inputs, rates);
}

static ad_status find_rates(optimize_motion *o, const double *x, size_t k)
{
    const size_t n = o->states;
    double inputs[SCENE_PARAMETERS_MAX];
    ad_status status = AD_OK;
    for (size_t j = 0; j < STAGES && status == AD_OK; j++) {
        take_point(o, x, k, j, inputs, NULL);
        status = reduced_rate(o->rod->rod, 0, o->state, inputs, o->rate + j * n,
                              o->by_state + j * n * n, o->by_input + j * n * o->inputs, &o->why);
    }
    return status;
}

/* Of point j: how much of the input that an interval begins with is there. */
static double part_before(const optimize_motion *o, size_t j)
{
    return o->linear ? 1 - o->rule.nodes[j] : 0;
}

/* Rows of stage i: what the state is more than at the beginning, less the integral of its rate. */
static double *put_stage(optimize_motion *o, const double *x, size_t k, size_t i, double *by)
{
    const size_t n = o->states, m = o->inputs;
    const double h = motion_duration(o, x) / (double)o->intervals;
    const double *a = o->rule.matrix[i];
    for (size_t r = 0; r < n; r++) {
        const double begin = k > 0 ? motion_end_of(o, x, k - 1)[r] : o->from[r] / o->scale[r];
        double sum = 0, slope[2][SCENE_PARAMETERS_MAX] = {{0}}; /* by inputs of before and own */
        for (size_t j = 0; j < STAGES; j++) {
            const double before = part_before(o, j);
            sum += a[j] * o->rate[j * n + r] / o->scale[r];
            for (size_t l = 0; l < m; l++) {
                const double part = -h * a[j] * o->by_input[(j * n + r) * m + l] * range_of(o, l);
                slope[0][l] += before * part / o->scale[r];
                slope[1][l] += (1 - before) * part / o->scale[r];
            }
        }
        o->row[k * o->height + i * n + r] = x[k * o->width + i * n + r] - begin - h * sum;
        if (k > 0) {
            *by++ = -1;
        }
        for (size_t l = 0; l < m && k > 0 && o->linear; l++) {
            *by++ = slope[0][l];
        }
        for (size_t j = 0; j < STAGES; j++) {
            for (size_t c = 0; c < n; c++) {
                const double of = o->by_state[(j * n + r) * n + c] * o->scale[c] / o->scale[r];
                *by++ = (j == i && c == r) - h * a[j] * of;
            }
        }
        memcpy(by, slope[1], m * sizeof *by);
        by += m;
        if (is_quickest(o)) {
            *by++ = -o->longest / (double)o->intervals * sum;
        }
    }
    return by;
}

/* The row of a value, over what it varies by, and its slope. Where there is one bound, what is far
 * from it nearly stays where it is: a size has a kink at 0, which no descent passes well. */
static double row_of(const motion_bound *b, double value, double *slope)
{
    const bool is_low = isinf(b->high), is_one = is_low || isinf(b->low);
    const double bound = is_low ? b->low : b->high, far = 0.3 / b->scale;
    const double off = (is_low ? value - bound : bound - value) / far;
    *slope = b->scale;
    if (!is_one || off < 0) {
        return b->scale * value;
    }
    *slope /= cosh(off) * cosh(off);
    return b->scale * (bound + (is_low ? far : -far) * tanh(off));
}

/* Rows of what is bounded at point j of an interval. */
static ad_status put_bounds(optimize_motion *o, const double *x, size_t k, size_t j, double **entry)
{
    const motion_rod *rod = o->rod;
    const size_t n = o->states, m = o->inputs;
    const double h = motion_duration(o, x) / (double)o->intervals, before = part_before(o, j);
    double inputs[SCENE_PARAMETERS_MAX], rates[SCENE_PARAMETERS_MAX], *by = *entry;
    double *row = o->row + k * o->height + STAGES * n + j * rod->rows;
    const double *value = o->values, *slope = o->slopes;
    take_point(o, x, k, j, inputs, rates);
    const ad_status status =
        motion_rod_look(o->rod, o->state, inputs, rates, o->values, o->slopes, &o->why);
    for (int i = 0; i < rod->bounds && status == AD_OK; i++) {
        for (size_t r = 0; r < rod->bound[i].rows; r++, slope += rod->directions) {
            double by_duration = 0, scale;
            *row++ = row_of(&rod->bound[i], *value++, &scale);
            for (size_t l = 0; l < m && k > 0 && o->linear; l++) {
                *by++ = scale * range_of(o, l) * (before * slope[l] - slope[m + l] / h);
            }
            for (size_t c = 0; c < n; c++) {
                *by++ = scale * o->scale[c] * slope[2 * m + c];
            }
            for (size_t l = 0; l < m; l++) {
                const double of_rate = o->linear ? slope[m + l] / h : 0;
                *by++ = scale * range_of(o, l) * ((1 - before) * slope[l] + of_rate);
                by_duration -= slope[m + l] * rates[l];
            }
            if (is_quickest(o)) {
                *by++ = scale * by_duration / x[o->n - 1];
            }
        }
    }
    *entry = by;
    return status;
}

/* The integral of squares of inputs over their ranges, s. With the derivatives of its share of the
 * duration, unless NULL [n]. */
static double share_of_effort(const optimize_motion *o, const double *x, double *gradient)
{
    const double each = 1 / (double)o->intervals;
    double sum = 0;
    for (size_t k = 0; k < o->intervals; k++) {
        for (size_t l = 0; l < o->inputs; l++) {
            const double range = range_of(o, l), b = input_of(o, x, k, l) / range;
            const double a = o->linear ? input_before(o, x, k, l) / range : b;
            sum += each * (a * a + a * b + b * b) / 3;
            if (gradient) {
                gradient[variable_of(o, k, l)] += each * (o->linear ? (a + 2 * b) / 3 : 2 * b);
            }
            if (gradient && o->linear && k > 0) {
                gradient[variable_of(o, k - 1, l)] += each * (2 * a + b) / 3;
            }
        }
    }
    return sum;
}

double motion_effort(const optimize_motion *o, const double *x)
{
    return share_of_effort(o, x, NULL) * motion_duration(o, x);
}

static void put_objective(optimize_motion *o, const double *x)
{
    memset(o->gradient, 0, o->n * sizeof *o->gradient);
    if (is_quickest(o)) {
        o->value = x[o->n - 1];
        o->gradient[o->n - 1] = 1;
    } else {
        o->value = share_of_effort(o, x, o->gradient);
    }
}

bool motion_evaluate(void *of, const double *x)
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
        ad_status status = find_rates(o, x, k);
        for (size_t i = 0; i < STAGES && status == AD_OK; i++) {
            by = put_stage(o, x, k, i, by);
        }
        for (size_t j = 0; j < STAGES && status == AD_OK && o->rod->rows > 0; j++) {
            status = put_bounds(o, x, k, j, &by);
        }
        if (status != AD_OK) {
            o->why.status = status == AD_NOT_FINITE ? AD_OK : status; /* a shorter step is tried */
            return false;
        }
    }
    put_objective(o, x);
    o->there = isfinite(o->value) && vector_is_finite(o->m, o->row);
    return o->there;
}

/* Places of the derivatives of a row: by so many variables from the first on, behind those of the
 * interval before, and by inputs; of the dynamics also by a state of the interval before. */
static void put_places(const optimize_motion *o, size_t k, size_t at, size_t first, size_t count,
                       int **row, int **column)
{
    const size_t own = variable_of(o, k, 0);
    const size_t before = k > 0 && o->linear ? o->inputs : 0;
    for (size_t c = 0; c < before + count + o->inputs + is_quickest(o); c++) {
        const size_t i = c - before;
        *(*row)++ = (int)at;
        *(*column)++ = (int)(c < before              ? k * o->width - o->inputs + c
                             : i < count             ? first + i
                             : i < count + o->inputs ? own + i - count
                                                     : o->n - 1);
    }
}

static void find_entries(const optimize_motion *o)
{
    const size_t n = o->states;
    int *row = o->entries, *column = o->entries + o->nonzeros;
    for (size_t k = 0; k < o->intervals; k++) {
        const size_t first = k * o->width, at = k * o->height;
        for (size_t r = 0; r < STAGES * n; r++) {
            if (k > 0) {
                *row++ = (int)(at + r);
                *column++ = (int)(first - o->inputs - n + r % n);
            }
            put_places(o, k, at + r, first, STAGES * n, &row, &column);
        }
        for (size_t r = 0; r < STAGES * o->rod->rows; r++) {
            put_places(o, k, at + STAGES * n + r, first + r / o->rod->rows * n, n, &row, &column);
        }
    }
}

double motion_share_of(const optimize_motion *o, size_t i, double value)
{
    return (value - reduced_input(o->rod->rod, (int)i)->low) / range_of(o, i);
}

void motion_rest_within(optimize_motion *o, double share)
{
    const size_t first = (size_t)(motion_end_of(o, o->x, o->intervals - 1) - o->x);
    for (size_t c = 0; c < o->states; c++) {
        o->limits[first + c] = o->to[c] / o->scale[c] - share;
        o->limits[o->n + first + c] = o->to[c] / o->scale[c] + share;
    }
}

static void find_limits(optimize_motion *o)
{
    double *low = o->limits, *high = low + o->n, *row_low = high + o->n, *row_high = row_low + o->m;
    for (size_t i = 0; i < o->n; i++) {
        const bool is_state = i % o->width < STAGES * o->states;
        low[i] = is_state ? -INFINITY : 0;
        high[i] = is_state ? INFINITY : 1;
    }
    if (is_quickest(o)) {
        low[o->n - 1] = 1e-3;
        high[o->n - 1] = 1;
    }
    motion_rest_within(o, 1e-7);
    for (size_t l = 0; l < o->inputs && o->linear; l++) {
        const size_t i = variable_of(o, o->intervals - 1, l);
        low[i] = high[i] = motion_share_of(o, l, o->given[1][l]);
    }
    for (size_t k = 0; k < o->intervals; k++) {
        size_t at = k * o->height + STAGES * o->states;
        for (size_t j = 0; j < STAGES; j++) {
            for (int i = 0; i < o->rod->bounds; i++) {
                const motion_bound *b = &o->rod->bound[i];
                for (size_t r = 0; r < b->rows; r++, at++) {
                    row_low[at] = b->scale * b->low;
                    row_high[at] = b->scale * b->high;
                }
            }
        }
    }
}

void motion_guess(optimize_motion *o, double share)
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
            const double way = ((double)k + (o->linear ? 1 : 0.5)) / (double)o->intervals;
            x[STAGES * o->states + l] =
                motion_share_of(o, l, o->given[0][l] + way * (o->given[1][l] - o->given[0][l]));
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
    const char *const text = end ? o->settings->motion.end : o->settings->motion.start;
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
        double *to = &most[reduced_mode_of(o->rod->rod, (int)c).strain >= 3];
        *to = fmax(*to, fabs(o->to[c] - o->from[c]));
    }
    for (size_t c = 0; c < half; c++) {
        o->scale[c] = most[reduced_mode_of(o->rod->rod, (int)c).strain >= 3];
        o->scale[half + c] = o->scale[c] * 2 * acos(-1) / o->longest;
    }
}

static ad_status allocate(optimize_motion *o, ad_error *error)
{
    const size_t n = o->states, m = o->inputs;
    o->width = STAGES * n + m;
    o->n = o->intervals * o->width + is_quickest(o);
    o->height = STAGES * (n + o->rod->rows);
    o->m = o->intervals * o->height;
    const size_t others = m + is_quickest(o), before = o->linear ? m : 0; /* of a row */
    o->nonzeros =
        o->intervals * STAGES *
            (n * (1 + before + STAGES * n + others) + o->rod->rows * (before + n + others)) -
        STAGES * (n * (1 + before) + o->rod->rows * before);
    AD_TAKE(o, x, o->n);
    AD_TAKE(o, limits, 2 * o->n + 2 * o->m);
    AD_TAKE(o, gradient, o->n);
    AD_TAKE(o, row, o->m);
    AD_TAKE(o, by, o->nonzeros);
    AD_TAKE(o, multiplier, o->m);
    AD_TAKE(o, entries, 2 * o->nonzeros);
    AD_TAKE(o, at, o->n);
    AD_TAKE(o, from, n);
    AD_TAKE(o, to, n);
    AD_TAKE(o, scale, n);
    AD_TAKE(o, state, n);
    AD_TAKE(o, rate, STAGES * n);
    AD_TAKE(o, by_state, STAGES * n * n);
    AD_TAKE(o, by_input, STAGES * n * m);
    AD_TAKE(o, values, o->rod->rows);
    AD_TAKE(o, slopes, o->rod->rows * o->rod->directions);
    return ad_memory_status(&o->memory, error, "out of memory for a motion");
}

ad_status motion_rest(const optimize_motion *o, reduced_rod *rod, int end, double *state,
                      ad_error *error)
{
    ad_status status = end == 0 ? reduced_initial(rod, o->given[0], state, error) : AD_OK;
    return status == AD_OK ? reduced_settle(rod, 0, o->given[end], state, error) : status;
}

/* What is bounded varies from one rest to the other, and to its bounds. It is kept at both. */
static ad_status scale_bounds(optimize_motion *o, char *key, ad_error *error)
{
    const double none[SCENE_PARAMETERS_MAX] = {0};
    const motion_rod *rod = o->rod;
    double *value[2] = {o->values, o->slopes};
    ad_status status = AD_OK;
    for (int end = 0; end < 2 && status == AD_OK && rod->rows > 0; end++) {
        status = motion_rod_look(o->rod, end ? o->to : o->from, o->given[end], none, value[end],
                                 NULL, error);
    }
    for (int i = 0; i < rod->bounds && status == AD_OK; i++) {
        motion_bound *b = &o->rod->bound[i];
        double low = INFINITY, high = -INFINITY, excess[2] = {0, 0};
        for (size_t r = 0; r < b->rows; r++) {
            for (int end = 0; end < 2; end++) {
                const double now = *value[end]++;
                low = fmin(low, now);
                high = fmax(high, now);
                excess[end] = fmax(excess[end], motion_bound_excess(b, now));
            }
        }
        low = fmin(low, isfinite(b->low) ? b->low : b->high);
        high = fmax(high, isfinite(b->high) ? b->high : b->low);
        b->scale = high > low ? 1 / (high - low) : 1;
        const int end = excess[0] > excess[1] ? 0 : 1;
        if (!(excess[end] * b->scale <= KEPT_AT_REST)) {
            snprintf(key, OPTIMIZE_KEY_MAX, "optimize.constraints[%d]", i);
            status = ad_fail(error, AD_BAD_INPUT,
                             "is missed by %.3g where the rod is at rest at the %s; allowed: what "
                             "is kept there",
                             excess[end], end ? "end" : "start");
        }
    }
    return status;
}

ad_status optimize_motion_create(const optimize_settings *settings, const scene *family,
                                 const environment *around, optimize_motion **result, char key[64],
                                 ad_error *error)
{
    optimize_motion *o = calloc(1, sizeof *o);
    *result = NULL;
    if (!o) {
        return ad_fail(error, AD_NO_MEMORY, "out of memory for a motion");
    }
    o->settings = settings;
    o->family = family;
    o->around = around;
    o->rule = gauss_radau_rule_of(STAGES);
    o->intervals = (size_t)settings->motion.intervals;
    o->longest = scene_duration(family);
    snprintf(key, OPTIMIZE_KEY_MAX, "optimize.motion");
    ad_status status = AD_OK;
    if (!scene_is_dynamic(family)) {
        status = ad_fail(error, AD_BAD_INPUT,
                         "asks for a motion, and the rod is at rest; allowed with time.duration, "
                         "which is that of the motion, or the longest");
    } else if (scene_uses(family, "t")) {
        status = ad_fail(error, AD_BAD_INPUT,
                         "chooses when things happen, and formulas of the scene depend on t; "
                         "allowed: those that do not");
    } else if (family->memory_count > 0) {
        status = ad_fail(error, AD_BAD_INPUT,
                         "chooses inputs by derivatives that a play or a lag does not keep; "
                         "allowed: a scene without them");
    } else if (scene_has_branch(family)) {
        status = ad_fail(error, AD_BAD_INPUT,
                         "does not take material.maxwell yet; allowed: a scene without it");
    }
    status = status == AD_OK ? read_end(o, 0, key, error) : status;
    status = status == AD_OK ? read_end(o, 1, key, error) : status;
    if (status == AD_OK) {
        status = motion_rod_create(settings, family, around, settings->motion.modes,
                                   (size_t)settings->points, &o->rod, key, error);
    }
    if (status == AD_OK) {
        o->states = (size_t)o->rod->states;
        o->inputs = (size_t)o->rod->inputs;
        o->linear = o->rod->rates;
        status = allocate(o, error);
    }
    status = status == AD_OK ? motion_rest(o, o->rod->rod, 0, o->from, error) : status;
    if (status == AD_OK) {
        memcpy(o->to, o->from, o->states * sizeof *o->to);
        status = motion_rest(o, o->rod->rod, 1, o->to, error);
    }
    status = status == AD_OK ? scale_bounds(o, key, error) : status;
    if (status != AD_OK) {
        optimize_motion_free(o);
        return status;
    }
    find_scales(o, scene_length(family));
    find_limits(o);
    find_entries(o);
    *result = o;
    return AD_OK;
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
                     .at = motion_evaluate,
                     .of = o,
                     .value = &o->value,
                     .gradient = o->gradient,
                     .row = o->row,
                     .by = o->by,
                     .why = &o->why,
                     .x = o->x,
                     .multiplier = o->multiplier};
}
