#include "physics/solve/motion_compose.h"

#include "physics/solve/motion_fastest.h"

#include <math.h>
#include <stdlib.h>

/* Kicks and drifts in turn, kicks first and last, as parts of a step; the second half mirrors the
 * first. */
enum { KICKS = 7 };
static const double KICK[4] = {0.0829844064174052, 0.396309801498368, -0.0390563049223486,
                               0.119524194012151 /* 1 - 2 (the others) */};
static const double DRIFT[3] = {0.245298957184271, 0.604872665711080,
                                -0.350171622895351 /* 1/2 - the others */};

/* Frequency times step of the fastest vibration. The method is stable up to 5; vibrations that the
 * mesh resolves, with five nodes to a wave or more, are below a fifth of it, and their frequencies
 * off by 2e-5 at most. After blows that excite all of them errors with 2.5 are the same. Large
 * motions gain energy with 4, 10 % in 50,000 steps of a tumbling rod; with 3.4 they stay within
 * 0.5 %. */
static const double LONGEST = 3.4;

/* After so many steps the fastest vibration is looked at again. */
enum { LOOK_AGAIN = 512 };

typedef struct composition {
    motion *motion;
    fastest *fastest;
    double *state; /* [nodes][MOTION_ROWS] */
    double frequency;
    long looked;                      /* the step at which it was last looked at */
    double longest;                   /* step; 0: by frequency */
    double varying;                   /* no longer than this either, between these events */
    double initial, work, dissipated; /* energy */
    double t;
    long steps, steps_max;
    bool is_driven;     /* what is prescribed may move: kicks and drifts do not see its work */
    double power;       /* then, now */
    double *kept;       /* the nodes, while steps go aside */
    size_t count, next; /* times, and which comes next */
    const double *times;
    double *states;
    solve_energy *energies;
    const solve_events *events; /* NULL: none */
    size_t event;               /* which comes next */
    solve_clock *clock;         /* NULL: none */
} composition;

/* ---- one step ------------------------------------------------------------------------------ */

static double drift_of(int i)
{
    return DRIFT[i < 3 ? i : 5 - i];
}

static double kick_of(int i)
{
    return KICK[i < 4 ? i : 6 - i];
}

/* From in->t to t, by h. The last kick of a step before of length `behind` joins the first, and the
 * last is left to the next step when `joins`. */
static ad_status step(composition *in, double h, double t, double behind, bool joins,
                      ad_error *error)
{
    double at = 0, work = 0;
    ad_status status = AD_OK;
    for (int i = 0; i < KICKS - joins && status == AD_OK; i++) {
        bool is_first = i == 0, is_last = i == KICKS - 1;
        bool slows = i == KICKS / 2 && motion_rod(in->motion)->along.by_velocity;
        double before = is_first ? behind * drift_of(5) : h * drift_of(i - 1);
        double after = is_last ? 0 : drift_of(i);
        double kick = kick_of(i) * (is_first ? h + behind : h);
        in->dissipated += slows ? motion_resist(in->motion, 0.5 * h) : 0;
        work += motion_kick(in->motion, kick, before, h * after);
        in->dissipated += slows ? motion_resist(in->motion, 0.5 * h) : 0;
        if (!is_last) {
            at += after;
            status =
                motion_drift(in->motion, h * after, i == KICKS - 2 ? t : in->t + at * h, error);
        }
    }
    in->work += in->is_driven ? 0 : work;
    in->t = t;
    in->steps++;
    return status == AD_OK && in->clock ? solve_clock_add(in->clock, t, error) : status;
}

/* What is prescribed does work that is integrated from the ends of steps. */
static void add_driven_work(composition *in, double h)
{
    double power = motion_power_now(in->motion).load;
    in->work += 0.5 * h * (in->power + power);
    in->power = power;
}

/* ---- through time -------------------------------------------------------------------------- */

/* A rest shape that jumps between in->t and t changes the strain energy where the rod is. */
static ad_status add_jump(composition *in, double t, ad_error *error)
{
    double before = motion_energy_now(in->motion).strain;
    ad_status status = motion_at(in->motion, t, error);
    in->work += motion_energy_now(in->motion).strain - before;
    return status == AD_OK ? motion_at(in->motion, in->t, error) : status;
}

