/* Matrix products of a tile, compiled once per instruction set (AD_PRODUCT_SET names the result).
 *
 * Here one factor is small and stays in the first cache (weights), the other has rows of hundreds
 * of points, and a product is over after some 10,000 instructions. A block of the result, as large
 * as the registers hold, is summed up at once: each step loads VECTORS vectors of b and ROWS
 * numbers of a, and so needs a load for two multiplications at most. Operands are read where they
 * are; what the next strip needs of b, whose rows lie pages apart, is fetched into the first cache
 * in time. A number of the result is summed in the order of k, in parts of PART that are added: its
 * bits depend on k alone, not on its block.
 *
 * There is this one way for all shapes, and the instruction set of the processor decides on the
 * kernels: nothing is timed, so a machine computes the same bits every time. Rates in Gflop/s of
 * 64 x 64 weights and panels of 240 points, one core of an Intel Xeon, medians:
 *                               OpenBLAS    here     LIBXSMM
 *     AVX-512, W x; W^T x        98; 101  102; 102  103; 103
 *     AVX-512, sum y x^T              86        93        90
 *     AVX2, W x; W^T x            45; 47    56; 57    57; 58
 *     AVX2, sum y x^T                 39        52        50
 */
#include "autodiff/compile/kernels.h"
#include "autodiff/run/lanes.h"

#if defined(__AVX512F__)
enum { ROWS = 8, VECTORS = 3 };
#else
enum { ROWS = 4, VECTORS = 3 };
#endif
enum { PART = 120, LINE = 8 };

/* Keep a number in a register: gcc would rather load it again for each of its uses. */
#if defined(__AVX512F__)
#define KEEP(x) __asm__("" : "+v"(x))
#elif defined(__x86_64__)
#define KEEP(x) __asm__("" : "+x"(x))
#else
#define KEEP(x) (void)0
#endif
#if defined(__clang__)
#define UNROLL _Pragma("clang loop unroll(full)")
#else
#define UNROLL _Pragma("GCC unroll 16")
#endif

typedef double unaligned __attribute__((vector_size(LANES * 8), aligned(8), may_alias));

typedef enum result { SET, ADD, SUBTRACT } result;

/* A column of blocks: c[m][width] = a b, or +=, or -=. */
typedef struct strip {
    int k, width;
    ptrdiff_t row, column; /* between rows and columns of a */
    const double *b;
    ptrdiff_t b_stride, c_stride;
    result result;
} strip;

/* c[rows][vectors * LANES] from rows of a; `ahead`: fetch what the next strip needs of b. */
INLINE void block(int rows, int vectors, const strip *s, const double *a, double *c, bool ahead)
{
    vec sum[ROWS][VECTORS];
    UNROLL for (int i = 0; i < rows; i++)
    {
        UNROLL for (int v = 0; v < vectors; v++)
        {
            sum[i][v] = splat(0);
        }
    }
    const ptrdiff_t row = s->row, column = s->column, b_stride = s->b_stride;
    const double *b = s->b;
    for (const double *end = b + s->k * b_stride; b < end; b += b_stride, a += column) {
        if (ahead) {
            UNROLL for (int j = 0; j < vectors * LANES; j += LINE)
            {
                __builtin_prefetch(b + vectors * LANES + j);
            }
        }
        vec x[VECTORS];
        UNROLL for (int v = 0; v < vectors; v++)
        {
            vec from_b = *(const vec *)(b + v * LANES);
            KEEP(from_b);
            x[v] = from_b;
        }
        UNROLL for (int i = 0; i < rows; i++)
        {
            vec from_a = splat(a[i * row]);
            KEEP(from_a);
            UNROLL for (int v = 0; v < vectors; v++)
            {
                sum[i][v] = v_mul_add(from_a, x[v], sum[i][v]);
            }
        }
    }
    const ptrdiff_t c_stride = s->c_stride;
    const result result = s->result;
    UNROLL for (int i = 0; i < rows; i++, c += c_stride)
    {
        UNROLL for (int v = 0; v < vectors; v++)
        {
            unaligned *out = (unaligned *)(c + v * LANES);
            if (result == ADD) {
                sum[i][v] += *out;
            } else if (result == SUBTRACT) {
                sum[i][v] = *out - sum[i][v];
            }
            *out = sum[i][v];
        }
    }
}

typedef void block_function(const strip *s, const double *a, double *c, bool ahead);

#define BLOCK(rows, vectors)                                                                       \
    static void block_##rows##_##vectors(const strip *s, const double *a, double *c, bool ahead)   \
    {                                                                                              \
        block(rows, vectors, s, a, c, ahead);                                                      \
    }
#define BLOCKS(rows) BLOCK(rows, 1) BLOCK(rows, 2) BLOCK(rows, 3)
#define NAMES(rows)                                                                                \
    {                                                                                              \
        block_##rows##_1, block_##rows##_2, block_##rows##_3                                       \
    }

BLOCKS(1)
BLOCKS(2)
BLOCKS(3)
BLOCKS(4)
#if defined(__AVX512F__)
BLOCKS(5)
BLOCKS(6)
BLOCKS(7)
BLOCKS(8)
#endif

