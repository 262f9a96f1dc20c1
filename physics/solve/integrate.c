#include "physics/solve/integrate.h"

#include "physics/local/solve_vector.h"
#include "physics/numerics/gauss.h"
#include "physics/solve/motion_fastest.h"
#include "physics/solve/motion_system.h"

#include <arkode/arkode_arkstep.h>

#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

/* Of the methods (integrate.h). */
static const ARKODE_DIRKTableID IMPLICIT_TABLE = ARKODE_ARK548L2SAb_DIRK_8_4_5;
static const ARKODE_ERKTableID EXPLICIT_TABLE = ARKODE_ARK436L2SA_ERK_6_3_4;

typedef struct integration {
    motion *motion;
    motion_system *system; /* implicit */
    SUNContext context;
    void *stepper;
    N_Vector state, sample;
    ad_error error;                /* of a formula, or SUNDIALS' words */
    gauss_rule quadrature;         /* of power over a step */
    double tolerance;              /* of a step */
    double initial;                /* energy */
    double work, dissipated, time; /* so far, up to `time` */
    const solve_events *events;    /* NULL: none */
    size_t event;                  /* which comes next */
    solve_clock *clock;            /* NULL: none */
    ARKodeButcherTable table;      /* of the steps */
    double *rows; /* explicit: state before the last step, stages of one that goes aside */
    double begun; /* the last step */
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
    if (in->system) {
        motion_system_at(in->system, from, result);
    }
    return solve_vector_is_finite(to) ? 0 : 1; /* a shorter step may do */
}

/* One over what a row may be off. */
static int weigh(N_Vector state, N_Vector weight, void *data)
{
    const integration *in = data;
    solve_vector_weigh(in->tolerance, state, weight);
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
    ARKodeButcherTable_Free(in->table);
    free(in->rows);
    if (in->context) {
        SUNContext_Free(&in->context);
    }
}

/* How the implicit stages are solved. */
static int set_up_stages(integration *in)
{
    /* Of the tolerance, what the iterations may leave: more of it would pass for errors of steps.
     */
    const double left_over = 0.01;
    void *s = in->stepper;
    int bad = ARKStepSetPredictorMethod(s, 1); /* by interpolation through past steps */
    bad |= ARKStepSetDeduceImplicitRhs(s, SUNTRUE);
    bad |= ARKStepSetNonlinConvCoef(s, left_over);
    bad |= ARKStepSetLinearSolver(s, motion_system_solver(in->system),
                                  motion_system_matrix(in->system));
    bad |= ARKStepSetLinSysFn(s, form);
    return bad;
}

static bool set_up(integration *in, const integrate_settings *settings)
{
    bool implicit = settings->method == INTEGRATE_IMPLICIT;
    void *s = in->stepper;
    int bad = ARKStepSetErrHandlerFn(s, keep_words, in);
    bad |= ARKStepSetUserData(s, in);
    bad |= ARKStepWFtolerances(s, weigh);
    bad |= ARKStepSetTableNum(s, implicit ? IMPLICIT_TABLE : ARKODE_DIRK_NONE,
                              implicit ? ARKODE_ERK_NONE : EXPLICIT_TABLE);
    bad |= ARKStepSetInterpolantType(s, ARK_INTERP_LAGRANGE);
    bad |= implicit ? set_up_stages(in) : 0;
    return bad == 0;
}

/* The stages of its steps. */
static ad_status start_clock(integration *in, ad_error *error)
{
    solve_clock *clock = in->clock;
    const ARKodeButcherTable table = in->table;
    clock->count = 0;
    clock->stages = 0;
    for (int i = 0; i < table->stages && i < EVENTS_STAGES_MAX; i++) {
        clock->at[i] = table->c[i];
        clock->weights[i] = table->b[i];
        clock->stages++;
    }
    return solve_clock_add(clock, 0, error);
}

