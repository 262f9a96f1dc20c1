#include "optim/seek.h"

#include <math.h>
#include <string.h>

/* x of a x = b [n], symmetric and positive: a becomes its factor of Cholesky. */
static void solve(int n, double a[OPTIM_SEEK_IMAGES][OPTIM_SEEK_IMAGES], const double *b, double *x)
{
    for (int i = 0; i < n; i++) {
        for (int j = 0; j <= i; j++) {
            for (int k = 0; k < j; k++) {
                a[i][j] -= a[i][k] * a[j][k];
            }
            a[i][j] = i == j ? sqrt(a[i][i]) : a[i][j] / a[j][j];
        }
    }
    for (int i = 0; i < n; i++) {
        x[i] = b[i];
        for (int k = 0; k < i; k++) {
            x[i] -= a[i][k] * x[k];
        }
        x[i] /= a[i][i];
    }
    for (int i = n; i-- > 0;) {
        for (int k = i + 1; k < n; k++) {
            x[i] -= a[k][i] * x[k];
        }
        x[i] /= a[i][i];
    }
}

/* The least step, in parts of the ranges, that goes to the place but for the damping; variables at
 * an end of their range that it would push beyond stay. */
static void step(optim_seek *s)
{
    bool held[OPTIM_SEEK_MAX] = {false};
    for (int again = 0; again < 3; again++) {
        double a[OPTIM_SEEK_IMAGES][OPTIM_SEEK_IMAGES], x[OPTIM_SEEK_IMAGES], size = 0;
        for (int i = 0; i < s->images; i++) {
            for (int j = 0; j < s->images; j++) {
                a[i][j] = 0;
                for (int k = 0; k < s->count; k++) {
                    const double range = held[k] ? 0 : s->high[k] - s->low[k];
                    a[i][j] += s->by[i * s->count + k] * s->by[j * s->count + k] * range * range;
                }
            }
            size += a[i][i];
        }
        for (int i = 0; i < s->images; i++) {
            a[i][i] += s->damping * size + 1e-300;
        }
        solve(s->images, a, s->off, x);
        bool beyond = false;
        for (int k = 0; k < s->count; k++) {
            const double range = s->high[k] - s->low[k];
            double along = 0;
            for (int i = 0; i < s->images; i++) {
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

void optim_seek_start(optim_seek *s, int count, const double *low, const double *high, int images,
                      const double *place, const double *from)
{
    *s = (optim_seek){.count = count,
                      .low = low,
                      .high = high,
                      .images = images,
                      .distance = INFINITY,
                      .damping = 1e-3};
    memcpy(s->place, place, (size_t)images * sizeof *place);
    memcpy(s->next, from, (size_t)count * sizeof *from);
    memcpy(s->x, from, (size_t)count * sizeof *from);
}

void optim_seek_tell(optim_seek *s, const double *image, const double *by, bool there)
{
    double off[OPTIM_SEEK_IMAGES] = {0}, square = 0;
    for (int i = 0; i < s->images; i++) {
        off[i] = s->place[i] - image[i];
        square += off[i] * off[i];
    }
    if (there && sqrt(square) < s->distance) {
        s->distance = sqrt(square);
        memcpy(s->x, s->next, sizeof s->x);
        memcpy(s->off, off, sizeof off);
        memcpy(s->by, by, (size_t)(s->images * s->count) * sizeof *by);
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
