/* What a family of rods really depends on: the dimensionless numbers of its equations, as inputs of
 * networks, in place of the parameters by which its author names the members.
 *
 *   groups_find(&family, &settings, &x, &error);
 *   ad_value inputs = groups_record(x, parameters, &turn);      [groups_count(x)], about -1 to 1
 *   ... a network of the inputs says the curvature u as u[0], u[1], u[2] ...
 *   groups_restore(&turn, u);
 *   groups_free(x);
 *
 * Members with the same groups have the same shape over their length (Buckingham, Phys. Rev. 4,
 * 1914). Forces are counted by EI/L^2, moments by EI/L, distributed ones by EI/L^3 and EI/L^2, with
 * EI the member's own, compliances by 1/EI and L^2/EI, all at some places along the rod. What
 * actuators do is their force and moment in the unstressed rod, and what they pull.
 *
 * Of these numbers those are left out that do not change, that are linear in others or follow from
 * them by a smooth function, and that do not move the rod. Each is mapped to -1 .. 1, and those
 * that move it little to less.
 *
 * Symmetry. Suppose that the section has no preferred direction, and that a turn about d3 of the
 * base or a mirror puts each actuator in the place of another. Then members come in sets
 * of equal shapes, but for the turn. Inputs are those of the one member of a set whose pull
 * (without actuators: the strongest load across the base) points into one sector, and the answer is
 * turned back. Derivatives by parameters are those within the sector. At its edges a network's
 * answer jumps by a part of its error. Three or more equal tendons around a round rod look the same
 * after any turn, but for what they pull beyond their force, their moment and their resistance to
 * twist. That is of third order in the strains. Where it moves the rod by less than networks of
 * many inputs miss it by, it is left to Newton's steps on their answers. */
#ifndef PHYSICS_LEARN_GROUPS_H
#define PHYSICS_LEARN_GROUPS_H

#include "physics/scene/scene.h"

#ifdef __cplusplus
extern "C" {
#endif

/* Name in C, name in YAML. */
#define GROUPS_INPUTS_LIST(X)                                                                      \
    X(GROUPS_OF_EQUATIONS, "groups")   /* those of the equations */                                \
    X(GROUPS_PARAMETERS, "parameters") /* the parameters themselves, mapped to -1 .. 1 */
#define GROUPS_SYMMETRY_LIST(X)                                                                    \
    X(GROUPS_SYMMETRY, "auto") /* with many inputs also one that holds nearly */                   \
    X(GROUPS_EXACT, "exact")                                                                       \
    X(GROUPS_NO_SYMMETRY, "none")

#define GROUPS_ENUM(name, text) name,
typedef enum groups_inputs { GROUPS_INPUTS_LIST(GROUPS_ENUM) } groups_inputs;
typedef enum groups_symmetry { GROUPS_SYMMETRY_LIST(GROUPS_ENUM) } groups_symmetry;
#undef GROUPS_ENUM

typedef struct groups_settings {
    groups_inputs inputs;
    groups_symmetry symmetry; /* of parameters there is none */
} groups_settings;

typedef struct groups groups;

/* Determined by the scene and the settings alone, so that a checkpoint need not hold it. Parameters
 * must be open names of the scene's formulas, which outlive the groups. A family of beams, of
 * manufactured solutions, or of rods in more than 64 pieces gets its parameters. AD_NO_MEMORY;
 * AD_BAD_INPUT: a number of the equations is not finite for members within the ranges. */
ad_status groups_find(const scene *family, const groups_settings *settings, groups **result,
                      ad_error *error);
void groups_free(groups *groups); /* NULL is allowed */

int groups_count(const groups *groups);
double groups_range(const groups *groups, int input); /* it lies within - this .. this, up to 1 */

/* How a member lies to the one of its set that the inputs are of. One row each. */
typedef struct groups_turn {
    bool turns, mirrors;         /* false: not at all, for all members */
    ad_value cosine, sine, sign; /* sign -1: mirrored */
} groups_turn;

/* [groups_count] inputs for parameters [parameter_count] in SI, in the scene's order; turn may be
 * NULL. */
ad_value groups_record(const groups *groups, ad_value parameters, groups_turn *turn);

/* An axial vector in body components (curvature u, moment m) of that member becomes the one of the
 * member itself; entries of any equal rows. */
void groups_restore(const groups_turn *turn, ad_value vector[3]);

/* Line `index` for people: a group with its range and the parameters that it depends on, parameters
 * without effect, the symmetry. False: there are not so many. */
bool groups_text(const groups *groups, int index, char *text, size_t size);

#ifdef __cplusplus
}
#endif

#endif
