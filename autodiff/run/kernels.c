/* One loop per elementwise operation of lanes.h. Compiled several times with different target
 * options; AD_KERNEL_SET names the result. */
#include "autodiff/compile/kernels.h"
#include "autodiff/run/lanes.h"

#include <string.h>

/* A loop over rows and points; `mask` and `arity` are known at compile time. Rows are short: what
 * counts is how little surrounds the inner loop. */
#define LOOP(name, expression)                                                                     \
    INLINE void name##_loop(int mask, int rows, int points, double *out, ptrdiff_t stride,         \
                            const kernel_operand *x, int arity, int whole, double number)          \
    {                                                                                              \
        (void)whole, (void)number;                                                                 \
        const double *at[4] = {NULL, NULL, NULL, NULL};                                            \
        ptrdiff_t next[4] = {0, 0, 0, 0};                                                          \
        for (int i = 0; i < arity; i++) {                                                          \
            at[i] = x[i].at;                                                                       \
            next[i] = x[i].stride;                                                                 \
        }                                                                                          \
        const ptrdiff_t end = points;                                                              \
        for (; rows > 0; rows--) {                                                                 \
            vec a = mask & 1 ? splat(*at[0]) : splat(0);                                           \
            vec b = mask & 2 ? splat(*at[1]) : splat(0);                                           \
            vec c = mask & 4 ? splat(*at[2]) : splat(0);                                           \
            vec d = mask & 8 ? splat(*at[3]) : splat(0);                                           \
            for (ptrdiff_t j = 0; j < end; j += LANES) {                                           \
                if (!(mask & 1)) {                                                                 \
                    a = *(const vec *)(at[0] + j);                                                 \
                }                                                                                  \
                if (arity > 1 && !(mask & 2)) {                                                    \
                    b = *(const vec *)(at[1] + j);                                                 \
                }                                                                                  \
                if (arity > 2 && !(mask & 4)) {                                                    \
                    c = *(const vec *)(at[2] + j);                                                 \
                }                                                                                  \
                if (arity > 3 && !(mask & 8)) {                                                    \
                    d = *(const vec *)(at[3] + j);                                                 \
                }                                                                                  \
                (void)b, (void)c, (void)d;                                                         \
                *(vec *)(out + j) = (expression);                                                  \
            }                                                                                      \
            for (int i = 0; i < arity; i++) {                                                      \
                at[i] += next[i];                                                                  \
            }                                                                                      \
            out += stride;                                                                         \
        }                                                                                          \
    }

#define VARIANT(name, arity, mask)                                                                 \
    static void name##_##mask(int rows, int points, double *out, ptrdiff_t stride,                 \
                              const kernel_operand *x, int whole, double number)                   \
    {                                                                                              \
        name##_loop(mask, rows, points, out, stride, x, arity, whole, number);                     \
    }

#define LOOP1(name, expression)                                                                    \
    LOOP(name, expression)                                                                         \
    VARIANT(name, 1, 0)                                                                            \
    VARIANT(name, 1, 1)
#define LOOP2(name, expression)                                                                    \
    LOOP(name, expression)                                                                         \
    VARIANT(name, 2, 0)                                                                            \
    VARIANT(name, 2, 1)                                                                            \
    VARIANT(name, 2, 2)
#define LOOP3(name, expression)                                                                    \
    LOOP(name, expression)                                                                         \
    VARIANT(name, 3, 0)                                                                            \
    VARIANT(name, 3, 1)                                                                            \
    VARIANT(name, 3, 2)                                                                            \
    VARIANT(name, 3, 3)                                                                            \
    VARIANT(name, 3, 4)                                                                            \
    VARIANT(name, 3, 5)                                                                            \
    VARIANT(name, 3, 6)

#define LOOP4(name, expression)                                                                    \
    LOOP(name, expression)                                                                         \
    VARIANT(name, 4, 0)                                                                            \
    VARIANT(name, 4, 1)                                                                            \
    VARIANT(name, 4, 2)                                                                            \
    VARIANT(name, 4, 3)                                                                            \
    VARIANT(name, 4, 4)                                                                            \
    VARIANT(name, 4, 5)                                                                            \
    VARIANT(name, 4, 6)                                                                            \
    VARIANT(name, 4, 7)                                                                            \
    VARIANT(name, 4, 8)                                                                            \
    VARIANT(name, 4, 9)                                                                            \
    VARIANT(name, 4, 10)                                                                           \
    VARIANT(name, 4, 11)                                                                           \
    VARIANT(name, 4, 12)                                                                           \
    VARIANT(name, 4, 13)                                                                           \
    VARIANT(name, 4, 14)

#define OPERATION(code, name, arity, kind, rule, numbers, vectors, text) LOOP##arity(name, vectors)
AD_ELEMENTWISE(OPERATION)

static void sum_points(int rows, int points, double *sum, kernel_operand x)
{
    enum { PARTS = 8 }; /* the same for every instruction set: so is the order of the sum */
    for (int row = 0; row < rows; row++) {
        const double *from = x.at + row * x.stride;
        vec parts[PARTS / LANES];
        double part[PARTS];
        int j = 0;
        for (int i = 0; i < PARTS / LANES; i++) {
            parts[i] = splat(0);
        }
        for (; j + PARTS <= points; j += PARTS) {
            for (int i = 0; i < PARTS / LANES; i++) {
                parts[i] += *(const vec *)(from + j + i * LANES);
            }
        }
        memcpy(part, parts, sizeof part);
        for (int i = 0; j + i < points; i++) {
            part[i] += from[j + i];
        }
        for (int half = PARTS / 2; half > 0; half /= 2) {
            for (int i = 0; i < half; i++) {
                part[i] += part[i + half];
            }
        }
        sum[row] += part[0];
    }
}

static void add_outer(int columns, int points, double *out, ptrdiff_t stride, const double *y,
                      kernel_operand x)
{
    for (int k = 0; k < columns; k++) {
        double *restrict to = out + k * stride;
        const double *restrict from = x.at + k * x.stride;
        for (int j = 0; j < points; j++) {
            to[j] = mul_add(y[j], from[j], to[j]);
        }
    }
}

#define ROW1(name)                                                                                 \
    {                                                                                              \
        name##_0, name##_1                                                                         \
    }
#define ROW2(name)                                                                                 \
    {                                                                                              \
        name##_0, name##_1, name##_2                                                               \
    }
#define ROW3(name)                                                                                 \
    {                                                                                              \
        name##_0, name##_1, name##_2, name##_3, name##_4, name##_5, name##_6                       \
    }

#define ROW4(name)                                                                                 \
    {                                                                                              \
        name##_0, name##_1, name##_2, name##_3, name##_4, name##_5, name##_6, name##_7, name##_8,  \
            name##_9, name##_10, name##_11, name##_12, name##_13, name##_14                        \
    }

#define ROW(code, name, arity, kind, rule, numbers, vectors, text) [OP_##code] = ROW##arity(name),

extern const product_set AD_PRODUCT_SET;

const kernel_set AD_KERNEL_SET = {
    .name = AD_KERNEL_NAME,
    .flags = AD_KERNEL_FLAGS,
    .loops = {AD_ELEMENTWISE(ROW)},
    .sum_points = sum_points,
    .add_outer = add_outer,
    .products = &AD_PRODUCT_SET,
};
