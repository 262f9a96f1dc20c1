/* What instructions do with values of members: a tile has whole members, or points of one. */
#include "autodiff/run/execute.h"

#include "autodiff/run/blas.h"

#include <string.h>

/* Neighbouring points of a tile that are of one member. */
typedef struct stretch {
    size_t member;
    int first, count;
} stretch;

/* Tiles begin with a member, or have points of one member only. */
static stretch first_stretch(const tile_state *t)
{
    size_t each = t->e->each;
    return (stretch){t->start / each, 0, (int)minimum(each, (size_t)t->valid)};
}

static bool next_stretch(const tile_state *t, stretch *s)
{
    s->member++;
    s->first += s->count;
    s->count = (int)minimum((size_t)s->count, (size_t)(t->valid - s->first));
    return s->count > 0;
}

/* One row of the memory of the members, at every point. */
static void spread_row(const tile_state *t, const double *from, double *to)
{
    if (t->e->each == 1) {
        memcpy(to, from + t->start, (size_t)t->valid * sizeof *to);
    } else {
        stretch s = first_stretch(t);
        do {
            for (int j = s.first; j < s.first + s.count; j++) {
                to[j] = from[s.member];
            }
        } while (next_stretch(t, &s));
    }
    for (int j = t->valid; j < t->width; j++) {
        to[j] = to[t->valid - 1];
    }
}

void ad_execute_spread(const tile_state *t, const instruction *i)
{
    for (int row = 0; row < i->out.rows; row++) {
        spread_row(t, operand(t, i->in[0], row).at, tile_at(t, i->out, row));
    }
}

/* y = W x for members of one point each. */
static void multiply_spread(const tile_state *t, const instruction *i, bool transposed)
{
    int m = i->out.rows, k = i->in[1].rows;
    for (int row = 0; row < m; row++) {
        for (int j = 0; j < k; j++) {
            int entry = transposed ? j * m + row : row * k + j;
            spread_row(t, operand(t, i->in[0], entry).at, t->row);
            ad_execute_multiply_rows(t, i->out, row, 1, (kernel_operand){t->row, 0},
                                     operand(t, i->in[1], j), j > 0, 0);
        }
    }
}

/* y = W x with a matrix of each member: a product for the points of each. */
void ad_execute_member_matvec(const tile_state *t, const instruction *i)
{
    bool transposed = i->op == OP_MATVEC_TRANSPOSED;
    int m = i->out.rows, k = i->in[1].rows;
    const double *x = tile_at(t, i->in[1], 0);
    double *y = tile_at(t, i->out, 0);
    kernel_operand w = operand(t, i->in[0], 0);
    if (t->e->each == 1) {
        multiply_spread(t, i, transposed);
        return;
    }
    const blas *blas = ad_blas_load(NULL);
    stretch s = first_stretch(t);
    do {
        int count = s.first + s.count == t->valid ? t->width - s.first : s.count;
        for (int n = 0; n < m * k; n++) {
            t->scratch[n] = w.at[n * w.stride + (ptrdiff_t)s.member];
        }
        blas->gemm(BLAS_ROW_MAJOR, transposed ? BLAS_TRANSPOSED : BLAS_NORMAL, BLAS_NORMAL, m,
                   count, k, 1, t->scratch, transposed ? m : k, x + s.first,
                   i->in[1].stride * t->tile, 0, y + s.first, i->out.stride * t->tile);
    } while (next_stretch(t, &s));
}

/* Where what a tile adds up for a member goes, and how far apart rows are. */
static double *share_of(const tile_state *t, const instruction *i, size_t member, ptrdiff_t *stride)
{
    const execution *e = t->e;
    const ad_program *program = e->program;
    size_t row = (size_t)(i->out.offset - e->pass->summed_offset);
    *stride = (ptrdiff_t)(e->parts > 1 ? e->tiles : e->members);
    return e->parts > 1 ? program->shares + row * e->tiles + t->number
                        : program->member + (size_t)i->out.offset * e->members + member;
}

/* The sums of members of one point each. */
static void keep_points(const tile_state *t, const instruction *i)
{
    bool outer = i->op == OP_OUTER_SUM;
    int k = outer ? i->in[1].rows : 1;
    for (int n = 0; n < i->out.rows; n++) {
        kernel_operand in[2] = {operand(t, i->in[0], n / k)};
        const double *from = in[0].at;
        if (outer) {
            in[1] = operand(t, i->in[1], n % k);
            t->e->program->kernels->loops[OP_MUL][0](1, t->width, t->row, 0, in, 0, 0);
            from = t->row;
        }
        memcpy(t->e->program->member + (size_t)(i->out.offset + n) * t->e->members + t->start, from,
               (size_t)t->valid * sizeof *from);
    }
}

/* Of each member's points: the values, or their outer products. */
void ad_execute_member_sum(const tile_state *t, const instruction *i)
{
    const ad_program *program = t->e->program;
    kernel_operand y = operand(t, i->in[0], 0), x = operand(t, i->in[1], 0);
    int m = i->in[0].rows, k = i->op == OP_OUTER_SUM ? i->in[1].rows : 1;
    if (t->e->each == 1) {
        keep_points(t, i);
        return;
    }
    const blas *blas = ad_blas_load(NULL);
    stretch s = first_stretch(t);
    do {
        ptrdiff_t stride;
        double *to = share_of(t, i, s.member, &stride);
        if (i->op == OP_OUTER_SUM) {
            blas->gemm(BLAS_ROW_MAJOR, BLAS_NORMAL, BLAS_TRANSPOSED, m, k, s.count, 1,
                       y.at + s.first, (int)y.stride, x.at + s.first, (int)x.stride, 0, t->scratch,
                       k);
        } else {
            memset(t->scratch, 0, (size_t)m * sizeof *t->scratch);
            program->kernels->sum_points(m, s.count, t->scratch,
                                         (kernel_operand){y.at + s.first, y.stride});
        }
        for (int n = 0; n < m * k; n++) {
            to[n * stride] = t->scratch[n];
        }
    } while (next_stretch(t, &s));
}

/* The shares of a member's tiles, in their order. */
void ad_execute_add_shares(const execution *e)
{
    const ad_program *program = e->program;
    for (size_t row = 0; e->parts > 1 && row < (size_t)e->pass->summed; row++) {
        const double *from = program->shares + row * e->tiles;
        double *to = program->member + ((size_t)e->pass->summed_offset + row) * e->members;
        for (size_t member = 0; member < e->members; member++) {
            to[member] = from[member * e->parts];
            for (size_t part = 1; part < e->parts; part++) {
                to[member] += from[member * e->parts + part];
            }
        }
    }
}
