/* A robot at an instant in a picture: cpinn-show's drawings of shapes. */
#ifndef TOOLS_PROGRAMS_SHOW_POSE_H
#define TOOLS_PROGRAMS_SHOW_POSE_H

#include "physics/scene/scene.h"
#include "tools/files/table_shapes.h"
#include "tools/picture/picture.h"

/* The shapes of a table, as rings to be drawn. */
typedef struct show_shapes {
    table_shapes at;
    const double *turned[4];  /* quaternions; NULL: there are none */
    const double *deflection; /* of a beam along x, in place of places */
    double enlarged;          /* by which factor it is drawn */
    const scene *of;          /* NULL: there is no scene */
    const double *members;    /* of a family [frames][parameter_count]; else NULL */
    size_t count;             /* rings of a shape */
    double size;              /* of all of them: the diagonal of their box, m */
    double low[3], high[3];   /* that box */
    const double *left;       /* m, how far each row is from a wall; NULL: there is none, */
    double least, most;       /* of all of it */
    double radius, thicker;   /* of a rod without a section; of a thin one what it is enlarged by */
} show_shapes;

/* With at most so many rings. AD_BAD_INPUT: there is nothing to be drawn. */
ad_status show_shapes_create(const table_source *table, const scene *of, const double *members,
                             size_t rings, show_shapes *shapes, ad_error *error);

/* rings [count] and their arc lengths at a frame, of a motion also between two. */
void show_pose(const show_shapes *shapes, double frame, picture_ring *rings, double *arc);

/* Place k of a frame. */
void show_place(const show_shapes *shapes, double frame, size_t k, double place[3]);

/* How far place k of a frame is from a wall, m; not a number where nobody has looked. */
double show_left(const show_shapes *shapes, double frame, size_t k);

/* From the nearest to the furthest, 0 to 1. */
picture_colour show_nearness(double part);

/* The time of a frame, s; the frame without times. */
double show_time(const show_shapes *shapes, double frame);

/* The parameters of a member at a frame; NULL: there are none. */
const double *show_member(const show_shapes *shapes, double frame);

/* Arrows of loads by `size`. */
#define SHOW_ARROW 0.15

/* How far anything of a robot reaches from the axis. */
double show_room(const show_shapes *shapes);

typedef struct show_look {
    picture_colour tube; /* of the rod */
    float opacity;       /* 1: nothing is seen behind */
    bool ends;           /* with discs, tendons, chambers, bodies, loads */
    int sides;           /* of a round rod */
} show_look;

/* The robot with its ends, discs, tendons, chambers, bodies and loads; the rings are scratch. */
void show_robot(picture *p, const show_shapes *shapes, double frame, const show_look *look,
                picture_ring *rings, double *arc);

/* What acts, in words at the left edge from y on: "tendons 2 N, 1 N". */
void show_actuation(picture *p, const show_shapes *shapes, double frame, double y);

/* "12.5 mm" of 0.0125 and "m". */
void show_with_unit(double value, const char *unit, int digits, char *text, size_t size);

/* 1, 2 or 5 times a power of ten, about `size`. */
double show_round(double size);

#endif
