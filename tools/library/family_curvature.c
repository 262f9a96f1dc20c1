/* Families whose networks say the curvature. */
#include "tools/library/family.h"

#include <stdlib.h>

typedef struct curvature_network {
    family_network *network;
    const experiment *e;
} curvature_network;

static ad_status run(void *context, size_t members, const double *parameters, double *curvature,
                     ad_error *error)
{
    curvature_network *x = context;
    return family_network_run(x->network, experiment_parameters(x->e), members, parameters,
                              curvature, error);
}

static void release(void *context)
{
    curvature_network *x = context;
    family_network_free(x->network);
    free(x);
}

ad_status cpinn_family_curvature(const experiment *e, cpinn_family_network *result, ad_error *error)
{
    curvature_network *x = calloc(1, sizeof *x);
    if (!x) {
        return ad_fail(error, AD_NO_MEMORY, "out of memory for a family");
    }
    x->e = e;
    ad_status status =
        family_network_create(targets_family(e->targets), e->mlp, e->pool, &x->network, error);
    if (status != AD_OK) {
        release(x);
        return status;
    }
    *result = (cpinn_family_network){.context = x, .curvature = run, .free = release};
    return AD_OK;
}
