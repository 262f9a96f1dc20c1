/* Real-time iterations: model and look are linearised at all samples of the plan at once (multiple
 * shooting, of which the gaps are closed in the same step), states are eliminated, and one
 * quadratic program changes the plan. States are eliminated from the end to the begin,
 *
 *   d seen_i/d u_j = C_i A_i-1 .. A_j+1 B_j,
 *
 * for what is seen alone, of which there is less than of states. */
#include "tools/control/controller_internal.h"
#include "tools/control/qp.h"
#include "tools/control/small.h"

#include <math.h>
#include <string.h>

/* R = horizon v rows of what is seen, z = change of moves by span [moves m], w = stride of
 * n + m + 1 columns. */
typedef struct gauss_newton {
    int R, z, w, stride;                           /* stride: of z columns */
    int rated, limited;                            /* inputs with a rate, values with soft limits */
    int rows;                                      /* of the quadratic program */
    double *nodes;                                 /* [horizon + 1][n] */
    double *inputs;                                /* [horizon][model.inputs] */
    double *next;                                  /* [horizon][n] */
    double *by_state, *by_inputs, *seen, *by_seen; /* as model and look answer */
    double *steps;                                 /* [horizon][n][w] A, B, gap to the next node */
    double *chain, *other; /* [R][w] d seen/d x_j, moved by one step to the next */
    double *sensitivity;   /* [R][stride] d seen/dz */
    double *gaps;          /* [R] what the gaps do to what is seen */
    double *weight;        /* [R] with which `hessian` was built */
    double *predicted;     /* [R] */
    double *residual;      /* [R] */
    double *change;        /* [w] of state, inputs, and 1 */
    double *hessian;       /* [z][stride] */
    double *gradient, *lower, *upper, *inside, *result; /* [stride] */
    double *target;                                     /* [moves][m] */
    double *A; /* [rows][stride]: rates, then limits, each in order of time */
    double *row_lower, *row_upper, *softness; /* [rows] */
    qp *program;
} gauss_newton;

static double gauss_newton_rate(const controller_settings *s, int j)
{
    return s->rate != NULL ? s->rate[j] : INFINITY;
}

static bool gauss_newton_limited(const controller_settings *s, int k)
{
    return (s->soft_lower != NULL && isfinite(s->soft_lower[k])) ||
           (s->soft_upper != NULL && isfinite(s->soft_upper[k]));
}

static qp_settings gauss_newton_sizes(const controller_settings *s, gauss_newton *x)
{
    const int moves = s->moves == 0 ? s->horizon : s->moves;
    qp_settings result = {0};

    x->R = s->horizon * s->look.values;
    x->z = moves * s->controlled;
    x->w = small_stride(s->model.states + s->controlled + 1);
    x->stride = small_stride(x->z);
    x->rated = 0;
    x->limited = 0;
    for (int j = 0; j < s->controlled; j++) {
        x->rated += isfinite(gauss_newton_rate(s, j)) ? 1 : 0;
    }
    for (int k = 0; k < s->look.values; k++) {
        x->limited += gauss_newton_limited(s, k) ? 1 : 0;
    }
    x->rows = (moves - 1) * x->rated + s->horizon * x->limited;
    result.variables = x->z;
    result.rows = x->rows;
    result.iterations = s->qp_limit;
    return result;
}

