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

static void rate(const beam_system *system, size_t node, const double *y, const beam_load *load,
                 double *to)
{
    rate_of(system->unit, &system->sections[node], y, load, to);
}

static double width(const beam_system *system, int element)
{
    return system->edges[element + 1] - system->edges[element];
}

/* y beyond what acts at an edge, from y before it. */
static void jump_over(const beam_system *system, int edge, const beam_load *loads, double *y)
{
    int jump = system->jump[edge];
    if (jump >= 0) {
        double force =
            system->jumps[jump].stiffness * system->unit[BEAM_W] * y[BEAM_W] - loads[jump].force;
        double moment =
            system->jumps[jump].turning * system->unit[BEAM_PSI] * y[BEAM_PSI] - loads[jump].moment;
        y[BEAM_V] += force / system->unit[BEAM_V];
        y[BEAM_M] += moment / system->unit[BEAM_M];
    }
}

/* The polynomial of an element, from y at its left end and at its points, at the right end. Without
 * loads: NULL, as in the next. */
static void pass(const beam_system *system, int element, const double *inner,
                 const beam_load *loads, double *end)
{
    static const beam_load none = {0, 0};
    size_t stages = (size_t)system->rule.stages, first = (size_t)element * stages;
    for (size_t j = 0; j < stages; j++) {
        double slope[ROWS];
        rate(system, first + j, inner + j * ROWS, loads ? loads + j : &none, slope);
        for (int r = 0; r < ROWS; r++) {
            end[r] += width(system, element) * system->rule.weights[j] * slope[r];
        }
    }
}

/* Inner unknowns of an element for loads, with y = `left` at its left end, and where `more` is not
 * NULL this [stages][ROWS] added to the equations. */
static void solve_inner(const beam_system *system, int element, const double *left,
                        const beam_load *loads, const double *more, double *inner)
{
    size_t stages = (size_t)system->rule.stages, n = system->inner;
    for (size_t i = 0; i < stages; i++) {
        double *y = inner + i * ROWS;
        for (size_t r = 0; r < ROWS; r++) {
            y[r] = left[r] + (more ? more[i * ROWS + r] : 0);
        }
        for (size_t j = 0; j < stages && loads; j++) {
            double weight = width(system, element) * system->rule.matrix[i][j];
            y[BEAM_V] -= weight * loads[j].force / system->unit[BEAM_V];
            y[BEAM_M] -= weight * loads[j].moment / system->unit[BEAM_M];
        }
    }
    ad_dense_lu_solve(n, 1, system->factors + (size_t)element * n * n,
                      system->pivots + (size_t)element * n, inner);
}

/* ---- matrices -------------------------------------------------------------------------------- */

/* y_i - h sum_j a_ij y_s,j */
static int factor_element(beam_system *system, int element)
{
    static const beam_load none = {0, 0};
    size_t stages = (size_t)system->rule.stages, n = system->inner;
    double *matrix = system->factors + (size_t)element * n * n;
    for (size_t column = 0; column < n; column++) {
        double unit[ROWS] = {0}, slope[ROWS];
        size_t j = column / ROWS;
        unit[column % ROWS] = 1;
        rate(system, (size_t)element * stages + j, unit, &none, slope);
        for (size_t i = 0; i < stages; i++) {
            double weight = width(system, element) * system->rule.matrix[i][j];
            for (size_t r = 0; r < ROWS; r++) {
                matrix[column * n + i * ROWS + r] = (i == j ? unit[r] : 0) - weight * slope[r];
            }
        }
    }
    return ad_dense_lu(n, matrix, system->pivots + (size_t)element * n);
}

/* Row of y that the `which`-th condition is about. */
static size_t held_row(const beam_system *system, int which)
{
    return which % 2 == 0 ? (system->holds[which] ? BEAM_W : BEAM_V)
                          : (system->holds[which] ? BEAM_PSI : BEAM_M);
}

/* Conditions at s = 0; for each element what its ends have to do with each other; conditions at
 * s = 1. */
static int factor_outer(beam_system *system)
{
    static const beam_load still[BEAM_JUMPS_MAX];
    size_t n = system->outer;
    double inner[INNER_MAX];
    memset(system->matrix, 0, n * n * sizeof *system->matrix);
    for (int i = 0; i < 2; i++) {
        system->matrix[held_row(system, i) * n + (size_t)i] = 1;
    }
    for (size_t column = 0; column < ROWS; column++) {
        double y[ROWS] = {0};
        y[column] = 1;
        jump_over(system, system->elements, still, y);
        for (int i = 0; i < 2; i++) {
            system->matrix[(n - ROWS + column) * n + n - 2 + (size_t)i] =
                y[held_row(system, 2 + i)];
        }
    }
    for (int e = 0; e < system->elements; e++) {
        size_t first = (size_t)e * ROWS;
        for (size_t column = 0; column < ROWS; column++) {
            double left[ROWS] = {0}, end[ROWS] = {0};
            left[column] = 1;
            jump_over(system, e, still, left);
            memcpy(end, left, sizeof end);
            solve_inner(system, e, left, NULL, NULL, inner);
            pass(system, e, inner, NULL, end);
            for (size_t r = 0; r < ROWS; r++) {
                system->matrix[(first + column) * n + 2 + first + r] = -end[r];
            }
            system->matrix[(first + ROWS + column) * n + 2 + first + column] = 1;
        }
    }
    return ad_dense_lu(n, system->matrix, system->outer_pivots);
}

