/* A way of a robot to its goal among surfaces: searched by whoever is quick to say what shapes are,
 * with the error of these shapes as a margin, then certified by the solver and exact distances. */
#ifndef PLAN_WAY_H
#define PLAN_WAY_H

#include "tools/environment/distance_grid.h"
#include "tools/plan/certificate.h"
#include "tools/plan/roadmap.h"

/* Who says what shapes are in the search. */
typedef struct way_shapes {
    /* values [points][columns], which begin with the position, of one member of the scene. */
    ad_status (*of_member)(void *context, const double *parameters, double *values,
                           ad_error *error);
    void *context;
    size_t points, columns;
    const double *s; /* [points] m, `from` among them */
    double error;    /* m, of a point at most, as far as is known */
} way_shapes;

typedef struct way_problem {
    const plan_settings *settings;
    const environment *environment;
    const distance_grid *grid;
    plan_exact *exact;
    const way_shapes *shapes;
    const roadmap_settings *roadmap; /* to search in; NULL: by the settings' method */
} way_problem;

typedef enum way_end {
    WAY_CERTIFIED,
    WAY_NOT_CERTIFIED, /* one was found, and the certificate says why it does not hold */
    WAY_NOT_FOUND,     /* the planner has found none */
    WAY_GOAL_BEYOND,   /* no configuration has its tip there */
    WAY_GOAL_TOUCHES,  /* those that have are too near to the surface */
    WAY_NOT_TRIED      /* there is no way to the goal before */
} way_end;

typedef struct way_goal {
    way_end end;           /* of the way to it from the goal before */
    size_t count;          /* configurations that are there, and free */
    double nearest, angle; /* m, rad, that the tip comes to it; of actuators 0 */
    size_t row;            /* of the certificate, where it is reached */
} way_goal;

typedef struct way {
    way_end end; /* of the first goal that is not reached, or WAY_CERTIFIED */
    int goals;
    way_goal goal[PLAN_GOALS_MAX]; /* [goals] in order */
    certificate *certificate;      /* of all of the way; NULL: a goal has none */
    size_t looked;                 /* configurations in all searches */
    size_t corners;                /* of the way that was found */
    int searches;
    double seconds_search, seconds_certificate, seconds_roadmap;
    double processor_search, processor_certificate; /* s, of this thread */
    roadmap_source source;                          /* of a roadmap */
    size_t nodes, edges;
} way;

/* AD_BAD_INPUT: `key` receives what is to blame: a start or a goal beyond the ranges, or a start or
 * actuators of a goal that touch. Errors of the shapes, AD_NO_MEMORY, AD_BAD_ARGUMENT without
 * OMPL. */
ad_status way_find(const way_problem *problem, way *result, char key[PLAN_KEY], ad_error *error);
void way_free(way *of); /* not itself */

#endif
