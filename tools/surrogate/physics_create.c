/* What a loss by the equations of the rod is made of: integrals, weights, beginnings. */
#include "tools/surrogate/physics_internal.h"

#include "nn/rng.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

/* Integrals of Lagrange's polynomials at the nodes, l_j, from 0 to c_i. */
static void find_integrals(physics_loss *x)
{
    for (int k = 0; k < NODES * NODES; k++) {
        const int i = k / NODES, j = k % NODES;
        const double c = decoupled_nodes[i], own = decoupled_nodes[j];
        const double p = decoupled_nodes[(j + 1) % NODES], q = decoupled_nodes[(j + 2) % NODES];
        x->integral[i][j] = c * (p * q - c * (p + q) / 2 + c * c / 3) / ((own - p) * (own - q));
    }
}

/* c = a b, all [n][n], c another array. */
static void multiply(size_t n, const double *a, const double *b, double *c)
{
    memset(c, 0, n * n * sizeof *c);
    for (size_t i = 0; i < n; i++) {
        for (size_t k = 0; k < n; k++) {
            const double by = a[i * n + k];
            for (size_t j = 0; by != 0 && j < n; j++) {
                c[i * n + j] += by * b[k * n + j];
            }
        }
    }
}

/* exp(a) into e by Taylor's series of a/2^k, squared k times; all [n][n], of which a is used up. */
static void exponential(size_t n, double *a, double *e, double *room)
{
    enum { DEGREE = 14 };
    double norm = 0;
    int squarings = 0;
    for (size_t i = 0; i < n; i++) {
        double sum = 0;
        for (size_t j = 0; j < n; j++) {
            sum += fabs(a[i * n + j]);
        }
        norm = sum > norm ? sum : norm;
    }
    for (; norm > 0.5 && squarings < 60; squarings++) {
        norm /= 2;
    }
    for (size_t i = 0; i < n * n; i++) {
        a[i] = ldexp(a[i], -squarings);
        e[i] = i % (n + 1) == 0;
    }
    for (int k = DEGREE; k > 0; k--) { /* Horner: e = 1 + a e / k */
        multiply(n, a, e, room);
        for (size_t i = 0; i < n * n; i++) {
            e[i] = (i % (n + 1) == 0) + room[i] / k;
        }
    }
    for (; squarings > 0; squarings--) {
        multiply(n, e, e, room);
        memcpy(e, room, n * n * sizeof *e);
    }
}

/* A [n][n] of z' = A z: the mean of the derivatives over states of the motions. */
static ad_status find_mean(const physics_loss *x, reduced_rod *rod, double *A, ad_error *error)
{
    enum { LINEARISED = 256 };
    const excite_rollouts *motions = x->motions;
    const size_t n = (size_t)x->m->states, inputs = (size_t)x->m->inputs;
    double *rate = x->workers[0].state, *by_state = x->workers[0].jacobian;
    ad_status status = AD_OK;
    for (int s = 0; s < LINEARISED && status == AD_OK; s++) {
        const int i = s % motions->count;
        const int k = motions->done[i] > 0 ? (int)(((long)s * 7919) % motions->done[i]) : 0;
        const size_t at = (size_t)i * (size_t)(motions->steps + 1) + (size_t)k;
        status = reduced_rate(rod, 0, motions->state + at * n, motions->input + at * inputs, rate,
                              by_state, NULL, error);
        for (size_t e = 0; e < n * n && status == AD_OK; e++) {
            A[e] += x->m->step / x->scale[e / n] * by_state[e] * x->scale[e % n] / LINEARISED;
        }
    }
    return status;
}

/* weight = sum over 250 steps of (F^k)^T C^T C F^k, so that its largest number is 1, and ALL times
 * the unit matrix: what does nothing to the tip grows otherwise, until it does. F = exp(A) of a
 * step, C of the tip by z in the middle. */
