/* What the files of the groups share; not for others. */
#ifndef PHYSICS_LEARN_GROUPS_INTERNAL_H
#define PHYSICS_LEARN_GROUPS_INTERNAL_H

#include "physics/learn/groups.h"
#include "physics/rod/rod_internal.h"

enum { GROUP_PLACES_MAX = 64, GROUP_TIMES_MAX = 4, GROUP_NAME = 48 };

/* How an item changes when the rod is turned about d3 of its base, or mirrored. */
typedef enum group_kind {
    GROUP_SCALAR,   /* not at all */
    GROUP_POLAR,    /* [3] a force, in components of the base or of the section */
    GROUP_AXIAL,    /* [3] a moment, a curvature, the same */
    GROUP_TENSOR,   /* [3] along d1, d2, d3: not at all if its first two are equal */
    GROUP_PULL,     /* of one tendon: it takes the value of the one that comes in its place */
    GROUP_OFFSET,   /* [3] of one tendon: it has to be where that one comes */
    GROUP_PARAMETER /* of the family itself: it may change, but not how is not known */
} group_kind;

/* The effect of half the range of a parameter that is among the items as it is. */
static const double GROUP_UNKNOWN = 0.5;

#define GROUP_MOMENT     "moment of actuators"
#define GROUP_RESISTANCE "resistance of tendons to twist"

/* One dimensionless number or vector that the equations are given, at one place. */
typedef struct group_item {
    char name[GROUP_NAME];
    const char *unit; /* what it is counted in: "EI/L^2" */
    double s, t;      /* m, s; NaN: the same everywhere */
    group_kind kind;
    int rows;
    int tendon;       /* of pulls and offsets */
    bool as_it_is;    /* a parameter of the family, */
    bool is_log;      /* which its author counts by its logarithm */
    double effect[3]; /* by how much of the length one unit moves the rod, an estimate */
    ad_value value;
} group_item;

/* In an order that depends on the scene alone. */
typedef struct group_list {
    int count, capacity;
    group_item *items;
} group_list;

/* The scene, the member with middle values, by whose scales all is recorded, and where. */
typedef struct group_source {
    scene open, middle;
    bool by_parameters; /* no items but these */
    const char *names[SCENE_PARAMETERS_MAX];
    rod_numbers numbers; /* of the middle */
    int places, times;
    double place[GROUP_PLACES_MAX], time[GROUP_TIMES_MAX]; /* dimensionless */
    bool turnable; /* a rod at rest, clamped at its start and held nowhere else: then loads in the
                    * world are in the frame of the base */
} group_source;

/* groups_items.c. by_parameters: also where it is a family of other than rods. */
ad_status group_source_fill(const scene *family, bool by_parameters, group_source *source,
                            ad_error *error);

/* For parameters in SI [parameter_count]. Errors stay on the tape; the caller frees list->items. */
void group_items(const group_source *source, ad_value parameters, group_list *list);

/* groups_symmetry.c. Turns about d3 of the base by 2 pi/order (0: by any angle) and the mirror
 * through d3 and the axis at `angle` in the section, each of which leaves the scene as it is. */
typedef struct group_symmetry {
    int order;
    bool mirrors;
    double angle;
    double off;                      /* by what it is no symmetry, of the length; 0: it is one */
    int turned[SCENE_TENDONS_MAX];   /* in whose place each tendon comes by 2 pi/order */
    int mirrored[SCENE_TENDONS_MAX]; /* and by the mirror */
    int by, second; /* items whose directions say into which sector, and on which side; -1: none */
} group_symmetry;

static const group_symmetry GROUP_NO_TURN = {.order = 1, .by = -1, .second = -1};

static inline bool group_symmetry_any(const group_symmetry *symmetry)
{
    return symmetry->order != 1 || symmetry->mirrors;
}

/* values [rows of all items in turn][draws]. `nearly`: tendons may be taken for their force and
 * moment. */
void group_symmetry_find(bool nearly, const group_source *source, const group_list *list,
                         size_t draws, const double *values, group_symmetry *result);

/* Items become those of the member in the sector. */
void group_symmetry_apply(const group_symmetry *symmetry, group_list *list, groups_turn *turn);

/* ---- the result ------------------------------------------------------------------------------ */

enum { GROUP_ROWS_MAX = 64 };

/* One row of an item. */
typedef struct group_row {
    int item, entry;
    bool is_log;         /* by its logarithm */
    double low, high;    /* over some members, of that */
    double effect;       /* by how much of the length half the range moves the rod, an estimate */
    double scale;        /* the input is within -scale .. scale */
    unsigned parameters; /* bits: those that it depends on */
    bool is_local;       /* it differs along the rod */
    group_item of;       /* its value is not to be looked at */
} group_row;

struct groups {
    group_source source;
    group_symmetry symmetry;
    int count;
    group_row rows[GROUP_ROWS_MAX];
};

#endif
