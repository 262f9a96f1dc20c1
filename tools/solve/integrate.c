#include "tools/solve/integrate.h"

#include "tools/solve/lobatto.h"
#include "tools/solve/motion_system.h"

#include <arkode/arkode_arkstep.h>
#include <nvector/nvector_serial.h>

#include <math.h>
#include <stdio.h>
#include <string.h>

enum { QUADRATURE_DEGREE = 4 }; /* over a step: as exact as the step */

typedef struct integration {
    motion *motion;
    motion_system *system;
    SUNContext context;
    void *stepper;
    N_Vector state, sample;
    ad_error error; /* of a formula, or SUNDIALS' words */
    double x[QUADRATURE_DEGREE + 1], weights[QUADRATURE_DEGREE + 1];
    double work, dissipated, time; /* energy so far, up to `time` */
} integration;

/* ---- what SUNDIALS calls ------------------------------------------------------------------- */

static int rate(realtype t, N_Vector state, N_Vector to, void *data)
{
    integration *in = data;
    const double *from = N_VGetArrayPointer(state);
    double *result = N_VGetArrayPointer(to);
    if (motion_at(in->motion, t, &in->error) != AD_OK) {
        return -1;
    }
    motion_rate(in->motion, from, result);
    motion_system_at(in->system, from, result);
    for (size_t i = 0; i < motion_nodes(in->motion) * MOTION_ROWS; i++) {
        if (!isfinite(result[i])) {
            return 1; /* a shorter step may do */
        }
    }
    return 0;
}

/* The rate has just been evaluated at t and state. */
static int form(realtype t, N_Vector state, N_Vector its_rate, SUNMatrix matrix, SUNMatrix mass,
                booleantype reuse, booleantype *is_new, realtype gamma, void *data, N_Vector a,
                N_Vector b, N_Vector c)
{
    (void)t, (void)state, (void)its_rate, (void)matrix, (void)mass, (void)reuse;
    (void)a, (void)b, (void)c;
    integration *in = data;
    *is_new = SUNTRUE;
    return motion_system_form(in->system, gamma) != 0;
}

static void keep_words(int code, const char *module, const char *function, char *words, void *data)
{
    (void)code, (void)module, (void)function;
    integration *in = data;
    if (in->error.status == AD_OK) {
        snprintf(in->error.message, sizeof in->error.message, "%s", words);
    }
}

/* ---- making and freeing -------------------------------------------------------------------- */

static void close_integration(integration *in)
{
    if (in->stepper) {
        ARKStepFree(&in->stepper);
    }
    if (in->state) {
        N_VDestroy(in->state);
    }
    if (in->sample) {
        N_VDestroy(in->sample);
    }
    motion_system_free(in->system);
    if (in->context) {
        SUNContext_Free(&in->context);
    }
}

static bool set_up(integration *in, double tolerance)
{
    /* Of the tolerance, what the iterations may leave: more of it would pass for errors of steps.
     */
    const double left_over = 0.01;
    void *s = in->stepper;
    int bad = ARKStepSetErrHandlerFn(s, keep_words, in) != 0;
    bad |= ARKStepSetUserData(s, in) != 0;
    bad |= ARKStepSStolerances(s, tolerance, tolerance) != 0;
    bad |= ARKStepSetTableNum(s, ARKODE_ARK548L2SAb_DIRK_8_4_5, ARKODE_ERK_NONE) != 0;
    bad |= ARKStepSetMaxNumSteps(s, -1) != 0;
    bad |= ARKStepSetInterpolantType(s, ARK_INTERP_LAGRANGE) != 0;
    bad |= ARKStepSetPredictorMethod(s, 1) != 0; /* by interpolation through past steps */
    bad |= ARKStepSetDeduceImplicitRhs(s, SUNTRUE) != 0;
    bad |= ARKStepSetNonlinConvCoef(s, left_over) != 0;
    bad |= ARKStepSetLinearSolver(s, motion_system_solver(in->system),
                                  motion_system_matrix(in->system)) != 0;
    bad |= ARKStepSetLinSysFn(s, form) != 0;
    return !bad;
}

