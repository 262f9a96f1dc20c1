/* A picture made of characters: texts, and lines of dots, two by four of them in a cell, which are
 * the Braille patterns of Unicode. Fixed memory, no files. */
#ifndef TOOLS_PROGRAMS_CANVAS_H
#define TOOLS_PROGRAMS_CANVAS_H

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

enum { CANVAS_COLUMNS = 200, CANVAS_ROWS = 60, CANVAS_ACROSS = 2, CANVAS_DOWN = 4 };

/* As terminals have them: those that are legible on black and on white. */
typedef enum canvas_colour {
    CANVAS_PLAIN,
    CANVAS_DIM,
    CANVAS_BLUE,
    CANVAS_CYAN,
    CANVAS_GREEN,
    CANVAS_YELLOW,
    CANVAS_RED,
    CANVAS_MAGENTA
} canvas_colour;

typedef struct canvas_cell {
    uint16_t code; /* of a character; 0: none */
    uint8_t dots;  /* bit b: U+2800 + 2^b */
    uint8_t colour;
} canvas_cell;

typedef struct canvas {
    int columns, rows;
    canvas_cell cells[CANVAS_ROWS][CANVAS_COLUMNS];
} canvas;

/* Empty, of that size or the largest there is. */
void canvas_clear(canvas *c, int columns, int rows);

/* One character, of the basic plane; what lies outside is left out. */
void canvas_put(canvas *c, int column, int row, canvas_colour colour, unsigned code);

/* ASCII, of other bytes question marks; returns the column behind it. */
int canvas_text(canvas *c, int column, int row, canvas_colour colour, const char *text);

/* A part of a canvas, and what of a plane it shows: its corners are at the first and the last dots.
 */
typedef struct canvas_view {
    int column, row, columns, rows;
    double left, right, bottom, top;
} canvas_view;

/* The part of a line from (x0, y0) to (x1, y1) that is seen; nothing of one that is not finite. */
void canvas_line(canvas *c, const canvas_view *view, canvas_colour colour, double x0, double y0,
                 double x1, double y1);

enum { CANVAS_LINE_SIZE = 12 * CANVAS_COLUMNS + 16 };

/* One row as text, blanks at its end left out, at most CANVAS_LINE_SIZE bytes; returns how many.
 * utf8: false: in ASCII. colours: by escape sequences, plain at the end. */
size_t canvas_row(const canvas *c, int row, bool utf8, bool colours, char *text);

#endif
