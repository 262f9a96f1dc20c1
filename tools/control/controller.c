#include "tools/control/controller.h"

#include "tools/control/controller_internal.h"

#include <math.h>
#include <string.h>

static const char *controller_refusal_inputs(const controller_settings *s)
{
    for (int j = 0; j < s->controlled; j++) {
        if (s->inputs[j] < 0 || s->inputs[j] >= s->model.inputs) {
            return "a controlled input that the model does not have";
        }
        for (int k = 0; k < j; k++) {
            if (s->inputs[j] == s->inputs[k]) {
                return "an input that is controlled twice";
            }
        }
        if (!isfinite(s->lower[j]) || !isfinite(s->upper[j]) || !(s->lower[j] < s->upper[j])) {
            return "limits of inputs are to be finite, the lower below the upper";
        }
        if (s->rate != NULL && !(s->rate[j] > 0.0)) {
            return "rates of inputs are to be positive";
        }
        if ((s->smooth != NULL && !(s->smooth[j] >= 0.0)) ||
            (s->effort != NULL && !(s->effort[j] >= 0.0))) {
            return "weights of inputs are not to be negative";
        }
        if (s->rest != NULL && !(s->rest[j] >= s->lower[j] && s->rest[j] <= s->upper[j])) {
            return "inputs at rest are to be within their limits";
        }
    }
    return NULL;
}

static const char *controller_refusal_values(const controller_settings *s)
{
    const bool limits = s->soft_lower != NULL || s->soft_upper != NULL;

    for (int k = 0; k < s->observation.values; k++) {
        const double lower = s->soft_lower != NULL ? s->soft_lower[k] : -INFINITY;
        const double upper = s->soft_upper != NULL ? s->soft_upper[k] : INFINITY;

        if (!(s->weight[k] >= 0.0) || !isfinite(s->weight[k])) {
            return "weights of what is seen are to be finite and not negative";
        }
        if (!(lower <= upper)) {
            return "a soft limit whose lower end is above its upper one";
        }
        if (limits && (isfinite(lower) || isfinite(upper)) &&
            (s->soft_weight == NULL || !(s->soft_weight[k] > 0.0))) {
            return "a soft limit without a positive weight";
        }
    }
    return NULL;
}

const char *controller_refusal(const controller_settings *s)
{
    const char *wrong = NULL;

    if (s->model.advance == NULL || s->observation.see == NULL || s->model.states < 1 ||
        s->model.states != s->observation.states || s->observation.values < 1 ||
        s->model.inputs != s->observation.inputs) {
        return "no model and observation of the same states and inputs";
    }
    if (s->horizon < 1 || s->moves < 0 || s->moves > s->horizon || s->delay < 0 ||
        s->iterations < 0 || s->qp_limit < 0 || s->coast < 0) {
        return "horizon at least 1, moves at most the horizon, delay, limits, coast not "
               "negative";
    }
    if (s->controlled < 1 || s->controlled > s->model.inputs || s->inputs == NULL ||
        s->others == NULL || s->lower == NULL || s->upper == NULL || s->weight == NULL) {
        return "no inputs, others, lower, upper or weight";
    }
    if (!controller_finite(s->others, s->model.inputs)) {
        return "other inputs are to be finite";
    }
    if (!(s->offset >= 0.0 && s->offset <= 1.0) || !(s->terminal >= 0.0) || !(s->outside >= 0.0)) {
        return "offset is to be within 0 and 1, terminal and outside not negative";
    }
    wrong = controller_refusal_inputs(s);
    return wrong == NULL ? controller_refusal_values(s) : wrong;
}

/* Everything but the memory of controller_plan.c, which begins behind it. */
static size_t controller_layout(const controller_settings *s, void *memory, controller *c)
{
    const size_t n = (size_t)s->model.states;
    const size_t m = (size_t)s->controlled;
    const size_t v = (size_t)s->observation.values;
    const size_t horizon = (size_t)s->horizon;
    const size_t inputs = (size_t)s->model.inputs;
    size_t used = 0;

    (void)small_matrix_take(memory, &used, 1, sizeof *c);
    c->span = small_matrix_take(memory, &used, m, sizeof(double));
    c->rest = small_matrix_take(memory, &used, m, sizeof(double));
    c->others = small_matrix_take(memory, &used, inputs, sizeof(double));
    c->reference = small_matrix_take(memory, &used, horizon * v, sizeof(double));
    c->plan = small_matrix_take(memory, &used, horizon * m, sizeof(double));
    c->pending = small_matrix_take(memory, &used, (size_t)s->delay * m, sizeof(double));
    c->last = small_matrix_take(memory, &used, m, sizeof(double));
    c->state = small_matrix_take(memory, &used, n, sizeof(double));
    c->start = small_matrix_take(memory, &used, n, sizeof(double));
    c->expected = small_matrix_take(memory, &used, n, sizeof(double));
    c->drift = small_matrix_take(memory, &used, n, sizeof(double));
    c->bias = small_matrix_take(memory, &used, v, sizeof(double));
    c->margin = small_matrix_take(memory, &used, v, sizeof(double));
    c->row = small_matrix_take(memory, &used, inputs, sizeof(double));
    c->next = small_matrix_take(memory, &used, n > v ? n : v, sizeof(double));
    return used;
}

