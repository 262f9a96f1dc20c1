#include "tools/train/learned_fit.h"

#include "autodiff/memory.h"
#include "nn/rng.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

/* Of squares over the mean square at the start; each a quarter of that before. */
static const double RIDGE_FIRST = 10, RIDGE_RATIO = 0.25;

/* A smaller ridge is taken where what is missed falls by more than a tenth: of fits that are as
 * good the smoothest (Breiman et al., Classification and Regression Trees, 1984, 3.4.3). */
static const double AS_GOOD = 1.1;

/* Of the fit around which residuals are linear while the ridge is chosen. */
static const double RIDGE_LOOK = 1e-2;
enum { RIDGES = 11, FOLD_STEPS = 8 };

/* The search ends after two steps in turn that lower its sum by no more than this part of it. */
static const double SETTLED = 1e-4;

/* What keeps common numbers of size 1, where nothing is measured. */
static const double RIDGE_COMMON = 1e-3;

struct learned_fit {
    learned_problem of;
    learned_net *net; /* NULL: none */
    learned_tape *tape;
    learned_settings asked;
    size_t width, count; /* of values of an experiment, of all numbers */
    double unit;         /* residuals are over it */
    double ridge;
    bool *used;       /* [numbers] by the caller */
    bool *fitted;     /* [numbers] at the moment */
    size_t *fold;     /* [experiments] */
    double *y, *dy;   /* [outputs][experiments], [theta][outputs][experiments] */
    double *dz, *dx;  /* [inputs][outputs][experiments]; [common][inputs][experiments] */
    double *values;   /* [experiments][width] */
    double *r, *by;   /* [numbers], [width][numbers] */
    double *g, *rows; /* [numbers][count] rows of J, and those that are fitted */
    double *base[3];  /* values, r, by where the problem is linear */
    bool linear;
    double *numbers, *start, *deviation, *covariance;
    double *kept; /* [count] the start, while others are tried */
    learned_report report;
    double last, still; /* the sum before the last step; steps in turn that hardly lowered it */
    least_squares ls;
    ad_error error;
    ad_memory memory;
};

size_t learned_fit_count(const learned_fit *fit)
{
    return fit->count;
}

double *learned_fit_numbers(const learned_fit *fit)
{
    return fit->numbers;
}

const double *learned_fit_residuals(const learned_fit *fit)
{
    return fit->r;
}

const double *learned_fit_deviations(const learned_fit *fit)
{
    return fit->deviation;
}

double *learned_fit_covariance(const learned_fit *fit)
{
    return fit->covariance;
}

learned_report learned_fit_report(const learned_fit *fit)
{
    return fit->report;
}

void learned_fit_free(learned_fit *fit)
{
    if (!fit) {
        return;
    }
    ad_memory_free(&fit->memory);
    learned_tape_free(fit->tape);
    free(fit);
}

static size_t outputs_of(const learned_fit *fit)
{
    return fit->net ? (size_t)fit->net->outputs : 0;
}

/* ---- residuals ----------------------------------------------------------------------------- */

/* What experiments have at these numbers. */
static ad_status spread(learned_fit *fit, const double *numbers, bool derive)
{
    const size_t points = fit->of.experiments, common = (size_t)fit->of.common;
    ad_status status = AD_OK;
    if (fit->net && fit->of.look) {
        status =
            fit->of.look(fit->of.context, numbers, fit->of.x, derive ? fit->dx : NULL, &fit->error);
    }
    if (status == AD_OK && fit->net) {
        status = learned_tape_run(fit->tape, fit->net, points, fit->of.x, numbers + common, fit->y,
                                  derive ? fit->dy : NULL, derive ? fit->dz : NULL, &fit->error);
    }
    for (size_t e = 0; status == AD_OK && e < points; e++) {
        double *to = fit->values + e * fit->width;
        memcpy(to, numbers, common * sizeof *to);
        for (size_t k = 0; k < outputs_of(fit); k++) {
            to[common + k] = fit->y[k * points + e];
        }
    }
    return status;
}

