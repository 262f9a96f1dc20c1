/* A run at work (execute.c, execute_members.c). Private to autodiff. */
#ifndef AD_EXECUTE_H
#define AD_EXECUTE_H

#include "autodiff/compile/program.h"

enum { CHUNKS_FEW = 8, CHUNKS_MANY = 64, CHUNKS_MOST = 1024 };

typedef struct execution {
    ad_program *program;
    const ad_run *run;
    const pass *pass;
    const int *input_units;
    size_t count;   /* points, or members, that the pass goes over */
    size_t members; /* of the run */
    size_t each;    /* points of a member; 1 where the pass goes over the members */
    int tile;       /* points per tile of this run, a multiple of 8 */
    size_t step;    /* of these, the ones that are taken */
    size_t parts;   /* tiles per member where they have a part of one, else 1 */
    size_t tiles, chunks;
    size_t leaves;                 /* of a chunk in the sums' tree, a power of 2 */
    size_t first_chunk, end_chunk; /* those of this rank */
    size_t slices, width;          /* of the final sum */
} execution;

/* One tile at work. */
struct tile_state {
    const execution *e;
    double *workspace, *scratch;
    double *row; /* scratch for one row */
    double *sums;
    const double *base[PLACE_KINDS]; /* by place_kind: where its values lie */
    ptrdiff_t unit[PLACE_KINDS];     /* by place_kind: numbers per unit of offset and stride */
    int tile;
    int width; /* points computed: `valid` rounded up to a multiple of 8 */
    int valid;
    size_t start, number; /* the first point; of the tile */
};

static inline size_t minimum(size_t a, size_t b)
{
    return a < b ? a : b;
}

static inline double *tile_at(const tile_state *t, place p, int row)
{
    return t->workspace + (ptrdiff_t)(p.offset + row * p.stride) * t->tile;
}

static inline kernel_operand operand(const tile_state *t, place p, int row)
{
    ptrdiff_t unit = t->unit[p.kind];
    return (kernel_operand){t->base[p.kind] + (p.offset + row * p.stride) * unit, p.stride * unit};
}

/* out = a b, or out += a b, in `rows` rows; mask: which of the two are uniform. */
void ad_execute_multiply_rows(const tile_state *t, place out, int row, int rows, kernel_operand a,
                              kernel_operand b, bool add, unsigned mask);

static inline size_t first_tile(const execution *e, size_t chunk)
{
    return chunk * e->tiles / e->chunks;
}

static inline size_t leaf_levels(const execution *e)
{
    size_t levels = 0;
    while (e->leaves >> (levels + 1)) {
        levels++;
    }
    return levels;
}

/* Sums of so many chunks, and of each thread one for every level within its chunk. */
static inline size_t rows_of_sums(const execution *e, size_t chunks)
{
    return chunks + (size_t)ad_pool_threads(e->program->pool) * leaf_levels(e);
}

/* Cut a pass over so many points into tiles, chunks and the share of this rank. */
void ad_execute_cut(execution *e, const pass *p, size_t points, size_t members);

/* Which chunks this rank takes; memory for what it exchanges; sums that are everyone's, from those
 * of its chunks, added up as far as they follow each other; values of points that are everyone's
 * (execute_ranks.c). */
void ad_execute_deal(execution *e);
bool ad_execute_make_room(const execution *e);
void ad_execute_sum(const execution *e);
void ad_execute_gather(const execution *e);

/* Values of members at their points; products with a matrix of each; sums over the points of each,
 * and those of all its tiles. */
void ad_execute_spread(const tile_state *t, const instruction *i);
void ad_execute_member_matvec(const tile_state *t, const instruction *i);
void ad_execute_member_sum(const tile_state *t, const instruction *i);
void ad_execute_add_shares(const execution *e);

#endif
