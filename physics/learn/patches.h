/* Own equations solved by networks in patches of space and time.
 *
 * The domain is divided into boxes. In each a network without hidden layers, whose functions are
 * products of Legendre polynomials of the coordinates in the box, stands for every field. So one is
 * smooth in every patch, and a front is followed by small patches. The tape differentiates the
 * residuals of the model by all derivatives of the fields, and Gauss-Newton steps make their
 * squares least. Conditions, and what joins patches (values, and slopes below the order of the
 * equation), are further rows, of such weight that they are met to 1e-11 or so. Time is
 * marched in windows unless something is known of its end. Local networks of random functions: Dong
 * & Li, Comput. Methods Appl. Mech. Eng. 387 (2021); least squares with spectral elements: Proot &
 * Gerritsma, J. Sci. Comput. 17 (2002). Numbers that are found from data go from march to march.
 *
 * A patch is halved along a coordinate where the last coefficients along it are too large, and
 * windows become longer and shorter for the same reason. The error is estimated by another basis,
 * of two degrees more: by the step that Gauss-Newton would take there from the solution that was
 * found. That goes from window to window with what it has added up to. So it is what defects of the
 * equations do to the solution through the linearised equations. */
#ifndef PHYSICS_LEARN_PATCHES_H
#define PHYSICS_LEARN_PATCHES_H

#include "physics/learn/model.h"

#ifdef __cplusplus
extern "C" {
#endif

enum { PATCHES_COORDINATES_MAX = 4 };

/* Why it ended: row, word. */
#define PATCHES_END_LIST(X)                                                                        \
    X(PATCHES_CONVERGED, "converged")   /* the estimated error is within the tolerance */          \
    X(PATCHES_INACCURATE, "inaccurate") /* it is not, and finer patches did not lower it enough */ \
    X(PATCHES_TIME_OVER, "time over")                                                              \
    X(PATCHES_DIVERGED, "diverged") /* no solution, in the smallest window of time either */       \
    X(PATCHES_STOPPED, "stopped")   /* it was asked to */

typedef enum patches_end {
#define PATCHES_END_ENUM(code, word) code,
    PATCHES_END_LIST(PATCHES_END_ENUM)
#undef PATCHES_END_ENUM
        PATCHES_END_COUNT
} patches_end;

const char *patches_end_word(patches_end end);

typedef struct patches_progress {
    int attempt;     /* from 1 on: an error above the tolerance begins anew, finer */
    int window;      /* of time, from 1 on */
    double done;     /* of time, 0 to 1 */
    double estimate; /* so far */
    double seconds;
    int patches; /* of this window */
} patches_progress;

typedef struct patches_settings {
    double tolerance; /* of the error of the fields relative to their root mean square, > 0 */
    double seconds;   /* it may take, > 0 */
    ad_pool *pool;
    bool (*progress)(void *context, const patches_progress *now); /* NULL; false: stop */
    void *context;
} patches_settings;

typedef struct patches patches;

typedef struct patches_summary {
    patches_end end;
    double estimate;    /* root mean square of the error over that of the fields, the worst field */
    double by_unknowns; /* the part of it that comes from the deviations of the unknowns, which no
                           finer patches lower: the tolerance is of the rest */
    double done;        /* of time, 0 to 1; places beyond have no value */
    double seconds;
    int attempts, windows;
    int most_patches;  /* in a window */
    size_t parameters; /* of all windows */
    int steps;         /* of Gauss-Newton, of all windows */
    int unknowns;
    double unknown[MODEL_UNKNOWNS_MAX];   /* in their units */
    double deviation[MODEL_UNKNOWNS_MAX]; /* standard deviations, by the scatter of the data */
} patches_summary;

/* The model must outlive the result. AD_BAD_ARGUMENT: a model without equations inside, with more
 * than four coordinates, an ansatz of its own, or derivatives beyond the sixth order; points on
 * something else than faces. AD_BAD_INPUT: conditions that do not determine the fields.
 * AD_NOT_FINITE: residuals that are not finite at the start. AD_NO_MEMORY. A fit that has not
 * reached its tolerance is AD_OK: the summary says so. */
ad_status patches_fit(const physics_model *m, const patches_settings *settings, patches **result,
                      ad_error *error);
void patches_free(patches *p); /* NULL is fine */

patches_summary patches_summarize(const patches *p);

/* The derivative of orders [coordinates] of a row of all fields, as the columns of the model count
 * them, at places x [coordinates][count]. All are in SI units. values [count]: NaN outside of the
 * domain and beyond the time that was reached. errors [count], or NULL: their estimated errors. */
void patches_evaluate(const patches *p, int row, const int *orders, size_t count,
                      const double *const *x, double *values, double *errors);

/* All that evaluation needs, as numbers that last: their count; written to numbers [count]; read
 * again, with a model of as many coordinates and fields: AD_BAD_INPUT. */
size_t patches_numbers(const patches *p);
void patches_write(const patches *p, double *numbers);
ad_status patches_read(const physics_model *m, size_t count, const double *numbers,
                       patches **result, ad_error *error);

#ifdef __cplusplus
}
#endif

#endif
