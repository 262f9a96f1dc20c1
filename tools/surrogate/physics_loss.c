#include "tools/surrogate/physics_internal.h"

#include "autodiff/ranks.h"
#include "nn/rng.h"

#include <math.h>
#include <string.h>

/* What chunks are summed of. */
enum { SUM_VALUE, SUM_FAILED, SUM_GRADIENT };

/* How much the defect at a node counts; the last is the end of the step. */
static const double node_weight[NODES] = {0.1, 0.3, 1};

size_t physics_given(const decoupled *m)
{
    return (size_t)m->states + decoupled_given(m);
}

/* ---- one step ------------------------------------------------------------------------------ */

/* Time of node i of the step: Radau's, or at random, each in a third of the step. */
static void draw_times(const physics_loss *x, size_t item, int ahead, double times[NODES])
{
    uint64_t state = x->settings.seed ^ ((uint64_t)x->number << 20) ^ (item << 5) ^ (uint64_t)ahead;
    for (int i = 0; i < NODES; i++) {
        const double uniform = (double)(nn_splitmix64(&state) >> 11) * 0x1p-53;
        times[i] = x->settings.rates ? (i + uniform) / NODES : decoupled_nodes[i];
    }
}

bool physics_rate(const physics_loss *x, physics_worker *w, const double *given, double t,
                  const double *z, double *rate, double *by_z)
{
    const decoupled *m = x->m;
    const int n = m->states, inputs = m->inputs;
    ad_error error;
    for (int j = 0; j < n; j++) {
        w->state[j] = x->center[j] + x->scale[j] * z[j];
        if (!(fabs(z[j]) < 1e6)) {
            return false;
        }
    }
    for (int k = 0; k < inputs; k++) {
        const double v = given[n + k] + (m->ramps ? t * (given[n + inputs + k] - given[n + k]) : 0);
        w->input[k] = x->input_center[k] + x->input_scale[k] * v;
    }
    if (reduced_rate(w->rod, 0, w->state, w->input, rate, by_z ? w->jacobian : NULL, NULL,
                     &error) != AD_OK) {
        return false;
    }
    for (int r = 0; r < n; r++) {
        const double h = m->step / x->scale[r];
        rate[r] *= h;
        for (int c = 0; c < n && by_z; c++) {
            by_z[r * n + c] = h * w->jacobian[r * n + c] * x->scale[c];
        }
    }
    return true;
}

/* to += matrix from, or its transpose times from; [n][n]. */
static void add_product(size_t n, bool transposed, double by, const double *matrix,
                        const double *from, double *to)
{
    for (size_t r = 0; r < n; r++) {
        double sum = 0;
        for (size_t c = 0; c < n; c++) {
            if (transposed) {
                to[c] += by * matrix[r * n + c] * from[r];
            } else {
                sum += matrix[r * n + c] * from[c];
            }
        }
        to[r] += by * sum;
    }
}

/* Residuals at the nodes: z' - f, the defect of the integral equation, or the distance from what
 * has none. */
static void find_residuals(const physics_loss *x, size_t item, physics_step *s)
{
    const size_t n = (size_t)x->m->states;
    const int *begin = x->begin[item];
    for (size_t k = 0; k < NODES * n && x->target; k++) {
        const size_t step = (size_t)begin[0] * (size_t)x->motions->steps + (size_t)begin[1];
        s->residual[k] = s->y[k] - x->target[step * NODES * n + k];
    }
    if (x->target) {
        return;
    }
    for (size_t i = 0; i < NODES; i++) {
        double *r = s->residual + i * n;
        memcpy(r, (x->settings.rates ? s->rate : s->y) + i * n, n * sizeof *r);
        for (size_t j = 0; j < n && x->settings.rates; j++) {
            r[j] -= s->n[i * n + j];
        }
        for (size_t j = 0; j < NODES && !x->settings.rates; j++) {
            for (size_t k = 0; k < n; k++) {
                r[k] -= x->integral[i][j] * s->n[j * n + k];
            }
        }
    }
}

