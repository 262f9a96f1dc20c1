/* Distances from a surface at the nodes of a grid, between which they are interpolated: some tens
 * of nanoseconds for one, for searches. Kept in a file beside the surface's. */
#ifndef ENVIRONMENT_DISTANCE_GRID_H
#define ENVIRONMENT_DISTANCE_GRID_H

#include "tools/environment/environment.h"

typedef struct distance_grid {
    double low[3], cell; /* m */
    double surface_low[3], surface_high[3];
    bool inside;     /* what is free is within the surface */
    size_t count[3]; /* of nodes */
    double *value;   /* [count[2]][count[1]][count[0]], m */
    bool was_kept;   /* in a file, from which it is */
} distance_grid;

/* About so many nodes. file: where it is kept, read if it is of this surface, side and number,
 * else written, if that can be; NULL: nowhere. AD_NO_MEMORY. */
ad_status distance_grid_create(const environment *of, environment_side side, size_t nodes,
                               const char *file, distance_grid **result, ad_error *error);
void distance_grid_free(distance_grid *of); /* NULL is allowed */

/* Of p, within distance_grid_error of the distance. Beyond the grid negative where what is free is
 * within the surface, else no more than the distance. */
double distance_grid_at(const distance_grid *of, const double p[3]);

/* Distances differ by no more than the points do, so an interpolated one is off by no more than the
 * mean square distance of the eight nodes, weighted: at most half a cell's diagonal. */
double distance_grid_error(const distance_grid *of);

#endif
