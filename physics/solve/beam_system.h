/* A beam at rest as a first-order system in s, collocated at Gauss points of elements (elements.h):
 * one linear solve for any loads. With y = (w, psi, V, M), by physics/beam/beam.h
 *
 *   w_s = psi + g V,   psi_s = c M,   V_s = k w - q,   M_s = -V - mu
 *
 * with g, c the compliances of shear and bending and k the foundation, all of which may vary.
 * Nothing is divided by a stiffness, so that beams that do not shear are no special case. Where
 * something acts at a place, an element ends, and the next begins with V and M as it leaves them.
 */
#ifndef PHYSICS_SOLVE_BEAM_SYSTEM_H
#define PHYSICS_SOLVE_BEAM_SYSTEM_H

#include "autodiff/memory.h"
#include "physics/solve/beam_model.h"
#include "physics/solve/elements.h"

enum { BEAM_W = 0, BEAM_PSI = 1, BEAM_V = 2, BEAM_M = 3, BEAM_ROWS = 4 };

typedef struct beam_system {
    solve_elements mesh;
    double
        unit[BEAM_ROWS]; /* of y here: where waves along the beam are short, all rows are alike */
    bool holds[4];       /* what the ends prescribe: w or V, psi or M, at 0, at 1 */
    int jump_count;      /* of the beam */
    beam_jump jumps[BEAM_JUMPS_MAX];
    int *jump;              /* [elements + 1] index of that at an edge; -1: none */
    beam_section *sections; /* [nodes], with the stiffening */
    double *right, *step;   /* [unknowns] */
    ad_memory memory;
} beam_system;

/* Elements of so many points between edges [elements + 1] from 0 to 1, each place of beam->jumps
 * among them; `stiffening` is added to the foundation. AD_BAD_ARGUMENT: a singular system, that of
 * a beam free to move. AD_NO_MEMORY, AD_NO_BLAS. */
ad_status beam_system_create(const solve_beam *beam, int stages, int elements, const double *edges,
                             double stiffening, beam_system **result, ad_error *error);
void beam_system_free(beam_system *system);

size_t beam_system_nodes(const beam_system *system); /* collocation points */

/* y is given at `places`, [places][BEAM_ROWS]: of each element the beginning, beyond what acts
 * there, the points, and the end. */
size_t beam_system_places(const beam_system *system);
size_t beam_system_place(const beam_system *system, size_t node); /* of a collocation point */

size_t beam_system_jump_place(const beam_system *system, int jump); /* of one of the beam's */

/* y for loads at the collocation points and at the jumps of the beam, and what the ends prescribe
 * as in solve_beam_ends. */
void beam_system_solve(beam_system *system, const beam_load *loads, const beam_load *jump_loads,
                       const double ends[4], double *y);

/* The step [places][BEAM_ROWS] that takes this from the equations of the points and the end of
 * every element, residual [elements][stages + 1][BEAM_ROWS]: left less right sides. */
void beam_system_correct(beam_system *system, const double *residual, double *step);

/* y_s; y [BEAM_ROWS] */
void beam_system_rate(const beam_section *at, const double *y, const beam_load *load, double *to);

/* at [BEAM_ROWS] = y at s in [0, 1], by the polynomial of its element; where something acts, before
 * that. */
void beam_system_at(const beam_system *system, const double *y, double s, double *at);

#endif
