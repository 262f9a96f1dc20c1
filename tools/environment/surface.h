/* A surface of triangles from a file, and what is wrong with it. STL, binary or as text, and OBJ;
 * corners at the same place are one. */
#ifndef ENVIRONMENT_SURFACE_H
#define ENVIRONMENT_SURFACE_H

#include "autodiff/error.h"

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

#define SURFACE_NONE UINT32_MAX

typedef struct surface {
    char *name; /* of the file */
    size_t corners, triangles;
    double *corner;      /* [corners][3], m */
    uint32_t *triangle;  /* [triangles][3], corners counterclockwise as seen from outside */
    uint32_t *neighbour; /* [triangles][3], across the edge from a corner to the next; or
                          * SURFACE_NONE */
    uint32_t *line;      /* [triangles] of the file; NULL: it is binary */
    double low[3], high[3];
    uint64_t hash; /* of the file's bytes, the unit and where it is placed */
} surface;

/* unit: m of one unit of the file. AD_IO; AD_BAD_INPUT with file and line: it is none of these
 * formats, is cut off, has what is not a number, or no triangle; a triangle without area.
 * AD_NO_MEMORY. */
ad_status surface_read(const char *path, double unit, surface **result, ad_error *error);
void surface_free(surface *of); /* NULL is allowed */

/* Turns it by a quaternion of any length, then moves it to a position, m. */
void surface_place(surface *of, const double position[3], const double rotation[4]);

/* Whether it has an inside: each edge has two triangles, which turn the same way, and the volume is
 * positive. AD_BAD_INPUT says which edge, and its place. */
ad_status surface_check_closed(const surface *of, ad_error *error);

/* Whether its size goes with a robot of that length, which it does not where mm are taken for m.
 * AD_BAD_INPUT. */
ad_status surface_check_size(const surface *of, double length, ad_error *error);

#endif