static size_t gauss_newton_layout(const controller_settings *s, void *memory, gauss_newton *x)
{
    const qp_settings sizes = gauss_newton_sizes(s, x);
    const size_t n = (size_t)s->model.states;
    const size_t inputs = (size_t)s->model.inputs;
    const size_t horizon = (size_t)s->horizon;
    const size_t R = (size_t)x->R;
    const size_t w = (size_t)x->w;
    const size_t z = (size_t)x->z;
    const size_t stride = (size_t)x->stride;
    const size_t rows = (size_t)x->rows;
    const size_t one = sizeof(double);
    size_t used = 0;

    (void)small_take(memory, &used, 1, sizeof *x);
    x->nodes = small_take(memory, &used, (horizon + 1) * n, one);
    x->inputs = small_take(memory, &used, horizon * inputs, one);
    x->next = small_take(memory, &used, horizon * n, one);
    x->by_state = small_take(memory, &used, horizon * n * n, one);
    x->by_inputs = small_take(memory, &used, horizon * n * inputs, one);
    x->seen = small_take(memory, &used, R, one);
    x->by_seen = small_take(memory, &used, R * n, one);
    x->steps = small_take(memory, &used, horizon * n * w, one);
    x->chain = small_take(memory, &used, R * w, one);
    x->other = small_take(memory, &used, R * w, one);
    x->sensitivity = small_take(memory, &used, R * stride, one);
    x->gaps = small_take(memory, &used, R, one);
    x->weight = small_take(memory, &used, R, one);
    x->predicted = small_take(memory, &used, R, one);
    x->residual = small_take(memory, &used, R, one);
    x->change = small_take(memory, &used, w, one);
    x->hessian = small_take(memory, &used, z * stride, one);
    x->gradient = small_take(memory, &used, stride, one);
    x->lower = small_take(memory, &used, stride, one);
    x->upper = small_take(memory, &used, stride, one);
    x->inside = small_take(memory, &used, stride, one);
    x->result = small_take(memory, &used, stride, one);
    x->target = small_take(memory, &used, z, one);
    x->A = small_take(memory, &used, rows * stride, one);
    x->row_lower = small_take(memory, &used, rows, one);
    x->row_upper = small_take(memory, &used, rows, one);
    x->softness = small_take(memory, &used, rows, one);
    x->program = small_take(memory, &used, qp_size(&sizes), 1);
    return used;
}

size_t controller_plan_size(const controller_settings *s)
{
    gauss_newton x;

    return gauss_newton_layout(s, NULL, &x);
}

void controller_plan_init(controller *c, void *memory)
{
    const controller_settings *s = &c->settings;
    gauss_newton *x = memory;
    qp_settings sizes;
    int row = 0;

    (void)gauss_newton_layout(s, memory, x);
    sizes = gauss_newton_sizes(s, x);
    c->most = qp_iterations_most(qp_init(x->program, &sizes));
    for (int i = 1; i < c->moves; i++) {
        for (int j = 0; j < c->m; j++) {
            if (isfinite(gauss_newton_rate(s, j))) {
                x->A[row * x->stride + i * c->m + j] = 1.0;
                x->A[row * x->stride + (i - 1) * c->m + j] = -1.0;
                row++;
            }
        }
    }
    for (int i = 0; i < c->horizon; i++) {
        for (int k = 0; k < c->v; k++) {
            if (gauss_newton_limited(s, k)) {
                x->softness[row++] = 1.0 / s->soft_weight[k];
            }
        }
    }
}

/* States along the plan, from its start on. */
static bool gauss_newton_roll(controller *c, gauss_newton *x)
{
    const one_step *model = &c->settings.model;

    memcpy(x->nodes, c->start, (size_t)c->n * sizeof *x->nodes);
    for (int i = 0; i < c->horizon; i++) {
        double *next = x->nodes + (i + 1) * c->n;

        controller_inputs(c, c->plan + i * c->m, c->row);
        if (model->advance(model->context, 1, model->step, next - c->n, c->row, NULL, next, NULL,
                           NULL) != 0 ||
            !controller_finite(next, c->n)) {
            return false;
        }
        for (int k = 0; k < c->n; k++) {
            next[k] += c->drift[k];
        }
    }
    return true;
}

/* Asks model and look for all samples at once, and puts A, B and gaps side by side. */
static bool gauss_newton_linearise(controller *c, gauss_newton *x)
{
    const one_step *model = &c->settings.model;
    const one_look *look = &c->settings.look;
    const int n = c->n;
    double *end = x->nodes + c->horizon * n;

    for (int i = 0; i < c->horizon; i++) {
        controller_inputs(c, c->plan + i * c->m, x->inputs + i * model->inputs);
    }
    if (model->advance(model->context, c->horizon, model->step, x->nodes, x->inputs, NULL, x->next,
                       x->by_state, x->by_inputs) != 0) {
        return false;
    }
    for (int k = 0; k < n; k++) {
        end[k] = x->next[(c->horizon - 1) * n + k] + c->drift[k];
    }
    if (look->see(look->context, c->horizon, x->nodes + n, x->inputs, x->seen, x->by_seen) != 0) {
        return false;
    }
    for (int i = 0; i < c->horizon; i++) {
        for (int k = 0; k < n; k++) {
            const int from = i * n + k;
            double *row = x->steps + from * x->w;

            memcpy(row, x->by_state + from * n, (size_t)n * sizeof *row);
            for (int j = 0; j < c->m; j++) {
                row[n + j] = x->by_inputs[from * model->inputs + c->settings.inputs[j]];
            }
            row[n + c->m] = x->next[from] + c->drift[k] - x->nodes[from + n];
        }
    }
    return controller_finite(x->steps, c->horizon * n * x->w) && controller_finite(x->seen, x->R) &&
           controller_finite(x->by_seen, x->R * n);
}

