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

/* Of y only the rows first .. first + rows - 1: others are 0 whatever the parameters are. */
typedef struct jacobian_term {
    int y, x; /* outputs; x -1: y is the whole block */
    int first, rows;
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

/* Neighbouring columns of J that are worked on together. A residual in which it is not live has
 * zeros there. */
typedef struct strip {
    size_t first, width;
    const bool *live; /* [residuals per point] */
} strip;

/* Neighbouring strips that share one row or column of blocks of J^T J. */
typedef struct strip_group {
    size_t first, end;
} strip_group;

typedef struct strips {
    strip *items;
    strip_group *groups;
    bool *live; /* [count][residuals per point] */
    size_t count, group_count;
} strips;

/* Record adjoints of every row of the residuals, per point. Rows that no parameter moves and that
 * are 0 are left out. */
ad_status ad_jacobian_record(jacobian *j, int count, const ad_value *residuals, int wrt_count,
                             const ad_value *wrt);
void ad_jacobian_clear(jacobian *j);

/* Are these recorded parameters, within the vector [parameters]? Else AD_BAD_ARGUMENT. */
ad_status ad_normal_check(int count, const ad_value *wrt, size_t parameters, ad_error *error);

/* Cut the columns of J [parameters] where other residuals begin to depend on them. AD_NO_MEMORY. */
ad_status ad_strips_create(const jacobian *j, size_t parameters, strips *result);
void ad_strips_clear(strips *s);
/* The next range of columns, from strip *at on, that are live in a residual; false: the group has
 * no more. *at becomes the strip after it. */
bool ad_strips_next(const strips *s, strip_group within, int residual, size_t *at, size_t *first,
                    size_t *width);
/* Are the same strips of a group live in two residuals? */
bool ad_strips_alike(const strips *s, strip_group within, int residual, int other);
/* Operations, per point, of the sums of products of two strips' columns. */
size_t ad_strips_flops(const strips *s, int row_count);

#endif