/* Around what was evaluated last, with derivatives. */
static void be_linear_around(learned_fit *fit)
{
    const size_t n = fit->of.numbers;
    memcpy(fit->base[0], fit->values, fit->of.experiments * fit->width * sizeof *fit->values);
    memcpy(fit->base[1], fit->r, n * sizeof *fit->r);
    memcpy(fit->base[2], fit->by, fit->width * n * sizeof *fit->by);
}

/* Residuals where the problem is linear. */
static void advance(learned_fit *fit)
{
    const size_t n = fit->of.numbers;
    for (size_t k = 0; k < n; k++) {
        const size_t at = fit->of.of[k] * fit->width;
        fit->r[k] = fit->base[1][k];
        for (size_t i = 0; i < fit->width; i++) {
            fit->by[i * n + k] = fit->base[2][i * n + k];
            fit->r[k] += fit->by[i * n + k] * (fit->values[at + i] - fit->base[0][at + i]);
        }
    }
}

/* How an output changes with a common number by the inputs alone, at an experiment. */
static double change_of(const learned_fit *fit, size_t output, size_t number, size_t experiment)
{
    const size_t points = fit->of.experiments, inputs = (size_t)fit->net->inputs;
    const double *by = fit->dz + output * points + experiment;
    const double *along = fit->dx + number * inputs * points + experiment;
    double sum = 0;
    for (size_t i = 0; i < inputs; i++) {
        sum += by[i * outputs_of(fit) * points] * along[i * points];
    }
    return sum;
}

/* Rows g of J, over the unit. */
static void chain(learned_fit *fit)
{
    const size_t n = fit->of.numbers, common = (size_t)fit->of.common;
    const size_t theta = fit->count - common, points = fit->of.experiments;
    memset(fit->g, 0, n * fit->count * sizeof *fit->g);
    for (size_t k = 0; k < n; k++) {
        double *row = fit->g + k * fit->count;
        for (size_t i = 0; i < common; i++) {
            row[i] = fit->by[i * n + k] / fit->unit;
        }
        for (size_t o = 0; o < outputs_of(fit); o++) {
            const double by = fit->by[(common + o) * n + k] / fit->unit;
            const double *from = fit->dy + o * points + fit->of.of[k];
            for (size_t i = 0; i < theta && by != 0; i++) {
                row[common + i] += by * from[i * outputs_of(fit) * points];
            }
            for (size_t i = 0; i < common && fit->of.look && by != 0; i++) {
                row[i] += by * change_of(fit, o, i, fit->of.of[k]);
            }
        }
    }
}

static ad_status evaluate(learned_fit *fit, const double *numbers, bool derive)
{
    ad_status status = spread(fit, numbers, derive);
    if (status == AD_OK && fit->linear) {
        advance(fit);
    } else if (status == AD_OK) {
        status = fit->of.solve(fit->of.context, fit->values, fit->r, derive ? fit->by : NULL,
                               &fit->error);
    }
    if (status == AD_OK && derive) {
        chain(fit);
    }
    return status;
}

/* ---- least squares ------------------------------------------------------------------------- */

static double ridge_of(const learned_fit *fit, size_t number)
{
    return number < (size_t)fit->of.common ? RIDGE_COMMON : fit->ridge;
}

/* J^T J and J^T r of the rows that are fitted. */
static void multiply(learned_fit *fit, least_squares *to)
{
    size_t rows = 0;
    for (size_t k = 0; k < fit->of.numbers; k++) {
        const double *row = fit->g + k * fit->count, off = fit->r[k] / fit->unit;
        if (fit->fitted[k]) {
            memcpy(fit->rows + rows++ * fit->count, row, fit->count * sizeof *row);
            for (size_t i = 0; i < fit->count; i++) {
                to->jtr[i] += row[i] * off;
            }
        }
    }
    ad_dense_gram(to->pool, rows, fit->count, fit->rows, to->jtj);
}

