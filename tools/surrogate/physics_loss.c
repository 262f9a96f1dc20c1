#include "tools/surrogate/physics_internal.h"

#include "autodiff/ranks.h"
#include "nn/rng.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

/* Times in a step, each in a part of its own; parts of a sum; what they are summed of. */
enum { TIMES = 3, CHUNKS = 16 };
enum { SUM_VALUE, SUM_FAILED, SUM_GRADIENT };

struct physics_loss {
    physics of;
    physics_loss_settings settings;
    ad_pool *pool;
    size_t count;    /* of beginnings */
    int (*begin)[2]; /* [count]: rollout, step */
    double *sums;    /* [CHUNKS + 1][2 + parameters]: value, how many have none, gradient; of
                      * chunks, then of all */
    double factor;   /* of the loss */
    const double *parameters;
    bool derives;
    int64_t number; /* of the step of training */
    physics_worker *workers;
};

/* What a worker has of its own. */
typedef struct room {
    double *hidden, *a, *to_a, *to_hidden;  /* of the network, and adjoints */
    double *y, *rate, *z, *f, *by_y, *by_z; /* [n] each, [n][n] */
} room;

static size_t widest(const decoupled *m)
{
    int wide = decoupled_outputs(m);
    for (int l = 0; l < m->layers; l++) {
        wide = m->width[l] > wide ? m->width[l] : wide;
    }
    return (size_t)wide;
}

static room room_of(const decoupled *m, double *at)
{
    const size_t n = (size_t)m->states;
    room r = {.a = at, .to_a = at + widest(m), .to_hidden = at + 2 * widest(m)};
    r.y = at + 3 * widest(m);
    r.rate = r.y + n;
    r.z = r.rate + n;
    r.f = r.z + n;
    r.by_y = r.f + n;
    r.by_z = r.by_y + n;
    r.hidden = r.by_z + n * n;
    return r;
}

static size_t room_numbers(const decoupled *m)
{
    const size_t n = (size_t)m->states;
    size_t units = 0;
    for (int l = 0; l < m->layers; l++) {
        units += (size_t)m->width[l];
    }
    return 3 * widest(m) + 5 * n + n * n + units;
}

/* ---- one step ------------------------------------------------------------------------------ */

/* Adds to the gradient what the adjoint of a, r->to_a, is of the parameters. */
static void network_adjoint(const physics_loss *loss, const physics_worker *w, const room *r,
                            double *gradient)
{
    const decoupled *m = loss->of.m;
    const double *weights = loss->parameters, *hidden = r->hidden;
    const double *inputs[DECOUPLED_LAYERS_MAX + 1], *of[DECOUPLED_LAYERS_MAX + 1];
    double *to[DECOUPLED_LAYERS_MAX + 1];
    size_t in[DECOUPLED_LAYERS_MAX + 1];
    for (int l = 0; l <= m->layers; l++) {
        in[l] = l == 0 ? physics_given(m) : (size_t)m->width[l - 1];
        const size_t out = (size_t)(l < m->layers ? m->width[l] : decoupled_outputs(m));
        inputs[l] = l == 0 ? w->given : hidden - in[l];
        of[l] = weights;
        to[l] = gradient;
        weights += out * (in[l] + 1);
        gradient += out * (in[l] + 1);
        hidden += l < m->layers ? out : 0;
    }
    double *adjoint = r->to_a, *before = r->to_hidden;
    for (int l = m->layers; l >= 0; l--) {
        const size_t out = (size_t)(l < m->layers ? m->width[l] : decoupled_outputs(m));
        memset(before, 0, (l > 0 ? in[l] : 0) * sizeof *before);
        for (size_t i = 0; i < out; i++) {
            const double by = adjoint[i], *row = of[l] + i * in[l];
            double *row_to = to[l] + i * in[l];
            for (size_t c = 0; c < in[l]; c++) {
                row_to[c] += by * inputs[l][c];
            }
            for (size_t c = 0; c < in[l] && l > 0; c++) {
                before[c] += by * row[c];
            }
            to[l][out * in[l] + i] += by;
        }
        for (size_t c = 0; c < in[l] && l > 0; c++) {
            before[c] *= 1 - inputs[l][c] * inputs[l][c];
        }
        double *const back = before; /* both as wide as the widest of all */
        before = adjoint;
        adjoint = back;
    }
}

