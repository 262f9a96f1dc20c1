/* NAME.h and NAME.c: the functions of the evaluators and what surrounds them. */
#include "tools/emit/export_model.h"
#include "tools/emit/export_text.h"

#include <inttypes.h>
#include <math.h>
#include <stdlib.h>
#include <string.h>

static const domain *domain_of(const export_model *model)
{
    return &model->e->model->domain;
}

static const char *type_of(const export_model *model)
{
    return model->single ? "float" : "double";
}

/* ---- the header ----------------------------------------------------------------------------- */

double export_largest(int count, const double *list)
{
    double result = 0;
    for (int i = 0; i < count; i++) {
        result = isnan(list[i]) || list[i] > result ? list[i] : result;
    }
    return result;
}

static void write_trust(const export_model *model, FILE *file)
{
    fputs(" * Can it be trusted? The verdict on training:\n", file);
    for (int i = 0; i < model->verdict.count; i++) {
        const verdict_finding *f = &model->verdict.findings[i];
        fprintf(file, " *   %s (%s): ", verdict_outcome_name(verdict_reason_outcome(f->reason)),
                verdict_reason_name(f->reason));
        export_put_comment(f->text, file);
        fputc('\n', file);
    }
    if (!model->is_judged || model->verdict.count == 0) {
        fprintf(file, " *   %s\n",
                model->is_judged ? "solved: nothing speaks against it"
                                 : "none: it was not finished");
    }
    if (isnan(model->estimate)) {
        fputs(" * The error of its position is not known.\n", file);
    } else {
        fprintf(file, " * Estimated error of the position, the largest: %.1e of the %s.\n",
                model->estimate, scene_is_beam(model->e->scene) ? "deflection" : "length");
    }
    if (!isnan(model->error)) {
        fprintf(file, " * Relative error of the position against the scene's reference: %.1e.\n",
                model->error);
    }
    if (isnan(model->measured.values[0])) {
        fputs(" * How far this C is from cpinn-eval has not been measured.\n", file);
    } else {
        fprintf(file,
                " * This C is from cpinn's own evaluation in double precision by at most %.1e of "
                "the scale of\n * an output, its Jacobian by %.1e, at the points of %s_selftest.c, "
                "compiled by cc.\n",
                export_largest(model->outputs, model->measured.values),
                export_largest(model->outputs, model->measured.jacobian), model->name);
    }
}

/* For a macro. */
static double known(double value)
{
    return isnan(value) ? -1 : value;
}

static void write_head(const export_model *model, FILE *file)
{
    const char *name = model->name;
    fprintf(file, "/* %s: the network of the scene \"", name);
    export_put_comment(model->e->settings->name, file);
    fputs("\", from ", file);
    export_put_comment(model->run, file);
    fprintf(file, ", as C99; written by cpinn " CPINN_VERSION ".\n *\n");
    write_trust(model, file);
    fprintf(file,
            " *\n * Numbers are of type %s, in SI units. The functions work in the caller's memory "
            "alone,\n * %s_MEMORY numbers, and keep nothing: several may run at once, each with "
            "memory of its own.\n * They return 0, or %s_OUT_OF_RANGE where an input is beyond its "
            "range by more than\n * rounding, or not a number: the result is then that at the "
            "nearer end of the range (of what\n * is not a number: at its lower end), and so is "
            "never the result of an extrapolation. */\n",
            type_of(model), name, name);
}

static void write_inputs(const export_model *model, FILE *file)
{
    const domain *d = domain_of(model);
    fputs("/* inputs: index, unit, range */\nenum {\n", file);
    for (int i = 0; i < model->inputs; i++) {
        export_put_index(model->name, "IN_", d->coordinates[i].name, i, model->inputs, file);
        fprintf(file, " /* %s%s%.9g to %.9g */\n", d->coordinates[i].unit,
                *d->coordinates[i].unit ? ", " : "", model->lower[i], model->upper[i]);
    }
    fputs("};\n\n", file);
}

static void write_outputs(const export_model *model, FILE *file)
{
    fputs("/* outputs: index, unit, scale: the largest of that unit, or that of the rod (EI/L^2 of "
          "a force) */\nenum {\n",
          file);
    for (int i = 0; i < model->outputs; i++) {
        const char *unit = evaluator_column_unit(model->values, i);
        export_put_index(model->name, "", evaluator_column_name(model->values, i), i,
                         model->outputs, file);
        fprintf(file, " /* %s, %.3g", *unit ? unit : "1", model->scale[i]);
        if (model->single && !isnan(model->measured.values[i])) {
            fprintf(file, "; to %.1e of it, its derivatives to %.1e", model->measured.values[i],
                    model->measured.jacobian[i]);
        }
        fputs(" */\n", file);
    }
    fputs("};\n\n", file);
}

