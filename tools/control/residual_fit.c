/* A residual trained through the steps of whole runs, and what these leave open of it. */
#include "tools/control/residual_internal.h"

#include "tools/train/least_squares.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

/* ---- runs ---------------------------------------------------------------------------------- */

typedef struct fitting {
    residual *of;
    one_step model;
    double h, noise;
    const one_observation *observation;
    size_t runs, held_out, values, count;
    const residual_run *run;
    double *room; /* as roll says */
    void (*take)(struct fitting *fit, double off, const double *row);
    double *last;    /* [values] what was missed of a run's sample before; NULL: it is not asked */
    double products; /* of these with what is missed */
    double *spread; /* [2][states][states] covariance if each step were off anew; NULL: not asked */
    double *shift;  /* [count] of the numbers, by which rows are moved; NULL: none */
    double *pairs;  /* [][2] squares of what is missed, variances by the numbers; NULL: not asked */
    size_t pair;
    bool looks;     /* at what is seen by the state, for the mean */
    double sums[2]; /* of variances of what is seen: by the numbers, and by `spread` */
    residual_score *score;
    least_squares ls;
    uint64_t seed;
    double *best; /* [count], of the network to be taken */
    double lowest;
} fitting;

/* Adds to J^T J and J^T r. */
static void add_row(fitting *fit, double off, const double *row)
{
    const size_t count = fit->count;
    for (size_t i = 0; i < count; i++) {
        double *to = fit->ls.jtj + i * count;
        fit->ls.jtr[i] += row[i] * off;
        for (size_t j = i; j < count; j++) {
            to[j] += row[i] * row[j];
        }
    }
}

/* What the numbers of the network leave open of what is seen, over the noise. */
static void add_variance(fitting *fit, double off, const double *row)
{
    double variance = 0;
    for (size_t i = 0; i < fit->count; i++) {
        const double *from = fit->of->covariance + i * fit->count;
        double product = 0;
        for (size_t j = 0; j < fit->count; j++) {
            product += from[j] * row[j];
        }
        variance += row[i] * product;
    }
    fit->sums[0] += variance;
    for (size_t i = 0; i < fit->count && fit->shift; i++) {
        off += row[i] * fit->shift[i];
    }
    if (fit->pairs) {
        fit->pairs[2 * fit->pair] = off * off;
        fit->pairs[2 * fit->pair++ + 1] = variance;
    }
    if (fit->score) {
        const double all = variance + pow(fit->of->noise / fit->noise, 2);
        fit->score->rms += off * off;
        fit->score->deviation += all;
        fit->score->covered[0] += off * off <= all;
        fit->score->covered[1] += off * off <= 4 * all;
    }
}

/* The same, if each step were off anew. */
static void add_spread(fitting *fit, const double *by)
{
    const size_t n = fit->of->states;
    for (size_t r = 0; r < n; r++) {
        for (size_t c = 0; c < n && by[r] != 0; c++) {
            fit->sums[1] += by[r] * fit->spread[r * n + c] * by[c] / (fit->noise * fit->noise);
        }
    }
}

/* The rows of one sample, J = what is seen by the state, times its changes. */
static void take_rows(fitting *fit, const double *seen, const double *found, const double *by_state,
                      const double *change, double *row)
{
    const size_t n = fit->of->states, count = fit->count;
    for (size_t v = 0; v < fit->values; v++) {
        if (!isfinite(seen[v])) {
            continue;
        }
        memset(row, 0, count * sizeof *row);
        for (size_t c = 0; c < n; c++) {
            const double by = by_state[v * n + c] / fit->noise, *from = change + c * count;
            for (size_t i = 0; i < count && by != 0; i++) {
                row[i] += by * from[i];
            }
        }
        fit->take(fit, (found[v] - seen[v]) / fit->noise, row);
        if (fit->spread) {
            add_spread(fit, by_state + v * n);
        }
        for (size_t c = 0; c < n && fit->looks; c++) {
            fit->of->sight[v * n + c] += by_state[v * n + c];
        }
    }
}

/* To A P A^T, and the doubt of the step. */
static void widen(const fitting *fit, const double *by_state, const double *change)
{
    residual *net = fit->of;
    const size_t n = net->states;
    double *now = fit->spread, *half = now + n * n;
    ad_dense_multiply(net->pool, false, true, n, n, n, now, by_state, 0, half);
    residual_doubt(net, fit->h, change, now);
    ad_dense_multiply(net->pool, false, false, n, n, n, by_state, half, 1, now);
}

