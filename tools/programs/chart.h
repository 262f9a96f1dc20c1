/* Curves over a logarithmic axis, with numbers at both axes, on a canvas. */
#ifndef TOOLS_PROGRAMS_CHART_H
#define TOOLS_PROGRAMS_CHART_H

#include "tools/programs/canvas.h"

enum { CHART_SERIES = 4 };

typedef struct chart_series {
    int points;
    const double *x, *y; /* [points], x ascending; what is not above 0 is a gap */
    canvas_colour colour;
} chart_series;

typedef struct chart {
    const char *x_unit; /* "s" */
    int count;
    chart_series series[CHART_SERIES]; /* the last on top */
} chart;

/* Least size of it, in cells. */
enum { CHART_COLUMNS = 20, CHART_ROWS = 5 };

/* In that part of the canvas. */
void chart_draw(canvas *c, const chart *what, int column, int row, int columns, int rows);

#endif
