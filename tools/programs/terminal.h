/* A picture at the end of what a program has printed on a terminal, drawn again in place. The
 * terminal is never put into another state that would have to be undone: no other screen, no hidden
 * cursor, and colours end with each line; so that whatever ends the program leaves the picture, and
 * the cursor below it. */
#ifndef TOOLS_PROGRAMS_TERMINAL_H
#define TOOLS_PROGRAMS_TERMINAL_H

#include "tools/programs/canvas.h"

#include <stdio.h>

typedef struct terminal {
    FILE *file;
    bool utf8, colours;
    int columns, rows; /* when the picture was drawn */
    int shown;         /* lines of the picture that is there */
    char text[CANVAS_ROWS * (CANVAS_LINE_SIZE + 8) + 64];
} terminal;

/* False: the file is no terminal, or one whose cursor cannot be moved (TERM). */
bool terminal_begin(terminal *t, FILE *file);

/* Room for a picture: one column less than the terminal has, where lines would wrap, and one row
 * for the cursor. As it is now; the terminal may change at any time. */
void terminal_room(const terminal *t, int *columns, int *rows);

/* In place of the one before. A terminal that is smaller since then is cleared first, as nobody
 * knows what has become of the lines. */
void terminal_show(terminal *t, const canvas *picture);

/* Takes the picture away; what is printed next begins where it began. */
void terminal_clear(terminal *t);

#endif