static ad_status look(composition *in, ad_error *error)
{
    motion_finish(in->motion, in->state);
    double now = motion_fastest_at(in->fastest, in->state, in->steps == 0 ? 20 : 3);
    motion_start(in->motion, in->state);
    in->frequency = fmax(in->frequency, now);
    in->looked = in->steps;
    return isfinite(now) ? AD_OK
                         : ad_fail(error, AD_NOT_FINITE, "accelerations are not finite numbers");
}

/* What is found at the next of the times. */
static ad_status record(composition *in, ad_error *error)
{
    motion_energy now = motion_energy_now(in->motion);
    motion_finish(in->motion, in->states + in->next * motion_nodes(in->motion) * MOTION_ROWS);
    double mismatch = now.kinetic + now.strain - (in->initial + in->work - in->dissipated);
    in->energies[in->next++] =
        (solve_energy){now.kinetic, now.strain, in->work, in->dissipated, mismatch};
    return isfinite(mismatch) /* nor its work */
               ? AD_OK
               : ad_fail(error, AD_NOT_FINITE, "the energy is not a finite number");
}

/* To times that come before `stop`, by steps that are taken back. */
static ad_status look_aside(composition *in, double behind, double stop, ad_error *error)
{
    ad_status status = AD_OK;
    while (status == AD_OK && in->next + 1 < in->count && in->times[in->next] < stop) {
        const composition before = *in;
        double t = in->times[in->next], h = t - in->t;
        motion_keep(in->motion, in->kept);
        in->clock = NULL;
        status = step(in, h, t, behind, false, error);
        if (in->is_driven && status == AD_OK) {
            add_driven_work(in, h);
        }
        status = status == AD_OK ? record(in, error) : status;
        *in = before;
        in->next++;
        status = status == AD_OK ? motion_take_back(in->motion, in->kept, in->t, error) : status;
    }
    return status;
}

/* At most LOOK_AGAIN equal steps towards `stop`, which is later. */
static ad_status advance(composition *in, double stop, ad_error *error)
{
    bool is_due = in->steps == 0 || in->steps - in->looked >= LOOK_AGAIN;
    ad_status status = is_due ? look(in, error) : AD_OK;
    double longest = LONGEST / in->frequency, from = in->t, left = stop - from;
    longest = in->longest > 0 ? fmin(longest, in->longest) : longest;
    longest = fmin(longest, in->varying);
    double needed = fmax(1, ceil(left / longest - 1e-9)), h = left / needed;
    long count = needed < LOOK_AGAIN ? (long)needed : LOOK_AGAIN;
    in->power = in->is_driven ? motion_power_now(in->motion).load : 0;
    for (long i = 0; i < count && status == AD_OK; i++) {
        bool joins = !in->is_driven && i + 1 < count;
        double behind = !in->is_driven && i > 0 ? h : 0;
        double to = (double)(i + 1) == needed ? stop : from + h * (double)(i + 1);
        status = look_aside(in, behind, to, error);
        status = status == AD_OK ? step(in, h, to, behind, joins, error) : status;
        if (in->is_driven && status == AD_OK) {
            add_driven_work(in, h);
        }
    }
    return status;
}

static ad_status go_to(composition *in, double stop, ad_error *error)
{
    const solve_rod *rod = motion_rod(in->motion);
    ad_status status = AD_OK;
    if (rod->rest_moves && stop > in->t && stop - in->t <= EVENTS_JUMP * rod->duration) {
        status = add_jump(in, stop, error);
        double work = in->work;
        status = status == AD_OK ? advance(in, stop, error) : status;
        in->work = work;
    }
    while (status == AD_OK && in->t < stop) {
        status = in->steps_max > 0 && in->steps >= in->steps_max
                     ? ad_fail(error, AD_NOT_FINITE, "%ld steps", in->steps)
                     : advance(in, stop, error);
    }
    return status;
}

/* How long steps may be for what acts, which changes between two events in a way that some steps
 * have to see: more of them on a finer mesh, so that what they miss shows as a difference. */
