/* The algebra of quaternion.h on LANES of them side by side: a vector is lanes [3], a
 * quaternion lanes [4]. For functions that are compiled FOR_EACH_PROCESSOR. */
#ifndef PHYSICS_NUMERICS_QUATERNION_LANES_H
#define PHYSICS_NUMERICS_QUATERNION_LANES_H

#include "physics/numerics/processor.h"

typedef long long integer_lanes
    __attribute__((vector_size(LANES * sizeof(long long)), aligned(sizeof(double)), may_alias));

/* 1/sqrt(x) of x > 0, to rounding, and a finite number at 0: Newton's method from a guess by the
 * exponent (Lomont, 2003), as the compiler makes no vectors of sqrt. */
PROCESSOR_INLINE void lanes_inverse_root(const lanes *x, lanes *root)
{
    const integer_lanes guess = 0x5fe6eb50c7b537a9LL - ((integer_lanes)*x >> 1);
    lanes y = (lanes)guess;
    for (int i = 0; i < 5; i++) {
        y = y * (1.5 - 0.5 * *x * y * y);
    }
    *root = y;
}

#define ALGEBRA_NUMBER lanes
#define ALGEBRA(name)  lanes_##name
#define ALGEBRA_INLINE PROCESSOR_INLINE
#include "physics/numerics/quaternion_algebra.h"
#include "physics/numerics/vector_algebra.h"
#undef ALGEBRA_NUMBER
#undef ALGEBRA
#undef ALGEBRA_INLINE

#endif
