#include "optim/continuation.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

static const double FIRST_GRADUAL = 0.125, SMALLEST = 1e-3;

bool optim_continuation_create(optim_continuation *path, size_t count, bool gradual)
{
    double part = gradual ? FIRST_GRADUAL : 1;
    *path = (optim_continuation){.count = count, .part = part, .before = NAN, .increment = part};
    path->solved = calloc(2 * count, sizeof *path->solved);
    return path->solved != NULL;
}

void optim_continuation_free(optim_continuation *path)
{
    free(path->solved);
    path->solved = NULL;
}

/* The straight line through the last two solutions, as functions of the part. */
static void extrapolate(const optim_continuation *path, double *x)
{
    const double *now = path->solved, *before = now + path->count;
    double ahead =
        isnan(path->before) ? 0 : (path->part - path->reached) / (path->reached - path->before);
    for (size_t i = 0; i < path->count; i++) {
        x[i] = now[i] + ahead * (now[i] - before[i]);
    }
}

bool optim_continuation_next(optim_continuation *path, bool is_solved, double *x)
{
    size_t bytes = path->count * sizeof *x;
    if (path->increment == 0 || (is_solved && path->part == 1)) {
        return false;
    }
    if (is_solved) {
        memcpy(path->solved + path->count, path->solved, bytes);
        memcpy(path->solved, x, bytes);
        path->before = path->reached;
        path->reached = path->part;
    } else {
        path->increment /= 2;
    }
    if (path->increment < SMALLEST) {
        path->increment = 0;
        path->part = 1;
        memcpy(x, path->solved, bytes);
        return true;
    }
    path->part = fmin(1, path->reached + path->increment);
    extrapolate(path, x);
    return true;
}

bool optim_continuation_is_sound(const optim_continuation *path)
{
    double sum = 0; /* 0 * x is NaN for NaN and infinity alike */
    for (size_t i = 0; i < 2 * path->count; i++) {
        sum += 0 * path->solved[i];
    }
    bool given_up = path->increment == 0 && path->part == 1;
    bool at_work = path->increment >= SMALLEST && path->part > path->reached && path->part <= 1;
    bool rises = isnan(path->before) || (path->before >= 0 && path->before < path->reached);
    return sum == 0 && (given_up || at_work) && path->reached >= 0 && path->reached < 1 && rises;
}