static ad_status find_weight(physics_loss *x, reduced_rod *rod, ad_error *error)
{
    enum { STEPS = 250 };
    static const double ALL = 0.1;
    const size_t n = (size_t)x->m->states;
    double *by_state = calloc(12 * n + 6 * n + 3 * n * n, sizeof *by_state);
    double *rows = by_state + 12 * n, *A = rows + 6 * n, *F = A + n * n, most = 0;
    reduced_place tip;
    if (!by_state) {
        return ad_fail(error, AD_NO_MEMORY, "out of memory for a tip");
    }
    ad_status status = find_mean(x, rod, A, error);
    if (status == AD_OK) {
        exponential(n, A, F, F + n * n);
        status = reduced_output(rod, 0, x->center, x->input_center, &tip, by_state, error);
    }
    for (size_t k = 0; k < 3 * n; k++) {
        rows[k] = by_state[k] * x->scale[k % n];
    }
    for (int s = 0; s < STEPS && status == AD_OK; s++) {
        for (size_t k = 0; k < 3 * n * n; k++) {
            const size_t r = k / n / n, a = k / n % n, b = k % n;
            x->weight[a * n + b] += rows[r * n + a] * rows[r * n + b];
        }
        memset(rows + 3 * n, 0, 3 * n * sizeof *rows);
        for (size_t k = 0; k < 3 * n * n; k++) {
            const size_t r = k / n / n, a = k / n % n, b = k % n;
            rows[3 * n + r * n + b] += rows[r * n + a] * F[a * n + b];
        }
        memcpy(rows, rows + 3 * n, 3 * n * sizeof *rows);
    }
    for (size_t j = 0; j < n; j++) {
        most = fmax(most, x->weight[j * n + j]);
    }
    for (size_t k = 0; k < n * n; k++) {
        x->weight[k] = (most > 0 ? x->weight[k] / most : 0) + (k % (n + 1) > 0 ? 0
                                                               : most > 0      ? ALL
                                                                               : 1);
    }
    free(by_state);
    return status;
}

static bool list_beginnings(physics_loss *x)
{
    const excite_rollouts *motions = x->motions;
    size_t all = 0, stride = 1;
    for (int pass = 0; pass < 2; pass++) {
        size_t number = 0;
        for (int i = 0; i < motions->count; i++) {
            for (int k = 0; k + x->settings.ahead <= motions->done[i]; k++, number++) {
                if (pass == 1 && number % stride == 0) {
                    x->begin[x->count][0] = i;
                    x->begin[x->count++][1] = k;
                }
            }
        }
        if (pass == 0) {
            all = number;
            const size_t most = (size_t)x->settings.most;
            stride = most > 0 ? (all + most - 1) / most : 1;
            stride = stride > 0 ? stride : 1;
            x->begin = calloc(all / stride + 2, sizeof *x->begin);
            if (!x->begin) {
                return false;
            }
        }
    }
    return true;
}

static bool make_worker(physics_loss *x, physics_worker *w)
{
    const decoupled *m = x->m;
    const size_t n = (size_t)m->states, given = physics_given(m),
                 outputs = (size_t)decoupled_outputs(m);
    size_t units = 0, wide = outputs > given ? outputs : given;
    for (int l = 0; l < m->layers; l++) {
        units += (size_t)m->width[l];
        wide = (size_t)m->width[l] > wide ? (size_t)m->width[l] : wide;
    }
    const size_t each = given + units + outputs + NODES * (4 * n + n * n) + n;
    const size_t all = (size_t)x->settings.ahead * each + (3 + NODES) * n + 2 * wide + given + n +
                       SCENE_PARAMETERS_MAX + n * n;
    double *at = w->memory = calloc(all, sizeof *at);
    for (int k = 0; k < x->settings.ahead && at; k++) {
        physics_step *s = &w->steps[k];
        double **const parts[] = {&s->given, &s->hidden, &s->a,        &s->y,  &s->rate,
                                  &s->n,     &s->by_z,   &s->residual, &s->end};
        const size_t sizes[] = {given,     units,         outputs,   NODES * n, NODES * n,
                                NODES * n, NODES * n * n, NODES * n, n};
        for (size_t i = 0; i < sizeof sizes / sizeof *sizes; i++) {
            *parts[i] = at;
            at += sizes[i];
        }
    }
    double **const rest[] = {&w->adjoint[0], &w->adjoint[1], &w->adjoint[2], &w->adjoint[3],
                             &w->to_a,       &w->to_hidden,  &w->to_given,   &w->state,
                             &w->input,      &w->jacobian};
    const size_t sizes[] = {n, n, n, NODES * n, wide, wide, given, n, SCENE_PARAMETERS_MAX, n * n};
    for (size_t i = 0; i < sizeof sizes / sizeof *sizes && at; i++) {
        *rest[i] = at;
        at += sizes[i];
    }
    return w->memory != NULL;
}

