/* environment.h where there is no Embree: nothing is ever made. */
#include "tools/environment/environment.h"

#include <math.h>

bool environment_is_built(void)
{
    return false;
}

ad_status environment_create(surface *of, environment_side side, environment **result,
                             ad_error *error)
{
    (void)side;
    *result = NULL;
    surface_free(of);
    return ad_fail(error, AD_BAD_ARGUMENT,
                   "distances from surfaces need Embree: install libembree-dev and build cpinn "
                   "again");
}

void environment_free(environment *of)
{
    (void)of;
}

const surface *environment_surface(const environment *of)
{
    (void)of;
    return NULL;
}

double environment_distance(const environment *of, const double p[3], double within)
{
    (void)of, (void)p, (void)within;
    return NAN;
}

double environment_slope(const environment *of, const double p[3], double slope[3])
{
    (void)of, (void)p;
    slope[0] = slope[1] = slope[2] = NAN;
    return NAN;
}

double environment_segment(const environment *of, const double a[3], const double b[3],
                           double within)
{
    (void)of, (void)a, (void)b, (void)within;
    return NAN;
}

bool environment_is_beyond(const environment *of, const double a[3], const double b[3],
                           double distance)
{
    (void)of, (void)a, (void)b, (void)distance;
    return false;
}

double environment_winding(const environment *of, const double p[3])
{
    (void)of, (void)p;
    return NAN;
}
