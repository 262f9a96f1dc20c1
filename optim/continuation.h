/* The way from an unloaded rod to its loads, where Gauss-Newton does not find the loaded shape at
 * once: solve for a part of the loads, start from there for a larger part, and so on. Continuation
 * with secant prediction (Allgower and Georg, Introduction to Numerical Continuation Methods,
 * chapter 2): a part starts from the straight line through the last two solutions. Without it rods
 * that are wound up several times were measured not to arrive. The increment is halved whenever a
 * part is not solved, and never grows: growing ones fail at every other part, which costs more.
 *
 * Nothing but numbers: the trainer applies the parts. */
#ifndef OPTIM_CONTINUATION_H
#define OPTIM_CONTINUATION_H

#include <stdbool.h>
#include <stddef.h>

typedef struct optim_continuation {
    size_t count;     /* of parameters */
    double part;      /* of the loads, at work */
    double reached;   /* the largest that has been solved; 0 at first */
    double before;    /* the one solved before that; NaN: none */
    double increment; /* from `reached`; 0: given up, all loads are at work for the last time */
    double *solved;   /* [2][count] parameters for `reached` and `before`; owned */
} optim_continuation;

/* A path from parameters 0, the unloaded rod, that tries all loads first or, `gradual`, an eighth
 * of them. False: out of memory. */
bool optim_continuation_create(optim_continuation *path, size_t count, bool gradual);
void optim_continuation_free(optim_continuation *path); /* a path of zeros is fine */

/* The part at work has been solved, or not, with parameters x [count]. True: another part is at
 * work now, and x is where to start; false: the path has ended. */
bool optim_continuation_next(optim_continuation *path, bool is_solved, double *x);

/* After a restore: whether the numbers can be those of a path. */
bool optim_continuation_is_sound(const optim_continuation *path);

#endif
