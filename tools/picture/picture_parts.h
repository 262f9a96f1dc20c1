/* What a picture consists of; for the files of this folder. */
#ifndef TOOLS_PICTURE_PICTURE_PARTS_H
#define TOOLS_PICTURE_PICTURE_PARTS_H

#include "tools/picture/picture.h"

#include <stdint.h>

#define PICTURE_PI   3.14159265358979323846
#define PICTURE_LENS 0.266 /* tangent of half the opening of the view upwards */

typedef struct picture_corner {
    float place[3], normal[3];
} picture_corner;

/* A convex area with its corners in turn. */
typedef struct picture_face {
    uint32_t first;
    int count;
    picture_paint paint;
} picture_face;

typedef struct picture_stroke {
    size_t first, count; /* points */
    double width;
    picture_colour colour;
} picture_stroke;

typedef struct picture_word {
    double x, y, size;
    picture_align align;
    picture_colour colour;
    char *text;
} picture_word;

struct picture {
    int width, height;
    double target[3], up[3], axis[3][3], distance, shift[2]; /* pixels */
    picture_corner *corners;
    picture_face *faces;
    double (*points)[2];
    picture_stroke *strokes;
    picture_word *words;
    size_t corner_count, face_count, point_count, stroke_count, word_count;
    size_t corner_room, face_room, point_room, stroke_room, word_room;
    bool has_floor, failed; /* memory ran out */
    double floor, step, reach;
};

/* The lines of the floor's grid: from and to [2] in pixels; false: there is no such line. They
 * fade with picture_fade. */
bool picture_grid_line(const picture *p, int k, double from[2], double to[2]);

/* The ellipse on the picture where the floor has faded. */
void picture_floor_seen(const picture *p, double centre[2], double radii[2]);

/* Where the shadow of a place is, pixels. */
void picture_shadow(const picture *p, const float place[3], double seen[2]);

/* The colour that a surface has there, `normal` need not be a unit vector and may look away. */
picture_colour picture_light(const picture *p, const float place[3], const float normal[3],
                             picture_colour colour);

/* How much of it hides what is behind: what is seen through hides more at its edges. */
float picture_hides(const picture *p, const float place[3], const float normal[3], float opacity);

/* Whether the eye sees the face from outside. */
bool picture_faces_eye(const picture *p, const picture_face *face);

/* Strokes of a text at (0, 0): points with y downwards, by size. `draw` gets each line. */
typedef void (*picture_pen)(void *context, const double *points, size_t count);
double picture_write(const char *text, double size, picture_pen draw, void *context);

extern const char *const picture_text_letters[]; /* lines of letters.txt, see letters.c */

#endif
