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

/* Stretches of springs of Maxwell branches at the stages: they are linear in rates of strains,
 *
 *   x = left x0 + sum over stages of by (v + rest_rate),
 *
 * as d_t = v + rest_rate - d/T makes (1 + h A/T) x = x0 + h A (v + rest_rate). Rows [size]. */
typedef struct collocation_branch {
    double *left;              /* [stages] */
    double *by;                /* [stages][stages] */
    double *start, *from;      /* of this step, and of the last */
    double *stretch, *change;  /* [stages], and d_t of the last step */
    double *rate, *rest_rate;  /* [stages] 1/T, and of the rest shape */
    double *matrix, *relaxing; /* [size][width] and 1/T where Newton's matrix was formed */
    double *rate_by, *rest_by; /* [stages][inputs] */
} collocation_branch;

struct collocation {
    modes *m;
    collocation_method by;
    int size;
    const double *after; /* inputs at the end of the step, which go there linearly; NULL: held */
    const collocation_path *path; /* of some, another way there; NULL: of none */
    double step, formed_step;     /* 0: none */
    bool has_polynomial;          /* accelerations of a last step, to go on from */
    bool must_form;               /* another matrix for the next step */
    bool asks_power;              /* of the stages: not in steps by themselves */
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
    modes_dual *dual;          /* [stages][frictions][points] of Newton's method */
    collocation_factors solve[COLLOCATION_PAIRS];
    collocation_branch branch; /* NULL where there is none */
    double load[COLLOCATION_STAGES_MAX], loss[COLLOCATION_STAGES_MAX]; /* powers of each stage */
    collocation_counts counts;
};

void collocation_make_method(int stages, collocation_method *by);

/* The model at the time of stage i, with its inputs. */
ad_status collocation_at(collocation *collocation, int i, double t, double h, const double *inputs,
                         ad_error *error);

/* q, v of stage i in collocation->q, collocation->v, by the accelerations as they are. */
void collocation_stage(collocation *collocation, int i, double h, const double *q, const double *v);

/* The right columns of [n][columns] become the solutions of the left [n][n]; false: singular. */
bool collocation_eliminate(int n, int columns, double *rows);

/* ---- Maxwell branches: nothing where there is none (modes_relaxing.c) ---- */

/* A step from stretches d [size]. */
ad_status collocation_branch_begin(collocation *collocation, double t, double h,
                                   const double *inputs, const double *d, ad_error *error);

/* Of stage i by the accelerations as they are, v of the step's start; the model has them. */
void collocation_branch_stretch(collocation *collocation, int i, double h, const double *v);

/* Keeps the matrix of the stage that was formed; adds what it is of Newton's. */
void collocation_branch_form(collocation *collocation, int stage);
void collocation_branch_system(const collocation *collocation, double complex first,
                               double complex second, collocation_factors *f);

/* Adds to rows [size][columns] of stage i: to the matrix of accelerations of all stages; to minus
 * the derivatives by v, d and inputs that begin in column `by_v`. */
void collocation_branch_rows(collocation *collocation, int i, double h, int columns, double *rows);
void collocation_branch_derivatives(const collocation *collocation, int i, collocation_ends ends,
                                    int columns, int by_v, double *rows);

/* Derivatives of what inputs say of branches, at all stages. */
ad_status collocation_branch_by_inputs(collocation *collocation, double t, double h,
                                       const double *inputs, ad_error *error);

/* How the stretch of mode k at stage i changes, with accelerations held: by v there, and by input
 * p of both ends, or of the one after the step alone. */
double collocation_branch_by_rate(const collocation *collocation, int i, int k);
double collocation_branch_by_input(const collocation *collocation, int i, int k, int p,
                                   bool is_end);

/* After the last iteration: d [size] at the end of the step; and at a share of it. */
void collocation_branch_finish(const collocation *collocation, double *d);
void collocation_branch_keep(collocation *collocation, double h, const double *d, const double *v);
void collocation_branch_within(const collocation *collocation, const double *integral, double *d);

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

/* q, v, d at the end of the step. */
void collocation_finish(collocation *collocation, double h, double *q, double *v, double *d);

#endif
