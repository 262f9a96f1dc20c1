/* Sampling in place of derivatives: a controller_method that weighs many random plans by what they
 * cost (model predictive path integral control: Williams, Aldrich, Theodorou 2017), for costs
 * that derivatives do not describe, and as a yardstick. Plans are steps of the model for
 * all samples at once; its derivatives are not needed. Seeded: the same calls give the same bits.
 */
#ifndef CONTROL_MPPI_H
#define CONTROL_MPPI_H

#include "tools/control/controller.h"

#include <stdint.h>

#ifdef __cplusplus
extern "C" {
#endif

extern const controller_method controller_sampling;

typedef struct mppi_settings {
    int samples;        /* plans; 0: 256 */
    int batch;          /* states that the model is given at once; 0: samples */
    double temperature; /* of exp(-cost/temperature), in spreads of the costs; 0: 0.01 */
    double noise;       /* standard deviation of the inputs, in parts of their span; 0: 0.05 */
    double memory;      /* within 0 and 1, of noise from one move to the next; 0: 0.8 */
    double shrink;      /* of noise from one iteration of a feedback to the next; 0: 0.9 */
    uint64_t seed;
} mppi_settings;

#ifdef __cplusplus
}
#endif

#endif
