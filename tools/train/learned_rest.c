#include "tools/train/learned_rest.h"

#include "autodiff/memory.h"
#include "nn/rng.h"
#include "physics/numerics/clock.h"
#include "physics/numerics/sort.h"
#include "physics/scene/scene_values.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

enum { MAX = SCENE_PARAMETERS_MAX };

struct learned_rest {
    const scene *open;
    scene_values names; /* its */
    learned_asked asked;
    solve_trials *trials;
    int common, known;
    size_t experiments, fitted_experiments, numbers;
    size_t *fitted;     /* [fitted_experiments] of which something is fitted */
    size_t *of, *row;   /* [numbers] experiment, row of all sets */
    double *noise;      /* [numbers] of each, in its unit */
    double *x;          /* [inputs][experiments] */
    double *parameters; /* [experiments][parameter_count] */
    bool moves;         /* inputs change with what is to be found */
    double *values;     /* [experiments][unknowns] */
    double *all, *room; /* [unknowns][numbers], [2 unknowns][numbers] */
    bool *used;         /* [numbers] */
    double *distances;  /* [numbers] of rows */
    double from[MAX];   /* where common numbers begin, as of scene_unknown_value */
    learned_net net, direct;
    size_t places;     /* that a network alone says */
    size_t *place;     /* [numbers] which */
    double *level;     /* [places] mean of what is fitted */
    double *measured;  /* [numbers] in its unit */
    learned_fit *last; /* of LEARNED_BOTH */
    double found[MAX]; /* values of the common numbers */
    ad_memory memory;
};

void learned_rest_free(learned_rest *rest)
{
    if (rest) {
        solve_trials_free(rest->trials);
        learned_fit_free(rest->last);
        ad_memory_free(&rest->memory);
        free(rest);
    }
}

size_t learned_rest_experiments(const learned_rest *rest)
{
    return rest->fitted_experiments;
}

const learned_net *learned_rest_net(const learned_rest *rest)
{
    return &rest->net;
}

double *learned_rest_theta(const learned_rest *rest)
{
    return learned_fit_numbers(rest->last) + rest->common;
}

const double *learned_rest_common(const learned_rest *rest)
{
    return rest->found;
}

double *learned_rest_covariance(const learned_rest *rest)
{
    return learned_fit_covariance(rest->last);
}

double learned_rest_noise(const learned_rest *rest)
{
    const learned_report report = learned_fit_report(rest->last);
    double unit = rest->noise[0];
    for (size_t k = 0; k < rest->numbers; k++) {
        unit = rest->noise[k] == unit ? unit : NAN;
    }
    return report.noise * report.calibration * unit;
}

/* ---- through the solver -------------------------------------------------------------------- */

static const scene_parameter *unknown_of(const learned_rest *rest, int i)
{
    return &rest->open->parameters[rest->known + i];
}

/* Values of a common number, and how they change with it. */
static double common_value(const learned_rest *rest, int i, double number, double *slope)
{
    const scene_parameter *p = unknown_of(rest, i);
    const double value = scene_unknown_value(p, rest->asked.common[i], rest->from[i] + number);
    const double z = scene_parameter_fraction(p, value);
    *slope = scene_parameter_slope(p, value) * z * (1 - z);
    return value;
}

double learned_rest_common_deviation(const learned_rest *rest, int unknown)
{
    const size_t i = (size_t)unknown;
    double slope;
    common_value(rest, unknown, learned_fit_numbers(rest->last)[i], &slope);
    return sqrt(learned_fit_covariance(rest->last)[i * learned_fit_count(rest->last) + i]) *
           fabs(slope);
}

static ad_status differentiate(learned_rest *rest, const double *values, const double *residuals,
                               double *by, ad_error *error)
{
    const size_t n = rest->numbers;
    size_t solved;
    ad_status status = solve_trials_differentiate(rest->trials, rest->values, NULL, residuals,
                                                  rest->room, by, &solved, error);
    for (int i = 0; status == AD_OK && i < rest->common; i++) {
        double slope;
        common_value(rest, i, values[i], &slope);
        for (size_t k = 0; k < n; k++) {
            by[(size_t)i * n + k] *= slope;
        }
    }
    return status;
}

