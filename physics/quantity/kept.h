/* What follows from formulas and takes long to find is kept with the names they were read with: the
 * last few findings, each under all that it follows from, as bytes. Formulas are there as nodes,
 * which are each that of one formula as long as the names live. Any number of threads may do so. */
#ifndef PHYSICS_QUANTITY_KEPT_H
#define PHYSICS_QUANTITY_KEPT_H

#include "physics/quantity/quantity.h"

/* The names it was read with; NULL of a number. */
quantities *quantity_names(quantity q);

/* Keeps a copy of `size` bytes. AD_NO_MEMORY. */
ad_status quantities_keep(quantities *names, size_t key_size, const void *key, size_t size,
                          const void *found, ad_error *error);

/* A copy of what is kept under the same key, which the caller frees; NULL: nothing. AD_NO_MEMORY.
 */
ad_status quantities_recall(quantities *names, size_t key_size, const void *key, size_t *size,
                            void **found, ad_error *error);

#endif
