/* How far a robot that is thick certainly stays from a surface: of one shape of which points are
 * known, and of all shapes between two. Each part that is taken off is told. */
#ifndef ENVIRONMENT_CLEARANCE_H
#define ENVIRONMENT_CLEARANCE_H

#include "tools/environment/environment.h"

/* m, of the place that has least. */
typedef struct clearance {
    double distance;               /* of the lines between points from the surface */
    double radius;                 /* of the robot */
    double distance_error;         /* rounding of distances */
    double shape_error;            /* of points */
    double unknown;                /* what unknown parameters move a point at most */
    double between_points;         /* the rod is no further from the line than so */
    double between_configurations; /* what the way from one to the next takes off */
    double free;                   /* what is left */
    double at;                     /* s of that place */
} clearance;

/* A shape. */
typedef struct clearance_shape {
    size_t points;
    const double *s;      /* [points] m, ascending */
    const double *r;      /* [points][3] */
    const double *speed;  /* [points] |dr/ds| */
    double error;         /* m: points are off by at most so much */
    const double *spread; /* [points] m, of unknown parameters; NULL: there are none */
    double radius;        /* of the robot, m */
    double from;          /* s from which on it counts, m; one of the points */
} clearance_shape;

/* Of the pieces between points, free [points - 1], infinite where they do not count, and the least
 * of them, which is 0 or less where the robot may touch. Of a piece of length l whose ends are
 * apart by c, a point is on an ellipsoid around them, and no further from the line than sqrt(l^2 -
 * c^2)/2. l is the distance of its points on the unstressed rod times the larger speed and the
 * difference of the two. */
void clearance_of_shape(const environment *of, const clearance_shape *shape, double *free,
                        clearance *least);

/* The least of all shapes on the way from a to b, of which each piece has free a, b [pieces] and no
 * point travels more than travel [pieces]: one that is x on the way from a and y from b is as free
 * as a less x, and as b less y. */
double clearance_between(size_t pieces, const double *a, const double *b, const double *travel);

#endif
