/* Networks on the tape against the same network as plain loops. */
#include "evaluate.h"

#include "nn/nn.h"

#define PI 3.14159265358979323846

enum { POINTS = 7, WIDEST = 64, OFFSET = 3 };

static double activate(nn_activation activation, double x)
{
    switch (activation) {
    case NN_SIN:
        return sin(x);
    case NN_SILU:
        return x / (1 + exp(-x));
    case NN_GELU:
        return 0.5 * x * (1 + erf(x / sqrt(2.0)));
    default:
        return tanh(x);
    }
}

/* y [outputs] of x [inputs]; x is destroyed. */
static void forward(const nn_mlp_settings *settings, nn_mlp *mlp, const double *parameters,
                    double *x, double *y)
{
    const nn_view *views;
    int count = nn_mlp_views(mlp, &views), features = settings->fourier_features;
    const double *frequencies = nn_mlp_fourier(mlp, NULL);
    for (int i = 0; i < features; i++) {
        double phase = 0;
        for (int k = 0; k < settings->inputs; k++)
            phase += frequencies[i * settings->inputs + k] * x[k];
        x[settings->inputs + i] = sin(phase);
        x[settings->inputs + features + i] = cos(phase);
    }
    for (int layer = 0; layer < count; layer += 2) {
        const nn_view *weight = &views[layer];
        for (int row = 0; row < weight->rows; row++) {
            double sum = parameters[views[layer + 1].offset + (size_t)row];
            for (int k = 0; k < weight->columns; k++)
                sum += parameters[weight->offset + (size_t)(row * weight->columns + k)] * x[k];
            y[row] = layer + 2 < count ? activate(settings->activation, sum) : sum;
        }
        memcpy(x, y, (size_t)weight->rows * sizeof *x);
    }
}

static nn_mlp_settings small(nn_activation activation, int features)
{
    nn_mlp_settings settings = nn_mlp_settings_default();
    settings.inputs = 2;
    settings.outputs = 3;
    settings.hidden_count = 2;
    settings.hidden[0] = 11;
    settings.hidden[1] = 6;
    settings.activation = activation;
    settings.initialization = NN_UNIFORM; /* biases are not 0 */
    settings.fourier_features = features;
    return settings;
}

static nn_mlp *create(const nn_mlp_settings *settings, uint64_t seed)
{
    nn_mlp *mlp = NULL;
    ad_error error = {.message = ""};
    nn_rng rng = nn_rng_seed(seed);
    if (nn_mlp_create(settings, &rng, &mlp, &error) != AD_OK)
        fail_msg("%s", error.message);
    return mlp;
}

static void check_forward(nn_activation activation, int features)
{
    nn_mlp_settings settings = small(activation, features);
    nn_mlp *mlp = create(&settings, 5);
    size_t count = nn_mlp_parameters(mlp);
    double *parameters = calloc(OFFSET + count, sizeof *parameters);
    nn_rng rng = nn_rng_seed(7);
    nn_mlp_initialize(mlp, &rng, parameters + OFFSET);
    double input[2 * POINTS];
    for (int i = 0; i < 2 * POINTS; i++)
        input[i] = nn_rng_between(&rng, -1, 1);
    ad_tape *tape = ad_tape_create();
    ad_value output = nn_mlp_record(mlp, ad_input(tape, "x", 2), OFFSET);
    assert_int_equal(ad_rows(output), 3);
    double *result = evaluate_at(output, POINTS, input, NULL, parameters);
    for (int point = 0; point < POINTS; point++) {
        double x[WIDEST] = {input[point], input[POINTS + point]}, y[WIDEST];
        forward(&settings, mlp, parameters + OFFSET, x, y);
        for (int row = 0; row < 3; row++) /* sums of at most 11 + 8 terms of order 1 */
            assert_near(result[row * POINTS + point], y[row], 1e-14);
    }
    free(result);
    free(parameters);
    ad_tape_free(tape);
    nn_mlp_free(mlp);
}

static void test_forward(void **state)
{
    (void)state;
    for (int activation = NN_TANH; activation <= NN_GELU; activation++) {
        check_forward((nn_activation)activation, 0);
        check_forward((nn_activation)activation, 4);
    }
}

static void test_views(void **state)
{
    (void)state;
    nn_mlp_settings settings = small(NN_TANH, 4);
    nn_mlp *mlp = create(&settings, 1);
    const nn_view *views;
    assert_int_equal(nn_mlp_views(mlp, &views), 6);
    assert_string_equal(views[0].name, "layer0/weight");
    assert_string_equal(views[5].name, "layer2/bias");
    assert_int_equal(views[0].columns, 2 + 2 * 4);
    size_t next = 0;
    for (int i = 0; i < 6; i++) {
        assert_int_equal(views[i].offset, next);
        next += (size_t)(views[i].rows * views[i].columns);
    }
    assert_int_equal(next, nn_mlp_parameters(mlp));
    size_t count = 0;
    assert_non_null(nn_mlp_fourier(mlp, &count));
    assert_int_equal(count, 8);
    nn_mlp_free(mlp);
    nn_mlp_free(NULL);
}

