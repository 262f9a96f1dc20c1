/* Some values of several looks as one look: the place that follows a path and numbers that are kept
 * in a range. Needs no library and allocates nothing: exported C has this very text. */
#ifndef CONTROL_VIEW_H
#define CONTROL_VIEW_H

#include "physics/solve/one_step.h"

#include <stddef.h>

#ifdef __cplusplus
extern "C" {
#endif

enum { VIEW_PARTS_MAX = 16 };

typedef struct view {
    int parts, inputs; /* of the model */
    struct view_part {
        one_look look;    /* context borrowed; all have the same states */
        int first, count; /* of its values, those that are taken */
    } part[VIEW_PARTS_MAX];
    double *room; /* [view_room] */
} view;

size_t view_room(const view *view);

/* Borrows x, which is for one call at a time. */
one_look view_of(view *view);

#ifdef __cplusplus
}
#endif

#endif
