/* The instances of an FMU around one trained model: what its functions (fmi3_functions.c) act on.
 * The values of the model follow from s and the time alone: there are no states, no events, and any
 * communication step is exact.
 *
 * What stands before this in the source of an FMU: the model's header, and
 *   FMU_TOKEN     the instantiation token
 *   FMU_PLACES    points of the rod; FMU_S and FMU_TIME, positions of s and t among the inputs of
 *                 the model, FMU_TIME -1 at rest
 *   FMU_INPUTS, FMU_OUTPUTS, FMU_MEMORY, FMU_EVAL, FMU_JACOBIAN   of the model
 *   fmu_lower, fmu_upper [FMU_INPUTS], the ranges, fmu_start [FMU_PLACES], where the points are at
 *                 first (m)
 *
 * Value references: 0 the time, 1 .. FMU_PLACES the s of each point, then all outputs of the first
 * point, of the second and so on, and last out_of_range. */
#ifndef TOOLS_EMIT_FMI3_INSTANCE_H
#define TOOLS_EMIT_FMI3_INSTANCE_H

#include "tools/emit/fmi3_types.h"

#include <math.h>
#include <stdarg.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

enum {
    FMU_FIRST_OUTPUT = 1 + FMU_PLACES,
    FMU_OUT_OF_RANGE = FMU_FIRST_OUTPUT + FMU_PLACES * FMU_OUTPUTS,
    FMU_MESSAGE = 256
};

/* What rounding may bring an input beyond an end of its range, as part of the range. */
#define FMU_ROUNDING 1e-9

/* The states of the standard's state machine, as bits. */
enum {
    FMU_INSTANTIATED = 1,
    FMU_INITIALIZATION = 2,
    FMU_EVENT = 4,
    FMU_CONTINUOUS = 8,
    FMU_STEP = 16,
    FMU_TERMINATED = 32,
    FMU_INITIALIZED = FMU_EVENT | FMU_CONTINUOUS | FMU_STEP,
    FMU_ANY = 63,
    FMU_SETTABLE = FMU_INSTANTIATED | FMU_INITIALIZATION | FMU_EVENT | FMU_STEP |
                   (FMU_TIME < 0 ? FMU_CONTINUOUS : 0) /* s is an input at rest */
};

/* All that an FMU state has to keep. */
typedef struct fmu_values {
    double time, s[FMU_PLACES];
    int mode;
} fmu_values;

typedef struct fmu_instance {
    fmu_values now;
    int by_steps; /* Co-Simulation */
    int evaluated, differentiated, warned;
    double outputs[FMU_PLACES][FMU_OUTPUTS];
    double jacobians[FMU_PLACES][FMU_OUTPUTS][FMU_INPUTS];
    double memory[FMU_MEMORY + 1];
    int logs_warnings;
    fmi3InstanceEnvironment environment;
    fmi3LogMessageCallback log;
} fmu_instance;

/* ---- messages ------------------------------------------------------------------------------- */

/* An error is told whatever is logged, and ends the simulation, as the standard has it. */
static fmi3Status fmu_fail(fmu_instance *m, const char *format, ...)
{
    char message[FMU_MESSAGE];
    va_list arguments;
    va_start(arguments, format);
    vsnprintf(message, sizeof message, format, arguments);
    va_end(arguments);
    if (m->log) {
        m->log(m->environment, fmi3Error, "logStatusError", message);
    }
    m->now.mode = FMU_TERMINATED;
    return fmi3Error;
}

/* NULL when the function may be called in the present state; else the error has been told. */
static fmu_instance *fmu_allowed(fmi3Instance instance, int modes, const char *function)
{
    fmu_instance *m = (fmu_instance *)instance;
    if (m && (m->now.mode & modes) == 0) {
        fmu_fail(m, "%s is not allowed in this state", function);
        return NULL;
    }
    return m;
}

