/* Elements along a rod, of lengths that are alike, with edges where something jumps. */
#ifndef PHYSICS_LOCAL_MESH_H
#define PHYSICS_LOCAL_MESH_H

/* Places along [0, 1] that are no farther apart differ by rounding: they are one. */
static const double SOLVE_SAME_PLACE = 1e-12;

/* Puts places s [count] in order, each once, those next to an end of [0, 1] there; returns how many
 * there are then. */
int solve_mesh_places(int count, double *s);

/* edges [elements + places + 1] from 0 to 1, the places [places], ascending, among them: what lies
 * between two is divided equally, into elements no longer than 1/elements. Those at 0 and 1 are no
 * division. Returns how many elements there are, at most elements + places. */
int solve_mesh_edges(int elements, int places, const double *place, double *edges);

#endif
