/* Input by input: products so far are kept by their weighted degree, so that what another power of
 * the next input may be multiplied with is whole blocks of rows. */
#include "nn/polynomial.h"

#include <math.h>

/* An input counts with a higher degree where it varies less: a range of a quarter for two, of a
 * sixteenth for three. What a smooth function has of it falls so much faster. */
static int weight_of(double range)
{
    return range < 1 ? (int)lround(1 - log2(range) / 2) : 1;
}

double nn_polynomial_count(const nn_mlp_settings *settings)
{
    double count[NN_DEGREE_MAX + 1] = {1}, sum = 0;
    for (int i = 0; i < settings->inputs; i++) {
        const int weight = weight_of(settings->range[i]);
        for (int d = settings->degree; d >= 0; d--) {
            for (int k = 1; k * weight <= d; k++) {
                count[d] += count[d - k * weight];
            }
        }
    }
    for (int d = 1; d <= settings->degree; d++) {
        sum += count[d];
    }
    return sum;
}

int nn_polynomial_degree(nn_mlp_settings settings, double most)
{
    settings.degree = NN_DEGREE_MAX;
    while (settings.degree > 1 && nn_polynomial_count(&settings) > most) {
        settings.degree--;
    }
    return settings.degree;
}

/* P [0 .. most], of mean square 1 over -1 .. 1. */
static void record_legendre(ad_value z, int most, ad_value *P)
{
    P[0] = ad_scalar(z.tape, 1);
    P[1] = z;
    for (int k = 1; k < most; k++) {
        P[k + 1] = ad_sub(ad_scale(ad_mul(z, P[k]), (2.0 * k + 1) / (k + 1)),
                          ad_scale(P[k - 1], (double)k / (k + 1)));
    }
    for (int k = 1; k <= most; k++) {
        P[k] = ad_scale(P[k], sqrt(2.0 * k + 1));
    }
}

ad_value nn_polynomial_record(const nn_mlp_settings *settings, ad_value x)
{
    const int degree = settings->degree;
    ad_value block[NN_DEGREE_MAX + 1] = {ad_scalar(x.tape, 1)}, P[NN_DEGREE_MAX + 2];
    bool any[NN_DEGREE_MAX + 1] = {true};
    for (int i = 0; i < settings->inputs; i++) {
        const int weight = weight_of(settings->range[i]);
        record_legendre(ad_scale(ad_row(x, i), 1 / settings->range[i]), degree / weight, P);
        for (int d = degree; d >= 0; d--) {
            ad_value parts[NN_DEGREE_MAX + 1];
            int count = 0;
            for (int k = 0; k * weight <= d; k++) {
                if (any[d - k * weight]) {
                    parts[count++] = ad_mul(P[k], block[d - k * weight]);
                }
            }
            any[d] = count > 0;
            block[d] = count > 0 ? ad_stack(count, parts) : block[0];
        }
    }
    ad_value all[NN_DEGREE_MAX];
    int count = 0;
    for (int d = 1; d <= degree; d++) {
        if (any[d]) {
            all[count++] = block[d];
        }
    }
    return ad_stack(count, all);
}
