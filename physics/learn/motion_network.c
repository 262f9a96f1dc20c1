#include "physics/learn/motion_network.h"

#include "autodiff/dense.h"
#include "physics/numerics/constants.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

struct motion_network {
    const physics_model *model;
    int functions; /* with the bias */
    ad_program *program;
    bool has_window; /* a uniform of the program */
    double begin;    /* of the window */
    size_t count, capacity;
    double *t;      /* [count] */
    double *values; /* [count][3][functions] */
    double *room;   /* [3][count], s [count] */
    double *basis;  /* [functions][functions] parameters of one output for each function */
};

/* Functions whose second derivatives are orthonormal over a window, so that parameters are how much
 * there is of accelerations of unit size: with others, even orthogonal polynomials times t^2,
 * J^T J is so ill-conditioned that steps end digits before rounding. The same for every window. */
static ad_status find_basis(motion_network *network, ad_error *error)
{
    enum { POINTS = 4 }; /* for each function */
    const size_t n = (size_t)network->functions, points = POINTS * n;
    const double begin = domain_window_time(&network->model->domain, 0);
    const double span = domain_window_time(&network->model->domain, 1) - begin;
    double *t = malloc((points + n * points + n * n + AD_DENSE_BASIS_WORK(n)) * sizeof *t);
    int *order = malloc(n * sizeof *order);
    ad_status status = ad_dense_load(error);
    if (status == AD_OK && (!t || !order)) {
        status = ad_fail(error, AD_NO_MEMORY, "out of memory for the functions of a motion");
    }
    double *columns = t + points, *made = columns + n * points, *work = made + n * n;
    for (size_t i = 0; i < points && status == AD_OK; i++) {
        t[i] = begin + span * (1 - cos(PI * ((double)i + 0.5) / (double)points)) / 2;
    }
    for (size_t j = 0; j < n; j++) {
        network->basis[j * n + j] = 1;
    }
    status = status == AD_OK ? motion_network_at(network, 0, points, t, error) : status;
    for (size_t i = 0; i < n * points && status == AD_OK; i++) {
        columns[i] = motion_network_values(network, i % points, 2)[i / points];
    }
    if (status == AD_OK && ad_dense_basis(points, n, columns, 1e-11, made, order, work) < n) {
        status = ad_fail(error, AD_BAD_ARGUMENT,
                         "some of the network's %zu functions of time are the same", n);
    }
    for (size_t i = 0; i < n * n && status == AD_OK; i++) {
        network->basis[i] = sqrt((double)points) * made[i];
    }
    free(t);
    free(order);
    return status;
}

/* t^2 times what one output is of its parameters, and its derivatives by t. */
static ad_status compile(motion_network *network, const nn_mlp *mlp, ad_pool *pool, ad_error *error)
{
    const domain *d = &network->model->domain;
    const domain_uniforms uniforms = {.window = network->has_window};
    ad_value wrt[2], outputs[3];
    ad_tape *tape = ad_tape_create();
    domain_place at = domain_record(d, &uniforms, tape);
    ad_value single = nn_mlp_record_single(mlp, domain_unit(d, &at, d->time), wrt);
    outputs[0] = ad_mul(ad_square(domain_elapsed(d, &at)), single);
    for (int k = 1; k < 3; k++) {
        outputs[k] = ad_derivative(outputs[0], at.x[d->time], k);
    }
    ad_status status = ad_compile(3, outputs, NULL, pool, &network->program, error);
    ad_tape_free(tape);
    return status;
}

