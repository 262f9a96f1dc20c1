/* A Jacobian as it is recorded. Private to autodiff. */
#ifndef AD_NORMAL_H
#define AD_NORMAL_H

#include "autodiff/compile/program.h"
#include "autodiff/memory.h"

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

/* Columns of J are worked on in panels of PANEL columns, the last ones of which may be empty. There
 * are two kinds.
 *
 * The columns of a head, one row of the matrix of a last layer, are sums of c x^T in every
 * residual: x the values of a basis or their derivatives, which residuals and heads share, c a
 * coefficient. The block of J^T J of two heads is then a sum over pairs of such x, whatever the
 * number of residuals, and their panels hold x.
 *
 * All other columns are plain: their panels hold the rows of J, one residual after the other. The
 * residuals themselves are the last plain column, so that J^T r and r^T r come with J^T J. */

/* A basis that heads share. */
typedef struct normal_source {
    int x, width; /* output of the program, its rows */
    int panel;    /* its first, of those of all sources */
} normal_source;

/* A coefficient of a head: row `row` of output y, in one residual. */
typedef struct normal_weight {
    int residual, source, y, row;
} normal_weight;

typedef struct normal_head {
    size_t column; /* the first */
    int width;
    int weight, weights; /* the first of its weights, by residual, and how many */
} normal_head;

/* Neighbouring panels of a head, or plain ones. */
typedef struct normal_group {
    int head; /* -1: plain */
    int panel, panels;
} normal_group;

typedef struct normal_layout {
    normal_source *sources;
    normal_weight *weights;
    normal_head *heads;
    normal_group *groups;
    size_t *columns; /* [plain_panels][PANEL], ascending; NO_COLUMN: none; parameters: residuals */
    bool *live;      /* [plain_panels][residuals]: is the panel not 0 there? */
    int source_count, weight_count, head_count, group_count, source_panels, plain_panels;
    int weights_max; /* of any head */
    int rows;        /* residuals per point */
    size_t parameters;
    size_t products; /* of two panels, per point */
    ad_memory memory;
} normal_layout;

#define NO_COLUMN ((size_t)-1)

/* Panels in a group at most, so that a block of J^T J fits into the L2 cache; points worked on
 * together, so that two panels fit into the L1 cache. */
enum { NORMAL_GROUP = 14, NORMAL_DEPTH = 96 };

/* What is worked with: basis [source_panels][points][PANEL], plain [plain_panels][rows][points]
 * [PANEL], weights [weight_count][points], `room` points apart. */
typedef struct normal_slab {
    double *basis, *plain, *weights;
    size_t room, points;
    ad_memory memory;
} normal_slab;

/* Working memory of a thread. */
typedef struct normal_space {
    double *tiles;                   /* [NORMAL_GROUP][NORMAL_GROUP][TILE] */
    double *panels;                  /* [NORMAL_GROUP][NORMAL_DEPTH][PANEL] */
    double *by;                      /* [source_count][NORMAL_DEPTH] */
    const double **factors, **terms; /* [weights_max + source_count] */
    int *sources[2], *used;          /* [source_count] */
} normal_space;

struct ad_normal {
    ad_program *program;
    jacobian jacobian;
    normal_layout layout;
    size_t parameters;
    normal_slab slab; /* no room before the first run */
    normal_space *spaces;
    int threads;
    double *leaves; /* sums that wait for others: [leaf_capacity][numbers of a leaf] */
    double *packed; /* of each of them a part, and of J^T J */
    size_t leaf_capacity;
    ad_memory memory;
};

/* One run. */
typedef struct normal_run {
    const ad_normal *normal;
    int tile;
    double *jtj, *jtr, *rtr;
    double *columns, *residual; /* where whole rows of J go: [parameters][stride], [stride] */
    size_t stride, points;      /* rows of J per residual */
} normal_run;

/* Points of a slab in a run over so many; memory for it (false: there is none); numbers of all
 * that a run needs beside workspaces (normal_sum.c). */
size_t ad_normal_room(const ad_normal *normal, size_t points);
bool ad_normal_make_slab(ad_normal *normal, size_t points);
size_t ad_normal_numbers(const ad_normal *normal, size_t points);

/* A tile_work: item is the number of the tile within the slab, context a normal_run. */
void ad_normal_write_panels(void *context, const tile_state *t, size_t item);

/* Record adjoints of every row of the residuals, per point. Rows that no parameter moves and that
 * are 0 are left out. */
ad_status ad_jacobian_record(jacobian *j, int count, const ad_value *residuals, int wrt_count,
                             const ad_value *wrt);
void ad_jacobian_clear(jacobian *j);

/* Heads where they save products. AD_NO_MEMORY. */
ad_status ad_normal_layout(const jacobian *j, size_t parameters, normal_layout *result);
void ad_normal_layout_clear(normal_layout *l);
/* Sources of a head in residuals in which another group is not 0; how many. */
int ad_normal_common(const normal_layout *l, const normal_head *head, normal_group other,
                     int *sources);
bool ad_normal_is_live(const normal_layout *l, normal_group group, int residual);
/* Operations, per point, of the products of panels. */
size_t ad_normal_flops(const normal_layout *l);

/* Add the block of J^T J, J^T r and r^T r of two groups, a not after b. */
void ad_normal_multiply(const normal_layout *l, const kernel_set *kernels, const normal_slab *slab,
                        normal_group a, normal_group b, normal_space *space, double *jtj,
                        double *jtr, double *rtr);

#endif
