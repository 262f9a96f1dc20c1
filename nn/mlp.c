/* Dense networks: hidden layers activation(W x + b), a linear last layer. */
#include "nn/basis.h"
#include "nn/polynomial.h"

#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

static const double NN_PI = 3.14159265358979323846;

/* First layer of sine networks: weights uniform within NN_SINE_FREQUENCY / inputs, the rule of
 * SIREN (Sitzmann et al. 2020, section 3.2) with 3 in place of its 30: inputs lie in [-1, 1] and
 * the residuals differentiate twice, which amplifies a needless frequency by its square. */
static const double NN_SINE_FREQUENCY = 3.0;

enum {
    NN_WIDTH_MAX = 4096,
    NN_OUTPUTS_MAX = 256,
    NN_FOURIER_MAX = 1024,
    NN_SCALARS_MAX = 64,
    NN_POLYNOMIALS_MAX = 8192
};

/* Functions [rows][nn_basis_functions] that a layer without hidden ones sees; NULL: there are none.
 */
typedef struct nn_basis {
    int rows;
    double *coefficients;
} nn_basis;

struct nn_mlp {
    nn_mlp_settings settings;
    int view_count; /* weight and bias of each layer, then of the edges of pieces, then scalars */
    nn_view views[2 * (NN_HIDDEN_MAX + 2) + 1];
    size_t parameters;
    double *fourier; /* [fourier_features][inputs], NULL when there are none */
    nn_basis basis;  /* of a linear network with features */
    nn_basis edges;  /* the same where the first input does not vary */
};

nn_mlp_settings nn_mlp_settings_default(void)
{
    nn_mlp_settings settings = {.inputs = 1,
                                .outputs = 1,
                                .pieces = 1,
                                .hidden_count = 3,
                                .hidden = {32, 32, 32},
                                .activation = NN_TANH,
                                .initialization = NN_GLOROT,
                                .orthonormal = true,
                                .fourier_features = 0};
    for (int i = 0; i < NN_INPUTS_MAX; i++) {
        settings.fourier_bandwidth[i] = 2 * NN_PI;
        settings.range[i] = 1;
    }
    return settings;
}

static const char *check_polynomials(const nn_mlp_settings *settings)
{
    if (settings->degree < 0 || settings->degree > NN_DEGREE_MAX) {
        return "polynomial.degree: 0 to 32";
    }
    if (settings->hidden_count > 0 || settings->fourier_features > 0 || settings->pieces > 1) {
        return "polynomial.degree: without hidden layers, Fourier features and windows";
    }
    for (int i = 0; i < settings->inputs; i++) {
        if (!(settings->range[i] > 0 && settings->range[i] <= 1)) {
            return "range: numbers in (0, 1]";
        }
    }
    return nn_polynomial_count(settings) > NN_POLYNOMIALS_MAX
               ? "polynomial.degree: of so many inputs more than 8192 polynomials; a smaller one"
               : NULL;
}

const char *nn_mlp_settings_check(const nn_mlp_settings *settings)
{
    if (settings->inputs < 1 || settings->inputs > NN_INPUTS_MAX) {
        return "inputs: 1 to 64";
    }
    if (settings->outputs < 1 || settings->outputs > NN_OUTPUTS_MAX) {
        return "outputs: 1 to 256";
    }
    if (settings->pieces < 1 || settings->pieces > NN_PIECES_MAX) {
        return "pieces: 1 to 64";
    }
    if (settings->hidden_count < 0 || settings->hidden_count > NN_HIDDEN_MAX) {
        return "hidden: at most 16 layers";
    }
    for (int i = 0; i < settings->hidden_count; i++) {
        if (settings->hidden[i] < 1 || settings->hidden[i] > NN_WIDTH_MAX) {
            return "hidden: widths 1 to 4096";
        }
    }
    if (settings->scalars < 0 || settings->scalars > NN_SCALARS_MAX) {
        return "scalars: 0 to 64";
    }
    if (settings->activation < NN_TANH || settings->activation > NN_GELU) {
        return "activation: tanh, sin, silu or gelu";
    }
    if (settings->initialization < NN_GLOROT || settings->initialization > NN_UNIFORM) {
        return "initialization: glorot or uniform";
    }
    if (settings->fourier_features < 0 || settings->fourier_features > NN_FOURIER_MAX) {
        return "fourier_features: 0 to 1024";
    }
    for (int i = 0; settings->fourier_features > 0 && i < settings->inputs; i++) {
        if (!(settings->fourier_bandwidth[i] > 0 && isfinite(settings->fourier_bandwidth[i]))) {
            return "fourier_bandwidth: positive numbers";
        }
    }
    return settings->degree ? check_polynomials(settings) : NULL;
}

