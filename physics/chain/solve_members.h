/* Many equilibria of one rod at rest at once, each with its own values of named parameters: what
 * data for networks are drawn from, and what networks are verified by. In the strain form
 * (strain_form.h), LANES members side by side and groups of them over threads, and over
 * ranks where there are any.
 *
 *   quantities_coordinate(names, "pull", &error);          the name stays open in formulas that
 *   scene.tendons[0].tension = quantity_formula(names, "pull");              are read afterwards
 *   scene.parameters[scene.parameter_count++] = (scene_parameter){"pull", 0, 2, SCENE_LINEAR};
 *   solve_members_create(&scene, &settings, &members, &error);
 *   solve_members_solve(members, count, parameters, values, results, &error);
 *   solve_members_free(members);
 *
 * Each member is the equilibrium that continues the unstressed rod while all loads and all that
 * pulls grow together from 0, as long as that is stable. One that is not solved may still have an
 * equilibrium, which solution_create with its numbers (scene_member) looks for. Places where
 * something jumps cut the rod into pieces, and the time is that of a piece times their number. It
 * is that of a full matrix with friction of tendons or with concentric tubes. So it is with springs
 * or a foundation, which do not grow with the loads, or with an end that is held, which moves to
 * its place. Tendons of given displacement are pulled with the loads, too; each takes the time of
 * one more right side.
 */
#ifndef PHYSICS_CHAIN_SOLVE_MEMBERS_H
#define PHYSICS_CHAIN_SOLVE_MEMBERS_H

#include "autodiff/ranks.h"
#include "physics/scene/scene.h"

