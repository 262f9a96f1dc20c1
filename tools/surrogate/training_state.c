/* Training of one-step models in a checkpoint. */
#include "tools/surrogate/training_internal.h"

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
    fit_put(&t->fit, file);
    history_put(&t->fit.rows, file);
    ad_status status = place ? checkpoint_write(file, place, error) : AD_OK;
    checkpoint_free(file);
    return status;
}

ad_status surrogate_training_restore(surrogate_training *t, const checkpoint *file, ad_error *error)
{
    ad_status status = fit_get(&t->fit, file, error);
    if (status == AD_OK && t->start) {
        status = checkpoint_get_doubles(file, "parameters", t->start, t->info.parameters, error);
    }
    if (!t->flow && !t->physics) {
        t->fit.state = FIT_OVER;
    }
    if (t->fit.state == FIT_OVER) { /* what is left is the model */
        optim_free(t->optimizer);
        t->optimizer = t->fit.by = NULL;
    }
    status = status == AD_OK ? fit_go_on(&t->fit, true, file, error) : status;
    return status == AD_OK ? fit_get_rows(&t->fit, file, error) : status;
}
