/* The measured defaults of families in the strain form. */
#include "tools/train/settings_internal.h"

#include <math.h>

/* Measured with a tendon robot of nine parameters: SOAP comes as far in 500 steps as Adam in 2000,
 * and with learning rates of 4e-3 to 1.6e-2 alike; bases turned every 5th to 20th step, batches of
 * 1024 and 2048, gelu and tanh are alike; 64 units are too few, 192 and a fourth layer better by a
 * third, in as much more time; 50000 members begin to be learnt by heart, 100000 and 200000 do not.
 */
enum { LAYERS = 3, WIDTH = 128, STEPS = 6000, WARMUP = 200, BATCH = 1024 };
enum { MEMBERS = 131072, MEMBERS_FEW = 8192, MEMBERS_LEAST = 16 };
static const double LEARNING_RATE = 8e-3;

/* Up to so many parameters polynomials, as many as seconds of least squares take, and no more than
 * one for 64 members: with one for ten they stray in the corners of the ranges. Measured on
 * cantilevers under forces and tendons, errors in mm, median and 95 %, in 1 to 9 s against the deep
 * network in 30 to 120 s: two parameters 1e-5 and 6e-5 against 6e-4 and 3e-3, three 0.05 and 0.3
 * against 0.013 and 0.05, four 0.024 and 0.23 against 0.008 and 0.03; after a step of Newton's
 * method the last are 5e-7 and 6e-5 against 1e-7 and 3e-5. Next to buckling polynomials ring: of
 * five parameters there 7 and 50 against 0.1 and 0.7. */
enum { PARAMETERS_FEW = 4, POLYNOMIALS = 1300, MEMBERS_OF_EACH = 64 };

/* Rows of the history cost measurements over fresh members. */
enum { OUTPUT_EVERY = 250 };

/* Of one parameter a few fill its range, and of each further one four times as many do: members
 * near where equilibria end take a hundred times as long as others. */
static int usual_members(const scene *family)
{
    int members = MEMBERS_FEW;
    for (int i = 1; i < family->parameter_count && members < MEMBERS; i++) {
        members *= 4;
    }
    return members < MEMBERS ? members : MEMBERS;
}

/* Some of the members in every step; the others need one function. */
static bool takes_batches(optim_method optimizer)
{
    return optim_method_needs(optimizer) == OPTIM_NEEDS_GRADIENTS;
}

/* Deep networks begin with other optimisers, and tell more of a table that may be short. */
static bool takes_polynomials(const train_settings *settings, const scene *family)
{
    const nn_mlp_settings *network = &settings->network;
    const bool few = family->parameter_count <= PARAMETERS_FEW && !settings->members_file;
    return network->hidden_count == TRAIN_OPEN && network->fourier_features <= 0 &&
           (network->degree > 0 || (network->degree == TRAIN_OPEN && few &&
                                    train_may_take(&settings->stages[0], OPTIM_GAUSS_NEWTON)));
}

/* Where the inputs are not found one for each parameter is taken; the reason is said where they are
 * needed. */
static int usual_degree(const train_settings *settings, const scene *family)
{
    const int members = settings->members_file ? MEMBERS : settings->members;
    nn_mlp_settings of = settings->network;
    groups *inputs = NULL;
    ad_error unused;
    of.inputs = family->parameter_count;
    if (groups_find(family, &settings->groups, &inputs, &unused) == AD_OK) {
        of.inputs = groups_count(inputs);
        for (int i = 0; i < of.inputs; i++) {
            of.range[i] = groups_range(inputs, i);
        }
    }
    groups_free(inputs);
    return nn_polynomial_degree(of, fmin(POLYNOMIALS, (double)members / MEMBERS_OF_EACH));
}

/* Of few parameters waves nearly depend on one another; of many a basis of them costs more than the
 * rest of training, and saves nothing. */
enum { FEW_PARAMETERS = 3 };

static void resolve_features(train_settings *settings, const scene *family)
{
    nn_mlp_settings *network = &settings->network;
    const bool linear = network->hidden_count == 0;
    network->fourier_features = network->fourier_features > 0 ? network->fourier_features : 0;
    network->orthonormal = family->parameter_count <= FEW_PARAMETERS;
    if (network->degree == TRAIN_OPEN) {
        network->degree =
            linear && network->fourier_features == 0 ? usual_degree(settings, family) : 0;
    }
    if (isnan(settings->fourier_parameters)) {
        settings->fourier_parameters = TRAIN_OF_PARAMETER;
    }
    for (int i = 0; i < NN_INPUTS_MAX; i++) {
        network->fourier_bandwidth[i] = settings->fourier_parameters;
    }
}

