/* Defaults of network, points and stages: they follow from the scene and from one another. */
#include "tools/config/config_parts.h"

#include <math.h>

/* Largest frequencies of random features. Along s 8 radians per half length at rest, where fields
 * are smooth and the best fit is wanted, 6 in motion; at rest 4 more than the loads may bend a rod
 * by, if that is more, and 32 at most. In time the third bending frequency of a
 * cantilever, 61.7 EI/(rhoA L^4)^(1/2), which a load hardly excites beyond, and at least 6 radians
 * per half window. All measured on the scenes in configs/: within a factor of two of these the
 * error changes little. */
static const double AT_REST = 8, MARGIN = 4, AT_REST_MOST = 32, IN_MOTION = 6;
static const double THIRD_FREQUENCY = 61.697;

/* Units of L^2 (rhoA/EI)^(1/2) in a window: 1.6 periods of that frequency. Half as many windows
 * with fewer waves take half the time, to errors ten to a hundred times as large. */
static const double WINDOW = 1.0 / 6;

/* Radians per half length or half window beyond which no number of points resolves a wave. */
static const double LARGEST_BANDWIDTH = 1e5;

enum { FEATURES_LEAST = 80, FEATURES_MAX = 256, POINTS_PER_FUNCTION = 4 };

static bool given(const config *experiment, const char *path)
{
    return config_given(experiment->source, path);
}

static bool begins_with_gauss_newton(const config *experiment)
{
    return experiment->stages[0].optimizer == CONFIG_GAUSS_NEWTON;
}

/* Windows so short that a moderate number of features spans what happens in one. */
static ad_status resolve_windows(config *experiment, ad_error *error)
{
    scene *rod_scene = &experiment->scene;
    bool hard = rod_scene->initial_enforcement == SCENE_HARD;
    bool whole = scene_is_fourth_order(rod_scene);
    if (scene_is_dynamic(rod_scene) && hard && !whole && !given(experiment, "time.windows")) {
        double units = rod_scene->duration / rod_scales_of(rod_scene).time;
        double windows = ceil(units / WINDOW * (1 - 1e-12));
        if (!(windows <= SCENE_WINDOWS_MAX)) {
            return config_blame(
                experiment->source, error, "time.duration",
                "would take %.3g windows of an eleventh of a period of the first bending mode; "
                "allowed: up to %d, here %.3g s, or longer windows, given by time.windows",
                windows, SCENE_WINDOWS_MAX,
                SCENE_WINDOWS_MAX * WINDOW * rod_scales_of(rod_scene).time);
        }
        rod_scene->windows = (int)fmax(1, windows);
    }
    return AD_OK;
}

static ad_status check_bandwidth(const config *experiment, bool dynamic, ad_error *error)
{
    const double *bandwidth = experiment->network.fourier_bandwidth;
    for (int i = 0; i <= dynamic; i++) {
        if (!(bandwidth[i] <= LARGEST_BANDWIDTH)) {
            return config_blame(experiment->source, error,
                                i ? "network.fourier.frequency" : "network.fourier.wavenumber",
                                "is %.3g radians in half the %s, more than points can resolve; "
                                "allowed: up to %g",
                                bandwidth[i], i ? "window of time" : "length", LARGEST_BANDWIDTH);
        }
    }
    return AD_OK;
}

/* At rest, per half length. A moment M bends by M / EI, a force F by 2 sqrt(F / EI) at most,
 * however the rod lies: half of EI times curvature squared changes along it by no more than F
 * times 2. */
static double bandwidth_at_rest(const scene *rod_scene)
{
    if (scene_is_beam(rod_scene)) {
        return AT_REST; /* which loads bend but do not turn */
    }
    rod_numbers numbers = rod_numbers_of(rod_scene);
    double force = numbers.tip_force + numbers.distributed_force + numbers.weight;
    double turns = numbers.tip_moment + numbers.distributed_moment + 2 * sqrt(force);
    return fmin(AT_REST_MOST, fmax(AT_REST, MARGIN + turns / 2));
}

static ad_status resolve_bandwidth(config *experiment, ad_error *error)
{
    const scene *rod_scene = &experiment->scene;
    double *bandwidth = experiment->network.fourier_bandwidth;
    bool dynamic = scene_is_dynamic(rod_scene);
    double half_length = rod_scene->rod.length / 2;
    double half_time = rod_scene->duration / rod_scene->windows / 2;
    if (!dynamic && given(experiment, "network.fourier.frequency")) {
        return config_blame(experiment->source, error, "network.fourier.frequency",
                            "is along time, but the scene is static; give time.duration, or leave "
                            "it out");
    }
    if (isnan(experiment->fourier_wavenumber)) {
        experiment->fourier_wavenumber =
            (dynamic ? IN_MOTION : bandwidth_at_rest(rod_scene)) / half_length;
    }
    bandwidth[0] = experiment->fourier_wavenumber * half_length;
    if (dynamic) {
        if (isnan(experiment->fourier_frequency)) {
            experiment->fourier_frequency =
                fmax(IN_MOTION / half_time, THIRD_FREQUENCY / rod_scales_of(rod_scene).time);
        }
        bandwidth[1] = experiment->fourier_frequency * half_time;
    }
    return check_bandwidth(experiment, dynamic, error);
}

