#include "methods.h"

#include <math.h>

const char *const *optim_schedule_names(void)
{
#define NAME(code, name) name,
    static const char *const names[] = {OPTIM_SCHEDULE_LIST(NAME) NULL};
#undef NAME
    return names;
}

double optim_schedule_rate(const optim_settings *settings, int64_t step)
{
    const double pi = 3.14159265358979323846;
    step = step > 0 ? step : 0;
    if (step < settings->warmup_steps) {
        return settings->learning_rate * ((double)step + 1) / ((double)settings->warmup_steps + 1);
    }
    const double progress = (double)(step - settings->warmup_steps) / (double)settings->decay_steps;
    double fraction = 1;
    if (settings->schedule == OPTIM_SCHEDULE_COSINE) {
        const double wave = 0.5 * (1 + cos(pi * fmin(progress, 1)));
        fraction = settings->final_fraction + (1 - settings->final_fraction) * wave;
    } else if (settings->schedule == OPTIM_SCHEDULE_EXPONENTIAL) {
        fraction = pow(settings->decay_factor, progress);
    }
    return settings->learning_rate * fraction;
}