/* r^T weight r, and weight r. */
static double weighed(const physics_loss *x, const double *r, double *to)
{
    const size_t n = (size_t)x->m->states;
    double sum = 0;
    memset(to, 0, n * sizeof *to);
    add_product(n, false, 1, x->weight, r, to);
    for (size_t j = 0; j < n; j++) {
        sum += r[j] * to[j];
    }
    return sum / (double)n;
}

static bool needs_end(const physics_loss *x)
{
    return x->settings.ahead > 1 || x->settings.data > 0;
}

static bool go_forward(const physics_loss *x, physics_worker *w, size_t item, int ahead,
                       physics_step *s, double *next, double *loss)
{
    const decoupled *m = x->m;
    const size_t n = (size_t)m->states;
    double times[NODES], z[256];
    draw_times(x, item, ahead, times);
    decoupled_network(m, x->parameters, s->given, s->given + n, s->hidden, s->a);
    for (size_t i = 0; i < NODES && x->settings.physics > 0; i++) {
        decoupled_curve(m, s->a, times[i], s->y + i * n,
                        x->settings.rates ? s->rate + i * n : NULL);
        if (x->target) {
            continue;
        }
        for (size_t j = 0; j < n; j++) {
            z[j] = s->given[j] + s->y[i * n + j];
        }
        if (!physics_rate(x, w, s->given, times[i], z, s->n + i * n,
                          x->derives ? s->by_z + i * n * n : NULL)) {
            return false;
        }
    }
    if (x->settings.physics > 0) {
        find_residuals(x, item, s);
        for (size_t i = 0; i < NODES; i++) {
            *loss += x->settings.physics * (x->settings.rates ? 1.0 / NODES : node_weight[i]) *
                     weighed(x, s->residual + i * n, z);
        }
    }
    if (!needs_end(x)) {
        return true;
    }
    decoupled_curve(m, s->a, 1, z, NULL);
    for (size_t j = 0; j < n; j++) {
        next[j] = s->given[j] + z[j];
    }
    return true;
}

/* Adds to the adjoint of given by that of a, and to the gradient. */
static void network_adjoint(const physics_loss *x, physics_worker *w, const physics_step *s,
                            double *gradient)
{
    const decoupled *m = x->m;
    const size_t first = physics_given(m);
    const double *weights = x->parameters, *hidden = s->hidden;
    const double *inputs[DECOUPLED_LAYERS_MAX + 1], *of[DECOUPLED_LAYERS_MAX + 1];
    double *to[DECOUPLED_LAYERS_MAX + 1];
    size_t in[DECOUPLED_LAYERS_MAX + 1];
    for (int l = 0; l <= m->layers; l++) {
        in[l] = l == 0 ? first : (size_t)m->width[l - 1];
        const size_t out = (size_t)(l < m->layers ? m->width[l] : decoupled_outputs(m));
        inputs[l] = l == 0 ? s->given : hidden - in[l];
        of[l] = weights;
        to[l] = gradient;
        weights += out * (in[l] + 1);
        gradient += out * (in[l] + 1);
        hidden += l < m->layers ? out : 0;
    }
    double *adjoint = w->to_a, *before = w->to_hidden;
    for (int l = m->layers; l >= 0; l--) {
        const size_t out = (size_t)(l < m->layers ? m->width[l] : decoupled_outputs(m));
        double *back = l == 0 ? w->to_given : before;
        if (l > 0) {
            memset(back, 0, in[l] * sizeof *back);
        }
        for (size_t r = 0; r < out; r++) {
            const double by = adjoint[r], *row = of[l] + r * in[l];
            double *row_to = to[l] + r * in[l];
            for (size_t c = 0; c < in[l]; c++) {
                row_to[c] += by * inputs[l][c];
                back[c] += by * row[c];
            }
            to[l][out * in[l] + r] += by;
        }
        for (size_t c = 0; c < in[l] && l > 0; c++) {
            back[c] *= 1 - inputs[l][c] * inputs[l][c];
        }
        before = adjoint; /* as wide as the widest of all */
        adjoint = back;
    }
}