static void gauss_newton_condense(controller *c, gauss_newton *x)
{
    memset(x->sensitivity, 0, (size_t)(x->R * x->stride) * sizeof *x->sensitivity);
    memset(x->gaps, 0, (size_t)x->R * sizeof *x->gaps);
    for (int i = c->horizon - 1; i >= 0; i--) {
        const int first = i * c->v;
        const int move = i < c->moves ? i : c->moves - 1;
        double *swap = x->chain;

        for (int r = first; r < first + c->v; r++) {
            memcpy(x->chain + r * x->w, x->by_seen + r * c->n, (size_t)c->n * sizeof *x->chain);
        }
        small_product_in(x->w, x->R - first, c->n, x->chain + first * x->w,
                         x->steps + i * c->n * x->w, x->other + first * x->w);
        x->chain = x->other;
        x->other = swap;
        for (int r = first; r < x->R; r++) {
            const double *row = x->chain + r * x->w + c->n;

            for (int j = 0; j < c->m; j++) {
                x->sensitivity[r * x->stride + move * c->m + j] += row[j] * c->span[j];
            }
            x->gaps[r] += row[c->m];
        }
    }
}

/* Weights of what is seen: 0 where there is no wish. Whether they are others than before. */
static bool gauss_newton_weights(const controller *c, gauss_newton *x)
{
    bool changed = false;

    for (int r = 0; r < x->R; r++) {
        double weight = isnan(c->reference[r]) ? 0.0 : c->settings.weight[r % c->v];

        weight *= r >= x->R - c->v ? c->settings.terminal : 1.0;
        changed = changed || weight != x->weight[r];
        x->weight[r] = weight;
    }
    return changed;
}

SMALL_FOR_EACH_PROCESSOR static void gauss_newton_squares(const gauss_newton *x, int v, int m)
{
    for (int r = 0; r < x->R; r++) {
        const double *row = x->sensitivity + r * x->stride;
        const int reach = (r / v + 1) * m < x->z ? (r / v + 1) * m : x->z;
        const int end = small_stride(reach);

        for (int a = 0; a < reach && x->weight[r] > 0.0; a++) {
            const double factor = x->weight[r] * row[a];
            double *h = x->hessian + a * x->stride;

            for (int b = a / SMALL_LANES * SMALL_LANES; b < end; b++) {
                h[b] += factor * row[b];
            }
        }
    }
}

/* Samples for which move i lasts. */
static int gauss_newton_lasts(const controller *c, int i)
{
    return i < c->moves - 1 ? 1 : c->horizon - c->moves + 1;
}

static int gauss_newton_hessian(const controller *c, gauss_newton *x)
{
    const controller_settings *s = &c->settings;
    double largest = 0.0;

    memset(x->hessian, 0, (size_t)(x->z * x->stride) * sizeof *x->hessian);
    gauss_newton_squares(x, c->v, c->m);
    for (int a = 0; a < x->z; a++) {
        const int i = a / c->m;
        const double smooth = s->smooth != NULL ? s->smooth[a % c->m] : 0.0;
        const double effort = s->effort != NULL ? s->effort[a % c->m] : 0.0;
        double *h = x->hessian + a * x->stride;

        h[a] += effort * gauss_newton_lasts(c, i) + (i < c->moves - 1 ? 2.0 : 1.0) * smooth;
        if (i < c->moves - 1) {
            h[a + c->m] -= smooth;
        }
        largest = fmax(largest, h[a]);
    }
    for (int a = 0; a < x->z; a++) {
        x->hessian[a * x->stride + a] += 1e-9 * largest;
    }
    return qp_factor(x->program, x->hessian) == QP_SOLVED ? 0 : CONTROLLER_QP;
}

int controller_plan_prepare(controller *c)
{
    gauss_newton *x = c->work;
    int row = (c->moves - 1) * x->rated;

    if ((c->restart && !gauss_newton_roll(c, x)) || !gauss_newton_linearise(c, x)) {
        return CONTROLLER_MODEL;
    }
    gauss_newton_condense(c, x);
    for (int r = 0; x->limited > 0 && r < x->R; r++) {
        if (gauss_newton_limited(&c->settings, r % c->v)) {
            memcpy(x->A + row++ * x->stride, x->sensitivity + r * x->stride,
                   (size_t)x->stride * sizeof *x->A);
        }
    }
    (void)gauss_newton_weights(c, x);
    return gauss_newton_hessian(c, x);
}

