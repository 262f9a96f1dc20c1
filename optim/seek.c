#include "optim/seek.h"

#include <math.h>
#include <string.h>

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

/* The least step, in parts of the ranges, that goes to the place but for the damping; variables at
 * an end of their range that it would push beyond stay. */
static void step(optim_seek *s)
{
    bool held[OPTIM_SEEK_MAX] = {false};
    for (int again = 0; again < 3; again++) {
        double a[3][3], x[3], size = 0;
        for (int i = 0; i < 3; i++) {
            for (int j = 0; j < 3; j++) {
                a[i][j] = 0;
                for (int k = 0; k < s->count; k++) {
                    const double range = held[k] ? 0 : s->high[k] - s->low[k];
                    a[i][j] += s->by[i * s->count + k] * s->by[j * s->count + k] * range * range;
                }
            }
            size += a[i][i];
        }
        for (int i = 0; i < 3; i++) {
            a[i][i] += s->damping * size + 1e-300;
        }
        solve(a, s->off, x);
        bool beyond = false;
        for (int k = 0; k < s->count; k++) {
            const double range = s->high[k] - s->low[k];
            double along = 0;
            for (int i = 0; i < 3; i++) {
                along += s->by[i * s->count + k] * x[i];
            }
            const double to = s->x[k] + (held[k] ? 0 : along * range * range);
            s->next[k] = fmin(fmax(to, s->low[k]), s->high[k]);
            if (!held[k] && s->next[k] != to && s->next[k] == s->x[k]) {
                held[k] = beyond = true;
            }
        }
        if (!beyond) {
            return;
        }
    }
}

void optim_seek_start(optim_seek *s, int count, const double *low, const double *high,
                      const double place[3], const double *from)
{
    *s = (optim_seek){.count = count,
                      .low = low,
                      .high = high,
                      .place = {place[0], place[1], place[2]},
                      .distance = INFINITY,
                      .damping = 1e-3};
    memcpy(s->next, from, (size_t)count * sizeof *from);
    memcpy(s->x, from, (size_t)count * sizeof *from);
}

void optim_seek_tell(optim_seek *s, const double image[3], const double *by, bool there)
{
    double off[3], square = 0;
    for (int i = 0; i < 3; i++) {
        off[i] = s->place[i] - image[i];
        square += off[i] * off[i];
    }
    if (there && sqrt(square) < s->distance) {
        s->distance = sqrt(square);
        memcpy(s->x, s->next, sizeof s->x);
        memcpy(s->off, off, sizeof off);
        memcpy(s->by, by, 3 * (size_t)s->count * sizeof *by);
        s->damping = fmax(s->damping / 5, 1e-12);
    } else {
        s->damping = fmin(s->damping * 8, 1e6);
    }
    if (s->distance < INFINITY) {
        step(s);
    }
}

bool optim_seek_is_over(const optim_seek *s, double distance)
{
    return s->distance <= distance || s->damping >= OPTIM_SEEK_STUCK;
}
