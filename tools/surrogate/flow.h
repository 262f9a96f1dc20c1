/* The network of kind `flow` and its loss; not for others. */
#ifndef SURROGATE_FLOW_H
#define SURROGATE_FLOW_H

#include "tools/surrogate/training_parts.h"

typedef struct surrogate_flow surrogate_flow;

/* What is learned beside the state: the end of a step, or nodes of a curve, the end first, with one
 * network but for its output layers. */
typedef struct surrogate_node {
    const surrogate_step *m; /* has its layers; its numbers but those of the network are known */
    const double *next;      /* [count][states] */
} surrogate_node;

/* q: of surrogate_gramian. Borrows models and the pool. */
ad_status surrogate_flow_create(int nodes, const surrogate_node *node, const surrogate_steps *steps,
                                const double *q, ad_pool *pool, surrogate_flow **result,
                                ad_error *error);
void surrogate_flow_free(surrogate_flow *flow); /* NULL is fine */

/* Those of the hidden layers; the first ones of the network's. */
size_t surrogate_flow_parameters(const surrogate_flow *flow);
void surrogate_flow_start(const surrogate_flow *flow, uint64_t seed, double *parameters);

/* An optim_objective: the loss over that of the linear map alone. */
int surrogate_flow_evaluate(void *flow, const double *parameters, double *value, double *gradient);

/* All numbers of the networks [nodes], output layers included; false: not finite. */
bool surrogate_flow_finish(surrogate_flow *flow, const double *parameters, double *const *network);

#endif
