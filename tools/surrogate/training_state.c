/* Training of one-step models in a checkpoint. */
#include "tools/surrogate/training_internal.h"
#include "tools/train/clock.h"

#include <stdio.h>
#include <stdlib.h>
#include <string.h>

enum { ITEM_NAME = 96 };

ad_status surrogate_training_save(surrogate_training *t, const char *yaml, const file_place *place,
                                  ad_error *error)
{
    checkpoint *file = checkpoint_create(CPINN_VERSION);
    const surrogate_step *m = surrogate_training_step_of(t);
    optim_array arrays[OPTIM_STATE_CAPACITY];
    char names[OPTIM_STATE_CAPACITY][ITEM_NAME];
    if (!file) {
        return ad_fail(error, AD_NO_MEMORY, "out of memory for a checkpoint");
    }
    if (!m) {
        checkpoint_free(file);
        return ad_fail(error, AD_NOT_FINITE, "the output layer of the model is not finite");
    }
    checkpoint_put_text(file, "scene/yaml", yaml);
    if (t->physics) {
        surrogate_put_curve(&t->curve, t->shape, file);
    } else {
        surrogate_put(&t->step, t->shape, file);
    }
    if (t->settings->kind == SURROGATE_POLYNOMIAL) {
        surrogate_put_nodes(&t->step, t->inner[0].numbers, file);
    }
    checkpoint_put_doubles(file, "parameters", t->start, 1, &t->info.parameters);
    checkpoint_put_integer(file, "training/step", t->info.step);
    checkpoint_put_integer(file, "training/stage", t->info.stage);
    checkpoint_put_integer(file, "training/stage_step", t->info.stage_step);
    checkpoint_put_double(file, "training/seconds", train_seconds() - t->began);
    const int count = t->optimizer && !t->info.done ? optim_state(t->optimizer, arrays) : 0;
    for (int i = 0; i < count; i++) {
        snprintf(names[i], ITEM_NAME, "optimizer/%s", arrays[i].name);
        checkpoint_put_doubles(file, names[i], arrays[i].data, 1, &arrays[i].count);
    }
    history_put(&t->rows, file);
    ad_status status = place ? checkpoint_write(file, place, error) : AD_OK;
    checkpoint_free(file);
    return status;
}

/* The optimiser of the stage at work. */
static ad_status restore_optimizer(surrogate_training *t, const checkpoint *file, ad_error *error)
{
    optim_array arrays[OPTIM_STATE_CAPACITY];
    ad_status status = surrogate_training_make_optimizer(t, error);
    const int count = status == AD_OK ? optim_state(t->optimizer, arrays) : 0;
    for (int i = 0; status == AD_OK && i < count; i++) {
        char name[ITEM_NAME];
        snprintf(name, sizeof name, "optimizer/%s", arrays[i].name);
        status = checkpoint_get_doubles(file, name, arrays[i].data, arrays[i].count, error);
    }
    const char *why = status == AD_OK ? optim_state_check(t->optimizer) : NULL;
    return why ? ad_fail(error, AD_BAD_INPUT, "checkpoint: %s", why) : status;
}

ad_status surrogate_training_restore(surrogate_training *t, const checkpoint *file, ad_error *error)
{
    int64_t stage = 0;
    double seconds = 0;
    ad_status status = checkpoint_get_int64(file, "training/step", &t->info.step, 1, error);
    if (status == AD_OK) {
        status = checkpoint_get_int64(file, "training/stage", &stage, 1, error);
    }
    if (status == AD_OK) {
        status = checkpoint_get_int64(file, "training/stage_step", &t->info.stage_step, 1, error);
    }
    if (status == AD_OK) {
        status = checkpoint_get_doubles(file, "training/seconds", &seconds, 1, error);
    }
    if (status == AD_OK && (stage < 0 || stage > t->training->stage_count || t->info.step < 0)) {
        status = ad_fail(error, AD_BAD_INPUT, "checkpoint: training/stage is %lld of %d",
                         (long long)stage, t->training->stage_count);
    }
    if (status == AD_OK && t->start) {
        status = checkpoint_get_doubles(file, "parameters", t->start, t->info.parameters, error);
    }
    status = status == AD_OK ? history_get(&t->rows, file, error) : status;
    if (status != AD_OK) {
        return status;
    }
    t->info.stage = (int)stage;
    t->info.done = (!t->flow && !t->physics) || t->info.stage == t->training->stage_count;
    t->began = train_seconds() - seconds;
    if (t->rows.count > 0) {
        t->info.loss = history_value(&t->rows, t->rows.count - 1, "loss");
        t->info.held_out = history_value(&t->rows, t->rows.count - 1, "held_out");
    }
    if (t->info.done) { /* what is left is the model */
        optim_free(t->optimizer);
        t->optimizer = NULL;
        return AD_OK;
    }
    return restore_optimizer(t, file, error);
}