/* As learned_problem says; of physics alone outputs are 0. */
static ad_status solve_with(learned_rest *rest, size_t width, const double *values,
                            double *residuals, double *by, ad_error *error)
{
    const size_t unknowns = (size_t)rest->open->unknown_count;
    for (size_t e = 0; e < rest->experiments; e++) {
        double *to = rest->values + e * unknowns, slope;
        memset(to, 0, unknowns * sizeof *to);
        memcpy(to, values + e * width, width * sizeof *to);
        for (int i = 0; i < rest->common; i++) {
            to[i] = common_value(rest, i, values[e * width + (size_t)i], &slope);
        }
    }
    ad_status status = solve_trials_run(rest->trials, 1, rest->values, true, residuals, error);
    return status == AD_OK && by ? differentiate(rest, values, residuals, by, error) : status;
}

static ad_status solve_both(void *context, const double *values, double *residuals, double *by,
                            ad_error *error)
{
    learned_rest *rest = context;
    return solve_with(rest, (size_t)rest->open->unknown_count, values, residuals, by, error);
}

static ad_status solve_physics(void *context, const double *values, double *residuals, double *by,
                               ad_error *error)
{
    learned_rest *rest = context;
    const size_t n = rest->numbers, common = (size_t)rest->common;
    ad_status status = solve_with(rest, common, values, residuals, by ? rest->all : NULL, error);
    if (status == AD_OK && by) {
        memcpy(by, rest->all, common * n * sizeof *by);
    }
    return status;
}

/* ---- without it ---------------------------------------------------------------------------- */

/* What a network alone says is what is measured, less its mean. */
static ad_status solve_directly(void *context, const double *values, double *residuals, double *by,
                                ad_error *error)
{
    const learned_rest *rest = context;
    (void)error;
    if (by) {
        memset(by, 0, rest->places * rest->numbers * sizeof *by);
    }
    for (size_t k = 0; k < rest->numbers; k++) {
        const size_t at = rest->place[k];
        const double said = rest->level[at] + values[rest->of[k] * rest->places + at];
        residuals[k] = (said - rest->measured[k]) / rest->noise[k];
        if (by) {
            by[at * rest->numbers + k] = 1 / rest->noise[k];
        }
    }
    return AD_OK;
}

/* ---- rows ---------------------------------------------------------------------------------- */

typedef struct place {
    int column;
    double s;
} place;

/* Which place a number is of, added where it is new. */
static size_t find_place(place *places, size_t *count, int column, double s)
{
    for (size_t i = 0; i < *count; i++) {
        if (places[i].column == column && places[i].s == s) {
            return i;
        }
    }
    if (*count < LEARNED_OUTPUTS_MAX) {
        places[*count] = (place){column, s};
    }
    return (*count)++;
}

/* Numbers of all sets in their order, as trials have them. */
static void take_numbers(learned_rest *rest)
{
    const learned_asked *asked = &rest->asked;
    place places[LEARNED_OUTPUTS_MAX];
    size_t n = 0, row = 0;
    for (int i = 0; i < asked->sets + asked->held_out; i++) {
        const solve_measured *set = &asked->measured[i];
        for (size_t r = 0; r < set->rows; r++, row++) {
            for (int c = 0; c < set->columns; c++) {
                const double value = set->values[(size_t)c * set->rows + r];
                if (isnan(value) || n == rest->numbers) {
                    continue;
                }
                rest->row[n] = row;
                rest->noise[n] = set->noise[c];
                rest->used[n] = i < asked->sets;
                rest->measured[n] = value;
                rest->place[n++] = find_place(places, &rest->places, set->column[c], set->s[r]);
            }
        }
    }
}

/* Whether numbers are those of columns, each by itself: of rotations in space they are not. */
static bool is_plain(const learned_rest *rest)
{
    const scene_physics *physics = scene_physics_of(rest->open);
    bool plain = rest->places <= LEARNED_OUTPUTS_MAX;
    for (int i = 0; i < rest->asked.sets + rest->asked.held_out; i++) {
        const solve_measured *set = &rest->asked.measured[i];
        plain = plain &&
                !(physics->rotation_columns == 4 && set->column[0] == physics->position_columns);
    }
    return plain;
}

