/* What the files of steps of a reduced rod share; not for others. */
#ifndef PHYSICS_CHAIN_MODES_STEP_INTERNAL_H
#define PHYSICS_CHAIN_MODES_STEP_INTERNAL_H

#include "physics/chain/modes_internal.h"
#include "physics/chain/modes_step.h"

#include <complex.h>

enum { COLLOCATION_PAIRS = (COLLOCATION_STAGES_MAX + 1) / 2 };

/* A method with its eigenvalues: one that is real comes first, then one of each pair. */
typedef struct collocation_method {
    gauss_rule rule;
    int pairs;
    double square[COLLOCATION_STAGES_MAX][COLLOCATION_STAGES_MAX]; /* of its matrix */
    double highest[COLLOCATION_STAGES_MAX]; /* Legendre's coefficient of the highest degree, by
                                               values at nodes */
    double complex eigenvalue[COLLOCATION_PAIRS], to[COLLOCATION_PAIRS][COLLOCATION_STAGES_MAX],
        from[COLLOCATION_STAGES_MAX][COLLOCATION_PAIRS]; /* rows of T^-1, columns of T */
} collocation_method;

/* LU factors of M + h l D + (h l)^2 K, real and imaginary parts [size][size] apart. */
typedef struct collocation_factors {
    double *re, *im;
    int *pivot;
} collocation_factors;

struct collocation {
    modes *m;
    collocation_method by;
    int size;
    const double *after; /* inputs at the end of the step, which go there linearly; NULL: held */
    double step, formed_step; /* 0: none */
    bool has_polynomial;      /* accelerations of a last step, to go on from */
    bool must_form;           /* another matrix for the next step */
    bool asks_power;          /* of the stages: not in steps by themselves */
    double last_step;
    double *from_q, *from_v;  /* [size] where the last step began, */
    solve_energy from_energy; /* with what energy */
    double *memory;
    double *a;                 /* [stages][size] accelerations */
    double *before;            /* [stages][size] of the last step */
    double *residual;          /* [stages][size] */
    double *q, *v;             /* [size] of a stage */
    double *by_q, *by_v;       /* [size][width] */
    double *mass;              /* [size][width] */
    double *change, *right[2]; /* [stages][size]; [size] */
    double *exact;             /* [stages size][stages size + 1] */
    collocation_factors solve[COLLOCATION_PAIRS];
    double load[COLLOCATION_STAGES_MAX], loss[COLLOCATION_STAGES_MAX]; /* powers of each stage */
    collocation_counts counts;
};

void collocation_make_method(int stages, collocation_method *by);

/* The model at the time of stage i, with its inputs. */
ad_status collocation_at(collocation *collocation, int i, double t, double h, const double *inputs,
                         ad_error *error);

/* q, v of stage i in collocation->q, collocation->v, by the accelerations as they are. */
void collocation_stage(collocation *collocation, int i, double h, const double *q, const double *v);

/* Mass and derivatives at the middle stage; LU factors for a step. */
ad_status collocation_form(collocation *collocation, double t, double h, const double *inputs,
                           const double *q, const double *v, ad_error *error);
bool collocation_factor(collocation *collocation, double h);

/* Newton's method to a tolerance; *slow: it took many steps, *failed: too many. */
ad_status collocation_iterate(collocation *collocation, double t, double h, const double *inputs,
                              double tolerance, const double *q, const double *v, bool *slow,
                              bool *failed, ad_error *error);

/* Adds collocation->change to the accelerations; by how much it moves modes, and their rates, at
 * most. */
double collocation_change(collocation *collocation, double h);

/* q, v at the end of the step. */
void collocation_finish(const collocation *collocation, double h, double *q, double *v);

#endif