static size_t room_for(size_t states, size_t inputs, size_t values, size_t count)
{
    return 2 * states + states * states + states * inputs + values * (1 + states) +
           (2 * states + 1) * count;
}

/* The sum of squares of what is missed on a run, by the noise, and how many there are; where
 * `derive`, the rows of all samples are taken as well. Infinite: no answer. */
static double roll(fitting *fit, const residual_run *run, bool derive, size_t *samples)
{
    const size_t n = (size_t)fit->model.states, m = (size_t)fit->model.inputs, values = fit->values;
    double *state = fit->room, *next = state + n, *by_state = next + n, *found, *seen_by, *change;
    found = by_state + n * n;
    seen_by = found + values;
    change = seen_by + values * n;
    double *other = change + n * fit->count, *row = other + n * fit->count, sum = 0;
    memcpy(state, run->start, n * sizeof *state);
    if (derive) {
        memset(change, 0, n * fit->count * sizeof *change);
    }
    if (derive && fit->spread) {
        memset(fit->spread, 0, n * n * sizeof *fit->spread);
    }
    for (size_t k = 0; k < run->count; k++) {
        const double *inputs = run->inputs + k * m, *seen = run->seen + k * values;
        if (fit->observation->see(fit->observation->context, 1, state, inputs, found,
                                  derive ? seen_by : NULL)) {
            return INFINITY;
        }
        for (size_t v = 0; v < values; v++) {
            const bool there = isfinite(seen[v]);
            const double off = there ? (found[v] - seen[v]) / fit->noise : 0;
            sum += off * off;
            *samples += there;
            if (fit->last) {
                fit->products += k > 0 ? off * fit->last[v] : 0;
                fit->last[v] = off;
            }
        }
        if (derive) {
            take_rows(fit, seen, found, seen_by, change, row);
        }
        if (k + 1 == run->count) {
            break;
        }
        if (fit->model.advance(fit->model.context, 1, fit->h, state, inputs, NULL, next,
                               derive ? by_state : NULL, NULL)) {
            return INFINITY;
        }
        if (derive) {
            double *swap = change;
            if (!residual_push(fit->of, fit->h, state, inputs, by_state, change, other)) {
                return INFINITY;
            }
            if (fit->spread) {
                widen(fit, by_state, other);
            }
            change = other;
            other = swap;
        }
        memcpy(state, next, n * sizeof *state);
    }
    return isfinite(sum) ? sum : INFINITY;
}

/* Of every so manieth run from `first` to before `end`. */
static double roll_runs(fitting *fit, size_t first, size_t end, size_t every, bool derive,
                        size_t *samples)
{
    double sum = 0;
    for (size_t i = first; i < end && isfinite(sum); i += every) {
        sum += roll(fit, &fit->run[i], derive, samples);
    }
    return sum;
}

/* Of those that are trained on. */
static double roll_trained(fitting *fit, bool derive, size_t *samples)
{
    return roll_runs(fit, 0, fit->runs - fit->held_out, 1, derive, samples);
}

double residual_error(const one_step *model, double h, const one_observation *observation,
                      size_t runs, const residual_run *run)
{
    const size_t n = (size_t)model->states;
    fitting x = {.model = *model,
                 .h = h,
                 .noise = 1,
                 .observation = observation,
                 .run = run,
                 .values = (size_t)observation->values};
    size_t samples = 0;
    x.room = malloc(room_for(n, (size_t)model->inputs, x.values, 0) * sizeof *x.room);
    const double sum = x.room ? roll_runs(&x, 0, runs, 1, false, &samples) : INFINITY;
    free(x.room);
    return sqrt(sum / (double)samples);
}

/* ---- Levenberg-Marquardt ------------------------------------------------------------------- */

/* And what the numbers of the network cost, whose squares keep them small. */
static double add_numbers(const fitting *fit)
{
    double sum = 0;
    for (size_t i = 0; i < fit->count; i++) {
        sum += fit->of->theta[i] * fit->of->theta[i];
    }
    return sum;
}

