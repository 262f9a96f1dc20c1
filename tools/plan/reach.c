#include "tools/plan/reach.h"

#include "nn/rng.h"
#include "optim/seek.h"
#include "physics/numerics/quaternion.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

enum { STEPS = 30 };

/* Of the angle that is allowed, what is sought: within it there is nothing to do. */
#define WITHIN 0.9

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

/* ---- a place and a direction ----------------------------------------------------------------- */

static bool has_direction(const reach_goal *goal)
{
    return !isnan(goal->direction[0]);
}

/* The image of a member: its tip, then how far it points beyond what is sought, times the length;
 * by [][variables]. */
static void look(const plan_exact *shapes, const reach_goal *goal, size_t member, double *image,
                 double *by)
{
    const size_t n = (size_t)shapes->robot->count, last = (member + 1) * shapes->points - 1;
    memcpy(image, &shapes->r[3 * last], 3 * sizeof *image);
    memcpy(by, &shapes->moves[3 * n * last], 3 * n * sizeof *by);
    if (has_direction(goal)) {
        const double *const t = &shapes->tangent[3 * member];
        double across[3];
        vector_cross(goal->direction, t, across);
        const double sine = sqrt(vector_dot(across, across));
        const double angle = atan2(sine, vector_dot(goal->direction, t));
        const bool beyond = angle > WITHIN * goal->angle;
        image[3] = beyond ? shapes->length * (angle - WITHIN * goal->angle) : 0;
        for (size_t k = 0; k < n; k++) {
            double change = 0;
            for (size_t i = 0; i < 3; i++) {
                change -= goal->direction[i] * shapes->turns[(3 * member + i) * n + k];
            }
            by[3 * n + k] = beyond ? shapes->length * change / fmax(sine, 1e-3) : 0;
        }
    }
}

/* Of the best of a seeker. */
static double place_off(const optim_seek *seeker)
{
    return sqrt(vector_dot(seeker->off, seeker->off));
}

static double angle_off(const plan_exact *shapes, const reach_goal *goal, const optim_seek *seeker)
{
    return has_direction(goal) ? WITHIN * goal->angle - seeker->off[3] / shapes->length : 0;
}

ad_status reach_tip(plan_exact *shapes, const reach_goal *goal, const double *from, uint64_t seed,
                    reach *result, ad_error *error)
{
    const plan_robot *const robot = shapes->robot;
    const size_t n = (size_t)robot->count;
    const double place[OPTIM_SEEK_IMAGES] = {goal->tip[0], goal->tip[1], goal->tip[2], 0};
    const double off = PLAN_TOLERANCE * shapes->length; /* the solver's */
    double enough = goal->tolerance / 10, nearest = INFINITY;
    nn_rng rng = nn_rng_split(seed, "tips");
    optim_seek *const seekers = malloc(PLAN_BATCH * sizeof *seekers);
    double q[PLAN_BATCH * PLAN_VARIABLES_MAX];
    ad_status status =
        seekers ? AD_OK : ad_fail(error, AD_NO_MEMORY, "out of memory for configurations");
    if (has_direction(goal)) {
        enough = fmin(enough, (1 - WITHIN) / 2 * goal->angle * shapes->length);
    }
    *result = (reach){.nearest = INFINITY};
    for (size_t i = 0; i < PLAN_BATCH && status == AD_OK; i++) {
        double first[PLAN_VARIABLES_MAX];
        for (size_t k = 0; k < n; k++) {
            first[k] = i == 0 ? from[k] : nn_rng_between(&rng, robot->low[k], robot->high[k]);
        }
        optim_seek_start(&seekers[i], robot->count, robot->low, robot->high,
                         has_direction(goal) ? 4 : 3, place, first);
    }
    for (int k = 0; k < STEPS && status == AD_OK; k++) {
        size_t which[PLAN_BATCH], members = 0;
        for (size_t i = 0; i < PLAN_BATCH; i++) {
            if (!optim_seek_is_over(&seekers[i], enough)) {
                memcpy(&q[members * n], seekers[i].next, n * sizeof *q);
                which[members++] = i;
            }
        }
        if (members == 0) {
            break;
        }
        status = plan_exact_shapes(shapes, members, q, error);
        for (size_t m = 0; m < members && status == AD_OK; m++) {
            double image[OPTIM_SEEK_IMAGES], by[OPTIM_SEEK_IMAGES * PLAN_VARIABLES_MAX];
            look(shapes, goal, m, image, by);
            optim_seek_tell(&seekers[which[m]], image, by, shapes->error[m] <= off);
        }
    }
    for (size_t i = 0; i < PLAN_BATCH && status == AD_OK; i++) {
        const optim_seek *const s = &seekers[i];
        if (s->distance < nearest) {
            nearest = s->distance;
            result->nearest = place_off(s);
            result->angle = angle_off(shapes, goal, s);
        }
        /* a thousandth of the angle for what the solver is off */
        if (s->distance < INFINITY && place_off(s) <= goal->tolerance - off &&
            (!has_direction(goal) || angle_off(shapes, goal, s) <= goal->angle * (1 - 1e-3))) {
            keep(robot, from, s->x, result);
        }
    }
    free(seekers);
    return status;
}
