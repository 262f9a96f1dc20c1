/* Robots in steps: trained one-step models and reduced rods, many states at once. */
#include "tools/library/stepper.h"
#include "physics/support.h"

#include "autodiff/host.h"
#include "autodiff/ranks.h"
#include "tools/control/reduced_model.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

/* ---- making -------------------------------------------------------------------------------- */

static ad_status create_worker(const cpinn_stepper *x, stepper_worker *to, ad_error *error)
{
    const double tip = scene_length(x->scene);
    reduced_settings settings = {.count = 1, .s = &tip};
    memcpy(settings.modes, x->given->modes, sizeof settings.modes);
    ad_status status = reduced_create(x->scene, &settings, &to->rod, error);
    if (status == AD_OK && !reduced_is_placed(to->rod)) {
        status = ad_fail(error, AD_BAD_INPUT,
                         "the start depends on time or on inputs; allowed: one that stays");
    }
    if (status == AD_OK && x->trained) {
        status = surrogate_one_step(x->trained, &to->model, error);
    } else if (status == AD_OK) {
        to->model = reduced_one_step(to->rod, x->step);
    }
    if (status == AD_OK) {
        to->tip = *reduced_kinematics(to->rod);
        to->seen = malloc((size_t)(STEPPER_MEMBERS * KINEMATICS_SEEN) * sizeof *to->seen);
        to->room = malloc(kinematics_room(&to->tip) * sizeof *to->room);
        status = to->seen && to->room
                     ? AD_OK
                     : ad_fail(error, AD_NO_MEMORY, "out of memory for a robot in steps");
    }
    return status;
}

static ad_status finish(cpinn_stepper *x, int threads, ad_error *error)
{
    ad_status status = ad_pool_open(threads, &x->pool, error);
    if (status != AD_OK) {
        return status;
    }
    const int count = ad_pool_threads(x->pool);
    x->workers = calloc((size_t)count, sizeof *x->workers);
    if (!x->workers) {
        return ad_fail(error, AD_NO_MEMORY, "out of memory for a robot in steps");
    }
    for (int i = 0; i < count && status == AD_OK; i++) {
        status = create_worker(x, &x->workers[i], error);
    }
    if (status == AD_OK) {
        x->states = x->workers->model.states;
        x->inputs = reduced_inputs(x->workers->rod);
        x->step = x->workers->model.step;
    }
    return status;
}

/* Takes over x, also when it fails. */
static ad_status hand_over(cpinn_stepper *x, ad_status status, cpinn_stepper **result)
{
    if (status != AD_OK) {
        cpinn_stepper_free(x);
        return status;
    }
    *result = x;
    return AD_OK;
}

ad_status cpinn_stepper_open(const char *path, int threads, cpinn_stepper **result, ad_error *error)
{
    AD_LEAVE_HOST;
    cpinn_stepper *x = calloc(1, sizeof *x);
    *result = NULL;
    if (!x) {
        return ad_fail(error, AD_NO_MEMORY, "out of memory for a robot in steps");
    }
    ad_status status = surrogate_load(path, &x->trained, error);
    if (status == AD_OK) {
        x->scene = x->trained->scene;
        x->given = &x->trained->settings;
        status = finish(x, threads, error);
    }
    return hand_over(x, status, result);
}

static ad_status take_scene(cpinn_stepper *x, const char *path, double step, ad_error *error)
{
    x->scene = &x->settings->scene;
    x->given = &x->settings->surrogate;
    x->step = step > 0 ? step : x->given->step;
    const char *key = "";
    ad_error reason;
    if (support_check(x->scene, SUPPORT_ONE_STEP, &key, &reason) != AD_OK) {
        return config_refuse(x->settings, key, reason.message, error);
    }
    if (x->scene->parameter_count == 0) {
        return ad_fail(error, AD_BAD_INPUT,
                       "%s: has no inputs; allowed: a scene with parameters that have ranges",
                       path);
    }
    return x->step > 0 ? AD_OK
                       : ad_fail(error, AD_BAD_ARGUMENT,
                                 "%s: has no surrogate.step; allowed: a scene with one, or a step "
                                 "in s that is given here",
                                 path);
}

ad_status cpinn_stepper_file(const char *path, int count, const char *const *overrides, double step,
                             int threads, cpinn_stepper **result, ad_error *error)
{
    AD_LEAVE_HOST;
    cpinn_stepper *x = calloc(1, sizeof *x);
    *result = NULL;
    if (!x) {
        return ad_fail(error, AD_NO_MEMORY, "out of memory for a robot in steps");
    }
    ad_status status = prepare_read(path, NULL, count, overrides, &x->settings, error);
    status = status == AD_OK ? take_scene(x, path, step, error) : status;
    status = status == AD_OK ? finish(x, threads, error) : status;
    return hand_over(x, status, result);
}

void cpinn_stepper_free(cpinn_stepper *x)
{
    if (!x) {
        return;
    }
    for (int i = 0; x->workers && i < ad_pool_threads(x->pool); i++) {
        stepper_worker *worker = &x->workers[i];
        if (x->trained) {
            surrogate_one_step_free(&worker->model);
        }
        reduced_free(worker->rod);
        free(worker->seen);
        free(worker->room);
    }
    free(x->workers);
    ad_pool_free(x->pool);
    surrogate_free(x->trained);
    config_free(x->settings);
    free(x);
}

/* ---- asking -------------------------------------------------------------------------------- */

int cpinn_stepper_states(const cpinn_stepper *x)
{
    return x->states;
}

int cpinn_stepper_inputs(const cpinn_stepper *x)
{
    return x->inputs;
}

const scene_parameter *cpinn_stepper_input(const cpinn_stepper *x, int i)
{
    return i >= 0 && i < x->inputs ? &x->scene->parameters[i] : NULL;
}

