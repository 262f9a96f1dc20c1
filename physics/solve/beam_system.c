#include "physics/solve/beam_system.h"

#include "autodiff/dense.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

enum { ROWS = BEAM_ROWS, INNER_MAX = GAUSS_STAGES_MAX * ROWS };

struct beam_system {
    gauss_rule rule;
    int elements;
    size_t inner, outer; /* unknowns within an element, at the ends of all */
    double unit[ROWS];   /* of y here: where waves along the beam are short, all rows are alike */
    bool holds[4];       /* what the ends prescribe: w or V, psi or M, at 0, at 1 */
    double *edges;       /* [elements + 1] */
    int jump_count;      /* of the beam */
    beam_jump jumps[BEAM_JUMPS_MAX];
    int *jump;              /* [elements + 1] index of that at an edge; -1: none */
    double *points;         /* [nodes] */
    beam_section *sections; /* [nodes] */
    double *factors;        /* [elements][inner][inner], LU */
    double *matrix, *right; /* [outer][outer], LU; [outer] */
    double *more;           /* [elements][stages + 1][ROWS] */
    int *pivots, *outer_pivots;
};

/* ---- equations ------------------------------------------------------------------------------- */

/* y_s for loads; y in its units. */
static void rate_of(const double *unit, const beam_section *at, const double *y,
                    const beam_load *load, double *to)
{
    double shear = unit[BEAM_V] * y[BEAM_V];
    to[BEAM_W] = unit[BEAM_PSI] * y[BEAM_PSI] + at->shear_compliance * shear;
    to[BEAM_PSI] = at->bending_compliance * unit[BEAM_M] * y[BEAM_M] / unit[BEAM_PSI];
    to[BEAM_V] = (at->foundation * y[BEAM_W] - load->force) / unit[BEAM_V];
    to[BEAM_M] = (-shear - load->moment) / unit[BEAM_M];
}

static void rate(const beam_system *x, size_t node, const double *y, const beam_load *load,
                 double *to)
{
    rate_of(x->unit, &x->sections[node], y, load, to);
}

static double width(const beam_system *x, int element)
{
    return x->edges[element + 1] - x->edges[element];
}

/* y beyond what acts at an edge, from y before it. */
static void jump_over(const beam_system *x, int edge, const beam_load *loads, double *y)
{
    int jump = x->jump[edge];
    if (jump >= 0) {
        double force = x->jumps[jump].stiffness * x->unit[BEAM_W] * y[BEAM_W] - loads[jump].force;
        double moment =
            x->jumps[jump].turning * x->unit[BEAM_PSI] * y[BEAM_PSI] - loads[jump].moment;
        y[BEAM_V] += force / x->unit[BEAM_V];
        y[BEAM_M] += moment / x->unit[BEAM_M];
    }
}

/* The polynomial of an element, from y at its left end and at its points, at the right end. Without
 * loads: NULL, as in the next. */
static void pass(const beam_system *x, int element, const double *inner, const beam_load *loads,
                 double *end)
{
    static const beam_load none = {0, 0};
    size_t stages = (size_t)x->rule.stages, first = (size_t)element * stages;
    for (size_t j = 0; j < stages; j++) {
        double slope[ROWS];
        rate(x, first + j, inner + j * ROWS, loads ? loads + j : &none, slope);
        for (int r = 0; r < ROWS; r++) {
            end[r] += width(x, element) * x->rule.weights[j] * slope[r];
        }
    }
}

/* Inner unknowns of an element for loads, with y = `left` at its left end, and where `more` is not
 * NULL this [stages][ROWS] added to the equations. */
static void solve_inner(const beam_system *x, int element, const double *left,
                        const beam_load *loads, const double *more, double *inner)
{
    size_t stages = (size_t)x->rule.stages, n = x->inner;
    for (size_t i = 0; i < stages; i++) {
        double *y = inner + i * ROWS;
        for (size_t r = 0; r < ROWS; r++) {
            y[r] = left[r] + (more ? more[i * ROWS + r] : 0);
        }
        for (size_t j = 0; j < stages && loads; j++) {
            double weight = width(x, element) * x->rule.matrix[i][j];
            y[BEAM_V] -= weight * loads[j].force / x->unit[BEAM_V];
            y[BEAM_M] -= weight * loads[j].moment / x->unit[BEAM_M];
        }
    }
    ad_dense_lu_solve(n, 1, x->factors + (size_t)element * n * n, x->pivots + (size_t)element * n,
                      inner);
}