static void find_varying(composition *in)
{
    const solve_rod *rod = motion_rod(in->motion);
    const solve_events *e = in->events;
    double from = in->event > 0 ? e->times[in->event - 1] : 0;
    double to = e && in->event < e->count ? e->times[in->event] : rod->duration;
    bool varies = e && e->drives->count > 0;
    bool jumps = to - from <= EVENTS_JUMP * rod->duration;
    double steps = 0.5 * (double)motion_nodes(in->motion);
    in->varying = varies && !jumps ? (to - from) / steps : INFINITY;
}

/* To the last of the times; the others are looked at on the way. */
static ad_status run(composition *in, ad_error *error)
{
    const solve_events *e = in->events;
    const double end = in->count > 0 ? in->times[in->count - 1] : 0;
    ad_status status = AD_OK;
    find_varying(in);
    while (status == AD_OK && e && in->event < e->count && e->times[in->event] < end) {
        status = go_to(in, e->times[in->event], error);
        in->event++;
        find_varying(in);
    }
    status = status == AD_OK ? go_to(in, end, error) : status;
    while (in->next < in->count && status == AD_OK) { /* those that are the same */
        status = record(in, error);
    }
    return status;
}

/* ---- making and freeing -------------------------------------------------------------------- */

/* Kicks are where forces are asked for. */
static ad_status start_clock(solve_clock *clock, ad_error *error)
{
    double at = 0;
    _Static_assert((int)KICKS <= (int)EVENTS_STAGES_MAX, "a step's kicks");
    clock->count = 0;
    clock->stages = KICKS;
    for (int i = 0; i < KICKS; i++) {
        clock->at[i] = at;
        clock->weights[i] = kick_of(i);
        at += i + 1 < KICKS ? drift_of(i) : 0;
    }
    return solve_clock_add(clock, 0, error);
}

static ad_status open_composition(composition *in, ad_error *error)
{
    const solve_rod *rod = motion_rod(in->motion);
    in->is_driven = rod->rest_moves || rod->actuators > 0;
    for (int end = 0; end < 2; end++) {
        in->is_driven |= solve_end_is_driven(&rod->ends[end]);
    }
    in->state = malloc(motion_nodes(in->motion) * MOTION_ROWS * sizeof *in->state);
    in->kept = malloc(motion_kept_size(in->motion) * sizeof *in->kept);
    ad_status status =
        in->state && in->kept ? AD_OK : ad_fail(error, AD_NO_MEMORY, "out of memory");
    if (status == AD_OK) {
        status = motion_fastest_create(in->motion, &in->fastest, error);
    }
    if (status == AD_OK && in->clock) {
        status = start_clock(in->clock, error);
    }
    if (status == AD_OK) {
        status = motion_initial(in->motion, in->state, error);
    }
    if (status == AD_OK) {
        status = motion_at(in->motion, 0, error);
    }
    if (status == AD_OK) {
        motion_start(in->motion, in->state);
        motion_energy energy = motion_energy_now(in->motion);
        in->initial = energy.kinetic + energy.strain;
    }
    return status;
}

ad_status motion_compose(motion *m, const integrate_settings *settings, size_t count,
                         const double *times, double *states, solve_energy *energies,
                         integrate_counts *counts, ad_error *error)
{
    composition in = {.motion = m,
                      .longest = settings->step,
                      .steps_max = settings->steps_max,
                      .events = settings->events,
                      .clock = settings->clock,
                      .count = count,
                      .times = times,
                      .states = states,
                      .energies = energies};
    ad_error cause = {.message = ""};
    ad_status status = open_composition(&in, &cause);
    status = status == AD_OK ? run(&in, &cause) : status;
    if (status != AD_OK) {
        ad_fail(error, status, "time integration stopped at t = %g of %g: %s", in.t,
                count > 0 ? times[count - 1] : 0, cause.message);
    }
    *counts = (integrate_counts){.steps = in.steps, .time = in.t};
    motion_fastest_free(in.fastest);
    free(in.state);
    free(in.kept);
    return status;
}

double motion_compose_steps(double frequency)
{
    return frequency / LONGEST;
}
