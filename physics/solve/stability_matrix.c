#include "physics/solve/stability_matrix.h"

#include "autodiff/dense.h"

#include <stdlib.h>
#include <string.h>

static size_t block_of(const stability_matrix *matrix)
{
    return (size_t)matrix->size * (size_t)matrix->size;
}

ad_status stability_matrix_create(int nodes, int size, stability_matrix *matrix, ad_error *error)
{
    *matrix = (stability_matrix){.nodes = nodes, .size = size};
    matrix->own = calloc((size_t)nodes * block_of(matrix), sizeof *matrix->own);
    matrix->next = calloc((size_t)nodes * block_of(matrix),
                          sizeof *matrix->next); /* of the last node: unused */
    return matrix->own && matrix->next
               ? ad_dense_load(error)
               : ad_fail(error, AD_NO_MEMORY, "out of memory for %d elements", nodes - 1);
}

void stability_matrix_free(stability_matrix *matrix)
{
    free(matrix->own);
    free(matrix->next);
}

void stability_matrix_add(stability_matrix *matrix, int row, int column, double value)
{
    int n = matrix->size, node = row / n, other = column / n;
    size_t block = block_of(matrix) * (size_t)node;
    if (node > other) {
        stability_matrix_add(matrix, column, row, value);
    } else if (node < other) {
        matrix->next[block + (size_t)(row % n * n + column % n)] += value;
    } else {
        matrix->own[block + (size_t)(row % n * n + column % n)] += value;
        matrix->own[block + (size_t)(column % n * n + row % n)] += row == column ? 0 : value;
    }
}

/* What is left of the block `own` behind a node; solved: the inverse of what was left of that
 * node's block times `next`, column-major. */
static void eliminate(int n, const double *own, const double *next, const double *solved,
                      double *left)
{
    for (int i = 0; i < n; i++) {
        for (int j = 0; j <= i; j++) {
            double taken = 0;
            for (int r = 0; r < n; r++) {
                taken += next[r * n + i] * solved[j * n + r];
            }
            left[i * n + j] = left[j * n + i] = own[i * n + j] - taken;
        }
    }
}

/* By elimination of one node after the other: the inertia of what is left of each block adds up
 * (Haynsworth 1968). */
int stability_matrix_negative(const stability_matrix *matrix)
{
    enum { MOST = STABILITY_NODE_MAX * STABILITY_NODE_MAX };
    const int n = matrix->size;
    const size_t block = block_of(matrix);
    int sum = 0, pivots[STABILITY_NODE_MAX];
    double left[MOST], copy[MOST], solved[MOST];
    memcpy(left, matrix->own, block * sizeof *left);
    for (int node = 0; node < matrix->nodes; node++) {
        const double *next = matrix->next + block * (size_t)node;
        memcpy(copy, left, block * sizeof *copy);
        sum += ad_dense_negative((size_t)n, copy, pivots);
        if (node + 1 == matrix->nodes) {
            break;
        }
        memcpy(copy, left, block * sizeof *copy); /* symmetric: by columns as by rows */
        for (int c = 0; c < n; c++) {
            for (int r = 0; r < n; r++) {
                solved[c * n + r] = next[r * n + c];
            }
        }
        if (ad_dense_lu((size_t)n, copy, pivots) != 0) {
            return -1;
        }
        ad_dense_lu_solve((size_t)n, (size_t)n, copy, pivots, solved);
        eliminate(n, matrix->own + block * (size_t)(node + 1), next, solved, left);
    }
    return sum;
}
