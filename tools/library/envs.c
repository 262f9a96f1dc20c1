/* Many robots that learn at once: episodes of a task, in steps of tools/library/stepper.h. */
#include "tools/library/stepper.h"

#include "autodiff/host.h"
#include "nn/rng.h"
#include "tools/surrogate/excite.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

/* Reference motions move between levels of the inputs in so many steps. */
enum { SHORTEST = 10, LONGEST = 40 };

/* A start and what the tip is to do. */
typedef struct env_task {
    const double *state, *inputs, *tip; /* at the start: [states], [inputs], [CPINN_TIP_NUMBERS] */
    const double *goal;                 /* [rows][3] m: at each step, or one for all */
} env_task;

struct cpinn_envs {
    cpinn_stepper *robot;
    cpinn_envs_settings settings;
    size_t width;                              /* of an observation */
    int actions, action[SCENE_PARAMETERS_MAX]; /* inputs that are actions */
    int goals;                                 /* rows of a task's goal */
    double *memory;                            /* of tasks */
    env_task *tasks;                           /* [settings.tasks] */
    double *states, *inputs;                   /* [count][states], [count][inputs] */
    double *next, *after;                      /* [threads][STEPPER_MEMBERS] of these */
    nn_rng *random;                            /* [count] */
    int *task, *step;                          /* [count] which task, and at which step of it */
    bool *over;                                /* [count] the episode is over */
};

void cpinn_envs_free(cpinn_envs *x)
{
    if (x) {
        free(x->memory);
        free(x->tasks);
        free(x->states);
        free(x->inputs);
        free(x->next);
        free(x->after);
        free(x->random);
        free(x->task);
        free(x->step);
        free(x->over);
        free(x);
    }
}

/* ---- tasks --------------------------------------------------------------------------------- */

/* Motions of the rod from which tasks are taken. To reach: one step, whose ends are two levels. */
static ad_status draw_motions(const cpinn_envs *x, excite_rollouts *motions, ad_error *error)
{
    const cpinn_stepper *robot = x->robot;
    const bool tracks = x->settings.task == CPINN_TRACK;
    excite_settings excitation = excite_settings_default();
    memcpy(excitation.modes, robot->given->modes, sizeof excitation.modes);
    excitation.step = robot->step;
    excitation.steps = tracks ? x->settings.steps : 1;
    excitation.count = x->settings.tasks;
    excitation.only = tracks ? EXCITE_RAMPS : EXCITE_STEPS;
    excitation.shortest = (tracks ? SHORTEST : 0.5) * robot->step;
    excitation.longest = (tracks ? LONGEST : 1) * robot->step;
    excitation.seed = x->settings.seed;
    excitation.linear = tracks;
    for (int i = 0; i < robot->inputs; i++) {
        excitation.constant |= (uint32_t)cpinn_stepper_is_slow(robot, i) << i;
    }
    return excite_run(robot->scene, &excitation, robot->pool, motions, error);
}

/* States under which the tip is where it is to be, [goals]: of the motion, or at rest. */
static bool find_goals(const cpinn_envs *x, const excite_rollouts *motions, int which,
                       double *states)
{
    const size_t n = (size_t)motions->states, rows = (size_t)motions->steps + 1;
    const double *state = motions->state + (size_t)which * rows * n;
    const double *inputs = motions->input + (size_t)which * rows * (size_t)motions->inputs;
    ad_error unsettled;
    if (motions->done[which] < motions->steps) {
        return false;
    }
    if (x->settings.task == CPINN_TRACK) {
        memcpy(states, state + n, (size_t)x->goals * n * sizeof *states);
        return true;
    }
    memcpy(states, state, n * sizeof *states);
    return reduced_settle(x->robot->workers->rod, 0, inputs + motions->inputs, states,
                          &unsettled) == AD_OK;
}

