/* What the files of a residual share; not for others. */
#ifndef CONTROL_RESIDUAL_INTERNAL_H
#define CONTROL_RESIDUAL_INTERNAL_H

#include "tools/control/residual.h"

struct residual {
    one_step of;
    size_t states, inputs, units, seen; /* seen: by the network */
    double *size, *middle, *half;       /* D, c, C; one after the other */
    double *numbers;
    double *z, *t; /* [states + inputs], [units] */
};

#endif
