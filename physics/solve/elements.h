/* Collocation of y_s = f(s, y) on [0, 1] at Gauss points of elements, with conditions at both ends
 * and jumps of y at edges: one linear solve by the derivatives of all these. Order 2 stages at the
 * ends of elements. The points within an element are eliminated element by element, of their rows
 * those together that depend on each other; what remains is a band matrix of y at the edges.
 *
 * Unknowns: y at s = 0; then for each element y at its points and at its end. Where y jumps at an
 * edge that y is the one before it, at s = 0 outside. Equations in the same order: conditions at
 * s = 0; for each element those of its points and of its end, left less right sides of
 *
 *   y_i - (y beyond the edge where it begins) = h sum_j a_ij f_j;
 *
 * conditions at s = 1. */
#ifndef PHYSICS_SOLVE_ELEMENTS_H
#define PHYSICS_SOLVE_ELEMENTS_H

#include "autodiff/error.h"
#include "autodiff/memory.h"
#include "physics/numerics/gauss.h"

#include <stddef.h>
#include <sundials/sundials_band.h>

enum { ELEMENTS_ROWS_MAX = 21 };

typedef double elements_matrix[ELEMENTS_ROWS_MAX][ELEMENTS_ROWS_MAX];

typedef struct solve_elements {
    gauss_rule rule;
    int count, stages;
    int rows, start_rows, end_rows; /* of y, of the conditions at s = 0, 1 */
    double *edges;                  /* [count + 1] */
    double *points;                 /* [count][stages], s */

    /* derivatives by y, which the owner sets */
    elements_matrix *by_y;      /* [count][stages] of f */
    elements_matrix *across;    /* [count] of y beyond the edge where an element begins */
    elements_matrix start, end; /* of the conditions */

    /* of the linear solve */
    int lower, above; /* diagonals of the band below, and above with those of pivoting */
    double *factor;   /* [count][inner][inner], column-major, of the rows that are coupled */
    int *pivots;      /* [count][inner] */
    double *by_start; /* [count][rows][inner]: how the inner y follow the start */
    double *inner;    /* [count][inner] */
    int *part;        /* [count][rows] which rows are solved for together */
    double *packed;   /* [rows][inner] work */
    realtype **band;  /* of y at the edges */
    sunindextype *band_pivots;
    double *right; /* [count + 1][rows] */
    ad_memory memory;
} solve_elements;

/* From zeros, with edges [count + 1] from 0 to 1. AD_NO_MEMORY, AD_NO_BLAS; to be cleared also
 * then. */
ad_status solve_elements_make(int rows, int start_rows, int stages, int count, const double *edges,
                              solve_elements *mesh, ad_error *error);
void solve_elements_clear(solve_elements *mesh);

static inline size_t elements_inner(const solve_elements *mesh)
{
    return (size_t)(mesh->stages * mesh->rows);
}

static inline double elements_width(const solve_elements *mesh, int element)
{
    return mesh->edges[element + 1] - mesh->edges[element];
}

/* Index of the y at edge `element`; the inner ones of the element follow. */
static inline size_t elements_edge(const solve_elements *mesh, int element)
{
    return (size_t)element * (elements_inner(mesh) + (size_t)mesh->rows);
}

static inline size_t elements_unknowns(const solve_elements *mesh)
{
    return elements_edge(mesh, mesh->count) + (size_t)mesh->rows;
}

/* s of all of them, [unknowns/rows]. */
void solve_elements_places(const solve_elements *mesh, double *s);

/* The element that ends at s or goes on there. */
int solve_elements_at(const solve_elements *mesh, double s);

/* y [rows] at s in an element, by the polynomial through values [stages + 2][stride] at its
 * beginning, its points and its end. */
void solve_elements_interpolate(const solve_elements *mesh, int element, double s, size_t rows,
                                size_t stride, const double *values, double *y);

/* Equations [stages + 1][rows] of an element that begins with `start`, whose points and end are y
 * [stages + 1][rows] and whose points have rates [stages][rows]. */
void solve_elements_residual(const solve_elements *mesh, int element, const double *start,
                             const double *y, const double *rate, double *residual);

/* 0, or not when the derivatives are singular; then the step [unknowns] with J step = right. */
int solve_elements_factor(solve_elements *mesh);
void solve_elements_solve(solve_elements *mesh, const double *right, double *step);

#endif