static ad_status allocate(physics_loss *x, ad_error *error)
{
    const size_t n = (size_t)x->m->states;
    x->weight = calloc(n * n, sizeof *x->weight);
    x->sums = calloc((CHUNKS + 1) * (2 + decoupled_parameters(x->m)), sizeof *x->sums);
    x->workers = calloc((size_t)ad_pool_threads(x->pool), sizeof *x->workers);
    bool good = x->weight && x->sums && x->workers && list_beginnings(x);
    for (int t = 0; t < ad_pool_threads(x->pool) && good; t++) {
        good = make_worker(x, &x->workers[t]);
    }
    if (good && x->count == 0) {
        return ad_fail(error, AD_BAD_ARGUMENT, "no rollout has %d steps", x->settings.ahead);
    }
    return good ? AD_OK : ad_fail(error, AD_NO_MEMORY, "out of memory for a loss");
}

/* So that states that stay, all parameters 0, have a loss of 1. */
static ad_status find_scale(physics_loss *x, ad_error *error)
{
    const int batch = x->settings.batch;
    double *zero = calloc(decoupled_parameters(x->m), sizeof *zero), value = NAN;
    x->settings.batch = 0;
    x->factor = 1;
    const bool fine = zero && physics_loss_evaluate(x, zero, &value, NULL) == 0;
    x->settings.batch = batch;
    x->factor = value > 0 ? 1 / value : 1;
    free(zero);
    return fine ? AD_OK
           : !zero
               ? ad_fail(error, AD_NO_MEMORY, "out of memory for a loss")
               : ad_fail(error, AD_NOT_FINITE, "the loss of curves that do not move is not finite");
}

/* States off the motions by up to settings.scatter of what is usual, most of them less. */
static ad_status scatter_states(physics_loss *x, ad_error *error)
{
    const excite_rollouts *from = x->motions;
    const size_t n = (size_t)from->states, rows = (size_t)from->count * (size_t)(from->steps + 1);
    nn_rng random = nn_rng_split(x->settings.seed, "off the motions");
    x->moved = *from;
    x->moved.state = malloc(rows * n * sizeof *x->moved.state);
    if (!x->moved.state) {
        return ad_fail(error, AD_NO_MEMORY, "out of memory for states");
    }
    for (size_t row = 0; row < rows; row++) {
        const double part = nn_rng_uniform(&random), reach = x->settings.scatter * part * part;
        for (size_t j = 0; j < n; j++) {
            x->moved.state[row * n + j] =
                from->state[row * n + j] + reach * x->scale[j] * (2 * nn_rng_uniform(&random) - 1);
        }
    }
    x->motions = &x->moved;
    return AD_OK;
}

/* Curves at the nodes that leave no defect, for every beginning; those without are left out. The
 * distance from these is the defect times the inverse of its derivatives: as Newton's method sees
 * it, and without the equations in every evaluation. */
