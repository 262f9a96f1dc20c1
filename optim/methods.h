/* The table of methods and of their settings. From it follow the keys of a stage of training, their
 * limits, defaults and help, the checks, and what tests try.
 *
 * A method is a row of OPTIM_METHOD_LIST and an optim_kind (internal.h) in a file of its own. A
 * setting that no method has yet is a row of OPTIM_SETTING_LIST. */
#ifndef OPTIM_METHODS_H
#define OPTIM_METHODS_H

#include "optim/optim.h"

#include <math.h>

#ifdef __cplusplus
extern "C" {
#endif

/* X(code, name): the code is of optim_method, the kind is optim_NAME_kind. */
#define OPTIM_METHOD_LIST(X)                                                                       \
    X(OPTIM_ADAM, adam)                                                                            \
    X(OPTIM_LBFGS, lbfgs)                                                                          \
    X(OPTIM_GAUSS_NEWTON, gauss_newton)                                                            \
    X(OPTIM_SSBROYDEN, ssbroyden)                                                                  \
    X(OPTIM_SOAP, soap)

typedef enum optim_method {
#define OPTIM_METHOD_ENUM(code, name) code,
    OPTIM_METHOD_LIST(OPTIM_METHOD_ENUM)
#undef OPTIM_METHOD_ENUM
        OPTIM_METHOD_COUNT
} optim_method;

/* What a method asks of what it minimises. */
typedef enum optim_needs {
    OPTIM_NEEDS_GRADIENTS,    /* which may be of another function in every step, as of batches */
    OPTIM_NEEDS_ONE_FUNCTION, /* its values compare; after a change it begins anew */
    OPTIM_NEEDS_SQUARES       /* an optim_linear_model of a sum of squares */
} optim_needs;

/* Groups of settings; a method reads some of them. */
enum {
    OPTIM_READS_RATE = 1,
    OPTIM_READS_MEANS = 2,
    OPTIM_READS_EPSILON = 4,
    OPTIM_READS_MEMORY = 8,
    OPTIM_READS_LINES = 16,
    OPTIM_READS_TOLERANCES = 32,
    OPTIM_READS_DAMPING = 64,
    OPTIM_READS_MATRICES = 128 /* no keys: matrices, multiply */
};

enum { OPTIM_LOW_OPEN = 1, OPTIM_HIGH_OPEN = 2 }; /* a limit itself is not allowed */

/* Limits: low, high, which are open, in words. */
#define OPTIM_POSITIVE          0, INFINITY, OPTIM_LOW_OPEN, "finite and > 0"
#define OPTIM_NOT_NEGATIVE      0, INFINITY, 0, "finite and >= 0"
#define OPTIM_ABOVE(low)        low, INFINITY, OPTIM_LOW_OPEN, "finite and > " #low
#define OPTIM_WITHIN(low, high) low, high, 0, "in [" #low ", " #high "]"
#define OPTIM_BETWEEN(low, high)                                                                   \
    low, high, OPTIM_LOW_OPEN | OPTIM_HIGH_OPEN, "in (" #low ", " #high ")"
#define OPTIM_FROM_TO(low, high)  low, high, OPTIM_HIGH_OPEN, "in [" #low ", " #high ")"
#define OPTIM_ABOVE_TO(low, high) low, high, OPTIM_LOW_OPEN, "in (" #low ", " #high "]"
#define OPTIM_ONE_OF(count)       0, (count)-1, 0, "one of its names"

/* X(type, name, kind, reads, default, words of it, names, unit, help, limits)
 *
 * kind: NUMBER double, INTEGER int, LONG int64_t, CHOICE an enumeration. reads: the group; words of
 * the default, or NULL, where users of this folder choose it by other things; names of a choice. */
/* clang-format off */
#define OPTIM_SETTING_LIST(X)                                                                      \
    X(double, learning_rate, NUMBER, OPTIM_READS_RATE, 1e-3, NULL, NULL, NULL,                     \
      "Largest step size, of adam and its kind.", OPTIM_POSITIVE)                                  \
    X(optim_schedule_kind, schedule, CHOICE, OPTIM_READS_RATE, OPTIM_SCHEDULE_CONSTANT, NULL,      \
      optim_schedule_names, NULL,                                                                  \
      "How the learning rate falls.", OPTIM_ONE_OF(OPTIM_SCHEDULE_COUNT))                          \
    X(int64_t, warmup_steps, LONG, OPTIM_READS_RATE, 0, NULL, NULL, "steps",                       \
      "Steps over which the learning rate rises first.", OPTIM_WITHIN(0, 1e9))                     \
    X(int64_t, decay_steps, LONG, OPTIM_READS_RATE, 1000, "steps less warmup_steps", NULL, "steps", \
      "cosine: steps over which the learning rate falls. exponential: steps in which it falls by " \
      "decay_factor.", OPTIM_WITHIN(1, 1e9))                                                       \
    X(double, final_fraction, NUMBER, OPTIM_READS_RATE, 0.01, NULL, NULL, NULL,                    \
      "cosine: fraction of the learning rate that is left at the end.", OPTIM_WITHIN(0, 1))        \
    X(double, decay_factor, NUMBER, OPTIM_READS_RATE, 0.9, NULL, NULL, NULL,                       \
      "exponential: factor of the learning rate per decay_steps.", OPTIM_ABOVE_TO(0, 1))           \
    X(double, beta1, NUMBER, OPTIM_READS_MEANS, 0.9, NULL, NULL, NULL,                             \
      "Decay rate of the mean of gradients.", OPTIM_FROM_TO(0, 1))                                 \
    X(double, beta2, NUMBER, OPTIM_READS_MEANS, 0.999, NULL, NULL, NULL,                           \
      "Decay rate of the mean of squared gradients.", OPTIM_FROM_TO(0, 1))                         \
    X(double, epsilon, NUMBER, OPTIM_READS_EPSILON, 1e-8, NULL, NULL, NULL,                        \
      "Keeps the division of Adam finite.", OPTIM_POSITIVE)                                        \
    X(double, clip_norm, NUMBER, OPTIM_READS_RATE, 0, NULL, NULL, NULL,                            \
      "Longest gradient; longer ones are shortened to it. 0: never.", OPTIM_NOT_NEGATIVE)          \
    X(int, memory, INTEGER, OPTIM_READS_MEMORY, 50, NULL, NULL, NULL,                              \
      "Number of pairs that L-BFGS keeps.", OPTIM_WITHIN(1, 1000))                                 \
    X(double, sufficient_decrease, NUMBER, OPTIM_READS_LINES, 1e-4, NULL, NULL, NULL,              \
      "c1 of the strong Wolfe conditions.", OPTIM_BETWEEN(0, 0.5))                                 \
    X(double, curvature, NUMBER, OPTIM_READS_LINES, 0.9, NULL, NULL, NULL,                         \
      "c2 of the strong Wolfe conditions, above c1.", OPTIM_BETWEEN(0, 1))                         \
    X(int, maximum_line_evaluations, INTEGER, OPTIM_READS_LINES, 25, NULL, NULL, NULL,             \
      "Largest number of evaluations in one line search.", OPTIM_WITHIN(2, 1000))                  \
    X(double, maximum_step, NUMBER, OPTIM_READS_LINES, 1e10, NULL, NULL, NULL,                     \
      "Longest step. A loss that still falls there counts as unbounded.", OPTIM_POSITIVE)          \
    X(double, gradient_tolerance, NUMBER, OPTIM_READS_TOLERANCES, 1e-12, NULL, NULL, NULL,         \
      "The stage ends when no component of the gradient is larger.", OPTIM_NOT_NEGATIVE)           \
    X(double, function_tolerance, NUMBER, OPTIM_READS_TOLERANCES, 0, NULL, NULL, NULL,             \
      "The stage ends when a step changes the loss relatively by no more; gauss_newton needs "     \
      "three such steps in a row.", OPTIM_FROM_TO(0, 1))                                           \
    X(double, step_tolerance, NUMBER, OPTIM_READS_TOLERANCES, 0, NULL, NULL, NULL,                 \
      "The stage ends when a step changes the parameters relatively by no more.",                  \
      OPTIM_FROM_TO(0, 1))                                                                         \
    X(double, curvature_threshold, NUMBER, OPTIM_READS_LINES, 1e-12, NULL, NULL, NULL,             \
      "Pairs with less curvature are dropped.", OPTIM_FROM_TO(0, 1))                               \
    X(optim_scaling, scaling, CHOICE, OPTIM_READS_DAMPING, OPTIM_SCALING_IDENTITY,                 \
      "identity; without hidden layers diagonal in motion and for beams", optim_scaling_names, NULL, \
      "What the damping multiplies: the identity, or the diagonal of J^T J.",                      \
      OPTIM_ONE_OF(OPTIM_SCALING_COUNT))                                                           \
    X(double, initial_damping, NUMBER, OPTIM_READS_DAMPING, 1e-3,                                  \
      "0.001; 1e-10 without hidden layers", NULL, NULL,                                            \
      "First damping, in units of the largest diagonal entry of J^T J (identity) or of 1 "         \
      "(diagonal).", OPTIM_POSITIVE)                                                               \
    X(double, maximum_damping, NUMBER, OPTIM_READS_DAMPING, 1e10, NULL, NULL, NULL,                \
      "The stage ends when no step lowers the loss up to this damping; same units.",               \
      OPTIM_POSITIVE)                                                                              \
    X(double, damping_increase, NUMBER, OPTIM_READS_DAMPING, 3, NULL, NULL, NULL,                  \
      "Factor of the damping after a step that did not lower the loss and is rejected.",           \
      OPTIM_ABOVE(1))                                                                              \
    X(double, damping_decrease, NUMBER, OPTIM_READS_DAMPING, 0.03, NULL, NULL, NULL,               \
      "Factor of the damping after a step that lowered the loss as predicted; its root after a "   \
      "smaller decrease.", OPTIM_BETWEEN(0, 1))
/* clang-format on */

/* The method, all settings, and what else it may be told. */
typedef struct optim_settings {
    optim_method method;
#define OPTIM_SETTING_FIELD(type, name, kind, reads, otherwise, words, names, unit, help, ...)     \
    type name;
    OPTIM_SETTING_LIST(OPTIM_SETTING_FIELD)
#undef OPTIM_SETTING_FIELD
    int basis_every; /* SOAP: >= 1, steps between turns of the bases */
    int matrix_count;
    const optim_matrix *matrices; /* in the order of their offsets, apart; copied */
    optim_multiply multiply;      /* NULL: plain loops */
    void *context;                /* of it */
} optim_settings;

/* A row of settings, for loops over all of them. */
typedef struct optim_setting {
    const char *name, *refusal; /* "memory must be in [1, 1000]" */
    enum { OPTIM_NUMBER, OPTIM_INTEGER, OPTIM_LONG, OPTIM_CHOICE } kind;
    unsigned reads, open;
    double low, high;
    size_t offset; /* into optim_settings */
} optim_setting;

extern const optim_setting optim_setting_rows[];
extern const int optim_setting_count;

/* Of OPTIM_METHOD_COUNT: what methods have in common, from which some differ. */
optim_settings optim_settings_defaults(optim_method method);

/* The same with the method's own defaults for all that it does not read. */
optim_settings optim_settings_own(const optim_settings *settings);

/* NULL, or a static text that names the first setting that is not within its limits. */
const char *optim_settings_check(const optim_settings *settings);

/* Whether a method has a default of its own for a number. */
bool optim_setting_is_own(const optim_setting *row, optim_method method);

double optim_setting_value(const optim_setting *row, const optim_settings *settings);

const char *const *optim_method_names(void); /* NULL at the end */

/* Name of a method, never NULL; method of a name, or OPTIM_METHOD_COUNT when there is none. */
const char *optim_method_name(optim_method method);
optim_method optim_method_of(const char *name);

const char *optim_method_about(optim_method method); /* "Levenberg-Marquardt", for help */
optim_needs optim_method_needs(optim_method method); /* of none: gradients */
unsigned optim_method_reads(optim_method method);    /* groups of settings */

/* "adam, soap": those with one of these needs, 1 << optim_needs, and groups; 0: any. */
void optim_method_list(unsigned needs, unsigned reads, char *text, size_t size);

/* What to try, in a few words, when a number is not finite. */
const char *optim_advice(optim_method method);

/* Bytes for `count` parameters, and the most parameters that the method is made for. */
double optim_bytes(const optim_settings *settings, size_t count);
size_t optim_count_max(optim_method method);

/* The rate of settings that pass the check at step = 0, 1, 2, ...; a negative step counts as 0. */
double optim_schedule_rate(const optim_settings *settings, int64_t step);

#ifdef __cplusplus
}
#endif

#endif
