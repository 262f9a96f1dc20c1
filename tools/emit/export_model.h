/* A trained model as C or as an FMU. */
#ifndef TOOLS_EMIT_EXPORT_MODEL_H
#define TOOLS_EMIT_EXPORT_MODEL_H

#include "physics/learn/evaluator.h"
#include "physics/scene/verdict.h"
#include "tools/emit/export_compile.h"
#include "tools/emit/export_family.h"
#include "tools/emit/fmu.h"
#include "tools/train/experiment.h"

enum { EXPORT_FORMAT = 1 };

/* How far the C is from the evaluator at the points of the self-test, relative to the largest value
 * of each output, and to that of all its derivatives; NaN: not measured. */
typedef struct export_errors {
    double values[EVALUATOR_COLUMNS_MAX], jacobian[EVALUATOR_COLUMNS_MAX];
} export_errors;

typedef struct export_model {
    const char *run, *name; /* what was opened; a C identifier */
    bool single;            /* float in place of double */
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
    double *at;                /* [points][inputs], SI; as float where single; has the next, too */
    double *expected;          /* [outputs * (1 + inputs)][points], of the evaluator */
    int *beyond;               /* [points] outside the range: expected is at its end */
    double *scale, *tolerance; /* [outputs * (1 + inputs)] */
    export_errors measured;

    export_family family; /* of a run of the strain form: what is written in place of the rest */
    double *family_numbers;

    size_t workspace, memory; /* numbers, of the functions and with their results; by the text of
                               * the source */
} export_model;

/* Of a run whose e, name and single are set, columns as evaluator_create takes them, NULL: all; not
 * for families in the strain form. AD_BAD_INPUT, AD_BAD_ARGUMENT, AD_NO_MEMORY; free it all the
 * same. */
ad_status export_model_prepare(export_model *model, const char *columns, ad_error *error);
void export_model_free(export_model *model);

/* The largest of a list without negative numbers; NaN where one is. */
double export_largest(int count, const double *list);

/* What a rod has by itself, of a unit: L of m, EI/L^2 of N; 0: not known. */
double export_natural_scale(const scene *of, const char *unit);

/* Of a family in the strain form, whose x->family has the columns. At places of the shape s
 * [places], of the length, the last of which is the tip; NULL: 21 at equal distances. */
enum { EXPORT_PLACES_MAX = 200 };
ad_status export_members_prepare(export_model *model, int places, const double *s, ad_error *error);

static inline bool export_is_family(const export_model *model)
{
    return model->e->targets != NULL;
}

/* Around the functions of a model: model_functions.c and model_selftest.c. */
extern const char *const export_model_functions[], *const export_model_selftest[];

/* An export_writer of the texts of an export_model: NAME.c, and then NAME.h and NAME_selftest.c. */
export_writer export_model_write;

/* Compiles the texts by `cc` and runs the self-test: model->measured. Errors as export_compile;
 * AD_BAD_PROGRAM: results differ by more than rounding. */
ad_status export_model_check(export_model *model, const export_texts texts, ad_error *error);

/* Writes the texts as an FMU, fmu.h, with outputs at places [count], m. Errors as fmu_write. */
ad_status export_write_fmu(const export_model *model, const export_texts texts, int count,
                           const double *places, const char *path, bool *compiled,
                           char note[FMU_NOTE], ad_error *error);

#endif
