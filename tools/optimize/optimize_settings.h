/* The section `optimize` of a scene: which numbers are chosen, what is made small by them and what
 * is kept. Numbers that are not given are NaN, texts NULL. */
#ifndef TOOLS_OPTIMIZE_OPTIMIZE_SETTINGS_H
#define TOOLS_OPTIMIZE_OPTIMIZE_SETTINGS_H

#include "physics/scene/scene.h"
#include "tools/environment/environment_settings.h"

#include <stdint.h>

enum {
    OPTIMIZE_CONSTRAINTS_MAX = 16,
    OPTIMIZE_PLACES_MAX = 8,
    OPTIMIZE_CASES_MAX = 64,
    OPTIMIZE_STARTS_MAX = 64,
    OPTIMIZE_POINTS_MAX = 241
};

#define OPTIMIZE_OVER_LIST(X)      X(OPTIMIZE_MEAN, "mean") X(OPTIMIZE_WORST, "worst")
#define OPTIMIZE_LEAST_LIST(X)     X(OPTIMIZE_TIME, "time") X(OPTIMIZE_EFFORT, "effort")
#define OPTIMIZE_ENUM(value, text) value,
typedef enum optimize_over { OPTIMIZE_OVER_LIST(OPTIMIZE_ENUM) } optimize_over;
typedef enum optimize_least { OPTIMIZE_LEAST_LIST(OPTIMIZE_ENUM) } optimize_least;
#undef OPTIMIZE_ENUM

typedef struct optimize_place {
    const char *name;
    double at; /* m */
} optimize_place;

/* From rest to rest, in the least time or with the least effort. */
typedef struct optimize_motion_settings {
    optimize_least minimize;
    const char *start, *end; /* "tension=1": inputs under which the rod is at rest there */
    int intervals;           /* in which inputs are held */
    int modes[4];            /* reduced_settings */
} optimize_motion_settings;

typedef struct optimize_settings {
    optimize_motion_settings motion; /* in place of all that follows */
    const char *minimize, *maximize; /* formulas; one of them */
    int variable_count, each_count, box_count, constraint_count, place_count, case_count;
    const char *variables[SCENE_PARAMETERS_MAX]; /* one value for all cases */
    const char *each[SCENE_PARAMETERS_MAX];      /* one for each case */
    const char *box[SCENE_PARAMETERS_MAX];       /* not chosen: any value of their range */
    const char *constraints[OPTIMIZE_CONSTRAINTS_MAX];
    optimize_place places[OPTIMIZE_PLACES_MAX];
    const char *cases[OPTIMIZE_CASES_MAX]; /* "tip_x=0.1, goal=0.02" */
    const char *file;                      /* a table of cases, absolute once read */
    optimize_over over;
    environment_settings environment; /* of which formulas have the clearance */
    double radius;                    /* of the robot there, m */
    int points, starts;
    double tolerance; /* of the solver, of the position over the length */
    int64_t seed;
} optimize_settings;

optimize_settings optimize_settings_default(void);

/* Whether a scene has the section: it says what is made small or large. And whether that of a
 * motion.
 */
bool optimize_is_given(const optimize_settings *settings);
bool optimize_motion_is_given(const optimize_settings *settings);

#endif