static int input_rows(const nn_mlp_settings *settings)
{
    return settings->inputs + (settings->pieces > 1 ? 1 + 2 * settings->pieces : 0);
}

static void nn_mlp_add_view(nn_mlp *mlp, const char *layer, const char *part, int rows, int columns)
{
    nn_view *view = &mlp->views[mlp->view_count++];
    snprintf(view->name, sizeof view->name, "%s/%s", layer, part);
    view->offset = mlp->parameters;
    view->rows = rows;
    view->columns = columns;
    mlp->parameters += (size_t)rows * (size_t)columns;
}

/* The inputs, then sin, then cos of their projections, or the basis made of them; or polynomials.
 */
int nn_mlp_features(const nn_mlp *mlp)
{
    const nn_mlp_settings *settings = &mlp->settings;
    return settings->degree          ? (int)nn_polynomial_count(settings)
           : mlp->basis.coefficients ? mlp->basis.rows
                                     : settings->inputs + 2 * settings->fourier_features;
}

static ad_status nn_mlp_draw(nn_mlp *mlp, nn_rng *rng, ad_error *error)
{
    const nn_mlp_settings *settings = &mlp->settings;
    size_t count = (size_t)settings->fourier_features * (size_t)settings->inputs;
    if (count == 0) {
        return AD_OK;
    }
    mlp->fourier = malloc(count * sizeof *mlp->fourier);
    if (!mlp->fourier) {
        return ad_fail(error, AD_NO_MEMORY, "network: out of memory");
    }
    for (size_t i = 0; i < count; i++) {
        double bound = settings->fourier_bandwidth[i % (size_t)settings->inputs];
        mlp->fourier[i] = nn_rng_between(rng, -bound, bound);
    }
    if (settings->hidden_count > 0 || !settings->orthonormal) {
        return AD_OK;
    }
    ad_status status = nn_basis_create(settings, mlp->fourier, false, rng, &mlp->basis.coefficients,
                                       &mlp->basis.rows, error);
    if (status == AD_OK && settings->pieces > 1 && settings->inputs > 1) {
        status = nn_basis_create(settings, mlp->fourier, true, rng, &mlp->edges.coefficients,
                                 &mlp->edges.rows, error);
    }
    return status;
}

static void nn_mlp_add_views(nn_mlp *mlp)
{
    const nn_mlp_settings *settings = &mlp->settings;
    int columns = nn_mlp_features(mlp);
    for (int i = 0; i <= settings->hidden_count; i++) {
        char layer[24];
        int rows =
            i < settings->hidden_count ? settings->hidden[i] : settings->outputs * settings->pieces;
        snprintf(layer, sizeof layer, "layer%d", i);
        nn_mlp_add_view(mlp, layer, "weight", rows, columns);
        nn_mlp_add_view(mlp, layer, "bias", rows, 1);
        columns = i < settings->hidden_count ? rows : columns;
    }
    if (settings->pieces > 1) {
        int rows = settings->outputs * (settings->pieces + 1);
        if (settings->inputs > 1) {
            nn_mlp_add_view(mlp, "edges", "weight", rows,
                            mlp->edges.coefficients ? mlp->edges.rows : columns);
        }
        nn_mlp_add_view(mlp, "edges", "bias", rows, 1);
    }
    if (settings->scalars > 0) {
        nn_mlp_add_view(mlp, "scalars", "value", settings->scalars, 1);
    }
}

ad_status nn_mlp_create(const nn_mlp_settings *settings, nn_rng *rng, nn_mlp **mlp, ad_error *error)
{
    *mlp = NULL;
    const char *bad = nn_mlp_settings_check(settings);
    if (bad) {
        return ad_fail(error, AD_BAD_ARGUMENT, "network: %s", bad);
    }
    nn_mlp *made = calloc(1, sizeof *made);
    if (!made) {
        return ad_fail(error, AD_NO_MEMORY, "network: out of memory");
    }
    made->settings = *settings;
    ad_status status = nn_mlp_draw(made, rng, error);
    if (status != AD_OK) {
        nn_mlp_free(made);
        return status;
    }
    nn_mlp_add_views(made);
    *mlp = made;
    return AD_OK;
}

void nn_mlp_free(nn_mlp *mlp)
{
    if (!mlp) {
        return;
    }
    free(mlp->fourier);
    free(mlp->basis.coefficients);
    free(mlp->edges.coefficients);
    free(mlp);
}

