/* NAME_selftest.c, and running it. */
#include "tools/emit/export_text.h"
#include "tools/programs/export.h"

#include <errno.h>
#include <math.h>
#include <stdlib.h>
#include <string.h>
#include <sys/wait.h>
#include <unistd.h>

enum { NOT_COMPILED = 77, NOT_RUN = 126, NOT_FOUND = 127 }; /* the last two: of the shell */

/* ---- the self-test -------------------------------------------------------------------------- */

static void write_tables(const export_model *x, FILE *file)
{
    size_t inputs = (size_t)x->inputs, columns = (size_t)x->outputs * (1 + inputs);
    fprintf(file, "enum { POINTS = %zu, COLUMNS = %zu };\n\n", x->points, columns);
    fputs("/* Inputs; whether they are out of range. */\n", file);
    export_put_rows(x->single ? "static const float at" : "static const double at", x->points,
                    inputs, x->at, x->single, file);
    fputs("static const int beyond[POINTS] = {", file);
    for (size_t k = 0; k < x->points; k++) {
        fprintf(file, "%s%d", k == 0 ? "" : ", ", x->beyond[k]);
    }
    fputs(
        "};\n\n/* Outputs and then their derivatives by the inputs: their scales, how far rounding "
        "may take\n * them, and what they are. */\n",
        file);
    fputs("static const double scale[COLUMNS] = ", file);
    export_put_list(columns, x->scale, 1, false, file);
    fputs(";\nstatic const double tolerance[COLUMNS] = ", file);
    export_put_list(columns, x->tolerance, 1, false, file);
    fputs(";\nstatic const double expected[POINTS][COLUMNS] = {\n", file);
    for (size_t k = 0; k < x->points; k++) {
        double row[EVALUATOR_COLUMNS_MAX * (1 + DOMAIN_COORDINATES_MAX)];
        for (size_t i = 0; i < columns; i++) {
            row[i] = x->expected[i * x->points + k];
        }
        export_put_list(columns, row, 1, false, file);
        fputs(k + 1 < x->points ? ",\n" : "};\n\n", file);
    }
}

void export_write_selftest(const export_model *x, FILE *file)
{
    export_begin_selftest(x->name, "c99", file);
    write_tables(x, file);
    export_put_lines(x->name, export_type(x), export_model_selftest, file);
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
