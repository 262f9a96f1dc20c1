#include "tools/control/mppi.h"

#include "tools/control/controller_method.h"

#include <math.h>
#include <string.h>

typedef struct mppi {
    mppi_settings settings;
    uint64_t random;
    double spare; /* the second number of a pair */
    bool paired;
    bool violated;  /* soft limits, by one of the plans */
    double *noise;  /* [samples][moves][m] in spans */
    double *plans;  /* [samples][horizon][m] */
    double *states; /* [batch][n], twice */
    double *inputs; /* [batch][model.inputs] */
    double *seen;   /* [batch][v] */
    double *costs;  /* [samples] */
} mppi;

static mppi_settings mppi_settings_of(const controller_settings *s)
{
    mppi_settings result = {0};

    if (s->method_settings != NULL) {
        result = *(const mppi_settings *)s->method_settings;
    }
    result.samples = result.samples == 0 ? 256 : result.samples;
    result.batch = result.batch == 0 ? result.samples : result.batch;
    result.temperature = result.temperature == 0.0 ? 0.01 : result.temperature;
    result.noise = result.noise == 0.0 ? 0.05 : result.noise;
    result.memory = result.memory == 0.0 ? 0.8 : result.memory;
    result.shrink = result.shrink == 0.0 ? 0.9 : result.shrink;
    return result;
}

static const char *mppi_refusal(const controller_settings *s)
{
    const mppi_settings settings = mppi_settings_of(s);

    if (settings.samples < 2 || settings.batch < 1 || !(settings.temperature > 0.0) ||
        !(settings.noise > 0.0) || !(settings.shrink > 0.0 && settings.shrink <= 1.0) ||
        !(settings.memory > 0.0 && settings.memory < 1.0)) {
        return "sampling: at least 2 samples, temperature and noise positive, shrink up to 1, "
               "memory within 0 and 1";
    }
    return NULL;
}

static size_t mppi_layout(const controller_settings *s, void *memory, mppi *x)
{
    const mppi_settings settings = mppi_settings_of(s);
    const size_t moves = (size_t)(s->moves == 0 ? s->horizon : s->moves);
    const size_t samples = (size_t)settings.samples;
    const size_t batch = (size_t)settings.batch;
    const size_t m = (size_t)s->controlled;
    const size_t one = sizeof(double);
    size_t used = 0;

    (void)small_take(memory, &used, 1, sizeof *x);
    x->noise = small_take(memory, &used, samples * moves * m, one);
    x->plans = small_take(memory, &used, samples * (size_t)s->horizon * m, one);
    x->states = small_take(memory, &used, 2 * batch * (size_t)s->model.states, one);
    x->inputs = small_take(memory, &used, batch * (size_t)s->model.inputs, one);
    x->seen = small_take(memory, &used, batch * (size_t)s->look.values, one);
    x->costs = small_take(memory, &used, samples, one);
    return used;
}

static size_t mppi_size(const controller_settings *s)
{
    mppi x;

    return mppi_layout(s, NULL, &x);
}

static void mppi_init(controller *c, void *memory)
{
    mppi *x = memory;

    (void)mppi_layout(&c->settings, memory, x);
    x->settings = mppi_settings_of(&c->settings);
    x->random = x->settings.seed;
}

/* Uniform in (0, 1): splitmix64 (Steele, Lea, Flood 2014). */
static double mppi_uniform(mppi *x)
{
    uint64_t z = x->random += UINT64_C(0x9e3779b97f4a7c15);

    z = (z ^ (z >> 30)) * UINT64_C(0xbf58476d1ce4e5b9);
    z = (z ^ (z >> 27)) * UINT64_C(0x94d049bb133111eb);
    return ((double)((z ^ (z >> 31)) >> 12) + 0.5) * 0x1p-52;
}

/* By Box and Muller, in pairs. */
static double mppi_normal(mppi *x)
{
    const double angle = 6.283185307179586;
    double radius;
    double turn;

    if (x->paired) {
        x->paired = false;
        return x->spare;
    }
    radius = sqrt(-2.0 * log(mppi_uniform(x)));
    turn = angle * mppi_uniform(x);
    x->spare = radius * sin(turn);
    x->paired = true;
    return radius * cos(turn);
}

/* Draws the noise of all plans; the first of them has none. */
static int mppi_prepare(controller *c)
{
    mppi *x = c->work;
    const int length = c->moves * c->m;
    const double memory = x->settings.memory;
    const double fresh = sqrt(1.0 - memory * memory);

    memset(x->noise, 0, (size_t)length * sizeof *x->noise);
    for (int i = 1; i < x->settings.samples; i++) {
        double *row = x->noise + (size_t)i * (size_t)length;

        for (int a = 0; a < length; a++) {
            const double drawn = x->settings.noise * mppi_normal(x);

            row[a] = a < c->m ? drawn : memory * row[a - c->m] + fresh * drawn;
        }
    }
    return 0;
}

/* Moves after the last one are as it. */
static void mppi_complete(const controller *c, double *plan)
{
    for (int i = c->moves; i < c->horizon; i++) {
        memcpy(plan + i * c->m, plan + (c->moves - 1) * c->m, (size_t)c->m * sizeof *plan);
    }
}

