/* A symmetric matrix of blocks in which each node of a chain meets itself and its two neighbours,
 * and how many negative directions it has; for stability.c. */
#ifndef PHYSICS_SOLVE_STABILITY_MATRIX_H
#define PHYSICS_SOLVE_STABILITY_MATRIX_H

#include "autodiff/error.h"
#include "physics/scene/scene.h"

/* Unknowns of a node: turns, displacement and force of a rod in space, an angle of each tube. */
enum { STABILITY_NODE_MAX = 9 + SCENE_TUBES_MAX };

typedef struct stability_matrix {
    int nodes;
    int size;     /* unknowns of a node, <= STABILITY_NODE_MAX */
    double *own;  /* [nodes][size][size] symmetric */
    double *next; /* [nodes][size][size] rows of a node, columns of the one behind; the
                   * last: zeros */
} stability_matrix;

/* Zeros. AD_NO_MEMORY, AD_NO_BLAS; to be freed also then. */
ad_status stability_matrix_create(int nodes, int size, stability_matrix *matrix, ad_error *error);
void stability_matrix_free(stability_matrix *matrix); /* not itself */

/* Adds to an entry and to its mirror image; of nodes that are the same or neighbours. */
void stability_matrix_add(stability_matrix *matrix, int row, int column, double value);

/* How many negative directions there are; -1 where a block is singular or holds a NaN. */
int stability_matrix_negative(const stability_matrix *matrix);

#endif
