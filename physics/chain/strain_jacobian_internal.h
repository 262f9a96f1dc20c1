/* What strain_jacobian.c and strain_columns.c share. */
#ifndef PHYSICS_CHAIN_STRAIN_JACOBIAN_INTERNAL_H
#define PHYSICS_CHAIN_STRAIN_JACOBIAN_INTERNAL_H

#include "autodiff/memory.h"
#include "physics/chain/solve_members.h"
#include "physics/chain/strain_jacobian.h"

/* At a point: what actuators and the law of the section leave of the wrench, (1 + C T_vv)^-1, T_uv.
 */
typedef struct softness {
    lanes left[6], inverse[3][3], turned[3][3];
} softness;

/* The shape on the finer mesh, as it changes: u and v, and rates of the turn and of the position.
 */
typedef struct finer {
    lanes *u, *v, *turning, *slopes; /* [nodes][3] */
    lanes *carried, *twisted;        /* [nodes][6] N, M, or what they change by; as below */
    lanes (*edges)[2][3];            /* [elements + 1] turn, position */
} finer;

struct strain_jacobian {
    strain_group *group;
    solve_rod *changes;
    strain_level by;              /* has what numbers change by */
    double *values[STRAIN_PARTS]; /* of parts by all parameters */
    double *growth;               /* [LANES][outputs][count] */
    double *room;                 /* for strain_level_find */
    strain_sources sources;
    softness *softness;             /* [nodes] */
    lanes *sought, *left, *strains; /* [unknowns] what changes; [nodes][6]; [nodes][3] u or v */
    lanes (*carried)[6];            /* [nodes] N, M, or what they change by */
    lanes *twisted;                 /* [nodes][2 tubes] theta and torsion of each, or the same */
    finer fine;
    lanes *forces;     /* [2][outputs][carrying] world, body */
    lanes (*turns)[3]; /* [outputs] world, of a parameter */
    lanes *columns; /* [count] of one parameter after the other, or of several in different lanes,
                     * [outputs][SOLVE_MEMBERS_COLUMNS] and then as forces */
    size_t carrying, derived; /* solve_members_carried, and with these columns */
    ad_memory memory;
};

/* The mesh of the equations, and that of shapes. */
static inline strain_level *level_of(const strain_jacobian *x)
{
    return &x->group->level[x->group->modes];
}

static inline strain_level *fine_of(const strain_jacobian *x)
{
    return level_of(x) + STRAIN_BEYOND;
}

/* x->forces of the rod as it is linearised, and forces [members][outputs][carrying]. */
void strain_columns_carry(strain_jacobian *x);
void strain_columns_put_forces(strain_jacobian *x, size_t members, double *forces);

/* x->columns from `columns` on, of parameters which [LANES], by what is sought and the strains; of
 * forces, too, where it `carries` them. */
void strain_columns_find(strain_jacobian *x, bool carries, const int *which, lanes *columns);

/* All of them, of `count` parameters of which as many `copies` as there is room for are side by
 * side. */
void strain_columns_put(const strain_jacobian *x, size_t members, size_t copies, size_t count,
                        const strain_derived *to);

#endif