/* The loss of one beginning times scale, and where it is wanted its gradient. */
static bool evaluate_one(const physics_loss *loss, physics_worker *w, size_t item, double scale,
                         double *value, double *gradient)
{
    const decoupled *m = loss->of.m;
    const int n = m->states;
    const room r = room_of(m, w->own);
    const double each = scale / (TIMES * n);
    uint64_t state = loss->settings.seed ^ ((uint64_t)loss->number << 20) ^ (item << 5);
    physics_take(&loss->of, loss->begin[item][0], loss->begin[item][1], w);
    decoupled_network(m, loss->parameters, w->given, w->given + n, r.hidden, r.a);
    memset(r.to_a, 0, (size_t)decoupled_outputs(m) * sizeof *r.to_a);
    for (int i = 0; i < TIMES; i++) {
        const double uniform = (double)(nn_splitmix64(&state) >> 11) * 0x1p-53;
        const double t = (i + uniform) / TIMES;
        decoupled_curve(m, r.a, t, r.y, r.rate);
        for (int j = 0; j < n; j++) {
            r.z[j] = w->given[j] + r.y[j];
            r.by_y[j] = 0;
        }
        if (!physics_rate(&loss->of, w, t, r.z, r.f, loss->derives ? r.by_z : NULL)) {
            return false;
        }
        for (int j = 0; j < n; j++) {
            const double off = r.rate[j] - r.f[j];
            *value += each * off * off;
            r.rate[j] = 2 * each * off; /* its adjoint */
            for (int c = 0; c < n && loss->derives; c++) {
                r.by_y[c] -= r.rate[j] * r.by_z[j * n + c];
            }
        }
        if (loss->derives) {
            decoupled_curve_adjoint(m, r.a, t, r.by_y, r.rate, r.to_a);
        }
    }
    if (loss->derives) {
        network_adjoint(loss, w, &r, gradient);
    }
    return isfinite(*value);
}

/* ---- all ----------------------------------------------------------------------------------- */

static size_t batch_of(const physics_loss *loss)
{
    const size_t batch = (size_t)loss->settings.batch;
    return batch > 0 && batch < loss->count ? batch : loss->count;
}

static size_t sum_width(const physics_loss *loss)
{
    return SUM_GRADIENT + (loss->derives ? decoupled_parameters(loss->of.m) : 0);
}

static void run_chunk(void *context, int chunk, int thread)
{
    const physics_loss *loss = context;
    const size_t all = batch_of(loss), width = sum_width(loss);
    double *sum = loss->sums + (size_t)chunk * width;
    memset(sum, 0, width * sizeof *sum);
    for (size_t i = (size_t)chunk; i < all && sum[SUM_FAILED] == 0; i += CHUNKS) {
        uint64_t state = loss->settings.seed ^ ((uint64_t)loss->number << 24) ^ i;
        const size_t item = all < loss->count ? nn_splitmix64(&state) % loss->count : i;
        sum[SUM_FAILED] =
            !evaluate_one(loss, &loss->workers[thread], item, loss->factor / (double)all,
                          &sum[SUM_VALUE], sum + SUM_GRADIENT);
    }
}

void physics_loss_draw(physics_loss *loss, int64_t number)
{
    loss->number = loss->settings.batch > 0 ? number : 0;
}