#ifdef __cplusplus
extern "C" {
#endif

enum { SOLVE_MEMBERS_COLUMNS = 13 }; /* r in m, q, v, u in 1/m; as a model's first columns */
enum { SOLVE_MEMBERS_FORCES = 6 };   /* n in N, m in N m; its next ones */

typedef struct solve_members_settings {
    double tolerance; /* > 0; of the position, over the length */
    int threads;      /* 0: one per processor */
    size_t points;
    const double *s;       /* [points] where the shape is wanted, m; ascending */
    const ad_ranks *ranks; /* borrowed; among which members are dealt: all of them call the same
                            * functions; NULL: this process is by itself */
    bool own_curvature; /* it is given by this solver alone, neither by a network nor by C that is
                         * written: one point may have that of a piece */
} solve_members_settings;

/* Why a member has no solution. */
typedef enum solve_member_end {
    SOLVE_MEMBER_SOLVED,
    SOLVE_MEMBER_UNSTABLE, /* its stable equilibria from the unstressed rod on end at `load` */
    SOLVE_MEMBER_LOST,     /* Newton's method does not settle beyond `load` */
    SOLVE_MEMBER_COARSE,   /* the estimate is above the tolerance on the finest mesh, too */
    SOLVE_MEMBER_ENDS
} solve_member_end;

/* In words; NULL of one that is solved. */
const char *solve_member_text(solve_member_end end);

/* What is known of one member. */
typedef struct solve_member {
    double estimate; /* of the largest error of the position before the last step, over the length:
                      * that step was taken with more modes, and lessens it; infinite where there
                      * is no equilibrium */
    double load;     /* factor that was reached; 1: all of it */
    int nodes;       /* of the last step */
    int steps;       /* of Newton's method */
    bool solved;     /* under the whole load, and the estimate is within the tolerance */
    solve_member_end end;
} solve_member;

typedef struct solve_members solve_members;

/* Of a scene with parameters, or without any. AD_BAD_INPUT: a scene that the checks refuse, or a
 * parameter where it has one number for all. AD_BAD_ARGUMENT: what only solution_create solves:
 * motions, beams, starts that are not clamped, ends that an angle turns, friction of tendons where
 * something jumps. AD_NO_MEMORY. The scene is copied, its formulas must outlive the members. */
ad_status solve_members_create(const scene *open, const solve_members_settings *settings,
                               solve_members **result, ad_error *error);
void solve_members_free(solve_members *members); /* NULL is allowed */

/* Whether nothing acts on the rod but actuators whose pull is given, and tubes: no point of the rod
 * asks another then, but by tubes, and a member takes half the time or less. */
bool solve_members_is_unloaded(const solve_members *members);

/* values [members][points][SOLVE_MEMBERS_COLUMNS], NaN of members without an equilibrium under the
 * whole load, and results [members], for parameters [members][parameter_count], which may lie
 * beyond their ranges. The bits are the same for any number of threads, and for members in any
 * order. Does not allocate. What a tape says of a
 * formula. */
ad_status solve_members_solve(solve_members *solver, size_t members, const double *parameters,
                              double *values, solve_member *results, ad_error *error);

/* How loads are followed, here and by C that is written. The largest ratio of the first two steps
 * of Newton's method, and of others. How exactly equilibria on the way are found, curvature times
 * length, and the last one, of the tolerance. The shortest step of the load; how much longer the
 * next one is after three steps, how much shorter where they do not settle. Steps at a load are
 * fewer than the last. */
#define SOLVE_PATH_RULES(X)                                                                        \
    X(FIRST_RATIO, 0.4)                                                                            \
    X(RATIO, 0.5)                                                                                  \
    X(ON_THE_WAY, 1e-3)                                                                            \
    X(LEAVES, 0.3)                                                                                 \
    X(SHORTEST, 1e-3)                                                                              \
    X(LONGER, 2.5)                                                                                 \
    X(SHORTER, 0.3)                                                                                \
    X(STEPS_MAX, 10)

/* ---- curvature, out and in ----------------------------------------------------------------- */

/* Curvature u, 1/m, in the frame of the section, is given and taken at the points of one mesh:
 * those of Gauss between places where something jumps. Where the scene is a family with ranges of
 * all parameters, as many as nearly all of some random members need; else 4 to 8 in each piece. Two
 * of each where curvature is the solver's own, and nothing acts but what pulls, the same all along
 * it. */
size_t solve_members_nodes(const solve_members *members);

/* How many numbers of a member are given and taken at each of them: its curvature, then the torsion
 * of each tube, over the scale of bending stiffness (rod_scales), 1/m; 0 beyond its end. What is
 * called curvature here has them all, [members][nodes][width]. */
size_t solve_members_width(const solve_members *members);
size_t solve_members_numbers(const solve_members *members); /* at all of them */

double solve_members_torsion(const solve_members *members); /* what 1/m of it is, N m */

/* s [nodes], m, ascending. */
void solve_members_places(const solve_members *members, double *s);

/* As solve_members_solve, and curvature [members][nodes][width], not numbers where a member is not
 * solved. values, curvature may be NULL. */
ad_status solve_members_curvature(solve_members *solver, size_t members, const double *parameters,
                                  double *values, double *curvature, solve_member *results,
                                  ad_error *error);

/* jacobian [members][points][SOLVE_MEMBERS_COLUMNS][parameter_count - from], the derivatives of the
 * values by the parameters from number `from` on at equilibria of this curvature, in SI units. They
 * are those of what solve_members_refine makes of it, by the implicit function theorem, to some
 * 1e-8 of them where the mesh resolves it. Not numbers where the curvature is none, or where an
 * equilibrium is at a fold. All of it by this process, also where there are ranks. The first call
 * records and compiles. AD_NO_MEMORY; errors of formulas. */
ad_status solve_members_jacobian(solve_members *solver, size_t members, const double *parameters,
                                 const double *curvature, int from, double *jacobian,
                                 ad_error *error);

/* The same, jacobian, with force and moment in the rod, body, then of each concentric tube its
 * angle and torsion, rad and N m, forces [members][points][solve_members_carried], and their
 * derivatives, by [members][points][solve_members_carried][parameter_count - from]; each may be
 * NULL. They are those of rod and actuators together, as the balance has them (strain_form.h): 0
 * where nothing acts but actuators. Where something jumps within the rod they are of the piece
 * before. All are polynomials of the mesh of the curvature, which positions choose. Of a robot of
 * tubes whose rest shape waves angles were off by 5e-5 rad and torsions by 5e-3 of the largest,
 * where positions were to 1e-13 m. */
size_t solve_members_carried(const solve_members *members);
ad_status solve_members_forces(solve_members *solver, size_t members, const double *parameters,
                               const double *curvature, int from, double *jacobian, double *forces,
                               double *by, ad_error *error);

enum { SOLVE_MARGINS = 2 };

/* The stability margin of equilibria next to this curvature and the next that bounds it, margin
 * [members][SOLVE_MARGINS], and their derivatives by the parameters, by
 * [members][SOLVE_MARGINS][parameter_count], or NULL. It is the least of the second
 * variation of the energy over what the same change of curvature stores in bending and twist by the
 * section alone, at most 1. That is the share of these stiffnesses that the rod could lose, all
 * else and the shape as they are, before it gives way. 1 where nothing softens it, as without
 * loads; 0 where it gives way; of a column 1 - P/P_cr. In the plane alone where `motion` of a
 * planar family says so, or where its loads have an energy in the plane alone. It means that where
 * the loads have an energy (physics/solve/stability.h). The margin has a kink where it and the next
 * one are the same, as of a column that buckles in two planes. Each is smooth along its own vector,
 * and both together bound the margin without a kink. Derivatives are those by these vectors, by
 * differences of fourth order along the equilibria. They are off by some 1e-8 where the mesh
 * resolves these and a fold is not within 1e-3 of a range. Not a number where it is not found.
 * AD_NO_MEMORY, AD_NO_BLAS; errors of formulas. */
ad_status solve_members_margin(solve_members *solver, size_t members, const double *parameters,
                               const double *curvature, double *margin, double *by,
                               ad_error *error);

/* Why a curvature that was given is not trusted. */
typedef enum solve_doubt {
    SOLVE_NO_DOUBT,
    SOLVE_NOT_FINITE,  /* it, or what follows from it, is none */
    SOLVE_UNSTABLE,    /* the matrix there has a negative pivot: another branch, or none */
    SOLVE_TOO_FAR,     /* `predicted` is above SOLVE_TRUSTED */
    SOLVE_NOT_SETTLING /* a step is more than a quarter of that before */
} solve_doubt;

/* Largest distance, over the length, of which a step still says how far an equilibrium is. */
#define SOLVE_TRUSTED 0.05

/* What is known of a curvature that was given. Distances are the largest over the rod, in m, from
 * the shape to that of one more step, of two where an end is held. The step is linearised where the
 * last was. The mesh's own error is in them. */
typedef struct solve_answer {
    double predicted;   /* of what was given */
    double left;        /* of what is returned */
    double ratio;       /* of the last two steps; NaN: none was taken */
    bool stable;        /* no pivot is negative */
    bool trusted;       /* predicted and left are what they say, and the equilibrium is that of
                         * solve_members_solve */
    solve_doubt reason; /* else */
} solve_answer;

/* From curvature [members][nodes][width] that somebody else has found: 0, 1 or 2 steps of Newton's
 * method. values [members][points][SOLVE_MEMBERS_COLUMNS] and refined [members][nodes][width] of
 * what is then, answers [members]; each may be NULL, and without answers and steps no matrix is
 * made. steps = -1: refined is what a step makes of the curvature, the rest as with 0. Bits as in
 * solve_members_solve. */
ad_status solve_members_refine(solve_members *solver, size_t members, const double *parameters,
                               const double *curvature, int steps, double *values, double *refined,
                               solve_answer *answers, ad_error *error);

#ifdef __cplusplus
}
#endif

#endif
