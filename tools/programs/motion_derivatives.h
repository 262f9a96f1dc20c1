/* Derivatives of a motion by the parameters of its family, beside the solution of a member
 * (physics/solve/motion_change.h). */
#ifndef TOOLS_PROGRAMS_MOTION_DERIVATIVES_H
#define TOOLS_PROGRAMS_MOTION_DERIVATIVES_H

#include "physics/scene/verdict.h"
#include "physics/solve/motion_change.h"
#include "tools/config/config.h"
#include "tools/files/json.h"
#include "tools/programs/cli.h"
#include "tools/programs/samples.h"

typedef struct motion_derivatives {
    config *family;        /* NULL: none are wanted */
    motion_change *change; /* NULL: none were found yet */
    motion_change_report report;
    double allowed; /* estimated error; INFINITY: modes are given, and nothing is estimated */
    double *at;     /* [count of the grid] s of its points along the member */
} motion_derivatives;

/* The family of the member `at` of a scene, whose values the grid takes, and what it asks. Errors
 * of reading. */
ad_status motion_derivatives_open(const char *path, const cli_list *overrides, const char *at,
                                  samples *grid, motion_derivatives *result, ad_error *error);
void motion_derivatives_free(motion_derivatives *of); /* not itself */

/* Where the family is there, at the places of the grid, whose s become those of the family. Errors
 * of motion_change_create. */
ad_status motion_derivatives_find(motion_derivatives *of, const scene *member, samples *grid,
                                  const solve_settings *settings, ad_error *error);

/* The solution of the member with these, at all points of the grid. */
answer motion_derivatives_answer(motion_derivatives *of, const solution *solved);

/* Nothing where none were found. */
void motion_derivatives_judge(const motion_derivatives *of, verdict *to);
void motion_derivatives_print(const motion_derivatives *of);
void motion_derivatives_json(const motion_derivatives *of, json *to);

#endif
