/* The functions of FMI 3.0, for Model Exchange and Co-Simulation; compiled only within an FMU,
 * after what fmi3_instance.h says. */
#include "tools/emit/fmi3_instance.h"

#ifdef __cplusplus
extern "C" {
#endif

FMU_FUNCTION(const char *, fmi3GetVersion)(void)
{
    return "3.0";
}

FMU_FUNCTION(fmi3Status, fmi3SetDebugLogging)
(fmi3Instance instance, fmi3Boolean logging, size_t count, const fmi3String categories[])
{
    fmu_instance *m = (fmu_instance *)instance;
    size_t i;
    int named = count == 0;
    for (i = 0; i < count; i++) {
        named = named || strcmp(categories[i], "logStatusWarning") == 0;
    }
    m->logs_warnings = named ? logging : m->logs_warnings;
    return fmi3OK;
}

FMU_FUNCTION(fmi3Instance, fmi3InstantiateModelExchange)
(fmi3String name, fmi3String token, fmi3String resources, fmi3Boolean visible, fmi3Boolean logging,
 fmi3InstanceEnvironment environment, fmi3LogMessageCallback log)
{
    fmu_unused(3, name, resources, (int)visible);
    return fmu_instantiate(token, logging, 0, 0, environment, log);
}

FMU_FUNCTION(fmi3Instance, fmi3InstantiateCoSimulation)
(fmi3String name, fmi3String token, fmi3String resources, fmi3Boolean visible, fmi3Boolean logging,
 fmi3Boolean event_mode, fmi3Boolean early_return, const fmi3ValueReference intermediate[],
 size_t intermediate_count, fmi3InstanceEnvironment environment, fmi3LogMessageCallback log,
 fmi3IntermediateUpdateCallback update)
{
    fmu_unused(7, name, resources, (int)visible, (int)early_return, intermediate,
               intermediate_count, update);
    return fmu_instantiate(token, logging, 1, event_mode, environment, log);
}

FMU_FUNCTION(fmi3Instance, fmi3InstantiateScheduledExecution)
(fmi3String name, fmi3String token, fmi3String resources, fmi3Boolean visible, fmi3Boolean logging,
 fmi3InstanceEnvironment environment, fmi3LogMessageCallback log, fmi3ClockUpdateCallback update,
 fmi3LockPreemptionCallback lock, fmi3UnlockPreemptionCallback unlock)
{
    fmu_unused(8, name, token, resources, (int)visible, (int)logging, update, lock, unlock);
    if (log) {
        log(environment, fmi3Error, "logStatusError", "this FMU has no scheduled execution");
    }
    return NULL;
}

FMU_FUNCTION(void, fmi3FreeInstance)(fmi3Instance instance)
{
    free(instance);
}

FMU_FUNCTION(fmi3Status, fmi3EnterInitializationMode)
(fmi3Instance instance, fmi3Boolean tolerance_defined, fmi3Float64 tolerance, fmi3Float64 start,
 fmi3Boolean stop_defined, fmi3Float64 stop)
{
    fmi3Status status =
        fmu_go(instance, FMU_INSTANTIATED, FMU_INITIALIZATION, "fmi3EnterInitializationMode");
    fmu_unused(4, (int)tolerance_defined, tolerance, (int)stop_defined, stop);
    return status == fmi3OK ? fmu_set_time((fmu_instance *)instance, start) : status;
}

FMU_FUNCTION(fmi3Status, fmi3ExitInitializationMode)(fmi3Instance instance)
{
    fmu_instance *m = fmu_allowed(instance, FMU_INITIALIZATION, "fmi3ExitInitializationMode");
    if (!m) {
        return fmi3Error;
    }
    m->now.mode = m->by_steps ? FMU_STEP : FMU_EVENT;
    return fmi3OK;
}

FMU_FUNCTION(fmi3Status, fmi3EnterEventMode)(fmi3Instance instance)
{
    return fmu_go(instance, FMU_CONTINUOUS, FMU_EVENT, "fmi3EnterEventMode");
}

FMU_FUNCTION(fmi3Status, fmi3EnterContinuousTimeMode)(fmi3Instance instance)
{
    return fmu_go(instance, FMU_EVENT, FMU_CONTINUOUS, "fmi3EnterContinuousTimeMode");
}

FMU_FUNCTION(fmi3Status, fmi3EnterStepMode)(fmi3Instance instance)
{
    return fmu_go(instance, 0, FMU_STEP, "fmi3EnterStepMode"); /* without event mode */
}

FMU_FUNCTION(fmi3Status, fmi3EnterConfigurationMode)(fmi3Instance instance)
{
    return fmu_go(instance, 0, FMU_STEP, "fmi3EnterConfigurationMode");
}

FMU_FUNCTION(fmi3Status, fmi3ExitConfigurationMode)(fmi3Instance instance)
{
    return fmu_go(instance, 0, FMU_STEP, "fmi3ExitConfigurationMode");
}

FMU_FUNCTION(fmi3Status, fmi3Terminate)(fmi3Instance instance)
{
    return fmu_go(instance, FMU_INITIALIZED, FMU_TERMINATED, "fmi3Terminate");
}

FMU_FUNCTION(fmi3Status, fmi3Reset)(fmi3Instance instance)
{
    fmu_reset((fmu_instance *)instance);
    return fmi3OK;
}

/* ---- variables ------------------------------------------------------------------------------ */

FMU_FUNCTION(fmi3Status, fmi3GetFloat64)
(fmi3Instance instance, const fmi3ValueReference references[], size_t count, fmi3Float64 values[],
 size_t size)
{
    fmu_instance *m = fmu_allowed(instance, FMU_ANY, "fmi3GetFloat64");
    double slope[1 + FMU_PLACES];
    fmi3Status status = fmi3OK;
    size_t i;
    if (!m || count != size) {
        return m ? fmu_fail(m, "fmi3GetFloat64: all variables are scalar") : fmi3Error;
    }
    for (i = 0; i < count; i++) {
        fmi3ValueReference k = references[i];
        if (k >= FMU_FIRST_OUTPUT && k <= FMU_OUT_OF_RANGE && status == fmi3OK) {
            status = fmu_evaluate(m);
        }
        if (status == fmi3Error || k > FMU_OUT_OF_RANGE) {
            return status == fmi3Error ? status
                                       : fmu_fail(m,
                                                  "fmi3GetFloat64: no variable has the "
                                                  "reference %lu",
                                                  (unsigned long)k);
        }
        values[i] = k == 0                 ? m->now.time
                    : k < FMU_FIRST_OUTPUT ? m->now.s[k - 1]
                    : k < FMU_OUT_OF_RANGE ? m->outputs[0][k - FMU_FIRST_OUTPUT]
                                           : fmu_excess(m, slope);
    }
    return status;
}

FMU_FUNCTION(fmi3Status, fmi3SetFloat64)
(fmi3Instance instance, const fmi3ValueReference references[], size_t count,
 const fmi3Float64 values[], size_t size)
{
    fmu_instance *m = fmu_allowed(instance, count ? FMU_SETTABLE : FMU_ANY, "fmi3SetFloat64");
    size_t i;
    if (!m || count != size) {
        return m ? fmu_fail(m, "fmi3SetFloat64: all variables are scalar") : fmi3Error;
    }
    for (i = 0; i < count; i++) {
        if (references[i] < 1 || references[i] > FMU_PLACES || !(fabs(values[i]) <= 1e300)) {
            return fmu_fail(m, "fmi3SetFloat64: only s can be set, and to a finite number");
        }
        m->now.s[references[i] - 1] = values[i];
    }
    fmu_changed(m);
    return fmi3OK;
}

/* Of all other types there are no variables. */
#define FMU_NO_VARIABLES(type)                                                                     \
    FMU_FUNCTION(fmi3Status, fmi3Get##type)                                                        \
    (fmi3Instance instance, const fmi3ValueReference references[], size_t count,                   \
     fmi3##type values[], size_t size)                                                             \
    {                                                                                              \
        fmu_unused(3, references, values, size);                                                   \
        return fmu_none(instance, count, "fmi3Get" #type);                                         \
    }                                                                                              \
    FMU_FUNCTION(fmi3Status, fmi3Set##type)                                                        \
    (fmi3Instance instance, const fmi3ValueReference references[], size_t count,                   \
     const fmi3##type values[], size_t size)                                                       \
    {                                                                                              \
        fmu_unused(3, references, values, size);                                                   \
        return fmu_none(instance, count, "fmi3Set" #type);                                         \
    }
FMU_NO_VARIABLES(Float32)
FMU_NO_VARIABLES(Int8)
FMU_NO_VARIABLES(UInt8)
FMU_NO_VARIABLES(Int16)
FMU_NO_VARIABLES(UInt16)
FMU_NO_VARIABLES(Int32)
FMU_NO_VARIABLES(UInt32)
FMU_NO_VARIABLES(Int64)
FMU_NO_VARIABLES(UInt64)
FMU_NO_VARIABLES(Boolean)
FMU_NO_VARIABLES(String)

/* A function (instance, `first` [count], count, rest) about what this FMU has none of. */
#define FMU_NOTHING(name, rest, ...)                                                               \
    FMU_FUNCTION(fmi3Status, name)                                                                 \
    (fmi3Instance instance, const fmi3ValueReference references[], size_t count, FMU_LIST rest)    \
    {                                                                                              \
        fmu_unused(1, references, __VA_ARGS__);                                                    \
        return fmu_none(instance, count, #name);                                                   \
    }
#define FMU_LIST(...) __VA_ARGS__
FMU_NOTHING(fmi3GetBinary, (size_t sizes[], fmi3Binary values[], size_t n), sizes, values, n)
FMU_NOTHING(fmi3SetBinary, (const size_t sizes[], const fmi3Binary values[], size_t n), sizes,
            values, n)
FMU_NOTHING(fmi3GetClock, (fmi3Clock values[]), values)
FMU_NOTHING(fmi3SetClock, (const fmi3Clock values[]), values)
FMU_NOTHING(fmi3GetIntervalDecimal, (fmi3Float64 of[], fmi3IntervalQualifier how[]), of, how)
FMU_NOTHING(fmi3GetIntervalFraction,
            (fmi3UInt64 of[], fmi3UInt64 per[], fmi3IntervalQualifier how[]), of, per, how)
FMU_NOTHING(fmi3GetShiftDecimal, (fmi3Float64 of[]), of)
FMU_NOTHING(fmi3GetShiftFraction, (fmi3UInt64 of[], fmi3UInt64 per[]), of, per)
FMU_NOTHING(fmi3SetIntervalDecimal, (const fmi3Float64 of[]), of)
FMU_NOTHING(fmi3SetIntervalFraction, (const fmi3UInt64 of[], const fmi3UInt64 per[]), of, per)
FMU_NOTHING(fmi3SetShiftDecimal, (const fmi3Float64 of[]), of)
FMU_NOTHING(fmi3SetShiftFraction, (const fmi3UInt64 of[], const fmi3UInt64 per[]), of, per)
FMU_NOTHING(fmi3GetOutputDerivatives, (const fmi3Int32 orders[], fmi3Float64 values[], size_t n),
            orders, values, n)

FMU_FUNCTION(fmi3Status, fmi3GetNumberOfVariableDependencies)
(fmi3Instance instance, fmi3ValueReference reference, size_t *count)
{
    fmu_unused(2, (int)reference, count);
    return fmu_none(instance, 1, "fmi3GetNumberOfVariableDependencies");
}

FMU_FUNCTION(fmi3Status, fmi3GetVariableDependencies)
(fmi3Instance instance, fmi3ValueReference dependent, size_t dependent_elements[],
 fmi3ValueReference independents[], size_t independent_elements[], fmi3DependencyKind kinds[],
 size_t count)
{
    fmu_unused(6, (int)dependent, dependent_elements, independents, independent_elements, kinds,
               count);
    return fmu_none(instance, 1, "fmi3GetVariableDependencies");
}

/* ---- derivatives ---------------------------------------------------------------------------- */

FMU_FUNCTION(fmi3Status, fmi3GetDirectionalDerivative)
(fmi3Instance instance, const fmi3ValueReference unknowns[], size_t unknown_count,
 const fmi3ValueReference knowns[], size_t known_count, const fmi3Float64 seed[], size_t seed_count,
 fmi3Float64 sensitivity[], size_t sensitivity_count)
{
    return fmu_product(instance, "fmi3GetDirectionalDerivative", 0, unknowns, unknown_count, knowns,
                       known_count, seed, seed_count, sensitivity, sensitivity_count);
}

FMU_FUNCTION(fmi3Status, fmi3GetAdjointDerivative)
(fmi3Instance instance, const fmi3ValueReference unknowns[], size_t unknown_count,
 const fmi3ValueReference knowns[], size_t known_count, const fmi3Float64 seed[], size_t seed_count,
 fmi3Float64 sensitivity[], size_t sensitivity_count)
{
    return fmu_product(instance, "fmi3GetAdjointDerivative", 1, unknowns, unknown_count, knowns,
                       known_count, seed, seed_count, sensitivity, sensitivity_count);
}

/* ---- FMU states ----------------------------------------------------------------------------- */

FMU_FUNCTION(fmi3Status, fmi3GetFMUState)(fmi3Instance instance, fmi3FMUState *state)
{
    fmu_instance *m = (fmu_instance *)instance;
    if (!*state && !(*state = malloc(sizeof m->now))) {
        return fmu_fail(m, "out of memory");
    }
    memcpy(*state, &m->now, sizeof m->now);
    return fmi3OK;
}

FMU_FUNCTION(fmi3Status, fmi3SetFMUState)(fmi3Instance instance, fmi3FMUState state)
{
    fmu_instance *m = (fmu_instance *)instance;
    memcpy(&m->now, state, sizeof m->now);
    fmu_changed(m);
    return fmi3OK;
}

FMU_FUNCTION(fmi3Status, fmi3FreeFMUState)(fmi3Instance instance, fmi3FMUState *state)
{
    fmu_unused(1, instance);
    if (state) {
        free(*state);
        *state = NULL;
    }
    return fmi3OK;
}

FMU_FUNCTION(fmi3Status, fmi3SerializedFMUStateSize)
(fmi3Instance instance, fmi3FMUState state, size_t *size)
{
    fmu_unused(2, instance, state);
    *size = sizeof(fmu_values);
    return fmi3OK;
}

FMU_FUNCTION(fmi3Status, fmi3SerializeFMUState)
(fmi3Instance instance, fmi3FMUState state, fmi3Byte bytes[], size_t size)
{
    if (size != sizeof(fmu_values)) {
        return fmu_fail((fmu_instance *)instance, "fmi3SerializeFMUState: the size is another");
    }
    memcpy(bytes, state, size);
    return fmi3OK;
}

FMU_FUNCTION(fmi3Status, fmi3DeserializeFMUState)
(fmi3Instance instance, const fmi3Byte bytes[], size_t size, fmi3FMUState *state)
{
    fmu_instance *m = (fmu_instance *)instance;
    if (size != sizeof(fmu_values)) {
        return fmu_fail(m, "fmi3DeserializeFMUState: this is no state of this FMU");
    }
    if (!*state && !(*state = malloc(size))) {
        return fmu_fail(m, "out of memory");
    }
    memcpy(*state, bytes, size);
    return fmi3OK;
}

/* ---- Model Exchange: time goes on, without states and events -------------------------------- */

FMU_FUNCTION(fmi3Status, fmi3SetTime)(fmi3Instance instance, fmi3Float64 time)
{
    fmu_instance *m = fmu_allowed(instance, FMU_CONTINUOUS | FMU_EVENT, "fmi3SetTime");
    return m ? fmu_set_time(m, time) : fmi3Error;
}

FMU_FUNCTION(fmi3Status, fmi3EvaluateDiscreteStates)(fmi3Instance instance)
{
    return fmu_go(instance, FMU_EVENT, FMU_EVENT, "fmi3EvaluateDiscreteStates");
}

FMU_FUNCTION(fmi3Status, fmi3UpdateDiscreteStates)
(fmi3Instance instance, fmi3Boolean *update_again, fmi3Boolean *terminate,
 fmi3Boolean *nominals_changed, fmi3Boolean *values_changed, fmi3Boolean *event_defined,
 fmi3Float64 *event_time)
{
    *update_again = *terminate = *nominals_changed = *values_changed = *event_defined = false;
    *event_time = 0;
    return fmu_go(instance, FMU_EVENT, FMU_EVENT, "fmi3UpdateDiscreteStates");
}

FMU_FUNCTION(fmi3Status, fmi3CompletedIntegratorStep)
(fmi3Instance instance, fmi3Boolean no_return, fmi3Boolean *enter_event_mode,
 fmi3Boolean *terminate)
{
    fmu_unused(1, (int)no_return);
    *enter_event_mode = *terminate = false;
    return fmu_go(instance, FMU_CONTINUOUS, FMU_CONTINUOUS, "fmi3CompletedIntegratorStep");
}

#define FMU_NO_STATES(name, constant)                                                              \
    FMU_FUNCTION(fmi3Status, name)(fmi3Instance instance, constant fmi3Float64 x[], size_t count)  \
    {                                                                                              \
        fmu_unused(1, x);                                                                          \
        return fmu_none(instance, count, #name);                                                   \
    }
FMU_NO_STATES(fmi3SetContinuousStates, const)
FMU_NO_STATES(fmi3GetContinuousStates, )
FMU_NO_STATES(fmi3GetContinuousStateDerivatives, )
FMU_NO_STATES(fmi3GetNominalsOfContinuousStates, )
FMU_NO_STATES(fmi3GetEventIndicators, )

FMU_FUNCTION(fmi3Status, fmi3GetNumberOfEventIndicators)(fmi3Instance instance, size_t *count)
{
    fmu_unused(1, instance);
    *count = 0;
    return fmi3OK;
}

FMU_FUNCTION(fmi3Status, fmi3GetNumberOfContinuousStates)(fmi3Instance instance, size_t *count)
{
    fmu_unused(1, instance);
    *count = 0;
    return fmi3OK;
}

/* ---- Co-Simulation -------------------------------------------------------------------------- */

FMU_FUNCTION(fmi3Status, fmi3DoStep)
(fmi3Instance instance, fmi3Float64 time, fmi3Float64 step, fmi3Boolean no_return,
 fmi3Boolean *event_needed, fmi3Boolean *terminate, fmi3Boolean *early_return,
 fmi3Float64 *last_time)
{
    fmu_instance *m = fmu_allowed(instance, FMU_STEP, "fmi3DoStep");
    fmi3Status status = fmi3Error;
    fmu_unused(1, (int)no_return);
    *event_needed = *terminate = *early_return = false;
    if (m && step >= 0) {
        status = fmu_set_time(m, time + step);
    } else if (m) {
        status = fmu_fail(m, "fmi3DoStep: a step cannot be negative");
    }
    *last_time = m ? m->now.time : time;
    return status == fmi3OK ? fmu_warn(m) : status;
}

FMU_FUNCTION(fmi3Status, fmi3ActivateModelPartition)
(fmi3Instance instance, fmi3ValueReference clock, fmi3Float64 time)
{
    fmu_unused(2, (int)clock, time);
    return fmu_none(instance, 1, "fmi3ActivateModelPartition");
}

#ifdef __cplusplus
}
#endif