/* What weights of 1 make of one function of the basis at Chebyshev's points, [points][points]. */
static double *basis_function(const nn_mlp *mlp, int columns, int which, int points)
{
    size_t count = (size_t)points * (size_t)points;
    double *x = malloc(2 * count * sizeof *x), *w = calloc((size_t)columns + 1, sizeof *w);
    assert_true(x && w);
    for (int p = 0; p < points * points; p++) {
        x[p] = cos(PI * (p % points + 0.5) / points);
        x[(size_t)p + count] = cos(PI * (p / points + 0.5) / points);
    }
    w[which] = 1; /* columns: the bias, the function 1 */
    ad_tape *tape = ad_tape_create();
    double *result = evaluate_at(nn_mlp_record(mlp, ad_input(tape, "x", 2), 0), count, x, NULL, w);
    ad_tape_free(tape);
    free(x);
    free(w);
    return result;
}

/* The trained layer of a linear network sees nearly orthonormal functions, fewer than there are
 * waves when those nearly depend on one another: here 81 functions of at most one radian, of which
 * polynomials of degree d span what is larger than 1/d!. */
static void test_basis(void **state)
{
    (void)state;
    enum { SIDE = 24 };
    nn_mlp_settings settings = small(NN_TANH, 40);
    settings.hidden_count = 0;
    settings.outputs = 1;
    settings.fourier_bandwidth[0] = settings.fourier_bandwidth[1] = 1;
    nn_mlp *mlp = create(&settings, 3);
    int rows, columns;
    assert_non_null(nn_mlp_basis(mlp, &rows, &columns));
    assert_int_equal(columns, 1 + 2 + 2 * 40);
    assert_true(rows > 40 && rows < 80);
    assert_int_equal(nn_mlp_parameters(mlp), rows + 1);
    const int chosen[] = {0, 1, rows / 2, rows - 1, rows};
    double *values[5];
    for (int i = 0; i < 5; i++)
        values[i] = basis_function(mlp, rows, chosen[i], SIDE);
    for (int i = 0; i < 5; i++) {
        for (int j = 0; j <= i; j++) { /* 4 random points for each function weigh roughly so */
            double product = 0;
            for (int p = 0; p < SIDE * SIDE; p++)
                product += values[i][p] * values[j][p] / (SIDE * SIDE);
            assert_near(product, i == j, 1);
        }
    }
    for (int i = 0; i < 5; i++)
        free(values[i]);
    nn_mlp_free(mlp);
    settings.hidden_count = 1;
    mlp = create(&settings, 3);
    assert_null(nn_mlp_basis(mlp, &rows, &columns));
    nn_mlp_free(mlp);
}

/* Polynomials in three inputs, the third of which counts twofold: orthonormal by Gauss' rule of six
 * points, which is exact for their products, and so many that monomials of the degree are theirs.
 */
static void test_polynomials(void **state)
{
    (void)state;
    enum { SIDE = 6, POINTS3 = SIDE * SIDE * SIDE, DEGREE = 4, MOST = 40 };
    static const double nodes[SIDE / 2] = {0.2386191860831969, 0.6612093864662645,
                                           0.9324695142031521};
    static const double weights[SIDE / 2] = {0.4679139345726910, 0.3607615730481386,
                                             0.1713244923791704};
    nn_mlp_settings settings = small(NN_TANH, 0);
    settings.hidden_count = 0;
    settings.inputs = 3;
    settings.outputs = 1;
    settings.degree = DEGREE;
    settings.range[2] = 0.25;
    nn_mlp *mlp = create(&settings, 1);
    const int count = nn_mlp_features(mlp);
    int expected = -1; /* but for the constant */
    for (int i = 0; i < 125; i++) {
        expected += i / 25 + i / 5 % 5 + 2 * (i % 5) <= DEGREE;
    }
    assert_int_equal(count, expected);
    assert_int_equal(nn_mlp_parameters(mlp), count + 1);
    double x[3 * POINTS3], w[POINTS3], *values[MOST], parameters[MOST + 1];
    for (int p = 0; p < POINTS3; p++) {
        w[p] = 1;
        for (int i = 0, at = p; i < 3; i++, at /= SIDE) {
            const int k = at % SIDE, n = k / 2;
            x[i * POINTS3 + p] = (k % 2 ? 1 : -1) * nodes[n] * settings.range[i];
            w[p] *= weights[n] / 2;
        }
    }
    ad_tape *tape = ad_tape_create();
    ad_value y = nn_mlp_record(mlp, ad_input(tape, "x", 3), 0);
    for (int k = 0; k <= count; k++) { /* the bias is the constant */
        memset(parameters, 0, sizeof parameters);
        parameters[k] = 1;
        values[k] = evaluate_at(y, POINTS3, x, NULL, parameters);
    }
    for (int i = 0; i <= count; i++) {
        for (int j = 0; j <= i; j++) {
            double product = 0;
            for (int p = 0; p < POINTS3; p++) {
                product += w[p] * values[i][p] * values[j][p];
            }
            assert_near(product, i == j, 1e-13);
        }
    }
    for (int i = 0; i < 125; i++) { /* what their expansion leaves of a monomial */
        const int power[3] = {i / 25, i / 5 % 5, i % 5};
        double all = 0, monomial[POINTS3];
        for (int p = 0; p < POINTS3; p++) {
            monomial[p] = 1;
            for (int k = 0; k < 3; k++) {
                monomial[p] *= pow(x[k * POINTS3 + p] / settings.range[k], power[k]);
            }
            all += w[p] * monomial[p] * monomial[p];
        }
        double square = all;
        for (int k = 0; k <= count; k++) {
            double part = 0;
            for (int p = 0; p < POINTS3; p++) {
                part += w[p] * monomial[p] * values[k][p];
            }
            square -= part * part;
        }
        const bool has = power[0] + power[1] + 2 * power[2] <= DEGREE;
        assert_true(has ? fabs(square) < 1e-14 : square > 1e-4 * all);
    }
    for (int k = 0; k <= count; k++) {
        free(values[k]);
    }
    ad_tape_free(tape);
    nn_mlp_free(mlp);
}