/* ---- matrices -------------------------------------------------------------------------------- */

/* y_i - h sum_j a_ij y_s,j */
static int factor_element(beam_system *x, int element)
{
    static const beam_load none = {0, 0};
    size_t stages = (size_t)x->rule.stages, n = x->inner;
    double *matrix = x->factors + (size_t)element * n * n;
    for (size_t column = 0; column < n; column++) {
        double unit[ROWS] = {0}, slope[ROWS];
        size_t j = column / ROWS;
        unit[column % ROWS] = 1;
        rate(x, (size_t)element * stages + j, unit, &none, slope);
        for (size_t i = 0; i < stages; i++) {
            double weight = width(x, element) * x->rule.matrix[i][j];
            for (size_t r = 0; r < ROWS; r++) {
                matrix[column * n + i * ROWS + r] = (i == j ? unit[r] : 0) - weight * slope[r];
            }
        }
    }
    return ad_dense_lu(n, matrix, x->pivots + (size_t)element * n);
}

/* Row of y that the `which`-th condition is about. */
static size_t held_row(const beam_system *x, int which)
{
    return which % 2 == 0 ? (x->holds[which] ? BEAM_W : BEAM_V)
                          : (x->holds[which] ? BEAM_PSI : BEAM_M);
}

/* Conditions at s = 0; for each element what its ends have to do with each other; conditions at
 * s = 1. */
static int factor_outer(beam_system *x)
{
    static const beam_load still[BEAM_JUMPS_MAX];
    size_t n = x->outer;
    double inner[INNER_MAX];
    memset(x->matrix, 0, n * n * sizeof *x->matrix);
    for (int i = 0; i < 2; i++) {
        x->matrix[held_row(x, i) * n + (size_t)i] = 1;
    }
    for (size_t column = 0; column < ROWS; column++) {
        double y[ROWS] = {0};
        y[column] = 1;
        jump_over(x, x->elements, still, y);
        for (int i = 0; i < 2; i++) {
            x->matrix[(n - ROWS + column) * n + n - 2 + (size_t)i] = y[held_row(x, 2 + i)];
        }
    }
    for (int e = 0; e < x->elements; e++) {
        size_t first = (size_t)e * ROWS;
        for (size_t column = 0; column < ROWS; column++) {
            double left[ROWS] = {0}, end[ROWS] = {0};
            left[column] = 1;
            jump_over(x, e, still, left);
            memcpy(end, left, sizeof end);
            solve_inner(x, e, left, NULL, NULL, inner);
            pass(x, e, inner, NULL, end);
            for (size_t r = 0; r < ROWS; r++) {
                x->matrix[(first + column) * n + 2 + first + r] = -end[r];
            }
            x->matrix[(first + ROWS + column) * n + 2 + first + column] = 1;
        }
    }
    return ad_dense_lu(n, x->matrix, x->outer_pivots);
}

/* ---- making and freeing ---------------------------------------------------------------------- */

void beam_system_free(beam_system *x)
{
    if (x) {
        free(x->edges);
        free(x->jump);
        free(x->points);
        free(x->sections);
        free(x->pivots);
        free(x);
    }
}

static ad_status place_elements(beam_system *x, const solve_beam *beam, const double *edges,
                                ad_error *error)
{
    int next = 0;
    size_t count = (size_t)x->elements + 1;
    x->jump_count = beam->jump_count;
    memcpy(x->jumps, beam->jumps, sizeof x->jumps);
    x->edges = malloc(count * sizeof *x->edges);
    x->jump = malloc(count * sizeof *x->jump);
    if (!x->edges || !x->jump) {
        return ad_fail(error, AD_NO_MEMORY, "out of memory for %d elements", x->elements);
    }
    memcpy(x->edges, edges, count * sizeof *edges);
    for (int e = 0; e <= x->elements; e++) {
        bool here = next < x->jump_count && x->jumps[next].s == x->edges[e];
        x->jump[e] = here ? next++ : -1;
    }
    return AD_OK;
}