static train_stage usual_stage(void)
{
    train_stage stage = train_stage_default();
    stage.optim.method = OPTIM_SOAP;
    stage.steps = STEPS;
    stage.optim.learning_rate = LEARNING_RATE;
    stage.optim.warmup_steps = WARMUP;
    return stage;
}

ad_status train_resolve_family(train_settings *settings, scene *family, char key[TRAIN_KEY_MAX],
                               ad_error *error)
{
    nn_mlp_settings *network = &settings->network;
    problem_settings *losses = &settings->losses;
    ad_status status = train_check_support(settings, family, key, error);
    if (status != AD_OK) {
        return status;
    }
    if (!scene_is_family(family)) {
        return train_refuse(key, "formulation", error,
                            "strain learns a rod at rest from members of its family; give "
                            "parameters with ranges, or take mixed");
    }
    if (!isnan(settings->fourier_wavenumber) || !isnan(settings->fourier_frequency)) {
        return train_refuse(key,
                            isnan(settings->fourier_frequency) ? "network.fourier.wavenumber"
                                                               : "network.fourier.frequency",
                            error,
                            "is along s or time, but this network is of the parameters alone; "
                            "allowed: fourier.parameters");
    }
    if (takes_polynomials(settings, family)) {
        network->hidden_count = 0;
    }
    train_close_stage(&settings->stages[0],
                      network->hidden_count == TRAIN_OPEN ? usual_stage() : train_usual_stage());
    if (network->hidden_count == TRAIN_OPEN) {
        network->hidden_count = LAYERS;
        for (int i = 0; i < LAYERS; i++) {
            network->hidden[i] = WIDTH;
        }
    }
    settings->rotation = SCENE_QUATERNION; /* there is none */
    settings->windows = family->windows = 1;
    if (settings->members_file && settings->members > 0) {
        return train_refuse(key, "members.solved", error,
                            "is beside members.file, which has its own; leave one of them out");
    }
    if (!settings->members_file && settings->members == 0) {
        settings->members = usual_members(family);
    }
    resolve_features(settings, family);
    losses->interior.points = losses->interior.points > 0 ? losses->interior.points
                              : network->hidden_count == 0 && settings->members > 0
                                  ? settings->members
                                  : BATCH;
    if (takes_batches(settings->stages[0].optim.method) && losses->interior.resample_every == 0) {
        losses->interior.resample_every = 1;
    }
    if ((int)losses->interior.sampler == TRAIN_OPEN) {
        losses->interior.sampler = SAMPLING_UNIFORM;
    }
    losses->adaptive.every = losses->adaptive.every > 0 ? losses->adaptive.every : BATCH;
    losses->boundary.points = losses->boundary.points > 0 ? losses->boundary.points : 1;
    losses->held_out_points = losses->held_out_points > 0 ? losses->held_out_points : BATCH;
    settings->output_every = settings->output_every > 0 ? settings->output_every : OUTPUT_EVERY;
    for (int i = 0; i < settings->stage_count; i++) {
        train_resolve_stage(&settings->stages[i], true, network->hidden_count == 0);
    }
    return AD_OK;
}

ad_status train_check_family(const train_settings *settings, const scene *family,
                             char key[TRAIN_KEY_MAX], ad_error *error)
{
    (void)family;
    if (train_names_reference(settings)) {
        return train_refuse(key, "reference", error,
                            "is of one scene; a family in the strain form is measured by fresh "
                            "members, leave it out, or take formulation: mixed");
    }
    if (sampling_kind_is_tensor(settings->losses.interior.sampler)) {
        return train_refuse(key, "losses.interior.sampler", error,
                            "is %s, a grid, but there are many parameters; allowed: uniform, "
                            "latin_hypercube, sobol",
                            sampling_kind_text(settings->losses.interior.sampler));
    }
    if (!settings->members_file && settings->members < MEMBERS_LEAST) {
        return train_refuse(key, "members.solved", error, "is %d; allowed: from %d on",
                            settings->members, MEMBERS_LEAST);
    }
    for (int i = 0; i < settings->stage_count; i++) {
        const train_stage *stage = &settings->stages[i];
        const char *moves = settings->losses.interior.resample_every > 0
                                ? "losses.interior.resample_every"
                            : stage->targets == TARGETS_PHYSICS ? "targets: physics"
                            : stage->targets == TARGETS_BOTH    ? "targets: both"
                                                                : NULL;
        char others[160];
        optim_method_list(1u << OPTIM_NEEDS_GRADIENTS, 0, others, sizeof others);
        if (moves && !takes_batches(stage->optim.method)) {
            return train_refuse_stage(key, i, "optimizer", error,
                                      "%s needs the same members in every step, which %s changes; "
                                      "allowed: %s, or losses.interior.resample_every 0 and solved "
                                      "targets in all stages",
                                      optim_method_name(stage->optim.method), moves, others);
        }
    }
    return AD_OK;
}
