/* NAME_selftest.c, and running it. */
#include "tools/programs/export.h"

#include <errno.h>
#include <math.h>
#include <stdlib.h>
#include <string.h>
#include <sys/wait.h>
#include <unistd.h>

enum { NOT_COMPILED = 77, NOT_RUN = 126, NOT_FOUND = 127 }; /* the last two: of the shell */

/* ---- the self-test -------------------------------------------------------------------------- */

static void put_numbers(const char *head, size_t count, const double *list, size_t stride,
                        FILE *file)
{
    fputs(head, file);
    for (size_t i = 0; i < count; i++) {
        fprintf(file, "%s%.17g", i == 0 ? "" : i % 4 ? ", " : ",\n     ", list[i * stride]);
    }
}

static void write_tables(const export_model *x, FILE *file)
{
    size_t inputs = (size_t)x->inputs, columns = (size_t)x->outputs * (1 + inputs);
    fprintf(file, "enum { POINTS = %zu, COLUMNS = %zu };\n\n", x->points, columns);
    fprintf(file,
            "/* Inputs; whether they are out of range. */\nstatic const %s at[POINTS][%d] = {\n",
            export_type(x), x->inputs);
    for (size_t k = 0; k < x->points; k++) {
        put_numbers("    {", inputs, x->at + k * inputs, 1, file);
        fputs(k + 1 < x->points ? "},\n" : "}};\n", file);
    }
    fputs("static const int beyond[POINTS] = {", file);
    for (size_t k = 0; k < x->points; k++) {
        fprintf(file, "%s%d", k == 0 ? "" : ", ", x->beyond[k]);
    }
    fputs(
        "};\n\n/* Outputs and then their derivatives by the inputs: their scales, how far rounding "
        "may take\n * them, and what they are. */\n",
        file);
    put_numbers("static const double scale[COLUMNS] = {\n     ", columns, x->scale, 1, file);
    put_numbers("};\nstatic const double tolerance[COLUMNS] = {\n     ", columns, x->tolerance, 1,
                file);
    fputs("};\nstatic const double expected[POINTS][COLUMNS] = {\n", file);
    for (size_t k = 0; k < x->points; k++) {
        put_numbers("    {", columns, x->expected + k, x->points, file);
        fputs(k + 1 < x->points ? "},\n" : "}};\n\n", file);
    }
}

