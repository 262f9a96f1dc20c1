#include "tools/surrogate/growth.h"

#include "autodiff/dense.h"
#include "tools/surrogate/surrogate_step.h"

#include <math.h>
#include <stdint.h>
#include <stdlib.h>
#include <string.h>

double surrogate_growth(ad_pool *pool, size_t n, const double *map, double *room)
{
    enum { SQUARES = 20 };
    double *now = room, *next = room + n * n, logarithm = 0;
    memcpy(now, map, n * n * sizeof *now);
    for (int k = 0; k < SQUARES; k++) {
        double square = 0;
        for (size_t a = 0; a < n * n; a++) {
            square += now[a] * now[a];
        }
        const double size = sqrt(square);
        if (!(size > 0) || isinf(size)) {
            return size;
        }
        logarithm += log(size) / (double)(INT64_C(1) << k);
        for (size_t a = 0; a < n * n; a++) {
            now[a] /= size;
        }
        ad_dense_multiply(pool, false, false, n, n, n, now, now, 0, next);
        memcpy(now, next, n * n * sizeof *now);
    }
    return exp(logarithm);
}

const char surrogate_steadier[] =
    "a stiffer or better damped rod (rod.material.youngs_modulus, rod.material.relaxation_time), "
    "smaller loads, or smaller ranges under parameters";

ad_status surrogate_rest_growth(ad_pool *pool, reduced_rod *rod, double step, double *result,
                                ad_error *error)
{
    const size_t n = (size_t)reduced_states(rod);
    double inputs[SURROGATE_INPUTS_MAX], *room = malloc((3 * n * n + n + 1) * sizeof *room);
    double *state = room + 3 * n * n;
    ad_error unsolved;
    if (!room) {
        return ad_fail(error, AD_NO_MEMORY, "out of memory for a robot at rest");
    }
    for (int i = 0; i < reduced_inputs(rod); i++) {
        inputs[i] = scene_parameter_at(reduced_input(rod, i), 0.5);
    }
    ad_status status = ad_dense_load(error);
    status = status == AD_OK ? reduced_initial(rod, inputs, state, error) : status;
    *result = INFINITY;
    if (status == AD_OK && reduced_settle(rod, 0, inputs, state, &unsolved) == AD_OK &&
        reduced_step(rod, 0, step, state, inputs, state, room, NULL, &unsolved) == AD_OK) {
        *result = surrogate_growth(pool, n, room, room + n * n);
    }
    free(room);
    return status;
}
