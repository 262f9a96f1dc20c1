#include "tools/train/clock.h"

#include "physics/numerics/clock.h"

double train_seconds(void)
{
    return clock_seconds(CLOCK_MONOTONIC);
}

double train_processor_seconds(void)
{
    return clock_seconds(CLOCK_THREAD_CPUTIME_ID);
}
