/* Equilibria of a reduced rod. */
#include "autodiff/dense.h"
#include "physics/chain/modes_internal.h"

#include <math.h>
#include <string.h>

void modes_stiffness(const modes *m, const double *by_q, double *factor)
{
    const int n = m->size;
    for (int c = 0; c < n; c++) {
        for (int r = 0; r < n; r++) {
            factor[c * n + r] = (c < m->end.first ? by_q : m->mass)[r * m->width + c];
        }
    }
}

/* The residual becomes what modes and reactions are off by; returns the largest number of modes,
 * not a number where the matrix is singular. */
static double solve_stiffness(const modes *m, const modes_linear *linear)
{
    const size_t n = (size_t)m->size;
    double most = 0;
    modes_stiffness(m, linear->by_q, linear->factor);
    if (ad_dense_lu(n, linear->factor, linear->pivots) != 0) {
        return NAN;
    }
    ad_dense_lu_solve(n, 1, linear->factor, linear->pivots, linear->residual);
    for (int i = 0; i < m->end.first; i++) {
        most = fabs(linear->residual[i]) > most || isnan(linear->residual[i])
                   ? fabs(linear->residual[i])
                   : most;
    }
    return most;
}

/* Of what is given, that which moves: of both ends, and of a feed. */
typedef struct given_motion {
    solve_end_state start, end;
    double feed[3];
} given_motion;

static void stop_end(solve_end_state *end)
{
    memset(end->velocity, 0, sizeof end->velocity);
    memset(end->acceleration, 0, sizeof end->acceleration);
    memset(end->spin, 0, sizeof end->spin);
    memset(end->spin_rate, 0, sizeof end->spin_rate);
}

static given_motion stop(modes *m)
{
    given_motion before = {m->start, m->end.given, {0}};
    memcpy(before.feed, m->feed.wanted, sizeof before.feed);
    stop_end(&m->start);
    stop_end(&m->end.given);
    m->feed.wanted[1] = m->feed.wanted[2] = 0;
    if (m->end.directions > 0) {
        modes_end_given(m);
    }
    return before;
}

static void go_on(modes *m, const given_motion *before)
{
    m->start = before->start;
    m->end.given = before->end;
    memcpy(m->feed.wanted, before->feed, sizeof before->feed);
    if (m->end.directions > 0) {
        modes_end_given(m);
    }
}

/* Newton's method. */
static bool settle(modes *m, const modes_linear *linear)
{
    enum { STEPS = 60 };
    const double near = 1e-11, farthest = 0.5;
    double moved = INFINITY;
    for (int step = 0; step < STEPS && moved > near; step++) {
        modes_linearise(m, linear->q, linear->v, m->end.count > 0 ? linear->a : NULL,
                        linear->residual, linear->by_q, linear->by_v);
        moved = solve_stiffness(m, linear);
        const double part = fmin(1, farthest / moved);
        for (int k = 0; k < m->size; k++) {
            *(k < m->end.first ? &linear->q[k] : &linear->a[k]) -= part * linear->residual[k];
        }
    }
    return moved <= near;
}

ad_status modes_settle(modes *m, const modes_linear *linear, ad_error *error)
{
    memset(linear->v, 0, (size_t)m->size * sizeof *linear->v);
    memset(linear->a, 0, (size_t)m->size * sizeof *linear->a);
    modes_stretch(m, NULL);
    const given_motion before = stop(m);
    const bool settled = settle(m, linear);
    go_on(m, &before);
    return settled ? AD_OK
                   : ad_fail(error, AD_NOT_FINITE, "no equilibrium is found from the state");
}