size_t controller_size(const controller_settings *settings)
{
    controller c;

    return controller_layout(settings, NULL, &c) + controller_plan_size(settings);
}

controller *controller_init(void *memory, const controller_settings *settings)
{
    controller *c = memory;
    size_t used;

    memset(memory, 0, controller_size(settings));
    used = controller_layout(settings, memory, c);
    c->work = (unsigned char *)memory + used;
    c->settings = *settings;
    c->settings.iterations = settings->iterations == 0 ? 1 : settings->iterations;
    c->settings.terminal = settings->terminal == 0.0 ? 1.0 : settings->terminal;
    c->settings.outside = settings->outside == 0.0 ? INFINITY : settings->outside;
    c->settings.coast = settings->coast == 0 ? settings->horizon : settings->coast;
    c->n = settings->model.states;
    c->m = settings->controlled;
    c->v = settings->observation.values;
    c->horizon = settings->horizon;
    c->moves = settings->moves == 0 ? settings->horizon : settings->moves;
    c->delay = settings->delay;
    memcpy(c->others, settings->others, (size_t)settings->model.inputs * sizeof *c->others);
    for (int j = 0; j < c->m; j++) {
        const double zero = fmin(fmax(0.0, settings->lower[j]), settings->upper[j]);

        c->span[j] = settings->upper[j] - settings->lower[j];
        c->rest[j] = settings->rest != NULL ? settings->rest[j] : zero;
        c->last[j] = c->rest[j];
        for (int i = 0; i < c->horizon; i++) {
            c->plan[i * c->m + j] = c->last[j];
        }
        for (int i = 0; i < c->delay; i++) {
            c->pending[i * c->m + j] = c->last[j];
        }
    }
    for (int i = 0; i < c->horizon * c->v; i++) {
        c->reference[i] = NAN;
    }
    c->restart = true;
    controller_plan_init(c, c->work);
    return c;
}

void controller_start(controller *c, const double *inputs)
{
    const controller_settings settings = c->settings;

    (void)controller_init(c, &settings);
    for (int i = 0; i <= c->delay; i++) {
        controller_applied(c, i, inputs);
    }
}

void controller_forget(controller *c)
{
    memset(c->drift, 0, (size_t)c->n * sizeof *c->drift);
    memset(c->bias, 0, (size_t)c->v * sizeof *c->bias);
    c->foreseen = false;
    c->prepared = false;
    c->restart = true;
}

bool controller_finite(const double *x, int count)
{
    double sum[SMALL_MATRIX_LANES] = {0}; /* of zeros, unless one is not finite */
    int i = 0;

    for (; i + SMALL_MATRIX_LANES <= count; i += SMALL_MATRIX_LANES) {
        for (int j = 0; j < SMALL_MATRIX_LANES; j++) {
            sum[j] += 0.0 * x[i + j];
        }
    }
    for (; i < count; i++) {
        sum[0] += 0.0 * x[i];
    }
    for (int j = 1; j < SMALL_MATRIX_LANES; j++) {
        sum[0] += sum[j];
    }
    return sum[0] == 0.0;
}

void controller_inputs(const controller *c, const double *move, double *inputs)
{
    memcpy(inputs, c->others, (size_t)c->settings.model.inputs * sizeof *inputs);
    for (int j = 0; j < c->m; j++) {
        inputs[c->settings.inputs[j]] = move[j];
    }
}

void controller_range(const controller *c, int j, double before, double *lower, double *upper)
{
    const double rate = c->settings.rate != NULL ? c->settings.rate[j] : INFINITY;
    const double low = c->settings.lower[j];
    const double high = c->settings.upper[j];

    *lower = fmin(fmax(low, before - rate), high);
    *upper = fmax(fmin(high, before + rate), low);
}

