/* What physics leaves, learned: numbers that differ between experiments are a network of what is
 * known of each, and others are the same for all. Both are found together by least squares with a
 * ridge on the network, by Levenberg and Marquardt's method through whatever computes residuals.
 *
 * The ridge is chosen by cross-validation among the experiments that are used. There the residuals
 * are linear around a first fit of all of them, so that it takes no solution. Deviations are those
 * of the linearised posterior (MacKay, Neural Computation 4 (1992) 448): with rows g of J by all
 * numbers, H = J^T J + ridge, and the noise s^2 = |r|^2/(n - tr(J H^-1 J^T)), the variance of a
 * residual is s^2 (1 + g H^-1 g^T). The same factor is then put on all, by which those of rows left
 * out by the cross-validation are off. */
#ifndef TOOLS_TRAIN_LEARNED_FIT_H
#define TOOLS_TRAIN_LEARNED_FIT_H

#include "tools/train/learned_net.h"
#include "tools/train/least_squares.h"

typedef struct learned_problem {
    size_t experiments, numbers;
    const size_t *of; /* [numbers] the experiment of each */
    double *x;        /* [inputs][experiments] */
    bool is_linear;   /* residuals are, in values */
    bool is_ordered;  /* experiments are, as those of inputs with a memory: parts of them that are
                       * left out are stretches */
    int common;       /* numbers that are the same for all, of size 1, from 0 on */
    /* residuals [numbers] at values [experiments][common + outputs], and their derivatives by those
     * of their experiment, by [common + outputs][numbers], or NULL. Not numbers: no solution. */
    ad_status (*solve)(void *context, const double *values, double *residuals, double *by,
                       ad_error *error);
    /* x at the common numbers, and its derivatives by them [common][inputs][experiments], or NULL.
     * NULL: x is what it is. */
    ad_status (*look)(void *context, const double *common, double *x, double *by, ad_error *error);
    void *context;
} learned_problem;

typedef struct learned_settings {
    uint64_t seed;
    int folds, steps;
    bool deviations;                    /* are wanted, and their factor */
    const least_squares_runner *runner; /* NULL: none */
} learned_settings;

typedef struct learned_fit learned_fit;

/* net (borrowed) NULL: nothing differs between experiments. Its sizes become those by which
 * residuals change by as much as they are at the start. used [numbers]: what is fitted. Errors of
 * the problem, AD_BAD_INPUT: no residuals at the start; AD_NO_MEMORY. */
ad_status learned_fit_create(const learned_problem *problem, learned_net *net, const bool *used,
                             const learned_settings *settings, learned_fit **result,
                             ad_error *error);
void learned_fit_free(learned_fit *fit); /* NULL is allowed */

/* Whether the search has come to its end: a runner may have left it. */
ad_status learned_fit_run(learned_fit *fit, bool *over, ad_error *error);

/* Then: common numbers, then theta [learned_fit_count]; residuals and standard deviations of what
 * is measured [numbers]; the covariance of the numbers [count][count]. They belong to the fit. */
size_t learned_fit_count(const learned_fit *fit);
double *learned_fit_numbers(const learned_fit *fit);
const double *learned_fit_residuals(const learned_fit *fit);
const double *learned_fit_deviations(const learned_fit *fit);
double *learned_fit_covariance(const learned_fit *fit);

typedef struct learned_report {
    double ridge, noise; /* noise: in units of the residuals */
    double effective;    /* how many numbers the measurements determine, tr(J H^-1 J^T) */
    double calibration;  /* the factor on deviations; 1: none was found */
    double validation;   /* rms of rows left out by the cross-validation; NaN: none */
    int steps;
} learned_report;
learned_report learned_fit_report(const learned_fit *fit);

#endif
