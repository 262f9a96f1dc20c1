/* Dense networks: hidden layers activation(W x + b), a linear last layer. */
#include "nn/basis.h"

#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

static const double NN_PI = 3.14159265358979323846;

/* First layer of sine networks: weights uniform within NN_SINE_FREQUENCY / inputs, the rule of
 * SIREN (Sitzmann et al. 2020, section 3.2) with 3 in place of its 30: inputs lie in [-1, 1] and
 * the residuals differentiate twice, which amplifies a needless frequency by its square. */
static const double NN_SINE_FREQUENCY = 3.0;

enum { NN_WIDTH_MAX = 4096, NN_OUTPUTS_MAX = 256, NN_FOURIER_MAX = 1024 };

struct nn_mlp {
    nn_mlp_settings settings;
    int view_count; /* weight and bias of each layer */
    nn_view views[2 * (NN_HIDDEN_MAX + 1)];
    size_t parameters;
    double *fourier; /* [fourier_features][inputs], NULL when there are none */
    int basis_rows;
    double *basis; /* [basis_rows][functions], of a linear network with features; else NULL */
};

nn_mlp_settings nn_mlp_settings_default(void)
{
    nn_mlp_settings settings = {.inputs = 1,
                                .outputs = 1,
                                .hidden_count = 3,
                                .hidden = {32, 32, 32},
                                .activation = NN_TANH,
                                .initialization = NN_GLOROT,
                                .orthonormal = true,
                                .fourier_features = 0};
    for (int i = 0; i < NN_INPUTS_MAX; i++) {
        settings.fourier_bandwidth[i] = 2 * NN_PI;
    }
    return settings;
}

