/* Distances from a surface at the nodes of a grid, between which they are interpolated: some tens
 * of nanoseconds for one, for searches. Kept in a file beside the surface's. */
#ifndef ENVIRONMENT_DISTANCE_GRID_H
#define ENVIRONMENT_DISTANCE_GRID_H

#include "physics/numerics/distance_field.h"
#include "tools/environment/environment.h"

typedef struct distance_grid {
    distance_field field; /* of the values; within distance_grid_error of the distance */
    float *value;
    bool was_kept; /* in a file, from which it is */
} distance_grid;

/* About so many nodes. file: where it is kept, read if it is of this surface, side and number,
 * else written, if that can be; NULL: nowhere. AD_NO_MEMORY. */
ad_status distance_grid_create(const environment *of, environment_side side, size_t nodes,
                               const char *file, distance_grid **result, ad_error *error);
/* The surface of settings, and its grid, which is fine enough for searches and kept beside the file
 * as NAME.distances.h5. What was made is the caller's, also where it fails. Errors of
 * environment_open and distance_grid_create. */
ad_status distance_grid_open(const environment_settings *of, double length, environment **around,
                             distance_grid **grid, ad_error *error);
void distance_grid_free(distance_grid *of); /* NULL is allowed */

/* Distances differ by no more than the points do, so an interpolated one is off by no more than the
 * mean square distance of the eight nodes, weighted: at most half a cell's diagonal; and what is
 * kept of a distance is rounded to a float. */
double distance_grid_error(const distance_grid *of);

#endif
