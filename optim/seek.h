/* A point within ranges whose image, three numbers, is at a given place: the steps of Levenberg and
 * Marquardt's method, from one start. Whoever knows the image evaluates many of these side by side.
 *
 *   optim_seek_start(&seek, count, low, high, place, from);
 *   ... the image of seek.next and its derivative ...
 *   optim_seek_tell(&seek, image, by, true);          seek.x is the best so far, seek.next the next
 */
#ifndef OPTIM_SEEK_H
#define OPTIM_SEEK_H

#include <stdbool.h>

enum { OPTIM_SEEK_MAX = 32 };

/* Damping from which on nothing nearer is found. */
#define OPTIM_SEEK_STUCK 1e4

typedef struct optim_seek {
    int count;
    const double *low, *high; /* [count], borrowed; where they are the same the number stays */
    double place[3];
    double x[OPTIM_SEEK_MAX];              /* of the least distance */
    double next[OPTIM_SEEK_MAX];           /* to be evaluated */
    double by[3 * OPTIM_SEEK_MAX], off[3]; /* at x: derivative of the image, what is missing */
    double distance, damping;
} optim_seek;

/* from [count] is the first to be evaluated. */
void optim_seek_start(optim_seek *s, int count, const double *low, const double *high,
                      const double place[3], const double *from);

/* The image of s->next and its derivative by [3][count]; there: it has one. */
void optim_seek_tell(optim_seek *s, const double image[3], const double *by, bool there);

/* Whether it is within a distance, or cannot come nearer. */
bool optim_seek_is_over(const optim_seek *s, double distance);

#endif
