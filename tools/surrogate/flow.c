/* The network of a step: what the linear map leaves over of solved steps, in the robot's frame.
 *
 * The loss is the sum of squares of the errors of each class, by a factor of the Gramian, over that
 * of the linear map alone. The output layer is found by least squares in every evaluation (variable
 * projection: Golub & Pereyra, SIAM J. Numer. Anal. 10, 1973), so that parameters are those of the
 * hidden layers; the gradient by them is that at fixed output weights, as these are at their best.
 */
#include "tools/surrogate/flow.h"

#include "autodiff/dense.h"
#include "autodiff/memory.h"
#include "nn/rng.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

/* Of output weights, beside the mean square of features. */
static const double RIDGE = 1e-9;

/* Errors at nodes within a step, which take units from its end, count so much as if those of their
 * linear maps were as large as at the end. */
static const double INNER = 0.1;

/* Outputs with one set of features and one scaling of them. */
typedef struct head {
    int each, first;     /* of the outputs of this parity, as a layer has them */
    int outputs;         /* each of all nodes */
    bool odd, shortened; /* by which hidden units; times the length of the frame */
    int slot;            /* of the state's first number in z */
    double factor[SURROGATE_STATES_MAX * SURROGATE_STATES_MAX]; /* L of Q = L L^T, [each]^2 */
    double *target;                                             /* [outputs][count] */
    double *features;                                           /* [hidden + 1][count] */
    double *gram, *weights; /* [hidden + 1]^2, [outputs][hidden + 1] */
    int width;              /* hidden units and 1, where it is even */
} head;

enum { HEADS = 4 };

struct surrogate_flow {
    const surrogate_step *m;
    ad_pool *pool;
    size_t count, parameters;
    int nodes, heads;
    double weight[SURROGATE_NODES]; /* of nodes */
    head head[HEADS];
    double *even, *odd, *length; /* [inputs][count]; of the frame */
    ad_program *forward, *gradient;
    double scale;               /* of the loss: 1 over that of the linear map */
    ad_dense_factor *factor[2]; /* of each parity */
    ad_memory memory;
};

/* ---- shapes -------------------------------------------------------------------------------- */

/* Inputs of hidden layer `at`, `odd` ones only with a mirror. */
static int layer_inputs(const surrogate_step *m, int at, bool odd)
{
    if (at > 0) {
        return m->mirrors ? m->width[at - 1] / 2 : odd ? 0 : m->width[at - 1];
    }
    return m->mirrors ? m->pairs + (odd ? m->odds : m->evens)
           : odd      ? 0
                      : 2 * m->pairs + m->evens + m->odds;
}

static int find_heads(surrogate_flow *flow)
{
    const surrogate_step *m = flow->m;
    const int p = m->out_pairs, q = 2 * m->pairs;
    int count = 0;
    const head all[] = {
        {.each = p, .first = 0, .shortened = true, .slot = 0},
        {.each = p,
         .first = m->mirrors ? 0 : p,
         .odd = m->mirrors,
         .shortened = true,
         .slot = m->pairs},
        {.each = m->out_evens, .first = m->mirrors ? p : 2 * p, .slot = q},
        {.each = m->out_odds,
         .first = m->mirrors ? p : 2 * p + m->out_evens,
         .odd = m->mirrors,
         .slot = q + m->evens},
    };
    for (int i = 0; i < HEADS; i++) {
        if (all[i].each > 0) {
            flow->head[count] = all[i];
            flow->head[count++].outputs = flow->nodes * all[i].each;
        }
    }
    return count;
}

static int hidden(const surrogate_step *m, bool odd)
{
    return layer_inputs(m, m->layers, odd);
}

size_t surrogate_flow_parameters(const surrogate_flow *flow)
{
    return flow->parameters;
}

static size_t count_parameters(const surrogate_step *m)
{
    size_t all = 0;
    for (int at = 0; at < m->layers; at++) {
        all += (size_t)((layer_inputs(m, at, false) + 1) * layer_inputs(m, at + 1, false) +
                        layer_inputs(m, at, true) * layer_inputs(m, at + 1, true));
    }
    return all;
}

/* ---- data ---------------------------------------------------------------------------------- */

/* The lower Cholesky factor of Q [n][n] for the states of a head, both components of pairs alike;
 * false: not positive. */
