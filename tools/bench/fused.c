/* See fused.h. Layout: a layer's values of one tile are [coefficient][point][feature], five stacked
 * blocks of tile x 64, so that one product per layer covers all coefficients, and every product of
 * the step is of a kind that needs no transposed copy inside BLAS (the transposed weights are made
 * once per step):
 *
 *     forward   Z  = Y W^T     no-trans, no-trans     rows = 5 tile
 *     backward  Y' = Z' W      no-trans, no-trans
 *     weights   W' += Z'^T Y   trans, no-trans        inner = 5 tile
 *
 * Only the outputs of tanh are kept for the way back. With G = 1 - Y^2 as a series in s (or t), the
 * linearised tanh is dY = G dZ as a product of series, because Y' = (1 - Y^2) Z'; its transpose
 * needs G, G_s = -2 y y_s and G_ss = -2 (y y_ss + y_s^2), never z_s or z_ss.
 *
 * The file includes itself once per instruction set: its first half holds the elementwise part. */
#ifdef FUSED_ISA

typedef double real __attribute__((vector_size(FUSED_BYTES), may_alias));
typedef long long bits __attribute__((vector_size(FUSED_BYTES), may_alias));

/* tanh x = e / (2 + e), e = exp(2 x) - 1 = 2^k (r + r^2 q(r)) + (2^k - 1), |r| <= ln(2)/2 (Cody and
 * Waite's reduction); q interpolates (exp(r) - 1 - r) / r^2 at Chebyshev points, error of e below
 * 2^-60 of it. Even and odd powers are two chains: half the latency. NaN stays NaN. */
INLINED real NAMED(tanh_of)(real x)
{
    const real magic = ALL(0x1.8p52);
    const bits above = (bits)(x > 20.0), below = (bits)(x < -20.0); /* there tanh rounds to +-1 */
    x = (real)(((bits)x & ~above) | ((bits)ALL(20.0) & above));
    x = (real)(((bits)x & ~below) | ((bits)ALL(-20.0) & below));
    const real shifted = x * 0x1.71547652b82fep+1 + magic;
    const real k = shifted - magic;
    const real r = (x * 2.0 - k * 0x1.62e42fefa3800p-1) - k * 0x1.ef35793c76730p-45;
    const real scale = (real)(((bits)shifted << 52) + (bits)ALL(1.0));
    const real r2 = r * r;
    real even = r2 * 0x1.1f730349868cep-29 + 0x1.27e4db646b17ep-22;
    real odd = r2 * 0x1.af4de97ca4194p-26 + 0x1.71de0231960ebp-19;
    even = even * r2 + 0x1.a01a01a6d889cp-16;
    odd = odd * r2 + 0x1.a01a01abe7fe1p-13;
    even = even * r2 + 0x1.6c16c16c162d4p-10;
    odd = odd * r2 + 0x1.11111111100dcp-7;
    even = even * r2 + 0x1.5555555555556p-5;
    odd = odd * r2 + 0x1.5555555555557p-3;
    even = even * r2 + 0.5;
    const real p = (odd * r + even) * r2 + r;
    const real e = scale * p + (scale - 1.0);
    return e / (e + 2.0);
}

/* y[5][tile][64] of the first layer: z = w_s s + w_t t + b, so z_ss = z_tt = 0. */
KERNEL NAMED(first_forward)(double *y, const double *w_s, const double *w_t, const double *bias,
                            const double *s, const double *t, int tile)
{
    const size_t block = (size_t)tile * STRIDE;
    for (int point = 0; point < tile; point++) {
        double *row = y + (size_t)point * STRIDE;
        for (int f = 0; f < FUSED_WIDTH; f += LANES) {
            const real z_s = LOAD(w_s + f), z_t = LOAD(w_t + f);
            const real v = NAMED(tanh_of)(z_s * s[point] + (z_t * t[point] + LOAD(bias + f)));
            const real g = 1.0 - v * v, h = -2.0 * v;
            const real v_s = g * z_s, v_t = g * z_t;
            STORE(row + f, v);
            STORE(row + block + f, v_s);
            STORE(row + 2 * block + f, h * v_s * z_s);
            STORE(row + 3 * block + f, v_t);
            STORE(row + 4 * block + f, h * v_t * z_t);
        }
    }
}

