/* A robot at rest: its equilibria for held inputs, which inputs bring a place of it nearest to a
 * point, and where a path can be followed at rest. By the reduced rod. */
#ifndef CONTROL_EQUILIBRIA_H
#define CONTROL_EQUILIBRIA_H

#include "physics/chain/reduced.h"
#include "tools/control/control_settings.h"

typedef struct equilibria equilibria;

/* Of the place s (m) of the rod, with control->low, high as limits of the inputs. */
ad_status equilibria_create(const scene *of, const surrogate_settings *model,
                            const control_settings *control, equilibria **result, ad_error *error);
void equilibria_free(equilibria *equilibria); /* NULL is allowed */

/* Inputs [parameter_count] with all in the middle: of limits, or of the range. */
void equilibria_middle(const equilibria *equilibria, double *inputs);

/* state [states] (or NULL), a whole one (physics/chain/reduced.h): the equilibrium for inputs that
 * were held for long, sought from the last one that was found. */
ad_status equilibria_settle(equilibria *equilibria, const double *inputs, double *state,
                            ad_error *error);

/* by [states][count of `which`]: derivatives of that state by the inputs `which`, by difference
 * quotients. */
ad_status equilibria_derivatives(equilibria *equilibria, const double *inputs, const double *state,
                                 int count, const int *which, double *by, ad_error *error);

/* By how much, m, places along the path are off where the place can be at rest. */
typedef struct equilibria_reach {
    double rms, worst; /* also between set points */
    double held;       /* rms; of set points alone where there are some */
} equilibria_reach;

/* Fills in centre, normal and heights of a circle or an eight where they are open. */
ad_status equilibria_place_task(equilibria *equilibria, control_task *task, equilibria_reach *found,
                                ad_error *error);

#endif