/* One task from one motion; `room` for states. */
static bool make_task(const cpinn_envs *x, const excite_rollouts *motions, int which, double *room,
                      double *memory, env_task *task)
{
    const size_t n = (size_t)motions->states, m = (size_t)motions->inputs;
    const size_t rows = (size_t)motions->steps + 1;
    double *state = memory, *inputs = state + n, *tip = inputs + m, *goal = tip + CPINN_TIP_NUMBERS;
    if (!find_goals(x, motions, which, room)) {
        return false;
    }
    memcpy(state, motions->state + (size_t)which * rows * n, n * sizeof *state);
    memcpy(inputs, motions->input + (size_t)which * rows * m, m * sizeof *inputs);
    cpinn_stepper_see(x->robot->workers, 1, state);
    memcpy(tip, x->robot->workers->seen, CPINN_TIP_NUMBERS * sizeof *tip);
    for (int k = 0; k < x->goals; k++) {
        cpinn_stepper_see(x->robot->workers, 1, room + (size_t)k * n);
        memcpy(goal + 3 * k, x->robot->workers->seen, 3 * sizeof *goal);
    }
    *task = (env_task){state, inputs, tip, goal};
    return true;
}

static ad_status make_tasks(cpinn_envs *x, ad_error *error)
{
    excite_rollouts motions = {0};
    const size_t width =
        (size_t)(x->robot->states + x->robot->inputs + CPINN_TIP_NUMBERS) + 3 * (size_t)x->goals;
    const int wanted = x->settings.tasks;
    int made = 0;
    x->memory = malloc((size_t)wanted * width * sizeof *x->memory);
    x->tasks = malloc((size_t)wanted * sizeof *x->tasks);
    double *room = malloc((size_t)x->goals * (size_t)x->robot->states * sizeof *room);
    ad_status status = x->memory && x->tasks && room
                           ? draw_motions(x, &motions, error)
                           : ad_fail(error, AD_NO_MEMORY, "out of memory for %d tasks", wanted);
    for (int i = 0; i < wanted && status == AD_OK; i++) {
        made += make_task(x, &motions, i, room, x->memory + (size_t)made * width, &x->tasks[made]);
    }
    if (status == AD_OK && made == 0) {
        status =
            ad_fail(error, AD_NOT_FINITE, "none of %d tasks has a motion that is solved", wanted);
    }
    x->settings.tasks = made;
    excite_free(&motions);
    free(room);
    return status;
}

/* ---- making -------------------------------------------------------------------------------- */

static ad_status allocate(cpinn_envs *x, ad_error *error)
{
    const size_t count = (size_t)x->settings.count, n = (size_t)x->robot->states;
    const size_t m = (size_t)x->robot->inputs;
    const size_t room = STEPPER_MEMBERS * (size_t)ad_pool_threads(x->robot->pool);
    x->states = calloc(count * n, sizeof *x->states);
    x->inputs = calloc(count * m, sizeof *x->inputs);
    x->next = calloc(room * n, sizeof *x->next);
    x->after = calloc(room * m, sizeof *x->after);
    x->random = calloc(count, sizeof *x->random);
    x->task = calloc(count, sizeof *x->task);
    x->step = calloc(count, sizeof *x->step);
    x->over = calloc(count, sizeof *x->over);
    return x->states && x->inputs && x->next && x->after && x->random && x->task && x->step &&
                   x->over
               ? AD_OK
               : ad_fail(error, AD_NO_MEMORY, "out of memory for %zu environments", count);
}

