/* What a network of a family in the strain form learns from and is measured by: members that the
 * solver of members has solved (physics/chain/solve_members.h).
 *
 *   solved    a pool of members, drawn and solved once; a step takes some of it, at random
 *   physics   members that are new in every step: from what the network says of them a step of
 *             Newton's method, that is, its residual preconditioned by its Jacobian; the few for
 *             which that is not trusted are solved
 *   both      half of each step's members of either kind
 *
 * Members of the pool are drawn from the ranges by the scales of the parameters, or those of a
 * file; fresh and held-out ones, by which a network is measured, uniformly from the ranges. Those
 * that are not solved are left out. */
#ifndef TOOLS_TRAIN_TARGETS_H
#define TOOLS_TRAIN_TARGETS_H

#include "physics/chain/solve_members.h"
#include "physics/learn/family.h"
#include "physics/numerics/sampling.h"

#ifdef __cplusplus
extern "C" {
#endif

#define TARGETS_LIST(X)                                                                            \
    X(TARGETS_SOLVED, "solved")                                                                    \
    X(TARGETS_PHYSICS, "physics")                                                                  \
    X(TARGETS_BOTH, "both")

typedef enum targets_kind {
#define TARGETS_ENUM(name, text) name,
    TARGETS_LIST(TARGETS_ENUM)
#undef TARGETS_ENUM
        TARGETS_COUNT
} targets_kind;

/* Fresh members by which networks are measured, and points along the rod of theirs. */
enum { TARGETS_FRESH = 1024, TARGETS_POINTS = 21 };

typedef struct targets_settings {
    int solved;            /* members of the pool */
    const char *file;      /* or a table of them (tools/train/members_given.h); NULL: none */
    sampling_kind sampler; /* of the pool; no grid */
    groups_settings inputs;
    const ad_ranks *ranks; /* that share the solving of members (physics/chain/solve_members.h) */
} targets_settings;

typedef struct targets targets;

/* Of a family of scenes, which outlives it; no member is drawn yet. AD_NO_MEMORY; AD_BAD_INPUT,
 * AD_BAD_ARGUMENT: what solve_members_create and groups_find say. */
ad_status targets_create(const scene *family, const targets_settings *settings, ad_pool *pool,
                         targets **result, ad_error *error);
void targets_free(targets *t); /* NULL is allowed */

/* Draws and solves pool and fresh members, and fits the family to them; every random number follows
 * from the seed. AD_BAD_INPUT: hardly any member has a solution; the file. */
ad_status targets_draw(targets *t, uint64_t seed, ad_error *error);

family *targets_family(targets *t);
solve_members *targets_solver(targets *t);

/* Of the set of points of the family's model. */
model_source targets_source(targets *t);
void targets_use(targets *t, targets_kind kind);

/* What drawing took, how the members drawn ended, and how many are in the pool. */
typedef struct targets_account {
    size_t drawn, solved;
    size_t ends[SOLVE_MEMBER_ENDS]; /* of those drawn */
    double seconds;
} targets_account;

targets_account targets_drawn(const targets *t);

/* Why members are not solved and where they lie; "" if all are solved. As " (7: its stable
 * equilibria end on the way to the whole load), all with push 0.25 to 0.4", by the parameters of
 * which they leave out a tenth of the range at least. */
enum { TARGETS_TEXT = 1000 };
void targets_unsolved_text(const targets *t, char text[TARGETS_TEXT]);

/* Over the fresh members the largest distance of each from its solution, over the length: of the
 * network's own shapes, and of those after one step of Newton's method. */
typedef struct targets_errors {
    double median, most, worst; /* most: 95 % are below */
    double polished_median, polished_most, polished_worst;
} targets_errors;

ad_status targets_measure(targets *t, const nn_mlp *mlp, const double *weights,
                          targets_errors *errors, ad_error *error);

#ifdef __cplusplus
}
#endif

#endif
