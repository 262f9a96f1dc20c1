/* A family of rods at rest as C: a network that says the curvature of a member, the equation that
 * polishes it, the shape that follows. What cpinn-export writes of a run of the strain form. */
#ifndef TOOLS_EMIT_EXPORT_FAMILY_H
#define TOOLS_EMIT_EXPORT_FAMILY_H

#include "physics/chain/solve_members.h"
#include "physics/rod/strain.h"
#include "tools/emit/export_compile.h"
#include "tools/environment/surface_tree.h"

#include <stdio.h>

struct experiment;

/* Members over the ranges by which the mesh of a run is judged. */
enum { EXPORT_JUDGED = 256 };

/* A surface that the robot must not touch. */
typedef struct export_wall {
    const surface_tree *surface;
    double radius, from; /* of the robot, m; s from which on it counts */
} export_wall;

typedef struct export_family {
    const char *name;                       /* a C identifier */
    const char *about;                      /* of the comment of the header: a few words */
    const scene *open;                      /* with parameters that have ranges */
    strain_mesh mesh;                       /* of the curvature */
    bool single;                            /* float in place of double */
    bool tip;                               /* functions of the end by itself */
    bool shape_by;                          /* derivatives of the whole shape */
    int places;                             /* of the shape */
    const double *s;                        /* [places], ascending, of the length; the last one 1 */
    int columns, which[STRAIN_COLUMNS_MAX]; /* of the shape, of strain_rod_columns */
    double tolerance; /* without a network, of the curvature times the length */
    /* NULL: members follow their loads from the unstressed rod (EXPORT_CODE). Else it
     * records the curvature times the length, and torsions, [3 + tubes][nodes], at coordinates x
     * [parameters], 0 to 1 over their ranges; with `weights`, its parameters. */
    ad_value (*network)(const void *context, ad_tape *tape, const ad_value *x);
    const void *context;
    const double *weights;
    double mesh_error; /* m, of equilibria on the mesh, for strain_mesh_unresolved of their
                        * curvature: comes to each distance */
    const struct export_wall *wall; /* NULL: none */
    size_t workspace; /* numbers of the functions; by export_family_write_source, as the next */
    int state;        /* numbers of the state of the rod */
    int forces, held; /* that are sought before and after the curvature, */
    int tubes;        /* and whose torsions are */
    bool follows;     /* forces follow the rod */
    bool placed;      /* a law depends on the position, or the end is held */
    /* Of the self-test: members with their parameters, float numbers where `single`; the curvature
     * times the length by the network, and after `steps`, with torsions. */
    int members, steps;
    const double *parameters, *curvature,
        *polished;                    /* [members][parameters], [nodes][3 + tubes] twice */
    const double *shapes;             /* then, [compared][columns] */
    double scale[STRAIN_COLUMNS_MAX]; /* of each of the columns */
    /* Differences from these that cc has measured, by the scales: of the curvature by the network
     * and after a step, then of each column and its derivatives. NaN: not measured. */
    const double *values, *derivatives; /* [1 + columns] */
} export_family;

/* Texts of the C: lines, NULL at the end; the last is for what is compiled at run time. */
extern const char *const export_family_types[];
extern const char *const export_equation_functions[], *const export_family_functions[];
extern const char *const export_solver_functions[], *const export_wall_functions[];
extern const char *const export_wall_distance[];
extern const char *const export_family_selftest[], *const export_code_functions[];

/* Which places of the shape the self-test compares: the last, with shape_by some before it. */
enum { EXPORT_COMPARED = 3 };
int export_family_compared(const export_family *family, int places[EXPORT_COMPARED]);

/* Of a run in the strain form: scene, mesh, network, weights, and how far the mesh is off, by
 * members over the ranges: their parameters [EXPORT_JUDGED][parameters], float numbers where
 * f->single, and what the network says of them, said [EXPORT_JUDGED][nodes][3 + tubes], 1/m.
 * Outlived by the run. AD_NO_MEMORY. */
ad_status export_family_of(const struct experiment *e, export_family *f, double *parameters,
                           double *said, ad_error *error);

/* The same with shapes of these columns at places s, m, and without measured differences; *numbers,
 * which it keeps, are to be freed after it. */
ad_status export_family_at(const struct experiment *e, int columns, int places, const double *s,
                           export_family *f, double **numbers, ad_error *error);

/* The same without a network, of members that follow their loads on the mesh of a solver.
 * AD_BAD_ARGUMENT: the solver's mesh is none of this form; AD_NO_MEMORY. */
ad_status export_family_solved(const scene *open, const solve_members *solver, double tolerance,
                               int columns, int places, const double *s, export_family *f,
                               double **numbers, ad_error *error);

/* EXPORT_JUDGED members: a sequence of Kronecker's, by the roots of primes. */
void export_family_judged(const scene *open, double *parameters);

/* An export_writer of the texts of an export_family, or all in one text that defines ad_code_table
 * (autodiff/ad.h), an export_family_table or, without a network, an export_solver_table, with the
 * columns and derivatives of whole shapes, family->shape_by. AD_BAD_ARGUMENT: strain_check;
 * AD_NO_MEMORY. */
enum { EXPORT_CODE = EXPORT_TEXTS };
export_writer export_family_write;

/* shape [places][columns] and, unless NULL, jacobian [places][columns][parameters] of a member
 * after some steps; said NULL: quicker, else [EXPORT_SAID] that are known of it, as model_answer of
 * family_types.h has them: why, a solve_doubt. Returns what model_shape does. memory: of so many
 * numbers. */
enum { EXPORT_PREDICTED, EXPORT_LEFT, EXPORT_WHY, EXPORT_SAID };
typedef struct export_family_table {
    size_t memory;
    int (*answer)(const double *parameters, int steps, double *shape, double *jacobian,
                  double *said, double *memory);
} export_family_table;

/* The same of an equilibrium that is found along its loads (physics/chain/solve_members.h); said
 * [EXPORT_SOLVED], with the steps of Newton's method: how far the last of them moves the rod, m,
 * and what strain_mesh_unresolved says. EXPORT_SINGULAR: there is none, or no derivatives. */
enum { EXPORT_MOVED, EXPORT_UNRESOLVED, EXPORT_STEPS, EXPORT_SOLVED };
typedef struct export_solver_table {
    size_t memory;
    int (*solve)(const double *parameters, double *shape, double *jacobian, double *said,
                 double *memory);
} export_solver_table;

#endif
