/* Planners of OMPL for configurations in a box, from C. What is found depends on the seed and on
 * nothing else: a search ends after so many configurations, not after a time. */
#ifndef PLAN_OMPL_SHIM_H
#define PLAN_OMPL_SHIM_H

#include "autodiff/error.h"
#include "tools/plan/plan_settings.h"

#include <stddef.h>

#ifdef __cplusplus
extern "C" {
#endif

typedef struct ompl_search {
    int count;                /* of variables */
    const double *low, *high; /* [count] */
    bool (*is_free)(void *context, const double *configuration);
    void *context;
    double step; /* of what is looked at on a way, part of the ranges */
    plan_method method;
    size_t states; /* that are looked at, at most; more to smooth what is found */
    int64_t seed;
    const double *start; /* [count] */
    size_t goals;
    const double *goal; /* [goals][count], one of which is to be reached */
} ompl_search;

/* Whether this build has OMPL. */
bool ompl_is_built(void);

/* way [length][count], owned by the caller; NULL and 0: none was found. looked: configurations that
 * were asked for. AD_BAD_ARGUMENT: without OMPL; AD_NO_MEMORY. One call at a time. */
ad_status ompl_find(const ompl_search *search, double **way, size_t *length, size_t *looked,
                    ad_error *error);

#ifdef __cplusplus
}
#endif

#endif