void controller_allow(const controller *c, double *moves)
{
    const double *before = c->last;

    for (int i = 0; i < c->moves; i++) {
        double *move = moves + i * c->m;

        for (int j = 0; j < c->m; j++) {
            double lower;
            double upper;

            controller_range(c, j, before[j], &lower, &upper);
            move[j] = fmin(fmax(move[j], lower), upper);
        }
        before = move;
    }
}

/* next = model of state and move, without drift. */
static bool controller_advance(controller *c, const double *state, const double *move, double *next)
{
    const one_step *model = &c->settings.model;

    controller_inputs(c, move, c->row);
    return model->advance(model->context, 1, model->step, state, c->row, NULL, next, NULL, NULL) ==
               0 &&
           controller_finite(next, c->n);
}

/* The first row of the plan becomes an answer. */
static void controller_shift(controller *c)
{
    const size_t row = (size_t)c->m * sizeof *c->plan;
    const size_t rest = (size_t)(c->horizon - 1);

    memcpy(c->last, c->plan, row);
    if (c->delay > 0) {
        memmove(c->pending, c->pending + c->m, (size_t)(c->delay - 1) * row);
        memcpy(c->pending + (c->delay - 1) * c->m, c->plan, row);
    }
    memmove(c->plan, c->plan + c->m, rest * row);
    controller_plan_shift(c);
    c->prepared = false;
}

static void controller_shift_reference(controller *c)
{
    memmove(c->reference, c->reference + c->v,
            (size_t)((c->horizon - 1) * c->v) * sizeof *c->reference);
}

static int controller_take_sample(controller *c, const controller_sample *now)
{
    int flags = 0;

    for (int k = 0; k < c->v; k++) {
        c->margin[k] = now->margin != NULL && now->margin[k] > 0.0 ? now->margin[k] : 0.0;
    }
    if (now->others != NULL) {
        const size_t size = (size_t)c->settings.model.inputs * sizeof *c->row;

        memcpy(c->row, now->others, size);
        for (int j = 0; j < c->m; j++) {
            c->row[c->settings.inputs[j]] = 0.0;
        }
        if (controller_finite(c->row, c->settings.model.inputs)) {
            memcpy(c->others, c->row, size);
        } else {
            flags |= CONTROLLER_OTHERS;
        }
    }
    if (now->reference == NULL) {
        controller_shift_reference(c);
        return flags;
    }
    for (int i = 0; i < c->horizon * c->v; i++) {
        c->reference[i] = isinf(now->reference[i]) ? NAN : now->reference[i];
        flags |= isinf(now->reference[i]) ? CONTROLLER_REFERENCE : 0;
    }
    return flags;
}

/* What is wrong with predictions by one sample, and with what is seen, goes into drift and bias. */
static void controller_learn(controller *c, const double *measured)
{
    const one_observation *observation = &c->settings.observation;
    const double gain = c->settings.offset;

    if (gain == 0.0) {
        return;
    }
    for (int i = 0; c->foreseen && i < c->n; i++) {
        const double error = c->state[i] - c->expected[i] - c->drift[i];

        c->drift[i] += isfinite(error) ? gain * error : 0.0;
    }
    if (measured == NULL) {
        return;
    }
    controller_inputs(c, c->delay > 0 ? c->pending : c->last, c->row);
    if (observation->see(observation->context, 1, c->state, c->row, c->next, NULL) != 0) {
        return;
    }
    for (int i = 0; i < c->v; i++) {
        const double error = measured[i] - c->next[i] - c->bias[i];

        c->bias[i] += isfinite(error) ? gain * error : 0.0;
    }
}

/* With a delay of 0 it is known only after the answer what is applied from a state on. */
static void controller_foresee(controller *c)
{
    if (c->delay == 0 && !c->foreseen && c->known) {
        c->foreseen = controller_advance(c, c->state, c->last, c->expected);
    }
}