const char *nn_mlp_settings_check(const nn_mlp_settings *settings)
{
    if (settings->inputs < 1 || settings->inputs > NN_INPUTS_MAX) {
        return "inputs: 1 to 64";
    }
    if (settings->outputs < 1 || settings->outputs > NN_OUTPUTS_MAX) {
        return "outputs: 1 to 256";
    }
    if (settings->hidden_count < 0 || settings->hidden_count > NN_HIDDEN_MAX) {
        return "hidden: at most 16 layers";
    }
    for (int i = 0; i < settings->hidden_count; i++) {
        if (settings->hidden[i] < 1 || settings->hidden[i] > NN_WIDTH_MAX) {
            return "hidden: widths 1 to 4096";
        }
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
    return NULL;
}

static void nn_mlp_add_view(nn_mlp *mlp, int layer, const char *part, int rows, int columns)
{
    nn_view *view = &mlp->views[mlp->view_count++];
    snprintf(view->name, sizeof view->name, "layer%d/%s", layer, part);
    view->offset = mlp->parameters;
    view->rows = rows;
    view->columns = columns;
    mlp->parameters += (size_t)rows * (size_t)columns;
}

/* Rows that enter the first layer: the inputs, then sin, then cos of their projections; or the
 * basis made of them. */
static int nn_mlp_features(const nn_mlp *mlp)
{
    const nn_mlp_settings *settings = &mlp->settings;
    return mlp->basis ? mlp->basis_rows : settings->inputs + 2 * settings->fourier_features;
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
    return settings->hidden_count > 0 || !settings->orthonormal
               ? AD_OK
               : nn_basis_create(settings, mlp->fourier, rng, &mlp->basis, &mlp->basis_rows, error);
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
    int columns = nn_mlp_features(made);
    for (int i = 0; i <= settings->hidden_count; i++) {
        int rows = i < settings->hidden_count ? settings->hidden[i] : settings->outputs;
        nn_mlp_add_view(made, i, "weight", rows, columns);
        nn_mlp_add_view(made, i, "bias", rows, 1);
        columns = rows;
    }
    *mlp = made;
    return AD_OK;
}

void nn_mlp_free(nn_mlp *mlp)
{
    if (!mlp) {
        return;
    }
    free(mlp->fourier);
    free(mlp->basis);
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
    *rows = mlp->basis_rows;
    *columns = nn_basis_functions(&mlp->settings);
    return mlp->basis;
}

/* Weights by the rule of the settings; biases 0 (Glorot) or uniform. The first layer of a sine
 * network is the exception, see NN_SINE_FREQUENCY: there biases are random phases, else every
 * unit would be odd. A linear network has no symmetry to break and begins at 0: its Gauss-Newton
 * steps then start from a field without waves. */
void nn_mlp_initialize(const nn_mlp *mlp, nn_rng *rng, double *parameters)
{
    if (mlp->settings.hidden_count == 0) {
        memset(parameters, 0, mlp->parameters * sizeof *parameters);
        return;
    }
    for (int i = 0; i < mlp->view_count; i += 2) {
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
    return mlp->basis ? ad_stack(4, functions) : ad_stack(3, functions + 1);
}

static ad_value nn_mlp_fourier_rows(const nn_mlp *mlp, ad_value x)
{
    ad_value waves = nn_mlp_waves(mlp, x);
    int numbers = mlp->basis_rows * nn_basis_functions(&mlp->settings);
    return mlp->basis ? ad_matvec(ad_constant(x.tape, numbers, mlp->basis), waves) : waves;
}

ad_value nn_mlp_record(const nn_mlp *mlp, ad_value input, size_t offset)
{
    if (ad_is_valid(input) && ad_rows(input) != mlp->settings.inputs) {
        ad_tape_fail(input.tape, AD_BAD_SHAPE, "network: the input has %d rows, %d are expected",
                     ad_rows(input), mlp->settings.inputs);
    }
    ad_value x = nn_mlp_fourier_rows(mlp, input);
    for (int i = 0; i < mlp->view_count; i += 2) {
        const nn_view *weight = &mlp->views[i], *bias = &mlp->views[i + 1];
        ad_value w = ad_parameter(input.tape, weight->name, weight->rows * weight->columns,
                                  offset + weight->offset);
        ad_value b = ad_parameter(input.tape, bias->name, bias->rows, offset + bias->offset);
        x = ad_add(ad_matvec(w, x), b);
        if (i + 2 < mlp->view_count) {
            x = nn_activate(mlp->settings.activation, x);
        }
    }
    return x;
}

/* ---- combined ------------------------------------------------------------------------------- */

size_t nn_mlp_combined_parameters(const nn_mlp *mlp)
{
    size_t functions = (size_t)nn_basis_functions(&mlp->settings) + 1;
    return mlp->basis ? (size_t)mlp->settings.outputs * functions : mlp->parameters;
}

void nn_mlp_combine(const nn_mlp *mlp, const double *parameters, double *combined)
{
    if (!mlp->basis) {
        memcpy(combined, parameters, mlp->parameters * sizeof *combined);
        return;
    }
    int outputs = mlp->settings.outputs, functions = nn_basis_functions(&mlp->settings);
    const double *weights = parameters + mlp->views[0].offset;
    memset(combined, 0, (size_t)outputs * (size_t)functions * sizeof *combined);
    for (int i = 0; i < outputs; i++) {
        double *row = combined + (size_t)i * (size_t)functions;
        for (int k = 0; k < mlp->basis_rows; k++) {
            double weight = weights[(size_t)i * (size_t)mlp->basis_rows + (size_t)k];
            const double *coefficients = mlp->basis + (size_t)k * (size_t)functions;
            for (int j = 0; j < functions; j++) {
                row[j] += weight * coefficients[j];
            }
        }
    }
    memcpy(combined + (size_t)outputs * (size_t)functions, parameters + mlp->views[1].offset,
           (size_t)outputs * sizeof *combined);
}

ad_value nn_mlp_record_combined(const nn_mlp *mlp, ad_value input, size_t offset)
{
    if (!mlp->basis) {
        return nn_mlp_record(mlp, input, offset);
    }
    int outputs = mlp->settings.outputs;
    int numbers = outputs * nn_basis_functions(&mlp->settings);
    ad_value w = ad_parameter(input.tape, "combined/weight", numbers, offset);
    ad_value b = ad_parameter(input.tape, "combined/bias", outputs, offset + (size_t)numbers);
    return ad_add(ad_matvec(w, nn_mlp_waves(mlp, input)), b);
}
