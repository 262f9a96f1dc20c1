/* Are the derivatives that a scene's equations use the derivatives of its unknowns? Each one, made
 * by the transforms of the tape, against central differences of the derivative one order lower, at
 * shifted points. */
#ifndef PHYSICS_LEARN_DERIVATIVE_CHECK_H
#define PHYSICS_LEARN_DERIVATIVE_CHECK_H

#include "nn/nn.h"
#include "physics/learn/model.h"

enum { DERIVATIVE_NAME_MAX = 16 };

/* Dimensionless, but for the place. */
typedef struct derivative_check {
    char name[DERIVATIVE_NAME_MAX]; /* "r_tt" */
    double worst_error;             /* |difference - derivative| / largest |derivative| */
    int worst_row;
    double worst_at[DOMAIN_COORDINATES_MAX]; /* the coordinates, in SI units */
    double worst_derivative;
    double worst_difference;
} derivative_check;

/* `name`: a field of the model, an underscore, then the coordinates (of one letter) as often as
 * differentiated, in their order ("r_sst"). At `points` points of window `window` drawn from `rng`,
 * for parameters x of its network, which starts from `start` (window_state.h; the first has none).
 * The differences are of sixth order; of a ladder of steps from 6e-3 to 2.7e-6 of the range the
 * best counts at each point, since how fast the functions vary is not known and a formula of the
 * scene may have a kink between shifted points: a wrong derivative fits none. AD_BAD_ARGUMENT: not
 * such a name; AD_NOT_FINITE: a derivative is not. */
ad_status derivative_check_run(const physics_model *m, int window, const double *start,
                               const nn_mlp *mlp, const double *x, const char *name, size_t points,
                               nn_rng *rng, ad_pool *pool, derivative_check *check,
                               ad_error *error);

#endif
