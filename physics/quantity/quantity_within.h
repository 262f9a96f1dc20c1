/* Formulas that know another's names. */
#ifndef PHYSICS_QUANTITY_QUANTITY_WITHIN_H
#define PHYSICS_QUANTITY_QUANTITY_WITHIN_H

#include "physics/quantity/quantity.h"

/* As quantities_create_open, for formulas that also know the tables of another and those of its
 * names that are numbers, unless they have a name like it. It outlives them; NULL: none. NULL when
 * memory runs out. */
quantities *quantities_create_within(const quantities *outer);

#endif