/* y[5][tile][64] in place: from W y (no bias) of the layer below to tanh of it. */
KERNEL NAMED(hidden_forward)(double *y, const double *bias, int tile)
{
    const size_t block = (size_t)tile * STRIDE;
    for (int point = 0; point < tile; point++) {
        double *row = y + (size_t)point * STRIDE;
        for (int f = 0; f < FUSED_WIDTH; f += LANES)
            STORE(row + f, NAMED(tanh_of)(LOAD(row + f) + LOAD(bias + f)));
        for (int f = 0; f < FUSED_WIDTH; f += LANES) {
            const real v = LOAD(row + f);
            const real g = 1.0 - v * v, h = -2.0 * v;
            const real z_s = LOAD(row + block + f), z_t = LOAD(row + 3 * block + f);
            const real v_s = g * z_s, v_t = g * z_t;
            STORE(row + block + f, v_s);
            STORE(row + 2 * block + f, g * LOAD(row + 2 * block + f) + h * v_s * z_s);
            STORE(row + 3 * block + f, v_t);
            STORE(row + 4 * block + f, g * LOAD(row + 4 * block + f) + h * v_t * z_t);
        }
    }
}

struct NAMED(series) {
    real z, s, ss, t, tt;
};

/* The adjoints of z, z_s, ... at one place of a layer, from those of y = tanh(z) and y itself;
 * `block` doubles from coefficient to coefficient. */
INLINED struct NAMED(series)
    NAMED(adjoint_of_tanh)(const double *adj, const double *y, size_t block)
{
    const real v = LOAD(y), v_s = LOAD(y + block), v_t = LOAD(y + 3 * block);
    const real g = 1.0 - v * v, h = -2.0 * v, g_s = h * v_s, g_t = h * v_t;
    const real g_ss = h * LOAD(y + 2 * block) - 2.0 * v_s * v_s;
    const real g_tt = h * LOAD(y + 4 * block) - 2.0 * v_t * v_t;
    const real a_s = LOAD(adj + block), a_ss = LOAD(adj + 2 * block);
    const real a_t = LOAD(adj + 3 * block), a_tt = LOAD(adj + 4 * block);
    const real a_z = g * LOAD(adj) + g_s * a_s + g_ss * a_ss + (g_t * a_t + g_tt * a_tt);
    return (struct NAMED(series)){a_z, g * a_s + 2.0 * g_s * a_ss, g * a_ss,
                                  g * a_t + 2.0 * g_t * a_tt, g * a_tt};
}

/* adj[5][tile][64] in place: from the adjoint of y = tanh(z) to that of z; bias_adj[64] += sum over
 * the points. Four points at a time, so that the sum is touched once for all of them. */
KERNEL NAMED(hidden_backward)(double *adj, const double *y, double *bias_adj, int tile)
{
    const size_t block = (size_t)tile * STRIDE;
    for (int point = 0; point < tile; point += 4) {
        for (int f = 0; f < FUSED_WIDTH; f += LANES) {
            real sum = LOAD(bias_adj + f);
            for (int j = 0; j < 4; j++) {
                const size_t at = (size_t)(point + j) * STRIDE + (size_t)f;
                const struct NAMED(series) a = NAMED(adjoint_of_tanh)(adj + at, y + at, block);
                sum += a.z;
                STORE(adj + at, a.z);
                STORE(adj + at + block, a.s);
                STORE(adj + at + 2 * block, a.ss);
                STORE(adj + at + 3 * block, a.t);
                STORE(adj + at + 4 * block, a.tt);
            }
            STORE(bias_adj + f, sum);
        }
    }
}

