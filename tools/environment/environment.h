/* What a robot must not touch: a surface, and exact distances from it. Embree, which has floats,
 * finds the triangles that may be nearest; their bounds and the radius of the search are rounded
 * outwards, and each is measured in doubles. So what is returned is what a search over all
 * triangles in doubles returns, but for rounding of its last digits. */
#ifndef ENVIRONMENT_ENVIRONMENT_H
#define ENVIRONMENT_ENVIRONMENT_H

#include "tools/environment/environment_settings.h"
#include "tools/environment/surface.h"

typedef struct environment environment;

/* Whether this build has Embree. */
bool environment_is_built(void);

/* Takes the surface, also where it fails; a side other than ENVIRONMENT_ANY asks for a closed one.
 * AD_BAD_INPUT as surface_check_closed; AD_BAD_ARGUMENT: without Embree; AD_NO_MEMORY. */
ad_status environment_create(surface *of, environment_side side, environment **result,
                             ad_error *error);
void environment_free(environment *of); /* NULL is allowed */

/* The surface of a file, in the scene's axes. Errors of surface_read. */
ad_status surface_open(const environment_settings *settings, surface **result, ad_error *error);

/* Distances from it, for a robot of that length. Errors of surface_read,
 * surface_check_size and environment_create. */
ad_status environment_open(const environment_settings *settings, double length,
                           environment **result, ad_error *error);
const surface *environment_surface(const environment *of);

/* Of p from the surface; negative: on the wrong side, by the normal of Baerentzen and Aanaes
 * (2005), that of corners weighted by angles. within: a distance that it certainly does not exceed,
 * or INFINITY; the answer is the same, sooner. NaN: p is
 * no place. Any thread. */
double environment_distance(const environment *of, const double p[3], double within);

/* And its derivative by p, of length 1: away from the nearest place, or on the surface along the
 * normal there, which a surface without sides has none of: 0. Of several places that are nearest
 * it is that by one of them. */
double environment_slope(const environment *of, const double p[3], double slope[3]);

/* Of the line from a to b, 0 where it meets the surface; negative as of a. */
double environment_segment(const environment *of, const double a[3], const double b[3],
                           double within);

/* Whether all of that line is further from the surface than `distance`, on either side; quick. */
bool environment_is_beyond(const environment *of, const double a[3], const double b[3],
                           double distance);

/* How often the surface goes around p: 1 inside of a closed one, 0 outside; by the solid angles of
 * all triangles (van Oosterom and Strackee 1983). Slow, and right also of surfaces that cut
 * themselves. */
double environment_winding(const environment *of, const double p[3]);

#endif
