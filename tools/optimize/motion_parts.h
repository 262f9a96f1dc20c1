/* What the files of optimize_motion share; not for others. */
#ifndef TOOLS_OPTIMIZE_MOTION_PARTS_H
#define TOOLS_OPTIMIZE_MOTION_PARTS_H

#include "autodiff/memory.h"
#include "physics/chain/reduced.h"
#include "physics/numerics/gauss.h"
#include "tools/optimize/motion.h"
#include "tools/optimize/optimize_parts.h"

/* ---- motion_rod.c: a reduced rod, and what is bounded of it along the way ---------------------
 */

typedef struct motion_bound {
    response *of;
    double low, high, scale; /* the last: 1 over what it varies by */
    size_t rows;
} motion_bound;

typedef struct motion_rod {
    reduced_rod *rod;
    int states, inputs;
    size_t points, place[OPTIMIZE_PLACES_MAX + 1];
    double *s;
    int bounds;
    motion_bound bound[OPTIMIZE_CONSTRAINTS_MAX];
    size_t rows, directions; /* of all bounds; of derivatives: inputs, their rates, the state */
    bool rates;              /* a formula has the rate of an input */
    kinematics look;         /* of all rows at all points */
    int *row;
    reduced_place *seen;                  /* [points] */
    double *values, *by_state, *jacobian; /* of shapes */
    double *number, *slope, *room;        /* of one bound; of kinematics */
    ad_memory memory;
} motion_rod;

/* With that many points along it. AD_BAD_INPUT with the key to blame. */
ad_status motion_rod_create(const optimize_settings *settings, const scene *family,
                            const environment *around, const int *modes, size_t points,
                            motion_rod **result, char key[OPTIMIZE_KEY_MAX], ad_error *error);
void motion_rod_free(motion_rod *rod); /* NULL is allowed */

ad_status motion_rod_tip(motion_rod *rod, const double *state, const double *inputs,
                         reduced_place *tip, ad_error *error);

/* Of all bounds, not scaled: values [rows], by [rows][directions] or NULL. */
ad_status motion_rod_look(motion_rod *rod, const double *state, const double *inputs,
                          const double *rates, double *values, double *by, ad_error *error);

/* By how much a value of a bound is beyond it, not scaled; 0: it is kept. */
double motion_bound_excess(const motion_bound *bound, double value);

/* ---- the problem ------------------------------------------------------------------------------
 */

enum { MOTION_STAGES = 3 };

struct optimize_motion {
    const optimize_settings *settings;
    const scene *family;
    const environment *around;
    motion_rod *rod;
    gauss_rule rule;
    size_t states, inputs, intervals;
    size_t width, height; /* variables and rows of an interval */
    bool linear;          /* inputs go linearly from one to the next; or they are held */
    double longest;       /* s */
    double *from, *to;    /* [states] at rest */
    double *scale;        /* [states] what they vary by */
    double given[2][SCENE_PARAMETERS_MAX]; /* inputs there */

    /* Variables: of each interval states at its points over their scales and the inputs, held or at
     * its end, as fractions of their ranges, then the duration over the longest. Rows: of each
     * interval those of states at its points, then those of bounds there. */
    size_t n, m, nonzeros;
    double *x, *limits, *gradient, *row, *by, *multiplier;
    int *entries;
    double value;
    bool known, there;
    double *at;                         /* [n] where it was evaluated last */
    double *rate, *by_state, *by_input; /* of the points of an interval */
    double *state, *values, *slopes;
    ad_error why;
    ad_memory memory;
};

double motion_duration(const optimize_motion *motion, const double *x);
double motion_effort(const optimize_motion *motion, const double *x);

/* At a part of interval k; rates may be NULL. */
void motion_inputs_at(const optimize_motion *motion, const double *x, size_t k, double part,
                      double *inputs, double *rates);

/* A value of an input as a fraction of its range. */
double motion_share_of(const optimize_motion *motion, size_t input, double value);

/* The scaled state at the end of interval k. */
const double *motion_end_of(const optimize_motion *motion, const double *x, size_t k);

/* How exactly states are at rest at the end, over what they vary by. */
void motion_rest_within(optimize_motion *motion, double share);

/* Begins in proportion from one rest to the other. */
void motion_guess(optimize_motion *motion, double share);
bool motion_evaluate(void *of, const double *x);

/* At rest at an end, from the state that is there. */
ad_status motion_rest(const optimize_motion *motion, reduced_rod *rod, int end, double *state,
                      ad_error *error);

#endif
