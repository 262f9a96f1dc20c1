/* Values at the nodes of a step that leave no defect of the equations. */
#include "tools/surrogate/physics_internal.h"

#include "autodiff/dense.h"
#include "autodiff/ranks.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

enum { NODES = DECOUPLED_NODES };

/* Numbers of z. */
static const double SMALL = 1e-8;

typedef struct job {
    physics x;
    physics_worker *workers;
    double integral[NODES][NODES]; /* the matrix of Radau's method */
    double *nodes;
    int *pivots; /* [threads][3 n] */
} job;

/* Integrals of Lagrange's polynomials at the nodes, l_j, from 0 to c_i. */
static void find_integrals(double integral[NODES][NODES])
{
    for (int k = 0; k < NODES * NODES; k++) {
        const int i = k / NODES, j = k % NODES;
        const double c = decoupled_nodes[i], own = decoupled_nodes[j];
        const double p = decoupled_nodes[(j + 1) % NODES], q = decoupled_nodes[(j + 2) % NODES];
        integral[i][j] = c * (p * q - c * (p + q) / 2 + c * c / 3) / ((own - p) * (own - q));
    }
}

/* A worker's own numbers: y, defect, rate [3 n] each, z [n], by_z [n][n], matrix [3 n][3 n]. */
static size_t own_numbers(size_t n)
{
    const size_t nodes = NODES;
    return 3 * nodes * n + n + n * n + nodes * n * nodes * n;
}

/* The defect y - integral of z', and its derivatives, column-major. */
static bool find_defect(const job *of, physics_worker *w, const double *y, double *defect,
                        double *matrix)
{
    const size_t n = (size_t)of->x.m->states, all = NODES * n;
    double *rate = defect + all, *z = rate + all, *by_z = z + n;
    memcpy(defect, y, all * sizeof *defect);
    memset(matrix, 0, all * all * sizeof *matrix);
    for (size_t k = 0; k < all; k++) {
        matrix[k * all + k] = 1;
    }
    for (size_t j = 0; j < NODES; j++) {
        for (size_t r = 0; r < n; r++) {
            z[r] = w->given[r] + y[j * n + r];
        }
        if (!physics_rate(&of->x, w, decoupled_nodes[j], z, rate, by_z)) {
            return false;
        }
        for (size_t i = 0; i < NODES; i++) {
            const double part = of->integral[i][j];
            for (size_t r = 0; r < n; r++) {
                defect[i * n + r] -= part * rate[r];
                for (size_t c = 0; c < n; c++) {
                    matrix[(j * n + c) * all + i * n + r] -= part * by_z[r * n + c];
                }
            }
        }
    }
    return true;
}

/* y of the step at hand. */
static bool solve(const job *of, physics_worker *w, int *pivots)
{
    enum { MOST = 12 };
    const size_t n = (size_t)of->x.m->states, all = NODES * n;
    double *y = w->own, *defect = y + all, *matrix = w->own + own_numbers(n) - all * all;
    memset(y, 0, all * sizeof *y);
    for (int turn = 0; turn < MOST; turn++) {
        double most = 0;
        if (!find_defect(of, w, y, defect, matrix) || ad_dense_lu(all, matrix, pivots) != 0) {
            return false;
        }
        ad_dense_lu_solve(all, 1, matrix, pivots, defect);
        for (size_t k = 0; k < all; k++) {
            y[k] -= defect[k];
            most = fmax(most, fabs(defect[k]));
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
    const physics *physics = &of->x;
    physics_worker *w = &of->workers[thread];
    const size_t n = (size_t)physics->m->states, all = NODES * n;
    (void)error;
    for (int k = 0; k < physics->motions->done[item]; k++) {
        double *to = of->nodes + ((size_t)item * (size_t)physics->motions->steps + (size_t)k) * all;
        physics_take(physics, item, k, w);
        if (!solve(of, w, of->pivots + (size_t)thread * all)) {
            to[0] = NAN;
            continue;
        }
        for (size_t i = 0; i < all; i++) {
            const size_t j = i % n;
            to[i] = physics->center[j] + physics->scale[j] * (w->given[j] + w->own[i]);
        }
    }
    return AD_OK;
}

ad_status physics_collocate(const scene *open, const int modes[4],
                            const excitation_rollouts *motions, const decoupled *m, ad_pool *pool,
                            double *nodes, ad_error *error)
{
    const size_t n = (size_t)m->states, all = NODES * n;
    const int threads = ad_pool_threads(pool);
    job of = {.x = physics_of(m, motions), .nodes = nodes};
    find_integrals(of.integral);
    ad_status status =
        physics_workers_create(open, modes, m, threads, own_numbers(n), &of.workers, error);
    of.pivots = malloc((size_t)threads * all * sizeof *of.pivots);
    if (status == AD_OK && !of.pivots) {
        status = ad_fail(error, AD_NO_MEMORY, "out of memory for nodes of steps");
    }
    if (status == AD_OK) {
        const size_t bytes = (size_t)motions->steps * all * sizeof *nodes;
        const ad_dealt made = {nodes, bytes, (size_t)motions->count * bytes};
        status = ad_pool_deal(pool, motions->count, run_rollout, &of, 1, &made, error);
    }
    physics_workers_free(threads, of.workers);
    free(of.pivots);
    return status;
}