/* A function of what this FMU does not have: fine when it is asked for nothing. */
static fmi3Status fmu_none(fmi3Instance instance, size_t count, const char *function)
{
    fmu_instance *m = (fmu_instance *)instance;
    return count == 0 ? fmi3OK
           : m        ? fmu_fail(m, "%s: this FMU has no such variables", function)
                      : fmi3Error;
}

static void fmu_unused(int count, ...)
{
    (void)count;
}

/* ---- the model ------------------------------------------------------------------------------ */

/* By how much the input `i` of a place is out of its range, as part of the range: above it more
 * than 0, below less; rounding is 0. */
static double fmu_beyond(const fmu_instance *m, int place, int i)
{
    double value = i == FMU_S ? m->now.s[place] : m->now.time;
    double end = value > fmu_upper[i] ? fmu_upper[i] : value < fmu_lower[i] ? fmu_lower[i] : value;
    double out = (value - end) / (fmu_upper[i] - fmu_lower[i]);
    return fabs(out) > FMU_ROUNDING ? out : 0;
}

/* Of the input that is furthest out; slope[0] is its derivative by the time, slope[1 + place] by
 * each s. */
static double fmu_excess(const fmu_instance *m, double slope[1 + FMU_PLACES])
{
    double worst = 0;
    int place, i;
    memset(slope, 0, (1 + FMU_PLACES) * sizeof *slope);
    for (place = 0; place < FMU_PLACES; place++) {
        for (i = 0; i < FMU_INPUTS; i++) {
            double out = fmu_beyond(m, place, i);
            if (fabs(out) > worst) {
                worst = fabs(out);
                memset(slope, 0, (1 + FMU_PLACES) * sizeof *slope);
                slope[i == FMU_S ? 1 + place : 0] =
                    (out > 0 ? 1 : -1) / (fmu_upper[i] - fmu_lower[i]);
            }
        }
    }
    return worst;
}

/* The inputs of the model at a place; those out of their range are put on its end. */
static void fmu_inputs(const fmu_instance *m, int place, double in[FMU_INPUTS])
{
    int i;
    for (i = 0; i < FMU_INPUTS; i++) {
        in[i] = i == FMU_S ? m->now.s[place] : m->now.time;
        in[i] = in[i] > fmu_upper[i] ? fmu_upper[i] : in[i] < fmu_lower[i] ? fmu_lower[i] : in[i];
    }
}

/* Told once, as a status too, because the importer may not want messages. */
static fmi3Status fmu_warn(fmu_instance *m)
{
    double slope[1 + FMU_PLACES];
    if (m->warned || fmu_excess(m, slope) == 0) {
        return fmi3OK;
    }
    m->warned = 1;
    if (m->logs_warnings && m->log) {
        m->log(
            m->environment, fmi3Warning, "logStatusWarning",
            "s or the time is beyond what the model was trained for: outputs stay as they are at "
            "the end of its range (see out_of_range)");
    }
    return fmi3Warning;
}

static fmi3Status fmu_evaluate(fmu_instance *m)
{
    double in[FMU_INPUTS];
    int place, k;
    for (place = 0; place < FMU_PLACES && !m->evaluated; place++) {
        fmu_inputs(m, place, in);
        FMU_EVAL(in, m->outputs[place], m->memory);
        for (k = 0; k < FMU_OUTPUTS; k++) {
            if (!(fabs(m->outputs[place][k]) <= 1e300)) {
                return fmu_fail(m, "an output is not finite");
            }
        }
    }
    m->evaluated = 1;
    return fmu_warn(m);
}

static fmi3Status fmu_differentiate(fmu_instance *m)
{
    double in[FMU_INPUTS], out[FMU_OUTPUTS];
    int place;
    for (place = 0; place < FMU_PLACES && !m->differentiated; place++) {
        fmu_inputs(m, place, in);
        FMU_JACOBIAN(in, out, &m->jacobians[place][0][0], m->memory);
    }
    m->differentiated = 1;
    return fmu_warn(m);
}

static void fmu_changed(fmu_instance *m)
{
    m->evaluated = m->differentiated = 0;
}

