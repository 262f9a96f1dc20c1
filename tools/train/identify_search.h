/* What the search for unknowns and what is known behind it share. */
#ifndef TOOLS_TRAIN_IDENTIFY_SEARCH_H
#define TOOLS_TRAIN_IDENTIFY_SEARCH_H

#include "tools/train/identify.h"

enum { MAX = SCENE_PARAMETERS_MAX, STARTS = 32, DESCENTS = 6 };

/* Starts and bounds keep so far from the ends of a range, as part of it. */
static const double EDGE = 1e-2;

/* Another end of the search is as good where its chi squared is larger by no more than this. */
static const double AS_GOOD = 9;

typedef struct descent {
    double z[MAX], chi_squared, steps;
    double converged; /* 0, 1 */
    double again;     /* so often it has begun once more */
} descent;

/* Starts from where the residuals are smallest within some distance, each time, which finds all
 * minima in the limit of many points (Rinnooy Kan & Timmer, Mathematical Programming 39 (1987) 57).
 * All that a checkpoint keeps beside residuals: nothing but doubles. */
typedef struct starts {
    double every; /* of the experiments each so many-th counts; 1 in the end */
    double count, ends;
    double z[STARTS][MAX], chi_squared[STARTS]; /* INFINITY: no solution, or not to be tried */
    double tried[STARTS];
    descent end[DESCENTS]; /* with those that count */
    double few_ends, settled;
    descent few[DESCENTS]; /* ends with some; `settled` of them are looked at with all */
    double from[MAX];      /* parts of the ranges where the descent at work begins */
    double y[MAX];         /* where r was computed; NaN: nowhere */
    double easy; /* members were solved where this descent began: steps to where they are not,
                  * which single solutions might reach after minutes, are too long */
    double solutions;
} starts;

/* The unknowns of the search are y = log(z / (1 - z)), z the part of the range, 0 to 1: no step
 * leaves a range. */
typedef struct search {
    const scene *open;
    bool noise_is_scaled, settles;
    solve_trials *trials;
    int count;
    size_t n, counted; /* residuals; those that are not 0 because others count */
    double exact;      /* chi squared below which residuals mean nothing */
    double difference; /* of z, to both sides, where derivatives are not known */
    double *room;      /* [2 count][n] residuals of trials */
    double *r;         /* [n] at y */
    double *j;         /* [count][n] by z */
    starts all;
    least_squares ls; /* by y */
    ad_error error;   /* what stops the search */
    ad_memory memory;
} search;

/* Values of the unknowns at parts z of their ranges. */
void identify_values(const search *search, const double *z, double *values);

/* residuals [trials][n] at parts z [trials][count] of the ranges; `rough`: an idea is enough. */
ad_status identify_run(search *search, bool rough, size_t trials, const double *z,
                       double *residuals, ad_error *error);

/* j around z; r is there. An optim_objective's code. */
int identify_differentiate(search *search, const double *z);

/* J^T J and J^T r, by unknowns of which the parts of the ranges go as slope [count], NULL: 1. */
void identify_multiply(search *search, const double *slope);

/* So that each so many-th experiment is enough for an idea. */
size_t identify_few(const search *search);

/* What stopped the search. */
ad_status identify_stopped(const search *search, ad_error *error);

/* What is known where the best descent, the first, has ended. */
ad_status identify_conclude(search *search, identified *result, ad_error *error);

#endif
