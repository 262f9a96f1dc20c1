/* What a scene's solution is known to be, and how far a field is from it. */
#ifndef TOOLS_TRAIN_REFERENCE_H
#define TOOLS_TRAIN_REFERENCE_H

#include "physics/solve/solve.h"
#include "tools/train/experiment.h"

/* A point counts as lying at an end of the rod or the duration within this fraction of it: files
 * hold rounded numbers. */
#define REFERENCE_END_TOLERANCE 1e-9

typedef struct reference reference;

/* The reference that the scene names: closed form, manufactured or classical solution at points of
 * our choice (101 in a static scene, 41 x 41 in a dynamic one), or the points of a file. *result is
 * NULL when the scene names none. Points of a file beyond the rod or the duration are left out. */
ad_status reference_create(const experiment *e, reference **result, ad_error *error);
void reference_free(reference *r);

/* Follow the experiment to the window of time at which it is. Points in windows from `from` up to
 * that one get the values of the experiment's finished networks, once and for all; those in windows
 * before `from` keep theirs. reference_create enters the window at hand. */
ad_status reference_enter(reference *r, const experiment *e, int from, ad_error *error);

size_t reference_points(const reference *r);
const double *reference_s(const reference *r);  /* [points] m */
const double *reference_t(const reference *r);  /* [points] s */
size_t reference_left_out(const reference *r);  /* points of a file outside the scene,
                                                 * or without a number */
const char *reference_name(const reference *r); /* "elastica", "file.csv", ... */

/* Of a classical solution, tools/train/reference_solve.h: how it was come by, and what was wrong
 * with its cache; "" of other references, and when nothing was. */
const char *reference_account(const reference *r);
const char *reference_remark(const reference *r);

typedef struct reference_errors {
    double position;     /* ||r - r_ref|| / ||r_ref||, over all points, 2-norm */
    double position_max; /* largest |r - r_ref| / length */
    double tip;          /* largest |r - r_ref| / length at s = length; NaN: no such point */
    double rotation;     /* root mean square of the angle between rotations, rad; NaN: unknown */
    double rotation_max; /* largest angle, rad */
} reference_errors;

/* Of the reference itself, at most; NaN: unknown, or none. */
reference_errors reference_estimates(const reference *r);

/* Of the experiment's field from t = 0 to the end of the window entered, at parameters x of that
 * window; NaN where no point lies so early. Allocates nothing after the first call. */
ad_status reference_compare(reference *r, const double *x, reference_errors *errors,
                            ad_error *error);

/* The same of a classical solution, at all points; of a motion it has to know their times. Until
 * the next reference_enter its values are what the points are left with. AD_NO_MEMORY. */
ad_status reference_compare_solution(reference *r, const solution *solved, reference_errors *errors,
                                     ad_error *error);

/* What is known of a coordinate of the position, 0 or a rod's 0 to 2, and what was found by the
 * comparison last: [points] m. NULL: of a beam there is one. */
const double *reference_known(const reference *r, int coordinate);
const double *reference_found(const reference *r, int coordinate);

/* Adds the remark, if it is so, that the errors are below the estimated one of the reference
 * itself, and so say no more than that; or the warning that they are larger than this and the
 * estimated error of what is compared allow (over the length, or a beam's deflection; NaN: not
 * known), so that one of the two is wrong. */
void reference_verdict(const reference *r, const reference_errors *errors, double estimate,
                       verdict *result);

/* Removes classical solutions that are in doubt from the cache: the next run solves them anew. */
void reference_forget(const reference *r);

/* Angle between two rotations, 2 atan2(|vec(p* q)|, |scalar(p* q)|): accurate at 0 and pi, and the
 * same for q and -q. */
double reference_angle(const double p[4], const double q[4]);

#endif
