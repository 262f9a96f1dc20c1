/* What is certain of a way through configurations, between which each variable goes evenly: each
 * shape by the solver, exact distances, and bounds between points and between configurations. Where
 * a bound takes off too much, the configuration half-way is looked at, too. */
#ifndef PLAN_CERTIFICATE_H
#define PLAN_CERTIFICATE_H

#include "tools/environment/clearance.h"
#include "tools/plan/plan_robot.h"

typedef enum certificate_end {
    CERTIFICATE_HOLDS,
    CERTIFICATE_TOO_NEAR,       /* at `which` a shape is nearer than promised */
    CERTIFICATE_NO_EQUILIBRIUM, /* at `which` the solver finds none */
    CERTIFICATE_JUMPS,          /* between `which` and the next shapes are not close, however near
                                 * configurations are */
    CERTIFICATE_OTHER_SIDE      /* the first shape is on the wrong side of the surface */
} certificate_end;

const char *certificate_text(certificate_end end); /* in words */

typedef struct certificate {
    certificate_end end;
    size_t which; /* of the configurations here */
    size_t count; /* those given, and those looked at between them, in their order */
    int variables;
    double *configuration; /* [count][variables] */
    clearance *shape;      /* [count] */
    double *least; /* [count] of all shapes from this one to the next; of the last its own */
    double *tip;   /* [count][3] */
    clearance all; /* of the place that has least */
} certificate;

typedef struct certificate_settings {
    double radius, from; /* of the robot, m */
    double promised;     /* m, what is to be left everywhere */
    size_t shapes_max;   /* more are not looked at: then it does not hold */
} certificate_settings;

/* configurations [count][variables of the robot]. Where it does not hold the result says why, too.
 * Between two neighbours it takes for granted that how far points move with a variable does not
 * change by more than it does between their ends; none are further apart than a tenth of a range.
 * AD_NO_MEMORY, errors of the solver. */
ad_status certificate_create(plan_exact *shapes, const environment *of, environment_side side,
                             const certificate_settings *settings, size_t count,
                             const double *configurations, certificate **result, ad_error *error);

/* Goes on with `next`, which begins where `to` ends, and is freed. The fault is that of next. to
 * NULL: is next. AD_NO_MEMORY: both are as they were. */
ad_status certificate_join(certificate **to, certificate *next, ad_error *error);
void certificate_free(certificate *of); /* NULL is allowed */

#endif
