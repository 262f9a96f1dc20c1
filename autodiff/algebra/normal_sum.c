/* J^T J slab by slab of points: first every tile of the slab writes panels of it, then blocks of
 * J^T J, each of two groups of panels, are dealt to the threads (normal_multiply.c). So there is
 * one J^T J, whatever the number of threads, and each of its numbers is summed in the same order.
 *
 * Slabs belong to leaves, by the number of points alone, and leaves are added to J^T J one after
 * the other. Each rank makes the sums of neighbouring leaves: that of the first adds them to J^T J,
 * as one process does, and others keep theirs apart until they are exchanged. */
#include "autodiff/algebra/normal.h"
#include "autodiff/run/execute.h"
#include "autodiff/run/rank_exchange.h"

#include <stdlib.h>
#include <string.h>

/* Numbers in a slab, and the least rows of J in a leaf: large enough that reading and writing J^T J
 * once for each costs little; numbers of J^T J that are exchanged at a time. Leaves are a power of
 * 2, which as many ranks or fewer share evenly. */
enum { SLAB_NUMBERS = 16 << 20, LEAF_ROWS = 1024, LEAVES_MAX = 8, PART = 1 << 18 };

/* How points are cut. */
typedef struct cutting {
    size_t points, tiles, leaves;
    size_t slab; /* tiles */
    int tile;
} cutting;

/* Numbers of a slab that belong to one point. */
static size_t slab_numbers(const normal_layout *l)
{
    size_t panels = (size_t)l->source_panels + (size_t)l->plain_panels * (size_t)l->rows;
    return panels * PANEL + (size_t)l->weight_count;
}

static size_t leaf_tile(const cutting *c, size_t leaf)
{
    return leaf * c->tiles / c->leaves;
}

static cutting cut(const ad_normal *normal, size_t points)
{
    cutting c = {.points = points};
    ad_execute_tiling(normal->program, points, &c.tile, &c.tiles);
    const size_t rows = (size_t)normal->layout.rows * points;
    for (c.leaves = 1; 2 * c.leaves <= LEAVES_MAX && 2 * c.leaves * LEAF_ROWS <= rows;) {
        c.leaves *= 2;
    }
    c.leaves = minimum(c.leaves, c.tiles);
    size_t most = SLAB_NUMBERS / (slab_numbers(&normal->layout) * (size_t)c.tile + 1);
    most = most < 2 ? 2 : most;
    c.slab = c.leaves ? minimum(most, (c.tiles + c.leaves - 1) / c.leaves) : 0;
    return c;
}

/* J^T J, J^T r and r^T r. */
static size_t leaf_numbers(const ad_normal *normal)
{
    return normal->parameters * (normal->parameters + 1) + 1;
}

/* The leaves that a rank makes. */
typedef struct leaf_range {
    size_t first, count;
} leaf_range;

static leaf_range leaves_of(const cutting *c, int ranks, int rank)
{
    const size_t first = share_first(c->leaves, ranks, rank);
    return (leaf_range){first, share_first(c->leaves, ranks, rank + 1) - first};
}

static leaf_range own_leaves(const ad_normal *normal, const cutting *c)
{
    const ad_ranks *ranks = ad_pool_ranks(normal->program->pool);
    return ranks ? leaves_of(c, ranks->count, ranks->rank) : (leaf_range){0, c->leaves};
}

/* How many sums a rank has of its leaves: those that begin with the first are one. */
static size_t sums_of(leaf_range leaves)
{
    return leaves.first == 0 && leaves.count > 0 ? 1 : leaves.count;
}

static bool is_one_slab(const cutting *c) /* a leaf */
{
    return c->slab * c->leaves >= c->tiles;
}

/* How many leaves are kept apart: each of a later rank, or one of several slabs until it is added.
 */
static size_t kept_leaves(const cutting *c, leaf_range own)
{
    return own.first > 0 ? own.count : !is_one_slab(c);
}

size_t ad_normal_room(const ad_normal *normal, size_t points)
{
    cutting c = cut(normal, points);
    return c.slab * (size_t)c.tile;
}

size_t ad_normal_numbers(const ad_normal *normal, size_t points)
{
    cutting c = cut(normal, points);
    return slab_numbers(&normal->layout) * c.slab * (size_t)c.tile +
           kept_leaves(&c, own_leaves(normal, &c)) * leaf_numbers(normal);
}

