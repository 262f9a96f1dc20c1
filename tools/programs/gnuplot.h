/* Pictures, drawn by gnuplot from scripts that hold their numbers, so that they can be restyled. */
#ifndef TOOLS_PROGRAMS_GNUPLOT_H
#define TOOLS_PROGRAMS_GNUPLOT_H

#include "autodiff/error.h"

#include <stdio.h>

typedef struct gnuplot_picture {
    const char *name;  /* of the files: less than GNUPLOT_NAME - 8 bytes */
    const char *about; /* a comment in the script, lines */
    int width, height; /* points */
    ad_status (*print)(FILE *file, const void *context, ad_error *error); /* data and plot */
    const void *context;
} gnuplot_picture;

/* A picture beside a file "FOLDER/NAME.csv". AD_BAD_ARGUMENT: the name is too long. */
enum { GNUPLOT_NAME = 72 };
typedef struct gnuplot_place {
    char folder[4096], name[GNUPLOT_NAME];
} gnuplot_place;
ad_status gnuplot_beside(const char *path, gnuplot_place *place, ad_error *error);

/* Writes FOLDER/NAME.gp, which draws NAME.svg and NAME.png. */
ad_status gnuplot_write(const gnuplot_picture *what, const char *folder, ad_error *error);

/* Runs gnuplot on it in the folder. AD_IO says that gnuplot is missing or failed, and how to draw
 * the picture later. */
ad_status gnuplot_draw(const char *name, const char *folder, ad_error *error);

#endif
