#include "tools/programs/control_judge.h"

#include <math.h>
#include <stdio.h>

/* Standard deviations from the truth by which an estimate is remarked on. */
static const double ESTIMATE_OFF = 5;

/* Of their ranges, by which inputs go to and fro in a sample. Twelve robots with 1 to 9 actuators
 * have 0.01 % to 0.9 % by default, and up to 6 % with weights of changes that are too small. */
static const double JITTER = 0.03;

/* Part of the filter's windows that may be beyond a bound. By chance it is 0.1 %, of which windows
 * that overlap come together; half and more where a model is off. That much shows in long windows
 * what is far below the noise, so what the model leaves out is to be this many times what it was
 * said to: 1 to 1.6 of robots with modes enough, 3 without those of shear, and 7 to 40 of those
 * with weak or leaking chambers, another damping or a load that nobody knows. */
static const double BEYOND = 0.1, DOUBT = 2;

static void judge_innovations(const loop_report *r, verdict *to)
{
    static const char *const words[LOOP_BOUNDS] = {
        "are larger than they may be", "have a mean that is not 0", "follow from those before"};
    int worst = 0;
    for (int k = 1; k < LOOP_BOUNDS; k++) {
        worst = r->beyond[k] > r->beyond[worst] ? k : worst;
    }
    if (r->beyond[worst] > BEYOND && r->doubt > DOUBT) {
        verdict_add(
            to, VERDICT_INNOVATIONS,
            "in %.3g %% of their windows innovations %s (mean square %.3g %%, bias %.3g %%, "
            "correlation %.3g %%): the robot or its sensors are not as the model says, or its "
            "modes "
            "are too few (surrogate.tolerance, surrogate.modes); deviations of what is estimated "
            "are taken %.2g times",
            100 * r->beyond[worst], words[worst], 100 * r->beyond[LOOP_SQUARE],
            100 * r->beyond[LOOP_BIAS], 100 * r->beyond[LOOP_CORRELATION], r->doubt);
    }
}

/* Times the largest deviation where a residual was trained. That of soft_arm_residual.yaml has 1.4
 * in other motions of that size and speed, 2 in those that are half as fast again, and 4 in circles
 * half as large again. */
static const double REACH = 2;

void control_judge_residual(const residual_reach *reach, const char *of, verdict *to)
{
    if (reach->most > REACH * reach->trained) {
        verdict_add(to, VERDICT_OUTSIDE_DATA,
                    "%s: the learned residual is beyond what it was trained on: what is not known "
                    "of it moves the place by up to %.3g mm, and %.3g mm in its training",
                    of, 1e3 * reach->most, 1e3 * reach->trained);
    }
}

void control_residual_json(const residual_reach *reach, json *to)
{
    if (isnan(reach->most)) {
        json_null(to, "residual");
        return;
    }
    json_open(to, "residual", '{');
    json_number(to, "deviation", reach->most);
    json_number(to, "trained_deviation", reach->trained);
    json_close(to, '}');
}

void control_judge(const control_settings *c, const loop_report *r, verdict *to)
{
    char reach[100] = "";
    control_judge_residual(&r->residual, "loop", to);
    if (r->reach > c->tolerance_rms || r->reach_worst > c->tolerance_worst) {
        snprintf(reach, sizeof reach,
                 "; at rest it comes no nearer than %.2g mm rms, and %.2g mm at most",
                 1e3 * r->reach, 1e3 * r->reach_worst);
    }
    if (r->diverged) {
        verdict_add(to, VERDICT_DIVERGED,
                    "the robot was a length off the path, or its simulation failed, %.4g s after "
                    "the start%s",
                    (double)r->done * c->period, reach);
    } else if (r->rms > c->tolerance_rms || r->worst > c->tolerance_worst) {
        verdict_add(to, VERDICT_NOT_HELD,
                    "the place is off the path by %.3g mm rms and at most %.3g mm; allowed by "
                    "control.tolerance: %.3g and %.3g mm%s",
                    1e3 * r->rms, 1e3 * r->worst, 1e3 * c->tolerance_rms, 1e3 * c->tolerance_worst,
                    reach);
    }
    double kept = INFINITY; /* from the surface */
    for (int i = 0; i < c->limit_count; i++) {
        const double left = c->limits[i].low - r->violation[i];
        kept = c->limits[i].what == CONTROL_CLEARANCE && left >= 0 ? left : kept;
        if (c->limits[i].what == CONTROL_CLEARANCE && left < 0) {
            verdict_add(to, VERDICT_NOT_HELD,
                        "the robot touches the surface, %.2g mm beyond it at most: it was not "
                        "where the filter believed (control.estimate finds what is not known), or "
                        "the inputs cannot keep it away",
                        -1e3 * left);
        }
    }
    if (r->modes > c->tolerance_rms || r->modes_worst > fmin(c->tolerance_worst, kept)) {
        verdict_add(to, VERDICT_ESTIMATE_ABOVE_TOLERANCE,
                    "%d, %d, %d, %d modes of the simulated robot leave out %.2g mm rms of where it "
                    "is, and at most %.2g mm%s; try more (control.plant.modes)",
                    c->plant_modes[0], c->plant_modes[1], c->plant_modes[2], c->plant_modes[3],
                    1e3 * r->modes, 1e3 * r->modes_worst,
                    r->modes_worst > kept ? ", which is more than it keeps from the surface" : "");
    }
    if (isnan(r->modes) && !r->diverged) {
        verdict_add(to, VERDICT_ERROR_UNKNOWN,
                    "what the modes of the simulated robot leave out is not known: one with one "
                    "more of each does not follow the inputs; try more (control.plant.modes)");
    }
    if (r->jitter > JITTER) {
        verdict_add(to, VERDICT_CHATTERS,
                    "inputs go to and fro by %.2g %% of their ranges a sample (they change by "
                    "%.3g %%, at most by %.3g %%); a larger control.weights.rate calms them",
                    100 * r->jitter, 100 * r->change[0], 100 * r->change[1]);
    }
    judge_innovations(r, to);
    for (int i = 0; i < c->estimate_count; i++) {
        const double off = fabs(r->estimate[i] - r->truth[i]);
        if (off > ESTIMATE_OFF * r->deviation[i]) {
            verdict_add(to, VERDICT_ESTIMATE_OFF,
                        "%.60s is found as %.4g, %.2g standard deviations off the truth, %.4g: the "
                        "robot differs from the model in something else",
                        c->estimate[i], r->estimate[i], off / r->deviation[i], r->truth[i]);
        }
    }
}
