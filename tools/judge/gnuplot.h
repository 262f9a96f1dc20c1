/* Pictures, drawn by gnuplot from scripts that hold their numbers, so that they can be restyled. */
#ifndef TOOLS_JUDGE_GNUPLOT_H
#define TOOLS_JUDGE_GNUPLOT_H

#include "autodiff/error.h"

#include <stdio.h>

/* In gnuplot's single quotes, where a quote is doubled. */
void gnuplot_quoted(FILE *file, const char *text);

/* Writes FOLDER/NAME.gp, as `print` prints it. */
ad_status gnuplot_write(const char *folder, const char *name,
                        ad_status (*print)(FILE *file, const void *context, ad_error *error),
                        const void *context, ad_error *error);

/* Runs gnuplot on it in the folder; a name has less than GNUPLOT_NAME - 8 bytes. AD_IO says that
 * gnuplot is missing or failed, and how to draw the picture later. */
enum { GNUPLOT_NAME = 72 };
ad_status gnuplot_draw(const char *name, const char *folder, ad_error *error);

#endif
