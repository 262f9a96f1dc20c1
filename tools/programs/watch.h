/* Training as a picture on a terminal, drawn again and again in place: curves of loss and error,
 * the rod's shape, and the numbers of the moment. */
#ifndef TOOLS_PROGRAMS_WATCH_H
#define TOOLS_PROGRAMS_WATCH_H

#include "tools/programs/status_line.h"
#include "tools/programs/watch_shapes.h"

typedef struct watch watch;

/* NULL: the file is not a terminal that can show it, or memory lacks; then there are plain lines.
 * The text lives on. */
watch *watch_create(FILE *file, const char *title);
void watch_free(watch *w); /* NULL is allowed; what is on the screen stays there */

/* Loss after every step, at seconds of training; the curve is thinned out as it grows. */
void watch_record(watch *w, double seconds, double loss);

/* Before the first of them: the rows of a run that is resumed. */
void watch_record_rows(watch *w, const history *h);

/* Whether it is time to draw: ten times a second at most, and not so often that it takes more than
 * half a percent of the processor time. */
bool watch_is_due(watch *w);

/* What is drawn beside the curve of the loss. */
typedef struct watch_view {
    status_line line;     /* of the moment */
    const char *over;     /* NULL, or what to say in its place */
    const history *rows;  /* columns seconds, held_out, and error if it is known */
    watch_shapes *shapes; /* NULL: there are none */
    const char *note;     /* a line below the curves; NULL: none */
} watch_view;

void watch_draw(watch *w, const watch_view *view);

/* Lines may be printed between these two; the picture goes on below them. */
void watch_hide(watch *w);
void watch_show(watch *w);

#endif