static ad_status allocate(beam_system *x, ad_error *error)
{
    x->inner = (size_t)x->rule.stages * ROWS;
    x->outer = ((size_t)x->elements + 1) * ROWS;
    size_t elements = (size_t)x->elements, points = beam_system_nodes(x);
    size_t factors = elements * x->inner * x->inner;
    size_t more = (points + elements) * ROWS;
    x->points = malloc((points + factors + (x->outer + 1) * x->outer + more) * sizeof(double));
    x->sections = malloc(points * sizeof *x->sections);
    x->pivots = malloc((elements * x->inner + x->outer) * sizeof *x->pivots);
    if (!x->points || !x->sections || !x->pivots) {
        return ad_fail(error, AD_NO_MEMORY, "out of memory for %zu nodes", points);
    }
    x->factors = x->points + points;
    x->matrix = x->factors + factors;
    x->right = x->matrix + x->outer * x->outer;
    x->more = x->right + x->outer;
    x->outer_pivots = x->pivots + elements * x->inner;
    for (size_t i = 0; i < points; i++) {
        size_t stages = (size_t)x->rule.stages, element = i / stages;
        x->points[i] = x->edges[element] + x->rule.nodes[i % stages] * width(x, (int)element);
    }
    return AD_OK;
}

/* By the wavenumber of bending on the foundation, (k/4EI)^(1/4) (Hetenyi 1946). */
static void choose_units(beam_system *x)
{
    double most = 4;
    for (size_t i = 0; i < beam_system_nodes(x); i++) {
        most = fmax(most, x->sections[i].foundation * x->sections[i].bending_compliance);
    }
    double wave = pow(most / 4, 0.25);
    x->unit[BEAM_W] = 1;
    x->unit[BEAM_PSI] = wave;
    x->unit[BEAM_M] = wave * wave;
    x->unit[BEAM_V] = wave * wave * wave;
}

static ad_status factor(beam_system *x, ad_error *error)
{
    choose_units(x);
    int bad = 0;
    for (int e = 0; e < x->elements && bad == 0; e++) {
        bad = factor_element(x, e);
    }
    return bad == 0 && factor_outer(x) == 0
               ? AD_OK
               : ad_fail(error, AD_BAD_ARGUMENT, "the beam is free to move");
}

ad_status beam_system_create(const solve_beam *beam, int stages, int elements, const double *edges,
                             double stiffening, beam_system **result, ad_error *error)
{
    *result = NULL;
    if (ad_dense_load(error) != AD_OK) {
        return AD_NO_BLAS;
    }
    beam_system *x = calloc(1, sizeof *x);
    if (!x) {
        return ad_fail(error, AD_NO_MEMORY, "out of memory for a beam");
    }
    for (int i = 0; i < 4; i++) {
        x->holds[i] =
            i % 2 == 0 ? beam->ends[i / 2].holds_deflection : beam->ends[i / 2].holds_slope;
    }
    x->rule = solve_gauss_rule_of(stages);
    x->elements = elements;
    ad_status status = place_elements(x, beam, edges, error);
    status = status == AD_OK ? allocate(x, error) : status;
    if (status == AD_OK) {
        status = solve_beam_sections(beam, beam_system_nodes(x), x->points, x->sections, error);
    }
    for (size_t i = 0; status == AD_OK && i < beam_system_nodes(x); i++) {
        x->sections[i].foundation += stiffening;
    }
    status = status == AD_OK ? factor(x, error) : status;
    if (status != AD_OK) {
        beam_system_free(x);
        return status;
    }
    *result = x;
    return AD_OK;
}

/* ---- places ---------------------------------------------------------------------------------- */

int beam_system_elements(const beam_system *x)
{
    return x->elements;
}

const double *beam_system_edges(const beam_system *x)
{
    return x->edges;
}

const gauss_rule *beam_system_rule(const beam_system *x)
{
    return &x->rule;
}

size_t beam_system_nodes(const beam_system *x)
{
    return (size_t)x->elements * (size_t)x->rule.stages;
}

const double *beam_system_points(const beam_system *x)
{
    return x->points;
}

const beam_section *beam_system_sections(const beam_system *x)
{
    return x->sections;
}

size_t beam_system_places(const beam_system *x)
{
    return beam_system_nodes(x) + 2 * (size_t)x->elements;
}

size_t beam_system_place(const beam_system *x, size_t node)
{
    return node + 2 * (node / (size_t)x->rule.stages) + 1;
}

