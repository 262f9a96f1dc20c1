/* For tests of values of members: runs of different shapes, and the same run with everything given
 * per point. */
#ifndef TESTS_MEMBERS_TESTING_H
#define TESTS_MEMBERS_TESTING_H

#include "ad_testing.h"

/* Products of up to 64 terms and a few hundred operations that do not amplify. */
#define ROUNDING 2e-12

typedef struct shape {
    size_t members, each;
    int tile;
} shape;

/* One member, one point of each, odd numbers, tiles smaller and larger than members. */
static const shape shapes[] = {{1, 40, 32}, {40, 1, 16},  {7, 5, 0},  {3, 33, 8},
                               {13, 7, 32}, {2, 100, 24}, {0, 17, 0}, {50, 8, 64}};

enum { SHAPES = sizeof shapes / sizeof *shapes };

static inline size_t points_of(shape s)
{
    return (s.members ? s.members : 1) * s.each;
}

/* A member's block at each of its points. */
static inline void repeat_inputs(run_data *data, const run_data *members, const ad_tape *tape)
{
    size_t each = data->points / blocks_of(members, AD_MEMBER);
    for (int i = 0; i < data->inputs; i++) {
        bool of_member = tape->input_extent[i] == AD_MEMBER;
        size_t width = blocks_of(members, (ad_extent)tape->input_extent[i]);
        for (int row = 0; row < tape->input_rows[i]; row++)
            for (size_t j = 0; j < data->points; j++)
                data->input[i][(size_t)row * data->points + j] =
                    members->input[i][(size_t)row * width + (of_member ? j / each : j)];
    }
    for (int i = 0; i < data->uniforms; i++)
        memcpy(data->uniform[i], members->uniform[i],
               (size_t)tape->uniform_rows[i] * sizeof(double));
    memcpy(data->parameters, members->parameters, sizeof data->parameters);
}

/* Row by row; per point where either is: a sum over the points of a member where only one is to be
 * summed. */
static inline double difference(const compiled *a, const compiled *b, int i, ad_extent extent,
                                ad_extent other, bool sum, const run_data *data)
{
    size_t width = blocks_of(data, extent), wide = blocks_of(data, other);
    size_t each = wide / width, rows = a->sizes[i] / width;
    double worst = 0, scale = 1;
    /* the same for every point, and so also for every member */
    double points = sum && other == AD_UNIFORM
                        ? (double)data->points / (double)(data->members > 0 ? data->members : 1)
                        : 1;
    for (size_t row = 0; row < rows; row++) {
        for (size_t k = 0; k < width; k++) {
            double expected = 0, value = a->results[i][row * width + k];
            for (size_t j = 0; j < each; j++) {
                double now = points * b->results[i][row * wide + k * each + j];
                expected = sum ? expected + now : now;
                worst = sum ? worst : fmax(worst, fabs(value - now));
            }
            worst = fmax(worst, fabs(value - expected));
            scale = fmax(scale, fabs(expected));
        }
    }
    return worst / scale;
}

#endif