static ad_status find_targets(physics_loss *x, const int modes[4], ad_error *error)
{
    const size_t n = (size_t)x->m->states, each = NODES * n, steps = (size_t)x->motions->steps;
    double z[256];
    size_t count = 0;
    x->target = malloc(((size_t)x->motions->count * steps + 1) * each * sizeof *x->target);
    ad_status status =
        x->target ? physics_collocate(x->scene, modes, x->motions, x->m, x->pool, x->target, error)
                  : ad_fail(error, AD_NO_MEMORY, "out of memory for nodes");
    for (size_t b = 0; b < x->count && status == AD_OK; b++) {
        const size_t i = (size_t)x->begin[b][0], k = (size_t)x->begin[b][1];
        double *target = x->target + (i * steps + k) * each;
        if (isnan(target[0])) {
            continue;
        }
        physics_take_state(x, i * (steps + 1) + k, z);
        for (size_t c = 0; c < each; c++) {
            const size_t j = c % n;
            target[c] = (target[c] - x->center[j]) / x->scale[j] - z[j];
        }
        memmove(x->begin[count++], x->begin[b], sizeof x->begin[b]);
    }
    x->count = count;
    return status != AD_OK || count > 0
               ? status
               : ad_fail(error, AD_NOT_FINITE, "no step of the rod's equations can be solved");
}

ad_status physics_open(const scene *open, const int modes[4], const excite_rollouts *motions,
                       const decoupled *m, const physics_loss_settings *settings, ad_pool *pool,
                       physics_loss **result, ad_error *error)
{
    const size_t n = (size_t)m->states, inputs = (size_t)m->inputs;
    const double tip = scene_length(open);
    reduced_settings of_rod = {.count = 1, .s = &tip};
    physics_loss *x = calloc(1, sizeof *x);
    *result = x;
    if (!x) {
        return ad_fail(error, AD_NO_MEMORY, "out of memory for a loss");
    }
    *x = (physics_loss){
        .scene = open, .motions = motions, .m = m, .settings = *settings, .pool = pool};
    x->center = m->numbers;
    x->scale = x->center + n;
    x->input_center = x->scale + n;
    x->input_scale = x->input_center + inputs;
    memcpy(of_rod.modes, modes, sizeof of_rod.modes);
    find_integrals(x);
    ad_status status = allocate(x, error);
    for (int t = 0; t < ad_pool_threads(pool) && status == AD_OK; t++) {
        status = reduced_create(open, &of_rod, &x->workers[t].rod, error);
    }
    return status;
}

ad_status physics_loss_create(const scene *open, const int modes[4], const excite_rollouts *motions,
                              const decoupled *m, const physics_loss_settings *settings,
                              ad_pool *pool, physics_loss **result, ad_error *error)
{
    const size_t n = (size_t)m->states;
    physics_loss *x = NULL;
    *result = NULL;
    if (!(settings->physics + settings->data > 0) || settings->ahead < 1 ||
        settings->ahead > AHEAD_MAX || (settings->scatter > 0 && settings->data > 0)) {
        return ad_fail(
            error, AD_BAD_ARGUMENT,
            "a loss of nothing, of %d steps in a row, or of solved steps from states off "
            "the motions",
            settings->ahead);
    }
    ad_status status = physics_open(open, modes, motions, m, settings, pool, &x, error);
    if (status == AD_OK && settings->tip) {
        status = find_weight(x, x->workers[0].rod, error);
    }
    for (size_t j = 0; j < n && status == AD_OK && !settings->tip; j++) {
        x->weight[j * n + j] = 1;
    }
    if (status == AD_OK && settings->scatter > 0) {
        status = scatter_states(x, error);
    }
    if (status == AD_OK && settings->physics > 0 && !settings->rates && settings->ahead == 1) {
        status = find_targets(x, modes, error);
    }
    status = status == AD_OK ? find_scale(x, error) : status;
    if (status != AD_OK) {
        physics_loss_free(x);
        return status;
    }
    *result = x;
    return AD_OK;
}

void physics_loss_free(physics_loss *x)
{
    if (!x) {
        return;
    }
    for (int t = 0; x->workers && t < ad_pool_threads(x->pool); t++) {
        reduced_free(x->workers[t].rod);
        free(x->workers[t].memory);
    }
    free(x->workers);
    free(x->begin);
    free(x->target);
    free(x->moved.state);
    free(x->weight);
    free(x->sums);
    free(x);
}
