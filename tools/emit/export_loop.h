/* Filter and controller of a robot as C: what cpinn-export writes of a scene with a section
 * `control`. */
#ifndef TOOLS_EMIT_EXPORT_LOOP_H
#define TOOLS_EMIT_EXPORT_LOOP_H

#include "physics/scene/scene.h"
#include "tools/control/clearance_observation.h"
#include "tools/control/linear_step.h"
#include "tools/control/regulator.h"
#include "tools/control/task_observation.h"
#include "tools/emit/export_compile.h"
#include "tools/surrogate/surrogate_step.h"

#include <stdbool.h>
#include <stdio.h>

/* A one-step model; one of them. */
typedef struct export_step {
    const surrogate_step *surrogate;
    const linear_step *linear;
} export_step;

enum { EXPORT_LOOP_HELD = 10 };

typedef struct export_loop {
    const char *name;  /* a C identifier */
    const char *about; /* of the comment of the header: a few words */
    const scene *open; /* its parameters with ranges are the inputs of the models */
    const regulator_settings *settings;
    export_step filter, controller; /* the models */
    /* What settings have as observations: of each sensor, and of the view that the controller has.
     */
    const kinematic_observation *const *sensors;
    const task_observation *seen;
    const kinematic_observation *const *parts; /* [seen->parts]; the first is the place */
    const clearance_observation *clearance;    /* of the part behind it; NULL: none */
    int clearance_part;
    const double *state, *inputs, *by_parameters; /* at sample 0, as regulator_start has them */
    const char *const *verified;                  /* lines of the header, NULL at the end */
    size_t memory;                                /* bytes; by export_loop_record */
    /* Of the self-test, by export_loop_record. */
    int samples;
    double *measured; /* [samples][values of all sensors], NaN: missing */
    double *paths;    /* [samples][horizon][3] */
    double *expected; /* [samples][controlled + parameters] */
    double *reached;  /* [samples][3]: the place, EXPORT_LOOP_HELD steps of the filter's model after
                       * the answer, from the estimate, as if the answer were held */
    int *flags;       /* [samples] */
} export_loop;

int export_loop_values(const export_loop *loop); /* of all sensors */

/* Texts of the C: lines, NULL at the end. */
extern const char *const export_loop_cores[], *const export_loop_types[];
extern const char *const export_loop_functions[], *const export_loop_selftest[];

/* Runs the loop on its own model with some noise and faults, for the self-test. AD_NO_MEMORY,
 * AD_NOT_FINITE. Free it all the same. */
ad_status export_loop_record(export_loop *loop, ad_error *error);
void export_loop_free(export_loop *loop);

/* An export_writer of the texts of an export_loop. */
export_writer export_loop_write;

/* Whether functions of the C have names of their own that begin so. */
bool export_loop_takes(const char *name);

#endif