/* NAME and TYPE stand for themselves. */
static const char program_text[] =
    "static TYPE memory[NAME_MEMORY], batch[POINTS][NAME_OUTPUTS];\n"
    "static TYPE batch_jacobian[POINTS][NAME_OUTPUTS * NAME_INPUTS];\n"
    "static double worst[COLUMNS];\n"
    "static int failures;\n"
    "\n"
    "static void compare(const char *function, int point, int column, double value)\n"
    "{\n"
    "    const double off = fabs(value - expected[point][column]);\n"
    "    const double size = scale[column] > 0 ? scale[column] : 1;\n"
    "    if (!(off <= tolerance[column]) && failures++ == 0) {\n"
    "        printf(\"%s: column %d at point %d is %.17g, not %.17g\\n\", function, column, point, "
    "value,\n"
    "               expected[point][column]);\n"
    "    }\n"
    "    worst[column] = off / size > worst[column] ? off / size : worst[column];\n"
    "}\n"
    "\n"
    "static void check_status(const char *function, int point, int status, int wanted)\n"
    "{\n"
    "    if (status != wanted && failures++ == 0) {\n"
    "        printf(\"%s: returns %d at point %d, not %d\\n\", function, status, point, wanted);\n"
    "    }\n"
    "}\n"
    "\n"
    "static void check_point(int point)\n"
    "{\n"
    "    TYPE out[NAME_OUTPUTS], jacobian[NAME_OUTPUTS * NAME_INPUTS];\n"
    "    int i;\n"
    "    check_status(\"eval\", point, NAME_eval(at[point], out, memory), beyond[point]);\n"
    "    for (i = 0; i < NAME_OUTPUTS; i++) {\n"
    "        compare(\"eval\", point, i, out[i]);\n"
    "    }\n"
    "    check_status(\"jacobian\", point, NAME_jacobian(at[point], out, jacobian, memory), "
    "beyond[point]);\n"
    "    for (i = 0; i < NAME_OUTPUTS; i++) {\n"
    "        compare(\"jacobian\", point, i, out[i]);\n"
    "    }\n"
    "    for (i = NAME_OUTPUTS; i < COLUMNS; i++) {\n"
    "        compare(\"jacobian\", point, i, jacobian[i - NAME_OUTPUTS]);\n"
    "    }\n"
    "}\n"
    "\n"
    "static void check_batches(void)\n"
    "{\n"
    "    int point, i;\n"
    "    check_status(\"eval_batch\", 0, NAME_eval_batch(POINTS, at[0], batch[0], memory), 1);\n"
    "    for (point = 0; point < POINTS; point++) {\n"
    "        for (i = 0; i < NAME_OUTPUTS; i++) {\n"
    "            compare(\"eval_batch\", point, i, batch[point][i]);\n"
    "        }\n"
    "    }\n"
    "    check_status(\"jacobian_batch\", 0,\n"
    "                 NAME_jacobian_batch(POINTS, at[0], batch[0], batch_jacobian[0], memory), "
    "1);\n"
    "    for (point = 0; point < POINTS; point++) {\n"
    "        for (i = 0; i < COLUMNS; i++) {\n"
    "            compare(\"jacobian_batch\", point, i,\n"
    "                    i < NAME_OUTPUTS ? batch[point][i] : batch_jacobian[point][i - "
    "NAME_OUTPUTS]);\n"
    "        }\n"
    "    }\n"
    "}\n"
    "\n"
    "/* What is not a number is out of range, and the result is one. */\n"
    "static void check_not_a_number(void)\n"
    "{\n"
    "    int input, i;\n"
    "    for (input = 0; input < NAME_INPUTS; input++) {\n"
    "        TYPE in[NAME_INPUTS], out[NAME_OUTPUTS];\n"
    "        for (i = 0; i < NAME_INPUTS; i++) {\n"
    "            in[i] = at[0][i];\n"
    "        }\n"
    "        in[input] = (TYPE)NAN;\n"
    "        check_status(\"not a number\", 0, NAME_eval(in, out, memory), NAME_OUT_OF_RANGE);\n"
    "        for (i = 0; i < NAME_OUTPUTS; i++) {\n"
    "            if (!(fabs((double)out[i]) <= HUGE_VAL) && failures++ == 0) {\n"
    "                printf(\"output %d of an input that is not a number is none either\\n\", i);\n"
    "            }\n"
    "        }\n"
    "    }\n"
    "}\n"
    "\n"
    "int main(void)\n"
    "{\n"
    "    int point, i, k;\n"
    "    for (point = 0; point < POINTS; point++) {\n"
    "        check_point(point);\n"
    "    }\n"
    "    check_batches();\n"
    "    check_not_a_number();\n"
    "    if (failures > 0) {\n"
    "        return 1;\n"
    "    }\n"
    "    printf(\"difference from cpinn, by the scale: output, its derivatives\\n\");\n"
    "    for (i = 0; i < NAME_OUTPUTS; i++) {\n"
    "        double most = 0;\n"
    "        for (k = 0; k < NAME_INPUTS; k++) {\n"
    "            const double off = worst[NAME_OUTPUTS + i * NAME_INPUTS + k];\n"
    "            most = off > most ? off : most;\n"
    "        }\n"
    "        printf(\"%-10s %.1e %.1e\\n\", NAME_output_names[i], worst[i], most);\n"
    "    }\n"
    "    return 0;\n"
    "}\n";

