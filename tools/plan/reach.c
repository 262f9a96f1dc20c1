#include "tools/plan/reach.h"

#include "nn/rng.h"
#include "optim/seek.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

enum { STEPS = 30 };

static double apart(const plan_robot *robot, const double *a, const double *b)
{
    double square = 0;
    for (int k = 0; k < robot->count; k++) {
        const double part = (a[k] - b[k]) / (robot->high[k] - robot->low[k]);
        square += part * part;
    }
    return sqrt(square);
}

/* In order, without those that are there already. */
static void keep(const plan_robot *robot, const double *from, const double *q, reach *to)
{
    const size_t n = (size_t)robot->count;
    size_t at = to->count;
    for (size_t i = 0; i < to->count; i++) {
        if (apart(robot, q, &to->configuration[i * n]) < 1e-3) {
            return;
        }
    }
    for (; at > 0 && apart(robot, q, from) < apart(robot, &to->configuration[(at - 1) * n], from);
         at--) {
        memcpy(&to->configuration[at * n], &to->configuration[(at - 1) * n], n * sizeof *q);
    }
    memcpy(&to->configuration[at * n], q, n * sizeof *q);
    to->count++;
}

ad_status reach_tip(plan_exact *shapes, const double tip[3], double tolerance, const double *from,
                    uint64_t seed, reach *result, ad_error *error)
{
    const plan_robot *const robot = shapes->robot;
    const size_t n = (size_t)robot->count;
    nn_rng rng = nn_rng_split(seed, "tips");
    optim_seek *const seekers = malloc(PLAN_BATCH * sizeof *seekers);
    double q[PLAN_BATCH * PLAN_VARIABLES_MAX];
    ad_status status =
        seekers ? AD_OK : ad_fail(error, AD_NO_MEMORY, "out of memory for configurations");
    *result = (reach){.nearest = INFINITY};
    for (size_t i = 0; i < PLAN_BATCH && status == AD_OK; i++) {
        double first[PLAN_VARIABLES_MAX];
        for (size_t k = 0; k < n; k++) {
            first[k] = i == 0 ? from[k] : nn_rng_between(&rng, robot->low[k], robot->high[k]);
        }
        optim_seek_start(&seekers[i], robot->count, robot->low, robot->high, tip, first);
    }
    for (int k = 0; k < STEPS && status == AD_OK; k++) {
        size_t which[PLAN_BATCH], members = 0;
        for (size_t i = 0; i < PLAN_BATCH; i++) {
            if (!optim_seek_is_over(&seekers[i], tolerance / 10)) {
                memcpy(&q[members * n], seekers[i].next, n * sizeof *q);
                which[members++] = i;
            }
        }
        if (members == 0) {
            break;
        }
        status = plan_exact_shapes(shapes, members, q, error);
        for (size_t m = 0; m < members && status == AD_OK; m++) {
            const size_t last = (m + 1) * shapes->points - 1;
            optim_seek_tell(&seekers[which[m]], &shapes->r[3 * last], &shapes->moves[3 * n * last],
                            shapes->error[m] < INFINITY);
        }
    }
    for (size_t i = 0; i < PLAN_BATCH && status == AD_OK; i++) {
        result->nearest = fmin(result->nearest, seekers[i].distance);
        if (seekers[i].distance <= tolerance - PLAN_TOLERANCE * shapes->length) {
            keep(robot, from, seekers[i].x, result);
        }
    }
    free(seekers);
    return status;
}
