/* Many robots that learn at once: episodes of a task, in steps of tools/library/stepper.h. */
#include "tools/library/stepper.h"

#include "autodiff/host.h"
#include "nn/rng.h"
#include "tools/surrogate/excitation.h"

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

void cpinn_envs_free(cpinn_envs *envs)
{
    if (envs) {
        free(envs->memory);
        free(envs->tasks);
        free(envs->states);
        free(envs->inputs);
        free(envs->next);
        free(envs->after);
        free(envs->random);
        free(envs->task);
        free(envs->step);
        free(envs->over);
        free(envs);
    }
}

/* ---- tasks --------------------------------------------------------------------------------- */

/* Motions of the rod from which tasks are taken. To reach: one step, whose ends are two levels. */
static ad_status draw_motions(const cpinn_envs *envs, excitation_rollouts *motions, ad_error *error)
{
    const cpinn_stepper *robot = envs->robot;
    const bool tracks = envs->settings.task == CPINN_TRACK;
    excitation_settings excitation = excitation_settings_default();
    memcpy(excitation.modes, robot->given->modes, sizeof excitation.modes);
    excitation.step = robot->step;
    excitation.steps = tracks ? envs->settings.steps : 1;
    excitation.count = envs->settings.tasks;
    excitation.only = tracks ? EXCITATION_RAMPS : EXCITATION_STEPS;
    excitation.shortest = (tracks ? SHORTEST : 0.5) * robot->step;
    excitation.longest = (tracks ? LONGEST : 1) * robot->step;
    excitation.seed = envs->settings.seed;
    excitation.linear = tracks;
    for (int i = 0; i < robot->inputs; i++) {
        excitation.constant |= (uint32_t)cpinn_stepper_is_slow(robot, i) << i;
    }
    return excitation_run(robot->scene, &excitation, robot->pool, motions, error);
}

/* States under which the tip is where it is to be, [goals]: of the motion, or at rest. */
static bool find_goals(const cpinn_envs *envs, const excitation_rollouts *motions, int which,
                       double *states)
{
    const size_t n = (size_t)motions->states, rows = (size_t)motions->steps + 1;
    const double *state = motions->state + (size_t)which * rows * n;
    const double *inputs = motions->input + (size_t)which * rows * (size_t)motions->inputs;
    ad_error unsettled;
    if (motions->done[which] < motions->steps) {
        return false;
    }
    if (envs->settings.task == CPINN_TRACK) {
        memcpy(states, state + n, (size_t)envs->goals * n * sizeof *states);
        return true;
    }
    memcpy(states, state, n * sizeof *states);
    return reduced_settle(envs->robot->workers->rod, 0, inputs + motions->inputs, states,
                          &unsettled) == AD_OK;
}

/* One task from one motion; `room` for states. */
static bool make_task(const cpinn_envs *envs, const excitation_rollouts *motions, int which,
                      double *room, double *memory, env_task *task)
{
    const size_t n = (size_t)motions->states, m = (size_t)motions->inputs;
    const size_t rows = (size_t)motions->steps + 1;
    double *state = memory, *inputs = state + n, *tip = inputs + m, *goal = tip + CPINN_TIP_NUMBERS;
    if (!find_goals(envs, motions, which, room)) {
        return false;
    }
    memcpy(state, motions->state + (size_t)which * rows * n, n * sizeof *state);
    memcpy(inputs, motions->input + (size_t)which * rows * m, m * sizeof *inputs);
    cpinn_stepper_see(envs->robot->workers, 1, state);
    memcpy(tip, envs->robot->workers->seen, CPINN_TIP_NUMBERS * sizeof *tip);
    for (int k = 0; k < envs->goals; k++) {
        cpinn_stepper_see(envs->robot->workers, 1, room + (size_t)k * n);
        memcpy(goal + 3 * k, envs->robot->workers->seen, 3 * sizeof *goal);
    }
    *task = (env_task){state, inputs, tip, goal};
    return true;
}

static ad_status make_tasks(cpinn_envs *envs, ad_error *error)
{
    excitation_rollouts motions = {0};
    const size_t width = (size_t)(envs->robot->states + envs->robot->inputs + CPINN_TIP_NUMBERS) +
                         3 * (size_t)envs->goals;
    const int wanted = envs->settings.tasks;
    int made = 0;
    envs->memory = malloc((size_t)wanted * width * sizeof *envs->memory);
    envs->tasks = malloc((size_t)wanted * sizeof *envs->tasks);
    double *room = malloc((size_t)envs->goals * (size_t)envs->robot->states * sizeof *room);
    ad_status status = envs->memory && envs->tasks && room
                           ? draw_motions(envs, &motions, error)
                           : ad_fail(error, AD_NO_MEMORY, "out of memory for %d tasks", wanted);
    for (int i = 0; i < wanted && status == AD_OK; i++) {
        made += make_task(envs, &motions, i, room, envs->memory + (size_t)made * width,
                          &envs->tasks[made]);
    }
    if (status == AD_OK && made == 0) {
        status =
            ad_fail(error, AD_NOT_FINITE, "none of %d tasks has a motion that is solved", wanted);
    }
    envs->settings.tasks = made;
    excitation_free(&motions);
    free(room);
    return status;
}