static bool factor_gramian(const surrogate_step *m, const double *q, head *h)
{
    int of[SURROGATE_STATES_MAX], partner[SURROGATE_STATES_MAX];
    const int other = h->slot == 0 ? m->pairs : h->slot == m->pairs ? 0 : h->slot, n = m->states;
    for (int k = 0; k < n; k++) {
        for (int o = 0; o < h->each; o++) {
            of[o] = m->state_slot[k] == h->slot + o ? k : of[o];
            partner[o] = m->state_slot[k] == (h->shortened ? other : h->slot) + o ? k : partner[o];
        }
    }
    for (int i = 0; i < h->each; i++) {
        for (int j = 0; j <= i; j++) {
            double sum = 0.5 * (q[of[i] * n + of[j]] + q[partner[i] * n + partner[j]]);
            for (int k = 0; k < j; k++) {
                sum -= h->factor[i * h->each + k] * h->factor[j * h->each + k];
            }
            if (i == j && !(sum > 0)) {
                return false;
            }
            h->factor[i * h->each + j] = i == j ? sqrt(sum) : sum / h->factor[j * h->each + j];
        }
    }
    return true;
}

/* Sample i: features in the frame, and what the linear map of a node leaves over, turned and
 * weighted. */
static void fill_sample(surrogate_flow *flow, const surrogate_steps *steps, size_t i, int node,
                        const double *next, const double *linear)
{
    enum { MOST = 2 * SURROGATE_STATES_MAX + 2 * SURROGATE_INPUTS_MAX };
    const surrogate_step *m = flow->m;
    const surrogate_numbers from = surrogate_numbers_of(m, (double *)m->numbers);
    const size_t n = (size_t)m->states, all = (size_t)m->inputs * (m->ramps ? 2 : 1);
    const int p = m->pairs;
    double z[MOST], rest[MOST] = {0}, w[2] = {0, 0}, c = 1, s = 0, length = 1;
    surrogate_coordinates(m, steps->state + i * n, steps->input + i * all, z);
    for (int k = 0; k < m->states; k++) {
        rest[m->state_slot[k]] = (next[i * n + (size_t)k] - linear[k]) / from.state_scale[k];
    }
    if (m->turns) {
        for (int k = 0; k < p; k++) {
            w[0] += from.lead[k] * z[k];
            w[1] += from.lead[k] * z[p + k];
        }
        const double rho = sqrt(w[0] * w[0] + w[1] * w[1] + m->soft * m->soft);
        c = w[0] / rho;
        s = -w[1] / rho;
        length = hypot(c, s);
    }
    flow->length[i] = length;
    for (int k = 0; k < p && m->turns; k++) {
        const double re = z[k], turned = rest[k];
        const double cosine = length > 0 ? c / length : 1, sine = length > 0 ? s / length : 0;
        z[k] = re * c - z[p + k] * s;
        z[p + k] = re * s + z[p + k] * c;
        rest[k] = turned * cosine - rest[p + k] * sine;
        rest[p + k] = turned * sine + rest[p + k] * cosine;
    }
    for (int k = 0; k < 2 * p + m->evens + m->odds; k++) {
        const bool odd = m->mirrors && ((k >= p && k < 2 * p) || k >= 2 * p + m->evens);
        const int row = !m->mirrors            ? k
                        : k < 2 * p            ? k % p
                        : k < 2 * p + m->evens ? k - p
                                               : k - p - m->evens;
        (odd ? flow->odd : flow->even)[(size_t)row * flow->count + i] = z[k];
    }
    for (int b = 0; b < flow->heads; b++) { /* L^T e */
        const head *h = &flow->head[b];
        for (int o = 0; o < h->each; o++) {
            double sum = 0;
            for (int k = o; k < h->each; k++) {
                sum += h->factor[k * h->each + o] * rest[h->slot + k];
            }
            h->target[(size_t)(node * h->each + o) * flow->count + i] = sum;
        }
    }
}

/* Multiplies what the linear map of a node leaves over; returns the sum of squares. */
static double weigh_node(surrogate_flow *flow, int node, double weight)
{
    double sum = 0;
    for (int b = 0; b < flow->heads; b++) {
        const size_t size = flow->count * (size_t)flow->head[b].each;
        double *target = flow->head[b].target + (size_t)node * size;
        for (size_t i = 0; i < size; i++) {
            target[i] *= weight;
            sum += target[i] * target[i];
        }
    }
    return sum;
}

