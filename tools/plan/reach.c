#include "tools/plan/reach.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

enum { STEPS = 30 };

typedef struct seeker {
    double q[PLAN_VARIABLES_MAX];                 /* of the least distance */
    double next[PLAN_VARIABLES_MAX];              /* that is tried now */
    double moves[3 * PLAN_VARIABLES_MAX], off[3]; /* at q */
    double distance, damping;
} seeker;

/* SplitMix64 (Steele, Lea and Flood 2014). */
static double random_part(uint64_t *state)
{
    uint64_t z = (*state += 0x9e3779b97f4a7c15u);
    z = (z ^ (z >> 30)) * 0xbf58476d1ce4e5b9u;
    z = (z ^ (z >> 27)) * 0x94d049bb133111ebu;
    return (double)((z ^ (z >> 31)) >> 11) * 0x1p-53;
}

/* x of a x = b, symmetric and positive, by Cramer's rule. */
static void solve(double a[3][3], const double b[3], double x[3])
{
    const double c[3] = {a[1][1] * a[2][2] - a[1][2] * a[2][1],
                         a[1][2] * a[2][0] - a[1][0] * a[2][2],
                         a[1][0] * a[2][1] - a[1][1] * a[2][0]};
    const double whole = a[0][0] * c[0] + a[0][1] * c[1] + a[0][2] * c[2];
    for (int i = 0; i < 3; i++) {
        double m[3][3];
        memcpy(m, a, sizeof m);
        for (int j = 0; j < 3; j++) {
            m[j][i] = b[j];
        }
        x[i] = (m[0][0] * (m[1][1] * m[2][2] - m[1][2] * m[2][1]) +
                m[0][1] * (m[1][2] * m[2][0] - m[1][0] * m[2][2]) +
                m[0][2] * (m[1][0] * m[2][1] - m[1][1] * m[2][0])) /
               whole;
    }
}

/* The least step, in parts of the ranges, that goes to the tip but for the damping; variables at an
 * end of their range that it would push beyond stay. */
static void step(const plan_robot *robot, seeker *s)
{
    bool held[PLAN_VARIABLES_MAX] = {false};
    for (int again = 0; again < 3; again++) {
        double a[3][3], x[3], size = 0;
        for (int i = 0; i < 3; i++) {
            for (int j = 0; j < 3; j++) {
                a[i][j] = 0;
                for (int k = 0; k < robot->count; k++) {
                    const double range = held[k] ? 0 : robot->high[k] - robot->low[k];
                    a[i][j] += s->moves[i * robot->count + k] * s->moves[j * robot->count + k] *
                               range * range;
                }
            }
            size += a[i][i];
        }
        for (int i = 0; i < 3; i++) {
            a[i][i] += s->damping * size + 1e-300;
        }
        solve(a, s->off, x);
        bool beyond = false;
        for (int k = 0; k < robot->count; k++) {
            const double range = robot->high[k] - robot->low[k];
            double along = 0;
            for (int i = 0; i < 3; i++) {
                along += s->moves[i * robot->count + k] * x[i];
            }
            const double to = s->q[k] + (held[k] ? 0 : along * range * range);
            s->next[k] = fmin(fmax(to, robot->low[k]), robot->high[k]);
            if (!held[k] && s->next[k] != to && s->next[k] == s->q[k]) {
                held[k] = beyond = true;
            }
        }
        if (!beyond) {
            return;
        }
    }
}

static void judge(const plan_exact *e, size_t member, const double tip[3], seeker *s)
{
    const size_t last = (member + 1) * e->points - 1, row = 3 * (size_t)e->robot->count;
    double off[3], square = 0;
    for (size_t i = 0; i < 3; i++) {
        off[i] = tip[i] - e->r[3 * last + i];
        square += off[i] * off[i];
    }
    if (e->error[member] < INFINITY && sqrt(square) < s->distance) {
        s->distance = sqrt(square);
        memcpy(s->q, s->next, sizeof s->q);
        memcpy(s->off, off, sizeof off);
        memcpy(s->moves, &e->moves[last * row], row * sizeof(double));
        s->damping = fmax(s->damping / 5, 1e-12);
    } else {
        s->damping = fmin(s->damping * 8, 1e6);
    }
}

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
    seeker *const seekers = malloc(PLAN_BATCH * sizeof *seekers);
    double q[PLAN_BATCH * PLAN_VARIABLES_MAX];
    ad_status status =
        seekers ? AD_OK : ad_fail(error, AD_NO_MEMORY, "out of memory for configurations");
    *result = (reach){.nearest = INFINITY};
    for (size_t i = 0; i < PLAN_BATCH && status == AD_OK; i++) {
        seekers[i] = (seeker){.distance = INFINITY, .damping = 1e-3};
        for (size_t k = 0; k < n; k++) {
            seekers[i].next[k] =
                i == 0 ? from[k]
                       : robot->low[k] + random_part(&seed) * (robot->high[k] - robot->low[k]);
        }
    }
    for (int k = 0; k < STEPS && status == AD_OK; k++) {
        size_t which[PLAN_BATCH], members = 0;
        for (size_t i = 0; i < PLAN_BATCH; i++) {
            if (seekers[i].distance > tolerance / 10 && seekers[i].damping < 1e4) {
                if (k > 0 && seekers[i].distance < INFINITY) {
                    step(robot, &seekers[i]);
                }
                memcpy(&q[members * n], seekers[i].next, n * sizeof *q);
                which[members++] = i;
            }
        }
        if (members == 0) {
            break;
        }
        status = plan_exact_shapes(shapes, members, q, error);
        for (size_t m = 0; m < members && status == AD_OK; m++) {
            judge(shapes, m, tip, &seekers[which[m]]);
        }
    }
    for (size_t i = 0; i < PLAN_BATCH && status == AD_OK; i++) {
        result->nearest = fmin(result->nearest, seekers[i].distance);
        if (seekers[i].distance <= tolerance - PLAN_TOLERANCE * shapes->length) {
            keep(robot, from, seekers[i].q, result);
        }
    }
    free(seekers);
    return status;
}
