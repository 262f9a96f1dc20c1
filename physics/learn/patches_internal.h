/* Parts of patches.h: what is recorded, the patches and their functions, the rows of a window. */
#ifndef PHYSICS_LEARN_PATCHES_INTERNAL_H
#define PHYSICS_LEARN_PATCHES_INTERNAL_H

#include "autodiff/memory.h"
#include "physics/learn/patches.h"
#include "physics/numerics/clock.h"

enum {
    PATCH_DIMS = PATCHES_COORDINATES_MAX,
    PATCH_ORDER = 7,   /* derivatives of this order are looked for, to refuse them */
    PATCH_JETS = 330,  /* derivatives by four coordinates up to this order */
    PATCH_DEGREE = 30, /* largest along a coordinate */
    PATCH_OUTPUTS = MODEL_COLUMNS_MAX,
    PATCH_PANELS_MAX = 512
};

/* ---- recording ------------------------------------------------------------------------------- */

/* Derivatives by their orders along the coordinates, the value itself first. */
typedef struct patch_jets {
    int dims, count;
    unsigned char order[PATCH_JETS][PATCH_DIMS];
} patch_jets;

void patch_jets_fill(patch_jets *jets, int dims);
int patch_jet_of(const patch_jets *jets, const int *order); /* its index */

/* A factor of a row of the Jacobian: of a residual by a derivative of an output, or (output -1) by
 * the unknown number `jet`. */
typedef struct patch_entry {
    int row, output, jet;
    bool same; /* at all points */
} patch_entry;

/* The residuals of the terms of a set of points, and their derivatives by derivatives of the
 * fields, as a program. */
typedef struct patch_law {
    const model_set *set;
    int rows, entry_count;
    bool linear;
    double *weight;       /* [rows], of the square */
    bool *same;           /* [rows], at all points */
    patch_entry *entries; /* [entry_count] */
    bool *uses;           /* [outputs][jets] */
    ad_program *program;  /* inputs: patch_input_jet, ...; outputs: rows, entries */
} patch_law;

ad_status patch_law_create(const physics_model *m, int set, const patch_jets *jets, ad_pool *pool,
                           patch_law *law, ad_error *error);
void patch_law_clear(patch_law *law);

/* ---- patches --------------------------------------------------------------------------------- */

/* Boxes between the edges of every coordinate. Patches are counted with the coordinate of the most
 * cells slowest. Coefficients of a patch are [outputs][functions], of functions whose mean square
 * in the patch is 1. */
typedef struct patch_grid {
    int dims, outputs;
    int cells[PATCH_DIMS];
    double *edge[PATCH_DIMS]; /* [cells + 1] */
    int degree[PATCH_DIMS];
    int functions; /* of an output in a patch */
    int patches;
    int stride[PATCH_DIMS]; /* patch = sum of cell times stride */
    double *c;              /* [patches][outputs][functions] */
    double *missed;         /* [patches], by equations that are not met there: patches_rows.h */
    double *slopes;         /* of them by the unknowns [unknowns][..]; NULL: none */
    ad_memory memory;
} patch_grid;

/* edges are copied; c is 0. False: no memory. */
bool patch_grid_create(patch_grid *grid, int dims, int outputs, const int *cells,
                       double *const *edges, const int *degree);
void patch_grid_clear(patch_grid *grid);

static inline size_t patch_grid_size(const patch_grid *grid)
{
    return (size_t)grid->outputs * (size_t)grid->functions;
}

/* Where the coefficients of an output in a patch are. */
static inline size_t patch_first(const patch_grid *grid, int patch, int output)
{
    return ((size_t)patch * (size_t)grid->outputs + (size_t)output) * (size_t)grid->functions;
}

static inline int patch_cell(const patch_grid *grid, int patch, int coordinate)
{
    return patch / grid->stride[coordinate] % grid->cells[coordinate];
}

double patch_half(const patch_grid *grid, int patch, int coordinate); /* of its length */
double patch_volume(const patch_grid *grid, int patch);               /* of it */
double patch_grid_volume(const patch_grid *grid);                     /* of all patches */

/* Its share of the volume, or of the face where some coordinates are held. */
double patch_share(const patch_grid *grid, int patch, const bool *holds);

/* A coordinate of a place of a patch that is at `local` in it, from -1 to 1; and the reverse: the
 * cell where a coordinate is, an edge belonging to the one that it begins. */
double patch_place(const patch_grid *grid, int patch, int coordinate, double local);
int patch_cell_at(const patch_grid *grid, int coordinate, double x);

/* The degree of a function along a coordinate; the last coordinate's degrees change fastest. */
int patch_degree(const patch_grid *grid, int function, int coordinate);
double patch_scale(const patch_grid *grid, int patch, const unsigned char *order); /* half^-order */