/* ---- making -------------------------------------------------------------------------------- */

static ad_status allocate(cpinn_envs *envs, ad_error *error)
{
    const size_t count = (size_t)envs->settings.count, n = (size_t)envs->robot->states;
    const size_t m = (size_t)envs->robot->inputs;
    const size_t room = STEPPER_MEMBERS * (size_t)ad_pool_threads(envs->robot->pool);
    envs->states = calloc(count * n, sizeof *envs->states);
    envs->inputs = calloc(count * m, sizeof *envs->inputs);
    envs->next = calloc(room * n, sizeof *envs->next);
    envs->after = calloc(room * m, sizeof *envs->after);
    envs->random = calloc(count, sizeof *envs->random);
    envs->task = calloc(count, sizeof *envs->task);
    envs->step = calloc(count, sizeof *envs->step);
    envs->over = calloc(count, sizeof *envs->over);
    return envs->states && envs->inputs && envs->next && envs->after && envs->random &&
                   envs->task && envs->step && envs->over
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
    cpinn_envs *envs = calloc(1, sizeof *envs);
    if (!envs) {
        return ad_fail(error, AD_NO_MEMORY, "out of memory for environments");
    }
    *envs = (cpinn_envs){.robot = robot, .settings = *settings};
    envs->goals = settings->task == CPINN_TRACK ? settings->steps : 1;
    for (int i = 0; i < robot->inputs; i++) {
        if (!cpinn_stepper_is_slow(robot, i)) {
            envs->action[envs->actions++] = i;
        }
    }
    envs->width = (size_t)robot->states + CPINN_TIP_NUMBERS + 6 + (size_t)envs->actions;
    ad_status status = allocate(envs, error);
    status = status == AD_OK ? make_tasks(envs, error) : status;
    for (int i = 0; i < settings->count && status == AD_OK; i++) {
        envs->random[i] = nn_rng_seed(settings->seed + (uint64_t)i);
    }
    if (status != AD_OK) {
        cpinn_envs_free(envs);
        return status;
    }
    *result = envs;
    return AD_OK;
}

int cpinn_envs_observed(const cpinn_envs *envs)
{
    return (int)envs->width;
}

int cpinn_envs_actions(const cpinn_envs *envs)
{
    return envs->actions;
}

int cpinn_envs_action(const cpinn_envs *envs, int i)
{
    return i >= 0 && i < envs->actions ? envs->action[i] : -1;
}

/* ---- one environment ----------------------------------------------------------------------- */

static const double *goal_at(const cpinn_envs *envs, size_t i, int step)
{
    const int last = envs->goals - 1;
    return envs->tasks[envs->task[i]].goal + 3 * (step < last ? step : last);
}

static void observe(const cpinn_envs *envs, size_t i, const double *tip, double *to)
{
    const size_t n = (size_t)envs->robot->states, m = (size_t)envs->robot->inputs;
    const double *goal = goal_at(envs, i, envs->step[i]),
                 *later = goal_at(envs, i, envs->step[i] + 1);
    memcpy(to, envs->states + i * n, n * sizeof *to);
    memcpy(to + n, tip, CPINN_TIP_NUMBERS * sizeof *to);
    to += n + CPINN_TIP_NUMBERS;
    for (int k = 0; k < 3; k++) {
        to[k] = goal[k] - tip[k];
        to[3 + k] = (later[k] - goal[k]) / envs->robot->step;
    }
    for (int k = 0; k < envs->actions; k++) {
        const scene_parameter *p = &envs->robot->scene->parameters[envs->action[k]];
        to[6 + k] = (2 * envs->inputs[i * m + (size_t)envs->action[k]] - p->low - p->high) /
                    (p->high - p->low);
    }
}

/* Begins an episode; its tip. */
static const double *begin(cpinn_envs *envs, size_t i)
{
    const size_t n = (size_t)envs->robot->states, m = (size_t)envs->robot->inputs;
    envs->task[i] = (int)nn_rng_below(&envs->random[i], (uint64_t)envs->settings.tasks);
    envs->step[i] = 0;
    envs->over[i] = false;
    const env_task *task = &envs->tasks[envs->task[i]];
    memcpy(envs->states + i * n, task->state, n * sizeof *envs->states);
    memcpy(envs->inputs + i * m, task->inputs, m * sizeof *envs->inputs);
    return task->tip;
}

