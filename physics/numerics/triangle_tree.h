/* Triangles in a tree of boxes, and exact distances from them. Needs no library and allocates
 * nothing: exported C has this very text. */
#ifndef PHYSICS_NUMERICS_TRIANGLE_TREE_H
#define PHYSICS_NUMERICS_TRIANGLE_TREE_H

/* Of 2^levels leaves leaf k has the triangles from k triangles / 2^levels up to those of the next.
 * Floats, which are exact corners: a surface of doubles has to be rounded before. */
typedef struct triangle_tree {
    int corners, triangles, levels;
    int side;            /* free is, 1: outside of the surface, -1: within, 0: all */
    const float *corner; /* [corners][3], m */
    const int *triangle; /* [triangles][3] corners, counterclockwise as seen from outside */
    const float *box;    /* [2^(levels + 1)][6] low and high; node 1 is the root, 2 i and 2 i + 1
                          * belong to i */
} triangle_tree;

enum { TRIANGLE_TREE_LEVELS_MAX = 28 };
#define TRIANGLE_TREE_BOXES(tree) ((size_t)2 << (tree)->levels)

/* Of p, m, or `within` if it is further than that; and the nearest place, left alone if so. */
double triangle_tree_distance(const triangle_tree *tree, const double p[3], double within,
                              double nearest[3]);

/* Of the line from a to b, 0: they meet; or `within`. */
double triangle_tree_segment(const triangle_tree *tree, const double a[3], const double b[3],
                             double within);

/* Whether p is on the side that is free: by how often the surface goes around it, right also of
 * surfaces that cut themselves. */
int triangle_tree_is_free(const triangle_tree *tree, const double p[3]);

#endif