/* ---- making and freeing ---------------------------------------------------------------------- */

void beam_system_free(beam_system *system)
{
    if (system) {
        free(system->edges);
        free(system->jump);
        free(system->points);
        free(system->sections);
        free(system->pivots);
        free(system);
    }
}

static ad_status place_elements(beam_system *system, const solve_beam *beam, const double *edges,
                                ad_error *error)
{
    int next = 0;
    size_t count = (size_t)system->elements + 1;
    system->jump_count = beam->jump_count;
    memcpy(system->jumps, beam->jumps, sizeof system->jumps);
    system->edges = malloc(count * sizeof *system->edges);
    system->jump = malloc(count * sizeof *system->jump);
    if (!system->edges || !system->jump) {
        return ad_fail(error, AD_NO_MEMORY, "out of memory for %d elements", system->elements);
    }
    memcpy(system->edges, edges, count * sizeof *edges);
    for (int e = 0; e <= system->elements; e++) {
        bool here = next < system->jump_count && system->jumps[next].s == system->edges[e];
        system->jump[e] = here ? next++ : -1;
    }
    return AD_OK;
}

static ad_status allocate(beam_system *system, ad_error *error)
{
    system->inner = (size_t)system->rule.stages * ROWS;
    system->outer = ((size_t)system->elements + 1) * ROWS;
    size_t elements = (size_t)system->elements, points = beam_system_nodes(system);
    size_t factors = elements * system->inner * system->inner;
    size_t more = (points + elements) * ROWS;
    system->points =
        malloc((points + factors + (system->outer + 1) * system->outer + more) * sizeof(double));
    system->sections = malloc(points * sizeof *system->sections);
    system->pivots = malloc((elements * system->inner + system->outer) * sizeof *system->pivots);
    if (!system->points || !system->sections || !system->pivots) {
        return ad_fail(error, AD_NO_MEMORY, "out of memory for %zu nodes", points);
    }
    system->factors = system->points + points;
    system->matrix = system->factors + factors;
    system->right = system->matrix + system->outer * system->outer;
    system->more = system->right + system->outer;
    system->outer_pivots = system->pivots + elements * system->inner;
    for (size_t i = 0; i < points; i++) {
        size_t stages = (size_t)system->rule.stages, element = i / stages;
        system->points[i] =
            system->edges[element] + system->rule.nodes[i % stages] * width(system, (int)element);
    }
    return AD_OK;
}

/* By the wavenumber of bending on the foundation, (k/4EI)^(1/4) (Hetenyi 1946). */
static void choose_units(beam_system *system)
{
    double most = 4;
    for (size_t i = 0; i < beam_system_nodes(system); i++) {
        most = fmax(most, system->sections[i].foundation * system->sections[i].bending_compliance);
    }
    double wave = pow(most / 4, 0.25);
    system->unit[BEAM_W] = 1;
    system->unit[BEAM_PSI] = wave;
    system->unit[BEAM_M] = wave * wave;
    system->unit[BEAM_V] = wave * wave * wave;
}

static ad_status factor(beam_system *system, ad_error *error)
{
    choose_units(system);
    int bad = 0;
    for (int e = 0; e < system->elements && bad == 0; e++) {
        bad = factor_element(system, e);
    }
    return bad == 0 && factor_outer(system) == 0
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
    beam_system *system = calloc(1, sizeof *system);
    if (!system) {
        return ad_fail(error, AD_NO_MEMORY, "out of memory for a beam");
    }
    for (int i = 0; i < 4; i++) {
        system->holds[i] =
            i % 2 == 0 ? beam->ends[i / 2].holds_deflection : beam->ends[i / 2].holds_slope;
    }
    system->rule = solve_gauss_rule_of(stages);
    system->elements = elements;
    ad_status status = place_elements(system, beam, edges, error);
    status = status == AD_OK ? allocate(system, error) : status;
    if (status == AD_OK) {
        status = solve_beam_sections(beam, beam_system_nodes(system), system->points,
                                     system->sections, error);
    }
    for (size_t i = 0; status == AD_OK && i < beam_system_nodes(system); i++) {
        system->sections[i].foundation += stiffening;
    }
    status = status == AD_OK ? factor(system, error) : status;
    if (status != AD_OK) {
        beam_system_free(system);
        return status;
    }
    *result = system;
    return AD_OK;
}

/* ---- places ---------------------------------------------------------------------------------- */

int beam_system_elements(const beam_system *system)
{
    return system->elements;
}

const double *beam_system_edges(const beam_system *system)
{
    return system->edges;
}

const gauss_rule *beam_system_rule(const beam_system *system)
{
    return &system->rule;
}