/* The same for the first layer, whose adjoint goes no further than its parameters:
 * sums[3][64] += adjoints of w_s, w_t, b. The adjoints of z_ss and z_tt are not wanted. */
KERNEL NAMED(first_backward)(const double *adj, const double *y, const double *s, const double *t,
                             double *sums, int tile)
{
    const size_t block = (size_t)tile * STRIDE;
    for (int point = 0; point < tile; point += 4) {
        for (int f = 0; f < FUSED_WIDTH; f += LANES) {
            real sum_s = LOAD(sums + f), sum_t = LOAD(sums + FUSED_WIDTH + f);
            real sum = LOAD(sums + 2 * FUSED_WIDTH + f);
            for (int j = 0; j < 4; j++) {
                const size_t at = (size_t)(point + j) * STRIDE + (size_t)f;
                const struct NAMED(series) a = NAMED(adjoint_of_tanh)(adj + at, y + at, block);
                sum += a.z;
                sum_s += a.z * s[point + j] + a.s;
                sum_t += a.z * t[point + j] + a.t;
            }
            STORE(sums + f, sum_s);
            STORE(sums + FUSED_WIDTH + f, sum_t);
            STORE(sums + 2 * FUSED_WIDTH + f, sum);
        }
    }
}

#include "fused_rod.h"

static const struct kernels NAMED(kernels) = {NAMED(first_forward), NAMED(hidden_forward),
                                              NAMED(hidden_backward), NAMED(first_backward),
                                              NAMED(residual)};

#undef FUSED_ISA
#undef FUSED_BYTES
#undef FUSED_TARGET

#else

#include "fused.h"
#include "rod_case.h"

#include <pthread.h>
#include <stdatomic.h>
#include <stdlib.h>
#include <string.h>

/* ISO C mode forbids a * b + c to become one instruction; the kernels want it. */
#if defined(__GNUC__) && !defined(__clang__)
#pragma GCC optimize("fp-contract=fast")
#endif

enum {
    COEFFICIENTS = 5,
    HIDDEN = 4,
    PADDED = 8,  /* the seven outputs, and a zero to fill the vector */
    CHUNKS = 16, /* the points are dealt to so many sums, whatever the number of threads */
    SQUARE = FUSED_WIDTH * FUSED_WIDTH,
    STRIDE = 72, /* doubles from row to row: 64 would put a column into few cache sets */
    /* A product of more than 10^6 multiply-adds leaves OpenBLAS's small-matrix kernels, which read
     * the operands where they are, for those that copy them first: 1.6 times slower here. A long
     * inner dimension overflows the cache. */
    OUTER_ROWS = 160,
    INNER_ROWS = 80,
    ROW_MAJOR = 101,
    NO_TRANS = 111,
    TRANS = 112
};

struct kernels {
    void (*first_forward)(double *y, const double *w_s, const double *w_t, const double *bias,
                          const double *s, const double *t, int tile);
    void (*hidden_forward)(double *y, const double *bias, int tile);
    void (*hidden_backward)(double *adj, const double *y, double *bias_adj, int tile);
    void (*first_backward)(const double *adj, const double *y, const double *s, const double *t,
                           double *sums, int tile);
    double (*residual)(double *out, const double *bias, double *bias_adj, const double *s,
                       const double *t, double scale, int valid, int tile);
};

/* What the kernels are written with; see the first half for the names they expand to. */
#define FUSED_PASTE(name, isa)  name##_##isa
#define FUSED_EXPAND(name, isa) FUSED_PASTE(name, isa)
#define NAMED(name)             FUSED_EXPAND(name, FUSED_ISA)
#define KERNEL                  FUSED_TARGET static void
#define INLINED                 FUSED_TARGET static inline __attribute__((always_inline))
#define real                    NAMED(real)
#define bits                    NAMED(bits)
#define LANES                   (FUSED_BYTES / 8)
#define LOAD(pointer)           (*(const real *)(pointer))
#define STORE(pointer, value)   (*(real *)(pointer) = (value))
#define ALL(value)              ((real){0} + (value))

