/* What a trained network leaves out of balance, and how far it is off, by the equations of the
 * classical solvers. */
#ifndef TOOLS_TRAIN_LEARNT_BALANCE_H
#define TOOLS_TRAIN_LEARNT_BALANCE_H

#include "tools/train/experiment.h"

/* NaN: of another scene, or not known. */
typedef struct learnt_balance {
    double loads;            /* at rest, under all loads: solve_balance (physics/solve/solve.h) */
    double energy, momentum; /* of a rod's motion: physics/solve/motion_balance.h */
} learnt_balance;

/* Of the parameters at hand, in motion to the end of the window at work; of a family of the member
 * with these values [parameter_count], NULL: of the middle one. */
learnt_balance experiment_balance(const experiment *e, const double *member);

/* The estimated error (physics/solve/error_estimate.h) of the parameters at hand, of a member as
 * above. NaN: not known, and `why` says why not. AD_NO_MEMORY, errors of a field. */
ad_status experiment_error(const experiment *e, const double *member, double *estimate,
                           ad_error *why);

/* The estimate that its checkpoint keeps; where there is none, as of training that is not over, of
 * the middle member as above. NaN of a family in the strain form, each of whose answers has one. */
ad_status experiment_kept_error(const experiment *e, const checkpoint *file, double *estimate,
                                ad_error *why);

#endif
