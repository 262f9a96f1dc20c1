#include "tools/train/robust.h"

#include "autodiff/memory.h"
#include "physics/numerics/sort.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

/* Cauchy's scale over the noise; steps end where no unknown moves by so much of its deviation. */
static const double CAUCHY = 2.385, SETTLED = 1e-3;

enum { PASSES = 50 };

/* The median of the length of a vector of as many normal numbers. */
static const double MEDIAN[] = {0, 0.67449, 1.17741, 1.53817, 1.83213};

/* What the deviations need, sums over all numbers. */
typedef struct sums {
    double numbers, weights, squares, influence, slope;
} sums;

typedef struct fit_robust {
    const scene *open;
    int sets;
    const solve_measured *measured; /* as they are */
    const bool *robust;
    solve_measured *weighted; /* the same with weights */
    solve_trials *trials;     /* without */
    double *residuals, *distances;
    sums sums;
    ad_memory memory;
} fit_robust;

/* Weights of a set whose residuals begin there; returns how many these are. */
static size_t weigh_set(fit_robust *x, int index)
{
    const solve_measured *set = &x->measured[index];
    double *weight = (double *)x->weighted[index].weight;
    const double *r = x->residuals;
    size_t used = 0;
    for (int pass = 0; pass < 2; pass++) { /* the scale, then weights */
        double scale = INFINITY;
        if (pass == 1 && x->robust[index]) {
            sort_ascending(set->rows, x->distances);
            scale = CAUCHY * x->distances[set->rows / 2];
        }
        used = 0;
        for (size_t row = 0; row < set->rows; row++) {
            const size_t count = solve_measured_residuals(x->open, set, row);
            double square = 0;
            for (size_t i = 0; i < count; i++) {
                square += r[used + i] * r[used + i];
            }
            used += count;
            if (pass == 0) {
                x->distances[row] = sqrt(square) / MEDIAN[count];
                continue;
            }
            const double far = square / (scale * scale), w = 1 / (1 + far);
            weight[row] = w;
            x->sums.numbers += (double)count;
            x->sums.weights += (double)count * w;
            x->sums.squares += w * square;
            x->sums.influence += w * w * square;
            x->sums.slope += (double)count * w - 2 * far * w * w;
        }
    }
    return used;
}

static ad_status weigh(fit_robust *x, const double *values, ad_error *error)
{
    double *all = x->residuals;
    const ad_status status = solve_trials_run(x->trials, 1, values, false, all, error);
    x->sums = (sums){0};
    for (int i = 0; i < x->sets && status == AD_OK; i++) {
        x->residuals += weigh_set(x, i);
    }
    x->residuals = all;
    return status == AD_OK && !isfinite(x->sums.squares)
               ? ad_fail(error, AD_NOT_FINITE, "there is no solution to be weighed by")
               : status;
}

static ad_status create(fit_robust *x, const identify_settings *settings, ad_error *error)
{
    size_t most = 0;
    ad_status status = solve_trials_create(x->open, x->sets, x->measured, settings->tolerance,
                                           settings->threads, &x->trials, error);
    AD_TAKE(x, weighted, x->sets);
    for (int i = 0; i < x->sets && x->weighted; i++) {
        const size_t rows = x->measured[i].rows;
        x->weighted[i] = x->measured[i];
        AD_TAKE(x, weighted[i].weight, rows);
        most = rows > most ? rows : most;
    }
    const size_t count = status == AD_OK ? solve_trials_residuals(x->trials) : 0;
    AD_TAKE(x, residuals, count);
    AD_TAKE(x, distances, most);
    return status == AD_OK ? ad_memory_status(&x->memory, error, "out of memory for weights")
                           : status;
}

/* By how many deviations the values have moved. */
static double moved(const identified *from, const identified *to)
{
    double most = 0;
    for (int i = 0; i < to->count; i++) {
        const double by = fabs(to->value[i] - from->value[i]) / to->deviation[i];
        most = by > most ? by : most; /* not of those at a bound */
    }
    return most;
}

/* Those of weighted squares take the weights for known. */
static void correct_deviations(const sums *s, identified *result)
{
    const double taken = s->squares / s->weights;
    const double is = s->influence * s->numbers / (s->slope * s->slope);
    for (int i = 0; i < result->count; i++) {
        result->deviation[i] *= sqrt(is / taken);
    }
}

ad_status identify_robust(const scene *open, int sets, const solve_measured *measured,
                          const bool *robust, const identify_settings *settings, identified *result,
                          ad_error *error)
{
    fit_robust x = {.open = open, .sets = sets, .measured = measured, .robust = robust};
    scene from = *open;
    identify_settings asked = *settings;
    asked.noise_is_scaled = true;
    ad_status status = identify(open, sets, measured, &asked, result, error);
    if (status != AD_OK || result->count == 0) {
        return status; /* it was stopped */
    }
    asked.settles = true;
    asked.runner = NULL;
    status = create(&x, settings, error);
    double by = INFINITY;
    for (int pass = 0; pass < PASSES && by > SETTLED && status == AD_OK; pass++) {
        const identified before = *result;
        memcpy(from.guess + scene_known_count(open), before.value,
               (size_t)before.count * sizeof *before.value);
        status = weigh(&x, before.value, error);
        status =
            status == AD_OK ? identify(&from, sets, x.weighted, &asked, result, error) : status;
        if (status == AD_OK) {
            by = moved(&before, result);
            result->steps += before.steps;
            result->solutions += before.solutions;
        }
    }
    if (status == AD_OK) {
        result->converged = by <= SETTLED;
        status = weigh(&x, result->value, error);
        correct_deviations(&x.sums, result);
    }
    ad_memory_free(&x.memory);
    solve_trials_free(x.trials);
    return status;
}