size_t nn_mlp_parameters(const nn_mlp *mlp)
{
    return mlp->parameters;
}

int nn_mlp_views(const nn_mlp *mlp, const nn_view **views)
{
    *views = mlp->views;
    return mlp->view_count;
}

double *nn_mlp_fourier(nn_mlp *mlp, size_t *count)
{
    if (count) {
        *count = (size_t)mlp->settings.fourier_features * (size_t)mlp->settings.inputs;
    }
    return mlp->fourier;
}

double *nn_mlp_basis(nn_mlp *mlp, int *rows, int *columns)
{
    *rows = mlp->basis.rows;
    *columns = nn_basis_functions(&mlp->settings);
    return mlp->basis.coefficients;
}

double *nn_mlp_edge_basis(nn_mlp *mlp, int *rows, int *columns)
{
    *rows = mlp->edges.rows;
    *columns = nn_basis_functions(&mlp->settings);
    return mlp->edges.coefficients;
}

/* Views without the scalars. */
static int layer_views(const nn_mlp *mlp)
{
    return mlp->view_count - (mlp->settings.scalars > 0);
}

/* Scalars 0. Weights by the rule of the settings; biases 0 (Glorot) or uniform. The first layer of
 * a sine network is the exception, see NN_SINE_FREQUENCY: there biases are random phases, else
 * every unit would be odd. A linear network has no symmetry to break and begins at 0: its
 * Gauss-Newton steps then start from a field without waves. */
void nn_mlp_initialize(const nn_mlp *mlp, nn_rng *rng, double *parameters)
{
    const int layers = layer_views(mlp);
    memset(parameters, 0, mlp->parameters * sizeof *parameters);
    if (mlp->settings.hidden_count == 0) {
        return;
    }
    for (int i = 0; i + 1 < layers; i += 2) {
        const nn_view *weight = &mlp->views[i], *bias = &mlp->views[i + 1];
        size_t count = (size_t)weight->rows * (size_t)weight->columns;
        double *w = parameters + weight->offset, *b = parameters + bias->offset;
        bool sine = i == 0 && mlp->settings.activation == NN_SIN;
        bool normal = mlp->settings.initialization == NN_GLOROT && !sine;
        double bound = sine ? NN_SINE_FREQUENCY / weight->columns : 1 / sqrt(weight->columns);
        double deviation = sqrt(2.0 / (weight->rows + weight->columns));
        double phase = sine ? NN_PI : bound;
        for (size_t k = 0; k < count; k++) {
            w[k] = normal ? deviation * nn_rng_normal(rng) : nn_rng_between(rng, -bound, bound);
        }
        for (int k = 0; k < bias->rows; k++) {
            b[k] = normal ? 0 : nn_rng_between(rng, -phase, phase);
        }
    }
}

static ad_value nn_activate(nn_activation activation, ad_value x)
{
    switch (activation) {
    case NN_SIN:
        return ad_sin(x);
    case NN_SILU:
        return ad_silu(x);
    case NN_GELU:
        return ad_gelu(x);
    case NN_TANH:
        break;
    }
    return ad_tanh(x);
}

/* 1 above x above sin(F x) above cos(F x), F the fixed frequencies (Tancik et al. 2020); without
 * the 1 where there is no basis made of these, and x alone where there are no frequencies. */
static ad_value nn_mlp_waves(const nn_mlp *mlp, ad_value x)
{
    if (!mlp->fourier) {
        return x;
    }
    int rows = mlp->settings.fourier_features * mlp->settings.inputs;
    ad_value frequencies = ad_constant(x.tape, rows, mlp->fourier);
    ad_value phase = ad_matvec(frequencies, x);
    ad_value functions[4] = {ad_scalar(x.tape, 1), x, ad_sin(phase), ad_cos(phase)};
    return mlp->basis.coefficients ? ad_stack(4, functions) : ad_stack(3, functions + 1);
}

/* What enters the first layer, by a basis if there is one. */
static ad_value nn_mlp_feature_rows(const nn_mlp *mlp, const nn_basis *basis, ad_value x)
{
    if (mlp->settings.degree) {
        return nn_polynomial_record(&mlp->settings, x);
    }
    ad_value waves = nn_mlp_waves(mlp, x);
    int numbers = basis->rows * nn_basis_functions(&mlp->settings);
    return basis->coefficients ? ad_matvec(ad_constant(x.tape, numbers, basis->coefficients), waves)
                               : waves;
}