ad_status motion_network_create(const physics_model *m, const nn_mlp *mlp, ad_pool *pool,
                                motion_network **result, ad_error *error)
{
    *result = NULL;
    const int functions = nn_mlp_features(mlp) + 1;
    if ((size_t)functions * (size_t)m->motion->size != nn_mlp_parameters(mlp)) {
        return ad_fail(error, AD_BAD_ARGUMENT,
                       "the network of a motion is one of time without hidden layers");
    }
    motion_network *network = calloc(1, sizeof *network);
    if (!network) {
        return ad_fail(error, AD_NO_MEMORY, "out of memory for the network of a motion");
    }
    *network =
        (motion_network){.model = m, .functions = functions, .has_window = m->domain.windows > 1};
    network->basis = calloc((size_t)functions * (size_t)functions, sizeof *network->basis);
    ad_status status = network->basis ? compile(network, mlp, pool, error)
                                      : ad_fail(error, AD_NO_MEMORY, "out of memory for a motion");
    status = status == AD_OK ? find_basis(network, error) : status;
    if (status != AD_OK) {
        motion_network_free(network);
        return status;
    }
    *result = network;
    return AD_OK;
}

void motion_network_free(motion_network *network)
{
    if (network) {
        ad_program_free(network->program);
        free(network->t);
        free(network->values);
        free(network->room);
        free(network->basis);
        free(network);
    }
}

static ad_status make_room(motion_network *network, size_t count, ad_error *error)
{
    if (count <= network->capacity) {
        return AD_OK;
    }
    free(network->t);
    free(network->values);
    free(network->room);
    network->t = malloc(count * sizeof *network->t);
    network->values = malloc(3 * count * (size_t)network->functions * sizeof *network->values);
    network->room = calloc(4 * count, sizeof *network->room);
    network->capacity = network->t && network->values && network->room ? count : 0;
    return network->capacity
               ? AD_OK
               : ad_fail(error, AD_NO_MEMORY, "out of memory for %zu instants", count);
}

ad_status motion_network_at(motion_network *network, int window, size_t count, const double *t,
                            ad_error *error)
{
    const domain *d = &network->model->domain;
    const size_t functions = (size_t)network->functions;
    const double begin = domain_window_time(d, window);
    const double times[2] = {begin, domain_window_time(d, window + 1) - begin};
    ad_status status = make_room(network, count, error);
    network->count = count;
    network->begin = begin;
    if (status == AD_OK && count > 0) {
        memcpy(network->t, t, count * sizeof *t);
        memset(network->room + 3 * count, 0, count * sizeof *network->room);
    }
    for (size_t j = 0; j < functions && count > 0 && status == AD_OK; j++) {
        const double *inputs[] = {network->room + 3 * count, network->t}, *uniforms[] = {times};
        double *outputs[] = {network->room, network->room + count, network->room + 2 * count};
        const ad_run run = {.points = count,
                            .inputs = inputs,
                            .uniforms = uniforms,
                            .parameters = network->basis + j * functions,
                            .outputs = outputs};
        status = ad_execute(network->program, &run, error);
        for (size_t i = 0; i < 3 * count; i++) {
            network->values[(3 * (i % count) + i / count) * functions + j] = network->room[i];
        }
    }
    return status;
}

int motion_network_functions(const motion_network *network)
{
    return network->functions;
}

const double *motion_network_values(const motion_network *network, size_t instant, int derivative)
{
    return network->values + (3 * instant + (size_t)derivative) * (size_t)network->functions;
}

void motion_network_state(const motion_network *network, size_t instant, const double *start,
                          const double *parameters, double *y)
{
    const int size = network->model->motion->size, features = network->functions - 1;
    const double elapsed = network->t[instant] - network->begin;
    start = start ? start : network->model->motion->start;
    for (int k = 0; k < 3; k++) {
        const double *value = motion_network_values(network, instant, k);
        for (int a = 0; a < size; a++) {
            const double *weights = parameters + (size_t)a * (size_t)features;
            double sum = parameters[(size_t)size * (size_t)features + (size_t)a] * value[features];
            for (int j = 0; j < features; j++) {
                sum += weights[j] * value[j];
            }
            for (int d = 1; d >= k; d--) { /* Taylor's polynomial of the start */
                const double by = d == k ? 1 : elapsed;
                sum += by * start[d * size + a];
            }
            y[k * size + a] = sum;
        }
    }
}