static void write_declarations(const export_model *model, FILE *file)
{
    const char *n = model->name, *t = type_of(model);
    fprintf(
        file,
        "extern const double %s_lower[%s_INPUTS], %s_upper[%s_INPUTS];\n"
        "extern const char *const %s_input_names[%s_INPUTS], *const %s_input_units[%s_INPUTS];\n"
        "extern const char *const %s_output_names[%s_OUTPUTS], "
        "*const %s_output_units[%s_OUTPUTS];\n\n",
        n, n, n, n, n, n, n, n, n, n, n, n);
    fprintf(file,
            "/* out [OUTPUTS] from in [INPUTS] */\n"
            "int %s_eval(const %s *in, %s *out, %s *memory);\n\n"
            "/* The same, and the derivatives of the outputs by the inputs: jacobian "
            "[OUTPUTS][INPUTS] */\n"
            "int %s_jacobian(const %s *in, %s *out, %s *jacobian, %s *memory);\n\n",
            n, t, t, t, n, t, t, t, t);
    fprintf(file,
            "/* The same of n points, one after the other: in [n][INPUTS], out [n][OUTPUTS], "
            "jacobian\n * [n][OUTPUTS][INPUTS]; not 0 where one of them is out of range. */\n"
            "int %s_eval_batch(size_t n, const %s *in, %s *out, %s *memory);\n"
            "int %s_jacobian_batch(size_t n, const %s *in, %s *out, %s *jacobian, %s *memory);\n\n",
            n, t, t, t, n, t, t, t, t);
}

static void write_header(const export_model *model, FILE *file)
{
    const char *n = model->name;
    verdict_outcome outcome = verdict_outcome_of(&model->verdict);
    write_head(model, file);
    export_begin_header(n, file);
    fprintf(file,
            "/* Of the format of this file, and a hash of the networks. */\n"
            "#define %s_VERSION \"%d %016" PRIx64 "\"\n\n",
            n, EXPORT_FORMAT, model->hash);
    fprintf(file, "#define %s_INPUTS       %d\n#define %s_OUTPUTS      %d\n", n, model->inputs, n,
            model->outputs);
    fprintf(file, "#define %s_MEMORY       %zu\n#define %s_OUT_OF_RANGE 1\n\n", n, model->memory,
            n);
    fprintf(
        file,
        "/* 1: nothing speaks against the result of training, see above. Estimated error of the "
        "position, the\n * largest over the length (of a beam over its deflection), relative "
        "error of the position against\n * the scene's reference, and root mean square of the "
        "residuals, weighted as in training and\n * dimensionless, at points never trained on; "
        "-1: not known. */\n"
        "#define %s_TRUSTED  %d\n#define %s_ESTIMATE %.2e\n#define %s_ERROR    %.2e\n"
        "#define %s_RESIDUAL %.2e\n\n",
        n, model->is_judged && outcome == VERDICT_SOLVED, n, known(model->estimate), n,
        known(model->error), n, known(model->held_out));
    write_inputs(model, file);
    write_outputs(model, file);
    write_declarations(model, file);
    export_end_header(file);
}

/* ---- the source ----------------------------------------------------------------------------- */

static void write_constants(const export_model *model, FILE *file)
{
    const domain *d = domain_of(model);
    const size_t inputs = (size_t)model->inputs, outputs = (size_t)model->outputs;
    const char *in[2][DOMAIN_COORDINATES_MAX], *out[2][EVALUATOR_COLUMNS_MAX];
    double scale[DOMAIN_COORDINATES_MAX];
    for (int i = 0; i < model->inputs; i++) {
        in[0][i] = d->coordinates[i].name;
        in[1][i] = d->coordinates[i].unit;
        scale[i] = d->coordinates[i].scale;
    }
    for (int i = 0; i < model->outputs; i++) {
        out[0][i] = evaluator_column_name(model->values, i);
        out[1][i] = evaluator_column_unit(model->values, i);
    }
    export_put_array(file, inputs, model->lower, "const double %s_lower[%s_INPUTS]", model->name,
                     model->name);
    export_put_array(file, inputs, model->upper, "const double %s_upper[%s_INPUTS]", model->name,
                     model->name);
    export_put_names(model->name, "input_names", inputs, in[0], file);
    export_put_names(model->name, "input_units", inputs, in[1], file);
    export_put_names(model->name, "output_names", outputs, out[0], file);
    export_put_names(model->name, "output_units", outputs, out[1], file);
    export_put_array(file, inputs, scale, "\nstatic const double coordinate_scale[]");
}

/* An instant between two windows belongs to the one that it ends. */
static void write_window(const export_model *model, FILE *file)
{
    const domain *d = domain_of(model);
    int windows = model->e->window + 1;
    double begin[SCENE_WINDOWS_MAX];
    fprintf(file,
            "\n/* The window of time of an instant; one between two belongs to the one that it "
            "ends. */\nstatic int window_at(%s t)\n{\n",
            type_of(model));
    for (int i = 0; i < windows; i++) {
        begin[i] = domain_window_time(d, i);
    }
    export_put_array(file, (size_t)windows, begin, "    static const double begin[]");
    fprintf(file,
            "    int low = 0, high = %d;\n    while (low < high) {\n"
            "        const int middle = (low + high + 1) / 2;\n"
            "        if (t > begin[middle]) {\n            low = middle;\n        } else {\n"
            "            high = middle - 1;\n        }\n    }\n    return low;\n}\n",
            windows - 1);
}

