/* Training of one-step models in a checkpoint. */
#include "tools/surrogate/training_internal.h"
#include "tools/train/clock.h"
#include "tools/train/stage_optimizer.h"

#include <stdio.h>
#include <stdlib.h>
#include <string.h>

ad_status surrogate_training_save(surrogate_training *t, const char *yaml, const file_place *place,
                                  ad_error *error)
{
    checkpoint *file = checkpoint_create(CPINN_VERSION);
    const surrogate_step *m = surrogate_training_step_of(t);
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
    const double now = train_seconds();
    const optimizer_place at = {t->info.step, t->info.stage, t->info.stage_step, now - t->began,
                                t->info.done ? 0 : now - t->stage_began};
    optimizer_put(t->info.done ? NULL : t->optimizer, &at, file);
    history_put(&t->rows, file);
    ad_status status = place ? checkpoint_write(file, place, error) : AD_OK;
    checkpoint_free(file);
    return status;
}

ad_status surrogate_training_restore(surrogate_training *t, const checkpoint *file, ad_error *error)
{
    optimizer_place at;
    ad_status status = optimizer_get_place(file, t->training->stage_count, &at, error);
    if (status == AD_OK && t->start) {
        status = checkpoint_get_doubles(file, "parameters", t->start, t->info.parameters, error);
    }
    status = status == AD_OK ? history_get(&t->rows, file, error) : status;
    if (status != AD_OK) {
        return status;
    }
    t->info.step = at.step;
    t->info.stage = (int)at.stage;
    t->info.stage_step = at.stage_step;
    t->info.done = (!t->flow && !t->physics) || t->info.stage == t->training->stage_count;
    t->began = train_seconds() - at.seconds;
    if (t->rows.count > 0) {
        t->info.loss = history_value(&t->rows, t->rows.count - 1, "loss");
        t->info.held_out = history_value(&t->rows, t->rows.count - 1, "held_out");
    }
    if (t->info.done) { /* what is left is the model */
        optim_free(t->optimizer);
        t->optimizer = NULL;
        return AD_OK;
    }
    status = surrogate_training_make_optimizer(t, error);
    t->stage_began -= at.stage_seconds;
    return status == AD_OK ? optimizer_get(t->optimizer, file, error) : status;
}