#if defined(__x86_64__)
#define FUSED_ISA    avx512
#define FUSED_BYTES  64
#define FUSED_TARGET __attribute__((target("avx512f,avx512dq,avx2,fma")))
#include "fused.c"
#define FUSED_ISA    avx2
#define FUSED_BYTES  32
#define FUSED_TARGET __attribute__((target("avx2,fma")))
#include "fused.c"
#endif
#define FUSED_ISA   plain
#define FUSED_BYTES 16
#define FUSED_TARGET
#include "fused.c"

/* The parameters as the kernels read them, and their adjoints in the same places: the flat order
 * but for w_s and w_t taken apart and the last layer padded with zeros. */
enum {
    W_S = 0,
    W_T = FUSED_WIDTH,
    FIRST_BIAS = 2 * FUSED_WIDTH,
    HIDDEN_WEIGHTS = 3 * FUSED_WIDTH, /* [out][in], then bias[out], then the next layer */
    HIDDEN_SLOTS = SQUARE + FUSED_WIDTH,
    LAST_WEIGHTS = HIDDEN_WEIGHTS + (HIDDEN - 1) * HIDDEN_SLOTS,
    LAST_BIAS = LAST_WEIGHTS + PADDED * FUSED_WIDTH,
    SLOTS = LAST_BIAS + PADDED,
    FLAT_LAST_BIAS = LAST_WEIGHTS + FUSED_OUTPUTS * FUSED_WIDTH,
    TURNED_SLOTS = (HIDDEN - 1) * SQUARE + PADDED * FUSED_WIDTH /* [in][out] of each layer */
};

typedef struct chunk {
    double adj[SLOTS];
    double loss;
    double filler[7]; /* the next chunk starts on a cache line of its own */
} chunk;

typedef struct workspace {
    double *y[HIDDEN + 2]; /* [5][tile][64] each; the last two for adjoints */
    double *out;           /* [5][tile][8] */
    double *s, *t;         /* [tile] */
} workspace;

typedef struct worker {
    fused_state *state;
    workspace space;
    pthread_t thread;
} worker;

struct fused_state {
    fused_blas blas;
    const struct kernels *kernels;
    int tile, threads, started;
    double *params, *turned; /* [SLOTS], [TURNED_SLOTS] */
    chunk *chunks;           /* [CHUNKS] */
    double *memory;          /* of all workspaces */
    worker *workers;
    /* the step at hand */
    const double *s, *t;
    size_t points;
    /* the pool: a new `round` starts the workers, `busy` counts those still at it */
    pthread_mutex_t mutex;
    pthread_cond_t start, done;
    unsigned long round;
    int busy, stop;
    atomic_int next_chunk;
};

/* c[rows][n] = a[rows][k] b[k][n], rows lda and ldc apart, in pieces that the small-matrix kernels
 * take. */
static void multiply(const fused_state *state, int rows, int n, int k, const double *a, int lda,
                     const double *b, double *c, int ldc)
{
    for (int row = 0; row < rows; row += OUTER_ROWS) {
        const int count = rows - row < OUTER_ROWS ? rows - row : OUTER_ROWS;
        state->blas.dgemm(ROW_MAJOR, NO_TRANS, NO_TRANS, count, n, k, 1.0, a + (size_t)row * lda,
                          lda, b, n, 0.0, c + (size_t)row * ldc, ldc);
    }
}

/* c[m][64] += a[rows][m]^T b[rows][64], rows lda and STRIDE apart. */
static void accumulate(const fused_state *state, int rows, int m, const double *a, int lda,
                       const double *b, double *c)
{
    for (int row = 0; row < rows; row += INNER_ROWS) {
        const int count = rows - row < INNER_ROWS ? rows - row : INNER_ROWS;
        state->blas.dgemm(ROW_MAJOR, TRANS, NO_TRANS, m, FUSED_WIDTH, count, 1.0,
                          a + (size_t)row * lda, lda, b + (size_t)row * STRIDE, STRIDE, 1.0, c,
                          FUSED_WIDTH);
    }
}

