/* Runs over several ranks: each takes neighbouring chunks. The sums of chunks are a binary tree,
 * and what a rank sends are its largest whole parts of it. */
#include "autodiff/run/execute.h"
#include "autodiff/run/rank_exchange.h"

#include <string.h>

enum { PIECES_MAX = 20 }; /* of a rank: two for every level of the tree of 1,024 chunks */

/* A whole part of the tree: the chunks from `first` on, `size` of them, a power of 2, or those that
 * there are. */
typedef struct piece {
    size_t first, size;
} piece;

static size_t first_of(const execution *e, int ranks, int rank)
{
    return share_first(e->chunks, ranks, rank);
}

/* The largest parts of the tree within a range of chunks, in order; how many. */
static int list_pieces(size_t chunks, size_t first, size_t end, piece *pieces)
{
    int count = 0;
    while (first < end) {
        size_t size = 1;
        while (first % (2 * size) == 0 && size < chunks &&
               minimum(first + 2 * size, chunks) <= end) {
            size *= 2;
        }
        pieces[count++] = (piece){first, size};
        first += size;
    }
    return count;
}

static const ad_ranks *ranks_of(const ad_program *program)
{
    return program->members ? NULL : ad_pool_ranks(program->pool);
}

/* Leaves: a power of 2 where there are more than a few, so that chunks are whole parts of their
 * tree; at most CHUNKS_MANY chunks for a rank. */
static void cut_chunks(execution *e, int ranks)
{
    size_t leaves = e->tiles / CHUNKS_FEW;
    leaves = leaves < CHUNKS_FEW ? CHUNKS_FEW : leaves;
    e->chunks = minimum(e->tiles, minimum(leaves, CHUNKS_MANY));
    e->leaves = 1;
    while (e->chunks > 0 && 2 * e->chunks * e->leaves <= minimum(leaves, CHUNKS_MOST)) {
        e->leaves *= 2;
    }
    for (int most = 1; most < ranks && e->leaves > 1; most *= 2) {
        e->chunks *= 2;
        e->leaves /= 2;
    }
}

void ad_execute_deal(execution *e)
{
    const ad_ranks *ranks = ranks_of(e->program);
    cut_chunks(e, ranks ? ranks->count : 1);
    e->first_chunk = ranks ? first_of(e, ranks->count, ranks->rank) : 0;
    e->end_chunk = ranks ? first_of(e, ranks->count, ranks->rank + 1) : e->chunks;
}

/* ---- sums ------------------------------------------------------------------------------------ */

/* How many pieces each rank has, and the sums of those of this one. */
static void count_pieces(const execution *e, int ranks, int *counts)
{
    piece pieces[PIECES_MAX];
    for (int i = 0; i < ranks; i++) {
        counts[i] =
            list_pieces(e->chunks, first_of(e, ranks, i), first_of(e, ranks, i + 1), pieces);
    }
}

/* The rest of the tree. A piece lies where its first chunk would. */
static void add_pieces(void *context, size_t width, double *values, double *to)
{
    const execution *e = context;
    const int ranks = ranks_of(e->program)->count;
    double *at[CHUNKS_MOST] = {NULL};
    size_t size[CHUNKS_MOST] = {0}, count = 0;
    for (int i = 0; i < ranks; i++) {
        piece own[PIECES_MAX];
        int pieces = list_pieces(e->chunks, first_of(e, ranks, i), first_of(e, ranks, i + 1), own);
        for (int k = 0; k < pieces; k++) {
            at[own[k].first] = values + count++ * width;
            size[own[k].first] = own[k].size;
        }
    }
    for (size_t step = 1; step < e->chunks; step *= 2) {
        for (size_t c = 0; c + step < e->chunks; c += 2 * step) {
            for (size_t i = 0; size[c] == step && i < width; i++) {
                at[c][i] += at[c + step][i];
            }
            size[c] = size[c] == step ? 2 * step : size[c];
        }
    }
    memcpy(to, at[0], width * sizeof *to);
}

void ad_execute_sum(const execution *e)
{
    ad_program *program = e->program;
    const ad_ranks *ranks = ranks_of(program);
    double *total = program->uniform + e->pass->reduced_offset;
    const size_t numbers = (size_t)e->pass->reduced;
    int counts[AD_RANKS_MAX];
    piece pieces[PIECES_MAX];
    const double *own[PIECES_MAX];
    if (!ranks) {
        memcpy(total, program->sums, numbers * sizeof *total);
        return;
    }
    count_pieces(e, ranks->count, counts);
    list_pieces(e->chunks, e->first_chunk, e->end_chunk, pieces);
    for (int k = 0; k < counts[ranks->rank]; k++) {
        own[k] = program->sums + (pieces[k].first - e->first_chunk) * (size_t)program->most_reduced;
    }
    ad_share_sum(ad_pool_get_share(program->pool), counts, own, numbers, add_pieces, (void *)e,
                 total);
}

