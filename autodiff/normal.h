/* A Jacobian as it is recorded. Private to autodiff. */
#ifndef AD_NORMAL_H
#define AD_NORMAL_H

#include "autodiff/program.h"

/* One residual's derivatives by one block of parameters: a sum of products y x^T [m][k], and of
 * values [m*k] as they are. Numbers of outputs of the program. */
typedef struct jacobian_block {
    size_t offset; /* in the parameter vector */
    int rows, columns;
    int first, count; /* of the terms */
} jacobian_block;

typedef struct jacobian_term {
    int y, x; /* outputs; x -1: y is the whole block */
} jacobian_term;

typedef struct jacobian_row {
    int residual;     /* output */
    int first, count; /* of the blocks */
} jacobian_row;

typedef struct jacobian {
    jacobian_row *rows;
    jacobian_block *blocks;
    jacobian_term *terms;
    ad_value *outputs;
    int row_count, block_count, term_count, output_count;
    int row_capacity, block_capacity, term_capacity, output_capacity;
} jacobian;

/* Record adjoints of every row of the residuals, per point. Rows that no parameter moves and that
 * are 0 are left out. */
ad_status jacobian_record(jacobian *j, int count, const ad_value *residuals, int wrt_count,
                          const ad_value *wrt);
void jacobian_clear(jacobian *j);

#endif
