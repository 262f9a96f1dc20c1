#include "optim.h"

#include <math.h>

optim_schedule optim_schedule_defaults(void)
{
    return (optim_schedule){.kind = OPTIM_SCHEDULE_CONSTANT,
                            .learning_rate = 1e-3,
                            .warmup_steps = 0,
                            .decay_steps = 1000,
                            .final_fraction = 0.01,
                            .decay_factor = 0.9};
}

/* Conditions are written so that a NaN fails them. */
const char *optim_schedule_check(const optim_schedule *schedule)
{
    if ((unsigned)schedule->kind >= OPTIM_SCHEDULE_COUNT) {
        return "schedule kind must be constant, cosine or exponential";
    }
    if (!(schedule->learning_rate > 0 && isfinite(schedule->learning_rate))) {
        return "learning_rate must be finite and > 0";
    }
    if (schedule->warmup_steps < 0) {
        return "warmup_steps must be >= 0";
    }
    if (schedule->decay_steps < 1) {
        return "decay_steps must be >= 1";
    }
    if (!(schedule->final_fraction >= 0 && schedule->final_fraction <= 1)) {
        return "final_fraction must be in [0, 1]";
    }
    if (!(schedule->decay_factor > 0 && schedule->decay_factor <= 1)) {
        return "decay_factor must be in (0, 1]";
    }
    return NULL;
}

double optim_schedule_rate(const optim_schedule *schedule, int64_t step)
{
    const double pi = 3.14159265358979323846;
    step = step > 0 ? step : 0;
    if (step < schedule->warmup_steps) {
        return schedule->learning_rate * ((double)step + 1) / ((double)schedule->warmup_steps + 1);
    }
    const double progress = (double)(step - schedule->warmup_steps) / (double)schedule->decay_steps;
    double fraction = 1;
    if (schedule->kind == OPTIM_SCHEDULE_COSINE) {
        const double wave = 0.5 * (1 + cos(pi * fmin(progress, 1)));
        fraction = schedule->final_fraction + (1 - schedule->final_fraction) * wave;
    } else if (schedule->kind == OPTIM_SCHEDULE_EXPONENTIAL) {
        fraction = pow(schedule->decay_factor, progress);
    }
    return schedule->learning_rate * fraction;
}
