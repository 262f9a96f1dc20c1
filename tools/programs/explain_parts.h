/* What the parts of the page of --explain share: its lines of at most 100 columns. */
#ifndef TOOLS_PROGRAMS_EXPLAIN_PARTS_H
#define TOOLS_PROGRAMS_EXPLAIN_PARTS_H

#include "tools/programs/explain.h"

/* A paragraph puts words behind one another and goes on under `indent` when a line is full. */
typedef struct paragraph {
    FILE *file;
    int indent, column;
} paragraph;

void explain_heading(FILE *file, const char *text);
paragraph explain_paragraph_begin(FILE *file, const char *label);
void explain_paragraph_add(paragraph *p, const char *text, bool comma);

/* Tapes, memory and steps of training. r: as for explain_print. */
void explain_costs(FILE *file, const experiment *e, problem *p, const reference *r);

#endif
