/* A rod in motion by a few strain modes: the reduced rod.
 *
 * Strains are those at rest at t = 0 plus modes, Legendre's polynomials along each piece of the rod
 * between places where strains jump:
 *
 *   v(s, t) = v*(s, 0) + sum_a P_a(s) q_a(t),   u(s, t) = u*(s, 0) + sum_a P_a(s) q_a(t)
 *
 * (Boyer, Lebastard, Candelier, Renda, IEEE Trans. Robotics 37, 2021). Rotation, position, velocity
 * and acceleration are integrals of them from the start, which is held or a pin, on to the tip; the
 * equations of motion M(q) q_tt + c(q, q_t) = forces follow from the principle of virtual power,
 * so that a locked strain is one without modes. Where the other end is held, too, slides or is
 * driven, reactions are unknowns beside the accelerations (modes_end.c). Points are Gauss',
 * rotations those of Magnus' expansion of order 6. All sums go once from the start to the tip and
 * once back; derivatives of the equations are exact ones of what is computed, but for the turn
 * between points (order 6).
 *
 * Numbers are dimensionless as in rod_model.h; the modes of u are by 1/L. */
#ifndef PHYSICS_CHAIN_MODES_H
#define PHYSICS_CHAIN_MODES_H

#include "physics/local/rod_model.h"

typedef struct modes modes;

/* Modes of each piece, of v along d1, d2, d3 and of u about them; 0: that strain stays as it was at
 * t = 0. */
typedef struct modes_counts {
    int of[6];
} modes_counts;

static inline modes_counts modes_counts_of(int bending, int twist, int stretch, int shear)
{
    return (modes_counts){{shear, shear, stretch, bending, bending, twist}};
}

/* The same, for a scene: in a plane across d1 or d2 the rod bends about that director alone, and
 * shears across it. */
modes_counts modes_counts_in(const scene *rod_scene, const int of[4]);

/* Borrows the rod. open: its open parameters with usual values (solve_rod_create_open), which are
 * the inputs; NULL: none. Strains
 * that the rod locks get no modes, whatever counts say. finer: so many more Gauss points for each
 * piece than modes ask for. AD_BAD_ARGUMENT: a scene that modes do not take
 * (physics/scene/support.h); AD_NO_MEMORY, errors of formulas. */
ad_status modes_create(solve_rod *rod, const solve_parameters *open, const modes_counts *counts,
                       int finer, modes **result, ad_error *error);
void modes_free(modes *m);

int modes_size(const modes *m); /* of q, reactions of a held end among it; the state is q, q_t */

/* q, v [size] of the state that the scene starts from, with the present inputs; what modes cannot
 * say of it is left out. AD_NOT_FINITE; AD_NO_MEMORY, errors of formulas. */
ad_status modes_initial(modes *m, double *q, double *v, ad_error *error);

#endif