/* c->state from what is given or foreseen. */
static int controller_see(controller *c, const controller_sample *now)
{
    const one_step *model = &c->settings.model;
    int flags = CONTROLLER_STATE;

    controller_foresee(c);
    if (now->state != NULL && controller_finite(now->state, c->n)) {
        double outside = 0.0;

        if (model->outside != NULL) {
            controller_inputs(c, c->delay > 0 ? c->pending : c->last, c->row);
            outside = model->outside(model->context, now->state, c->row);
        }
        flags = outside <= 1.0 ? 0 : CONTROLLER_OUTSIDE;
        if (outside <= c->settings.outside) {
            memcpy(c->state, now->state, (size_t)c->n * sizeof *c->state);
            controller_learn(c, now->measured);
            c->coasted = 0;
            c->known = true;
            return flags;
        }
        flags |= CONTROLLER_STATE;
    }
    c->known = c->foreseen && c->coasted < c->settings.coast;
    c->coasted++;
    for (int i = 0; i < c->n; i++) {
        c->state[i] = c->expected[i] + c->drift[i];
    }
    return flags;
}

/* c->start from c->state by what is decided. */
static bool controller_begin(controller *c)
{
    memcpy(c->start, c->state, (size_t)c->n * sizeof *c->start);
    c->foreseen = false;
    for (int i = 0; i < c->delay; i++) {
        if (!controller_advance(c, c->start, c->pending + i * c->m, c->next)) {
            return false;
        }
        if (i == 0) {
            memcpy(c->expected, c->next, (size_t)c->n * sizeof *c->expected);
            c->foreseen = true;
        }
        for (int k = 0; k < c->n; k++) {
            c->start[k] = c->next[k] + c->drift[k];
        }
    }
    return true;
}

static void controller_hold(controller *c)
{
    for (int i = 0; i < c->horizon; i++) {
        memcpy(c->plan + i * c->m, c->last, (size_t)c->m * sizeof *c->plan);
    }
}

static int controller_ready(controller *c)
{
    const int flags = controller_plan_prepare(c);

    c->prepared = (flags & (CONTROLLER_MODEL | CONTROLLER_QP)) == 0;
    c->restart = !c->prepared;
    return flags;
}

int controller_feedback(controller *c, const controller_sample *now, double *inputs)
{
    int flags = controller_take_sample(c, now);

    flags |= controller_see(c, now);
    c->iterations = 0;
    if (!c->known) {
        c->foreseen = false;
        c->restart = true;
        controller_hold(c);
        flags |= CONTROLLER_HELD;
    } else if (!controller_begin(c)) {
        c->restart = true;
        flags |= CONTROLLER_MODEL;
    } else {
        for (int i = 0; i < c->settings.iterations; i++) {
            int found = c->prepared ? 0 : controller_ready(c);

            found |= c->prepared ? controller_plan_solve(c) : 0;
            c->prepared = false;
            c->restart = c->restart || (found & (CONTROLLER_MODEL | CONTROLLER_QP)) != 0;
            flags = (flags & ~CONTROLLER_SOFT) | found;
        }
    }
    controller_allow(c, c->plan);
    memcpy(inputs, c->plan, (size_t)c->m * sizeof *inputs);
    controller_shift(c);
    return flags;
}

int controller_prepare(controller *c)
{
    controller_foresee(c);
    /* From a new start it waits for the state. */
    return c->known && !c->prepared && !c->restart ? controller_ready(c) : 0;
}

void controller_skip(controller *c, int count)
{
    const int most = c->horizon + c->delay; /* then nothing of the plan is left */

    for (int i = 0; i < count && i < most; i++) {
        controller_foresee(c);
        controller_shift_reference(c);
        c->known = c->foreseen && c->coasted < c->settings.coast;
        c->coasted++;
        if (c->known) {
            for (int k = 0; k < c->n; k++) {
                c->state[k] = c->expected[k] + c->drift[k];
            }
            c->foreseen = c->delay > 0 && controller_advance(c, c->state, c->pending, c->expected);
        }
        controller_shift(c);
    }
    if (count > most) {
        c->known = false;
        c->foreseen = false;
    }
}

void controller_applied(controller *c, int ago, const double *inputs)
{
    if (ago < 0 || !controller_finite(inputs, c->m)) {
        return;
    }
    if (ago == 0) {
        memcpy(c->last, inputs, (size_t)c->m * sizeof *c->last);
    }
    if (ago < c->delay) {
        memcpy(c->pending + (c->delay - 1 - ago) * c->m, inputs, (size_t)c->m * sizeof *c->pending);
    }
}

const double *controller_plan(const controller *c)
{
    return c->plan;
}

double controller_cost(const controller *c)
{
    return c->cost;
}

int controller_iterations(const controller *c)
{
    return c->iterations;
}

int controller_iterations_most(const controller *c)
{
    return c->most;
}
