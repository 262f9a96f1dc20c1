#include "tools/programs/control_judge.h"

#include <math.h>
#include <stdio.h>

/* Standard deviations from the truth by which an estimate is remarked on. */
static const double ESTIMATE_OFF = 5;

void control_judge(const control_settings *c, const loop_report *r, verdict *to)
{
    char reach[80] = "";
    if (r->reach > c->tolerance_rms) {
        snprintf(reach, sizeof reach, "; at rest it comes no nearer than %.2g mm rms",
                 1e3 * r->reach);
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
