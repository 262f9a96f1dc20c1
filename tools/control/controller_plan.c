/* Real-time iterations: model and observation are linearised at all samples of the plan at once
 * (multiple shooting, of which the gaps are closed in the same step), states are eliminated, and
 * one quadratic program changes the plan. States are eliminated from the end to the begin,
 *
 *   d seen_i/d u_j = C_i A_i-1 .. A_j+1 B_j,
 *
 * for what is seen alone, of which there is less than of states. */
#include "tools/control/controller_internal.h"
#include "tools/control/qp.h"
#include "tools/control/small_matrix.h"

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
    double *by_state, *by_inputs, *seen, *by_seen; /* as model and observation answer */
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

/* What is left of the limits of value k by its margin. */
static void gauss_newton_limits(const controller *c, int k, double *lower, double *upper)
{
    const controller_settings *s = &c->settings;

    *lower = s->soft_lower != NULL ? s->soft_lower[k] + c->margin[k] : -INFINITY;
    *upper = s->soft_upper != NULL ? s->soft_upper[k] - c->margin[k] : INFINITY;
    if (*lower > *upper) {
        *lower = *upper = 0.5 * (s->soft_lower[k] + s->soft_upper[k]);
    }
}

static qp_settings gauss_newton_sizes(const controller_settings *s, gauss_newton *newton)
{
    const int moves = s->moves == 0 ? s->horizon : s->moves;
    qp_settings result = {0};

    newton->R = s->horizon * s->observation.values;
    newton->z = moves * s->controlled;
    newton->w = small_matrix_stride(s->model.states + s->controlled + 1);
    newton->stride = small_matrix_stride(newton->z);
    newton->rated = 0;
    newton->limited = 0;
    for (int j = 0; j < s->controlled; j++) {
        newton->rated += isfinite(gauss_newton_rate(s, j)) ? 1 : 0;
    }
    for (int k = 0; k < s->observation.values; k++) {
        newton->limited += gauss_newton_limited(s, k) ? 1 : 0;
    }
    newton->rows = (moves - 1) * newton->rated + s->horizon * newton->limited;
    result.variables = newton->z;
    result.rows = newton->rows;
    result.iterations = s->qp_limit;
    return result;
}

static size_t gauss_newton_layout(const controller_settings *s, void *memory, gauss_newton *newton)
{
    const qp_settings sizes = gauss_newton_sizes(s, newton);
    const size_t n = (size_t)s->model.states;
    const size_t inputs = (size_t)s->model.inputs;
    const size_t horizon = (size_t)s->horizon;
    const size_t R = (size_t)newton->R;
    const size_t w = (size_t)newton->w;
    const size_t z = (size_t)newton->z;
    const size_t stride = (size_t)newton->stride;
    const size_t rows = (size_t)newton->rows;
    const size_t one = sizeof(double);
    size_t used = 0;

    (void)small_matrix_take(memory, &used, 1, sizeof *newton);
    newton->nodes = small_matrix_take(memory, &used, (horizon + 1) * n, one);
    newton->inputs = small_matrix_take(memory, &used, horizon * inputs, one);
    newton->next = small_matrix_take(memory, &used, horizon * n, one);
    newton->by_state = small_matrix_take(memory, &used, horizon * n * n, one);
    newton->by_inputs = small_matrix_take(memory, &used, horizon * n * inputs, one);
    newton->seen = small_matrix_take(memory, &used, R, one);
    newton->by_seen = small_matrix_take(memory, &used, R * n, one);
    newton->steps = small_matrix_take(memory, &used, horizon * n * w, one);
    newton->chain = small_matrix_take(memory, &used, R * w, one);
    newton->other = small_matrix_take(memory, &used, R * w, one);
    newton->sensitivity = small_matrix_take(memory, &used, R * stride, one);
    newton->gaps = small_matrix_take(memory, &used, R, one);
    newton->weight = small_matrix_take(memory, &used, R, one);
    newton->predicted = small_matrix_take(memory, &used, R, one);
    newton->residual = small_matrix_take(memory, &used, R, one);
    newton->change = small_matrix_take(memory, &used, w, one);
    newton->hessian = small_matrix_take(memory, &used, z * stride, one);
    newton->gradient = small_matrix_take(memory, &used, stride, one);
    newton->lower = small_matrix_take(memory, &used, stride, one);
    newton->upper = small_matrix_take(memory, &used, stride, one);
    newton->inside = small_matrix_take(memory, &used, stride, one);
    newton->result = small_matrix_take(memory, &used, stride, one);
    newton->target = small_matrix_take(memory, &used, z, one);
    newton->A = small_matrix_take(memory, &used, rows * stride, one);
    newton->row_lower = small_matrix_take(memory, &used, rows, one);
    newton->row_upper = small_matrix_take(memory, &used, rows, one);
    newton->softness = small_matrix_take(memory, &used, rows, one);
    newton->program = small_matrix_take(memory, &used, qp_size(&sizes), 1);
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
    gauss_newton *newton = memory;
    qp_settings sizes;
    int row = 0;

    (void)gauss_newton_layout(s, memory, newton);
    sizes = gauss_newton_sizes(s, newton);
    c->most = qp_iterations_most(qp_init(newton->program, &sizes));
    for (int i = 1; i < c->moves; i++) {
        for (int j = 0; j < c->m; j++) {
            if (isfinite(gauss_newton_rate(s, j))) {
                newton->A[row * newton->stride + i * c->m + j] = 1.0;
                newton->A[row * newton->stride + (i - 1) * c->m + j] = -1.0;
                row++;
            }
        }
    }
    for (int i = 0; i < c->horizon; i++) {
        for (int k = 0; k < c->v; k++) {
            if (gauss_newton_limited(s, k)) {
                newton->softness[row++] = 1.0 / s->soft_weight[k];
            }
        }
    }
}

