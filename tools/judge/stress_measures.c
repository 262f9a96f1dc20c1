/* What is measured of an answer beside its error of position against a reference. */
#include "tools/judge/stress.h"

#include <math.h>

/* Points along the rod; columns of rods. */
enum { ALONG = 65, FORCE = 13, MOMENT = 16, VELOCITY = 19, SPIN = 22 };

static void points_along(const scene *rod_scene, double s[ALONG])
{
    for (int k = 0; k < ALONG; k++) {
        s[k] = scene_length(rod_scene) * k / (ALONG - 1);
    }
}

ad_status stress_rotation(const judge_answer *a, double *error, ad_error *reason)
{
    (void)reason;
    *error = a->errors[JUDGE_ROTATION];
    return AD_OK;
}

/* ---- energy -------------------------------------------------------------------------------- */

static void tip_force(const scene *rod_scene, double t, double force[3])
{
    for (int i = 0; i < 3; i++) {
        quantity given = quantity_or(rod_scene->loads.tip.force[i], quantity_number(0));
        force[i] = quantity_value(given, 0, t);
    }
}

/* The first instant from which on the force at the tip stays what it is. */
static int last_change(const scene *rod_scene)
{
    double last[3], now[3];
    tip_force(rod_scene, scene_duration(rod_scene), last);
    for (int i = JUDGE_INSTANTS - 1; i >= 0; i--) {
        tip_force(rod_scene, scene_duration(rod_scene) * i / (JUDGE_INSTANTS - 1), now);
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
    double force[3], last = scene_duration(rod_scene);
    tip_force(rod_scene, last, force);
    for (int k = 0; k < ALONG; k++) {
        double weight = scene_length(rod_scene) / (ALONG - 1) / 3 *
                        (k == 0 || k == ALONG - 1 ? 1
                         : k % 2                  ? 4
                                                  : 2);
        double s = scene_length(rod_scene) * k / (ALONG - 1);
        double mass = quantity_value(p.mass_per_length, s, 0);
        for (int i = 0; i < 3; i++) {
            double inertia = quantity_value(p.rotary_inertia[i], s, 0);
            double gravity = quantity_value(rod_scene->loads.gravity[i], s, last);
            double velocity = values[(VELOCITY + i) * ALONG + k];
            double spin = values[(SPIN + i) * ALONG + k];
            double n = values[(FORCE + i) * ALONG + k], m = values[(MOMENT + i) * ALONG + k];
            double stretch = n * n / quantity_value(p.strain_stiffness[i], s, 0);
            double bend = m * m / quantity_value(p.curvature_stiffness[i], s, 0);
            sum.kinetic += weight / 2 * (mass * velocity * velocity + inertia * spin * spin);
            sum.potential +=
                weight * ((stretch + bend) / 2 - mass * gravity * values[i * ALONG + k]);
        }
    }
    for (int i = 0; i < 3; i++) {
        sum.potential -= force[i] * values[i * ALONG + ALONG - 1];
    }
    return sum;
}

ad_status stress_energy_drift(const judge_answer *a, double *error, ad_error *reason)
{
    const scene *rod_scene = a->found.scene;
    double s[ALONG], t[ALONG], times[JUDGE_INSTANTS], values[MODEL_COLUMNS_MAX * ALONG];
    double first = 0, drift = 0, kinetic = 0;
    int from = last_change(rod_scene);
    points_along(rod_scene, s);
    judge_instants(rod_scene, times);
    for (int j = from; j < JUDGE_INSTANTS; j++) {
        for (int k = 0; k < ALONG; k++) {
            t[k] = times[j];
        }
        ad_status status = a->found.kind->at_points(&a->found, ALONG, s, t, values, reason);
        if (status != AD_OK) {
            return status;
        }
        energy now = energy_of(rod_scene, values);
        double sum = now.kinetic + now.potential;
        first = j == from ? sum : first;
        drift = isnan(sum) ? NAN : fmax(drift, fabs(sum - first));
        kinetic = fmax(kinetic, now.kinetic);
        if (isnan(drift)) {
            break;
        }
    }
    *error = drift / kinetic;
    return AD_OK;
}
