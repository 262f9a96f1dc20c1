/* What a loss by the equations of the rod is made of: flows, integrals, weights, beginnings. */
#include "tools/surrogate/physics_internal.h"

#include "nn/rng.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

/* Integrals of exp(A (c_i - s)) l_j(s) from 0 to c_i, l_j Lagrange's polynomials at the nodes; with
 * A = 0 the matrix of Radau's method. */
static ad_status find_integrals(physics_loss *x, ad_error *error)
{
    const size_t n = (size_t)x->m->states, columns = n + (size_t)x->m->inputs + 1;
    const size_t order = (NODES + 1) * n;
    double *memory = malloc(3 * order * order * sizeof *memory);
    double *a = memory, *e = a + order * order, *room = e + order * order;
    if (!memory) {
        return ad_fail(error, AD_NO_MEMORY, "out of memory for integrals of a flow");
    }
    for (size_t i = 0; i < NODES; i++) {
        memset(a, 0, order * order * sizeof *a);
        for (size_t r = 0; r < NODES * n; r++) {
            for (size_t c = 0; c < n && r < n; c++) {
                a[r * order + c] = decoupled_nodes[i] * x->linear[r * columns + c];
            }
            a[r * order + r + n] = decoupled_nodes[i];
        }
        decoupled_exponential(order, a, e, room);
        /* block k + 1 of the first row: integral of exp(A (c - s)) s^k / k! */
        for (size_t j = 0; j < NODES; j++) {
            const double p = decoupled_nodes[(j + 1) % NODES], q = decoupled_nodes[(j + 2) % NODES];
            const double by = 1 / ((decoupled_nodes[j] - p) * (decoupled_nodes[j] - q));
            const double of[NODES] = {p * q * by, -(p + q) * by, 2 * by};
            double *to = x->integral + (i * NODES + j) * n * n;
            for (size_t k = 0; k < n * n * NODES; k++) {
                const size_t r = k / NODES / n, c = k / NODES % n;
                to[r * n + c] += of[k % NODES] * e[r * order + (k % NODES + 1) * n + c];
            }
        }
    }
    free(memory);
    return AD_OK;
}

/* weight = sum over 250 steps of (F^k)^T C^T C F^k, so that its largest number is 1, and
 * settings.all times the unit matrix; F the flow of a step, C of the tip by z in the middle. */
