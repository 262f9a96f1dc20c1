/* Inputs over time: of a scene in motion, known parameters that have several values in rows of a
 * file whose times ascend. Such rows are one recording; the next begins where t falls. Rows of one
 * instant with different values are no recording, but several experiments. */
#ifndef TOOLS_TRAIN_RECORDED_INPUTS_H
#define TOOLS_TRAIN_RECORDED_INPUTS_H

#include "physics/scene/scene.h"
#include "physics/solve/recording.h"

typedef struct recorded_inputs recorded_inputs;

ad_status recorded_inputs_create(recorded_inputs **result, ad_error *error); /* AD_NO_MEMORY */
void recorded_inputs_free(recorded_inputs *inputs);                          /* NULL is allowed */

/* The recordings of a file, t [rows] s and known [parameters][rows], NULL of those that the file
 * does not say. of [rows]: the inputs over time that each row has, NULL: none; they live as long as
 * `inputs`, and are the same of all lists that have the same file. AD_BAD_INPUT: they begin after
 * t = 0, or have a row without a number; the error names the row. AD_NO_MEMORY. */
ad_status recorded_inputs_find(recorded_inputs *inputs, const scene *open, const char *path,
                               size_t rows, const double *t, const double *const *known,
                               const solve_inputs **of, ad_error *error);

#endif