static block_function *const blocks[ROWS][VECTORS] = {
    NAMES(1), NAMES(2), NAMES(3), NAMES(4),
#if defined(__AVX512F__)
    NAMES(5), NAMES(6), NAMES(7), NAMES(8),
#endif
};

static int minimum(int a, int b)
{
    return a < b ? a : b;
}

/* A block of which not all columns count. */
static void part_of_block(int rows, int vectors, const strip *s, const double *a, double *c)
{
    double whole[ROWS * VECTORS * LANES] __attribute__((aligned(64)));
    const int width = vectors * LANES;
    strip apart = *s;
    apart.c_stride = width;
    apart.result = SET;
    blocks[rows - 1][vectors - 1](&apart, a, whole, false);
    for (int i = 0; i < rows; i++) {
        for (int j = 0; j < s->width; j++) {
            double *out = c + i * s->c_stride + j;
            *out = s->result == ADD ? *out + whole[i * width + j] : whole[i * width + j];
        }
    }
}

static int pieces(int count, int most)
{
    return (count + most - 1) / most;
}

/* Blocks about equally high. */
static void run_strip(int m, int vectors, const strip *s, const double *a, double *c, bool ahead)
{
    for (int left = pieces(m, ROWS), rows; left > 0; left--, m -= rows) {
        rows = m / left;
        if (s->width < vectors * LANES) {
            part_of_block(rows, vectors, s, a, c);
        } else {
            blocks[rows - 1][vectors - 1](s, a, c, ahead);
        }
        a += rows * s->row;
        c += rows * s->c_stride;
        ahead = false;
    }
}

/* Of the next strip of `width` columns that are left; strips are about equally wide. */
static int next_vectors(int width)
{
    const int vectors = pieces(width, LANES);
    return vectors / pieces(vectors, VECTORS);
}

static void multiply(int m, int n, int k, const double *a, ptrdiff_t row, ptrdiff_t column,
                     const double *b, ptrdiff_t b_stride, double *c, ptrdiff_t c_stride, bool add)
{
    for (int l = 0; l < k; l += PART) {
        strip s = {minimum(PART, k - l),    0, row, column, NULL, b_stride, c_stride,
                   add || l > 0 ? ADD : SET};
        for (int j = 0, vectors; j < n; j += vectors * LANES) {
            vectors = next_vectors(n - j);
            s.b = b + l * b_stride + j;
            s.width = n - j;
            run_strip(m, vectors, &s, a + l * column, c + j, true);
        }
    }
}

/* ---- sums of outer products ----------------------------------------------------------------- */

#if LANES > 2
typedef double half __attribute__((vector_size(LANES * 4), may_alias));
#endif

/* LANES x LANES numbers, to[j][i] = from[i][j]. Rows are paired by loading halves of them, which
 * needs no shuffle: of these a processor does one at a time, and nothing beside it. */
INLINE void turn_block(const double *const *from, ptrdiff_t at, double *to, ptrdiff_t stride)
{
#if LANES == 8
#define TWO(i) HALVES(i, i + 4, 0), HALVES(i, i + 4, 4)
#define HALVES(i, k, j)                                                                            \
    __builtin_shufflevector(*(const half *)(from[i] + at + j), *(const half *)(from[k] + at + j),  \
                            0, 1, 2, 3, 4, 5, 6, 7)
    const vec paired[] = {TWO(0), TWO(1), TWO(2), TWO(3)}; /* points 0 to 3, 4 to 7 of two rows */
    UNROLL for (int h = 0; h < 2; h++)
    {
        const vec a = paired[h], b = paired[2 + h], c = paired[4 + h], d = paired[6 + h];
        const vec even[] = {__builtin_shufflevector(a, b, 0, 8, 2, 10, 4, 12, 6, 14),
                            __builtin_shufflevector(c, d, 0, 8, 2, 10, 4, 12, 6, 14)};
        const vec odd[] = {__builtin_shufflevector(a, b, 1, 9, 3, 11, 5, 13, 7, 15),
                           __builtin_shufflevector(c, d, 1, 9, 3, 11, 5, 13, 7, 15)};
        const vec even_mixed = __builtin_shufflevector(even[0], even[1], 2, 3, 8, 9, 6, 7, 12, 13);
        const vec odd_mixed = __builtin_shufflevector(odd[0], odd[1], 2, 3, 8, 9, 6, 7, 12, 13);
        double *row = to + h * stride * 4;
        *(vec *)row = __builtin_shufflevector(even[0], even_mixed, 0, 1, 10, 11, 4, 5, 14, 15);
        *(vec *)(row + stride) =
            __builtin_shufflevector(odd[0], odd_mixed, 0, 1, 10, 11, 4, 5, 14, 15);
        *(vec *)(row + 2 * stride) =
            __builtin_shufflevector(even_mixed, even[1], 0, 1, 10, 11, 4, 5, 14, 15);
        *(vec *)(row + 3 * stride) =
            __builtin_shufflevector(odd_mixed, odd[1], 0, 1, 10, 11, 4, 5, 14, 15);
    }
#elif LANES == 4
#define HALVES(i, k, j)                                                                            \
    __builtin_shufflevector(*(const half *)(from[i] + at + j), *(const half *)(from[k] + at + j),  \
                            0, 1, 2, 3)
    UNROLL for (int j = 0; j < LANES; j += 2)
    {
        const vec a = HALVES(0, 2, j), b = HALVES(1, 3, j);
        *(vec *)(to + j * stride) = __builtin_shufflevector(a, b, 0, 4, 2, 6);
        *(vec *)(to + (j + 1) * stride) = __builtin_shufflevector(a, b, 1, 5, 3, 7);
    }
#else
    const vec a = *(const vec *)(from[0] + at), b = *(const vec *)(from[1] + at);
    *(vec *)to = __builtin_shufflevector(a, b, 0, 2);
    *(vec *)(to + stride) = __builtin_shufflevector(a, b, 1, 3);
#endif
}

