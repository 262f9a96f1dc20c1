/* Single members of a family in the strain form, by C that is written for them (export_family.h),
 * compiled and kept: in a third of the time that LANES of them side by side take. */
#ifndef TOOLS_LIBRARY_MEMBER_CODE_H
#define TOOLS_LIBRARY_MEMBER_CODE_H

#include "tools/library/cpinn.h"
#include "tools/train/experiment.h"

typedef struct member_code member_code;

/* Their text, and what it takes to compile it, grow with the places of the shape. */
enum { MEMBER_CODE_POINTS_MAX = 101 };

/* Shapes at s [points], m, of a run that outlives it: SOLVE_MEMBERS_COLUMNS of its columns, or with
 * `forces` solve_members_carried more. Waits for the compiler where nothing is kept.
 * AD_IO: no compiler, or no folder for what it makes; AD_BAD_ARGUMENT: strain_check, too many
 * points; AD_NO_MEMORY.
 */
ad_status member_code_create(const experiment *e, bool forces, size_t points, const double *s,
                             member_code **result, ad_error *error);
void member_code_free(member_code *code); /* NULL is allowed */

/* The same of members that are solved, by a solver of settings that are its own. AD_BAD_ARGUMENT
 * also where more than curvature is sought, or nothing is a parameter. */
ad_status member_code_create_solver(const scene *open, bool forces, solve_members *solver,
                                    const solve_members_settings *settings, member_code **result,
                                    ad_error *error);

/* values [points][columns] as solve_members_solve and solve_members_forces have them, and jacobian
 * [points][columns][parameters], unless NULL. Returns whether the member is solved; else that is
 * left to the solver. */
bool member_code_solve(const member_code *code, const double *parameters, double *values,
                       double *jacobian, solve_member *result);

/* values [points][columns] and, unless NULL, jacobian [points][columns][parameters]
 * and the answer, in SI units, of a member within the ranges after some steps. */
void member_code_answer(const member_code *code, int steps, const double *parameters,
                        double *values, double *jacobian, cpinn_answer *answer);

#endif