/* A derivative of an output at a place (clamped into the grid), by coefficients of the grid. */
double patch_grid_at(const patch_grid *grid, const double *c, int output, const int *order,
                     const double *x);

/* Coefficients of `to` become those of the projection of what `from` has there. */
void patch_grid_project(const patch_grid *from, patch_grid *to);

/* The same functions where `to` has the same patches and higher degrees. */
void patch_grid_embed(const patch_grid *from, patch_grid *to);

/* Functions and their derivatives by the local coordinates at points of a patch. */
typedef struct patch_table {
    int points;
    double *local;           /* [dims][points], from -1 to 1 */
    double *weight;          /* [points], their sum is 1 */
    double *phi[PATCH_JETS]; /* [functions][points]; NULL: not wanted */
    ad_memory memory;
} patch_table;

/* Gauss' points along the coordinates whose end is 0, else at -1 or 1. */
bool patch_table_create(patch_table *table, const patch_grid *grid, const patch_jets *jets,
                        const bool *wanted, const int *end);
/* The same at local coordinates [dims][points] of one's own. */
bool patch_table_at(patch_table *table, const patch_grid *grid, const patch_jets *jets,
                    const bool *wanted, int points, const double *local);
void patch_table_clear(patch_table *table);

/* ---- the rows of a window -------------------------------------------------------------------- */

typedef struct patch_problem {
    const physics_model *model;
    const patches_settings *settings;
    patch_jets jets;
    int dims, outputs, law_count, unknowns;
    bool marches; /* window by window */
    bool linear;
    patch_law laws[MODEL_SETS_MAX];
    int order[PATCH_OUTPUTS][PATCH_DIMS]; /* the highest inside, of an output along a coordinate */
    double scale[PATCH_OUTPUTS];          /* the size of the outputs */
    double unknown[MODEL_UNKNOWNS_MAX];
    double deviation[MODEL_UNKNOWNS_MAX];
    double deadline; /* of patch_now */
} patch_problem;

static inline double patch_now(void)
{
    return clock_seconds(CLOCK_MONOTONIC);
}

static inline bool patch_is_late(const patch_problem *p)
{
    return patch_now() > p->deadline;
}

/* Where the inputs of a law's program are: coordinates, [outputs][jets], unknowns, data (one, where
 * its set has any), the coordinates once more. */
static inline size_t patch_input_jet(const patch_problem *p, size_t output_and_jet)
{
    return (size_t)p->dims + output_and_jet;
}

static inline size_t patch_input_unknown(const patch_problem *p, int unknown)
{
    return patch_input_jet(p, (size_t)p->outputs * (size_t)p->jets.count) + (size_t)unknown;
}

static inline size_t patch_input_data(const patch_problem *p)
{
    return patch_input_unknown(p, p->unknowns);
}

static inline size_t patch_input_about(const patch_problem *p, const patch_law *law, int coordinate)
{
    return patch_input_data(p) + (law->set->source.rows > 0) + (size_t)coordinate;
}

static inline size_t patch_inputs(const patch_problem *p, const patch_law *law)
{
    return patch_input_about(p, law, p->dims);
}

/* Edges along coordinates between which formulas of equations and conditions are smooth. */
typedef struct patch_panels {
    int count[PATCH_DIMS];
    double edge[PATCH_DIMS][PATCH_PANELS_MAX]; /* ascending */
} patch_panels;

/* False: no memory. */
bool patch_look(const patch_problem *p, patch_panels *panels);

/* Which laws count: those of the start of time alone, or all. */
typedef enum patch_phase { PATCH_START, PATCH_FIRST, PATCH_LATER } patch_phase;

/* What data of a window say of the unknowns: numbers, sum of squares r.r, and J^T J
 * [unknowns][unknowns], J^T r, with fields that follow the equations. */
typedef struct patch_misfit {
    size_t rows;
    double sum;
    double jtj[MODEL_UNKNOWNS_MAX * MODEL_UNKNOWNS_MAX], jtr[MODEL_UNKNOWNS_MAX];
} patch_misfit;

typedef struct patch_outcome {
    int steps;
    double left;
    double rounding; /* what it may do to the fields, as `left` */
    patch_misfit misfit;
} patch_outcome;

/* Gauss-Newton steps from grid->c until what is left to go seems below `enough`, relative to the
 * scale of the fields and in root mean square; at most `steps`. A linear problem takes one. Steps
 * that become shorter by a factor leave the last times this factor. Writes grid->slopes, too.
 * `before`: what the window before ends with (PATCH_LATER), or NULL. AD_NOT_FINITE: it diverges;
 * AD_BAD_INPUT: rows do not determine the coefficients. */
ad_status patch_solve(patch_problem *p, patch_grid *grid, patch_phase phase,
                      const patch_grid *before, int steps, double enough, patch_outcome *outcome,
                      ad_error *error);

#endif