static ad_status open_integration(integration *in, double tolerance, ad_error *error)
{
    size_t rows = motion_nodes(in->motion) * MOTION_ROWS;
    if (SUNContext_Create(NULL, &in->context) != 0) {
        return ad_fail(error, AD_NO_MEMORY, "out of memory for SUNDIALS");
    }
    ad_status status = motion_system_create(in->motion, in->context, &in->system, error);
    if (status != AD_OK) {
        return status;
    }
    in->state = N_VNew_Serial((sunindextype)rows, in->context);
    in->sample = N_VNew_Serial((sunindextype)rows, in->context);
    if (!in->state || !in->sample) {
        return ad_fail(error, AD_NO_MEMORY, "out of memory for SUNDIALS");
    }
    status = motion_initial(in->motion, N_VGetArrayPointer(in->state), error);
    if (status != AD_OK) {
        return status;
    }
    in->stepper = ARKStepCreate(NULL, rate, 0, in->state, in->context);
    if (!in->stepper || !set_up(in, tolerance)) {
        return ad_fail(error, AD_NO_MEMORY, "out of memory for SUNDIALS");
    }
    lobatto_points(QUADRATURE_DEGREE, in->x, in->weights);
    return AD_OK;
}

/* ---- stepping ------------------------------------------------------------------------------ */

/* The state at t within the last step, or at 0 before the first; NULL: see the error. */
static double *state_at(integration *in, double t, bool has_stepped)
{
    double *state = N_VGetArrayPointer(has_stepped ? in->sample : in->state);
    if ((has_stepped && ARKStepGetDky(in->stepper, t, 0, in->sample) != 0) ||
        motion_at(in->motion, t, &in->error) != AD_OK) {
        return NULL;
    }
    motion_prescribe(in->motion, state);
    return state;
}

/* Work and dissipation from in->time to t, within the last step. */
static bool integrate_power(integration *in, double t)
{
    double half = 0.5 * (t - in->time), middle = 0.5 * (t + in->time);
    for (int i = 0; half > 0 && i <= QUADRATURE_DEGREE; i++) {
        const double *state = state_at(in, middle + half * in->x[i], true);
        if (!state) {
            return false;
        }
        motion_energy energy = motion_energy_of(in->motion, state);
        in->work += half * in->weights[i] * energy.power;
        in->dissipated += half * in->weights[i] * energy.dissipation;
    }
    in->time = t;
    return true;
}

static bool record(integration *in, double t, bool has_stepped, double *to,
                   integrate_energy *energy)
{
    if (energy && has_stepped && !integrate_power(in, t)) {
        return false;
    }
    const double *state = state_at(in, t, has_stepped);
    if (!state) {
        return false;
    }
    memcpy(to, state, motion_nodes(in->motion) * MOTION_ROWS * sizeof *to);
    if (energy) {
        motion_energy now = motion_energy_of(in->motion, state);
        *energy = (integrate_energy){now.kinetic, now.strain, in->work, in->dissipated};
    }
    return true;
}

static bool run(integration *in, size_t count, const double *times, double *states,
                integrate_energy *energies, double *t)
{
    size_t rows = motion_nodes(in->motion) * MOTION_ROWS, done = 0;
    for (bool has_stepped = false; true; has_stepped = true) {
        for (; done < count && times[done] <= *t; done++) {
            if (!record(in, times[done], has_stepped, states + done * rows,
                        energies ? energies + done : NULL)) {
                return false;
            }
        }
        if (done == count) {
            return true;
        }
        if (energies && has_stepped && !integrate_power(in, *t)) {
            return false;
        }
        if (ARKStepSetStopTime(in->stepper, times[count - 1]) < 0 ||
            ARKStepEvolve(in->stepper, times[count - 1], in->state, t, ARK_ONE_STEP) < 0) {
            return false;
        }
    }
}

static void count_work(const integration *in, integrate_counts *counts)
{
    long unused;
    ARKStepGetNumSteps(in->stepper, &counts->steps);
    ARKStepGetNonlinSolvStats(in->stepper, &counts->newton_steps, &unused);
    ARKStepGetNumLinSolvSetups(in->stepper, &counts->matrices);
    ARKStepGetNumErrTestFails(in->stepper, &counts->failures);
}

ad_status integrate(motion *m, double tolerance, size_t count, const double *times, double *states,
                    integrate_energy *energies, integrate_counts *counts, ad_error *error)
{
    integration in = {.motion = m};
    *counts = (integrate_counts){0};
    ad_status status = open_integration(&in, tolerance, error);
    if (status == AD_OK && !run(&in, count, times, states, energies, &counts->time)) {
        status = in.error.status != AD_OK ? in.error.status : AD_NOT_FINITE;
        ad_fail(error, status, "time integration stopped at t = %g of %g: %s", counts->time,
                times[count - 1], in.error.message);
    }
    if (in.stepper) {
        count_work(&in, counts);
    }
    close_integration(&in);
    return status;
}
