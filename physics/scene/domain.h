/* The coordinates of a model: their names, ranges and units, the windows of time, and the pieces of
 * the first coordinate within which fields are smooth.
 *
 * Sampling, network input, evaluation and checkpoints ask the domain; nothing else knows how many
 * coordinates there are. On the tape coordinates are dimensionless, one row each. */
#ifndef PHYSICS_SCENE_DOMAIN_H
#define PHYSICS_SCENE_DOMAIN_H

#include "autodiff/ad.h"

#include <stdbool.h>

#ifdef __cplusplus
extern "C" {
#endif

enum {
    DOMAIN_COORDINATES_MAX = 50, /* s, t and the parameters of a scene */
    DOMAIN_NAME = 48,
    DOMAIN_WINDOWS_MAX = 1024,
    DOMAIN_PIECES_MAX = 64 /* NN_PIECES_MAX */
};

typedef struct domain_coordinate {
    char name[DOMAIN_NAME]; /* "s" */
    const char *unit;       /* of the SI, static text: "m" */
    double low, high;       /* range, dimensionless; low < high */
    double scale;           /* what one is in that unit */
    bool logarithmic;       /* points and networks go by its logarithm; 0 < low */
    bool periodic;          /* what is at `low` is at `high`, with all derivatives */
} domain_coordinate;

typedef struct domain {
    int count;
    domain_coordinate coordinates[DOMAIN_COORDINATES_MAX];
    int time;     /* the coordinate that windows divide and causal weights follow; -1: none */
    int windows;  /* parts of it, each with a network of its own; 1 without time */
    bool divided; /* into the windows between the following times, else into equal ones */
    double window_edge[DOMAIN_WINDOWS_MAX + 1]; /* [windows + 1], dimensionless, ascending */
    int pieces;                         /* of the first coordinate; 0 or 1: all of it is one */
    double edge[DOMAIN_PIECES_MAX + 1]; /* [pieces + 1] of several: ascending, low and high too */
} domain;

/* Lets windows end at `count` times [count] within the range, ascending and dimensionless, as far
 * as there are more windows than that. Between two of them windows are equal, and as many as make
 * the longest of all short. */
void domain_divide_time(domain *d, int count, const double *times);

/* The longest window. */
double domain_longest_window(const domain *d);

/* Where window `index` of time begins; index = windows: where the last one ends. 0 without time. */
double domain_window_time(const domain *d, int index);

/* The window of an instant: one between two windows belongs to the one that it ends. */
int domain_window_at(const domain *d, double time);

/* Pieces of the first coordinate, at least 1, and the range [low, high] of one. */
int domain_pieces(const domain *d);
void domain_piece(const domain *d, int piece, double *low, double *high);

/* The place, dimensionless, at a fraction of the range of a coordinate. */
double domain_coordinate_at(const domain_coordinate *c, double fraction);

/* The coordinate of that name, -1: there is none. */
int domain_find(const domain *d, const char *name);

/* By what "xxt" differentiates: orders [count] of the coordinates, which the text of `length` names
 * as often as that; those with names of several letters are set apart by underscores. False: it
 * names something else, nothing, or more than `most` in all. */
bool domain_read_orders(const domain *d, const char *names, size_t length, int most, int *orders);

/* ---- places ----
 * Where a model is recorded on a tape. Coordinates are inputs, or constants where they do not vary;
 * derivatives are taken by those that are inputs (ad_derivative takes no results of operations).
 * What is set before a run is a uniform of the tape, so that the windows of time and the steps of a
 * load continuation run the same compiled program. To try a residual by itself, a place may be
 * filled in with nothing but the tape and inputs x. */
typedef struct domain_place {
    ad_tape *tape;
    const domain *over; /* NULL: one piece; outlives the place */
    ad_value x[DOMAIN_COORDINATES_MAX];
    ad_value start, span; /* of the window of time at work, one row each */
    bool goes_on;         /* the window starts from the state in which the one before ended */
    ad_value state;       /* that state, uniform, as the model wrote it (physics/learn/model.h) */
    ad_value load_factor; /* of all loads, 0 to 1, one row */
    ad_value unknowns;    /* numbers that are trained with the network, in SI; not valid: none */
    ad_value data;        /* of points that have a source (physics/learn/model.h) */
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

/* Those of a window; the state is borrowed. */
domain_setting domain_setting_of(const domain *d, int window, const double *state,
                                 double load_factor);

enum { DOMAIN_UNIFORMS_MAX = 3 };

/* Fills list with the uniforms of a tape in the order of domain_record and returns how many they
 * are; the setting is borrowed. */
int domain_list_uniforms(const domain_uniforms *uniforms, const domain_setting *setting,
                         const double **list);

/* Which piece a place lies in, and where: an edge belongs to the piece before it. */
typedef struct domain_local {
    int pieces;
    ad_value x;                       /* from -1 to 1 over the piece */
    ad_value mask[DOMAIN_PIECES_MAX]; /* 1 in the piece, 0 elsewhere */
    ad_value ramp[DOMAIN_PIECES_MAX]; /* rises with s in the piece, constant elsewhere */
    ad_value bubble; /* its length times x (1 - x) where x is from 0 to 1: 0 at all edges */
} domain_local;

domain_local domain_local_of(const domain *d, ad_value s);

/* Factors that vanish where the first coordinate begins (end 0) or ends (1), from 0 to 1 in a
 * dimensionless coordinate: x and 1 - x. With several pieces they do so within the piece at that
 * end alone, and are 1 elsewhere. What is divided by them is then smooth in every piece, also where
 * it has no analytic continuation to that end. */
ad_value domain_vanish(const domain_place *at, int end);

/* One coordinate mapped to [-1, 1] over its range, by its logarithm if it goes by that. */
ad_value domain_unit(const domain *d, const domain_place *at, int coordinate);

/* The coordinates mapped to [-1, 1] over their ranges, time over the window at work and the first
 * over its piece: one row for each coordinate. With several pieces what nn/nn.h wants of them
 * follows. */
ad_value domain_network_input(const domain *d, const domain_place *at);

/* Time since the window at work began. */
ad_value domain_elapsed(const domain *d, const domain_place *at);

#ifdef __cplusplus
}
#endif

#endif
