/* A surface as a tree of its triangles, for exact distances, in exported C, too. */
#ifndef ENVIRONMENT_SURFACE_TREE_H
#define ENVIRONMENT_SURFACE_TREE_H

#include "autodiff/memory.h"
#include "physics/numerics/triangle_tree.h"
#include "tools/environment/environment_settings.h"
#include "tools/environment/surface.h"

typedef struct surface_tree {
    triangle_tree tree; /* of what follows */
    float *corner, *box;
    int *triangle, *number; /* of each in the tree that in the surface */
    double error; /* m: distances from it are off by at most so much, as its corners are floats */
    ad_memory memory;
} surface_tree;

/* Of a surface that is closed where a side is asked for, and is not kept. AD_NO_MEMORY. */
ad_status surface_tree_create(const surface *of, environment_side side, surface_tree **result,
                              ad_error *error);
void surface_tree_free(surface_tree *of); /* NULL is allowed */

static inline size_t surface_tree_bytes(const surface_tree *of)
{
    return 12 * ((size_t)of->tree.corners + (size_t)of->tree.triangles +
                 2 * TRIANGLE_TREE_BOXES(&of->tree));
}

#endif