static double mean_square(const double *x, size_t count)
{
    double sum = 0;
    for (size_t i = 0; i < count; i++)
        sum += x[i] * x[i];
    return sum / (double)count;
}

/* Variances of many weights: relative deviation about sqrt(2/4096), allowed four of these. */
static void test_initialization(void **state)
{
    (void)state;
    const double tolerance = 0.09;
    for (int kind = 0; kind < 3; kind++) {
        nn_mlp_settings settings = nn_mlp_settings_default();
        settings.inputs = settings.outputs = settings.hidden[0] = settings.hidden[1] = 64;
        settings.hidden_count = 2;
        settings.initialization = kind == 1 ? NN_UNIFORM : NN_GLOROT;
        settings.activation = kind == 2 ? NN_SIN : NN_TANH;
        nn_mlp *mlp = create(&settings, 1);
        double *parameters = malloc(nn_mlp_parameters(mlp) * sizeof *parameters);
        nn_rng rng = nn_rng_seed(11);
        nn_mlp_initialize(mlp, &rng, parameters);
        const nn_view *views;
        nn_mlp_views(mlp, &views);
        double expected = kind == 1 ? 1.0 / 64 / 3 : 2.0 / 128;
        double first = kind == 2 ? 9.0 / (64.0 * 64) / 3 : expected;
        assert_near(mean_square(parameters, 4096) / first, 1, tolerance);
        assert_near(mean_square(parameters + views[2].offset, 4096) / expected, 1, tolerance);
        bool zero_bias = mean_square(parameters + views[3].offset, 64) == 0;
        assert_int_equal(zero_bias, kind != 1);
        free(parameters);
        nn_mlp_free(mlp);
    }
}

static void test_refusals(void **state)
{
    (void)state;
    nn_mlp_settings bad[6];
    for (int i = 0; i < 6; i++)
        bad[i] = nn_mlp_settings_default();
    bad[0].inputs = 0;
    bad[1].outputs = -1;
    bad[2].hidden_count = NN_HIDDEN_MAX + 1;
    bad[3].hidden[1] = 0;
    bad[4].fourier_features = -1;
    bad[5].fourier_features = 2;
    bad[5].fourier_bandwidth[0] = NAN;
    const char *fields[6] = {"inputs", "outputs",          "hidden",
                             "hidden", "fourier_features", "fourier_bandwidth"};
    nn_mlp_settings fine = nn_mlp_settings_default();
    assert_null(nn_mlp_settings_check(&fine));
    for (int i = 0; i < 6; i++) {
        nn_mlp *mlp = NULL;
        nn_rng rng = nn_rng_seed(1);
        ad_error error;
        assert_int_equal(nn_mlp_create(&bad[i], &rng, &mlp, &error), AD_BAD_ARGUMENT);
        assert_null(mlp);
        assert_non_null(strstr(error.message, fields[i]));
    }
    nn_mlp *mlp = create(&fine, 1);
    ad_tape *tape = ad_tape_create();
    nn_mlp_record(mlp, ad_input(tape, "x", 2), 0);
    assert_int_equal(ad_tape_status(tape, NULL), AD_BAD_SHAPE);
    ad_tape_free(tape);
    nn_mlp_free(mlp);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_forward),        cmocka_unit_test(test_views),
        cmocka_unit_test(test_initialization), cmocka_unit_test(test_refusals),
        cmocka_unit_test(test_basis),          cmocka_unit_test(test_polynomials),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