static ad_status find_weight(physics_loss *x, reduced_rod *rod, ad_error *error)
{
    enum { STEPS = 250 };
    const size_t n = (size_t)x->m->states, order = physics_order(x->m);
    decoupled flowing = *x->m;
    double *by_state = calloc(12 * n + 6 * n + n * order + decoupled_work(x->m), sizeof *by_state);
    double *rows = by_state + 12 * n, *flow = rows + 6 * n, most = 0;
    reduced_place tip;
    if (!by_state) {
        return ad_fail(error, AD_NO_MEMORY, "out of memory for a tip");
    }
    flowing.flows = true;
    decoupled_flow(&flowing, 1, flow + n * order, flow);
    ad_status status = reduced_output(rod, 0, x->center, x->input_center, &tip, by_state, error);
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
            rows[3 * n + r * n + b] += rows[r * n + a] * flow[a * order + b];
        }
        memcpy(rows, rows + 3 * n, 3 * n * sizeof *rows);
    }
    for (size_t j = 0; j < n; j++) {
        most = fmax(most, x->weight[j * n + j]);
    }
    for (size_t k = 0; k < n * n; k++) {
        x->weight[k] = (most > 0 ? x->weight[k] / most : 0) + (k % (n + 1) > 0 ? 0
                                                               : most > 0      ? x->settings.all
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
    const size_t n = (size_t)m->states, order = physics_order(m),
                 outputs = (size_t)decoupled_outputs(m);
    size_t units = 0, wide = outputs > order ? outputs : order;
    for (int l = 0; l < m->layers; l++) {
        units += (size_t)m->width[l];
        wide = (size_t)m->width[l] > wide ? (size_t)m->width[l] : wide;
    }
    const size_t each = order + units + outputs + NODES * (4 * n + n * n) + n;
    const size_t all = (size_t)x->settings.ahead * each + (3 + NODES) * n + 2 * wide + order + n +
                       SCENE_PARAMETERS_MAX + n * n;
    double *at = w->memory = calloc(all, sizeof *at);
    for (int k = 0; k < x->settings.ahead && at; k++) {
        physics_step *s = &w->steps[k];
        double **const parts[] = {&s->given, &s->hidden, &s->a,        &s->y,  &s->rate,
                                  &s->n,     &s->by_z,   &s->residual, &s->end};
        const size_t sizes[] = {order,     units,         outputs,   NODES * n, NODES * n,
                                NODES * n, NODES * n * n, NODES * n, n};
        for (size_t i = 0; i < sizeof sizes / sizeof *sizes; i++) {
            *parts[i] = at;
            at += sizes[i];
        }
    }
    double **const rest[] = {&w->adjoint[0], &w->adjoint[1], &w->adjoint[2], &w->adjoint[3],
                             &w->to_a,       &w->to_hidden,  &w->to_given,   &w->state,
                             &w->input,      &w->jacobian};
    const size_t sizes[] = {n, n, n, NODES * n, wide, wide, order, n, SCENE_PARAMETERS_MAX, n * n};
    for (size_t i = 0; i < sizeof sizes / sizeof *sizes && at; i++) {
        *rest[i] = at;
        at += sizes[i];
    }
    return w->memory != NULL;
}

static ad_status allocate(physics_loss *x, ad_error *error)
{
    const size_t n = (size_t)x->m->states;
    const size_t columns = n + (size_t)x->m->inputs + 1;
    x->flow = calloc(NODES * n * physics_order(x->m), sizeof *x->flow);
    x->zero = calloc(n * columns, sizeof *x->zero);
    x->integral = calloc(n * n * NODES * NODES, sizeof *x->integral);
    x->weight = calloc(n * n, sizeof *x->weight);
    x->sums = calloc((CHUNKS + 1) * (2 + decoupled_parameters(x->m)), sizeof *x->sums);
    x->workers = calloc((size_t)ad_pool_threads(x->pool), sizeof *x->workers);
    bool good = x->flow && x->zero && x->integral && x->weight && x->sums && x->workers &&
                list_beginnings(x);
    for (int t = 0; t < ad_pool_threads(x->pool) && good; t++) {
        good = make_worker(x, &x->workers[t]);
    }
    if (good && x->count == 0) {
        return ad_fail(error, AD_BAD_ARGUMENT, "no rollout has %d steps", x->settings.ahead);
    }
    return good ? AD_OK : ad_fail(error, AD_NO_MEMORY, "out of memory for a loss");
}

static ad_status find_flows(physics_loss *x, ad_error *error)
{
    const size_t n = (size_t)x->m->states;
    double *work = calloc(decoupled_work(x->m), sizeof *work);
    if (!work) {
        return ad_fail(error, AD_NO_MEMORY, "out of memory for a flow");
    }
    for (size_t i = 0; i < NODES; i++) {
        decoupled_flow(x->m, decoupled_nodes[i], work, x->flow + i * n * physics_order(x->m));
    }
    free(work);
    return AD_OK;
}

/* So that the base alone, all parameters 0, has a loss of 1. */
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
    double *given = x->workers[0].steps[0].given, z[256];
    decoupled plain =
        *x->m; /* on stiff rods Radau's method is better by itself than beside a flow */
    size_t count = 0;
    plain.flows = false;
    x->target = malloc(((size_t)x->motions->count * steps + 1) * each * sizeof *x->target);
    ad_status status = x->target ? physics_collocate(x->scene, modes, x->motions, &plain, x->pool,
                                                     x->target, error)
                                 : ad_fail(error, AD_NO_MEMORY, "out of memory for nodes");
    for (size_t b = 0; b < x->count && status == AD_OK; b++) {
        const size_t i = (size_t)x->begin[b][0], k = (size_t)x->begin[b][1];
        double *target = x->target + (i * steps + k) * each;
        if (isnan(target[0])) {
            continue;
        }
        physics_take_state(x, i * (steps + 1) + k, given);
        physics_take_inputs(x, i * (steps + 1) + k, given + n);
        given[physics_order(x->m) - 1] = 1;
        for (size_t c = 0; c < NODES; c++) {
            physics_base(x, x->flow + c * n * physics_order(x->m), given, z);
            for (size_t j = 0; j < n; j++) {
                double *y = target + c * n + j;
                *y = (*y - x->center[j]) / x->scale[j] - z[j];
            }
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
    x->mean = x->input_scale + inputs + n; /* behind the ranges of states */
    memcpy(of_rod.modes, modes, sizeof of_rod.modes);
    ad_status status = allocate(x, error);
    x->linear = m->flows ? x->mean : x->zero;
    for (int t = 0; t < ad_pool_threads(pool) && status == AD_OK; t++) {
        status = reduced_create(open, &of_rod, &x->workers[t].rod, error);
    }
    status = status == AD_OK ? find_flows(x, error) : status;
    return status == AD_OK ? find_integrals(x, error) : status;
}

ad_status physics_loss_create(const scene *open, const int modes[4], const excite_rollouts *motions,
                              const decoupled *m, const physics_loss_settings *settings,
                              ad_pool *pool, physics_loss **result, ad_error *error)
{
    const size_t n = (size_t)m->states;
    physics_loss *x = NULL;
    *result = NULL;
    if (!(settings->physics + settings->data > 0) || settings->ahead < 1 ||
        settings->ahead > AHEAD_MAX || (settings->rates && m->flows) ||
        (settings->scatter > 0 && settings->data > 0)) {
        return ad_fail(
            error, AD_BAD_ARGUMENT,
            "a loss of nothing, of %d steps in a row, of rates beside a flow, or of solved "
            "steps from states off the motions",
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
    free(x->flow);
    free(x->zero);
    free(x->integral);
    free(x->weight);
    free(x->sums);
    free(x);
}