/* What is seen along the plan from `start` on, and by how much it is not what is wanted. */
SMALL_FOR_EACH_PROCESSOR static void gauss_newton_predict(const controller *c, gauss_newton *x)
{
    memset(x->change, 0, (size_t)x->w * sizeof *x->change);
    for (int k = 0; k < c->n; k++) {
        x->change[k] = c->start[k] - x->nodes[k];
    }
    for (int r = 0; r < x->R; r++) {
        x->predicted[r] = x->seen[r] + c->bias[r % c->v] + x->gaps[r] +
                          small_dot(x->w, x->chain + r * x->w, x->change);
        x->residual[r] = x->weight[r] > 0.0 ? x->predicted[r] - c->reference[r] : 0.0;
    }
}

SMALL_FOR_EACH_PROCESSOR static void gauss_newton_gradient(const controller *c, gauss_newton *x)
{
    const controller_settings *s = &c->settings;

    memset(x->gradient, 0, (size_t)x->stride * sizeof *x->gradient);
    for (int r = 0; r < x->R; r++) {
        const double factor = x->weight[r] * x->residual[r];
        const double *row = x->sensitivity + r * x->stride;

        for (int a = 0; a < x->stride; a++) {
            x->gradient[a] += factor * row[a];
        }
    }
    for (int a = 0; a < x->z; a++) {
        const int i = a / c->m;
        const int j = a % c->m;
        const double now = c->plan[a];
        const double before = i > 0 ? c->plan[a - c->m] : c->last[j];

        if (s->smooth != NULL) {
            x->gradient[a] += s->smooth[j] * (now - before) / c->span[j];
            x->gradient[a] -=
                i < c->moves - 1 ? s->smooth[j] * (c->plan[a + c->m] - now) / c->span[j] : 0.0;
        }
        if (s->effort != NULL) {
            x->gradient[a] +=
                s->effort[j] * gauss_newton_lasts(c, i) * (now - c->rest[j]) / c->span[j];
        }
    }
}

/* Bounds of z, and the plan itself, cut to what is allowed. */
static void gauss_newton_bounds(const controller *c, gauss_newton *x)
{
    const controller_settings *s = &c->settings;
    int row = 0;

    memcpy(x->target, c->plan, (size_t)x->z * sizeof *x->target);
    controller_allow(c, x->target);
    for (int a = 0; a < x->z; a++) {
        const int j = a % c->m;
        double lower = s->lower[j];
        double upper = s->upper[j];

        if (a < c->m) {
            controller_range(c, j, c->last[j], &lower, &upper);
        }
        x->lower[a] = (lower - c->plan[a]) / c->span[j];
        x->upper[a] = (upper - c->plan[a]) / c->span[j];
        x->inside[a] =
            fmin(fmax((x->target[a] - c->plan[a]) / c->span[j], x->lower[a]), x->upper[a]);
    }
    for (int a = c->m; a < x->z; a++) {
        const int j = a % c->m;
        const double rate = gauss_newton_rate(s, j);

        if (isfinite(rate)) {
            const double change = c->plan[a] - c->plan[a - c->m];

            x->row_lower[row] = (-rate - change) / c->span[j];
            x->row_upper[row++] = (rate - change) / c->span[j];
        }
    }
    for (int r = 0; x->limited > 0 && r < x->R; r++) {
        const int k = r % c->v;

        if (gauss_newton_limited(s, k)) {
            x->row_lower[row] =
                (s->soft_lower != NULL ? s->soft_lower[k] : -INFINITY) - x->predicted[r];
            x->row_upper[row++] =
                (s->soft_upper != NULL ? s->soft_upper[k] : INFINITY) - x->predicted[r];
        }
    }
}

