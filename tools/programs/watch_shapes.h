/* What a network in training says of the rod's shape: at rest one shape, in motion those of several
 * instants, of a family those of several members, spread over the ranges of its parameters. */
#ifndef TOOLS_PROGRAMS_WATCH_SHAPES_H
#define TOOLS_PROGRAMS_WATCH_SHAPES_H

#include "tools/programs/shape_views.h"
#include "tools/train/trainer.h"

typedef struct watch_shapes watch_shapes;

/* Of an experiment in training, with the shape that is known, if any; both outlive it. NULL: out of
 * memory. */
watch_shapes *watch_shapes_create(const experiment *e, const reference *known);
void watch_shapes_free(watch_shapes *w); /* NULL is allowed */

/* As they are now; does not touch what the trainer computes with. Where that fails, or memory
 * lacks, there are none. */
void watch_shapes_update(watch_shapes *w, trainer *t);

/* Those of the last update, in that part of the canvas, and a line about them. */
void watch_shapes_draw(const watch_shapes *w, canvas *c, int column, int row, int columns,
                       int rows);

#endif
