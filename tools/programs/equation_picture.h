/* A picture of a solution of equations of one's own: curves over the first coordinate at some
 * values of the second, or a map where both are of space. Any others are in their middle, time at
 * its end. */
#ifndef TOOLS_PROGRAMS_EQUATION_PICTURE_H
#define TOOLS_PROGRAMS_EQUATION_PICTURE_H

#include "tools/library/cpinn.h"

/* Of the first field, to a file .svg or .png. */
ad_status equation_picture_write(const cpinn_fit *fit, const char *title, const char *path,
                                 ad_error *error);

#endif