/* ---- observables --------------------------------------------------------------------------- */

typedef struct placed {
    double t;
    size_t point;
} placed;

static int by_time(const void *a, const void *b)
{
    const placed *placed = a, *y = b;
    return placed->t != y->t ? (placed->t > y->t) - (placed->t < y->t)
                             : (placed->point > y->point) - (placed->point < y->point);
}

/* All points of one instant together. */
static ad_status observe_instant(const motion_network *network, const placed *all, size_t count,
                                 const double *y, const double *s, int columns, size_t points,
                                 double *room, double *values, ad_error *error)
{
    const model_motion *motion = network->model->motion;
    double *places = room, *found = room + count;
    for (size_t i = 0; i < count; i++) {
        places[i] = s[all[i].point];
    }
    ad_status status =
        motion->observe(motion->context, all[0].t, y, count, places, count, found, error);
    for (size_t i = 0; i < (size_t)columns * count && status == AD_OK; i++) {
        values[i / count * points + all[i % count].point] = found[i];
    }
    return status;
}

ad_status motion_network_observe(motion_network *network, int window, const double *start,
                                 const double *parameters, size_t points, const double *s,
                                 const double *t, int columns, double *values, ad_error *error)
{
    const size_t size = (size_t)network->model->motion->size;
    const size_t all_columns = (size_t)network->model->column_count;
    placed *all = malloc((points + 1) * sizeof *all);
    double *times = malloc((points + 1) * sizeof *times), *y = malloc(3 * size * sizeof *y);
    double *room = malloc((all_columns + 1) * (points + 1) * sizeof *room);
    ad_status status = all && times && y && room
                           ? AD_OK
                           : ad_fail(error, AD_NO_MEMORY, "out of memory for %zu points", points);
    size_t instants = 0;
    for (size_t i = 0; i < points && status == AD_OK; i++) {
        all[i] = (placed){t[i], i};
    }
    if (status == AD_OK) {
        qsort(all, points, sizeof *all, by_time);
    }
    for (size_t i = 0; i < points && status == AD_OK; i++) {
        if (i == 0 || all[i].t != times[instants - 1]) {
            times[instants++] = all[i].t;
        }
    }
    status = status == AD_OK ? motion_network_at(network, window, instants, times, error) : status;
    for (size_t i = 0, k = 0, count; i < points && status == AD_OK; i += count, k++) {
        count = 1;
        while (i + count < points && all[i + count].t == all[i].t) {
            count++;
        }
        motion_network_state(network, k, start, parameters, y);
        status =
            observe_instant(network, all + i, count, y, s, columns, points, room, values, error);
    }
    free(all);
    free(times);
    free(y);
    free(room);
    return status;
}

ad_status motion_network_off(motion_network *network, int window, const double *start,
                             const double *parameters, model_motion_error *off, ad_error *error)
{
    enum { INSTANTS = 8 }; /* for each function: residuals have about as many zeros as there are */
    const domain *d = &network->model->domain;
    const model_motion *motion = network->model->motion;
    const double begin = domain_window_time(d, window), end = domain_window_time(d, window + 1);
    const size_t count = INSTANTS * (size_t)network->functions, size = (size_t)motion->size;
    double *t = malloc((count + 3 * count * size) * sizeof *t), *y = t + count;
    if (!t) {
        return ad_fail(error, AD_NO_MEMORY, "out of memory for a motion");
    }
    for (size_t i = 0; i < count; i++) {
        t[i] = begin + (end - begin) * ((double)i + 0.5) / (double)count;
    }
    ad_status status = motion_network_at(network, window, count, t, error);
    for (size_t i = 0; i < count && status == AD_OK; i++) {
        motion_network_state(network, i, start, parameters, y + 3 * size * i);
    }
    if (status == AD_OK) {
        status = motion->off(motion->context, begin, end, count, y, off, error);
    }
    free(t);
    return status;
}
