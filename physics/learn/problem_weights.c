/* Weights that follow training: causal by slice of time, balanced by term. The equations stand in
 * problem.h. */
#include "physics/learn/problem_internal.h"

#include "physics/numerics/vector_size.h"

#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

/* A term whose gradient vanishes would get all the weight there is. */
static const double least_share = 1e-6;

/* ---- making ---------------------------------------------------------------------------------- */

const char *problem_weights_check(const problem_settings *settings, const physics_model *m)
{
    if (settings->causal_slices < 0 || (settings->causal_slices > 0 && m->domain.time < 0)) {
        return "causal_slices: at least 0, and 0 in a static scene";
    }
    if (settings->causal_slices > 0 && (settings->causal_epsilon_count < 1 ||
                                        settings->causal_epsilon_count > PROBLEM_EPSILONS_MAX ||
                                        settings->causal_update_every < 1)) {
        return "causal_epsilon_count: 1 to 16, causal_update_every: at least 1";
    }
    if (settings->balance_every < 1 ||
        !(settings->balance_memory >= 0 && settings->balance_memory < 1)) {
        return "balance_every: at least 1, balance_memory: 0 to below 1";
    }
    return NULL;
}

bool problem_weights_create(problem *p)
{
    int slices = p->settings.causal_slices;
    if (slices == 0) {
        return true;
    }
    p->slice_weights = malloc((size_t)slices * sizeof *p->slice_weights);
    p->slice_losses = calloc((size_t)slices, sizeof *p->slice_losses);
    p->slice_points = calloc((size_t)slices, sizeof *p->slice_points);
    return p->slice_weights && p->slice_losses && p->slice_points;
}

void problem_weights_start(problem *p)
{
    for (int i = 0; i < p->settings.causal_slices; i++) {
        p->slice_weights[i] = i == 0; /* until the first update only the first slice counts */
    }
    p->epsilon_index = 0;
    for (int i = 0; i < PROBLEM_TERMS; i++) {
        p->balance[i] = 1;
    }
    p->balance_updates = 0;
}

void problem_weights_free(problem *p)
{
    free(p->slice_weights);
    free(p->slice_losses);
    free(p->slice_points);
}

ad_status problem_set_weigh_points(problem *p, problem_set *set, ad_error *error)
{
    size_t count = set->trained.count;
    if (p->settings.balance) {
        set->balance = p->balance + set->terms[0];
    }
    if (set->about->points != MODEL_INTERIOR || !p->settings.causal_slices) {
        return AD_OK;
    }
    set->point_weights = calloc(count, sizeof *set->point_weights);
    set->point_losses = calloc(count, sizeof *set->point_losses);
    return set->point_weights && set->point_losses
               ? AD_OK
               : ad_fail(error, AD_NO_MEMORY, "out of memory for the weights of points");
}

size_t problem_weights_per_point(const problem_set *set)
{
    return (set->point_weights != NULL) + (set->point_losses != NULL);
}

static int slice_at(const problem *p, double t)
{
    double passed = (t - p->setting.window[0]) / p->setting.window[1];
    int slice = (int)(passed * p->settings.causal_slices);
    int last = p->settings.causal_slices - 1;
    return slice < 0 ? 0 : slice > last ? last : slice;
}

void problem_weights_spread(problem *p)
{
    for (int k = 0; k < p->set_count; k++) {
        problem_set *set = &p->sets[k];
        for (size_t i = 0; set->point_weights && i < set->trained.count; i++) {
            const int slice = slice_at(p, problem_time_of(p, &set->trained, i));
            set->point_weights[i] = p->slice_weights[slice];
        }
    }
}

/* ---- causal ---------------------------------------------------------------------------------- */

/* w_i = exp(-epsilon sum_{k<i} L_k) from the losses at the points of the last evaluation. */
void problem_weights_follow_time(problem *p)
{
    problem_set *set = &p->sets[0];
    int slices = p->settings.causal_slices;
    memset(p->slice_losses, 0, (size_t)slices * sizeof *p->slice_losses);
    memset(p->slice_points, 0, (size_t)slices * sizeof *p->slice_points);
    for (size_t i = 0; i < set->trained.count; i++) {
        int slice = slice_at(p, problem_time_of(p, &set->trained, i));
        p->slice_losses[slice] += set->point_losses[i];
        p->slice_points[slice]++;
    }
    double before = 0, least = 1;
    for (int i = 0; i < slices; i++) {
        p->slice_weights[i] = exp(-p->settings.causal_epsilon[(int)p->epsilon_index] * before);
        least = fmin(least, p->slice_weights[i]);
        before += p->slice_points[i] ? p->slice_losses[i] / p->slice_points[i] : 0;
    }
    if (least > p->settings.causal_threshold &&
        (int)p->epsilon_index + 1 < p->settings.causal_epsilon_count) {
        p->epsilon_index++;
    }
    problem_weights_spread(p);
}

