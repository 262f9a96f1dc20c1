#include "tools/train/learned_net.h"

#include "nn/nn.h"

#include <math.h>
#include <stdlib.h>

/* Layers: the hidden ones, and the last. Of theta first weights [rows][columns], then biases. */
static int rows_of(const learned_net *net, int layer)
{
    return layer < net->hidden_count ? net->hidden[layer] : net->outputs;
}

static int columns_of(const learned_net *net, int layer)
{
    return layer == 0 ? net->inputs : net->hidden[layer - 1];
}

static size_t numbers_of(const learned_net *net, int layer)
{
    return (size_t)rows_of(net, layer) * (size_t)(columns_of(net, layer) + 1);
}

size_t learned_net_count(const learned_net *net)
{
    size_t count = 0;
    for (int i = 0; i <= net->hidden_count; i++) {
        count += numbers_of(net, i);
    }
    return count;
}

/* What theta of weights is multiplied with; that of biases is 1. */
static double scale_of(const learned_net *net, int layer)
{
    return 1 / sqrt(columns_of(net, layer));
}

void learned_net_draw(const learned_net *net, uint64_t seed, double *theta)
{
    nn_rng rng = nn_rng_split(seed, "learned");
    const size_t last = learned_net_count(net) - numbers_of(net, net->hidden_count);
    for (size_t i = 0; i < learned_net_count(net); i++) {
        theta[i] = i < last ? nn_rng_normal(&rng) : 0;
    }
}

/* ---- as formulas --------------------------------------------------------------------------- */

static void layer_formula(const learned_net *net, int layer, const double *theta, const quantity *x,
                          quantity *y)
{
    const int rows = rows_of(net, layer), columns = columns_of(net, layer);
    for (int r = 0; r < rows; r++) {
        y[r] = quantity_number(theta[rows * columns + r]);
        for (int c = 0; c < columns; c++) {
            const double weight = scale_of(net, layer) * theta[r * columns + c];
            y[r] = quantity_add(y[r], quantity_scale(x[c], weight));
        }
        y[r] = layer < net->hidden_count ? quantity_call("tanh", &y[r])
                                         : quantity_scale(y[r], net->size[r]);
    }
}

void learned_net_formula(const learned_net *net, const double *theta, const quantity *x,
                         quantity *y)
{
    enum { WIDTH = LEARNED_OUTPUTS_MAX };
    quantity from[WIDTH], to[WIDTH];
    for (int i = 0; i < net->inputs; i++) {
        from[i] = quantity_scale(quantity_subtract(x[i], quantity_number(net->middle[i])),
                                 1 / net->half[i]);
    }
    for (int i = 0; i <= net->hidden_count; i++) {
        layer_formula(net, i, theta, from, to);
        for (int r = 0; r < rows_of(net, i); r++) {
            (i < net->hidden_count ? from : y)[r] = to[r];
        }
        theta += numbers_of(net, i);
    }
}

/* ---- on the tape --------------------------------------------------------------------------- */

struct learned_tape {
    int inputs, outputs;
    size_t count, parts; /* of theta and x; weights and biases of layers, and x */
    ad_pool *pool;
    ad_program *program, *derive; /* the outputs, and with their adjoints by all parts */
    double *z, **out;             /* [inputs + 1][points], [1 + outputs parts] */
    size_t points;
};

void learned_tape_free(learned_tape *tape)
{
    if (tape) {
        ad_program_free(tape->program);
        ad_program_free(tape->derive);
        ad_pool_free(tape->pool);
        free(tape->z);
        free(tape->out);
        free(tape);
    }
}

static ad_value record_layer(const learned_net *net, int layer, ad_value x, size_t *offset,
                             ad_value wrt[2])
{
    const int rows = rows_of(net, layer), columns = columns_of(net, layer);
    wrt[0] = ad_parameter(x.tape, "weight", rows * columns, *offset);
    wrt[1] = ad_parameter(x.tape, "bias", rows, *offset + (size_t)rows * (size_t)columns);
    *offset += numbers_of(net, layer);
    ad_value y = ad_add(ad_matvec(ad_scale(wrt[0], scale_of(net, layer)), x), wrt[1]);
    return layer < net->hidden_count ? ad_tanh(y) : y;
}