ad_status cpinn_envs_create(cpinn_stepper *robot, const cpinn_envs_settings *settings,
                            cpinn_envs **result, ad_error *error)
{
    AD_LEAVE_HOST;
    *result = NULL;
    if (settings->count < 1 || settings->steps < 1 || settings->tasks < 1) {
        return ad_fail(error, AD_BAD_ARGUMENT,
                       "%d environments of %d steps and %d tasks; allowed: 1 of each and more",
                       settings->count, settings->steps, settings->tasks);
    }
    cpinn_envs *x = calloc(1, sizeof *x);
    if (!x) {
        return ad_fail(error, AD_NO_MEMORY, "out of memory for environments");
    }
    *x = (cpinn_envs){.robot = robot, .settings = *settings};
    x->goals = settings->task == CPINN_TRACK ? settings->steps : 1;
    for (int i = 0; i < robot->inputs; i++) {
        if (!cpinn_stepper_is_slow(robot, i)) {
            x->action[x->actions++] = i;
        }
    }
    x->width = (size_t)robot->states + CPINN_TIP_NUMBERS + 6 + (size_t)x->actions;
    ad_status status = allocate(x, error);
    status = status == AD_OK ? make_tasks(x, error) : status;
    for (int i = 0; i < settings->count && status == AD_OK; i++) {
        x->random[i] = nn_rng_seed(settings->seed + (uint64_t)i);
    }
    if (status != AD_OK) {
        cpinn_envs_free(x);
        return status;
    }
    *result = x;
    return AD_OK;
}

int cpinn_envs_observed(const cpinn_envs *x)
{
    return (int)x->width;
}

int cpinn_envs_actions(const cpinn_envs *x)
{
    return x->actions;
}

int cpinn_envs_action(const cpinn_envs *x, int i)
{
    return i >= 0 && i < x->actions ? x->action[i] : -1;
}

/* ---- one environment ----------------------------------------------------------------------- */

static const double *goal_at(const cpinn_envs *x, size_t i, int step)
{
    const int last = x->goals - 1;
    return x->tasks[x->task[i]].goal + 3 * (step < last ? step : last);
}

static void observe(const cpinn_envs *x, size_t i, const double *tip, double *to)
{
    const size_t n = (size_t)x->robot->states, m = (size_t)x->robot->inputs;
    const double *goal = goal_at(x, i, x->step[i]), *later = goal_at(x, i, x->step[i] + 1);
    memcpy(to, x->states + i * n, n * sizeof *to);
    memcpy(to + n, tip, CPINN_TIP_NUMBERS * sizeof *to);
    to += n + CPINN_TIP_NUMBERS;
    for (int k = 0; k < 3; k++) {
        to[k] = goal[k] - tip[k];
        to[3 + k] = (later[k] - goal[k]) / x->robot->step;
    }
    for (int k = 0; k < x->actions; k++) {
        const scene_parameter *p = &x->robot->scene->parameters[x->action[k]];
        to[6 + k] =
            (2 * x->inputs[i * m + (size_t)x->action[k]] - p->low - p->high) / (p->high - p->low);
    }
}

/* Begins an episode; its tip. */
static const double *begin(cpinn_envs *x, size_t i)
{
    const size_t n = (size_t)x->robot->states, m = (size_t)x->robot->inputs;
    x->task[i] = (int)nn_rng_below(&x->random[i], (uint64_t)x->settings.tasks);
    x->step[i] = 0;
    x->over[i] = false;
    const env_task *task = &x->tasks[x->task[i]];
    memcpy(x->states + i * n, task->state, n * sizeof *x->states);
    memcpy(x->inputs + i * m, task->inputs, m * sizeof *x->inputs);
    return task->tip;
}

void cpinn_envs_reset(cpinn_envs *x, const bool *which, const uint64_t *seeds, double *observations)
{
    for (size_t i = 0; i < (size_t)x->settings.count; i++) {
        if (which && !which[i]) {
            continue;
        }
        if (seeds) {
            x->random[i] = nn_rng_seed(seeds[i]);
        }
        const double *tip = begin(x, i);
        observe(x, i, tip, observations + i * x->width);
    }
}

/* ---- all of them --------------------------------------------------------------------------- */

typedef struct stepping {
    cpinn_envs *x;
    const double *actions;
    cpinn_envs_step_result *to;
} stepping;

/* Inputs at the end of the step, from actions within [-1, 1]. */
static void set_inputs(const cpinn_envs *x, size_t i, const double *actions, double *after)
{
    const size_t m = (size_t)x->robot->inputs;
    memcpy(after, x->inputs + i * m, m * sizeof *after);
    for (int k = 0; k < x->actions; k++) {
        const scene_parameter *p = &x->robot->scene->parameters[x->action[k]];
        const double action = fmin(fmax(actions[k], -1), 1);
        after[x->action[k]] = p->low + 0.5 * (1 + action) * (p->high - p->low);
    }
}