static int sum(void *context, const double *numbers, double *value, least_squares *to)
{
    learned_fit *fit = context;
    if (evaluate(fit, numbers, to != NULL) != AD_OK) {
        return OPTIM_OBJECTIVE_STOP;
    }
    *value = 0;
    for (size_t k = 0; k < fit->of.numbers; k++) {
        *value += fit->fitted[k] ? pow(fit->r[k] / fit->unit, 2) : 0;
    }
    if (to) {
        multiply(fit, to);
    }
    for (size_t i = 0; i < fit->count; i++) {
        *value += ridge_of(fit, i) * numbers[i] * numbers[i];
        if (to) {
            to->jtj[i * fit->count + i] += ridge_of(fit, i);
            to->jtr[i] += ridge_of(fit, i) * numbers[i];
        }
    }
    for (size_t i = 0; to && i < fit->count; i++) {
        for (size_t j = 0; j < i; j++) {
            to->jtj[i * fit->count + j] = to->jtj[j * fit->count + i];
        }
    }
    return isfinite(*value) ? OPTIM_OBJECTIVE_OK : OPTIM_OBJECTIVE_NOT_FINITE;
}

static ad_status begin(void *context, double *numbers, ad_error *error)
{
    learned_fit *fit = context;
    (void)error;
    memcpy(numbers, fit->start, fit->count * sizeof *numbers);
    fit->last = INFINITY;
    fit->still = 0;
    return AD_OK;
}

static ad_status judge(void *context, optim_status status, ad_error *error)
{
    learned_fit *fit = context;
    if (status == OPTIM_STOPPED_BY_OBJECTIVE) {
        return ad_fail(error, fit->error.status, "%s", fit->error.message);
    }
    memcpy(fit->numbers, optim_x(fit->ls.by), fit->count * sizeof *fit->numbers);
    fit->report.steps = (int)fit->ls.fit.at.stage_step + 1;
    const double now = optim_inspect(fit->ls.by).value;
    fit->still = fit->last - now > SETTLED * now ? 0 : fit->still + 1;
    fit->last = now;
    if (fit->still >= 2) {
        fit->ls.fit.reason = "settled";
    }
    return AD_OK;
}

static int state_of(void *context, optim_array *arrays)
{
    learned_fit *fit = context;
    arrays[0] = (optim_array){"numbers", fit->numbers, fit->count};
    arrays[1] = (optim_array){"last", &fit->last, 1};
    arrays[2] = (optim_array){"still", &fit->still, 1};
    return 3;
}

static ad_status search_begin(learned_fit *fit, int steps, ad_error *error)
{
    uint64_t digest = checkpoint_hash(CHECKPOINT_HASH_START, fit->base[1],
                                      fit->of.numbers * sizeof *fit->base[1]);
    digest = checkpoint_hash(digest, fit->used, fit->of.numbers * sizeof *fit->used);
    fit->ls = (least_squares){.count = fit->count,
                              .scaling = OPTIM_SCALING_DIAGONAL,
                              .sum = sum,
                              .begin = begin,
                              .judge = judge,
                              .state = state_of,
                              .context = fit,
                              .name = "residual",
                              .digest = digest,
                              .every = 1,
                              .descents = 1,
                              .steps = steps};
    return least_squares_create(&fit->ls, error);
}

/* ---- deviations ---------------------------------------------------------------------------- */

/* Factors H at the numbers, and the noise s over the unit that the fitted residuals show. */
static ad_status posterior(learned_fit *fit, double *noise, ad_error *error)
{
    double value, left = 0, trace = 0;
    size_t n = 0;
    memset(fit->ls.jtj, 0, fit->count * fit->count * sizeof *fit->ls.jtj);
    memset(fit->ls.jtr, 0, fit->count * sizeof *fit->ls.jtr);
    if (sum(fit, fit->numbers, &value, &fit->ls) != OPTIM_OBJECTIVE_OK) {
        return ad_fail(error, AD_NOT_FINITE, "there is no solution where the search ends");
    }
    const ad_status status = least_squares_inverse(&fit->ls, fit->covariance, error);
    for (size_t i = 0; status == AD_OK && i < fit->count; i++) {
        trace += 1 - ridge_of(fit, i) * fit->covariance[i * (fit->count + 1)];
    }
    for (size_t k = 0; status == AD_OK && k < fit->of.numbers; k++) {
        n += fit->fitted[k];
        left += fit->fitted[k] ? pow(fit->r[k] / fit->unit, 2) : 0;
    }
    fit->report.effective = trace;
    *noise = sqrt(left / fmax(1, (double)n - trace));
    return status;
}