static void fmu_reset(fmu_instance *m)
{
    m->now.time = 0;
    memcpy(m->now.s, fmu_start, sizeof m->now.s);
    m->now.mode = FMU_INSTANTIATED;
    m->warned = 0;
    fmu_changed(m);
}

/* ---- instances ------------------------------------------------------------------------------ */

static fmi3Instance fmu_instantiate(fmi3String token, fmi3Boolean logging, int by_steps,
                                    int event_mode, fmi3InstanceEnvironment environment,
                                    fmi3LogMessageCallback log)
{
    const char *wrong = !token || strcmp(token, FMU_TOKEN) != 0
                            ? "the instantiation token is not that of this FMU"
                        : event_mode ? "this FMU has no event mode in co-simulation"
                                     : NULL;
    fmu_instance *m = wrong ? NULL : (fmu_instance *)calloc(1, sizeof *m);
    if (m) {
        m->by_steps = by_steps;
        m->logs_warnings = logging;
        m->environment = environment;
        m->log = log;
        fmu_reset(m);
    } else if (log) {
        log(environment, fmi3Error, "logStatusError", wrong ? wrong : "out of memory");
    }
    return m;
}

/* From one of the states in `from` to another one. */
static fmi3Status fmu_go(fmi3Instance instance, int from, int to, const char *function)
{
    fmu_instance *m = fmu_allowed(instance, from, function);
    if (!m) {
        return fmi3Error;
    }
    m->now.mode = to;
    return fmi3OK;
}

static fmi3Status fmu_set_time(fmu_instance *m, double time)
{
    if (!(fabs(time) <= 1e300)) {
        return fmu_fail(m, "the time is not finite");
    }
    m->now.time = time;
    fmu_changed(m);
    return fmi3OK;
}

/* ---- derivatives ---------------------------------------------------------------------------- */

/* Of the unknown by the known, which both are in range. */
static double fmu_partial(const fmu_instance *m, fmi3ValueReference unknown,
                          fmi3ValueReference known)
{
    double slope[1 + FMU_PLACES];
    int output = (int)unknown - FMU_FIRST_OUTPUT, place = output / FMU_OUTPUTS, input;
    if (unknown == FMU_OUT_OF_RANGE) {
        fmu_excess(m, slope);
        return slope[known];
    }
    if (known == 0 ? FMU_TIME < 0 : (int)known - 1 != place) {
        return 0;
    }
    input = known == 0 ? FMU_TIME : FMU_S;
    return fmu_beyond(m, place, input) != 0 ? 0 : m->jacobians[place][output % FMU_OUTPUTS][input];
}

/* J seed, or with `adjoint` J^T seed; J [unknowns][knowns] has the derivatives of outputs by the
 * time and by s. */
static fmi3Status fmu_product(fmi3Instance instance, const char *function, int adjoint,
                              const fmi3ValueReference unknowns[], size_t unknown_count,
                              const fmi3ValueReference knowns[], size_t known_count,
                              const double seed[], size_t seed_count, double product[],
                              size_t product_count)
{
    fmu_instance *m = fmu_allowed(instance, FMU_INITIALIZATION | FMU_INITIALIZED, function);
    fmi3Status status = m ? fmu_differentiate(m) : fmi3Error;
    size_t i, k;
    if (status == fmi3Error) {
        return status;
    }
    if (seed_count != (adjoint ? unknown_count : known_count) ||
        product_count != (adjoint ? known_count : unknown_count)) {
        return fmu_fail(m, "%s: all variables are scalar", function);
    }
    memset(product, 0, product_count * sizeof *product);
    for (i = 0; i < unknown_count; i++) {
        for (k = 0; k < known_count; k++) {
            if (unknowns[i] < FMU_FIRST_OUTPUT || unknowns[i] > FMU_OUT_OF_RANGE ||
                knowns[k] > FMU_PLACES) {
                return fmu_fail(m, "%s: outputs can be differentiated by s and the time", function);
            }
            product[adjoint ? k : i] +=
                fmu_partial(m, unknowns[i], knowns[k]) * seed[adjoint ? i : k];
        }
    }
    return status;
}

#endif
