/* The coordinates of a model: their names, ranges and units, and the windows of time.
 *
 * Sampling, network input, evaluation and checkpoints ask the domain; nothing else knows how many
 * coordinates there are. On the tape coordinates are dimensionless, one row each. */
#ifndef PHYSICS_DOMAIN_H
#define PHYSICS_DOMAIN_H

#include "autodiff/ad.h"

#include <stdbool.h>

#ifdef __cplusplus
extern "C" {
#endif

enum { DOMAIN_COORDINATES_MAX = 8, DOMAIN_NAME = 24, DOMAIN_WINDOWS_MAX = 1024 };

typedef struct domain_coordinate {
    char name[DOMAIN_NAME]; /* "s" */
    const char *unit;       /* of the SI, static text: "m" */
    double low, high;       /* range, dimensionless; low < high */
    double scale;           /* what one is in that unit */
} domain_coordinate;

typedef struct domain {
    int count;
    domain_coordinate coordinates[DOMAIN_COORDINATES_MAX];
    int time;    /* the coordinate that windows divide and causal weights follow; -1: none */
    int windows; /* equal parts of it, each with a network of its own; 1 without time */
} domain;

/* Where window `index` of time begins; index = windows: where the last one ends. 0 without time. */
double domain_window_time(const domain *d, int index);

/* The window of an instant: one between two windows belongs to the one that it ends. */
int domain_window_at(const domain *d, double time);

/* The coordinate of that name, -1: there is none. */
int domain_find(const domain *d, const char *name);

/* ---- places ----
 * Where a model is recorded on a tape. Coordinates are inputs, or constants where they do not vary;
 * derivatives are taken by those that are inputs (ad_derivative takes no results of operations).
 * What is set before a run is a uniform of the tape, so that the windows of time and the steps of a
 * load continuation run the same compiled program. */
typedef struct domain_place {
    ad_tape *tape;
    ad_value x[DOMAIN_COORDINATES_MAX];
    ad_value start, span; /* of the window of time at work, one row each */
    bool goes_on;         /* the window starts from the state in which the one before ended */
    ad_value state;       /* that state, uniform, as the model wrote it (physics/model.h) */
    ad_value load_factor; /* of all loads, 0 to 1, one row */
} domain_place;

/* Which numbers of a place are uniforms and not constants. */
typedef struct domain_uniforms {
    bool window;      /* start and span */
    int state;        /* rows; 0: not a later window */
    bool load_factor; /* else it is 1 */
} domain_uniforms;

/* Records the inputs, one for each coordinate in their order, and then the uniforms; both have to
 * be the first of the tape. Without a uniform for the window, it is the first one. */
domain_place domain_record(const domain *d, const domain_uniforms *uniforms, ad_tape *tape);

/* The numbers of those uniforms, for a run. */
typedef struct domain_setting {
    double window[2];    /* start, span */
    const double *state; /* [uniforms.state] */
    double load_factor;
} domain_setting;

enum { DOMAIN_UNIFORMS_MAX = 3 };

/* Fills list with the uniforms of a tape in the order of domain_record and returns how many they
 * are; the setting is borrowed. */
int domain_list_uniforms(const domain_uniforms *uniforms, const domain_setting *setting,
                         const double **list);

/* The coordinates mapped to [-1, 1] over their ranges, time over the window at work: one row for
 * each coordinate. */
ad_value domain_network_input(const domain *d, const domain_place *at);

/* Time since the window at work began. */
ad_value domain_elapsed(const domain *d, const domain_place *at);

#ifdef __cplusplus
}
#endif

#endif
