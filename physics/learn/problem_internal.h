/* What the files of the problem share; not for others. */
#ifndef PHYSICS_LEARN_PROBLEM_INTERNAL_H
#define PHYSICS_LEARN_PROBLEM_INTERNAL_H

#include "physics/learn/motion_network.h"
#include "physics/learn/problem.h"
#include "physics/scene/breaks.h"

enum {
    PROBLEM_TERMS = MODEL_TERMS_MAX,
    PROBLEM_SET_TERMS = MODEL_TERMS_MAX,
    PROBLEM_UNIFORMS = DOMAIN_UNIFORMS_MAX + 1,
    PROBLEM_INPUTS = DOMAIN_COORDINATES_MAX + 2,
    PROBLEM_VIEWS = 2 * (NN_HIDDEN_MAX + 2) + 1,
    PROBLEM_FIXED_ROWS = 1024,
    PROBLEM_FIXED_BYTES = 16 << 20 /* of numbers kept per point set */
};

/* Points, dimensionless. Where ranks share them each has those that it takes, all at their places.
 */
typedef struct problem_cloud {
    double *x;    /* [coordinates][count], of each those from `first` to `end` - 1 */
    double *data; /* [source.rows][count]; NULL: none */
    size_t count;
    size_t first, end;
    problem_drawn drawn;
} problem_cloud;

/* A candidate for adaptive points; key: what those with the largest are chosen by. */
typedef struct problem_candidate {
    double key;
    size_t index;
} problem_candidate;

/* What depends on the trained points and on what is set before a run: computed once for both, more
 * inputs of a program. */
typedef struct problem_fixed {
    ad_program *program; /* NULL: there is nothing worth keeping */
    double *values;      /* [rows][trained] */
    int count, rows;
    int offsets[PROBLEM_FIXED_ROWS]; /* first row of each */
    bool stale;                      /* the points or the setting are new */
} problem_fixed;

/* Outputs of a set's programs, in this order: the weighted loss; per term the mean of its squared
 * residual; per point the loss by the weights of the settings (gradient, where points have weights)
 * or per term and point the squared residual (value); per view of the parameters the gradient. */
typedef struct problem_set {
    const model_set *about;
    const problem *problem;
    int terms[PROBLEM_SET_TERMS]; /* numbers of terms of the problem */
    int term_count;
    problem_cloud trained, held_out;
    problem_cloud candidates;  /* of adaptive points; made when they first move */
    double *candidate_squares; /* [term_count][candidates] */
    problem_candidate *ranked; /* [candidates] */
    nn_rng rng;
    ad_program *gradient, *value;
    ad_program *term_gradient[PROBLEM_SET_TERMS];  /* made when asked for */
    ad_normal *normal;                             /* the same */
    ad_program *product;                           /* the same; J^T J v per view */
    int product_rows;                              /* of J, per point */
    ad_program *fields;                            /* the same; of a source that follows them */
    double *field_values;                          /* [rows of all fields][trained] of that */
    ad_program *share_gradient[PROBLEM_SET_TERMS]; /* balanced: points by their weights */
    int view_count;
    size_t view_offsets[PROBLEM_VIEWS];
    problem_fixed gradient_fixed, normal_fixed, product_fixed;
    double *point_weights; /* causal: [trained] */
    double *point_losses;  /* the same, of the last evaluation */
    const double *balance; /* balanced: [term_count] of problem.balance */
    ad_tape_counts counts;
} problem_set;

struct problem {
    const physics_model *model;
    problem_settings settings;
    const nn_mlp *mlp;
    ad_pool *pool;
    uint64_t seed;
    size_t parameters;
    double released;        /* 1: unknowns are trained, and measurements count; 0: not yet */
    int window;             /* at work, from 0 */
    domain_uniforms kinds;  /* of the programs' uniforms */
    domain_setting setting; /* their numbers */
    const model_term *terms[PROBLEM_TERMS];
    int term_count;
    problem_set sets[MODEL_SETS_MAX];
    int set_count;
    double losses[PROBLEM_TERMS];
    double *scratch;                                     /* [parameters] */
    double *pair;                                        /* [2 parameters], x and v of a product */
    double *slice_weights, *slice_losses, *slice_points; /* [slices] */
    double epsilon_index;
    double balance[PROBLEM_TERMS]; /* 1 where terms are not balanced */
    double balance_updates;        /* so far */
    problem_compilations compiled;
    char derivatives[160];
    scene_panels panels[2];              /* of a scene, along s and t; none: no edges */
    motion_network *motion;              /* of a model of such, made when it is needed */
    double *motion_room, *motion_blocks; /* of problem_motion.c */
};

/* problem_points.c */
problem_points problem_points_of(const problem *p, const problem_set *set);
ad_status problem_set_sample(problem *p, problem_set *set, ad_error *error);
ad_status problem_set_resample(problem *p, problem_set *set, ad_error *error);
/* Data for the trained points, by the network at x where they follow it. */
bool problem_set_follows(const problem_set *set);
ad_status problem_set_supply(problem *p, problem_set *set, const double *x, ad_error *error);
/* A cloud with the points of a set, or with none of them yet, and other points in the same memory.
 */
ad_status problem_cloud_make(const problem *p, const problem_set *set, problem_cloud *cloud,
                             const problem_points *points, bool none, nn_rng *rng, ad_error *error);
ad_status problem_cloud_fill(const problem *p, const problem_set *set, problem_cloud *cloud,
                             sampling_kind kind, nn_rng *rng, ad_error *error);
