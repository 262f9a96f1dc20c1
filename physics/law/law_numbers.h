/* The laws at a point (physics/law/law.h) for plain numbers: law_tendon and so on. */
#ifndef PHYSICS_LAW_LAW_NUMBERS_H
#define PHYSICS_LAW_LAW_NUMBERS_H

#include <math.h>

#ifndef LAWS_INLINE
#define LAWS_INLINE static inline __attribute__((unused))
#endif

static inline void number_sqrt(const double *x, double *root)
{
    *root = sqrt(*x);
}

static inline void number_inverse_root(const double *x, double *root)
{
    *root = *x > 0 ? 1 / sqrt(*x) : 0;
}

static inline void number_exp(const double *x, double *result)
{
    *result = exp(*x);
}

static inline void number_log(const double *x, double *result)
{
    *result = log(*x);
}

#define NUMBER         double
#define ALGEBRA(name)  number_##name
#define ALGEBRA_INLINE LAWS_INLINE
#include "physics/law/law_functions.h"
#undef NUMBER
#undef ALGEBRA
#undef ALGEBRA_INLINE

#endif
