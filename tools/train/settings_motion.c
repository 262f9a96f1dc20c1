/* The measured defaults of one motion in the strain form. */
#include "tools/train/settings_internal.h"

#include <math.h>
#include <string.h>

/* Modes of bending, twist, stretch and shear; and what is begun with where a tolerance is given. */
static const int MODES[4] = {12, 6, 10, 10}, MODES_FIRST[4] = {4, 2, 3, 3};

/* Degree of polynomials of time in a window: that, and in a long one that is given one more for
 * each radian of the third bending frequency of a cantilever, 61.7 EI/(rhoA L^4)^(1/2), in half of
 * it, of which the default has 5. Errors add up from window to window unless they fade by damping:
 * degree 20 takes a quarter to half again the time of 16, to errors a half to a sixtieth in motions
 * without damping, to three quarters where there is some. Instants for each of them. */
enum { DEGREE = 20, DEGREE_FADING = 16, DEGREE_FIRST = 12, RADIANS = 5, HELD_OUT = 32 };
static const double FIRST_FREQUENCY = 3.516, THIRD_FREQUENCY = 61.697, INSTANTS = 1.2;

/* Of waves in place of polynomials, the largest frequency: radians in half a window. */
static const double IN_WINDOW = 8;

/* What is not of time alone, or of tapes. */
static ad_status check_given(const train_settings *settings, const scene *motion, char *key,
                             ad_error *error)
{
    const problem_settings *losses = &settings->losses;
    ad_status status = train_check_support(settings, motion, key, error);
    if (status != AD_OK) {
        return status;
    }
    const struct {
        bool is_so;
        const char *key;
    } others[] = {{settings->network.hidden_count > 0, "network.hidden"},
                  {!isnan(settings->fourier_wavenumber), "network.fourier.wavenumber"},
                  {!isnan(settings->fourier_parameters), "network.fourier.parameters"},
                  {losses->causal_slices > 0, "losses.causal.slices"},
                  {losses->adaptive.kind != PROBLEM_ADAPTIVE_NONE, "losses.adaptive.kind"},
                  {losses->balance != PROBLEM_BALANCE_NONE, "losses.balance.kind"},
                  {settings->members > 0, "members.solved"},
                  {settings->members_file != NULL, "members.file"}};
    for (size_t i = 0; i < sizeof others / sizeof *others; i++) {
        if (others[i].is_so) {
            return train_refuse(key, others[i].key, error,
                                "is not of a motion in the strain form, a linear network of time "
                                "for each mode; leave it out, or take formulation: mixed");
        }
    }
    return AD_OK;
}

/* Before radians are added. */
static int degree_of(const train_settings *settings, const scene *motion)
{
    const double duration = scene_duration(motion) / rod_scales_of(motion).time;
    const double faded = rod_numbers_of(motion).curvature_damping * FIRST_FREQUENCY * duration;
    return !isnan(settings->tolerance) ? DEGREE_FIRST : faded > 1 ? DEGREE_FADING : DEGREE;
}

/* With the bias; beside waves time itself. */
static int functions_of(const nn_mlp_settings *network)
{
    const int waves = network->fourier_features;
    return 1 + network->degree + (waves > 0 ? 1 + 2 * waves : 0);
}

ad_status train_resolve_motion(train_settings *settings, scene *motion, char key[TRAIN_KEY_MAX],
                               ad_error *error)
{
    nn_mlp_settings *network = &settings->network;
    problem_points *points = &settings->losses.interior;
    ad_status status = check_given(settings, motion, key, error);
    if (status != AD_OK) {
        return status;
    }
    train_close_stage(&settings->stages[0], train_usual_stage());
    network->hidden_count = 0;
    settings->rotation = SCENE_QUATERNION; /* there is none */
    status = train_resolve_windows(settings, motion, key, error);
    int *modes = settings->modes;
    if (modes[0] + modes[1] + modes[2] + modes[3] == 0) {
        memcpy(modes, isnan(settings->tolerance) ? MODES : MODES_FIRST, sizeof settings->modes);
    }
    network->orthonormal = false; /* motion_network.h has a basis of its own */
    network->fourier_features = network->fourier_features > 0 ? network->fourier_features : 0;
    const double half_time = scene_duration(motion) / motion->windows / 2;
    if (network->degree == TRAIN_OPEN) {
        const double radians = THIRD_FREQUENCY * half_time / rod_scales_of(motion).time;
        const double degree = floor(degree_of(settings, motion) + fmax(0, radians - RADIANS));
        network->degree = network->fourier_features > 0 ? 0 : (int)fmin(NN_DEGREE_MAX, degree);
    }
    if (network->fourier_features > 0) {
        if (isnan(settings->fourier_frequency)) {
            settings->fourier_frequency = IN_WINDOW / half_time;
        }
        network->fourier_bandwidth[0] = settings->fourier_frequency * half_time;
    }
    if (points->points == 0) {
        points->points = (int)ceil(INSTANTS * functions_of(network));
    }
    if ((int)points->sampler == TRAIN_OPEN) {
        points->sampler = SAMPLING_CHEBYSHEV_LOBATTO;
    }
    settings->losses.adaptive.every = fmax(1, settings->losses.adaptive.every);
    settings->losses.boundary.points = fmax(1, settings->losses.boundary.points);
    settings->losses.initial.points = fmax(1, settings->losses.initial.points);
    if (settings->losses.held_out_points == 0) {
        settings->losses.held_out_points = HELD_OUT;
    }
    settings->output_every = settings->output_every > 0 ? settings->output_every : 10;
    for (int i = 0; i < settings->stage_count; i++) {
        train_resolve_stage(&settings->stages[i], true, true);
    }
    return status;
}

ad_status train_check_motion(const train_settings *settings, char key[TRAIN_KEY_MAX],
                             ad_error *error)
{
    const int functions = functions_of(&settings->network);
    if (settings->losses.interior.points < functions) {
        return train_refuse(key, "losses.interior.points", error,
                            "are %d instants for %d functions of time; allowed: as many at least",
                            settings->losses.interior.points, functions);
    }
    for (int i = 0; i < settings->stage_count; i++) {
        const train_stage *stage = &settings->stages[i];
        if (optim_method_needs(stage->optim.method) == OPTIM_NEEDS_SQUARES &&
            stage->linear_algebra != TRAIN_LINEAR_AUTOMATIC &&
            stage->linear_algebra != TRAIN_NORMAL_EQUATIONS) {
            return train_refuse_stage(key, i, "linear_algebra", error,
                                      "%s needs rows of a Jacobian, which a motion in the strain "
                                      "form does not keep; allowed: automatic, normal_equations",
                                      train_linear_algebra_names()[stage->linear_algebra]);
        }
    }
    return AD_OK;
}
