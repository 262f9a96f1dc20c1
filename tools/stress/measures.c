/* What is measured of a trained scene beside the error of position. */
#include "tools/stress/stress.h"

#include "physics/expression.h"

#include <math.h>
#include <stdlib.h>

ad_status stress_rotation(const session *s, double *error, ad_error *reason)
{
    (void)reason;
    *error = trainer_inspect(s->trainer).errors.rotation;
    return AD_OK;
}

/* ---- energy -------------------------------------------------------------------------------- */

/* Points along the rod and instants; columns of FIELD_COLUMN_LIST. */
enum { ALONG = 65, INSTANTS = 201, FORCE = 13, MOMENT = 16, VELOCITY = 19, SPIN = 22 };

static void tip_force(const scene *rod_scene, double t, double force[3])
{
    for (int i = 0; i < 3; i++) {
        const char *text = rod_scene->loads.tip.force[i];
        force[i] = text ? expression_evaluate(text, 0, t) : 0;
    }
}

/* The first instant from which on the force at the tip stays what it is. */
static int last_change(const scene *rod_scene)
{
    double last[3], now[3];
    tip_force(rod_scene, rod_scene->duration, last);
    for (int i = INSTANTS - 1; i >= 0; i--) {
        tip_force(rod_scene, rod_scene->duration * i / (INSTANTS - 1), now);
        if (now[0] != last[0] || now[1] != last[1] || now[2] != last[2]) {
            return i + 1;
        }
    }
    return 0;
}

typedef struct energy {
    double kinetic, potential;
} energy;

/* values [columns][ALONG]; Simpson's rule. */
static energy energy_of(const scene *rod_scene, const double *values)
{
    scene_properties p = scene_properties_of(rod_scene);
    energy sum = {0, 0};
    double force[3];
    tip_force(rod_scene, rod_scene->duration, force);
    for (int k = 0; k < ALONG; k++) {
        double weight = rod_scene->rod.length / (ALONG - 1) / 3 *
                        (k == 0 || k == ALONG - 1 ? 1
                         : k % 2                  ? 4
                                                  : 2);
        for (int i = 0; i < 3; i++) {
            double velocity = values[(VELOCITY + i) * ALONG + k];
            double spin = values[(SPIN + i) * ALONG + k];
            double n = values[(FORCE + i) * ALONG + k], m = values[(MOMENT + i) * ALONG + k];
            double stretch = isfinite(p.strain_stiffness[i]) ? n * n / p.strain_stiffness[i] : 0;
            double bend = isfinite(p.curvature_stiffness[i]) ? m * m / p.curvature_stiffness[i] : 0;
            sum.kinetic +=
                weight / 2 *
                (p.mass_per_length * velocity * velocity + p.rotary_inertia[i] * spin * spin);
            sum.potential +=
                weight * ((stretch + bend) / 2 -
                          p.mass_per_length * rod_scene->loads.gravity[i] * values[i * ALONG + k]);
        }
    }
    for (int i = 0; i < 3; i++) {
        sum.potential -= force[i] * values[i * ALONG + ALONG - 1];
    }
    return sum;
}

static ad_status drift_of(const session *s, field *motion, double *values, double *error,
                          ad_error *reason)
{
    const scene *rod_scene = &s->e->settings->scene;
    double at[ALONG], t[ALONG], first = 0, drift = 0, kinetic = 0;
    int from = last_change(rod_scene);
    for (int j = from; j < INSTANTS; j++) {
        for (int k = 0; k < ALONG; k++) {
            at[k] = rod_scene->rod.length * k / (ALONG - 1);
            t[k] = rod_scene->duration * j / (INSTANTS - 1);
        }
        ad_status status =
            field_evaluate(motion, experiment_parameters(s->e), ALONG, at, t, values, reason);
        if (status != AD_OK) {
            return status;
        }
        energy now = energy_of(rod_scene, values);
        double sum = now.kinetic + now.potential;
        first = j == from ? sum : first;
        if (isnan(sum)) {
            *error = NAN;
            return AD_OK;
        }
        drift = fmax(drift, fabs(sum - first));
        kinetic = fmax(kinetic, now.kinetic);
    }
    *error = drift / kinetic;
    return AD_OK;
}

ad_status stress_energy_drift(const session *s, double *error, ad_error *reason)
{
    const experiment *e = s->e;
    field *motion = NULL;
    *error = NAN;
    ad_status status = field_create(&e->settings->scene, e->mlp, false, e->pool, &motion, reason);
    double *values = malloc(MODEL_COLUMNS_MAX * ALONG * sizeof *values);
    if (status == AD_OK && !values) {
        status = ad_fail(reason, AD_NO_MEMORY, "out of memory for an energy");
    }
    if (status == AD_OK) {
        field_enter(motion, e->window, e->parameters, e->starts);
        status = drift_of(s, motion, values, error, reason);
    }
    free(values);
    field_free(motion);
    return status;
}
