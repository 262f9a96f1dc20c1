#include "tools/environment/clearance.h"

#include "physics/numerics/quaternion.h"

#include <math.h>

/* Both ends may be off, and so nearer to each other. */
static double off_line(const clearance_shape *shape, size_t piece)
{
    const double *const v = &shape->speed[piece];
    const double length =
        (shape->s[piece + 1] - shape->s[piece]) * (fmax(v[0], v[1]) + fabs(v[1] - v[0]));
    const double *const r = &shape->r[3 * piece];
    const double nearer = vector_distance(r, r + 3) - 2 * shape->error, between = fmax(nearer, 0);
    if (!(nearer <= length * (1 + 1e-9))) {
        return INFINITY; /* no numbers, or a rod that is shorter than the line: speeds are wrong */
    }
    return sqrt(fmax((length - between) * (length + between), 0)) / 2;
}

/* Of a piece, where the spread bends a fourth of its second difference more: as much as twice what
 * a parabola has between points. */
static double spread_of(const clearance_shape *shape, size_t piece)
{
    const double *const d = shape->spread;
    if (!d) {
        return 0;
    }
    const size_t last = shape->points - 1;
    const double before = piece > 0 ? fabs(d[piece - 1] - 2 * d[piece] + d[piece + 1]) : 0;
    const double after = piece + 2 <= last ? fabs(d[piece] - 2 * d[piece + 1] + d[piece + 2]) : 0;
    return fmax(d[piece], d[piece + 1]) + fmax(before, after) / 4;
}

void clearance_of_shape(const environment *of, const clearance_shape *shape, double *free,
                        clearance *least)
{
    const surface *const s = environment_surface(of);
    double size = 1, within = INFINITY;
    for (int i = 0; i < 3; i++) {
        size = fmax(size, fmax(fabs(s->low[i]), fabs(s->high[i])));
    }
    *least = (clearance){.free = INFINITY, .radius = shape->radius, .distance = INFINITY};
    for (size_t k = 0; k + 1 < shape->points; k++) {
        const double *const r = &shape->r[3 * k];
        free[k] = INFINITY;
        if (shape->s[k + 1] <= shape->from) {
            continue;
        }
        clearance c = {.distance = environment_segment(of, r, r + 3, within),
                       .radius = shape->radius,
                       .distance_error = 1e-12 * size, /* as tested */
                       .shape_error = shape->error,
                       .unknown = spread_of(shape, k),
                       .between_points = off_line(shape, k),
                       .at = shape->s[k]};
        within =
            fabs(c.distance) + vector_distance(r, r + 3); /* the next one begins where this ends */
        c.free =
            c.distance - c.radius - c.distance_error - c.shape_error - c.unknown - c.between_points;
        free[k] = c.free;
        if (!(c.free >= least->free)) {
            *least = c;
        }
    }
}

double clearance_between(size_t pieces, const double *a, const double *b, const double *travel)
{
    double least = INFINITY;
    for (size_t k = 0; k < pieces; k++) {
        if (a[k] < INFINITY) {
            const double here = fmin((a[k] + b[k] - travel[k]) / 2, fmin(a[k], b[k]));
            least = here >= least ? least : here;
        }
    }
    return least;
}