/* What a step has come to. Where there is no state any more the episode ends, at its start. */
static void judge(cpinn_envs *x, size_t i, const double *seen, const double *next,
                  const double *after, cpinn_envs_step_result *to)
{
    const size_t n = (size_t)x->robot->states, m = (size_t)x->robot->inputs;
    const double *goal = goal_at(x, i, x->step[i]);
    const double off[3] = {seen[0] - goal[0], seen[1] - goal[1], seen[2] - goal[2]};
    const double distance = sqrt(off[0] * off[0] + off[1] * off[1] + off[2] * off[2]);
    const bool good = isfinite(distance) && isfinite(next[0]);
    to->distances[i] = good ? distance : NAN;
    to->rewards[i] = good ? -distance / cpinn_stepper_length(x->robot) : -1;
    to->terminated[i] = !good;
    x->step[i]++;
    to->truncated[i] = good && x->step[i] >= x->settings.steps;
    x->over[i] = to->terminated[i] || to->truncated[i];
    memcpy(x->states + i * n, good ? next : x->tasks[x->task[i]].state, n * sizeof *next);
    memcpy(x->inputs + i * m, good ? after : x->tasks[x->task[i]].inputs, m * sizeof *after);
}

static void step_piece(void *context, int item, int thread)
{
    const stepping *of = context;
    cpinn_envs *x = of->x;
    cpinn_envs_step_result *to = of->to;
    const cpinn_stepper *robot = x->robot;
    const stepper_worker *worker = &robot->workers[thread];
    const size_t n = (size_t)robot->states, m = (size_t)robot->inputs;
    const size_t first = STEPPER_MEMBERS * (size_t)item, left = (size_t)x->settings.count - first;
    const size_t members = left < STEPPER_MEMBERS ? left : STEPPER_MEMBERS;
    double *next = x->next + (size_t)thread * STEPPER_MEMBERS * n;
    double *after = x->after + (size_t)thread * STEPPER_MEMBERS * m;
    const bool moves = robot->given->hold == SURROGATE_RAMP;
    for (size_t k = 0; k < members; k++) {
        set_inputs(x, first + k, of->actions + (first + k) * (size_t)x->actions, after + k * m);
    }
    cpinn_stepper_take(robot, worker, (int)members, x->states + first * n,
                       moves ? x->inputs + first * m : after, moves ? after : NULL, next, NULL,
                       NULL);
    cpinn_stepper_see(worker, (int)members, next);
    for (size_t k = 0; k < members; k++) {
        const size_t i = first + k;
        const double *tip = worker->seen + k * KINEMATICS_SEEN;
        double *seen = to->observations + i * x->width;
        if (x->over[i] && x->settings.autoreset == CPINN_RESET_NEXT) {
            observe(x, i, begin(x, i), seen);
            to->rewards[i] = 0;
            to->distances[i] = NAN;
            to->terminated[i] = to->truncated[i] = false;
            continue;
        }
        judge(x, i, tip, next + k * n, after + k * m, to);
        observe(x, i, to->terminated[i] ? x->tasks[x->task[i]].tip : tip, seen);
        if (x->over[i] && x->settings.autoreset == CPINN_RESET_SAME) {
            memcpy(to->last + i * x->width, seen, x->width * sizeof *seen);
            observe(x, i, begin(x, i), seen);
        }
    }
}

void cpinn_envs_step(cpinn_envs *x, const double *actions, cpinn_envs_step_result *result)
{
    AD_LEAVE_HOST;
    stepping of = {x, actions, result};
    ad_pool_run(x->robot->pool, (x->settings.count + STEPPER_MEMBERS - 1) / STEPPER_MEMBERS,
                step_piece, &of);
}
