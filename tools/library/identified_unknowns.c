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

void cpinn_unknowns_free(cpinn_unknowns *x)
{
    if (x) {
        config_free(x->settings);
        free(x);
    }
}

ad_status cpinn_identify_file(const char *path, int count, const char *const *overrides,
                              int threads, cpinn_unknowns **result, ad_error *error)
{
    AD_LEAVE_HOST;
    cpinn_unknowns *x = calloc(1, sizeof *x);
    *result = NULL;
    if (!x) {
        return ad_fail(error, AD_NO_MEMORY, "out of memory for unknowns");
    }
    ad_status status = prepare_read(path, NULL, count, overrides, &x->settings, error);
    if (status == AD_OK) {
        status = config_identify(x->settings, threads, &x->found, error);
    }
    if (status != AD_OK) {
        cpinn_unknowns_free(x);
        return status;
    }
    identified_verdict(&x->found, &x->settings->scene, &x->verdict);
    *result = x;
    return AD_OK;
}

int cpinn_unknowns_count(const cpinn_unknowns *x)
{
    return x->found.count;
}

static bool is_one(const cpinn_unknowns *x, int unknown)
{
    return unknown >= 0 && unknown < x->found.count;
}

const char *cpinn_unknowns_name(const cpinn_unknowns *x, int unknown)
{
    const scene *open = &x->settings->scene;
    return is_one(x, unknown) ? open->parameters[scene_known_count(open) + unknown].name : "";
}

double cpinn_unknowns_value(const cpinn_unknowns *x, int unknown)
{
    return is_one(x, unknown) ? x->found.value[unknown] : NAN;
}

double cpinn_unknowns_deviation(const cpinn_unknowns *x, int unknown)
{
    return is_one(x, unknown) ? x->found.deviation[unknown] : NAN;
}

double cpinn_unknowns_correlation(const cpinn_unknowns *x, int one, int other)
{
    return is_one(x, one) && is_one(x, other) ? x->found.information.correlation[one][other] : NAN;
}

double cpinn_unknowns_chi_squared(const cpinn_unknowns *x)
{
    return x->found.chi_squared;
}

double cpinn_unknowns_freedom(const cpinn_unknowns *x)
{
    return (double)x->found.residuals - x->found.count;
}

const verdict *cpinn_unknowns_verdict(const cpinn_unknowns *x)
{
    return &x->verdict;
}
