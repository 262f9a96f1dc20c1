/* The algebra of quaternion.h on LANES of them side by side: a vector is lanes [3], a quaternion
 * lanes [4]. For functions that are compiled FOR_EACH_PROCESSOR. */
#ifndef PHYSICS_SOLVE_LANES_H
#define PHYSICS_SOLVE_LANES_H

#include "physics/solve/processor.h"

#define NUMBER         lanes
#define ALGEBRA(name)  lanes_##name
#define ALGEBRA_INLINE PROCESSOR_INLINE
#include "physics/quaternion_algebra.h"
#undef NUMBER
#undef ALGEBRA
#undef ALGEBRA_INLINE

#endif
