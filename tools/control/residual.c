#include "tools/control/residual_internal.h"

#include "nn/rng.h"
#include "tools/train/least_squares.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

ad_status residual_create(const one_step *of, int units, const double *size, const double *middle,
                          const double *half, residual **result, ad_error *error)
{
    const size_t n = (size_t)of->states, m = (size_t)of->inputs, k = (size_t)units;
    residual *x = calloc(1, sizeof *x);
    double *all = calloc(2 * n + 3 * m + k + k * (1 + n + m) + n * k + 1, sizeof *all);
    *result = x;
    if (!x || !all) {
        free(x);
        free(all);
        *result = NULL;
        return ad_fail(error, AD_NO_MEMORY, "out of memory for a residual of %d units", units);
    }
    *x = (residual){.of = *of, .states = n, .inputs = m, .units = k, .seen = n + m, .size = all};
    x->middle = x->size + n;
    x->half = x->middle + m;
    x->z = x->half + m;
    x->t = x->z + n + m;
    x->numbers = x->t + k;
    memcpy(x->size, size, n * sizeof *size);
    memcpy(x->middle, middle, m * sizeof *middle);
    memcpy(x->half, half, m * sizeof *half);
    return AD_OK;
}

void residual_free(residual *residual)
{
    if (residual) {
        free(residual->size);
        free(residual);
    }
}

size_t residual_count(const residual *residual)
{
    return residual->units * (1 + residual->seen + residual->states);
}

/* ---- a step -------------------------------------------------------------------------------- */

static const double *w1_of(const residual *residual)
{
    return residual->numbers + residual->units;
}

static const double *w2_of(const residual *residual)
{
    return residual->numbers + residual->units * (1 + residual->seen);
}

/* Adds the network to next; leaves what it saw in residual->z and tanh in residual->t. */
static void add_network(residual *residual, double h, const double *state, const double *inputs,
                        double *next)
{
    const double *w1 = w1_of(residual), *w2 = w2_of(residual);
    for (size_t i = 0; i < residual->seen; i++) {
        const size_t input = i - residual->states;
        residual->z[i] = i < residual->states
                             ? state[i] / residual->size[i]
                             : (inputs[input] - residual->middle[input]) / residual->half[input];
    }
    for (size_t u = 0; u < residual->units; u++) {
        double sum = residual->numbers[u];
        for (size_t i = 0; i < residual->seen; i++) {
            sum += w1[u * residual->seen + i] * residual->z[i];
        }
        residual->t[u] = tanh(sum);
    }
    for (size_t r = 0; r < residual->states; r++) {
        double sum = 0;
        for (size_t u = 0; u < residual->units; u++) {
            sum += w2[r * residual->units + u] * residual->t[u];
        }
        next[r] += h * residual->size[r] * sum;
    }
}

/* Of the network where it was added, to by [states][count], by those of its inputs from `first`. */
static void add_derivatives(const residual *residual, double h, size_t first, size_t count,
                            double *by)
{
    const double *w1 = w1_of(residual), *w2 = w2_of(residual);
    for (size_t r = 0; r < residual->states; r++) {
        for (size_t u = 0; u < residual->units; u++) {
            const double rise = h * residual->size[r] * w2[r * residual->units + u] *
                                (1 - residual->t[u] * residual->t[u]);
            for (size_t i = 0; i < count; i++) {
                const double unit = first == 0 ? residual->size[i] : residual->half[i];
                by[r * count + i] += rise * w1[u * residual->seen + first + i] / unit;
            }
        }
    }
}

static int advance(void *context, int count, double h, const double *states, const double *inputs,
                   const double *after, double *next, double *by_state, double *by_inputs)
{
    residual *residual = context;
    const size_t n = residual->states, m = residual->inputs;
    int failed = residual->of.advance(residual->of.context, count, h, states, inputs, after, next,
                                      by_state, by_inputs);
    for (size_t i = 0; i < (size_t)count && !failed; i++) {
        add_network(residual, h, states + i * n, inputs + i * m, next + i * n);
        if (by_state) {
            add_derivatives(residual, h, 0, n, by_state + i * n * n);
        }
        if (by_inputs) {
            add_derivatives(residual, h, n, m, by_inputs + i * n * m);
        }
    }
    return failed;
}

static double outside(void *context, const double *state, const double *inputs)
{
    const residual *residual = context;
    return residual->of.outside(residual->of.context, state, inputs);
}

one_step residual_one_step(residual *residual)
{
    one_step result = residual->of;
    result.context = residual;
    result.advance = advance;
    result.outside = residual->of.outside ? outside : NULL;
    return result;
}

/* ---- runs ---------------------------------------------------------------------------------- */

typedef struct fitting {
    residual *of;
    one_step model;
    double h, noise;
    const one_observation *observation;
    size_t runs, held_out, values, count;
    const residual_run *run;
    double *room; /* as roll says */
    least_squares ls;
    uint64_t seed;
    double *best; /* [count], of the network to be taken */
    double lowest;
} fitting;

/* The change of the next state by each number [states][count]: the model's own times that of the
 * state, and that of the network by its numbers. */
