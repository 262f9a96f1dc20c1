/* Distances at the nodes of a grid of cubes, between which they are interpolated. */
#ifndef PHYSICS_NUMERICS_DISTANCE_FIELD_H
#define PHYSICS_NUMERICS_DISTANCE_FIELD_H

typedef struct distance_field {
    int count[3];                   /* of nodes */
    int inside;                     /* 1: what is free is within the surface; 0: around it */
    double low[3], cell;            /* m: the first node, from one to the next */
    double box_low[3], box_high[3]; /* around the surface, less than a cell within the grid */
    const float *value;             /* [count[2]][count[1]][count[0]], m; negative: not free */
} distance_field;

/* Of p, m. Beyond the grid negative where what is free is within the surface, else no more than the
 * distance: that from the box. */
double distance_field_at(const distance_field *field, const double p[3]);

/* No more than the distance of p, m, within the grid: by each node around it, whose distance
 * differs by no more than it is away. Beyond the grid as above. */
double distance_field_least(const distance_field *field, const double p[3]);

#endif
