/* Columns of a motion (model_motion), which is computed and not recorded, for an evaluator: in each
 * window polynomials of s, in pieces, and t through their values at Chebyshev's points. Not for
 * callers of the library. */
#ifndef PHYSICS_LEARN_EVALUATOR_TABLE_H
#define PHYSICS_LEARN_EVALUATOR_TABLE_H

#include "physics/learn/evaluator.h"

/* Numbers of a window of so many columns. */
size_t evaluator_table_numbers(const physics_model *m, int columns);

/* table [windows][numbers] of the columns which [columns] of the model. AD_NO_MEMORY, errors of the
 * motion. */
ad_status evaluator_table_fill(const evaluator_model *model, int columns, const int *which,
                               ad_pool *pool, double *table, ad_error *error);

/* On the tape: values [columns] rows, from the numbers of the place's window. */
ad_value evaluator_table_record(const physics_model *m, int columns, const domain_place *at,
                                ad_value numbers);

#endif