/* How an input changes with the common numbers [common], at parameters of an experiment. */
static void change_input(const learned_rest *rest, int input, size_t experiment,
                         const double *parameters, const double *slope, double *by, size_t stride)
{
    const quantity of = rest->asked.input[input];
    double column[MAX] = {0}, along[MAX] = {0};
    for (int i = rest->known - rest->open->memory_count; i < rest->open->parameter_count; i++) {
        if (quantity_depends_on(of, rest->open->parameters[i].name)) {
            along[i] = 1;
            column[i] = scene_slope_at(&rest->names, of, parameters, along);
            along[i] = 0;
        }
    }
    for (int i = 0; i < rest->common; i++) {
        by[(size_t)i * stride] =
            slope[i] * solve_trials_change(rest->trials, experiment, rest->known + i, column);
    }
}

/* As learned_problem says: inputs at common numbers. */
static ad_status look(void *context, const double *common, double *x, double *by, ad_error *error)
{
    learned_rest *rest = context;
    const size_t width = (size_t)rest->open->parameter_count, points = rest->experiments;
    const size_t inputs = (size_t)rest->asked.inputs;
    double slope[MAX];
    for (int i = 0; i < rest->common; i++) {
        const double value = common_value(rest, i, common[i], &slope[i]);
        for (size_t e = 0; e < points; e++) {
            rest->values[e * (size_t)rest->open->unknown_count + (size_t)i] = value;
        }
    }
    const ad_status status =
        solve_trials_remember(rest->trials, rest->values, by != NULL, rest->parameters, error);
    for (size_t e = 0; status == AD_OK && e < points; e++) {
        const double *at = rest->parameters + e * width;
        for (size_t i = 0; i < inputs; i++) {
            x[i * points + e] = scene_value_at(&rest->names, rest->asked.input[i], at);
            if (by) {
                change_input(rest, (int)i, e, at, slope, by + i * points + e, inputs * points);
            }
        }
    }
    return status;
}

/* Inputs of each experiment, and how far they reach in those that are fitted. */
static ad_status take_inputs(learned_rest *rest, ad_error *error)
{
    const double zero[MAX] = {0};
    const scene *open = rest->open;
    for (int i = 0; i < open->unknown_count; i++) {
        const char *name = open->parameters[rest->known + i].name;
        rest->moves = rest->moves ||
                      quantity_any_depends_on(rest->asked.inputs, rest->asked.input, name) ||
                      scene_memory_uses(open, name);
    }
    const ad_status status = look(rest, zero, rest->x, NULL, error);
    for (int i = 0; status == AD_OK && i < rest->asked.inputs; i++) {
        double low = INFINITY, high = -INFINITY;
        for (size_t k = 0; k < rest->numbers; k++) {
            const double x = rest->x[(size_t)i * rest->experiments + rest->of[k]];
            low = rest->used[k] ? fmin(low, x) : low;
            high = rest->used[k] ? fmax(high, x) : high;
        }
        rest->net.middle[i] = (low + high) / 2;
        rest->net.half[i] = high > low ? (high - low) / 2 : 1;
    }
    return status;
}

/* Experiments are marked, and then listed. */
static void list_fitted(learned_rest *rest)
{
    for (size_t k = 0; k < rest->numbers; k++) {
        rest->fitted[rest->of[k]] |= rest->used[k];
    }
    for (size_t e = 0; e < rest->experiments; e++) {
        if (rest->fitted[e]) {
            rest->fitted[rest->fitted_experiments++] = e;
        }
    }
}

/* ---- making -------------------------------------------------------------------------------- */

