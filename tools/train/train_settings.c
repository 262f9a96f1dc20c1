#include "tools/train/train_settings.h"

#include <math.h>

#define TEXT_OF(name, text) text,
#define NAMES(function, LIST)                                                                      \
    const char *const *function(void)                                                              \
    {                                                                                              \
        static const char *const names[] = {LIST(TEXT_OF) NULL};                                   \
        return names;                                                                              \
    }

NAMES(train_optimizer_names, OPTIM_METHOD_LIST)
NAMES(train_linear_algebra_names, TRAIN_LINEAR_ALGEBRA_LIST)
NAMES(train_reference_names, TRAIN_REFERENCE_LIST)
NAMES(train_targets_names, TARGETS_LIST)
NAMES(train_quantity_names, TRAIN_QUANTITY_LIST)

train_stage train_stage_default(void)
{
    train_stage stage = {.optimizer = OPTIM_ADAM,
                         .steps = 1000,
                         .adam = optim_adam_defaults(),
                         .lbfgs = optim_lbfgs_defaults(),
                         .gauss_newton = optim_gauss_newton_defaults()};
    stage.adam.schedule.kind = OPTIM_SCHEDULE_COSINE;
    stage.adam.schedule.learning_rate = 5e-3;
    stage.adam.schedule.decay_steps = 0;
    stage.adam.beta1 = stage.adam.beta2 = NAN;
    stage.gauss_newton.scaling = (optim_scaling)TRAIN_OPEN;
    stage.gauss_newton.initial_damping = NAN;
    stage.stop_held_out_ratio = 100;
    return stage;
}

static problem_settings losses_default(void)
{
    problem_settings losses = problem_settings_default();
    losses.interior.points = losses.boundary.points = losses.held_out_points = 0;
    losses.interior.sampler = (sampling_kind)TRAIN_OPEN;
    losses.adaptive.every = 0;
    losses.initial.points = 64;
    return losses;
}

train_settings train_settings_default(void)
{
    train_settings settings = {.network = nn_mlp_settings_default(),
                               .fourier_wavenumber = NAN,
                               .fourier_frequency = NAN,
                               .fourier_parameters = NAN,
                               .rotation = TRAIN_OPEN,
                               .tolerance = NAN,
                               .weights = rod_weights_default(),
                               .losses = losses_default(),
                               .stage_count = 1,
                               .checkpoint_every = 1000,
                               .checkpoint_seconds = 60,
                               .checkpoint_keep = 3,
                               .reference_tolerance = NAN};
    settings.network.inputs = settings.network.outputs = 1;
    settings.network.hidden_count = settings.network.fourier_features = TRAIN_OPEN;
    settings.network.degree = TRAIN_OPEN;
    for (int i = 0; i < TRAIN_STAGES_MAX; i++) {
        settings.stages[i] = train_stage_default();
    }
    for (int i = 0; i < TRAIN_DATA_MAX; i++) {
        settings.data[i].weight = NAN;
    }
    settings.stages[0].optimizer = (optim_method)TRAIN_OPEN;
    settings.stages[0].steps = TRAIN_OPEN;
    settings.stages[0].adam.schedule.learning_rate = NAN;
    settings.stages[0].adam.schedule.warmup_steps = TRAIN_OPEN;
    settings.stages[0].adam.clip_norm = NAN;
    settings.stages[0].lbfgs.descent.function_tolerance = NAN;
    return settings;
}

train_stage train_usual_stage(void)
{
    train_stage stage = train_stage_default();
    stage.optimizer = OPTIM_GAUSS_NEWTON;
    stage.steps = 200;
    stage.lbfgs.descent.function_tolerance = 0.2; /* converging gains decades */
    return stage;
}

bool train_may_take(const train_stage *stage, optim_method optimizer)
{
    return (int)stage->optimizer == TRAIN_OPEN || stage->optimizer == optimizer;
}

void train_close_stage(train_stage *stage, train_stage usual)
{
    const train_stage from = (int)stage->optimizer == TRAIN_OPEN ? usual : train_stage_default();
    optim_schedule *schedule = &stage->adam.schedule;
    double *tolerance = &stage->lbfgs.descent.function_tolerance;
    if ((int)stage->optimizer == TRAIN_OPEN) {
        stage->optimizer = usual.optimizer;
    }
    if (stage->steps == TRAIN_OPEN) {
        stage->steps = from.steps;
    }
    if (isnan(schedule->learning_rate)) {
        schedule->learning_rate = from.adam.schedule.learning_rate;
    }
    if (schedule->warmup_steps == TRAIN_OPEN) {
        const int64_t half = stage->steps / 2;
        schedule->warmup_steps = from.adam.schedule.warmup_steps;
        schedule->warmup_steps = schedule->warmup_steps < half ? schedule->warmup_steps : half;
    }
    if (isnan(stage->adam.clip_norm)) {
        stage->adam.clip_norm = from.adam.clip_norm;
    }
    *tolerance = isnan(*tolerance) ? from.lbfgs.descent.function_tolerance : *tolerance;
}
