#include "tools/control/task_observation.h"

#include <string.h>

/* States at once. */
enum { TASK_OBSERVATION_STATES = 8 };

static size_t largest_observation(const task_observation *task_observation)
{
    int most = 0;
    for (int i = 0; i < task_observation->parts; i++) {
        most = task_observation->part[i].observation.values > most
                   ? task_observation->part[i].observation.values
                   : most;
    }
    return (size_t)most;
}

size_t task_observation_room(const task_observation *task_observation)
{
    return TASK_OBSERVATION_STATES * largest_observation(task_observation) *
           (1 + (size_t)task_observation->part[0].observation.states);
}

static int values_of(const task_observation *task_observation)
{
    int count = 0;
    for (int i = 0; i < task_observation->parts; i++) {
        count += task_observation->part[i].count;
    }
    return count;
}

/* Values of one part from `column` on, of at most TASK_OBSERVATION_STATES states. */
static int see_part(const task_observation *task_observation,
                    const struct task_observation_part *part, int column, int count,
                    const double *states, const double *inputs, double *values, double *by_state)
{
    const one_observation *of = &part->observation;
    const size_t n = (size_t)of->states, all = (size_t)values_of(task_observation),
                 taken = (size_t)part->count;
    double *rows = task_observation->room + TASK_OBSERVATION_STATES * (size_t)of->values;
    const int bad =
        of->see(of->context, count, states, inputs, task_observation->room, by_state ? rows : NULL);
    for (size_t i = 0; i < (size_t)count && !bad; i++) {
        const size_t to = i * all + (size_t)column;
        const size_t from = i * (size_t)of->values + (size_t)part->first;
        memcpy(values + to, task_observation->room + from, taken * sizeof *values);
        if (by_state) {
            memcpy(by_state + to * n, rows + from * n, taken * n * sizeof *by_state);
        }
    }
    return bad;
}

static int see_parts(void *context, int count, const double *states, const double *inputs,
                     double *values, double *by_state)
{
    const task_observation *task_observation = context;
    const one_observation *first = &task_observation->part[0].observation;
    const int all = values_of(task_observation), n = first->states;
    for (int from = 0; from < count; from += TASK_OBSERVATION_STATES) {
        const int now =
            count - from < TASK_OBSERVATION_STATES ? count - from : TASK_OBSERVATION_STATES;
        for (int i = 0, column = 0; i < task_observation->parts;
             column += task_observation->part[i++].count) {
            const int bad = see_part(
                task_observation, &task_observation->part[i], column, now, states + from * n,
                inputs ? inputs + from * task_observation->inputs : NULL, values + from * all,
                by_state ? by_state + from * all * n : NULL);
            if (bad) {
                return bad;
            }
        }
    }
    return 0;
}

one_observation task_observation_of(task_observation *task_observation)
{
    return (one_observation){.context = task_observation,
                             .states = task_observation->part[0].observation.states,
                             .inputs = task_observation->inputs,
                             .values = values_of(task_observation),
                             .see = see_parts};
}