bool cpinn_stepper_is_slow(const cpinn_stepper *x, int i)
{
    return surrogate_names_parameter(x->given, cpinn_stepper_input(x, i)->name);
}

double cpinn_stepper_step(const cpinn_stepper *x)
{
    return x->step;
}

double cpinn_stepper_length(const cpinn_stepper *x)
{
    return scene_length(x->scene);
}

/* ---- stepping ------------------------------------------------------------------------------ */

static bool all_finite(int count, const double *numbers)
{
    double sum = 0; /* not a number if any is none */
    for (int i = 0; i < count; i++) {
        sum += 0 * numbers[i];
    }
    return sum == 0;
}

void cpinn_stepper_take(const cpinn_stepper *x, const stepper_worker *worker, int members,
                        const double *states, const double *inputs, const double *after,
                        double *next, double *by_state, double *by_inputs)
{
    const one_step *model = &worker->model;
    const size_t n = (size_t)x->states, m = (size_t)x->inputs;
    if (model->advance(model->context, members, x->step, states, inputs, after, next, by_state,
                       by_inputs) == 0) {
        return;
    }
    for (size_t i = 0; i < (size_t)members; i++) { /* which of them have none */
        double *to = next + i * n;
        if (!all_finite(x->states, states + i * n) ||
            model->advance(model->context, 1, x->step, states + i * n, inputs + i * m,
                           after ? after + i * m : NULL, to, by_state ? by_state + i * n * n : NULL,
                           by_inputs ? by_inputs + i * n * m : NULL)) {
            for (size_t k = 0; k < n; k++) {
                to[k] = NAN;
            }
        }
    }
}

void cpinn_stepper_see(const stepper_worker *worker, int members, const double *states)
{
    kinematics_see(&worker->tip, members, states, worker->seen, NULL, worker->room);
}

typedef struct batch {
    cpinn_stepper *x;
    size_t members;
    const double *states, *inputs, *after;
    double *next, *by_state, *by_inputs, *tip;
} batch;

/* The first member of a piece of work, and how many it has. */
static size_t piece(const batch *of, int item, int *members)
{
    const size_t first = STEPPER_MEMBERS * (size_t)item, left = of->members - first;
    *members = left < STEPPER_MEMBERS ? (int)left : STEPPER_MEMBERS;
    return first;
}

static void run(batch *of, ad_pool_work work)
{
    ad_pool_run(of->x->pool, (int)((of->members + STEPPER_MEMBERS - 1) / STEPPER_MEMBERS), work,
                of);
}

static double *behind(double *of, size_t count)
{
    return of ? of + count : NULL;
}

static void advance_piece(void *context, int item, int thread)
{
    const batch *of = context;
    const size_t n = (size_t)of->x->states, m = (size_t)of->x->inputs;
    int members;
    const size_t first = piece(of, item, &members);
    cpinn_stepper_take(of->x, &of->x->workers[thread], members, of->states + first * n,
                       of->inputs + first * m, of->after ? of->after + first * m : NULL,
                       of->next + first * n, behind(of->by_state, first * n * n),
                       behind(of->by_inputs, first * n * m));
}

ad_status cpinn_stepper_advance(cpinn_stepper *x, size_t members, const double *states,
                                const double *inputs, const double *after, double *next,
                                double *by_state, double *by_inputs, ad_error *error)
{
    AD_LEAVE_HOST;
    if (after && x->trained && x->given->hold != SURROGATE_RAMP) {
        return ad_fail(error, AD_BAD_ARGUMENT,
                       "the model was trained for inputs that stay while a step lasts; allowed: "
                       "one with surrogate.hold: linear");
    }
    batch of = {.x = x,
                .members = members,
                .states = states,
                .inputs = inputs,
                .after = after,
                .next = next,
                .by_state = by_state,
                .by_inputs = by_inputs};
    run(&of, advance_piece);
    return AD_OK;
}

static void see_piece(void *context, int item, int thread)
{
    const batch *of = context;
    const stepper_worker *worker = &of->x->workers[thread];
    int members;
    const size_t first = piece(of, item, &members);
    cpinn_stepper_see(worker, members, of->states + first * (size_t)of->x->states);
    for (size_t i = 0; i < (size_t)members; i++) {
        memcpy(of->tip + (first + i) * CPINN_TIP_NUMBERS, worker->seen + i * KINEMATICS_SEEN,
               CPINN_TIP_NUMBERS * sizeof *of->tip);
    }
}

void cpinn_stepper_tip(cpinn_stepper *x, size_t members, const double *states, double *tip)
{
    AD_LEAVE_HOST;
    batch of = {.x = x, .members = members, .states = states, .tip = tip};
    run(&of, see_piece);
}

static void rest_piece(void *context, int item, int thread)
{
    const batch *of = context;
    reduced_rod *rod = of->x->workers[thread].rod;
    const size_t n = (size_t)of->x->states, m = (size_t)of->x->inputs;
    int members;
    ad_error unsettled;
    const size_t first = piece(of, item, &members);
    for (size_t i = first; i < first + (size_t)members; i++) {
        double *state = of->next + i * n;
        if (reduced_initial(rod, of->inputs + i * m, state, &unsettled) != AD_OK ||
            reduced_settle(rod, 0, of->inputs + i * m, state, &unsettled) != AD_OK) {
            for (size_t k = 0; k < n; k++) {
                state[k] = NAN;
            }
        }
    }
}

void cpinn_stepper_rest(cpinn_stepper *x, size_t members, const double *inputs, double *states)
{
    AD_LEAVE_HOST;
    batch of = {.x = x, .members = members, .inputs = inputs, .next = states};
    run(&of, rest_piece);
}
