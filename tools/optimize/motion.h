/* The quickest motion of a reduced rod (physics/chain/reduced.h) between two equilibria, or the one
 * of least effort, by direct collocation: states at the points of Radau's method of order 5 and the
 * inputs, held in each of equal intervals, are what IPOPT chooses, together with the duration.
 *
 * The constraints of the section are kept at these points: formulas of response.h in motion, and
 * NAME.rate, how fast an input changes. With a rate in them inputs go linearly from one end of an
 * interval to the other, from those at rest to those at rest. Between the points a replay looks. */
#ifndef TOOLS_OPTIMIZE_MOTION_H
#define TOOLS_OPTIMIZE_MOTION_H

#include "physics/scene/scene.h"
#include "tools/environment/environment.h"
#include "tools/optimize/descent.h"
#include "tools/optimize/optimize_settings.h"

/* What the inputs do to a rod that is none of those that they were chosen by. */
typedef struct optimize_replay {
    double off;   /* m, of the tip at the end of the motion from that at rest there */
    double speed; /* m/s, of the tip then */
    double beyond[OPTIMIZE_CONSTRAINTS_MAX]; /* by which constraints are missed on the way */
} optimize_replay;

typedef struct optimize_motion_report {
    bool found;
    int steps, starts;
    double duration, effort; /* s: the integral of squares of inputs, over their ranges */
    double error;            /* of what is made small, as inputs change so seldom, s; infinite:
                              * unknown */
    double violation;        /* of equations and constraints, over what these vary by */
    int bounds;
    double spread[OPTIMIZE_CONSTRAINTS_MAX]; /* what a constraint's formula varies by */
    double way;                              /* m, of the tip from one rest to the other */
    optimize_replay same, finer; /* with steps a fourth as long; and with more modes as well, */
    int modes[4];                /* these */
    double seconds;
} optimize_motion_report;

typedef struct optimize_motion optimize_motion;

/* A scene in motion, whose parameters with ranges are the inputs; settings, scene and the surface
 * around it, NULL if there is none, are borrowed. AD_BAD_INPUT with the key to blame; what
 * reduced_create says; AD_NOT_FINITE: an end has no equilibrium. */
ad_status optimize_motion_create(const optimize_settings *settings, const scene *family,
                                 const environment *around, optimize_motion **result, char key[64],
                                 ad_error *error);
void optimize_motion_free(optimize_motion *motion); /* NULL is allowed */

/* What IPOPT is given; borrows. */
descent optimize_motion_problem(optimize_motion *motion);

/* AD_BAD_ARGUMENT: built without IPOPT; AD_NO_MEMORY; what the rod says. */
ad_status optimize_motion_run(optimize_motion *motion, optimize_motion_report *report,
                              ad_error *error);

/* At the beginning of interval k, and at the end of the last: time, inputs from then on, the tip.
 */
int optimize_motion_intervals(const optimize_motion *motion);
int optimize_motion_inputs(const optimize_motion *motion);
bool optimize_motion_is_linear(const optimize_motion *motion); /* or inputs are held */
ad_status optimize_motion_at(optimize_motion *motion, int k, double *t, double *inputs,
                             double tip[3], ad_error *error);

#endif