int physics_loss_evaluate(void *loss, const double *parameters, double *value, double *gradient)
{
    physics_loss *of = loss;
    const size_t count = decoupled_parameters(of->of.m);
    of->parameters = parameters;
    of->derives = gradient != NULL;
    const size_t width = sum_width(of);
    double *total = of->sums + CHUNKS * width;
    if (ad_pool_sum(of->pool, CHUNKS, run_chunk, of, width, of->sums, total, NULL) != AD_OK) {
        return 2; /* OPTIM_OBJECTIVE_STOP */
    }
    *value = total[SUM_VALUE];
    if (gradient) {
        memcpy(gradient, total + SUM_GRADIENT, count * sizeof *gradient);
    }
    return total[SUM_FAILED] == 0 && isfinite(*value) ? 0 : 1; /* OPTIM_OBJECTIVE_NOT_FINITE */
}

/* ---- creation ------------------------------------------------------------------------------ */

static bool list_beginnings(physics_loss *loss)
{
    const excitation_rollouts *motions = loss->of.motions;
    size_t all = 0, stride = 1;
    for (int pass = 0; pass < 2; pass++) {
        size_t number = 0;
        for (int i = 0; i < motions->count; i++) {
            for (int k = 0; k < motions->done[i]; k++, number++) {
                if (pass == 1 && number % stride == 0) {
                    loss->begin[loss->count][0] = i;
                    loss->begin[loss->count++][1] = k;
                }
            }
        }
        if (pass == 0) {
            all = number;
            const size_t most = (size_t)loss->settings.most;
            stride = most > 0 ? (all + most - 1) / most : 1;
            stride = stride > 0 ? stride : 1;
            loss->begin = calloc(all / stride + 2, sizeof *loss->begin);
            if (!loss->begin) {
                return false;
            }
        }
    }
    return true;
}

/* So that states that stay, all parameters 0, have a loss of 1. */
static ad_status find_scale(physics_loss *loss, ad_error *error)
{
    const int batch = loss->settings.batch;
    double *zero = calloc(decoupled_parameters(loss->of.m), sizeof *zero), value = NAN;
    loss->settings.batch = 0;
    loss->factor = 1;
    const bool fine = zero && physics_loss_evaluate(loss, zero, &value, NULL) == 0;
    loss->settings.batch = batch;
    loss->factor = value > 0 ? 1 / value : 1;
    free(zero);
    return fine ? AD_OK
           : !zero
               ? ad_fail(error, AD_NO_MEMORY, "out of memory for a loss")
               : ad_fail(error, AD_NOT_FINITE, "the loss of curves that do not move is not finite");
}

ad_status physics_loss_create(const scene *open, const int modes[4],
                              const excitation_rollouts *motions, const decoupled *m,
                              const physics_loss_settings *settings, ad_pool *pool,
                              physics_loss **result, ad_error *error)
{
    physics_loss *loss = calloc(1, sizeof *loss);
    *result = NULL;
    if (!loss) {
        return ad_fail(error, AD_NO_MEMORY, "out of memory for a loss");
    }
    *loss = (physics_loss){.of = physics_of(m, motions), .settings = *settings, .pool = pool};
    loss->sums =
        calloc((CHUNKS + 1) * (SUM_GRADIENT + decoupled_parameters(m)), sizeof *loss->sums);
    ad_status status = loss->sums && list_beginnings(loss)
                           ? physics_workers_create(open, modes, m, ad_pool_threads(pool),
                                                    room_numbers(m), &loss->workers, error)
                           : ad_fail(error, AD_NO_MEMORY, "out of memory for a loss");
    if (status == AD_OK && loss->count == 0) {
        status = ad_fail(error, AD_BAD_ARGUMENT, "no rollout has a step");
    }
    status = status == AD_OK ? find_scale(loss, error) : status;
    if (status != AD_OK) {
        physics_loss_free(loss);
        return status;
    }
    *result = loss;
    return AD_OK;
}

void physics_loss_free(physics_loss *loss)
{
    if (loss) {
        physics_workers_free(ad_pool_threads(loss->pool), loss->workers);
        free(loss->begin);
        free(loss->sums);
        free(loss);
    }
}