/* Of a window's motion from where it starts a rotation vector tells more simply than a quaternion.
 * From the unloaded rod a wire of one turn was measured to be too far, so not at rest. */
static void resolve_rotation(config *experiment)
{
    scene *rod_scene = &experiment->scene;
    bool from_start = scene_is_dynamic(rod_scene) && rod_scene->initial_enforcement == SCENE_HARD;
    if (from_start && experiment->network.hidden_count == 0 &&
        !given(experiment, "network.rotation")) {
        rod_scene->rotation = SCENE_VECTOR;
    }
}

/* Twice the bandwidth along s at rest; in motion 1.4 times the product of both. */
static int default_features(const config *experiment)
{
    const double *bandwidth = experiment->network.fourier_bandwidth;
    double count = scene_is_dynamic(&experiment->scene)
                       ? fmax(FEATURES_LEAST, 1.4 * bandwidth[0] * bandwidth[1])
                       : 2 * bandwidth[0];
    return (int)fmin(FEATURES_MAX, ceil(count - 1e-9));
}

/* A linear network starts near where it ends, so with hardly any damping. The functions of its
 * orthonormal basis differ in their derivatives, and so in what J^T J holds of them; in motion,
 * and for beams, damping that follows this was measured to be better by many orders. For rods at
 * rest damping all alike takes fewer steps, and only so do those wound up five times arrive. */
static void resolve_linear_stages(config *experiment)
{
    const scene *rod_scene = &experiment->scene;
    char path[CONFIG_PATH_MAX];
    for (int i = 0; i < experiment->stage_count; i++) {
        config_stage *stage = &experiment->stages[i];
        snprintf(path, sizeof path, "training.stages[%d].initial_damping", i);
        if (!given(experiment, path)) {
            stage->gauss_newton.initial_damping = 1e-10;
        }
        snprintf(path, sizeof path, "training.stages[%d].scaling", i);
        if (!given(experiment, path) && stage->linear_algebra != CONFIG_MATRIX_FREE &&
            (scene_is_dynamic(rod_scene) || scene_is_beam(rod_scene))) {
            stage->gauss_newton.scaling = OPTIM_SCALING_DIAGONAL;
        }
    }
}

static void resolve_points(const config *experiment, int *points, const char *path, int otherwise)
{
    if (!given(experiment, path)) {
        *points = otherwise;
    }
}

ad_status config_resolve_network(config *experiment, ad_error *error)
{
    nn_mlp_settings *network = &experiment->network;
    problem_settings *losses = &experiment->losses;
    bool dynamic = scene_is_dynamic(&experiment->scene);
    if (!given(experiment, "network.hidden") && begins_with_gauss_newton(experiment)) {
        network->hidden_count = 0;
    }
    bool linear = network->hidden_count == 0;
    resolve_rotation(experiment);
    network->orthonormal = !scene_is_fourth_order(&experiment->scene);
    ad_status status = linear ? resolve_windows(experiment, error) : AD_OK;
    if (status == AD_OK) {
        status = resolve_bandwidth(experiment, error);
    }
    if (status != AD_OK) {
        return status;
    }
    if (linear && !given(experiment, "network.fourier.features")) {
        network->fourier_features = default_features(experiment);
    }
    int functions = 1 + 2 * network->fourier_features;
    int interior = linear ? POINTS_PER_FUNCTION * functions : dynamic ? 1024 : 256;
    resolve_points(experiment, &losses->interior.points, "losses.interior.points", interior);
    resolve_points(experiment, &losses->boundary.points, "losses.boundary.points",
                   dynamic ? 64 : 1);
    resolve_points(experiment, &losses->held_out_points, "losses.held_out_points",
                   dynamic ? 1024 : 256);
    if (linear) {
        resolve_linear_stages(experiment);
    }
    if (linear && !given(experiment, "losses.interior.sampler")) {
        losses->interior.sampler =
            SAMPLING_CHEBYSHEV_LOBATTO; /* edges are where it would go astray */
    }
    if (!given(experiment, "output.every") && begins_with_gauss_newton(experiment)) {
        experiment->output_every = 1;
    }
    return AD_OK;
}
