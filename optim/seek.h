/* A point within ranges whose image, some numbers, is at a given place: the steps of Levenberg and
 * Marquardt's method, from one start. Whoever knows the image evaluates many of these side by side.
 *
 *   optim_seek_start(&seek, count, low, high, 3, place, from);
 *   ... the image of seek.next and its derivative ...
 *   optim_seek_tell(&seek, image, by, true);          seek.x is the best so far, seek.next the next
 */
#ifndef OPTIM_SEEK_H
#define OPTIM_SEEK_H

#include <stdbool.h>

enum { OPTIM_SEEK_MAX = 32, OPTIM_SEEK_IMAGES = 4 };

/* Damping from which on nothing nearer is found. */
#define OPTIM_SEEK_STUCK 1e4

typedef struct optim_seek {
    int count;
    const double *low, *high; /* [count], borrowed; where they are the same the number stays */
    int images;               /* numbers of an image, at most OPTIM_SEEK_IMAGES */
    double place[OPTIM_SEEK_IMAGES];
    double x[OPTIM_SEEK_MAX];                      /* of the least distance */
    double next[OPTIM_SEEK_MAX];                   /* to be evaluated */
    double by[OPTIM_SEEK_IMAGES * OPTIM_SEEK_MAX]; /* at x: the derivative of the image, */
    double off[OPTIM_SEEK_IMAGES];                 /* what is missing */
    double distance, damping;
} optim_seek;

/* from [count] is the first to be evaluated. */
void optim_seek_start(optim_seek *s, int count, const double *low, const double *high, int images,
                      const double *place, const double *from);

/* The image of s->next and its derivative by [images][count]; there: it has one. */
void optim_seek_tell(optim_seek *s, const double *image, const double *by, bool there);

/* Whether it is within a distance, or cannot come nearer. */
bool optim_seek_is_over(const optim_seek *s, double distance);

#endif
