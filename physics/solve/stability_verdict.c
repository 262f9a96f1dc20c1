/* What is known of the stability of an equilibrium, and how it is said. */
#include "physics/numerics/constants.h"
#include "physics/rod/rod.h"
#include "physics/solve/stability.h"

#include <math.h>

/* Real parts of vibrations over their size: of a scene without damping less is held by what any
 * material damps (steel 1e-3, polymers some 1e-2), and less yet is rounding. */
static const double HELD = 0.01, ROUNDING = 1e-6;

/* By the energy, or else by vibrations. */
static ad_status find_in(const scene *rod_scene, const double *values, stability *result,
                         ad_error *error)
{
    *result = (stability){.modes = -1, .share = NAN};
    const ad_status status = stability_count(rod_scene, values, &result->modes, error);
    return status == AD_OK && result->modes < 0
               ? stability_of_motion(rod_scene, values, result, error)
               : status;
}

ad_status stability_find(const scene *rod_scene, const double *values, stability *result,
                         ad_error *error)
{
    *result = (stability){.modes = -1, .share = NAN};
    if (scene_is_dynamic(rod_scene) || scene_is_beam(rod_scene) ||
        scene_is_manufactured(rod_scene)) {
        return AD_OK;
    }
    ad_status status = find_in(rod_scene, values, result, error);
    scene loose = *rod_scene;
    loose.motion = SCENE_SPATIAL;
    if (status == AD_OK && !stability_is_lost(result) && rod_scene->motion == SCENE_AUTOMATIC &&
        rod_plane_of(rod_scene).is_planar) {
        status = find_in(&loose, values, result, error);
        result->aside = stability_is_lost(result);
    }
    return status;
}

bool stability_is_lost(const stability *stability)
{
    return stability->modes > 0 || stability->share > (stability->damped ? ROUNDING : HELD);
}

bool stability_flutters(const stability *stability)
{
    return stability->modes < 0 && stability->frequency > stability->growth * ROUNDING;
}

static const char *way_of(const stability *stability)
{
    return stability->aside ? " out of the plane of the scene" : "";
}

static void judge_motion(const stability *stability, const char *advice, verdict *result)
{
    const char *mass = stability->massless ? " (with a mass of 1 kg/m, as none is given)" : "";
    if (!stability_flutters(stability)) {
        verdict_add(result, VERDICT_UNSTABLE,
                    "in this equilibrium the rod gives way%s: a push grows by a factor of e in "
                    "%.3g s%s%s",
                    way_of(stability), 1 / stability->growth, mass, advice);
    } else {
        verdict_add(
            result, VERDICT_UNSTABLE,
            "in this equilibrium the rod flutters%s: a vibration of %.4g Hz grows by a factor "
            "of e in %.3g s%s",
            way_of(stability), stability->frequency / (2 * PI), 1 / stability->growth, mass);
    }
}

void stability_judge(const stability *stability, const char *advice, verdict *result)
{
    advice = stability->aside ? "; motion: spatial and an imperfection out of the plane show where "
                                "to, motion: planar keeps the rod in it"
                              : advice;
    if (stability->modes > 0) {
        verdict_add(result, VERDICT_UNSTABLE,
                    "in this equilibrium the energy falls in %d direction%s%s%s", stability->modes,
                    stability->modes == 1 ? "" : "s", way_of(stability), advice);
    } else if (stability_is_lost(stability)) {
        judge_motion(stability, advice, result);
    } else if (stability->unknown[0]) {
        verdict_add(result, VERDICT_STABILITY_OPEN,
                    "whether this equilibrium is stable is not known: %s", stability->unknown);
    } else if (stability->share > ROUNDING) {
        verdict_add(result, VERDICT_STABILITY_OPEN,
                    "this equilibrium is stable if its vibration of %.4g Hz%s is damped by more "
                    "than %.2g of the critical damping; the scene has none",
                    stability->frequency / (2 * PI),
                    stability->massless ? ", with a mass of 1 kg/m," : "", stability->share);
    }
}