/* ---- a leaf ---------------------------------------------------------------------------------- */

/* Item of the triangle of blocks of J^T J. */
static void multiply_groups(void *context, int item, int thread)
{
    const normal_run *n = context;
    const ad_normal *normal = n->normal;
    const normal_layout *l = &normal->layout;
    int row = 0, column = item;
    for (; column >= l->group_count - row; row++) { /* a row has group_count - row blocks */
        column -= l->group_count - row;
    }
    ad_normal_multiply(l, normal->program->kernels, &normal->slab, l->groups[row],
                       l->groups[row + column], &normal->spaces[thread], n->jtj, n->jtr, n->rtr);
}

static void add_leaf(ad_normal *normal, const ad_run *run, const cutting *c, size_t leaf,
                     normal_run *n)
{
    const size_t end = leaf_tile(c, leaf + 1);
    const int groups = normal->layout.group_count;
    for (size_t first = leaf_tile(c, leaf), count; first < end; first += count) {
        count = minimum(end - first, c->slab);
        normal->slab.points =
            minimum((first + count) * (size_t)c->tile, c->points) - first * (size_t)c->tile;
        ad_execute_tiles(normal->program, run, first, count, ad_normal_write_panels, n);
        ad_pool_run(normal->program->pool, groups * (groups + 1) / 2, multiply_groups, n);
    }
}

/* Where the sums of a leaf that is kept apart are, and go. */
static normal_run kept(const ad_normal *normal, const cutting *c, size_t which)
{
    const size_t n = normal->parameters;
    double *to = normal->leaves + which * leaf_numbers(normal);
    return (normal_run){
        .normal = normal, .tile = c->tile, .jtj = to, .jtr = to + n * n, .rtr = to + n * n + n};
}

static normal_run begin_kept(const ad_normal *normal, const cutting *c, size_t which)
{
    const size_t n = normal->parameters;
    const normal_run leaf = kept(normal, c, which);
    for (size_t row = 0; row < n; row++) { /* what is below the diagonal is not looked at */
        memset(leaf.jtj + row * n + row, 0, (n - row) * sizeof *leaf.jtj);
    }
    memset(leaf.jtr, 0, (n + 1) * sizeof *leaf.jtr);
    return leaf;
}

/* ---- all of them ----------------------------------------------------------------------------- */

/* Rows first .. end - 1 of the upper triangle of J^T J, then J^T r and r^T r as one more row. */
typedef struct part {
    size_t first, end, numbers;
} part;

static part next_part(size_t n, size_t first)
{
    part p = {first, first, 0};
    while (p.end <= n && (p.end == first || p.numbers + n - p.end <= PART)) {
        p.numbers += p.end < n ? n - p.end : n + 1;
        p.end++;
    }
    return p;
}

typedef enum part_way { PART_PACK, PART_UNPACK, PART_ADD } part_way;

/* Between the sums of a run and a packed part. */
static void move_part(const normal_run *sums, part p, part_way way, double *packed)
{
    const size_t n = sums->normal->parameters;
    for (size_t row = p.first; row < p.end; row++) {
        double *at = row < n ? sums->jtj + row * n + row : sums->jtr;
        const size_t count = row < n ? n - row : n;
        for (size_t i = 0; way == PART_ADD && i < count; i++) {
            at[i] += packed[i];
        }
        if (way != PART_ADD) {
            memcpy(way == PART_PACK ? packed : at, way == PART_PACK ? at : packed,
                   count * sizeof *at);
        }
        packed += count;
    }
    if (p.end > n) {
        *packed = way == PART_PACK ? *sums->rtr : *packed;
        *sums->rtr = way == PART_PACK  ? *sums->rtr
                     : way == PART_ADD ? *sums->rtr + *packed
                                       : *packed;
    }
}

/* Of all ranks; the first piece has what was there before. */
static void add_in_order(void *context, size_t width, double *pieces, double *to)
{
    memcpy(to, pieces, width * sizeof *to);
    for (size_t k = 1; k < *(const size_t *)context; k++) {
        pieces += width;
        for (size_t i = 0; i < width; i++) {
            to[i] += pieces[i];
        }
    }
}