static ad_value nn_view_record(const nn_view *view, ad_tape *tape, size_t offset)
{
    return ad_parameter(tape, view->name, view->rows * view->columns, offset + view->offset);
}

/* What enters the trained layer without activation. */
static ad_value nn_mlp_record_hidden(const nn_mlp *mlp, const nn_basis *basis, ad_value x,
                                     size_t offset)
{
    x = nn_mlp_feature_rows(mlp, basis, x);
    for (int i = 0; i < mlp->settings.hidden_count; i++) {
        ad_value w = nn_view_record(&mlp->views[2 * i], x.tape, offset);
        ad_value b = nn_view_record(&mlp->views[2 * i + 1], x.tape, offset);
        x = nn_activate(mlp->settings.activation, ad_add(ad_matvec(w, x), b));
    }
    return x;
}

/* The input where the first one does not vary. */
static ad_value nn_mlp_edge_input(const nn_mlp *mlp, ad_value x)
{
    ad_value others = ad_slice(x, 1, mlp->settings.inputs - 1);
    return ad_stack(2, (ad_value[]){ad_scalar(x.tape, 0), others});
}

/* What is said at the edges of pieces, [outputs * (pieces + 1)]. */
static ad_value nn_mlp_record_edges(const nn_mlp *mlp, ad_value x, size_t offset)
{
    ad_value b = nn_view_record(&mlp->views[layer_views(mlp) - 1], x.tape, offset);
    if (mlp->settings.inputs == 1) {
        return b;
    }
    ad_value w = nn_view_record(&mlp->views[layer_views(mlp) - 2], x.tape, offset);
    x = nn_mlp_record_hidden(mlp, &mlp->edges, nn_mlp_edge_input(mlp, x), offset);
    return ad_add(ad_matvec(w, x), b);
}

/* The pieces [outputs * pieces] put together where the input is. */
static ad_value nn_mlp_join(const nn_mlp *mlp, ad_value input, ad_value inside, ad_value edges)
{
    int pieces = mlp->settings.pieces, outputs = mlp->settings.outputs;
    int first = mlp->settings.inputs;
    ad_value sum = ad_slice(edges, 0, outputs), within = ad_zeros(input.tape, outputs);
    for (int k = 0; k < pieces; k++) {
        ad_value mask = ad_row(input, first + 1 + k), ramp = ad_row(input, first + 1 + pieces + k);
        within = ad_add(within, ad_mul(mask, ad_slice(inside, k * outputs, outputs)));
        sum = ad_add(sum, ad_mul(ramp, ad_slice(edges, (k + 1) * outputs, outputs)));
    }
    return ad_add(sum, ad_mul(ad_row(input, first), within));
}

static void nn_mlp_check_input(const nn_mlp *mlp, ad_value input)
{
    int rows = input_rows(&mlp->settings);
    if (ad_is_valid(input) && ad_rows(input) != rows) {
        ad_tape_fail(input.tape, AD_BAD_SHAPE, "network: the input has %d rows, %d are expected",
                     ad_rows(input), rows);
    }
}

ad_value nn_mlp_record(const nn_mlp *mlp, ad_value input, size_t offset)
{
    nn_mlp_check_input(mlp, input);
    int last = 2 * mlp->settings.hidden_count;
    bool joined = mlp->settings.pieces > 1;
    ad_value x = joined ? ad_slice(input, 0, mlp->settings.inputs) : input;
    ad_value hidden = nn_mlp_record_hidden(mlp, &mlp->basis, x, offset);
    ad_value w = nn_view_record(&mlp->views[last], input.tape, offset);
    ad_value b = nn_view_record(&mlp->views[last + 1], input.tape, offset);
    ad_value y = ad_add(ad_matvec(w, hidden), b);
    return joined ? nn_mlp_join(mlp, input, y, nn_mlp_record_edges(mlp, x, offset)) : y;
}

ad_value nn_mlp_record_single(const nn_mlp *mlp, ad_value input, ad_value wrt[2])
{
    const int features = nn_mlp_features(mlp);
    wrt[0] = ad_parameter(input.tape, "weight", features, 0);
    wrt[1] = ad_parameter(input.tape, "bias", 1, (size_t)features);
    return ad_add(ad_matvec(wrt[0], nn_mlp_feature_rows(mlp, &mlp->basis, input)), wrt[1]);
}

/* ---- combined ------------------------------------------------------------------------------- */

