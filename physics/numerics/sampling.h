/* Point sets in the unit cube [0,1]^dimension: where residuals and conditions are evaluated.
 *
 * A set is an array [dimension][count] of doubles owned by the caller, each coordinate contiguous.
 *
 *   uniform            independent, on [0,1)
 *   latin_hypercube    one point in each of `count` equal slices of every coordinate (McKay,
 *                      Beckman and Conover 1979)
 *   sobol              Sobol' sequence in Gray-code order (Bratley and Fox 1988, algorithm 659),
 *                      direction numbers of Joe and Kuo (2008, new-joe-kuo-6). Begins with index 0:
 *                      leaving it out would spoil the balance of 2^m points (Owen 2020). With a
 *                      generator, every coordinate is exclusive-or'ed with 53 random bits (digital
 *                      shift), which keeps the balance, avoids the origin and makes each call a new
 *                      set; without one, the plain sequence.
 *   chebyshev          tensor grid of Chebyshev-Gauss points (1 - cos((2i+1)pi/2n))/2, no ends
 *   chebyshev_lobatto  tensor grid of Chebyshev-Gauss-Lobatto points (1 - cos(i pi/(n-1)))/2
 *   grid               tensor grid of equispaced points, ends included
 *
 * The last three are tensor grids n1 x n2 x n3; the first coordinate varies slowest. They need a
 * count that has such a shape: see sampling_grid_shape. */
#ifndef PHYSICS_NUMERICS_SAMPLING_H
#define PHYSICS_NUMERICS_SAMPLING_H

#include "autodiff/error.h"
#include "nn/rng.h"

#include <stdbool.h>
#include <stddef.h>

#ifdef __cplusplus
extern "C" {
#endif

/* One row per kind: name, text in a scene file, needs a generator, is a tensor grid. */
#define SAMPLING_KIND_LIST(X)                                                                      \
    X(SAMPLING_UNIFORM, "uniform", true, false)                                                    \
    X(SAMPLING_LATIN_HYPERCUBE, "latin_hypercube", true, false)                                    \
    X(SAMPLING_SOBOL, "sobol", false, false)                                                       \
    X(SAMPLING_CHEBYSHEV, "chebyshev", false, true)                                                \
    X(SAMPLING_CHEBYSHEV_LOBATTO, "chebyshev_lobatto", false, true)                                \
    X(SAMPLING_GRID, "grid", false, true)

typedef enum sampling_kind {
#define SAMPLING_KIND_ENUM(name, text, random, tensor) name,
    SAMPLING_KIND_LIST(SAMPLING_KIND_ENUM)
#undef SAMPLING_KIND_ENUM
        SAMPLING_KIND_COUNT
} sampling_kind;

enum { SAMPLING_MAX_DIMENSION = 48, SAMPLING_MAX_GRID_DIMENSION = 3 };

/* Text of a kind, never NULL. */
const char *sampling_kind_text(sampling_kind kind);

bool sampling_kind_is_tensor(sampling_kind kind);

/* Points from 0 to a length, ascending: `even` of them, at least 2, the last exactly the length.
 * Those of `more` [count] that lie between and are none of them are added, others and NaN left out.
 * s has room for all. How many there are. */
size_t sampling_along(double length, size_t even, size_t count, const double *more, double *s);

/* Shape of the tensor grid with at most `count` points: the largest number of points <= count that
 * is a product of axis lengths >= 2 of which every ratio is within a factor of 2. Among the shapes
 * with that number it is the nearest to a cube, by the least sum of squared logarithms of ratios.
 * Of equals it is the one with the shorter first axis. So 1000 gives 25 x 40 and 997 gives
 * 992 = 31 x 32. A count that this function gave back is given back unchanged. *actual receives
 * the product. AD_BAD_ARGUMENT: dimension not 1..3, or no shape fits.
 */
ad_status sampling_grid_shape(int dimension, size_t count,
                              size_t shape[SAMPLING_MAX_GRID_DIMENSION], size_t *actual,
                              ad_error *error);

/* Number of points a request for `count` leads to: for tensor grids *actual of the above, for the
 * others `count` itself. Call it before allocating. */
ad_status sampling_count(sampling_kind kind, int dimension, size_t count, size_t *actual,
                         ad_error *error);

/* Fill points [dimension][count]. `rng` may be NULL except for uniform and latin_hypercube.
 * AD_BAD_ARGUMENT: dimension not 1..48 (grids 1..3), count 0 or (sobol) above 2^32, generator
 * missing, or a count without a grid shape (the message names the nearest below). */
ad_status sampling_fill(sampling_kind kind, nn_rng *rng, int dimension, size_t count,
                        double *points, ad_error *error);

/* Of these points number `first` to `end` - 1 alone: coordinate i into to[i][first] to
 * to[i][end - 1], where to[i] is [count]. The generator goes on as far as for all of them.
 * latin_hypercube draws all: it needs those before and after, and writes them. */
ad_status sampling_fill_part(sampling_kind kind, nn_rng *rng, int dimension, size_t count,
                             size_t first, size_t end, double *const *to, ad_error *error);

#ifdef __cplusplus
}
#endif

#endif
