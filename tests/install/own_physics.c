/* Physics of one's own, outside the project: heat in a bar that is cooled at both ends,
 *
 *   u_t = u_xx for 0 < x < 1 m, 0 < t < 0.2 s,   u(0, t) = u(1, t) = 0,   u(x, 0) = sin(pi x),
 *
 * trained by the default recipe and compared with exp(-pi^2 t) sin(pi x). */
#include <cpinn/cpinn.h>

#include <math.h>
#include <stdio.h>

static const double pi = 3.14159265358979323846, diffusivity = 1, duration = 0.2; /* m^2/s, s */

/* ---- the physics: coordinates on the tape run from 0 to 1 ------------------------------------ */

static ad_value balance(const void *context, const domain_place *at, const ad_value *u)
{
    double k = *(const double *)context;
    return ad_sub(ad_derivative(*u, at->x[1], 1),
                  ad_scale(ad_derivative(*u, at->x[0], 2), k * duration));
}

static ad_value cold(const void *context, const domain_place *at, const ad_value *u)
{
    (void)context;
    (void)at;
    return *u;
}

static ad_value start(const void *context, const domain_place *at, const ad_value *u)
{
    (void)context;
    return ad_sub(*u, ad_sin(ad_scale(at->x[0], pi)));
}

static physics_model *bar(void)
{
    physics_model *m = model_create();
    if (m) {
        int x = model_add_coordinate(m, "x", "m", 0, 1, 0);
        int t = model_add_coordinate(m, "t", "s", 0, duration, 0);
        model_set_time(m, t);
        model_add_field(m, "u", 1);
        model_add_term(m, "balance", model_add_interior(m, "inside"), 1, balance, &diffusivity);
        model_add_term(m, "left", model_add_face(m, "left", x, 0), 100, cold, NULL);
        model_add_term(m, "right", model_add_face(m, "right", x, 1), 100, cold, NULL);
        model_add_term(m, "start", model_add_face(m, "start", t, 0), 100, start, NULL);
    }
    return m;
}

/* ---- training and looking -------------------------------------------------------------------- */

static int compare(const cpinn_model *trained, ad_error *error)
{
    evaluator *e;
    double worst = 0, slope = 0;
    if (cpinn_evaluator(trained, "u u_t", &e, error) != AD_OK) {
        return 1;
    }
    for (int i = 0; i <= 20; i++) {
        for (int j = 0; j <= 20; j++) {
            double x = i / 20.0, t = duration * j / 20, values[2];
            double exact = exp(-pi * pi * diffusivity * t) * sin(pi * x);
            if (evaluator_evaluate_at(e, 1, (const double *const[]){&x, &t}, values, error)) {
                return 1;
            }
            worst = fmax(worst, fabs(values[0] - exact));
            slope = fmax(slope, fabs(values[1] + pi * pi * diffusivity * exact));
        }
    }
    evaluator_free(e);
    printf("heat: largest error %.1e, of u_t %.1e; %s\n", worst, slope,
           verdict_outcome_name(verdict_outcome_of(cpinn_verdict(trained))));
    return worst < 1e-6 && slope < 1e-3 ? 0 : 1; /* smooth: far above what the waves miss */
}

int main(void)
{
    ad_error error = {AD_OK, ""};
    cpinn_model *trained = NULL;
    physics_model *m = bar();
    int failed = !m || cpinn_train_physics(m, NULL, NULL, &trained, &error) != AD_OK ||
                 compare(trained, &error);
    if (error.status != AD_OK) {
        fprintf(stderr, "%s\n", error.message);
    }
    cpinn_free(trained);
    model_free(m);
    return failed;
}
