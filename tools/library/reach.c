/* Inverse kinematics: parameters of a family that bring its tip to places. */
#include "autodiff/host.h"
#include "autodiff/memory.h"
#include "nn/rng.h"
#include "optim/seek.h"
#include "physics/numerics/quaternion.h"
#include "physics/numerics/vector_size.h"
#include "tools/library/trained_family.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

/* Random members that starts are chosen from, of one place and for each further; starts of a place;
 * steps of a start; places at a time. */
enum { DRAWN = 128, DRAWN_EACH = 8, DRAWN_MAX = 2048, STARTS = 12, STEPS = 30, BATCH = 64 };

typedef struct reaching {
    cpinn_family *family;
    const cpinn_reach_settings *settings;
    double tolerance;
    size_t count, width; /* parameters; numbers of a shape */
    double low[SCENE_PARAMETERS_MAX], high[SCENE_PARAMETERS_MAX];
    size_t drawn;
    double *sample, *tip;           /* [drawn][count], [drawn][3]; NaN: there is none */
    double *at, *values, *jacobian; /* of members [BATCH] */
    cpinn_answer *answers;          /* [BATCH] */
    ad_memory memory;
} reaching;

static ad_status refuse(const cpinn_family *family, const cpinn_reach_settings *settings,
                        ad_error *error)
{
    const char *why = family->solves_all ? "tips of a robot in motion are not sought"
                                         : cpinn_family_without_error(family);
    if (*why || family->points == 0) {
        return ad_fail(error, AD_BAD_ARGUMENT, "%s",
                       *why ? why : "the family has no points, of which the last is the tip");
    }
    for (int p = 0; p < family->count && settings->fixed; p++) {
        const scene_parameter *of = cpinn_family_parameter(family, p);
        const double value = settings->fixed[p];
        if (!isnan(value) &&
            !(scene_parameter_holds(of, value) || (family->extrapolate && isfinite(value)))) {
            return ad_fail(error, AD_BAD_ARGUMENT, "%s is %g; allowed: %g to %g", of->name, value,
                           of->low, of->high);
        }
    }
    return AD_OK;
}

static void free_reaching(reaching *r)
{
    ad_memory_free(&r->memory);
}

static ad_status prepare(reaching *r, size_t tips, ad_error *error)
{
    const cpinn_family *family = r->family;
    const size_t more = tips < DRAWN_MAX / DRAWN_EACH ? DRAWN_EACH * tips : DRAWN_MAX;
    r->drawn = DRAWN + more < DRAWN_MAX ? DRAWN + more : DRAWN_MAX;
    r->count = (size_t)family->count;
    r->width = family->points * (size_t)family->columns;
    r->tolerance = r->settings->tolerance > 0 ? r->settings->tolerance : CPINN_REACHED;
    for (int p = 0; p < family->count; p++) {
        const scene_parameter *of = cpinn_family_parameter(family, p);
        const double value = r->settings->fixed ? r->settings->fixed[p] : NAN;
        r->low[p] = isnan(value) ? of->low : value;
        r->high[p] = isnan(value) ? of->high : value;
    }
    AD_TAKE(r, sample, r->drawn * r->count);
    AD_TAKE(r, tip, r->drawn * 3);
    AD_TAKE(r, at, BATCH * r->count);
    AD_TAKE(r, values, BATCH * r->width);
    AD_TAKE(r, jacobian, BATCH * r->width * r->count);
    AD_TAKE(r, answers, BATCH);
    return ad_memory_status(&r->memory, error, "out of memory for %zu tips", tips);
}

/* Where the tip of a member is among the numbers of its shape. */
static size_t tip_of(const reaching *r)
{
    return (r->family->points - 1) * (size_t)r->family->columns;
}

static ad_status draw(reaching *r, ad_error *error)
{
    const cpinn_polish alone = {.steps = 0, .alone = true};
    nn_rng rng = nn_rng_split(r->settings->seed, "reach");
    ad_status status = AD_OK;
    for (size_t i = 0; i < r->drawn * r->count; i++) {
        const size_t p = i % r->count;
        const scene_parameter of = {NULL, r->low[p], r->high[p],
                                    cpinn_family_parameter(r->family, (int)p)->scale};
        const double part = nn_rng_uniform(&rng);
        r->sample[i] = r->low[p] < r->high[p] ? scene_parameter_at(&of, part) : r->low[p];
    }
    for (size_t i = 0; i < r->drawn && status == AD_OK; i += BATCH) {
        const size_t now = r->drawn - i < BATCH ? r->drawn - i : BATCH;
        status = cpinn_family_shapes(r->family, &alone, now, r->sample + i * r->count, r->values,
                                     NULL, r->answers, error);
        for (size_t k = 0; k < now && status == AD_OK; k++) {
            memcpy(r->tip + 3 * (i + k), r->values + k * r->width + tip_of(r), 3 * sizeof *r->tip);
        }
    }
    return status;
}

