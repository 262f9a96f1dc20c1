/* Whether the motion that networks have learnt conserves energy and momentum. */
#ifndef TOOLS_TRAIN_MOTION_BALANCE_H
#define TOOLS_TRAIN_MOTION_BALANCE_H

#include "physics/solve/motion_balance.h"
#include "tools/train/experiment.h"

#ifdef __cplusplus
extern "C" {
#endif

/* Of a rod's motion, to the end of the window at work; NaN of all else, and where it is not known:
 * physics/solve/motion_balance.h. */
motion_balance experiment_motion_balance(const experiment *e);

#ifdef __cplusplus
}
#endif

#endif