/* Of a layer of so many rows: [rows][functions] and the biases. */
static size_t nn_combined_numbers(const nn_mlp *mlp, int rows)
{
    return (size_t)rows * ((size_t)nn_basis_functions(&mlp->settings) + 1);
}

size_t nn_mlp_combined_parameters(const nn_mlp *mlp)
{
    int outputs = mlp->settings.outputs, pieces = mlp->settings.pieces;
    if (!mlp->basis.coefficients) {
        return mlp->parameters;
    }
    int edges = pieces > 1 ? outputs * (pieces + 1) : 0;
    return nn_combined_numbers(mlp, outputs * pieces) + (size_t)mlp->settings.scalars +
           (mlp->edges.coefficients ? nn_combined_numbers(mlp, edges) : (size_t)edges);
}

/* The layer that begins with view `weight`; returns where the next one goes. */
static double *nn_combine_layer(const nn_mlp *mlp, const nn_basis *basis, int weight,
                                const double *parameters, double *combined)
{
    const nn_view *view = &mlp->views[weight];
    int rows = view->rows, functions = nn_basis_functions(&mlp->settings);
    const double *weights = parameters + view->offset;
    memset(combined, 0, (size_t)rows * (size_t)functions * sizeof *combined);
    for (int i = 0; i < rows; i++) {
        double *row = combined + (size_t)i * (size_t)functions;
        for (int k = 0; k < basis->rows; k++) {
            double factor = weights[(size_t)i * (size_t)basis->rows + (size_t)k];
            const double *coefficients = basis->coefficients + (size_t)k * (size_t)functions;
            for (int j = 0; j < functions; j++) {
                row[j] += factor * coefficients[j];
            }
        }
    }
    combined += (size_t)rows * (size_t)functions;
    memcpy(combined, parameters + view[1].offset, (size_t)rows * sizeof *combined);
    return combined + rows;
}

void nn_mlp_combine(const nn_mlp *mlp, const double *parameters, double *combined)
{
    if (!mlp->basis.coefficients) {
        memcpy(combined, parameters, mlp->parameters * sizeof *combined);
        return;
    }
    const size_t scalars = (size_t)mlp->settings.scalars;
    memcpy(combined + nn_mlp_combined_parameters(mlp) - scalars,
           parameters + mlp->parameters - scalars, scalars * sizeof *combined);
    combined = nn_combine_layer(mlp, &mlp->basis, 0, parameters, combined);
    if (mlp->edges.coefficients) {
        nn_combine_layer(mlp, &mlp->edges, 2, parameters, combined);
    } else if (mlp->settings.pieces > 1) {
        const nn_view *bias = &mlp->views[2];
        memcpy(combined, parameters + bias->offset, (size_t)bias->rows * sizeof *combined);
    }
}

/* A layer of `rows` from `offset` on. */
static ad_value nn_record_combined(const nn_mlp *mlp, ad_value x, int rows, size_t offset)
{
    int numbers = rows * nn_basis_functions(&mlp->settings);
    ad_value w = ad_parameter(x.tape, "combined/weight", numbers, offset);
    ad_value b = ad_parameter(x.tape, "combined/bias", rows, offset + (size_t)numbers);
    return ad_add(ad_matvec(w, nn_mlp_waves(mlp, x)), b);
}

ad_value nn_mlp_record_combined(const nn_mlp *mlp, ad_value input, size_t offset)
{
    int outputs = mlp->settings.outputs, pieces = mlp->settings.pieces;
    int rows = outputs * (pieces + 1);
    if (!mlp->basis.coefficients) {
        return nn_mlp_record(mlp, input, offset);
    }
    nn_mlp_check_input(mlp, input);
    ad_value x = pieces > 1 ? ad_slice(input, 0, mlp->settings.inputs) : input;
    ad_value y = nn_record_combined(mlp, x, outputs * pieces, offset);
    if (pieces == 1) {
        return y;
    }
    offset += nn_combined_numbers(mlp, outputs * pieces);
    ad_value edges = mlp->edges.coefficients
                         ? nn_record_combined(mlp, nn_mlp_edge_input(mlp, x), rows, offset)
                         : ad_parameter(x.tape, "combined/edges", rows, offset);
    return nn_mlp_join(mlp, input, y, edges);
}

ad_value nn_mlp_record_scalars(const nn_mlp *mlp, ad_tape *tape, bool combined, size_t offset)
{
    const size_t end = combined ? nn_mlp_combined_parameters(mlp) : mlp->parameters;
    return ad_parameter(tape, "scalars", mlp->settings.scalars,
                        offset + end - (size_t)mlp->settings.scalars);
}