/* ---- values of points ------------------------------------------------------------------------ */

/* Where the points of a rank begin. */
static size_t first_point(const execution *e, int ranks, int rank)
{
    return minimum(first_tile(e, first_of(e, ranks, rank)) * e->step, e->count);
}

/* Rows of all values that are wanted. */
static size_t rows_of(const execution *e)
{
    size_t rows = 0;
    for (int i = 0; i < e->pass->output_count; i++) {
        const batch_output *output = &e->pass->outputs[i];
        rows += e->run->outputs[output->number] ? (size_t)output->from.rows : 0;
    }
    return rows;
}

/* The rows of a range of points: from the outputs, or into them. */
static void copy_rows(const execution *e, size_t first, size_t end, double *room, bool into)
{
    for (int i = 0; i < e->pass->output_count; i++) {
        const batch_output *output = &e->pass->outputs[i];
        double *values = e->run->outputs[output->number];
        for (int row = 0; values && row < output->from.rows; row++, room += end - first) {
            double *at = values + (size_t)row * e->count + first;
            memcpy(into ? at : room, into ? room : at, (end - first) * sizeof *room);
        }
    }
}

void ad_execute_gather(const execution *e)
{
    const ad_ranks *ranks = ranks_of(e->program);
    const size_t rows = ranks ? rows_of(e) : 0;
    if (rows == 0) {
        return;
    }
    share *s = ad_pool_get_share(e->program->pool);
    for (int i = 0; i <= ranks->count; i++) {
        s->bounds[i] = rows * first_point(e, ranks->count, i);
    }
    const size_t first = first_point(e, ranks->count, ranks->rank),
                 end = first_point(e, ranks->count, ranks->rank + 1);
    copy_rows(e, first, end, s->room + rows * first, false);
    ranks->gather(ranks->context, s->bounds, s->room);
    for (int i = 0; i < ranks->count; i++) {
        const size_t start = first_point(e, ranks->count, i);
        if (i != ranks->rank) {
            copy_rows(e, start, first_point(e, ranks->count, i + 1), s->room + rows * start, true);
        }
    }
}

bool ad_execute_make_room(const execution *e)
{
    const ad_ranks *ranks = ranks_of(e->program);
    int counts[AD_RANKS_MAX];
    if (!ranks || e->chunks == 0) {
        return true;
    }
    count_pieces(e, ranks->count, counts);
    const size_t sums = ad_share_room(ranks->count, counts, ranks->rank, (size_t)e->pass->reduced),
                 values = rows_of(e) * e->count;
    return ad_share_make_room(ad_pool_get_share(e->program->pool), sums > values ? sums : values);
}

/* ---- what is shared -------------------------------------------------------------------------- */

/* Of one pass; e is cut. */
static ad_share share_of_pass(const execution *e, int ranks, int rank)
{
    const size_t chunks = first_of(e, ranks, rank + 1) - first_of(e, ranks, rank);
    const size_t first = first_point(e, ranks, rank);
    return (ad_share){.first = first,
                      .points = first_point(e, ranks, rank + 1) - first,
                      .bytes = rows_of_sums(e, chunks) * (size_t)e->program->most_reduced *
                               sizeof(double)};
}

/* All points of both. */
static void add_range(ad_share *to, const ad_share *of)
{
    const size_t end = of->first + of->points, before = to->first + to->points;
    if (to->points == 0 || of->points == 0) {
        to->first = of->points > 0 ? of->first : to->first;
        to->points += of->points;
        return;
    }
    to->first = minimum(to->first, of->first);
    to->points = (end > before ? end : before) - to->first;
}

ad_share ad_program_share(const ad_program *program, size_t points, int ranks, int rank)
{
    ad_share result = {.points = 0};
    if (program->members) { /* every rank takes all of them */
        return (ad_share){.points = points};
    }
    for (int s = 0; s < program->pass_count; s++) {
        execution e = {.program = (ad_program *)program};
        ad_execute_cut(&e, &program->passes[s], points, 1);
        cut_chunks(&e, ranks);
        if (e.chunks > 0) {
            const ad_share of = share_of_pass(&e, ranks, rank);
            add_range(&result, &of);
            result.bytes = of.bytes > result.bytes ? of.bytes : result.bytes;
        }
    }
    return result;
}