void cpinn_envs_reset(cpinn_envs *envs, const bool *which, const uint64_t *seeds,
                      double *observations)
{
    for (size_t i = 0; i < (size_t)envs->settings.count; i++) {
        if (which && !which[i]) {
            continue;
        }
        if (seeds) {
            envs->random[i] = nn_rng_seed(seeds[i]);
        }
        const double *tip = begin(envs, i);
        observe(envs, i, tip, observations + i * envs->width);
    }
}

/* ---- all of them --------------------------------------------------------------------------- */

typedef struct stepping {
    cpinn_envs *x;
    const double *actions;
    cpinn_envs_step_result *to;
} stepping;

/* Inputs at the end of the step, from actions within [-1, 1]. */
static void set_inputs(const cpinn_envs *envs, size_t i, const double *actions, double *after)
{
    const size_t m = (size_t)envs->robot->inputs;
    memcpy(after, envs->inputs + i * m, m * sizeof *after);
    for (int k = 0; k < envs->actions; k++) {
        const scene_parameter *p = &envs->robot->scene->parameters[envs->action[k]];
        const double action = fmin(fmax(actions[k], -1), 1);
        after[envs->action[k]] = p->low + 0.5 * (1 + action) * (p->high - p->low);
    }
}

/* What a step has come to. Where there is no state any more the episode ends, at its start. */
static void judge(cpinn_envs *envs, size_t i, const double *seen, const double *next,
                  const double *after, cpinn_envs_step_result *to)
{
    const size_t n = (size_t)envs->robot->states, m = (size_t)envs->robot->inputs;
    const double *goal = goal_at(envs, i, envs->step[i]);
    const double off[3] = {seen[0] - goal[0], seen[1] - goal[1], seen[2] - goal[2]};
    const double distance = sqrt(off[0] * off[0] + off[1] * off[1] + off[2] * off[2]);
    const bool good = isfinite(distance) && isfinite(next[0]);
    to->distances[i] = good ? distance : NAN;
    to->rewards[i] = good ? -distance / cpinn_stepper_length(envs->robot) : -1;
    to->terminated[i] = !good;
    envs->step[i]++;
    to->truncated[i] = good && envs->step[i] >= envs->settings.steps;
    envs->over[i] = to->terminated[i] || to->truncated[i];
    memcpy(envs->states + i * n, good ? next : envs->tasks[envs->task[i]].state, n * sizeof *next);
    memcpy(envs->inputs + i * m, good ? after : envs->tasks[envs->task[i]].inputs,
           m * sizeof *after);
}

static void step_piece(void *context, int item, int thread)
{
    const stepping *of = context;
    cpinn_envs *envs = of->x;
    cpinn_envs_step_result *to = of->to;
    const cpinn_stepper *robot = envs->robot;
    const stepper_worker *worker = &robot->workers[thread];
    const size_t n = (size_t)robot->states, m = (size_t)robot->inputs;
    const size_t first = STEPPER_MEMBERS * (size_t)item,
                 left = (size_t)envs->settings.count - first;
    const size_t members = left < STEPPER_MEMBERS ? left : STEPPER_MEMBERS;
    double *next = envs->next + (size_t)thread * STEPPER_MEMBERS * n;
    double *after = envs->after + (size_t)thread * STEPPER_MEMBERS * m;
    const bool moves = robot->given->hold == SURROGATE_RAMP;
    for (size_t k = 0; k < members; k++) {
        set_inputs(envs, first + k, of->actions + (first + k) * (size_t)envs->actions,
                   after + k * m);
    }
    cpinn_stepper_take(robot, worker, (int)members, envs->states + first * n,
                       moves ? envs->inputs + first * m : after, moves ? after : NULL, next, NULL,
                       NULL);
    cpinn_stepper_see(worker, (int)members, next);
    for (size_t k = 0; k < members; k++) {
        const size_t i = first + k;
        const double *tip = worker->seen + k * KINEMATICS_SEEN;
        double *seen = to->observations + i * envs->width;
        if (envs->over[i] && envs->settings.autoreset == CPINN_RESET_NEXT) {
            observe(envs, i, begin(envs, i), seen);
            to->rewards[i] = 0;
            to->distances[i] = NAN;
            to->terminated[i] = to->truncated[i] = false;
            continue;
        }
        judge(envs, i, tip, next + k * n, after + k * m, to);
        observe(envs, i, to->terminated[i] ? envs->tasks[envs->task[i]].tip : tip, seen);
        if (envs->over[i] && envs->settings.autoreset == CPINN_RESET_SAME) {
            memcpy(to->last + i * envs->width, seen, envs->width * sizeof *seen);
            observe(envs, i, begin(envs, i), seen);
        }
    }
}

void cpinn_envs_step(cpinn_envs *envs, const double *actions, cpinn_envs_step_result *result)
{
    AD_LEAVE_HOST;
    stepping of = {envs, actions, result};
    ad_pool_run(envs->robot->pool, (envs->settings.count + STEPPER_MEMBERS - 1) / STEPPER_MEMBERS,
                step_piece, &of);
}
