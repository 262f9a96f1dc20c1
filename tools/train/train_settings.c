#include "tools/train/train_settings.h"

#include <math.h>

#define TEXT_OF(name, text) text,
#define NAMES(function, LIST)                                                                      \
    const char *const *function(void)                                                              \
    {                                                                                              \
        static const char *const names[] = {LIST(TEXT_OF) NULL};                                   \
        return names;                                                                              \
    }

NAMES(train_linear_algebra_names, TRAIN_LINEAR_ALGEBRA_LIST)
NAMES(train_reference_names, TRAIN_REFERENCE_LIST)
NAMES(train_targets_names, TARGETS_LIST)
NAMES(train_quantity_names, TRAIN_QUANTITY_LIST)

static double *number_of(train_stage *stage, const optim_setting *row)
{
    return (double *)(void *)((char *)&stage->optim + row->offset);
}

static bool has_own_defaults(const optim_setting *row)
{
    bool has = false;
    for (int i = 0; i < OPTIM_METHOD_COUNT; i++) {
        has = has || optim_setting_is_own(row, (optim_method)i);
    }
    return has;
}

void train_close_own(train_stage *stage)
{
    const optim_settings otherwise = optim_settings_defaults(stage->optim.method);
    for (int i = 0; i < optim_setting_count; i++) {
        const optim_setting *row = &optim_setting_rows[i];
        double *number = number_of(stage, row);
        if (has_own_defaults(row) && isnan(*number)) {
            *number = optim_setting_value(row, &otherwise);
        }
    }
}

train_stage train_stage_default(void)
{
    train_stage stage = {.optim = optim_settings_defaults(OPTIM_METHOD_COUNT), .steps = 1000};
    stage.optim.method = OPTIM_ADAM;
    stage.optim.schedule = OPTIM_SCHEDULE_COSINE;
    stage.optim.learning_rate = 5e-3;
    stage.optim.decay_steps = 0;
    stage.optim.scaling = (optim_scaling)TRAIN_OPEN;
    stage.optim.initial_damping = NAN;
    for (int i = 0; i < optim_setting_count; i++) {
        if (has_own_defaults(&optim_setting_rows[i])) {
            *number_of(&stage, &optim_setting_rows[i]) = NAN;
        }
    }
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
        settings.data[i].from = settings.data[i].every = 1;
    }
    settings.stages[0].optim.method = (optim_method)TRAIN_OPEN;
    settings.stages[0].steps = TRAIN_OPEN;
    settings.stages[0].optim.learning_rate = NAN;
    settings.stages[0].optim.warmup_steps = TRAIN_OPEN;
    settings.stages[0].optim.clip_norm = NAN;
    settings.stages[0].optim.function_tolerance = NAN;
    return settings;
}

train_stage train_usual_stage(void)
{
    train_stage stage = train_stage_default();
    stage.optim.method = OPTIM_GAUSS_NEWTON;
    stage.steps = 200;
    stage.optim.function_tolerance = 0.2; /* converging gains decades */
    return stage;
}

bool train_may_take(const train_stage *stage, optim_method optimizer)
{
    return (int)stage->optim.method == TRAIN_OPEN || stage->optim.method == optimizer;
}

void train_close_stage(train_stage *stage, train_stage usual)
{
    const train_stage from = (int)stage->optim.method == TRAIN_OPEN ? usual : train_stage_default();
    optim_settings *schedule = &stage->optim;
    double *tolerance = &stage->optim.function_tolerance;
    if ((int)stage->optim.method == TRAIN_OPEN) {
        stage->optim.method = usual.optim.method;
    }
    if (stage->steps == TRAIN_OPEN) {
        stage->steps = from.steps;
    }
    if (isnan(schedule->learning_rate)) {
        schedule->learning_rate = from.optim.learning_rate;
    }
    if (schedule->warmup_steps == TRAIN_OPEN) {
        const int64_t half = stage->steps / 2;
        schedule->warmup_steps = from.optim.warmup_steps;
        schedule->warmup_steps = schedule->warmup_steps < half ? schedule->warmup_steps : half;
    }
    if (isnan(stage->optim.clip_norm)) {
        stage->optim.clip_norm = from.optim.clip_norm;
    }
    *tolerance = isnan(*tolerance) ? from.optim.function_tolerance : *tolerance;
}
