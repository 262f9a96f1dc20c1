/* Training of curves in time. */
#include "tools/surrogate/training_internal.h"

#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

/* Beginnings in an evaluation of Adam, and of methods that need the same function again. */
enum { BATCH = 128, WHOLE = 4000, HELD = 500 };

static ad_status make_loss(surrogate_training *t, const excitation_rollouts *motions,
                           const physics_loss_settings *settings, physics_loss **loss,
                           ad_error *error)
{
    physics_loss_free(*loss);
    return physics_loss_create(t->open, t->settings->modes, motions, &t->curve, settings, t->pool,
                               loss, error);
}

ad_status surrogate_make_physics(surrogate_training *t, ad_error *error)
{
    const optim_method method = t->training->stages[t->fit.at.stage].optim.method;
    const bool batches = optim_method_needs(method) == OPTIM_NEEDS_GRADIENTS;
    physics_loss_settings settings = {.most = HELD, .seed = t->training->seed};
    ad_status status = make_loss(t, &t->held_motions, &settings, &t->held_loss, error);
    settings.batch = batches ? BATCH : 0;
    settings.most = batches ? 0 : WHOLE;
    return status == AD_OK ? make_loss(t, &t->motions, &settings, &t->physics, error) : status;
}

double surrogate_held_error(surrogate_training *t, const double *parameters)
{
    double value;
    return physics_loss_evaluate(t->held_loss, parameters, &value, NULL) == 0 ? value : NAN;
}

static ad_status allocate(surrogate_training *t, ad_error *error)
{
    const nn_mlp_settings *network = &t->training->network;
    t->curve = (decoupled){.states = t->motions.states,
                           .inputs = t->motions.inputs,
                           .ramps = t->settings->hold == SURROGATE_RAMP,
                           .terms = t->settings->terms,
                           .step = t->settings->step,
                           .layers = network->hidden_count};
    for (int i = 0; i < t->curve.layers; i++) {
        t->curve.width[i] = network->hidden[i];
    }
    t->info.parameters = decoupled_parameters(&t->curve);
    t->numbers = calloc(decoupled_numbers(&t->curve), sizeof *t->numbers);
    t->start = calloc(t->info.parameters, sizeof *t->start);
    t->curve.numbers = t->numbers;
    t->step.states = t->curve.states; /* for those who ask for sizes */
    t->step.inputs = t->curve.inputs;
    return t->numbers && t->start
               ? AD_OK
               : ad_fail(error, AD_NO_MEMORY, "out of memory for a one-step model");
}

ad_status surrogate_prepare_curve(surrogate_training *t, int steps, int rollouts, int held,
                                  ad_error *error)
{
    const excitation_settings first = surrogate_excitation(t, steps, 0, rollouts);
    const excitation_settings other = surrogate_excitation(t, steps, rollouts, held);
    ad_status status = excitation_run(t->open, &first, t->pool, &t->motions, error);
    status = status == AD_OK ? excitation_run(t->open, &other, t->pool, &t->held_motions, error)
                             : status;
    status = status == AD_OK ? allocate(t, error) : status;
    if (status != AD_OK) {
        return status;
    }
    physics_prepare(t->open, &t->motions, t->training->seed, &t->curve, t->numbers);
    memcpy(t->start, t->numbers + decoupled_numbers(&t->curve) - t->info.parameters,
           t->info.parameters * sizeof *t->start);
    for (int i = 0; i < t->motions.count; i++) {
        t->info.solved += (size_t)t->motions.done[i];
    }
    t->held_linear = 1;
    snprintf(t->info.frame, sizeof t->info.frame,
             "curves in time: damped sines beside the state; no frame; losses: over that of states "
             "that stay");
    return AD_OK;
}
