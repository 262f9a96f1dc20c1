/* A program outside the project: the fourth derivative of y = sin(2 x) exp(x), and the gradient of
 * sum over points of w y^2 with respect to the parameter w, against the closed forms. */
#include "autodiff/ad.h"
#include "nn/nn.h"
#include "optim/optim.h"
#include "physics/scene/scene.h"

#include <math.h>
#include <stdio.h>

enum { POINTS = 1000 };

/* The derivatives are below 70, where a unit of rounding is 1.4e-14; some dozens may add up. */
static const double tolerance = 1e-12;

typedef struct recording {
    ad_value fourth;
    ad_value gradient;
} recording;

static recording record(ad_tape *tape)
{
    ad_value x = ad_input(tape, "x", 1);
    ad_value w = ad_parameter(tape, "w", 1, 0);
    ad_value y = ad_mul(ad_sin(ad_scale(x, 2.0)), ad_exp(x));
    ad_value loss = ad_sum_points(ad_mul(w, ad_square(y)));
    recording result = {.fourth = ad_derivative(y, x, 4)};
    ad_reverse(loss, 1, &w, AD_SUMMED, &result.gradient);
    return result;
}

/* y = Im exp((1 + 2i) x), and (1 + 2i)^4 = -7 - 24i. */
static double fourth_derivative(double x)
{
    return exp(x) * (-7.0 * sin(2.0 * x) - 24.0 * cos(2.0 * x));
}

static int compare(const double *x, const double *fourth, double gradient)
{
    double worst = 0.0;
    double sum = 0.0;
    for (int i = 0; i < POINTS; i++) {
        double y = sin(2.0 * x[i]) * exp(x[i]);
        worst = fmax(worst, fabs(fourth[i] - fourth_derivative(x[i])));
        sum += y * y;
    }
    double error = fabs(gradient - sum) / sum;
    printf("fourth derivative: error %.1e; gradient: relative error %.1e\n", worst, error);
    return worst < tolerance && error < tolerance ? 0 : 1;
}

static int run(ad_program *program, ad_error *error)
{
    static double x[POINTS];
    static double fourth[POINTS];
    double gradient = 0.0;
    double w = 0.5;
    for (int i = 0; i < POINTS; i++) {
        x[i] = -1.0 + 2.0 * i / (POINTS - 1);
    }
    const double *inputs[] = {x};
    double *outputs[] = {fourth, &gradient};
    ad_run job = {.points = POINTS, .inputs = inputs, .parameters = &w, .outputs = outputs};
    if (ad_execute(program, &job, error) != AD_OK) {
        return 1;
    }
    return compare(x, fourth, gradient);
}

int main(void)
{
    ad_error error = {AD_OK, ""};
    ad_tape *tape = ad_tape_create();
    ad_pool *pool = ad_pool_create(2);
    ad_program *program = NULL;
    int failed = 1;
    if (tape && pool) {
        recording made = record(tape);
        ad_value outputs[] = {made.fourth, made.gradient};
        if (ad_compile(2, outputs, NULL, pool, &program, &error) == AD_OK) {
            failed = run(program, &error);
        }
    }
    if (error.status != AD_OK) {
        fprintf(stderr, "%s: %s\n", ad_status_text(error.status), error.message);
    }
    ad_program_free(program);
    ad_pool_free(pool);
    ad_tape_free(tape);
    return failed;
}