static int sum(void *context, const double *p, double *value, least_squares *to)
{
    fitting *fit = context;
    const size_t n = fit->count;
    size_t samples = 0;
    memcpy(fit->of->theta, p, n * sizeof *p);
    *value = roll_trained(fit, to != NULL, &samples) + add_numbers(fit);
    for (size_t i = 0; to && i < n; i++) {
        to->jtj[i * n + i] += 1;
        to->jtr[i] += p[i];
        for (size_t j = 0; j < i; j++) {
            to->jtj[i * n + j] = to->jtj[j * n + i];
        }
    }
    return isfinite(*value) ? OPTIM_OBJECTIVE_OK : OPTIM_OBJECTIVE_NOT_FINITE;
}

/* Of the network as it is: by the runs held out; where there are none the last is the best. */
static void look_back(fitting *fit, const double *p, int64_t step)
{
    memcpy(fit->of->theta, p, fit->count * sizeof *p);
    const size_t trained = fit->runs - fit->held_out;
    size_t samples = 0;
    const double off =
        fit->held_out > 0 ? roll_runs(fit, trained, fit->runs, 1, false, &samples) : -(double)step;
    fit->ls.fit.held_out = fit->held_out > 0 ? off * (double)trained / (double)fit->held_out : NAN;
    if (off < fit->lowest) {
        fit->lowest = off;
        memcpy(fit->best, p, fit->count * sizeof *p);
    }
}

static ad_status begin(void *context, double *p, ad_error *error)
{
    fitting *fit = context;
    (void)error;
    learned_net_draw(&fit->of->net, fit->seed, p); /* outputs 0: it begins as the model */
    look_back(fit, p, 0);
    return AD_OK;
}

static ad_status no_answer(ad_error *error)
{
    return ad_fail(error, AD_BAD_INPUT, "the model has no answer on a measured run");
}

static ad_status judge(void *context, optim_status status, ad_error *error)
{
    fitting *fit = context;
    if (status == OPTIM_NOT_FINITE) {
        return no_answer(error);
    }
    if (status == OPTIM_RUNNING) { /* else it has hardly moved */
        look_back(fit, optim_x(fit->ls.by), fit->ls.fit.at.stage_step + 1);
    }
    return AD_OK;
}

static int state_of(void *context, optim_array *arrays)
{
    fitting *fit = context;
    arrays[0] = (optim_array){"best", fit->best, fit->count};
    arrays[1] = (optim_array){"lowest", &fit->lowest, 1};
    return 2;
}

static uint64_t digest_of(size_t runs, const residual_run *run, size_t inputs, size_t values)
{
    uint64_t digest = CHECKPOINT_HASH_START;
    for (size_t i = 0; i < runs; i++) {
        digest = checkpoint_hash(digest, run[i].inputs, run[i].count * inputs * sizeof(double));
        digest = checkpoint_hash(digest, run[i].seen, run[i].count * values * sizeof(double));
    }
    return digest;
}

/* ---- what it leaves open ------------------------------------------------------------------- */

static void forget(fitting *fit)
{
    memset(fit->ls.jtj, 0, fit->count * fit->count * sizeof *fit->ls.jtj);
    memset(fit->ls.jtr, 0, fit->count * sizeof *fit->ls.jtr);
}

/* Outputs are, over the sizes of their states, as large as they would have to be, always the same
 * and independent, for all that the model misses. */
static ad_status find_sizes(fitting *fit)
{
    residual *net = fit->of;
    size_t samples = 0;
    double change = 0;
    memcpy(net->net.size, net->net.half, net->states * sizeof *net->net.size);
    learned_net_draw(&net->net, fit->seed, net->theta);
    forget(fit);
    memset(net->sight, 0, fit->values * net->states * sizeof *net->sight);
    fit->looks = true;
    const double sum = roll_trained(fit, true, &samples);
    fit->looks = false;
    for (size_t i = 0; i < fit->values * net->states; i++) {
        net->sight[i] *= (double)fit->values / (double)samples;
    }
    if (!residual_turn(net)) {
        return AD_BAD_INPUT;
    }
    for (size_t r = 0; r < net->states; r++) { /* biases of outputs are the last numbers */
        change += fit->ls.jtj[(fit->count - 1 - r) * (fit->count + 1)];
    }
    for (size_t r = 0; r < net->states; r++) {
        net->net.size[r] *= change > 0 && sum > 0 ? sqrt(sum / change) : 1;
    }
    return isfinite(sum) ? AD_OK : AD_BAD_INPUT;
}

