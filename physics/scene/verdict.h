/* How a computation ended: one type for training, for the classical solvers and for the programs
 * that judge both. A verdict is a list of findings, the worst first; each has a reason, which is a
 * stable word for scripts, and a sentence for people. The outcome follows from the worst reason. No
 * findings: solved. A verdict holds no pointers, so it may be copied and sent between processes. */
#ifndef PHYSICS_SCENE_VERDICT_H
#define PHYSICS_SCENE_VERDICT_H

#include "autodiff/error.h"

#include <stdbool.h>
#include <stdio.h>

#ifdef __cplusplus
extern "C" {
#endif

/* One row per outcome: name, word, exit status of a program that ends so, meaning. Those after
 * `refused` can only be seen from outside, by a program that runs others. */
#define VERDICT_OUTCOME_LIST(X)                                                                    \
    X(VERDICT_SOLVED, "solved", 0, "there is an answer, and nothing speaks against it")            \
    X(VERDICT_WARNING, "warning", 3, "there is an answer, and a reason to distrust it")            \
    X(VERDICT_STOPPED, "stopped", 1, "the computation ended early, without a whole answer")        \
    X(VERDICT_REFUSED, "refused", 2, "nothing was computed, because of the input")                 \
    X(VERDICT_OUT_OF_TIME, "out of time", 1, "a time limit ended the computation")                 \
    X(VERDICT_HUNG, "hung", 1, "the process did not keep its time limit and was killed")           \
    X(VERDICT_CRASHED, "crashed", 1, "the process died")

/* One row per reason, from the mildest to the worst: name, word, outcome, meaning. Words are never
 * changed or reused. Reasons whose outcome is `solved` are remarks. */
#define VERDICT_REASON_LIST(X)                                                                     \
    X(VERDICT_NONE, "none", VERDICT_SOLVED, "nothing to remark")                                   \
    X(VERDICT_IMPLAUSIBLE, "implausible", VERDICT_SOLVED,                                          \
      "a size of the scene is hardly meant, as of a modulus in MPa or a length in mm")             \
    X(VERDICT_MISFIT_UNKNOWN, "misfit_unknown", VERDICT_SOLVED,                                    \
      "a learned law does not say how well it meets its data, so the error it leaves is unknown")  \
    X(VERDICT_SEVERAL_EQUILIBRIA, "several_equilibria", VERDICT_SOLVED,                            \
      "the rod is pushed from both ends, so that other equilibria may exist")                      \
    X(VERDICT_STABILITY_OPEN, "stability_open", VERDICT_SOLVED,                                    \
      "whether an equilibrium is stable is not known, or up to a damping that is not given")       \
    X(VERDICT_END_TURN, "end_turn", VERDICT_SOLVED,                                                \
      "a held end is turned so far that another way round may be meant")                           \
    X(VERDICT_REFERENCE_TOO_COARSE, "reference_too_coarse", VERDICT_SOLVED,                        \
      "the error measured is below the error of the reference itself")                             \
    X(VERDICT_NOISE_OVERSTATED, "noise_overstated", VERDICT_SOLVED,                                \
      "measurements are closer to the solution than the noise that is stated for them")            \
    X(VERDICT_KNOWN_TOGETHER, "known_together", VERDICT_SOLVED,                                    \
      "measurements tell a combination of unknowns much better than each of them")                 \
    X(VERDICT_ESTIMATE_OFF, "estimate_off", VERDICT_SOLVED,                                        \
      "what a filter has found is further from the truth than its standard deviation explains")    \
    X(VERDICT_LOCAL_OPTIMUM, "local_optimum", VERDICT_SOLVED,                                      \
      "an optimum is the best of several starts; there may be a better one elsewhere")             \
    X(VERDICT_ERROR_UNKNOWN, "error_unknown", VERDICT_WARNING,                                     \
      "residuals are small, and what error they leave is not known")                               \
    X(VERDICT_DEVIATIONS_ROUGH, "deviations_rough", VERDICT_WARNING,                               \
      "standard deviations of unknowns are off, as what is measured is far from linear in them")   \
    X(VERDICT_AT_BOUND, "at_bound", VERDICT_WARNING,                                               \
      "the value of an unknown that suits the measurements best is an end of its range")           \
    X(VERDICT_NOT_TOLD, "not_told", VERDICT_WARNING,                                               \
      "the measurements do not tell an unknown, or a combination of several")                      \
    X(VERDICT_SEVERAL_SOLUTIONS, "several_solutions", VERDICT_WARNING,                             \
      "other values of the unknowns suit the measurements as well")                                \
    X(VERDICT_MISFIT, "misfit", VERDICT_WARNING,                                                   \
      "measurements are further from the solution than their noise explains")                      \
    X(VERDICT_SNAPPED, "snapped", VERDICT_WARNING,                                                 \
      "a slowly growing load does not lead to this equilibrium: on the way stability is lost")     \
    X(VERDICT_UNSTABLE, "unstable", VERDICT_WARNING,                                               \
      "the forces balance, but the energy is no minimum: the rod buckles or snaps")                \
    X(VERDICT_ENERGY_OUT_OF_BALANCE, "energy_out_of_balance", VERDICT_WARNING,                     \
      "energy, work and dissipation of a motion do not add up")                                    \
    X(VERDICT_LOADS_OUT_OF_BALANCE, "loads_out_of_balance", VERDICT_WARNING,                       \
      "the loads on a whole rod at rest and the forces at its ends do not add up")                 \
    X(VERDICT_ESTIMATE_ABOVE_TOLERANCE, "estimate_above_tolerance", VERDICT_WARNING,               \
      "the estimated error is larger than what was asked for")                                     \
    X(VERDICT_ESTIMATES_CONTRADICT, "estimates_contradict", VERDICT_WARNING,                       \
      "network and reference are further apart than their estimated errors allow: one of the two " \
      "is wrong")                                                                                  \
    X(VERDICT_UNRESOLVED, "unresolved", VERDICT_WARNING,                                           \
      "a formula jumps in places that were not found, or varies on lengths too short for any "     \
      "mesh")                                                                                      \
    X(VERDICT_OUTSIDE_DATA, "outside_data", VERDICT_WARNING,                                       \
      "strains are beyond those of the data that the law of the section has learned from, or "     \
      "inputs beyond those of a learned residual")                                                 \
    X(VERDICT_STRAIN_LARGE, "strain_large", VERDICT_WARNING,                                       \
      "the rod is crushed or stretched to where no linear law of its section holds")               \
    X(VERDICT_NOT_CONVERGED, "not_converged", VERDICT_WARNING,                                     \
      "residuals are still large at points that were not trained on")                              \
    X(VERDICT_NO_OPTIMUM, "no_optimum", VERDICT_WARNING,                                           \
      "no start of an optimisation has ended at an optimum that a more exact solver confirms")     \
    X(VERDICT_INFEASIBLE, "infeasible", VERDICT_WARNING,                                           \
      "no values of the variables are known that keep all constraints of an optimisation")         \
    X(VERDICT_INTERPOLATES, "interpolates", VERDICT_WARNING,                                       \
      "the network fits the equations at its points, but not between them")                        \
    X(VERDICT_NOT_HELD, "not_held", VERDICT_WARNING,                                               \
      "a controlled robot is further off its path than it may be")                                 \
    X(VERDICT_CHATTERS, "chatters", VERDICT_WARNING,                                               \
      "inputs of a controlled robot jump to and fro from one sample to the next")                  \
    X(VERDICT_INNOVATIONS, "innovations", VERDICT_WARNING,                                         \
      "what sensors see of a controlled robot is not what its filter expects: the model is off")   \
    X(VERDICT_DIVERGED, "diverged", VERDICT_WARNING,                                               \
      "a controlled robot has left its path, a one-step model its robot, or a simulation failed")  \
    X(VERDICT_NOT_CERTIFIED, "not_certified", VERDICT_WARNING,                                     \
      "a way was found, and it is not certain that it keeps its clearance")                        \
    X(VERDICT_NONE_FOUND, "none_found", VERDICT_WARNING,                                           \
      "no way to the goal was found; there may be one")                                            \
    X(VERDICT_UNFINISHED, "unfinished", VERDICT_STOPPED, "training has steps left to do")          \
    X(VERDICT_LOAD_NOT_REACHED, "load_not_reached", VERDICT_STOPPED,                               \
      "equilibria could be followed to a part of the load only")                                   \
    X(VERDICT_NOT_FINITE, "not_finite", VERDICT_STOPPED, "a number stopped being finite")          \
    X(VERDICT_SIGNAL, "signal", VERDICT_STOPPED,                                                   \
      "the user or the system asked the program to end")                                           \
    X(VERDICT_FAILED, "failed", VERDICT_STOPPED,                                                   \
      "out of memory, a file that cannot be written, or steps that fail")                          \
    X(VERDICT_BAD_INPUT, "bad_input", VERDICT_REFUSED, "a file or an option is not valid")         \
    X(VERDICT_NO_METHOD, "no_method", VERDICT_REFUSED, "the method cannot compute this scene")     \
    X(VERDICT_TIME_LIMIT, "time_limit", VERDICT_OUT_OF_TIME, "the time limit was reached")         \
    X(VERDICT_KILLED, "killed", VERDICT_HUNG, "the process was killed after its time limit")       \
    X(VERDICT_DIED, "died", VERDICT_CRASHED, "the process ended by a signal or without a result")

typedef enum verdict_outcome {
#define VERDICT_OUTCOME_ENUM(name, word, status, help) name,
    VERDICT_OUTCOME_LIST(VERDICT_OUTCOME_ENUM)
#undef VERDICT_OUTCOME_ENUM
        VERDICT_OUTCOME_COUNT
} verdict_outcome;

typedef enum verdict_reason {
#define VERDICT_REASON_ENUM(name, word, outcome, help) name,
    VERDICT_REASON_LIST(VERDICT_REASON_ENUM)
#undef VERDICT_REASON_ENUM
        VERDICT_REASON_COUNT
} verdict_reason;

enum { VERDICT_TEXT = 512, VERDICT_FINDINGS_MAX = 6 };

typedef struct verdict_finding {
    verdict_reason reason;
    char text[VERDICT_TEXT]; /* one sentence, without a full stop */
} verdict_finding;

typedef struct verdict {
    int count;
    verdict_finding findings[VERDICT_FINDINGS_MAX]; /* [count], the worst first */
    int signal; /* with VERDICT_SIGNAL: its number, for the exit status; 0: unknown */
} verdict;

/* Adds a finding with a printf-style sentence. A reason that is there already keeps its sentence;
 * where there are too many findings the mildest is dropped. */
void verdict_add(verdict *v, verdict_reason reason, const char *format, ...)
    __attribute__((format(printf, 3, 4)));

/* Adds what an error says, with the reason that belongs to its status. Nothing for AD_OK. */
void verdict_add_error(verdict *v, const ad_error *error);

verdict_reason verdict_worst(const verdict *v); /* VERDICT_NONE without findings */
const char *verdict_text(const verdict *v);     /* sentence of the worst reason, or "" */
bool verdict_has(const verdict *v, verdict_reason reason);
verdict_outcome verdict_outcome_of(const verdict *v);

/* 0 solved, 3 warning, 2 refused, 128 + number of a signal that is known, 1 everything else. */
int verdict_exit_status(const verdict *v);

const char *verdict_outcome_name(verdict_outcome outcome); /* "out of time" */
const char *verdict_reason_name(verdict_reason reason);    /* "not_converged" */
verdict_outcome verdict_reason_outcome(verdict_reason reason);

/* The reason of that name; VERDICT_REASON_COUNT: there is none. */
verdict_reason verdict_reason_find(const char *name);

/* One line per finding, "OUTCOME (REASON): SENTENCE" after `prefix`, remarks as "note (REASON):
 * ..."; without findings one line, "solved". */
void verdict_print(FILE *file, const char *prefix, const verdict *v);

/* For --help: exit status and meaning of the outcomes that a program by itself can have, and
 * the reasons of warnings. */
void verdict_help(FILE *file);

#ifdef __cplusplus
}
#endif

#endif