/* by_y at node i by that of its state: what f says, through all residuals. */
static void adjoint_of_state(const physics_loss *x, const physics_step *s, size_t i,
                             const double *lambda, double *sum, double *by_z)
{
    const size_t n = (size_t)x->m->states;
    memset(sum, 0, n * sizeof *sum);
    for (size_t j = 0; j < NODES && !x->settings.rates; j++) {
        for (size_t k = 0; k < n; k++) {
            sum[k] -= x->integral[j][i] * lambda[j * n + k];
        }
    }
    for (size_t j = 0; j < n && x->settings.rates; j++) {
        sum[j] = -lambda[i * n + j];
    }
    add_product(n, true, 1, s->by_z + i * n * n, sum, by_z);
}

/* Of a curve by that of the state that it begins at. */
static void add(size_t n, const double *from, double *to)
{
    for (size_t j = 0; j < n; j++) {
        to[j] += from[j];
    }
}

/* Adjoints of one step: w->adjoint[0] of the state at its end becomes that of its begin. */
static void go_back(const physics_loss *x, physics_worker *w, size_t item, int ahead,
                    const physics_step *s, double scale, double *gradient)
{
    const decoupled *m = x->m;
    const size_t n = (size_t)m->states;
    const bool rates = x->settings.rates;
    double times[NODES], *end = w->adjoint[0], *by_z = w->adjoint[1], *sum = w->adjoint[2];
    double *lambda = w->adjoint[3]; /* [NODES][n] */
    draw_times(x, item, ahead, times);
    memset(w->to_a, 0, (size_t)decoupled_outputs(m) * sizeof *w->to_a);
    memset(w->to_given, 0, physics_given(m) * sizeof *w->to_given);
    if (needs_end(x)) {
        decoupled_curve_adjoint(m, s->a, 1, end, NULL, w->to_a);
        add(n, end, w->to_given);
    }
    for (size_t i = 0; i < NODES && x->settings.physics > 0; i++) {
        const double weight = rates ? 1.0 / NODES : node_weight[i];
        weighed(x, s->residual + i * n, lambda + i * n);
        for (size_t j = 0; j < n; j++) {
            lambda[i * n + j] *= 2 * scale * x->settings.physics * weight / (double)n;
        }
    }
    for (size_t i = 0; i < NODES && x->settings.physics > 0; i++) {
        memset(by_z, 0, n * sizeof *by_z);
        if (!x->target) {
            adjoint_of_state(x, s, i, lambda, sum, by_z);
            add(n, by_z, w->to_given);
        }
        for (size_t j = 0; j < n && !rates; j++) {
            by_z[j] += lambda[i * n + j];
        }
        decoupled_curve_adjoint(m, s->a, times[i], by_z, rates ? lambda + i * n : NULL, w->to_a);
    }
    network_adjoint(x, w, s, gradient);
    memcpy(end, w->to_given, n * sizeof *end);
}

/* ---- sequences ----------------------------------------------------------------------------- */

void physics_take_inputs(const physics_loss *x, size_t row, double *v)
{
    const int inputs = x->m->inputs;
    for (int k = 0; k < decoupled_given(x->m); k++) {
        const double u =
            x->motions->input[row * (size_t)inputs + (size_t)k]; /* the next row: end */
        v[k] = (u - x->input_center[k % inputs]) / x->input_scale[k % inputs];
    }
}

void physics_take_state(const physics_loss *x, size_t row, double *z)
{
    const size_t n = (size_t)x->m->states;
    for (size_t j = 0; j < n; j++) {
        z[j] = (x->motions->state[row * n + j] - x->center[j]) / x->scale[j];
    }
}