static ad_status record(learned_tape *to, const learned_net *net, ad_tape *tape, ad_error *error)
{
    enum { PARTS = 2 * (LEARNED_LAYERS_MAX + 1) + 1 };
    ad_value wrt[PARTS], all[1 + LEARNED_OUTPUTS_MAX * PARTS];
    ad_value x = wrt[to->parts - 1] = ad_input(tape, "x", net->inputs);
    const ad_value one = ad_input(tape, "one", 1); /* what is the same at all points varies by it */
    size_t offset = 0;
    for (int i = 0; i <= net->hidden_count; i++) {
        x = record_layer(net, i, x, &offset, wrt + 2 * i);
    }
    all[0] = ad_mul(x, one);
    for (int k = 0; k < net->outputs; k++) {
        ad_value *by = all + 1 + (size_t)k * to->parts;
        ad_reverse(ad_row(x, k), (int)to->parts, wrt, AD_PER_POINT, by);
        for (size_t i = 0; i < to->parts; i++) {
            by[i] = ad_mul(by[i], one);
        }
    }
    const ad_settings settings = ad_settings_default();
    const int count = 1 + net->outputs * (int)to->parts;
    ad_status status = ad_tape_status(tape, error);
    status =
        status == AD_OK ? ad_compile(1, all, &settings, to->pool, &to->program, error) : status;
    return status == AD_OK ? ad_compile(count, all, &settings, to->pool, &to->derive, error)
                           : status;
}

ad_status learned_tape_create(const learned_net *net, learned_tape **result, ad_error *error)
{
    learned_tape *to = calloc(1, sizeof *to);
    ad_tape *tape = ad_tape_create();
    *result = NULL;
    if (to) {
        *to = (learned_tape){.inputs = net->inputs,
                             .outputs = net->outputs,
                             .count = learned_net_count(net) + (size_t)net->inputs,
                             .parts = 2 * (size_t)(net->hidden_count + 1) + 1,
                             .pool = ad_pool_create(1)};
        to->out = calloc(1 + (size_t)net->outputs * to->parts, sizeof *to->out);
    }
    ad_status status = to && to->pool && to->out && tape
                           ? record(to, net, tape, error)
                           : ad_fail(error, AD_NO_MEMORY, "out of memory for a network");
    ad_tape_free(tape);
    if (status == AD_OK) {
        *result = to;
    } else {
        learned_tape_free(to);
    }
    return status;
}

static ad_status scale_inputs(learned_tape *tape, const learned_net *net, size_t points,
                              const double *x, ad_error *error)
{
    if (tape->points < points) {
        free(tape->z);
        tape->z = malloc(points * (size_t)(net->inputs + 1) * sizeof *tape->z);
        tape->points = tape->z ? points : 0;
    }
    if (!tape->z) {
        return ad_fail(error, AD_NO_MEMORY, "out of memory for a network of %zu points", points);
    }
    for (size_t i = 0; i < points * (size_t)net->inputs; i++) {
        tape->z[i] = (x[i] - net->middle[i / points]) / net->half[i / points];
    }
    for (size_t i = 0; i < points; i++) {
        tape->z[points * (size_t)net->inputs + i] = 1;
    }
    return AD_OK;
}

ad_status learned_tape_run(learned_tape *tape, const learned_net *net, size_t points,
                           const double *x, const double *theta, double *y, double *by,
                           ad_error *error)
{
    double **out = tape->out;
    out[0] = y;
    for (int k = 0, n = 1; by && k < net->outputs; k++) {
        for (int layer = 0; layer <= net->hidden_count; layer++) {
            const size_t rows = (size_t)rows_of(net, layer);
            const size_t weights = rows * (size_t)columns_of(net, layer);
            out[n++] = by;
            out[n++] = by + weights * points;
            by += (weights + rows) * points;
        }
        out[n++] = by;
        by += (size_t)net->inputs * points;
    }
    ad_status status = scale_inputs(tape, net, points, x, error);
    const double *const given[] = {tape->z, tape->z + points * (size_t)net->inputs};
    if (status == AD_OK) {
        const ad_run run = {.points = points, .inputs = given, .parameters = theta, .outputs = out};
        status = ad_execute(by ? tape->derive : tape->program, &run, error);
    }
    for (size_t k = 0; status == AD_OK && k < (size_t)net->outputs; k++) {
        const size_t numbers = by ? tape->count * points : 0;
        double *to = by ? by - (size_t)net->outputs * numbers + k * numbers : NULL;
        for (size_t i = 0; i < points; i++) {
            y[k * points + i] *= net->size[k];
        }
        for (size_t i = 0; i < numbers; i++) {
            const size_t row = i / points, theta_count = tape->count - (size_t)net->inputs;
            to[i] *= row < theta_count ? net->size[k] : net->size[k] / net->half[row - theta_count];
        }
    }
    return status;
}
