/* ompl_shim.h where there is no OMPL. */
#include "tools/plan/ompl_shim.h"

bool ompl_is_built(void)
{
    return false;
}

ad_status ompl_find(const ompl_search *search, double **way, size_t *length, size_t *looked,
                    ad_error *error)
{
    (void)search;
    *way = NULL;
    *length = *looked = 0;
    return ad_fail(error, AD_BAD_ARGUMENT,
                   "planning needs OMPL: install libompl-dev and a C++ compiler, and build cpinn "
                   "again");
}