/* to[j * to_stride + row] = x[row][j] of `vectors` LANES rows, of which x has `rows`; the last of
 * them stands for those that are missing. */
static void turn(int rows, int vectors, int points, const double *x, ptrdiff_t stride, double *to,
                 ptrdiff_t to_stride)
{
    for (int row = 0; row < vectors * LANES; row += LANES) {
        const double *from[LANES];
        for (int i = 0; i < LANES; i++) {
            from[i] = x + minimum(row + i, rows - 1) * stride;
        }
        for (int j = 0; j < points; j += LANES) {
            turn_block(from, j, to + j * to_stride + row, to_stride);
        }
    }
}

static void add_outer_sum(int m, int k, int points, const double *y, ptrdiff_t y_stride,
                          const double *x, ptrdiff_t x_stride, double *sum)
{
    double turned[PART * VECTORS * LANES] __attribute__((aligned(64)));
    for (int at = 0, left = pieces(points, PART), count; left > 0; left--, at += count) {
        count = minimum(pieces(pieces(points - at, left), LINE) * LINE, points - at);
        for (int j = 0, vectors; j < k; j += vectors * LANES) {
            vectors = next_vectors(k - j);
            const strip s = {count, k - j, y_stride, 1, turned, (ptrdiff_t)vectors * LANES, k, ADD};
            turn(minimum(k - j, vectors * LANES), vectors, count, x + j * x_stride + at, x_stride,
                 turned, (ptrdiff_t)vectors * LANES);
            run_strip(m, vectors, &s, y + at, sum + j, false);
        }
    }
}

/* Rows that are no whole block one number after the other. */
static void transpose(int rows, int points, double *out, ptrdiff_t stride, kernel_operand x)
{
    const int whole = rows / LANES * LANES;
    turn(whole, whole / LANES, points, x.at, x.stride, out, stride);
    for (int row = whole; row < rows; row++) {
        for (int j = 0; j < points; j++) {
            out[j * stride + row] = x.at[row * x.stride + j];
        }
    }
}

/* ---- panels --------------------------------------------------------------------------------- */

static void multiply_panels(size_t depth, const double *a, const double *b, bool subtract,
                            double *c)
{
    strip s = {(int)depth, 0, 1, PANEL, NULL, PANEL, PANEL, subtract ? SUBTRACT : ADD};
    for (int j = 0; j < PANEL; j += VECTORS * LANES) {
        s.b = b + j;
        s.width = PANEL - j;
        run_strip(PANEL, VECTORS, &s, a, c + j, false);
    }
}

enum { PANEL_VECTORS = PANEL / LANES };

static void combine_panels(int count, size_t depth, const double *const *by, const double *const *x,
                           double *out)
{
    for (size_t k = 0; k < depth; k++) {
        vec sum[PANEL_VECTORS] = {{0}};
        for (int i = 0; i < count; i++) {
            vec y = splat(by[i][k]);
            for (int j = 0; j < PANEL_VECTORS; j++) {
                sum[j] = v_mul_add(y, *(const vec *)(x[i] + k * PANEL + j * LANES), sum[j]);
            }
        }
        for (int j = 0; j < PANEL_VECTORS; j++) {
            *(vec *)(out + k * PANEL + j * LANES) = sum[j];
        }
    }
}

static void solve_tile(const double *u, double *x)
{
    for (int i = 0; i < PANEL; i++) {
        vec sum[PANEL_VECTORS] = {{0}};
        for (int k = 0; k < i; k++) {
            vec y = splat(u[k * PANEL + i]);
            for (int j = 0; j < PANEL_VECTORS; j++) {
                sum[j] = v_mul_add(y, *(vec *)(x + k * PANEL + j * LANES), sum[j]);
            }
        }
        for (int j = 0; j < PANEL_VECTORS; j++) {
            vec *to = (vec *)(x + i * PANEL + j * LANES);
            *to = (*to - sum[j]) / splat(u[i * PANEL + i]);
        }
    }
}

const product_set AD_PRODUCT_SET = {multiply,        add_outer_sum,  transpose,
                                    multiply_panels, combine_panels, solve_tile};