/* Squares of what is left on runs that were trained on, of each number, by the noise; and of how
 * many samples in turn one says as much as if they were off anew: of what is left with a
 * correlation p from one to the next (1 + p)/(1 - p) (Bartlett 1946). */
static double find_left(fitting *fit, size_t *samples, double *in_turn)
{
    fit->products = 0;
    fit->last = fit->of->by_theta; /* as many as there are numbers, at least */
    const double sum = roll_trained(fit, false, samples);
    fit->last = NULL;
    const double p = sum > 0 ? fmin(fmax(0, fit->products / sum), 0.99) : 0;
    *in_turn = (1 + p) / (1 - p);
    return fmax(sum / (double)*samples, 1e-12); /* more than rounding */
}

/* The covariance of the numbers, (J^T J/left + 1)^-1, where there is no other. */
static ad_status invert(fitting *fit, double left, ad_error *error)
{
    for (size_t i = 0; i < fit->count; i++) {
        for (size_t j = i; j < fit->count; j++) {
            fit->ls.jtj[i * fit->count + j] /= left;
        }
        fit->ls.jtj[i * (fit->count + 1)] += 1;
    }
    return least_squares_inverse(&fit->ls, fit->of->covariance, error);
}

/* By how much variances have to be larger for squares of what is missed to be 1 over them and the
 * noise, in the mean. */
static double factor_of(size_t count, const double *pairs, double noise)
{
    double low = log(1e-2), high = log(1e4);
    for (int step = 0; step < 50; step++) {
        const double middle = (low + high) / 2;
        double sum = 0;
        for (size_t i = 0; i < count; i++) {
            sum += pairs[2 * i] / (noise + exp(middle) * pairs[2 * i + 1]);
        }
        *(sum > (double)count ? &low : &high) = middle;
    }
    return exp(high);
}

/* Variances, so that those of runs that are left out are right: of those held out, and of each fold
 * of the others in turn, in a network that is linear around what all say. */
static ad_status calibrate(fitting *fit, double noise, double left, const double *whole,
                           ad_error *error)
{
    enum { FOLDS = 10 };
    const size_t count = fit->count, trained = fit->runs - fit->held_out;
    const size_t folds = trained < FOLDS ? trained : FOLDS;
    size_t samples = 0, again = 0;
    ad_status status = AD_OK;
    fit->pair = 0;
    for (size_t fold = 0; fold < folds && folds > 1 && status == AD_OK; fold++) {
        fit->take = add_row;
        forget(fit);
        roll_runs(fit, fold, trained, folds, true, &again);
        for (size_t i = 0; i < count * count; i++) {
            fit->ls.jtj[i] = whole[i] - fit->ls.jtj[i];
        }
        status = invert(fit, left, error);
        for (size_t i = 0; i < count; i++) {
            fit->shift[i] = 0;
            for (size_t j = 0; j < count; j++) {
                fit->shift[i] += fit->of->covariance[i * count + j] * fit->ls.jtr[j] / left;
            }
        }
        fit->take = add_variance;
        roll_runs(fit, fold, trained, folds, true, &samples);
    }
    fit->shift = NULL;
    memcpy(fit->ls.jtj, whole, count * count * sizeof *whole);
    status = status == AD_OK ? invert(fit, left, error) : status;
    fit->take = add_variance;
    roll_runs(fit, trained, fit->runs, 1, true, &samples);
    const double factor = fit->pair > 0 ? factor_of(fit->pair, fit->pairs, noise) : 1;
    for (size_t i = 0; i < count * count; i++) {
        fit->of->covariance[i] *= factor;
    }
    return status;
}

/* By the runs that were trained on. What is not known of the numbers does not change from step to
 * step: the part of it that comes anew is what leaves as much open of what is seen. */
