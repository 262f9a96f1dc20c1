/* A motion whose inputs were recorded: some parameters of the scene, such as angles of motors,
 * tensions or pressures, are columns over time, and go linearly from each sample to the next. Those
 * that an end of the rod follows go by the cubic spline through their samples instead, as the
 * accelerations of ends act on the rod.
 *
 * It is followed by the reduced rod (physics/chain/reduced.h) from each sample to the next, with a
 * stop wherever something was measured, so that no step has a kink of an input inside. */
#ifndef PHYSICS_SOLVE_RECORDING_H
#define PHYSICS_SOLVE_RECORDING_H

#include "physics/scene/scene.h"

#include <stdint.h>

/* Borrowed. Of parameters that are no inputs the values are not looked at. */
typedef struct solve_inputs {
    int number; /* from 1 on, of the recording: what is measured on it has the same */
    size_t count;
    const double *t;      /* [count] s, ascending, from 0 or less on */
    const double *values; /* [count][parameter_count of the scene] */
    uint64_t which;       /* a bit for each parameter that is an input */
} solve_inputs;

/* values [parameter_count] at a time: those given, and of inputs what was recorded, before the
 * first sample and behind the last what is next to it. *at: a sample at or before t, which is moved
 * on; 0 to begin with. */
void solve_inputs_at(const solve_inputs *inputs, int parameters, double t, size_t *at,
                     double *values);

/* The first of the columns of velocity, behind which those of angular velocity are, of a rod. */
size_t solve_velocity_column(const scene *open);

typedef struct solve_recording solve_recording;

/* modes as in reduced_settings; s [places] m, where the rod is looked at. Errors as of
 * reduced_create. One is for one thread at a time. */
ad_status solve_recording_create(const scene *open, const int modes[4], size_t places,
                                 const double *s, solve_recording **result, ad_error *error);
void solve_recording_free(solve_recording *recording); /* NULL is allowed */

/* values [columns of the scene's model][rows]: what the rod is at t [rows] s, ascending, and
 * places [rows], of the columns of position, rotation, velocity and angular velocity; others are
 * left as they are. From where the scene begins, with parameters [parameter_count] for those that
 * are no inputs, in steps of so many `parts` between stops. AD_BAD_INPUT: times beyond the inputs,
 * or a play of both t and an input; AD_NOT_FINITE: there is no start, or no step; the error has the
 * time. */
ad_status solve_recording_run(solve_recording *recording, const solve_inputs *inputs,
                              const double *parameters, int parts, size_t rows, const double *t,
                              const size_t *places, double *values, ad_error *error);

/* The same with by [count][columns][rows]: derivatives by the last `count` parameters, none of them
 * an input: those of the steps, and differences of the start and of where its end is held. */
ad_status solve_recording_change(solve_recording *recording, const solve_inputs *inputs,
                                 const double *parameters, int parts, size_t rows, const double *t,
                                 const size_t *places, double *values, size_t count, double *by,
                                 ad_error *error);

#endif
