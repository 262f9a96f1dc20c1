/* What inputs with a memory (physics/scene/scene_memory.h) were before measured rows, at trial
 * values of unknowns; of scenes without them nothing. Not for callers of measured.h. */
#ifndef PHYSICS_SOLVE_MEASURED_MEMORY_H
#define PHYSICS_SOLVE_MEASURED_MEMORY_H

#include "physics/solve/measured.h"

typedef struct trial_memory trial_memory;

/* *result: NULL where the scene remembers nothing; the scene must outlive it. AD_NO_MEMORY. */
ad_status trial_memory_create(const scene *open, int sets, const solve_measured *measured,
                              trial_memory **result, ad_error *error);
void trial_memory_free(trial_memory *memory); /* NULL is allowed, here and below */

/* The turn of a row of a set, counted over all sets: of rows in turn with the same command it is
 * one. For all rows of one set after the other, in their order; 0 without a memory. */
size_t trial_memory_turn(trial_memory *memory, int set, size_t row);

/* Follows all turns at values [trials][unknowns], which must stay until the next call; where
 * slopes are wanted, with how states change with the unknowns. AD_NO_MEMORY. */
ad_status trial_memory_follow(trial_memory *memory, size_t trials, const double *values,
                              bool slopes, ad_error *error);

/* Writes the states before a turn among the parameters [parameter_count], for `values` one of those
 * trials. */
void trial_memory_fill(const trial_memory *memory, const double *values, size_t turn,
                       double *parameters);

/* The derivative of a column by a parameter, of its derivatives by each [parameter_count] at fixed
 * states: with these. */
double trial_memory_change(const trial_memory *memory, size_t turn, size_t parameter,
                           const double *column);

#endif
