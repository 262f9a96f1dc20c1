#include "physics/numerics/triangle_tree.h"

#include "physics/numerics/triangle.h"

#include <stddef.h>
#include <string.h>

/* Three corners, and what triangle.h has them by. */
typedef struct corners {
    double place[3][3];
    const double *by[3];
} corners;

static void take_corners(const triangle_tree *tree, int triangle, corners *to)
{
    for (int k = 0; k < 3; k++) {
        const float *from = tree->corner + 3 * (size_t)tree->triangle[3 * (size_t)triangle + k];
        for (int i = 0; i < 3; i++) {
            to->place[k][i] = from[i];
        }
        to->by[k] = to->place[k];
    }
}

/* The first triangle of a leaf, or behind the last one. */
static int first_of(const triangle_tree *tree, unsigned leaf)
{
    return (int)(((unsigned long long)leaf * (unsigned)tree->triangles) >> tree->levels);
}

/* Square of what is between from the lower to the higher ends of two boxes. */
static double square_between(const double low[3], const double high[3], const double other_low[3],
                             const double other_high[3])
{
    double square = 0;
    for (int i = 0; i < 3; i++) {
        const double below = other_low[i] - high[i], above = low[i] - other_high[i];
        const double off = below > above ? below : above;
        square += off > 0 ? off * off : 0;
    }
    return square;
}

/* Of a node of the tree, or three corners, from such a box. */
static double node_apart(const triangle_tree *tree, unsigned node, const double low[3],
                         const double high[3])
{
    const float *box = tree->box + 6 * (size_t)node;
    const double from[3] = {box[0], box[1], box[2]}, to[3] = {box[3], box[4], box[5]};
    return square_between(from, to, low, high);
}

static double corners_apart(const corners *of, const double low[3], const double high[3])
{
    double from[3], to[3];
    for (int i = 0; i < 3; i++) {
        const double x = of->place[0][i], y = of->place[1][i], z = of->place[2][i];
        from[i] = x < y ? x : y;
        to[i] = x < y ? y : x;
        from[i] = z < from[i] ? z : from[i];
        to[i] = z > to[i] ? z : to[i];
    }
    return square_between(from, to, low, high);
}

/* b NULL: of a. Nearer boxes first. */
static double search(const triangle_tree *tree, const double *a, const double *b, double best,
                     double nearest[3])
{
    unsigned nodes[TRIANGLE_TREE_LEVELS_MAX + 2];
    double off[TRIANGLE_TREE_LEVELS_MAX + 2], low[3], high[3];
    int count = 1;
    for (int i = 0; i < 3; i++) {
        low[i] = b && b[i] < a[i] ? b[i] : a[i];
        high[i] = b && b[i] > a[i] ? b[i] : a[i];
    }
    nodes[0] = 1;
    off[0] = node_apart(tree, 1, low, high);
    while (count > 0) {
        const unsigned node = nodes[--count], leaf = node - (1u << tree->levels);
        if (!(off[count] < best * best)) {
            continue;
        }
        if (node >> tree->levels == 0) {
            const double left = node_apart(tree, 2 * node, low, high);
            const double right = node_apart(tree, 2 * node + 1, low, high);
            const unsigned further = left <= right ? 1 : 0;
            nodes[count] = 2 * node + further;
            off[count++] = further ? right : left;
            nodes[count] = 2 * node + 1 - further;
            off[count++] = further ? left : right;
            continue;
        }
        for (int t = first_of(tree, leaf); t < first_of(tree, leaf + 1); t++) {
            corners of;
            double here[3];
            int part;
            take_corners(tree, t, &of);
            if (!(corners_apart(&of, low, high) < best * best) ||
                triangle_is_beyond(of.by, a, b ? b : a, best)) {
                continue;
            }
            const double distance = b ? triangle_segment_distance(of.by, a, b)
                                      : triangle_distance(of.by, a, here, &part);
            if (distance < best) {
                best = distance;
                if (nearest) {
                    memcpy(nearest, here, sizeof here);
                }
            }
        }
    }
    return best;
}

double triangle_tree_distance(const triangle_tree *tree, const double p[3], double within,
                              double nearest[3])
{
    return search(tree, p, NULL, within, nearest);
}

double triangle_tree_segment(const triangle_tree *tree, const double a[3], const double b[3],
                             double within)
{
    return search(tree, a, b, within, NULL);
}

/* ---- sides ----------------------------------------------------------------------------------- */

/* On which side of the line from a to b, along x, p is: of one that is moved by as little as it
 * takes along y, and by less along z, so that it is never on the line; 0: there is no line. Of a
 * line and its reverse exactly the opposite. */
static int side_of(const double a[3], const double b[3], const double p[3])
{
    const int turned = a[1] > b[1] || (a[1] == b[1] && a[2] > b[2]);
    const double *from = turned ? b : a, *to = turned ? a : b;
    const double y = to[1] - from[1], z = to[2] - from[2];
    double side = y * (p[2] - from[2]) - z * (p[1] - from[1]);
    side = side != 0 ? side : -z;
    side = side != 0 ? side : y;
    return side == 0 ? 0 : (side > 0) != turned ? 1 : -1;
}

/* Which way the ray from p along x goes through: 1 out of the surface, -1 into it, 0: not at all.
 */
static int crossing(const corners *of, const double p[3])
{
    const double(*c)[3] = of->place;
    const int side = side_of(c[0], c[1], p);
    if (side == 0 || side_of(c[1], c[2], p) != side || side_of(c[2], c[0], p) != side) {
        return 0;
    }
    return side * triangle_volume(of->by, p) < 0 ? side : 0;
}

int triangle_tree_is_free(const triangle_tree *tree, const double p[3])
{
    unsigned nodes[TRIANGLE_TREE_LEVELS_MAX + 2];
    int count = 1, around = 0;
    if (tree->side == 0) {
        return 1;
    }
    nodes[0] = 1;
    while (count > 0) {
        const unsigned node = nodes[--count], leaf = node - (1u << tree->levels);
        const float *box = tree->box + 6 * (size_t)node;
        if (!(box[3] >= p[0] && box[1] <= p[1] && p[1] <= box[4] && box[2] <= p[2] &&
              p[2] <= box[5])) {
            continue;
        }
        if (node >> tree->levels == 0) {
            nodes[count++] = 2 * node;
            nodes[count++] = 2 * node + 1;
            continue;
        }
        for (int t = first_of(tree, leaf); t < first_of(tree, leaf + 1); t++) {
            corners of;
            take_corners(tree, t, &of);
            around += crossing(&of, p);
        }
    }
    return (around > 0) == (tree->side < 0);
}