static ad_status allocate(learned_rest *rest, ad_error *error)
{
    const size_t n = rest->numbers, points = rest->experiments;
    const size_t unknowns = (size_t)rest->open->unknown_count;
    AD_TAKE(rest, fitted, points + 1);
    AD_TAKE(rest, of, n + 1);
    AD_TAKE(rest, row, n + 1);
    AD_TAKE(rest, noise, n + 1);
    AD_TAKE(rest, x, (size_t)rest->asked.inputs * points + 1);
    AD_TAKE(rest, values, points * unknowns + 1);
    AD_TAKE(rest, parameters, points * (size_t)rest->open->parameter_count + 1);
    AD_TAKE(rest, all, n * unknowns + 1);
    AD_TAKE(rest, room, 2 * n * unknowns + 1);
    AD_TAKE(rest, used, n + 1);
    AD_TAKE(rest, distances, n + 1);
    AD_TAKE(rest, place, n + 1);
    AD_TAKE(rest, level, (size_t)2 * LEARNED_OUTPUTS_MAX);
    AD_TAKE(rest, measured, n + 1);
    return ad_memory_status(&rest->memory, error, "out of memory for %zu measured numbers", n);
}

static void shape_nets(learned_rest *rest)
{
    const learned_asked *asked = &rest->asked;
    rest->net.inputs = asked->inputs;
    rest->net.outputs = asked->outputs;
    rest->net.hidden_count = asked->hidden_count;
    memcpy(rest->net.hidden, asked->hidden, (size_t)asked->hidden_count * sizeof *asked->hidden);
    rest->direct = rest->net;
    rest->direct.outputs = (int)rest->places;
}

ad_status learned_rest_create(const scene *open, const learned_asked *asked, learned_rest **result,
                              ad_error *error)
{
    learned_rest *rest = calloc(1, sizeof *rest);
    *result = NULL;
    if (!rest) {
        return ad_fail(error, AD_NO_MEMORY, "out of memory for a residual");
    }
    rest->open = open;
    rest->names = scene_values_of(open);
    rest->asked = *asked;
    rest->common = open->unknown_count - asked->outputs;
    rest->known = scene_known_count(open);
    ad_status status = solve_trials_create(open, asked->sets + asked->held_out, asked->measured,
                                           asked->tolerance, asked->threads, &rest->trials, error);
    status = status == AD_OK ? solve_trials_apart(rest->trials, error) : status;
    if (status == AD_OK) {
        rest->experiments = solve_trials_experiments(rest->trials);
        rest->numbers = solve_trials_residuals(rest->trials);
        status = allocate(rest, error);
    }
    if (status == AD_OK) {
        solve_trials_tell(rest->trials, rest->of);
        take_numbers(rest);
        status = take_inputs(rest, error);
        shape_nets(rest);
        list_fitted(rest);
    }
    if (status != AD_OK) {
        learned_rest_free(rest);
        return status;
    }
    *result = rest;
    return AD_OK;
}

/* ---- judging ------------------------------------------------------------------------------- */

/* Adds a row that has ended. */
static void add_row(learned_score *to, double square, double variance, double *distances)
{
    distances[to->rows++] = sqrt(square);
    to->mean += sqrt(square);
    to->rms += square;
    to->deviation += variance;
}

/* Of the rows whose numbers are those that are used, or the others. */
static learned_score score(const learned_rest *rest, const learned_fit *fit, const bool *used,
                           bool fitted)
{
    const double *r = learned_fit_residuals(fit), *deviation = learned_fit_deviations(fit);
    learned_score to = {.rows = 0};
    size_t row = SIZE_MAX;
    double square = 0, variance = 0;
    for (size_t k = 0; k < rest->numbers; k++) {
        if (used[k] != fitted) {
            continue;
        }
        if (row != SIZE_MAX && rest->row[k] != row) {
            add_row(&to, square, variance, rest->distances);
            square = variance = 0;
        }
        row = rest->row[k];
        to.numbers++;
        to.covered[0] += fabs(r[k]) <= deviation[k];
        to.covered[1] += fabs(r[k]) <= 2 * deviation[k];
        square += pow(r[k] * rest->noise[k], 2);
        variance += pow(deviation[k] * rest->noise[k], 2);
    }
    if (row != SIZE_MAX) {
        add_row(&to, square, variance, rest->distances);
        to.median = sort_median(to.rows, rest->distances);
    }
    const double rows = to.rows > 0 ? (double)to.rows : NAN;
    to.mean /= rows;
    to.rms = sqrt(to.rms / rows);
    to.deviation = sqrt(to.deviation / rows);
    for (int i = 0; i < 2; i++) {
        to.covered[i] /= to.numbers > 0 ? (double)to.numbers : NAN;
    }
    return to;
}