/* The functions of the windows as one: "static void values_at(x, to, memory)". */
static void write_choice(const export_model *model, const char *kind, FILE *file)
{
    const char *t = type_of(model);
    const int windows = model->e->window + 1;
    fprintf(file, "\nstatic void %s_at(const %s *x, %s *to, %s *memory)\n{\n", kind, t, t, t);
    if (windows == 1) {
        fprintf(file, "    %s_first(x, to, memory);\n}\n", kind);
        return;
    }
    fprintf(file,
            "    const int window = window_at(x[%d]);\n    if (window == 0) {\n"
            "        %s_first(x, to, memory);\n    } else {\n"
            "        %s_later(%sx, to, memory);\n    }\n}\n",
            domain_of(model)->time, kind, kind, windows > 2 ? "window - 1, " : "");
}

static ad_status write_source(export_model *model, FILE *file, ad_error *error)
{
    static const char *const names[] = {"values", "jacobian"};
    export_begin_source(model->name, file);
    ad_status status = evaluator_write_c(2, (evaluator *const[]){model->values, model->jacobian},
                                         names, model->single, file, &model->workspace, error);
    model->memory = model->workspace + (size_t)(model->outputs * (1 + model->inputs));
    if (status == AD_OK) {
        write_constants(model, file);
        if (model->e->window > 0) {
            write_window(model, file);
        }
        write_choice(model, names[0], file);
        write_choice(model, names[1], file);
        fprintf(file, "\nenum { JACOBIAN_AT = %zu }; /* in memory */\n\n", model->workspace);
        export_put_lines(model->name, model->single ? EXPORT_FLOAT : EXPORT_DOUBLE,
                         export_model_functions, file);
    }
    return status;
}

/* ---- the self-test -------------------------------------------------------------------------- */

static void write_tables(const export_model *model, FILE *file)
{
    size_t inputs = (size_t)model->inputs, columns = (size_t)model->outputs * (1 + inputs);
    fprintf(file, "enum { POINTS = %zu, COLUMNS = %zu };\n\n", model->points, columns);
    fputs("/* Inputs; whether they are out of range. */\n", file);
    export_put_rows(model->single ? "static const float at" : "static const double at",
                    model->points, inputs, model->at, model->single, file);
    export_put_integers(file, model->points, model->beyond, "static const int beyond[POINTS]");
    fputs("\n/* Outputs and then their derivatives by the inputs: their scales, how far rounding "
          "may take\n * them, and what they are. */\n",
          file);
    export_put_array(file, columns, model->scale, "static const double scale[COLUMNS]");
    export_put_array(file, columns, model->tolerance, "static const double tolerance[COLUMNS]");
    fputs("static const double expected[POINTS][COLUMNS] = {\n", file);
    for (size_t k = 0; k < model->points; k++) {
        double row[EVALUATOR_COLUMNS_MAX * (1 + DOMAIN_COORDINATES_MAX)];
        for (size_t i = 0; i < columns; i++) {
            row[i] = model->expected[i * model->points + k];
        }
        export_put_list(columns, row, 1, false, file);
        fputs(k + 1 < model->points ? ",\n" : "};\n\n", file);
    }
}

static void write_selftest(const export_model *model, FILE *file)
{
    export_begin_selftest(model->name, "c99", file);
    write_tables(model, file);
    export_put_lines(model->name, model->single ? EXPORT_FLOAT : EXPORT_DOUBLE,
                     export_model_selftest, file);
}

ad_status export_model_write(void *of, int which, FILE *file, ad_error *error)
{
    export_model *model = of;
    if (export_is_family(model)) {
        return export_family_write(&model->family, which, file, error);
    }
    if (which == EXPORT_SOURCE) {
        return write_source(model, file, error);
    }
    (which == EXPORT_HEADER ? write_header : write_selftest)(model, file);
    return AD_OK;
}

/* The lines "NAME VALUE VALUE" of the self-test. */
ad_status export_model_check(export_model *model, const export_texts texts, ad_error *error)
{
    char *said = NULL, *rest = NULL, name[64];
    int count = 0;
    ad_status status = export_texts_check(texts, model->name, "c99", &said, error);
    for (char *line = said ? strtok_r(said, "\n", &rest) : NULL; line && count < model->outputs;
         line = strtok_r(NULL, "\n", &rest)) {
        double value, jacobian;
        if (sscanf(line, "%63s %lf %lf", name, &value, &jacobian) == 3) {
            model->measured.values[count] = value;
            model->measured.jacobian[count++] = jacobian;
        }
    }
    if (status == AD_OK && count < model->outputs) {
        model->measured.values[0] = NAN;
        status = ad_fail(error, AD_BAD_PROGRAM, "the self-test of the C says nothing");
    }
    free(said);
    return status;
}
