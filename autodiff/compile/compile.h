/* A compilation at work (compile.c, stages.c). Private to autodiff. */
#ifndef AD_COMPILE_H
#define AD_COMPILE_H

#include "autodiff/compile/program.h"

/* Working memory of one compilation; arrays by node id. */
typedef struct compilation {
    ad_program *program;
    ad_tape *tape;
    bool *needed;
    int *stage; /* passes that must be over before the node can be evaluated */
    int *uses;
    int *sum_of;  /* reductions and sums of reductions: the node that holds the whole sum, or -1 */
    bool *in;     /* needed in the pass at hand */
    int *home;    /* of values of members: stage of the pass that computes it, -1: none has yet */
    bool *kept;   /* lies in the memory of the members */
    bool *stored; /* is put there by the pass at hand */
    int stages;
} compilation;

static inline int argument(const compilation *c, int id, int i)
{
    return c->tape->arguments[c->tape->nodes[id].first + i];
}

/* The stage of every node, sums that are one sum, and the passes. False: out of memory. */
bool ad_stages_assign(compilation *c);

/* Is a sum, or a sum of sums, added up by a pass? */
bool ad_stages_summed_by(const compilation *c, int id, const pass *p);

/* Is a value of members there when a pass over the members begins? */
bool ad_stages_is_there(const compilation *c, int id, const pass *p);

/* What a pass computes, and what of it goes into the memory of the members: in c->in, c->stored.
 * False: nothing. */
bool ad_stages_mark(compilation *c, const pass *p);

#endif
