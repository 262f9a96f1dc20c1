/* Explains a scene in one page, before any training. */
#ifndef TOOLS_PROGRAMS_EXPLAIN_H
#define TOOLS_PROGRAMS_EXPLAIN_H

#include "tools/train/experiment.h"
#include "tools/train/reference.h"

#include <stdio.h>

/* Prints lines of at most 100 columns. r is NULL where the scene names no reference. */
void explain_print(FILE *file, const experiment *e, problem *p, const reference *r);

/* What the members of a family depend on (physics/learn/groups.h), and which ones a network in the
 * strain form is trained by; part of the former. */
void explain_groups(FILE *file, const scene *family, const groups_settings *settings);
void explain_members(FILE *file, const experiment *e);

/* Parameters with ranges, and what is to be found from which measurements; part of the former too.
 */
void explain_parameters(FILE *file, const experiment *e);

/* The table of support (physics/scene/support.h) as a page of Markdown,
 * tools/site/pages/support.md. */
void explain_support(FILE *file);

/* The programs that training runs, those of Gauss-Newton included. */
ad_status explain_programs(FILE *file, const experiment *e, problem *p, ad_error *error);

#endif