/* The random members whose tips are nearest to a place, the nearest first. */
static int choose(const reaching *r, const double place[3], size_t start[STARTS])
{
    double far[STARTS];
    int count = 0;
    for (size_t i = 0; i < r->drawn; i++) {
        const double now = vector_distance(r->tip + 3 * i, place);
        int at = count;
        if (isnan(now)) {
            continue;
        }
        for (; at > 0 && now < far[at - 1]; at--) {
            if (at < STARTS) {
                far[at] = far[at - 1];
                start[at] = start[at - 1];
            }
        }
        if (at < STARTS) {
            far[at] = now;
            start[at] = i;
            count += count < STARTS;
        }
    }
    return count;
}

/* A place that is sought. */
typedef struct seeker {
    optim_seek seek;
    size_t start[STARTS];
    int starts, tried, steps;
    bool over;
} seeker;

static void begin(const reaching *r, const double place[3], seeker *s)
{
    optim_seek_start(&s->seek, (int)r->count, r->low, r->high, 3, place,
                     r->sample + s->start[s->tried++] * r->count);
    s->steps = 0;
}

/* What the answer to seek.next says, and where to go on. */
static void go_on(const reaching *r, size_t member, const double place[3], seeker *s,
                  double *parameters, cpinn_reached *result)
{
    const cpinn_answer *answer = &r->answers[member];
    const double *tip = r->values + member * r->width + tip_of(r);
    const double *by = r->jacobian + (member * r->width + tip_of(r)) * r->count;
    const double far = vector_distance(tip, place), bound = cpinn_family_bound(r->family, answer);
    const bool there =
        answer->trusted && isfinite(far) && isfinite(bound) && vector_is_finite(3 * r->count, by);
    if (there && far + bound < result->distance + result->bound) {
        *result = (cpinn_reached){far, bound, far + bound <= r->tolerance};
        memcpy(parameters, s->seek.next, r->count * sizeof *parameters);
    }
    optim_seek_tell(&s->seek, tip, by, there);
    s->steps++;
    if (result->reached) {
        s->over = true;
    } else if (optim_seek_is_over(&s->seek, 0) || s->steps == STEPS) {
        s->over = s->tried == s->starts;
        if (!s->over) {
            begin(r, place, s);
        }
    }
}

static ad_status seek_some(reaching *r, size_t tips, const double *places, seeker *seekers,
                           double *parameters, cpinn_reached *results, ad_error *error)
{
    ad_status status = AD_OK;
    for (size_t i = 0; i < tips; i++) {
        seekers[i] = (seeker){.tried = 0};
        seekers[i].starts = choose(r, places + 3 * i, seekers[i].start);
        results[i] = (cpinn_reached){INFINITY, INFINITY, false};
        for (size_t p = 0; p < r->count; p++) {
            parameters[i * r->count + p] = NAN;
        }
        seekers[i].over = seekers[i].starts == 0;
        if (!seekers[i].over) {
            begin(r, places + 3 * i, &seekers[i]);
        }
    }
    while (status == AD_OK) {
        /* a member that only another solver may find is no way: that would take seconds */
        const cpinn_polish how = {.steps = 2, .quick = true};
        size_t which[BATCH], now = 0;
        for (size_t i = 0; i < tips; i++) {
            if (!seekers[i].over) {
                memcpy(r->at + now * r->count, seekers[i].seek.next, r->count * sizeof *r->at);
                which[now++] = i;
            }
        }
        if (now == 0) {
            break;
        }
        status = cpinn_family_shapes(r->family, &how, now, r->at, r->values, r->jacobian,
                                     r->answers, error);
        for (size_t k = 0; k < now && status == AD_OK; k++) {
            const size_t i = which[k];
            go_on(r, k, places + 3 * i, &seekers[i], parameters + i * r->count, &results[i]);
        }
    }
    return status;
}

ad_status cpinn_reach(cpinn_family *family, const cpinn_reach_settings *settings, size_t tips,
                      const double *places, double *parameters, cpinn_reached *results,
                      ad_error *error)
{
    AD_LEAVE_HOST;
    const cpinn_reach_settings defaults = {.seed = 0};
    reaching r = {.family = family, .settings = settings ? settings : &defaults};
    ad_status status = refuse(family, r.settings, error);
    status = status == AD_OK ? prepare(&r, tips, error) : status;
    seeker *seekers = status == AD_OK ? malloc(BATCH * sizeof *seekers) : NULL;
    if (status == AD_OK && !seekers) {
        status = ad_fail(error, AD_NO_MEMORY, "out of memory for %zu tips", tips);
    }
    status = status == AD_OK ? draw(&r, error) : status;
    for (size_t i = 0; i < tips && status == AD_OK; i += BATCH) {
        const size_t now = tips - i < BATCH ? tips - i : BATCH;
        status = seek_some(&r, now, places + 3 * i, seekers, parameters + i * r.count, results + i,
                           error);
    }
    free(seekers);
    free_reaching(&r);
    return status;
}
