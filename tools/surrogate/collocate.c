/* Values at Radau's nodes of steps that leave no defect of the equations of the reduced rod. */
#include "tools/surrogate/training_internal.h"

#include "autodiff/dense.h"
#include "autodiff/ranks.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

enum { NODES = SURROGATE_NODES };

/* Of changes in a step, by deviations of the states: of the last step of Newton's method, and from
 * where on there is no answer. */
static const double SMALL = 1e-8, LARGE = 1e6;

/* Of one thread. */
typedef struct worker {
    reduced_rod *rod;
    double *own; /* y, defect, rate [3 n] each, by_y [n][n], matrix [3 n][3 n] */
    int *pivots; /* [3 n] */
} worker;

typedef struct job {
    const excitation_rollouts *motions;
    double step;
    bool ramps;
    double scale[SURROGATE_STATES_MAX];
    double integral[NODES][NODES]; /* the matrix of Radau's method */
    worker *workers;
    double *nodes;
} job;

/* Integrals of Lagrange's polynomials at the nodes, l_j, from 0 to c_i. */
static void find_integrals(double integral[NODES][NODES])
{
    for (int k = 0; k < NODES * NODES; k++) {
        const int i = k / NODES, j = k % NODES;
        const double c = surrogate_nodes[i], own = surrogate_nodes[j];
        const double p = surrogate_nodes[(j + 1) % NODES], q = surrogate_nodes[(j + 2) % NODES];
        integral[i][j] = c * (p * q - c * (p + q) / 2 + c * c / 3) / ((own - p) * (own - q));
    }
}

/* Deviations of the states; 1 of what stays. */
static void find_scale(const excitation_rollouts *motions, double *scale)
{
    const size_t n = (size_t)motions->states;
    double largest = 0;
    for (size_t j = 0; j < n; j++) {
        double count = 0, mean = 0, squares = 0;
        for (int i = 0; i < motions->count; i++) {
            const double *state = motions->state + (size_t)i * (size_t)(motions->steps + 1) * n + j;
            for (size_t k = 0; k <= (size_t)motions->done[i]; k++) {
                const double off = state[k * n] - mean;
                mean += off / ++count;
                squares += off * (state[k * n] - mean);
            }
        }
        scale[j] = sqrt(squares / count);
        largest = fmax(largest, scale[j]);
    }
    for (size_t j = 0; j < n; j++) {
        scale[j] = scale[j] > EXCITATION_STAYS * largest ? scale[j] : 1;
    }
}

/* y' after a part t of a step that began in `state`, and its derivatives [n][n]. */
static bool find_rate(const job *of, worker *w, const double *state, const double *input, double t,
                      const double *y, double *rate, double *by_y)
{
    const size_t n = (size_t)of->motions->states, inputs = (size_t)of->motions->inputs;
    double x[SURROGATE_STATES_MAX], u[SCENE_PARAMETERS_MAX];
    ad_error error;
    for (size_t r = 0; r < n; r++) {
        x[r] = state[r] + of->scale[r] * y[r];
        if (!(fabs(y[r]) < LARGE)) {
            return false;
        }
    }
    for (size_t k = 0; k < inputs; k++) {
        u[k] = input[k] + (of->ramps ? t * (input[inputs + k] - input[k]) : 0);
    }
    if (reduced_rate(w->rod, 0, x, u, rate, by_y, NULL, &error) != AD_OK) {
        return false;
    }
    for (size_t r = 0; r < n; r++) {
        rate[r] *= of->step / of->scale[r];
        for (size_t c = 0; c < n; c++) {
            by_y[r * n + c] *= of->step * of->scale[c] / of->scale[r];
        }
    }
    return true;
}