/* Means of what is fitted, from which a network alone begins. */
static void take_levels(learned_rest *rest, const bool *used)
{
    double *count = rest->level + LEARNED_OUTPUTS_MAX;
    memset(rest->level, 0, sizeof *rest->level * 2 * LEARNED_OUTPUTS_MAX);
    for (size_t k = 0; k < rest->numbers; k++) {
        if (used[k]) {
            rest->level[rest->place[k]] += rest->measured[k];
            count[rest->place[k]]++;
        }
    }
    for (size_t i = 0; i < rest->places; i++) {
        rest->level[i] /= fmax(1, count[i]);
    }
}

/* Physics alone, of which what is learned then begins where it ends; or a network, or both. */
static ad_status run_fit(learned_rest *rest, learned_kind kind, const bool *used,
                         const learned_settings *settings, learned_fit **fit, bool *over,
                         ad_error *error)
{
    const learned_problem problem = {.experiments = rest->experiments,
                                     .numbers = rest->numbers,
                                     .of = rest->of,
                                     .x = rest->x,
                                     .is_linear = kind == LEARNED_NETWORK,
                                     .is_ordered = rest->open->memory_count > 0,
                                     .common = kind == LEARNED_NETWORK ? 0 : rest->common,
                                     .solve = kind == LEARNED_PHYSICS   ? solve_physics
                                              : kind == LEARNED_NETWORK ? solve_directly
                                                                        : solve_both,
                                     .look = kind == LEARNED_BOTH && rest->moves ? look : NULL,
                                     .context = rest};
    if (kind == LEARNED_NETWORK) {
        memcpy(rest->direct.middle, rest->net.middle, sizeof rest->net.middle);
        memcpy(rest->direct.half, rest->net.half, sizeof rest->net.half);
        take_levels(rest, used);
    }
    const double zero[MAX] = {0};
    ad_status status = rest->moves ? look(rest, zero, rest->x, NULL, error) : AD_OK;
    learned_net *nets[] = {NULL, &rest->direct, &rest->net};
    if (status == AD_OK) {
        status = learned_fit_create(&problem, nets[kind], used, settings, fit, error);
    }
    status = status == AD_OK ? learned_fit_run(*fit, over, error) : status;
    for (int i = 0; status == AD_OK && kind == LEARNED_PHYSICS && i < rest->common; i++) {
        rest->from[i] += learned_fit_numbers(*fit)[i];
    }
    return status;
}

/* A network alone is made of places that experiments share; physics alone of other unknowns. */
static bool is_made(const learned_rest *rest, learned_kind kind)
{
    return kind != LEARNED_NETWORK || is_plain(rest);
}

ad_status learned_rest_run(learned_rest *rest, learned_kind kind, learned_result *result,
                           bool *over, ad_error *error)
{
    learned_fit *fit = NULL;
    learned_settings settings = rest->asked.fit;
    const double start = clock_seconds(CLOCK_MONOTONIC);
    *result = (learned_result){.made = is_made(rest, kind)};
    *over = true;
    if (!result->made) {
        return AD_OK;
    }
    settings.runner = kind == LEARNED_BOTH ? settings.runner : NULL;
    const ad_status status = run_fit(rest, kind, rest->used, &settings, &fit, over, error);
    if (status == AD_OK && *over) {
        result->trained = score(rest, fit, rest->used, true);
        result->held_out = score(rest, fit, rest->used, false);
        result->report = learned_fit_report(fit);
        result->seconds = clock_seconds(CLOCK_MONOTONIC) - start;
    }
    if (status == AD_OK && *over && kind == LEARNED_BOTH) {
        double slope;
        for (int i = 0; i < rest->common; i++) {
            rest->found[i] = common_value(rest, i, learned_fit_numbers(fit)[i], &slope);
        }
        learned_fit_free(rest->last);
        rest->last = fit;
        fit = NULL;
    }
    learned_fit_free(fit);
    return status;
}