/* One tile, its points in `space`: forward, residual, backward; adds to the chunk's loss and
 * adjoint. */
static void run_tile(const fused_state *state, const workspace *space, int valid, chunk *sum)
{
    const struct kernels *kernels = state->kernels;
    const double *params = state->params, *turned = state->turned, *s = space->s, *t = space->t;
    double *adj = sum->adj;
    const int tile = state->tile, rows = COEFFICIENTS * tile, width = FUSED_WIDTH;
    double *const *y = space->y;

    kernels->first_forward(y[0], params + W_S, params + W_T, params + FIRST_BIAS, s, t, tile);
    for (int layer = 0; layer < HIDDEN - 1; layer++) {
        const double *bias = params + HIDDEN_WEIGHTS + layer * HIDDEN_SLOTS + SQUARE;
        multiply(state, rows, width, width, y[layer], STRIDE, turned, y[layer + 1], STRIDE);
        kernels->hidden_forward(y[layer + 1], bias, tile);
        turned += SQUARE;
    }
    multiply(state, rows, PADDED, width, y[HIDDEN - 1], STRIDE, turned, space->out, PADDED);
    sum->loss += kernels->residual(space->out, params + LAST_BIAS, adj + LAST_BIAS, s, t,
                                   1.0 / (double)state->points, valid, tile);

    double *upper = y[HIDDEN];
    accumulate(state, rows, PADDED, space->out, PADDED, y[HIDDEN - 1], adj + LAST_WEIGHTS);
    multiply(state, rows, width, PADDED, space->out, PADDED, params + LAST_WEIGHTS, upper, STRIDE);
    for (int layer = HIDDEN - 2; layer >= 0; layer--) {
        const int at = HIDDEN_WEIGHTS + layer * HIDDEN_SLOTS;
        kernels->hidden_backward(upper, y[layer + 1], adj + at + SQUARE, tile);
        accumulate(state, rows, width, upper, STRIDE, y[layer], adj + at);
        double *const lower = y[HIDDEN + (upper == y[HIDDEN])];
        multiply(state, rows, width, width, upper, STRIDE, params + at, lower, STRIDE);
        upper = lower;
    }
    kernels->first_backward(upper, y[0], s, t, adj + W_S, tile);
}

static void run_chunk(const fused_state *state, const workspace *space, int index)
{
    const size_t tile = (size_t)state->tile, tiles = (state->points + tile - 1) / tile;
    chunk *sum = &state->chunks[index];
    memset(sum, 0, sizeof *sum);
    const size_t end = tiles * (size_t)(index + 1) / CHUNKS;
    for (size_t at = tiles * (size_t)index / CHUNKS; at < end; at++) {
        const size_t first = at * tile, left = state->points - first;
        const size_t valid = left < tile ? left : tile;
        memcpy(space->s, state->s + first, valid * sizeof *space->s);
        memcpy(space->t, state->t + first, valid * sizeof *space->t);
        memset(space->s + valid, 0, (tile - valid) * sizeof *space->s);
        memset(space->t + valid, 0, (tile - valid) * sizeof *space->t);
        run_tile(state, space, (int)valid, sum);
    }
}

static void run_chunks(fused_state *state, const workspace *space)
{
    int index;
    while ((index = atomic_fetch_add(&state->next_chunk, 1)) < CHUNKS) {
        run_chunk(state, space, index);
    }
}

static void *work(void *argument)
{
    worker *self = argument;
    fused_state *state = self->state;
    unsigned long seen = 0;
    for (;;) {
        pthread_mutex_lock(&state->mutex);
        while (state->round == seen && !state->stop) {
            pthread_cond_wait(&state->start, &state->mutex);
        }
        seen = state->round;
        const int stop = state->stop;
        pthread_mutex_unlock(&state->mutex);
        if (stop) {
            return NULL;
        }
        run_chunks(state, &self->space);
        pthread_mutex_lock(&state->mutex);
        if (--state->busy == 0) {
            pthread_cond_signal(&state->done);
        }
        pthread_mutex_unlock(&state->mutex);
    }
}

