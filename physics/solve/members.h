/* Many equilibria of one rod at rest at once, each with its own values of named parameters: what
 * data for networks are drawn from, and what networks are verified by. In the strain form
 * (strain_form.h), LANES members side by side and groups of them over threads.
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
 * equilibrium, which solution_create with its numbers (scene_member) looks for. Followers and
 * moments, whose derivatives are not local, and places where something jumps make members slower:
 * forces alone on a rod that is one piece take ten microseconds, a rod of three with followers a
 * thousand.
 */
#ifndef PHYSICS_SOLVE_MEMBERS_H
#define PHYSICS_SOLVE_MEMBERS_H

#include "physics/scene.h"

#ifdef __cplusplus
extern "C" {
#endif

enum { SOLVE_MEMBERS_COLUMNS = 13 }; /* r in m, q, v, u in 1/m; as a model's first columns */

typedef struct solve_members_settings {
    double tolerance; /* > 0; of the position, over the length */
    int threads;
    size_t points;
    const double *s; /* [points] where the shape is wanted, m; ascending */
} solve_members_settings;

/* What is known of one member. */
typedef struct solve_member {
    double estimate; /* of the largest error of the position before the last step, over the length:
                      * that step was taken with more modes, and lessens it; infinite where there
                      * is no equilibrium */
    double load;     /* factor that was reached; 1: all of it */
    int nodes;       /* of the last step */
    int steps;       /* of Newton's method */
    bool solved;     /* under the whole load, and the estimate is within the tolerance */
} solve_member;

typedef struct solve_members solve_members;

/* Of a scene with parameters, or without any. AD_BAD_INPUT: a scene that the checks refuse, or a
 * parameter where it has one number for all; AD_BAD_ARGUMENT: what only solution_create solves:
 * motions, beams, ends that are not clamped at s = 0 and free or loaded at s = length, springs,
 * foundations, bodies, tubes, tendons with friction or of given displacement. AD_NO_MEMORY. The
 * scene is copied, its formulas must outlive the members. */
ad_status solve_members_create(const scene *open, const solve_members_settings *settings,
                               solve_members **result, ad_error *error);
void solve_members_free(solve_members *x); /* NULL is allowed */

/* values [members][points][SOLVE_MEMBERS_COLUMNS], not numbers of members without an equilibrium
 * under the whole load, and results [members], for parameters [members][parameter_count], which
 * may lie beyond their ranges: the same bits for
 * any number of threads, and for members in any order. Does not allocate. What a tape says of a
 * formula. */
ad_status solve_members_solve(solve_members *x, size_t members, const double *parameters,
                              double *values, solve_member *results, ad_error *error);

#ifdef __cplusplus
}
#endif

#endif