size_t beam_system_jump_place(const beam_system *x, int jump)
{
    size_t stride = (size_t)x->rule.stages + 2;
    int edge = 0;
    while (x->jump[edge] != jump) {
        edge++;
    }
    return edge < x->elements ? (size_t)edge * stride : beam_system_places(x) - 1;
}

/* ---- solving --------------------------------------------------------------------------------- */

/* loads: NULL for none; more [elements][stages + 1][ROWS] is added to the equations of the points
 * and the end of every element, in units of y here, or NULL. */
static void solve_for(beam_system *x, const beam_load *loads, const double *more,
                      const beam_load *jump_loads, const double ends[4], double *y)
{
    size_t n = x->outer, stages = (size_t)x->rule.stages, stride = (stages + 2) * ROWS;
    double inner[INNER_MAX];
    memset(x->right, 0, n * sizeof *x->right);
    for (int e = 0; e < x->elements; e++) {
        const beam_load *its = loads ? loads + (size_t)e * stages : NULL;
        const double *rows = more ? more + (size_t)e * (stages + 1) * ROWS : NULL;
        double start[ROWS] = {0}, *end = x->right + 2 + (size_t)e * ROWS;
        jump_over(x, e, jump_loads, start);
        memcpy(end, start, sizeof start);
        solve_inner(x, e, start, its, rows, inner);
        pass(x, e, inner, its, end);
        for (size_t r = 0; r < ROWS && rows; r++) {
            end[r] += rows[stages * ROWS + r];
        }
    }
    double last[ROWS] = {0};
    jump_over(x, x->elements, jump_loads, last);
    for (int i = 0; i < 2; i++) {
        size_t row = held_row(x, 2 + i);
        x->right[i] = ends[i] / x->unit[held_row(x, i)];
        x->right[n - 2 + (size_t)i] = ends[2 + i] / x->unit[row] - last[row];
    }
    ad_dense_lu_solve(n, 1, x->matrix, x->outer_pivots, x->right);
    for (int e = 0; e < x->elements; e++) {
        const double *left = x->right + (size_t)e * ROWS;
        const beam_load *its = loads ? loads + (size_t)e * stages : NULL;
        const double *rows = more ? more + (size_t)e * (stages + 1) * ROWS : NULL;
        double *start = y + (size_t)e * stride, *end = start + stride - ROWS;
        memcpy(start, left, ROWS * sizeof *y);
        jump_over(x, e, jump_loads, start);
        solve_inner(x, e, start, its, rows, start + ROWS);
        memcpy(end, left + ROWS, ROWS * sizeof *y);
    }
    for (size_t i = 0; i < beam_system_places(x) * ROWS; i++) {
        y[i] *= x->unit[i % ROWS];
    }
}

void beam_system_solve(beam_system *x, const beam_load *loads, const beam_load *jump_loads,
                       const double ends[4], double *y)
{
    solve_for(x, loads, NULL, jump_loads, ends, y);
}

void beam_system_correct(beam_system *x, const double *residual, double *step)
{
    static const beam_load still[BEAM_JUMPS_MAX];
    static const double none[4];
    size_t rows = (size_t)x->elements * ((size_t)x->rule.stages + 1) * ROWS;
    for (size_t i = 0; i < rows; i++) {
        x->more[i] = residual[i] / x->unit[i % ROWS];
    }
    solve_for(x, NULL, x->more, still, none, step);
}

void beam_system_rate(const beam_section *at, const double *y, const beam_load *load, double *to)
{
    static const double unit[ROWS] = {1, 1, 1, 1};
    rate_of(unit, at, y, load, to);
}

void beam_system_at(const beam_system *x, const double *y, double s, double *at)
{
    double weights[GAUSS_STAGES_MAX + 2];
    int element = 0, last = x->elements - 1;
    while (element < last) {
        int middle = (element + last + 1) / 2;
        if (x->edges[middle] < s) {
            element = middle;
        } else {
            last = middle - 1;
        }
    }
    solve_gauss_lagrange(&x->rule, (s - x->edges[element]) / width(x, element), weights);
    const double *from = y + (size_t)element * ((size_t)x->rule.stages + 2) * ROWS;
    memset(at, 0, ROWS * sizeof *at);
    for (int i = 0; i < x->rule.stages + 2; i++) {
        for (int r = 0; r < ROWS; r++) {
            at[r] += weights[i] * from[i * ROWS + r];
        }
    }
}