/* Sums of all ranks; `sums`: where they go, and where that of the first leaf is. */
static void share_leaves(ad_normal *normal, const cutting *c, const normal_run *sums)
{
    share *s = ad_pool_get_share(normal->program->pool);
    const double *packed[LEAVES_MAX];
    int pieces[AD_RANKS_MAX];
    const leaf_range own = own_leaves(normal, c);
    const size_t n = normal->parameters, width = PART + n + 1, mine = sums_of(own);
    size_t all = 0;
    for (int i = 0; i < s->ranks->count; i++) {
        pieces[i] = (int)sums_of(leaves_of(c, s->ranks->count, i));
        all += (size_t)pieces[i];
    }
    for (part p = next_part(n, 0); p.first <= n; p = next_part(n, p.end)) {
        double *total = normal->packed + mine * width;
        for (size_t k = 0; k < mine; k++) {
            const normal_run from = own.first == 0 ? *sums : kept(normal, c, k);
            double *to = normal->packed + k * width;
            move_part(&from, p, PART_PACK, to);
            packed[k] = to;
        }
        ad_share_sum(s, pieces, packed, p.numbers, add_in_order, &all, total);
        move_part(sums, p, PART_UNPACK, total);
    }
}

static bool make_room(ad_normal *normal, const cutting *c)
{
    const ad_ranks *ranks = ad_pool_ranks(normal->program->pool);
    const size_t wanted = kept_leaves(c, own_leaves(normal, c)),
                 width = PART + normal->parameters + 1;
    if (!ad_normal_make_slab(normal, c->points)) {
        return false;
    }
    if (wanted > normal->leaf_capacity) {
        free(normal->leaves);
        normal->leaves = malloc(wanted * leaf_numbers(normal) * sizeof *normal->leaves);
        normal->leaf_capacity = normal->leaves ? wanted : 0;
    }
    if (ranks && !normal->packed) {
        normal->packed = malloc((LEAVES_MAX + 1) * width * sizeof *normal->packed);
    }
    return (wanted == 0 || normal->leaves) &&
           (!ranks ||
            (normal->packed && ad_share_make_room(ad_pool_get_share(normal->program->pool),
                                                  width * 2 * (LEAVES_MAX + 1))));
}

/* To the sums, by way of memory of its own where it has several slabs. */
static void add_leaf_at_once(ad_normal *normal, const ad_run *run, const cutting *c, size_t leaf,
                             normal_run *sums)
{
    const size_t n = normal->parameters;
    if (is_one_slab(c)) {
        add_leaf(normal, run, c, leaf, sums);
        return;
    }
    normal_run apart = begin_kept(normal, c, 0);
    add_leaf(normal, run, c, leaf, &apart);
    for (size_t row = 0; row < n; row++) {
        move_part(sums, (part){row, row + 1, 0}, PART_ADD, apart.jtj + row * n + row);
    }
    move_part(sums, (part){n, n + 1, 0}, PART_ADD, apart.jtr);
}

ad_status ad_normal_add(ad_normal *normal, const ad_run *run, double *jtj, double *jtr, double *rtr,
                        ad_error *error)
{
    const cutting c = cut(normal, run->points);
    if (!make_room(normal, &c)) {
        return ad_fail(error, AD_NO_MEMORY, "out of memory for rows of a Jacobian");
    }
    normal_run sums = {.normal = normal, .tile = c.tile, .jtj = jtj, .jtr = jtr, .rtr = rtr};
    const leaf_range own = own_leaves(normal, &c);
    ad_execute_begin(normal->program, run);
    for (size_t k = 0; k < own.count; k++) {
        if (own.first == 0) {
            add_leaf_at_once(normal, run, &c, k, &sums);
        } else {
            normal_run leaf = begin_kept(normal, &c, k);
            add_leaf(normal, run, &c, own.first + k, &leaf);
        }
    }
    if (ad_pool_ranks(normal->program->pool) && c.leaves > 0) {
        share_leaves(normal, &c, &sums);
    }
    return AD_OK;
}

ad_share ad_normal_share(const ad_normal *normal, size_t points, int ranks, int rank)
{
    const cutting c = cut(normal, points);
    const size_t tile = (size_t)c.tile;
    const leaf_range own = leaves_of(&c, ranks, rank);
    ad_share result = {.points = 0};
    if (c.leaves > 0) {
        result.first = minimum(leaf_tile(&c, own.first) * tile, points);
        result.points = minimum(leaf_tile(&c, own.first + own.count) * tile, points) - result.first;
        result.bytes = kept_leaves(&c, own) * leaf_numbers(normal) * sizeof(double);
    }
    return result;
}
