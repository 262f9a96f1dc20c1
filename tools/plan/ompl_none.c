/* ompl_shim.h where there is no OMPL. */
#include "tools/plan/ompl_shim.h"

bool ompl_is_built(void)
{
    return false;
}

static ad_status refuse(ad_error *error)
{
    return ad_fail(error, AD_BAD_ARGUMENT,
                   "planning needs OMPL: install libompl-dev and a C++ compiler, and build cpinn "
                   "again");
}

ad_status ompl_find(const ompl_search *search, double **way, size_t *length, size_t *looked,
                    ad_error *error)
{
    (void)search;
    *way = NULL;
    *length = *looked = 0;
    return refuse(error);
}

ad_status ompl_roadmap_make(const ompl_search *search, size_t nodes, ompl_roadmap *result,
                            ad_error *error)
{
    (void)search;
    (void)nodes;
    *result = (ompl_roadmap){.nodes = 0};
    return refuse(error);
}

ad_status ompl_map_create(const ompl_search *search, const ompl_roadmap *of, bool known,
                          ompl_map **result, ad_error *error)
{
    (void)search;
    (void)of;
    (void)known;
    *result = NULL;
    return refuse(error);
}

ad_status ompl_map_find(ompl_map *map, const ompl_search *search, bool forget, double **way,
                        size_t *length, size_t *looked, ad_error *error)
{
    (void)map;
    (void)forget;
    return ompl_find(search, way, length, looked, error);
}

void ompl_map_free(ompl_map *map)
{
    (void)map;
}
