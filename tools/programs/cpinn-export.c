/* cpinn-export: a trained network as C or as an FMU; see --help. */
#include "tools/files/file_bytes.h"
#include "tools/programs/cli.h"
#include "tools/programs/export.h"
#include "tools/programs/help.h"

#include <ctype.h>
#include <errno.h>
#include <math.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>

static const char program[] = "cpinn-export";

enum { TEXTS = 3, FMU = TEXTS, FILES };
static const char *const endings[FILES] = {".c", ".h", "_selftest.c", ".fmu"};

typedef struct options {
    const char *run, *c, *fmu, *columns, *places;
    bool single, force;
} options;

typedef struct texts {
    char *text[TEXTS];
    size_t size[TEXTS];
} texts;

/* What is written: OUT, and which files. */
static const char *out_of(const options *o)
{
    return o->fmu ? o->fmu : o->c;
}

static bool writes(const options *o, int file)
{
    return (file == FMU) == (o->fmu != NULL);
}

static void texts_free(texts *t)
{
    for (int i = 0; i < TEXTS; i++) {
        free(t->text[i]);
        t->text[i] = NULL;
    }
}

/* ---- names ---------------------------------------------------------------------------------- */

/* OUT without .c or .fmu: its length, and its last part as the name. */
static ad_status read_name(const options *o, size_t *length, char name[EXPORT_NAME_MAX + 1],
                           ad_error *error)
{
    const char *out = out_of(o), *slash = strrchr(out, '/'), *base = slash ? slash + 1 : out;
    const char *ending = endings[o->fmu ? FMU : 0];
    size_t count = strlen(base), end = strlen(ending);
    count -= count > end && strcmp(base + count - end, ending) == 0 ? end : 0;
    bool ok = count > 0 && count <= EXPORT_NAME_MAX && !isdigit((unsigned char)base[0]);
    for (size_t i = 0; i < count; i++) {
        ok = ok && (base[i] == '_' || isalnum((unsigned char)base[i]));
    }
    if (!ok) {
        return ad_fail(error, AD_BAD_ARGUMENT,
                       "%s %s: functions cannot be called %.*s; allowed: up to %d letters, digits "
                       "and _, the first no digit",
                       o->fmu ? "--fmu" : "--c", out, (int)count, base, EXPORT_NAME_MAX);
    }
    snprintf(name, EXPORT_NAME_MAX + 1, "%.*s", (int)count, base);
    *length = (size_t)(base - out) + count;
    return AD_OK;
}

static char *path_of(const char *out, size_t length, int file, ad_error *error)
{
    size_t size = length + strlen(endings[file]) + 1;
    char *path = malloc(size);
    if (path) {
        snprintf(path, size, "%.*s%s", (int)length, out, endings[file]);
    } else {
        ad_fail(error, AD_NO_MEMORY, "out of memory for the name of a file");
    }
    return path;
}

/* Before anything is computed. */
static ad_status check_paths(const options *o, size_t length, ad_error *error)
{
    ad_status status = AD_OK;
    for (int i = 0; i < FILES && status == AD_OK; i++) {
        if (!writes(o, i)) {
            continue;
        }
        char *path = path_of(out_of(o), length, i, error);
        status = path ? file_bytes_check(path, error) : AD_NO_MEMORY;
        if (status == AD_OK && !o->force && access(path, F_OK) == 0) {
            status = ad_fail(error, AD_IO, "%s: there is such a file already; --force replaces it",
                             file_bytes_shown(path));
        }
        free(path);
    }
    return status;
}

/* ---- files ---------------------------------------------------------------------------------- */

static ad_status write_family(export_model *x, FILE *to, int file, ad_error *error)
{
    if (file == 0) {
        return export_family_write_source(&x->family, to, error);
    }
    if (file == 1) {
        export_family_write_header(&x->family, to);
    } else {
        export_family_write_selftest(&x->family, to);
    }
    return AD_OK;
}

static ad_status write_text(export_model *x, texts *t, int file, ad_error *error)
{
    free(t->text[file]);
    t->text[file] = NULL;
    FILE *to = open_memstream(&t->text[file], &t->size[file]);
    ad_status status = AD_OK;
    if (to && export_is_family(x)) {
        status = write_family(x, to, file, error);
    } else if (to && file == 0) {
        status = export_write_source(x, to, error);
    } else if (to && file == 1) {
        export_write_header(x, to);
    } else if (to) {
        export_write_selftest(x, to);
    }
    bool ok = to && !ferror(to);
    ok = to && fclose(to) == 0 && ok;
    return status != AD_OK || ok ? status
                                 : ad_fail(error, AD_NO_MEMORY, "out of memory for a file of C");
}

static ad_status write_texts(export_model *x, texts *t, ad_error *error)
{
    ad_status status = AD_OK;
    for (int i = 0; i < TEXTS && status == AD_OK; i++) {
        status = write_text(x, t, i, error);
    }
    return status;
}

/* Each file is whole or not there; the header, which the others need, comes last. */
static ad_status put_files(const export_model *x, const options *o, size_t length, const texts *t,
                           ad_error *error)
{
    static const int order[FILES] = {2, 0, 1, FMU};
    ad_status status = AD_OK;
    for (int i = 0; i < FILES && status == AD_OK; i++) {
        int file = order[i];
        if (!writes(o, file)) {
            continue;
        }
        char *path = path_of(out_of(o), length, file, error);
        status = !path         ? AD_NO_MEMORY
                 : file == FMU ? export_write_fmu(x, t->text[0], t->text[1], o->places, path, error)
                               : file_bytes_write(path, t->text[file], t->size[file], error);
        free(path);
    }
    return status;
}