/* Over the unit, of one residual. */
static double deviation_of(const learned_fit *fit, size_t k, double noise)
{
    const double *row = fit->g + k * fit->count;
    double variance = 1;
    for (size_t i = 0; i < fit->count; i++) {
        const double *from = fit->covariance + i * fit->count;
        double product = 0;
        for (size_t j = 0; j < fit->count; j++) {
            product += from[j] * row[j];
        }
        variance += row[i] * product;
    }
    return noise * sqrt(variance);
}

/* ---- cross-validation ---------------------------------------------------------------------- */

/* The fit without one fold, from where the last one ended: the squares of what it misses there,
 * over the unit, and where `deviate` over their deviations. */
static ad_status leave_out(learned_fit *fit, bool deviate, double *missed, ad_error *error)
{
    double noise = 0;
    ad_status status = search_begin(fit, FOLD_STEPS, error);
    status = status == AD_OK ? least_squares_run(&fit->ls, NULL, error) : status;
    if (status == AD_OK && deviate) {
        status = posterior(fit, &noise, error);
    } else if (status == AD_OK) {
        status = evaluate(fit, fit->numbers, false);
    }
    for (size_t k = 0; status == AD_OK && k < fit->of.numbers; k++) {
        if (fit->used[k] && !fit->fitted[k]) {
            const double by = deviate ? deviation_of(fit, k, noise) : 1;
            *missed += pow(fit->r[k] / fit->unit / by, 2);
        }
    }
    memcpy(fit->start, fit->numbers, fit->count * sizeof *fit->start);
    least_squares_clear(&fit->ls);
    return status;
}

/* One fold at all ridges, from the largest on; missed [ridges] grow. */
static ad_status leave_out_at(learned_fit *fit, size_t fold, int ridges, bool deviate,
                              double *missed, ad_error *error)
{
    ad_status status = AD_OK;
    for (size_t k = 0; k < fit->of.numbers; k++) {
        fit->fitted[k] = fit->used[k] && fit->fold[fit->of.of[k]] != fold;
    }
    memcpy(fit->start, fit->kept, fit->count * sizeof *fit->start);
    for (int i = 0; i < ridges && status == AD_OK; i++) {
        fit->ridge = RIDGE_FIRST * pow(RIDGE_RATIO, i);
        double none = 0;
        const bool last = i + 1 == ridges;
        status = leave_out(fit, deviate && last, deviate && !last ? &none : &missed[i], error);
    }
    memcpy(fit->start, fit->kept, fit->count * sizeof *fit->start);
    return status;
}

/* Of experiments that are ordered each fold has so many stretches (Burman, Chow & Nolan, Biometrika
 * 81 (1994) 351): one beside those that are fitted says little. */
enum { STRETCHES = 8 };

/* Folds of experiments that are used, dealt by the seed; those that are ordered in their order. */
static void deal(learned_fit *fit, size_t *order)
{
    nn_rng rng = nn_rng_split(fit->asked.seed, "folds");
    size_t count = 0, stretch = 1;
    for (size_t e = 0; e < fit->of.experiments; e++) {
        fit->fold[e] = SIZE_MAX;
    }
    for (size_t k = 0; k < fit->of.numbers; k++) {
        const size_t e = fit->of.of[k];
        if (fit->used[k] && fit->fold[e] == SIZE_MAX) {
            const size_t other = fit->of.is_ordered ? count : (size_t)nn_rng_below(&rng, count + 1);
            order[count++] = order[other];
            order[other] = e;
            fit->fold[e] = 0;
        }
    }
    fit->asked.folds = fit->asked.folds > (int)count ? (int)count : fit->asked.folds;
    if (fit->of.is_ordered) {
        const size_t stretches = STRETCHES * (size_t)fit->asked.folds;
        stretch = (count + stretches - 1) / stretches;
    }
    for (size_t i = 0; i < count; i++) {
        fit->fold[order[i]] = i / stretch % (size_t)fit->asked.folds;
    }
}

