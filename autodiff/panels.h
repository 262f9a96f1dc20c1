/* Products, combinations and triangular solves of panels, for products.c: see kernels.h. A piece of
 * a tile, PIECE_ROWS x PIECE_VECTORS vectors, stays in registers while its sums grow. Private. */
#ifndef AD_PANELS_H
#define AD_PANELS_H

#include "autodiff/kernels.h"
#include "autodiff/lanes.h"

#if LANES == 8
enum { PIECE_ROWS = 8, PIECE_VECTORS = 3 };
#elif LANES == 4
enum { PIECE_ROWS = 4, PIECE_VECTORS = 3 };
#else
enum { PIECE_ROWS = 4, PIECE_VECTORS = 2 };
#endif

INLINE void multiply_piece(size_t depth, const double *a, const double *b, double scale, double *c)
{
    vec sum[PIECE_ROWS][PIECE_VECTORS] = {{{0}}};
    for (size_t k = 0; k < depth; k++) {
        vec x[PIECE_VECTORS];
#pragma GCC unroll 8
        for (int j = 0; j < PIECE_VECTORS; j++) {
            x[j] = *(const vec *)(b + k * PANEL + j * LANES);
        }
#pragma GCC unroll 8
        for (int i = 0; i < PIECE_ROWS; i++) {
            vec y = splat(a[k * PANEL + i]);
#pragma GCC unroll 8
            for (int j = 0; j < PIECE_VECTORS; j++) {
                sum[i][j] = v_mul_add(y, x[j], sum[i][j]);
            }
        }
    }
#pragma GCC unroll 8
    for (int i = 0; i < PIECE_ROWS; i++) {
#pragma GCC unroll 8
        for (int j = 0; j < PIECE_VECTORS; j++) {
            vec *to = (vec *)(c + i * PANEL + j * LANES);
            *to = v_mul_add(splat(scale), sum[i][j], *to);
        }
    }
}

static void multiply_panels(size_t depth, const double *a, const double *b, double scale, double *c)
{
    for (int j = 0; j < PANEL; j += PIECE_VECTORS * LANES) {
        for (int i = 0; i < PANEL; i += PIECE_ROWS) {
            multiply_piece(depth, a + i, b + j, scale, c + i * PANEL + j);
        }
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

#endif
