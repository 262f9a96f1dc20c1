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

/* ---- roadmaps -------------------------------------------------------------------------------- */

/* Configurations, and pairs of them between which the way is free. */
typedef struct ompl_roadmap {
    size_t nodes, edges;
    double *node;   /* [nodes][count] */
    uint64_t *edge; /* [edges][2] */
} ompl_roadmap;

/* Of so many configurations at random that are free, or fewer if they are rare; start and goal are
 * not read. The arrays are the caller's, also where it fails. */
ad_status ompl_roadmap_make(const ompl_search *search, size_t nodes, ompl_roadmap *result,
                            ad_error *error);

/* A roadmap for many searches. What is not known to be free is looked at when a way uses it, and
 * left out from then on if it is not; so is what searches add to it. */
typedef struct ompl_map ompl_map;

/* Of a roadmap whose numbers of nodes hold. */
ad_status ompl_map_create(const ompl_search *search, const ompl_roadmap *of, bool known,
                          ompl_map **result, ad_error *error);

/* As ompl_find, in place of the search's method. forget: nothing is known any more. */
ad_status ompl_map_find(ompl_map *map, const ompl_search *search, bool forget, double **way,
                        size_t *length, size_t *looked, ad_error *error);
void ompl_map_free(ompl_map *map); /* NULL is allowed */

#ifdef __cplusplus
}
#endif

#endif
