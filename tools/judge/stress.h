/* Stiff and extreme scenes, each with the outcome that a user should expect, and what came of it.
 * The parts of cpinn-stress. */
#ifndef TOOLS_JUDGE_STRESS_H
#define TOOLS_JUDGE_STRESS_H

#include "tools/judge/judge.h"

enum { STRESS_OVERRIDES_MAX = 6, STRESS_ROWS_MAX = 256 };

typedef struct stress_expectation {
    verdict_outcome outcome;
    verdict_reason reason; /* that is among those of the verdict; VERDICT_NONE: any */
    double bound;          /* of a solution's error, with or without a warning; 0: none */
    const char *text;      /* what a line that the user reads has to contain, or NULL */
    const char *why;       /* this bound, this outcome; a few words */
} stress_expectation;

typedef void stress_write(FILE *file);

typedef struct stress_row {
    const char *name;                            /* "slender/10000": subject/case */
    const char *about;                           /* of the first row of a group, else NULL */
    const char *scene;                           /* YAML */
    const char *overrides[STRESS_OVERRIDES_MAX]; /* as for --set; ends with NULL */
    const char *file;            /* what is in reference.csv beside the scene; NULL: no file */
    stress_write *write;         /* or who writes it */
    judge_error *measure;        /* the error; NULL: of position against the reference */
    double seconds;              /* of the processor, for training, at most; 0: 10 */
    const char *solver_override; /* one more, of its scene alone; or NULL */
    double tolerance;            /* of the solver; 0: its default */
    bool quick, is_long;         /* in the short selection; only in the long one */
    stress_expectation expected[JUDGE_METHODS]; /* why is NULL: not for this method */
} stress_row;

/* The rows of stress.yaml, [*count]. AD_BAD_INPUT: the file is not as its head says. */
typedef struct stress_rows stress_rows;

ad_status stress_rows_open(stress_rows **rows, ad_error *error);
void stress_rows_free(stress_rows *rows); /* NULL is fine */
const stress_row *stress_rows_of(const stress_rows *rows, size_t *count);

extern const char *const stress_text_stress[]; /* its lines, NULL at the end */

/* Runs a row by a method in a process of its own, which has `folder` for its files and ends with
 * all that it started. An answer beyond the bound without another warning than the expected is
 * wrong, the verdict then says. AD_IO: there is no such process, or no file. */
ad_status stress_run(const stress_row *row, judge_method method, const char *folder,
                     judge_row *result, ad_error *error);

bool stress_as_expected(const stress_expectation *expected, const verdict *found);

/* Largest change of the energy of a motion, kinetic, elastic and of gravity and a dead load at the
 * tip, from the time on at which nothing drives it, over the largest kinetic energy. */
judge_error stress_energy_drift;

/* Angle between rotations, root mean square over the points of the reference, rad. */
judge_error stress_rotation;

/* Who writes reference.csv of a closed form, for rods of L = EI = 1, and rhoA = 1 where they move;
 * the bending stiffness is dimensionless throughout. NULL: there is none of this name.
 *
 * elastica: along +x under the tip force (0, 0, -4).
 *
 * step_at_once, step, push, blow: the tip of a cantilever along +z, at rest at t = 0, until t = 1,
 * that a small force along +x bends: Euler and Bernoulli's modes (Meirovitch, Fundamentals of
 * Vibrations, ch. 8). 1e-3 from the start; 1e-3 from 0.1 on; 1e-2 from 0.1 to 0.2; 0.1 from 0.1 to
 * 0.11.
 *
 * creep: the same tip under 1e-2 t/10, until t = 10: bending damped by 10, inertia left out.
 *
 * small, large: the tip of a round rod, length over radius 100, in motion as in
 * configs/slender.yaml, its length and time unit 1 mm and 1 ms; 1 km and 1 h. */
stress_write *stress_formula(const char *name);

#endif
