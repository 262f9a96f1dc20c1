/* Unknowns of a scene that training has found beside the network. */
#ifndef TOOLS_TRAIN_TRAINER_UNKNOWNS_H
#define TOOLS_TRAIN_TRAINER_UNKNOWNS_H

#include "tools/train/identify.h"
#include "tools/train/trainer.h"

/* What the scene's unknowns are now and how well they are known, from the normal equations of
 * network and unknowns together; count 0 where there are none. Needs room for two matrices of all
 * parameters. AD_NO_MEMORY, AD_NOT_FINITE. */
ad_status trainer_unknowns(trainer *t, identified *result, ad_error *error);

#endif
