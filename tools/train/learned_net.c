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
    ad_pool *pool;
    ad_program *program; /* of all outputs */
    /* Of one output, that of which the seed is not 0: by numbers, and by inputs. */
    ad_program *by_theta, *by_x;
    double *z; /* [room] inputs, and seeds behind them */
    size_t room;
};

void learned_tape_free(learned_tape *tape)
{
    if (tape) {
        ad_program_free(tape->program);
        ad_program_free(tape->by_theta);
        ad_program_free(tape->by_x);
        ad_pool_free(tape->pool);
        free(tape->z);
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
    const int parts = 2 * (net->hidden_count + 1);
    const ad_settings settings = ad_settings_default();
    ad_value wrt[PARTS], by[PARTS], y = wrt[parts] = ad_input(tape, "x", net->inputs);
    const ad_value seed = ad_input(tape, "seed", net->outputs);
    size_t offset = 0;
    for (int i = 0; i <= net->hidden_count; i++) {
        y = record_layer(net, i, y, &offset, wrt + 2 * i);
    }
    ad_reverse(ad_dot(seed, y), parts + 1, wrt, AD_PER_POINT, by);
    ad_status status = ad_tape_status(tape, error);
    status = status == AD_OK ? ad_compile(1, &y, &settings, to->pool, &to->program, error) : status;
    status =
        status == AD_OK ? ad_compile(parts, by, &settings, to->pool, &to->by_theta, error) : status;
    return status == AD_OK ? ad_compile(1, by + parts, &settings, to->pool, &to->by_x, error)
                           : status;
}

ad_status learned_tape_create(const learned_net *net, learned_tape **result, ad_error *error)
{
    learned_tape *to = calloc(1, sizeof *to);
    ad_tape *tape = ad_tape_create();
    *result = NULL;
    if (to) {
        to->pool = ad_pool_create(1);
    }
    ad_status status = to && to->pool && tape
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

/* Points, `copies` times: for the derivatives of as many outputs, each of its own copy. */
static ad_status fill(learned_tape *tape, const learned_net *net, size_t points, size_t copies,
                      const double *x, ad_error *error)
{
    const size_t inputs = (size_t)net->inputs, outputs = (size_t)net->outputs;
    const size_t all = copies * points, room = (inputs + outputs) * outputs * points;
    if (tape->room < room) {
        free(tape->z);
        tape->z = malloc(room * sizeof *tape->z);
        tape->room = tape->z ? room : 0;
    }
    if (!tape->z) {
        return ad_fail(error, AD_NO_MEMORY, "out of memory for a network of %zu points", points);
    }
    for (size_t i = 0; i < inputs; i++) {
        for (size_t p = 0; p < points; p++) {
            const double z = (x[i * points + p] - net->middle[i]) / net->half[i];
            for (size_t k = 0; k < copies; k++) {
                tape->z[i * all + k * points + p] = z;
            }
        }
    }
    for (size_t k = 0; k < outputs && copies == outputs; k++) {
        double *seed = tape->z + (inputs + k) * all;
        for (size_t p = 0; p < all; p++) {
            seed[p] = p / points == k ? net->size[k] : 0;
        }
    }
    return AD_OK;
}

static ad_status run(const learned_tape *tape, const learned_net *net, ad_program *program,
                     size_t points, const double *theta, double **outputs, ad_error *error)
{
    const double *const given[] = {tape->z, tape->z + points * (size_t)net->inputs};
    return ad_execute(
        program,
        &(ad_run){.points = points, .inputs = given, .parameters = theta, .outputs = outputs},
        error);
}

ad_status learned_tape_run(learned_tape *tape, const learned_net *net, size_t points,
                           const double *x, const double *theta, double *y, double *by_theta,
                           double *by_x, ad_error *error)
{
    const size_t outputs = (size_t)net->outputs, all = outputs * points;
    double *by[2 * (LEARNED_LAYERS_MAX + 1)];
    ad_status status = fill(tape, net, points, 1, x, error);
    status = status == AD_OK ? run(tape, net, tape->program, points, theta, &y, error) : status;
    for (size_t i = 0; status == AD_OK && i < all; i++) {
        y[i] *= net->size[i / points];
    }
    if (status == AD_OK && (by_theta || by_x)) {
        status = fill(tape, net, points, outputs, x, error);
    }
    if (status == AD_OK && by_theta) {
        for (int i = 0; i <= net->hidden_count; i++) {
            by[2 * i] = by_theta;
            by[2 * i + 1] = by_theta + all * (size_t)rows_of(net, i) * (size_t)columns_of(net, i);
            by_theta += all * numbers_of(net, i);
        }
        status = run(tape, net, tape->by_theta, all, theta, by, error);
    }
    if (status == AD_OK && by_x) {
        status = run(tape, net, tape->by_x, all, theta, &by_x, error);
        for (size_t i = 0; i < all * (size_t)net->inputs; i++) {
            by_x[i] /= net->half[i / all];
        }
    }
    return status;
}
