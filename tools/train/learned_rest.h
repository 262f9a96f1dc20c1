/* What a rod at rest leaves of its measurements, learned: outputs are names of the scene's
 * formulas, such as amplitudes of a wrench along the rod, and a network of what is known of each
 * experiment says them. Beside it stand physics alone, and a network alone from the same inputs to
 * what is measured. */
#ifndef TOOLS_TRAIN_LEARNED_REST_H
#define TOOLS_TRAIN_LEARNED_REST_H

#include "physics/solve/measured.h"
#include "tools/train/learned_fit.h"

typedef struct learned_asked {
    int outputs;           /* the last unknowns of the open scene */
    int inputs;            /* 0: none */
    const quantity *input; /* [inputs] formulas of the known parameters */
    int hidden_count;
    const int *hidden;    /* [hidden_count] */
    const double *common; /* [others] values of the other unknowns, where the search begins */
    int sets, held_out;   /* of measured [sets + held_out] the last are not fitted */
    const solve_measured *measured;
    double tolerance; /* as of solve_trials_create */
    int threads;
    learned_settings fit;
} learned_asked;

/* Errors on some rows. Distances and deviations in the unit of what is measured. */
typedef struct learned_score {
    size_t rows, numbers;
    double mean, median; /* distance of a row, from all its numbers together */
    double rms;          /* the same, root mean square */
    double deviation;    /* as predicted: root mean square of a row's */
    double covered[2];   /* part of the numbers within one and two deviations */
} learned_score;

typedef enum learned_kind {
    LEARNED_PHYSICS,
    LEARNED_NETWORK,
    LEARNED_BOTH,
    LEARNED_KINDS
} learned_kind;

typedef struct learned_result {
    bool made; /* a network alone needs places that experiments share */
    learned_score trained, held_out;
    learned_report report;
    double seconds;
} learned_result;

typedef struct learned_rest learned_rest;

/* The scene's formulas must outlive it; `open` and all that is asked for are borrowed. Errors as of
 * solve_trials_create, AD_BAD_INPUT: no solution where the search begins. */
ad_status learned_rest_create(const scene *open, const learned_asked *asked, learned_rest **result,
                              ad_error *error);
void learned_rest_free(learned_rest *rest); /* NULL is allowed */

size_t learned_rest_experiments(const learned_rest *rest); /* that are fitted */

/* *over false: a runner has left it. */
ad_status learned_rest_run(learned_rest *rest, learned_kind kind, learned_result *result,
                           bool *over, ad_error *error);

/* All choices of so many fitted experiments that are left out, at most so many choices, else drawn
 * by the seed: mean distances of the rows left out [*choices], by kind. The caller frees. */
ad_status learned_rest_leave_out(learned_rest *rest, int count, int most, double **distance,
                                 int *choices, ad_error *error);

/* What was learned by the last run of LEARNED_BOTH: the net, its numbers, and values of the other
 * unknowns. */
const learned_net *learned_rest_net(const learned_rest *rest);
double *learned_rest_theta(const learned_rest *rest);
const double *learned_rest_common(const learned_rest *rest);
double learned_rest_common_deviation(const learned_rest *rest, int unknown);
/* Standard deviation of a measured number beside what was learned, in its unit; NaN: several. */
double learned_rest_noise(const learned_rest *rest);
double *learned_rest_covariance(const learned_rest *rest); /* [count][count], as theta */

#endif
