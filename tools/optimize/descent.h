/* A problem with constraints as IPOPT sees it, and its descent. */
#ifndef TOOLS_OPTIMIZE_DESCENT_H
#define TOOLS_OPTIMIZE_DESCENT_H

#include "autodiff/error.h"

#include <stdbool.h>
#include <stddef.h>

/* Numbers are of the order of 1. Arrays are borrowed; x_low, x_high [n], row_low, row_high [m] may
 * be infinite. */
typedef struct descent {
    size_t n, m;     /* variables, rows of constraints */
    size_t nonzeros; /* of the derivatives of rows */
    const double *x_low, *x_high, *row_low, *row_high;
    const int *row_of, *column_of; /* [nonzeros] places of derivatives */

    /* Writes, with derivatives, what follows at x; false: there is nothing. With a status in *why
     * it ends. */
    bool (*at)(void *of, const double *x);
    void *of;
    const double *value, *gradient, *row, *by; /* [1], [n], [m], [nonzeros] */
    const ad_error *why;

    double *x, *multiplier; /* [n], from where and where it ends; [m] */
} descent;

/* AD_NO_MEMORY; AD_BAD_ARGUMENT: built without IPOPT; *why. */
ad_status optimize_descent(const descent *of, int *steps, bool *converged, ad_error *error);

#endif