/* The plan goes on to `target`, and the states along it by the linear model. */
SMALL_FOR_EACH_PROCESSOR static void gauss_newton_move(controller *c, gauss_newton *x)
{
    for (int i = 0; i < c->horizon; i++) {
        const double *move = x->target + (i < c->moves ? i : c->moves - 1) * c->m;
        double *plan = c->plan + i * c->m;
        double *node = x->nodes + i * c->n;

        for (int k = 0; k < c->n; k++) {
            node[k] += x->change[k];
        }
        for (int j = 0; j < c->m; j++) {
            x->change[c->n + j] = move[j] - plan[j];
            plan[j] = move[j];
        }
        x->change[c->n + c->m] = 1.0;
        for (int k = 0; k < c->n; k++) {
            x->other[k] = small_dot(x->w, x->steps + (i * c->n + k) * x->w, x->change);
        }
        memcpy(x->change, x->other, (size_t)c->n * sizeof *x->change);
    }
    for (int k = 0; k < c->n; k++) {
        x->nodes[c->horizon * c->n + k] += x->change[k];
    }
}

/* What changes of inputs and their distance from rest cost in the plan. */
static double gauss_newton_cost_of_moves(const controller *c)
{
    const double *plan = c->plan;
    const double *smooth = c->settings.smooth;
    const double *effort = c->settings.effort;
    double cost = 0.0;

    for (int a = 0; a < c->horizon * c->m; a++) {
        const int j = a % c->m;
        const double before = a < c->m ? c->last[j] : plan[a - c->m];
        const double change = (plan[a] - before) / c->span[j];
        const double away = (plan[a] - c->rest[j]) / c->span[j];

        cost += smooth != NULL ? 0.5 * smooth[j] * change * change : 0.0;
        cost += effort != NULL ? 0.5 * effort[j] * away * away : 0.0;
    }
    return cost;
}

/* What the plan costs by the linear model; whether it violates soft limits. */
SMALL_FOR_EACH_PROCESSOR static bool gauss_newton_costs(controller *c, const gauss_newton *x)
{
    const controller_settings *s = &c->settings;
    bool violated = false;

    c->cost = 0.0;
    for (int r = 0; r < x->R; r++) {
        const int k = r % c->v;
        const double change = small_dot(x->stride, x->sensitivity + r * x->stride, x->result);
        const double error = x->residual[r] + change;

        c->cost += 0.5 * x->weight[r] * error * error;
        if (x->limited > 0 && gauss_newton_limited(s, k)) {
            const double value = x->predicted[r] + change;
            const double over = s->soft_upper != NULL ? value - s->soft_upper[k] : 0.0;
            const double under = s->soft_lower != NULL ? s->soft_lower[k] - value : 0.0;
            const double most = fmax(fmax(over, under), 0.0);

            c->cost += 0.5 * s->soft_weight[k] * most * most;
            violated = violated || most > 1e-9 * fmax(1.0, fabs(value));
        }
    }
    c->cost += gauss_newton_cost_of_moves(c);
    return violated;
}

int controller_plan_solve(controller *c)
{
    gauss_newton *x = c->work;
    qp_bounds bounds = {0};
    qp_status status;

    if (gauss_newton_weights(c, x) && gauss_newton_hessian(c, x) != 0) {
        return CONTROLLER_QP;
    }
    gauss_newton_predict(c, x);
    gauss_newton_gradient(c, x);
    gauss_newton_bounds(c, x);
    bounds.lower = x->lower;
    bounds.upper = x->upper;
    bounds.A = x->A;
    bounds.row_lower = x->row_lower;
    bounds.row_upper = x->row_upper;
    bounds.softness = x->softness;
    status = qp_solve(x->program, x->gradient, &bounds, x->inside, x->result);
    c->iterations = qp_iterations(x->program);
    if (status != QP_SOLVED && status != QP_LIMIT) {
        return CONTROLLER_QP;
    }
    for (int a = 0; a < x->z; a++) {
        x->target[a] = c->plan[a] + x->result[a] * c->span[a % c->m];
    }
    controller_allow(c, x->target);
    gauss_newton_move(c, x);
    return (status == QP_LIMIT ? CONTROLLER_QP_LIMIT : 0) |
           (gauss_newton_costs(c, x) ? CONTROLLER_SOFT : 0);
}

void controller_plan_shift(controller *c)
{
    gauss_newton *x = c->work;
    const int rates = (c->moves - 1) * x->rated;

    qp_shift(x->program, 0, x->z, c->m);
    if (rates > 0) {
        qp_shift(x->program, x->z, rates, x->rated);
    }
    if (x->limited > 0) {
        qp_shift(x->program, x->z + rates, c->horizon * x->limited, x->limited);
    }
    memmove(x->nodes, x->nodes + c->n, (size_t)(c->horizon * c->n) * sizeof *x->nodes);
}