double problem_causal_epsilon(const problem *p)
{
    return p->settings.causal_slices ? p->settings.causal_epsilon[(int)p->epsilon_index] : 0;
}

double problem_causal_least_weight(const problem *p)
{
    double least = 1;
    for (int i = 0; i < p->settings.causal_slices; i++) {
        least = fmin(least, p->slice_weights[i]);
    }
    return least;
}

/* ---- balanced -------------------------------------------------------------------------------- */

/* b_i = sum_j |g_j| / |g_i|; the first time as it is, then with memory. */
static ad_status balance(problem *p, const double *x, ad_error *error)
{
    double norms[PROBLEM_TERMS], sum = 0, value;
    for (int i = 0; i < p->term_count; i++) {
        ad_status status = problem_set_run_term(p, problem_set_of_term(p, i), i, true, x, &value,
                                                p->scratch, error);
        if (status != AD_OK) {
            return status;
        }
        norms[i] = p->terms[i]->weight * sqrt(vector_square(p->parameters, p->scratch));
        sum += norms[i];
    }
    if (!isfinite(sum)) {
        return ad_fail(error, AD_NOT_FINITE, "the gradient of a loss term is not finite");
    }
    double memory = p->balance_updates > 0 ? p->settings.balance_memory : 0;
    for (int i = 0; sum > 0 && i < p->term_count; i++) {
        double now = sum / fmax(norms[i], least_share * sum);
        p->balance[i] = memory * p->balance[i] + (1 - memory) * now;
    }
    p->balance_updates++;
    return AD_OK;
}

double problem_balance_weight(const problem *p, int term)
{
    return p->balance[term];
}

ad_status problem_reweigh(problem *p, int64_t step, const double *x, bool *changed, ad_error *error)
{
    const problem_settings *settings = &p->settings;
    *changed =
        settings->balance && (p->balance_updates == 0 || (step - 1) % settings->balance_every == 0);
    return *changed ? balance(p, x, error) : AD_OK;
}

/* ---- state ----------------------------------------------------------------------------------- */

static problem_array array_of(const char *name, double *data, size_t count)
{
    problem_array array = {.data = data, .rows = 1, .columns = count};
    snprintf(array.name, sizeof array.name, "%s", name);
    return array;
}

int problem_weights_state(problem *p, problem_array *arrays)
{
    int count = 0;
    if (p->settings.causal_slices) {
        size_t slices = (size_t)p->settings.causal_slices, points = p->sets[0].trained.count;
        problem_set *set = &p->sets[0];
        arrays[count++] = array_of("causal/weights", p->slice_weights, slices);
        arrays[count++] = array_of("causal/epsilon_index", &p->epsilon_index, 1);
        arrays[count++] = array_of("causal/point_weights", set->point_weights, points);
        arrays[count++] = array_of("causal/point_losses", set->point_losses, points);
    }
    if (p->settings.balance) {
        arrays[count++] = array_of("balance/weights", p->balance, (size_t)p->term_count);
        arrays[count++] = array_of("balance/updates", &p->balance_updates, 1);
    }
    return count;
}

/* Infinity as `high` allows what is finite. */
static bool within(const double *x, size_t count, double low, double high)
{
    for (size_t i = 0; i < count; i++) {
        if (!(x[i] >= low && x[i] <= high && isfinite(x[i]))) {
            return false;
        }
    }
    return true;
}

static const char *causal_fault(const problem *p)
{
    const problem_set *set = &p->sets[0];
    if (!(p->epsilon_index >= 0 && p->epsilon_index < p->settings.causal_epsilon_count)) {
        return "causal/epsilon_index is out of range";
    }
    return within(p->slice_weights, (size_t)p->settings.causal_slices, 0, 1) &&
                   within(set->point_weights, set->trained.count, 0, 1) &&
                   within(set->point_losses, set->trained.count, 0, INFINITY)
               ? NULL
               : "a causal weight lies outside 0 to 1, or a loss below 0";
}

ad_status problem_weights_restored(problem *p, ad_error *error)
{
    const char *fault = p->settings.causal_slices ? causal_fault(p) : NULL;
    if (!within(p->balance, PROBLEM_TERMS, 0, INFINITY) ||
        !within(&p->balance_updates, 1, 0, INFINITY)) {
        fault = "a balanced weight or its count lies below 0 or is not finite";
    }
    return fault ? ad_fail(error, AD_BAD_INPUT, "checkpoint: %s", fault) : AD_OK;
}