/* out[in_count][stride] = in[out_count][in_count] transposed. */
static void turn(double *out, int stride, const double *in, int out_count, int in_count)
{
    for (int i = 0; i < out_count; i++) {
        for (int j = 0; j < in_count; j++) {
            out[j * stride + i] = in[i * in_count + j];
        }
    }
}

static void unpack(fused_state *state, const double *flat)
{
    double *params = state->params, *turned = state->turned;
    turn(params, FUSED_WIDTH, flat, FUSED_WIDTH, FUSED_INPUTS);
    memcpy(params + FIRST_BIAS, flat + FIRST_BIAS, (FLAT_LAST_BIAS - FIRST_BIAS) * sizeof *flat);
    /* the network is one of 2 s - 1 and 2 t / duration - 1 */
    for (int i = 0; i < FUSED_WIDTH; i++) {
        params[FIRST_BIAS + i] -= params[W_S + i] + params[W_T + i];
        params[W_S + i] *= 2.0;
        params[W_T + i] *= 2.0 / rod_case_numbers.duration;
    }
    memcpy(params + LAST_BIAS, flat + FLAT_LAST_BIAS, FUSED_OUTPUTS * sizeof *flat);
    for (int layer = 0; layer < HIDDEN - 1; layer++) {
        turn(turned + layer * SQUARE, FUSED_WIDTH, flat + HIDDEN_WEIGHTS + layer * HIDDEN_SLOTS,
             FUSED_WIDTH, FUSED_WIDTH);
    }
    turn(turned + (HIDDEN - 1) * SQUARE, PADDED, flat + LAST_WEIGHTS, FUSED_OUTPUTS, FUSED_WIDTH);
}

/* grad += one chunk's adjoint, back in the flat order. */
static void add_flat(double *grad, const double *adj)
{
    for (int i = 0; i < FUSED_WIDTH; i++) {
        const double bias = adj[FIRST_BIAS + i];
        grad[FUSED_INPUTS * i] += 2.0 * adj[W_S + i] - bias;
        grad[FUSED_INPUTS * i + 1] += 2.0 / rod_case_numbers.duration * adj[W_T + i] - bias;
    }
    for (int i = FIRST_BIAS; i < FLAT_LAST_BIAS; i++) {
        grad[i] += adj[i];
    }
    for (int i = 0; i < FUSED_OUTPUTS; i++) {
        grad[FLAT_LAST_BIAS + i] += adj[LAST_BIAS + i];
    }
}

void fused_step(fused_state *state, const double *params, const double *s, const double *t,
                size_t n, double *loss, double *grad)
{
    unpack(state, params);
    pthread_mutex_lock(&state->mutex);
    state->s = s;
    state->t = t;
    state->points = n;
    atomic_store(&state->next_chunk, 0);
    state->busy = state->threads - 1;
    state->round++;
    pthread_cond_broadcast(&state->start);
    pthread_mutex_unlock(&state->mutex);
    run_chunks(state, &state->workers[0].space);
    pthread_mutex_lock(&state->mutex);
    while (state->busy > 0) {
        pthread_cond_wait(&state->done, &state->mutex);
    }
    pthread_mutex_unlock(&state->mutex);

    *loss = 0.0;
    memset(grad, 0, FUSED_PARAMETERS * sizeof *grad);
    for (int i = 0; i < CHUNKS; i++) {
        *loss += state->chunks[i].loss / (double)n;
        add_flat(grad, state->chunks[i].adj);
    }
}