/* The defect y - integral of y', and its derivatives, column-major. */
static bool find_defect(const job *of, worker *w, const double *state, const double *input,
                        const double *y, double *defect, double *matrix)
{
    const size_t n = (size_t)of->motions->states, all = NODES * n;
    double *rate = defect + all, *by_y = rate + all;
    memcpy(defect, y, all * sizeof *defect);
    memset(matrix, 0, all * all * sizeof *matrix);
    for (size_t k = 0; k < all; k++) {
        matrix[k * all + k] = 1;
    }
    for (size_t j = 0; j < NODES; j++) {
        if (!find_rate(of, w, state, input, surrogate_nodes[j], y + j * n, rate, by_y)) {
            return false;
        }
        for (size_t i = 0; i < NODES; i++) {
            const double part = of->integral[i][j];
            for (size_t r = 0; r < n; r++) {
                defect[i * n + r] -= part * rate[r];
                for (size_t c = 0; c < n; c++) {
                    matrix[(j * n + c) * all + i * n + r] -= part * by_y[r * n + c];
                }
            }
        }
    }
    return true;
}

/* y of a step, at w->own. */
static bool solve(const job *of, worker *w, const double *state, const double *input)
{
    enum { MOST = 12 };
    const size_t n = (size_t)of->motions->states, all = NODES * n;
    double *y = w->own, *defect = y + all, *matrix = y + 3 * all + n * n;
    memset(y, 0, all * sizeof *y);
    for (int turn = 0; turn < MOST; turn++) {
        double most = 0;
        if (!find_defect(of, w, state, input, y, defect, matrix) ||
            ad_dense_lu(all, matrix, w->pivots) != 0) {
            return false;
        }
        ad_dense_lu_solve(all, 1, matrix, w->pivots, defect);
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
    const excitation_rollouts *motions = of->motions;
    worker *w = &of->workers[thread];
    const size_t n = (size_t)motions->states, all = NODES * n;
    (void)error;
    for (int k = 0; k < motions->done[item]; k++) {
        const size_t row = (size_t)item * (size_t)(motions->steps + 1) + (size_t)k;
        const double *state = motions->state + row * n;
        double *to = of->nodes + ((size_t)item * (size_t)motions->steps + (size_t)k) * all;
        if (!solve(of, w, state, motions->input + row * (size_t)motions->inputs)) {
            to[0] = NAN;
            continue;
        }
        for (size_t i = 0; i < all; i++) {
            to[i] = state[i % n] + of->scale[i % n] * w->own[i];
        }
    }
    return AD_OK;
}

static ad_status prepare_worker(const surrogate_training *t, const job *of, worker *w,
                                ad_error *error)
{
    const size_t n = (size_t)of->motions->states, all = NODES * n;
    reduced_settings settings = {.count = 0};
    memcpy(settings.modes, t->settings->modes, sizeof settings.modes);
    w->own = malloc((3 * all + n * n + all * all) * sizeof *w->own);
    w->pivots = malloc(all * sizeof *w->pivots);
    return w->own && w->pivots ? reduced_create(t->open, &settings, &w->rod, error)
                               : ad_fail(error, AD_NO_MEMORY, "out of memory for nodes of steps");
}

ad_status surrogate_collocate(surrogate_training *t, const excitation_rollouts *motions,
                              double *nodes, ad_error *error)
{
    const int threads = ad_pool_threads(t->pool);
    job of = {.motions = motions,
              .step = t->settings->step,
              .ramps = t->settings->hold == SURROGATE_RAMP,
              .workers = calloc((size_t)threads, sizeof *of.workers),
              .nodes = nodes};
    ad_status status =
        of.workers ? AD_OK : ad_fail(error, AD_NO_MEMORY, "out of memory for nodes of steps");
    find_integrals(of.integral);
    find_scale(motions, of.scale);
    for (int i = 0; i < threads && status == AD_OK; i++) {
        status = prepare_worker(t, &of, &of.workers[i], error);
    }
    if (status == AD_OK) {
        const size_t bytes =
            (size_t)motions->steps * NODES * (size_t)motions->states * sizeof *nodes;
        const ad_dealt made = {nodes, bytes, (size_t)motions->count * bytes};
        status = ad_pool_deal(t->pool, motions->count, run_rollout, &of, 1, &made, error);
    }
    for (int i = 0; i < threads && of.workers; i++) {
        reduced_free(of.workers[i].rod);
        free(of.workers[i].own);
        free(of.workers[i].pivots);
    }
    free(of.workers);
    return status;
}
