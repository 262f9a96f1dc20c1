/* How long things take; for reports and time limits only, never in numerics. */
#ifndef TOOLS_TRAIN_CLOCK_H
#define TOOLS_TRAIN_CLOCK_H

/* Seconds since a moment fixed while the machine runs; never goes back. */
double train_seconds(void);

/* Seconds for which the processor has worked for this thread. */
double train_processor_seconds(void);

#endif