/* Draws points that the cloud does not have yet: these too; all of them again, as they were drawn.
 */
ad_status problem_cloud_hold(const problem *p, const problem_set *set, problem_cloud *cloud,
                             size_t first, size_t end, ad_error *error);
ad_status problem_cloud_redraw(const problem *p, const problem_set *set, problem_cloud *cloud,
                               ad_error *error);
/* From the unit interval to the range of a coordinate: of the first to a piece of it, of time to
 * the window at work. */
double problem_placed(const problem *p, int coordinate, int piece, double x);
void problem_set_forget_points(problem_set *set);
double problem_time_of(const problem *p, const problem_cloud *cloud, size_t point);
bool problem_points_are_inside(const problem *p, const problem_cloud *cloud);

/* problem_motion.c, of a model with a motion, whose only term is of the only set: the mean square
 * of its residuals over a cloud, with squares [points] and gradient [parameters] or NULL; memory
 * for, and then loss, jtj and jtr, which are 0 before. */
ad_status problem_motion_prepare(problem *p, ad_error *error);
ad_status problem_motion_run(problem *p, const problem_cloud *cloud, const double *x,
                             double *squares, double *mean, double *gradient, ad_error *error);
ad_status problem_motion_loss(problem *p, const problem_cloud *cloud, const double *x,
                              double *terms, double *total, double *gradient,
                              ad_error *error); /* weighted */
ad_status problem_motion_least_squares(problem *p, problem_least_squares *info, ad_error *error);
ad_status problem_motion_normal(problem *p, const double *x, double *loss, double *jtj, double *jtr,
                                ad_error *error);

/* problem_set.c */
ad_status problem_set_build(problem *p, problem_set *set, ad_error *error);
void problem_set_clear(problem_set *set);
void problem_set_refresh(problem_set *set); /* the points or the setting are new */

/* The network's fields at the trained points, into set->field_values. */
ad_status problem_set_fields(problem *p, problem_set *set, const double *x, ad_error *error);

/* Run one of the set's programs over a cloud: terms by number, the weighted total, and, when
 * gradient is not NULL, the gradient. */
ad_status problem_set_run(problem_set *set, ad_program *program, const problem_cloud *cloud,
                          const double *x, double *terms, double *total, double *gradient,
                          ad_error *error);
/* Per term and point of a cloud the squared residual, squares [term_count][points]. */
ad_status problem_set_squares(problem_set *set, const problem_cloud *cloud, const double *x,
                              double *squares, ad_error *error);
/* weighted: by the weights of points. */
ad_status problem_set_run_term(problem *p, problem_set *set, int term, bool weighted,
                               const double *x, double *loss, double *gradient, ad_error *error);
/* Rows of the set's Jacobian: compiled when they are not yet, which the others need; the set's part
 * of the normal equations, added; the rows as such, written from row `first` on. */
ad_status problem_set_prepare_normal(problem *p, problem_set *set, ad_error *error);
ad_status problem_set_normal(problem_set *set, const double *x, double *loss, double *jtj,
                             double *jtr, ad_error *error);
ad_status problem_set_jacobian(problem_set *set, const double *x, size_t first, size_t stride,
                               double *jt, double *r, ad_error *error);
/* J^T J v of the set, written; pair is x, then v. */
ad_status problem_set_prepare_product(problem *p, problem_set *set, ad_error *error);
ad_status problem_set_product(problem_set *set, const double *pair, double *product,
                              ad_error *error);
ad_status problem_set_locate(problem *p, problem_set *set, const double *x, problem_place *place,
                             ad_error *error);

/* problem_ranks.c. Whether ranks may have a part of the trained points each; what they may not have
 * yet: those that this rank takes of the first so many in a run of the program, or for the rows of
 * J; all. */
bool problem_set_is_shared(const problem *p, const problem_set *set);
ad_status problem_set_hold(problem_set *set, const ad_program *program, size_t points,
                           ad_error *error);
ad_status problem_set_hold_rows(problem_set *set, ad_error *error);
ad_status problem_set_hold_all(problem_set *set, ad_error *error);

/* problem.c */
problem_set *problem_set_of_term(problem *p, int term);

/* problem_adaptive.c */
const char *problem_adaptive_check(const problem_settings *settings);
void problem_set_forget_candidates(problem_set *set);
/* Whether the points of the set move before this step; to where residuals are large at x. Allocates
 * nothing after the first call. AD_NOT_FINITE when a residual is not. */
bool problem_set_adapts(const problem *p, const problem_set *set, int64_t step);
ad_status problem_set_adapt(problem *p, problem_set *set, int64_t step, const double *x,
                            ad_error *error);

/* problem_weights.c */
const char *problem_weights_check(const problem_settings *settings, const physics_model *m);
bool problem_weights_create(problem *p); /* false: out of memory */
void problem_weights_start(problem *p);  /* as before the first step of a window */
void problem_weights_free(problem *p);
/* Which weights the set has, memory for them, and as they are at first. */
ad_status problem_set_weigh_points(problem *p, problem_set *set, ad_error *error);
size_t problem_weights_per_point(const problem_set *set); /* numbers kept for a point */
void problem_weights_spread(problem *p);      /* weights of slices to points, of variables too */
void problem_weights_follow_time(problem *p); /* new causal weights */
int problem_weights_state(problem *p, problem_array *arrays);
ad_status problem_weights_restored(problem *p, ad_error *error);

/* Whether the terms of a set do not count yet, and the first parameter that is not trained yet. */
bool problem_is_held(const problem *p, const problem_set *set);
size_t problem_first_held(const problem *p);

#endif