size_t beam_system_nodes(const beam_system *system)
{
    return (size_t)system->elements * (size_t)system->rule.stages;
}

const double *beam_system_points(const beam_system *system)
{
    return system->points;
}

const beam_section *beam_system_sections(const beam_system *system)
{
    return system->sections;
}

size_t beam_system_places(const beam_system *system)
{
    return beam_system_nodes(system) + 2 * (size_t)system->elements;
}

size_t beam_system_place(const beam_system *system, size_t node)
{
    return node + 2 * (node / (size_t)system->rule.stages) + 1;
}

size_t beam_system_jump_place(const beam_system *system, int jump)
{
    size_t stride = (size_t)system->rule.stages + 2;
    int edge = 0;
    while (system->jump[edge] != jump) {
        edge++;
    }
    return edge < system->elements ? (size_t)edge * stride : beam_system_places(system) - 1;
}

/* ---- solving --------------------------------------------------------------------------------- */

/* loads: NULL for none; more [elements][stages + 1][ROWS] is added to the equations of the points
 * and the end of every element, in units of y here, or NULL. */
static void solve_for(beam_system *system, const beam_load *loads, const double *more,
                      const beam_load *jump_loads, const double ends[4], double *y)
{
    size_t n = system->outer, stages = (size_t)system->rule.stages, stride = (stages + 2) * ROWS;
    double inner[INNER_MAX];
    memset(system->right, 0, n * sizeof *system->right);
    for (int e = 0; e < system->elements; e++) {
        const beam_load *its = loads ? loads + (size_t)e * stages : NULL;
        const double *rows = more ? more + (size_t)e * (stages + 1) * ROWS : NULL;
        double start[ROWS] = {0}, *end = system->right + 2 + (size_t)e * ROWS;
        jump_over(system, e, jump_loads, start);
        memcpy(end, start, sizeof start);
        solve_inner(system, e, start, its, rows, inner);
        pass(system, e, inner, its, end);
        for (size_t r = 0; r < ROWS && rows; r++) {
            end[r] += rows[stages * ROWS + r];
        }
    }
    double last[ROWS] = {0};
    jump_over(system, system->elements, jump_loads, last);
    for (int i = 0; i < 2; i++) {
        size_t row = held_row(system, 2 + i);
        system->right[i] = ends[i] / system->unit[held_row(system, i)];
        system->right[n - 2 + (size_t)i] = ends[2 + i] / system->unit[row] - last[row];
    }
    ad_dense_lu_solve(n, 1, system->matrix, system->outer_pivots, system->right);
    for (int e = 0; e < system->elements; e++) {
        const double *left = system->right + (size_t)e * ROWS;
        const beam_load *its = loads ? loads + (size_t)e * stages : NULL;
        const double *rows = more ? more + (size_t)e * (stages + 1) * ROWS : NULL;
        double *start = y + (size_t)e * stride, *end = start + stride - ROWS;
        memcpy(start, left, ROWS * sizeof *y);
        jump_over(system, e, jump_loads, start);
        solve_inner(system, e, start, its, rows, start + ROWS);
        memcpy(end, left + ROWS, ROWS * sizeof *y);
    }
    for (size_t i = 0; i < beam_system_places(system) * ROWS; i++) {
        y[i] *= system->unit[i % ROWS];
    }
}

void beam_system_solve(beam_system *system, const beam_load *loads, const beam_load *jump_loads,
                       const double ends[4], double *y)
{
    solve_for(system, loads, NULL, jump_loads, ends, y);
}

void beam_system_correct(beam_system *system, const double *residual, double *step)
{
    static const beam_load still[BEAM_JUMPS_MAX];
    static const double none[4];
    size_t rows = (size_t)system->elements * ((size_t)system->rule.stages + 1) * ROWS;
    for (size_t i = 0; i < rows; i++) {
        system->more[i] = residual[i] / system->unit[i % ROWS];
    }
    solve_for(system, NULL, system->more, still, none, step);
}

void beam_system_rate(const beam_section *at, const double *y, const beam_load *load, double *to)
{
    static const double unit[ROWS] = {1, 1, 1, 1};
    rate_of(unit, at, y, load, to);
}

void beam_system_at(const beam_system *system, const double *y, double s, double *at)
{
    double weights[GAUSS_STAGES_MAX + 2];
    int element = 0, last = system->elements - 1;
    while (element < last) {
        int middle = (element + last + 1) / 2;
        if (system->edges[middle] < s) {
            element = middle;
        } else {
            last = middle - 1;
        }
    }
    solve_gauss_lagrange(&system->rule, (s - system->edges[element]) / width(system, element),
                         weights);
    const double *from = y + (size_t)element * ((size_t)system->rule.stages + 2) * ROWS;
    memset(at, 0, ROWS * sizeof *at);
    for (int i = 0; i < system->rule.stages + 2; i++) {
        for (int r = 0; r < ROWS; r++) {
            at[r] += weights[i] * from[i * ROWS + r];
        }
    }
}
