/* A trained model as C: what cpinn-export writes, taken apart. */
#ifndef TOOLS_PROGRAMS_EXPORT_H
#define TOOLS_PROGRAMS_EXPORT_H

#include "physics/evaluator.h"
#include "physics/verdict.h"
#include "tools/emit/export_family.h"
#include "tools/train/experiment.h"

enum { EXPORT_NAME_MAX = 40, EXPORT_FORMAT = 1 };

/* How far the C is from the evaluator at the points of the self-test, relative to the largest value
 * of each output, and to that of all its derivatives; NaN: not measured. */
typedef struct export_errors {
    double values[EVALUATOR_COLUMNS_MAX], jacobian[EVALUATOR_COLUMNS_MAX];
} export_errors;

typedef struct export_model {
    const char *run;                /* what was opened */
    char name[EXPORT_NAME_MAX + 1]; /* a C identifier */
    bool single;                    /* float in place of double */
    experiment *e;
    int inputs, outputs;
    evaluator *values, *jacobian; /* outputs; and behind them [outputs][inputs] */
    double lower[DOMAIN_COORDINATES_MAX], upper[DOMAIN_COORDINATES_MAX]; /* of inputs, SI */

    bool is_judged;
    verdict verdict; /* of training */
    double error;    /* of the position against the scene's reference; NaN: unknown */
    double
        estimate; /* of the largest error over the length, or a beam's deflection; NaN: unknown */
    double held_out; /* root of the loss at points never trained on; NaN: unknown */
    uint64_t hash;   /* of the networks */

    size_t points;             /* of the self-test */
    double *at;                /* [points][inputs], SI; as float where single */
    double *expected;          /* [outputs * (1 + inputs)][points], of the evaluator */
    bool *beyond;              /* [points] outside the range: expected is at its end */
    double *scale, *tolerance; /* [outputs * (1 + inputs)] */
    export_errors measured;

    export_family family; /* of a run of the strain form: what is written in place of the rest */
    double *family_numbers;

    size_t workspace, memory; /* numbers, of the functions and with their results; by
                               * export_write_source */
} export_model;

/* Of numbers in the C. */
static inline const char *export_type(const export_model *x)
{
    return x->single ? "float" : "double";
}

/* `columns`: names as evaluator_create takes them, NULL: all; `places`: of families in the strain
 * form. The name is set. AD_BAD_INPUT, AD_BAD_ARGUMENT, AD_NO_MEMORY; free it all the same. */
ad_status export_open(export_model *x, const char *run, const char *columns, const char *places,
                      ad_error *error);
void export_free(export_model *x);

/* What a rod has by itself, of a unit: L of m, EI/L^2 of N; 0: not known. export_model.c. */
double export_natural_scale(const scene *of, const char *unit);

/* Of a family in the strain form; columns by name, NULL: all; at places of the shape, arc lengths
 * in m separated by commas, of which the last is the tip; NULL: 21 at equal distances.
 * export_run.c. */
ad_status export_open_family(export_model *x, const char *columns, const char *places,
                             ad_error *error);

static inline bool export_is_family(const export_model *x)
{
    return x->family.open != NULL;
}

/* Around the functions of a model: model_functions.c and model_selftest.c. */
extern const char *const export_model_functions[], *const export_model_selftest[];

/* The texts of NAME.c, and then of NAME.h and NAME_selftest.c. */
ad_status export_write_source(export_model *x, FILE *file, ad_error *error);
void export_write_header(const export_model *x, FILE *file);
void export_write_selftest(const export_model *x, FILE *file);

/* Compiles the three texts by `cc` and runs the self-test: x->measured. AD_IO: there is no such
 * compiler, or it refuses; AD_BAD_PROGRAM: results differ by more than rounding. */
ad_status export_check(export_model *x, const char *source, const char *header,
                       const char *selftest, ad_error *error);

/* Writes the texts of NAME.c and NAME.h as an FMU, tools/fmu/fmu.h, with outputs at `places`, arc
 * lengths in m separated by commas; NULL: at the end of the rod. Says on stderr when there is no
 * compiler for it. Errors as fmu_write. */
ad_status export_write_fmu(const export_model *x, const char *source, const char *header,
                           const char *places, const char *path, ad_error *error);

#endif
