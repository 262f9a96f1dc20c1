/* Values at the nodes of a step that leave no defect of the equations. */
#include "tools/surrogate/physics_internal.h"

#include "autodiff/dense.h"
#include "autodiff/ranks.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

/* Numbers of z. */
static const double SMALL = 1e-8;

typedef struct job {
    const physics_loss *x;
    double *nodes;
    double *matrices; /* [threads][(3 n)^2] */
    int *pivots;      /* [threads][3 n] */
} job;

/* The defect y - integral of z', and its derivatives, column-major. */
static bool find_defect(const physics_loss *x, physics_worker *w, double *matrix, double *defect)
{
    const size_t n = (size_t)x->m->states, all = NODES * n;
    physics_step *s = &w->steps[0];
    for (size_t i = 0; i < NODES; i++) {
        double *z = s->rate + i * n; /* free here */
        for (size_t j = 0; j < n; j++) {
            z[j] = s->given[j] + s->y[i * n + j];
        }
        if (!physics_rate(x, w, s->given, decoupled_nodes[i], z, s->n + i * n,
                          s->by_z + i * n * n)) {
            return false;
        }
    }
    memcpy(defect, s->y, all * sizeof *defect);
    memset(matrix, 0, all * all * sizeof *matrix);
    for (size_t k = 0; k < all; k++) {
        matrix[k * all + k] = 1;
    }
    for (size_t b = 0; b < (size_t)NODES * NODES; b++) {
        const size_t i = b / NODES, j = b % NODES;
        const double part = x->integral[i][j];
        for (size_t r = 0; r < n; r++) {
            const double *by_z = s->by_z + (j * n + r) * n;
            defect[i * n + r] -= part * s->n[j * n + r];
            for (size_t c = 0; c < n; c++) {
                matrix[(j * n + c) * all + i * n + r] -= part * by_z[c];
            }
        }
    }
    return true;
}

static bool solve(const physics_loss *x, physics_worker *w, double *matrix, int *pivots)
{
    enum { MOST = 12 };
    const size_t all = NODES * (size_t)x->m->states;
    physics_step *s = &w->steps[0];
    memset(s->y, 0, all * sizeof *s->y);
    for (int turn = 0; turn < MOST; turn++) {
        double most = 0;
        if (!find_defect(x, w, matrix, s->residual) || ad_dense_lu(all, matrix, pivots) != 0) {
            return false;
        }
        ad_dense_lu_solve(all, 1, matrix, pivots, s->residual);
        for (size_t k = 0; k < all; k++) {
            s->y[k] -= s->residual[k];
            most = fmax(most, fabs(s->residual[k]));
        }
        if (most < SMALL) { /* quadratic: the next would be far below rounding */
            return true;
        }
    }
    return false;
}

static ad_status run_rollout(void *context, int item, int thread, ad_error *error)
{
    const job *of = context;
    const physics_loss *x = of->x;
    physics_worker *w = &x->workers[thread];
    const size_t n = (size_t)x->m->states, all = NODES * n;
    const size_t steps = (size_t)x->motions->steps;
    double *given = w->steps[0].given;
    (void)error;
    for (size_t k = 0; k < (size_t)x->motions->done[item]; k++) {
        const size_t row = (size_t)item * (steps + 1) + k;
        double *to = of->nodes + ((size_t)item * steps + k) * all;
        physics_take_state(x, row, given);
        physics_take_inputs(x, row, given + n);
        if (!solve(x, w, of->matrices + (size_t)thread * all * all,
                   of->pivots + (size_t)thread * all)) {
            to[0] = NAN;
            continue;
        }
        for (size_t i = 0; i < all; i++) {
            const size_t j = i % n;
            to[i] = x->center[j] + x->scale[j] * (given[j] + w->steps[0].y[i]);
        }
    }
    return AD_OK;
}

ad_status physics_collocate(const scene *open, const int modes[4], const excite_rollouts *motions,
                            const decoupled *m, ad_pool *pool, double *nodes, ad_error *error)
{
    const physics_loss_settings settings = {.ahead = 1};
    const size_t all = NODES * (size_t)m->states, threads = (size_t)ad_pool_threads(pool);
    job of = {.nodes = nodes};
    physics_loss *x = NULL;
    ad_status status = physics_open(open, modes, motions, m, &settings, pool, &x, error);
    of.matrices = malloc(threads * all * all * sizeof *of.matrices);
    of.pivots = malloc(threads * all * sizeof *of.pivots);
    if (status == AD_OK && (!of.matrices || !of.pivots)) {
        status = ad_fail(error, AD_NO_MEMORY, "out of memory for nodes of steps");
    }
    if (status == AD_OK) {
        const size_t bytes = (size_t)motions->steps * all * sizeof *nodes;
        const ad_dealt made = {nodes, bytes, (size_t)motions->count * bytes};
        of.x = x;
        status = ad_pool_deal(pool, motions->count, run_rollout, &of, 1, &made, error);
    }
    physics_loss_free(x);
    free(of.matrices);
    free(of.pivots);
    return status;
}
