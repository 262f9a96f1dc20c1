/* Values of s and t as solvers want them: recorded on the tape, compiled, evaluated at points. */
#ifndef PHYSICS_LOCAL_FORMULA_H
#define PHYSICS_LOCAL_FORMULA_H

#include "autodiff/ad.h"

typedef struct formula formula;

/* `value` depends on two inputs of one row, s and then t, and where `more` is not 0 on a third of
 * so many rows. Borrows the pool. What the tape says of the value, AD_NO_MEMORY. */
ad_status solve_formula_create(ad_value value, int more, ad_pool *pool, formula **result,
                               ad_error *error);
void solve_formula_free(formula *f);

/* out [n][rows of the value] at s [n] and t. Allocates only when n grows; one thread at a time. */
ad_status solve_formula_evaluate(formula *f, size_t n, const double *s, double t, double *out,
                                 ad_error *error);

/* The same with the third input [n][more]; NULL where it has none. */
ad_status solve_formula_evaluate_of(formula *f, size_t n, const double *s, double t,
                                    const double *third, double *out, ad_error *error);

#endif