void export_write_selftest(const export_model *x, FILE *file)
{
    fprintf(
        file,
        "/* Compares %s.c with what cpinn has computed, at points over the whole range, its ends "
        "and\n * beyond: exit 1 and a line where they differ by more than rounding.\n"
        " *     cc -std=c99 -O2 -o selftest %s.c %s_selftest.c -lm && ./selftest */\n"
        "#include \"%s.h\"\n\n#include <math.h>\n#include <stdio.h>\n\n",
        x->name, x->name, x->name, x->name);
    write_tables(x, file);
    for (const char *at = program_text; *at;) {
        bool name = strncmp(at, "NAME_", 5) == 0, type = strncmp(at, "TYPE", 4) == 0;
        if (name) {
            fprintf(file, "%s_", x->name);
        } else if (type) {
            fputs(export_type(x), file);
        } else {
            fputc(*at, file);
        }
        at += name ? 5 : type ? 4 : 1;
    }
}

/* ---- compiling it --------------------------------------------------------------------------- */

static ad_status put_file(const char *folder, const char *name, const char *ending,
                          const char *text, ad_error *error)
{
    char path[256];
    snprintf(path, sizeof path, "%s/%s%s", folder, name, ending);
    FILE *file = fopen(path, "w");
    bool ok = file && fputs(text, file) >= 0;
    ok = file && fclose(file) == 0 && ok;
    return ok ? AD_OK : ad_fail(error, AD_IO, "%s: %s", path, strerror(errno));
}

static void remove_files(const char *folder, const char *name)
{
    static const char *const endings[] = {".c", ".h", "_selftest.c", ".run"};
    char path[256];
    for (size_t i = 0; i < sizeof endings / sizeof *endings; i++) {
        snprintf(path, sizeof path, "%s/%s%s", folder, name, endings[i]);
        unlink(path);
    }
    rmdir(folder);
}

/* The lines "NAME VALUE VALUE" of the self-test; the first line that is another is kept. */
static int read_errors(export_model *x, FILE *from, char first[256])
{
    char line[256], name[64];
    double value, jacobian;
    int count = 0;
    first[0] = '\0';
    while (fgets(line, sizeof line, from)) {
        if (sscanf(line, "%63s %lf %lf", name, &value, &jacobian) == 3 && count < x->outputs) {
            x->measured.values[count] = value;
            x->measured.jacobian[count++] = jacobian;
        } else if (!first[0]) {
            line[strcspn(line, "\n")] = '\0';
            memcpy(first, line, sizeof line);
        }
    }
    return count;
}

static ad_status run_selftest(export_model *x, const char *folder, ad_error *error)
{
    char command[512], first[256];
    snprintf(command, sizeof command,
             "cd '%s' && { cc -std=c99 -o %s.run %s.c %s_selftest.c -lm 2>&1 || exit %d; } && "
             "./%s.run",
             folder, x->name, x->name, x->name, NOT_COMPILED, x->name);
    fflush(stdout);
    FILE *from = popen(command, "r");
    if (!from) {
        return ad_fail(error, AD_IO, "the compiler cannot be started: %s", strerror(errno));
    }
    int count = read_errors(x, from, first), status = pclose(from);
    if (status == 0 && count == x->outputs) {
        return AD_OK;
    }
    x->measured.values[0] = NAN;
    int code = WIFEXITED(status) ? WEXITSTATUS(status) : 1;
    bool ran = code != NOT_COMPILED && code != NOT_RUN && code != NOT_FOUND;
    return ad_fail(error, ran ? AD_BAD_PROGRAM : AD_IO, "%s%s", ran ? "the self-test fails: " : "",
                   *first ? first : "it says nothing");
}

ad_status export_check(export_model *x, const char *source, const char *header,
                       const char *selftest, ad_error *error)
{
    char folder[] = "/tmp/cpinn_export_XXXXXX";
    if (!mkdtemp(folder)) {
        return ad_fail(error, AD_IO, "%s: %s", folder, strerror(errno));
    }
    ad_status status = put_file(folder, x->name, ".c", source, error);
    if (status == AD_OK) {
        status = put_file(folder, x->name, ".h", header, error);
    }
    if (status == AD_OK) {
        status = put_file(folder, x->name, "_selftest.c", selftest, error);
    }
    if (status == AD_OK) {
        status = run_selftest(x, folder, error);
    }
    remove_files(folder, x->name);
    return status;
}
