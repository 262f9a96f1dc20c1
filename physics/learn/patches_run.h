/* A fit at work: its windows, patches of the next one, what has added up. For patches*.c alone. */
#ifndef PHYSICS_LEARN_PATCHES_RUN_H
#define PHYSICS_LEARN_PATCHES_RUN_H

#include "physics/learn/patches_internal.h"

enum {
    PATCH_STEPS = 40,  /* of Gauss-Newton at most */
    PATCH_RICHER = 2,  /* degrees of the basis that judges */
    PATCH_ATTEMPTS = 5 /* of a fit, each finer */
};

/* A window of time: what was found, and by the richer basis. */
typedef struct solved {
    patch_grid found, richer;
} solved;

struct patches {
    const physics_model *model;
    patches_summary summary;
    int count, room;
    solved *window; /* [room] */
};

typedef struct patch_run {
    patch_problem problem;
    patches *result;
    double began;
    double local; /* tolerance of a window */
    int cells[PATCH_DIMS];
    double *edges[PATCH_DIMS]; /* of the next window */
    int degree[PATCH_DIMS];
    patch_panels panels; /* of the formulas: their edges stay */
    /* over the windows so far: of the fields, of their errors, of what unknowns do */
    double squares[PATCH_OUTPUTS], errors[PATCH_OUTPUTS], varied[PATCH_OUTPUTS], volume;
    double slopes[MODEL_UNKNOWNS_MAX][PATCH_OUTPUTS]; /* squares of what unknowns change */
    patch_misfit misfit, richer; /* of data, by what was found and by the richer basis */
    int steps;
} patch_run;

static inline int patch_time(const patch_run *r)
{
    return r->problem.model->domain.time;
}

ad_status patch_no_memory(ad_error *error);

/* ---- patches_refine.c: what patches there are ------------------------------------------------ */

/* Degrees that suit r->local, and the patches to begin with. False: no memory. */
bool patch_begin(patch_run *r);

/* Where a window that begins there ends at most: with the panel of time. */
double patch_panel_end(const patch_run *r, double begin, double end);

/* Root mean squares of the fields so far become their scale. *changed: some by more than ten. */
void patch_find_scale(patch_run *r, const patch_grid *grid, bool *changed);

/* Cells whose tails are too long are halved; where two neighbours have far shorter ones than needed
 * they become one (only if `merge`). Returns how many were halved. */
int patch_refine(patch_run *r, const patch_grid *grid, int coordinate, bool merge);

/* What a window solved on a grid says of its length: the factor it should have had. */
double patch_length_factor(const patch_run *r, const patch_grid *grid);

/* ---- patches_march.c: through all of time ---------------------------------------------------- */

/* With r->local and the unknowns as they are. The end it had: PATCHES_CONVERGED means that all of
 * time is solved, PATCHES_INACCURATE that the error was above the tolerance long before. */
ad_status patch_march(patch_run *r, int attempt, patches_end *end, ad_error *error);

bool patches_keep(patches *p, patch_grid *found, patch_grid *richer); /* they are taken */
void patches_drop(patches *p);

/* Root mean square of errors [outputs] over that of the fields, the worst; and of those found. */
double patch_relative(const patch_run *r, const double *errors);
double patch_estimate(const patch_run *r);

/* ---- patches_unknowns.c ---------------------------------------------------------------------- */

/* The unknowns whose fields, which follow the equations, are nearest to the data, with deviations.
 * As patch_march, which it calls again and again. */
ad_status patch_identify(patch_run *r, int attempt, patches_end *end, ad_error *error);

#endif
