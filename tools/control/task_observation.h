/* Some values of several observations as one observation: the place that follows a path and numbers
 * that are kept in a range. Needs no library and allocates nothing: exported C has this very text.
 */
#ifndef CONTROL_TASK_OBSERVATION_H
#define CONTROL_TASK_OBSERVATION_H

#include "physics/local/one_step.h"

#include <stddef.h>

enum { TASK_OBSERVATION_PARTS_MAX = 16 };

typedef struct task_observation {
    int parts, inputs; /* of the model */
    struct task_observation_part {
        one_observation observation; /* context borrowed; all have the same states */
        int first, count;            /* of its values, those that are taken */
    } part[TASK_OBSERVATION_PARTS_MAX];
    double *room; /* [task_observation_room] */
} task_observation;

size_t task_observation_room(const task_observation *task_observation);

/* Borrows x, which is for one call at a time. */
one_observation task_observation_of(task_observation *task_observation);

#endif