static double mppi_value_cost(const controller *c, mppi *x, int i, const double *seen)
{
    const controller_settings *s = &c->settings;
    const double terminal = i == c->horizon - 1 ? s->terminal : 1.0;
    double cost = 0.0;

    for (int k = 0; k < c->v; k++) {
        const double value = seen[k] + c->bias[k];
        const double wanted = c->reference[i * c->v + k];
        const double error = isnan(wanted) ? 0.0 : value - wanted;
        const double over = s->soft_upper != NULL ? value - s->soft_upper[k] : 0.0;
        const double under = s->soft_lower != NULL ? s->soft_lower[k] - value : 0.0;
        const double most = fmax(fmax(over, under), 0.0);

        cost += 0.5 * terminal * s->weight[k] * error * error;
        if (most > 1e-9 * fmax(1.0, fabs(value))) {
            cost += 0.5 * s->soft_weight[k] * most * most;
            x->violated = true;
        }
    }
    return cost;
}

/* Costs of `count` plans; false: the model has no answer for any of them. */
static bool mppi_batch(controller *c, mppi *x, int count, const double *plans, double *costs)
{
    const one_step *model = &c->settings.model;
    const one_look *look = &c->settings.look;
    const size_t row = (size_t)c->n * sizeof *x->states;
    double *now = x->states;
    double *next = x->states + x->settings.batch * c->n;

    for (int b = 0; b < count; b++) {
        memcpy(now + b * c->n, c->start, row);
        costs[b] = controller_cost_of_moves(c, plans + b * c->horizon * c->m);
    }
    for (int i = 0; i < c->horizon; i++) {
        double *swap = now;

        for (int b = 0; b < count; b++) {
            controller_inputs(c, plans + (b * c->horizon + i) * c->m,
                              x->inputs + b * model->inputs);
        }
        if (model->advance(model->context, count, model->step, now, x->inputs, NULL, next, NULL,
                           NULL) != 0) {
            return false;
        }
        now = next;
        next = swap;
        for (int b = 0; b < count * c->n; b++) {
            now[b] += c->drift[b % c->n];
        }
        if (look->see(look->context, count, now, x->inputs, x->seen, NULL) != 0) {
            return false;
        }
        for (int b = 0; b < count; b++) {
            costs[b] += mppi_value_cost(c, x, i, x->seen + b * c->v);
        }
    }
    return true;
}

/* The plans' mean by exp(-cost/temperature); of plans that are allowed it is allowed. */
static bool mppi_mean(controller *c, mppi *x)
{
    const int length = c->horizon * c->m;
    double least = INFINITY;
    double spread = 0.0;
    double total = 0.0;
    int finite = 0;

    for (int i = 0; i < x->settings.samples; i++) {
        least = fmin(least, x->costs[i]); /* which passes over NaN */
    }
    for (int i = 0; i < x->settings.samples; i++) {
        if (isfinite(x->costs[i])) {
            spread += x->costs[i] - least;
            finite++;
        }
    }
    if (!isfinite(least) || !isfinite(spread)) {
        return false;
    }
    spread = fmax(spread / finite, 1e-300) * x->settings.temperature;
    memset(c->plan, 0, (size_t)length * sizeof *c->plan);
    for (int i = 0; i < x->settings.samples; i++) {
        const double weight = isfinite(x->costs[i]) ? exp((least - x->costs[i]) / spread) : 0.0;
        const double *plan = x->plans + i * length;

        total += weight;
        for (int a = 0; a < length; a++) {
            c->plan[a] += weight * plan[a];
        }
    }
    for (int a = 0; a < length; a++) {
        c->plan[a] /= total;
    }
    return true;
}

static int mppi_solve(controller *c)
{
    mppi *x = c->work;
    const int length = c->horizon * c->m;
    const int samples = x->settings.samples;
    const double part = pow(x->settings.shrink, c->iteration);

    for (int i = 0; i < samples; i++) {
        double *plan = x->plans + i * length;
        const double *noise = x->noise + i * c->moves * c->m;

        for (int a = 0; a < c->moves * c->m; a++) {
            plan[a] = c->plan[a] + part * noise[a] * c->span[a % c->m];
        }
        controller_allow(c, plan);
        mppi_complete(c, plan);
    }
    for (int i = 0; i < samples; i += x->settings.batch) {
        const int left = samples - i;
        const int count = left < x->settings.batch ? left : x->settings.batch;

        if (!mppi_batch(c, x, count, x->plans + i * length, x->costs + i)) {
            for (int b = i; b < i + count; b++) {
                x->costs[b] = INFINITY;
            }
        }
    }
    if (!mppi_mean(c, x)) {
        return CONTROLLER_MODEL;
    }
    x->violated = false;
    return mppi_batch(c, x, 1, c->plan, &c->cost) && x->violated ? CONTROLLER_SOFT : 0;
}

/* It keeps nothing of the plan but the plan. */
static void mppi_shift(controller *c)
{
    (void)c;
}

const controller_method controller_sampling = {mppi_refusal, mppi_size,  mppi_init,
                                               mppi_prepare, mppi_solve, mppi_shift};