static ad_status fill(surrogate_flow *flow, const surrogate_node *node,
                      const surrogate_steps *steps, const double *q, ad_error *error)
{
    surrogate_step linear = *flow->m;
    linear.layers = 0;
    double base[SURROGATE_STATES_MAX], sum = 0, first = 0;
    double *work = malloc((surrogate_step_work(&linear) + 1) * sizeof *work);
    ad_status status = work ? AD_OK : ad_fail(error, AD_NO_MEMORY, "out of memory for steps");
    for (int b = 0; b < flow->heads && status == AD_OK; b++) {
        status = factor_gramian(flow->m, q, &flow->head[b])
                     ? AD_OK
                     : ad_fail(error, AD_NOT_FINITE,
                               "what errors of the linear map do to the tip is not finite");
    }
    const size_t n = (size_t)linear.states, m = (size_t)linear.inputs,
                 all = linear.ramps ? 2 * m : m;
    for (size_t i = 0; i < flow->count * (size_t)flow->nodes && status == AD_OK; i++) {
        const size_t sample = i % flow->count, k = i / flow->count;
        const double *u = steps->input + sample * all;
        linear.numbers = node[k].m->numbers;
        surrogate_step_advance(&linear, work, 1, linear.step, steps->state + sample * n, u,
                               linear.ramps ? u + m : NULL, base, NULL, NULL);
        fill_sample(flow, steps, sample, (int)k, node[k].next, base);
    }
    for (int k = 0; k < flow->nodes && status == AD_OK; k++) {
        const double own = weigh_node(flow, k, 1);
        flow->weight[k] = k == 0 || !(own > 0) ? 1 : INNER * sqrt(first / own);
        sum += weigh_node(flow, k, flow->weight[k]);
        first = k == 0 ? own : first;
    }
    flow->scale = sum > 0 ? 1 / sum : 1;
    free(work);
    return status;
}

/* ---- recording ----------------------------------------------------------------------------- */

/* Hidden units, even and odd, on the tape; wrt receives the parameters' values. */
static int record_hidden(const surrogate_step *m, ad_value units[2], ad_value *wrt)
{
    ad_tape *tape = units[0].tape;
    size_t at = 0;
    int count = 0;
    for (int l = 0; l < m->layers; l++) {
        for (int odd = 0; odd < (m->mirrors ? 2 : 1); odd++) {
            const int in = layer_inputs(m, l, odd == 1), out = layer_inputs(m, l + 1, odd == 1);
            ad_value w = wrt[count++] = ad_parameter(tape, "weight", in * out, at);
            at += (size_t)(in * out);
            units[odd] = ad_matvec_transposed(w, units[odd]);
            if (!odd) {
                wrt[count] = ad_parameter(tape, "bias", out, at);
                units[0] = ad_add(units[0], wrt[count++]);
                at += (size_t)out;
            }
        }
        if (m->mirrors) {
            ad_value one = ad_tanh(ad_add(units[0], units[1]));
            ad_value other = ad_tanh(ad_sub(units[0], units[1]));
            units[0] = ad_scale(ad_add(one, other), 0.5);
            units[1] = ad_scale(ad_sub(one, other), 0.5);
        } else {
            units[0] = ad_tanh(units[0]);
        }
    }
    return count;
}

static ad_status record(surrogate_flow *flow, ad_error *error)
{
    const surrogate_step *m = flow->m;
    ad_tape *tape = ad_tape_create();
    ad_value units[2], length, features[HEADS], wrt[4 * SURROGATE_LAYERS_MAX], loss;
    ad_value outputs[4 * SURROGATE_LAYERS_MAX + 1];
    units[0] = ad_input(tape, "even", layer_inputs(m, 0, false));
    units[1] = m->mirrors ? ad_input(tape, "odd", layer_inputs(m, 0, true)) : units[0];
    length = ad_input(tape, "length", 1);
    const int count = record_hidden(m, units, wrt);
    loss = ad_scalar(tape, 0);
    const ad_value one = ad_add(ad_scale(length, 0x1p-1000), ad_scalar(tape, 1)); /* varies */
    for (int b = 0; b < flow->heads; b++) {
        const head *h = &flow->head[b];
        const ad_value parts[2] = {units[h->odd], one};
        ad_value f = h->odd ? units[1] : ad_stack(2, parts);
        f = features[b] = h->shortened ? ad_mul(f, length) : f;
        const ad_value target = ad_input(tape, "target", h->outputs);
        const ad_value w = ad_uniform(tape, "output", h->outputs * h->width);
        const ad_value off = ad_sub(target, ad_matvec(w, f));
        loss = ad_add(loss, ad_sum_points(ad_sum_rows(ad_square(off))));
    }
    outputs[0] = ad_scale(loss, flow->scale);
    ad_status status = ad_reverse(outputs[0], count, wrt, AD_SUMMED, outputs + 1);
    if (status == AD_OK) {
        status = ad_compile(flow->heads, features, NULL, flow->pool, &flow->forward, error);
    } else {
        ad_tape_status(tape, error);
    }
    if (status == AD_OK) {
        status = ad_compile(count + 1, outputs, NULL, flow->pool, &flow->gradient, error);
    }
    ad_tape_free(tape);
    return status;
}

