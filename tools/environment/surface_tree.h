/* A surface as a tree of its triangles, for exact distances in exported C. */
#ifndef ENVIRONMENT_SURFACE_TREE_H
#define ENVIRONMENT_SURFACE_TREE_H

#include "physics/numerics/triangle_tree.h"
#include "tools/environment/environment_settings.h"
#include "tools/environment/surface.h"

typedef struct surface_tree {
    triangle_tree tree; /* of what follows */
    float *corner, *box;
    int *triangle;
    double error; /* m: distances from it are off by at most so much, as its corners are floats */
} surface_tree;

/* Of a surface that is closed where a side is asked for, and is not kept. AD_NO_MEMORY. */
ad_status surface_tree_create(const surface *of, environment_side side, surface_tree **result,
                              ad_error *error);
/* Of the surface of settings, for a robot of that length. Errors of surface_open,
 * surface_check_size and, where a side is asked for, surface_check_closed. */
ad_status surface_tree_open(const environment_settings *settings, double length,
                            surface_tree **result, ad_error *error);
void surface_tree_free(surface_tree *of); /* NULL is allowed */

static inline size_t surface_tree_bytes(const surface_tree *of)
{
    return 12 * ((size_t)of->tree.corners + (size_t)of->tree.triangles +
                 2 * TRIANGLE_TREE_BOXES(&of->tree));
}

#endif
