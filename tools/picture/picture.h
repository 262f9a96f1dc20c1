/* Pictures of solids in space above a floor, with light, shadow, lines and words: as pixels, for
 * .png, .gif and movies, and as areas of one colour, for .svg.
 *
 *   picture *p = picture_create(960, 640);
 *   picture_look(p, target, up, azimuth, elevation);
 *   picture_fit(p, count, places, 0.8);
 *   picture_floor(p, -0.1, 0.05, 0.4);
 *   picture_tube(p, rings, count, 16, false, &paint);
 *   picture_text(p, 20, 30, 14, PICTURE_LEFT, ink, "t = 0.5 s");
 *   picture_svg(p, &text, &size, &error);
 *   picture_free(p);
 *
 * Lengths in space are in m, places on the picture in pixels from its upper left corner. Memory
 * that runs out while things are added is told by what makes the picture. */
#ifndef TOOLS_PICTURE_PICTURE_H
#define TOOLS_PICTURE_PICTURE_H

#include "autodiff/error.h"

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

typedef struct picture picture;

typedef struct picture_colour {
    float red, green, blue; /* 0 to 1 */
} picture_colour;

/* How solids look. */
typedef struct picture_paint {
    picture_colour colour;
    float opacity; /* 1: nothing is seen behind */
    bool shadow;   /* it throws one on the floor */
} picture_paint;

/* A white sheet. NULL: out of memory. */
picture *picture_create(int width, int height);
void picture_free(picture *p); /* NULL is allowed */
int picture_width(const picture *p);
int picture_height(const picture *p);

/* Takes all things away; the camera stays. */
void picture_clear(picture *p);

/* From "rrggbb"; between the colours of a list [count], at 0 to 1. */
picture_colour picture_rgb(const char *hex);
picture_colour picture_between(const char *const *hex, int count, double at);

/* ---- camera -------------------------------------------------------------------------------- */

/* Towards the target; `up` is a unit vector, angles in rad, the azimuth from `side`, the elevation
 * above the floor. */
void picture_look(picture *p, const double target[3], const double up[3], double azimuth,
                  double elevation);

/* As near as lets all places [count][3] be within this part of the picture, and its middle. */
void picture_fit(picture *p, size_t count, const double *places, double part);

/* Two unit vectors across `up`, from which the azimuth is counted. */
void picture_level(const double up[3], double side[3], double front[3]);

/* x and y, and how far away, m. */
void picture_project(const picture *p, const double place[3], double seen[3]);

/* Unit vectors of the picture: to the right, upwards, to the eye. */
const double *picture_axis(const picture *p, int k);

/* Pixels of a metre at the target. */
double picture_scale(const picture *p);

/* ---- solids -------------------------------------------------------------------------------- */

/* A cross section: the third director is along the tube. */
typedef struct picture_ring {
    double place[3], director[3][3];
    double half[2]; /* along the first two directors */
} picture_ring;

/* Round or, with four corners, rectangular, with both its ends. */
void picture_tube(picture *p, const picture_ring *rings, size_t count, int sides, bool rectangle,
                  const picture_paint *paint);

/* Triangles [count][3] of corners [][3], counterclockwise as seen from outside. */
void picture_mesh(picture *p, const double *corners, const uint32_t *triangles, size_t count,
                  const picture_paint *paint);

/* A thin tube through places [count][3]. */
void picture_thread(picture *p, const double *places, size_t count, double radius,
                    const picture_paint *paint);

/* Moments have two heads. */
void picture_arrow(picture *p, const double from[3], const double vector[3], double radius,
                   int heads, const picture_paint *paint);
void picture_ball(picture *p, const double centre[3], double radius, const picture_paint *paint);

/* ---- floor, lines, words ------------------------------------------------------------------- */

/* A grid at this height along `up`, with shadows on it, that fades towards `reach`. */
void picture_floor(picture *p, double height, double step, double reach);

/* A line through points [count][2], over all solids. */
void picture_line(picture *p, const double *points, size_t count, double width,
                  picture_colour colour);

typedef enum picture_align { PICTURE_LEFT, PICTURE_MIDDLE, PICTURE_RIGHT } picture_align;

/* UTF-8, with a white rim; (x, y) is on the line on which letters stand. */
void picture_text(picture *p, double x, double y, double size, picture_align align,
                  picture_colour colour, const char *text);

/* Its width in pixels, as about all fonts have it. */
double picture_text_width(double size, const char *text);

/* ---- what becomes of it -------------------------------------------------------------------- */

/* rgb [height][width][3], by samples x samples (1 to 4) for each pixel. AD_NO_MEMORY. */
ad_status picture_pixels(const picture *p, int samples, unsigned char *rgb, ad_error *error);

/* A text that the caller frees. AD_NO_MEMORY. */
ad_status picture_svg(const picture *p, char **text, size_t *size, ad_error *error);

#endif