/* ---- evaluation ---------------------------------------------------------------------------- */

/* Inputs of both programs in the order of their recording. */
static void list_inputs(const surrogate_flow *flow, const double **inputs)
{
    int count = 0;
    inputs[count++] = flow->even;
    if (flow->m->mirrors) {
        inputs[count++] = flow->odd;
    }
    inputs[count++] = flow->length;
    for (int b = 0; b < flow->heads; b++) {
        inputs[count++] = flow->head[b].target;
    }
}

/* Output weights for the hidden parameters; returns the loss of the ridge, not a number where a
 * feature is not finite. */
static double solve_outputs(surrogate_flow *flow, const double *parameters)
{
    const double *inputs[HEADS + 3];
    double *features[HEADS], ridge = 0, shift[2 * NN_INPUTS_MAX * NN_INPUTS_MAX];
    list_inputs(flow, inputs);
    for (int b = 0; b < flow->heads; b++) {
        features[b] = flow->head[b].features;
    }
    const ad_run run = {
        .points = flow->count, .inputs = inputs, .parameters = parameters, .outputs = features};
    if (ad_execute(flow->forward, &run, NULL) != AD_OK) {
        return NAN;
    }
    for (int b = 0; b < flow->heads; b++) {
        head *h = &flow->head[b];
        const size_t f = (size_t)h->width, outs = (size_t)h->outputs;
        const double little = RIDGE * (double)flow->count;
        ad_dense_multiply(flow->pool, false, true, f, f, flow->count, h->features, h->features, 0,
                          h->gram);
        ad_dense_multiply(flow->pool, false, true, outs, f, flow->count, h->target, h->features, 0,
                          h->weights);
        for (size_t i = 0; i < f; i++) {
            shift[i] = little;
        }
        if (ad_dense_cholesky(flow->pool, h->gram, shift, flow->factor[h->odd]) != 0) {
            return NAN;
        }
        for (size_t o = 0; o < outs; o++) {
            ad_dense_cholesky_solve(flow->factor[h->odd], h->weights + o * f);
            for (size_t i = 0; i < f; i++) {
                ridge += little * h->weights[o * f + i] * h->weights[o * f + i];
            }
        }
    }
    return ridge * flow->scale;
}

int surrogate_flow_evaluate(void *flow, const double *parameters, double *value, double *gradient)
{
    surrogate_flow *of = flow;
    const double *inputs[HEADS + 3], *uniforms[HEADS];
    double *outputs[4 * SURROGATE_LAYERS_MAX + 1] = {value}, *at = gradient;
    const double ridge = solve_outputs(of, parameters);
    int count = 1;
    if (!isfinite(ridge)) {
        return OPTIM_OBJECTIVE_NOT_FINITE;
    }
    list_inputs(of, inputs);
    for (int b = 0; b < of->heads; b++) {
        uniforms[b] = of->head[b].weights;
    }
    for (int l = 0; l < of->m->layers; l++) {
        for (int odd = 0; odd < (of->m->mirrors ? 2 : 1); odd++) {
            const int in = layer_inputs(of->m, l, odd == 1),
                      out = layer_inputs(of->m, l + 1, odd == 1);
            outputs[count++] = at;
            at += in * out;
            if (!odd) {
                outputs[count++] = at;
                at += out;
            }
        }
    }
    const ad_run run = {.points = of->count,
                        .inputs = inputs,
                        .uniforms = uniforms,
                        .parameters = parameters,
                        .outputs = outputs};
    if (ad_execute(of->gradient, &run, NULL) != AD_OK) {
        return OPTIM_OBJECTIVE_STOP;
    }
    *value += ridge;
    return isfinite(*value) ? OPTIM_OBJECTIVE_OK : OPTIM_OBJECTIVE_NOT_FINITE;
}

/* ---- the whole network --------------------------------------------------------------------- */

/* L^-T of the columns of weights into the layer `to` [width][outs]. */
static void add_outputs(const head *h, int node, double weight, int outs, double *to)
{
    const int n = h->each;
    for (int i = 0; i < h->width; i++) {
        double column[SURROGATE_STATES_MAX];
        for (int o = n; o-- > 0;) {
            double sum = h->weights[(node * n + o) * h->width + i] / weight;
            for (int k = o + 1; k < n; k++) {
                sum -= h->factor[k * n + o] * column[k];
            }
            column[o] = sum / h->factor[o * n + o];
            to[i * outs + h->first + o] = column[o];
        }
    }
}