static void push(const fitting *fit, const double *by_state, const double *before, double *after)
{
    const residual *net = fit->of;
    const size_t n = net->states, k = net->units, count = fit->count;
    memset(after, 0, n * count * sizeof *after);
    for (size_t r = 0; r < n; r++) {
        double *to = after + r * count;
        for (size_t c = 0; c < n; c++) {
            const double by = by_state[r * n + c], *from = before + c * count;
            for (size_t i = 0; i < count; i++) {
                to[i] += by * from[i];
            }
        }
        for (size_t u = 0; u < k; u++) {
            const double by = fit->h * net->size[r], t = net->t[u];
            const double rise = by * w2_of(net)[r * k + u] * (1 - t * t);
            to[u] += rise;
            for (size_t i = 0; i < net->seen; i++) {
                to[k + u * net->seen + i] += rise * net->z[i];
            }
            to[k * (1 + net->seen) + r * k + u] += by * t;
        }
    }
}

/* Adds the rows of one sample, J = what is seen by the state, times its changes. */
static void add_rows(fitting *fit, const double *seen, const double *found, const double *by_state,
                     const double *change, double *row)
{
    const size_t n = fit->of->states, count = fit->count;
    for (size_t v = 0; v < fit->values; v++) {
        if (!isfinite(seen[v])) {
            continue;
        }
        const double off = (found[v] - seen[v]) / fit->noise;
        memset(row, 0, count * sizeof *row);
        for (size_t c = 0; c < n; c++) {
            const double by = by_state[v * n + c] / fit->noise, *from = change + c * count;
            for (size_t i = 0; i < count && by != 0; i++) {
                row[i] += by * from[i];
            }
        }
        for (size_t i = 0; i < count; i++) {
            double *to = fit->ls.jtj + i * count;
            fit->ls.jtr[i] += row[i] * off;
            for (size_t j = i; j < count; j++) {
                to[j] += row[i] * row[j];
            }
        }
    }
}

static size_t room_for(size_t states, size_t inputs, size_t values, size_t count)
{
    return 2 * states + states * states + states * inputs + values * (1 + states) +
           (2 * states + 1) * count;
}

/* The sum of squares of what is missed on a run, by the noise, and how many there are; where
 * `derive`, the rows of all samples as well. Infinite: no answer. */
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
        }
        if (derive) {
            add_rows(fit, seen, found, seen_by, change, row);
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
            push(fit, by_state, change, other);
            change = other;
            other = swap;
        }
        memcpy(state, next, n * sizeof *state);
    }
    return isfinite(sum) ? sum : INFINITY;
}

double residual_error(const one_step *model, double h, const one_observation *observation,
                      size_t runs, const residual_run *run)
{
    const size_t n = (size_t)model->states;
    fitting x = {.model = *model,
                 .h = h,
                 .noise = 1,
                 .observation = observation,
                 .values = (size_t)observation->values};
    size_t samples = 0;
    double sum = 0;
    x.room = malloc(room_for(n, (size_t)model->inputs, x.values, 0) * sizeof *x.room);
    for (size_t i = 0; i < runs && x.room; i++) {
        sum += roll(&x, &run[i], false, &samples);
    }
    free(x.room);
    return x.room ? sqrt(sum / (double)samples) : INFINITY;
}

/* ---- Levenberg-Marquardt ------------------------------------------------------------------- */

/* Over the runs from `first` to before `end`. */
static double sum_over(fitting *fit, size_t first, size_t end, bool derive)
{
    size_t samples = 0;
    double sum = 0;
    for (size_t i = first; i < end && isfinite(sum); i++) {
        sum += roll(fit, &fit->run[i], derive, &samples);
    }
    return sum;
}

/* And what the numbers of the network cost, whose squares keep them small. */
static double add_numbers(const fitting *fit)
{
    double sum = 0;
    for (size_t i = 0; i < fit->count; i++) {
        sum += fit->of->numbers[i] * fit->of->numbers[i];
    }
    return sum;
}

static int sum(void *context, const double *p, double *value, least_squares *to)
{
    fitting *fit = context;
    const size_t n = fit->count;
    memcpy(fit->of->numbers, p, n * sizeof *p);
    *value = sum_over(fit, 0, fit->runs - fit->held_out, to != NULL) + add_numbers(fit);
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
    memcpy(fit->of->numbers, p, fit->count * sizeof *p);
    const size_t trained = fit->runs - fit->held_out;
    const double off = fit->held_out > 0 ? sum_over(fit, trained, fit->runs, false) : -(double)step;
    fit->ls.fit.held_out = fit->held_out > 0 ? off * (double)trained / (double)fit->held_out : NAN;
    if (off < fit->lowest) {
        fit->lowest = off;
        memcpy(fit->best, p, fit->count * sizeof *p);
    }
}

static ad_status begin(void *context, double *p, ad_error *error)
{
    fitting *fit = context;
    nn_rng rng = nn_rng_split(fit->seed, "residual");
    (void)error;
    for (size_t i = 0; i < fit->count; i++) { /* W2 = 0: it begins as the model */
        const bool hidden = i < fit->of->units * (1 + fit->of->seen);
        p[i] = hidden ? nn_rng_normal(&rng) / sqrt((double)fit->of->seen) : 0;
    }
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
                 .seed = settings->seed,
                 .lowest = INFINITY};
    x.best = malloc(count * sizeof *x.best);
    x.room = malloc(room_for(net->states, net->inputs, values, count) * sizeof *x.room);
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
    status = status == AD_OK ? least_squares_run(&x.ls, settings->runner, error) : status;
    if (status == AD_OK && x.ls.fit.state == FIT_OVER) {
        memcpy(net->numbers, x.best, count * sizeof *x.best);
        status = isfinite(x.lowest) ? AD_OK : no_answer(error);
    }
    free(x.best);
    free(x.room);
    least_squares_clear(&x.ls);
    return status;
}