static const struct kernels *choose_kernels(void)
{
#if defined(__x86_64__)
    __builtin_cpu_init();
    if (__builtin_cpu_supports("avx512f") && __builtin_cpu_supports("avx512dq")) {
        return &kernels_avx512;
    }
    if (__builtin_cpu_supports("avx2") && __builtin_cpu_supports("fma")) {
        return &kernels_avx2;
    }
#endif
    return &kernels_plain;
}

/* Zeroed and aligned to a page, or NULL. */
static void *zeroed(size_t bytes)
{
    void *memory = NULL;
    if (posix_memalign(&memory, 4096, bytes) != 0) {
        return NULL;
    }
    return memset(memory, 0, bytes);
}

/* Cut the workspaces out of one block; `memory` == NULL only counts. Returns doubles per worker. */
static size_t lay_out(workspace *space, double *memory, size_t tile)
{
    const size_t layer = COEFFICIENTS * tile * STRIDE, out = COEFFICIENTS * tile * PADDED;
    if (memory != NULL) {
        for (int i = 0; i < HIDDEN + 2; i++) {
            space->y[i] = memory + (size_t)i * layer;
        }
        space->out = memory + (HIDDEN + 2) * layer;
        space->s = space->out + out;
        space->t = space->s + tile;
    }
    return ((HIDDEN + 2) * layer + out + 2 * tile + 511) / 512 * 512;
}

static int allocate(fused_state *state)
{
    const size_t threads = (size_t)state->threads, tile = (size_t)state->tile;
    const size_t each = lay_out(NULL, NULL, tile);
    state->params = zeroed(SLOTS * sizeof *state->params);
    state->turned = zeroed(TURNED_SLOTS * sizeof *state->turned);
    state->chunks = zeroed(CHUNKS * sizeof *state->chunks);
    state->memory = zeroed(threads * each * sizeof *state->memory);
    state->workers = zeroed(threads * sizeof *state->workers);
    if (state->params == NULL || state->turned == NULL || state->chunks == NULL ||
        state->memory == NULL || state->workers == NULL) {
        return 0;
    }
    for (size_t i = 0; i < threads; i++) {
        state->workers[i].state = state;
        lay_out(&state->workers[i].space, state->memory + i * each, tile);
    }
    return 1;
}

fused_state *fused_create(const fused_blas *blas, int tile, int threads)
{
    tile = tile == 0 ? FUSED_DEFAULT_TILE : tile;
    if (blas == NULL || blas->dgemm == NULL || tile < 8 || tile > FUSED_MAX_TILE || tile % 8 != 0 ||
        threads < 1 || threads > FUSED_MAX_THREADS) {
        return NULL;
    }
    fused_state *state = zeroed(sizeof *state);
    if (state == NULL) {
        return NULL;
    }
    state->blas = *blas;
    state->kernels = choose_kernels();
    state->tile = tile;
    state->threads = threads;
    /* With default attributes these cannot fail on the systems this is built for. */
    pthread_mutex_init(&state->mutex, NULL);
    pthread_cond_init(&state->start, NULL);
    pthread_cond_init(&state->done, NULL);
    int ready = allocate(state);
    for (int i = 1; ready && i < threads; i++) {
        worker *helper = &state->workers[i];
        ready = pthread_create(&helper->thread, NULL, work, helper) == 0;
        state->started += ready;
    }
    if (ready) {
        return state;
    }
    fused_free(state);
    return NULL;
}

void fused_free(fused_state *state)
{
    if (state == NULL) {
        return;
    }
    pthread_mutex_lock(&state->mutex);
    state->stop = 1;
    pthread_cond_broadcast(&state->start);
    pthread_mutex_unlock(&state->mutex);
    for (int i = 1; i <= state->started; i++) {
        pthread_join(state->workers[i].thread, NULL);
    }
    pthread_cond_destroy(&state->done);
    pthread_cond_destroy(&state->start);
    pthread_mutex_destroy(&state->mutex);
    free(state->workers);
    free(state->memory);
    free(state->chunks);
    free(state->turned);
    free(state->params);
    free(state);
}

#endif
