/* A model to be learned: its loss terms, their points, one program each.
 *
 *   loss = sum over terms of weight * mean over points of |residual|^2
 *
 * The terms are those of a model (physics/learn/model.h), dimensionless. Terms that share points
 * (the equations inside) share a tape. With causal weighting (Wang, Sankaran, Perdikaris 2024) the
 * points inside carry weights w_i = exp(-epsilon sum_{k<i} L_k) by slice of time i. L_k is the mean
 * weighted loss of slice k at the last update. The weights are not differentiated. Until the first
 * update only the first slice counts.
 *
 * More weights multiply those of the settings, if wanted, and are not differentiated either;
 * problem_reweigh moves them.
 *
 * Balanced terms (Wang, Teng, Perdikaris 2021; in the form of Wang, Sankaran, Wang, Perdikaris
 * 2023): b_i = sum_j |g_j| / |g_i|. Here g_i is the gradient of term i times its weight, so that
 * every b_i g_i has the same length whatever the weights of the settings. After the first update b
 * is a moving average, b <- memory b + (1 - memory) b_now. No |g_i| is taken for smaller than 1e-6
 * of the sum.
 *
 * Adaptive points: from time to time the residual |r|, the root of the weighted sum of squares of
 * all terms inside, is taken at candidates, and points move to where it is large. Their number
 * stays, so that steps cost the same.
 *   rad (Wu, Zhu, Tan, Kartha, Lu 2023): all points are drawn anew from the candidates, without
 *     replacement, with density |r|^power / mean |r|^power + floor;
 *   rar_g (the same): half of the points make room, a tenth of them each time, for the candidates
 *     where |r| is largest, which then stay;
 *   gaussian (after Bensch et al. 2024): half of the points stay, the others lie around the
 *     candidates where |r| is largest, ten around each, normally distributed. */
#ifndef PHYSICS_LEARN_PROBLEM_H
#define PHYSICS_LEARN_PROBLEM_H

#include "autodiff/ranks.h"
#include "nn/nn.h"
#include "physics/learn/model.h"
#include "physics/numerics/sampling.h"

#include <stdint.h>

