/* Stiff and extreme scenes, each with the outcome that a user should expect, and what came of it.
 * The parts of cpinn-stress. */
#ifndef TOOLS_JUDGE_STRESS_STRESS_H
#define TOOLS_JUDGE_STRESS_STRESS_H

#include "tools/train/session.h"

enum { STRESS_OVERRIDES_MAX = 6, STRESS_TEXT = 512 };

/* Those that can be expected come first. */
#define STRESS_OUTCOME_LIST(X)                                                                     \
    X(STRESS_SOLVED, "solved")   /* to an error <= bound, and nothing was said against it */       \
    X(STRESS_DOUBTED, "doubted") /* trained to the end, and the program says what is wrong */      \
    X(STRESS_REFUSED, "refused") /* before anything was computed */                                \
    X(STRESS_STOPPED, "stopped") /* on the way, with a reason */                                   \
    X(STRESS_WRONG, "wrong")     /* beyond the bound, and nothing was said */                      \
    X(STRESS_OUT_OF_TIME, "out of time") /* its own clock ended it */                              \
    X(STRESS_HUNG, "hung")               /* it had to be killed */                                 \
    X(STRESS_CRASHED, "crashed")         /* a signal, or an exit from within */

#define STRESS_ENUM(name, text) name,
typedef enum stress_outcome {
    STRESS_OUTCOME_LIST(STRESS_ENUM) STRESS_OUTCOME_COUNT
} stress_outcome;
#undef STRESS_ENUM

const char *stress_outcome_name(stress_outcome outcome);

typedef enum stress_method { STRESS_PINN, STRESS_SOLVER, STRESS_METHODS } stress_method;

const char *stress_method_name(stress_method method); /* "pinn", "solver" */

typedef struct stress_expectation {
    stress_outcome outcome;
    double bound;     /* of a solution's error */
    const char *text; /* of the others: what the line that the user reads has to contain */
    const char *why;  /* this bound, this outcome; a few words */
} stress_expectation;

/* What a method has found, and what is measured of it; NaN: it cannot be. */
typedef struct stress_answer stress_answer;
typedef ad_status stress_measure(const stress_answer *a, double *error, ad_error *reason);

typedef struct stress_row {
    const char *name;                            /* "slender/10000": subject/case */
    const char *scene;                           /* YAML */
    const char *overrides[STRESS_OVERRIDES_MAX]; /* as for --set; ends with NULL */
    const char *file;            /* what is in reference.csv beside the scene; NULL: no file */
    void (*write)(FILE *file);   /* or who writes it */
    stress_measure *measure;     /* the error; NULL: of position against the reference */
    double seconds;              /* of the processor, for training, at most; 0: 10 */
    const char *solver_override; /* one more, of its scene alone; or NULL */
    double tolerance;            /* of the solver; 0: its default */
    bool quick, is_long;         /* in the short selection; only in the long one */
    stress_expectation expected[STRESS_METHODS]; /* why is NULL: not for this method */
} stress_row;

typedef struct stress_group {
    const char *about;
    const stress_row *rows;
    int count;
} stress_group;

extern const stress_group stress_rods, stress_loads, stress_motions, stress_beams, stress_pairs,
    stress_inputs;

typedef struct stress_result {
    stress_outcome outcome;
    double error;   /* NaN: none */
    double seconds; /* wall time of the answer, else of its process */
    bool as_expected;
    char text[STRESS_TEXT]; /* why; one line */
} stress_result;

/* Runs a row by a method in a process of its own, which has `folder` for its files and ends with
 * all that it started. AD_IO: there is no such process. */
ad_status stress_run(const stress_row *row, stress_method method, const char *folder,
                     stress_result *result, ad_error *error);

/* Largest change of the energy of a motion, kinetic, elastic and of gravity and a dead load at the
 * tip, from the time on at which nothing drives it, over the largest kinetic energy. */
stress_measure stress_energy_drift;

/* Angle between rotations, root mean square over the points of the reference, rad. */
stress_measure stress_rotation;

/* For stress_row.write: reference.csv of closed forms, for rods of L = EI = 1, and rhoA = 1 where
 * they move; the bending stiffness is dimensionless throughout. */

/* Elastica along +x under the tip force (0, 0, -4). */
void stress_write_elastica(FILE *file);

/* The tip of a cantilever along +z, at rest at t = 0, until t = 1, that a small force along +x
 * bends: Euler and Bernoulli's modes (Meirovitch, Fundamentals of Vibrations, ch. 8). 1e-3 from the
 * start; 1e-3 from 0.1 on; 1e-2 from 0.1 to 0.2; 0.1 from 0.1 to 0.11. */
void stress_write_step_at_once(FILE *file);
void stress_write_step(FILE *file);
void stress_write_push(FILE *file);
void stress_write_blow(FILE *file);

/* The same tip under 1e-2 t/10, until t = 10, creeping: bending damped by 10, inertia left out. */
void stress_write_creep(FILE *file);

/* The tip of a round rod, length over radius 100, in motion as in configs/slender.yaml, its length
 * and time unit 1 mm and 1 ms; 1 km and 1 h. */
void stress_write_small(FILE *file);
void stress_write_large(FILE *file);

#endif
