#include "physics/numerics/triangle.h"

#include "physics/numerics/vector.h"

#include <math.h>
#include <string.h>

static void minus(const double a[3], const double b[3], double out[3])
{
    for (int i = 0; i < 3; i++) {
        out[i] = a[i] - b[i];
    }
}

static double clamp(double value)
{
    return fmin(fmax(value, 0), 1);
}

/* Nearest point of the line from a to b, and its part of the length. */
static double to_line(const double a[3], const double b[3], const double p[3], double nearest[3])
{
    double along[3], from[3];
    minus(b, a, along);
    minus(p, a, from);
    const double square = vector_dot(along, along);
    double part = square > 0 ? clamp(vector_dot(from, along) / square) : 0;
    for (int i = 0; i < 3; i++) {
        nearest[i] = part == 1 ? b[i] : a[i] + part * along[i];
    }
    return part;
}

/* Whether the foot of p on the plane is within, and where it is. */
static int has_foot(const double *const corners[3], const double normal[3], const double p[3],
                    double foot[3])
{
    double from[3], edge[3], side[3];
    minus(p, corners[0], from);
    const double height = vector_dot(normal, from) / vector_dot(normal, normal);
    for (int i = 0; i < 3; i++) {
        foot[i] = p[i] - height * normal[i];
    }
    for (int k = 0; k < 3; k++) {
        minus(corners[(k + 1) % 3], corners[k], edge);
        minus(p, corners[k], from);
        vector_cross(edge, from, side);
        if (!(vector_dot(side, normal) >= 0)) {
            return 0;
        }
    }
    return 1;
}

double triangle_distance(const double *const corners[3], const double p[3], double nearest[3],
                         int *part)
{
    double one[3], other[3], normal[3], foot[3], from[3], least = INFINITY;
    minus(corners[1], corners[0], one);
    minus(corners[2], corners[0], other);
    vector_cross(one, other, normal);
    if (vector_dot(normal, normal) > 0 && has_foot(corners, normal, p, foot)) {
        memcpy(nearest, foot, sizeof foot);
        *part = TRIANGLE_WITHIN;
        minus(p, corners[0], from);
        return fabs(vector_dot(normal, from)) / sqrt(vector_dot(normal, normal));
    }
    for (int k = 0; k < 3; k++) {
        const double at = to_line(corners[k], corners[(k + 1) % 3], p, foot);
        minus(p, foot, from);
        const double square = vector_dot(from, from);
        if (square < least) {
            least = square;
            memcpy(nearest, foot, sizeof foot);
            *part = at == 0   ? TRIANGLE_CORNER + k
                    : at == 1 ? TRIANGLE_CORNER + (k + 1) % 3
                              : TRIANGLE_EDGE + k;
        }
    }
    return sqrt(least);
}

/* Of two lines; where they are parallel, an end of one of them is nearest. */
static double between_lines(const double a[3], const double b[3], const double c[3],
                            const double d[3])
{
    const double *const ends[4] = {a, b, c, d};
    double nearest[3], from[3], least = INFINITY;
    for (int k = 0; k < 4; k++) {
        const double *const p = ends[k];
        to_line(k < 2 ? c : a, k < 2 ? d : b, p, nearest);
        minus(p, nearest, from);
        least = fmin(least, vector_dot(from, from));
    }
    double one[3], other[3];
    minus(b, a, one);
    minus(d, c, other);
    minus(c, a, from);
    const double oo = vector_dot(one, one), ot = vector_dot(one, other),
                 tt = vector_dot(other, other);
    const double area = oo * tt - ot * ot;
    if (area > 0) {
        const double s = (vector_dot(one, from) * tt - vector_dot(other, from) * ot) / area;
        const double t = (vector_dot(one, from) * ot - vector_dot(other, from) * oo) / area;
        if (s > 0 && s < 1 && t > 0 && t < 1) {
            double apart[3];
            for (int i = 0; i < 3; i++) {
                apart[i] = from[i] + t * other[i] - s * one[i];
            }
            least = fmin(least, vector_dot(apart, apart));
        }
    }
    return sqrt(least);
}

double triangle_volume(const double *const corners[3], const double p[3])
{
    double one[3], other[3], to[3], normal[3];
    minus(corners[1], corners[0], one);
    minus(corners[2], corners[0], other);
    minus(p, corners[0], to);
    vector_cross(one, other, normal);
    return vector_dot(normal, to);
}

/* Whether the line goes through: its ends on two sides, and the three edges all to one side of it.
 * Where rounding hides that, an edge is as near as rounding is. */
static int is_cut(const double *const corners[3], const double a[3], const double b[3])
{
    const double below = triangle_volume(corners, a);
    const double above = triangle_volume(corners, b);
    if (!((below <= 0 && above >= 0) || (below >= 0 && above <= 0)) || below == above) {
        return 0;
    }
    int left = 0, right = 0;
    for (int k = 0; k < 3; k++) {
        const double *const around[3] = {a, b, corners[k]};
        const double side = triangle_volume(around, corners[(k + 1) % 3]);
        left += side <= 0;
        right += side >= 0;
    }
    return left == 3 || right == 3;
}

double triangle_segment_distance(const double *const corners[3], const double a[3],
                                 const double b[3])
{
    if (is_cut(corners, a, b)) {
        return 0;
    }
    double nearest[3];
    int part;
    double least = fmin(triangle_distance(corners, a, nearest, &part),
                        triangle_distance(corners, b, nearest, &part));
    for (int k = 0; k < 3; k++) {
        least = fmin(least, between_lines(a, b, corners[k], corners[(k + 1) % 3]));
    }
    return least;
}

int triangle_is_beyond(const double *const corners[3], const double a[3], const double b[3],
                       double distance)
{
    double one[3], other[3], normal[3], to_a[3], to_b[3];
    minus(corners[1], corners[0], one);
    minus(corners[2], corners[0], other);
    vector_cross(one, other, normal);
    minus(a, corners[0], to_a);
    minus(b, corners[0], to_b);
    const double p = vector_dot(normal, to_a), q = vector_dot(normal, to_b);
    const double square = distance * distance * vector_dot(normal, normal);
    if ((p < 0) == (q < 0) && p * p > square && q * q > square) {
        return 1;
    }
    double middle[3], half[3], nearest[3];
    int part;
    for (int i = 0; i < 3 && a != b; i++) {
        middle[i] = (a[i] + b[i]) / 2;
        half[i] = (b[i] - a[i]) / 2;
    }
    return a != b &&
           triangle_distance(corners, middle, nearest, &part) - sqrt(vector_dot(half, half)) >
               distance;
}
