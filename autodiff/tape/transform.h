/* What the transforms (taylor.c, reverse.c, substitute.c) share: each takes a tape and appends to
 * it, in terms of the table's rules. Private to autodiff. */
#ifndef AD_TRANSFORM_H
#define AD_TRANSFORM_H

#include "autodiff/tape/tape.h"

/* For ids below `count`, grown on demand: does the node depend on the marked ones? */
typedef struct dependence {
    ad_tape *tape;
    bool *on; /* freed by whoever made the struct */
    int count, capacity;
} dependence;

bool ad_dependence_extend(dependence *d); /* to the nodes there are now; false: out of memory */
void ad_dependence_mark(dependence *d, int id); /* and what is known to depend on it */

ad_value ad_transform_zeros(ad_value y); /* of its rows */

/* The operation of y on arguments given in place of its own. */
ad_value ad_transform_apply(ad_value y, const ad_value *arguments);

/* Is x a value of this tape, and the tape without error? If not, the tape knows. */
bool ad_transform_usable(ad_value x, const char *what, ad_tape *tape);

/* The same, and is x a leaf? Simplification may look through any operation, so only leaves are
 * certain to be seen. */
bool ad_transform_variable(ad_value x, const char *what, ad_tape *tape);

/* What a transform returns when it fails: values that may be passed on but compute nothing. */
void ad_transform_fail(ad_tape *tape, int count, ad_value *values);

#endif
