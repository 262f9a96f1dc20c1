/* Unknown numbers of a scene, found from its data. */
#include "tools/library/cpinn.h"
#include "tools/prepare/config_experiment.h"

#include "autodiff/host.h"
#include <math.h>
#include <stdlib.h>

struct cpinn_unknowns {
    config *settings; /* holds the names */
    identified found;
    verdict verdict;
};

void cpinn_unknowns_free(cpinn_unknowns *unknowns)
{
    if (unknowns) {
        config_free(unknowns->settings);
        free(unknowns);
    }
}

ad_status cpinn_identify_file(const char *path, int count, const char *const *overrides,
                              int threads, cpinn_unknowns **result, ad_error *error)
{
    AD_LEAVE_HOST;
    cpinn_unknowns *unknowns = calloc(1, sizeof *unknowns);
    *result = NULL;
    if (!unknowns) {
        return ad_fail(error, AD_NO_MEMORY, "out of memory for unknowns");
    }
    ad_status status = prepare_read(path, NULL, count, overrides, &unknowns->settings, error);
    if (status == AD_OK) {
        status = config_identify(unknowns->settings, threads, NULL, NULL, &unknowns->found, error);
    }
    if (status != AD_OK) {
        cpinn_unknowns_free(unknowns);
        return status;
    }
    identified_verdict(&unknowns->found, &unknowns->settings->scene, &unknowns->verdict);
    *result = unknowns;
    return AD_OK;
}

int cpinn_unknowns_count(const cpinn_unknowns *unknowns)
{
    return unknowns->found.count;
}

static bool is_one(const cpinn_unknowns *unknowns, int unknown)
{
    return unknown >= 0 && unknown < unknowns->found.count;
}

const char *cpinn_unknowns_name(const cpinn_unknowns *unknowns, int unknown)
{
    const scene *open = &unknowns->settings->scene;
    return is_one(unknowns, unknown) ? open->parameters[scene_known_count(open) + unknown].name
                                     : "";
}

double cpinn_unknowns_value(const cpinn_unknowns *unknowns, int unknown)
{
    return is_one(unknowns, unknown) ? unknowns->found.value[unknown] : NAN;
}

double cpinn_unknowns_deviation(const cpinn_unknowns *unknowns, int unknown)
{
    return is_one(unknowns, unknown) ? unknowns->found.deviation[unknown] : NAN;
}

double cpinn_unknowns_correlation(const cpinn_unknowns *unknowns, int one, int other)
{
    return is_one(unknowns, one) && is_one(unknowns, other)
               ? unknowns->found.information.correlation[one][other]
               : NAN;
}

double cpinn_unknowns_chi_squared(const cpinn_unknowns *unknowns)
{
    return unknowns->found.chi_squared;
}

double cpinn_unknowns_freedom(const cpinn_unknowns *unknowns)
{
    return (double)unknowns->found.residuals - unknowns->found.count;
}

const verdict *cpinn_unknowns_verdict(const cpinn_unknowns *unknowns)
{
    return &unknowns->verdict;
}