/* ---- leaving out --------------------------------------------------------------------------- */

/* The next choice of `count` ascending numbers below n; false: there is none. */
static bool next_choice(int count, size_t n, size_t *choice)
{
    for (int i = count - 1; i >= 0; i--) {
        if (choice[i] + (size_t)(count - i) < n) {
            choice[i]++;
            for (int k = i + 1; k < count; k++) {
                choice[k] = choice[k - 1] + 1;
            }
            return true;
        }
    }
    return false;
}

static void draw_choice(nn_rng *rng, int count, size_t n, size_t *choice)
{
    for (int i = 0; i < count; i++) {
        bool fresh;
        do {
            choice[i] = (size_t)nn_rng_below(rng, n);
            fresh = true;
            for (int k = 0; k < i; k++) {
                fresh = fresh && choice[k] != choice[i];
            }
        } while (!fresh);
    }
}

static ad_status leave_out(learned_rest *rest, int count, const size_t *choice,
                           double distance[LEARNED_KINDS], ad_error *error)
{
    bool *used = malloc(2 * (rest->numbers + 1) * sizeof *used), *left = used + rest->numbers;
    learned_settings settings = rest->asked.fit;
    double from[MAX];
    memcpy(from, rest->from, sizeof from);
    ad_status status =
        used ? AD_OK : ad_fail(error, AD_NO_MEMORY, "out of memory for what is left out");
    settings.runner = NULL;
    settings.deviations = false;
    for (size_t k = 0; status == AD_OK && k < rest->numbers; k++) {
        used[k] = rest->used[k];
        for (int i = 0; i < count; i++) {
            used[k] = used[k] && rest->of[k] != rest->fitted[choice[i]];
        }
        left[k] = rest->used[k] && !used[k]; /* and not what nobody was to fit */
    }
    for (int kind = 0; kind < LEARNED_KINDS && status == AD_OK; kind++) {
        learned_fit *fit = NULL;
        bool over;
        distance[kind] = NAN;
        if (!is_made(rest, (learned_kind)kind)) {
            continue;
        }
        status = run_fit(rest, (learned_kind)kind, used, &settings, &fit, &over, error);
        if (status == AD_OK) {
            distance[kind] = score(rest, fit, left, true).mean;
        }
        learned_fit_free(fit);
    }
    memcpy(rest->from, from, sizeof from);
    free(used);
    return status;
}

ad_status learned_rest_leave_out(learned_rest *rest, int count, int most, double **distance,
                                 int *choices, ad_error *error)
{
    enum { COUNT_MAX = 64 };
    const size_t n = rest->fitted_experiments;
    size_t choice[COUNT_MAX];
    nn_rng rng = nn_rng_split(rest->asked.fit.seed, "left out");
    double all = 1;
    *choices = 0;
    *distance = NULL;
    if (count >= COUNT_MAX || n < (size_t)count + 2) {
        return ad_fail(error, AD_BAD_INPUT, "%zu experiments are fitted; allowed: 1 to %d left out",
                       n, n > 3 ? (int)fmin((double)n - 2, COUNT_MAX - 1) : 1);
    }
    for (int i = 0; i < count; i++) {
        all *= (double)(n - (size_t)i) / (i + 1);
        choice[i] = (size_t)i;
    }
    const bool each = all <= most;
    const int total = each ? (int)lround(all) : most;
    *distance = malloc((size_t)total * LEARNED_KINDS * sizeof **distance);
    ad_status status =
        *distance ? AD_OK : ad_fail(error, AD_NO_MEMORY, "out of memory for what is left out");
    for (int i = 0; i < total && status == AD_OK; i++) {
        if (!each) {
            draw_choice(&rng, count, n, choice);
        }
        status = leave_out(rest, count, choice, *distance + i * LEARNED_KINDS, error);
        *choices = i + 1;
        next_choice(count, n, choice);
    }
    return status;
}