bool surrogate_flow_finish(surrogate_flow *flow, const double *parameters, double *const *network)
{
    const surrogate_step *m = flow->m;
    const int outs[2] = {m->mirrors ? m->out_pairs + m->out_evens : m->states,
                         m->mirrors ? m->out_pairs + m->out_odds : 0};
    if (isnan(solve_outputs(flow, parameters))) {
        return false;
    }
    for (int i = 0; i < flow->nodes * flow->heads; i++) {
        const int node = i / flow->heads;
        const head *h = &flow->head[i % flow->heads];
        double *even = network[node] + flow->parameters;
        double *odd = even + (hidden(m, false) + 1) * outs[0];
        memcpy(network[node], parameters, flow->parameters * sizeof *parameters);
        add_outputs(h, node, flow->weight[node], outs[h->odd], h->odd ? odd : even);
    }
    return true;
}

void surrogate_flow_start(const surrogate_flow *flow, uint64_t seed, double *parameters)
{
    const surrogate_step *m = flow->m;
    nn_rng random = nn_rng_split(seed, "initialisation");
    for (int l = 0; l < m->layers; l++) {
        const int all = layer_inputs(m, l, false) + layer_inputs(m, l, true);
        for (int odd = 0; odd < (m->mirrors ? 2 : 1); odd++) {
            const int in = layer_inputs(m, l, odd == 1), out = layer_inputs(m, l + 1, odd == 1);
            for (int i = 0; i < (in + !odd) * out; i++) {
                *parameters++ = nn_rng_normal(&random) * (i < in * out ? 1 / sqrt(all) : 0.3);
            }
        }
    }
}

/* ---- making -------------------------------------------------------------------------------- */

static bool allocate(surrogate_flow *flow)
{
    const surrogate_step *m = flow->m;
    bool fine = true;
    AD_TAKE(flow, even, (size_t)layer_inputs(m, 0, false) * flow->count + 1);
    AD_TAKE(flow, odd, (size_t)layer_inputs(m, 0, true) * flow->count + 1);
    AD_TAKE(flow, length, flow->count + 1);
    for (int odd = 0; odd < 2; odd++) {
        const size_t f = (size_t)hidden(m, odd == 1) + (odd == 0);
        flow->factor[odd] = f > 0 ? ad_dense_factor_create(f) : NULL;
        fine = fine && (f == 0 || flow->factor[odd]);
    }
    for (int b = 0; b < flow->heads; b++) {
        head *h = &flow->head[b];
        h->width = hidden(m, h->odd) + !h->odd;
        const size_t f = (size_t)h->width, outs = (size_t)h->outputs;
        AD_TAKE(flow, head[b].target, outs * flow->count);
        AD_TAKE(flow, head[b].features, f * flow->count);
        AD_TAKE(flow, head[b].gram, f * f);
        AD_TAKE(flow, head[b].weights, outs * f);
    }
    return fine && !flow->memory.is_short;
}

ad_status surrogate_flow_create(int nodes, const surrogate_node *node, const surrogate_steps *steps,
                                const double *q, ad_pool *pool, surrogate_flow **result,
                                ad_error *error)
{
    surrogate_flow *flow = calloc(1, sizeof *flow);
    *result = NULL;
    if (!flow) {
        return ad_fail(error, AD_NO_MEMORY, "out of memory for a one-step model");
    }
    flow->m = node[0].m;
    flow->nodes = nodes;
    flow->pool = pool;
    flow->count = steps->count;
    flow->parameters = count_parameters(flow->m);
    flow->heads = find_heads(flow);
    ad_status status =
        allocate(flow) ? AD_OK : ad_fail(error, AD_NO_MEMORY, "out of memory for a one-step model");
    status = status == AD_OK ? fill(flow, node, steps, q, error) : status;
    status = status == AD_OK ? record(flow, error) : status;
    if (status != AD_OK) {
        surrogate_flow_free(flow);
        return status;
    }
    *result = flow;
    return AD_OK;
}

void surrogate_flow_free(surrogate_flow *flow)
{
    if (flow) {
        ad_program_free(flow->forward);
        ad_program_free(flow->gradient);
        ad_dense_factor_free(flow->factor[0]);
        ad_dense_factor_free(flow->factor[1]);
        ad_memory_free(&flow->memory);
        free(flow);
    }
}