/* The loss of one beginning times scale, and where it is wanted its gradient. */
static bool evaluate_one(const physics_loss *x, physics_worker *w, size_t item, double scale,
                         double *value, double *gradient)
{
    const size_t n = (size_t)x->m->states;
    const int *begin = x->begin[item], ahead = x->settings.ahead;
    const size_t row = (size_t)begin[0] * (size_t)(x->motions->steps + 1) + (size_t)begin[1];
    double loss = 0, next[256] = {0}, weighted[256];
    physics_take_state(x, row, w->steps[0].given);
    for (int k = 0; k < ahead; k++) {
        physics_step *s = &w->steps[k];
        physics_take_inputs(x, row + (size_t)k, s->given + n);
        if (!go_forward(x, w, item, k, s, next, &loss)) {
            return false;
        }
        physics_take_state(x, row + (size_t)k + 1, s->end);
        for (size_t j = 0; j < n; j++) {
            s->end[j] = next[j] - s->end[j];
        }
        if (x->settings.data > 0) {
            loss += x->settings.data * weighed(x, s->end, weighted);
        }
        if (k + 1 < ahead) {
            memcpy(w->steps[k + 1].given, next, n * sizeof *next);
        }
    }
    *value += scale * loss / ahead;
    memset(w->adjoint[0], 0, n * sizeof *w->adjoint[0]);
    for (int k = ahead - 1; k >= 0 && x->derives; k--) {
        const physics_step *s = &w->steps[k];
        weighed(x, s->end, weighted);
        for (size_t j = 0; j < n && x->settings.data > 0; j++) {
            w->adjoint[0][j] += 2 * scale / ahead * x->settings.data * weighted[j] / (double)n;
        }
        go_back(x, w, item, k, s, scale / ahead, gradient);
    }
    return isfinite(*value);
}

static size_t batch_of(const physics_loss *x)
{
    const size_t batch = (size_t)x->settings.batch;
    return batch > 0 && batch < x->count ? batch : x->count;
}

static size_t sum_width(const physics_loss *x)
{
    return SUM_GRADIENT + (x->derives ? decoupled_parameters(x->m) : 0);
}

static void run_chunk(void *context, int chunk, int thread)
{
    const physics_loss *x = context;
    const size_t all = batch_of(x), width = sum_width(x);
    double *sum = x->sums + (size_t)chunk * width;
    memset(sum, 0, width * sizeof *sum);
    for (size_t i = (size_t)chunk; i < all && sum[SUM_FAILED] == 0; i += CHUNKS) {
        uint64_t state = x->settings.seed ^ ((uint64_t)x->number << 24) ^ i;
        const size_t item = all < x->count ? nn_splitmix64(&state) % x->count : i;
        sum[SUM_FAILED] = !evaluate_one(x, &x->workers[thread], item, x->factor / (double)all,
                                        &sum[SUM_VALUE], sum + SUM_GRADIENT);
    }
}

void physics_loss_draw(physics_loss *x, int64_t number)
{
    x->number = number;
}

int physics_loss_evaluate(void *loss, const double *parameters, double *value, double *gradient)
{
    physics_loss *x = loss;
    const size_t count = decoupled_parameters(x->m);
    x->parameters = parameters;
    x->derives = gradient != NULL;
    const size_t width = sum_width(x);
    double *total = x->sums + CHUNKS * width;
    if (ad_pool_sum(x->pool, CHUNKS, run_chunk, x, width, x->sums, total, NULL) != AD_OK) {
        return 2; /* OPTIM_OBJECTIVE_STOP */
    }
    *value = total[SUM_VALUE];
    if (gradient) {
        memcpy(gradient, total + SUM_GRADIENT, count * sizeof *gradient);
    }
    return total[SUM_FAILED] == 0 && isfinite(*value) ? 0 : 1; /* OPTIM_OBJECTIVE_NOT_FINITE */
}
