/* Distances in doubles. Needs no library and allocates nothing: exported C has this very text. */
#ifndef PHYSICS_NUMERICS_TRIANGLE_H
#define PHYSICS_NUMERICS_TRIANGLE_H

/* Where the nearest point of a triangle lies: at corner 0, 1, 2, on the edge from such a corner to
 * the next, within. */
typedef enum triangle_part {
    TRIANGLE_CORNER = 0,
    TRIANGLE_EDGE = 3,
    TRIANGLE_WITHIN = 6
} triangle_part;

/* Of p from a triangle; nearest [3]. part: one of the above and, of the first two, which. */
double triangle_distance(const double *const corners[3], const double p[3], double nearest[3],
                         int *part);

/* Of the line from a to b from it; 0: they meet. */
double triangle_segment_distance(const double *const corners[3], const double a[3],
                                 const double b[3]);

/* Whether it is certainly further from the line than that: by its plane, or by the distance of the
 * line's middle; quick. */
int triangle_is_beyond(const double *const corners[3], const double a[3], const double b[3],
                       double distance);

/* Of the tetrahedron with p, times six; positive on the side from which they are counterclockwise.
 */
double triangle_volume(const double *const corners[3], const double p[3]);

#endif