/* Without a compiler the C is written unchecked, and its header says so. */
static ad_status check(export_model *x, texts *t, ad_error *error)
{
    ad_status status = export_check(x, t->text[0], t->text[1], t->text[2], error);
    if (status == AD_IO) {
        cli_warn(program, "the C has not been compiled and checked: %s", error->message);
        status = AD_OK;
    }
    return status == AD_OK ? write_text(x, t, 1, error) : status;
}

/* ---- report --------------------------------------------------------------------------------- */

/* The largest of the columns. */
static double largest(const export_model *x, const double *list, int first)
{
    double most = 0;
    for (int i = first; i < x->outputs; i++) {
        most = fmax(most, list[i]);
    }
    return most;
}

static void report_family(const export_model *x, size_t length, const char *out)
{
    const export_errors *off = &x->measured;
    const bool measured = !isnan(off->values[0]);
    printf("wrote %.*s.c, .h and _selftest.c: %d parameters, %d nodes, shapes at %d places\n",
           (int)length, out, x->family.open->parameter_count, strain_mesh_nodes(&x->family.mesh),
           x->family.places);
    if (measured) {
        printf("checked by cc: a polished curvature to %.1e of its scale, columns of the tip to "
               "%.1e, derivatives to %.1e of their scales\n",
               off->jacobian[0], largest(x, off->values, 1), largest(x, off->jacobian, 1));
    }
    for (int i = 1; i < x->outputs && x->single && measured; i++) {
        printf("  %-10s %.1e  derivatives %.1e\n",
               scene_physics_of(x->family.open)->columns[x->family.which[i - 1]].name,
               off->values[i], off->jacobian[i]);
    }
    if (x->is_judged) {
        verdict_print(stdout, "verdict on training: ", &x->verdict);
    }
}

static void report(const export_model *x, const options *o, size_t length)
{
    if (export_is_family(x)) {
        report_family(x, length, out_of(o));
        return;
    }
    const double value = largest(x, x->measured.values, 0);
    const double jacobian = largest(x, x->measured.jacobian, 0);
    printf("wrote %.*s%s: %d inputs, %d outputs, %zu numbers of memory\n", (int)length, out_of(o),
           o->fmu ? ".fmu" : ".c, .h and _selftest.c", x->inputs, x->outputs, x->memory);
    if (!isnan(x->measured.values[0])) {
        printf("checked by cc: values to %.1e, derivatives to %.1e of their scales\n", value,
               jacobian);
    }
    if (x->single && x->measured.values[0] >= 0) {
        for (int i = 0; i < x->outputs; i++) {
            printf("  %-10s %.1e  derivatives %.1e\n", evaluator_column_name(x->values, i),
                   x->measured.values[i], x->measured.jacobian[i]);
        }
    }
    if (x->single && value > x->error) {
        cli_warn(program, "single precision costs %.1e, more than the error of the network, %.1e",
                 value, x->error);
    }
    if (x->is_judged) {
        verdict_print(stdout, "verdict on training: ", &x->verdict);
    }
}

static ad_status run(export_model *x, const options *o, size_t length, texts *t, ad_error *error)
{
    ad_status status = check_paths(o, length, error);
    if (status == AD_OK) {
        status = export_open(x, o->run, o->columns, o->places, error);
    }
    if (status == AD_OK && o->fmu && export_is_family(x)) {
        status = ad_fail(error, AD_BAD_ARGUMENT,
                         "%s: --fmu is not for families in the strain form; allowed: --c", o->run);
    }
    if (status == AD_OK && o->c && o->places && !export_is_family(x)) {
        status = ad_fail(error, AD_BAD_ARGUMENT,
                         "--places is for --fmu and for families in the strain form alone");
    }
    if (status == AD_OK) {
        status = write_texts(x, t, error);
    }
    if (status == AD_OK) {
        status = check(x, t, error);
    }
    return status == AD_OK ? put_files(x, o, length, t, error) : status;
}

int main(int argc, char **argv)
{
    options o = {.run = NULL};
    export_model x = {.e = NULL};
    texts t = {.text = {NULL}};
    size_t length = 0;
    ad_error error = {AD_OK, ""};
    const cli_option list[] = {{"--c", "OUT", CLI_TEXT, &o.c, 0, 0},
                               {"--fmu", "OUT", CLI_TEXT, &o.fmu, 0, 0},
                               {"--places", "S,S,...", CLI_TEXT, &o.places, 0, 0},
                               {"--columns", "NAMES", CLI_TEXT, &o.columns, 0, 0},
                               {"--single", NULL, CLI_FLAG, &o.single, 0, 0},
                               CLI_FORCE(&o.force)};
    const cli_program about = {program, "DIR_OR_CHECKPOINT", help_export, NULL, NULL};
    int status = cli_parse(&about, list, sizeof list / sizeof *list, argc, argv, &o.run);
    if (status != CLI_RUN) {
        return status;
    }
    if (!o.c == !o.fmu) {
        return cli_fail(program, o.c ? "--c and --fmu are given; allowed: one of the two"
                                     : "nothing would be written; give --c OUT or --fmu OUT");
    }
    if (o.fmu && o.single) {
        return cli_fail(program, "--single is for --c alone; FMUs have double precision");
    }
    status = 0;
    if (read_name(&o, &length, x.name, &error) != AD_OK) {
        return cli_fail_error(program, &error);
    }
    x.single = o.single;
    if (run(&x, &o, length, &t, &error) == AD_OK) {
        report(&x, &o, length);
    } else {
        status = cli_fail_error(program, &error);
    }
    texts_free(&t);
    export_free(&x);
    return status;
}