static ad_status try_ridges(learned_fit *fit, int ridges, bool deviate, double *missed,
                            ad_error *error)
{
    ad_status status = AD_OK;
    memset(missed, 0, RIDGES * sizeof *missed);
    for (int i = 0; i < fit->asked.folds && status == AD_OK; i++) {
        status = leave_out_at(fit, (size_t)i, ridges, deviate, missed, error);
    }
    return status;
}

static ad_status choose_ridge(learned_fit *fit, ad_error *error)
{
    size_t *order = malloc((fit->of.experiments + 1) * sizeof *order);
    double missed[RIDGES], used = 0;
    int best = 0;
    if (!order) {
        return ad_fail(error, AD_NO_MEMORY, "out of memory for a cross-validation");
    }
    deal(fit, order);
    free(order);
    for (size_t k = 0; k < fit->of.numbers; k++) {
        used += fit->used[k];
    }
    memcpy(fit->kept, fit->start, fit->count * sizeof *fit->start);
    fit->linear = true;
    ad_status status = try_ridges(fit, RIDGES, false, missed, error);
    for (int i = 1; i < RIDGES; i++) {
        best = missed[i] * AS_GOOD < missed[best] ? i : best;
    }
    fit->report.validation = sqrt(missed[best] / used) * fit->unit;
    if (status == AD_OK && fit->asked.deviations) {
        status = try_ridges(fit, best + 1, true, missed, error);
        fit->report.calibration = sqrt(missed[best] / used);
    }
    fit->ridge = fit->report.ridge = RIDGE_FIRST * pow(RIDGE_RATIO, best);
    fit->linear = false;
    return status;
}

/* ---- making, running ----------------------------------------------------------------------- */

static ad_status allocate(learned_fit *fit, const bool *used, ad_error *error)
{
    const size_t n = fit->of.numbers, points = fit->of.experiments, outputs = outputs_of(fit);
    const size_t theta = fit->count - (size_t)fit->of.common;
    const size_t inputs = fit->net ? (size_t)fit->net->inputs : 0;
    AD_TAKE(fit, y, outputs * points);
    AD_TAKE(fit, dy, outputs * theta * points);
    AD_TAKE(fit, dz, outputs * inputs * points);
    AD_TAKE(fit, dx, inputs * (size_t)fit->of.common * points);
    AD_TAKE(fit, values, points * fit->width);
    AD_TAKE(fit, r, n);
    AD_TAKE(fit, by, fit->width * n);
    AD_TAKE(fit, g, n * fit->count);
    AD_TAKE(fit, rows, n * fit->count);
    AD_TAKE(fit, kept, fit->count);
    AD_TAKE(fit, base[0], points * fit->width);
    AD_TAKE(fit, base[1], n);
    AD_TAKE(fit, base[2], fit->width * n);
    AD_TAKE(fit, numbers, fit->count);
    AD_TAKE(fit, start, fit->count);
    AD_TAKE(fit, deviation, n);
    AD_TAKE(fit, covariance, fit->count * fit->count);
    AD_TAKE(fit, used, n + 1);
    AD_TAKE(fit, fitted, n + 1);
    AD_TAKE(fit, fold, points + 1);
    if (fit->memory.is_short) {
        return ad_fail(error, AD_NO_MEMORY, "out of memory for a residual of %zu numbers", n);
    }
    memcpy(fit->used, used, n * sizeof *used);
    memcpy(fit->fitted, used, n * sizeof *used);
    return AD_OK;
}

