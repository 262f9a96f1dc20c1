/* Unknowns from measurements among which some are far off. */
#ifndef TOOLS_TRAIN_ROBUST_H
#define TOOLS_TRAIN_ROBUST_H

#include "tools/train/identify.h"

/* As identify, of sets [sets] of which `robust` [sets] says where the logarithm of Cauchy's
 * distribution is least and not squares: log(1 + (d/c)^2), d the distance of a row over its noise,
 * c = 2.385 times what the noise is found to be. For normal errors that is as good as squares but
 * for 5 % (Holland and Welsch, Communications in Statistics A6 (1977) 813). The noise is that whose
 * distances have the median of these, found anew at every step, as are the weights of rows
 * 1 / (1 + (d/c)^2). Deviations are those of such an estimate (Huber, Robust Statistics,
 * 1981, 7.6), and the noise counts as known up to a factor. Unless the search begins near to it, it
 * is least squares that say where. */
ad_status identify_robust(const scene *open, int sets, const solve_measured *measured,
                          const bool *robust, const identify_settings *settings, identified *result,
                          ad_error *error);

#endif