/* States along the plan, from its start on. */
static bool gauss_newton_roll(controller *c, gauss_newton *newton)
{
    const one_step *model = &c->settings.model;

    memcpy(newton->nodes, c->start, (size_t)c->n * sizeof *newton->nodes);
    for (int i = 0; i < c->horizon; i++) {
        double *next = newton->nodes + (i + 1) * c->n;

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

/* Asks model and observation for all samples at once, and puts A, B and gaps side by side. */
static bool gauss_newton_linearise(controller *c, gauss_newton *newton)
{
    const one_step *model = &c->settings.model;
    const one_observation *observation = &c->settings.observation;
    const int n = c->n;
    double *end = newton->nodes + c->horizon * n;

    for (int i = 0; i < c->horizon; i++) {
        controller_inputs(c, c->plan + i * c->m, newton->inputs + i * model->inputs);
    }
    if (model->advance(model->context, c->horizon, model->step, newton->nodes, newton->inputs, NULL,
                       newton->next, newton->by_state, newton->by_inputs) != 0) {
        return false;
    }
    for (int k = 0; k < n; k++) {
        end[k] = newton->next[(c->horizon - 1) * n + k] + c->drift[k];
    }
    if (observation->see(observation->context, c->horizon, newton->nodes + n, newton->inputs,
                         newton->seen, newton->by_seen) != 0) {
        return false;
    }
    for (int i = 0; i < c->horizon; i++) {
        for (int k = 0; k < n; k++) {
            const int from = i * n + k;
            double *row = newton->steps + from * newton->w;

            memcpy(row, newton->by_state + from * n, (size_t)n * sizeof *row);
            for (int j = 0; j < c->m; j++) {
                row[n + j] = newton->by_inputs[from * model->inputs + c->settings.inputs[j]];
            }
            row[n + c->m] = newton->next[from] + c->drift[k] - newton->nodes[from + n];
        }
    }
    return controller_finite(newton->steps, c->horizon * n * newton->w) &&
           controller_finite(newton->seen, newton->R) &&
           controller_finite(newton->by_seen, newton->R * n);
}

static void gauss_newton_condense(controller *c, gauss_newton *newton)
{
    memset(newton->sensitivity, 0,
           (size_t)(newton->R * newton->stride) * sizeof *newton->sensitivity);
    memset(newton->gaps, 0, (size_t)newton->R * sizeof *newton->gaps);
    for (int i = c->horizon - 1; i >= 0; i--) {
        const int first = i * c->v;
        const int move = i < c->moves ? i : c->moves - 1;
        double *swap = newton->chain;

        for (int r = first; r < first + c->v; r++) {
            memcpy(newton->chain + r * newton->w, newton->by_seen + r * c->n,
                   (size_t)c->n * sizeof *newton->chain);
        }
        small_matrix_product_in(
            newton->w, newton->R - first, c->n, newton->chain + first * newton->w,
            newton->steps + i * c->n * newton->w, newton->other + first * newton->w);
        newton->chain = newton->other;
        newton->other = swap;
        for (int r = first; r < newton->R; r++) {
            const double *row = newton->chain + r * newton->w + c->n;

            for (int j = 0; j < c->m; j++) {
                newton->sensitivity[r * newton->stride + move * c->m + j] += row[j] * c->span[j];
            }
            newton->gaps[r] += row[c->m];
        }
    }
}

/* Weights of what is seen: 0 where there is no wish. Whether they are others than before. */
static bool gauss_newton_weights(const controller *c, gauss_newton *newton)
{
    bool changed = false;

    for (int r = 0; r < newton->R; r++) {
        double weight = isnan(c->reference[r]) ? 0.0 : c->settings.weight[r % c->v];

        weight *= r >= newton->R - c->v ? c->settings.terminal : 1.0;
        changed = changed || weight != newton->weight[r];
        newton->weight[r] = weight;
    }
    return changed;
}

SMALL_FOR_EACH_PROCESSOR static void gauss_newton_squares(const gauss_newton *newton, int v, int m)
{
    for (int r = 0; r < newton->R; r++) {
        const double *row = newton->sensitivity + r * newton->stride;
        const int reach = (r / v + 1) * m < newton->z ? (r / v + 1) * m : newton->z;
        const int end = small_matrix_stride(reach);

        for (int a = 0; a < reach && newton->weight[r] > 0.0; a++) {
            const double factor = newton->weight[r] * row[a];
            double *h = newton->hessian + a * newton->stride;

            for (int b = a / SMALL_MATRIX_LANES * SMALL_MATRIX_LANES; b < end; b++) {
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

static int gauss_newton_hessian(const controller *c, gauss_newton *newton)
{
    const controller_settings *s = &c->settings;
    double largest = 0.0;

    memset(newton->hessian, 0, (size_t)(newton->z * newton->stride) * sizeof *newton->hessian);
    gauss_newton_squares(newton, c->v, c->m);
    for (int a = 0; a < newton->z; a++) {
        const int i = a / c->m;
        const double smooth = s->smooth != NULL ? s->smooth[a % c->m] : 0.0;
        const double effort = s->effort != NULL ? s->effort[a % c->m] : 0.0;
        double *h = newton->hessian + a * newton->stride;

        h[a] += effort * gauss_newton_lasts(c, i) + (i < c->moves - 1 ? 2.0 : 1.0) * smooth;
        if (i < c->moves - 1) {
            h[a + c->m] -= smooth;
        }
        largest = fmax(largest, h[a]);
    }
    for (int a = 0; a < newton->z; a++) {
        newton->hessian[a * newton->stride + a] += 1e-9 * largest;
    }
    return qp_factor(newton->program, newton->hessian) == QP_SOLVED ? 0 : CONTROLLER_QP;
}

int controller_plan_prepare(controller *c)
{
    gauss_newton *newton = c->work;
    int row = (c->moves - 1) * newton->rated;

    if ((c->restart && !gauss_newton_roll(c, newton)) || !gauss_newton_linearise(c, newton)) {
        return CONTROLLER_MODEL;
    }
    gauss_newton_condense(c, newton);
    for (int r = 0; newton->limited > 0 && r < newton->R; r++) {
        if (gauss_newton_limited(&c->settings, r % c->v)) {
            memcpy(newton->A + row++ * newton->stride, newton->sensitivity + r * newton->stride,
                   (size_t)newton->stride * sizeof *newton->A);
        }
    }
    (void)gauss_newton_weights(c, newton);
    return gauss_newton_hessian(c, newton);
}

/* What is seen along the plan from `start` on, and by how much it is not what is wanted. */
SMALL_FOR_EACH_PROCESSOR static void gauss_newton_predict(const controller *c, gauss_newton *newton)
{
    memset(newton->change, 0, (size_t)newton->w * sizeof *newton->change);
    for (int k = 0; k < c->n; k++) {
        newton->change[k] = c->start[k] - newton->nodes[k];
    }
    for (int r = 0; r < newton->R; r++) {
        newton->predicted[r] =
            newton->seen[r] + c->bias[r % c->v] + newton->gaps[r] +
            small_matrix_dot(newton->w, newton->chain + r * newton->w, newton->change);
        newton->residual[r] =
            newton->weight[r] > 0.0 ? newton->predicted[r] - c->reference[r] : 0.0;
    }
}

SMALL_FOR_EACH_PROCESSOR static void gauss_newton_gradient(const controller *c,
                                                           gauss_newton *newton)
{
    const controller_settings *s = &c->settings;

    memset(newton->gradient, 0, (size_t)newton->stride * sizeof *newton->gradient);
    for (int r = 0; r < newton->R; r++) {
        const double factor = newton->weight[r] * newton->residual[r];
        const double *row = newton->sensitivity + r * newton->stride;

        for (int a = 0; a < newton->stride; a++) {
            newton->gradient[a] += factor * row[a];
        }
    }
    for (int a = 0; a < newton->z; a++) {
        const int i = a / c->m;
        const int j = a % c->m;
        const double now = c->plan[a];
        const double before = i > 0 ? c->plan[a - c->m] : c->last[j];

        if (s->smooth != NULL) {
            newton->gradient[a] += s->smooth[j] * (now - before) / c->span[j];
            newton->gradient[a] -=
                i < c->moves - 1 ? s->smooth[j] * (c->plan[a + c->m] - now) / c->span[j] : 0.0;
        }
        if (s->effort != NULL) {
            newton->gradient[a] +=
                s->effort[j] * gauss_newton_lasts(c, i) * (now - c->rest[j]) / c->span[j];
        }
    }
}

/* Bounds of z, and the plan itself, cut to what is allowed. */
static void gauss_newton_bounds(const controller *c, gauss_newton *newton)
{
    const controller_settings *s = &c->settings;
    int row = 0;

    memcpy(newton->target, c->plan, (size_t)newton->z * sizeof *newton->target);
    controller_allow(c, newton->target);
    for (int a = 0; a < newton->z; a++) {
        const int j = a % c->m;
        double lower = s->lower[j];
        double upper = s->upper[j];

        if (a < c->m) {
            controller_range(c, j, c->last[j], &lower, &upper);
        }
        newton->lower[a] = (lower - c->plan[a]) / c->span[j];
        newton->upper[a] = (upper - c->plan[a]) / c->span[j];
        newton->inside[a] =
            fmin(fmax((newton->target[a] - c->plan[a]) / c->span[j], newton->lower[a]),
                 newton->upper[a]);
    }
    for (int a = c->m; a < newton->z; a++) {
        const int j = a % c->m;
        const double rate = gauss_newton_rate(s, j);

        if (isfinite(rate)) {
            const double change = c->plan[a] - c->plan[a - c->m];

            newton->row_lower[row] = (-rate - change) / c->span[j];
            newton->row_upper[row++] = (rate - change) / c->span[j];
        }
    }
    for (int r = 0; newton->limited > 0 && r < newton->R; r++) {
        const int k = r % c->v;

        if (gauss_newton_limited(s, k)) {
            double lower, upper;

            gauss_newton_limits(c, k, &lower, &upper);
            newton->row_lower[row] = lower - newton->predicted[r];
            newton->row_upper[row++] = upper - newton->predicted[r];
        }
    }
}

/* The plan goes on to `target`, and the states along it by the linear model. */
SMALL_FOR_EACH_PROCESSOR static void gauss_newton_move(controller *c, gauss_newton *newton)
{
    for (int i = 0; i < c->horizon; i++) {
        const double *move = newton->target + (i < c->moves ? i : c->moves - 1) * c->m;
        double *plan = c->plan + i * c->m;
        double *node = newton->nodes + i * c->n;

        for (int k = 0; k < c->n; k++) {
            node[k] += newton->change[k];
        }
        for (int j = 0; j < c->m; j++) {
            newton->change[c->n + j] = move[j] - plan[j];
            plan[j] = move[j];
        }
        newton->change[c->n + c->m] = 1.0;
        for (int k = 0; k < c->n; k++) {
            newton->other[k] = small_matrix_dot(
                newton->w, newton->steps + (i * c->n + k) * newton->w, newton->change);
        }
        memcpy(newton->change, newton->other, (size_t)c->n * sizeof *newton->change);
    }
    for (int k = 0; k < c->n; k++) {
        newton->nodes[c->horizon * c->n + k] += newton->change[k];
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
SMALL_FOR_EACH_PROCESSOR static bool gauss_newton_costs(controller *c, const gauss_newton *newton)
{
    const controller_settings *s = &c->settings;
    bool violated = false;

    c->cost = 0.0;
    for (int r = 0; r < newton->R; r++) {
        const int k = r % c->v;
        const double change = small_matrix_dot(
            newton->stride, newton->sensitivity + r * newton->stride, newton->result);
        const double error = newton->residual[r] + change;

        c->cost += 0.5 * newton->weight[r] * error * error;
        if (newton->limited > 0 && gauss_newton_limited(s, k)) {
            const double value = newton->predicted[r] + change;
            double lower, upper;

            gauss_newton_limits(c, k, &lower, &upper);
            const double most = fmax(fmax(value - upper, lower - value), 0.0);

            c->cost += 0.5 * s->soft_weight[k] * most * most;
            violated = violated || most > 1e-9 * fmax(1.0, fabs(value));
        }
    }
    c->cost += gauss_newton_cost_of_moves(c);
    return violated;
}

int controller_plan_solve(controller *c)
{
    gauss_newton *newton = c->work;
    qp_bounds bounds = {0};
    qp_status status;

    if (gauss_newton_weights(c, newton) && gauss_newton_hessian(c, newton) != 0) {
        return CONTROLLER_QP;
    }
    gauss_newton_predict(c, newton);
    gauss_newton_gradient(c, newton);
    gauss_newton_bounds(c, newton);
    bounds.lower = newton->lower;
    bounds.upper = newton->upper;
    bounds.A = newton->A;
    bounds.row_lower = newton->row_lower;
    bounds.row_upper = newton->row_upper;
    bounds.softness = newton->softness;
    status = qp_solve(newton->program, newton->gradient, &bounds, newton->inside, newton->result);
    c->iterations = qp_iterations(newton->program);
    if (status != QP_SOLVED && status != QP_LIMIT) {
        return CONTROLLER_QP;
    }
    for (int a = 0; a < newton->z; a++) {
        newton->target[a] = c->plan[a] + newton->result[a] * c->span[a % c->m];
    }
    controller_allow(c, newton->target);
    gauss_newton_move(c, newton);
    return (status == QP_LIMIT ? CONTROLLER_QP_LIMIT : 0) |
           (gauss_newton_costs(c, newton) ? CONTROLLER_SOFT : 0);
}

void controller_plan_shift(controller *c)
{
    gauss_newton *newton = c->work;
    const int rates = (c->moves - 1) * newton->rated;

    qp_shift(newton->program, 0, newton->z, c->m);
    if (rates > 0) {
        qp_shift(newton->program, newton->z, rates, newton->rated);
    }
    if (newton->limited > 0) {
        qp_shift(newton->program, newton->z + rates, c->horizon * newton->limited, newton->limited);
    }
    memmove(newton->nodes, newton->nodes + c->n,
            (size_t)(c->horizon * c->n) * sizeof *newton->nodes);
}