/* Where the search begins, outputs 0: the unit, and sizes of the outputs. */
static ad_status look_at_start(learned_fit *fit, ad_error *error)
{
    const size_t n = fit->of.numbers, common = (size_t)fit->of.common;
    size_t used = 0;
    double square = 0;
    memset(fit->values, 0, fit->of.experiments * fit->width * sizeof *fit->values);
    const ad_status status =
        fit->of.solve(fit->of.context, fit->values, fit->r, fit->by, &fit->error);
    for (size_t k = 0; k < n; k++) {
        used += fit->used[k];
        square += fit->used[k] ? fit->r[k] * fit->r[k] : 0;
    }
    if (status != AD_OK) {
        return ad_fail(error, status, "%s", fit->error.message);
    }
    if (!isfinite(square) || !(square > 0)) {
        return ad_fail(error, AD_BAD_INPUT,
                       "there is no solution where the search begins, or nothing is left to learn");
    }
    fit->unit = sqrt(square / (double)used);
    for (size_t o = 0; o < outputs_of(fit); o++) {
        double change = 0;
        for (size_t k = 0; k < n; k++) {
            change += fit->used[k] ? pow(fit->by[(common + o) * n + k], 2) : 0;
        }
        fit->net->size[o] = change > 0 ? sqrt(square / change) : 1;
    }
    be_linear_around(fit);
    return AD_OK;
}

ad_status learned_fit_create(const learned_problem *problem, learned_net *net, const bool *used,
                             const learned_settings *settings, learned_fit **result,
                             ad_error *error)
{
    learned_fit *fit = calloc(1, sizeof *fit);
    *result = NULL;
    if (!fit) {
        return ad_fail(error, AD_NO_MEMORY, "out of memory for a residual");
    }
    fit->of = *problem;
    fit->net = net;
    fit->asked = *settings;
    fit->report = (learned_report){.calibration = 1, .validation = NAN};
    fit->width = (size_t)problem->common + outputs_of(fit);
    fit->count = (size_t)problem->common + (net ? learned_net_count(net) : 0);
    ad_status status = allocate(fit, used, error);
    status = status == AD_OK ? look_at_start(fit, error) : status;
    if (status == AD_OK && net) {
        learned_net_draw(net, settings->seed, fit->start + problem->common);
        status = learned_tape_create(net, &fit->tape, error);
    }
    if (status != AD_OK) {
        learned_fit_free(fit);
        return status;
    }
    *result = fit;
    return AD_OK;
}

static ad_status deviate(learned_fit *fit, ad_error *error)
{
    double noise = 0;
    const ad_status status = posterior(fit, &noise, error);
    const double scale = fit->unit * fit->report.calibration;
    fit->report.noise = noise * fit->unit;
    for (size_t k = 0; status == AD_OK && k < fit->of.numbers; k++) {
        fit->deviation[k] = scale * deviation_of(fit, k, noise);
    }
    for (size_t i = 0; status == AD_OK && i < fit->count * fit->count; i++) {
        fit->covariance[i] *= pow(noise * fit->report.calibration, 2);
    }
    return status;
}

/* A fit from the start on, around which residuals are linear from then on. */
static ad_status look(learned_fit *fit, ad_error *error)
{
    fit->ridge = RIDGE_LOOK;
    ad_status status = search_begin(fit, fit->asked.steps, error);
    status = status == AD_OK ? least_squares_run(&fit->ls, NULL, error) : status;
    if (status == AD_OK && evaluate(fit, fit->numbers, true) != AD_OK) {
        status = ad_fail(error, fit->error.status, "%s", fit->error.message);
    }
    least_squares_clear(&fit->ls);
    be_linear_around(fit);
    return status;
}

ad_status learned_fit_run(learned_fit *fit, bool *over, ad_error *error)
{
    const bool chooses = fit->net && fit->asked.folds > 1;
    ad_status status = chooses && !fit->of.is_linear ? look(fit, error) : AD_OK;
    status = status == AD_OK && chooses ? choose_ridge(fit, error) : status;
    *over = false;
    memcpy(fit->fitted, fit->used, fit->of.numbers * sizeof *fit->used);
    status = status == AD_OK ? search_begin(fit, fit->asked.steps, error) : status;
    status = status == AD_OK ? least_squares_run(&fit->ls, fit->asked.runner, error) : status;
    if (status == AD_OK && fit->ls.fit.state == FIT_OVER) {
        *over = true;
        status = fit->asked.deviations ? deviate(fit, error) : evaluate(fit, fit->numbers, false);
    }
    least_squares_clear(&fit->ls);
    return status;
}
