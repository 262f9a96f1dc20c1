/* The laws at a point (physics/law/law.h) for lanes: lanes_law_tendon and so on. For functions that
 * are compiled FOR_EACH_PROCESSOR. */
#ifndef PHYSICS_LAW_LAWS_LANES_H
#define PHYSICS_LAW_LAWS_LANES_H

#include "physics/numerics/quaternion_lanes.h"

#include <math.h>

PROCESSOR_INLINE void lanes_sqrt(const lanes *x, lanes *root)
{
    lanes by;
    lanes_inverse_root(x, &by);
    *root = *x * by;
}

PROCESSOR_INLINE void lanes_exp(const lanes *x, lanes *result)
{
    for (int k = 0; k < LANES; k++) {
        (*result)[k] = exp((*x)[k]);
    }
}

PROCESSOR_INLINE void lanes_log(const lanes *x, lanes *result)
{
    for (int k = 0; k < LANES; k++) {
        (*result)[k] = log((*x)[k]);
    }
}

#define NUMBER         lanes
#define ALGEBRA(name)  lanes_##name
#define ALGEBRA_INLINE PROCESSOR_INLINE
#include "physics/law/law_functions.h"
#undef NUMBER
#undef ALGEBRA
#undef ALGEBRA_INLINE

#endif
