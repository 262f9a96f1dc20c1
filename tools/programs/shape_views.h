/* Shapes of a rod on a canvas: one view where all lies in a plane of two axes, else two. */
#ifndef TOOLS_PROGRAMS_SHAPE_VIEWS_H
#define TOOLS_PROGRAMS_SHAPE_VIEWS_H

#include "tools/programs/canvas.h"

enum { SHAPE_VIEWS_SHAPES = 9, SHAPE_VIEWS_POINTS = 41, SHAPE_VIEWS_KNOWN = 512 };
enum { SHAPE_VIEWS_AXES = 3 };

typedef struct shape_views {
    double length;     /* of the rod, m */
    bool beam;         /* a view has scales of its own for length and deflection */
    int count, points; /* 0: nothing is drawn */
    double places[SHAPE_VIEWS_SHAPES][SHAPE_VIEWS_POINTS]
                 [SHAPE_VIEWS_AXES]; /* [count][points], m;
                                      * of a beam s, 0, deflection */
    int known;                       /* dots beside them */
    double known_places[SHAPE_VIEWS_KNOWN][SHAPE_VIEWS_AXES];
} shape_views;

/* Of shape k: from blue to red. */
canvas_colour shape_views_colour(const shape_views *w, int k);

/* In that part of the canvas, with names of the axes and a scale in its last row. */
void shape_views_draw(const shape_views *w, canvas *c, int column, int row, int columns, int rows);

#endif