static ad_status open_integration(integration *in, const integrate_settings *settings,
                                  ad_error *error)
{
    bool implicit = settings->method == INTEGRATE_IMPLICIT;
    ad_status status = AD_OK;
    size_t rows = motion_size(in->motion);
    if (SUNContext_Create(NULL, &in->context) != 0) {
        return ad_fail(error, AD_NO_MEMORY, "out of memory for SUNDIALS");
    }
    if (implicit) {
        status = motion_system_create(in->motion, in->context, &in->system, error);
    }
    if (status != AD_OK) {
        return status;
    }
    in->state = solve_vector_create(rows, in->context);
    in->sample = solve_vector_create(rows, in->context);
    in->table = implicit ? ARKodeButcherTable_LoadDIRK(IMPLICIT_TABLE)
                         : ARKodeButcherTable_LoadERK(EXPLICIT_TABLE);
    in->rows = malloc((implicit ? 1 : (EVENTS_STAGES_MAX + 1) * rows) * sizeof *in->rows);
    if (!in->state || !in->sample || !in->table || !in->rows || !solve_vectors_fit(rows)) {
        return ad_fail(error, AD_NO_MEMORY, "out of memory for SUNDIALS");
    }
    status = motion_initial(in->motion, N_VGetArrayPointer(in->state), error);
    if (status != AD_OK) {
        return status;
    }
    in->stepper =
        ARKStepCreate(implicit ? NULL : rate, implicit ? rate : NULL, 0, in->state, in->context);
    if (!in->stepper || !set_up(in, settings)) {
        return ad_fail(error, AD_NO_MEMORY, "out of memory for SUNDIALS");
    }
    if (settings->step > 0) {
        ARKStepSetFixedStep(in->stepper, settings->step);
        ARKStepSetMaxNonlinIters(in->stepper, 50); /* there is no shorter step to turn to */
    } else if (!implicit) { /* error control sees what grows only when it has grown */
        fastest *f = NULL;
        double frequency = 1;
        status = motion_fastest_create(in->motion, &f, error);
        status = status == AD_OK ? motion_fastest_at_start(f, &frequency, error) : status;
        motion_fastest_free(f);
        ARKStepSetMaxStep(in->stepper, 1 / motion_explicit_steps(frequency));
    }
    if (in->clock) {
        status = status == AD_OK ? start_clock(in, error) : status;
    }
    in->quadrature =
        solve_gauss_rule_of(implicit ? 3 : 2); /* explicit steps are small for stability */
    return status;
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

/* The work of a rest shape that jumps, of which its rate knows nothing: what the strain energy
 * changes by where the rod is, from in->time to t. */
static bool add_jump(integration *in, double t)
{
    double strain[2];
    for (int i = 0; i < 2; i++) {
        const double *state = state_at(in, t, true);
        if (!state || motion_at(in->motion, i ? t : in->time, &in->error) != AD_OK) {
            return false;
        }
        strain[i] = motion_energy_of(in->motion, state).strain;
    }
    in->work += strain[1] - strain[0];
    return true;
}

/* Work and dissipation from in->time to t, within the last step. */
static bool integrate_power(integration *in, double t)
{
    const solve_rod *rod = motion_rod(in->motion);
    const gauss_rule *rule = &in->quadrature;
    double length = t - in->time;
    bool jumps = rod->rest_moves && length > 0 && length <= EVENTS_JUMP * rod->duration;
    if (jumps && !add_jump(in, t)) {
        return false;
    }
    for (int i = 0; length > 0 && !jumps && i < rule->stages; i++) {
        const double *state = state_at(in, in->time + length * rule->nodes[i], true);
        if (!state) {
            return false;
        }
        motion_power power = motion_power_of(in->motion, state);
        in->work += length * rule->weights[i] * power.load;
        in->dissipated += length * rule->weights[i] * power.dissipation;
    }
    in->time = t;
    return true;
}

/* The state at t within the last explicit step, by a shorter one: what it does not resolve, no
 * interpolation has; NULL: see the error. */
static double *step_aside(integration *in, double t)
{
    const size_t rows = motion_size(in->motion);
    const ARKodeButcherTable by = in->table;
    double h = t - in->begun, *to = N_VGetArrayPointer(in->sample);
    for (int i = 0; i <= by->stages; i++) { /* the last is the end */
        const double *factors = i < by->stages ? by->A[i] : by->b;
        memcpy(to, in->rows, rows * sizeof *to);
        for (int j = 0; j < i; j++) {
            const double *stage = in->rows + (size_t)(j + 1) * rows;
            for (size_t k = 0; k < rows; k++) {
                to[k] += h * factors[j] * stage[k];
            }
        }
        double at = i < by->stages ? in->begun + by->c[i] * h : t;
        if (motion_at(in->motion, at, &in->error) != AD_OK) {
            return NULL;
        }
        if (i < by->stages) {
            motion_rate(in->motion, to, in->rows + (size_t)(i + 1) * rows);
        }
    }
    motion_prescribe(in->motion, to);
    return to;
}

static bool record(integration *in, double t, bool has_stepped, bool aside, double *to,
                   solve_energy *energy)
{
    const integration before = *in;
    if (has_stepped && !integrate_power(in, t)) {
        return false;
    }
    bool within = has_stepped && aside && !in->system;
    const double *state = within ? step_aside(in, t) : state_at(in, t, has_stepped);
    if (!state) {
        return false;
    }
    memcpy(to, state, motion_size(in->motion) * sizeof *to);
    motion_energy now = motion_energy_of(in->motion, state);
    double expected = in->initial + in->work - in->dissipated;
    *energy = (solve_energy){now.kinetic, now.strain, in->work, in->dissipated,
                             now.kinetic + now.strain - expected};
    if (aside) {
        in->work = before.work;
        in->dissipated = before.dissipated;
        in->time = before.time;
    }
    return true;
}

/* Before a step from t on. */
static void keep_state(integration *in, double t)
{
    const size_t rows = motion_size(in->motion);
    if (!in->system) {
        memcpy(in->rows, N_VGetArrayPointer(in->state), rows * sizeof *in->rows);
    }
    in->begun = t;
}

/* One step, which ends at the next event or at the end. */
static bool step(integration *in, double end, double *t)
{
    const solve_events *e = in->events;
    while (e && in->event < e->count && e->times[in->event] <= *t) {
        in->event++;
    }
    double stop = e && in->event < e->count ? fmin(end, e->times[in->event]) : end;
    return ARKStepSetStopTime(in->stepper, stop) >= 0 &&
           ARKStepEvolve(in->stepper, stop, in->state, t, ARK_ONE_STEP) >= 0 &&
           (!in->clock || solve_clock_add(in->clock, *t, &in->error) == AD_OK);
}

static bool run(integration *in, long steps_max, size_t count, const double *times, double *states,
                solve_energy *energies, double *t)
{
    size_t rows = motion_size(in->motion), done = 0;
    const double *initial = state_at(in, 0, false);
    if (!initial) {
        return false;
    }
    motion_energy at_start = motion_energy_of(in->motion, initial);
    in->initial = at_start.kinetic + at_start.strain;
    for (long steps = 0; true; steps++) {
        bool has_stepped = steps > 0;
        for (; done < count && times[done] <= *t; done++) {
            bool aside = done + 1 < count; /* no step stops there */
            if (!record(in, times[done], has_stepped, aside, states + done * rows,
                        energies + done)) {
                return false;
            }
        }
        if (done == count) {
            return true;
        }
        if (steps_max > 0 && steps == steps_max) {
            snprintf(in->error.message, sizeof in->error.message, "%ld steps", steps);
            return false;
        }
        if (has_stepped && !integrate_power(in, *t)) {
            return false;
        }
        keep_state(in, *t);
        if (!step(in, times[count - 1], t)) {
            return false;
        }
    }
}

static void count_work(const integration *in, integrate_counts *counts)
{
    ARKStepGetNumSteps(in->stepper, &counts->steps);
    ARKStepGetNumErrTestFails(in->stepper, &counts->failures);
    if (in->system) {
        ARKStepGetNumNonlinSolvIters(in->stepper, &counts->newton_steps);
        ARKStepGetNumLinSolvSetups(in->stepper, &counts->matrices);
    }
}

ad_status motion_integrate(motion *m, const integrate_settings *settings, size_t count,
                           const double *times, double *states, solve_energy *energies,
                           integrate_counts *counts, ad_error *error)
{
    integration in = {.motion = m,
                      .tolerance = settings->tolerance,
                      .events = settings->events,
                      .clock = settings->clock};
    *counts = (integrate_counts){0};
    ad_status status = open_integration(&in, settings, error);
    if (status == AD_OK &&
        !run(&in, settings->steps_max, count, times, states, energies, &counts->time)) {
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

double motion_explicit_steps(double frequency)
{
    const double stable = 3; /* eigenvalue times step, on the imaginary axis */
    return frequency / stable;
}
