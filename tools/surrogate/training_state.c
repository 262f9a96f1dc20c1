/* Training of one-step models in a checkpoint. */
#include "tools/surrogate/training_internal.h"

#include <stdio.h>
#include <stdlib.h>
#include <string.h>

ad_status surrogate_training_put(void *of, checkpoint *file, ad_error *error)
{
    surrogate_training *t = of;
    if (!surrogate_training_step_of(t)) {
        return ad_fail(error, AD_NOT_FINITE, "the output layer of the model is not finite");
    }
    surrogate_put(&t->step, t->shape, file);
    if (t->settings->kind == SURROGATE_POLYNOMIAL) {
        surrogate_put_nodes(&t->step, t->inner[0].numbers, file);
    }
    checkpoint_put_doubles(file, "parameters", t->start, 1, &t->info.parameters);
    return AD_OK;
}

ad_status surrogate_training_get(void *of, const checkpoint *file, bool *at_work, ad_error *error)
{
    surrogate_training *t = of;
    (void)at_work;
    if (!t->flow) {
        t->fit.state = FIT_OVER;
    }
    if (t->fit.state == FIT_OVER) { /* what is left is the model */
        optim_free(t->optimizer);
        t->optimizer = t->fit.by = NULL;
    }
    return t->start
               ? checkpoint_get_doubles(file, "parameters", t->start, t->info.parameters, error)
               : AD_OK;
}