#ifdef __cplusplus
extern "C" {
#endif

enum { PROBLEM_EPSILONS_MAX = 16 };

/* Where the points of one set come from. */
typedef struct problem_points {
    int points;
    sampling_kind sampler;
    int resample_every; /* steps between new points; 0: never */
} problem_points;

#define PROBLEM_ADAPTIVE_LIST(X)                                                                   \
    X(PROBLEM_ADAPTIVE_NONE, "none")                                                               \
    X(PROBLEM_ADAPTIVE_RAD, "rad")                                                                 \
    X(PROBLEM_ADAPTIVE_RAR_G, "rar_g")                                                             \
    X(PROBLEM_ADAPTIVE_GAUSSIAN, "gaussian")
#define PROBLEM_ENUM(name, text) name,
typedef enum problem_adaptive_kind {
    PROBLEM_ADAPTIVE_LIST(PROBLEM_ENUM) PROBLEM_ADAPTIVE_COUNT
} problem_adaptive_kind;
#undef PROBLEM_ENUM

/* Of points inside, in place of interior.resample_every. */
typedef struct problem_adaptive {
    problem_adaptive_kind kind;
    int every;           /* steps between moves */
    int candidates;      /* at least as many as points; 0: ten for each */
    double power, floor; /* of rad; above 0, at least 0 */
    double width;        /* of gaussian: standard deviation, in parts of the coordinates' ranges */
} problem_adaptive;

typedef enum problem_balance {
    PROBLEM_BALANCE_NONE,
    PROBLEM_BALANCE_GRADIENT_NORM,
    PROBLEM_BALANCE_COUNT
} problem_balance;

typedef struct problem_settings {
    problem_points interior; /* sets of all of the domain */
    problem_points boundary; /* sets on faces, where the ansatz leaves conditions open */
    problem_points initial;  /* the face where time begins, soft enforcement */
    problem_adaptive adaptive;
    int held_out_points; /* per set, never trained on; others lie in short panels */

    int causal_slices; /* of time; 0: no causal weighting */
    int causal_epsilon_count;
    double causal_epsilon[PROBLEM_EPSILONS_MAX]; /* in turn */
    double causal_threshold; /* the next epsilon when every weight exceeds this */
    int causal_update_every; /* steps between updates of the weights */

    problem_balance balance;
    int balance_every;     /* steps between updates */
    double balance_memory; /* 0 to 1, below 1: what an update keeps of the weights before */
} problem_settings;

problem_settings problem_settings_default(void);

/* NULL, or which field is out of range and what is allowed (static text). */
const char *problem_settings_check(const problem_settings *settings, const physics_model *m);

typedef struct problem problem;

/* Record, transform, compile and sample; every random number follows from `seed`. `settings` is
 * copied; the model, `mlp` and `pool` must outlive the problem. */
ad_status problem_create(const physics_model *m, const nn_mlp *mlp,
                         const problem_settings *settings, uint64_t seed, ad_pool *pool,
                         problem **result, ad_error *error);
void problem_free(problem *p);

/* Go to another window of time; a problem begins in the first. Points and causal weights are made
 * anew, as by problem_create; all windows but the first share their programs. `start`
 * [window_state_numbers] is the state in which the one before ends, borrowed; the first has none.
 * After an error the problem can only be freed. */
ad_status problem_enter(problem *p, int window, const double *start, ad_error *error);

/* Let only a factor of the loads act, 0 to 1, and the imperfection to the rest; a problem begins
 * with all of them, factor 1. Nothing is made anew. Needs a model that takes a load factor. */
void problem_load(problem *p, double factor);

/* The unknowns of a scene stay at their guesses, and its measurements do not count, until they are
 * released: what they seem to be beside equations that are not met yet may be far off. The loss is
 * another function then. */
bool problem_holds_unknowns(const problem *p);
void problem_release_unknowns(problem *p);

/* How many times the equations have been recorded and compiled so far, and the seconds that took.
 */
typedef struct problem_compilations {
    int count;
    double seconds;
} problem_compilations;

problem_compilations problem_compiled(const problem *p);

/* Have the programs of training as machine code, which gives the same bits (ad_fuse_begin), as far
 * as they have been made. It takes what is kept in `folder`. It compiles the others in the
 * background, one after the other, or waits for them. To be called again from time to time until
 * all are. Errors as there; the first of them, once. */
typedef enum problem_fuse_way {
    PROBLEM_FUSE_KEPT,
    PROBLEM_FUSE_COMPILE,
    PROBLEM_FUSE_WAIT
} problem_fuse_way;

typedef struct problem_fusing {
    int programs, fused;
} problem_fusing;

ad_status problem_fuse(problem *p, const char *folder, problem_fuse_way way, problem_fusing *state,
                       ad_error *error);

const ad_ranks *problem_ranks(const problem *p);            /* that share it, or NULL */
size_t problem_parameters(const problem *p);                /* length of x */
int problem_views(const problem *p, const nn_view **views); /* the network's, nn_mlp_views */

/* The terms of this scene, in a fixed order, by index. */
int problem_terms(const problem *p);
const char *problem_term_name(const problem *p, int term);
double problem_term_weight(const problem *p, int term);
bool problem_term_is_held_out(const problem *p, int term); /* part of the held-out loss */

/* Loss and gradient [parameters] (NULL: not wanted) at x. Allocates nothing after the first call.
 * AD_NOT_FINITE when the loss or its gradient is not. */
ad_status problem_evaluate(problem *p, const double *x, double *loss, double *gradient,
                           ad_error *error);

/* The loss as a sum of squares of residuals, each times sqrt(weight / points); all weights are
 * taken as constants. */
typedef struct problem_least_squares {
    size_t rows;  /* residuals that parameters move, over all points */
    size_t bytes; /* of the workspaces, and of what is kept per point */
    size_t inner; /* products for an entry of J^T J: as many, or fewer where blocks are known */
    size_t slab_bytes; /* of the rows of J that the normal equations keep at a time */
} problem_least_squares;

/* Records and compiles what the next two need, unless it has been done. */
ad_status problem_prepare_least_squares(problem *p, problem_least_squares *info, ad_error *error);

/* loss, the upper triangle of J^T J [parameters][parameters] (0 below) and J^T r [parameters], half
 * the gradient, at x. Allocates nothing after the first call. AD_NOT_FINITE as above. */
ad_status problem_normal_equations(problem *p, const double *x, double *loss, double *jtj,
                                   double *jtr, ad_error *error);

/* Networks that are linear in their parameters, weights [outputs][features] and biases [outputs],
 * and of whose outputs each has residuals of its own. The block of J^T J for output i is
 * factors[i]^2 times one matrix [features + 1][features + 1], the last row that of the bias. Blocks
 * of two outputs are 0. Whether that is so; its size, and the factors (NULL: not wanted). */
bool problem_separates(const problem *p, size_t *size, double *factors);
/* That matrix, its upper triangle (0 below). AD_NOT_FINITE as above. */
ad_status problem_separate_matrix(problem *p, double *matrix, ad_error *error);

/* The terms of measurements (sets of points that the model draws from a source), whose residuals
 * are independent numbers of variance 1: the sum of their squares, their number, and their
 * information on all parameters. The latter is the upper triangle of sum_k J_k^T J_k / v_k
 * [parameters][parameters], with J_k their rows in the normal equations and v_k the variance of
 * these rows. */
typedef struct problem_noise {
    double chi_squared;
    size_t numbers;
    double variance; /* of the rows, the largest of all sets */
} problem_noise;

ad_status problem_noise_of(problem *p, const double *x, double *by_noise, problem_noise *noise,
                           ad_error *error);

/* J by columns, jt [parameters][rows], r [rows], J^T r and the diagonal of J^T J
 * [parameters]. jt has to be 0 before the first call: an entry that is always 0 is not written. */
ad_status problem_jacobian(problem *p, const double *x, double *loss, double *jt, double *r,
                           double *jtr, double *diagonal, ad_error *error);

/* J^T J v [parameters] at x, by a program that is compiled when it has not been; no rows of J are
 * kept. rows and bytes of info are written. AD_NOT_FINITE as above. */
ad_status problem_prepare_product(problem *p, problem_least_squares *info, ad_error *error);
ad_status problem_normal_product(problem *p, const double *x, const double *v, double *product,
                                 ad_error *error);

/* The loss terms of the last problem_evaluate, unweighted: [problem_terms]. */
const double *problem_losses(const problem *p);

/* Value and gradient of one term alone, unweighted; for gradient checks. Slower. */
ad_status problem_evaluate_term(problem *p, int term, const double *x, double *loss,
                                double *gradient, ad_error *error);

/* The key of a formula of the scene that jumps in places that are not found, or varies on lengths
 * that no panel follows (physics/scene/breaks.h); NULL: there is none. */
const char *problem_unresolved(const problem *p);

/* The loss on the points never trained on, by the weights of the settings alone; terms
 * [problem_terms] may be NULL. Some of these points lie wherever formulas of the scene vary on
 * short lengths, so that nothing is overlooked that falls between points. */
ad_status problem_held_out(problem *p, const double *x, double *loss, double *terms,
                           ad_error *error);

/* What is due before step `step` = 1, 2, ...: new points, which may move to where residuals are
 * large at x, new data, which may follow the network at x, new causal weights. *changed says that
 * the loss is another function now. AD_NOT_FINITE when such a residual is not; errors of sources of
 * data. */
ad_status problem_advance(problem *p, int64_t step, const double *x, bool *changed,
                          ad_error *error);

/* New balanced weights where they are due before step `step` at x, which is where problem_evaluate
 * was called last or a step further. For optimisers that follow the gradient of a
 * loss that changes. *changed as above. Allocates nothing after the first call. AD_NOT_FINITE when
 * a gradient is not. */
ad_status problem_reweigh(problem *p, int64_t step, const double *x, bool *changed,
                          ad_error *error);

/* Causal weighting: the epsilon in force and the smallest weight; 0 and 1 without. */
double problem_causal_epsilon(const problem *p);
double problem_causal_least_weight(const problem *p);

/* The balanced weight of a term, by which that of the settings is multiplied; 1 without. */
double problem_balance_weight(const problem *p, int term);

/* Where a loss term stops being finite at x; *term = -1 if every term is finite. */
typedef struct problem_place {
    int term;
    double x[DOMAIN_COORDINATES_MAX]; /* the coordinates, in SI units */
} problem_place;

/* "s = 0.1 m, t = 2 s", of any coordinates. */
void problem_place_text(const problem *p, const problem_place *place, char *text, size_t size);

ad_status problem_locate(problem *p, const double *x, problem_place *place, ad_error *error);

/* ---- state as a value ---------------------------------------------------------------------- */

/* Points that have not moved since they were drawn follow from where their generator was before. */
typedef struct problem_drawn {
    bool still; /* false: they have moved, or a source may have */
    sampling_kind sampler;
    nn_rng before;
} problem_drawn;

/* Live memory that a checkpoint writes, and fills in place to restore: point sets
 * [coordinates][points], their data, weights, and the states of the generators. */
typedef struct problem_array {
    char name[MODEL_NAME + 24];
    double *data;
    size_t rows, columns;
    bool given; /* as the set's source has it once and for all: a checkpoint has the same */
    problem_drawn *drawn; /* of points, or NULL: while they are still, `before` stands for `data`,
                             which may have those of this rank alone */
} problem_array;

typedef struct problem_generator {
    const char *name;
    nn_rng *rng;
} problem_generator;

enum { PROBLEM_STATE_MAX = 4 * MODEL_SETS_MAX + 8 };

int problem_state(problem *p, problem_array *arrays, problem_generator *generators,
                  int *generator_count);

/* Call it after a restore: draws points that are still, AD_BAD_INPUT when a point or weight lies
 * where none can be. */
ad_status problem_restored(problem *p, ad_error *error);

/* ---- what was built ------------------------------------------------------------------------- */

/* One set of points and the program that serves it. */
typedef struct problem_set_info {
    const char *name;
    size_t points, held_out;
    ad_tape_counts tape;       /* before: recorded; after simplification: stored */
    ad_program_info program;   /* value and gradient */
    size_t fixed_instructions; /* run once for a set of points, not in every step */
    int fixed_rows;            /* numbers kept per point for that */
} problem_set_info;

int problem_sets(const problem *p);
problem_set_info problem_set_inspect(const problem *p, int set);

/* The programs of every set that have been compiled, line by line as ad_program_print. */
void problem_print(const problem *p, FILE *file);

/* The derivatives of the unknowns that the equations inside use, as text: "r_s r_tt q_s ...". */
const char *problem_derivatives(const problem *p);

/* Bytes that a process by itself holds for the loss and its gradient: points, workspaces, sums. */
size_t problem_bytes(const problem *p);

#ifdef __cplusplus
}
#endif

#endif
