/* Robots in steps: trained one-step models and reduced rods, many states at once. */
#include "tools/library/cpinn.h"

#include "autodiff/host.h"
#include "autodiff/ranks.h"
#include "physics/numerics/vector_size.h"
#include "physics/scene/support.h"
#include "tools/control/reduced_model.h"
#include "tools/prepare/config_surrogate.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

/* States that a thread takes at a time: eight vectors of eight. */
enum { STEPPER_MEMBERS = 64 };

/* Of one thread. */
typedef struct stepper_worker {
    one_step model;
    reduced_rod *rod; /* looked at in its tip */
    kinematics tip;
    double *seen, *room; /* [STEPPER_MEMBERS][KINEMATICS_SEEN], [kinematics_room] */
} stepper_worker;

struct cpinn_stepper {
    surrogate *trained; /* NULL: the reduced rod itself, */
    config *settings;   /* of these */
    const scene *scene;
    const surrogate_settings *given; /* modes, which inputs are slow, how they move in a step */
    double step;
    int states, inputs;
    ad_pool *pool;
    stepper_worker *workers; /* [threads] */
};

/* ---- making -------------------------------------------------------------------------------- */

static ad_status create_worker(const cpinn_stepper *stepper, stepper_worker *to, ad_error *error)
{
    const double tip = scene_length(stepper->scene);
    reduced_settings settings = {.count = 1, .s = &tip};
    memcpy(settings.modes, stepper->given->modes, sizeof settings.modes);
    ad_status status = reduced_create(stepper->scene, &settings, &to->rod, error);
    if (status == AD_OK && !reduced_is_placed(to->rod)) {
        status = ad_fail(error, AD_BAD_INPUT,
                         "the start depends on time or on inputs; allowed: one that stays");
    }
    if (status == AD_OK && stepper->trained) {
        status = surrogate_one_step(stepper->trained, &to->model, error);
    } else if (status == AD_OK) {
        to->model = reduced_one_step(to->rod, stepper->step);
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

static ad_status finish(cpinn_stepper *stepper, int threads, ad_error *error)
{
    ad_status status = ad_pool_open(threads, &stepper->pool, error);
    if (status != AD_OK) {
        return status;
    }
    const int count = ad_pool_threads(stepper->pool);
    stepper->workers = calloc((size_t)count, sizeof *stepper->workers);
    if (!stepper->workers) {
        return ad_fail(error, AD_NO_MEMORY, "out of memory for a robot in steps");
    }
    for (int i = 0; i < count && status == AD_OK; i++) {
        status = create_worker(stepper, &stepper->workers[i], error);
    }
    if (status == AD_OK) {
        stepper->states = stepper->workers->model.states;
        stepper->inputs = reduced_inputs(stepper->workers->rod);
        stepper->step = stepper->workers->model.step;
    }
    return status;
}

/* Takes over x, also when it fails. */
static ad_status hand_over(cpinn_stepper *stepper, ad_status status, cpinn_stepper **result)
{
    if (status != AD_OK) {
        cpinn_stepper_free(stepper);
        return status;
    }
    *result = stepper;
    return AD_OK;
}

ad_status cpinn_stepper_open(const char *path, int threads, cpinn_stepper **result, ad_error *error)
{
    AD_LEAVE_HOST;
    cpinn_stepper *stepper = calloc(1, sizeof *stepper);
    *result = NULL;
    if (!stepper) {
        return ad_fail(error, AD_NO_MEMORY, "out of memory for a robot in steps");
    }
    ad_status status = surrogate_load(path, &stepper->trained, error);
    if (status == AD_OK) {
        stepper->scene = stepper->trained->scene;
        stepper->given = &stepper->trained->settings;
        status = finish(stepper, threads, error);
    }
    return hand_over(stepper, status, result);
}

static ad_status take_scene(cpinn_stepper *stepper, const char *path, double step, ad_error *error)
{
    stepper->scene = &stepper->settings->scene;
    stepper->given = &stepper->settings->surrogate;
    stepper->step = step > 0 ? step : stepper->given->step;
    const char *key = "";
    ad_error reason;
    if (support_check(stepper->scene, SUPPORT_ONE_STEP, &key, &reason) != AD_OK) {
        return config_refuse(stepper->settings, key, reason.message, error);
    }
    if (stepper->scene->memory_count > 0) {
        return ad_fail(error, AD_BAD_INPUT,
                       "%s: has plays or lags of inputs, whose states robots in steps do not keep; "
                       "allowed: a scene without them",
                       path);
    }
    if (stepper->scene->parameter_count == 0) {
        return ad_fail(error, AD_BAD_INPUT,
                       "%s: has no inputs; allowed: a scene with parameters that have ranges",
                       path);
    }
    return stepper->step > 0
               ? AD_OK
               : ad_fail(error, AD_BAD_ARGUMENT,
                         "%s: has no surrogate.step; allowed: a scene with one, or a step "
                         "in s that is given here",
                         path);
}

ad_status cpinn_stepper_file(const char *path, int count, const char *const *overrides, double step,
                             int threads, cpinn_stepper **result, ad_error *error)
{
    AD_LEAVE_HOST;
    cpinn_stepper *stepper = calloc(1, sizeof *stepper);
    *result = NULL;
    if (!stepper) {
        return ad_fail(error, AD_NO_MEMORY, "out of memory for a robot in steps");
    }
    ad_status status = prepare_read(path, NULL, count, overrides, &stepper->settings, error);
    status = status == AD_OK ? take_scene(stepper, path, step, error) : status;
    status = status == AD_OK ? finish(stepper, threads, error) : status;
    return hand_over(stepper, status, result);
}

void cpinn_stepper_free(cpinn_stepper *stepper)
{
    if (!stepper) {
        return;
    }
    for (int i = 0; stepper->workers && i < ad_pool_threads(stepper->pool); i++) {
        stepper_worker *worker = &stepper->workers[i];
        if (stepper->trained) {
            surrogate_one_step_free(&worker->model);
        }
        reduced_free(worker->rod);
        free(worker->seen);
        free(worker->room);
    }
    free(stepper->workers);
    ad_pool_free(stepper->pool);
    surrogate_free(stepper->trained);
    config_free(stepper->settings);
    free(stepper);
}

/* ---- asking -------------------------------------------------------------------------------- */

int cpinn_stepper_states(const cpinn_stepper *stepper)
{
    return stepper->states;
}

int cpinn_stepper_inputs(const cpinn_stepper *stepper)
{
    return stepper->inputs;
}

const scene_parameter *cpinn_stepper_input(const cpinn_stepper *stepper, int i)
{
    return i >= 0 && i < stepper->inputs ? &stepper->scene->parameters[i] : NULL;
}

bool cpinn_stepper_is_slow(const cpinn_stepper *stepper, int i)
{
    return surrogate_names_parameter(stepper->given, cpinn_stepper_input(stepper, i)->name);
}

bool cpinn_stepper_ramps(const cpinn_stepper *stepper)
{
    return stepper->given->hold == SURROGATE_RAMP;
}

double cpinn_stepper_step(const cpinn_stepper *stepper)
{
    return stepper->step;
}

double cpinn_stepper_length(const cpinn_stepper *stepper)
{
    return scene_length(stepper->scene);
}

/* ---- stepping ------------------------------------------------------------------------------ */

static void take(const cpinn_stepper *stepper, const stepper_worker *worker, int members,
                 const double *states, const double *inputs, const double *after, double *next,
                 double *by_state, double *by_inputs)
{
    const one_step *model = &worker->model;
    const size_t n = (size_t)stepper->states, m = (size_t)stepper->inputs;
    if (model->advance(model->context, members, stepper->step, states, inputs, after, next,
                       by_state, by_inputs) == 0) {
        return;
    }
    for (size_t i = 0; i < (size_t)members; i++) { /* which of them have none */
        double *to = next + i * n;
        if (!vector_is_finite(n, states + i * n) ||
            model->advance(model->context, 1, stepper->step, states + i * n, inputs + i * m,
                           after ? after + i * m : NULL, to, by_state ? by_state + i * n * n : NULL,
                           by_inputs ? by_inputs + i * n * m : NULL)) {
            for (size_t k = 0; k < n; k++) {
                to[k] = NAN;
            }
        }
    }
}

static void see(const stepper_worker *worker, int members, const double *states)
{
    const int n = reduced_states(worker->rod), all = 2 * worker->tip.modes;
    for (int i = 0; n > all && i < members; i++) { /* behind what is seen of a state is more */
        kinematics_see(&worker->tip, 1, states + i * n, worker->seen + i * KINEMATICS_SEEN, NULL,
                       worker->room);
    }
    if (n == all) {
        kinematics_see(&worker->tip, members, states, worker->seen, NULL, worker->room);
    }
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
    take(of->x, &of->x->workers[thread], members, of->states + first * n, of->inputs + first * m,
         of->after ? of->after + first * m : NULL, of->next + first * n,
         behind(of->by_state, first * n * n), behind(of->by_inputs, first * n * m));
}

/* AD_BAD_ARGUMENT: the first of inputs [members][inputs] that is outside its range, which neither
 * training nor the scene's checks have seen. */
static ad_status check_inputs(const cpinn_stepper *stepper, size_t members, const double *inputs,
                              ad_error *error)
{
    const size_t m = (size_t)stepper->inputs;
    for (size_t i = 0; inputs && i < members * m; i++) {
        const scene_parameter *p = &stepper->scene->parameters[i % m];
        if (!scene_parameter_holds(p, inputs[i])) {
            return ad_fail(error, AD_BAD_ARGUMENT,
                           "inputs of member %zu: %.60s is %g; allowed: %g to %g", i / m, p->name,
                           inputs[i], p->low, p->high);
        }
    }
    return AD_OK;
}

ad_status cpinn_stepper_advance(cpinn_stepper *stepper, size_t members, const double *states,
                                const double *inputs, const double *after, double *next,
                                double *by_state, double *by_inputs, ad_error *error)
{
    AD_LEAVE_HOST;
    if (after && stepper->trained && stepper->given->hold != SURROGATE_RAMP) {
        return ad_fail(error, AD_BAD_ARGUMENT,
                       "the model was trained for inputs that stay while a step lasts; allowed: "
                       "one with surrogate.hold: linear");
    }
    if (!after && stepper->trained && stepper->given->hold == SURROGATE_RAMP) {
        return ad_fail(error, AD_BAD_ARGUMENT,
                       "the model was trained for inputs that go linearly on from step to step; "
                       "allowed: with those after the step");
    }
    batch of = {.x = stepper,
                .members = members,
                .states = states,
                .inputs = inputs,
                .after = after,
                .next = next,
                .by_state = by_state,
                .by_inputs = by_inputs};
    ad_status status = check_inputs(stepper, members, inputs, error);
    status = status == AD_OK ? check_inputs(stepper, members, after, error) : status;
    if (status == AD_OK) {
        run(&of, advance_piece);
    }
    return status;
}

static void see_piece(void *context, int item, int thread)
{
    const batch *of = context;
    const stepper_worker *worker = &of->x->workers[thread];
    int members;
    const size_t first = piece(of, item, &members);
    see(worker, members, of->states + first * (size_t)of->x->states);
    for (size_t i = 0; i < (size_t)members; i++) {
        memcpy(of->tip + (first + i) * CPINN_TIP_NUMBERS, worker->seen + i * KINEMATICS_SEEN,
               CPINN_TIP_NUMBERS * sizeof *of->tip);
    }
}

void cpinn_stepper_tip(cpinn_stepper *stepper, size_t members, const double *states, double *tip)
{
    AD_LEAVE_HOST;
    batch of = {.x = stepper, .members = members, .states = states, .tip = tip};
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
        if (check_inputs(of->x, 1, of->inputs + i * m, &unsettled) != AD_OK ||
            reduced_initial(rod, of->inputs + i * m, state, &unsettled) != AD_OK ||
            reduced_settle(rod, 0, of->inputs + i * m, state, &unsettled) != AD_OK) {
            for (size_t k = 0; k < n; k++) {
                state[k] = NAN;
            }
        }
    }
}

void cpinn_stepper_rest(cpinn_stepper *stepper, size_t members, const double *inputs,
                        double *states)
{
    AD_LEAVE_HOST;
    batch of = {.x = stepper, .members = members, .inputs = inputs, .next = states};
    run(&of, rest_piece);
}
