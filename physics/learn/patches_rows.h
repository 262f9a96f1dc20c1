/* The rows of a window: residuals of the model, what joins patches, what the window before ends
 * with. For patches_solve.c alone. */
#ifndef PHYSICS_LEARN_PATCHES_ROWS_H
#define PHYSICS_LEARN_PATCHES_ROWS_H

#include "autodiff/memory.h"
#include "physics/learn/patches_internal.h"

/* A law in the patches where it counts. */
typedef struct patch_rows {
    const patch_law *law;
    int patches;
    int *patch;         /* [patches] */
    size_t *first;      /* [patches + 1], of its points */
    patch_table *table; /* one, or where points are given one for each patch */
    double *x;          /* [dims][points], dimensionless */
    double *numbers;    /* [dims..] what the inputs and outputs point to */
    double *unknowns;   /* [unknowns][points] of them */
    const double **inputs;
    double **outputs;
    double *factor; /* [rows], of residuals; 0 until they are known */
    ad_memory memory;
} patch_rows;

/* Where two patches meet: the high end of `a` along d is the low end of `b`. */
typedef struct patch_joint {
    int a, b, d;
} patch_joint;

typedef struct patch_window {
    patch_problem *p;
    patch_grid *grid;
    patch_phase phase;
    int law_count;
    patch_rows laws[MODEL_SETS_MAX];
    patch_table low[PATCH_DIMS], high[PATCH_DIMS]; /* of joints */
    patch_table start;                             /* of what the window before ends with, */
    double *before; /* [1 + unknowns][rows of it][points], with slopes */
    int joint_count;
    patch_joint *joints;
    ad_memory memory;
} patch_window;

/* `before` as for patch_solve. Errors of sources of data; AD_NO_MEMORY; AD_BAD_ARGUMENT: a set that
 * is no face. */
ad_status patch_window_create(patch_window *w, patch_problem *p, patch_grid *grid,
                              patch_phase phase, const patch_grid *before, ad_error *error);
void patch_window_clear(patch_window *w);

static inline const patch_table *patch_rows_table(const patch_rows *rows, int k)
{
    return &rows->table[rows->law->set->points == MODEL_GIVEN ? k : 0];
}

/* How many numbers the window before gives, each with its derivatives by the unknowns. */
size_t patch_before_size(const patch_window *w);

/* Evaluates residuals and their factors at the coefficients of the grid. AD_NOT_FINITE. */
ad_status patch_window_evaluate(patch_window *w, ad_error *error);

/* Columns of rows: coefficients of the patch at column 0 on, unknowns from `unknowns` on, the
 * residual in the last. a is column-major with `stride` between columns, is 0 before; rows from
 * `row` on are written. */
typedef struct patch_block {
    double *a;
    size_t stride, row, unknowns, residual;
} patch_block;

size_t patch_own_count(const patch_window *w, int patch);
void patch_own_rows(const patch_window *w, int patch, const patch_block *block);
size_t patch_joint_count(const patch_window *w, const patch_joint *joint);
/* a NULL: not wanted. Returns the sum of squares of the residuals. */
double patch_joint_rows(const patch_window *w, const patch_joint *joint, const patch_block *block,
                        size_t column_a, size_t column_b);

/* The sum of squares of all rows. */
double patch_window_sum(const patch_window *w);

/* Into grid->missed: the mean over a patch of what an equation inside leaves, relative to usual
 * fields, where it is no small part of what the equation is made of; else 0. Where a layer is
 * narrower than its patch, the least squares leave an equation unmet on all of it. */
void patch_window_missed(patch_window *w);

/* Whether rows are those of data by which unknowns are found, and no part of the least squares. */
static inline bool patch_rows_judge(const patch_window *w, const patch_rows *rows)
{
    return w->p->unknowns > 0 && rows->law->set->points == MODEL_GIVEN;
}

/* What these rows say, where the coefficients change by slopes [unknowns][stride]. */
patch_misfit patch_window_misfit(const patch_window *w, const double *slopes, size_t stride);

#endif