static ad_status find_posterior(fitting *fit, ad_error *error)
{
    residual *net = fit->of;
    const size_t n = net->states, count = fit->count;
    size_t samples = 0, again = 0, numbers = 0;
    for (size_t i = 0; i < fit->runs; i++) {
        numbers += fit->run[i].count * fit->values;
    }
    double in_turn, free_ones, *room;
    room = malloc((count * count + count + 2 * n * n + 2 * numbers) * sizeof *room);
    if (!room) {
        return ad_fail(error, AD_NO_MEMORY, "out of memory for a residual");
    }
    double noise = find_left(fit, &samples, &in_turn);
    forget(fit);
    const double sum = roll_trained(fit, true, &again);
    memcpy(room, fit->ls.jtj, count * count * sizeof *room);
    ad_status status =
        isfinite(sum) && noise > 0 ? invert(fit, noise * in_turn, error) : no_answer(error);
    free_ones = (double)samples - (double)count;
    for (size_t i = 0; i < count; i++) {
        free_ones += net->covariance[i * (count + 1)];
    }
    noise *= (double)samples / fmax(1, free_ones);
    fit->shift = room + count * count;
    fit->pairs = room + count * count + count + 2 * n * n;
    status = status == AD_OK ? calibrate(fit, noise, noise * in_turn, room, error) : status;
    fit->pairs = NULL;
    fit->sums[0] = 0;
    net->noise = sqrt(noise) * fit->noise;
    net->anew = 1 / fit->h;
    fit->spread = room + count * count + count;
    net->reach.most = 0;
    roll_trained(fit, true, &again);
    net->reach = (residual_reach){.trained = net->reach.most};
    net->anew *= fit->sums[1] > 0 ? fit->sums[0] / fit->sums[1] : 1;
    free(room);
    return status == AD_OK && !(net->anew > 0 && isfinite(net->anew)) ? no_answer(error) : status;
}

static double *room_of(const residual *net, size_t values)
{
    return malloc(room_for(net->states, net->inputs, values, net->count) * sizeof(double));
}

ad_status residual_judge(residual *net, double h, const one_observation *observation, size_t runs,
                         const residual_run *run, residual_score *score, ad_error *error)
{
    fitting x = {.of = net,
                 .model = residual_one_step(net),
                 .h = h,
                 .noise = 1,
                 .observation = observation,
                 .run = run,
                 .values = (size_t)observation->values,
                 .count = net->count,
                 .take = add_variance,
                 .score = score};
    size_t samples = 0;
    *score = (residual_score){.rms = 0};
    x.room = room_of(net, x.values);
    const double sum = x.room ? roll_runs(&x, 0, runs, 1, true, &samples) : 0;
    const double count = (double)samples;
    *score = (residual_score){sqrt(score->rms / count),
                              sqrt(score->deviation / count),
                              {score->covered[0] / count, score->covered[1] / count}};
    free(x.room);
    return !x.room          ? ad_fail(error, AD_NO_MEMORY, "out of memory for a residual")
           : !isfinite(sum) ? no_answer(error)
                            : AD_OK;
}

ad_status residual_fit(residual *net, double h, const one_observation *observation, size_t runs,
                       const residual_run *run, size_t held_out, const residual_settings *settings,
                       ad_error *error)
{
    const size_t count = residual_count(net), values = (size_t)observation->values;
    fitting x = {.of = net,
                 .model = residual_one_step(net),
                 .h = h,
                 .noise = settings->noise,
                 .observation = observation,
                 .runs = runs,
                 .held_out = held_out,
                 .values = values,
                 .count = count,
                 .run = run,
                 .take = add_row,
                 .seed = settings->seed,
                 .lowest = INFINITY};
    x.best = malloc(count * sizeof *x.best);
    x.room = room_of(net, values);
    x.ls = (least_squares){.count = count,
                           .scaling = OPTIM_SCALING_DIAGONAL,
                           .sum = sum,
                           .begin = begin,
                           .judge = judge,
                           .state = state_of,
                           .context = &x,
                           .name = "residual",
                           .digest = digest_of(runs, run, net->inputs, values),
                           .every = 1,
                           .descents = 1,
                           .steps = settings->steps};
    ad_status status = least_squares_create(&x.ls, error);
    if (status == AD_OK && !(x.best && x.room)) {
        status = ad_fail(error, AD_NO_MEMORY, "out of memory for a residual");
    }
    status = status == AD_OK ? residual_see(net, values, error) : status;
    if (status == AD_OK && find_sizes(&x) != AD_OK) {
        status = no_answer(error);
    }
    status = status == AD_OK ? least_squares_run(&x.ls, settings->runner, error) : status;
    if (status == AD_OK && x.ls.fit.state == FIT_OVER) {
        memcpy(net->theta, x.best, count * sizeof *x.best);
        status = isfinite(x.lowest) ? find_posterior(&x, error) : no_answer(error);
    }
    free(x.best);
    free(x.room);
    least_squares_clear(&x.ls);
    return status;
}
